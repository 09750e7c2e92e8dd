"""Profiles and pairs before a run: what a file is taken for, its measures, what a wheel does on a rail."""
from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .._core import _flat
from .._core.calls import Handle, check, descriptions, path_bytes, text, text_bytes
from ..case import Case
from ..conicity import GEOMETRY_PITCH, equivalent_conicity, geometry_rows, linearised_conicity
from ..results.quantities import DEG, MM
from ..table import located
from .measures import Stations, survey

KINDS = "", "wheel", "rail"
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
    smoothing: float            # [mm]
    checksum: str
    taken: str                  # how, where it says more than y, z in mm
    mended: str                 # '' where nothing was
    points: np.ndarray          # (n, 2) [mm], y from a wheel's back
    rough: Stations             # curve through the points
    smooth: Stations            # curve at the smoothing that is asked for
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
        found.append(f"noise of the points {noise}, smoothing_mm = {self.smoothing:g}")
        for name, value in self.measures.items():
            label, unit, scale, digits = MEASURES[name]
            number = f"{scale*value:.{digits}f}" if np.isfinite(value) else "not on the profile"
            if name in ("tread_slope", "inclination") and np.isfinite(value) and abs(value) > 1e-4:
                number += f" (1:{1/value:.1f})"
            found.append(f"{label} {number} {unit if np.isfinite(value) else ''}".rstrip())
        return found


def inspect(path: str | os.PathLike[str], kind: str = "", smoothing: float = 0.0, flip: str = "auto",
            unit: str = "auto", gauge_depth: float = 0.014) -> Profile:
    """Read a profile file; without `kind` its shape says whether it is a wheel or a rail.

    smoothing [mm], flip and unit as in &profiles of a namelist, gauge_depth [m]. Raises Error as a run would.
    """
    address, message, length = _flat.inspect_profile(path_bytes(path), KINDS.index(kind), smoothing, text_bytes(flip),
                                                     text_bytes(unit))
    check(message, length)
    handle = Handle(_flat.free_profile, address)
    (kind_number, n), (noise, smooth_length, rough_length), listing, size = _flat.profile_facts(handle)
    found = KINDS[kind_number]
    checksum, taken, mended = text(listing, size).split("\n")
    rough, _ = survey(found, rough_length, lambda s: _flat.profile_frames(handle, 0, s), gauge_depth)
    smooth, measures = survey(found, smooth_length, lambda s: _flat.profile_frames(handle, 1, s), gauge_depth)
    return Profile(os.fspath(path), found, smoothing, checksum, taken, mended, _flat.profile_points(handle, n).T, rough,
                   smooth, float(noise), measures)


@dataclass(frozen=True)
class Pair:
    """A wheel on a rail, rigid."""
    clearance: tuple[float, float]      # to the left, to the right [m]
    zones: dict[str, np.ndarray]        # of 'left', 'right' (zone, 4): first and last y on the wheel [m], flange 0 or 1,
                                        # contact angle [rad]
    geometry: dict[str, np.ndarray]     # the columns of a geometry file
    amplitude: np.ndarray       # [m]
    conicity: np.ndarray        # for the amplitudes, by EN 15302
    linearised: np.ndarray      # the same by harmonic linearisation

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        names = "y_first", "y_last", "flange", "angle"
        return {"clearance_left": self.clearance[0], "clearance_right": self.clearance[1],
                "zones": {side: [dict(zip(names, zone.tolist(), strict=True)) for zone in zones]
                          for side, zones in self.zones.items()},
                "conicity": {"amplitude": self.amplitude, "EN 15302": self.conicity, "harmonic linearisation": self.linearised}}

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        left, right = (MM*x for x in self.clearance)
        found = ["rigid-axle clearance " + (f"2 x {left:.3f} mm" if left == right else f"left {left:.3f}, right {right:.3f} mm")]
        for amplitude in (2e-3, 3e-3, 4e-3):
            if amplitude <= self.amplitude[-1]:
                values = (np.interp(amplitude, self.amplitude, x) for x in (self.conicity, self.linearised))
                found.append("equivalent conicity at {:.0f} mm {:.3f} (EN 15302), {:.3f} (harmonic linearisation)"
                             .format(MM*amplitude, *values))
        for side, zones in self.zones.items():
            where = "" if left == right else f"{side} "
            found += [f"{where}zone of the {'flange' if flange else 'tread'}: y {MM*first:.1f} to {MM*last:.1f} mm, "
                      f"angle {DEG*alpha:.1f}°" for first, last, flange, alpha in zones if where or side == "left"]
        return found


def rigid_geometry(case: Case) -> Handle:
    """The profiles of a case in their places, without a contact table."""
    address, message, length = _flat.prepare_rigid_case(*case.arrays(), located(case))
    check(message, length, case.label)
    return Handle(_flat.free_prepared, address)


def pair(case: Case) -> Pair:
    """The rigid geometry of a case's profiles."""
    handle = rigid_geometry(case)
    (left, n_left), zones_left = _flat.rigid_numbers(handle, 1)
    (right, n_right), zones_right = _flat.rigid_numbers(handle, 2)
    zones = {"left": zones_left.T[:int(n_left)], "right": zones_right.T[:int(n_right)]}
    reach = max(20, int(1.3e4*max(left, right)))
    rows = geometry_rows(handle, GEOMETRY_PITCH*np.arange(-reach, reach + 1))
    rows = rows[:, np.isfinite(rows[7])]
    names = descriptions()[2].split()
    amplitude = GEOMETRY_PITCH*np.arange(2, int(1e4*rows[0, -1]) + 1)
    return Pair((left, right), zones, dict(zip(names, rows, strict=True)), amplitude,
                *(conicity(amplitude, rows[0], rows[7]) for conicity in (equivalent_conicity, linearised_conicity)))


def inspect_for(file: str, case: Case) -> Profile:
    """A profile as the case would take it, wheel or rail."""
    found = inspect(file, smoothing=case.smoothing_mm, gauge_depth=case.gauge_depth)
    flip, unit = ((case.wheel_flip, case.wheel_unit) if found.kind == "wheel" else (case.rail_flip, case.rail_unit))
    if (flip, unit) != ("auto", "auto"):
        found = inspect(file, found.kind, case.smoothing_mm, flip, unit, case.gauge_depth)
    return found
