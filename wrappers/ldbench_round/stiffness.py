"""The law of a contact, fitted to a blow: N = k δⁿ with or without damping."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .blows import Blow
from .estimate import COVERAGE

NONE, BY_DEPTH, BY_RATE = "no damping", "damping that grows with the approach", "damping by the rate alone"
LEAST_ROWS = 8              # of a blow, and of a branch
LEAST_SHARE = 0.02          # of the peak, below which rows are not fitted: there the zero of the approach decides
EXPONENTS = 0.6, 3.5        # that are tried
ROUNDS, POINTS = 24, 17     # of the search


@dataclass(frozen=True)
class Law:
    """N = k (δ - zero)ⁿ, times (1 + damping dδ/dt) or plus damping dδ/dt; SI units, uncertainties of two standard deviations."""

    kind: str               # of damping
    k: float                # [N/mⁿ]
    n: float
    zero: float             # [m]
    damping: float          # [s/m] or [N s/m]
    misfit: float           # rms of the residual over the largest force
    u_n: float
    u_log_k: float          # at the mean approach of the fit, where k and n are independent
    u_damping: float

    def force(self, approach: float) -> float:
        """Elastic force [N] at an approach [m]."""
        return float(self.k*max(approach, 0.0)**self.n)

    def approach(self, force: float) -> float:
        """Approach [m] of an elastic force [N]."""
        return float((force/self.k)**(1/self.n))

    def without_damping(self, blow: Blow) -> np.ndarray:
        """The elastic part of the force of a blow, (rows,) [N]."""
        if self.kind == BY_RATE:
            return blow.force - self.damping*blow.closing
        return blow.force/np.maximum(1 + self.damping*blow.closing, 0.1) if self.kind == BY_DEPTH else blow.force


def fit_law(blow: Blow, kind: str, branch: int = 0) -> Law | None:
    """Fit a law to a blow, or to its closing (1) or opening (-1) branch; None for fewer than LEAST_ROWS rows.

    For each exponent and zero of the approach, stiffness and damping follow from linear least squares; the best pair is found
    by a search on ever finer grids.
    """
    top = int(blow.force.argmax())
    used = blow.force > LEAST_SHARE*blow.peak
    if branch:
        used &= on_branch(blow.closing, top, branch)
    d, v, force = blow.approach[used], blow.closing[used], blow.force[used]
    if d.size < LEAST_ROWS or np.ptp(d) <= 0:
        return None
    reach = float(np.ptp(d))
    low, high = np.array([EXPONENTS[0], d.min() - 0.5*reach]), np.array([EXPONENTS[1], d.min() + 0.2*reach])
    limits = low.copy(), high.copy()
    best = np.empty(2)
    for _ in range(ROUNDS):
        n, zero = (axis.ravel() for axis in np.meshgrid(*np.linspace(low, high, POINTS).T, indexing="ij"))
        misfit = linear_fit(n, zero, d, v, force, kind)[2]
        best = np.array([n[misfit.argmin()], zero[misfit.argmin()]])
        half = 0.3*(high - low)
        low, high = np.maximum(best - half, limits[0]), np.minimum(best + half, limits[1])
    k, damping, square = (float(x[0]) for x in linear_fit(best[:1], best[1:], d, v, force, kind))
    if k <= 0:
        return None
    return with_uncertainty(kind, k, float(best[0]), float(best[1]), damping, d, v, force, square)


def on_branch(closing: np.ndarray, top: int, branch: int) -> np.ndarray:
    """The rows from the largest force back (1) or on (-1) as long as the contact closes, or opens; (rows,)."""
    wrong = np.flatnonzero(branch*closing < 0)
    rows = np.arange(closing.size)
    if branch > 0:
        return (rows <= top) & (rows > wrong[wrong < top].max(initial=-1))
    return (rows >= top) & (rows < wrong[wrong > top].min(initial=closing.size))


def shapes(n: np.ndarray, zero: np.ndarray, d: np.ndarray, v: np.ndarray, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Force per stiffness and per damping, (candidates, rows) each."""
    elastic = np.maximum(d - zero[:, None], 0.0)**n[:, None]
    return elastic, {NONE: np.zeros_like(elastic), BY_DEPTH: elastic*v, BY_RATE: (elastic > 0)*v}[kind]


def linear_fit(n: np.ndarray, zero: np.ndarray, d: np.ndarray, v: np.ndarray, force: np.ndarray,
               kind: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stiffness, damping as `Law` has it, and mean square of the residual for candidates of exponent and zero, (candidates,)."""
    e, r = shapes(n, zero, d, v, kind)
    ee, er, rr = (np.sum(a*b, axis=1) for a, b in ((e, e), (e, r), (r, r)))
    ef, rf = e @ force, r @ force
    if kind == NONE:
        k, c = ef/np.maximum(ee, 1e-300), np.zeros_like(ef)
    else:
        scale = ee*rr - er**2
        scale[scale <= 1e-12*ee*rr] = np.inf
        k, c = (ef*rr - rf*er)/scale, (rf*ee - ef*er)/scale
    residual = force - k[:, None]*e - c[:, None]*r
    if kind == BY_DEPTH:
        c = c/np.where(k != 0, k, np.inf)
    return k, c, np.mean(residual**2, axis=1)


def with_uncertainty(kind: str, k: float, n: float, zero: float, damping: float, d: np.ndarray, v: np.ndarray,
                     force: np.ndarray, square: float) -> Law:
    """The law with the uncertainties of its numbers."""
    x = np.maximum(d - zero, 1e-9)
    middle = float(np.exp(np.average(np.log(x), weights=force)))
    elastic = k*x**n
    rate = {NONE: None, BY_DEPTH: elastic*v, BY_RATE: v}[kind]
    growth = 1 + damping*v if kind == BY_DEPTH else 1.0
    columns = [elastic*growth, elastic*growth*np.log(x/middle), -n*elastic*growth/x, *([rate] if rate is not None else [])]
    jacobian = np.column_stack(columns)
    residual = force - elastic*growth - (damping*v if kind == BY_RATE else 0.0)
    u = uncertainties(jacobian, residual)
    return Law(kind, k, n, zero, damping, float(np.sqrt(square)/force.max()), float(u[1]), float(u[0]),
               float(u[3]) if rate is not None else 0.0)


def uncertainties(jacobian: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Uncertainties of fitted numbers, (numbers,), by the rates of the force with each, (rows, numbers), and what the fit leaves.

    What is left of neighbouring rows is alike, so that rows count as fewer.
    """
    square = float(np.sum(residual**2))
    alike = float(np.clip(np.sum(residual[1:]*residual[:-1])/max(square, 1e-300), 0, 0.95))
    freedom = max(residual.size*(1 - alike)/(1 + alike) - jacobian.shape[1], 1.0)
    size = np.sqrt(np.sum(jacobian**2, axis=0))
    size[size == 0] = 1.0
    scaled = jacobian/size
    covariance = np.linalg.pinv(scaled.T @ scaled)*square/freedom/np.outer(size, size)
    return COVERAGE*np.sqrt(np.maximum(np.diag(covariance), 0))
