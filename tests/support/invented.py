"""Runs of invented numbers, runs of which something is changed, and the coarsest contact table."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from ldbench import Case
from ldbench.results.header import Header
from ldbench.results.run_data import RunData

# The changes of a case that make its contact table so small that it is built in a moment.
COARSE = {"model": "hertz", "table_file": ""}


def invented_run(frame: pd.DataFrame, file: str | Path = "invented.txt", name: str = "", header: Header | None = None,
                 case: Case | None = None) -> RunData:
    """A run with the columns `frame`; without a header it is like another code's file."""
    return RunData(Path(file), name=name, header=header or Header(), data=frame, case=case)


def altered(run: RunData, header: Mapping[str, Any] | None = None, results: Mapping[str, Any] | None = None,
            data: pd.DataFrame | None = None, name: str = "") -> RunData:
    """The run with other fields of the header, other results beside the rest (None: without it), other columns, or by another name.
    The case is the one of the run, unless `header` has other settings."""
    facts = replace(run.header, **(header or {}))
    numbers = {key: value for key, value in {**facts.results, **(results or {})}.items() if value is not None}
    told = run.case if run.header.settings and facts.settings == run.header.settings else None
    return invented_run(run.data if data is None else data, run.file, name or run.name, replace(facts, results=numbers), told)
