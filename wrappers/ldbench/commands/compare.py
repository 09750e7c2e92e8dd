"""Compare column files, of ldbench with other models or steps, or of other codes.

The first file is the reference. The document has the files, events and peaks, a table of impacts (start, duration,
peak, impulse, contact angle), the forces of each impact laid on each other, and all quantities that the files share with
their differences from the reference. Differences are taken at the rows of the reference, up to the end of the shortest
file; angle, position and radius of a contact while it is closed in both files. A CSV file beside the document has all tables,
in SI units. The columns of another code's file are named by --map, or guessed, as `check` does it, for a simulation of the
benchmark.

examples:
  python -m ldbench compare outputs/ex2_aw.txt other_code.csv --map other_code.toml
  python -m ldbench compare a.txt b.txt c.txt --align first-flange -o three.pdf
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.errors import Usage
from ..report.compare import make_comparison
from ..viewer.page import distinct
from .options import add_map, add_output, add_simulation, read_files


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column files; the first is the reference")
    add_output(parser, "the document .pdf, or the picture .svg or .png; the tables go beside it as .csv", default="comparison.pdf")
    parser.add_argument("--align", choices=("time", "first-flange"), default="time",
                        help="lay equal times, or the first flange contacts, on each other (%(default)s)")
    add_map(parser)
    add_simulation(parser)


def main(args: argparse.Namespace) -> int:
    if len(args.files) < 2:
        raise Usage(expected="at least two files, of which the first is the reference", found=len(args.files))
    runs = distinct(read_files(args.files, args.map, args.simulation))
    print("\n".join(str(file) for file in make_comparison(runs, args.output, args.align)))
    return 0
