"""What is drawn against time: pages of panels of curves, and the columns that they show."""
from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..record import Record
from ..style import BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, GREEN, ORANGE, PURPLE, RED, Line
from ..table import CONTACT_NAMES, CONTACTS
from .frame import DEG, KN, MM


@dataclass(frozen=True)
class Curve:
    columns: tuple[str, ...]      # added up
    label: str
    line: Line

    def values(self, record: Record) -> np.ndarray:
        return functools.reduce(np.add, map(record.values, self.columns))


@dataclass(frozen=True)
class Panel:
    label: str
    unit: str
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]


@dataclass(frozen=True)
class Page:
    title: str
    panels: tuple[Panel, ...]
    note: str | Callable[[Record], str] = ""


def contact_curves(quantity: str, *contacts: str) -> tuple[Curve, ...]:
    return tuple(Curve((f"{quantity}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c]) for c in contacts)


def single(column: str, label: str, unit: str, scale: float = 1.0) -> Panel:
    return Panel(label, unit, scale, (Curve((column,), label, Line(BLACK)),))


def by_side(quantity: str, label: str, unit: str, scale: float) -> tuple[Panel, ...]:
    """Left and right wheel, each with tread and flange."""
    return (Panel(f"{label}, left wheel", unit, scale, contact_curves(quantity, "LT", "LF")),
            Panel(f"{label}, right wheel", unit, scale, contact_curves(quantity, "RT", "RF")))


def by_part(quantity: str, label: str, unit: str, scale: float) -> tuple[Panel, ...]:
    """Treads and flanges, each left and right."""
    return (Panel(f"{label}, treads", unit, scale, contact_curves(quantity, "LT", "RT")),
            Panel(f"{label}, flanges", unit, scale, contact_curves(quantity, "LF", "RF")))


IMPULSES = Page("impulses of impacts, and energy lost", (
    *by_side("P", "impulses so far", "kN·s", 1e-3), single("E_lost", "energy lost so far", "J")),
    "rigid contacts: forces that last are on the pages of forces, impacts on this one")


def constant_energies(record: Record) -> str:
    forward, pitch = (record.values(column)[0] for column in ("KE_long", "KE_pitch"))
    return (f"constant and not drawn: kinetic energy of forward motion {forward:.3f} J and of pitch {pitch:.3f} J; "
            "drift: total energy − work of the lateral force − total energy at the start")


PAGES = (
    Page("displacements", (
        single("Y", "lateral Y", "mm", MM), single("Z", "vertical Z", "mm", MM),
        single("roll", "roll Φ", "mrad", 1e3))),
    Page("velocities", (
        single("vY", "lateral dY/dt", "m/s"), single("vZ", "vertical dZ/dt", "m/s"),
        single("roll_rate", "roll dΦ/dt", "mrad/s", 1e3))),
    Page("accelerations", (
        single("aY", "lateral", "m/s²"), single("aZ", "vertical", "m/s²"), single("roll_acc", "roll", "rad/s²"))),
    Page("contact angles and rolling radii",
         by_part("angle", "angle", "°", DEG) + by_part("radius", "radius", "mm", MM),
         "angle of the contact normal to the vertical, positive towards the flange"),
    Page("normal forces", by_side("N", "normal force", "kN", KN)),
    Page("vertical forces", by_side("Fz", "vertical force", "kN", KN), "of the rail on the wheel, up positive"),
    Page("lateral forces", by_side("Fy", "lateral force", "kN", KN), "of the rail on the wheel, left positive"),
    Page("contact positions, lateral",
         tuple(Panel(f"y, {CONTACT_NAMES[c]}", "mm", MM, contact_curves("y", c)) for c in CONTACTS),
         "from the track centreline, left positive"),
    Page("contact positions, vertical", by_part("z", "z", "mm", MM), "from the top of the rails, up positive"),
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
