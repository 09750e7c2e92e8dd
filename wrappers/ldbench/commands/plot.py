"""Plot column files: every quantity against time, one PDF with bookmarks, or a picture .svg or .png with the pages one below
the other. The columns of another code's file are named by --map, or guessed, as for `compare`.

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
from ..plots.document import check_plots, make_plots
from .options import add_jobs, add_map, add_output, add_simulation, read_files


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column files")
    add_output(parser, "the document .pdf, or the picture .svg or .png", default="ldbench_plots.pdf")
    parser.add_argument("--geometry", action="append", type=Path, default=[], metavar="FILE",
                        help="a file of geometry functions (`ldbench table -o`), as often as given")
    parser.add_argument("--extras", action="store_true",
                        help="also draw cross-sections of impacts, phase portraits, spectra, L/V, and runs side by side")
    add_map(parser)
    add_simulation(parser)
    add_jobs(parser, "processes")


def main(args: argparse.Namespace) -> int:
    check_plots(args.output, args.files, args.geometry)
    runs = read_files(args.files, args.map, args.simulation)
    with tqdm(total=len(args.files)*(1 + args.extras), desc="plots", disable=None) as bar:
        pages = make_plots(runs, args.output, args.geometry, args.jobs, bar.update, args.extras)
    print(f"{args.output}: {counted(pages, 'page')}")
    return 0
