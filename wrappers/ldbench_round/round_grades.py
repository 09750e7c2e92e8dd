"""The grades of a round: what a collation keeps of the scores of a file against a reference."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ldbench import Error
from ldbench.results.run_data import RunData
from ldbench.tools import digest

from .check import read_submitted
from .energies import ENERGIES
from .horizon import horizon
from .jumps import IMPULSES
from .metrics import MATCHED_BEYOND, score
from .scores import GRADED, GRADES, Score, unscored
from .submissions import DESCRIPTION, complaint, find_files, present, printable, read_small_toml, reason, told_map
from .tasks import QUANTITIES, Task, task_of

LARGEST = 300_000_000           # of a file that is read [bytes]: 2 GB of memory hold it

#: What the table tells of each: the difference, its grade, its share of the spread of formulations, and what was scored.
ROW_ENDINGS = "", "_grade", "_of_spread", "_share"
NEEDED = {"time", *QUANTITIES, *ENERGIES, *IMPULSES}


def row_of(one: Score, ending: str) -> tuple[float, str]:
    """The value of a row of the table, and why it is NaN. ending: of the name of the row."""
    if np.isnan(one.difference):
        return np.nan, one.reason or "no difference is known"
    if ending == "_share":
        return one.share, ""
    if ending == "_grade":
        return (np.nan, f"beyond {GRADES[-1]:g}") if one.grade is None else (one.grade, "")
    if ending == "_of_spread":
        return one.of_spread, "" if np.isfinite(one.of_spread) else "the spread of this quantity is not known"
    return one.difference, ""


@dataclass(frozen=True)
class Reference:
    """The file of a simulation that others are scored against."""

    task: Task
    file: Path
    map: Mapping[str, Any] | None       # of its columns; None: it is guessed
    key: str                            # changes with the bytes of the file and the map


def find_references(path: Path) -> dict[Task, Reference]:
    """The references of a folder, which holds column files or is that of a code with its map; or of one file. Error if the folder,
    a file or the map cannot be read, if no file is of a simulation, or two are of the same one."""
    if not path.exists():
        raise Error(f"{path}: expected a folder of column files as the reference, or one such file, found none")
    try:
        folder = path if path.is_dir() else path.parent
        files = find_files(path, [], strict=True) if path.is_dir() else {task: path for task in [task_of(path)] if task}
        if not files:
            raise Error(f"{path}: expected names of files that say the simulation, as ex2_aw.txt, for the reference, found none")
        map, remarks = None, list[str]()
        if present(folder/DESCRIPTION):
            map = told_map(read_small_toml(folder/DESCRIPTION), folder, remarks)
        if remarks:
            raise Error(f"{folder}: {remarks[0].removesuffix('; the map is guessed')}")
        return {task: reference_of(task, file, map) for task, file in files.items()}
    except OSError as error:
        raise Error(f"{path}: expected a reference that can be read, found {reason(error)}") from None


def reference_of(task: Task, file: Path, map: Mapping[str, Any] | None) -> Reference:
    """The reference of a simulation. Error where its file cannot be read."""
    try:
        return Reference(task, file, map, digest(repr((digest_of(file), task.name, map)).encode()))
    except Error as error:
        raise Error(f"{file.parent}/{error}") from None


def digest_of(file: Path) -> str:
    """The digest of a file's bytes. Error where it cannot be read or is too large."""
    try:
        size = file.stat().st_size
        if size > LARGEST:
            raise Error(f"{file.name}: expected at most {LARGEST/1e6:.0f} MB, found {size/1e6:.0f} MB")
        return digest(file.read_bytes())
    except (OSError, ValueError) as error:
        raise Error(f"{printable(file.name)}: cannot be opened for reading: {reason(error)}") from None


_READ: dict[str, RunData] = {}


def read_reference(one: Reference) -> RunData:
    """The columns and rows of a reference that scores need, read once. Error where there are none."""
    if one.key not in _READ:
        with np.errstate(all="ignore"):
            run = read_submitted(one.file, one.task, one.map).run
            data = run.data
        known = [name for name in data if name in NEEDED - {"time"} and np.isfinite(data[name]).any()]
        if "time" not in data or len(data) < 2 or not known:
            raise Error(f"{one.file}: expected times, and numbers of the motion or of normal forces, found none")
        # The row behind the last one that is matched: the reference is interpolated between rows.
        rows = int(np.searchsorted(run.time, MATCHED_BEYOND*horizon(one.task), "right")) + 1
        few = data.iloc[:rows][[name for name in data if name in NEEDED]].copy()
        _READ[one.key] = RunData(one.file, header=run.header, data=few)
    return _READ[one.key]


def graded(run: RunData, task: Task, reference: RunData) -> tuple[dict[str, Score], str]:
    """The scores of a run by the kinds of GRADED, each with the share of its kind that was scored; or none, and why."""
    try:
        scores = score(run, reference, task)
    except Exception as error:
        return {}, f"not scored: {complaint(error, run.file)}"
    return {kind: replace(one, share=scores.share_of(kind)) if (one := scores.graded(kind)) else
            unscored(kind, "no number in common with the reference before the horizon") for kind in GRADED}, ""
