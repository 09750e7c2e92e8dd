"""A run in one row of numbers, for the table of all runs, summary.csv and the abstract."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .answers import answers
from .quantities import CONTACTS, OUTCOME
from .run_data import RunData

# The rows of the table of all runs, by their names in `quantities.OUTCOME`. Pressures come from `geometry.pressures`.
SUMMARY = (
    "t_first_LF", "t_first_RF", "t_first_centre", "t_return", "t_derailment", "F_derailment", "farthest_left", "farthest_right",
    "farthest_up", "farthest_down", "largest_roll", "smallest_roll", *(f"peak_N_{c}" for c in CONTACTS),
    "first_peak_N_LF", "pmax_LF", "patch_LF", "approach_LF", "first_peak_N_RF", "pmax_RF", "patch_RF", "approach_RF",
    "n_left_flange_contact", "n_right_flange_contact", "n_left_wheel_lift_off", "n_right_wheel_lift_off",
    "drift", "drift_relative", "step", "t")


#: By case and result, how far a start moved by 1 µm changes the chaotic results, SI; infinite where one comes or goes.
Chaotic = Mapping[str, Mapping[str, float]]
CHAOTIC_NOTE = ("italics: chaotic, one sample; a start moved by 1 µm changes the number by more than 0.1 %, and its last "
                "digit by three at most, or makes it come or go")


def shown(row: Mapping[str, Any], key: str, chaotic: Chaotic, digits: int | None = None) -> tuple[str, bool]:
    """A result of a row as every table shows it, and whether it is chaotic."""
    spread = chaotic.get(str(row["case"]), {}).get(key)
    return OUTCOME[key].text(row.get(key), digits, spread or 0.0), spread is not None


def summary_row(run: RunData) -> dict[str, Any]:
    """The run in one row, SI units; None for what did not happen."""
    known = answers(run)
    numbers = dict.fromkeys((*SUMMARY, *(f"t_peak_{c}" for c in CONTACTS), "t_first_peak_LF", "t_first_peak_RF", "drift_reference",
                             "steps", "end"))
    return {"case": run.name, "exercise": run.exercise, "profiles": run.pair,
            "model": run.setting("contact", "model") if run.formulation == "elastic" else run.formulation,
            **{name: known[name] for name in numbers}}
