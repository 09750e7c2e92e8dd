"""Runs side by side: the free exercises with both pairs of profiles, and the first contact of the left flange of each."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from ..results.contact_intervals import ContactInterval
from ..results.derived import PARTS, Exchange, exchange
from ..results.quantities import KN, MM
from ..results.run_data import RunData
from .figures import free
from .frame import legend_above, legend_of_page, new_page
from .stretches import PANEL, thin
from .style import BLACK, BLUE, DASHED, GREEN, GREY, PURPLE, RED, SKY, Line, plain_numbers

PAIR_LINES = Line(BLACK), Line(RED, DASHED, 1.1)
NEEDED = {"Y", "vY", "N_LF", "N_RF", *PARTS}


def overview_figures(runs: Sequence[RunData]) -> Iterator[tuple[str, Figure]]:
    """The pages that compare runs of exercises 1 to 4, where there are several."""
    shown = [run for run in free(runs) if NEEDED.issubset(run.data)]
    if len(shown) < 2:
        return
    yield "exercises 1 to 4 side by side", side_by_side(shown)
    told = [(run, first, energies) for run in shown
            if (first := run.first_interval("LF")) and (energies := exchange(run, first.start, first.end))]
    if told:
        yield "first contact of the left flange", first_contacts(told)


def side_by_side(runs: Sequence[RunData]) -> Figure:
    """Lateral motion, flange forces, the first contact and the kinetic energy of exercises 1 to 4, an exercise to a row."""
    exercises = list(dict.fromkeys(run.exercise for run in runs))
    figure = new_page("Exercises 1 to 4 side by side", "", "first contact: the time counts from the first touch of the left "
                      "flange; force of flanges: the left one upwards, the right one downwards")
    axes = figure.subplots(len(exercises), 4, squeeze=False)
    for row, exercise in zip(axes, exercises, strict=True):
        for run, line in zip([run for run in runs if run.exercise == exercise], PAIR_LINES, strict=False):
            t, look = run.time, line.kwargs() | {"label": run.pair or run.name}
            row[0].plot(*thin(t, MM*run.values("Y"), PANEL), **look)
            row[1].plot(*thin(t, KN*run.values("N_LF"), PANEL), **look)
            row[1].plot(*thin(t, -KN*run.values("N_RF"), PANEL), **line.kwargs())
            if first := run.first_interval("LF"):
                rows = slice(*np.searchsorted(t, [first.start, first.end]) + [-1, 2])
                row[2].plot(1e3*(t[rows] - first.start), KN*run.values("N_LF")[rows], **look)
            row[3].plot(*thin(t, np.sum([run.values(part) for part in PARTS], axis=0), PANEL), **look)
        words = f"Exercise {exercise}: Y [mm]", "N of flanges [kN]", "N, first contact [kN]", "kinetic energy [J]"
        for ax, label in zip(row, words, strict=True):
            ax.set_ylabel(label)
            ax.locator_params(nbins=5)
    for ax, label in zip(axes[-1], ("time [s]", "time [s]", "time since the touch [ms]", "time [s]"), strict=True):
        ax.set_xlabel(label)
    figure.align_ylabels(axes)
    legend_of_page(figure, axes[0, 0].get_lines())
    return figure


def first_contacts(told: Sequence[tuple[RunData, ContactInterval, Exchange]]) -> Figure:
    """Where the energy goes in the first contact of the left flange; peak, duration, impulse and rebound over the velocity."""
    figure = new_page("First contact of the left flange in exercises 1 to 4", "", (
        "bars: kinetic energy at the end of the contact over that at its beginning; what is missing is elastic and potential "
        "energy. Dotted: powers 6/5, -1/5 and 1 of Hertz's impact of two bodies, through the slowest run with the first pair"))
    body = figure.add_gridspec(1, 2, width_ratios=(1.1, 1))
    draw_shares(figure.add_subplot(body[0]), [run.name for run, *_ in told], [energies for *_, energies in told])
    axes = body[1].subgridspec(2, 2).subplots()
    pairs = list(dict.fromkeys(run.pair for run, *_ in told))
    for pair, marker in zip(pairs, "os", strict=False):
        own = [(run, first) for run, first, _ in told if run.pair == pair]
        speed = np.array([run.values("vY")[0] for run, _ in own])
        rebound = [-np.interp(first.end, run.time, run.values("vY"))/run.values("vY")[0] for run, first in own]
        for ax, x, power in zip(axes.ravel(), (
                [KN*first.peak for _, first in own], [1e3*first.duration for _, first in own],
                [KN*first.impulse for _, first in own], rebound), (6/5, -1/5, 1, None), strict=True):
            ax.plot(speed, x, marker, color=BLACK, markersize=4.5, markerfacecolor=BLACK if marker == "o" else "white", label=pair)
            if power is not None and pair == pairs[0]:
                ax.plot(speed, x[0]*(speed/speed[0])**power, color=GREY, linewidth=0.8, linestyle=":",
                        label="Hertz" if ax is axes[0, 0] else None)
    for ax, words in zip(axes.ravel(), ("peak N [kN]", "duration [ms]", "impulse ∫N dt [kN·s]",
                                        "lateral velocity after / before, reversed"), strict=True):
        ax.set(xscale="log", xlabel="initial lateral velocity [m/s]", ylabel=words)
        ax.margins(0.12)
        plain_numbers(ax.xaxis)
        if ax is axes[1, 1]:
            ax.set_ylim(-0.1, 1)
        else:
            ax.set(yscale="log")
            plain_numbers(ax.yaxis)
            ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[0, 0].legend(loc="lower right", fontsize=6.5)
    return figure


def draw_shares(ax: Axes, names: Sequence[str], energies: Sequence[Exchange]) -> None:
    """Stacked bars of kinetic energies after an impact, in per cent of their sum before it."""
    left = np.zeros(len(names))
    total = np.array([sum(one.before.values()) for one in energies])
    for (part, words), color in zip(PARTS.items(), (BLUE, GREEN, PURPLE), strict=True):
        share = 100*np.array([one.after[part] for one in energies])/total
        ax.barh(range(len(names)), share, left=left, color=color, height=0.65, label=words)
        for k, (x, width) in enumerate(zip(left, share, strict=True)):
            if width > 6:
                ax.text(x + width/2, k, f"{width:.0f} %", ha="center", va="center", fontsize=6.5,
                        color="white" if color == BLUE else BLACK)
        left += share
    ax.barh(range(len(names)), 100 - left, left=left, color=SKY, height=0.65, alpha=0.4, label="elastic and potential")
    ax.set(xlim=(0, 100), yticks=range(len(names)), yticklabels=names)
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    legend_above(ax)
    ax.set_xlabel("share of the kinetic energy before the contact [%]")
