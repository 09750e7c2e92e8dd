"""The one table of quantities: what columns and results are called in words, and how they are shown.

Plots, comparison, page, film, data sets, CSV files and the abstract take their words, units and digits from here.
"""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..constants import CONTACT_NAMES, CONTACTS, DEG, KN, MM
from ..number_text import UNKNOWN, decimals_of, number_text, scientific

PAIRS = {"aw": "actual profiles", "sw": "simplified profiles"}
# The files of wheel and rail that make a pair of the benchmark.
PAIR_FILES = {(f"{pair[0]}wprof.yz", f"{pair[0]}rprof.yz"): words for pair, words in PAIRS.items()}


class Quantity(NamedTuple):
    """A column or a result in words."""

    words: str
    unit: str               # as it is shown
    scale: float            # from SI to that unit
    group: str = ""         # of columns that are chosen together
    digits: int | None = None   # decimals in tables, in the unit; None for four significant digits
    short: str = ""         # words where there is little room

    def text(self, x: float | None, digits: int | None = None, spread: float = 0.0) -> str:
        """A number as it is shown, without its unit; a dash for what did not happen. Of a number that is known within a range of
        the width `spread`, SI, the digits down to the first one of a quarter of that width are shown, one at least."""
        if x is None or not np.isfinite(x):
            return UNKNOWN
        shown, places = self.scale*x, self.digits if digits is None else digits
        if places is not None and places < 0:
            return scientific(shown)
        if 0 < spread < np.inf and shown:
            places = min(decimals_of(shown, 4) if places is None else places,
                         int(max(np.ceil(-np.log10(self.scale*spread/4)), -np.floor(np.log10(abs(shown))))))
            return number_text(round(shown, places), max(places, 0))
        return number_text(shown, places)

    @property
    def label(self) -> str:
        """Words and unit: 'Y, largest [mm]'."""
        return f"{self.words} [{self.unit}]" if self.unit else self.words

    @property
    def brief(self) -> str:
        """Brief words, where there are some, and unit."""
        return self._replace(words=self.short or self.words).label


# Columns of a column file; those of a contact by their beginning.
COLUMNS = {
    "time": Quantity("time", "s", 1, ""),
    "X": Quantity("distance X", "m", 1, "displacements"),
    "Y": Quantity("lateral displacement Y", "mm", 1e3, "displacements"),
    "Z": Quantity("vertical displacement Z", "mm", 1e3, "displacements"),
    "roll": Quantity("roll Φ", "mrad", 1e3, "displacements"),
    "pitch": Quantity("pitch Ω", "rad", 1, "displacements"),
    "vX": Quantity("forward velocity", "m/s", 1, "velocities"),
    "vY": Quantity("lateral velocity", "m/s", 1, "velocities"),
    "vZ": Quantity("vertical velocity", "m/s", 1, "velocities"),
    "roll_rate": Quantity("roll velocity", "mrad/s", 1e3, "velocities"),
    "pitch_rate": Quantity("pitch velocity", "rad/s", 1, "velocities"),
    "aY": Quantity("lateral acceleration", "m/s²", 1, "accelerations"),
    "aZ": Quantity("vertical acceleration", "m/s²", 1, "accelerations"),
    "roll_acc": Quantity("roll acceleration", "rad/s²", 1, "accelerations"),
    "F_ext": Quantity("external lateral force", "kN", 1e-3, "loads"),
    "M_gyro": Quantity("gyroscopic moment", "N·m", 1, "loads"),
    "KE_long": Quantity("kinetic energy, forward", "J", 1, "energies"),
    "KE_lat": Quantity("kinetic energy, lateral", "J", 1, "energies"),
    "KE_vert": Quantity("kinetic energy, vertical", "J", 1, "energies"),
    "KE_roll": Quantity("kinetic energy, roll", "J", 1, "energies"),
    "KE_pitch": Quantity("kinetic energy, pitch", "J", 1, "energies"),
    "PE_grav": Quantity("potential energy, gravity", "J", 1, "energies"),
    "PE_load": Quantity("potential energy, vertical load", "J", 1, "energies"),
    "PE_elastic_L": Quantity("elastic energy, left wheel", "J", 1, "energies"),
    "PE_elastic_R": Quantity("elastic energy, right wheel", "J", 1, "energies"),
    "W_ext": Quantity("work of the lateral force", "J", 1, "energies"),
    "E_total": Quantity("total energy", "J", 1, "energies"),
    "E_drift": Quantity("energy drift", "J", 1, "energies"),
    "E_lost": Quantity("energy lost in impacts", "J", 1, "energies"),
}
PER_CONTACT = {
    "N": Quantity("normal force", "kN", 1e-3, "normal forces"),
    "Fz": Quantity("vertical force", "kN", 1e-3, "vertical forces"),
    "Fy": Quantity("lateral force", "kN", 1e-3, "lateral forces"),
    "angle": Quantity("contact angle", "°", DEG, "contact angles"),
    "y": Quantity("lateral position", "mm", 1e3, "contact positions"),
    "z": Quantity("vertical position", "mm", 1e3, "contact positions"),
    "radius": Quantity("rolling radius", "mm", 1e3, "rolling radii"),
    "P": Quantity("impulses so far", "kN·s", 1e-3, "impulses"),
}
GROUPS = ("displacements", "velocities", "accelerations", "normal forces", "vertical forces", "lateral forces",
          "contact angles", "contact positions", "rolling radii", "impulses", "loads", "energies", "other columns")

# How a quantity is shown of which nothing but the SI unit is known, and the SI unit of what is shown.
SHOWN = {"m": ("mm", MM), "N": ("kN", KN), "N.s": ("kN·s", KN), "m/s2": ("m/s²", 1.0), "rad/s2": ("rad/s²", 1.0), "1": ("", 1.0)}
SI = {"mm": "m", "mm²": "m2", "MPa": "Pa", "kN": "N", "kN·s": "N.s", "N·s": "N.s", "ms": "s", "mrad": "rad", "mrad/s": "rad/s",
      "°": "rad", "µs": "s", "m/s²": "m/s2", "rad/s²": "rad/s2", "N·m": "N.m", "": "1"}

# Answers of a run. The core computes them and writes them to &setup and &results; `answers.py` finds them in rows of other codes.
# Digits below zero stand for an exponent.
OUTCOME = {
    **{f"t_first_{c}": Quantity(f"first contact of the {words}", "s", 1, digits=6, short=f"first {words} contact")
       for c, words in CONTACT_NAMES.items()},
    "t_first_centre": Quantity("first passage of the centre after a flange contact", "s", 1, digits=6,
                               short="first passage of the centre"),
    "t_return": Quantity("return to the centre after turning back on both sides", "s", 1, digits=6, short="return to the centre"),
    "t_unloaded": Quantity("last force of the wheel that lifts for good", "s", 1, digits=3, short="lift for good"),
    "F_unloaded": Quantity("lateral force at which a wheel lifts for good", "kN", KN, digits=1,
                           short="lateral force, lift for good"),
    "t_derailment": Quantity("derailment", "s", 1, digits=3, short="derailment"),
    "F_derailment": Quantity("lateral force at derailment", "kN", KN, digits=1, short="lateral force at derailment"),
    **{f"F_limit_{way}": Quantity(f"static limit of the lateral force, {way}", "kN", KN, digits=2,
                                  short="static limit of the lateral force") for way in ("left", "right")},
    "farthest_left": Quantity("Y, largest", "mm", MM, short="largest Y"),
    "farthest_right": Quantity("Y, smallest", "mm", MM, short="smallest Y"),
    "farthest_up": Quantity("Z, largest", "mm", MM, short="largest Z"),
    "farthest_down": Quantity("Z, smallest", "mm", MM, short="smallest Z"),
    "largest_roll": Quantity("Φ, largest", "mrad", 1e3, short="largest Φ"),
    "smallest_roll": Quantity("Φ, smallest", "mrad", 1e3, short="smallest Φ"),
    **{f"peak_N_{c}": Quantity(f"peak N, {words}", "kN", KN, short=f"peak N, {words}")
       for c, words in CONTACT_NAMES.items()},
    **{key: value for c, words in CONTACT_NAMES.items() for key, value in {
        f"first_peak_N_{c}": Quantity(f"peak N, first contact, {words}", "kN", KN),
        f"first_duration_{c}": Quantity(f"duration, first contact, {words}", "ms", 1e3),
        f"first_impulse_{c}": Quantity(f"impulse, first contact, {words}", "N·s", 1)}.items()},
    **{key: value for c in ("LF", "RF") for key, value in {
        f"turn_impulse_{c}": Quantity(f"impulse until the wheelset moves back, {CONTACT_NAMES[c]}", "kN·s", KN),
        f"pmax_{c}": Quantity(f"peak pressure, first contact, {CONTACT_NAMES[c]}", "MPa", 1e-6, digits=0,
                              short=f"peak pressure, {CONTACT_NAMES[c]}"),
        f"patch_{c}": Quantity(f"patch area, first contact, {CONTACT_NAMES[c]}", "mm²", 1e6, digits=0,
                               short=f"patch area, {CONTACT_NAMES[c]}"),
        f"approach_{c}": Quantity(f"approach, first contact, {CONTACT_NAMES[c]}", "mm", MM,
                                  short=f"approach, {CONTACT_NAMES[c]}")}.items()},
    "pmax": Quantity("largest pressure of the run", "MPa", 1e-6, digits=0, short="largest pressure"),
    "t_pmax": Quantity("time of the largest pressure", "s", 1, digits=6),
    "pmax_contact": Quantity("contact of the largest pressure", "", 1),
    "pmax_y": Quantity("lateral position of the largest pressure", "mm", MM),
    "pmax_z": Quantity("vertical position of the largest pressure", "mm", MM),
    "n_left_flange_contact": Quantity("contacts of the left flange", "", 1, digits=0),
    "n_right_flange_contact": Quantity("contacts of the right flange", "", 1, digits=0),
    "n_left_wheel_lift_off": Quantity("lift-offs of the left wheel", "", 1, digits=0, short="lift-offs, left wheel"),
    "n_right_wheel_lift_off": Quantity("lift-offs of the right wheel", "", 1, digits=0, short="lift-offs, right wheel"),
    "drift": Quantity("largest energy drift", "J", 1, digits=-1),
    "drift_relative": Quantity("the drift over initial kinetic energy or work", "", 1, digits=-1, short="energy drift, relative"),
    "step": Quantity("time step", "µs", 1e6, digits=0),
    "t": Quantity("end of the run", "s", 1, digits=6),
    # The comparison of formulations and ensembles have these.
    "lift_offs": Quantity("lift-offs of both wheels", "", 1, digits=0),
    "lost": Quantity("energy lost", "J", 1),
    "F_pulls": Quantity("lateral force from which a rail pulls", "kN", KN),
    "kinetic_energy": Quantity("initial kinetic energy, lateral, vertical and roll", "J", 1),
    "drift_reference": Quantity("initial kinetic energy, or largest work of the lateral force", "J", 1),
    "event_time": Quantity("time of an event", "s", 1),
    "event_force": Quantity("lateral force at an event", "kN", KN),
    "clearance_left": Quantity("rigid-axle flange clearance to the left", "mm", MM, digits=3),
    "clearance_right": Quantity("rigid-axle flange clearance to the right", "mm", MM, digits=3),
    "axle_height": Quantity("height of the axle at rest", "mm", MM),
    "axle_roll": Quantity("roll of the axle at rest", "mrad", 1e3),
    "rest_Y": Quantity("Y where nothing holds the wheelset", "mm", MM),
    "rest_Z": Quantity("Z where nothing holds the wheelset", "mm", MM),
    "rest_roll": Quantity("Φ where nothing holds the wheelset", "mrad", 1e3),
    **{f"frequency_{k}": Quantity(f"eigenfrequency {k} at rest", "Hz", 1) for k in (1, 2, 3)},
    **{f"peak_P_{c}": Quantity(f"largest impulse, {words}", "kN·s", KN) for c, words in CONTACT_NAMES.items()},
}


def quantity(column: str, unit: str = "") -> Quantity:
    """A column in words. An unknown one goes by its own name; `unit` is its SI unit."""
    if column in COLUMNS:
        return COLUMNS[column]
    beginning, _, contact = column.rpartition("_")
    if contact in CONTACTS:
        name = CONTACT_NAMES[contact]
        if beginning in PER_CONTACT:
            known = PER_CONTACT[beginning]
            return known._replace(words=f"{known.words}, {name}")
        return Quantity(f"{beginning}, {name}", *SHOWN.get(unit, (unit, 1.0)), "other columns")
    return Quantity(column, *SHOWN.get(unit, (unit, 1.0)), "other columns")


def si_unit(result: str) -> str:
    """The SI unit of a result; '1' for a number without unit, '' for what is not known."""
    if result.startswith("t_"):
        return "s"
    known = OUTCOME.get(result)
    return SI.get(known.unit, known.unit) if known else ""
