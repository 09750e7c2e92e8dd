"""Codes that ran with their own contact force, and with the force that the round gave to all.

With a given force codes differ by their integrators alone; what the medians of both groups differ by comes from the forces.
"""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from ldbench.tools import write_frame

from .collation import Collation
from .round_numbers import SI, names_of
from .submissions import CONTACT_FORCES, FORCE, Submission

FILE = "contact_forces.csv"


def group_of(code: Submission) -> str:
    """Whether a code ran with its own contact force, which needs not be said, or with the given one."""
    return code.facts.get(FORCE, CONTACT_FORCES[0])


def write_groups(found: Collation, target: Path) -> bool:
    """Write for each simulation and number how many codes of a group have it, their median, and their largest less their smallest
    value; then how far the median of the given force is from that of the own forces. Without a code that ran with the given force
    nothing is written, and the result is False."""
    if all(group_of(code) != "given" for code in found.codes):
        return False
    rows = []
    for task in found.tasks:
        for number in names_of(task):
            row: dict[str, object] = {"simulation": task.name, "number": number, "unit": SI[number]}
            medians = []
            for group in CONTACT_FORCES:
                values = np.array([found.value(code, task, number) for code in found.codes if group_of(code) == group])
                known = values[np.isfinite(values)]
                medians.append(float(np.median(known)) if len(known) else np.nan)
                row |= {f"{group}_codes": len(known), f"{group}_median": medians[-1],
                        f"{group}_spread": float(np.ptp(known)) if len(known) else np.nan}
            rows.append(row | {"given_less_own": medians[1] - medians[0]})
    write_frame(pd.DataFrame(rows), target)
    return True
