"""Narrow-flange wheels with a tread of 1:40 of APTA PR-M-S-015-06, Rev. 1 (2022), appendix C: the 140M and the 240.

Their arcs and points are given in inches; the angles at which arcs meet follow from the centres. A wheel is rebuilt from
radii and angles, so that tangents do not jump by what the four decimals of the points leave.
"""
from __future__ import annotations

from math import radians

import make_profiles as mp

INCH = 25.4                 # [mm]
# Distance from the wheel's back to where the throat leaves the tread; measures that follow and test the arcs: from the back to
# the lowest point, height of the flange there over the end of the throat [in].
THROAT = {"140M": 0.6929 + 1.1875, "240": 1.0148 + 1.1563}
LOWEST = {"140M": (1.1875 - 0.5905, 0.6250 - 0.2025 + 0.6250), "240": (1.1563 - 0.5625, 0.3750 + 0.6556)}


def flange(name: str) -> list[tuple[float, float, float, float]]:
    """Pieces from the lowest point to the tread [mm, rad]."""
    if name == "140M":
        a, b = radians(72.45), radians(75.23)
        return [mp.arc(-0.625*INCH, 0, a), mp.arc(-1.875*INCH, a, b), mp.arc(0.703*INCH, b, mp.TAPER)]
    a, b, c = radians(37.89), radians(75), radians(30.79)
    return [mp.arc(-0.6875*INCH, 0, a), mp.arc(-0.375*INCH, a, b), mp.line(b, 0.143*INCH), mp.arc(0.5625*INCH, b, c),
            mp.arc(1.5*INCH, c, mp.TAPER)]


def wheel(name: str) -> list[mp.Piece]:
    """A wheel from its lowest point's back to the field side, z = 0 on the tread 78 mm from the back."""
    return mp.wheel(THROAT[name]*INCH, 78, *flange(name))


def clearance(name: str) -> float:
    """Rigid-axle clearance of the exact arcs on the shipped actual rail [mm]."""
    rail = mp.shift(mp.arprof(), mp.GAUGE_POINT, 0)
    placed = mp.shift(wheel(name), mp.WHEEL_BACK, 0)
    height, _, (_, z) = mp.touch(placed[-1:], rail, 0, 0)
    placed = mp.shift(placed, 0, height - z - mp.ROLLING_RADIUS)
    return float(mp.root(lambda Y: mp.on_flange(placed, rail, Y), 5, 14))
