"""Quantities against time: curves of columns, panels of curves, and how they are drawn."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from ..constants import CONTACT_NAMES, CONTACTS, SIDES
from ..results.derived import is_forced, lateral_over_vertical
from ..results.quantities import PER_CONTACT, quantity
from ..results.run_data import RunData
from .frame import legend_above
from .named import name, shows
from .stretches import Window, split
from .style import BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, DOTTED, GREEN, GREY, ORANGE, PURPLE, RED, Line, short_numbers

FEW_ROWS = 60               # that are marked by dots
WIDTH = 70                  # of a panel of which nothing else is told [mm]


@dataclass(frozen=True)
class Curve:
    """A curve: one column, several that are added up, or what follows from them."""
    columns: tuple[str, ...]      # added up
    label: str
    line: Line
    sign: float = 1.0
    derive: Callable[[RunData], np.ndarray] | None = None     # what the columns give where they are not added up
    derived: str = ""             # the name of that

    def values(self, run: RunData) -> np.ndarray:
        """The values of the curve, SI."""
        if self.derive is not None:
            return self.derive(run)
        return self.sign*np.sum([run.values(column) for column in self.columns], axis=0)

    @property
    def name(self) -> str:
        """What the curve shows, as `named.shows` has it."""
        return self.derived or "-"*(self.sign < 0) + "+".join(self.columns)


@dataclass(frozen=True)
class Panel:
    """A panel: curves of one unit."""
    words: str                    # of the vertical axis
    unit: str
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]

    @property
    def label(self) -> str:
        """The label of the vertical axis."""
        return name(self.words, self.unit)

    def of(self, run: RunData) -> Panel | None:
        """The panel with what the run has columns for, without work where no force does any; None without any column."""
        curves = tuple(curve for curve in self.curves if all(column in run.data for column in curve.columns)
                       and (curve.columns != WORK or is_forced(run)))
        return replace(self, curves=curves) if curves else None


def panels_of(run: RunData, panels: Iterable[Panel]) -> tuple[Panel, ...]:
    """The panels for which a run has columns."""
    return tuple(own for panel in panels if (own := panel.of(run)))


def single(column: str, label: str = "") -> Panel:
    """A panel for a column."""
    known = quantity(column)
    return Panel(label or known.words, known.unit, known.scale, (Curve((column,), label or known.words, Line(BLACK)),))


def of_contacts(what: str, label: str, *contacts: str) -> Panel:
    """A panel of one quantity of some contacts, each in the colour of the contact; y points outwards."""
    known = PER_CONTACT[what]
    return Panel(label, known.unit, known.scale, tuple(Curve(
        (f"{what}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c], -1.0 if what == "y" and c[0] == "R" else 1.0) for c in contacts))


def of_energies(label: str, *curves: Curve) -> Panel:
    """A panel of energies."""
    return Panel(label, "J", 1.0, curves)


def ratio_curve(side: str) -> Curve:
    """L/V of a wheel, 'left' or 'right'."""
    needed = tuple(f"{force}_{contact}" for force in ("Fy", "Fz") for contact in SIDES[side])
    return Curve(needed, f"{side} wheel", CONTACT_LINES[SIDES[side][0]], derive=lambda run: lateral_over_vertical(run, side),
                 derived=f"L/V {side}")


WORK = "W_ext",
RATIO = Panel("L/V", "", 1.0, (ratio_curve("left"), ratio_curve("right")))
KINETIC = (Curve(("KE_lat",), "lateral", Line(BLACK)), Curve(("KE_vert",), "vertical", Line(GREEN, DASHED)),
           Curve(("KE_roll",), "roll", Line(PURPLE, DASH_DOT)))
ELASTIC = (Curve(("PE_elastic_L",), "elastic left", Line(BLUE, DOTTED, 1.1)),
           Curve(("PE_elastic_R",), "elastic right", Line(RED, DOTTED, 1.1)))
POTENTIAL = (Curve(("PE_grav",), "gravity", Line(GREY)), Curve(("PE_load",), "vertical load", Line(BLACK, DASHED)),
             Curve(WORK, "work of the lateral force", Line(ORANGE, DASH_DOT)))
# Around an impact that was computed again.
CLOSE = (
    (of_contacts("N", "N", *CONTACTS), of_contacts("angle", "contact angle", "LF", "RF")),
    tuple(Panel(label, unit, 1.0, (Curve((lateral,), "lateral", Line(BLACK)), Curve((vertical,), "vertical", Line(GREEN, DASHED))))
          for label, unit, lateral, vertical in (("velocity", "m/s", "vY", "vZ"), ("acceleration", "m/s²", "aY", "aZ"))),
    (of_energies("energy", *KINETIC, Curve(("PE_elastic_L", "PE_elastic_R"), "elastic", Line(BLUE))), RATIO),
)


def draw_columns(place: SubplotSpec, run: RunData, columns: Sequence[Sequence[Panel]], window: Window,
                 spare: int = 0) -> np.ndarray:
    """Panels in columns of a place of a page, and `spare` columns of axes for others; all axes."""
    shown = [own for column in columns if (own := panels_of(run, column))]
    figure = place.get_gridspec().figure
    axes: np.ndarray = place.subgridspec(max(map(len, shown), default=1), len(shown) + spare).subplots(sharex=True, squeeze=False)
    for column, panels in zip(axes.T[:len(shown)], shown, strict=True):
        for k, ax in enumerate(column):
            if k >= len(panels):
                ax.set_visible(False)
                continue
            draw_panel(ax, run, panels[k], window)
            ax.set_ylabel(panels[k].label)
            if len(panels[k].curves) > 1:
                legend_above(ax, 2)
        column[len(panels) - 1].set_xlabel(window.axis)
        column[len(panels) - 1].tick_params(labelbottom=True)
    axes[0, 0].set_xlim(*window.of(np.array([window.start, window.end])))
    axes[0, 0].locator_params(axis="x", nbins=4 if window.since else 6)
    figure.align_ylabels(axes)
    return axes


def draw_panel(ax: Axes, run: RunData, panel: Panel, window: Window, width: float = WIDTH) -> None:
    """One quantity in one window, in a panel so many millimetres wide."""
    rows = window.rows(run)
    t = window.of(run.time[rows])
    drawn = [panel.scale*curve.values(run)[rows] for curve in panel.curves]
    draw_curves(ax, [(t, x, curve.label, curve.line, {"y": name(curve.name, panel.unit), "x": window.clock})
                     for x, curve in zip(drawn, panel.curves, strict=True)], width)
    if all(np.isnan(x).all() for x in drawn):
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center", color="#606060")
        ax.tick_params(left=False, labelleft=False)
        return
    low, high = ax.get_ylim()
    middle = (low + high)/2
    if high - low < 1e-9*max(abs(middle), 1e-3):        # of a constant matplotlib would show the rounding
        half = max(0.05*abs(middle), 0.1)
        ax.set_ylim(middle - half, middle + half)
    ax.yaxis.set_major_locator(MaxNLocator(5, min_n_ticks=2))
    short_numbers(ax.yaxis)


def draw_curves(ax: Axes, curves: Sequence[tuple[np.ndarray, np.ndarray, str, Line, dict[str, str]]],
                width: float = WIDTH) -> None:
    """Curves, as `draw_curve` takes them; smooth ones lie over those that swing."""
    swings = [np.nansum(np.abs(np.diff(y))) for _, y, *_ in curves]
    for curve, swing in zip(curves, swings, strict=True):
        draw_curve(ax, *curve, width, 2 + 0.01*sum(other > swing for other in swings))


def draw_curve(ax: Axes, x: np.ndarray, y: np.ndarray, label: str, line: Line, names: dict[str, str], width: float = WIDTH,
               zorder: float = 2) -> None:
    """A curve in a panel so many millimetres wide; where it swings more than once a millimetre, the band of its values and over it
    their mean with a white rim, which no other band hides. `names`: what it shows, as `shows` takes it."""
    look = line.kwargs() | {"zorder": zorder}
    line_x, line_y, band = split(x, y, int(width))
    if band:
        area = ax.fill_between(band.middle, band.low, band.high, facecolor=line.color + "40", edgecolor=line.color + "B0",
                               linewidth=0.4)
        shows(area, **names, how="range")
        mean, = ax.plot(band.middle, band.mean, **look | {"linewidth": 1.0, "path_effects": [
            withStroke(linewidth=2.0, foreground="white")]})
        shows(mean, **names, how="mean")
    dots = {"marker": ".", "markersize": 2.5} if len(x) < FEW_ROWS else {}
    drawn, = ax.plot(line_x, line_y, **look | dots, label=label)
    shows(drawn, **names)


def key_of(curves: Iterable[Curve]) -> list[Line2D]:
    """What a legend shows of curves, each look and its words once."""
    known = {curve.label: curve.line for curve in curves}
    return [shows(Line2D([], [], label=label, **line.kwargs()), label, how="legend") for label, line in known.items()]
