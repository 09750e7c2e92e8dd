"""The page of a profile or a pair: shape and parts, tangent angle, curvature, and what a pair does."""
from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._core.files import complete
from ..profiles.en15302 import AMPLITUDES, window
from ..profiles.inspect import Pair, Profile
from ..profiles.measures import PARTS
from ..results.quantities import DEG, MM
from .frame import new_page
from .style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, ldbench_style, plain


def profile_page(profiles: list[Profile], found: Pair | None, note: str, reference: str | None = None) -> Figure:
    """Profiles in columns: shape and parts, tangent angle, curvature; below them what a pair does.

    reference: the combination of EN 15302 that is drawn behind the conicity.
    """
    figure = new_page(" on ".join(Path(p.path).name for p in profiles), note)
    grid = figure.add_gridspec(4 if found else 3, len(profiles), left=0.06, right=0.735, top=0.915, bottom=0.075,
                               hspace=0.5, wspace=0.2, height_ratios=[1.35, 1, 1, 1][:4 if found else 3])
    for column, profile in enumerate(profiles):
        shape, angle, curvature = (figure.add_subplot(grid[row, column]) for row in range(3))
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
        curvature.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    if found:
        positions, conicity = (figure.add_subplot(grid[3, column]) for column in range(2))
        geometry = found.rolled.geometry
        for side, sign, color in ("left", 1, BLACK), ("right", -1, ORANGE):
            contact = geometry[f"y_{side[0].upper()}"]
            positions.plot(MM*geometry["Y"], sign*MM*contact, ".", markersize=2, color=color, label=side)
        positions.set_ylabel("contact, outward |y| [mm]")
        draw_conicity(conicity, found, reference)
        positions.set_xlabel("lateral displacement Y [mm]")
        conicity.set_xlabel("amplitude [mm]")
        for ax in positions, conicity:
            for reach in set(found.clearance):
                ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
        positions.legend(loc="center left", markerscale=3)
        conicity.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, columnspacing=1.0, fontsize=5.5)
    write_lines(figure, profiles, found)
    return figure


def draw_conicity(ax: Axes, found: Pair, reference: str | None) -> None:
    """Equivalent conicity of the wheelset kept level and of the one with roll; behind it the reference of EN 15302."""
    if reference:
        w = window(reference)
        ax.fill_between(MM*AMPLITUDES, w.extended_low, w.extended_high, color=SKY, alpha=0.2, linewidth=0,
                        label=f"extended window, {reference}")
        ax.fill_between(MM*AMPLITUDES, w.low, w.high, color=SKY, alpha=0.45, linewidth=0, label=f"window, {reference}")
    for geometry, color in (found.level, BLUE), (found.rolled, BLACK):
        ax.plot(MM*geometry.amplitude, geometry.conicity, color=color, label=f"{geometry.kept}, EN 15302")
    ax.plot(MM*found.rolled.amplitude, found.rolled.linearised, "--", color=RED, linewidth=0.8,
            label="with roll, harmonic")
    ax.set(xlim=(0, max(1.2*MM*max(found.clearance), MM*AMPLITUDES[-1])), ylabel="equivalent conicity")
    ax.set_ylim(bottom=0)


def draw_shape(ax: Axes, profile: Profile, found: Pair | None) -> None:
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
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.03, 0.08)
    ax.set_ylabel("z [mm]")
    ax.set_title(profile.kind, loc="left", weight="bold")
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, borderaxespad=0.1, columnspacing=1.0)


def write_lines(figure: Figure, profiles: list[Profile], found: Pair | None) -> None:
    """The numbers, in a column on the right."""
    blocks = [profile.lines() for profile in profiles] + ([found.lines()] if found else [])
    wrapped = []
    for block in blocks:
        wrapped += [line for entry in block for line in textwrap.wrap(entry, 52, subsequent_indent="  ")] + [""]
    figure.text(0.752, 0.905, plain("\n".join(wrapped)), fontsize=6.5, va="top", linespacing=1.45)


def save_page(profiles: list[Profile], found: Pair | None, note: str, target: Path, reference: str | None = None) -> None:
    """Write the page, a .pdf or a .png."""
    with ldbench_style(), complete(target) as scratch:
        profile_page(profiles, found, note, reference).savefig(scratch, format=target.suffix[1:], dpi=110)
