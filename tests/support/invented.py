"""Runs of invented numbers, runs of which something is changed, and the coarsest contact table."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from ldbench import Case
from ldbench.results.header import Comments
from ldbench.results.run_data import RunData

# The changes of a case that make its contact table so small that it is built in a moment.
COARSE = {"model": "hertz", "table_folder": ""}


def invented_run(frame: pd.DataFrame, file: str | Path = "invented.txt", name: str = "", comments: Comments | None = None,
                 case: Case | None = None) -> RunData:
    """A run with the columns `frame`; without comments it is like another code's file."""
    return RunData(Path(file), name=name, comments=comments or Comments(), data=frame, case=case)


def altered(run: RunData, results: Mapping[str, Any] | None = None, data: pd.DataFrame | None = None, name: str = "") -> RunData:
    """The run with other results beside the rest, other columns, or by another name."""
    comments = replace(run._comments, results=run.results | (results or {}))
    return invented_run(run.data if data is None else data, run.file, name or run.name, comments, run.case if run.is_ours else None)
