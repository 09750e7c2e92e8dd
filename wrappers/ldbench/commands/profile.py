"""Look at a wheel or rail profile, or at a pair, before a run: pages and the numbers.

The page shows the parts of the profile, Sh, Sd and qR, tangent angle and curvature before and after smoothing, the
measures of EN 15313, and what was mended. A pair has a second page: each wheel on its rail with contact lines, and over
the lateral displacement the rolling radius difference, the contact angles and their tangents, the contact positions,
roll and conicity, for the level wheelset (EN 15302) and for the one that rolls until it stands on both rails. A picture
.svg or .png has the second page below the first.

examples:
  python -m ldbench profile profiles/awprof.yz
  python -m ldbench profile wheel.whl rail.ban --smoothing 0.02 --set gauge=1.435 -o pair.png
  python -m ldbench profile wheel.whl -o wheel.yz
  python -m ldbench profile left.whl rail.ban --set wheel_profile_right=right.whl
  python -m ldbench profile wheel.whl rail.ban --rail-inclination 1:40
  python -m ldbench profile wheel.whl rail.ban --radii 0.46,0.459 --en15302 A-918
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.errors import Error, Usage
from .._core.files import check_ending, check_written
from ..case import Case
from ..geometry.en15302 import TABLES
from ..geometry.pair import Pair, inclination_words, pair
from ..plots.profile_page import save_page
from ..plots.sheets import ENDINGS
from ..profile import Profile
from .options import add_json, add_output, add_set, parse_setting, print_json, settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="+", metavar="PROFILE", help="a wheel or a rail, or one of each")
    add_set(parser)
    parser.add_argument("--smoothing", type=float, metavar="MM",
                        help="rms distance that the curve may keep from the points [mm], 0 for none; their noise by default")
    parser.add_argument("--unit", choices=["auto", "mm", "cm", "m", "in"], default="auto",
                        help="unit of the file (default: as its width says)")
    parser.add_argument("--flip", choices=["auto", "none", "y", "z", "yz"], default="auto",
                        help="axes to turn over (default: as the shape says)")
    parser.add_argument("--wheel-back", type=float, metavar="MM", help="y of the wheel's back in its file [mm]")
    parser.add_argument("--slice", type=int, metavar="N", help="which profile of a file that has several, from 1")
    parser.add_argument("--rail-inclination", metavar="ANGLE", default=None,
                        help="angle by which the rails lean to the track's centre beyond their file, in rad or as 1:40")
    parser.add_argument("--scale", type=float, metavar="N", help="N of a model 1:N, from 1 to 10 (default: as the size says)")
    parser.add_argument("--radii", type=two_radii, metavar="LEFT,RIGHT",
                        help="radii of the wheels on the tape circle [m], in place of rolling_radius where they touch")
    parser.add_argument("--en15302", choices=TABLES, metavar="CASE",
                        help=f"draw the reference of EN 15302:2021 and its window behind the conicity: {', '.join(TABLES)}")
    add_output(parser, "the page, .pdf, .svg or .png; or, of one profile, the curve .yz that the executable reads",
               default="ldbench_profile.pdf")
    add_json(parser)


def two_radii(words: str) -> tuple[float, float]:
    """Read the radii of the left and the right wheel [m], separated by a comma."""
    try:
        left, right = map(float, words.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected two radii in m, LEFT,RIGHT, found '{words}'") from None
    return left, right


def main(args: argparse.Namespace) -> int:
    if len(args.files) > 2:
        raise Usage(expected="a wheel or a rail, or one of each", found=f"{len(args.files)} files")
    check_ending(args.output, "a page .pdf, .svg or .png, or a curve .yz", *ENDINGS, ".yz")
    check_written([args.output], map(Path, args.files))
    case = Case(settings(args.set))
    if args.rail_inclination is not None:
        case = case.replace(rail_inclination=parse_setting(f"rail_inclination={args.rail_inclination}")[1])
    profiles = [Profile(file, unit=args.unit, flip=args.flip, wheel_back=args.wheel_back, smoothing=args.smoothing,
                        slice=args.slice, gauge_depth=case.gauge_depth, scale=args.scale) for file in args.files]
    profiles.sort(key=lambda profile: profile.kind, reverse=True)
    found = None
    if len(profiles) == 2:
        if profiles[0].kind == profiles[1].kind:
            raise Error(expected="a wheel and a rail", found=f"two {profiles[0].kind}s: {', '.join(args.files)}")
        found = pair(case.replace(wheel_profile=profiles[0], rail_profile=profiles[1]), args.radii)
    elif args.radii or args.en15302 or args.rail_inclination is not None:
        option = "--radii" if args.radii else "--en15302" if args.en15302 else "--rail-inclination"
        raise Usage(expected=f"a wheel and a rail for {option}", found="one profile")
    right = [Path(file).name for file in (case.wheel_profile_right, case.rail_profile_right) if file]
    note = (f"on the right {', '.join(right)}; " if right else "") + f"gauge {case.gauge:g} m, back-to-back {case.back_to_back:g} m"
    note = "; ".join(filter(None, (note, inclination_words(found.inclination)))) if found else ""
    if args.output.suffix == ".yz":
        if found:
            raise Usage(expected="one profile for a curve .yz", found="two")
        profiles[0].write(args.output)
    else:
        save_page(profiles, found, note, args.output, args.en15302)
    blocks: list[Profile | Pair] = [*profiles, *([found] if found else [])]
    if args.json:
        print_json({"profiles": [profile.facts() for profile in profiles], "page": str(args.output)}
                   | ({"pair": found.facts()} if found else {}))
        return 0
    for block in blocks:
        print(block.lines()[0], *(f"  {line}" for line in block.lines()[1:]), sep="\n")
    print(args.output)
    return 0
