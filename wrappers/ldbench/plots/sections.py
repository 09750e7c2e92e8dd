"""Cross-sections: wheels on rails with contact points and forces."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from ..geometry.outlines import Outlines, Side, pose, run_outlines, turned
from ..results.contact_intervals import is_closed
from ..results.quantities import CONTACT_NAMES, CONTACTS, DEG, KN, MM, significant
from ..results.run_data import RunData
from .style import BLACK, CONTACT_LINES

RAIL_GREY = "#D0D0D0"
ARROW = 40.0            # length of the longest arrow [mm]
AROUND = 44.0, 44.0, 46.0   # beside the rail's head, below the top of rail and above it [mm]
HEAD = 0.04             # height of the rail below its top that makes its head [m]
NEEDED = {"Y", "Z", "roll", *(f"{what}_{c}" for what in ("N", "Fy", "Fz", "y", "z", "angle") for c in CONTACTS)}


def placed_outlines(run: RunData) -> Outlines | None:
    """The outlines of a run that has what a picture needs."""
    return run_outlines(run)[0] if NEEDED.issubset(run.data) else None


def instants(run: RunData) -> list[tuple[str, int]]:
    """Rows worth a picture: the peak of the first contact of each flange, or the hardest contact of the left one."""
    found = [(f"first contact of the {CONTACT_NAMES[contact]}, at its peak", one.top) for contact in ("LF", "RF")
             if (one := run.first_interval(contact))]
    if found and not run.first_interval("RF"):
        found.append(("hardest contact of the left flange", int(np.argmax(run.values("N_LF")))))
    return found or [("end of the run", len(run.time) - 1)]


def close_up(side: Side, sign: int) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of the picture of a rail's head, y from left to right and z [mm]."""
    head = MM*side.rail[side.rail[:, 1] > side.rail[:, 1].max() - HEAD, 0]
    beside, below, above = AROUND
    ends = sign*(head.min() - beside), sign*(head.max() + beside)
    return (max(ends), min(ends)), (-below, above)


def draw_detail(ax: Axes, run: RunData, placed: Outlines, k: int, right: bool) -> None:
    """One rail head with its wheel, contact points and force arrows at row k; the forces stand in the title."""
    side, sign = placed.sides[right]
    wheel, rail = turned(side.wheel*[sign, 1], *pose(run, k)), side.rail*[sign, 1]
    ax.add_artist(Polygon(MM*rail, facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.7))
    ax.plot(MM*wheel[:, 0], MM*wheel[:, 1], color=BLACK, linewidth=0.9)
    contacts = ("RT", "RF") if right else ("LT", "LF")
    longest = max(run.values(f"N_{c}")[k] for c in CONTACTS) or 1.0
    words = []
    for c in contacts:
        N = run.values(f"N_{c}")[k]
        if not is_closed(N):
            continue
        x, z = MM*run.values(f"y_{c}")[k], MM*run.values(f"z_{c}")[k]
        arrow = ARROW/longest*np.array([run.values(f"Fy_{c}")[k], run.values(f"Fz_{c}")[k]])
        color = CONTACT_LINES[c].color
        ax.quiver([x], [z], [arrow[0]], [arrow[1]], angles="xy", scale_units="xy", scale=1, color=color, width=0.010, zorder=4)
        ax.plot([x], [z], "o", color=color, markersize=3.5, markeredgecolor=BLACK, markeredgewidth=0.4, zorder=5)
        words.append(f"{CONTACT_NAMES[c].split()[1]} {significant(KN*N)} kN at {DEG*run.values(f'angle_{c}')[k]:.1f}°")
    title = ax.set_title(f"{'right' if right else 'left'}: {', '.join(words) or 'no contact'}", loc="left", fontsize=6.2, pad=3)
    title.set_in_layout(False)
    y, z = close_up(side, sign)
    ax.set(xlim=y, ylim=z)
    ax.set_aspect("equal", anchor="NW")
    ax.tick_params(labelsize=6)
    ax.set_xlabel("y [mm]")
