"""A run under a growing lateral force: its quantities over that force."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..geometry.outlines import flange_angle, run_outlines
from ..results.derived import lateral_over_vertical, nadal_limit, wheel_loads
from ..results.quantities import CONTACT_NAMES, DEG, KN, MM
from ..results.run_data import RunData
from .frame import caption, legend_above, new_page
from .series import ENERGY
from .stretches import overall
from .style import BLACK, BLUE, CONTACT_LINES, GREY, RED, Line
from .times import draw_columns, draw_curve

FRICTIONS = 0.0, 0.3        # for which Nadal's limit is drawn
NEEDED = {"F_ext", "Y", "roll", *(f"{what}_{contact}" for what in ("N", "Fy", "Fz") for contact in CONTACT_NAMES)}


def is_ramp(run: RunData) -> bool:
    """Whether the lateral force of a run grows or falls all the time."""
    if not NEEDED.issubset(run.data):
        return False
    change = np.diff(run.values("F_ext"))
    return bool(np.any(change)) and (bool(np.all(change >= 0)) or bool(np.all(change <= 0)))


def ramp_page(run: RunData) -> Figure:
    """Energies over time, and beside them L/V of both wheels with Nadal's limit, loads of wheels, largest forces and
    displacements over the lateral force."""
    placed = run_outlines(run)[0]
    angle = flange_angle(placed.left) if placed else np.nan
    window, energies = overall(run), ENERGY.of(run)
    limit = (f"Nadal's limit for the steepest angle of the flange, {DEG*angle:.1f}°, with friction "
             f"{' and '.join(f'{friction:g}' for friction in FRICTIONS)}" if placed else "")
    below = "; ".join(words for words in (window.title, limit) if words)
    figure = new_page(f"{run.heading}: energy and lateral force", run.header.title,
                      "\n".join(words for words in (ENERGY.words(run), below, caption(run)) if words))
    body = figure.add_gridspec(1, 2, width_ratios=(1, 2))
    if energies:
        draw_columns(body[0], run, energies.columns, window)
    grid = body[1].subgridspec(3, 2)
    places = grid[0, :], grid[1, 0], grid[1, 1], grid[2, 0], grid[2, 1]
    ratio, load, normal, lateral, roll = axes = [figure.add_subplot(place) for place in places]
    rows = window.rows(run)
    force = KN*run.values("F_ext")[rows]

    def draw(ax: Axes, x: np.ndarray, label: str, line: Line) -> None:
        draw_curve(ax, force, x[rows], label, line, window.band)

    for side, color in (("left", BLUE), ("right", RED)):
        draw(ratio, lateral_over_vertical(run, side), f"{side} wheel", Line(color))
        draw(load, KN*wheel_loads(run, side)[1], f"{side} wheel", Line(color))
    for friction in FRICTIONS if placed else ():
        level = nadal_limit(angle, friction)
        ratio.axhline(level, color=GREY, linewidth=0.9, linestyle="--" if friction else "-")
        ratio.annotate(f"Nadal, friction {friction:g}", (0.01, level), xycoords=("axes fraction", "data"), xytext=(0, 1.5),
                       textcoords="offset points", fontsize=6, color="#505050", va="bottom")
    ratio.margins(y=0.12)
    for contact in ("LT", "LF", "RT"):
        draw(normal, KN*run.values(f"N_{contact}"), CONTACT_NAMES[contact], CONTACT_LINES[contact])
    draw(lateral, MM*run.values("Y"), "", Line(BLACK))
    draw(roll, 1e3*run.values("roll"), "", Line(BLACK))
    for ax, words in zip(axes, ("L/V", "vertical load [kN]", "normal N [kN]", "lateral Y [mm]", "roll Φ [mrad]"), strict=True):
        ax.set(xlabel="" if ax in (load, normal) else "lateral force [kN]", ylabel=words)
        ax.locator_params(nbins=6)
        if len(ax.get_legend_handles_labels()[0]) > 1:
            legend_above(ax)
    return figure
