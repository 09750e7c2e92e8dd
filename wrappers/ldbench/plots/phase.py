"""Energies, phase portraits and spectra of a free run."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec

from ..results.derived import spectrum
from ..results.quantities import CONTACT_NAMES, MM, quantity
from ..results.run_data import RunData
from .frame import caption, legend_above, new_page
from .series import ENERGY, RATIO
from .stretches import PANEL, Window, is_long, last_second, overall, thin
from .style import BLACK, CONTACT_LINES, GREEN, GREY, PURPLE, powers_of_ten
from .times import draw_columns

PHASES = (("Y", "vY", "Y [mm]", "dY/dt [m/s]", MM, 1.0), ("Z", "vZ", "Z [mm]", "dZ/dt [m/s]", MM, 1.0),
          ("roll", "roll_rate", "Φ [mrad]", "dΦ/dt [mrad/s]", 1e3, 1e3))
HIGHEST = 500.0         # frequency of the spectra [Hz]
DECADES = 1e-5          # smallest amplitude of a spectrum that is drawn, over the largest one


def energy_page(run: RunData) -> Figure | None:
    """Energies over time, velocity over displacement, spectra with the eigenfrequencies at rest, and L/V; None without
    energies and without velocities."""
    energies, window = ENERGY.of(run), overall(run)
    portraits = all({phase[0], phase[1]}.issubset(run.data) for phase in PHASES)
    if energies is None and not portraits:
        return None
    notes = ["; ".join(words for words in (ENERGY.words(run), window.title) if words)]
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
    t, rows = run.time, window.rows(run)
    for ax, (q, v, x_label, y_label, x_scale, y_scale) in zip(axes, PHASES, strict=True):
        x, y = x_scale*run.values(q)[rows], y_scale*run.values(v)[rows]
        ax.plot(x, y, color=BLACK, linewidth=0.6)
        look = {"linestyle": "none", "markersize": 4.5}
        if rows.start == 0:
            ax.plot(x[:1], y[:1], "o", color=GREEN, label="start", **look)
        for contact, marker in (("LF", "<"), ("RF", ">")):
            first = run.first_contact(contact)
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
        f, amplitude = spectrum(run, column) if column in run.data else (np.empty(0), np.empty(0))
        shown = f <= HIGHEST
        if not shown.any() or not amplitude.any():
            continue
        ax = figure.add_subplot(grid[k])
        scale, unit = quantity(column).scale, quantity(column).unit
        top = scale*amplitude[shown].max()
        ax.plot(*thin(f[shown], np.maximum(scale*amplitude[shown], DECADES*top), PANEL), color=BLACK, linewidth=0.7)
        ax.set(yscale="log", ylim=(DECADES*top, 2*top), xlim=(0, HIGHEST), xlabel="frequency [Hz]", ylabel=f"{words} [{unit}]")
        powers_of_ten(ax.yaxis)
        for frequency in frequencies(run):
            ax.axvline(frequency, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
    if all(name in run.data for curve in RATIO.curves for name in curve.columns):
        draw_columns(grid[2], run, ((RATIO,),), window, alone=False)


def frequencies(run: RunData) -> list[float]:
    """The eigenfrequencies at rest that are known [Hz]."""
    return [f for k in (1, 2, 3) if np.isfinite(f := run.result(f"frequency_{k}"))]
