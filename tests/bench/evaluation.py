"""Cost of one evaluation of the contact forces, against what it replaces and against the floor."""
from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import ldbench
from ldbench import Case
from ldbench._core import flat
from measure import Section, measure, ratio

EXERCISES = 1, 2
LEAST = 0.2                     # of a round, which repeats an evaluation until it took so long [s]
PRESSED = 40                    # poses of half-spaces

TEXT = """One evaluation gives force, or tangent stiffness, of all four contacts at a pose. Poses: the rows of the run. force,
tangent: the core's look-up in the table, all poses in one call from Python; the explicit step needs the force alone. half-space:
force and energy of half-spaces on 24 x 48 elements per patch, to 1e-6, which the table replaces."""


def seconds_per_pose(work: Callable[[], int]) -> float:
    """Processor time; `work` says how many poses it did."""
    begin, count = time.process_time(), 0
    while time.process_time() - begin < LEAST:
        count += work()
    return (time.process_time() - begin)/count


def section() -> Section:
    out = Section("Cost of an evaluation", TEXT)
    table = None
    for exercise in EXERCISES:
        case = Case.exercise(exercise, "aw")
        run = ldbench.run(case, table=table)
        table, handle = run.table, run.table._handle
        q = run.data[["Y", "Z", "roll"]].to_numpy() + [0, run.table.equilibrium, 0]
        arrays, few = [np.ascontiguousarray(x) for x in q.T], q[np.linspace(0, len(q) - 1, PRESSED).astype(int)]
        kinds: dict[str, Callable[[], int]] = {
            "force": lambda arrays=arrays, handle=handle: len(flat.contact_values(handle, 0, 3, *arrays)[1]),
            "tangent": lambda arrays=arrays, handle=handle: len(flat.contact_values(handle, 0, 6, *arrays)[1]),
            "half-space": lambda few=few, handle=handle: len([
                flat.pressures(handle, side, pose, 12, 48) for pose in few for side in (1, 2)])//2}
        times = np.array([[seconds_per_pose(work) for work in kinds.values()] for _ in range(3)]).T
        for kind, seconds in zip(kinds, times, strict=True):
            out.measures += [measure(case.case_name, kind, "time of an evaluation", "s", seconds),
                             ratio(case.case_name, kind, "time over the force's", seconds, times[0])]
    return out
