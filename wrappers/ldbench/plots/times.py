"""Quantities against time: a grid of panels, with the events of the run above it."""
from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .series import Page, Panel
from .stretches import PANEL, Window, band, overall, thin
from .style import GREY

EVENT_SIZE = 6.0            # of the words of events [pt]
LINE = 7.5                  # distance of lines of such words [pt]
PAGE_KEY = 4                # as many curves or fewer have one legend for the page
LEFT, RIGHT, TOP, BOTTOM = 0.058, 0.985, 0.878, 0.125


def time_page(run: RunData, page: Page, window: Window | None = None) -> Figure:
    """A page of panels against time, of the whole run unless a window is given."""
    window = window or overall(run)
    note = page.note(run) if callable(page.note) else page.note
    note = "; ".join(words for words in (note, window.title) if words)
    figure = new_page(f"{run.heading}: {page.title}", run.header.title, f"{note}\n{caption(run)}".strip())
    axes = figure.subplots(max(map(len, page.columns)), len(page.columns), sharex=True, squeeze=False, gridspec_kw={
        "left": LEFT, "right": RIGHT, "top": TOP, "bottom": BOTTOM, "hspace": 0.1, "wspace": 0.06 + 0.06*len(page.columns)})
    draw_columns(axes, run, page.columns, window)
    return figure


def draw_columns(axes: np.ndarray, run: RunData, columns: Sequence[Sequence[Panel]], window: Window, alone: bool = True) -> None:
    """Panels in columns of axes. `alone`: the panels fill the page, so the events of the run are marked above them, and one
    legend is for all of them where they share a few curves."""
    lines = {curve.label: curve.line for column in columns for panel in column if len(panel.curves) > 1 for curve in panel.curves}
    together = alone and 0 < len(lines) <= PAGE_KEY
    width = axes[0, 0].get_position().width*axes[0, 0].figure.get_figwidth()*72
    room = mark_events(axes, run, window, width) if alone else 0
    for column, shown in zip(axes.T, columns, strict=True):
        for k, ax in enumerate(column):
            if k >= len(shown):
                ax.set_visible(False)
                continue
            draw_panel(ax, run, shown[k], window)
            label_y(ax, shown[k].words, left=38 if alone else 31)
            if not together and len(shown[k].curves) > 1:
                ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=5, borderaxespad=0.1 + (k == 0)*room*LINE/7,
                          columnspacing=0.7, handlelength=1.4, handletextpad=0.3, fontsize=6.3)
        label_x(column[len(shown) - 1], "time [ms]" if window.milliseconds else "time [s]")
        column[len(shown) - 1].tick_params(labelbottom=True)
    start, end = (window.scale*(x - window.zero) for x in (window.start, window.end))
    axes[0, 0].set_xlim(start, end)
    axes[0, 0].xaxis.get_major_locator().set_params(nbins=6)
    if together:
        handles: dict[str, object] = {}
        for ax in axes.ravel():
            handles |= {line.get_label(): line for line in ax.get_lines() if line.get_label() in lines}
        axes[0, 0].figure.legend(handles.values(), handles.keys(), loc="upper right", bbox_to_anchor=(RIGHT, 0.943), ncols=4,
                                 borderaxespad=0)


def draw_panel(ax: Axes, run: RunData, panel: Panel, window: Window) -> None:
    """One quantity in one window."""
    rows = window.rows(run)
    t = window.scale*(run.time[rows] - window.zero)
    drawn = [(curve, panel.scale*curve.values(run)[rows]) for curve in panel.curves]
    for curve, x in drawn:
        style = curve.line.kwargs()
        if window.band:
            centre, low, high, x = band(t, x)
            ax.fill_between(centre, low, high, color=curve.line.color, alpha=0.35, linewidth=0)
            ax.plot(centre, x, label=curve.label, **style)
        else:
            marker = {"marker": ".", "markersize": 2.5} if len(t) < 60 else {}
            ax.plot(*thin(t, x, PANEL), label=curve.label, **style, **marker)
    if all(np.isnan(x).all() for _, x in drawn):
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])
    else:
        widen_flat(ax)
        ax.yaxis.get_major_locator().set_params(nbins=5)


def widen_flat(ax: Axes) -> None:
    """Axis limits for a constant: matplotlib would show its rounding."""
    low, high = ax.get_ylim()
    middle = (low + high)/2
    if high - low < 1e-9*max(abs(middle), 1e-3):
        half = max(0.05*abs(middle), 0.1)
        ax.set_ylim(middle - half, middle + half)


def key_events(run: RunData) -> list[tuple[float, str]]:
    """The events to mark on the whole run."""
    found = []
    for contact, label in (("LF", "left flange"), ("RF", "right flange")):
        t = run.first_contact(contact)
        if t is not None:
            found.append((t, label))
    found += [(passage, "centre") for passage in run.passages()[:1]]
    derailment = run.first("derailment")
    if derailment:
        found.append((derailment.t, "derailment"))
    return sorted(found)


def mark_events(axes: np.ndarray, run: RunData, window: Window, width: float) -> int:
    """Mark events by dotted lines, with their words above the topmost axes, `width` points wide; the number of lines that
    the words take. Events at one place share a line, and words that would overlap go one line up."""
    shown = [(t, label) for t, label in key_events(run) if window.start <= t <= window.end]
    place = {t: (t - window.start)/(window.end - window.start)*width for t, _ in shown}
    ends: list[float] = []
    for t, group in groupby(shown, key=lambda event: event[0]):
        words = ", ".join(label for _, label in group)
        half = 0.27*EVENT_SIZE*len(words) + 1
        middle = min(max(place[t], half), width - half)
        line = next((k for k, end in enumerate(ends) if middle - half > end + 2), len(ends))
        ends[line:line + 1] = [middle + half]
        x = window.scale*(t - window.zero)
        for ax in axes.ravel():
            ax.axvline(x, color=GREY, linewidth=0.6, linestyle=":", zorder=1)
        for ax in axes[0]:
            ax.annotate(words, (middle/width, 1.0), xycoords="axes fraction", xytext=(0, 1.5 + LINE*line), va="bottom",
                        textcoords="offset points", ha="center", fontsize=EVENT_SIZE, color="#505050", annotation_clip=False)
    return len(ends)
