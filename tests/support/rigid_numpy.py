"""Rigid contact of a level wheelset and EN 15302's conicity from the points of two files, by numpy and scipy alone.

Nothing here is the program's: cubic splines over chord lengths, the gauge by its definition, the wheel lowered onto the rail on a
grid of 0.02 mm, and the integral of the standard over a quarter of the wavelength.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

GRID = 0.02         # [mm]
STRAIGHT = 1e-6     # a radius difference below this does not steer [mm]


def read(path: str | Path) -> np.ndarray:
    """Points of plain columns, (n, 2) [mm]."""
    return np.loadtxt(path, comments=("#", "!", "%"))


def dense(points: np.ndarray, pitch: float = GRID) -> np.ndarray:
    """The spline through points, at equal distances along it, (n, 2) [mm]."""
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    return CubicSpline(s, points)(np.arange(0, s[-1], pitch))


def turned(points: np.ndarray, angle: float) -> np.ndarray:
    """Points turned from y to z [rad]: a left rail leans to the track's centre by a positive angle."""
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


@dataclass(frozen=True)
class Level:
    """A left wheel above a left rail, y outward from the track's centre [mm]."""
    y: np.ndarray           # of the wheel
    wheel: np.ndarray       # its height there
    rail_y: np.ndarray
    rail: np.ndarray

    @classmethod
    def of(cls, wheel: np.ndarray, rail: np.ndarray, lean: float = 0.0, gauge: float = 1435.0, back_to_back: float = 1360.0,
           depth: float = 14.0) -> Level:
        """From points [mm]: wheel from its back, the rail turned by an angle and put to the gauge."""
        rail = dense(turned(rail, lean))
        top = rail[:, 1].argmax()
        face = rail[:top + 1]
        below = np.flatnonzero(face[:, 1] < rail[top, 1] - depth)[-1]
        share = (rail[top, 1] - depth - face[below, 1])/(face[below + 1, 1] - face[below, 1])
        gauge_y = face[below, 0] + share*(face[below + 1, 0] - face[below, 0])
        rail = rail + [gauge/2 - gauge_y, -rail[top, 1]]
        head = rail[rail[:, 1] > -depth]
        y = np.arange(head[:, 0].min(), head[:, 0].max(), GRID)
        order = head[:, 0].argsort(kind="stable")
        curve = dense(wheel)
        tip = curve[:, 1].argmin()
        curve = curve[tip:]
        u = np.arange(curve[0, 0], curve[-1, 0], GRID)
        return cls(u + back_to_back/2, np.interp(u, curve[:, 0], curve[:, 1]), y, np.interp(y, head[order, 0], head[order, 1]))

    def contact(self, shift: float) -> float:
        """y in the wheelset where the wheel touches, moved outward by a shift [mm]: the least gap."""
        at = self.y + shift
        inside = (at > self.rail_y[0]) & (at < self.rail_y[-1])
        gap = np.where(inside, self.wheel - np.interp(at, self.rail_y, self.rail), np.inf)
        k = int(gap.argmin())
        return float(self.y[k])

    def radius(self, shift: float) -> float:
        """Growth of the rolling radius with the place of the contact [mm]: minus its height."""
        return -float(np.interp(self.contact(shift), self.y, self.wheel))

    def radius_difference(self, y: np.ndarray) -> np.ndarray:
        """Left minus right [mm] at displacements of the wheelset to the left."""
        return np.array([self.radius(one) - self.radius(-one) for one in y])

    def conicity(self, amplitude: float = 3.0) -> float:
        """Equivalent conicity by EN 15302; NaN where the wheelset is not turned back."""
        return by_wavelength(amplitude, self.radius_difference)


def by_wavelength(amplitude: float, radius_difference: Callable[[np.ndarray], np.ndarray]) -> float:
    """The cone with the wavelength of y'' = -delta_r(y)/(e r), for an odd delta_r; NaN where the wheelset is not turned back."""
    y = np.linspace(0, amplitude, 1 + round(amplitude/GRID))
    value = radius_difference(y)
    work = np.r_[0.0, np.cumsum((value[1:] + value[:-1])/2*np.diff(y))]
    t = (np.arange(2000) + 0.5)*np.pi/4000
    left = np.interp(amplitude, y, work) - np.interp(amplitude*np.sin(t), y, work)
    if np.abs(left).max() < STRAIGHT*amplitude:
        return 0.0
    if (left <= 0).any():
        return np.nan
    quarter = np.mean(amplitude*np.cos(t)/np.sqrt(2*left))*np.pi/2
    return float(np.pi**2/(8*quarter**2))


@dataclass(frozen=True)
class Rolled:
    """A wheelset that rolls until it stands on both rails, wheels and rails of both sides alike [mm]."""
    level: Level
    axle: float             # from the axle down to z = 0 of the wheel's points

    @classmethod
    def of(cls, level: Level, radius: float = 457.0) -> Rolled:
        """radius: at the contact of the centred wheelset."""
        return cls(level, radius - level.radius(0.0))

    def lowered(self, shift: float, roll: float) -> tuple[float, float]:
        """Height of the axle at which the left wheel touches, and y of the contact in the wheelset."""
        z = self.level.wheel - self.axle
        across, up = self.level.y*np.cos(roll) - z*np.sin(roll) + shift, self.level.y*np.sin(roll) + z*np.cos(roll)
        inside = (across > self.level.rail_y[0]) & (across < self.level.rail_y[-1])
        high = np.where(inside, np.interp(across, self.level.rail_y, self.level.rail) - up, -np.inf)
        k = int(high.argmax())
        return float(high[k]), float(self.level.y[k])

    def contacts(self, y: float) -> tuple[float, float]:
        """y of the contacts of the left and the right wheel in the wheelset, outward, at a displacement to the left."""
        def difference(roll: float) -> float:
            return self.lowered(y, roll)[0] - self.lowered(-y, -roll)[0]

        roll = float(brentq(difference, -0.05, 0.05, xtol=1e-9)) if y else 0.0
        return self.lowered(y, roll)[1], self.lowered(-y, -roll)[1]

    def conicity(self, amplitude: float = 3.0) -> float:
        """As that of the level wheelset."""
        return by_wavelength(amplitude, lambda y: np.array([np.subtract(*self.radii(one)) for one in y]))

    def radii(self, y: float) -> np.ndarray:
        """Growth of the rolling radii with the places of the contacts [mm], left and right."""
        return -np.interp(self.contacts(y), self.level.y, self.level.wheel)

    def clearance(self, flange: float = 0.4363) -> float:
        """Displacement at which the contact of the left wheel comes to where the wheel is as steep as `flange` [rad]."""
        slope = np.arctan(np.gradient(self.level.wheel, self.level.y))

        def steep(y: float) -> bool:
            return bool(np.interp(self.contacts(y)[0], self.level.y, slope) >= flange)

        high = next(y for y in np.arange(0.5, 20, 0.5) if steep(y))
        low = high - 0.5
        while high - low > 1e-3:
            middle = (low + high)/2
            low, high = (low, middle) if steep(middle) else (middle, high)
        return float(high)


def wheel_measures(points: np.ndarray, tape: float = 70.0) -> tuple[float, float, float]:
    """Sh, Sd and qR of EN 15313 [mm]: y from the wheel's back."""
    curve = dense(points)
    tip = curve[:, 1].argmin()
    face = curve[tip:][curve[tip:, 0] <= tape]
    level = np.interp(tape, curve[tip:, 0], curve[tip:, 1])

    def y_at(z: float) -> float:
        k = int(np.flatnonzero(face[:, 1] >= z)[0])
        return float(np.interp(z, face[k - 1:k + 1, 1], face[k - 1:k + 1, 0]))

    return float(level - curve[tip, 1]), y_at(level - 10), y_at(level - 10) - y_at(curve[tip, 1] + 2)
