"""Outlines of wheels and rails of a run, read as the core reads them and placed as it places them."""
from __future__ import annotations

import functools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ._core import Error, digest
from .case import data_folder
from .profile import inspect
from .record import Record, Setting


@dataclass(frozen=True)
class Section:
    """The left wheel in the frame of the wheelset, origin at the axle centre, and the left rail in
    the frame of the track; each an array of points (n, 2) [m], Y left and Z up. Of the right side the
    mirror images, None: as the left one."""
    wheel: np.ndarray
    rail: np.ndarray
    right_wheel: np.ndarray | None = None
    right_rail: np.ndarray | None = None

    def wheel_at(self, y: float, z: float, roll: float, right: bool = False) -> np.ndarray:
        """The wheel's points in the track frame, with the axle centre at (y, z) [m]."""
        points = self.mirrored(self.wheel, self.right_wheel) if right else self.wheel
        c, s = np.cos(roll), np.sin(roll)
        return points @ np.array([[c, s], [-s, c]]) + [y, z]

    def rail_at(self, right: bool = False) -> np.ndarray:
        return self.mirrored(self.rail, self.right_rail) if right else self.rail

    @staticmethod
    def mirrored(left: np.ndarray, right: np.ndarray | None) -> np.ndarray:
        return (left if right is None else right)*[-1, 1]


def read_profile(path: str | Path, kind: str, settings: Mapping[str, Setting]) -> np.ndarray:
    """The points of a profile file of any format, (n, 2) [m], as the core takes them; `settings` are those of &profiles.
    Raises Error where a run would."""
    flip, unit = (str(settings.get(f"{kind}_{what}") or "auto") for what in ("flip", "unit"))
    content = ""
    with suppress(OSError):             # the core says what is wrong
        content = digest(Path(path).read_bytes())
    return 1e-3*_points(str(path), content, kind, flip, unit)


@functools.lru_cache
def _points(file: str, content: str, kind: str, flip: str, unit: str) -> np.ndarray:
    """Points [mm] of a file with that content."""
    return inspect(file, kind, flip=flip, unit=unit).points


def find_profile(record: Record, which: str, right: bool = False) -> Path | None:
    """The profile file of a run: relative to here, to the column file, or a shipped one."""
    name = record.setting("profiles", f"{which}_profile")
    if right:
        name = record.setting("profiles", f"{which}_profile_right") or name
    folders = (Path(), record.file.parent, record.file.parent.parent, data_folder())
    with suppress(OSError):             # a name that no file can have
        return next((folder/str(name) for folder in folders if (folder/str(name)).is_file()), None) if name else None
    return None


def section(record: Record) -> Section | None:
    """Wheel and rail of a run, placed as the program places them; None if a file is missing."""
    two_sided = any(record.setting("profiles", f"{which}_profile_right") for which in ("wheel", "rail"))
    sides = [side_section(record, right) for right in ((False, True) if two_sided else (False,))]
    found = [outline for side in sides if side for outline in side]
    return Section(*found) if all(sides) else None


def side_section(record: Record, right: bool = False) -> tuple[np.ndarray, np.ndarray] | None:
    """Wheel and rail of a side, as on the left."""
    wheel_file, rail_file = (find_profile(record, which, right) for which in ("wheel", "rail"))
    if not (wheel_file and rail_file) or np.isnan(record.axle_height):
        return None
    files = record.settings.get("profiles", {})
    try:
        rail, wheel = read_profile(rail_file, "rail", files), read_profile(wheel_file, "wheel", files)
    except Error:
        return None
    rail = place_rail(rail, record.number("track", "gauge"), record.number("track", "gauge_depth"))
    wheel = wheel + [record.number("wheelset", "back_to_back")/2, 0.0]
    tread, side = ("RT", -1) if right else ("LT", 1)
    touching = np.flatnonzero(~np.isnan(record.values(f"y_{tread}")))
    if not touching.size:
        return None
    # The columns tell where a point of the tread is, seen from the axle centre.
    k = touching[0]
    y, z, roll = pose(record, k)
    dy = side*(record.values(f"y_{tread}")[k] - y)
    dz = record.values(f"z_{tread}")[k] - z
    c, s = np.cos(side*roll), np.sin(side*roll)
    along, across = c*dy + s*dz, c*dz - s*dy
    order = np.argsort(wheel[:, 0], kind="stable")
    wheel[:, 1] += across - np.interp(along, wheel[order, 0], wheel[order, 1])
    return wheel, rail


def place_rail(points: np.ndarray, gauge: float, depth: float) -> np.ndarray:
    """The left rail with its top at z = 0 and its gauge side, `depth` below, at half the gauge."""
    points = points - [0.0, points[:, 1].max()]
    above = points[:, 1] > -depth
    i = np.flatnonzero(above[1:] != above[:-1])
    if not i.size:
        raise Error(f"expected a rail with points {1e3*depth:g} mm below its top, &track gauge_depth, found none")
    share = (-depth - points[i, 1])/(points[i + 1, 1] - points[i, 1])
    gauge_side = (points[i, 0] + share*(points[i + 1, 0] - points[i, 0])).min()
    return points + [gauge/2 - gauge_side, 0.0]


def pose(record: Record, k: int) -> tuple[float, float, float]:
    """Axle centre and roll angle in the track frame at row k [m, m, rad]."""
    return (record.values("Y")[k], record.axle_height + record.values("Z")[k], record.axle_roll + record.values("roll")[k])
