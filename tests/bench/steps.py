"""What halving the step changes at the end of the runs, and the largest step that is small enough."""
from __future__ import annotations

import numpy as np

import ldbench
from checks import Table
from ldbench import Case, ContactTable
from measure import Section, measure

CASES = [(exercise, pair) for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
SHORT = [(2, "aw")]
STEPS = 5e-5, 2.5e-5, 1.25e-5, 6.25e-6, 3.125e-6, 1.5625e-6, 7.8125e-7, 3.90625e-7    # halves of an output interval
MEMBERS = ("energy", 4), ("energy", 2)
BOUND = 1e-6                    # of the change of Y, Z [m] and roll [rad]
IN_HAND = 5

TEXT = """Change of Y, Z [m] and roll [rad], the largest of the three, at the last row of the shipped run when the
step is halved. Recommended: the largest step at which it and all smaller ones change the end by less than a fifth of
1e-6. Steps are halves of halves of the output interval. Exercise 5 is not listed: after 1 s it is chaotic and no step
fixes its end."""


def ends(case: Case, table: ContactTable, t_end: float, scheme: str, order: int,
         steps: tuple[float, ...]) -> np.ndarray:
    """Y, Z, roll at t_end per step; NaN where the run ended before."""
    poses = []
    for dt in steps:
        run = ldbench.run(case.replace(scheme=scheme, order=order, dt=dt, t_end=t_end, stop_at="t_end"), table=table)
        last = run.columns[["time", "Y", "Z", "roll"]].to_numpy()[-1]
        poses.append(last[1:] if abs(last[0] - t_end) < 1e-9 else np.full(3, np.nan))
    return np.array(poses)


def small_enough(changes: np.ndarray) -> int | None:
    """The first step from which on all changes are below the bound."""
    above = [k for k, x in enumerate(changes) if not x < BOUND/IN_HAND]
    k = above[-1] + 1 if above else 0
    return k if k < len(changes) else None


def section(short: bool) -> Section:
    out = Section("Steps", TEXT)
    steps = STEPS[:4] if short else STEPS
    tables: dict[str, ContactTable] = {}
    rows = []
    for exercise, pair in SHORT if short else CASES:
        case = Case.exercise(exercise, pair)
        table = tables.setdefault(pair, ContactTable(case)).for_case(case)
        t_end = float(ldbench.run(case, table=table).columns["time"].iloc[-2])
        for scheme, order in MEMBERS:
            changes = np.abs(np.diff(ends(case, table, t_end, scheme, order, steps), axis=0)).max(axis=1)
            for dt, change in zip(steps, changes, strict=False):
                out.measures.append(measure(case.case_name, f"{scheme} {order}, {dt:g}", "change by halving the step",
                                            "m", change))
            k = small_enough(changes)
            found = f"{1e6*steps[k]:g}" if k is not None else "–"
            if k is not None and scheme == case.scheme and order == case.order:
                out.measures.append(measure(case.case_name, f"{scheme} {order}", "recommended step", "s", steps[k],
                                            f"shipped {case.dt:g} s", True))
            rows.append([case.case_name, f"{scheme} {order}", *(f"{x:.1e}" for x in changes), found,
                         f"{1e6*case.dt:g}" if (scheme, order) == (case.scheme, case.order) else ""])
    out.tables.append(Table("Change at the end by halving the step [m, rad]", [
        "case", "member", *(f"{1e6*dt:.3g} µs" for dt in steps[:-1]), "recommended [µs]", "shipped [µs]"], rows))
    return out
