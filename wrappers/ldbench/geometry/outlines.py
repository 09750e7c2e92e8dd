"""Outlines of wheels and rails, placed by the core: the one placement for plots, films and pages."""
from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .._core.errors import Error
from ..case import Case
from ..profiles.profile import checksum
from ..results.run_data import RunData
from ..table import Curve, core_files, placed_outlines


@dataclass(frozen=True)
class Side:
    """A wheel in the frame of the wheelset, origin at the axle centre, and its rail in the frame of the track, (n, 2) [m], Y
    outward and Z up: the right side as its mirror image."""

    wheel: np.ndarray
    rail: np.ndarray


@dataclass(frozen=True)
class Outlines:
    """Both sides; height [m] and roll [rad] of the axle from which the columns Z and roll are measured; rigid-axle flange clearance
    to the left and to the right [m]."""

    left: Side
    right: Side
    axle: float
    roll: float
    clearance: tuple[float, float]

    @property
    def sides(self) -> tuple[tuple[Side, int], ...]:
        """The sides with the sign of Y: 1 left, -1 right."""
        return (self.left, 1), (self.right, -1)


def turned(points: np.ndarray, y: float, z: float, roll: float) -> np.ndarray:
    """Points of the wheelset, (n, 2), in the track frame, with the axle centre at (y, z) [m]."""
    c, s = np.cos(roll), np.sin(roll)
    return points @ np.array([[c, s], [-s, c]]) + [y, z]


def case_outlines(case: Case, curve: Curve = "run") -> Outlines:
    """The outlines of a case's profiles; the axle is that of the rigid wheelset on both rails. Error where a run would
    refuse them."""
    (left, right), axle, roll, clearance = placed_outlines(case, curve)
    return Outlines(Side(*left), Side(*right), axle, roll, clearance)


def run_outlines(run: RunData, assumed: RunData | Case | None = None) -> tuple[Outlines | None, str]:
    """The outlines of a run, and a remark where the files are not those of the run; or None, and why.

    assumed: the run or case whose profiles stand for those of a file without ldbench's header.
    """
    source = assumed if assumed is not None and not run.is_ours else run
    try:
        case = source.case if isinstance(source, RunData) else source
    except Error as error:
        return None, f"no outlines: {error}"
    files = {name: Path(path) for name, path in case.profile_files().items()}
    missing = dict.fromkeys(str(getattr(case, name)) for name, file in files.items() if not file.is_file())
    if missing:
        return None, f"no outlines: {' and '.join(missing)} not found"
    try:
        outlines = case_outlines(case)
    except Error:               # not profiles, or not such that fit
        names = " and ".join(dict.fromkeys(file.name for file in files.values()))
        return None, f"no outlines: {names} cannot be placed"
    if not isinstance(source, RunData):
        return outlines, ""
    changed = dict.fromkeys(file.name for name, file in files.items() if not fits(case, source, name))
    remark = f"{' and '.join(changed)} changed since the run" if changed else ""
    told = source.results
    return replace(outlines, axle=told["axle_height"], roll=told["axle_roll"],
                   clearance=(told["clearance_left"], told["clearance_right"])), remark


def pose(run: RunData, k: int) -> tuple[float, float, float]:
    """Axle centre and roll angle in the track frame at row k [m, m, rad]."""
    axle, roll = run.results["axle_height"], run.results["axle_roll"]
    return run.values("Y")[k], axle + run.values("Z")[k], roll + run.values("roll")[k]


def flange_angle(side: Side) -> float:
    """The steepest angle of the flange's face towards the rail [rad]: between the tip and the height of the top of rail, in
    the pose in which the tread stands on the rail, the outline rises outwards."""
    y, z = side.wheel.T
    tip = int(z.argmin())
    outer = np.argsort(y[y >= y[tip]], kind="stable")
    y, z = y[y >= y[tip]][outer], z[y >= y[tip]][outer]
    rise, run = np.diff(z), np.diff(y)
    return float(np.arctan2(rise, run)[(rise > 0) & (run >= 0)].max())


def stated_profile(run: RunData, variable: str) -> str:
    """What the header says of the profile of a variable: 'awprof.yz, CRC-32 9FA7E873'."""
    what = variable.partition("_")[0]
    side = "right" if variable.endswith("_right") else "left"
    return run.header.profiles.get(f"{side} {what}", run.header.profiles.get(what, ""))


def fits(case: Case, run: RunData, variable: str) -> bool:
    """Whether a profile of a run's case, by its variable, has the checksum that the run's header gives."""
    stated = re.search(r"CRC-32 ([0-9A-F]{8})", stated_profile(run, variable))
    return not stated or checksum(Path(core_files(case)[variable]).read_bytes()) == stated[1]
