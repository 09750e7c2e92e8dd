"""Rigid contacts: whether the shipped steps are fine enough, and exercise 5 to its end.

Exercises 1 to 3: the lateral displacement at the end, with the shipped steps and with steps of a quarter. Exercise 1 with
restitution 1 is left out, for it is chaotic: a change of the initial velocity by 1e-10 of itself moves the end beyond the bar.
Exercise 5: the energy that the wheelset has is the work of the lateral force, and times, forces and losses are the stored
ones, to what a change of the initial velocity by 1e-12 m/s makes of them.
"""
from __future__ import annotations

import ldbench
import reference
from checks import Check, Section, limit
from ldbench import Case
from sheets import Table

PAIRS = "aw", "sw"
EXERCISES = 1, 2, 3
CHAOTIC = (1, "unilateral, e = 1")      # hundreds of impacts in a row, each of which multiplies what differs
FINE = {"dt": 2.5e-5, "energy_tolerance": 1e-11}        # steps of a quarter
BAR = 1e-6                              # of Y at the end [m]

def end_of(exercise: int, pair: str, formulation: str) -> tuple[float, float]:
    """Y at the end with the shipped steps and with fine ones [m]."""
    case = Case.exercise(exercise, pair).replace(**reference.RIGID[formulation], rows="interval")
    shipped = ldbench.run(case).data.iloc[-1]
    fine = ldbench.run(case.replace(**FINE, t_end=shipped.time, stop_at="t_end")).data.iloc[-1]
    return float(shipped.Y), float(fine.Y)


def ends_of_exercise_5() -> list[Check]:
    """Energy at the end of exercise 5, and how many of the stored numbers have moved."""
    checks = []
    for pair in PAIRS:
        for name, bar in reference.DRIFTS.items():
            done = reference.rigid_run(f"ex5_{pair}", name, "end")
            checks += [
                limit(f"{pair}, {name}: energy drift of exercise 5 to its end [of the work]",
                      done.results["drift"]/done.data.W_ext.abs().max(), "work of the lateral force", bar),
                limit(f"{pair}, {name}: stored numbers of the end of exercise 5 that have moved",
                      len(reference.rigid_moves(f"ex5_{pair}", name, "end")), reference.RIGID_FILE.name, 0)]
    return checks


def section() -> Section:
    every = [(exercise, pair, name) for exercise in EXERCISES for pair in PAIRS for name in reference.RIGID
             if (exercise, name) != CHAOTIC]
    checks: list[Check] = []
    rows = []
    for exercise, pair, name in every:
        ours, fine = end_of(exercise, pair, name)
        checks.append(limit(f"ex{exercise}_{pair}, {name}: Y at the end, change by steps of a quarter [m]", ours - fine,
                            "steps of a quarter", BAR))
        rows.append([f"ex{exercise}_{pair}", name, f"{1e3*ours:.6f}", f"{1e9*(ours - fine):.3g}"])
    return Section("Rigid contacts: steps and exercise 5", __doc__, checks + ends_of_exercise_5(), [
        Table("Y at the end of the run", ["case", "formulation", "Y [mm]", "change by finer steps [nm]"], rows)])
