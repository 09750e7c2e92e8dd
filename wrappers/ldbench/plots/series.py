"""What is drawn against time: pages of panels of curves, and the columns that they show."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..results.derived import SIDES, lateral_over_vertical
from ..results.quantities import CONTACT_NAMES, CONTACTS, PER_CONTACT, quantity
from ..results.run_data import RunData
from .style import BLACK, BLUE, CONTACT_LINES, DASH_DOT, DASHED, GREEN, ORANGE, PURPLE, RED, Line


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
    label: str
    unit: str
    scale: float                  # from SI to the unit
    curves: tuple[Curve, ...]

    @property
    def words(self) -> str:
        """The label of the vertical axis."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


@dataclass(frozen=True)
class Page:
    """A page of panels against time, in columns beside each other."""
    title: str
    columns: tuple[tuple[Panel, ...], ...]
    note: str | Callable[[RunData], str] = ""

    @property
    def panels(self) -> tuple[Panel, ...]:
        """All panels of the page, column by column."""
        return tuple(panel for column in self.columns for panel in column)

    def words(self, run: RunData) -> str:
        """The note on the page of a run."""
        return self.note(run) if callable(self.note) else self.note

    def of(self, run: RunData) -> Page | None:
        """The page with what the run has columns for, without work where no force does any; None without any column."""
        found = []
        for column in self.columns:
            panels = tuple(replace(panel, curves=curves) for panel in column if (curves := tuple(
                curve for curve in panel.curves if all(name in run.data for name in curve.columns)
                and (curve.columns != WORK or run.values(*WORK).any()))))
            found += [panels] if panels else []
        return replace(self, columns=tuple(found)) if found else None


def singles(**labels: str) -> tuple[Panel, ...]:
    """A panel for each column, with its label."""
    return tuple(Panel(label, (shown := quantity(column)).unit, shown.scale, (Curve((column,), label, Line(BLACK)),))
                 for column, label in labels.items())


def of_contacts(what: str, label: str, *contacts: str) -> Panel:
    """A panel of one quantity of some contacts, each in the colour of the contact; y points outwards."""
    return Panel(label, PER_CONTACT[what].unit, PER_CONTACT[what].scale, tuple(Curve(
        (f"{what}_{c}",), CONTACT_NAMES[c], CONTACT_LINES[c], -1.0 if what == "y" and c[0] == "R" else 1.0) for c in contacts))


def panels(places: dict[str, tuple[str, str]], **labels: str) -> tuple[tuple[Panel, ...], ...]:
    """A column of panels for each place, one for each quantity of its contacts."""
    return tuple(tuple(of_contacts(what, f"{label}, {place}", *contacts) for what, label in labels.items())
                 for place, contacts in places.items())


def of_energies(label: str, *curves: Curve) -> Panel:
    """A panel of energies [J]."""
    return Panel(label, "J", 1.0, curves)


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
PARTS = {"treads": ("LT", "RT"), "flanges": ("LF", "RF")}
WORK = "W_ext",
RATIO = Panel("L/V", "", 1.0, (ratio_curve("left"), ratio_curve("right")))
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
    Page("contact points", panels(PARTS, angle="angle", radius="rolling radius", y="outward y", z="z"),
         "angle of the contact normal to the vertical, positive towards the flange; outward y: from the track centreline, "
         "positive to the left on the left side and to the right on the right side; z: from the top of the rails, up positive"),
)
IMPULSES = Page("impulses of impacts, and energy lost", (
    (*(panel for panel, in panels(WHEELS, P="impulses so far")), *singles(E_lost="energy lost so far")),),
    "rigid contacts: forces that last are on the page of forces, impacts on this one")
ENERGY = Page("energy", (ENERGIES,), constant_energies)
# Around an impact, and before the end of a long run.
CLOSE = (
    (of_contacts("N", "N", *CONTACTS), of_contacts("angle", "contact angle", "LF", "RF")),
    tuple(Panel(label, unit, 1.0, (Curve((lateral,), "lateral", Line(BLACK)), Curve((vertical,), "vertical", Line(GREEN, DASHED))))
          for label, unit, lateral, vertical in (("velocity", "m/s", "vY", "vZ"), ("acceleration", "m/s²", "aY", "aZ"))),
    (of_energies("energy", *KINETIC.curves, Curve(("PE_elastic_L", "PE_elastic_R"), "elastic", Line(BLUE))), RATIO),
)
LAST = Page("motion and forces, last second", (POSITIONS, (*(panel for panel, in panels(WHEELS, N="normal N")), RATIO)))
