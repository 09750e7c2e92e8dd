"""Quantities against time; one column of panels per stretch of time."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .series import Page, Panel
from .stretches import Window, band, thin, windows
from .style import GREY


def time_page(run: RunData, page: Page) -> Figure:
    """A page of panels against time; one column of panels per window."""
    figure = new_page(f"{run.heading}: {page.title}", run.header.title,
                      f"{page.note(run) if callable(page.note) else page.note}\n{caption(run)}".strip())
    shown = windows(run)
    widths = {1: [1], 2: [1.7, 1], 3: [1.5, 1, 1]}[len(shown)]
    axes = figure.subplots(len(page.panels), len(shown), sharex="col", squeeze=False, gridspec_kw={
        "width_ratios": widths, "left": 0.07, "right": 0.985, "top": 0.885, "bottom": 0.125,
        "hspace": 0.16 + 0.04*len(page.panels), "wspace": 0.1 + 0.05*len(shown)})
    for i, panel in enumerate(page.panels):
        for j, window in enumerate(shown):
            draw_panel(axes[i, j], run, panel, window, legend=j == 0)
            if j == 0:
                label_y(axes[i, 0], f"{panel.label} [{panel.unit}]")
                mark_events(axes[i, 0], run, window, labels=i == 0)
                for zoom in shown[1:2]:
                    axes[i, 0].axvspan(zoom.start, zoom.end, color="#E6E6E6", linewidth=0, zorder=0)
    for window, top, bottom in zip(shown, axes[0], axes[-1], strict=True):
        above_legend = len(page.panels[0].curves) > 1
        top.set_title(window.title, loc="left", fontsize=8, color="#404040", pad=12 if above_legend else 4)
        label_x(bottom, "time [ms]" if window.milliseconds else "time [s]")
        bottom.set_xlim(window.start*window.scale, window.end*window.scale)
    return figure


def draw_panel(ax: Axes, run: RunData, panel: Panel, window: Window, legend: bool = True) -> None:
    """One quantity in one window."""
    rows = window.rows(run)
    t = window.scale*run.time[rows]
    drawn = [(curve, panel.scale*curve.values(run)[rows]) for curve in panel.curves]
    for curve, x in drawn:
        style = curve.line.kwargs()
        if window.band:
            centre, low, high, x = band(t, x)
            ax.fill_between(centre, low, high, color=curve.line.color, alpha=0.35, linewidth=0)
            ax.plot(centre, x, label=curve.label, **style)
        else:
            marker = {"marker": ".", "markersize": 2.5} if len(t) < 60 else {}
            ax.plot(*thin(t, x), label=curve.label, **style, **marker)
    if legend and len(panel.curves) > 1:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, columnspacing=1.2)
    if all(np.isnan(x).all() for _, x in drawn):
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])
    else:
        widen_flat(ax)
        ax.yaxis.get_major_locator().set_params(nbins=6)
    ax.xaxis.get_major_locator().set_params(nbins=6)


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


def mark_events(ax: Axes, run: RunData, window: Window, labels: bool) -> None:
    """Mark events on the time axis by dotted lines."""
    last = -np.inf
    for t, label in key_events(run):
        if not window.start <= t <= window.end:
            continue
        ax.axvline(window.scale*t, color=GREY, linewidth=0.6, linestyle=":", zorder=1)
        apart = (t - last)/(window.end - window.start)
        if labels and apart > 0.02:
            ax.annotate(label, (window.scale*t, 0.97), xycoords=("data", "axes fraction"), xytext=(-1, 0),
                        textcoords="offset points", rotation=90, ha="right", va="top", fontsize=5.5, color="#505050",
                        bbox={"facecolor": "white", "alpha": 0.7, "linewidth": 0, "pad": 0.5})
            last = t
