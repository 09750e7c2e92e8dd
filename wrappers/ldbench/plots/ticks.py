"""Grid, ticks and numbers of linear axes as a few artists, where matplotlib has five for every tick: the same picture in
two thirds of the time."""
from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.transforms import ScaledTranslation

ORDER = 0.5         # of an axis below what is drawn
OFFSET_PAD = 3.0    # between axes and the power of ten above them [pt], as matplotlib has it


def simplify_ticks(figure: Figure) -> None:
    """Replace the ticks of a finished figure; what is not plain linear stays as it is."""
    for ax in figure.axes:
        if not (ax.get_visible() and ax.axison):
            continue
        # The other axis has its limits from its data, which go before what is added here.
        limits = ax.get_xlim(), ax.get_ylim()
        for axis in ax.xaxis, ax.yaxis:
            if is_plain(axis):
                replace_ticks(ax, axis)
        ax.set(xlim=limits[0], ylim=limits[1])


def is_plain(axis: Axis) -> bool:
    far_side = "top" if axis.axis_name == "x" else "right"
    params = axis.get_tick_params()
    return (axis.get_visible() and axis.get_scale() == "linear" and not len(axis.get_minorticklocs())
            and not params.get(far_side) and not params.get(f"label{far_side}"))


def replace_ticks(ax: Axes, axis: Axis) -> None:
    along = 0 if axis is ax.xaxis else 1        # place of the coordinate that the axis measures
    low, high = sorted(axis.get_view_interval())
    places = np.asarray(axis.get_majorticklocs())
    places = places[(places >= low - 1e-10*(high - low)) & (places <= high + 1e-10*(high - low))]
    formatter = axis.get_major_formatter()
    words = formatter.format_ticks(places)
    power = formatter.get_offset()
    if power and along == 0:                    # below the numbers: needs their heights
        return
    params = axis.get_tick_params()
    transform = ax.get_xaxis_transform() if along == 0 else ax.get_yaxis_transform()
    rc = matplotlib.rcParams
    if params.get("gridOn"):
        ends = np.zeros((len(places), 2, 2))
        ends[:, :, along] = places[:, None]
        ends[:, 1, 1 - along] = 1.0
        ax.add_collection(LineCollection(ends, transform=transform, colors=rc["grid.color"],
                                         linewidths=rc["grid.linewidth"], zorder=ORDER), autolim=False)
    size, pad = (rc[f"{'xy'[along]}tick.major.{what}"] for what in ("size", "pad"))
    at = np.zeros((2, len(places)))
    at[along] = places
    ax.add_artist(Line2D(*at, transform=transform, linestyle="none", marker=(TICKDOWN, TICKLEFT)[along], markersize=size,
                         markeredgewidth=rc["xtick.major.width"], color=rc["xtick.color"], clip_on=False, zorder=ORDER))
    if params.get("labelbottom" if along == 0 else "labelleft"):
        place = ax.get_xaxis_text1_transform if along == 0 else ax.get_yaxis_text1_transform
        where, va, ha = place(size + pad)
        font = params.get("labelsize", rc[f"{'xy'[along]}tick.labelsize"])
        for (x, y), word in zip(at.T, words, strict=True):
            ax.text(x, y, word, transform=where, va=va, ha=ha, fontsize=font, zorder=ORDER)
        if power:
            above = ax.transAxes + ScaledTranslation(0, OFFSET_PAD/72, ax.figure.dpi_scale_trans)
            ax.text(0.0, 1.0, power, transform=above, va="baseline", ha="left", fontsize=font, zorder=ORDER)
    label = axis.label
    if label.get_text() and label.get_visible():
        ax.text(*label.get_position(), label.get_text(), transform=label.get_transform(), va=label.get_va(),
                ha=label.get_ha(), rotation=label.get_rotation(), rotation_mode=label.get_rotation_mode(),
                fontsize=label.get_fontsize(), color=label.get_color(), zorder=ORDER)
    axis.set_visible(False)
