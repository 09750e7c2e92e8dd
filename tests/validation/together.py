"""The first contact of the flange: forces of the table against the whole wheel pressed directly, along the motion; and what the
model of influence changes."""
from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import ldbench
from checks import Check, limit, relative
from programs import fortran_test
from sheets import Table

SHIPPED = "aw", "sw"
EXERCISES = 1, 2, 3, 4
POSES = 40                  # of the first flange contact
INFLUENCES = "local", "flat", "apart"
# Force and impulse may err by the largest error that the tables state.
BAR = 1e-2


def first_contact(exercise: int, pair: str, influence: str = "local") -> tuple[ldbench.Case, ldbench.Run, slice]:
    """The run of an exercise with steps of 10 us, and its rows during the first contact of the left flange."""
    case = ldbench.Case.exercise(exercise, pair).replace(dt=1e-5, interval=1e-5, influence=influence, table_file="")
    run = ldbench.run(case)
    flange = run.data.N_LF.to_numpy() > 0
    begin = int(np.argmax(flange))
    return case, run, slice(begin, begin + int(np.argmin(flange[begin:])))


def impulse(t: np.ndarray, force: np.ndarray) -> float:
    return float(((force[1:] + force[:-1])*np.diff(t)).sum()/2)


def pressed(case: ldbench.Case, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal forces of the left flange from the table, and directly, in some poses [N]."""
    with tempfile.TemporaryDirectory() as folder:
        case.to_namelist(Path(folder)/"case.nml")
        lines = "".join(" ".join(map(repr, pose)) + "\n" for pose in poses.tolist())
        found = fortran_test("halfspace_direct", Path(folder)/"case.nml", stdin=lines).splitlines()
    forces = np.array([line.split() for line in found], float).reshape(-1, 2, 2, 3)[:, 1]
    tabulated, direct = np.linalg.norm(forces[:, :, :2], axis=2).T
    return tabulated, direct


def one_system(short: bool) -> tuple[list[Check], Table]:
    checks: list[Check] = []
    rows = []
    for pair in SHIPPED[:1] if short else SHIPPED:
        for exercise in EXERCISES[:1] if short else EXERCISES:
            case, run, rows_of = first_contact(exercise, pair)
            t = run.data.time.to_numpy()[rows_of]
            poses = (run.data[["Y", "Z", "roll"]].to_numpy() + [0, run.results["axle_height"], 0])[rows_of]
            some = np.unique(np.linspace(0, len(t) - 1, POSES//4 if short else POSES).astype(int))
            tabulated, direct = pressed(case, poses[some])
            name = f"ex{exercise}_{pair}"
            checks.append(limit(f"{name}: flange's force along its first contact, off by at most [of its peak]",
                                np.abs(tabulated - direct).max()/direct.max(), "whole wheel pressed directly", BAR))
            checks.append(relative(f"{name}: impulse of the first contact of the flange [N s]", impulse(t[some], tabulated),
                                   impulse(t[some], direct), "whole wheel pressed directly", BAR))
            peaks = [1e-3*direct.max()]
            for influence in INFLUENCES[:1] if short else INFLUENCES:
                if influence != "local":
                    _, run, rows_of = first_contact(exercise, pair, influence)
                peaks.append(1e-3*float(run.data.N_LF.to_numpy()[rows_of].max()))
            rows.append([name, *(f"{peak:.1f}" for peak in peaks), *[""]*(len(INFLUENCES) - len(peaks) + 1)])
    return checks, Table(
        "First peak of the left flange [kN]: pressed directly at rows of the run, and of runs by the model of influence",
        ["case", "directly", *INFLUENCES], rows)
