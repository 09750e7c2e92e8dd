"""Stored motions of the rigid formulations: every exercise, both pairs, bilateral and unilateral.

    python tests/rigid_reference.py            run all and say what moved; exit status 1 if out of tolerance
    python tests/rigid_reference.py --store    the same, then replace outputs/reference/formulations.csv

Instants of Y, Z, roll, vY and the left flange's impulse. A number may move by 1e-9 of its unit and ten times what a
change of the initial lateral velocity by 1e-10 of itself (exercise 5: by 1e-12 m/s) makes of it, to either side; beyond
1e-4 it says nothing and is not compared. Exercise 5 is run for its first second.
"""
from __future__ import annotations

import argparse
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
from ldbench import Case, formulations, run

from conftest import CASES, REPO

FILE = REPO / "outputs/reference/formulations.csv"
COLUMNS = "Y", "Z", "roll", "vY", "P_LF"
INSTANTS = 12
RESOLUTION, AMPLIFICATION, LIMIT = 1e-9, 10.0, 1e-4
RIGID = {name: changes for name, changes in formulations.FORMULATIONS.items() if changes}


def case_of(name: str, formulation: str) -> Case:
    case = Case.exercise(int(name[2]), name[-2:]).replace(**RIGID[formulation])
    return case.replace(t_end=1.0, interval=1e-3) if name.startswith("ex5") else case


def motion(case: Case) -> pd.DataFrame:
    return run(case).columns[["time", *COLUMNS]]


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


def moves(stored: pd.DataFrame, name: str, formulation: str) -> list[str]:
    """What is out of tolerance, in words."""
    own = stored[(stored.case == name) & (stored.formulation == formulation)]
    columns = motion(case_of(name, formulation))
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


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--store", action="store_true", help="replace the references")
    args = parser.parse_args()
    todo = [(name, formulation) for name in CASES for formulation in RIGID]
    found: list[str] = []
    with ThreadPoolExecutor(2) as pool:
        if FILE.is_file():
            stored = pd.read_csv(FILE)
            found = [line for lines in pool.map(lambda x: moves(stored, *x), todo) for line in lines]
        if args.store:
            new = pd.concat(pool.map(lambda x: reference(*x), todo))
            new.to_csv(FILE, index=False, float_format="%.10g")
    print("\n".join(found) or "nothing has moved")
    return int(bool(found) and not args.store)


if __name__ == "__main__":
    sys.exit(main())
