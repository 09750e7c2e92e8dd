"""A run in one row of numbers, for the table of all runs, summary.csv and the abstract."""
from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .quantities import CONTACTS, OUTCOME
from .run_data import RETURNED, RunData

# The rows of the table of all runs, by their names in `quantities.OUTCOME`. Pressures come from `geometry.pressures`.
SUMMARY = (
    "t_first_LF", "t_first_RF", "t_first_centre", "t_return", "t_derailment", "F_derailment", "Y_max", "Y_min", "Z_max", "Z_min",
    "roll_max", "roll_min", *(f"peak_N_{c}" for c in CONTACTS), "first_peak_N_LF", "pmax_LF", "patch_LF", "approach_LF",
    "first_peak_N_RF", "pmax_RF", "patch_RF", "approach_RF", "n_left_flange_contact", "n_right_flange_contact",
    "n_left_wheel_lift_off", "n_right_wheel_lift_off", "drift", "drift_relative", "step", "t")


#: By case and result, how far a start moved by 1 µm changes the chaotic results, SI; infinite where one comes or goes.
Chaotic = Mapping[str, Mapping[str, float]]
CHAOTIC_NOTE = ("italics: chaotic, one sample; a start moved by 1 µm changes the number by more than 0.1 %, and its last "
                "digit by three at most, or makes it come or go")


def shown(row: Mapping[str, Any], key: str, chaotic: Chaotic, digits: int | None = None) -> tuple[str, bool]:
    """A result of a row as every table shows it, and whether it is chaotic."""
    spread = chaotic.get(str(row["case"]), {}).get(key)
    return OUTCOME[key].text(row.get(key), digits, spread or 0.0), spread is not None


def drift_reference(run: RunData) -> float:
    """Reference of the relative energy drift [J]: the kinetic energy of lateral, vertical and roll motion
    at the start, or the work of the lateral force if the wheelset starts at rest. NaN without these columns."""
    if not {"KE_lat", "KE_vert", "KE_roll", "W_ext"}.issubset(run.data):
        return np.nan
    kinetic = sum(run.values(column)[0] for column in ("KE_lat", "KE_vert", "KE_roll"))
    return float(kinetic) or float(np.abs(run.values("W_ext")).max())


def summary_row(run: RunData) -> dict[str, Any]:
    """The run in one row, SI units; None for what did not happen."""
    passages = run.passages()
    derailment = run.first("derailment")
    row: dict[str, Any] = {
        "case": run.name,
        "exercise": run.exercise,
        "profiles": run.pair,
        "model": run.setting("contact", "model") if run.formulation == "elastic" else run.formulation,
        "step": run.result("step"),
        "steps": run.header.results.get("steps"),
        "end": run.ending,
        "t": float(run.time[-1]),
        "t_first_LF": run.first_contact("LF"),
        "t_first_RF": run.first_contact("RF"),
        "t_first_centre": passages[0] if passages else None,
        "t_return": passages[-1] if passages and run.ending == RETURNED else None,
        "t_derailment": derailment.t if derailment else None,
        "F_derailment": derailment.force if derailment and np.isfinite(derailment.force) else None,
    }
    for column in ("Y", "Z", "roll"):
        x = run.values(column) if column in run.data else np.array([np.nan])
        row[f"{column}_min"], row[f"{column}_max"] = float(x.min()), float(x.max())
    # Between the rows, too, where the file says it.
    for way, name in ("left", "Y_max"), ("right", "Y_min"), ("up", "Z_max"):
        row[name] = run.header.results.get(f"farthest_{way}", row[name])
    for contact in CONTACTS:
        row[f"peak_N_{contact}"], row[f"t_peak_{contact}"] = run.peak(contact) or (None, None)
    for contact in ("LF", "RF"):
        row[f"first_peak_N_{contact}"], row[f"t_first_peak_{contact}"] = run.first_peak(contact) or (None, None)
    for side in ("left", "right"):
        row[f"n_{side}_flange_contact"] = run.count(f"{side} flange contact")
        row[f"n_{side}_wheel_lift_off"] = run.count(f"{side} wheel lift-off")
    reference = drift_reference(run)
    return row | {"drift_reference": reference, "drift": run.result("drift"),
                  "drift_relative": run.result("drift")/(reference or np.nan)}
