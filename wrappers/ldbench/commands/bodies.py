"""Compute what wheel and rail as bodies of their own differ by from half-spaces, for `&contact influence = 'bodies'`.

Finite elements of the cross-sections, with loads that are waves along the rolling direction: wheel and rail do not change along it.
The profile goes on straight to a base; behind it the body is infinite, or clamped. Both are assumptions, between which most real
wheels and rails lie; their span says how much that matters. Outlines end where the plate or the web begins: these would bend like
prisms, which they are not.

examples:
  python -m ldbench bodies inputs/ex2_aw.nml -o aw.bodies
  python -m ldbench bodies inputs/ex2_aw.nml -o stiff.bodies --support clamped --rim-thickness 40
"""
from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .. import bodies
from .._core.files import check_written
from ..bodies.sections import HEAD_DEPTH, RIM_THICKNESS
from ..case import Case
from .options import add_json, add_output, add_set, print_json, settings

PLACES = (60, 45), (60, 30), (60, 0), (45, 0)         # angles of places on each other, as on the wheel's flange and tread [degrees]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", metavar="NAMELIST", help="namelist file, whose profiles and Poisson's ratio are taken")
    add_set(parser)
    parser.add_argument("--support", choices=["infinite", "clamped"], default="infinite",
                        help="what is behind the base of rim and head (%(default)s)")
    parser.add_argument("--rim-thickness", type=float, metavar="MM", default=1e3*RIM_THICKNESS,
                        help="height of the rim's base over the tape circle (%(default)g mm)")
    parser.add_argument("--head-depth", type=float, metavar="MM", default=1e3*HEAD_DEPTH,
                        help="depth of the head's base below the rail's top (%(default)g mm)")
    parser.add_argument("--rim", metavar="FILE",
                        help="outline of the rim, without a plate: a closed polygon, y and z in mm as in the profile")
    parser.add_argument("--head", metavar="FILE", help="outline of the rail's head, without a web")
    parser.add_argument("--only", choices=["wheel", "rail"], help="one kind of body; the other one stays a half-space")
    add_output(parser, "the file of the bodies", default="ldbench.bodies")
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    case = Case.from_namelist(args.namelist).replace(settings(args.set))
    check_written([args.output], map(Path, filter(None, (args.namelist, args.rim, args.head, *case.files().values()))))
    found = bodies.find(case, args.support, 1e-3*args.rim_thickness, 1e-3*args.head_depth, args.rim, args.head,
                        (args.only,) if args.only else ("wheel", "rail"))
    bodies.write(args.output, found)
    ratios = [{f"{one} on {other}": body.over_halfspace(*np.radians([one, other])) for one, other in PLACES} for body in found]
    if args.json:
        print_json({"file": str(args.output), "bodies": [
            {"kind": body.kind, "profile": body.profile, "support": body.support, "nodes": body.nodes, "strips": len(body.middles),
             "influence over half-space": ratio} for body, ratio in zip(found, ratios, strict=True)]})
        return 0
    for body, ratio in zip(found, ratios, strict=True):
        print(f"{body.kind} {body.profile}: {body.support} behind its base, {len(body.middles)} strips, {body.nodes} nodes")
        print("  influence between places over that of a half-space, by their angles in degrees: "
              + ", ".join(f"{places} {x:.2f}" for places, x in ratio.items()))
    print(f"bodies: {args.output}")
    return 0
