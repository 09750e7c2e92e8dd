"""Plot column files: every quantity against time, one PDF with bookmarks.

examples:
  python -m ldbench plot outputs/ex1_aw.txt -o ex1_aw.pdf
  python -m ldbench plot outputs/ex*.txt --geometry outputs/geometry_aw.txt
  python -m ldbench plot other_code.csv --map other_code.toml -o other_code.pdf
"""
from __future__ import annotations

import argparse
from pathlib import Path

from tqdm import tqdm

from .._core.wording import counted
from ..plots.document import make_plots
from .options import add_jobs, add_map, add_output, check_names


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column files")
    add_output(parser, "the PDF", default="ldbench_plots.pdf")
    parser.add_argument("--geometry", action="append", type=Path, default=[], metavar="FILE",
                        help="a file of geometry functions (`ldbench table -o`), as often as given")
    add_map(parser)
    add_jobs(parser, "processes")


def main(args: argparse.Namespace) -> int:
    check_names(args.files, args.map)
    with tqdm(total=len(args.files), desc="plots", disable=None) as bar:
        pages = make_plots(args.files, args.output, args.geometry, args.jobs, bar.update, args.map)
    print(f"{args.output}: {counted(pages, 'page')}")
    return 0
