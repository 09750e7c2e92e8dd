"""The page of a profile or of both profiles of a pair: shape, parts and dimensions, tangent angle, curvature."""
from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..geometry.pair import Pair
from ..profiles.measures import PARTS
from ..profiles.profile import ProfileData
from ..results.quantities import DEG, MM
from .dimensions import draw_rail_dimensions, draw_wheel_dimensions
from .document import save_sheets
from .frame import legend_above, new_page
from .pair_page import pair_page
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, ldbench_style, plain


def profile_page(profiles: Sequence[ProfileData], found: Pair | None, note: str) -> Figure:
    """Profiles in columns: shape, parts and dimensions, distance of the points from the curve where one is smoothed, tangent
    angle, curvature; on the right the numbers."""
    figure = new_page(" on ".join(Path(p.path).name for p in profiles), note)
    smoothed = any(profile.smoothing for profile in profiles)
    heights = [1.7, 0.6, 1, 1] if smoothed else [1.7, 1, 1]
    grid = figure.add_gridspec(len(heights), len(profiles) + 1, height_ratios=heights, width_ratios=[1]*len(profiles) + [
        0.36*len(profiles)])
    for column, profile in enumerate(profiles):
        shape, *distance, angle, curvature = (figure.add_subplot(grid[row, column]) for row in range(len(heights)))
        if distance:
            distance[0].plot(profile.points[:, 0], 1e3*profile.distance(), ".", markersize=1.5, color=SKY)
            distance[0].set_ylabel("distance [µm]")
        draw_shape(shape, profile, found)
        for stations, label, color in ((profile.rough, "through the points", GREY),
                                       (profile.smooth, f"smoothed by {profile.smoothing:.4f} mm", BLACK)):
            if stations is profile.rough and profile.smoothing == 0:
                continue
            label = label if profile.smoothing else "through the points"
            width = 0.5 if color == GREY else 0.9
            angle.plot(MM*stations.y, DEG*stations.angle, color=color, linewidth=width, label=label)
            curvature.plot(MM*stations.y, stations.curvature, color=color, linewidth=width, label=label)
        usual = np.percentile(np.abs(profile.smooth.curvature), 99)
        curvature.set_ylim(-1.4*usual, 1.4*usual)
        angle.set_ylabel("tangent angle [°]")
        curvature.set_ylabel("curvature [1/m]")
        curvature.set_xlabel("y [mm]")
        legend_above(curvature)
    write_lines(figure.add_subplot(grid[:, -1]), profiles, found)
    return figure


def draw_shape(ax: Axes, profile: ProfileData, found: Pair | None) -> None:
    """Points, curve and parts; of a wheel in a pair the ends of its zones."""
    colors = dict(zip(PARTS, (GREY, RED, ORANGE, BLUE, GREEN, PURPLE, BLUE, GREEN), strict=True))
    c = profile.smooth
    ax.plot(*profile.points.T, ".", markersize=1.5, color=SKY, zorder=1)
    for k, name in enumerate(PARTS, 1):
        here = c.part == k
        if here.any():
            ax.plot(MM*np.where(here, c.y, np.nan), MM*c.z, color=colors[name], linewidth=1.4, label=name)
    if found and profile.kind == "wheel":
        for first, *_ in found.zones["left"][:-1]:
            k = int(np.argmin(np.where((c.part > 1) & (c.part < 5), np.abs(c.y - first), np.inf)))
            ax.plot(MM*c.y[k], MM*c.z[k], "|", color="black", markersize=12)
    (draw_wheel_dimensions if profile.kind == "wheel" else draw_rail_dimensions)(ax, profile)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.05, 0.08)
    ax.set_ylabel("z [mm]")
    ax.set_title(profile.kind, loc="left", weight="bold")
    legend_above(ax)


def write_lines(ax: Axes, profiles: Sequence[ProfileData], found: Pair | None) -> None:
    """The numbers, in a column on the right."""
    blocks = [profile.lines() for profile in profiles] + ([found.lines()] if found else [])
    wrapped = []
    for block in blocks:
        wrapped += [line for entry in block for line in textwrap.wrap(entry, 52, subsequent_indent="  ")] + [""]
    ax.set_axis_off()
    ax.text(0, 1, plain("\n".join(wrapped)), fontsize=6.5, va="top", linespacing=1.45, in_layout=False)


def save_page(profiles: Sequence[ProfileData], found: Pair | None, note: str, target: Path, reference: str | None = None) -> None:
    """Write the pages of profiles and pair, a .pdf, or a .png with one below the other.

    reference: the combination of EN 15302 that is drawn behind the conicity.
    """
    with ldbench_style():
        figures = [profile_page(profiles, found, note)]
        if found:
            figures.append(pair_page(found, note, reference, " on ".join(Path(p.path).name for p in profiles)))
        save_sheets(figures, target)
