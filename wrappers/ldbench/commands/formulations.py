"""Compare elastic contact with constraint equations, in all exercises.

Elastic contact, both wheels held on their rails (bilateral) and rigid contacts that only push (unilateral, restitution 1,
0.5 and 0): which results depend on the choice? Results: ldbench_formulations.pdf and ldbench_formulations.csv.

examples:
  python -m ldbench formulations
  python -m ldbench formulations -o trial -j 4
"""
from __future__ import annotations

import argparse

from ..report.formulations import make_comparison
from ..report.jobs import shipped_inputs
from .options import add_folder, add_jobs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_folder(parser, "where the results go")
    add_jobs(parser)


def main(args: argparse.Namespace) -> int:
    print("\n".join(str(file) for file in make_comparison(shipped_inputs(), args.output, args.jobs)))
    return 0
