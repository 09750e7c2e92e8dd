"""How far into a simulation a score means something, and how far formulations of our own differ until then.

Impacts multiply differences. The horizon of a simulation is the first time at which a difference of 1e-9 of the start has grown
to 1e-3 of the motion: then the motion depends on digits of the start that no code promises. It is measured on twins of an exact
run, whose start is aside in one coordinate each. Another integrator on the same forces tells whether our own has made it.
yardsticks.json keeps what `make yardsticks` has measured.
"""
from __future__ import annotations

import functools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ldbench import Case, ContactTable
from ldbench.runs import Run, compute

from .exact_runs import exact
from .tasks import Task

FILE = Path(__file__).with_name("yardsticks.json")
ASIDE = 1e-9            # of a start, as a share of the largest value of the coordinate in the case
GROWN = 1e-3            # largest difference of a displacement, as a share of its largest value, at the horizon
LONGEST = 4.0           # that twins run [s]
BEYOND = 1.2            # times the horizon, up to which runs of exercise 5 go
ROWS = 1e-4             # between rows of twins [s]
DISPLACEMENTS = "Y", "Z", "roll"
# The coordinates of the start and the variables of the namelist that set them.
STARTS = {"Y": "initial_Y", "Z": "initial_Z", "roll": "initial_roll", "vY": "vY", "vZ": "vZ", "roll_rate": "roll_rate"}


@dataclass(frozen=True)
class Yardstick:
    """What scores of a simulation are measured by."""

    horizon: float              # [s]; where a difference has not grown so far, the longest time that was tried
    reached: bool               # whether the difference grew to the limit in that time
    end: float | None           # of our own run [s]; None where it is behind the horizon
    growth: float               # how many times a difference of the start has grown at most until then and the horizon
    hertz: Mapping[str, float]      # relative difference of Hertz's law from half-spaces, by the name of the score
    rigid: Mapping[str, float]      # relative difference of rigid contacts from half-spaces
    independent: float | None = None    # horizon that another integrator sees [s]; None where the difference does not grow so far
    integrators: float = np.nan     # largest relative difference of both integrators from one start, up to the horizon
    earliest: float | None = None   # horizon that `integrators` allows another one to see [s]
    latest: float | None = None     # None where the difference does not grow so far


@functools.cache
def yardsticks() -> dict[str, Yardstick]:
    """The yardsticks of the ten simulations by their names."""
    return {name: Yardstick(**facts) for name, facts in json.loads(FILE.read_text(encoding="utf-8")).items()}


def horizon(task: Task) -> float:
    """The time [s] in a simulation beyond which nothing is scored."""
    return yardsticks()[task.name].horizon


def spreads(task: Task) -> dict[str, dict[str, float]]:
    """Relative differences of our own runs with Hertz's law ('hertz') and with rigid contacts ('rigid') from that with
    half-spaces, by the name of the score."""
    known = yardsticks()[task.name]
    return {"hertz": dict(known.hertz), "rigid": dict(known.rigid)}


def ending(case: Case, horizon: float) -> Case:
    """The case, which ends not far behind the horizon where it would go on for long."""
    return case.replace(t_end=BEYOND*horizon) if case.t_end > BEYOND*horizon else case


# Measurement ------------------------------------------------------------------------------

#: Y, Z and roll at times, (rows, 3) for each case, by an integrator on the forces of a table; fewer rows where a motion ends
#: before. The cases differ in their starts alone.
Integrator = Callable[[Sequence[Case], ContactTable, np.ndarray], Iterable[np.ndarray]]


def ours(cases: Sequence[Case], table: ContactTable, t: np.ndarray) -> Iterator[np.ndarray]:
    """The motions of cases by our integrator; the rows of the cases are at these times."""
    return (motion_of(compute(case, table=table))[:len(t)] for case in cases)


def motion_of(found: Run) -> np.ndarray:
    """The displacements of a run, (rows, 3)."""
    return np.column_stack([found.values(column) for column in DISPLACEMENTS])


@dataclass(frozen=True)
class Base:
    """The motion from which differences grow: a run with exact steps that nothing but its time ends."""

    run: Run
    sizes: Mapping[str, float]      # the largest values of the coordinates in the case as it stands

    def apart(self, motion: np.ndarray) -> np.ndarray:
        """How far another motion is away at each row: the largest of all displacements, as a share of their sizes, (rows,)."""
        own, sizes = motion_of(self.run), np.array([self.sizes[column] for column in DISPLACEMENTS])
        rows = min(len(own), len(motion))
        found = np.zeros(len(own))
        found[:rows] = np.max(np.abs(own[:rows] - motion[:rows])/sizes, axis=1)
        return found

    def twins(self) -> list[Case]:
        """The case with each coordinate of the start aside."""
        return [self.run.case.replace(**{variable: getattr(self.run.case, variable) + ASIDE*self.sizes[column]})
                for column, variable in STARTS.items()]


def base(case: Case, table: ContactTable | None = None, t_end: float = LONGEST) -> Base:
    """Run a case up to a time [s], whatever ends it else. Coordinates are measured by their largest values in the case as it
    stands, up to that time."""
    case = exact(case).replace(interval=ROWS, rows="interval", t_end=t_end)
    own = compute(case, table=table)
    sizes = {column: float(np.abs(own.values(column)).max()) for column in STARTS}
    case = case.replace(stop_at="t_end")
    return Base(compute(case, table=own.table.for_case(case)), sizes)


@dataclass(frozen=True)
class Growth:
    """How the difference of twins grows: the largest of all displacements and twins so far, in units of that of the start."""

    time: np.ndarray        # (rows,) [s]
    factor: np.ndarray      # (rows,)

    @property
    def horizon(self) -> float | None:
        """The first time at which the difference has grown to GROWN [s]; None where it has not."""
        return self.passes(GROWN)

    def passes(self, level: float) -> float | None:
        """The first time at which the difference has grown to a share of the motion [s]; None where it has not."""
        grown = np.flatnonzero(self.factor >= level/ASIDE)
        return float(self.time[grown[0]]) if grown.size else None

    def band(self, apart: float) -> tuple[float | None, float | None]:
        """The earliest and the latest horizon [s] of an integrator whose motion from one start is apart from ours by a share.

        The other's twin is apart from ours by as much again at most. So the other passes GROWN when ours passes a level that is
        lower or higher by twice this share, or a row before or behind.
        """
        low, high = self.passes(max(GROWN - 2*apart, 0.0)), self.passes(GROWN + 2*apart)
        return None if low is None else max(low - ROWS, 0.0), None if high is None else high + ROWS

    def until(self, t: float) -> float:
        """The growth up to a time [s] and to the horizon."""
        return float(min(self.factor[:np.searchsorted(self.time, t, "right")].max(), GROWN/ASIDE))


def growth(first: Base) -> Growth:
    """The growth of differences between a motion of ours and its six twins."""
    t = first.run.time
    return grown(first, t, ours(first.twins(), first.run.table, t))


def growth_seen(first: Base, integrator: Integrator, until: float) -> tuple[Growth, np.ndarray]:
    """What another integrator sees up to a time [s]: the growth of differences between our motion and its twins, and the
    difference between both motions from one start up to each row, (rows,)."""
    t = first.run.time[first.run.time <= until]
    own, *twins = integrator([first.run.case, *first.twins()], first.run.table, t)
    return grown(first, t, twins), np.maximum.accumulate(first.apart(own)[:len(t)])


def grown(first: Base, t: np.ndarray, twins: Iterable[np.ndarray]) -> Growth:
    """The growth up to each of the first rows, at times t, by the motions of the twins."""
    found = np.zeros(len(t))
    for motion in twins:
        found = np.maximum(found, first.apart(motion)[:len(t)])
    return Growth(t, np.maximum.accumulate(found)/ASIDE)
