"""Velocities that jump between two rows, as those of rigid codes do, and the step of an integrator that writes every step."""
from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ldbench import Case
from ldbench.constants import CONTACTS
from ldbench.results.run_data import RunData

from .blows import first_blow_gives
from .findings import Estimate
from .lattice import bends, digit_noise, find_lattice
from .submissions import quiet
from .tasks import Task

IMPULSES = tuple(f"P_{contact}" for contact in CONTACTS)
VELOCITIES, ACCELERATIONS = ("vY", "vZ", "roll_rate"), ("aY", "aZ", "roll_acc")
LARGE = 0.1             # of the largest velocity, in the kinetic norm, from which a jump is one
NEARLY = 0.1            # share of a change of velocity that accelerations may leave unexplained, where nothing jumps
SHORT = 0.25e-3         # interval of rows in which no elastic impact of steel begins and ends [s]: it lasts some milliseconds
RELATION = 0.05         # share of what a smooth motion leaves of a relation, below which the relation is that of the code
INFORMATIVE = 30.0      # times the rounding that a smooth motion has to leave of a relation
LEAST_INTERVALS = 10
ONE_FORCE = "velocities of successive rows obey one force per step, as the Euler methods have it"
TWO_FORCES = "velocities of successive rows obey the mean of two forces, as Newmark's method has it"
INTERPOLATED = "velocities are interpolated between steps"


@dataclass(frozen=True)
class Jump:
    """A change of velocity between two rows that no acceleration of the rows explains."""

    row: int                # before it
    restitution: float      # velocity along the change after it over that before it, both in the kinetic metric
    uncertainty: float      # from when between the rows it happens
    size: float             # over the largest velocity, in the kinetic norm


def jumps(run: RunData, case: Case) -> list[Jump]:
    """The jumps of a file.

    An impact changes the velocity by Δv = M⁻¹Jᵀ P with impulses P ≥ 0. Newton's law of impact for every contact that has
    an impulse gives Δv·M v⁺ = -e Δv·M v⁻. So the velocities alone tell the restitution e, whichever contacts are hit.
    """
    if any(name not in run.data for name in VELOCITIES):
        return []
    v, a, dt = columns(run, VELOCITIES), np.nan_to_num(columns(run, ACCELERATIONS)), np.diff(run.time)[:, None]
    if not np.isfinite(v).all():
        return []
    mass = np.array([case.mass, case.mass, case.roll_inertia])
    largest = float(np.sqrt(np.max(v**2 @ mass)))
    size = np.sqrt((np.diff(v, axis=0) - dt*(a[1:] + a[:-1])/2)**2 @ mass)/max(largest, 1e-300)
    found = []
    for k in np.flatnonzero(size > LARGE):
        if max(size[max(k - 1, 0):k].max(initial=0), size[k + 1:k + 2].max(initial=0)) > LARGE/3:
            continue            # several impacts between neighbouring rows
        tried = []
        for share in (0.0, 0.5, 1.0):
            before, after = v[k] + share*dt[k]*a[k], v[k + 1] - (1 - share)*dt[k]*a[k + 1]
            way = (after - before)*mass
            tried.append(-float(way @ after)/float(way @ before) if way @ before < 0 else np.nan)
        if np.isfinite(tried).all():
            found.append(Jump(int(k), tried[1], float(np.ptp(tried)), float(size[k])))
    return found


def columns(run: RunData, names: tuple[str, ...]) -> np.ndarray:
    """Columns side by side, (rows, columns); one that the file lacks is zero."""
    return np.column_stack([run.values(name) if name in run.data else np.zeros(len(run)) for name in names])


def tells_impulses(run: RunData) -> bool:
    """Whether a file has the impulses of rigid impacts."""
    return any(name in run.data for name in IMPULSES)


def leaps(run: RunData, case: Case) -> bool:
    """Whether velocities jump between rows that are so near that no elastic impact fits between them, and no contact gives."""
    return typical_interval(run) <= SHORT and bool(jumps(run, case)) and not first_blow_gives(run, case)


@quiet()
def is_rigid(run: RunData, task: Task) -> bool:
    """Whether a file has rigid contacts: columns of their impulses, or velocities that jump from one row to the next."""
    return tells_impulses(run) or leaps(run, Case.exercise(task.exercise, task.profiles))


def jump_intervals(run: RunData, case: Case) -> np.ndarray:
    """The intervals, (rows - 1,), whose change of velocity is not nearly that of the accelerations; none without these columns."""
    if any(name not in run.data for name in (*VELOCITIES, *ACCELERATIONS)):
        return np.zeros(run.time.size - 1, bool)
    v, a = columns(run, VELOCITIES), columns(run, ACCELERATIONS)
    explained = np.diff(run.time)[:, None]*(a[1:] + a[:-1])/2
    mass = np.array([case.mass, case.mass, case.roll_inertia])
    return ~((np.diff(v, axis=0) - explained)**2 @ mass <= NEARLY**2*(explained**2 @ mass))


def typical_interval(run: RunData) -> float:
    """The interval between most rows [s]."""
    steps = np.diff(run.time)
    steps = steps[steps > 0]
    return float(np.median(steps)) if steps.size else np.nan


def step_of(run: RunData) -> Estimate:
    """The time step, where rows are steps, or where rows are interpolated between steps."""
    pairs = [(v, a) for v, a in zip(VELOCITIES, ACCELERATIONS, strict=True) if v in run.data and a in run.data]
    step = typical_interval(run)
    for words, points in (ONE_FORCE, 1), (TWO_FORCES, 2):
        if pairs and all_fit(run, pairs, step, points):
            return Estimate(step, 1e-3*step, "s", words)
    velocities = [run.values(name) for name in VELOCITIES if name in run.data]
    nothing = "rows are not single steps, nor interpolated between steps" if pairs else "no velocities with accelerations"
    found = find_lattice([bends(run.time, x, digit_noise(x)) for x in velocities if np.isfinite(x).all()], "s", nothing)
    return replace(found, why=INTERPOLATED) if found.known else found


def centred(run: RunData, step: Estimate) -> RunData:
    """The run with velocities of the times of its rows.

    The symplectic Euler method has velocities half a step before or after its displacements. They would let a contact
    without damping look damped.
    """
    if step.why != ONE_FORCE or "Y" not in run.data:
        return run
    rate = np.gradient(run.values("Y"), run.time)
    left = {shift: float(np.sum((rate - run.values("vY") - shift*step.value*run.values("aY"))**2)) for shift in (-0.5, 0.0, 0.5)}
    shift = min(left, key=lambda shift: left[shift])
    moved = {v: run.values(v) + shift*step.value*run.values(a) for v, a in zip(VELOCITIES, ACCELERATIONS, strict=True)
             if v in run.data and a in run.data}
    return run.with_data(run.data.assign(**moved))


def all_fit(run: RunData, pairs: list[tuple[str, str]], step: float, points: int) -> bool:
    """Whether velocities and accelerations obey a rule with one force or two, far better than a smooth motion does.

    A smooth motion leaves h/2 times the change of the acceleration of the rule with one force, and h/12 times its second
    difference of the rule with two. Only intervals count in which this is far above the rounding.
    """
    dt = np.diff(run.time)
    equal = np.abs(dt - step) < 1e-4*step
    fits = informative = 0
    for v_name, a_name in pairs:
        v, a = run.values(v_name), run.values(a_name)
        if not (np.isfinite(v).all() and np.isfinite(a).all()):
            return False
        change, first = np.diff(v), np.diff(a)
        second = np.concatenate([[0.0], np.minimum(np.abs(first[2:] - first[1:-1]), np.abs(first[1:-1] - first[:-2])), [0.0]])
        noise = 2*digit_noise(v) + step*digit_noise(a)
        expected = step/2*np.abs(first) if points == 1 else step/12*second
        left = [np.abs(change - step*force) for force in ((a[:-1], a[1:]) if points == 1 else ((a[1:] + a[:-1])/2,))]
        told = equal & (expected > INFORMATIVE*noise)
        informative += int(told.sum())
        fits += max(int(np.sum(told & (rest < RELATION*expected))) for rest in left)
    return informative >= LEAST_INTERVALS and fits > 0.9*informative
