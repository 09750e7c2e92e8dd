"""The spread of formulations, by which scores are judged: half-spaces, Hertz's law and rigid contacts in runs of our own."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ldbench import Case, ContactTable
from ldbench.runs import Run, compute

from .exact_runs import exact
from .horizon import BEYOND, LONGEST, Integrator, Yardstick, base, ending, growth, growth_seen
from .metrics import scored
from .tasks import Task

OTHERS: dict[str, dict[str, Any]] = {
    "hertz": {"model": "hertz", "table_file": ""},
    "rigid": {"formulation": "unilateral", "restitution": 1.0}}
LEAST_SHARE = 0.5       # of the time with the same contacts closed, below which the motion tells no spread


def spread(task: Task, horizon: float, first: Run, tables: dict[str, ContactTable]) -> dict[str, dict[str, float]]:
    """The relative differences of the other formulations from `first`, by formulation and by the name of the score."""
    found: dict[str, dict[str, float]] = {}
    for name, changes in OTHERS.items():
        case = first.case.replace(**changes)
        other = compute(case, table=tables[name].for_case(case) if name in tables else None)
        tables[name] = other.table
        scores = scored(other, first, task, horizon)
        found[name] = {one.name: one.difference for one in scores.scores if np.isfinite(one.difference)
                       and (one.kind != "motion" or scores.share >= LEAST_SHARE)}
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
    return Yardstick(limit, grew.horizon is not None, end if whole else None, grew.until(end),
                     **spread(task, limit, first, tables), independent=seen, integrators=apart,
                     earliest=earliest, latest=latest)


def rounded(yardstick: Yardstick) -> Mapping[str, Any]:
    """The yardstick as yardsticks.json keeps it: three digits."""
    def three(x: Any) -> Any:
        return {name: three(value) for name, value in x.items()} if isinstance(x, Mapping) else \
            float(f"{x:.3g}") if isinstance(x, float) else x

    return {name: three(x) for name, x in vars(yardstick).items()}
