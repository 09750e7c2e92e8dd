"""A round of the benchmark with six codes that do not exist: runs of ours, written as somebody else would write them."""
from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest

import golden
import ldbench
from hostile_files import HOSTILE
from invented import COARSE
from ldbench import Case
from ldbench.results.run_data import RunData
from ldbench_round import check, own_runs
from ldbench_round.collation import Collation, collate
from ldbench_round.kept_entries import find_references
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


FAST, SLOW = Task(4, "aw"), Task(2, "aw")
ADAMS, BORA, CONTURA, GENSIM, IMPAKT, KINEMA = CODES
FILE = f"{FAST.name}.csv"


class Runs:
    """Runs of ours that codes share, each computed once; contact tables too."""

    def __init__(self) -> None:
        self.runs: dict[str, ldbench.Run] = {}
        self.tables: dict[str, Any] = {}

    def of(self, code: Code, task: Task) -> ldbench.Run:
        law = repr(code.case)
        if law + task.name not in self.runs:
            case = Case.exercise(task.exercise, task.profiles).replace(**code.case)
            self.runs[law + task.name] = run = ldbench.run(case, table=self.tables.get(law))
            self.tables[law] = run.table
        return self.runs[law + task.name]


def submit(code: Code, task: Task, folder: Path, run: RunData) -> None:
    """A file of a code in its folder, and the description."""
    (folder/code.name).mkdir(parents=True, exist_ok=True)
    write(table_of(run), folder/code.name/f"{task.name}.csv", code.row)
    restitution = f'restitution = {code.case["restitution"]}\n' if "restitution" in code.case else ""
    (folder/code.name/"submission.toml").write_text(
        f'code = "{code.name}"\nauthors = ["A. Author", "B. Author"]\nprocessor_time = {{ ex2_aw = 1.5 }}\n{restitution}')


read = cache(ldbench.read_run)


def run_of(code: Code, task: Task) -> RunData:
    """The run that a file of the round was written from."""
    return read(the_round()/"runs"/code.name/f"{task.name}.txt")


@contextmanager
def own_are_of(code: Code, of: Callable[[Code, Task], RunData]) -> Iterator[None]:
    """Our own runs, by which maps are guessed, are those of a code."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(own_runs, "_OWN", {task: of(code, task) for task in (FAST, SLOW)})
        yield


def collated(folder: Path, reference: Path | None = None) -> Collation:
    """The collation of the codes below a folder, with what it keeps beside them."""
    (folder/"kept").mkdir(exist_ok=True)
    return collate(folder/"codes", folder/"kept", 2, references=find_references(reference) if reference else None)


def make_round(folder: Path) -> None:
    """Codes with one simulation each, two of them with another one, and the runs that their files come from, collated."""
    runs = Runs()
    for code, task in *((code, FAST) for code in CODES), (ADAMS, SLOW), (BORA, SLOW):
        run = runs.of(code, task)
        submit(code, task, folder/"codes", run)
        (folder/"runs"/code.name).mkdir(parents=True, exist_ok=True)
        run.write(folder/"runs"/code.name/f"{task.name}.txt")
    with own_are_of(BORA, runs.of):
        collated(folder)


def make_graded(folder: Path) -> None:
    """Bora with larger forces, a code with softer steel, one whose file cannot be read, and one whose times are ten seconds later,
    by its own map, collated with Bora as the reference."""
    codes, written = folder/"codes", the_round()/"codes"
    good = written/BORA.name/FILE
    frame = pd.read_csv(good)
    forces = frame.columns[frame.columns.str.contains("force")]
    for name, source in ("Itself", BORA), ("Softer", CONTURA):
        shutil.copytree(written/source.name, codes/name)
    for name in ("Near", "Double", "Late", "Spoilt"):
        (codes/name).mkdir()
    for name, factor in ("Near", 1.005), ("Double", 2.0):
        frame.assign(**{one: factor*frame[one] for one in forces}).to_csv(codes/name/FILE, index=False)
    frame.assign(**{"time [s]": frame["time [s]"] + 10}).to_csv(codes/"Late"/FILE, index=False)
    (codes/"Late/submission.toml").write_text('map = "columns.toml"\n')
    (codes/"Spoilt"/FILE).write_text("nothing\n")
    with own_are_of(BORA, run_of):
        (codes/"Late/columns.toml").write_text(check.check_file(good).guess.toml())
        collated(folder, good)


def make_hostile(folder: Path) -> None:
    """A code for each kind of file that nobody can use, beside two that are as they should be, collated. The good file has every
    second row, to be checked in half the time."""
    codes, written = folder/"codes", the_round()/"codes"
    shutil.copytree(written/ADAMS.name, codes/ADAMS.name)
    for name in BORA.name, *HOSTILE, "no files", "TOML that does not parse":
        (codes/name).mkdir()
    good = codes/BORA.name/FILE
    names, *rows = (written/BORA.name/FILE).read_text().splitlines(True)
    good.write_text("".join([names, *rows[::2]]))
    for kind, spoil in HOSTILE.items():
        spoil(codes/kind/FILE, good)
    shutil.copy(good, codes/"TOML that does not parse")
    (codes/"TOML that does not parse/submission.toml").write_bytes(b"\xff\xfe code = = \n")
    (codes/"zz loop").symlink_to("zz loop")
    with own_are_of(BORA, run_of):
        collated(folder)


RECIPE = "imaginary_round", "hostile_files", "invented", "stranger_files"


@cache
def the_round() -> Path:
    return golden.kept("round", golden.of_python(), make_round, *RECIPE)


@cache
def graded_round() -> Path:
    return golden.kept("graded", golden.of_python(), make_graded, *RECIPE)


@cache
def hostile_round() -> Path:
    return golden.kept("hostile", golden.of_python(), make_hostile, *RECIPE)
