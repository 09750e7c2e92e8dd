"""Numbers, marks and grid lines of the axes of a finished page, drawn with one tick for all.

Matplotlib makes an object for each tick, each of three lines and two texts, and measures all numbers to find a place for the
label of the axis. That takes half of the time of a page. On our pages labels have fixed places, see `frame`.
"""
from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakSet

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.backend_bases import RendererBase
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import NullLocator

PAD = 3.0               # between the numbers of an axis and its power of ten [pt]
ZORDER = 0.5            # below the curves, as that of an axis with `axes.axisbelow`
INSIDE = 1e-9           # share of the range of an axis by which a tick may lie outside

placed: WeakSet[Text] = WeakSet()       # labels that stay where they are


class Numbers(Artist):        # type: ignore[misc]      # matplotlib has no types
    """What an axis shows, its label too."""

    def __init__(self, axis: Axis) -> None:
        super().__init__()
        self.axis = axis
        self.set_zorder(ZORDER)

    def draw(self, renderer: RendererBase) -> None:
        """Draw grid lines, marks, numbers, the label, and the power of ten."""
        axis = self.axis
        major = axis.get_majorticklocs()
        if not isinstance(axis.get_major_locator(), NullLocator):
            draw_ticks(axis, axis.get_major_ticks(1)[0], major, axis.get_major_formatter().format_ticks(major), renderer)
        if not isinstance(axis.get_minor_locator(), NullLocator):
            minor = axis.get_minorticklocs()
            draw_ticks(axis, axis.get_minor_ticks(1)[0], minor, axis.get_minor_formatter().format_ticks(minor), renderer)
        axis.label.draw(renderer)
        if power := axis.get_major_formatter().get_offset():
            words, box, dot = axis.get_offset_text(), axis.axes.bbox, renderer.points_to_pixels(1.0)
            tick = axis.get_major_ticks(1)[0]
            below = tick.get_pad() + tick.get_tick_padding() + tick.label1.get_size() + PAD
            x, _ = words.get_position()
            words.set(text=power, position=(x, box.ymax + PAD*dot if axis.axis_name == "y" else box.ymin - below*dot))
            words.draw(renderer)


def draw_ticks(axis: Axis, tick: Tick, places: Sequence[float], numbers: Sequence[str], renderer: RendererBase) -> None:
    """Draw one tick at all places inside the range of an axis: all grid lines at once, all marks at once, number by number."""
    transform = axis.get_transform().transform
    at = transform(np.asarray(places, float))
    low, high = sorted(transform(np.asarray(axis.get_view_interval())))
    spare = INSIDE*(high - low)
    inside = [k for k, t in enumerate(at) if low - spare <= t <= high + spare]
    if not inside:
        return
    x = np.array([places[k] for k in inside])
    across = axis.axis_name == "x"
    if tick.gridline.get_visible():
        along, over = np.repeat(x, 3), np.tile([0.0, 1.0, np.nan], len(x))
        tick.gridline.set_data(*((along, over) if across else (over, along)))
        tick.gridline.draw(renderer)
    for marks, end in (tick.tick1line, 0.0), (tick.tick2line, 1.0):
        if marks.get_visible():
            marks.set_data(*((x, np.full(len(x), end)) if across else (np.full(len(x), end), x)))
            marks.draw(renderer)
    for label in (tick.label1, tick.label2):
        for k, place in zip(inside, x, strict=True) if label.get_visible() else ():
            (label.set_x if across else label.set_y)(place)
            label.set_text(numbers[k])
            label.draw(renderer)


def settle(figure: Figure) -> None:
    """Let the axes of a finished figure be drawn so, but those with a label that is not placed."""
    for ax in figure.axes:
        if ax.axison and ax.get_visible():
            settle_axes(ax)


def settle_axes(ax: Axes) -> None:
    """`settle` for one of the axes."""
    for axis in (ax.xaxis, ax.yaxis):
        if axis.get_visible() and (not axis.get_label_text() or axis.label in placed):
            ax.add_artist(Numbers(axis))
            axis.set_visible(False)
