"""Geometry functions of the rigid wheelset at any displacement, and the equivalent conicity by EN 15302.

Sources: EN 15302:2021; O. Polach, D. Nicklisch, Wear 366-367 (2016) 200-208; K. Knothe, S. Stichel, Rail Vehicle Dynamics,
Springer 2017.

delta_r is the rolling radius difference, left minus right [m], at lateral displacements y [m] that increase evenly.
"""
from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ._core import flat
from ._core.calls import Handle

# Geometry functions of the rigid wheelset, and their SI units.
GEOMETRY = {"Y": "m", "roll": "rad", "Z": "m", "angle_L": "rad", "angle_R": "rad", "radius_L": "m", "radius_R": "m", "delta_r": "m",
            "y_L": "m", "z_L": "m", "y_R": "m", "z_R": "m", "conicity": "1"}
GEOMETRY_PITCH = 1e-4       # between rows of geometry functions [m]
PHASES = 200                # of a period, from which harmonic linearisation takes its means
FINE_PITCH = 2e-5           # between rows from which the conicity is integrated where the radius difference may jump [m]
ROLL_STRIDE, LARGEST_ROLL = 1e-3, 0.1       # two ways to stand on both rails are farther apart than the stride [rad]
SAME, MISSED = 1e-13, 1e-9  # difference of heights or radii that ends a search, that is refused after it [m]
ROUNDING = 1e-12            # of radii, and of places at the ends of y [m]
NO_DIFFERENCE = 1e-9        # a radius difference that is below this over all of a motion does not steer [m]


def geometry_rows(handle: Handle, y: np.ndarray) -> np.ndarray:
    """Geometry functions of a prepared case at lateral displacements y, (n,) [m]: (13, n), in the order of `GEOMETRY`.

    The last row is the equivalent conicity for the amplitude |y| by harmonic linearisation, from rows that are about
    GEOMETRY_PITCH apart. A column is NaN where the rigid wheelset does not stand on both rails.
    """
    rows = np.vstack([flat.geometry_rows(handle, y), np.full(y.size, np.nan)])
    stands = np.isfinite(rows[0])
    if stands.any():
        reach = float(np.max(np.abs(y[stands])))
        n = max(2, round(reach/GEOMETRY_PITCH))
        step = max(reach, GEOMETRY_PITCH)/n
        even = flat.geometry_rows(handle, step*np.arange(-n, n + 1.0))
        if np.isfinite(even).all():
            rows[-1, stands] = linearised_conicity(np.maximum(np.abs(y[stands]), step), even[0], even[7])
    return rows


def level_rows(handle: Handle, y: np.ndarray, raised: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Geometry functions of the wheelset that is kept level, as EN 15302 has it, (12, n): each wheel touches its own rail.

    The roll angle is what the heights of the two wheels stand for. `raised` says by how much the surfaces of the left and the
    right wheel lie nearer to the axle than the case has them [m].
    """
    left, right = both_wheels(handle, y, np.zeros_like(y), raised)
    return gathered(y, (left[0] - right[0])/(left[4] + right[4]), left, right, raised)


def rolled_rows(handle: Handle, y: np.ndarray, raised: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """Geometry functions of the wheelset that stands on both rails, (12, n); `raised` as in `level_rows`.

    The roll angle is the least one at which both wheels touch; a column is NaN where there is none.
    """
    if raised == (0.0, 0.0):
        return flat.geometry_rows(handle, y)

    def difference(at: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """Height at which the left wheel touches less the one of the right wheel, at places `at` of y and roll angles [m]. A
        positive one asks for roll that lifts the left wheel."""
        left, right = both_wheels(handle, y[at], phi, raised)
        return np.where(np.abs(phi) <= LARGEST_ROLL, left[0] - right[0], np.nan)

    roll = nearest_root(difference, y.size, ROLL_STRIDE)
    found = np.full((12, y.size), np.nan)
    at = np.flatnonzero(np.isfinite(roll))
    left, right = both_wheels(handle, y[at], roll[at], raised)
    found[:, at] = gathered(y[at], roll[at], left, right, raised)
    return found


def both_wheels(handle: Handle, y: np.ndarray, roll: np.ndarray, raised: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Contacts of the left and the right wheel alone at a roll angle, rows of `wheel_contacts`."""
    # A surface that is raised in the wheelset touches as the surface of the case does with the axle elsewhere.
    left = flat.wheel_contacts(handle, 1, y - raised[0]*np.sin(roll), roll)
    right = flat.wheel_contacts(handle, 2, -y + raised[1]*np.sin(roll), -roll)
    left[0] -= raised[0]*np.cos(roll)
    right[0] -= raised[1]*np.cos(roll)
    return left, right


def nearest_root(function: Callable[[np.ndarray, np.ndarray], np.ndarray], n: int, stride: float) -> np.ndarray:
    """Arguments nearest to 0 at which function(places, arguments) vanishes, (n,); NaN where none is found.

    A positive value at 0 asks for a larger argument. A search goes away from 0 in strides and ends where the function is NaN.
    """
    inner, outer = np.zeros(n), np.zeros(n)
    start = function(np.arange(n), inner)
    near, far = start.copy(), start.copy()
    seeking = np.flatnonzero(np.isfinite(start) & (start != 0))
    while seeking.size:
        inner[seeking], near[seeking] = outer[seeking], far[seeking]
        outer[seeking] += np.copysign(stride, start[seeking])
        far[seeking] = function(seeking, outer[seeking])
        seeking = seeking[far[seeking]*start[seeking] > 0]
    root = np.where(far*start <= 0, outer, np.nan)
    at = np.flatnonzero(np.isfinite(root) & (far != 0))
    for k in range(60):             # regula falsi with halved values (Illinois), and bisection where it creeps
        at = at[np.abs(far[at]) > SAME]
        if not at.size:
            break
        share = far[at]/(far[at] - near[at]) if k < 20 else 0.5
        middle = outer[at] + share*(inner[at] - outer[at])
        found = function(at, middle)
        beyond = found*far[at] < 0
        near[at] = np.where(beyond, far[at], near[at]/2)
        inner[at] = np.where(beyond, outer[at], inner[at])
        outer[at], far[at] = middle, found
    return np.where(np.isfinite(root) & (np.abs(far) <= MISSED), outer, np.nan)


def gathered(y: np.ndarray, roll: np.ndarray, left: np.ndarray, right: np.ndarray, raised: tuple[float, float]) -> np.ndarray:
    """Rows in the order of `GEOMETRY`, without the conicity, from the contacts of both wheels; Z is from y = 0."""
    z = (left[0] + right[0])/2
    centred = np.flatnonzero(np.isfinite(z))
    z = z - z[centred[np.argmin(np.abs(y[centred]))]] if centred.size else z
    radii = -left[3] - raised[0], -right[3] - raised[1]
    rows = np.array([y, roll, z, left[1], right[1], *radii, radii[0] - radii[1], left[4], left[5], -right[4], right[5]])
    return np.where(np.isfinite(rows[7]), rows, np.nan)


def linearised_conicity(amplitude: np.ndarray, y: np.ndarray, delta_r: np.ndarray) -> np.ndarray:
    """Equivalent conicity for amplitudes, (m,) [m], by harmonic linearisation of the rolling radius difference: 1/(pi a) times
    the integral over one period of delta_r(c + a sin tau)/2 sin tau dtau. The mean of delta_r over the period is zero about the
    centre c, which is off the track's centre where left and right differ. NaN where y does not hold the motion.
    """
    wave = np.sin(2*np.pi*(np.arange(PHASES) + 0.5)/PHASES)

    def motion(at: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """delta_r over a period about centres, (n, PHASES)."""
        places = centre[:, None] + amplitude[at][:, None]*wave
        inside = np.abs(places - (y[0] + y[-1])/2).max(axis=1) <= (y[-1] - y[0])/2 + ROUNDING
        return np.where(inside[:, None], np.interp(places, y, delta_r), np.nan)

    def mean(at: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """The mean of delta_r about -centre; none that is above rounding where left and right are the same."""
        found = motion(at, -centre).mean(axis=1)
        return np.where(np.abs(found) <= ROUNDING, 0.0, found)

    every = np.arange(amplitude.size)
    return np.asarray((motion(every, -nearest_root(mean, amplitude.size, y[1] - y[0]))*wave).mean(axis=1)/amplitude)


def equivalent_conicity(amplitude: np.ndarray, y: np.ndarray, delta_r: np.ndarray) -> np.ndarray:
    """Equivalent conicity for amplitudes, (m,) [m], by EN 15302: of the cone with the same wavelength.

    The wheelset's kinematic motion y'' = -delta_r(y)/(e r) goes from one end to the other, as far apart as twice the
    amplitude, in half a wave. The conicity is 0 where delta_r vanishes over all of the motion, and NaN where delta_r turns the
    wheelset away from the centre of the motion, or y does not hold the motion.
    """
    integral = integral_of(y, delta_r)
    centre = motion_centre(amplitude, y, delta_r)
    # y'^2 = 2/(e r) times the integral of delta_r from y to the end; y = c + a sin tau takes away the singularity at both
    # ends. wave = wavelength / sqrt(e r).
    n = 400
    tau = -np.pi/2 + np.pi*(np.arange(n) + 0.5)/n
    at = centre[:, None] + amplitude[:, None]*np.sin(tau)
    work = integral(centre + amplitude)[:, None] - integral(at)
    with np.errstate(invalid="ignore", divide="ignore"):
        wave = np.sum(2*amplitude[:, None]*np.cos(tau)/np.sqrt(2*work), axis=1)*np.pi/n
    straight = np.max(np.abs(work), axis=1) < NO_DIFFERENCE*amplitude
    return np.where(straight, 0.0, np.where(np.isfinite(wave), 2*np.pi**2/wave**2, np.nan))


def harmonic_slope(amplitude: float, centre: float, y: np.ndarray, values: np.ndarray) -> float:
    """Slope of the line that stands for a function of y over a harmonic motion: 1/(pi a) int_0^2pi f(c + a sin t) sin t dt."""
    tau = 2*np.pi*(np.arange(400) + 0.5)/400
    return float(2*np.mean(np.interp(centre + amplitude*np.sin(tau), y, values)*np.sin(tau))/amplitude)


def integral_of(y: np.ndarray, values: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The integral, as a function of its end, of values that are linear between points y."""
    from scipy.interpolate import make_interp_spline  # takes longer than a short run

    return make_interp_spline(y, values, k=1).antiderivative()


def motion_centre(amplitude: np.ndarray, y: np.ndarray, delta_r: np.ndarray) -> np.ndarray:
    """Centres of motions about which delta_r is zero in the mean over the way, (m,) [m]; NaN where y holds none.

    The centre is off the track's centre where left and right differ. delta_r grows with y: a positive mean asks for a centre
    farther to the right.
    """
    integral = integral_of(y, delta_r)

    def mean(at: np.ndarray, centre: np.ndarray) -> np.ndarray:
        """The mean of delta_r over motions about -centre [m]; none that is above rounding where left and right are the same."""
        low, high = -centre - amplitude[at], -centre + amplitude[at]
        found = (integral(high) - integral(low))/(2*amplitude[at])
        inside = (low >= y[0] - ROUNDING) & (high <= y[-1] + ROUNDING)
        return np.where(np.abs(found) <= ROUNDING, 0.0, np.where(inside, found, np.nan))

    return -nearest_root(mean, amplitude.size, y[1] - y[0])
