"""Cost of one evaluation of the contact forces, against what it replaces and against the floor."""
from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import ldbench
from ldbench import Case, Run
from ldbench._core import flat
from measure import Section, measure, ratio
from problem import absolute
from programs import fortran_test

EXERCISES = 1, 2
CALLS = 20_000                  # from Python, per round
LOOPED = 100_000                # in compiled loops, per round
NAMES = "table", "force alone", "direct", "half-space"

TEXT = """One evaluation gives energy, force and tangent stiffness of all four contacts at a pose. Poses: the rows of
the run. table: the core's look-up in a Fortran loop; force alone: without the tangent, as the explicit step needs it;
direct: force and energy (no tangent) of strips; half-space: force and energy of half-spaces on 24 x 48 elements per
patch, to 1e-6."""


def seconds_per_call(call: Callable[[float, float, float], object], poses: np.ndarray) -> float:
    count = -(-CALLS//len(poses))
    rows = poses.tolist()
    begin = time.process_time()
    for _ in range(count):
        for row in rows:
            call(*row)
    return (time.process_time() - begin)/(count*len(rows))


def write_poses(path: Path, poses: np.ndarray) -> None:
    with path.open("wb") as file:
        np.array([len(poses)], np.int64).tofile(file)
        np.ascontiguousarray(poses.T).tofile(file)


def poses_of(run: Run) -> np.ndarray:
    """y, z above the rails, roll of the run's rows."""
    poses = run.data[["Y", "Z", "roll"]].to_numpy().copy()
    poses[:, 1] += run.table.equilibrium
    return poses


def fortran_times(case: Case, poses: np.ndarray, rounds: int) -> tuple[dict[str, np.ndarray], float]:
    """Per kind of evaluation and round [s]; the mean number of touching zones."""
    with tempfile.TemporaryDirectory() as folder:
        namelist, file = Path(folder)/"case.nml", Path(folder)/"poses"
        absolute(case).to_namelist(namelist)
        write_poses(file, poses)
        repeats, stride = max(1, LOOPED//len(poses)), max(1, len(poses)//10)
        lines = fortran_test("bench_force", namelist, file, rounds, repeats, stride).splitlines()
    times = np.array([line.split() for line in lines[:-1]], float).T
    return dict(zip(NAMES, times, strict=True)), float(lines[-1].split()[0])


def section(full: bool) -> Section:
    out = Section("Cost of an evaluation", TEXT)
    rounds = 7 if full else 3
    table = None
    for exercise in EXERCISES:
        case = Case.exercise(exercise, "aw")
        run = ldbench.run(case, table=table)
        table, poses = run.table, poses_of(run)
        times, zones = fortran_times(case, poses, rounds)
        handle = run.table._handle
        arrays = [np.ascontiguousarray(x) for x in poses.T]

        def loop(m: int) -> float:
            count = max(1, LOOPED//len(poses))
            begin = time.process_time()
            for _ in range(count):
                flat.contact_values(handle, 0, m, *arrays)
            return (time.process_time() - begin)/(count*len(poses))

        kinds = {"force, array from Python": lambda: loop(3),
                 "tangent, array from Python": lambda: loop(6),
                 "force, one by one from Python": lambda: seconds_per_call(
                     lambda y, z, phi: flat.contact_values(handle, 0, 3, y, z, phi), poses)}
        samples = [[kind() for kind in kinds.values()] for _ in range(rounds)]
        times |= dict(zip(kinds, np.array(samples).T, strict=True))
        name = case.case_name
        out.measures.append(measure(name, "touching zones, both wheels", "mean number", "1", zones))
        for kind, seconds in times.items():
            out.measures.append(measure(name, kind, "time of an evaluation", "s", seconds))
            out.measures.append(ratio(name, kind, "time over the look-up's", seconds, times["table"]))
    return out
