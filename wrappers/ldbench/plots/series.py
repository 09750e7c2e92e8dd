"""What is drawn against time: pages of panels of curves, and the columns that they show."""
from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..results.quantities import CONTACT_NAMES, CONTACTS, PER_CONTACT, quantity
from ..results.run_data import RunData
from .style import BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, GREEN, ORANGE, PURPLE, RED, Line


@dataclass(frozen=True)
class Curve:
    """A curve against time: one column, or several that are added up."""

    columns: tuple[str, ...]      # added up
    label: str
    line: Line

    def values(self, run: RunData) -> np.ndarray:
        """The values of the curve, SI."""
        return functools.reduce(np.add, map(run.values, self.columns))


@dataclass(frozen=True)
class Panel:
    """A panel: curves of one unit."""

    label: str
    unit: str
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Page:
    """A page of panels against time."""

    title: str
    panels: tuple[Panel, ...]
    note: str | Callable[[RunData], str] = ""

    def of(self, run: RunData) -> Page | None:
        """The page with what the run has columns for; None without any."""
        panels = [replace(panel, curves=curves) for panel in self.panels
                  if (curves := tuple(curve for curve in panel.curves if all(name in run.data for name in curve.columns)))]
        return replace(self, panels=tuple(panels)) if panels else None


def contact_curves(what: str, *contacts: str) -> tuple[Curve, ...]:
    """One quantity of some contacts, each in the colour of the contact."""
    return tuple(Curve((f"{what}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c]) for c in contacts)


def single(column: str, label: str) -> Panel:
    """A panel of one column."""
    shown = quantity(column)
    return Panel(label, shown.unit, shown.scale, (Curve((column,), label, Line(BLACK)),))


def of_contacts(what: str, label: str, *contacts: str) -> Panel:
    """A panel of one quantity of some contacts."""
    return Panel(label, PER_CONTACT[what].unit, PER_CONTACT[what].scale, contact_curves(what, *contacts))


def by_side(what: str, label: str) -> tuple[Panel, ...]:
    """Left and right wheel, each with tread and flange."""
    return of_contacts(what, f"{label}, left wheel", "LT", "LF"), of_contacts(what, f"{label}, right wheel", "RT", "RF")


def by_part(what: str, label: str) -> tuple[Panel, ...]:
    """Treads and flanges, each left and right."""
    return of_contacts(what, f"{label}, treads", "LT", "RT"), of_contacts(what, f"{label}, flanges", "LF", "RF")


IMPULSES = Page("impulses of impacts, and energy lost", (
    *by_side("P", "impulses so far"), single("E_lost", "energy lost so far")),
    "rigid contacts: forces that last are on the pages of forces, impacts on this one")


def constant_energies(run: RunData) -> str:
    """Tell the energies that stay constant and are not drawn."""
    if not {"KE_long", "KE_pitch"}.issubset(run.data):
        return ""
    forward, pitch = (run.values(column)[0] for column in ("KE_long", "KE_pitch"))
    return (f"constant and not drawn: kinetic energy of forward motion {forward:.3f} J and of pitch {pitch:.3f} J; "
            "drift: total energy − work of the lateral force − total energy at the start")


PAGES = (
    Page("displacements", (
        single("Y", "lateral Y"), single("Z", "vertical Z"),
        single("roll", "roll Φ"))),
    Page("velocities", (
        single("vY", "lateral dY/dt"), single("vZ", "vertical dZ/dt"),
        single("roll_rate", "roll dΦ/dt"))),
    Page("accelerations", (
        single("aY", "lateral"), single("aZ", "vertical"), single("roll_acc", "roll"))),
    Page("contact angles and rolling radii",
         by_part("angle", "angle") + by_part("radius", "radius"),
         "angle of the contact normal to the vertical, positive towards the flange"),
    Page("normal forces", by_side("N", "normal force")),
    Page("vertical forces", by_side("Fz", "vertical force"), "of the rail on the wheel, up positive"),
    Page("lateral forces", by_side("Fy", "lateral force"), "of the rail on the wheel, left positive"),
    Page("contact positions, lateral",
         tuple(of_contacts("y", f"y, {CONTACT_NAMES[c]}", c) for c in CONTACTS),
         "from the track centreline, left positive"),
    Page("contact positions, vertical", by_part("z", "z"), "from the top of the rails, up positive"),
    Page("energy balance", (
        Panel("kinetic", "J", 1.0, (
            Curve(("KE_lat",), "lateral", Line(BLACK)), Curve(("KE_vert",), "vertical", Line(GREEN, DASHED)),
            Curve(("KE_roll",), "roll", Line(PURPLE, DASH_DOT)))),
        Panel("potential", "J", 1.0, (
            Curve(("PE_grav",), "gravity", Line(BLACK)), Curve(("PE_load",), "vertical load", Line(GREEN, DASHED)),
            Curve(("PE_elastic_L",), "elastic left", Line(BLUE)),
            Curve(("PE_elastic_R",), "elastic right", Line(RED)))),
        Panel("sums", "J", 1.0, (
            Curve(("KE_lat", "KE_vert", "KE_roll"), "kinetic", Line(BLACK)),
            Curve(("PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R"), "potential", Line(GREEN, DASHED)),
            Curve(("W_ext",), "work of the lateral force", Line(ORANGE)))),
        Panel("drift", "J", 1.0, (
            Curve(("E_drift",), "total − work of the lateral force − total at the start", Line(BLACK)),))),
        constant_energies),
)
