"""Contact geometry: functions of the lateral displacement."""
from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullLocator

from ..results.quantities import DEG, MM
from ..results.run_data import RunData, read_data
from .frame import caption, label_x, label_y, new_page
from .style import BLACK, CONTACT_LINES, GREY


def geometry_page(path: Path) -> Figure:
    """The geometry functions of a pair, from the file that `&output geometry_file` asks for."""
    run = read_data(path)
    y = MM*run.values("Y")
    figure = new_page(f"Contact geometry, {run.pair or run.name}", "rigid wheelset standing on both rails",
                      f"dotted: rigid-axle clearance, {clearance_words(run)} mm; conicity: equivalent, by "
                      f"harmonic linearisation, for the amplitude |Y|\n{caption(run).splitlines()[-1]}")
    axes = figure.subplots(2, 4, gridspec_kw={
        "left": 0.062, "right": 0.985, "top": 0.885, "bottom": 0.125, "hspace": 0.28, "wspace": 0.4})
    left, right = CONTACT_LINES["LT"], CONTACT_LINES["RT"]

    def both(ax: Axes, quantity: str, label: str, scale: float, sign: float = 1.0) -> None:
        ax.plot(y, scale*run.values(f"{quantity}_L"), label="left", **left.kwargs())
        ax.plot(y, sign*scale*run.values(f"{quantity}_R"), label="right", **right.kwargs())
        label_y(ax, label)
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)

    def one(ax: Axes, column: str, label: str, scale: float) -> None:
        ax.plot(y, scale*run.values(column), color=BLACK, linewidth=0.9)
        label_y(ax, label)

    both(axes[0, 0], "angle", "contact angle [°]", DEG)
    both(axes[0, 1], "radius", "rolling radius [mm]", MM)
    one(axes[0, 2], "delta_r", "Δr = left − right [mm]", MM)
    one(axes[0, 3], "conicity", "equivalent conicity", 1.0)
    axes[0, 3].set_yscale("log")
    axes[0, 3].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[0, 3].set_ylim(bottom=0.02)
    axes[0, 3].yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes[0, 3].yaxis.set_minor_locator(NullLocator())
    both(axes[1, 0], "y", "contact position, outward |y| [mm]", MM, -1.0)
    both(axes[1, 1], "z", "contact position z [mm]", MM)
    one(axes[1, 2], "roll", "roll Φ [mrad]", 1e3)
    one(axes[1, 3], "Z", "height Z [mm]", MM)
    for ax in axes.ravel():
        label_x(ax, "lateral displacement Y [mm]")
        for reach in (-run.result("clearance_right"), run.result("clearance_left")):
            ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
    return figure


def clearance_words(run: RunData) -> str:
    """'2 × 10.18', or of either side [mm]."""
    if run.result("clearance_left") == run.result("clearance_right"):
        return f"2 × {MM*run.result('clearance_left'):.2f}"
    return f"left {MM*run.result('clearance_left'):.2f}, right {MM*run.result('clearance_right'):.2f}"
