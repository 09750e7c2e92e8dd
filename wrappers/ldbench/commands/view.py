"""Show runs as a page in the browser, as a film or as a picture: the ending of -o says which.

The page is one HTML file with everything in it: wheels on rails with contact points and forces, contact patches at
the peaks, charts of any columns over time or over each other, the values at the cursor, and the namelist of each
run. It opens at the first flange contact. The button `keys` lists what keyboard and mouse do; the address of the page holds
the view. The picture and charts are saved as SVG, PDF or PNG, charts as CSV too. Further files are drawn over the first one.
The columns of another code's file are named by --map, or guessed, as for `compare`.
Films and pictures show the whole wheelset and a close-up of each contact, of at most eight runs, with scales of force
and length.

examples:
  python -m ldbench view outputs/ex2_aw.txt
  python -m ldbench view outputs/ex2_aw.txt other_code.csv --map other_code.toml -o ex2.html
  python -m ldbench view outputs/ex2_aw.txt -o ex2.mp4 --from 0.015 --to 0.03 --speed 1e-3
  python -m ldbench view outputs/ex2_aw.txt -o wheelset.svg --from 0.0219 --width 170mm
"""
from __future__ import annotations

import argparse
import os
import sys
import webbrowser
from fractions import Fraction
from pathlib import Path

from .._core.errors import Usage
from .._core.files import DEFAULT_FOLDER, check_ending, check_written
from ..case import Case
from ..viewer.film import FILMS, PICTURES, Width, check_film, make_film
from ..viewer.page import distinct, make_page
from .options import add_map, add_output, add_simulation, read_files

PAGES = ".html", ".htm"
WIDTHS = 80, 600            # of a picture [mm]


def speed(word: str) -> float:
    """The speed of a film, seconds of the run per second: 0.001, 1e-3 or 1:1000."""
    try:
        found = float(Fraction(word.strip().replace(":", "/")))
    except (ValueError, ZeroDivisionError):
        found = 0.0
    if not found > 0:
        raise argparse.ArgumentTypeError(f"expected a number above 0 such as 1e-3 or 1:1000, found {word}")
    return found


def width(word: str) -> Width:
    """The width of a picture: 170mm, of which a PNG file has 300 dots to the inch, or 1280px, of which an inch has 96."""
    known = {"mm": (25.4, 300.0), "px": (96.0, 96.0)}.get(word.strip()[-2:])
    try:
        found = Width(float(word.strip()[:-2])/known[0], known[1]) if known else None
    except ValueError:
        found = None
    if not found or not WIDTHS[0] <= 25.4*found.inches <= WIDTHS[1]:
        raise argparse.ArgumentTypeError(f"expected {WIDTHS[0]}mm to {WIDTHS[1]}mm, such as 170mm or 1280px, found {word}")
    return found


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="column files; the first is the reference")
    add_output(parser, "the page .html, the film .mp4 or .gif, or the picture of one moment .png, .svg or .pdf "
                       "(outputs/NAME.html, by the first file's name)")
    add_map(parser)
    add_simulation(parser)
    parser.add_argument("--case", metavar="NAMELIST",
                        help="case whose profiles are drawn for files that name none (default: the first file that names "
                             "some, else the benchmark)")
    parser.add_argument("--title", default="", help="title of the page (default: those of the cases)")
    parser.add_argument("--from", dest="start", type=float, metavar="S",
                        help="start of the film, or the moment of the picture [s] (start of the run)")
    parser.add_argument("--to", dest="end", type=float, metavar="S", help="end of the film [s] (end of the run)")
    parser.add_argument("--speed", type=speed, metavar="X",
                        help="speed of the film, 1e-3 or 1:1000 for a thousandth (default: so that it takes 20 s)")
    parser.add_argument("--width", type=width, metavar="X",
                        help="width of a picture .png, .svg or .pdf in mm or px, such as 170mm or 1280px: letters keep their size, "
                             "and a narrow picture has its charts below the wheelset (default: 1280 pixels of a PNG file, 325 mm)")
    parser.add_argument("--no-browser", dest="browser", action="store_false",
                        help="write the page and do not open it; pipes, CI and machines without a display never open it")


def main(args: argparse.Namespace) -> int:
    target = args.output or Path(DEFAULT_FOLDER, f"{args.files[0].stem}.html")
    check_ending(target, "a page .html, a film .mp4 or .gif, or a picture .png, .svg or .pdf", *PAGES, *FILMS,
                 *PICTURES)
    kind = target.suffix.lower()
    for name, value in ("--from", args.start), ("--to", args.end), ("--speed", args.speed):
        if value is not None and kind in PAGES:
            raise Usage(place=name, expected="with a film -o FILE.mp4", found="with a page")
        if value is not None and kind in PICTURES and name != "--from":
            raise Usage(place=name, expected="with a film -o FILE.mp4", found="with the picture of a moment")
    if args.width and kind not in PICTURES:
        raise Usage(place="--width", expected="with a picture -o FILE.svg, .pdf or .png", found=f"with a {kind} file")
    case = Case.from_namelist(args.case) if args.case else None
    check_written([target], args.files)
    if kind not in PAGES:
        check_film(target)
    runs = distinct(read_files(args.files, args.map, args.simulation))
    if kind in PAGES:
        make_page(runs, args.title, case).write(target)
    else:
        make_film(runs, target, args.start, args.end, args.speed, case, args.width)
    print(f"{target}  {target.stat().st_size/1e6:.2f} MB")
    if kind in PAGES and args.browser and at_display() and not webbrowser.open(target.resolve().as_uri()):
        print(f"{target}: no browser was found that opens this page")
    return 0


def at_display() -> bool:
    """Whether a person at a terminal called, on a machine that shows windows; never in tests and CI."""
    shows = sys.platform in ("darwin", "win32") or bool({"DISPLAY", "WAYLAND_DISPLAY"} & os.environ.keys())
    return shows and sys.stdout.isatty() and not {"CI", "PYTEST_CURRENT_TEST"} & os.environ.keys()
