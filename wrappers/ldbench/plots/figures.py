"""Figures of the abstract, of the size at which they are printed [in]: no letter gets smaller."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from ..results.quantities import CONTACT_NAMES, KN, MM, PAIRS
from ..results.run_data import RunData
from .impact import draw_detail, instants, placed_outlines
from .series import ELASTIC, KINETIC
from .stretches import first_impact
from .style import BLACK, CONTACT_LINES, DASHED, DOTTED, GREY, SERIES, plain_numbers


def by_pair(runs: Sequence[RunData]) -> dict[str, list[RunData]]:
    """Runs by pair of profiles, 'aw' and 'sw'; a pair without runs is left out."""
    return {pair: own for pair in PAIRS if (own := [run for run in runs if run.name.endswith(f"_{pair}")])}


def free(runs: Sequence[RunData]) -> list[RunData]:
    """Exercises 1 to 4."""
    return [run for run in runs if run.exercise in range(1, 5)]


def motion_figure(runs: Sequence[RunData]) -> Figure:
    """Lateral displacement of exercises 1 to 4 against the distance that the first velocity would cover."""
    pairs = by_pair(free(runs))
    figure = Figure(figsize=(5.2, 1.6), layout="constrained")
    axes = figure.subplots(1, len(pairs), squeeze=False)[0]
    for ax, own in zip(axes, pairs.values(), strict=True):
        for run, line in zip(own, SERIES, strict=False):
            speed = run.values("vY")[0]
            ax.plot(MM*speed*run.time, MM*run.values("Y"), label=f"{speed:g} m/s", **line.kwargs())
        ax.set_title(own[0].pair, loc="left")
        ax.set_xlabel("initial velocity × time [mm]")
    axes[0].set_ylabel("Y [mm]")
    axes[0].legend(loc="upper right", fontsize=6.5, ncols=2, columnspacing=1.0)
    return figure


def impact_figure(runs: Sequence[RunData]) -> Figure:
    """First contact of the left flange: normal force against time, its peak against velocity."""
    figure = Figure(figsize=(5.2, 1.7), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.2, 1])
    for pair, own in by_pair(free(runs)).items():
        actual, speeds, peaks = pair == "aw", [], []
        for run, line in zip(own, SERIES, strict=False):
            if (first := run.first_interval("LF")) is None:
                continue
            speeds.append(run.values("vY")[0])
            peaks.append(KN*first.peak)
            rows = slice(*np.searchsorted(run.time, [first.start, first.end]) + [0, 1])
            left.plot(1e3*(run.time[rows] - first.start), KN*run.values("N_LF")[rows], color=line.color, linewidth=0.9,
                      linestyle="-" if actual else DASHED, label=f"{speeds[-1]:g} m/s" if actual else None)
        right.plot(speeds, peaks, "o" if actual else "s", color=BLACK, markersize=4, label=own[0].pair,
                   markerfacecolor=BLACK if actual else "white")
        if actual and speeds:
            v = np.array([min(speeds), max(speeds)])
            right.plot(v, peaks[0]*(v/speeds[0])**1.2, color=GREY, linewidth=0.8, linestyle=DOTTED, label="slope 6/5")
    left.set(yscale="log", ylim=(10, None), xlabel="time since the flange touched [ms]", ylabel="N of the left flange [kN]")
    left.set_title("solid: actual, dashed: simplified profiles", loc="left")
    left.legend(loc="upper right", fontsize=6.5)
    right.set(xscale="log", yscale="log", xlabel="lateral velocity [m/s]", ylabel="first peak [kN]")
    right.margins(0.08)
    right.legend(loc="lower right", fontsize=6.5)
    for axis in (left.yaxis, right.yaxis, right.xaxis):
        plain_numbers(axis)
    return figure


SHARES = 5, 95              # percentiles at the edges of a band
STEPS = 130                 # intervals of the lateral force


def derailment_figure(runs: Sequence[RunData]) -> Figure | None:
    """Exercise 5: vertical forces until the last second over the lateral force, a panel per pair: means and percentiles."""
    ramps = by_pair([run for run in runs if run.exercise == 5 and run.time[-1] > 2]).values()
    if not ramps:
        return None
    figure = Figure(figsize=(6.1, 1.85), layout="constrained")
    axes = figure.subplots(1, len(ramps), sharey=True, squeeze=False)[0]
    for ax, own in zip(axes, ramps, strict=True):
        for run in own:
            rows = run.time < run.time[-1] - 1
            for contact in ("LF", "LT", "RT"):
                force, mean, low, high = percentiles(KN*run.values("F_ext")[rows], KN*run.values(f"Fz_{contact}")[rows])
                line = CONTACT_LINES[contact]
                ax.fill_between(force, low, high, color=line.color, alpha=0.22, linewidth=0)
                ax.plot(force, mean, label=CONTACT_NAMES[contact], **line.kwargs())
        ax.set_title(own[0].pair, loc="left")
        ax.set_xlabel("lateral force [kN]")
    axes[0].set_ylabel("vertical force [kN]")
    axes[0].legend(loc="upper left", fontsize=6.5)
    return figure


def percentiles(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Means of x and y in equal intervals of x, and percentiles of y in each."""
    edges = np.searchsorted(x, np.linspace(x[0], x[-1], STEPS + 1)[1:-1])
    parts = [(part, at) for part, at in zip(np.split(y, edges), np.split(x, edges), strict=True) if part.size]
    found = np.array([(at.mean(), part.mean(), *np.percentile(part, SHARES)) for part, at in parts])
    return tuple(found.T)


def first_shown(runs: Sequence[RunData]) -> RunData | None:
    """The run whose first flange contact the abstract shows: exercise 2, or the first with such a contact."""
    touched = [run for run in free(runs) if first_impact(run)]
    return next((run for run in touched if run.exercise == 2), touched[0] if touched else None)


def contact_figure(runs: Sequence[RunData]) -> Figure | None:
    """The first contact of the left flange: the cross-section at its peak for both pairs, and the energies through it."""
    shown = first_shown(runs)
    window = first_impact(shown) if shown else None
    if shown is None or window is None:
        return None
    chosen = [run for run in runs if run.exercise == shown.exercise and first_impact(run)][:2]
    placed = [(run, outlines) for run in chosen if (outlines := placed_outlines(run))]
    figure = Figure(figsize=(6.0, 1.75), layout="constrained")
    *sections, energies = figure.subplots(1, len(placed) + 1, squeeze=False)[0]
    for ax, (run, outlines) in zip(sections, placed, strict=True):
        draw_detail(ax, run, outlines, instants(run)[0][1], right=False)
        ax.set_title(f"{run.pair},\n{ax.get_title(loc='left').removeprefix('left: ')}", loc="left", fontsize=6.2)
        ax.set(xlim=(ax.get_xlim()[0] - 8, ax.get_xlim()[1] + 8), ylim=(-36, 36))
    rows = window.rows(shown)
    for curve in (*KINETIC.curves, *ELASTIC):
        energies.plot(1e3*shown.time[rows], curve.values(shown)[rows], label=curve.label, **curve.line.kwargs())
    energies.set(xlim=(1e3*window.start, 1e3*window.end), xlabel=window.axis)
    energies.legend(loc="upper right", fontsize=6, handlelength=1.6)
    energies.set_title(f"energies, {shown.pair} [J]", loc="left", fontsize=6.2)
    energies.tick_params(labelsize=6)
    return figure
