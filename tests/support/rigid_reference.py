"""Stored motions of the rigid formulations: every exercise, both pairs, bilateral and unilateral.

`make reference` runs all, says what moved, and replaces outputs/reference/formulations*.csv.

formulations.csv: instants of Y, Z, roll, vY and the left flange's impulse. A number may move by 1e-9 of its unit and
ten times what a change of the initial lateral velocity by 1e-10 of itself (exercise 5: by 1e-12 m/s) makes of it, to
either side; beyond 1e-4 it says nothing and is not compared. Of exercise 5 these are of its first second.

formulations_ex5.csv: how exercise 5 goes on and ends. With restitution below 1 the wheelset comes to rest on the flange
long before, and the end does not depend on how; with restitution 1 it rattles on, and the end may move by some kN, as
ten times the change says; bilateral, it never ends: when a rail begins to pull, and the least Y of the last second.
"""
from __future__ import annotations

import functools
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd

from ldbench import Case, Run, run
from ldbench._core.files import complete
from ldbench.report import formulations
from running import CASES, PAIRS, REPO

FILE = REPO / "outputs/reference/formulations.csv"
ENDS = REPO / "outputs/reference/formulations_ex5.csv"
COLUMNS = "Y", "Z", "roll", "vY", "P_LF"
INSTANTS = 12
RESOLUTION, AMPLIFICATION, LIMIT = 1e-9, 10.0, 1e-4
RIGID = {name: changes for name, changes in formulations.FORMULATIONS.items() if changes}
# Largest energy drift of exercise 5 up to its end, of the work.
DRIFTS = {"bilateral": 1e-10, "unilateral, e = 1": 1e-12, "unilateral, e = 0.5": 1e-9, "unilateral, e = 0": 1e-9}


def case_of(name: str, formulation: str) -> Case:
    case = Case.exercise(int(name[2]), name[-2:]).replace(**RIGID[formulation], rows="interval")
    return case.replace(t_end=1.0, interval=1e-3) if name.startswith("ex5") else case


def motion(case: Case) -> pd.DataFrame:
    return run(case).data[["time", *COLUMNS]]


def rows_of(columns: pd.DataFrame) -> pd.DataFrame:
    return columns.iloc[np.linspace(0, len(columns) - 1, INSTANTS + 1).astype(int)[1:]]


def reference(name: str, formulation: str) -> pd.DataFrame:
    """Instants of a motion, and how far each number may move; inf: not compared."""
    case = case_of(name, formulation)
    kept = rows_of(motion(case)).reset_index(drop=True)
    changes = (1e-12, -1e-12) if name.startswith("ex5") else (1e-10*case.vY, -1e-10*case.vY)
    moved = np.zeros((len(kept), len(COLUMNS)))
    for change in changes:
        other = motion(case.replace(vY=case.vY + change, t_end=case.t_end, stop_at=case.stop_at))
        at = np.searchsorted(other.time, kept.time - 1e-9)
        missing = at >= len(other)
        there = other[list(COLUMNS)].to_numpy()[np.minimum(at, len(other) - 1)]
        moved = np.maximum(moved, np.where(missing[:, None], np.inf, np.abs(there - kept[list(COLUMNS)].to_numpy())))
    moved = np.maximum.accumulate(moved)
    scale = np.maximum(np.abs(kept[list(COLUMNS)].to_numpy()).max(axis=0), 1e-3)
    tolerance = np.where(AMPLIFICATION*moved < LIMIT*scale, RESOLUTION*np.maximum(scale, 1) + AMPLIFICATION*moved, np.inf)
    kept.insert(0, "formulation", formulation)
    kept.insert(0, "case", name)
    return kept.assign(**{f"may move {c}": tolerance[:, k] for k, c in enumerate(COLUMNS)})


def moves(stored: pd.DataFrame, name: str, formulation: str, columns: pd.DataFrame | None = None) -> list[str]:
    """What is out of tolerance, in words, in the columns of a run that is made here unless it is given."""
    own = stored[(stored.case == name) & (stored.formulation == formulation)]
    columns = motion(case_of(name, formulation)) if columns is None else columns
    found = []
    for _, row in own.iterrows():
        k = int(np.searchsorted(columns.time, row.time - 1e-9))
        for c in COLUMNS:
            if not np.isfinite(row[f"may move {c}"]):
                continue
            if k >= len(columns) or abs(columns[c].iloc[k] - row[c]) > row[f"may move {c}"]:
                now = "the run's end" if k >= len(columns) else f"{columns[c].iloc[k]:.10g}"
                found.append(f"{name}, {formulation}: {c} at t = {row.time:g} s: expected {row[c]:.10g} within "
                             f"{row[f'may move {c}']:.1g}, found {now}")
    return found


@functools.cache
def ramp(pair: str, formulation: str, start: float = 0.0) -> Run:
    """Exercise 5 to its end, begun with a lateral velocity [m/s]."""
    return run(Case.exercise(5, pair).replace(**RIGID[formulation], interval=5e-3, rows="interval", vY=start))


def end_of(done: Run) -> dict[str, float]:
    """First events and the last one, with the lateral force then; what impacts have cost [s, N, J, m]."""
    found: dict[str, float] = {}
    for event in done.events:
        if event.kind in ("left flange contact", "right wheel lift-off", "rail pulls", "derailment"):
            found.setdefault(f"{event.kind} at", event.t)
            found.setdefault(f"{event.kind}: lateral force", event.force)
    if done.case.restitution < 1:
        found["energy lost"] = float(done.data.E_lost.iloc[-1])
    if done.case.formulation == "bilateral":
        c = done.data
        found["least Y of the last second"] = float(c.Y[c.time > c.time.iloc[-1] - 1].min())
    return found


def end_reference(pair: str, formulation: str) -> pd.DataFrame:
    own = end_of(ramp(pair, formulation))
    others = [end_of(ramp(pair, formulation, start)) for start in (1e-12, -1e-12)]
    return pd.DataFrame([{"pair": pair, "formulation": formulation, "quantity": name, "value": x, "may move":
                          RESOLUTION*max(1, abs(x)) + AMPLIFICATION*max(abs(other[name] - x) for other in others)}
                         for name, x in own.items()])


def end_moves(stored: pd.DataFrame, pair: str, formulation: str) -> list[str]:
    """What is out of tolerance at the end of exercise 5, in words."""
    own = stored[(stored.pair == pair) & (stored.formulation == formulation)]
    now = end_of(ramp(pair, formulation))
    missing = [f"ex5_{pair}, {formulation}: {name} is new or gone" for name in set(own.quantity) ^ set(now)]
    return missing + [f"ex5_{pair}, {formulation}: {row.quantity}: expected {row.value:.12g} within {row['may move']:.1g}, "
                      f"found {now[row.quantity]:.12g}" for _, row in own.iterrows()
                      if row.quantity in now and not abs(now[row.quantity] - row.value) <= row["may move"]]


def main() -> None:
    work = ((FILE, moves, reference, [(name, formulation) for name in CASES for formulation in RIGID], 10),
            (ENDS, end_moves, end_reference, [(pair, formulation) for pair in PAIRS for formulation in RIGID], 12))
    with ThreadPoolExecutor(2) as pool:
        for file, compared, made, cases, digits in work:
            if file.is_file():
                for lines in pool.map(functools.partial(compared, pd.read_csv(file)), *zip(*cases, strict=True)):
                    print(*lines, sep="\n", end="\n" if lines else "")
            rows = pd.concat(pool.map(made, *zip(*cases, strict=True)))
            with complete(file) as scratch:
                rows.to_csv(scratch, index=False, float_format=f"%.{digits}g")


if __name__ == "__main__":
    main()
