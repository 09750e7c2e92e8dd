"""A round of the benchmark with six codes that do not exist: runs of ours, written as somebody else would write them."""
from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

import ldbench
from invented import COARSE
from ldbench import Case
from ldbench.results.run_data import RunData
from ldbench_round.tasks import Task
from stranger_files import CALL, DOWN, MM_KN, MRAD, RIGHT, ROLL, SHORT, Row, both, of, text_of, times

RIGHTWARDS = times(-1.0, *RIGHT, *of("Fy"))       # another code's columns of a lateral axis to the right


def table_of(run: RunData, interval: float = 1e-4) -> pd.DataFrame:
    """The columns of the call, on equal intervals [s]; a contact has no place between an open row and a closed one."""
    t = np.arange(run.time[0], run.time[-1] + interval/2, interval)
    found = {"time": t}
    for column in CALL[1:]:
        x = run.values(column)
        open_ = np.interp(t, run.time, np.isnan(x).astype(float)) > 0
        found[column] = np.where(open_, np.nan, np.interp(t, run.time, np.nan_to_num(x)))
    return pd.DataFrame(found)


def write(frame: pd.DataFrame, path: Path, row: Row) -> None:
    """Write the columns of the call as a code that does not exist writes them."""
    path.write_text(row.after(text_of(row.change(frame), **{"order": CALL, **row.form})))


def damped(frame: pd.DataFrame) -> pd.DataFrame:
    """The velocities die away, by a quarter over the run."""
    fading = 1 - 0.25*frame["time"]/frame["time"].iloc[-1]
    return frame.assign(**{name: frame[name]*fading for name in ("vY", "vZ", "roll_rate")})


class Code(NamedTuple):
    """A code that does not exist."""

    name: str
    case: dict[str, Any]        # what it changes of ours
    row: Row = Row()            # how it changes and writes the results


CODES = (
    Code("Adams", COARSE | {"stiffness_scale": 1.2}, Row(form={"units": MM_KN, "names": SHORT})),
    Code("Bora", COARSE),
    Code("Contura", COARSE | {"stiffness_scale": 0.8}, Row(RIGHTWARDS, {"units": {**MM_KN, **MRAD}, "sep": ";"})),
    Code("Gensim", COARSE, Row(both(damped, times(-1.0, *DOWN, *of("Fz"), *ROLL)), {"sep": "\t"})),
    Code("Impakt", {"formulation": "unilateral", "restitution": 0.5, "table_folder": ""}, Row(form={"names": SHORT})),
    Code("Kinema", COARSE, Row(lambda frame: frame.iloc[::20])),       # a row every 2 ms
)


class Runs:
    """Runs of ours that codes share, each computed once; contact tables too."""

    def __init__(self) -> None:
        self.runs: dict[str, RunData] = {}
        self.tables: dict[str, Any] = {}

    def of(self, code: Code, task: Task) -> RunData:
        law = repr(code.case)
        if law + task.name not in self.runs:
            case = Case.exercise(task.exercise, task.profiles).replace(**code.case)
            self.runs[law + task.name] = run = ldbench.run(case, table=self.tables.get(law))
            self.tables[law] = run.table
        return self.runs[law + task.name]


def submit(code: Code, task: Task, folder: Path, runs: Runs) -> None:
    """A file of a code in its folder, and the description; the run that it comes from is `runs.of(code, task)`."""
    (folder/code.name).mkdir(parents=True, exist_ok=True)
    write(table_of(runs.of(code, task)), folder/code.name/f"{task.name}.csv", code.row)
    restitution = f'restitution = {code.case["restitution"]}\n' if "restitution" in code.case else ""
    (folder/code.name/"submission.toml").write_text(
        f'code = "{code.name}"\nauthors = ["A. Author", "B. Author"]\nprocessor_time = {{ ex2_aw = 1.5 }}\n{restitution}')
