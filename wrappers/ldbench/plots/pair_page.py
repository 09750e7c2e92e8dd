"""The page of a pair: each wheel on its rail with contact lines, and what contact does over the lateral displacement."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..geometry.en15302 import AMPLITUDES, window
from ..geometry.outlines import Side
from ..geometry.pair import Pair
from ..results.quantities import DEG, MM
from .frame import legend_above, new_page
from .style import BLACK, BLUE, CONTACT_LINES, GREY, RED, SKY, Line

RAISED = 16.0           # the wheel above its rail in the drawing of contact lines [mm]
BEYOND = 3e-3           # contact lines go so far past the clearance [m]
JUMP = 1e-3             # a contact that moves more between neighbouring displacements jumps [m]
LEVEL, ROLLED, HARMONIC = Line(BLUE), Line(BLACK), Line(RED, "--", 0.8)
SIDES = {1: ("left", "L", CONTACT_LINES["LT"]), -1: ("right", "R", CONTACT_LINES["RT"])}
FACE = "#EEF0F3"
DRAWN = 82.0            # height of the drawing of contact lines [mm]
LABELS = 6.5            # between labels of its lines, at least [mm]


class ContactLine(NamedTuple):
    """The points of wheel and rail that touch at a displacement, in the frame of `Side`."""

    y: float                # lateral displacement of the wheelset [m]
    wheel: np.ndarray       # Y outward and Z from the axle centre [m]
    rail: np.ndarray        # Y outward and Z from the top of the rail [m]


def contact_lines(found: Pair, side: int) -> list[ContactLine]:
    """The contact lines of the left (1) or right (-1) wheel for displacements of whole millimetres, to a little beyond the
    clearance."""
    g = found.rolled.geometry
    letter = SIDES[side][1]
    own = found.outlines.left if side > 0 else found.outlines.right
    lines = []
    first, last = max(g["Y"][0], -found.clearance[1] - BEYOND), min(g["Y"][-1], found.clearance[0] + BEYOND)
    for mm in range(int(np.ceil(MM*first - 1e-9)), int(np.floor(MM*last + 1e-9)) + 1):
        k = int(np.argmin(np.abs(g["Y"] - mm/MM)))
        rail = np.array([side*g[f"y_{letter}"][k], g[f"z_{letter}"][k]])
        roll = side*g["roll"][k]
        across = rail[0] - side*g["Y"][k]
        # The point of the wheel that lies at `across` and, turned back by the roll, at its radius below the axle.
        out = (across - np.sin(roll)*g[f"radius_{letter}"][k])/np.cos(roll)
        lines.append(ContactLine(mm/MM, np.array([out, height(own, out, g[f"radius_{letter}"][k])]), rail))
    return lines


def height(own: Side, out: float, radius: float) -> float:
    """Height [m] of the wheel's surface at a distance from the axle's centre, on the branch that is near a radius."""
    order = slice(int(np.argmin(own.wheel[:, 1])), None)        # from the tip of the flange to the rim face
    y, z = own.wheel[order].T
    return float(np.interp(out, y, z)) if y[0] <= out <= y[-1] else -radius


def pair_page(found: Pair, note: str, reference: str | None, title: str = "") -> Figure:
    """Draw wheels on rails, and six functions; `reference` of EN 15302 lies behind the conicity."""
    figure = new_page(title, note, "drawings: the wheel is raised above its rail; a line joins the points that touch at the "
                                   "lateral displacement Y [mm] beside it, of the wheelset that stands on both rails\n"
                                   "dotted: rigid-axle clearance; level: wheelset kept level as in EN 15302")
    body = figure.add_gridspec(2, 1, height_ratios=(1, 1.35))
    for ax, side in zip(body[0].subgridspec(1, 2).subplots(), (1, -1), strict=True):
        draw_contact_lines(ax, found, side)
    axes = body[1].subgridspec(2, 3).subplots().ravel()
    g = found.rolled.geometry
    over(axes[0], "Δr = left − right [mm]", {"level": (found.level.geometry, "delta_r", MM, LEVEL),
                                             "with roll": (g, "delta_r", MM, ROLLED)})
    over(axes[1], "contact angle γ [°]", {name: (g, f"angle_{letter}", DEG, line) for name, letter, line in SIDES.values()})
    tangents = {kept.kept: {**kept.geometry, "tan": (np.tan(kept.geometry["angle_L"]) - np.tan(kept.geometry["angle_R"]))/2}
                for kept in (found.level, found.rolled)}
    over(axes[2], "½(tan γL − tan γR)", {"level": (tangents["level"], "tan", 1.0, LEVEL),
                                         "with roll": (tangents["with roll"], "tan", 1.0, ROLLED)})
    outward = {**g, "out_L": g["y_L"], "out_R": -g["y_R"]}
    over(axes[3], "contact, outward |y| [mm]", {name: (outward, f"out_{letter}", MM, line)
                                                for name, letter, line in SIDES.values()})
    over(axes[4], "roll Φ [mrad]", {"with roll": (g, "roll", 1e3, ROLLED)})
    draw_conicity(axes[5], found, reference)
    for ax in axes:
        ax.set_xlabel("amplitude [mm]" if ax is axes[5] else "lateral displacement Y [mm]")
        for reach in {found.clearance[0], found.clearance[1] if ax is axes[5] else -found.clearance[1]}:
            ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
    return figure


def over(ax: Axes, label: str, curves: dict[str, tuple[dict[str, np.ndarray], str, float, Line]]) -> None:
    """Draw curves over the lateral displacement, broken where a contact jumps."""
    for words, (geometry, column, scale, line) in curves.items():
        values = np.array(scale*geometry[column])
        gaps = np.zeros(values.shape, bool)
        if column != "delta_r" and column != "roll":
            for letter in column[-1] if column[-1] in "LR" else "LR":
                gaps[1:] |= np.abs(np.diff(geometry[f"y_{letter}"] - geometry["Y"])) > JUMP
        values[gaps] = np.nan
        ax.plot(MM*geometry["Y"], values, label=words, **line.kwargs())
    ax.set_ylabel(label)
    if len(curves) > 1:
        legend_above(ax)


def draw_contact_lines(ax: Axes, found: Pair, side: int) -> None:
    """Draw a wheel above its rail, and lines between the points that touch; left is left."""
    own = found.outlines.left if side > 0 else found.outlines.right
    name, _, line = SIDES[side]
    lift = np.array([0.0, MM*found.outlines.axle + RAISED])
    wheel, rail = MM*own.wheel + lift, MM*own.rail
    inner, outer = min(wheel[0, 0], rail[:, 0].min()) - 3, max(wheel[-1, 0], rail[:, 0].max()) + 3
    top = max(wheel[:, 1].max(), 0.0) + 8
    ax.fill(*np.vstack([wheel, [wheel[-1, 0], top], [wheel[0, 0], top]]).T, facecolor=FACE, linewidth=0)
    ax.fill(*rail.T, facecolor=FACE, linewidth=0)
    for curve in wheel, rail:
        ax.plot(*curve.T, color=BLACK, linewidth=0.9)
    labelled = -np.inf
    for one in sorted(contact_lines(found, side), key=lambda one: one.wheel[0]):
        above, below = MM*one.wheel + lift, MM*one.rail
        ax.plot(*np.array([above, below]).T, color=line.color, linewidth=0.6)
        ax.plot(*np.array([above, below]).T, "o", color=line.color, markersize=1.6)
        if above[0] - labelled > LABELS:
            labelled = above[0]
            ax.text(above[0], above[1] + 1.0, f"{MM*one.y:.0f}".replace("-", "−"), fontsize=6, ha="center", va="bottom")
    # The limits are the least; `auto` lets the aspect widen them.
    ax.set_xlim((outer, inner) if side > 0 else (inner, outer), auto=True)
    ax.set_ylim((top - DRAWN, top), auto=True)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title(f"{name} wheel and rail, y outward from the track's centre [mm]", loc="left")
    ax.tick_params(labelleft=False, left=False)
    ax.grid(False)


def draw_conicity(ax: Axes, found: Pair, reference: str | None) -> None:
    """Draw the conicity of the wheelset kept level and of the one with roll; behind it the reference of EN 15302."""
    if reference:
        w = window(reference)
        ax.fill_between(MM*AMPLITUDES, w.extended_low, w.extended_high, color=SKY, alpha=0.2, linewidth=0,
                        label=f"extended window, {reference}")
        ax.fill_between(MM*AMPLITUDES, w.low, w.high, color=SKY, alpha=0.45, linewidth=0, label=f"window, {reference}")
    for geometry, line in (found.level, LEVEL), (found.rolled, ROLLED):
        ax.plot(MM*geometry.amplitude, geometry.conicity, label=f"{geometry.kept}, EN 15302", **line.kwargs())
    ax.plot(MM*found.rolled.amplitude, found.rolled.linearised, label="with roll, harmonic", **HARMONIC.kwargs())
    ax.set(xlim=(0, max(1.2*MM*max(found.clearance), MM*AMPLITUDES[-1])))
    ax.set_ylim(bottom=0)
    ax.set_ylabel("equivalent conicity")
    legend_above(ax, 3, fontsize=6)
