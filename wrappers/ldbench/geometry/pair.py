"""A wheel on a rail before a run: clearance, zones, conicity, what the wheelset does between its flanges."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._core import flat
from .._core.calls import Handle, text
from .._core.errors import Error
from ..case import Case
from ..conicity import FINE_PITCH, GEOMETRY, level_rows, rolled_rows
from ..constants import DEG, MM, SIDES, TAPE_CIRCLE
from ..number_text import clearance_words, slope_words
from ..profiles.formats import told_by
from ..table import core_files, rigid_geometry, smoothing_words
from .contact_geometry import AMPLITUDE, CURVE, SOFT, STIFF, ContactGeometry
from .outlines import Outlines, case_outlines

LEAST_REACH = 10e-3         # of geometry functions to either side of the centre [m]


@dataclass(frozen=True)
class Pair:
    """A wheel on a rail, rigid."""
    zones: dict[str, np.ndarray]        # of 'left', 'right' (zone, 4): first and last y on the wheel [m], flange 0 or 1,
                                        # contact angle [rad]
    level: ContactGeometry              # of the wheelset that is kept level, as EN 15302 has it
    rolled: ContactGeometry             # of the wheelset that stands on both rails
    outlines: Outlines                  # of wheels and rails, with the clearances
    inclination: tuple[float, float]    # of the left and the right rail to the track's centre, beyond their files [rad]
    warnings: tuple[str, ...]           # what is doubtful about the profiles in their places, a line each
    remark: str = ""                    # what was done to the profiles that changes the clearances

    @property
    def clearance(self) -> tuple[float, float]:
        """Rigid-axle flange clearance to the left and to the right [m]."""
        return self.outlines.clearance

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        names = "y_first", "y_last", "flange", "angle"
        return {"clearance_left": self.clearance[0], "clearance_right": self.clearance[1],
                "rail_inclination": list(self.inclination), "warnings": list(self.warnings),
                **({"clearance_remark": self.remark} if self.remark else {}),
                "zones": {side: [dict(zip(names, zone.tolist(), strict=True)) for zone in zones]
                          for side, zones in self.zones.items()},
                "conicity": {found.kept: found.facts() for found in (self.level, self.rolled)}}

    def lines(self) -> list[str]:
        """What there is to say, line by line."""
        found = [f"rigid-axle clearance {clearance_words(*self.clearance)} mm" + (f" ({self.remark})" if self.remark else ""),
                 *(f"warning: {words}" for words in self.warnings)]
        if words := inclination_words(self.inclination):
            found.append(words)
        scale = self.level.scale
        for amplitude in (SOFT/scale, AMPLITUDE/scale, STIFF/scale):
            linearised = float(np.interp(amplitude, self.rolled.amplitude, self.rolled.linearised, right=np.nan)
                               if self.rolled.amplitude.size else np.nan)
            why = "; ".join(filter(None, (self.level.why_none(amplitude), self.rolled.why_none(amplitude))))
            found.append(f"equivalent conicity at {MM*amplitude:.4g} mm: level {number(self.level.conicity_at(amplitude))}, "
                         f"with roll {number(self.rolled.conicity_at(amplitude))} (EN 15302), "
                         f"{number(linearised)} (harmonic linearisation)" + (f"; no wave by EN 15302: {why}" if why else ""))
        soft_stiff = f"without the conicities at {MM*SOFT/scale:.4g} and {MM*STIFF/scale:.4g} mm"
        at = f"{MM*AMPLITUDE/scale:.4g} mm"
        for label, level, rolled, lacking in (
                ("nonlinearity parameter [1/mm]", self.level.nonlinearity/MM, self.rolled.nonlinearity/MM, soft_stiff),
                (f"rolling radii coefficient in a curve of {CURVE/scale:.4g} m", self.level.rolling_radii_coefficient(),
                 self.rolled.rolling_radii_coefficient(), "without contacts of the centred wheelset"),
                *((f"{words} parameter at {at}", self.level.parameter(name), self.rolled.parameter(name),
                   f"without a motion of {at}") for name, words in (("angle", "contact angle"), ("roll", "roll angle")))):
            found.append(f"{label}: level {number(level)}, with roll {number(rolled)}"
                         + ("" if np.isfinite([level, rolled]).all() else f"; none {lacking}"))
        for side, zones in self.zones.items():
            where = "" if self.clearance[0] == self.clearance[1] else f"{side} "
            found += [f"{where}zone of the {'flange' if flange else 'tread'}: y {MM*first:.1f} to {MM*last:.1f} mm, "
                      f"angle {DEG*alpha:.1f}°" for first, last, flange, alpha in zones if where or side == "left"]
        return found


def number(x: float) -> str:
    """A number with three decimals, without a minus before 0.000; 'none' for none."""
    return f"{round(x, 3) + 0.0:.3f}" if np.isfinite(x) else "none"


def pair(case: Case, radii: Sequence[float] | None = None) -> Pair:
    """The rigid geometry of a case's profiles, from points that are smoothed by their noise alone; zones are those of a run.

    radii: of the left and the right wheel on the tape circle [m], in place of `rolling_radius` where the wheels touch.
    """
    handle, outlines = rigid_geometry(case, "geometry"), case_outlines(case, "geometry")
    of_run = rigid_geometry(case)
    zones = {side: zones.T[:int(count)] for side, ((_, count), zones) in zip(
        SIDES, (flat.rigid_numbers(of_run, side) for side in (1, 2)), strict=True)}
    end_left, end_right = (case.back_to_back/2 + max(side[side[:, 2] == 1, 1], default=-np.inf) for side in zones.values())
    told = {name: told_by(path) for name, path in core_files(case).items() if name != "bodies"}
    scale = told["wheel_profile"][0]
    remark = "; ".join(dict.fromkeys(remarks["clearance"] for _, remarks in told.values() if "clearance" in remarks))
    pitch = FINE_PITCH/scale
    reach = round(max(LEAST_REACH/scale, 1.3*max(outlines.clearance))/pitch)
    y = pitch*np.arange(-reach, reach + 1)
    raised = raised_surfaces(case, handle, radii)
    names = list(GEOMETRY)
    level, rolled = (ContactGeometry.of(kept, names, rows(handle, y, raised), (end_left, end_right), scale)
                     for kept, rows in (("level", level_rows), ("with roll", rolled_rows)))
    warnings = (*text(*flat.placement_warnings(handle)).splitlines(), *filter(None, [smoothing_words(case)]))
    inclination = tuple(flat.rail_inclinations(handle).tolist())
    return Pair(zones, level, rolled, outlines, (inclination[0], inclination[1]), warnings, remark)


def inclination_words(inclination: tuple[float, float]) -> str:
    """By how much rails lean to the track's centre beyond their files; '' where they stand as the files have them."""
    left, right = inclination
    if left == right:
        return f"rails inclined by {slope_words(left)} beyond their files" if left else ""
    return f"rails inclined beyond their files: left {slope_words(left)}, right {slope_words(right)}"


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
    sizes, _ = flat.outline_sizes(handle)
    y, z = flat.outline_points(handle, 1, side, sizes[0, side - 1])
    at = case.back_to_back/2 + TAPE_CIRCLE
    if not y[0] <= at <= y[-1]:
        raise Error(file=case.label, expected=f"a wheel that reaches the tape circle, {MM*TAPE_CIRCLE:g} mm from its back",
                    found=f"one from {MM*(y[0] - case.back_to_back/2):.1f} to {MM*(y[-1] - case.back_to_back/2):.1f} mm")
    return -float(np.interp(at, y, z))
