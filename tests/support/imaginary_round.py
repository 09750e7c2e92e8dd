"""A round of the benchmark with twelve codes that do not exist: contact laws, steels, constraints and damping of their own."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

import imaginary_codes as imaginary
import ldbench
from ldbench import Case
from ldbench.results.run_data import RunData
from ldbench_round.tasks import Task

Change = Callable[[pd.DataFrame], pd.DataFrame]


def same(frame: pd.DataFrame) -> pd.DataFrame:
    return frame


@dataclass(frozen=True)
class Code:
    """A code that does not exist."""

    name: str
    law: str
    case: dict[str, Any]                    # what it changes of ours
    dialect: imaginary.Dialect = field(default_factory=imaginary.Dialect)
    change: Change = same                   # of its results
    formulation: str = "elastic"


D = imaginary.Dialect
STRIP, HERTZ = {"model": "strip", "table_file": ""}, {"model": "hertz", "table_file": ""}
RIGID = {"formulation": "unilateral", "table_file": ""}
CODES = (
    Code("Adams", "strips", STRIP, D(length="mm", force="kN", scheme=2)),
    Code("Bora", "Hertz", HERTZ, D(scheme=1)),
    Code("Contura", "Hertz, steel softer by a fifth", HERTZ | {"stiffness_scale": 0.8},
         D(lateral=-1, length="mm", force="kN", scheme=1)),
    Code("Dynarail", "Hertz, steel stiffer by a fifth", HERTZ | {"stiffness_scale": 1.2}, D(angle="mrad", scheme=2, separator=";")),
    Code("Elastra", "strips, softer steel", STRIP | {"stiffness_scale": 0.7}, D(vertical=-1, scheme=2, separator="\t")),
    Code("Flange8", "Hertz, damped", HERTZ, D(length="mm", angle="deg", scheme=1, separator=" "), imaginary.damped),
    Code("Gensim", "strips, damped", STRIP, D(force="kN", roll=-1, scheme=2), imaginary.damped),
    Code("Hunt", "rigid, restitution 1", RIGID | {"restitution": 1.0}, D(scheme=2), formulation="unilateral constraints"),
    Code("Impakt", "rigid, restitution 0.5", RIGID | {"restitution": 0.5}, D(scheme=1), formulation="unilateral constraints"),
    Code("Jolt", "rigid, restitution 0", RIGID | {"restitution": 0.0}, D(length="mm", scheme=2),
         formulation="unilateral constraints"),
    Code("Kinema", "strips, rows every 2 ms", STRIP, D(scheme=0), imaginary.thinned),
    Code("Lumen", "Hertz, half the stiffness", HERTZ | {"stiffness_scale": 0.5}, D(start=0.5, height=0.457, scheme=2)),
)


class Runs:
    """Runs of ours that codes share, each computed once; contact tables too."""

    def __init__(self, **changes: Any) -> None:
        """changes: of all cases, as a coarser table."""
        self.changes = changes
        self.runs: dict[str, RunData] = {}
        self.tables: dict[str, Any] = {}

    def of(self, code: Code, task: Task) -> RunData:
        law = repr(sorted(code.case.items()))
        key, pair = f"{law} {task.name}", f"{law} {task.profiles}"
        if key not in self.runs:
            case = Case.exercise(task.exercise, task.profiles).replace(**code.case | self.changes)
            self.runs[key] = run = ldbench.run(case, table=self.tables.get(pair))
            self.tables[pair] = run.table
        return self.runs[key]


def submit(code: Code, task: Task, folder: Path, runs: Runs) -> None:
    """A file of a code in its folder; the run that it comes from is `runs.of(code, task)`."""
    (folder/code.name).mkdir(exist_ok=True)
    imaginary.write(code.change(imaginary.table_of(runs.of(code, task), 1e-4)), folder/code.name/f"{task.name}.csv", code.dialect)


def describe(code: Code, folder: Path, seconds: float = 1.5) -> None:
    """The description of a code in its folder."""
    (folder/code.name).mkdir(exist_ok=True)
    restitution = f'restitution = {code.case["restitution"]}\n' if "restitution" in code.case else ""
    (folder/code.name/"submission.toml").write_text(
        f'code = "{code.name}"\nversion = "1.0"\nauthors = ["A. Author", "B. Author"]\nformulation = "{code.formulation}"\n'
        f'law = "{code.law}"\nstep = 1e-5\nmachine = "a laptop"\nprocessor_time = {{ ex2_aw = {seconds} }}\n{restitution}')


def write_round(folder: Path, tasks: Iterable[Task], codes: Sequence[Code], runs: Runs) -> None:
    """The folder of a round."""
    for task in tasks:
        for code in codes:
            submit(code, task, folder, runs)
    for k, code in enumerate(codes):
        describe(code, folder, 1.5 + k)
