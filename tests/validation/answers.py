"""The answers in the results of a run against its rows.

Exercises 1 to 4, with rows at every step of 10 us. The core integrates the normal force of a contact over its steps. Here the
impulse of a contact comes from the balance of momentum: mass times the change of velocity between two rows, less weight and
the forces of the other contacts, along the mean normal of the contact. So the force of the contact itself is not used. The
first contact of every wheel's tread and flange is compared, and a flange until the wheelset moves back. The impulses of the left
flange with the shipped steps are compared with those of the fine rows; the table says what longer and shorter steps change. With
rigid contacts and restitution 1 the first impulse is the jump of the velocities times the mass.

Times of contacts, of passages of the centre, of the wheel that lifts for good and of the derailment, and the extremes of the
motion, are looked for in the rows. The return of a slow exercise 1, which passes the centre many times more than the list of
events has room for, is among them.
"""
from __future__ import annotations

import numpy as np
import pandas as pd

import ldbench
from checks import Check, Section, absolute, limit, relative
from derailment import past_crown
from integration import refined
from ldbench import Case, ContactTable, Run
from ldbench.constants import CONTACTS
from sheets import Table

PAIRS = "aw", "sw"
EXERCISES = 1, 2, 3, 4
OUTWARDS = {"LF": 1, "RF": -1}
STEP = 1e-5                     # of the fine runs, and between their rows [s]
FACTORS = 4.0, 2.0, 1.0, 0.5, 0.25  # of the shipped step
ASIDE = 1e-6                    # from the centre, before a passage counts, as in the core [m]
ROUNDING = 1e-12                # of times [s]
# Exercise 1 at so low a speed that flanges are touched only with a small lateral force, which turns from right to left. The
# wheelset passes the centre more often than a column file lists.
SLOW = {"contact_model": "hertz", "vY": 0.0272, "roll_link": "rails", "lateral_force": -8.0, "lateral_ramp": 0.5, "t_end": 40.0,
        "stop_at": "t_end", "name": "ex1_aw_slow"}


def fine_run(case: Case, table: ContactTable) -> Run:
    return ldbench.run(case.replace(dt=STEP, interval=STEP), table=table)


def impulse(run: Run, contact: str, rows: np.ndarray, share: float = 1.0) -> float:
    """Impulse of a contact from the first to the last of some rows, by the balance of momentum [N s]; of the time between the last
    two rows a share counts."""
    c, case = run.data.iloc[rows], run.case
    dt = np.diff(c.time)
    others = [name for name in CONTACTS if name != contact]
    push = []
    for axis, load in ("y", c.F_ext), ("z", -case.mass*9.81 - case.vertical_load):
        force = (load + c[[f"F{axis}_{name}" for name in others]].sum(axis=1)).to_numpy()
        push.append(case.mass*np.diff(c["v" + axis.upper()]) - (force[1:] + force[:-1])/2*dt)
    angle = c[f"angle_{contact}"].where(c[f"N_{contact}"] > 0).ffill().bfill().to_numpy()
    normal = np.array([-np.sin(angle)*(1 if contact[0] == "L" else -1), np.cos(angle)])
    along = (np.array(push)*(normal[:, 1:] + normal[:, :-1])/2).sum(axis=0)
    along[-1] *= share
    return float(along.sum())


def balance(run: Run, contact: str, begin: int, end: int, share: float = 1.0) -> tuple[float, float]:
    """Impulse of a contact between two rows [N s], and the largest relative error that it may have.

    Mean normals and trapezoids err by the square of the distance of rows, so every other row changes the impulse by three times the
    error; the even and the odd rows tell it, as one of them may be near by chance. A share of the last distance h errs by at most
    h/8 times the change of the force in it.
    """
    rows = np.arange(begin, end + 1)
    exact = impulse(run, contact, rows, share)
    change = sum(abs(impulse(run, contact, np.unique([begin, *rows[first::2], *rows[-2:]]), share) - exact) for first in (0, 1))
    if share < 1:
        last = run.data.iloc[end - 1:end + 1]
        change += float(np.ptp(last.time)*np.ptp(last[f"N_{contact}"]))/8
    return exact, change/exact


def first_rows(c: pd.DataFrame, contact: str) -> tuple[int, int]:
    """The rows before and after the first contact; for a contact that is closed at the start, the first row. The last row where it
    does not open."""
    closed = c[f"N_{contact}"].to_numpy() > 0
    begin = int(closed.argmax())
    end = begin + int(closed[begin:].argmin())
    return max(begin - 1, 0), end if end > begin else len(c) - 1


def turning(c: pd.DataFrame, contact: str) -> tuple[int, float]:
    """The row after the wheelset moves back from a flange, and the share of the time from the row before at which it does."""
    v = OUTWARDS[contact]*c.vY.to_numpy()
    k = first_rows(c, contact)[0] + 1
    k += int((v[k:] <= 0).argmax())
    return k, float(v[k - 1]/(v[k - 1] - v[k]))


def impulse_checks(run: Run) -> list[Check]:
    """Impulses and times of the first contacts."""
    c, s = run.data, run.results
    time = c.time.to_numpy()
    checks = []
    for contact in CONTACTS:
        if np.isnan(s[f"first_duration_{contact}"]):
            continue
        name = f"{run.name}, {contact}"
        begin, end = first_rows(c, contact)
        checks += [
            relative(f"{name}: first_impulse [N s]", s[f"first_impulse_{contact}"], *with_bar(balance(run, contact, begin, end))),
            absolute(f"{name}: t_first [s]", s[f"t_first_{contact}"], time[begin], "rows; bar the distance of rows",
                     time[begin + 1] - time[begin]),
            absolute(f"{name}: first_duration [s]", s[f"first_duration_{contact}"], time[end] - time[begin],
                     "rows; bar the distance of rows", time[begin + 1] - time[begin] + time[end] - time[end - 1])]
        if contact in OUTWARDS:
            checks.append(relative(f"{name}: turn_impulse [N s]", s[f"turn_impulse_{contact}"],
                                   *with_bar(balance(run, contact, begin, *turning(c, contact)))))
    return checks


def with_bar(found: tuple[float, float]) -> tuple[float, str, float]:
    """An impulse by the balance of momentum as a check's reference, source and bar."""
    return found[0], "balance of momentum; bar what every other row changes", found[1]


def crossings(c: pd.DataFrame) -> list[int]:
    """The rows before passages of the centre, each of which counts once the wheelset has been aside."""
    y = c.Y.to_numpy()
    aside = np.abs(y) > ASIDE
    found: list[int] = []
    before = 0
    for k in np.flatnonzero(y[1:]*y[:-1] <= 0).tolist():
        if aside[before:k + 1].any():
            found.append(k)
            before = k + 1
    return found


def passage_checks(run: Run) -> list[Check]:
    """First passage of the centre after a flange contact, and after turns on both sides, by straight lines between rows."""
    c, s = run.data, run.results
    t, y, v, a = (c[name].to_numpy() for name in ("time", "Y", "vY", "aY"))
    touched = min(t[c[f"N_{contact}"] > 0].min(initial=np.inf) for contact in OUTWARDS)
    turned = max(t[1:][(side*v[:-1] > 0) & (side*v[1:] <= 0) & (side*y[1:] > 0)].min() for side in OUTWARDS.values())
    checks = []
    for name, after in ("t_first_centre", touched), ("t_return", turned):
        k = next(k for k in crossings(c) if t[k] > after)
        checks.append(absolute(f"{run.name}: {name} [s]", s[name], t[k] - y[k]*(t[k + 1] - t[k])/(y[k + 1] - y[k]),
                               "straight lines between rows; bar the curvature between rows and in a step",
                               run.case.dt**2/4*np.abs(a[k:k + 2]/v[k:k + 2]).max() + ROUNDING))
    return checks


def extreme_checks(run: Run) -> list[Check]:
    """Extremes of Y, Z and roll, which lie beyond those of the rows by at most what a parabola between two rows has."""
    c, s = run.data, run.results
    longest = np.diff(c.time).max()
    checks = []
    for column, rate, largest, smallest in (("Y", "aY", "farthest_left", "farthest_right"),
                                            ("Z", "aZ", "farthest_up", "farthest_down"),
                                            ("roll", "roll_acc", "largest_roll", "smallest_roll")):
        bar = longest**2/8*c[rate].abs().max()
        unit = "rad" if column == "roll" else "m"
        checks += [absolute(f"{run.name}: {name} [{unit}]", s[name], way*(way*c[column]).max(),
                            "rows; bar a parabola between two rows", bar) for name, way in ((largest, 1), (smallest, -1))]
    return checks


def step_checks(fine: Run, shipped: Case, table: ContactTable) -> tuple[list[Check], list[str]]:
    """Impulses of the left flange with the shipped step against the fine rows, and what other steps change."""
    found = [ldbench.run(refined(shipped, factor), table=table).results for factor in FACTORS]
    begin, end = first_rows(fine.data, "LF")
    checks, row = [], [fine.name]
    for name, balanced in (("first_impulse_LF", balance(fine, "LF", begin, end)),
                           ("turn_impulse_LF", balance(fine, "LF", begin, *turning(fine.data, "LF")))):
        of_steps = [results[name] for results in found]
        checks.append(relative(f"{fine.name}: {name} with the shipped step [N s]", of_steps[FACTORS.index(1.0)],
                               *with_bar(balanced)))
        row += [f"{of_steps[-1]:.6f}", *(f"{x/of_steps[-1] - 1:.1e}" for x in of_steps[:-1])]
    return checks, row


def impact_checks(exercise: int, pair: str) -> list[Check]:
    """The first contact with rigid contacts and restitution 1, an impact of the flange alone: the rows before and after it."""
    run = ldbench.run(Case.exercise(exercise, pair).replace(formulation="unilateral", restitution=1.0))
    s = run.results
    rows = run.data[(run.data.time - s["t_first_LF"]).abs() < ROUNDING]
    blow = run.case.mass*float(np.hypot(*(rows[["vY", "vZ"]].iloc[-1] - rows[["vY", "vZ"]].iloc[0])))
    return [relative(f"{run.name}, rigid: first_impulse_LF [N s]", s["first_impulse_LF"], blow,
                     "jump of the velocities times the mass; bar rounding", 1e-9),
            limit(f"{run.name}, rigid: first_duration_LF [s]", s["first_duration_LF"], "an impact takes no time", 0.0)]


def ramp_checks(pair: str) -> list[Check]:
    """Exercise 5: derailment, and the lateral forces of the answers."""
    run = ldbench.run(Case.exercise(5, pair))
    c, s = run.data, run.results
    past = past_crown(run.case, c)[:, 0]
    k = int((past > 0).argmax())
    time = c.time.iloc[k - 1] + (c.time.iloc[k] - c.time.iloc[k - 1])*past[k - 1]/(past[k - 1] - past[k])
    carried = c.time[(c.N_RT + c.N_RF) > 0].iloc[-1]
    return [
        absolute(f"{run.name}: t_derailment [s]", s["t_derailment"], time, "the flange's tip in the rows; bar the distance of rows",
                 run.case.interval),
        absolute(f"{run.name}: t_unloaded [s]", s["t_unloaded"], carried, "last row in which the right wheel carries; bar the "
                 "distance of rows", run.case.interval),
        *(relative(f"{run.name}: F{name} [N]", s[f"F{name}"], run.case.lateral_ramp*s[f"t{name}"], "the ramp at this time", 1e-12)
          for name in ("_derailment", "_unloaded"))]


def slow_return() -> list[Check]:
    run = ldbench.run(Case.exercise(1, "aw").replace(SLOW))
    return [*passage_checks(run), limit("ex1_aw_slow: passages of the centre that the results miss [1]",
                                        run.results["n_centre_passage"] - len(crossings(run.data)), "rows", 0)]


def section(short: bool = False) -> Section:
    """short: exercise 2 with the actual profiles, by both integrators, without other steps."""
    checks: list[Check] = []
    rows = []
    for pair in PAIRS:
        table = ContactTable(Case.exercise(1, pair))
        for exercise in EXERCISES:
            case = Case.exercise(exercise, pair)
            run = fine_run(case, table)
            checks += impulse_checks(run) + passage_checks(run) + extreme_checks(run)
            if short:
                newmark = fine_run(case.replace(order=2, beta=0.25, energy_tolerance=0.0, error_tolerance=0.0), table)
                return Section("", "", checks + impulse_checks(newmark) + impact_checks(exercise, pair))
            more, row = step_checks(run, case, table)
            checks += more + impact_checks(exercise, pair)
            rows.append(row)
        checks += ramp_checks(pair)
    checks += slow_return()
    return Section("Answers of a run against its rows", __doc__, checks, [Table(
        f"Impulses of the left flange with {FACTORS[-1]:g} of the shipped step, and what other steps change [1]",
        ["case", "first contact [N s]", *(f"first, step x {x:g}" for x in FACTORS[:-1]), "until it moves back [N s]",
         *(f"back, step x {x:g}" for x in FACTORS[:-1])], rows)])
