"""The study of contact laws, some minutes.

contact-law runs all exercises with another contact law and with a coarse step: how much of the spread between codes
is contact law, how much is time step? Results: ldbench_study.pdf and ldbench_study.csv (units stand in the names of
its columns).

examples:
  python -m ldbench study contact-law
"""
from __future__ import annotations

import argparse

from .options import add_folder, add_jobs

STUDIES = ("contact-law",)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", choices=STUDIES, help="which study")
    add_folder(parser, "where the results go")
    add_jobs(parser)


def main(args: argparse.Namespace) -> int:
    from ..report.jobs import shipped_inputs
    from ..report.study import make_study

    print("\n".join(str(file) for file in make_study(shipped_inputs(), args.output, args.jobs)))
    return 0
