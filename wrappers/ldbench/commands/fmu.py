"""Write a case as a Functional Mock-up Unit (FMI 2.0) for other simulators: the wheelset, whose states another program integrates
(model exchange) or which integrates itself (co-simulation), or its contacts alone, which give the forces in a pose that comes from
outside. Profiles and contact tables are inside.

examples:
  python -m ldbench fmu inputs/ex1_aw.nml -o wheelset.fmu
  python -m ldbench fmu inputs/ex1_aw.nml --contact -o contact.fmu
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.files import check_written
from ..case import Case
from ..fmu import write_fmu
from .options import add_output, add_set, settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", metavar="NAMELIST", help="namelist file")
    add_set(parser)
    parser.add_argument("--contact", action="store_true", help="the contacts alone: pose in, forces out")
    add_output(parser, "the FMU", default="wheelset.fmu")


def main(args: argparse.Namespace) -> int:
    case = Case.from_namelist(args.namelist).replace(settings(args.set))
    check_written([Path(args.output)], map(Path, (args.namelist, *case.files().values())))
    write_fmu(case, args.output, args.contact)
    print(f"FMU: {args.output}")
    return 0
