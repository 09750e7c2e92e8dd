"""A run in one row of numbers, for the table of all runs, summary.csv and the abstract."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..constants import CONTACTS
from ..number_text import UNKNOWN
from .answers import answers
from .quantities import OUTCOME, Quantity
from .run_data import RunData
from .twins import SAME, TWINS, Chaotic, Spread

# The rows of the table of all runs, by their names in `quantities.OUTCOME`.
SUMMARY = (
    "t_first_LF", "t_first_RF", "t_first_centre", "t_return", "F_limit_left", "F_unloaded", "t_derailment", "F_derailment",
    "farthest_left", "farthest_right", "farthest_up", "farthest_down", "largest_roll", "smallest_roll",
    *(f"peak_N_{c}" for c in CONTACTS), *(f"{name}_{c}" for c in ("LF", "RF") for name in (
        "first_peak_N", "first_duration", "first_impulse", "pmax", "patch", "approach")), "pmax",
    "n_left_flange_contact", "n_right_flange_contact", "n_left_wheel_lift_off", "n_right_wheel_lift_off",
    "drift", "drift_relative", "step", "t")
# The extreme poses, which tell nothing of a wheelset that derails: they are where the run ends.
EXTREMES = "farthest_left", "farthest_right", "farthest_up", "farthest_down", "largest_roll", "smallest_roll"
IDENTITY = "case", "exercise", "profiles", "model"      # of a row, which tell its run

CHAOTIC_NOTE = (
    f"with a range: median, least and largest of the run and of {len(TWINS)} twins, whose starts differ from its own by up to "
    f"{1e6*max(TWINS):.0f} µm, where one of these is more than {100*SAME:g} % from the median")


class Shown(NamedTuple):
    """A result as it is shown."""

    text: str       # the number, or the median of a chaotic one
    range: str      # in little room: '268–271', or '268–271, 5 of 9' where not all twins have it; '' of one that is not chaotic
    line: str       # number and range: '270 (268 to 271)'


def shown(row: Mapping[str, Any], key: str, chaotic: Chaotic, digits: int | None = None, known: Quantity | None = None) -> Shown:
    """A result of a row as every table shows it, with the range of a chaotic one; a dash for what did not happen, and for the
    extreme poses of a run that derails. known: digits and unit where they are others."""
    known, spread = known or OUTCOME[key], chaotic.get(str(row["case"]), {}).get(key)
    if key in EXTREMES and row["t_derailment"] is not None:
        return Shown(UNKNOWN, "", UNKNOWN)
    if spread:
        return ranged(known, spread, digits)
    text = known.text(row.get(key), digits)
    return Shown(text, "", text)


def ranged(known: Quantity, spread: Spread, digits: int | None = None) -> Shown:
    """Median and range of a chaotic result, with the digits that the range leaves."""
    width = spread.largest - spread.least
    median, least, largest = (known.text(x, digits, width) for x in (spread.median, spread.least, spread.largest))
    some = f", {spread.having} of {spread.of}" if spread.having < spread.of else ""
    dash = "…" if largest.startswith("−") else "–"
    return Shown(median, f"{least}{dash}{largest}{some}", f"{median} ({least} to {largest}{some})")


def summary_row(run: RunData) -> dict[str, Any]:
    """The run in one row, SI units; None for what did not happen."""
    known = answers(run)
    numbers = dict.fromkeys((*SUMMARY, *(f"t_peak_{c}" for c in CONTACTS), "t_first_peak_LF", "t_first_peak_RF", "t_unloaded",
                             "t_pmax", "pmax_contact", "drift_reference", "steps", "end"))
    return {"case": run.name, "exercise": run.exercise, "profiles": run.pair,
            "model": run.law, **{name: known[name] for name in numbers}}
