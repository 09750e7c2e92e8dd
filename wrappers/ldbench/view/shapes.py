"""Outlines of wheel and rail for the scene, placed as the core places them."""
from __future__ import annotations

import re
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .._core import Error
from ..outlines import find_profile, place_rail, read_profile
from ..record import Record, Setting

Settings = Mapping[str, Mapping[str, Setting]]

FLANK = np.radians(20)      # steeper parts of wheel and rail may touch as a flange


@dataclass(frozen=True)
class Side:
    """A wheel, origin at the axle centre, and its rail in the frame of the track, (n, 2) [m], as on the left: the right
    side is the mirror image of its own.  flank: the wheel's flange where it faces the rail; gauge: the rail's side that
    it meets, from below."""
    wheel: np.ndarray
    rail: np.ndarray
    flank: np.ndarray
    gauge: np.ndarray


@dataclass(frozen=True)
class Shape:
    """Both sides, and height [m] and roll [rad] of the axle where the centred wheelset rests."""
    left: Side
    right: Side
    axle: float
    roll: float


class Placing(NamedTuple):
    """Settings that name profiles and place them; height [m] and roll [rad] of the centred axle at rest, NaN where not
    known."""
    settings: Settings
    axle: float = np.nan
    roll: float = np.nan


def shape(record: Record, placing: Placing) -> tuple[Shape | None, str]:
    """The outlines that the settings name, looked for as `record` would; or None, and why.  A remark otherwise, if the
    files are not those of the run."""
    settings = placing.settings
    placed = replace(record, settings=settings)
    found = {(which, right): find_profile(placed, which, right)
             for right in (False, True) for which in ("wheel", "rail")}
    named = settings.get("profiles", {})
    missing = dict.fromkeys(str((right and named.get(f"{which}_profile_right")) or named.get(f"{which}_profile", "?"))
                            for (which, right), file in found.items() if not file)
    files = {side: file for side, file in found.items() if file}
    if missing:
        return None, f"no outlines: {' and '.join(missing)} not found"
    changed = dict.fromkeys(file.name for (which, right), file in files.items()
                            if not fits(file, stated_profile(record, which, right)))
    try:
        (left, height, y), (right, height_right, y_right) = (
            place_side(files["wheel", right], files["rail", right], placed) for right in (False, True))
    except (Error, ValueError, IndexError):     # not profiles
        names = " and ".join(dict.fromkeys(file.name for file in files.values()))
        return None, f"no outlines: {names} cannot be placed"
    remark = f"{' and '.join(changed)} changed since the run" if changed else ""
    if np.isnan(placing.axle):          # rigid, on both rails; the sides' heights differ by some micrometres
        axle, roll = (height*y_right + height_right*y)/(y + y_right), (height - height_right)/(y + y_right)
        return Shape(left, right, axle, roll), remark
    return Shape(left, right, placing.axle, placing.roll), remark


def place_side(wheel_file: Path, rail_file: Path, record: Record) -> tuple[Side, float, float]:
    """A side, the height of the axle at which its rigid centred wheel touches, and how far outward it does [m]."""
    profiles = record.settings["profiles"]
    rail = place_rail(read_profile(rail_file, "rail", profiles), record.number("track", "gauge"),
                      record.number("track", "gauge_depth"))
    wheel = read_profile(wheel_file, "wheel", profiles) + [record.number("wheelset", "back_to_back")/2, 0.0]
    wheel, height, y = place_wheel(wheel, rail, record.number("wheelset", "rolling_radius"))
    return Side(wheel, rail, *facing(wheel, rail)), height, y


def stated_profile(record: Record, which: str, right: bool) -> str:
    """What the header says of a profile: 'awprof.yz, CRC-32 9FA7E873'."""
    return record.profiles.get(f"{'right' if right else 'left'} {which}", record.profiles.get(which, ""))


def fits(file: Path, described: str) -> bool:
    """Whether a profile has the checksum that the header gives, before what it says of format and mending."""
    stated = re.search(r"CRC-32 ([0-9A-F]{8})", described)
    return not stated or checksum(file) == stated[1]


def checksum(file: Path) -> str:
    """Of a profile's lines, as the core computes it: tabs are blanks, line ends are one newline."""
    lines = file.read_bytes().replace(b"\t", b" ").splitlines()
    return f"{zlib.crc32(b''.join(line + bytes([10]) for line in lines)):08X}"


def upper_side(points: np.ndarray, reach: float) -> np.ndarray:
    """The points down to `reach` below the highest, by ascending y."""
    top = points[points[:, 1] > points[:, 1].max() - reach]
    return top[np.argsort(top[:, 0], kind="stable")]


def place_wheel(wheel: np.ndarray, rail: np.ndarray, radius: float) -> tuple[np.ndarray, float, float]:
    """The wheel with its origin at the axle centre, the height of the axle of the rigid centred wheelset, and y of the
    point which touches then: the radius is the point's."""
    by_y = wheel[np.argsort(wheel[:, 0], kind="stable")]
    head = upper_side(rail, 0.01)
    y = np.arange(head[0, 0], head[-1, 0], 1e-6)
    under = np.interp(y, by_y[:, 0], by_y[:, 1])
    on = np.interp(y, head[:, 0], head[:, 1])
    touching = int(np.argmin(under - on))
    return wheel - [0.0, under[touching] + radius], radius + on[touching], y[touching]


def facing(wheel: np.ndarray, rail: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The flange's outer side and the rail's gauge side, where they are steep, each from below."""
    by_y = wheel[np.argsort(wheel[:, 0], kind="stable")]
    outer = by_y[int(np.argmin(by_y[:, 1])):]
    return steep(outer), steep(gauge_side(rail))


def gauge_side(rail: np.ndarray) -> np.ndarray:
    """From below up to the top."""
    top = int(np.argmax(rail[:, 1]))
    inner = rail[:top + 1] if rail[0, 0] < rail[-1, 0] else rail[top:]
    return inner[np.argsort(inner[:, 1], kind="stable")]


def steep(points: np.ndarray) -> np.ndarray:
    """The connected stretch that begins with the first steep piece."""
    d = np.diff(points, axis=0)
    pieces = np.flatnonzero(np.arctan2(d[:, 1], np.abs(d[:, 0])) > FLANK)
    return points[pieces[0]:pieces[-1] + 2] if pieces.size else points[:0]
