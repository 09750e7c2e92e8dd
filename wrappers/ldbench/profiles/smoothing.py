"""A smooth curve near measured points.

Cubic B-splines on equally spaced knots minimise, over points p_i at stations s_i,

    sum |r(s_i) - p_i|^2 + lambda sum w_j |d_j|^2,

d_j the third differences of the coefficients: they tell how the curvature varies (P. H. C. Eilers, B. D. Marx, "Flexible
smoothing with B-splines and penalties", Statistical Science 11 (1996) 89-121). With equal weights a corner would be rounded
off and would ring. So the weights yield where the curvature really varies, w_j = 1/sqrt(1 + (d_j/median d)^2), which makes the
sum nearly one of |d_j|: reweighted least squares, as for total variation (P. Rodriguez, B. Wohlberg, IEEE Trans. Image Process. 18
(2009) 322-332). Arcs and straight lines, of which new profiles are made, come out as such. Where the curve still keeps
farther from its points than the noise explains, the weights there are lowered further.

The noise is that of generalised cross-validation (P. Craven, G. Wahba, Numer. Math. 31 (1979) 377-403), with the trace
estimated from random signs (M. F. Hutchinson, Communications in Statistics 19 (1990) 433-450). lambda follows from the distance
that the curve may keep (C. H. Reinsch, Numer. Math. 10 (1967) 177-183). A station is the arc length at the foot of its point
(J. Hoschek, "Intrinsic parametrization for approximation", CAGD 5 (1988) 27-31).
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

DIFFERENCE = -1.0, 3.0, -3.0, 1.0   # of the third order
FINEST, COARSEST = 0.25, 0.5        # between knots [mm]
ROUNDS = 16, 6                      # of weights: at chord lengths, at feet
TRIALS, RANGE = 31, 40.0            # values of ln(lambda), and how far they reach
GAIN = 3.0                          # of lambda over the distance: a distance hardly grows with lambda
NEAR = 0.3                          # to either side, over which a local distance is a mean, of three points at least [mm]
CHANCE = 1e-3                       # that noise alone makes a local distance from which the weights are lowered
MOST_RELIEF = 1e3                   # of a weight: without any the equations have no solution between distant points
FAR = 3.0                           # distance of three points over noise from which the place is told


@dataclass(frozen=True)
class Smoothed:
    """A smoothed curve and how near it is to the points that it was made of."""
    points: np.ndarray      # at the knots, (m, 2) [mm]
    noise: float            # of the points, rms, normal to the curve [mm]
    distance: float         # between curve and points, rms [mm]
    far: np.ndarray         # places (y, z) where the curve keeps farther from its points than FAR times the noise, (k, 2) [mm]


class Splines:
    """The equations of k cubic B-splines on knots 0, 1, 2, ... for points at stations x [intervals]."""

    def __init__(self, points: np.ndarray, x: np.ndarray, k: int) -> None:
        from scipy.interpolate import BSpline
        from scipy.sparse import diags

        self.points, self.k = points, k
        self.at_points = BSpline.design_matrix(x, knots(k), 3)      # times coefficients: the splines at the stations
        self.differences = diags(DIFFERENCE, range(4), (k - 3, k))
        self.normal = self.at_points.T @ self.at_points
        self.right = self.at_points.T @ points

    def solve(self, log_lambda: float, weights: np.ndarray, right: np.ndarray | None = None) -> np.ndarray:
        """Coefficients for a penalty with weights of the k - 3 third differences."""
        from scipy.linalg import solveh_banded

        penalty = self.differences.T @ self.differences.multiply(weights[:, None])
        whole = np.exp(log_lambda)*penalty + self.normal
        band = np.stack([np.pad(whole.diagonal(above), (above, 0)) for above in (3, 2, 1, 0)])
        return solveh_banded(band, self.right if right is None else right, check_finite=False)


def smooth(points: np.ndarray, distance: float | None = None, least: float = 0.0, most: float = np.inf) -> Smoothed:
    """The smooth curve near points (n, 2) [mm], which follow a profile.

    distance: the rms distance that the curve may keep from them [mm]; None for their noise, which is from `least` to `most` [mm].
    """
    from scipy.interpolate import BSpline
    from scipy.stats import chi2

    s = chord_lengths(points)
    n = len(points)
    m = min(max(8, round(s[-1]/np.clip(s[-1]/(n - 1), FINEST, COARSEST))), n)
    x, k = s*(m/s[-1]), m + 3
    splines = Splines(points, np.minimum(x, m), k)
    logs, distances, noise = cross_validated(splines)
    noise = max(min(noise, most), least)
    asked = noise if distance is None else distance
    log_lambda = float(np.interp(asked, distances, logs))
    relief = np.ones(k - 3)
    near = max(1, int(NEAR*n/s[-1]))
    usual = asked*np.sqrt(chi2.isf(CHANCE, 2*near + 1)/(2*near + 1))
    c = splines.solve(log_lambda, relief)
    for rounds in ROUNDS:
        if rounds is not ROUNDS[0]:
            x, order = feet(c, points, x)
            x = x[order]
            splines = Splines(points[order], x, k)
        for _ in range(rounds):
            squares = np.sum((splines.at_points @ c - splines.points)**2, 1)
            log_lambda += np.clip(GAIN*np.log(asked/np.sqrt(np.mean(squares))), -1.6, 1.6)
            log_lambda = max(float(log_lambda), logs[0])
            relieve(relief, x, np.sqrt(local_mean(squares, near))/usual)
            d = np.hypot(*np.diff(c, 3, axis=0).T)
            try:
                c = splines.solve(log_lambda, 1/(relief*np.sqrt(1 + (d/(np.median(d) + 1e-12))**2)))
            except np.linalg.LinAlgError:       # as above
                log_lambda -= 2
    squares = np.sum((splines.at_points @ c - splines.points)**2, 1)
    far = peaks(np.sqrt(local_mean(squares, 1)), FAR*noise)
    return Smoothed(BSpline(knots(k), c, 3)(np.arange(m + 1.0)), noise, float(np.sqrt(np.mean(squares))), splines.points[far])


def cross_validated(splines: Splines) -> tuple[np.ndarray, np.ndarray, float]:
    """Values of ln(lambda), the rms distances [mm] with equal weights at them, which grow, and the noise of the points [mm]."""
    n = len(splines.points)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (n, 2))
    right = np.concatenate([splines.right, splines.at_points.T @ signs], 1)
    equal = np.ones(splines.k - 3)
    low = np.log(1e-7*splines.normal.diagonal().sum()/(20*splines.k))
    logs, distances, best, noise = [], [], np.inf, 0.0
    for log_lambda in low + np.linspace(0, RANGE, TRIALS):
        try:
            values = splines.at_points @ splines.solve(log_lambda, equal, right)
        except np.linalg.LinAlgError:       # rounding spoils the system: lambda is far too large
            break
        logs.append(log_lambda)
        distances.append(np.sqrt(np.mean(np.sum((values[:, :2] - splines.points)**2, 1))))
        free = 1 - np.sum(signs*values[:, 2:])/signs.size       # share of degrees of freedom that is left
        if free > 0.02 and distances[-1]/free < best:
            best, noise = distances[-1]/free, float(distances[-1]/np.sqrt(free))
    return np.array(logs), np.maximum.accumulate(distances), noise


def relieve(relief: np.ndarray, x: np.ndarray, excess: np.ndarray) -> None:
    """Lower the weights of the differences about points at x [intervals] whose local distance is too large by a factor `excess`."""
    far = np.flatnonzero(excess > 1)
    if len(far):
        about = np.clip(x[far, None].astype(int) + np.arange(-3, 4), 0, len(relief) - 1)
        factor = np.ones(len(relief))
        np.maximum.at(factor, about.ravel(), np.repeat(excess[far]**2, about.shape[1]))
        np.minimum(relief*factor, MOST_RELIEF, out=relief)


def chord_lengths(points: np.ndarray) -> np.ndarray:
    """Length of the polygon up to every point, (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def local_mean(values: np.ndarray, near: int) -> np.ndarray:
    """Mean over every value and `near` to either side of it."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    i = np.arange(len(values))
    low, high = np.maximum(i - near, 0), np.minimum(i + near + 1, len(values))
    return (total[high] - total[low])/(high - low)


def peaks(values: np.ndarray, least: float) -> np.ndarray:
    """Places of the largest value in every stretch of values above `least`."""
    above = np.concatenate([[False], values > least, [False]])
    ends = np.flatnonzero(np.diff(above.astype(int))).reshape(-1, 2)
    return np.array([low + np.argmax(values[low:high]) for low, high in ends], dtype=int)


def knots(k: int) -> np.ndarray:
    """The knots of k cubic B-splines, one to an interval."""
    return np.arange(-3.0, k + 1)


def feet(c: np.ndarray, points: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the feet of points are on the curve [intervals], from places nearby, and their order along it."""
    from scipy.interpolate import BSpline

    curve = BSpline(knots(len(c)), c, 3)
    for _ in range(3):
        r, slope = curve(x), curve(x, 1)
        x = x + np.clip(np.sum((points - r)*slope, 1)/np.sum(slope**2, 1), -0.5, 0.5)
    x = np.clip(x, 0, len(c) - 3)
    return x, np.argsort(x, kind="stable")
