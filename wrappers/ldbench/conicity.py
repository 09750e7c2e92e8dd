"""Geometry functions of the rigid wheelset at any displacement, and the equivalent conicity by EN 15302.

delta_r is the rolling radius difference, left minus right [m], at lateral displacements y [m] that increase evenly.
"""
from __future__ import annotations

import numpy as np

from ._core import _flat
from ._core.calls import Handle

GEOMETRY_PITCH = 1e-4       # between rows of geometry functions [m]


def geometry_rows(handle: Handle, y: np.ndarray) -> np.ndarray:
    """Geometry functions of a prepared case at lateral displacements y, (n,) [m]: (13, n), in the order of a geometry file.

    The last row is the equivalent conicity for the amplitude |y| by harmonic linearisation, from rows that are about
    GEOMETRY_PITCH apart. A column is NaN where the rigid wheelset does not stand on both rails.
    """
    rows = np.vstack([_flat.geometry_functions(handle, y), np.full(y.size, np.nan)])
    stands = np.isfinite(rows[0])
    if stands.any():
        reach = float(np.max(np.abs(y[stands])))
        n = max(2, round(reach/GEOMETRY_PITCH))
        step = max(reach, GEOMETRY_PITCH)/n
        even = _flat.geometry_functions(handle, step*np.arange(-n, n + 1.0))
        if np.isfinite(even).all():
            rows[-1, stands] = linearised_conicity(np.maximum(np.abs(y[stands]), step), even[0], even[7])
    return rows


def linearised_conicity(amplitude: np.ndarray, y: np.ndarray, delta_r: np.ndarray) -> np.ndarray:
    """Equivalent conicity for amplitudes [m] by harmonic linearisation; NaN where y does not hold the motion."""
    return _flat.linearised_conicities(y, delta_r, amplitude)


def equivalent_conicity(amplitude: np.ndarray, y: np.ndarray, delta_r: np.ndarray) -> np.ndarray:
    """Equivalent conicity for amplitudes, (m,) [m], by EN 15302: of the cone with the same wavelength.

    The wheelset's kinematic motion y'' = -delta_r(y)/(e r) goes from one end to the other, as far apart as twice the
    amplitude, in half a wave. NaN where delta_r turns the wheelset away from the centre of the motion, or y does not hold
    the motion.
    """
    integral = Integral(y, delta_r)
    centre = motion_centre(amplitude, integral)
    # y'^2 = 2/(e r) times the integral of delta_r from y to the end; y = c + a sin tau takes away the singularity at both
    # ends. wave = wavelength / sqrt(e r).
    n = 400
    tau = -np.pi/2 + np.pi*(np.arange(n) + 0.5)/n
    at = centre[:, None] + amplitude[:, None]*np.sin(tau)
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = np.sqrt(2*(integral(centre + amplitude)[:, None] - integral(at)))
        wave = np.sum(2*amplitude[:, None]*np.cos(tau)/speed, axis=1)*np.pi/n
    return np.where(np.isfinite(wave), 2*np.pi**2/wave**2, np.nan)


class Integral:
    """Integral of values that are linear between evenly spaced points y, (n,), from the first point on."""

    def __init__(self, y: np.ndarray, values: np.ndarray) -> None:
        self.y, self.values, self.step = y, values, y[1] - y[0]
        self.area = np.concatenate([[0.0], np.cumsum((values[:-1] + values[1:])/2*self.step)])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """The integral from the first point to x; NaN where x is."""
        share = np.nan_to_num((x - self.y[0])/self.step)
        j = np.clip(share.astype(int), 0, self.y.size - 2)
        share = np.where(np.isnan(x), np.nan, share - j)
        return self.area[j] + self.step*share*(self.values[j] + share*(self.values[j + 1] - self.values[j])/2)


def motion_centre(amplitude: np.ndarray, integral: Integral) -> np.ndarray:
    """Centres of motions about which delta_r is zero in the mean over the way, (m,) [m]; NaN where y holds none.

    The centre is off the track's centre where left and right differ.
    """
    def mean(centre: np.ndarray) -> np.ndarray:
        return (integral(centre + amplitude) - integral(centre - amplitude))/(2*amplitude)

    y, step = integral.y, integral.step
    start = mean(np.zeros_like(amplitude))
    away = -step*np.sign(start)                 # delta_r grows with y: the centre is on the side that lowers the mean
    high = np.where(np.abs(start) <= 1e-12, 0.0, np.nan)        # rounding, where left and right are the same [m]
    seeking = np.isnan(high)
    centre = np.zeros_like(amplitude)
    while seeking.any():
        centre = centre + away
        seeking &= (centre - amplitude >= y[0]) & (centre + amplitude <= y[-1])
        found = seeking & (mean(centre)*start <= 0)
        high[found] = centre[found]
        seeking &= ~found
    low = np.where(high == 0, 0.0, high - away)
    for _ in range(50):                         # a step of 0.1 mm to below the rounding of a displacement
        middle = (low + high)/2
        before = mean(middle)*start > 0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return high
