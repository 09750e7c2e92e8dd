"""Figures of the abstract."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, NullFormatter

from ..results.quantities import CONTACT_NAMES, KN, MM, PAIRS
from ..results.run_data import RunData
from .frame import label_x, label_y
from .stretches import BINS, band, first_episode
from .style import BLACK, CONTACT_LINES, DASHED, DOTTED, GREY, SERIES


def small_figure(width: float = 6.7, height: float = 2.4) -> Figure:
    """Make an empty figure of the width of a text column [in]."""
    return Figure(figsize=(width, height))


def by_pair(runs: Sequence[RunData]) -> dict[str, list[RunData]]:
    """Runs by pair of profiles, 'aw' and 'sw'."""
    return {pair: [run for run in runs if run.name.endswith(f"_{pair}")] for pair in PAIRS}


def motion_figure(runs: Sequence[RunData]) -> Figure:
    """Lateral displacement of exercises 1 to 4 against the distance that the first velocity would cover."""
    figure = small_figure()
    axes = figure.subplots(1, 2, gridspec_kw={"left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.2, "wspace": 0.2})
    for ax, (pair, own) in zip(axes, by_pair(runs).items(), strict=True):
        for run, line in zip([r for r in own if r.exercise in range(1, 5)], SERIES, strict=False):
            speed = run.values("vY")[0]
            ax.plot(MM*speed*run.time, MM*run.values("Y"), label=f"{speed:g} m/s", **line.kwargs())
        ax.set_title(PAIRS[pair], loc="left", fontsize=8)
        label_x(ax, "initial velocity × time [mm]")
    label_y(axes[0], "Y [mm]", left=30)
    axes[1].legend(loc="upper right", fontsize=6.5)
    return figure


def impact_figure(runs: Sequence[RunData]) -> Figure:
    """First contact of the left flange: normal force against time, its peak against velocity."""
    figure = small_figure()
    left, right = figure.subplots(1, 2, gridspec_kw={
        "left": 0.085, "right": 0.99, "top": 0.9, "bottom": 0.2, "wspace": 0.25, "width_ratios": [1.5, 1]})
    for (pair, own), dashes, marker in zip(by_pair(runs).items(), ("-", DASHED), "os", strict=True):
        speeds, peaks = [], []
        for run, line in zip([r for r in own if r.exercise in range(1, 5)], SERIES, strict=False):
            episode = first_episode(run, "LF")
            if episode is None:
                continue
            rows = slice(*np.searchsorted(run.time, episode) + [0, 1])
            t, N = 1e3*(run.time[rows] - episode[0]), KN*run.values("N_LF")[rows]
            left.plot(t, N, color=line.color, linestyle=dashes, linewidth=0.9,
                      label=f"{run.values('vY')[0]:g} m/s" if dashes == "-" else None)
            speeds.append(run.values("vY")[0])
            peaks.append(N.max())
        right.plot(speeds, peaks, marker, color=BLACK, markersize=4, label=PAIRS[pair],
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


def derailment_figure(runs: Sequence[RunData]) -> Figure | None:
    """Exercise 5: vertical forces until the last second, band and mean, against the lateral force."""
    if not any(run.exercise == 5 and run.time[-1] > 2 for run in runs):
        return None
    figure = small_figure()
    axes = figure.subplots(1, 2, sharey=True, gridspec_kw={
        "left": 0.085, "right": 0.985, "top": 0.9, "bottom": 0.2, "wspace": 0.08})
    for ax, (pair, own) in zip(axes, by_pair(runs).items(), strict=True):
        for run in (r for r in own if r.exercise == 5 and r.time[-1] > 2):
            rows = run.time < run.time[-1] - 1
            force = KN*run.values("F_ext")[rows]
            for contact in ("LF", "LT", "RT"):
                x, low, high, mean = band(force, KN*run.values(f"Fz_{contact}")[rows], BINS//2)
                line = CONTACT_LINES[contact]
                ax.fill_between(x, low, high, color=line.color, alpha=0.25, linewidth=0)
                ax.plot(x, mean, label=CONTACT_NAMES[contact], **line.kwargs())
        ax.set_title(PAIRS[pair], loc="left", fontsize=8)
        label_x(ax, "lateral force [kN]")
    label_y(axes[0], "vertical force [kN]", left=30)
    drawn = next(ax for ax in axes[::-1] if ax.get_lines())
    drawn.legend(loc="upper center", ncols=3, fontsize=6.5)
    return figure
