"""Plot column files: every quantity against time, one PDF with bookmarks.

examples:
  python -m ldbench plot outputs/ex1_aw.txt -o ex1_aw.pdf
  python -m ldbench plot outputs/ex*.txt --geometry outputs/geometry_aw.txt
"""
from __future__ import annotations

import argparse
from pathlib import Path

from tqdm import tqdm

from . import plots
from ._core import side_by_side


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column file of ldbench")
    parser.add_argument("-o", "--output", type=Path, default=Path("ldbench_plots.pdf"), help="PDF (%(default)s)")
    parser.add_argument("--geometry", nargs="+", type=Path, default=[], metavar="FILE",
                        help="geometry files (&output geometry_file)")
    parser.add_argument("--jobs", type=side_by_side, help="processes (all cores)")


def main(args: argparse.Namespace) -> int:
    with tqdm(total=len(args.files) + len(args.geometry), desc="plots", disable=None) as bar:
        pages = plots.make_plots(args.files, args.output, args.geometry, args.jobs, bar.update)
    print(f"{args.output}: {pages} pages")
    return 0
