"""Wheels on rails: measures, clearance and conicity of the program beside those of numpy from the raw points.

Of a wheel with noise the reference is its shape without it.

`PYTHONPATH=tests/support:profiles python tests/support/geometry_table.py` prints the table.
"""
from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import en15302
import shapes
from ldbench import Case, Profile
from ldbench.geometry.pair import pair
from rigid_numpy import Level, Rolled, read, turned, wheel_measures
from running import REPO

GAUGE, BACK_TO_BACK, DEPTH, RADIUS = 1435.0, 1360.0, 14.0, 457.0       # [mm]
CANT = float(np.arctan(1/40))
NAMES = "Sh", "Sd", "qR", "clearance", *(f"{kept} {mm} mm" for kept in ("level", "rolled") for mm in (1, 2, 3))
RELATIVE, ABSOLUTE = 0.03, 3e-3     # to which a conicity is that of the points
NEAR = 0.03                         # to which lengths are [mm]; a clearance to twice of it


def waved(points: np.ndarray, amplitude: float, length: float, phase: float = 0.0) -> np.ndarray:
    """Points moved along their normals by a wave of an amplitude and a length [mm]."""
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    return points + amplitude*np.sin(2*np.pi*s/length + phase)[:, None]*shapes.normals(points)


def cone(slope: float) -> np.ndarray:
    """Flange and throat of the wheel S1002 with a conical tread from where the throat is nearly as steep, (n, 2) [mm]."""
    wheel = read(REPO/"profiles/s1002.yz")
    angle = np.gradient(wheel[:, 1], wheel[:, 0])
    tip = wheel[:, 1].argmin()
    steepest = tip + angle[tip:].argmax()
    end = steepest + np.flatnonzero(angle[steepest:] < max(slope, 0.08))[0]
    run = np.arange(0.25, 135 - wheel[end, 0], 0.25)[:, None]
    return np.concatenate([wheel[:end + 1], wheel[end] + run*[1, slope]])


def wheels() -> dict[str, np.ndarray]:
    """Points of wheels, y from the back [mm]."""
    s1002, aw = read(REPO/"profiles/s1002.yz"), read(REPO/"profiles/awprof.yz")
    return {"S1002": s1002, "awprof": aw, "swprof": read(REPO/"profiles/swprof.yz"),
            "cone 1:20": cone(1/20), "cone 1:40": cone(1/40),
            "EN A": en15302.points("A closed"), "EN B": en15302.points("B"), "EN C": en15302.points("C")[2:],
            "EN H": en15302.points("H"), "EN I": en15302.points("I"),
            "S1002, thin flange": shapes.thin_flange(s1002), "S1002, noise 3 um": s1002,
            "S1002, waves 10 um": waved(s1002, 0.010, 6),
            "cone 1:40, waves 5 um": waved(cone(1/40), 0.005, 8, 1.0)}


def rails() -> dict[str, np.ndarray]:
    """Points of a rail as designs are published, upright, and with noise [mm]."""
    upright = turned(read(REPO/"profiles/60e1.yz"), -CANT)
    top = upright[:, 1].argmax()
    upright -= [np.interp(upright[top, 1] - DEPTH, upright[:top, 1], upright[:top, 0]), upright[top, 1]]
    return {"60E1": upright}


# Noise of the points that the program gets [mm]: it moves the contact of the raw points about.
NOISE = {"S1002, noise 3 um": 3e-3, "S1002, waves 10 um": 2e-4, "cone 1:40, waves 5 um": 4e-4}
LEANS = {"upright": 0.0, "1:40": CANT, "1:20": float(np.arctan(1/20))}
PAIRS = [(wheel, lean) for wheel in wheels() for lean in LEANS]


def numbers(wheel: str, lean: str, folder: Path) -> tuple[np.ndarray, np.ndarray, str]:
    """The program's numbers of a pair in the order of NAMES, those of numpy, and what the program notes of the wheel."""
    exact, rail = wheels()[wheel].round(6), rails()["60E1"].round(6)
    points = shapes.noisy(exact, NOISE[wheel], 1).round(6) if wheel in NOISE else exact
    for name, profile in ("wheel", points), ("rail", rail):
        (folder/f"{name}.yz").write_text(shapes.rows(profile, digits=6))
    source = Profile(folder/"wheel.yz", "wheel", wheel_back=0.0)
    found = pair(Case(wheel_profile=source, rail_profile=folder/"rail.yz", rail_inclination=lean if lean != "upright" else 0.0,
                      gauge=1e-3*GAUGE, back_to_back=1e-3*BACK_TO_BACK, rolling_radius=1e-3*RADIUS, gauge_depth=1e-3*DEPTH))
    ours = [*(1e3*source.measures[name] for name in ("Sh", "Sd", "qR")), 1e3*found.clearance[0],
            *(one.conicity_at(1e-3*mm) for one in (found.level, found.rolled) for mm in (1, 2, 3))]
    level = Level.of(exact, rail, LEANS[lean], GAUGE, BACK_TO_BACK, DEPTH)
    rolled = Rolled.of(level, RADIUS)
    theirs = [*wheel_measures(exact), rolled.clearance(), *(one.conicity(mm) for one in (level, rolled) for mm in (1.0, 2.0, 3.0))]
    return np.array(ours), np.array(theirs), "; ".join(source.notes)


def outside(ours: np.ndarray, theirs: np.ndarray) -> list[str]:
    """Names of the numbers that are farther from those of the points than they may be; a number that one of both lacks is."""
    bound = np.r_[NEAR, NEAR, NEAR, 2*NEAR, np.maximum(RELATIVE*np.abs(theirs[4:]), ABSOLUTE)]
    off = ~((np.abs(ours - theirs) <= bound) | (np.isnan(ours) & np.isnan(theirs)))
    return [name for name, one in zip(NAMES, off, strict=True) if one]


def table(folder: Path) -> Iterator[str]:
    """Lines of the table: the program's number, and that of the points behind a stroke."""
    yield "| wheel | 60E1 | " + " | ".join(NAMES) + " | off |"
    yield "| --- "*(len(NAMES) + 3) + "|"
    for wheel, lean in PAIRS:
        ours, theirs, _ = numbers(wheel, lean, folder)
        cells = (f"{one:.{digits}f} / {other:.{digits}f}" for one, other, digits in
                 zip(ours, theirs, [2]*4 + [3]*6, strict=True))
        yield f"| {wheel} | {lean} | " + " | ".join(cells) + f" | {', '.join(outside(ours, theirs)) or '–'} |"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        for line in table(Path(scratch)):
            print(line, flush=True)
