"""Runs side by side: pages of exercises 1 to 4, and the figures of the abstract.

Those of the abstract have the size at which they are printed [in]: no letter gets smaller.
"""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from ..constants import CONTACT_NAMES, KN, MM
from ..results.contact_intervals import ContactInterval
from ..results.derived import KINETIC_PARTS, Exchange, exchange
from ..results.quantities import PAIRS
from ..results.run_data import RunData
from .frame import legend_above, legend_of_page, new_page
from .impact import draw_detail, instants, placed_outlines
from .named import named_bars, shows
from .series import ELASTIC, KINETIC
from .stretches import PANEL, first_contact, thin
from .style import BLACK, BLUE, CONTACT_LINES, DASHED, DOTTED, GREEN, GREY, PURPLE, RED, SERIES, SKY, Line, plain_numbers

PAIR_LINES = Line(BLACK), Line(RED, DASHED, 1.1)
NEEDED = {"Y", "vY", "N_LF", "N_RF", *KINETIC_PARTS}


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
            curve, = ax.plot(MM*speed*run.time, MM*run.values("Y"), label=f"{speed:g} m/s", **line.kwargs())
            shows(curve, "Y [mm]", "time × first vY [mm]", of=run.name)
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
            curve, = left.plot(1e3*(run.time[rows] - first.start), KN*run.values("N_LF")[rows], color=line.color, linewidth=0.9,
                      linestyle="-" if actual else DASHED, label=f"{speeds[-1]:g} m/s" if actual else None)
            shows(curve, "N_LF [kN]", "time since LF [ms]", of=run.name)
        dots, = right.plot(speeds, peaks, "o" if actual else "s", color=BLACK, markersize=4, label=own[0].pair,
                   markerfacecolor=BLACK if actual else "white")
        shows(dots, "first peak of N_LF [kN]", "first vY [m/s]", "runs", pair)
        if actual and speeds:
            v = np.array([min(speeds), max(speeds)])
            slope, = right.plot(v, peaks[0]*(v/speeds[0])**1.2, color=GREY, linewidth=0.8, linestyle=DOTTED, label="slope 6/5")
            shows(slope, "first peak of N_LF [kN]", "first vY [m/s]", "power", pair)
    left.set(yscale="log", ylim=(10, None), xlabel="time since the flange touched [ms]", ylabel="N of the left flange [kN]")
    left.set_title("solid: actual, dashed: simplified profiles", loc="left")
    left.legend(loc="upper right", fontsize=6.5)
    right.set(xscale="log", yscale="log", xlabel="lateral velocity [m/s]", ylabel="first peak [kN]")
    right.margins(0.08)
    right.set_ylim(top=8*right.get_ylim()[1])       # room for the legend above the points
    right.legend(loc="upper left", fontsize=6.5)
    for axis in (left.yaxis, right.yaxis, right.xaxis):
        plain_numbers(axis)
    return figure


SHARES = 5, 95              # percentiles at the edges of a band
# Lines that are told apart without their colours.
RAMP_LINES = {"LF": CONTACT_LINES["LF"], "LT": CONTACT_LINES["LT"], "RT": replace(CONTACT_LINES["RT"], dashes=DOTTED, width=1.3)}
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
            for contact, line in RAMP_LINES.items():
                force, mean, low, high = percentiles(KN*run.values("F_ext")[rows], KN*run.values(f"Fz_{contact}")[rows])
                names = f"Fz_{contact} [kN]", "F_ext [kN]"
                shows(ax.fill_between(force, low, high, color=line.color, alpha=0.22, linewidth=0), *names, "percentiles", run.name)
                curve, = ax.plot(force, mean, label=CONTACT_NAMES[contact], **line.kwargs())
                shows(curve, *names, "mean of steps", run.name)
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
    touched = [run for run in free(runs) if first_contact(run, "LF")]
    return next((run for run in touched if run.exercise == 2), touched[0] if touched else None)


def contact_figure(runs: Sequence[RunData]) -> Figure | None:
    """The first contact of the left flange: the cross-section at its peak for both pairs, and the energies through it."""
    shown = first_shown(runs)
    window = first_contact(shown, "LF") if shown else None
    if shown is None or window is None:
        return None
    chosen = [run for run in runs if run.exercise == shown.exercise and first_contact(run, "LF")][:2]
    placed = [(run, outlines) for run in chosen if (outlines := placed_outlines(run))]
    figure = Figure(figsize=(6.6, 1.75), layout="constrained")
    *sections, energies = figure.subplots(1, len(placed) + 1, squeeze=False)[0]
    for ax, (run, outlines) in zip(sections, placed, strict=True):
        draw_detail(ax, run, outlines, instants(run)[0][1], right=False)
        ax.set_title(f"{run.pair},\n{ax.get_title(loc='left').removeprefix('left: ')}", loc="left", fontsize=6.2)
        ax.set(xlim=(ax.get_xlim()[0] - 8, ax.get_xlim()[1] + 8), ylim=(-36, 36))
    rows = window.rows(shown)
    for curve in (*KINETIC, *ELASTIC):
        drawn, = energies.plot(window.of(shown.time[rows]), curve.values(shown)[rows], label=curve.label, **curve.line.kwargs())
        shows(drawn, f"{curve.name} [J]", window.clock, of=shown.name)
    energies.set(xlim=window.of(np.array([window.start, window.end])), xlabel=window.axis)
    energies.legend(loc="center left", bbox_to_anchor=(1, 0.5), fontsize=6, handlelength=1.6)
    energies.set_title(f"energies, {shown.pair} [J]", loc="left", fontsize=6.2)
    energies.tick_params(labelsize=6)
    return figure


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
            kinetic = np.sum([run.values(part) for part in KINETIC_PARTS], axis=0)
            for ax, x, shown in ((row[0], MM*run.values("Y"), "Y [mm]"), (row[1], KN*run.values("N_LF"), "N_LF [kN]"),
                                 (row[1], -KN*run.values("N_RF"), "-N_RF [kN]"),
                                 (row[3], kinetic, f"{'+'.join(KINETIC_PARTS)} [J]")):
                curve, = ax.plot(*thin(t, x, PANEL), **look)
                shows(curve, shown, "time [s]", of=run.name)
            if first := run.first_interval("LF"):
                rows = slice(*np.searchsorted(t, [first.start, first.end]) + [-1, 2])
                curve, = row[2].plot(1e3*(t[rows] - first.start), KN*run.values("N_LF")[rows], **look)
                shows(curve, "N_LF [kN]", "time since LF [ms]", of=run.name)
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
        for ax, (x, shown), power in zip(axes.ravel(), (
                ([KN*first.peak for _, first in own], "first peak of N_LF [kN]"),
                ([1e3*first.duration for _, first in own], "first duration of N_LF [ms]"),
                ([KN*first.impulse for _, first in own], "first impulse of N_LF [kN·s]"), (rebound, "rebound of N_LF")),
                (6/5, -1/5, 1, None), strict=True):
            dots, = ax.plot(speed, x, marker, color=BLACK, markersize=4.5, label=pair,
                            markerfacecolor=BLACK if marker == "o" else "white")
            shows(dots, shown, "first vY [m/s]", "runs", pair)
            if power is not None and pair == pairs[0]:
                slope, = ax.plot(speed, x[0]*(speed/speed[0])**power, color=GREY, linewidth=0.8, linestyle=":",
                        label="Hertz" if ax is axes[0, 0] else None)
                shows(slope, shown, "first vY [m/s]", "power", pair)
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
    for (part, words), color in zip(KINETIC_PARTS.items(), (BLUE, GREEN, PURPLE), strict=True):
        share = 100*np.array([one.after[part] for one in energies])/total
        bars = ax.barh(range(len(names)), share, left=left, color=color, height=0.65, label=words)
        named_bars(bars, names, x=f"share of {part} [%]")
        for k, (x, width) in enumerate(zip(left, share, strict=True)):
            if width > 6:
                ax.text(x + width/2, k, f"{width:.0f} %", ha="center", va="center", fontsize=6.5,
                        color="white" if color == BLUE else BLACK)
        left += share
    rest = ax.barh(range(len(names)), 100 - left, left=left, color=SKY, height=0.65, alpha=0.4, label="elastic and potential")
    named_bars(rest, names, x="share of the rest [%]")
    ax.set(xlim=(0, 100), yticks=range(len(names)), yticklabels=names)
    ax.invert_yaxis()
    ax.grid(visible=False, axis="y")
    legend_above(ax)
    ax.set_xlabel("share of the kinetic energy before the contact [%]")
