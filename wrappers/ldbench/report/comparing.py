"""Runs compared in one call: `ldbench.compare`."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

from ..results.run_data import RunData
from ..runs import read_run

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd


def compare(reference: RunData | str | os.PathLike[str], *others: RunData | str | os.PathLike[str],
            align: Literal["time", "first-flange"] = "time", map: Any = None) -> pd.DataFrame:
    """What differs between runs, or column files, and the reference, as the command `compare` writes it as CSV, SI units: root mean
    square and largest difference of each quantity, events and peaks, impacts.

    align: lay equal times, or the first flange contacts, on each other. map: names of columns in files without ldbench's header.
    """
    import pandas as pd

    from .differences import compare as compared, difference_table, event_table, impact_table

    found = compared([run if isinstance(run, RunData) else read_run(run, map) for run in (reference, *others)], align)
    return pd.concat([difference_table(found), event_table(found.runs), impact_table(found.runs)], ignore_index=True)
