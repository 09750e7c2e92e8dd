"""Cross-sections: wheels on rails with contact points and forces."""
from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ..profiles.outlines import Outlines, pose, run_outlines, turned
from ..results.quantities import CONTACT_NAMES, CONTACTS, DEG, KN, MM
from ..results.run_data import RunData
from .frame import caption, label_x, new_page
from .stretches import first_episode
from .style import BLACK, CONTACT_LINES


def instants(run: RunData) -> list[tuple[str, int]]:
    """Rows worth a picture: peak of the first contact of each flange, or the hardest, and the end."""
    found = []
    for contact in ("LF", "RF"):
        episode = first_episode(run, contact)
        if episode:
            rows = slice(*np.searchsorted(run.time, episode) + [0, 1])
            k = rows.start + int(np.argmax(run.values(f"N_{contact}")[rows]))
            found.append((f"first contact of the {CONTACT_NAMES[contact]}, at its peak", k))
    if first_episode(run, "RF") is None and found:
        found.append(("hardest contact of the left flange", int(np.argmax(run.values("N_LF")))))
    found.append(("end", len(run.time) - 1))
    return found


def section_page(run: RunData) -> Figure | None:
    """Wheels on rails with contact points and forces: left rail, whole wheelset, right rail."""
    needed = {"Y", "Z", "roll", *(f"{what}_{c}" for what in ("N", "Fy", "Fz", "y", "z", "angle") for c in CONTACTS)}
    placed = run_outlines(run)[0] if needed.issubset(run.data) else None
    if placed is None:
        return None
    chosen = instants(run)
    figure = new_page(f"{run.heading}: cross-sections", run.header.title,
                      "seen in the direction of travel, left is left; arrows: force of the rail on the wheel, "
                      f"the longest of a picture is 40 mm\n{caption(run)}")
    axes = figure.subplots(3, 3, squeeze=False, gridspec_kw={
        "left": 0.045, "right": 0.985, "top": 0.885, "bottom": 0.125, "hspace": 0.38, "wspace": 0.12,
        "width_ratios": [1, 1.05, 1]})
    for ax in axes[len(chosen):].ravel():
        ax.set_visible(False)
    for (label, k), (left, whole, right) in zip(chosen, axes, strict=False):
        draw_detail(left, run, placed, k, right=False)
        draw_wheelset(whole, run, placed, k)
        draw_detail(right, run, placed, k, right=True)
        left.set_title(f"t = {run.time[k]:.4f} s: {label}", loc="left", color="#404040")
    return figure


RAIL_GREY, WHEEL_GREY = "#D0D0D0", "#F2F2F2"


def draw_detail(ax: Axes, run: RunData, placed: Outlines, k: int, right: bool) -> None:
    """One rail head with its wheel, contact points and force arrows at row k."""
    side, sign = placed.sides[right]
    wheel, rail = turned(side.wheel*[sign, 1], *pose(run, k)), side.rail*[sign, 1]
    ax.add_artist(Polygon(MM*rail, facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.7))
    ax.plot(MM*wheel[:, 0], MM*wheel[:, 1], color=BLACK, linewidth=0.9)
    contacts = ("RT", "RF") if right else ("LT", "LF")
    longest = max(run.values(f"N_{c}")[k] for c in CONTACTS) or 1.0
    words = []
    for c in contacts:
        N = run.values(f"N_{c}")[k]
        if N <= 0:
            continue
        x, z = MM*run.values(f"y_{c}")[k], MM*run.values(f"z_{c}")[k]
        arrow = 40/longest*np.array([run.values(f"Fy_{c}")[k], run.values(f"Fz_{c}")[k]])
        color = CONTACT_LINES[c].color
        ax.quiver([x], [z], [arrow[0]], [arrow[1]], angles="xy", scale_units="xy", scale=1, color=color, width=0.008,
                  zorder=4)
        ax.plot([x], [z], "o", color=color, markersize=3.5, markeredgecolor=BLACK, markeredgewidth=0.4, zorder=5)
        words.append(f"{CONTACT_NAMES[c]}: {KN*N:.1f} kN at {DEG*run.values(f'angle_{c}')[k]:.1f}°")
    ax.text(0.02 if not right else 0.98, 0.96, "\n".join(words) or "no contact", transform=ax.transAxes, va="top",
            ha="left" if not right else "right", fontsize=6.5)
    middle = -755 if right else 755
    ax.set(xlim=(middle + 92, middle - 92), ylim=(-44, 62))
    ax.set_aspect("equal")
    ax.tick_params(labelsize=6)
    label_x(ax, "y [mm]")


def draw_wheelset(ax: Axes, run: RunData, placed: Outlines, k: int) -> None:
    """The whole wheelset on its rails at row k; axle and wheel bodies are sketched."""
    y, z, roll = pose(run, k)
    for side, sign in placed.sides:
        rail = side.rail*[sign, 1]
        foot = np.array([[rail[-1, 0], -0.12], [rail[0, 0], -0.12]])
        ax.add_artist(Polygon(np.vstack([rail, foot]), facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.5))
        body = np.vstack([side.wheel, side.wheel[::-1]*[1, -1]])*[sign, 1]
        ax.add_artist(Polygon(turned(body, y, z, roll), facecolor=WHEEL_GREY, edgecolor=BLACK, linewidth=0.6))
    half = placed.left.wheel[:, 0].min()
    axle = np.array([[-half, -0.08], [half, -0.08], [half, 0.08], [-half, 0.08]])
    ax.add_artist(Polygon(turned(axle, y, z, roll), facecolor=WHEEL_GREY, edgecolor=BLACK, linewidth=0.6))
    ax.plot([y], [z], "+", color=BLACK, markersize=6, markeredgewidth=0.8)
    ax.set(xlim=(1.15, -1.15), ylim=(-0.14, 1.42))
    ax.set_aspect("equal")
    ax.tick_params(labelsize=6)
    ax.grid(False)
    ax.text(0.5, 0.97, f"Y {MM*y:.2f} mm, Z {MM*(z - run.result('axle_height')):.2f} mm, Φ {1e3*roll:.2f} mrad",
            transform=ax.transAxes, ha="center", va="top", fontsize=6.5,
            bbox={"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.5})
    label_x(ax, "y [m]")
