"""Figures of the abstract."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, NullFormatter

from ..results.quantities import CONTACT_NAMES, KN, MM, PAIRS
from ..results.run_data import RunData
from .frame import label_x, label_y
from .sections import draw_detail, instants, placed_outlines
from .series import ELASTIC, KINETIC
from .stretches import first_impact
from .style import BLACK, BLUE, DASHED, DOTTED, GREY, RED, SERIES


def small_figure(width: float = 6.7, height: float = 2.0) -> Figure:
    """Make an empty figure of the width of a text column [in]."""
    return Figure(figsize=(width, height))


def by_pair(runs: Sequence[RunData]) -> dict[str, list[RunData]]:
    """Runs by pair of profiles, 'aw' and 'sw'."""
    return {pair: [run for run in runs if run.name.endswith(f"_{pair}")] for pair in PAIRS}


def pair_words(pair: str, own: Sequence[RunData]) -> str:
    """The profiles of a pair's runs in words."""
    return own[0].pair or PAIRS[pair] if own else PAIRS[pair]


def motion_figure(runs: Sequence[RunData]) -> Figure:
    """Lateral displacement of exercises 1 to 4 against the distance that the first velocity would cover."""
    figure = small_figure()
    axes = figure.subplots(1, 2, gridspec_kw={"left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.22, "wspace": 0.2})
    for ax, (pair, own) in zip(axes, by_pair(runs).items(), strict=True):
        for run, line in zip([r for r in own if r.exercise in range(1, 5)], SERIES, strict=False):
            speed = run.values("vY")[0]
            ax.plot(MM*speed*run.time, MM*run.values("Y"), label=f"{speed:g} m/s", **line.kwargs())
        ax.set_title(pair_words(pair, own), loc="left", fontsize=8)
        label_x(ax, "initial velocity × time [mm]")
    label_y(axes[0], "Y [mm]", left=30)
    if drawn := [ax for ax in axes if ax.lines]:        # a report of one pair has one panel of runs
        drawn[-1].legend(loc="upper right", fontsize=6.5)
    return figure


def impact_figure(runs: Sequence[RunData]) -> Figure:
    """First contact of the left flange: normal force against time, its peak against velocity."""
    figure = small_figure()
    left, right = figure.subplots(1, 2, gridspec_kw={
        "left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.22, "wspace": 0.25, "width_ratios": [1.5, 1]})
    for (pair, own), dashes, marker in zip(by_pair(runs).items(), ("-", DASHED), "os", strict=True):
        speeds, peaks = [], []
        for run, line in zip([r for r in own if r.exercise in range(1, 5)], SERIES, strict=False):
            first = run.first_interval("LF")
            if first is None:
                continue
            rows = slice(*np.searchsorted(run.time, [first.start, first.end]) + [0, 1])
            t, N = 1e3*(run.time[rows] - first.start), KN*run.values("N_LF")[rows]
            left.plot(t, N, color=line.color, linestyle=dashes, linewidth=0.9,
                      label=f"{run.values('vY')[0]:g} m/s" if dashes == "-" else None)
            speeds.append(run.values("vY")[0])
            peaks.append(KN*first.peak)
        right.plot(speeds, peaks, marker, color=BLACK, markersize=4, label=pair_words(pair, own),
                   markerfacecolor=BLACK if marker == "o" else "white")
        if pair == "aw" and speeds:
            v = np.array([min(speeds), max(speeds)])
            right.plot(v, peaks[0]*(v/speeds[0])**1.2, color=GREY, linewidth=0.8, linestyle=DOTTED, label="slope 6/5")
    left.set(yscale="log", ylim=(10, None))
    left.set_title("solid: actual, dashed: simplified profiles", loc="left", fontsize=8)
    left.legend(loc="upper right", fontsize=6.5)
    right.set(xscale="log", yscale="log")
    right.margins(0.08)
    right.legend(loc="lower right", fontsize=6.5)
    label_x(left, "time since the flange touched [ms]")
    label_y(left, "N of the left flange [kN]", left=30)
    label_x(right, "lateral velocity [m/s]")
    label_y(right, "first peak [kN]", left=30)
    for axis in (left.yaxis, right.yaxis, right.xaxis):
        axis.set_major_formatter(FormatStrFormatter("%g"))
        axis.set_minor_formatter(NullFormatter())
    return figure


SHARES = 5, 95              # percentiles at the edges of a band
STEPS = 130                 # intervals of the lateral force


def derailment_figure(runs: Sequence[RunData]) -> Figure | None:
    """Exercise 5: vertical forces until the last second over the lateral force, a panel per contact: means and percentiles."""
    ramps = {pair: [run for run in own if run.exercise == 5 and run.time[-1] > 2] for pair, own in by_pair(runs).items()}
    if not any(ramps.values()):
        return None
    figure = small_figure(height=1.75)
    axes = figure.subplots(1, 3, sharey=True, gridspec_kw={
        "left": 0.075, "right": 0.985, "top": 0.89, "bottom": 0.23, "wspace": 0.08})
    for ax, contact in zip(axes, ("LF", "LT", "RT"), strict=True):
        for (pair, own), color, dashes in zip(ramps.items(), (BLUE, RED), ("-", DASHED), strict=True):
            for run in own:
                rows = run.time < run.time[-1] - 1
                force, mean, low, high = percentiles(KN*run.values("F_ext")[rows], KN*run.values(f"Fz_{contact}")[rows])
                ax.fill_between(force, low, high, color=color, alpha=0.22, linewidth=0)
                ax.plot(force, mean, color=color, linestyle=dashes, linewidth=1.0, label=pair_words(pair, own))
        ax.set_title(CONTACT_NAMES[contact], loc="left", fontsize=8)
        label_x(ax, "lateral force [kN]")
    label_y(axes[0], "vertical force [kN]", left=28)
    axes[1].legend(loc="upper right", fontsize=6.5)
    return figure


def percentiles(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, ...]:
    """Means of x and y in equal intervals of x, and percentiles of y in each."""
    edges = np.searchsorted(x, np.linspace(x[0], x[-1], STEPS + 1)[1:-1])
    parts = [(part, at) for part, at in zip(np.split(y, edges), np.split(x, edges), strict=True) if part.size]
    found = np.array([(at.mean(), part.mean(), *np.percentile(part, SHARES)) for part, at in parts])
    return tuple(found.T)


def first_shown(runs: Sequence[RunData]) -> RunData | None:
    """The run whose first flange contact the abstract shows: exercise 2, or the first with such a contact."""
    touched = [run for run in runs if run.exercise in range(1, 5) and first_impact(run)]
    return next((run for run in touched if run.exercise == 2), touched[0] if touched else None)


def contact_figure(runs: Sequence[RunData]) -> Figure | None:
    """The first contact of the left flange: the cross-section at its peak for both pairs, and the energies through it."""
    shown = first_shown(runs)
    if shown is None:
        return None
    chosen = [run for run in runs if run.exercise == shown.exercise and first_impact(run)][:2]
    placed = [(run, outlines) for run in chosen if (outlines := placed_outlines(run))]
    window = first_impact(shown)
    assert window is not None
    figure = small_figure(height=1.9)
    axes = figure.subplots(1, len(placed) + 1, squeeze=False, gridspec_kw={
        "left": 0.05, "right": 0.99, "top": 0.88, "bottom": 0.22, "wspace": 0.25})[0]
    for ax, (run, outlines) in zip(axes, placed, strict=False):
        draw_detail(ax, run, outlines, instants(run)[0][1], right=False)
        ax.set_title(f"{run.pair}: {ax.get_title(loc='left').removeprefix('left wheel: ')}", loc="left", fontsize=6.2)
        ax.set_xlim(ax.get_xlim()[0] - 8, ax.get_xlim()[1] + 8)
        ax.set_ylim(-36, 36)
    rows = window.rows(shown)
    for curve in (*KINETIC.curves, *ELASTIC):
        axes[-1].plot(1e3*shown.time[rows], curve.values(shown)[rows], label=curve.label, **curve.line.kwargs())
    axes[-1].set_xlim(1e3*window.start, 1e3*window.end)
    axes[-1].legend(loc="upper right", fontsize=5.5, handlelength=1.6)
    axes[-1].set_title(f"energies, {shown.pair} [J]", loc="left", fontsize=6.2)
    axes[-1].tick_params(labelsize=6)
    label_x(axes[-1], "time [ms]", below=18.5)
    return figure
