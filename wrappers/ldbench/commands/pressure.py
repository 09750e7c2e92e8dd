"""Show the pressure between wheels and rails at one moment of a run: a picture and the numbers.

The picture shows the pressure on the surface developed into the plane, its largest values along and across the
rail, the patch on the profiles, and Hertz's ellipse with the integral of the pressure. For runs with the model 'halfspace'.
A patch that tread and flange share has both names. The force of the columns is that by which the elastic energy changes
with the pose; the vector sum of the pressures differs from it by the error of the contact table and by normals that turn
over a patch. The integral of the pressure, ∫p dA, adds pressures without their directions and is the largest of the three.

examples:
  python -m ldbench pressure outputs/ex2_aw.txt --at 0.0217 --contact LF
  python -m ldbench pressure outputs/ex2_aw.txt --at 0.0217 -o outputs/pressure.pdf
"""
from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .._core.errors import Error
from .._core.files import check_written
from ..constants import CONTACT_NAMES, KN, MM
from ..geometry.pressures import run_patches
from ..plots.pressure_page import force_words, patch_name, save_page
from ..plots.sheets import check_sheets
from ..results.run_data import RunData, read_data
from .options import add_json, add_output, print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE", help="a column file")
    parser.add_argument("--at", type=float, metavar="S", required=True, help="the moment [s]; the nearest row counts")
    parser.add_argument("--contact", choices=tuple(CONTACT_NAMES),
                        help="one contact: left or right, tread or flange (default: all that are closed)")
    add_output(parser, "the picture, .pdf, .svg or .png", default="ldbench_pressure.pdf")
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    check_sheets(args.output)
    check_written([args.output], [args.file])
    run = read_data(args.file)
    k = row_at(run, args.at)
    contacts = [args.contact] if args.contact else list(CONTACT_NAMES)
    patches = run_patches(run, k, contacts)
    if not patches:
        closed = [name for name in CONTACT_NAMES if run.closed(name)[k]]
        where = f"{args.file}, t = {run.time[k]:.6f} s"
        if args.contact in closed:
            raise Error(file=where, expected=f"pressure in {args.contact}",
                        found="none: with the whole wheel pressed, this contact carries nothing")
        raise Error(file=where, expected=f"{args.contact or 'a contact'} closed",
                    found=", ".join(closed) or "all contacts open")
    save_page(run, k, patches, args.output)
    if args.json:
        print_json({"time": run.time[k], "patches": [patch.facts() for patch in patches], "picture": str(args.output)})
        return 0
    print(f"{run.name}: t = {run.time[k]:.6f} s")
    for patch in patches:
        print(f"{patch_name(patch)}: {force_words(run, k, patch)}, in the columns",
              f"  vector sum of these pressures {KN*float(np.hypot(*patch.resultant)):.2f} kN, sum without directions ∫p dA "
              f"{KN*patch.integral:.2f} kN",
              f"  largest pressure {1e-6*patch.largest:.0f} MPa, mean {1e-6*patch.mean:.0f} MPa",
              f"  area {1e6*patch.area:.1f} mm², {2e3*patch.half_x:.2f} mm along the rail, {2e3*patch.half_s:.2f} mm across it, "
              f"approach {MM*patch.approach:.4f} mm",
              f"  centre in the track at y {MM*patch.centre[0]:.3f} mm, z {MM*patch.centre[1]:.3f} mm", sep="\n")
        if patch.hertz:
            print(f"  Hertz's ellipse with ∫p dA: {2e3*patch.hertz.half_x:.2f} mm x {2e3*patch.hertz.half_s:.2f} mm, "
                  f"{1e-6*patch.hertz.largest:.0f} MPa")
    print(args.output)
    return 0


def row_at(run: RunData, time: float) -> int:
    """The row nearest to a time; Error where the run does not go there."""
    t = run.time
    if not t[0] <= time <= t[-1]:
        raise Error(file=run.file, place=f"--at {time:g}", expected=f"a time from {t[0]:g} to {t[-1]:g} s",
                    found=f"{time:g}")
    return int(np.abs(t - time).argmin())
