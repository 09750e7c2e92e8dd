"""Outlines of wheel and rail for the scene, placed as the core places them."""
from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .._core import Error
from ..record import Record, Setting

Settings = Mapping[str, Mapping[str, Setting]]

FLANK = np.radians(20)      # steeper parts of wheel and rail may touch as a flange


@dataclass(frozen=True)
class Shape:
    """The left wheel, origin at the axle centre, and the left rail in the frame of the track, (n, 2) [m]; the right
    side is the mirror image.  flank: the wheel's flange where it faces the rail; gauge: the rail's side that it
    meets, from below; axle: height of the axle centre of the centred wheelset [m]."""
    wheel: np.ndarray
    rail: np.ndarray
    flank: np.ndarray
    gauge: np.ndarray
    axle: float


def shape(record: Record, settings: Settings, axle: float = np.nan) -> tuple[Shape | None, str]:
    """The outlines that `settings` name, looked for as `record` would; or None, and why.  A remark otherwise, if the
    files are not those of the run."""
    from ..outlines import find_profile, place_rail, read_profile

    files = {which: find_profile(with_settings(record, settings), which) for which in ("wheel", "rail")}
    missing = [str(settings.get("profiles", {}).get(f"{which}_profile", "?")) for which in files if not files[which]]
    if missing:
        return None, f"no outlines: {' and '.join(missing)} not found"
    stated = {which: record.profiles.get(which, record.profiles.get(f"left {which}", "")) for which in files}
    changed = [file.name for which, file in files.items() if not fits(file, stated[which])]
    try:
        profiles = settings.get("profiles", {})
        rail = place_rail(read_profile(files["rail"], "rail", profiles), float(settings["track"]["gauge"]),
                          float(settings["track"]["gauge_depth"]))
        wheel = read_profile(files["wheel"], "wheel", profiles) + [float(settings["wheelset"]["back_to_back"])/2, 0.0]
        wheel, rigid = place_wheel(wheel, rail, float(settings["wheelset"]["rolling_radius"]))
    except (Error, ValueError, IndexError):     # not profiles
        return None, f"no outlines: {files['wheel'].name} and {files['rail'].name} cannot be placed"
    remarks = [f"{' and '.join(changed)} changed since the run"] if changed else []
    if any(settings.get("profiles", {}).get(f"{which}_profile_right") for which in files):
        remarks.append("both sides are drawn with the profiles of the left one")
    remark = "; ".join(remarks)
    return Shape(wheel, rail, *facing(wheel, rail), rigid if np.isnan(axle) else axle), remark


def with_settings(record: Record, settings: Settings) -> Record:
    return replace(record, settings=settings)


def fits(file: Path, described: str) -> bool:
    """Whether a profile has the checksum that the header gives: 'awprof.yz, CRC-32 9FA7E873'."""
    stated = described.rpartition("CRC-32 ")[2]
    return not stated or checksum(file) == stated


def checksum(file: Path) -> str:
    """Of a profile's lines, as the core computes it: tabs are blanks, line ends are one newline."""
    lines = file.read_bytes().replace(b"\t", b" ").splitlines()
    return f"{zlib.crc32(b''.join(line + bytes([10]) for line in lines)):08X}"


def upper_side(points: np.ndarray, reach: float) -> np.ndarray:
    """The points down to `reach` below the highest, by ascending y."""
    top = points[points[:, 1] > points[:, 1].max() - reach]
    return top[np.argsort(top[:, 0], kind="stable")]


def place_wheel(wheel: np.ndarray, rail: np.ndarray, radius: float) -> tuple[np.ndarray, float]:
    """The wheel with its origin at the axle centre, and the height of the axle of the rigid centred wheelset: the
    radius is that of the point which touches then."""
    by_y = wheel[np.argsort(wheel[:, 0], kind="stable")]
    head = upper_side(rail, 0.01)
    y = np.arange(head[0, 0], head[-1, 0], 1e-6)
    under = np.interp(y, by_y[:, 0], by_y[:, 1])
    on = np.interp(y, head[:, 0], head[:, 1])
    touching = int(np.argmin(under - on))
    return wheel - [0.0, under[touching] + radius], radius + on[touching]


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
