"""The numbers of a run for the matrix of a round: answers, which every code's file has by the same definitions, and a few more."""
from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ldbench import Case
from ldbench.constants import CONTACT_NAMES, KN
from ldbench.results.answers import answers
from ldbench.results.quantities import OUTCOME, Quantity, si_unit
from ldbench.results.run_data import RunData

from .findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding
from .tasks import Task

MS: dict[str, Any] = {"unit": "ms", "scale": 1e3, "digits": 3}
#: The numbers in words, and how they are shown; answers of a run have their own words.
NUMBERS = {
    "t_first_LF": OUTCOME["t_first_LF"]._replace(short="left flange", **MS),
    "t_first_RF": OUTCOME["t_first_RF"]._replace(short="right flange", **MS),
    "first_peak_N_LF": OUTCOME["first_peak_N_LF"]._replace(short="peak", digits=1),
    "first_impulse_LF": OUTCOME["first_impulse_LF"]._replace(short="impulse", unit="kN·s", scale=KN, digits=4),
    "first_duration_LF": OUTCOME["first_duration_LF"]._replace(short="duration", digits=3),
    "rebound": Quantity("lateral velocity after over before that contact, reversed", "", 1, digits=4, short="rebound"),
    "t_return": OUTCOME["t_return"]._replace(short="return", **MS),
    "F_derailment": OUTCOME["F_derailment"]._replace(short="derailment"),
    "energy_error": Quantity("error of the energy balance, at rest on the treads", "%", 100, digits=2, short="energy error"),
    "processor_time": Quantity("processor time", "s", 1, digits=2, short="processor time"),
}
#: SI units of the numbers, as the CSV has them.
SI = {name: si_unit(name) or {"processor_time": "s"}.get(name, "1") for name in NUMBERS}
VERDICTS = {PASSED: "passed", DOUBTFUL: "doubtful", FAILED: "failed", UNKNOWN: "not_checked"}

BEYOND = 1e15           # what no number of a wheelset reaches, in any of the units
NO_DISPLACEMENT = "no lateral displacement in the file"


class Number(NamedTuple):
    """A number of a run in SI units, or why there is none."""

    value: float
    reason: str = ""                # where the value is NaN


def main_number(task: Task) -> str:
    """The number of a simulation that stands for it."""
    return "F_derailment" if task.exercise == 5 else "first_peak_N_LF"


def names_of(task: Task) -> list[str]:
    """The numbers that a simulation has."""
    left_out = {"t_first_RF", "t_return"} if task.exercise == 5 else {"F_derailment"}
    return [name for name in NUMBERS if name not in left_out]


def numbers_of(run: RunData, task: Task, findings: Iterable[Finding], seconds: float = np.nan) -> dict[str, Number]:
    """All numbers of a run whose columns are ours, in SI units.

    findings: of the check, for the error of the energy balance. seconds: processor time that the submission tells.
    """
    known = answers(run, Case.exercise(task.exercise, task.profiles))
    others = {"energy_error": next((Number(one.number, one.hint) for one in findings if one.what == "energy closes"),
                                   Number(np.nan, "not checked")),
              "processor_time": Number(seconds, "the submission does not tell it"), "rebound": rebound(run, known)}
    return {name: finite(others[name] if name in others else Number(np.nan if known[name] is None else known[name],
                                                                    reason(run, name, known))) for name in names_of(task)}


def finite(number: Number) -> Number:
    """A number that can be, or the reason why it is none."""
    if np.isfinite(number.value) and abs(number.value) <= BEYOND:
        return Number(float(number.value))
    return Number(np.nan, number.reason or "the rows give no number that can be")


def reason(run: RunData, name: str, known: Mapping[str, Any]) -> str:
    """Why a run has no answer of a name."""
    if name in ("t_return", "F_derailment"):
        return NO_DISPLACEMENT if "Y" not in run else "the file ends before " + (
            "the wheelset is back at the centre after turning back on both sides" if name == "t_return" else "the derailment")
    contact = name[-2:]
    if run.normal_force(contact) is None:
        return f"no normal force of the {CONTACT_NAMES[contact]} in the file"
    if known[f"t_first_{contact}"] is None:
        return f"no contact of the {CONTACT_NAMES[contact]} in the rows"
    if known[f"first_duration_{contact}"] is None:
        return f"the first contact of the {CONTACT_NAMES[contact]} does not end in the rows"
    return "the impact takes no time" + (", and the file does not tell its impulse" if "impulse" in name else "")


def rebound(run: RunData, known: Mapping[str, Any]) -> Number:
    """Lateral velocity after the first contact of the left flange over the one before, reversed."""
    start, duration = known["t_first_LF"], known["first_duration_LF"]
    if duration is None:
        return Number(np.nan, reason(run, "first_duration_LF", known))
    if "vY" not in run:
        return Number(np.nan, "no lateral velocity in the file")
    t, v = run.time, run.values("vY")
    before, after = np.interp([start, start + duration], t, v)
    if duration == 0:           # between the last row before the impact and the row after it; files have times in nine digits
        k = int(np.searchsorted(t, start*(1 + 1e-8), "right")) - 1
        before, after = v[max(k - 1, 0)], v[k]
    return Number(-after/before) if abs(before) > 0 else Number(np.nan, "no lateral velocity before the impact")
