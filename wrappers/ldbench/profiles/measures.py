"""Parts and measures of a wheel or rail profile, from stations on its curve.

Lengths are in m, angles in rad, curvatures in 1/m; z points up, y from a wheel's back or from a rail's gauge side to the
field side. A measure is NaN where the profile does not go so far.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..constants import TAPE_CIRCLE

PROFILE_PARTS = "flange back", "flange", "throat", "tread", "chamfer", "gauge side", "head", "field side"
STATION_PITCH = 0.1e-3              # distance between stations [m]
GENTLE, CHAMFER = np.radians([10, 25])      # tangent angles at which the tread begins and ends [rad]
STEEP = np.radians(60)              # the sides of a rail are steeper than its head [rad]
CROWN = 3.0                         # curvature of a rail's crown [1/m]
LARGEST_INCLINATION = 0.12          # of a rail [rad]


@dataclass(frozen=True)
class Stations:
    """Stations along the curve of a profile, arrays of shape (n,)."""
    s: np.ndarray               # [m]
    y: np.ndarray               # [m]
    z: np.ndarray               # [m]
    angle: np.ndarray           # of the tangent [rad]
    curvature: np.ndarray       # d(angle)/ds [1/m]
    part: np.ndarray            # a place in PROFILE_PARTS, from 1


def survey(kind: str, length: float, frames: Callable[[np.ndarray], np.ndarray],
           gauge_depth: float) -> tuple[Stations, dict[str, float]]:
    """Stations of a 'wheel' or a 'rail' and its measures.

    length [m] of the curve; frames(s) gives y, z, angle and curvature, (4, n), at stations s, (n,); gauge_depth [m].
    """
    n = int(np.ceil(length/STATION_PITCH))
    s = np.arange(n)*length/(n - 1)
    y, z, angle, curvature = frames(s)
    part, measures = survey_wheel(y, z, angle) if kind == "wheel" else survey_rail(s, y, z, angle, gauge_depth)
    return Stations(s, y, z, angle, curvature, part), measures


def waviness(stations: Stations) -> float:
    """By how much the curvature over 2 mm, the size of a contact, differs from that over 8 mm, relative to it or to the crown of a
    rail: the median where the profile is less steep than 70 degrees."""
    pitch = stations.s[1] - stations.s[0]
    near, far = (max(1, round(half/pitch)) for half in (1e-3, 4e-3))
    angle = np.unwrap(stations.angle)
    if len(angle) < 4*far:
        return 0.0
    inner = slice(far, len(angle) - far)
    small, large = ((np.roll(angle, -k) - np.roll(angle, k))[inner]/(2*k*pitch) for k in (near, far))
    wave = np.abs(small - large)/np.maximum(CROWN, np.abs(large)/2)
    return float(np.median(wave[np.abs(angle[inner]) < np.radians(70)]))


def survey_wheel(y: np.ndarray, z: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, dict[str, float]]:
    """Parts of a wheel and its measures in service (EN 15313).

    Sh: height of the flange above the tape circle. Sd: thickness of the flange 10 mm below the tape circle's level.
    qR: lateral distance along the flange face from there to 2 mm from the tip. flange_angle: steepest angle of the
    flange face. tread_slope: mean slope over 20 mm about the tape circle. hollow: the most that the tread rises before
    a lower part farther out.
    """
    tip = int(np.argmin(z))
    tape = first(y >= TAPE_CIRCLE, tip, len(y) - 1)
    face = tip + int(np.argmax(angle[tip:tape + 1]))
    throat = first(angle < GENTLE, face, len(y) - 1)
    edge = first(angle > CHAMFER, tape, len(y))
    part = np.full(len(y), 4)
    part[:tip + 1] = 1
    part[tip + 1:face + 1] = 2
    part[face + 1:throat + 1] = 3
    part[edge:] = 5

    walk = slice(tip, tape + 1)
    thickness = crossing(y[walk], z[walk], z[tape] - 10e-3)
    near = np.abs(y - TAPE_CIRCLE) < 10e-3
    tread = z[throat:edge]
    return part, {
        "Sh": float(z[tape] - z[tip]), "Sd": thickness, "qR": thickness - crossing(y[walk], z[walk], z[tip] + 2e-3),
        "flange_angle": float(angle[face]), "tread_slope": slope(y[near], z[near]),
        "hollow": float(np.max(np.maximum.accumulate(tread) - tread, initial=0.0))}


def survey_rail(s: np.ndarray, y: np.ndarray, z: np.ndarray, angle: np.ndarray,
                gauge_depth: float) -> tuple[np.ndarray, dict[str, float]]:
    """Parts of a rail and its measures.

    Mean radii of three arcs that a head has (EN 13674-1): of the crown, within 1.5 degrees about the inclination; of the
    shoulder, 5 to 12 degrees from it; of the gauge corner, 35 to 70 degrees from it. gauge_point_y, top_y: y of the
    gauge point, gauge_depth [m] below the top, and of the top. inclination: that at which the head is symmetric.
    """
    top = int(np.argmax(z))
    part = np.full(len(z), 7)
    part[:last(angle[:top + 1] > STEEP) + 1] = 6
    part[first(angle < -STEEP, top, len(z)):] = 8

    lean = inclination(y, z, top)
    upright = lean if np.isfinite(lean) else 0.0
    crown, shoulder, corner = (arc_radius(s, angle, *(upright + np.radians(ends))) for ends in ((1.5, -1.5), (12, 5), (70, 35)))
    return part, {"crown_radius": crown, "shoulder_radius": shoulder, "corner_radius": corner,
                  "gauge_point_y": crossing(y[:top + 1], z[:top + 1], z[top] - gauge_depth), "top_y": float(y[top]),
                  "inclination": lean}


def first(found: np.ndarray, start: int, default: int) -> int:
    """The first place from `start` on that is true."""
    places = np.flatnonzero(found[start:])
    return start + int(places[0]) if places.size else default


def last(found: np.ndarray) -> int:
    """The last place that is true, -1 without one."""
    places = np.flatnonzero(found)
    return int(places[-1]) if places.size else -1


def crossing(y: np.ndarray, z: np.ndarray, level: float) -> float:
    """y where z first rises to a level; NaN where it does not."""
    i = first((z[:-1] <= level) & (z[1:] >= level), 0, -1)
    if i < 0:
        return np.nan
    rise = z[i + 1] - z[i]
    return float(y[i] + ((level - z[i])/rise if rise > 0 else 0.0)*(y[i + 1] - y[i]))


def slope(y: np.ndarray, z: np.ndarray) -> float:
    """Slope of the line through points by least squares; NaN for fewer than three points."""
    if y.size < 3:
        return np.nan
    return float(np.polyfit(y - np.mean(y), z, 1)[0])


def inclination(y: np.ndarray, z: np.ndarray, top: int) -> float:
    """Inclination at which a rail's head is symmetric [rad]; NaN where none is.

    With the head turned upright, the midpoints of its chords 4 to 14 mm below the top lie above each other.
    """
    def tilt(angle: float) -> float:
        """Slope of the line of midpoints from the vertical, with the head turned back by an angle."""
        across, up = y*np.cos(angle) + z*np.sin(angle), z*np.cos(angle) - y*np.sin(angle)
        levels = np.max(up) - np.linspace(4e-3, 14e-3, 11)
        middle = [(crossing(across[:top + 1], up[:top + 1], level)
                   + crossing(across[top:][::-1], up[top:][::-1], level))/2 for level in levels]
        return slope(levels, np.array(middle))

    low, high = -LARGEST_INCLINATION, LARGEST_INCLINATION
    if not (tilt(low) > 0 > tilt(high)):
        return np.nan
    for _ in range(40):             # to 2e-13 rad
        lean = (low + high)/2
        low, high = (lean, high) if tilt(lean) > 0 else (low, lean)
    return lean


def arc_radius(s: np.ndarray, angle: np.ndarray, steeper: float, flatter: float) -> float:
    """Mean radius of a rail's arc between two tangent angles [rad] on the gauge side [m]; NaN where it has none."""
    start, end = last(angle > steeper), first(angle < flatter, 0, -1)
    if start < 0 or end <= start:
        return np.nan
    return float((s[end] - s[start])/(angle[start] - angle[end]))
