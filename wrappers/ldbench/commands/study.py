"""Studies of the exercises, some minutes each.

contact-law runs all exercises with another contact law and with a coarse step: how much of the spread between codes
is contact law, how much is time step? Results: ldbench_study.pdf and ldbench_study.csv (units stand in the names of
its columns).
derailment runs exercise 3 over mass and gauge and exercise 5 over mass and flange angle (needs ldbench[ensemble]):
peak flange force and derailment force. Result: derailment_demo.pdf.

examples:
  python -m ldbench study contact-law
  python -m ldbench study derailment -o trial
"""
from __future__ import annotations

import argparse

from .options import add_folder, add_jobs

STUDIES = "contact-law", "derailment"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("study", choices=STUDIES, help="which study")
    add_folder(parser, "where the results go")
    add_jobs(parser)
    parser.add_argument("--scheduler", metavar="ADDRESS", help="derailment: run on the workers of this Dask scheduler")


def main(args: argparse.Namespace) -> int:
    if args.study == "derailment":
        from ..report.derailment_demo import derailment_demo

        print(derailment_demo(args.output/"derailment_demo.pdf", args.scheduler, args.jobs))
        return 0
    from ..report.jobs import shipped_inputs
    from ..report.study import make_study

    print("\n".join(str(file) for file in make_study(shipped_inputs(), args.output, args.jobs)))
    return 0
