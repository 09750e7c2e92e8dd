"""Files of one code for the ten simulations, and their reader."""
from __future__ import annotations

from pathlib import Path
from typing import Any

from .._core.errors import Error
from ..results.run_data import RunData, read_data
from .call import Task, task_of
from .check import ENDINGS, own_run
from .guess import guess_map


def read_submitted(file: Path, task: Task, map: Any = None) -> RunData:
    """Read a file of any code; the map of another code's columns is guessed where none is given. Error where it cannot be read."""
    run = read_data(file, map)
    if run.header.settings or map is not None:
        return run
    return read_data(file, guess_map(file, own_run(task)).map)


def files_of(folder: Path) -> dict[Task, Path]:
    """The files of a folder by the simulation that their names speak of; Error where two speak of the same one."""
    found: dict[Task, Path] = {}
    for file in sorted(folder.iterdir()):
        task = task_of(file) if file.suffix.lower() in ENDINGS else None
        if task in found:
            raise Error(f"{file}: expected one file for {task.words}, found {found[task].name}, too")
        if task is not None:
            found[task] = file
    return found
