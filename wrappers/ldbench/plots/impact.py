"""The page of impacts: cross-sections, the patch of the left flange in its first contact, and a table of impacts."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from ..constants import CONTACT_NAMES, CONTACTS, DEG, KN, MM
from ..geometry.outlines import Outlines, pose, run_outlines, turned
from ..geometry.pressures import patch_history
from ..number_text import number_text
from ..results.contact_intervals import ContactInterval, is_closed
from ..results.derived import KINETIC_PARTS, exchange
from ..results.events import FLANGE_ANGLE
from ..results.run_data import RunData
from .frame import caption, new_page
from .named import shows
from .series import CLOSE, draw_columns
from .stretches import Window, around
from .style import BLACK, CONTACT_LINES
from .tables import draw_table

MOST = 6            # impacts in the table
CLOSEUPS = "first contact of the left flange", "hardest contact of the left flange"
SECTIONS = 2        # instants with a picture
SOLVED = 9          # instants of the first contact at which its patch is solved
HEADS = ("impact", "begins at", "lasts", "peak N", "at angle", "impulse ∫N dt", "elastic, largest",
         "lateral KE", "vertical KE", "roll KE")
EDGES = 0.0, 0.09, 0.145, 0.21, 0.28, 0.345, 0.445, 0.55, 0.7, 0.85, 1.0      # of the table's columns
RAIL_GREY = "#D0D0D0"
ARROW = 40.0            # length of the longest arrow [mm]
AROUND, ABOVE = 44.0, 46.0  # what is drawn beside the rail's head and below the top of rail, and above it [mm]
HEAD = 0.04             # height of the rail below its top that makes its head [m]
NEEDED = {"Y", "Z", "roll", *(f"{what}_{c}" for what in ("N", "Fy", "Fz", "y", "z", "angle") for c in CONTACTS)}


@dataclass(frozen=True)
class Recomputed:
    """A part of a run that was computed again with more rows."""
    run: RunData            # whose time counts from `start`
    start: float            # [s]

    @property
    def words(self) -> str:
        """A note on the page."""
        return (f"computed again from the row at t = {self.start:.6f} s, with rows every "
                f"{1e6*self.run.case.interval:.3g} µs; black dots: rows of the run")


def impact_page(run: RunData) -> Figure | None:
    """Cross-sections at first impacts of flanges, the patch of the left flange over time, and the impacts of flanges in numbers;
    None where a run has none of these."""
    first, placed = run.first_interval("LF"), placed_outlines(run)
    if first is None and placed is None:
        return None
    note = ("cross-sections seen in the direction of travel, left is left, arrows: force of the rail on the wheel, the "
            "longest of an instant is 40 mm") if placed else ""
    figure = new_page(f"{run.heading}: impacts of flanges", run.header.title, f"{note}\n{caption(run)}".strip())
    body = figure.add_gridspec(4, 1, height_ratios=(0.2, 1.1, 1.2, 0.7))        # the first row is for words
    if placed:
        shown = instants(run)[:SECTIONS]
        axes = body[1].subgridspec(1, 2*SECTIONS).subplots(squeeze=False)[0]
        for ax in axes[2*len(shown):]:
            ax.set_visible(False)
        for (label, k), left, right in zip(shown, axes[::2], axes[1::2], strict=False):
            draw_detail(left, run, placed, k, right=False)
            draw_detail(right, run, placed, k, right=True)
            left.annotate(f"t = {run.time[k]:.4f} s: {label}", (0, 1), xycoords="axes fraction", xytext=(0, 14),
                          textcoords="offset points", color="#404040", in_layout=False)
    pressed = patch_history(run, first, SOLVED) if first else np.empty((4, 0))
    if first and pressed.size:
        draw_patch(body[2].subgridspec(1, 2).subplots(), pressed, around(run, "LF", first.start, first))
    draw_impacts(figure.add_subplot(body[3]), run)
    return figure


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


def draw_detail(ax: Axes, run: RunData, placed: Outlines, k: int, right: bool) -> None:
    """One rail head with its wheel, contact points and force arrows at row k; the forces stand in the title."""
    side, sign = placed.sides[right]
    wheel, rail = turned(side.wheel*[sign, 1], *pose(run, k)), side.rail*[sign, 1]
    name = "right" if right else "left"
    shows(ax.add_artist(Polygon(MM*rail, facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.7)), f"rail {name} [mm]", "y [mm]",
          "outline", run.name)
    outline, = ax.plot(MM*wheel[:, 0], MM*wheel[:, 1], color=BLACK, linewidth=0.9)
    shows(outline, f"wheel {name} [mm]", "y [mm]", "outline", run.name)
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
        force = ax.quiver([x], [z], [arrow[0]], [arrow[1]], angles="xy", scale_units="xy", scale=1, color=color, width=0.010,
                          zorder=4)
        shows(force, f"Fz_{c}", f"Fy_{c}", "arrow", run.name)
        point, = ax.plot([x], [z], "o", color=color, markersize=3.5, markeredgecolor=BLACK, markeredgewidth=0.4, zorder=5)
        shows(point, f"z_{c} [mm]", f"y_{c} [mm]", "point", run.name)
        words.append(f"{CONTACT_NAMES[c].split()[1]} {number_text(KN*N)} kN at {DEG*run.values(f'angle_{c}')[k]:.1f}°")
    title = ax.set_title(f"{name}: {', '.join(words) or 'no contact'}", loc="left", fontsize=6.2, pad=3)
    title.set_in_layout(False)
    head = sign*MM*side.rail[side.rail[:, 1] > side.rail[:, 1].max() - HEAD, 0]
    ax.set(xlim=(head.max() + AROUND, head.min() - AROUND), ylim=(-AROUND, ABOVE), xlabel="y [mm]")
    ax.set_aspect("equal", anchor="NW")
    ax.tick_params(labelsize=6)


def close_page(run: RunData, again: Recomputed, title: str) -> Figure | None:
    """A contact of the left flange, computed again with rows as close as it needs; None where it does not happen again."""
    one = max(again.run.intervals("LF", rigid=False) or [], key=lambda one: one.peak, default=None)
    if one is None:
        return None
    note = again.words if one.begins else f"{again.words}; the left flange is in contact from the first of them on"
    figure = new_page(f"{run.heading}: {title}", run.header.title, f"{note}\n{caption(run)}")
    window = around(again.run, "LF", one.start, one)
    pressed = patch_history(again.run, one, 3*SOLVED)
    axes = draw_columns(figure.add_gridspec(1, 1)[0], again.run, CLOSE, window, spare=int(pressed.size > 0))
    if pressed.size:
        draw_patch(axes[:, -1], pressed, window)
    rows = slice(*np.searchsorted(run.time, [again.start + window.start, again.start + window.end]))
    dots, = axes[0, 0].plot(window.of(run.time[rows] - again.start), KN*run.values("N_LF")[rows], ".", color=BLACK, markersize=3,
                            zorder=6)
    shows(dots, "N_LF [kN]", window.clock)
    return figure


def draw_patch(axes: np.ndarray, pressed: np.ndarray, window: Window) -> None:
    """Largest pressure and area of the patches of the left flange; the approach at the largest pressure in words."""
    t = window.of(pressed[0])
    look = CONTACT_LINES["LF"].kwargs() | {"marker": "o", "markersize": 2.5}
    hardest = int(pressed[1].argmax())
    axes[0].set_title(f"left flange, largest;\napproach {number_text(MM*pressed[3, hardest])} mm", loc="right", pad=2.5)
    for ax, values, words, shown in zip(axes, (1e-9*pressed[1], 1e6*pressed[2]), ("pressure [GPa]", "patch area [mm²]"),
                                        ("pressure LF [GPa]", "area LF [mm²]"), strict=True):
        curve, = ax.plot(t, values, **look)
        shows(curve, shown, window.clock, "solved")
        ax.set_ylabel(words)
        ax.set_ylim(bottom=0)
        ax.margins(x=0.03)
        ax.locator_params(axis="y", nbins=5)
        ax.set_xlabel(window.axis)


def chosen_impacts(run: RunData) -> tuple[list[ContactInterval], int]:
    """The first impacts of flanges, and the number of all: of the steps of an elastic run, as the rows miss some."""
    found = run.impacts(("LF", "RF"))
    if run.formulation == "elastic":
        return found[:MOST], sum(run.results[f"n_{side}_flange_contact"] for side in ("left", "right"))
    return found[:MOST], len(found)


def draw_impacts(ax: Axes, run: RunData) -> None:
    """The impacts of flanges in numbers."""
    def told(x: float, unit: str) -> str:
        return number_text(x) + (unit if np.isfinite(x) else "")

    found, count = chosen_impacts(run)
    rows = [list(HEADS)] if count else []
    for one in found:
        energies = exchange(run, one.start, one.end)
        rows.append([
            CONTACT_NAMES[one.contact] + ", root"*one.at_root, f"{one.start:.6f} s", told(1e3*one.duration or np.nan, " ms"),
            told(KN*one.peak, " kN"), told(DEG*one.angle, "°"), told(KN*one.impulse, " kN·s"),
            *(["–"]*4 if energies is None else [told(energies.elastic, " J"), *(
                f"{number_text(energies.before[part])} → {number_text(energies.after[part])} J" for part in KINETIC_PARTS)])])
    draw_table(ax, rows, EDGES, 1/(MOST + 2.5), above=1, pad=0.0, size=6.8, band=lambda i: "")
    which = f"the first {MOST} of {count}" if count > MOST else "all"
    words = f"Impacts of flanges, {which}" if count else "No impact of a flange that begins and ends in the run"
    if any(one.at_root for one in found):
        words += f"; root: contact angle below {DEG*FLANGE_ANGLE:.0f}°"
    ax.text(0, 1, words, fontsize=8, color="#404040", va="top")
