"""Contact geometry: functions of the lateral displacement."""
from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from ..results.quantities import DEG, MM
from ..results.run_data import RunData
from .frame import caption, legend_above, new_page
from .style import BLACK, CONTACT_LINES, GREY, Line, plain_numbers

if TYPE_CHECKING:
    import pandas as pd

SIDES = {"_L": "left", "_R": "right"}
Shape = tuple[RunData, "pd.DataFrame"]      # a run, and the geometry functions of its profiles


def geometry_page(run: RunData, functions: pd.DataFrame) -> Figure:
    """The geometry functions of the profiles of a run, as `ContactTable.geometry` and the file of `&output geometry_file` have
    them."""
    y = MM*functions["Y"]
    figure = new_page(f"Contact geometry, {run.pair or run.name}", "rigid wheelset standing on both rails",
                      f"dotted: rigid-axle clearance, {clearance_words(run)} mm; conicity: equivalent, by "
                      f"harmonic linearisation, for the amplitude |Y|\n{caption(run).splitlines()[-1]}")
    axes = figure.subplots(2, 4)
    left, right, black = CONTACT_LINES["LT"], CONTACT_LINES["RT"], Line(BLACK)
    for ax, (label, scale, curves) in zip(axes.ravel(), (
            ("contact angle [°]", DEG, (("angle_L", left), ("angle_R", right))),
            ("rolling radius [mm]", MM, (("radius_L", left), ("radius_R", right))),
            ("Δr = left − right [mm]", MM, (("delta_r", black),)), ("equivalent conicity", 1.0, (("conicity", black),)),
            ("contact position, outward |y| [mm]", MM, (("y_L", left), ("y_R", right))),
            ("contact position z [mm]", MM, (("z_L", left), ("z_R", right))),
            ("roll Φ [mrad]", 1e3, (("roll", black),)), ("height Z [mm]", MM, (("Z", black),))), strict=True):
        for column, line in curves:
            ax.plot(y, (-scale if column == "y_R" else scale)*functions[column], label=SIDES.get(column[-2:]), **line.kwargs())
        ax.set(xlabel="lateral displacement Y [mm]", ylabel=label)
        if len(curves) > 1:
            legend_above(ax)
        for reach in (-run.result("clearance_right"), run.result("clearance_left")):
            ax.axvline(MM*reach, color=GREY, linewidth=0.6, linestyle=":")
    conicity = axes[0, 3]
    conicity.set_yscale("log")
    conicity.set_ylim(bottom=0.02)
    conicity.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    plain_numbers(conicity.yaxis)
    return figure


def clearance_words(run: RunData) -> str:
    """'2 × 10.18', or of either side [mm]."""
    if run.result("clearance_left") == run.result("clearance_right"):
        return f"2 × {MM*run.result('clearance_left'):.2f}"
    return f"left {MM*run.result('clearance_left'):.2f}, right {MM*run.result('clearance_right'):.2f}"
