"""What columns are called, in words, and the units they are shown in."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..table import CONTACT_NAMES, CONTACTS


@dataclass(frozen=True)
class Label:
    words: str
    unit: str
    scale: float        # from SI to the unit
    group: str


COLUMNS = {
    "X": Label("distance X", "m", 1, "displacements"),
    "Y": Label("lateral displacement Y", "mm", 1e3, "displacements"),
    "Z": Label("vertical displacement Z", "mm", 1e3, "displacements"),
    "roll": Label("roll Φ", "mrad", 1e3, "displacements"),
    "pitch": Label("pitch Ω", "rad", 1, "displacements"),
    "vX": Label("forward velocity", "m/s", 1, "velocities"),
    "vY": Label("lateral velocity", "m/s", 1, "velocities"),
    "vZ": Label("vertical velocity", "m/s", 1, "velocities"),
    "roll_rate": Label("roll velocity", "mrad/s", 1e3, "velocities"),
    "pitch_rate": Label("pitch velocity", "rad/s", 1, "velocities"),
    "aY": Label("lateral acceleration", "m/s²", 1, "accelerations"),
    "aZ": Label("vertical acceleration", "m/s²", 1, "accelerations"),
    "roll_acc": Label("roll acceleration", "rad/s²", 1, "accelerations"),
    "F_ext": Label("external lateral force", "kN", 1e-3, "loads"),
    "M_gyro": Label("gyroscopic moment", "N·m", 1, "loads"),
    "KE_long": Label("kinetic energy, forward", "J", 1, "energies"),
    "KE_lat": Label("kinetic energy, lateral", "J", 1, "energies"),
    "KE_vert": Label("kinetic energy, vertical", "J", 1, "energies"),
    "KE_roll": Label("kinetic energy, roll", "J", 1, "energies"),
    "KE_pitch": Label("kinetic energy, pitch", "J", 1, "energies"),
    "PE_grav": Label("potential energy, gravity", "J", 1, "energies"),
    "PE_load": Label("potential energy, vertical load", "J", 1, "energies"),
    "PE_elastic_L": Label("elastic energy, left wheel", "J", 1, "energies"),
    "PE_elastic_R": Label("elastic energy, right wheel", "J", 1, "energies"),
    "W_ext": Label("work of the lateral force", "J", 1, "energies"),
    "E_total": Label("total energy", "J", 1, "energies"),
    "E_drift": Label("energy drift", "J", 1, "energies"),
}
PER_CONTACT = {
    "N": Label("normal force", "kN", 1e-3, "normal forces"),
    "Fz": Label("vertical force", "kN", 1e-3, "vertical forces"),
    "Fy": Label("lateral force", "kN", 1e-3, "lateral forces"),
    "angle": Label("contact angle", "°", 180/np.pi, "contact angles"),
    "y": Label("lateral position", "mm", 1e3, "contact positions"),
    "z": Label("vertical position", "mm", 1e3, "contact positions"),
    "radius": Label("rolling radius", "mm", 1e3, "rolling radii"),
}
GROUPS = ("displacements", "velocities", "accelerations", "normal forces", "vertical forces", "lateral forces",
          "contact angles", "contact positions", "rolling radii", "loads", "energies", "other columns")
SHOWN = {"m": ("mm", 1e3), "N": ("kN", 1e-3), "m/s2": ("m/s²", 1.0), "rad/s2": ("rad/s²", 1.0), "1": ("", 1.0)}


def label(column: str, unit: str = "") -> Label:
    """Of a column that has `unit` in SI; of an unknown one, its own name."""
    if column in COLUMNS:
        return COLUMNS[column]
    quantity, _, contact = column.rpartition("_")
    if contact in CONTACTS:
        name = CONTACT_NAMES[contact]
        if quantity in PER_CONTACT:
            known = PER_CONTACT[quantity]
            return Label(f"{known.words}, {name}", known.unit, known.scale, known.group)
        return Label(f"{quantity}, {name}", *SHOWN.get(unit, (unit, 1.0)), "other columns")
    return Label(column, *SHOWN.get(unit, (unit, 1.0)), "other columns")
