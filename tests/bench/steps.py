"""What halving the step changes at the end of the runs, and the largest step that is small enough."""
from __future__ import annotations

import numpy as np

import ldbench
from ldbench import Case, ContactTable
from measure import Form, Section, measure
from sheets import Table

CASES = [(exercise, pair) for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
USUAL = [(1, "aw"), (2, "aw"), (3, "sw")]
SHORT = [(2, "aw")]
LEVELS = 8
STEP, ENERGY = 1e-4, 1e-2       # at level 0 [s], [J]; halved, divided by 32: the energy's error goes with dt^5
MEMBERS = "cut 4", "explicit 4", "energy 4", "energy 2"
BOUND = 1e-6                    # of the change of Y, Z [m] and roll [rad]
IN_HAND = 5

TEXT = """Change of Y, Z [m] and roll [rad], the largest of the three, at the last row of the shipped run when the
step is halved. Recommended: the largest step at which it and all smaller ones change the end by less than a fifth of
1e-6. cut 4: explicit, fourth order, the output interval as step, cut where it changes the energy by more than a
tolerance; 'half the step' is a 32th of the tolerance. Exercise 5 is not listed: after 1 s it is chaotic and no step
fixes its end."""


def settings(member: str, level: int) -> dict[str, object]:
    """The settings of the integrator."""
    name, order = member.split()
    if name == "cut":
        return {"scheme": "newmark", "beta": 0.0, "order": 4, "dt": STEP, "energy_tolerance": ENERGY/32**level}
    scheme, beta = ("newmark", 0.0) if name == "explicit" else (name, 0.25)
    return {"scheme": scheme, "beta": beta, "order": int(order), "dt": STEP/2**level, "energy_tolerance": 0.0}


def words(member: str, level: int) -> str:
    """A level as it is printed."""
    values = settings(member, level)
    return f"{values['energy_tolerance']:.1e} J" if member == "cut 4" else f"{1e6*values['dt']:.3g} µs"


def ends(case: Case, table: ContactTable, t_end: float, member: str, levels: int) -> np.ndarray:
    """Y, Z, roll at t_end per level; NaN where the run ended before."""
    poses = []
    for level in range(levels):
        run = ldbench.run(case.replace(t_end=t_end, stop_at="t_end", **settings(member, level)), table=table)
        last = run.data[["time", "Y", "Z", "roll"]].to_numpy()[-1]
        poses.append(last[1:] if abs(last[0] - t_end) < 1e-9 else np.full(3, np.nan))
    return np.array(poses)


def small_enough(changes: np.ndarray) -> int | None:
    """The first step from which on all changes are below the bound."""
    above = [k for k, x in enumerate(changes) if not x < BOUND/IN_HAND]
    k = above[-1] + 1 if above else 0
    return k if k < len(changes) else None


def section(form: Form) -> Section:
    short = form is Form.SHORT
    out = Section("Steps", TEXT)
    levels = 4 if short else LEVELS
    tables: dict[str, ContactTable] = {}
    rows = []
    for exercise, pair in SHORT if short else CASES if form is Form.FULL else USUAL:
        case = Case.exercise(exercise, pair)
        if pair not in tables:
            tables[pair] = ContactTable(case)
        table = tables[pair].for_case(case)
        t_end = float(ldbench.run(case, table=table).data["time"].iloc[-2])
        for member in MEMBERS:
            count = min(levels, 6) if member == "cut 4" else levels     # below 1e-9 J energies are rounded
            changes = np.abs(np.diff(ends(case, table, t_end, member, count), axis=0)).max(axis=1)
            for level, change in enumerate(changes):
                out.measures.append(measure(case.case_name, f"{member}, {words(member, level)}",
                                            "change by halving the step", "m", change))
            k = small_enough(changes)
            if k is not None and member == "cut 4":
                out.measures.append(measure(case.case_name, member, "recommended energy_tolerance", "J",
                                            settings(member, k)["energy_tolerance"],
                                            f"shipped {case.energy_tolerance:g} J", True))
            blank = [""]*(levels - 1 - len(changes))
            rows.append([case.case_name, member, *(f"{x:.1e}" for x in changes), *blank,
                         words(member, k) if k is not None else "–"])
    out.tables.append(Table("Change at the end by halving the step [m, rad]", [
        "case", "member", *(f"{1e6*STEP/2**level:.3g} µs, {ENERGY/32**level:.0e} J" for level in range(levels - 1)),
        "recommended"], rows))
    return out
