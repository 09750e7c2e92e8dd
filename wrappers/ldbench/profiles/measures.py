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
SAME_Y = 1e-7                       # by which a station may be farther in than the point between two stations [m]
TOP, FLAT = 3e-6, 6e-3              # depth below the top of a rail, and width down to which it is flat [m]
CROWN_OFF, CORNER_OFF = 0.12, 0.05  # shares of a crown's and a corner's angle by which they may miss an arc
OVER = 10                           # stations over which an angle is a mean
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

    def scaled(self, factor: float) -> Stations:
        """The stations of the same shape in another size."""
        return Stations(factor*self.s, factor*self.y, factor*self.z, self.angle, self.curvature/factor, self.part)


def survey(kind: str, length: float, frames: Callable[[np.ndarray], np.ndarray],
           gauge_depth: float, hidden: float = 0.0) -> tuple[Stations, dict[str, float]]:
    """Stations of a 'wheel' or a 'rail' and its measures.

    length [m] of the curve; frames(s) gives y, z, angle and curvature, (4, n), at stations s, (n,); gauge_depth [m]; hidden,
    depth to which a rail goes on behind its first point [m].
    """
    n = int(np.ceil(length/STATION_PITCH))
    s = np.arange(n)*length/(n - 1)
    y, z, angle, curvature = frames(s)
    part, measures = survey_wheel(y, z, angle) if kind == "wheel" else survey_rail(s, y, z, angle, gauge_depth, hidden)
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
                gauge_depth: float, hidden: float = 0.0) -> tuple[np.ndarray, dict[str, float]]:
    """Parts of a rail and its measures.

    Radii of three arcs that a head has (EN 13674-1): of the crown, within 1.5 degrees about the inclination; of the
    shoulder, 5 to 12 degrees from it; of the gauge corner, 35 to 70 degrees from it. NaN of crown or corner where there is no
    single arc, and both radii of a corner that has two. gauge_point_y, top_y: y of the gauge point, the innermost one down to
    gauge_depth [m] below the top (EN 13848-1), and of the top. inclination: that at which the head is symmetric.
    """
    top = int(np.argmax(z))
    part = np.full(len(z), 7)
    part[:last(angle[:top + 1] > STEEP) + 1] = 6
    part[first(angle < -STEEP, top, len(z)):] = 8

    lean = inclination(y, z, top)
    upright = lean if np.isfinite(lean) else 0.0
    crown, shoulder, corner = (arc_radii(s, angle, upright + np.radians(steeper), upright + np.radians(flatter), off)
                               for steeper, flatter, off in ((1.5, -1.5, CROWN_OFF), (12, 5, np.inf), (70, 35, CORNER_OFF)))
    low, high = flat_top(y, z, top)
    found = {"crown_radius": crown[0] if len(crown) == 1 else np.nan, "shoulder_radius": shoulder[0] if shoulder else np.nan,
             "corner_radius": corner[0] if corner else np.nan,
             "gauge_point_y": gauge_point(y[:top + 1], z[:top + 1], z[top] - gauge_depth, z[top] - hidden),
             "top_y": float(y[top]) if high - low < FLAT else (low + high)/2, "inclination": lean}
    if len(corner) > 1:         # the second one where there are two, behind the first
        found = {key: value for name in found for key, value in (
            (name, found[name]), ("lower_corner_radius", corner[0]))[:1 + (name == "corner_radius")]}
        found["corner_radius"] = corner[1]
    return part, found


def rail_remarks(stations: Stations, measures: dict[str, float]) -> dict[str, str]:
    """Why a rail has no radius, more than one, or no one highest point, by measure."""
    top = int(np.argmax(stations.z))
    low, high = flat_top(stations.y, stations.z, top)
    found = {}
    if high - low >= FLAT:
        found["top_y"] = f"flat within {1e6*TOP:.0f} µm from y = {1e3*low:.1f} to {1e3*high:.1f} mm"
    lean = measures["inclination"] if np.isfinite(measures["inclination"]) else 0.0
    for name, steeper, flatter in ("crown_radius", 1.5, -1.5), ("corner_radius", 70, 35):
        start, end = stretch(stations.angle, lean + np.radians(steeper), lean + np.radians(flatter))
        if np.isnan(measures[name]) and end > start >= 0:
            found[name] = f"no single arc from {steeper:g}° to {flatter:g}°"
    if "lower_corner_radius" in measures:
        found |= dict.fromkeys(("corner_radius", "lower_corner_radius"), "one of two arcs from 70° to 35°")
    return found


def flat_top(y: np.ndarray, z: np.ndarray, top: int) -> tuple[float, float]:
    """Ends of a rail's stretch about its top that is less than TOP below it [m]."""
    below = z < z[top] - TOP
    return float(y[last(below[:top]) + 1]), float(y[first(below, top, len(z)) - 1])


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


def gauge_point(y: np.ndarray, z: np.ndarray, level: float, hidden: float) -> float:
    """y of the innermost point of a rail's gauge side above a level; NaN where the side does not reach it, neither by its curve nor
    by points behind the first one, down to `hidden` [m]."""
    at_level, innermost = crossing(y, z, level), float(np.min(y, where=z >= level, initial=np.inf))
    if np.isnan(at_level) and not (z[0] >= level >= hidden):
        return np.nan
    return at_level if innermost > at_level - SAME_Y else innermost


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


def stretch(angle: np.ndarray, steeper: float, flatter: float) -> tuple[int, int]:
    """First and last station of a rail between two tangent angles [rad] on the gauge side; -1 where it lacks one."""
    return last(angle > steeper), first(angle < flatter, 0, -1)


def arc_radii(s: np.ndarray, angle: np.ndarray, steeper: float, flatter: float, off: float) -> list[float]:
    """Radii [m] of the one or two arcs of a rail between two tangent angles [rad] on the gauge side, in the order of the walk.

    On an arc the angle falls in proportion to the way. `off` is the share of all of the angle by which one straight line may
    miss it, and two by half as much; none are given where they miss it by more.
    """
    start, end = stretch(angle, steeper, flatter)
    if start < 0 or end <= start:
        return []
    mean = float((s[end] - s[start])/(angle[start] - angle[end]))
    near = min(OVER, max(1, (end - start)//20))
    x, turn = (np.convolve(values[start:end + 1], np.full(near, 1/near), "valid") for values in (s, angle))
    if len(x) < 6 or missed(np.column_stack([np.ones_like(x), x]), turn)[0] <= off*abs(turn[0] - turn[-1]):
        return [mean]
    best, slopes = np.inf, np.zeros(3)
    for k in range(len(x)//10, len(x) - len(x)//10, max(1, len(x)//60)):
        miss, found = missed(np.column_stack([np.ones_like(x), x, np.maximum(x - x[k], 0)]), turn)
        if miss < best:
            best, slopes = miss, found
    one, two = -slopes[1], -slopes[1] - slopes[2]
    return [float(1/one), float(1/two)] if best <= off/2*abs(turn[0] - turn[-1]) and min(one, two) > 0 else []


def missed(columns: np.ndarray, values: np.ndarray) -> tuple[float, np.ndarray]:
    """The most by which least squares over columns miss values, and their factors."""
    factors = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.abs(columns @ factors - values).max()), factors
