"""List the variables of a namelist: group, name, default, unit, range and meaning.

examples:
  python -m ldbench variables
  python -m ldbench variables integrator vY
"""
from __future__ import annotations

import argparse

from ..case import find_variable, variables
from .options import naming


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="groups or variables (all)")


def main(args: argparse.Namespace) -> int:
    groups = {variable.group for variable in variables()}
    with naming():
        chosen = {k for name in (given.lstrip("&").lower() for given in args.names) for k, variable in enumerate(variables())
                  if (variable.group == name if name in groups else k == find_variable(name))}
    group = ""
    for k, variable in enumerate(variables()):
        if args.names and k not in chosen:
            continue
        if variable.group != group:
            group = variable.group
            print(f"&{group}")
        print(f"  {variable.name} = {variable.default.strip()}   {variable.range}\n      {variable.meaning}")
    return 0
