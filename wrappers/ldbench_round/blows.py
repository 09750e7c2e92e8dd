"""Blows of a contact in a file of any code: normal force over approach, from the columns of motion and contact alone, and the law
N = k δⁿ, with or without damping, that is fitted to a blow.

No code writes the approach of its bodies. Its rate is the velocity at which the contact point of the wheel enters the rail
along the normal, whatever the contact law, because the normal force does no work on a motion along the tangent.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ldbench import Case
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.derived import cumulative
from ldbench.results.run_data import RunData

from .findings import COVERAGE
from .row_checks import MODULUS, axle_height

NEEDED = "Y", "Z", "vY", "vZ", "roll_rate"
OF_CONTACT = "N", "angle", "y", "z"
LEAST_FORCE = 1e4       # of an impact that counts [N]
TELLING_ROWS = 4        # of a blow that shows whether bodies give
GIVES = 0.1             # approach over that of steel, above which a contact is elastic
NEAREST = 5e-3          # distance of tread and flange contact in which a load is no point any more [m]
NONE, BY_DEPTH, BY_RATE = "no damping", "damping that grows with the approach", "damping by the rate alone"
LEAST_ROWS = 8              # of a blow
LEAST_SHARE = 0.02          # of the peak, below which rows are not fitted: there the zero of the approach decides
EXPONENTS = 0.6, 3.5        # that a law may have
TRIED = 1.0, 1.5, 2.5       # exponents from which a fit begins


@dataclass(frozen=True)
class Blow:
    """The motion in an interval in which a contact is closed; arrays over its closed rows, (rows,)."""

    interval: ContactInterval
    time: np.ndarray        # [s]
    force: np.ndarray       # normal [N]
    closing: np.ndarray     # rate of the approach [m/s]
    approach: np.ndarray    # since the contact closed [m]
    angle: np.ndarray       # contact angle [rad]
    lowered: np.ndarray     # how far the load of the wheel's tread lowers the surface here [m]

    @property
    def peak(self) -> float:
        """The largest normal force of the rows [N]."""
        return float(self.force.max())

    @property
    def approach_share(self) -> float:
        """Range of the approach over that of steel for the same force."""
        return float(np.ptp(self.approach))/(self.peak/MODULUS)**(2/3)

    @property
    def energy(self) -> tuple[float, float]:
        """Energy that goes into the contact while it closes, and that comes back [J]."""
        power = np.concatenate([[0.0], self.force*self.closing, [0.0]])
        t = np.concatenate([[self.interval.start], self.time, [self.interval.end]])
        # The power bends where it changes its sign, but its integral over both branches is that of a smooth function.
        put_in = float(cumulative(t, np.maximum(power, 0))[-1])
        return put_in, put_in - float(smooth_integral(t, power)[-1])


def lacking(run: RunData, contacts: Sequence[str]) -> list[str]:
    """The columns that an approach needs and the file has not."""
    return [name for name in (*NEEDED, *(f"{base}_{c}" for c in contacts for base in OF_CONTACT)) if name not in run.data]


def closing_velocity(run: RunData, contact: str, height: float) -> np.ndarray:
    """Velocity at which the contact point of the wheel enters the rail along the normal, (rows,) [m/s]; NaN where it is open.

    height: of the axle above the top of rail at Z = 0 [m].
    """
    inward = -1.0 if contact[0] == "L" else 1.0
    # Either sign of the angle is in use; that of a flange, or of a tread, does not change.
    angle = np.abs(run.values(f"angle_{contact}"))
    a_y, a_z = run.values(f"y_{contact}") - run.values("Y"), run.values(f"z_{contact}") - run.values("Z") - height
    rate = run.values("roll_rate")
    v_y, v_z = run.values("vY") - rate*a_z, run.values("vZ") + rate*a_y
    return -(inward*np.sin(angle)*v_y + np.cos(angle)*v_z)


def lowering(run: RunData, contact: str, softness: float) -> np.ndarray:
    """How far the load N of the same wheel's tread lowers the surface of a flange along its normal, (rows,) [m].

    In a half-space, N cos(γ)/(π E* d) at the distance d, with the angle γ between both normals. softness: 1/(π E*) [m²/N].
    """
    tread = contact[0] + "T"
    if not softness or lacking(run, [tread]):
        return np.zeros(run.time.size)
    distance = np.hypot(*(run.values(f"{axis}_{contact}") - run.values(f"{axis}_{tread}") for axis in "yz")).clip(NEAREST)
    between = np.abs(run.values(f"angle_{contact}")) - np.abs(run.values(f"angle_{tread}"))
    return np.nan_to_num(run.values(f"N_{tread}")*np.cos(between)*softness/distance)


def blows(run: RunData, contact: str, height: float, least: float, softness: float = 0.0) -> list[Blow]:
    """The blows of a contact whose force reaches `least` [N], in order of time; of a flange, without those of its root.

    With a softness of the half-space, 1/(π E*) [m²/N], the approach is that to the surface which the tread has lowered.
    """
    found = []
    closing, lowered = closing_velocity(run, contact, height), lowering(run, contact, softness)
    time, force, angle = run.time, np.nan_to_num(run.values(f"N_{contact}")), np.abs(run.values(f"angle_{contact}"))
    for one in run.intervals(contact, rigid=False) or []:
        if not one.is_impact or one.at_root:
            continue
        rows = np.arange(one.rows.start, one.rows.stop)
        rows = rows[np.isfinite(closing[rows])]
        # Rows at equal times, as at an event, count once.
        rows = rows[np.append(np.diff(time[rows]) > 0, True)] if rows.size else rows
        if not rows.size or force[rows].max() < least:
            continue
        t, v, low = time[rows], closing[rows], lowered[rows]
        approach = max(t[0] - one.start, 0.0)*v[0] + smooth_integral(t, v) - (low - low[0])
        v = v - (np.gradient(low, t) if t.size > 1 else 0.0)
        found.append(Blow(one, t, force[rows], v, approach, angle[rows], low))
    return sorted(found, key=lambda blow: blow.interval.start)


def first_blow_gives(run: RunData, case: Case) -> bool:
    """Whether the first blow of a flange that has enough rows is that of bodies that approach each other, as elastic ones do."""
    told = [blow for contact in ("LF", "RF") if not lacking(run, [contact])
            for blow in blows(run, contact, axle_height(case), LEAST_FORCE) if blow.time.size >= TELLING_ROWS]
    return bool(told) and min(told, key=lambda blow: blow.interval.start).approach_share > GIVES


def smooth_integral(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The integral of a smooth x over t from the first row, (rows,): trapezoidal rule with the correction of its ends' slopes."""
    whole = cumulative(t, x)
    if t.size < 3:
        return whole
    slope = np.gradient(x, t)
    return whole + np.concatenate([[0.0], np.cumsum(np.diff(t)**2*(slope[:-1] - slope[1:])/12)])


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

    def without_damping(self, blow: Blow) -> np.ndarray:
        """The elastic part of the force of a blow, (rows,) [N]."""
        if self.kind == BY_RATE:
            return blow.force - self.damping*blow.closing
        return blow.force/np.maximum(1 + self.damping*blow.closing, 0.1) if self.kind == BY_DEPTH else blow.force


def fit_law(blow: Blow, kind: str) -> Law | None:
    """Fit a law to a blow by least squares; None for fewer than LEAST_ROWS rows."""
    used = blow.force > LEAST_SHARE*blow.peak
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
    k, zero = float(peak*np.exp(log_k)/reach**n), zero*reach
    damping = share*{NONE: 0.0, BY_DEPTH: 1.0, BY_RATE: peak}[kind]/fastest
    x = np.maximum(d - zero, 1e-9)
    middle = float(np.exp(np.average(np.log(x), weights=force)))
    elastic = k*x**n
    growth = 1 + damping*v if kind == BY_DEPTH else 1.0
    rates = [elastic*growth, elastic*growth*np.log(x/middle), -n*elastic*growth/x, *{
        NONE: [], BY_DEPTH: [elastic*v], BY_RATE: [v]}[kind]]
    residual = force - elastic*growth - (damping*v if kind == BY_RATE else 0.0)
    u_log_k, u_n, _, *u_damping = uncertainties(np.column_stack(rates), residual).tolist()
    return Law(kind, k, n, zero, damping, float(np.sqrt(np.mean(residual**2))/peak), u_n, u_log_k, sum(u_damping))


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
