"""Contact over the lateral displacement: geometry functions of a run, and the page of a pair of profiles with contact lines."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from ..constants import DEG, MM
from ..geometry.en15302 import AMPLITUDES, window
from ..geometry.outlines import Side
from ..geometry.pair import Pair
from ..number_text import clearance_words, number_text
from ..results.run_data import RunData
from .frame import legend_above, new_page, profile_words
from .named import name, shows
from .style import BLACK, BLUE, CONTACT_LINES, GREY, RED, SKY, Line, plain_numbers

if TYPE_CHECKING:
    import pandas as pd

RAISED = 16.0           # the wheel above its rail in the drawing of contact lines [mm]
BEYOND = 3e-3           # contact lines go so far past the clearance [m]
JUMP = 1e-3             # a contact that moves more between neighbouring displacements jumps [m]
LEVEL, ROLLED, HARMONIC = Line(BLUE), Line(BLACK), Line(RED, "--", 0.8)
WHEELS = {"_L": "left", "_R": "right"}
WHEEL_LOOKS = {1: ("left", "L", CONTACT_LINES["LT"]), -1: ("right", "R", CONTACT_LINES["RT"])}
FACE = "#EEF0F3"
DRAWN = 82.0            # height of the drawing of contact lines [mm]
LABELS = 6.5            # between labels of its lines, at least [mm]
FUNCTIONS = "Y", *(f"{name}{side}" for name in ("angle", "radius", "y", "z") for side in WHEELS), "delta_r", "conicity", "roll", "Z"
Shape = tuple[RunData, "pd.DataFrame"]      # a run, and the geometry functions of its profiles


def geometry_page(run: RunData, functions: pd.DataFrame) -> Figure:
    """The functions that `ContactTable.geometry` and its file have."""
    y = MM*functions["Y"]
    left_reach, right_reach = (run.results.get(f"clearance_{side}", np.nan) for side in ("left", "right"))
    figure = new_page(f"Contact geometry, {run.pair or run.name}", "rigid wheelset standing on both rails",
                      f"dotted: rigid-axle clearance, {clearance_words(left_reach, right_reach)} mm; conicity: equivalent, by "
                      f"harmonic linearisation, for the amplitude |Y|\n{profile_words(run) or run.file}")
    axes = figure.subplots(2, 4)
    left, right, black = CONTACT_LINES["LT"], CONTACT_LINES["RT"], Line(BLACK)
    for ax, (label, scale, curves) in zip(axes.ravel(), (
            ("contact angle [°]", DEG, (("angle_L", left), ("angle_R", right))),
            ("rolling radius [mm]", MM, (("radius_L", left), ("radius_R", right))),
            ("Δr = left − right [mm]", MM, (("delta_r", black),)), ("equivalent conicity", 1.0, (("conicity", black),)),
            ("contact position, outward |y| [mm]", MM, (("y_L", left), ("y_R", right))),
            ("contact position z [mm]", MM, (("z_L", left), ("z_R", right))),
            ("roll Φ [mrad]", 1e3, (("roll", black),)), ("height Z [mm]", MM, (("Z", black),))), strict=True):
        for column, line in curves:
            sign = "-" if column == "y_R" else ""
            curve, = ax.plot(y, (-scale if sign else scale)*functions[column], label=WHEELS.get(column[-2:]), **line.kwargs())
            shows(curve, name(sign + column, unit_of(label)), "Y [mm]", "functions")
        ax.set(xlabel="lateral displacement Y [mm]", ylabel=label)
        if len(curves) > 1:
            legend_above(ax)
        mark_reach(ax, -MM*right_reach, MM*left_reach)
    conicity = axes[0, 3]
    conicity.set_yscale("log")
    conicity.set_ylim(bottom=0.02)
    conicity.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    plain_numbers(conicity.yaxis)
    return figure


class ContactLine(NamedTuple):
    """The points of wheel and rail that touch at a displacement, in the frame of `Side`."""
    y: float                # lateral displacement of the wheelset [m]
    wheel: np.ndarray       # Y outward and Z from the axle centre [m]
    rail: np.ndarray        # Y outward and Z from the top of the rail [m]


def contact_lines(found: Pair, side: int) -> list[ContactLine]:
    """Contact lines of the left (1) or right (-1) wheel at whole millimetres of displacement, to a little beyond the clearance."""
    g = found.rolled.geometry
    letter = WHEEL_LOOKS[side][1]
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
    *axes, last = body[1].subgridspec(2, 3).subplots().ravel()
    level, rolled = ({**g, "tan": (np.tan(g["angle_L"]) - np.tan(g["angle_R"]))/2, "out_L": g["y_L"], "out_R": -g["y_R"]}
                     for g in (found.level.geometry, found.rolled.geometry))

    def both(column: str) -> list[OfDisplacement]:
        return [("level", level, column, LEVEL), ("with roll", rolled, column, ROLLED)]

    def sides(column: str) -> list[OfDisplacement]:
        return [(name, rolled, f"{column}_{letter}", line) for name, letter, line in WHEEL_LOOKS.values()]

    for ax, (label, scale, curves) in zip(axes, (
            ("Δr = left − right [mm]", MM, both("delta_r")), ("contact angle γ [°]", DEG, sides("angle")),
            ("½(tan γL − tan γR)", 1.0, both("tan")), ("contact, outward |y| [mm]", MM, sides("out")),
            ("roll Φ [mrad]", 1e3, both("roll")[1:])), strict=True):
        draw_functions(ax, label, scale, curves)
        mark_reach(ax, -MM*found.clearance[1], MM*found.clearance[0])
    draw_conicity(last, found, reference)
    mark_reach(last, *{MM*reach for reach in found.clearance})
    return figure


def mark_reach(ax: Axes, *reaches: float) -> None:
    """Dotted lines where the rigid-axle clearance ends [mm]."""
    for reach in reaches:
        shows(ax.axvline(reach, color=GREY, linewidth=0.6, linestyle=":"), "clearance", "Y [mm]", "mark")


def unit_of(label: str) -> str:
    """The unit in brackets behind a label."""
    return label.partition("[")[2].rstrip("]")


OfDisplacement = tuple[str, dict[str, np.ndarray], str, Line]       # a curve: label, geometry functions, name of one, look


def draw_functions(ax: Axes, label: str, scale: float, curves: Sequence[OfDisplacement]) -> None:
    """Draw curves over the lateral displacement, broken where a contact jumps."""
    for words, geometry, column, line in curves:
        values = np.array(scale*geometry[column])
        gaps = np.zeros(values.shape, bool)
        if column not in ("delta_r", "roll"):
            for letter in column[-1] if column[-1] in "LR" else "LR":
                gaps[1:] |= np.abs(np.diff(geometry[f"y_{letter}"] - geometry["Y"])) > JUMP
        values[gaps] = np.nan
        curve, = ax.plot(MM*geometry["Y"], values, label=words, **line.kwargs())
        shows(curve, name(column, unit_of(label)), "Y [mm]", "functions", words if words in ("level", "with roll") else "with roll")
    ax.set(xlabel="lateral displacement Y [mm]", ylabel=label)
    if len(curves) > 1:
        legend_above(ax)


def draw_contact_lines(ax: Axes, found: Pair, side: int) -> None:
    """Draw a wheel above its rail, and lines between the points that touch; left is left."""
    own = found.outlines.left if side > 0 else found.outlines.right
    of_wheel, _, line = WHEEL_LOOKS[side]
    lift = np.array([0.0, MM*found.outlines.axle + RAISED])
    wheel, rail = MM*own.wheel + lift, MM*own.rail
    inner, outer = min(wheel[0, 0], rail[:, 0].min()) - 3, max(wheel[-1, 0], rail[:, 0].max()) + 3
    top = max(wheel[:, 1].max(), 0.0) + 8
    for words, points, closing in ("wheel", wheel, [[wheel[-1, 0], top], [wheel[0, 0], top]]), ("rail", rail, np.empty((0, 2))):
        names = f"{words} {of_wheel} [mm]", "outward y [mm]", "raised outline"
        face, = ax.fill(*np.vstack([points, closing]).T, facecolor=FACE, linewidth=0)
        curve, = ax.plot(*points.T, color=BLACK, linewidth=0.9)
        shows(face, *names)
        shows(curve, *names)
    labelled = -np.inf
    for one in sorted(contact_lines(found, side), key=lambda one: one.wheel[0]):
        above, below = MM*one.wheel + lift, MM*one.rail
        for look in {"linewidth": 0.6}, {"linestyle": "none", "marker": "o", "markersize": 1.6}:
            joined, = ax.plot(*np.array([above, below]).T, color=line.color, **look)
            shows(joined, f"contact at Y = {MM*one.y:.0f} mm, {of_wheel} [mm]", "outward y [mm]", "contact line")
        if above[0] - labelled > LABELS:
            labelled = above[0]
            ax.text(above[0], above[1] + 1.0, number_text(MM*one.y, 0), fontsize=6, ha="center", va="bottom")
    # The limits are the least; `auto` lets the aspect widen them.
    ax.set_xlim((outer, inner) if side > 0 else (inner, outer), auto=True)
    ax.set_ylim((top - DRAWN, top), auto=True)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_title(f"{of_wheel} wheel and rail, y outward from the track's centre [mm]", loc="left")
    ax.tick_params(labelleft=False, left=False)
    ax.grid(False)


def draw_conicity(ax: Axes, found: Pair, reference: str | None) -> None:
    """Draw the conicity of the wheelset kept level and of the one with roll; behind it the reference of EN 15302."""
    if reference:
        w = window(reference)
        for words, low, high, alpha in (("extended window", w.extended_low, w.extended_high, 0.2), ("window", w.low, w.high, 0.45)):
            area = ax.fill_between(MM*AMPLITUDES, low, high, color=SKY, alpha=alpha, linewidth=0, label=f"{words}, {reference}")
            shows(area, f"{words} of {reference}", "amplitude [mm]", "reference")
    for geometry, line in (found.level, LEVEL), (found.rolled, ROLLED):
        curve, = ax.plot(MM*geometry.amplitude, geometry.conicity, label=f"{geometry.kept}, EN 15302", **line.kwargs())
        shows(curve, "conicity", "amplitude [mm]", "functions", geometry.kept)
    curve, = ax.plot(MM*found.rolled.amplitude, found.rolled.linearised, label="with roll, harmonic", **HARMONIC.kwargs())
    shows(curve, "linearised", "amplitude [mm]", "functions", "with roll")
    ax.set(xlim=(0, max(1.2*MM*max(found.clearance), MM*AMPLITUDES[-1])), xlabel="amplitude [mm]", ylabel="equivalent conicity")
    ax.set_ylim(bottom=0)
    legend_above(ax, 3, fontsize=6)
