"""Energies of a run over time; beside them phase portraits and spectra or, under a growing force, quantities over the force."""
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
from .series import ENERGY, RATIO, constant_energies, draw_columns, draw_curve
from .stretches import PANEL, Window, is_long, last_second, overall, thin
from .style import BLACK, BLUE, CONTACT_LINES, GREEN, GREY, PURPLE, RED, Line, powers_of_ten

PHASES = (("Y", "vY", "Y [mm]", "dY/dt [m/s]", MM, 1.0), ("Z", "vZ", "Z [mm]", "dZ/dt [m/s]", MM, 1.0),
          ("roll", "roll_rate", "Φ [mrad]", "dΦ/dt [mrad/s]", 1e3, 1e3))
HIGHEST = 500.0         # frequency of the spectra [Hz]
DECADES = 1e-5          # smallest amplitude of a spectrum that is drawn, over the largest one
FRICTIONS = 0.0, 0.3        # for which Nadal's limit is drawn
NEEDED = {"F_ext", "Y", "roll", *(f"{what}_{contact}" for what in ("N", "Fy", "Fz") for contact in CONTACT_NAMES)}


def energy_page(run: RunData) -> Figure | None:
    """Energies over time, velocity over displacement, spectra, and L/V; None without energies and without velocities."""
    energies, window = ENERGY.of(run), overall(run)
    portraits = all({phase[0], phase[1]}.issubset(run.data) for phase in PHASES)
    if energies is None and not portraits:
        return None
    notes = ["; ".join(words for words in (constant_energies(run), window.title) if words)]
    if found := frequencies(run):
        notes.append(f"dotted in spectra: eigenfrequencies at rest, {', '.join(f'{f:.4g}' for f in found)} Hz")
    figure = new_page(f"{run.heading}: energy, phase portrait, spectrum", run.header.title,
                      "\n".join(note for note in (*notes, caption(run)) if note))
    body = figure.add_gridspec(1, 3, width_ratios=(1.1, 1, 1))
    if energies is not None:
        draw_columns(body[0], run, energies.columns, window)
    if portraits:
        draw_portraits(body[1].subgridspec(3, 1).subplots(), run, last_second(run) if is_long(run) else window)
    draw_spectra(body[2], run, window)
    return figure


def draw_portraits(axes: np.ndarray, run: RunData, window: Window) -> None:
    """Velocity over displacement of the three degrees of freedom."""
    t, rows, found = run.time, window.rows(run), answers(run)
    for ax, (q, v, x_label, y_label, x_scale, y_scale) in zip(axes, PHASES, strict=True):
        x, y = x_scale*run.values(q)[rows], y_scale*run.values(v)[rows]
        ax.plot(x, y, color=BLACK, linewidth=0.6)
        look = {"linestyle": "none", "markersize": 4.5}
        if rows.start == 0:
            ax.plot(x[:1], y[:1], "o", color=GREEN, label="start", **look)
        for contact, marker in (("LF", "<"), ("RF", ">")):
            first = found[f"t_first_{contact}"]
            if first is not None and t[rows][0] <= first <= t[rows][-1]:
                k = np.searchsorted(t[rows], first)
                ax.plot(x[k:k + 1], y[k:k + 1], marker, color=CONTACT_LINES[contact].color, markeredgecolor=BLACK,
                        markeredgewidth=0.4, label=f"{CONTACT_NAMES[contact]} touches", **look)
        ax.plot(x[-1:], y[-1:], "s", color=PURPLE, label="end of the run", **look)
        ax.margins(0.04)
        ax.locator_params(nbins=6)
        ax.set(xlabel=x_label, ylabel=y_label)
    legend_above(axes[0], handlelength=1.0, fontsize=6.3)


def draw_spectra(place: SubplotSpec, run: RunData, window: Window) -> None:
    """Amplitude spectra of Z and roll, and L/V."""
    grid = place.subgridspec(3, 1)
    figure = place.get_gridspec().figure
    for k, (column, words) in enumerate((("Z", "amplitude of Z"), ("roll", "amplitude of Φ"))):
        if column not in run.data:
            continue
        f, amplitude = spectrum(run, column)
        f, x = f[f <= HIGHEST], quantity(column).scale*amplitude[f <= HIGHEST]
        if not x.any():
            continue
        ax, unit, top = figure.add_subplot(grid[k]), quantity(column).unit, x.max()
        ax.plot(*thin(f, np.maximum(x, DECADES*top), PANEL), color=BLACK, linewidth=0.7)
        ax.set(yscale="log", ylim=(DECADES*top, 2*top), xlim=(0, HIGHEST), xlabel="frequency [Hz]", ylabel=f"{words} [{unit}]")
        powers_of_ten(ax.yaxis)
        for frequency in frequencies(run):
            ax.axvline(frequency, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
    if all(name in run.data for curve in RATIO.curves for name in curve.columns):
        draw_columns(grid[2], run, ((RATIO,),), window, alone=False)


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
    """Energies over time; L/V of both wheels with Nadal's limit, loads, forces and displacements over the lateral force."""
    placed = run_outlines(run)[0]
    angle = flange_angle(placed.left) if placed else np.nan
    window, energies = overall(run), ENERGY.of(run)
    limit = (f"Nadal's limit for the steepest angle of the flange, {DEG*angle:.1f}°, with friction "
             f"{' and '.join(f'{friction:g}' for friction in FRICTIONS)}" if placed else "")
    below = "; ".join(words for words in (window.title, limit) if words)
    figure = new_page(f"{run.heading}: energy and lateral force", run.header.title,
                      "\n".join(words for words in (constant_energies(run), below, caption(run)) if words))
    body = figure.add_gridspec(1, 2, width_ratios=(1, 2))
    if energies:
        draw_columns(body[0], run, energies.columns, window)
    grid = body[1].subgridspec(3, 2)
    places = grid[0, :], grid[1, 0], grid[1, 1], grid[2, 0], grid[2, 1]
    ratio, load, normal, lateral, roll = axes = [figure.add_subplot(place) for place in places]
    rows = window.rows(run)
    force = KN*run.values("F_ext")[rows]

    def draw(ax: Axes, x: np.ndarray, label: str, line: Line) -> None:
        draw_curve(ax, force, x[rows], label, line, window.band)

    for side, color in (("left", BLUE), ("right", RED)):
        draw(ratio, lateral_over_vertical(run, side), f"{side} wheel", Line(color))
        draw(load, KN*wheel_loads(run, side)[1], f"{side} wheel", Line(color))
    for friction in FRICTIONS if placed else ():
        level = nadal_limit(angle, friction)
        ratio.axhline(level, color=GREY, linewidth=0.9, linestyle="--" if friction else "-")
        ratio.annotate(f"Nadal, friction {friction:g}", (0.01, level), xycoords=("axes fraction", "data"), xytext=(0, 1.5),
                       textcoords="offset points", fontsize=6, color="#505050", va="bottom")
    ratio.margins(y=0.12)
    for contact in ("LT", "LF", "RT"):
        draw(normal, KN*run.values(f"N_{contact}"), CONTACT_NAMES[contact], CONTACT_LINES[contact])
    draw(lateral, MM*run.values("Y"), "", Line(BLACK))
    draw(roll, 1e3*run.values("roll"), "", Line(BLACK))
    for ax, words in zip(axes, ("L/V", "vertical load [kN]", "normal N [kN]", "lateral Y [mm]", "roll Φ [mrad]"), strict=True):
        ax.set(xlabel="" if ax in (load, normal) else "lateral force [kN]", ylabel=words)
        ax.locator_params(nbins=6)
        if len(ax.get_legend_handles_labels()[0]) > 1:
            legend_above(ax)
    return figure
