"""Reference wheels and the reference rail of EN 15302:2021, annex I, as formulas, and their points as profile files.

A zone holds from its first y on [mm], y = 0 on the tape circle of a wheel and on the line of the rail above which the tape
circle of the centred wheel stands; depth grows downwards [mm]. A zone is a line (value at y = 0, slope), or an arc (y and depth
of its centre, radius, side: 1 below the centre, -1 above it).

The last zone of wheel C begins at 59 mm with the depth with which the zone before it ends.
"""
from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

import en15302_tables
from ldbench import Case
from ldbench.conicity import level_rows
from ldbench.geometry.pair import raised_surfaces, rigid_geometry

TAPE_CIRCLES = 1.5          # distance between the tape circles, and between the lines of the rails [m]
TAPE_CIRCLE = 70.0          # of a wheel, from its back [mm]
RADIUS = 0.46               # on the tape circle [m]
SMALLER = 0.459             # of the right wheel in the combinations with diameters of 920 mm and 918 mm [m]
GAUGE_DEPTH = 14.0          # below the top of the rail [mm]
NEAR = 1e-4                 # to which displacements are known where the contact jumps [mm]
FINE, GROWTH, STEP = 0.005, 1.2, 0.1     # distance between points at the ends of a zone, its growth, largest distance [mm]


@dataclass(frozen=True)
class Arc:
    """Part of a circle [mm]."""

    y: float
    depth: float
    radius: float
    side: int

    def __call__(self, y: np.ndarray) -> np.ndarray:
        return self.depth + self.side*np.sqrt(np.maximum(self.radius**2 - (y - self.y)**2, 0))


@dataclass(frozen=True)
class Line:
    """A line [mm]."""

    at_zero: float
    slope: float

    def __call__(self, y: np.ndarray) -> np.ndarray:
        return self.at_zero + self.slope*y


Zones = dict[float, Arc | Line]
NARROW = 14375**0.5         # depth of the centre of a wheel I's throat [mm]
ENDS = {"A": 65.0, "B": 65.0, "C": 65.0, "H": 65.0, "I": 65.0, "rail": 39.2705}     # last y of a profile [mm]
PROFILES: dict[str, Zones] = {
    "A": {-70.0: Arc(-49.5, 9.51926, 20.5, 1), -62.7647: Arc(-55.0, 16.00065, 12.0, 1), -49.6625: Arc(-58.5583, 8.83556, 20.0, 1),
          -39.7645: Line(-93.57685, -2.7475), -38.7372: Arc(-25.5816, 17.64215, 14.0, -1),
          -29.4591: Arc(-2.6594, 97.16493, 96.76055, -1), -10.8749: Arc(18.4173, 344.50806, 345.0, -1),
          18.4173: Line(-0.49194, 0.0), 30.0: Line(1.50804, -0.066666), 60.0: Line(57.50808, -1.0)},
    "B": {-70.0: Arc(-49.5, 9.5193, 20.5, 1), -62.7647: Arc(-55.0, 16.0, 12.0, 1), -49.6625: Arc(-58.5583, 8.8349, 20.0, 1),
          -39.764: Line(-93.5767, -2.7475), -38.7879: Arc(-25.6322, 17.7814, 14.0, -1), -29.3505: Arc(2.5204, 119.9745, 120.0, -1),
          -0.4787: Line(0.0, -0.025), 30.0: Line(0.75, -0.05), 60.0: Line(57.75, -1.0)},
    "C": {-70.0: Line(21.39173 + 7.11537*69.40268, 7.11537), -69.4027: Arc(-59.5, 20.00006, 10.0, 1),
          -59.5: Arc(-60.4941, 12.02753, 18.0, 1), -43.8048: Line(11.96051 - 2.47508685*41.05339, -2.47508685),
          -41.0534: Arc(-29.0, 16.830365, 13.0, -1), -32.3621: Arc(-6.5, 100.870534, 100.0, -1),
          -17.587: Arc(19.0, 329.45258, 330.0, -1), 19.0: Line(-0.54742374, 0.0), 29.0: Line(-0.54742374 + 2.9, -0.1),
          59.0: Line(-3.54742374 + 59.0, -1.0)},
    "H": {-70.0: Arc(-49.5, 9.5193, 20.5, 1), -62.7647: Arc(-55.0, 16.0, 12.0, 1), -49.6625: Arc(-58.5583, 8.8349, 20.0, 1),
          -39.7645: Line(-93.5767, -2.7475), -38.722: Arc(-25.5663, 17.6003, 14.0, -1), -28.3119: Line(-1.7902, -0.2),
          -10.2297: Line(0.0, -0.025), 30.0: Line(1.251, -0.0667), 60.0: Line(57.249, -1.0)},
    "I": {-70.0: Arc(-49.5, 9.51929, 20.5, 1), -62.7647: Arc(-55.0, 16.00054, 12.0, 1), -49.6625: Arc(-58.5583, 8.83545, 20.0, 1),
          -39.764: Line(-93.5767, -2.7475), -39.0486: Arc(-25.8929, 18.49733, 14.0, -1), -29.9231: Arc(5.0, NARROW, 120.0, -1),
          5.0: Line(NARROW - 120.0, 0.0), 30.0: Line(1.89679, -0.0667), 60.0: Line(57.89479, -1.0)},
    "rail": {-32.634: Arc(-19.63949, 15.899044, 13.0, -1), -23.2401: Arc(-1.0825, 80.277908, 80.0, -1),
             -7.8749: Arc(17.5966, 299.48349, 300.0, -1), 13.0989: Arc(14.29829, 79.508225, 80.0, -1),
             28.6709: Arc(26.33535, 13.598369, 13.0, -1)}}
# Wheel A without the step with which two of its zones meet: the throat is moved onto the tread's zone.
STEP_AT = -29.4591
_throat, _tread = PROFILES["A"][-38.7372], PROFILES["A"][STEP_AT]
PROFILES["A closed"] = PROFILES["A"] | {-38.7372: replace(_throat, depth=_throat.depth + _tread(STEP_AT) - _throat(STEP_AT))}
ENDS["A closed"] = ENDS["A"]


def depth(name: str, y: np.ndarray) -> np.ndarray:
    """Depth of a profile at y [mm]."""
    zones = list(PROFILES[name].values())
    which = np.clip(np.searchsorted(list(PROFILES[name]), y, "right") - 1, 0, len(zones) - 1)
    return np.select([which == k for k in range(len(zones))], [zone(y) for zone in zones])


def points(name: str) -> np.ndarray:
    """Points of a profile, (n, 2) [mm], y from a wheel's back or from the rail's line, z up: dense where zones meet."""
    found = []
    for (first, zone), last in zip(PROFILES[name].items(), [*list(PROFILES[name])[1:], ENDS[name]], strict=True):
        y = np.linspace(first, last, 20001)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(zone(y))))])
        half = np.concatenate([[0.0], np.cumsum(np.minimum(FINE*GROWTH**np.arange(1000), STEP))])
        half = half[half < along[-1]/2 - FINE]
        y = np.interp([*half, *(along[-1] - half[::-1])], along, y)
        found.append(np.column_stack([y, -zone(y)])[bool(found):])
    return np.vstack(found) + [0.0 if name == "rail" else TAPE_CIRCLE, 0.0]


@cache
def gauge() -> float:
    """Distance between two rails, GAUGE_DEPTH below their top [m]."""
    y = np.linspace(-32.634, 39.2705, 2_000_001)
    down = depth("rail", y)
    side = y < y[np.argmin(down)]
    return TAPE_CIRCLES + 2e-3*float(np.interp(-np.min(down) - GAUGE_DEPTH, -down[side], y[side]))


def write(folder: Path) -> dict[str, str]:
    """Write all profiles; their paths by name."""
    paths = {}
    for name in PROFILES:
        paths[name] = str(folder/f"en15302_{name.replace(' ', '_')}.yz")
        np.savetxt(paths[name], points(name), fmt="%.9f")
    return paths


def case(combination: str, paths: dict[str, str]) -> Case:
    """The case of a combination, named as in ldbench.geometry.en15302: its right wheel is our left one."""
    left, _, right = combination.removesuffix("-918").partition("-")
    return Case.from_namelist("&case /").replace(
        wheel_profile=paths[left], wheel_profile_right=paths[right] if right else "", rail_profile=paths["rail"],
        gauge=gauge(), gauge_depth=1e-3*GAUGE_DEPTH, back_to_back=TAPE_CIRCLES - 2e-3*TAPE_CIRCLE, rolling_radius=RADIUS,
        table_file="")


def radii(combination: str) -> tuple[float, float]:
    """Radii of both wheels on the tape circle [m]."""
    return RADIUS, SMALLER if combination.endswith("-918") else RADIUS


def deviations(combination: str, paths: dict[str, str]) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of a combination's table [mm] and by how much the level wheelset's radius difference is off it [um].

    Misprints are put right. Where the radius difference jumps at a displacement of the table, either end of the jump counts.    """
    y, printed = en15302_tables.table(combination)
    meant = [en15302_tables.MISPRINTS.get((combination, y_k), value) for y_k, value in zip(y.tolist(), printed, strict=True)]
    made = case(combination, paths)
    handle = rigid_geometry(made)
    raised = raised_surfaces(made, handle, radii(combination))
    off = [1e6*level_rows(handle, 1e-3*(y + near), raised)[7] - 1e3*np.array(meant) for near in (-NEAR, 0.0, NEAR)]
    return y, np.min(np.abs(off), axis=0)
