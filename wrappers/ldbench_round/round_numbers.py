"""The numbers of a run for the matrix of a round, found in the same way for every code, from the rows of its file."""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ldbench import Case
from ldbench.geometry.derailment import derailment
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.quantities import KN, OUTCOME, Quantity
from ldbench.results.run_data import RunData

from .findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding
from .inertia_checks import has
from .metrics import passages
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


class Number(NamedTuple):
    """A number of a run in SI units, or why there is none."""

    value: float
    reason: str = ""                # where the value is NaN


def names_of(task: Task) -> list[str]:
    """The numbers that a simulation has."""
    left_out = {"t_right_flange", "t_return"} if task.exercise == 5 else {"F_derailment"}
    return [name for name in NUMBERS if name not in left_out]


def numbers_of(run: RunData, task: Task, findings: Iterable[Finding], seconds: float = np.nan) -> dict[str, Number]:
    """All numbers of a run whose columns are ours, in SI units.

    findings: of the check, for the error of the energy balance. seconds: processor time that the submission tells.
    """
    left = first_impact(run, "L")
    found = impact_numbers(run, left)
    if task.exercise == 5:
        event = derailment(run, Case.exercise(5, task.profiles)) if has(run, "Y") else None
        found["F_derailment"] = Number(event.force if event else np.nan, "the file ends before the derailment" if has(run, "Y")
                                       else "no lateral displacement in the file")
    else:
        right = first_impact(run, "R")
        found["t_right_flange"] = Number(right.start) if isinstance(right, ContactInterval) else Number(np.nan, right)
        found["t_return"] = return_time(run, right.start if isinstance(right, ContactInterval) else np.nan)
    energy = next((one for one in findings if one.what == "energy closes"), None)
    found["energy_error"] = Number(np.nan, "not checked") if energy is None else Number(
        energy.number, energy.hint if np.isnan(energy.number) else "")
    found["processor_time"] = Number(seconds, "" if np.isfinite(seconds) else "the submission does not tell it")
    return {name: finite(found[name]) for name in names_of(task)}


def finite(number: Number) -> Number:
    """A number that can be, or the reason why it is none."""
    if np.isfinite(number.value) and abs(number.value) <= BEYOND:
        return Number(float(number.value))
    return Number(np.nan, number.reason or "the rows give no number that can be")


def impact_numbers(run: RunData, left: ContactInterval | str) -> dict[str, Number]:
    """The numbers of the first impact of the left flange, or why there are none."""
    if isinstance(left, str):
        return {name: Number(np.nan, left) for name in ("t_left_flange", "peak", "impulse", "duration", "rebound")}
    sudden = "the impact takes no time"
    rebound = Number(np.nan, "no lateral velocity in the file")
    if has(run, "vY"):
        v = run.values("vY")
        before, after = np.interp([left.start, left.end], run.time, v) if left.duration > 0 else v[left.top - 1:left.top + 1]
        rebound = Number(-after/before) if abs(before) > 0 else Number(np.nan, "no lateral velocity before the impact")
    return {"t_left_flange": Number(left.start), "peak": Number(left.peak, sudden),
            "impulse": Number(left.impulse, f"{sudden}, and the file does not tell its impulse"),
            "duration": Number(left.duration), "rebound": rebound}


def first_impact(run: RunData, side: str) -> ContactInterval | str:
    """The first impact of a flange, 'L' or 'R'; words that say why there is none.

    It is the first closed interval of the contact, not of its root, or, where the lateral velocity turns from one row to
    the next without a force that explains it, an impact without duration, as codes with constraints have it.
    """
    lasting, sudden = first_interval(run, f"{side}F"), sudden_impact(run, side)
    if sudden and (isinstance(lasting, str) or sudden.start <= lasting.start + CLOSE_ROWS):
        return sudden
    return lasting


def first_interval(run: RunData, contact: str) -> ContactInterval | str:
    """The first closed interval of a flange, where it begins and ends in the rows; words that say why there is none."""
    flange = "left flange" if contact[0] == "L" else "right flange"
    if not has(run, f"N_{contact}"):
        return f"no normal force of the {flange} in the file"
    one = run.first_interval(contact)
    return one if one and one.is_impact else f"no impact of the {flange} begins and ends in the rows"


def sudden_impact(run: RunData, side: str) -> ContactInterval | None:
    """The first impact of a flange that takes no time: the lateral velocity towards it drops from one row to the next."""
    # Without forces nothing tells such an impact from one that lasts.
    if not has(run, "vY", "Y", f"N_{side}F") or len(run.time) < 2:
        return None
    towards = 1 if side == "L" else -1
    t, v, y = run.time, towards*run.values("vY"), towards*run.values("Y")
    force = np.nan_to_num(run.values(f"N_{side}F"))
    mass = Case().mass
    drop, spacing = v[:-1] - v[1:], np.diff(t)
    explained = np.abs(spacing)*np.maximum(np.abs(force[1:]), np.abs(force[:-1]))
    with np.errstate(invalid="ignore"):
        found = (drop > SUDDEN*v[:-1]) & (v[:-1] > 0.02) & (y[:-1] > 0.5*np.nanmax(y)) & (mass*drop > 5*explained)
    found &= spacing < CLOSE_ROWS
    if not found.any():
        return None
    k = int(found.argmax())
    told = next((event.impulses[f"{side}F"] for event in run.events
                 if f"{side}F" in event.impulses and abs(event.t - t[k + 1]) <= CLOSE_ROWS), np.nan)
    return ContactInterval(f"{side}F", float(t[k + 1]), float(t[k + 1]), np.nan, float(t[k + 1]), told, np.nan, top=k + 1)


def return_time(run: RunData, right: float) -> Number:
    """When the wheelset is back at the centre after it touched the right flange."""
    if not has(run, "Y"):
        return Number(np.nan, "no lateral displacement in the file")
    t, y = run.time, run.values("Y")
    if np.isnan(right):
        if not np.nanmin(y, initial=0.0) < -0.5*np.nanmax(y, initial=0.0):
            return Number(np.nan, "the wheelset does not reach the right flange")
        right = float(t[np.nanargmin(y)])
    back = next((passage for passage in passages(run) if passage > right), np.nan)
    return Number(back, "the file ends before the wheelset is back at the centre")


def verdict_counts(findings: Iterable[Finding]) -> dict[str, int]:
    """How many checks passed, are doubtful, failed, were not made."""
    counts = Counter(finding.verdict for finding in findings)
    return {name: counts[verdict] for verdict, name in VERDICTS.items()}
