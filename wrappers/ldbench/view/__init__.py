"""Show runs as a page in the browser, or as a film.

The page is one HTML file with everything in it: wheels on rails with contact points and forces, charts of any
columns, the values at the cursor. Files beside the first one are drawn over it; of another code's, --columns says
how it names our columns, as for `compare`.

examples:
  python -m ldbench view outputs/ex2_aw.txt
  python -m ldbench view outputs/ex2_aw.txt other_code.csv --columns other_code.toml -o ex2.html
  python -m ldbench view outputs/ex2_aw.txt --film ex2.mp4 --from 0.015 --to 0.03 --speed 1e-3
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from .._core import Error, check_ending, check_written

if TYPE_CHECKING:       # what draws and reads is imported where it is needed: it takes longer than a short run
    from ..case import Case
    from ..record import Record
    from ..run import Run
    from .page import Page


def view(runs: Run | str | PathLike[str] | Sequence[Run | str | PathLike[str]], title: str = "",
         case: Case | None = None) -> Page:
    """Runs, or column files, as a page: `ldbench.view([run, "other.txt"]).write("both.html")`; a notebook shows it.

    The first one is the reference of the differences. case: whose profiles are drawn for files that name none.
    """
    from .page import case_settings, make_page

    if isinstance(runs, (str, PathLike)) or not isinstance(runs, Sequence):
        runs = [runs]
    if not runs:
        raise Error("view: expected a run or a column file, found none")
    records = distinct([as_record(run) for run in runs])
    return make_page(records, title, case_settings(case) if case else None)


def as_record(run: Run | str | PathLike[str]) -> Record:
    from ..record import read_record
    from .page import run_record

    return read_record(run) if isinstance(run, (str, PathLike)) else run_record(run)


def distinct(records: Sequence[Record]) -> list[Record]:
    """Runs of one name are told apart: by their contact law, if that does, by their file, or by number."""
    def apart(names: list[str]) -> bool:
        return len(set(names)) == len(names)

    names = [record.name for record in records]
    if apart(names):
        return list(records)
    laws = [f"{record.name} {record.setting('contact', 'model') or record.file.name}" for record in records]
    files = [str(record.file) for record in records]
    numbered = [f"{name} ({k})" for k, name in enumerate(names, 1)]
    chosen = next(words for words in (laws, files, numbered) if apart(words))
    return [replace(record, name=name) for record, name in zip(records, chosen, strict=True)]


def speed(word: str) -> float:
    """Of a film, seconds of the run per second: 0.001, 1e-3 or 1:1000."""
    try:
        found = float(Fraction(word.strip().replace(":", "/")))
    except (ValueError, ZeroDivisionError):
        found = 0.0
    if not found > 0:
        raise argparse.ArgumentTypeError(f"expected a number above 0 such as 1e-3 or 1:1000, found {word}")
    return found


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column files; the first is the reference")
    parser.add_argument("-o", "--output", type=Path, metavar="HTML",
                        help="the page (default: the first file's name with .html, here)")
    parser.add_argument("--columns", type=Path, metavar="TOML",
                        help="how files without our header name our columns")
    parser.add_argument("--case", metavar="NAMELIST",
                        help="whose profiles are drawn for files that name none (default: those of the first file that "
                             "does, else the benchmark's)")
    parser.add_argument("--title", default="", help="of the page (default: the cases')")
    parser.add_argument("--film", type=Path, metavar="FILE",
                        help="write a film instead, .mp4 or .gif, or a picture of one moment, .png")
    parser.add_argument("--from", dest="start", type=float, metavar="S",
                        help="start of the film, or the moment [s] (start of the run)")
    parser.add_argument("--to", dest="end", type=float, metavar="S", help="end of the film [s] (end of the run)")
    parser.add_argument("--speed", type=speed, metavar="X",
                        help="of the film, 1e-3 or 1:1000 for a thousandth (default: so that it takes 20 s)")


def main(args: argparse.Namespace) -> int:
    from .page import case_settings, make_page

    case = None
    if args.case:
        from ..case import Case

        case = Case.from_namelist(args.case)
    for name, value in ("--from", args.start), ("--to", args.end), ("--speed", args.speed):
        if value is not None and not args.film:
            raise Error(f"{name}: expected with --film, found without")
        if value is not None and name != "--from" and args.film.suffix.lower() == ".png":
            raise Error(f"{name}: expected with a film, found with the picture of a moment")
    target = args.film or args.output or Path(f"{args.files[0].stem}.html")
    check_written([target], args.files)
    if not args.film:
        check_ending(target, "a page .html", ".html", ".htm")
    if args.film:
        from .film import check_film, make_film

        check_film(target)
        records = read(args.files, args.columns)
        make_film(records, target, args.start, args.end, args.speed, case_settings(case) if case else None)
    else:
        records = read(args.files, args.columns)
        make_page(records, args.title, case_settings(case) if case else None).write(target)
    print(f"{target}  {target.stat().st_size/1e6:.2f} MB")
    return 0


def read(files: Sequence[Path], columns: Path | None) -> list[Record]:
    """The files; the map of names is for those without our header."""
    from ..record import read_record

    return distinct([read_record(file, columns) for file in files])
