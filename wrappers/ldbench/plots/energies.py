"""Phase portraits and spectra of a run; quantities over the lateral force of one whose force grows."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from ..constants import CONTACT_NAMES, DEG, KN, MM
from ..geometry.outlines import flange_angle, run_outlines
from ..results.answers import answers
from ..results.derived import lateral_over_vertical, nadal_limit, spectrum, wheel_loads
from ..results.quantities import quantity
from ..results.run_data import RunData
from .frame import caption, legend_above, new_page
from .named import name, shows
from .series import RATIO, draw_columns, draw_curve
from .stretches import PANEL, Window, last_second, thin, whole
from .style import BLACK, BLUE, CONTACT_LINES, GREEN, GREY, PURPLE, RED, Line, powers_of_ten

PHASES = ("Y", "vY"), ("Z", "vZ"), ("roll", "roll_rate")
HIGHEST = 500.0         # frequency of the spectra [Hz]
DECADES = 1e-5          # smallest amplitude of a spectrum that is drawn, over the largest one
FRICTIONS = 0.0, 0.3        # for which Nadal's limit is drawn
NEEDED = {"F_ext", "Y", "roll", *(f"{what}_{contact}" for what in ("N", "Fy", "Fz") for contact in CONTACT_NAMES)}


def portrait_page(run: RunData) -> Figure | None:
    """Velocity over displacement, spectra, and L/V; None without velocities."""
    if not all({*phase}.issubset(run.data) for phase in PHASES):
        return None
    shown = last_second(run) or whole(run)
    notes = ["phase portraits: the last second"] if shown.start > run.time[0] else []
    if found := frequencies(run):
        notes.append(f"dotted in spectra: eigenfrequencies at rest, {', '.join(f'{f:.4g}' for f in found)} Hz")
    figure = new_page(f"{run.heading}: phase portraits and spectra", run.header.title,
                      f"{'; '.join(notes)}\n{caption(run)}".strip())
    body = figure.add_gridspec(1, 2)
    draw_portraits(body[0].subgridspec(3, 1).subplots(), run, shown)
    draw_spectra(body[1], run)
    return figure


def draw_portraits(axes: np.ndarray, run: RunData, window: Window) -> None:
    """Velocity over displacement of the three degrees of freedom."""
    t, rows, found = run.time, window.rows(run), answers(run)
    for ax, columns in zip(axes, PHASES, strict=True):
        known = [quantity(column) for column in columns]
        x, y = (one.scale*run.values(column)[rows] for one, column in zip(known, columns, strict=True))
        of_x, of_y = (name(column, one.unit) for one, column in zip(known, columns, strict=True))
        curve, = ax.plot(x, y, color=BLACK, linewidth=0.6)
        shows(curve, of_y, of_x)
        marks = {"start": (0, "o", GREEN)} if rows.start == 0 else {}
        for contact, marker in (("LF", "<"), ("RF", ">")):
            first = found[f"t_first_{contact}"]
            if first is not None and t[rows][0] <= first <= t[rows][-1]:
                color = CONTACT_LINES[contact].color
                marks[f"{CONTACT_NAMES[contact]} touches"] = int(np.abs(t[rows] - first).argmin()), marker, color
        marks["end of the run"] = len(x) - 1, "s", PURPLE
        for words, (k, marker, color) in marks.items():
            mark, = ax.plot(x[k:k + 1], y[k:k + 1], marker, color=color, linestyle="none", markersize=4.5, markeredgecolor=BLACK,
                            markeredgewidth=0.4, label=words)
            shows(mark, of_y, of_x, words)
        ax.margins(0.04)
        ax.locator_params(nbins=6)
        ax.set(xlabel=known[0].label, ylabel=known[1].label)
    legend_above(axes[0], handlelength=1.0)


def draw_spectra(place: SubplotSpec, run: RunData) -> None:
    """Amplitude spectra of Z and roll, and L/V."""
    grid = place.subgridspec(3, 1)
    figure = place.get_gridspec().figure
    for k, (column, words) in enumerate((("Z", "amplitude of Z"), ("roll", "amplitude of Φ"))):
        f, amplitude = spectrum(run, column)
        f, x = f[f <= HIGHEST], quantity(column).scale*amplitude[f <= HIGHEST]
        if not x.any():
            continue
        ax, unit, top = figure.add_subplot(grid[k]), quantity(column).unit, x.max()
        curve, = ax.plot(*thin(f, np.maximum(x, DECADES*top), PANEL), color=BLACK, linewidth=0.7)
        shows(curve, name(f"amplitude of {column}", unit), "frequency [Hz]", "spectrum")
        ax.set(yscale="log", ylim=(DECADES*top, 2*top), xlim=(0, HIGHEST), xlabel="frequency [Hz]", ylabel=name(words, unit))
        powers_of_ten(ax.yaxis)
        for frequency in frequencies(run):
            mark = ax.axvline(frequency, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
            shows(mark, "eigenfrequency", "frequency [Hz]", "mark")
    if RATIO.of(run):
        draw_columns(grid[2], run, ((RATIO,),), whole(run))


def frequencies(run: RunData) -> list[float]:
    """The eigenfrequencies at rest that are known [Hz]."""
    return [f for k in (1, 2, 3) if np.isfinite(f := run.results.get(f"frequency_{k}", np.nan))]


def is_ramp(run: RunData) -> bool:
    """Whether the lateral force of a run grows or falls all the time."""
    if not NEEDED.issubset(run.data):
        return False
    change = np.diff(run.values("F_ext"))
    return bool(np.any(change)) and (bool(np.all(change >= 0)) or bool(np.all(change <= 0)))


def ramp_page(run: RunData) -> Figure:
    """L/V of both wheels with Nadal's limit, loads, forces and displacements over the lateral force."""
    placed = run_outlines(run)[0]
    angle = flange_angle(placed.left) if placed else np.nan
    limit = (f"Nadal's limit for the steepest angle of the flange, {DEG*angle:.1f}°, with friction "
             f"{' and '.join(f'{friction:g}' for friction in FRICTIONS)}" if placed else "")
    figure = new_page(f"{run.heading}: over the lateral force", run.header.title,
                      "\n".join(words for words in (limit, caption(run)) if words))
    grid = figure.add_gridspec(3, 2)
    places = grid[0, :], grid[1, 0], grid[1, 1], grid[2, 0], grid[2, 1]
    ratio, load, normal, lateral, roll = axes = [figure.add_subplot(place) for place in places]
    last = last_second(run)
    rows = whole(run, last.start if last else None).rows(run)
    force = KN*run.values("F_ext")[rows]

    def draw(ax: Axes, x: np.ndarray, label: str, line: Line, shown: str) -> None:
        draw_curve(ax, force, x[rows], label, line, {"y": shown, "x": "F_ext [kN]"}, 240 if ax is ratio else 110)

    for side, color in (("left", BLUE), ("right", RED)):
        draw(ratio, lateral_over_vertical(run, side), f"{side} wheel", Line(color), f"L/V {side}")
        draw(load, KN*wheel_loads(run, side)[1], f"{side} wheel", Line(color), f"Fz_{side[0].upper()}T+Fz_{side[0].upper()}F [kN]")
    for friction in FRICTIONS if placed else ():
        level = nadal_limit(angle, friction)
        mark = ratio.axhline(level, color=GREY, linewidth=0.9, linestyle="--" if friction else "-")
        shows(mark, f"Nadal {friction:g}", how="mark")
        ratio.annotate(f"Nadal, friction {friction:g}", (0.01, level), xycoords=("axes fraction", "data"), xytext=(0, 1.5),
                       textcoords="offset points", color="#505050", va="bottom")
    ratio.margins(y=0.12)
    for contact in ("LT", "LF", "RT"):
        draw(normal, KN*run.values(f"N_{contact}"), CONTACT_NAMES[contact], CONTACT_LINES[contact], f"N_{contact} [kN]")
    draw(lateral, MM*run.values("Y"), "", Line(BLACK), "Y [mm]")
    draw(roll, 1e3*run.values("roll"), "", Line(BLACK), "roll [mrad]")
    for ax, words in zip(axes, ("L/V", "vertical load [kN]", "normal N [kN]", "lateral Y [mm]", "roll Φ [mrad]"), strict=True):
        ax.set(xlabel="" if ax in (load, normal) else "lateral force [kN]", ylabel=words)
        ax.locator_params(nbins=6)
        if len(ax.get_legend_handles_labels()[0]) > 1:
            legend_above(ax)
    return figure
