"""Measure the horizons and spreads of the ten simulations, by which scores are judged: wrappers/ldbench_round/yardsticks.json.

    python docs/yardsticks.py [SIMULATION ...]      as ex2_aw; all ten without a name, in some minutes

The horizon is measured on twins of an exact run, whose start is aside in one coordinate each, and twice: by twins of our
integrator, and by twins of SciPy's DOP853 on the same forces. The spread is that of half-spaces, Hertz's law, wheel and rail as
elastic bodies and rigid contacts in runs of our own.
"""
from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from independent import displacements
from ldbench import Case, ContactTable, bodies
from ldbench.runs import Run, compute
from ldbench.tools import complete
from ldbench_round.metrics import scored
from ldbench_round.own_runs import BEYOND, DISPLACEMENTS, FILE, Yardstick, ending, exact
from ldbench_round.scores import OVER_TIME
from ldbench_round.tasks import TASKS, Task, task_named

ASIDE = 1e-9            # of a start, as a share of the largest value of the coordinate in the case
GROWN = 1e-3            # largest difference of a displacement, as a share of its largest value, at the horizon
LONGEST = 4.0           # that twins run [s]
ROWS = 1e-4             # between rows of twins [s]
# The coordinates of the start and the variables of the namelist that set them.
STARTS = {"Y": "initial_Y", "Z": "initial_Z", "roll": "initial_roll", "vY": "vY", "vZ": "vZ", "roll_rate": "roll_rate"}
OTHERS: dict[str, dict[str, Any]] = {
    "hertz": {"model": "hertz", "table_folder": ""},
    "bodies": {"influence": "bodies"},
    "rigid": {"formulation": "unilateral", "restitution": 1.0}}
LEAST_SHARE = 0.5       # of the time with the same contacts closed, below which the motion tells no spread

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


def spread(task: Task, horizon: float, first: Run, tables: dict[str, ContactTable], folder: str) -> dict[str, dict[str, float]]:
    """The relative differences of the other laws and formulations from `first`, by formulation and by the name of the score.
    folder: for bodies of a case that keeps no tables."""
    found: dict[str, dict[str, float]] = {}
    for name, changes in OTHERS.items():
        made = {"bodies": bodies.kept(first.case, "infinite", Path(folder))} if name == "bodies" else {}
        case = first.case.replace(changes | made)
        other = compute(case, table=tables[name].for_case(case) if name in tables else None)
        tables[name] = other.table
        scores = scored(other, first, task, horizon)
        # No other run has an impact of the same name that the reference lacks.
        found[name] = {one.name: one.difference for one in scores.scores if np.isfinite(one.difference)
                       and "file alone" not in one.name and (one.kind not in OVER_TIME or scores.share >= LEAST_SHARE)}
    return found


def measured_yardstick(task: Task, tables: dict[str, ContactTable] | None = None, longest: float = LONGEST,
                       another: Integrator | None = None) -> Yardstick:
    """Measure the yardstick of a simulation. tables: by formulation; they serve the simulations with these profiles. longest: time
    up to which differences may grow [s]. another: an integrator; without it the yardstick does not tell what that one sees."""
    tables = {} if tables is None else tables
    case = Case.exercise(task.exercise, task.profiles)
    begun = base(case, tables.get("elastic"), longest)
    grew = growth(begun)
    limit = grew.horizon or float(grew.time[-1])
    seen, apart = None, np.nan
    earliest, latest = None, None
    if another is not None:
        other, differences = growth_seen(begun, another, BEYOND*limit)
        seen, apart = other.horizon, float(differences[other.time <= limit][-1])
        earliest, latest = grew.band(apart)
    case = ending(exact(case), limit)
    first = compute(case, table=begun.run.table.for_case(case))
    tables["elastic"] = first.table
    end = float(first.time[-1])
    whole = end < case.t_end - case.interval
    with tempfile.TemporaryDirectory() as folder:
        spreads = spread(task, limit, first, tables, folder)
    return Yardstick(limit, grew.horizon is not None, end if whole else None, grew.until(end), **spreads,
                     independent=seen, integrators=apart, earliest=earliest, latest=latest)


def rounded(yardstick: Yardstick) -> Mapping[str, Any]:
    """The yardstick as yardsticks.json keeps it: three digits."""
    def three(x: Any) -> Any:
        return {name: three(value) for name, value in x.items()} if isinstance(x, Mapping) else \
            float(f"{x:.3g}") if isinstance(x, float) else x

    return {name: three(x) for name, x in vars(yardstick).items()}


def main(names: list[str]) -> int:
    known: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {}
    tables: dict[str, dict[str, ContactTable]] = {"aw": {}, "sw": {}}
    for task in [task_named(name) for name in names] or TASKS:
        facts = rounded(measured_yardstick(task, tables[task.profiles], another=displacements))
        known[task.name] = facts
        least = "" if facts["reached"] else " at least"
        end = "later" if facts["end"] is None else f"at {facts['end']:g} s"
        seen = "later" if facts["independent"] is None else f"{facts['independent']:g} s"
        print(f"{task.name}: horizon {facts['horizon']:g} s{least}, by DOP853 {seen}, both from one start apart by "
              f"{facts['integrators']:.1e}, run ends {end}, growth until then {facts['growth']:g}, "
              f"spreads of {len(facts['hertz'])}, {len(facts['bodies'])} and {len(facts['rigid'])} numbers", flush=True)
    with complete(FILE) as scratch:
        scratch.write_text(json.dumps({task.name: known[task.name] for task in TASKS if task.name in known}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
