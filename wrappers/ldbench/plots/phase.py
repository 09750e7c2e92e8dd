"""Energies, phase portraits and spectra of a free run."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..results.derived import spectrum
from ..results.quantities import CONTACT_NAMES, MM, quantity
from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .series import ENERGY, RATIO
from .stretches import PANEL, Window, is_long, last_second, overall, thin
from .style import BLACK, CONTACT_LINES, GREEN, GREY, PURPLE
from .times import BOTTOM, LEFT, RIGHT, TOP, draw_columns

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
    notes = [str(ENERGY.note(run)) if callable(ENERGY.note) else ENERGY.note, window.title]
    found = [run.result(f"frequency_{k}") for k in (1, 2, 3)]
    if np.isfinite(found).any():
        notes.append(f"dotted in spectra: eigenfrequencies at rest, {', '.join(f'{f:.4g}' for f in found if np.isfinite(f))} Hz")
    figure = new_page(f"{run.heading}: energy, phase portrait, spectrum", run.header.title,
                      f"{'; '.join(note for note in notes if note)}\n{caption(run)}")
    if energies is not None:
        draw_energies(figure, run, 0.33)
    if portraits:
        axes = figure.subplots(3, 1, squeeze=False, gridspec_kw={
            "left": 0.425, "right": 0.68, "top": TOP, "bottom": BOTTOM, "hspace": 0.3})[:, 0]
        draw_portraits(axes, run, last_second(run) if is_long(run) else window)
    draw_spectra(figure, run, window)
    return figure


def draw_energies(figure: Figure, run: RunData, right: float) -> None:
    """The energies in a column from the left edge of a page to `right`."""
    energies = ENERGY.of(run)
    assert energies is not None
    axes = figure.subplots(len(energies.panels), 1, sharex=True, squeeze=False, gridspec_kw={
        "left": LEFT, "right": right, "top": TOP, "bottom": BOTTOM, "hspace": 0.2})
    draw_columns(axes, run, energies.columns, overall(run))


def draw_portraits(axes: np.ndarray, run: RunData, window: Window) -> None:
    """Velocity over displacement of the three degrees of freedom."""
    t, rows = run.time, window.rows(run)
    for ax, (q, v, x_label, y_label, x_scale, y_scale) in zip(axes, PHASES, strict=True):
        x, y = x_scale*run.values(q)[rows], y_scale*run.values(v)[rows]
        ax.plot(x, y, color=BLACK, linewidth=0.6)
        if rows.start == 0:
            ax.plot(x[:1], y[:1], "o", color=GREEN, markersize=4.5, label="start", linestyle="none")
        for contact, marker in (("LF", "<"), ("RF", ">")):
            first = run.first_contact(contact)
            if first is not None and t[rows][0] <= first <= t[rows][-1]:
                k = np.searchsorted(t[rows], first)
                ax.plot(x[k:k + 1], y[k:k + 1], marker, color=CONTACT_LINES[contact].color, markersize=5.5,
                        markeredgecolor=BLACK, markeredgewidth=0.4, linestyle="none",
                        label=f"{CONTACT_NAMES[contact]} touches")
        ax.plot(x[-1:], y[-1:], "s", color=PURPLE, markersize=4.5, label="end of the run", linestyle="none")
        ax.margins(0.04)
        ax.xaxis.get_major_locator().set_params(nbins=6)
        ax.yaxis.get_major_locator().set_params(nbins=5)
        label_x(ax, x_label)
        label_y(ax, y_label, left=30)
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4, borderaxespad=0.1, columnspacing=0.8, handletextpad=0.1,
                   handlelength=1.2)


def draw_spectra(figure: Figure, run: RunData, window: Window) -> None:
    """Amplitude spectra of Z and roll, and L/V."""
    axes = figure.subplots(3, 1, gridspec_kw={"left": 0.745, "right": RIGHT, "top": TOP, "bottom": BOTTOM, "hspace": 0.3})
    for ax, column, words in zip(axes, ("Z", "roll"), ("amplitude of Z", "amplitude of Φ"), strict=False):
        f, amplitude = spectrum(run, column) if column in run.data else (np.empty(0), np.empty(0))
        shown = f <= HIGHEST
        if not shown.any() or not amplitude.any():
            ax.set_visible(False)
            continue
        scale, unit = quantity(column).scale, quantity(column).unit
        top = scale*amplitude[shown].max()
        ax.plot(*thin(f[shown], np.maximum(scale*amplitude[shown], DECADES*top), PANEL), color=BLACK, linewidth=0.7)
        ax.set(yscale="log", ylim=(DECADES*top, 2*top), xlim=(0, HIGHEST))
        mark_frequencies(ax, run)
        label_x(ax, "frequency [Hz]")
        label_y(ax, f"{words} [{unit}]", left=34)
    if all(name in run.data for curve in RATIO.curves for name in curve.columns):
        draw_columns(axes[2:, None], run, ((RATIO,),), window, alone=False)
    else:
        axes[2].set_visible(False)


def mark_frequencies(ax: Axes, run: RunData) -> None:
    """Dotted lines at the eigenfrequencies at rest."""
    for k in (1, 2, 3):
        f = run.result(f"frequency_{k}")
        if np.isfinite(f) and f <= HIGHEST:
            ax.axvline(f, color=GREY, linewidth=0.8, linestyle=":", zorder=1)
