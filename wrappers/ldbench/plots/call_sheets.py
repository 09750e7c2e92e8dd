"""The sheets of a run: every quantity of the call's list in its order, a row of panels each.

A row shows the whole run and, each on its own axis, the first contact of either flange. The last second of a long run stands in
the place of a flange that is not touched.
"""
from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..constants import CONTACT_NAMES, SIDES
from ..number_text import number_text
from ..results.answers import answers
from ..results.run_data import RunData
from .frame import LEFT, body, caption, legend_of_page, new_page
from .named import shows
from .series import ELASTIC, KINETIC, POTENTIAL, Panel, draw_panel, key_of, of_contacts, of_energies, panels_of, single
from .stretches import Window, first_contact, last_second, whole
from .style import GREY, PAGE, SIZE, short_numbers

# Left and right edges of the columns of panels [mm].
COLUMNS = (46.0, 147.0), (166.0, 217.5), (235.5, 287.0)
BETWEEN = 3.0               # free between rows [mm]
HEADS = 11.0                # free above the panels, for their heads and for events [mm]
BELOW = 9.0                 # free below the panels, for the time axis [mm]
MANY, CROWDED = 4, 1.5      # a panel of more curves is so many times as high
TICK = 6.0                  # between numbers of a vertical axis, about [mm]
STEPS = 1, 2, 2.5, 5, 10    # of numbers of an axis
LETTERS = 16                # of a line of a label
CHARACTER = 0.55            # mean width of a letter over its size
WHEELS = {f"{side} wheel": contacts for side, contacts in SIDES.items()}
PLACES = {"treads": ("LT", "RT"), "flanges": ("LF", "RF")}
BANDS = "; light band: smallest to largest value, and mean"
EVENTS = {"t_first_LF": "left flange", "t_first_RF": "right flange", "t_first_centre": "centre", "t_derailment": "derailment"}


@dataclass(frozen=True)
class Sheet:
    """A sheet of panels, one below the other."""
    title: str
    panels: tuple[Panel, ...]
    note: str = ""


def by_place(what: str, label: str, places: Mapping[str, tuple[str, ...]]) -> tuple[Panel, ...]:
    """A panel of a quantity for each place."""
    return tuple(of_contacts(what, f"{label}, {place}", *contacts) for place, contacts in places.items())


SHEETS = (
    Sheet("motions and velocities", tuple(map(single, ("Y", "Z", "roll", "vY", "vZ", "roll_rate"))),
          "Z and Φ from static equilibrium at Y = 0; Φ > 0 lifts the left wheel"),
    Sheet("accelerations and contact angles", (*map(single, ("aY", "aZ", "roll_acc")), *by_place("angle", "contact angle", PLACES)),
          "contact angle: of the contact normal to the vertical, positive towards the flange"),
    Sheet("contact forces", (*by_place("N", "normal force", WHEELS), *by_place("Fz", "vertical force", WHEELS),
                             *by_place("Fy", "lateral force", WHEELS), *by_place("P", "impulses so far", WHEELS)),
          "forces of the rail on the wheel, upwards and to the left"),
    Sheet("positions, rolling radii, energies", (
        *by_place("y", "outward position", PLACES), *by_place("z", "vertical position", PLACES),
        *by_place("radius", "rolling radius", PLACES), of_energies("kinetic, elastic energy", *KINETIC, *ELASTIC),
        of_energies("potential energy", *POTENTIAL), single("E_drift", "balance: energy drift"), single("E_lost")),
        "outward position: y on the left, −y on the right, from the track's centre; vertical position: from the top of the rails"),
)


def run_sheet(run: RunData, sheet: Sheet) -> Figure | None:
    """A sheet of a run; None where the run has no column of it."""
    panels = panels_of(run, sheet.panels)
    if not panels:
        return None
    notes = [sheet.note, constant_energies(run) if any(one in panel.curves for panel in panels for one in KINETIC) else ""]
    figure = new_page(f"{run.heading}: {sheet.title}", run.header.title, f"{'; '.join(filter(None, notes))}\n{caption(run)}")
    keyed = [curve for panel in panels if len(panel.curves) > 1 for curve in panel.curves]
    if keyed:
        legend_of_page(figure, key_of(keyed), 7)
    bottom, top = body(figure)
    bottom, top = bottom + BELOW/HEIGHT, top - HEADS/HEIGHT
    weights = np.array([CROWDED if len(panel.curves) > MANY else 1.0 for panel in panels])
    edges = top - (top - bottom + BETWEEN/HEIGHT)*np.cumsum([0.0, *weights/weights.sum()])
    drawn: list[tuple[Column, list[Axes]]] = []
    for (left, right), shown in zip(COLUMNS, columns_of(run), strict=True):
        if shown.window is None:
            figure.text((left + right)/2/WIDTH, (bottom + top)/2, shown.words, ha="center", va="center", color="#404040")
            continue
        axes = [figure.add_axes((left/WIDTH, low + BETWEEN/HEIGHT, (right - left)/WIDTH, high - low - BETWEEN/HEIGHT))
                for high, low in pairwise(edges)]
        draw_column(axes, run, panels, shown.window, right - left)
        drawn.append((shown, axes))
    banded = any(vars(one)["shown"].how == "range" for ax in figure.axes for one in ax.collections)
    for k, (shown, axes) in enumerate(drawn):
        axes[0].annotate(shown.words + (BANDS if banded and k == 0 else ""), (0, 1), xycoords="axes fraction",
                         xytext=(0, 2 if shown.window and shown.window.since else 1.3*SIZE), textcoords="offset points",
                         va="bottom", linespacing=1.15, annotation_clip=False)
    for ax, panel in zip(figure.axes, panels, strict=False):        # those of the first column
        ax.set_ylabel(textwrap.fill(panel.label, LETTERS), rotation=0, ha="left", va="center")
        ax.yaxis.set_label_coords((LEFT*WIDTH - COLUMNS[0][0])/(COLUMNS[0][1] - COLUMNS[0][0]), 0.5)
    return figure


WIDTH, HEIGHT = (25.4*inches for inches in PAGE)        # of a page [mm]


@dataclass(frozen=True)
class Column:
    """What a column of panels shows, and the words above it; the words alone where there is nothing to show."""
    words: str
    window: Window | None


def columns_of(run: RunData) -> tuple[Column, Column, Column]:
    """The whole run, the first contact of the left flange and that of the right flange. The last second of a long run stands in
    the place of a flange that is not touched."""
    contacts = [contact_column(run, contact) for contact in ("LF", "RF")]
    free = next((k for k in (1, 0) if contacts[k].window is None), None)
    last = last_second(run)
    if free is None or last is None:
        return Column("whole run", whole(run)), contacts[0], contacts[1]
    contacts[free] = Column(f"last second of the run:\nt{contacts[free].words[1:]}", last)
    return Column("whole run up to its last second", whole(run, last.start)), contacts[0], contacts[1]


def contact_column(run: RunData, contact: str) -> Column:
    """The column of the first contact of a flange."""
    window = first_contact(run, contact)
    if window is None:
        return Column(f"The {CONTACT_NAMES[contact]} is not touched", None)
    lasts = f", lasts {number_text(1e3*(window.opens - window.zero))} ms" if np.isfinite(window.opens) else ""
    return Column(f"first contact of the {CONTACT_NAMES[contact]}:\nat {window.zero:.6f} s{lasts}", window)


def draw_column(axes: Sequence[Axes], run: RunData, panels: Sequence[Panel], window: Window, width: float) -> None:
    """The panels of a column, one below the other, so many millimetres wide."""
    for ax, panel in zip(axes, panels, strict=True):
        draw_panel(ax, run, panel, window, width)
        ax.yaxis.set_major_locator(MaxNLocator(max(int(HEIGHT*ax.get_position().height/TICK), 2), steps=STEPS, min_n_ticks=2))
        ax.set_xlim(*window.of(np.array([window.start, window.end])))
        ax.xaxis.set_major_locator(MaxNLocator(7 if width > 80 else 5, steps=STEPS))
        short_numbers(ax.xaxis)
        ax.tick_params(labelbottom=ax is axes[-1])
        for t, words in ((window.zero, "touch"), (window.opens, "opening")) if window.since else ():
            if np.isfinite(t):
                shows(ax.axvline(window.of(t), color=GREY, linewidth=0.6, linestyle=":", zorder=1), words, window.clock, "mark")
    axes[-1].set_xlabel(window.axis)
    if not window.since:
        mark_events(axes, run, window, width)


def mark_events(axes: Sequence[Axes], run: RunData, window: Window, width: float) -> None:
    """Mark events by dotted lines, with their words above the topmost axes. Events at one time share a line; words that would
    overlap go one line up."""
    points = 72/25.4*width
    ends: list[float] = []
    found = answers(run)
    events = [(found[key], word) for key, word in EVENTS.items() if found[key] is not None]
    shown = sorted(event for event in events if window.start <= event[0] <= window.end)
    for t, group in groupby(shown, key=lambda event: event[0]):
        label = ", ".join(word for _, word in group)
        half = CHARACTER/2*SIZE*len(label) + 1
        middle = min(max((t - window.start)/(window.end - window.start)*points, half), points - half)
        line = next((k for k, end in enumerate(ends) if middle - half > end + 2), len(ends))
        ends[line:line + 1] = [middle + half]
        for ax in axes:
            shows(ax.axvline(window.of(t), color=GREY, linewidth=0.6, linestyle=":", zorder=1), label, window.clock, "mark")
        axes[0].annotate(label, (middle/points, 1.0), xycoords="axes fraction", xytext=(0, 1.5 + 1.2*SIZE*line), va="bottom",
                         textcoords="offset points", ha="center", color="#505050", annotation_clip=False)


def constant_energies(run: RunData) -> str:
    """Tell the energies that stay constant and are not drawn."""
    if not {"KE_long", "KE_pitch"}.issubset(run.data):
        return ""
    forward, pitch = (run.values(column)[0] for column in ("KE_long", "KE_pitch"))
    return (f"constant and not drawn: kinetic energy of forward motion {forward:.3f} J and of pitch {pitch:.3f} J; "
            "energy drift: total energy − work of the lateral force − total energy at the start")
