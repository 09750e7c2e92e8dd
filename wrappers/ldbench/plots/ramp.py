"""A run under a growing lateral force: its quantities over that force."""
from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..geometry.outlines import flange_angle, run_outlines
from ..results.derived import lateral_over_vertical, nadal_limit, wheel_loads
from ..results.quantities import CONTACT_NAMES, DEG, KN, MM
from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .phase import draw_energies
from .series import ENERGY
from .stretches import BINS, band, overall
from .style import BLACK, BLUE, CONTACT_LINES, GREY, RED, Line
from .times import BOTTOM, RIGHT, TOP

FRICTIONS = 0.0, 0.3        # for which Nadal's limit is drawn
NEEDED = {"F_ext", "Y", "roll", *(f"{what}_{contact}" for what in ("N", "Fy", "Fz") for contact in CONTACT_NAMES)}


def is_ramp(run: RunData) -> bool:
    """Whether the lateral force of a run grows or falls all the time."""
    if not NEEDED.issubset(run.data):
        return False
    change = np.diff(run.values("F_ext"))
    return bool(np.any(change)) and (bool(np.all(change >= 0)) or bool(np.all(change <= 0)))


def ramp_page(run: RunData) -> Figure:
    """Energies over time, and beside them L/V of each wheel with Nadal's limit, loads of wheels, largest forces and
    displacements over the lateral force."""
    placed = run_outlines(run)[0]
    angle = flange_angle(placed.left) if placed else np.nan
    window = overall(run)
    limit = (f"Nadal's limit for the steepest angle of the flange, {DEG*angle:.1f}°, with friction "
             f"{' and '.join(f'{friction:g}' for friction in FRICTIONS)}" if placed else "")
    note = ENERGY.note(run) if callable(ENERGY.note) else ENERGY.note
    figure = new_page(f"{run.heading}: energy and lateral force", run.header.title, "; ".join(
        words for words in (note, window.title, limit) if words) + f"\n{caption(run)}")
    if ENERGY.of(run):
        draw_energies(figure, run, 0.33)
    axes = figure.subplots(3, 2, sharex=True, gridspec_kw={
        "left": 0.405, "right": RIGHT, "top": TOP, "bottom": BOTTOM, "hspace": 0.2, "wspace": 0.2})
    rows = window.rows(run)
    force = KN*run.values("F_ext")[rows]
    draw = partial(draw_band, force=force, banded=window.band)
    draw(axes[0, 0], lateral_over_vertical(run, "left")[rows], "left wheel", Line(BLUE))
    draw(axes[0, 1], lateral_over_vertical(run, "right")[rows], "right wheel", Line(RED))
    for ax, side in zip(axes[0], ("left", "right"), strict=True):
        for friction in FRICTIONS if placed else ():
            level = nadal_limit(angle, friction)
            ax.axhline(level, color=GREY, linewidth=0.9, linestyle="--" if friction else "-")
            ax.annotate(f"Nadal, friction {friction:g}", (0.01, level), xycoords=("axes fraction", "data"), xytext=(0, 1.5),
                        textcoords="offset points", fontsize=6, color="#505050", va="bottom")
        ax.margins(y=0.12)
        label_y(ax, f"L/V, {side} wheel", left=28)
    for side, color in (("left", BLUE), ("right", RED)):
        draw(axes[1, 0], KN*wheel_loads(run, side)[1][rows], f"{side} wheel", Line(color))
    label_y(axes[1, 0], "vertical load [kN]", left=28)
    for contact in ("LT", "LF", "RT"):
        draw(axes[1, 1], KN*run.values(f"N_{contact}")[rows], CONTACT_NAMES[contact], CONTACT_LINES[contact])
    label_y(axes[1, 1], "normal N [kN]", left=30)
    draw(axes[2, 0], MM*run.values("Y")[rows], "", Line(BLACK))
    label_y(axes[2, 0], "lateral Y [mm]", left=28)
    draw(axes[2, 1], 1e3*run.values("roll")[rows], "", Line(BLACK))
    label_y(axes[2, 1], "roll Φ [mrad]", left=30)
    for ax in axes.ravel():
        ax.yaxis.get_major_locator().set_params(nbins=6)
    for ax in axes[1]:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, columnspacing=1.0)
    for ax in axes[-1]:
        label_x(ax, "lateral force [kN]")
    return figure


def draw_band(ax: Axes, x: np.ndarray, label: str, line: Line, force: np.ndarray, banded: bool) -> None:
    """A quantity over the lateral force: smallest, largest and mean value of a long run."""
    if not banded:
        ax.plot(force, x, label=label, **line.kwargs())
        return
    centre, low, high, mean = band(force, x, BINS)
    ax.fill_between(centre, low, high, color=line.color, alpha=0.3, linewidth=0)
    ax.plot(centre, mean, label=label, **line.kwargs())
