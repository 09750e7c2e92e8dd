"""Make the submission: ten column files, the PDF of plots, the abstract, summary.csv and a page of all results.

The files are ex1_aw.txt to ex5_sw.txt, ldbench_plots.pdf, ldbench_extras.pdf, ldbench_abstract.pdf, summary.csv and
ldbench_results.html. With submission.toml beside them, `submit` puts them together.

A case is run again only when its namelist, its profiles or the program have changed.

examples:
  python -m ldbench report
  python -m ldbench report -o trial -j 4
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.kept import inside
from ..report.jobs import shipped_inputs
from ..report.submission import make_report
from .options import add_folder, add_jobs


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_folder(parser, "where everything goes")
    parser.add_argument("--inputs", type=Path, metavar="DIR",
                        help="namelists exN_PAIR.nml (inputs in this folder, or those shipped)")
    add_jobs(parser)
    parser.add_argument("--force", action="store_true", help="make everything again")


def main(args: argparse.Namespace) -> int:
    made = make_report(args.inputs or shipped_inputs(), args.output, args.jobs, args.force)
    for file in made:
        print(f"{inside(file, Path())}  {file.stat().st_size/1e6:.2f} MB")
    return 0
