"""Say how far the answers of a case are to be trusted, and what decides them.

The case runs, and variations of it, one cause at a time: twins, whose starts differ by less than anybody measures; the accuracy
of the contact table; the influence of half-spaces' places on each other; the bodies' own elasticity; the smoothing of measured
profiles; every input that is not zero, raised by 1 % (gauge, back_to_back and gauge_depth by 0.1 mm, as they are known better). For
each answer it prints the value, the median and the range that the program leaves open, the range with inputs, and the causes in the
order of their size. Contact tables and bodies are kept in the case's table folder: a second call takes seconds.

examples:
  python -m ldbench trust inputs/ex2_aw.nml
  python -m ldbench trust inputs/ex2_aw.nml --laws --all
  python -m ldbench trust inputs/ex1_aw.nml --json outputs/trust.json --picture outputs/trust.png
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.files import check_written
from ..case import Case
from ..plots.sheets import check_sheets, save_sheets
from ..trust import trust
from .options import add_jobs, add_set, settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", metavar="NAMELIST", help="namelist file")
    add_set(parser)
    parser.add_argument("--laws", action="store_true", help="vary the contact law, too")
    parser.add_argument("--all", action="store_true", help="all answers, not the short list alone")
    parser.add_argument("--json", metavar="FILE", help="write all answers as JSON, SI units; - prints them instead of text")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw the causes as bars, .pdf, .svg or .png")
    add_jobs(parser)


def main(args: argparse.Namespace) -> int:
    target = Path(args.json) if args.json not in (None, "-") else None
    if args.picture:
        check_sheets(args.picture)
    written = [file for file in (target, args.picture) if file]
    check_written(written, [Path(args.namelist)])
    found = trust(Case.from_namelist(args.namelist).replace(settings(args.set)), laws=args.laws, jobs=args.jobs, progress=True)
    if target:
        found.json(target)
    if args.picture:
        save_sheets(found.plot(args.all), args.picture)
    if args.json == "-":
        print(found.json())
        return 0
    print(*found.lines(args.all), *written, sep="\n")
    return 0
