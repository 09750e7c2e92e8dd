"""A round of the benchmark with twelve codes that do not exist: contact laws, steels, constraints and damping of their own.

usage: PYTHONPATH=tests/support:profiles python tests/support/imaginary_round.py FOLDER [INTERVAL]       (make collation)
It writes twelve codes by ten simulations, collates them, and prints times and the memory of the largest process. INTERVAL: of the
rows of exercise 5 [s]; the other exercises have rows every 0.1 ms.
"""
from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd

import imaginary_codes as imaginary
import ldbench
from ldbench import Case
from ldbench.results.run_data import RunData
from ldbench_round.tasks import TASKS, Task
from running import environment

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

    def __init__(self, interval: float | None = None, **changes: Any) -> None:
        """interval: of the rows of exercise 5 [s]. changes: of all cases, as a coarser table."""
        self.interval, self.changes = interval, changes
        self.runs: dict[str, RunData] = {}
        self.tables: dict[str, Any] = {}

    def of(self, code: Code, task: Task) -> RunData:
        law = repr(sorted(code.case.items()))
        key = f"{law} {task.name}"
        if key not in self.runs:
            case = Case.exercise(task.exercise, task.profiles).replace(**code.case | self.changes)
            if task.exercise == 5 and self.interval is not None:
                # Between the shipped rows, which are far apart, no row could be interpolated.
                case = case.replace(rows="interval", interval=self.interval, dt=min(case.dt, self.interval))
            # Rigid contacts rattle without end on a rail under a force, so a shorter exercise 5 does.
            if task.exercise == 5 and code.formulation != "elastic":
                case = case.replace(t_end=20.0)
            table = self.tables.get(f"{law} {task.profiles}")
            self.runs[key] = run = ldbench.run(case, table=table)
            self.tables[f"{law} {task.profiles}"] = run.table
        return self.runs[key]


def submit(code: Code, task: Task, folder: Path, runs: Runs, interval: float = 1e-4) -> Path:
    """A file of a code in its folder; the run that it comes from is `runs.of(code, task)`."""
    (folder/code.name).mkdir(exist_ok=True)
    frame = code.change(imaginary.table_of(runs.of(code, task), interval))
    file = folder/code.name/f"{task.name}.csv"
    imaginary.write(frame, file, replace(code.dialect, interval=interval))
    return file


def describe(code: Code, folder: Path, seconds: float = 1.5) -> None:
    """The description of a code in its folder."""
    (folder/code.name).mkdir(exist_ok=True)
    restitution = f'restitution = {code.case["restitution"]}\n' if "restitution" in code.case else ""
    (folder/code.name/"submission.toml").write_text(
        f'code = "{code.name}"\nversion = "1.0"\nauthors = ["A. Author", "B. Author"]\nformulation = "{code.formulation}"\n'
        f'law = "{code.law}"\nstep = 1e-5\nmachine = "a laptop"\nprocessor_time = {{ ex2_aw = {seconds} }}\n{restitution}')


def write_round(folder: Path, tasks: Iterable[Task], codes: Sequence[Code] = CODES, runs: Runs | None = None) -> Runs:
    """The folder of a round."""
    runs = runs or Runs()
    folder.mkdir(exist_ok=True)
    for task in tasks:
        for code in codes:
            submit(code, task, folder, runs)
    for k, code in enumerate(codes):
        describe(code, folder, 1.5 + k)
    return runs


# ---- the demonstration ---------------------------------------------------------------
def measured(words: list[str]) -> tuple[float, float, int]:
    """Time, processor time [s] and memory of the largest process [bytes] of a command."""
    begun, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "ldbench", *words], env=environment(), check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return time.monotonic() - begun, processor, 1024*after.ru_maxrss


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("interval", type=float, nargs="?", default=1.6e-4)
    args = parser.parse_args()
    codes, results = args.folder/"codes", args.folder/"results"
    if not codes.exists():
        args.folder.mkdir(exist_ok=True)
        runs = write_round(codes, TASKS[:8], runs=Runs(args.interval))
        for task in TASKS[8:]:
            for code in CODES:
                file = submit(code, task, codes, runs, args.interval)
                print(f"{file} {file.stat().st_size/1e6:.0f} MB", flush=True)
            runs.runs.clear()
    results.mkdir(exist_ok=True)
    files = list(codes.rglob("*.csv"))
    print(f"{len(files)} files, {sum(path.stat().st_size for path in files)/1e9:.2f} GB, the largest "
          f"{max(path.stat().st_size for path in files)/1e6:.0f} MB; {os.cpu_count()} cores")
    words = ["collate", str(codes), "-o", str(results)]
    for what in "all files read", "nothing to read":
        seconds, processor, largest = measured(words)
        print(f"{what}: {seconds:.1f} s, processor time {processor:.1f} s, at most {largest/1e6:.0f} MB a process", flush=True)


if __name__ == "__main__":
    main()
