"""Dimension lines on the drawing of a profile: measures of a wheel, radii and gauge point of a rail."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from ..profiles.measures import TAPE_CIRCLE
from ..profiles.profile import ProfileData
from ..results.quantities import MM
from .style import GREY

Point = tuple[float, float]         # [mm]

INK = "#303030"
BELOW = 7.0                         # from the tip of the flange down to the dimension line of qR [mm]
LEFT = -9.0                         # the dimension line of Sh, from the back of the wheel [mm]
ARCS = {"crown_radius": 0.0, "shoulder_radius": 8.5, "corner_radius": 52.0}     # middle of the arc from the rail's axis [°]


def wheel_dimensions(profile: ProfileData) -> dict[str, tuple[Point, Point]]:
    """Ends of the dimension lines of Sh, Sd and qR [mm]; a measure that the profile lacks has none."""
    sh, sd, qr = (MM*profile.measures[name] for name in ("Sh", "Sd", "qR"))
    tip = MM*float(profile.smooth.z.min())
    found: dict[str, tuple[Point, Point]] = {}
    if np.isfinite(sh):
        found["Sh"] = (LEFT, tip), (LEFT, tip + sh)
    if np.isfinite([sh, sd]).all():
        found["Sd"] = (0.0, tip + sh - 10), (sd, tip + sh - 10)
    if np.isfinite([sh, sd, qr]).all():
        found["qR"] = (sd - qr, tip - BELOW), (sd, tip - BELOW)
    return found


def draw_wheel_dimensions(ax: Axes, profile: ProfileData) -> None:
    """Draw Sh, Sd and qR with lines that lead to the profile, and the tape circle."""
    lines = wheel_dimensions(profile)
    tip = int(np.argmin(profile.smooth.z))
    y_tip, z_tip = MM*profile.smooth.y[tip], MM*profile.smooth.z[tip]
    tape = MM*TAPE_CIRCLE
    if "Sh" in lines:
        top = lines["Sh"][1][1]
        lead(ax, (y_tip, z_tip), (LEFT - 1, z_tip))
        lead(ax, (tape, top), (LEFT - 1, top))
        ax.plot([tape, tape], [top - 9, top + 6], color=GREY, linewidth=0.6, linestyle=(0, (8, 2, 2, 2)))
        ax.text(tape + 1, top - 8, "tape circle", fontsize=6, color=INK)
    if "Sd" in lines:
        z = lines["Sd"][0][1]
        lead(ax, (0.0, z), (0.0, z + 4))
    if "qR" in lines:
        (inner, bottom), (outer, _) = lines["qR"]
        lead(ax, (inner, z_tip + 2), (inner, bottom - 1))
        lead(ax, (outer, lines["Sd"][1][1]), (outer, bottom - 1))
    for name, (first, last) in lines.items():
        dimension(ax, first, last, f"{name} {MM*profile.measures[name]:.2f}", below=name == "qR")


def draw_rail_dimensions(ax: Axes, profile: ProfileData) -> None:
    """Write the radii beside their arcs and mark the gauge point."""
    curve, lean = profile.smooth, profile.measures["inclination"]
    upright = lean if np.isfinite(lean) else 0.0
    top = int(np.argmax(curve.z))
    for name, at in ARCS.items():
        radius = MM*profile.measures[name]
        if not np.isfinite(radius):
            continue
        angle = upright + np.radians(at)
        k = int(np.argmin(np.abs(curve.angle[:top + 1] - angle))) if at else top
        y, z = MM*curve.y[k], MM*curve.z[k]
        inward = np.array([np.sin(curve.angle[k]), -np.cos(curve.angle[k])])
        ax.annotate(f"R {radius:.1f}", (y, z), (y + 11*inward[0], z + 11*inward[1]), fontsize=6, ha="center", va="center",
                    color=INK, arrowprops={"arrowstyle": "-|>", "linewidth": 0.5, "color": INK, "shrinkA": 0, "shrinkB": 0,
                                           "mutation_scale": 5})
    gauge = MM*profile.measures["gauge_point_y"]
    if np.isfinite(gauge):
        z = MM*float(np.interp(gauge, MM*curve.y[:top + 1], curve.z[:top + 1]))
        ax.plot([gauge], [z], "o", markersize=2.5, color=INK)
        ax.annotate("gauge point", (gauge, z), (gauge + 1.5, z - 6), fontsize=6, ha="left", va="center", color=INK)


def lead(ax: Axes, start: Point, end: Point) -> None:
    """Draw a thin line from the profile to the end of a dimension line."""
    ax.plot(*zip(start, end, strict=True), color=GREY, linewidth=0.4)


def dimension(ax: Axes, first: Point, last: Point, words: str, below: bool = False) -> None:
    """Draw a dimension line with an arrow at either end and its words beside the middle."""
    ax.annotate("", first, last, arrowprops={"arrowstyle": "<|-|>", "linewidth": 0.6, "color": INK, "shrinkA": 0, "shrinkB": 0,
                                             "mutation_scale": 5})
    middle = (first[0] + last[0])/2, (first[1] + last[1])/2
    if first[0] == last[0]:
        ax.text(middle[0] - 1, middle[1], words, rotation=90, fontsize=6, ha="right", va="center", color=INK)
    else:
        ax.text(middle[0], middle[1] + (-0.9 if below else 0.7), words, fontsize=6, ha="center", va="top" if below else "bottom",
                color=INK)
