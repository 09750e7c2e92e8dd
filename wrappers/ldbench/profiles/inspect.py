"""Profiles and pairs before a run: what a file is taken for, its measures, what a wheel does on a rail."""
from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .._core import _flat
from .._core.calls import Handle, check, descriptions, path_bytes, text, text_bytes
from .._core.errors import Error
from ..case import Case
from ..conicity import FINE_PITCH, level_rows, rolled_rows
from ..results.quantities import DEG, MM
from ..table import rigid_geometry
from .contact_geometry import AMPLITUDE, CURVE, ContactGeometry
from .measures import TAPE_CIRCLE, Stations, survey
from .outlines import Outlines, case_outlines

KINDS = "", "wheel", "rail"
LEAST_REACH = 10e-3         # of geometry functions to either side of the centre [m]
# Label of a measure, unit, scale from SI, decimals.
MEASURES = {
    "Sh": ("flange height Sh", "mm", MM, 2), "Sd": ("flange thickness Sd", "mm", MM, 2), "qR": ("qR", "mm", MM, 2),
    "flange_angle": ("flange angle", "°", DEG, 2), "tread_slope": ("tread slope", "", 1.0, 4),
    "hollow": ("hollow of the tread", "mm", MM, 2),
    "crown_radius": ("crown radius", "mm", MM, 1), "shoulder_radius": ("shoulder radius", "mm", MM, 1),
    "corner_radius": ("gauge corner radius", "mm", MM, 2),
    "gauge_point_y": ("gauge point at y", "mm", MM, 3), "top_y": ("top of rail at y", "mm", MM, 1),
    "inclination": ("inclination", "rad", 1.0, 4),
}


@dataclass(frozen=True)
class Profile:
    """A profile as the program takes it."""
    path: str
    kind: str                   # 'wheel' or 'rail'
    smoothing: float            # rms distance that the curve may keep from the points [mm]; 0 interpolates
    checksum: str
    taken: str                  # how, where it says more than y, z in mm
    mended: str                 # '' where nothing was
    points: np.ndarray          # (n, 2) [mm], y from a wheel's back
    rough: Stations             # curve through the points
    smooth: Stations            # curve that a run uses
    noise: float                # of the points, estimated [m]
    measures: dict[str, float]  # SI units; NaN where the profile does not go so far

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        return {"path": self.path, "kind": self.kind, "points": len(self.points), "checksum": self.checksum, "taken": self.taken,
                "mended": self.mended, "noise": self.noise, "smoothing": 1e-3*self.smoothing, **self.measures}

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        found = [f"{self.kind} {Path(self.path).name}: {len(self.points)} points, CRC-32 {self.checksum}"]
        found += [note for note in (self.taken, self.mended) if note]
        noise = f"about {MM*self.noise:.3f} mm" if self.noise >= 5e-7 else "below 0.001 mm"
        curve = f"smoothed by {self.smoothing:.4f} mm" if self.smoothing else "curve through the points"
        found.append(f"noise of the points {noise}, {curve}")
        for name, value in self.measures.items():
            label, unit, scale, digits = MEASURES[name]
            number = f"{scale*value:.{digits}f}" if np.isfinite(value) else "not on the profile"
            if name in ("tread_slope", "inclination") and np.isfinite(value) and abs(value) > 1e-4:
                number += f" (1:{1/value:.1f})"
            found.append(f"{label} {number} {unit if np.isfinite(value) else ''}".rstrip())
        return found


def inspect(path: str | os.PathLike[str], kind: str = "", smoothing: float = -1.0, flip: str = "auto",
            unit: str = "auto", gauge_depth: float = 0.014) -> Profile:
    """Read a profile file; without `kind` its shape says whether it is a wheel or a rail.

    smoothing [mm], flip and unit as in &profiles of a namelist, gauge_depth [m]. Raises Error as a run would.
    """
    address, message, length = _flat.inspect_profile(path_bytes(path), KINDS.index(kind), smoothing, text_bytes(flip),
                                                     text_bytes(unit))
    check(message, length)
    handle = Handle(_flat.free_profile, address)
    (kind_number, n), (noise, distance, smooth_length, rough_length), listing, size = _flat.profile_facts(handle)
    found = KINDS[kind_number]
    checksum, taken, mended = text(listing, size).split("\n")
    rough, _ = survey(found, rough_length, lambda s: _flat.profile_frames(handle, 0, s), gauge_depth)
    smooth, measures = survey(found, smooth_length, lambda s: _flat.profile_frames(handle, 1, s), gauge_depth)
    return Profile(os.fspath(path), found, MM*float(distance), checksum, taken, mended, _flat.profile_points(handle, n).T, rough,
                   smooth, float(noise), measures)


@dataclass(frozen=True)
class Pair:
    """A wheel on a rail, rigid."""
    clearance: tuple[float, float]      # to the left, to the right [m]
    zones: dict[str, np.ndarray]        # of 'left', 'right' (zone, 4): first and last y on the wheel [m], flange 0 or 1,
                                        # contact angle [rad]
    level: ContactGeometry              # of the wheelset that is kept level, as EN 15302 has it
    rolled: ContactGeometry             # of the wheelset that stands on both rails
    outlines: Outlines                  # of wheels and rails

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        names = "y_first", "y_last", "flange", "angle"
        return {"clearance_left": self.clearance[0], "clearance_right": self.clearance[1],
                "zones": {side: [dict(zip(names, zone.tolist(), strict=True)) for zone in zones]
                          for side, zones in self.zones.items()},
                "conicity": {found.kept: found.facts() for found in (self.level, self.rolled)}}

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        left, right = (MM*x for x in self.clearance)
        found = ["rigid-axle clearance " + (f"2 x {left:.3f} mm" if left == right else f"left {left:.3f}, right {right:.3f} mm")]
        for amplitude in (2e-3, 3e-3, 4e-3):
            level, rolled = self.level.conicity_at(amplitude), self.rolled.conicity_at(amplitude)
            if np.isfinite(rolled):
                linearised = np.interp(amplitude, self.rolled.amplitude, self.rolled.linearised)
                found.append(f"equivalent conicity at {MM*amplitude:.0f} mm: level {level:.3f}, with roll {rolled:.3f} (EN 15302), "
                             f"{linearised:.3f} (harmonic linearisation)")
        for label, level, rolled in (
                ("nonlinearity parameter [1/mm]", self.level.nonlinearity/MM, self.rolled.nonlinearity/MM),
                (f"rolling radii coefficient in a curve of {CURVE:.0f} m", self.level.rolling_radii_coefficient(),
                 self.rolled.rolling_radii_coefficient()),
                *((f"{words} parameter at {MM*AMPLITUDE:.0f} mm", self.level.parameter(name), self.rolled.parameter(name))
                  for name, words in (("angle", "contact angle"), ("roll", "roll angle")))):
            if np.isfinite([level, rolled]).all():
                found.append(f"{label}: level {level:.3f}, with roll {rolled:.3f}")
        for side, zones in self.zones.items():
            where = "" if left == right else f"{side} "
            found += [f"{where}zone of the {'flange' if flange else 'tread'}: y {MM*first:.1f} to {MM*last:.1f} mm, "
                      f"angle {DEG*alpha:.1f}°" for first, last, flange, alpha in zones if where or side == "left"]
        return found


def pair(case: Case, radii: Sequence[float] | None = None) -> Pair:
    """The rigid geometry of a case's profiles.

    radii: of the left and the right wheel on the tape circle [m], in place of `rolling_radius` where the wheels touch.
    """
    handle = rigid_geometry(case)
    (left, n_left), zones_left = _flat.rigid_numbers(handle, 1)
    (right, n_right), zones_right = _flat.rigid_numbers(handle, 2)
    zones = {"left": zones_left.T[:int(n_left)], "right": zones_right.T[:int(n_right)]}
    ends = tuple(case.back_to_back/2 + max(side[side[:, 2] == 1, 1], default=-np.inf) for side in zones.values())
    reach = round(max(LEAST_REACH, 1.3*max(left, right))/FINE_PITCH)
    y = FINE_PITCH*np.arange(-reach, reach + 1)
    raised = raised_surfaces(case, handle, radii)
    names = descriptions()[2].split()
    level, rolled = (ContactGeometry.of(kept, names, rows(handle, y, raised), ends)
                     for kept, rows in (("level", level_rows), ("with roll", rolled_rows)))
    return Pair((left, right), zones, level, rolled, case_outlines(case))


def raised_surfaces(case: Case, handle: Handle, radii: Sequence[float] | None) -> tuple[float, float]:
    """By how much the surfaces of the left and the right wheel lie nearer to the axle than the case has them [m]."""
    if radii is None:
        return 0.0, 0.0
    for radius in radii:
        case.replace(rolling_radius=radius)         # refuses what is no radius of a wheel
    left, right = (tape_radius(case, handle, side) - radius for side, radius in enumerate(radii, 1))
    return left, right


def tape_radius(case: Case, handle: Handle, side: int) -> float:
    """Radius of a wheel (side 1 left, 2 right) on the tape circle as the case has it [m]."""
    sizes, _ = _flat.outline_sizes(handle)
    y, z = _flat.outline_points(handle, 1, side, sizes[0, side - 1])
    at = case.back_to_back/2 + TAPE_CIRCLE
    if not y[0] <= at <= y[-1]:
        raise Error(f"{case.label}: expected a wheel that reaches the tape circle, {MM*TAPE_CIRCLE:g} mm from its back, "
                    f"found one from {MM*(y[0] - case.back_to_back/2):.1f} to {MM*(y[-1] - case.back_to_back/2):.1f} mm")
    return -float(np.interp(at, y, z))


def inspect_for(file: str, case: Case) -> Profile:
    """A profile as the case would take it, wheel or rail."""
    found = inspect(file, smoothing=case.smoothing_mm, gauge_depth=case.gauge_depth)
    flip, unit = ((case.wheel_flip, case.wheel_unit) if found.kind == "wheel" else (case.rail_flip, case.rail_unit))
    if (flip, unit) != ("auto", "auto"):
        found = inspect(file, found.kind, case.smoothing_mm, flip, unit, case.gauge_depth)
    return found
