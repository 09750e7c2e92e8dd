"""Quantities against time: pages of panels of curves, and how they are drawn, with the events of the run above them."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.patheffects import withStroke

from ..constants import CONTACT_NAMES, CONTACTS, SIDES
from ..results.answers import answers
from ..results.derived import is_forced, lateral_over_vertical
from ..results.quantities import PER_CONTACT, quantity
from ..results.run_data import RunData
from .frame import caption, legend_above, legend_of_page, new_page
from .stretches import BINS, PANEL, Window, band, overall, thin
from .style import BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, GREEN, GREY, ORANGE, PAGE, PURPLE, RED, Line

EVENT_SIZE = 6.0            # of the words of events [pt]
LEGEND_SIZE = 6.3           # of the words above a panel [pt]
PAGE_KEY = 4                # as many curves or fewer have one legend for the page
FEW_ROWS = 60               # that are marked by dots
ROOM = 70.0                 # about as much of its width a column of panels leaves to labels and margins [pt]


@dataclass(frozen=True)
class Curve:
    """A curve against time: one column, or several that are added up."""
    columns: tuple[str, ...]      # added up
    label: str
    line: Line
    sign: float = 1.0
    derive: Callable[[RunData], np.ndarray] | None = None     # what the columns give where they are not added up

    def values(self, run: RunData) -> np.ndarray:
        """The values of the curve, SI."""
        if self.derive is not None:
            return self.derive(run)
        return self.sign*np.sum([run.values(column) for column in self.columns], axis=0)


@dataclass(frozen=True)
class Panel:
    """A panel: curves of one unit."""
    label: str                    # of the vertical axis, with the unit
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Page:
    """A page of panels against time, in columns beside each other."""
    title: str
    columns: tuple[tuple[Panel, ...], ...]
    note: str = ""

    def of(self, run: RunData) -> Page | None:
        """The page with what the run has columns for, without work where no force does any; None without any column."""
        found = []
        for column in self.columns:
            panels = tuple(replace(panel, curves=curves) for panel in column if (curves := tuple(
                curve for curve in panel.curves if all(name in run.data for name in curve.columns)
                and (curve.columns != WORK or is_forced(run)))))
            found += [panels] if panels else []
        return replace(self, columns=tuple(found)) if found else None


def singles(**labels: str) -> tuple[Panel, ...]:
    """A panel for each column, with its label."""
    return tuple(Panel(quantity(column)._replace(words=label).label, quantity(column).scale,
                       (Curve((column,), label, Line(BLACK)),)) for column, label in labels.items())


def of_contacts(what: str, label: str, *contacts: str) -> Panel:
    """A panel of one quantity of some contacts, each in the colour of the contact; y points outwards."""
    return Panel(PER_CONTACT[what]._replace(words=label).label, PER_CONTACT[what].scale, tuple(Curve(
        (f"{what}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c], -1.0 if what == "y" and c[0] == "R" else 1.0) for c in contacts))


def panels(places: dict[str, tuple[str, str]], **labels: str) -> tuple[tuple[Panel, ...], ...]:
    """A column of panels for each place, one for each quantity of its contacts."""
    return tuple(tuple(of_contacts(what, f"{label}, {place}", *contacts) for what, label in labels.items())
                 for place, contacts in places.items())


def of_energies(label: str, *curves: Curve) -> Panel:
    """A panel of energies [J]."""
    return Panel(f"{label} [J]", 1.0, curves)


def ratio_curve(side: str) -> Curve:
    """L/V of a wheel, 'left' or 'right'."""
    needed = tuple(f"{force}_{contact}" for force in ("Fy", "Fz") for contact in SIDES[side])
    return Curve(needed, f"{side} wheel", CONTACT_LINES[SIDES[side][0]], derive=lambda run: lateral_over_vertical(run, side))


def constant_energies(run: RunData) -> str:
    """Tell the energies that stay constant and are not drawn."""
    if not {"KE_long", "KE_pitch"}.issubset(run.data):
        return ""
    forward, pitch = (run.values(column)[0] for column in ("KE_long", "KE_pitch"))
    return (f"constant and not drawn: kinetic energy of forward motion {forward:.3f} J and of pitch {pitch:.3f} J; "
            "drift: total energy − work of the lateral force − total energy at the start")


WHEELS = {f"{side} wheel": contacts for side, contacts in SIDES.items()}
PLACES = {"treads": ("LT", "RT"), "flanges": ("LF", "RF")}
WORK = "W_ext",
RATIO = Panel("L/V", 1.0, (ratio_curve("left"), ratio_curve("right")))
KINETIC = of_energies("kinetic energy", Curve(("KE_lat",), "lateral", Line(BLACK)),
                      Curve(("KE_vert",), "vertical", Line(GREEN, DASHED)), Curve(("KE_roll",), "roll", Line(PURPLE, DASH_DOT)))
ELASTIC = Curve(("PE_elastic_L",), "elastic left", Line(BLUE)), Curve(("PE_elastic_R",), "elastic right", Line(RED))
ENERGIES = (
    KINETIC,
    of_energies("potential energy", Curve(("PE_grav",), "gravity", Line(BLACK)),
                Curve(("PE_load",), "vertical load", Line(GREEN, DASHED)), *ELASTIC),
    of_energies("sums", Curve(("KE_lat", "KE_vert", "KE_roll"), "kinetic", Line(BLACK)),
                Curve(("PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"), "potential", Line(GREEN, DASHED)),
                Curve(WORK, "work of lateral force", Line(ORANGE))),
    of_energies("drift", Curve(("E_drift",), "drift", Line(BLACK))),
)
POSITIONS = singles(Y="lateral Y", Z="vertical Z", roll="roll Φ")

PAGES = (
    Page("motion", (POSITIONS, singles(vY="dY/dt", vZ="dZ/dt", roll_rate="dΦ/dt"),
                    singles(aY="d²Y/dt²", aZ="d²Z/dt²", roll_acc="d²Φ/dt²"))),
    Page("contact forces", panels(WHEELS, N="normal N", Fz="vertical", Fy="lateral"),
         "of the rail on the wheel, in the directions up and left"),
    Page("contact points", panels(PLACES, angle="angle", radius="rolling radius", y="outward y", z="z"),
         "angle of the contact normal to the vertical, positive towards the flange; outward y: from the track centreline, "
         "positive to the left on the left side and to the right on the right side; z: from the top of the rails, up positive"),
)
IMPULSES = Page("impulses of impacts, and energy lost", (
    (*(panel for panel, in panels(WHEELS, P="impulses so far")), *singles(E_lost="energy lost so far")),),
    "rigid contacts: forces that last are on the page of forces, impacts on this one")
ENERGY = Page("energy", (ENERGIES,))
# Around an impact, and before the end of a long run.
CLOSE = (
    (of_contacts("N", "N", *CONTACTS), of_contacts("angle", "contact angle", "LF", "RF")),
    tuple(Panel(label, 1.0, (Curve((lateral,), "lateral", Line(BLACK)), Curve((vertical,), "vertical", Line(GREEN, DASHED))))
          for label, lateral, vertical in (("velocity [m/s]", "vY", "vZ"), ("acceleration [m/s²]", "aY", "aZ"))),
    (of_energies("energy", *KINETIC.curves, Curve(("PE_elastic_L", "PE_elastic_R"), "elastic", Line(BLUE))), RATIO),
)
LAST = Page("motion and forces, last second", (POSITIONS, (*(panel for panel, in panels(WHEELS, N="normal N")), RATIO)))


def time_page(run: RunData, page: Page, window: Window | None = None) -> Figure | None:
    """A page of panels against time, of the whole run unless a window is given; None where the run has no column of it."""
    shown, window = page.of(run), window or overall(run)
    if shown is None:
        return None
    figure = new_page(f"{run.heading}: {page.title}", run.header.title,
                      "; ".join(words for words in (page.note, window.title) if words) + f"\n{caption(run)}")
    draw_columns(figure.add_gridspec(1, 1)[0], run, shown.columns, window)
    return figure


def draw_columns(place: SubplotSpec, run: RunData, columns: Sequence[Sequence[Panel]], window: Window, alone: bool = True,
                 spare: int = 0) -> np.ndarray:
    """Panels in columns of a place of a page, and `spare` columns of axes for others; all axes. `alone`: the panels fill the
    page, so the events of the run are marked above them, and one legend is for all of them where they share a few curves."""
    figure = place.get_gridspec().figure
    axes: np.ndarray = place.subgridspec(max(map(len, columns)), len(columns) + spare).subplots(sharex=True, squeeze=False)
    lines = {curve.label: curve.line for column in columns for panel in column if len(panel.curves) > 1 for curve in panel.curves}
    together = alone and 0 < len(lines) <= PAGE_KEY
    raised = mark_events(axes, run, window, figure) if alone else 0
    for column, shown in zip(axes.T[:len(columns)], columns, strict=True):
        for k, ax in enumerate(column):
            if k >= len(shown):
                ax.set_visible(False)
                continue
            draw_panel(ax, run, shown[k], window)
            if not together and len(shown[k].curves) > 1:
                legend_above(ax, raised=raised/LEGEND_SIZE if k == 0 else 0, fontsize=LEGEND_SIZE)
        column[len(shown) - 1].set_xlabel(window.axis)
        column[len(shown) - 1].tick_params(labelbottom=True)
    axes[0, 0].set_xlim(*(window.scale*(x - window.zero) for x in (window.start, window.end)))
    axes[0, 0].locator_params(axis="x", nbins=4 if window.milliseconds else 6)      # 49220 is longer than 0.2
    figure.align_ylabels(axes)
    if together:
        handles = {line.get_label(): line for ax in axes.ravel() for line in ax.get_lines() if line.get_label() in lines}
        legend_of_page(figure, list(handles.values()))
    return axes


def draw_panel(ax: Axes, run: RunData, panel: Panel, window: Window) -> None:
    """One quantity in one window."""
    rows = window.rows(run)
    t = window.scale*(run.time[rows] - window.zero)
    drawn = [(t, panel.scale*curve.values(run)[rows], curve.label, curve.line) for curve in panel.curves]
    draw_curves(ax, drawn, window.band)
    ax.set_ylabel(panel.label)
    if all(np.isnan(x).all() for _, x, *_ in drawn):
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])
        return
    low, high = ax.get_ylim()
    middle = (low + high)/2
    if high - low < 1e-9*max(abs(middle), 1e-3):        # of a constant matplotlib would show the rounding
        half = max(0.05*abs(middle), 0.1)
        ax.set_ylim(middle - half, middle + half)
    ax.locator_params(axis="y", nbins=5)


def draw_curves(ax: Axes, curves: Sequence[tuple[np.ndarray, np.ndarray, str, Line]], banded: bool) -> None:
    """Curves over time with their labels and looks; smooth ones lie over those that swing."""
    swings = [np.nansum(np.abs(np.diff(x))) for _, x, *_ in curves]
    for curve, swing in zip(curves, swings, strict=True):
        draw_curve(ax, *curve, banded, 2 + 0.01*sum(other > swing for other in swings))


def draw_curve(ax: Axes, t: np.ndarray, x: np.ndarray, label: str, line: Line, banded: bool, zorder: float = 2) -> None:
    """A curve, or the band of a long run and over it the mean with a white rim, which no other band hides."""
    look = line.kwargs() | {"label": label, "zorder": zorder}
    if banded:
        t, low, high, x = band(t, x, BINS)
        ax.fill_between(t, low, high, color=line.color, alpha=0.3, linewidth=0)
        look |= {"linewidth": 1.1, "path_effects": [withStroke(linewidth=2.2, foreground="white")]}
    elif len(t) < FEW_ROWS:
        look |= {"marker": ".", "markersize": 2.5}
    ax.plot(*thin(t, x, PANEL), **look)


def mark_events(axes: np.ndarray, run: RunData, window: Window, figure: Figure) -> float:
    """Mark events by dotted lines, with their words above the topmost axes; the height that the words take [pt]. Events at
    one place share a line, and words that would overlap go one line up."""
    width = 72*PAGE[0]/axes.shape[1] - ROOM         # of a panel [pt]
    ends: list[float] = []

    def height(line: int) -> float:
        return 1.5 + 1.25*EVENT_SIZE*line

    found, words = answers(run), {"t_first_LF": "left flange", "t_first_RF": "right flange", "t_first_centre": "centre",
                                  "t_derailment": "derailment"}
    events = [(found[name], word) for name, word in words.items() if found[name] is not None]
    shown = sorted(event for event in events if window.start <= event[0] <= window.end)
    for t, group in groupby(shown, key=lambda event: event[0]):
        label = ", ".join(word for _, word in group)
        half = 0.27*EVENT_SIZE*len(label) + 1
        middle = min(max((t - window.start)/(window.end - window.start)*width, half), width - half)
        line = next((k for k, end in enumerate(ends) if middle - half > end + 2), len(ends))
        ends[line:line + 1] = [middle + half]
        for ax in axes.ravel():
            ax.axvline(window.scale*(t - window.zero), color=GREY, linewidth=0.6, linestyle=":", zorder=1)
        for ax in axes[0]:
            ax.annotate(label, (middle/width, 1.0), xycoords="axes fraction", xytext=(0, height(line)), va="bottom",
                        textcoords="offset points", ha="center", fontsize=EVENT_SIZE, color="#505050", annotation_clip=False)
    return height(len(ends)) if ends else 0.0
