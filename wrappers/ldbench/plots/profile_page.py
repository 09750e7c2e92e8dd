"""The page of a profile or of both profiles of a pair: shape, parts and dimensions, tangent angle, curvature."""
from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..constants import DEG, MM, TAPE_CIRCLE
from ..geometry.pair import Pair
from ..profiles.measures import PROFILE_PARTS
from ..profiles.profile import ProfileData
from .frame import legend_above, new_page
from .geometry import pair_page
from .named import decoration, shows
from .sheets import save_sheets
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, ldbench_style, plain

Point = tuple[float, float]         # [mm]

INK = "#303030"
ARROW = {"color": INK, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 5}
BELOW = 7.0                         # from the tip of the flange down to the dimension line of qR [mm]
LEFT = -9.0                         # the dimension line of Sh, from the back of the wheel [mm]
ARCS = {"crown_radius": 0.0, "shoulder_radius": 8.5, "corner_radius": 52.0}     # middle of the arc from the rail's axis [°]


def profile_page(profiles: Sequence[ProfileData], found: Pair | None, note: str) -> Figure:
    """Profiles in columns: shape, parts and dimensions, distance of the points, angle, curvature; on the right the numbers."""
    figure = new_page(" on ".join(Path(p.path).name for p in profiles), note)
    smoothed = any(profile.smoothing for profile in profiles)
    heights = [1.7, 0.6, 1, 1] if smoothed else [1.7, 1, 1]
    grid = figure.add_gridspec(len(heights), len(profiles) + 1, height_ratios=heights, width_ratios=[1]*len(profiles) + [
        0.36*len(profiles)])
    for column, profile in enumerate(profiles):
        shape, *distance, angle, curvature = (figure.add_subplot(grid[row, column]) for row in range(len(heights)))
        if distance:
            dots, = distance[0].plot(profile.points[:, 0], 1e3*profile.distance(), ".", markersize=1.5, color=SKY)
            shows(dots, "distance of the points [µm]", "y [mm]", "points", profile.kind)
            distance[0].set_ylabel("distance [µm]")
        draw_shape(shape, profile, found)
        curves = [(profile.smooth, "through the points", BLACK, 0.9)]
        if profile.smoothing:
            own = f"smoothed by {profile.own_smoothing:.4f} mm" if profile.own_smoothing else "through the points"
            curves = [(profile.rough, "through the points", GREY, 0.5), (profile.smooth, own, BLACK, 0.9)]
        if profile.smoothed_further:
            curves.append((profile.used, f"for a run smoothed by {profile.smoothing:.4f} mm", BLUE, 0.9))
        for stations, label, color, width in curves:
            for ax, x, shown in ((angle, DEG*stations.angle, "tangent angle [°]"),
                                 (curvature, stations.curvature, "curvature [1/m]")):
                line, = ax.plot(MM*stations.y, x, color=color, linewidth=width, label=label)
                shows(line, shown, "y [mm]", label, profile.kind)
        usual = np.percentile(np.abs(profile.smooth.curvature), 99)
        curvature.set_ylim(-1.4*usual, 1.4*usual)
        angle.set_ylabel("tangent angle [°]")
        curvature.set_ylabel("curvature [1/m]")
        curvature.set_xlabel("y [mm]")
        legend_above(curvature)
    blocks = [profile.lines() for profile in profiles] + ([found.lines()] if found else [])
    numbers = [line for block in blocks for entry in [*block, ""]
               for line in textwrap.wrap(entry, 52, subsequent_indent="  ") or [""]]
    side = figure.add_subplot(grid[:, -1])
    side.set_axis_off()
    side.text(0, 1, plain("\n".join(numbers)), fontsize=6.5, va="top", linespacing=1.45, in_layout=False)
    return figure


def draw_shape(ax: Axes, profile: ProfileData, found: Pair | None) -> None:
    """Points, curve and parts; of a wheel in a pair the ends of its zones."""
    colors = dict(zip(PROFILE_PARTS, (GREY, RED, ORANGE, BLUE, GREEN, PURPLE, BLUE, GREEN), strict=True))
    c = profile.smooth
    dots, = ax.plot(*profile.points.T, ".", markersize=1.5, color=SKY, zorder=1)
    shows(dots, "z [mm]", "y [mm]", "points", profile.kind)
    for k, name in enumerate(PROFILE_PARTS, 1):
        here = c.part == k
        if here.any():
            line, = ax.plot(MM*np.where(here, c.y, np.nan), MM*c.z, color=colors[name], linewidth=1.4, label=name)
            shows(line, "z [mm]", "y [mm]", f"part {name}", profile.kind)
    if found and profile.kind == "wheel":
        for first, *_ in found.zones["left"][:-1]:
            k = int(np.argmin(np.where((c.part > 1) & (c.part < 5), np.abs(c.y - first), np.inf)))
            end, = ax.plot(MM*c.y[k], MM*c.z[k], "|", color="black", markersize=12)
            shows(end, "z [mm]", "y [mm]", "end of a zone", profile.kind)
    (draw_wheel_dimensions if profile.kind == "wheel" else draw_rail_dimensions)(ax, profile)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.05, 0.08)
    ax.set_ylabel("z [mm]")
    ax.set_title(profile.kind, loc="left", weight="bold")
    legend_above(ax)


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
    lines, leads = wheel_dimensions(profile), []
    tip, tape = int(np.argmin(profile.smooth.z)), MM*TAPE_CIRCLE
    y_tip, z_tip = MM*profile.smooth.y[tip], MM*profile.smooth.z[tip]
    if "Sh" in lines:
        top = lines["Sh"][1][1]
        leads += [((y_tip, z_tip), (LEFT - 1, z_tip)), ((tape, top), (LEFT - 1, top))]
        circle, = ax.plot([tape, tape], [top - 9, top + 6], color=GREY, linewidth=0.6, linestyle=(0, (8, 2, 2, 2)))
        shows(circle, "tape circle", "y [mm]", "mark", profile.kind)
        ax.text(tape + 1, top - 8, "tape circle", fontsize=6, color=INK)
    if "Sd" in lines:
        z = lines["Sd"][0][1]
        leads.append(((0.0, z), (0.0, z + 4)))
    if "qR" in lines:
        (inner, bottom), (outer, _) = lines["qR"]
        leads += [((inner, z_tip + 2), (inner, bottom - 1)), ((outer, lines["Sd"][1][1]), (outer, bottom - 1))]
    for ends in leads:
        lead, = ax.plot(*zip(*ends, strict=True), color=GREY, linewidth=0.4)
        decoration(lead)
    for name, (first, last) in lines.items():
        ax.annotate("", first, last, arrowprops=ARROW | {"arrowstyle": "<|-|>", "linewidth": 0.6})
        (x, y), words = np.mean([first, last], axis=0), f"{name} {MM*profile.measures[name]:.2f}"
        if first[0] == last[0]:
            ax.text(x - 1, y, words, rotation=90, fontsize=6, ha="right", va="center", color=INK)
        else:
            below = name == "qR"
            ax.text(x, y + (-0.9 if below else 0.7), words, fontsize=6, ha="center", va="top" if below else "bottom", color=INK)


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
                    color=INK, arrowprops=ARROW | {"arrowstyle": "-|>", "linewidth": 0.5})
    gauge = MM*profile.measures["gauge_point_y"]
    if np.isfinite(gauge):
        z = MM*float(np.interp(gauge, MM*curve.y[:top + 1], curve.z[:top + 1]))
        point, = ax.plot([gauge], [z], "o", markersize=2.5, color=INK)
        shows(point, "z [mm]", "y [mm]", "gauge point", profile.kind)
        ax.annotate("gauge point", (gauge, z), (gauge + 1.5, z - 6), fontsize=6, ha="left", va="center", color=INK)


def save_page(profiles: Sequence[ProfileData], found: Pair | None, note: str, target: Path, reference: str | None = None) -> None:
    """Write the pages of profiles and pair, .pdf, .svg or .png. reference: the combination of EN 15302 behind the conicity."""
    with ldbench_style():
        figures = [profile_page(profiles, found, note)]
        if found:
            figures.append(pair_page(found, note, reference, " on ".join(Path(p.path).name for p in profiles)))
        save_sheets(figures, target)
