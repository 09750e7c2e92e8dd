"""The numbers of a run for the matrix of a round, found in the same way for every code, from the rows of its file."""
from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ldbench import Case
from ldbench.geometry.derailment import derailment
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.quantities import KN, OUTCOME, Quantity
from ldbench.results.run_data import RunData

from .findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding
from .metrics import passages
from .row_checks import has
from .tasks import Task

#: The numbers in words, and how they are shown.
NUMBERS = {
    "t_left_flange": Quantity("first contact of the left flange", "ms", 1e3, digits=3, short="left flange"),
    "t_right_flange": Quantity("first contact of the right flange", "ms", 1e3, digits=3, short="right flange"),
    "peak": Quantity("largest force of the first left flange impact", "kN", KN, digits=1, short="peak"),
    "impulse": Quantity("impulse of the first left flange impact", "kN·s", KN, digits=4, short="impulse"),
    "duration": Quantity("duration of the first left flange impact", "ms", 1e3, digits=3, short="duration"),
    "rebound": Quantity("lateral velocity after over before that impact, reversed", "", 1, digits=4, short="rebound"),
    "t_return": Quantity("return to the centre after both flanges", "ms", 1e3, digits=3, short="return"),
    "F_derailment": OUTCOME["F_derailment"]._replace(short="derailment"),
    "energy_error": Quantity("error of the energy balance, at rest on the treads", "%", 100, digits=-1, short="energy error"),
    "processor_time": Quantity("processor time", "s", 1, digits=2, short="processor time"),
}
#: SI units of the numbers, as the CSV has them.
SI = {"t_left_flange": "s", "t_right_flange": "s", "peak": "N", "impulse": "N.s", "duration": "s", "rebound": "1", "t_return": "s",
      "F_derailment": "N", "energy_error": "1", "processor_time": "s"}
VERDICTS = {PASSED: "passed", DOUBTFUL: "doubtful", FAILED: "failed", UNKNOWN: "not_checked"}

SUDDEN = 0.2            # least relative change of the lateral velocity from row to row that is an impact without duration
BEYOND = 1e15           # what no number of a wheelset reaches, in any of the units
CLOSE_ROWS = 0.5e-3     # rows that are farther apart do not tell such an impact from one with a duration [s]
NO_TIME, NO_DISPLACEMENT = "the impact takes no time", "no lateral displacement in the file"


class Number(NamedTuple):
    """A number of a run in SI units, or why there is none."""

    value: float
    reason: str = ""                # where the value is NaN


def main_number(task: Task) -> str:
    """The number of a simulation that stands for it."""
    return "F_derailment" if task.exercise == 5 else "peak"


def names_of(task: Task) -> list[str]:
    """The numbers that a simulation has."""
    left_out = {"t_right_flange", "t_return"} if task.exercise == 5 else {"F_derailment"}
    return [name for name in NUMBERS if name not in left_out]


def numbers_of(run: RunData, task: Task, findings: Iterable[Finding], seconds: float = np.nan) -> dict[str, Number]:
    """All numbers of a run whose columns are ours, in SI units.

    findings: of the check, for the error of the energy balance. seconds: processor time that the submission tells.
    """
    found = impact_numbers(run)
    if task.exercise == 5:
        event = derailment(run, Case.exercise(5, task.profiles)) if has(run, "Y") else None
        found["F_derailment"] = Number(event.force if event else np.nan, "the file ends before the derailment" if has(run, "Y")
                                       else NO_DISPLACEMENT)
    else:
        right = first_impact(run, "R")
        found["t_right_flange"] = Number(np.nan, right) if isinstance(right, str) else Number(right.start)
        found["t_return"] = return_time(run, found["t_right_flange"].value)
    found["energy_error"] = next((Number(one.number, one.hint) for one in findings if one.what == "energy closes"),
                                 Number(np.nan, "not checked"))
    found["processor_time"] = Number(seconds, "the submission does not tell it")
    return {name: finite(found[name]) for name in names_of(task)}


def finite(number: Number) -> Number:
    """A number that can be, or the reason why it is none."""
    if np.isfinite(number.value) and abs(number.value) <= BEYOND:
        return Number(float(number.value))
    return Number(np.nan, number.reason or "the rows give no number that can be")


def impact_numbers(run: RunData) -> dict[str, Number]:
    """The numbers of the first impact of the left flange, or why there are none."""
    left = first_impact(run, "L")
    if isinstance(left, str):
        return dict.fromkeys(("t_left_flange", "peak", "impulse", "duration", "rebound"), Number(np.nan, left))
    rebound = Number(np.nan, "no lateral velocity in the file")
    if has(run, "vY"):
        v = run.values("vY")
        before, after = np.interp([left.start, left.end], run.time, v) if left.duration > 0 else v[left.top - 1:left.top + 1]
        rebound = Number(-after/before) if abs(before) > 0 else Number(np.nan, "no lateral velocity before the impact")
    return {"t_left_flange": Number(left.start), "peak": Number(left.peak, NO_TIME),
            "impulse": Number(left.impulse, f"{NO_TIME}, and the file does not tell its impulse"),
            "duration": Number(left.duration), "rebound": rebound}


def first_impact(run: RunData, side: str) -> ContactInterval | str:
    """The first impact of a flange, 'L' or 'R'; words that say why there is none.

    It is the first closed interval of the contact, not of its root, or, where the lateral velocity turns from one row to
    the next without a force that explains it, an impact without duration, as codes with constraints have it.
    """
    flange = "left flange" if side == "L" else "right flange"
    if not has(run, f"N_{side}F"):
        return f"no normal force of the {flange} in the file"
    lasting, sudden = run.first_interval(f"{side}F"), sudden_impact(run, side)
    lasting = lasting if lasting and lasting.is_impact else None
    if sudden and not (lasting and lasting.start + CLOSE_ROWS < sudden.start):
        return sudden
    return lasting or f"no impact of the {flange} begins and ends in the rows"


def sudden_impact(run: RunData, side: str) -> ContactInterval | None:
    """The first impact of a flange that takes no time: the lateral velocity towards it drops from one row to the next."""
    if not has(run, "vY", "Y") or len(run.time) < 2:
        return None
    contact, towards = f"{side}F", 1 if side == "L" else -1
    t, v, y = run.time, towards*run.values("vY"), towards*run.values("Y")
    force = np.abs(np.nan_to_num(run.values(f"N_{contact}")))
    drop, spacing = v[:-1] - v[1:], np.diff(t)
    explained = spacing*np.maximum(force[1:], force[:-1])
    with np.errstate(invalid="ignore"):
        found = (drop > SUDDEN*v[:-1]) & (v[:-1] > 0.02) & (y[:-1] > 0.5*np.nanmax(y)) & (Case().mass*drop > 5*explained)
    found &= spacing < CLOSE_ROWS
    if not found.any():
        return None
    k = int(found.argmax()) + 1
    told = next((event.impulses[contact] for event in run.events
                 if contact in event.impulses and abs(event.t - t[k]) <= CLOSE_ROWS), np.nan)
    return ContactInterval(contact, float(t[k]), float(t[k]), np.nan, float(t[k]), told, np.nan, top=k)


def return_time(run: RunData, right: float) -> Number:
    """When the wheelset is back at the centre after it touched the right flange."""
    if not has(run, "Y"):
        return Number(np.nan, NO_DISPLACEMENT)
    t, y = run.time, run.values("Y")
    if np.isnan(right):
        if not np.nanmin(y, initial=0.0) < -0.5*np.nanmax(y, initial=0.0):
            return Number(np.nan, "the wheelset does not reach the right flange")
        right = float(t[np.nanargmin(y)])
    back = next((passage for passage in passages(run) if passage > right), np.nan)
    return Number(back, "the file ends before the wheelset is back at the centre")
