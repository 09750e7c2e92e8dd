"""The law of a contact, fitted to a blow: N = k δⁿ with or without damping."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from .blows import Blow
from .estimate import COVERAGE

NONE, BY_DEPTH, BY_RATE = "no damping", "damping that grows with the approach", "damping by the rate alone"
LEAST_ROWS = 8              # of a blow, and of a branch
LEAST_SHARE = 0.02          # of the peak, below which rows are not fitted: there the zero of the approach decides
EXPONENTS = 0.6, 3.5        # that a law may have
TRIED = 1.0, 1.5, 2.5       # exponents from which a fit begins


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
    """Fit a law to a blow, or to its closing (1) or opening (-1) branch, by least squares; None for fewer than LEAST_ROWS rows."""
    top = int(blow.force.argmax())
    used = blow.force > LEAST_SHARE*blow.peak
    if branch:
        used &= on_branch(blow.closing, top, branch)
    d, v, force = blow.approach[used], blow.closing[used], blow.force[used]
    if d.size < LEAST_ROWS or np.ptp(d) <= 0:
        return None
    reach, peak = float(np.ptp(d)), float(force.max())

    def missed(p: np.ndarray) -> np.ndarray:
        """What a law misses of the forces over the peak. p: logarithm of the force over the peak at the approach `reach`, exponent,
        and zero of the approach over `reach`; the part of the peak that damping makes of the largest velocity."""
        elastic = np.exp(p[0])*np.maximum(d/reach - p[2], 0.0)**p[1]
        share = p[3]*v/fastest if kind != NONE else 0.0
        return np.asarray(elastic*(1 + share) if kind == BY_DEPTH else elastic + (elastic > 0)*share) - force/peak

    fastest = float(np.abs(v).max()) or 1.0
    first = float(d.min()/reach)
    low, high = [-20.0, EXPONENTS[0], first - 0.5, -10.0], [20.0, EXPONENTS[1], first + 0.2, 10.0]
    found = min((least_squares(missed, [0.0, n, first - 0.05, 0.0], bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-12)
                 for n in TRIED), key=lambda one: float(one.cost))
    log_k, n, zero, share = found.x.tolist()
    damping = share*{NONE: 0.0, BY_DEPTH: 1.0, BY_RATE: peak}[kind]/fastest
    return with_uncertainty(kind, float(peak*np.exp(log_k)/reach**n), n, zero*reach, damping, d, v, force)


def on_branch(closing: np.ndarray, top: int, branch: int) -> np.ndarray:
    """The rows from the largest force back (1) or on (-1) as long as the contact closes, or opens; (rows,)."""
    wrong = np.flatnonzero(branch*closing < 0)
    rows = np.arange(closing.size)
    if branch > 0:
        return (rows <= top) & (rows > wrong[wrong < top].max(initial=-1))
    return (rows >= top) & (rows < wrong[wrong > top].min(initial=closing.size))


def with_uncertainty(kind: str, k: float, n: float, zero: float, damping: float, d: np.ndarray, v: np.ndarray,
                     force: np.ndarray) -> Law:
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
    return Law(kind, k, n, zero, damping, float(np.sqrt(np.mean(residual**2))/force.max()), float(u[1]), float(u[0]),
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
