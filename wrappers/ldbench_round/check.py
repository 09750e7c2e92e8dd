"""Whether a submission says what the call asks for, and whether physics agrees with it.

No reference is needed for a finding: mass, weight and inertia are those of the call, and the rest are laws. Our own run of
the simulation serves the map of the columns alone.
"""
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ldbench import Case, Error
from ldbench.results.columns import converted, read_raw
from ldbench.results.header import read_comments
from ldbench.results.quantities import quantity
from ldbench.results.run_data import RunData, read_data

from .cell_checks import cell_findings
from .column_names import understood
from .drift_checks import TIME_ERROR
from .findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding, listed
from .languages import encoding_of
from .map_guess import AXES, SURE, Guess, guess_map, side_sign
from .own_runs import own_run
from .physics_checks import law_findings
from .row_times import spread_times
from .submissions import complaint, find_files, is_device, quiet
from .tasks import QUANTITIES, TASKS, Task, task_named, task_of


@dataclass(frozen=True)
class Checked:
    """The findings about one file."""

    file: Path
    task: Task
    guess: Guess | None             # None: the file has ldbench's header
    findings: tuple[Finding, ...]


def check_file(file: Path, task: Task | None = None, map: Any = None) -> Checked:
    """Check a column file of any code. task: the simulation, by default that of the file's name or of ldbench's header. map: a
    column map, a path or a mapping, by default guessed. Error if the file cannot be read, or if neither says which simulation it
    is."""
    one = read_submitted(file, task, map)
    return Checked(file, one.task, one.guess, findings_of(one))


@dataclass(frozen=True)
class SubmittedFile:
    """A file of any code with columns of ours."""

    task: Task
    run: RunData
    guess: Guess | None             # of the map; None where a map was given or the file has ldbench's header
    rounded: str = ""               # what was done to times of few digits; '' where nothing was


@quiet()
def read_submitted(file: Path, task: Task | None = None, map: Any = None) -> SubmittedFile:
    """Read a file of any code, once, and guess its map where it needs one and none is given.

    Arguments and errors are those of `check_file`.
    """
    if is_device(file):
        raise Error(file=file, expected="a file", found="a device or a pipe")
    comments = read_comments(file)
    task = task or task_of(file) or next((one for one in TASKS if one.name == comments.header.name), None)
    if task is None:
        raise Error(file=file, expected="a name or a header that says the simulation, as ex2_aw, or --simulation", found="neither")
    if comments.settings or map is not None:
        return SubmittedFile(task, read_data(file, map), None)
    (raw, error, rounded), own = spread_times(read_raw(file, encoding_of(file, understood))), own_run(task)
    # Our own run of exercise 5 is its first seconds alone.
    guess = guess_map(file, own, raw, Case.exercise(5, task.profiles).t_end if task.exercise == 5 else float(np.ptp(own.time)))
    data = converted(file, raw, guess.map)
    data.attrs[TIME_ERROR] = error
    return SubmittedFile(task, RunData(file, comments=comments, data=data), guess, rounded)


def guessed_map(file: Path, simulation: str = "") -> dict[str, dict[str, Any]] | None:
    """The map of the columns of a file without ldbench's header; None where neither the name of the file nor `simulation` says
    which simulation it is."""
    task = task_named(simulation) if simulation else task_of(file)
    guess = read_submitted(file, task).guess if task else None
    return guess.map if guess else None


@quiet()
def findings_of(one: SubmittedFile) -> tuple[Finding, ...]:
    """All findings about a file that was read."""
    case = Case.exercise(one.task.exercise, one.task.profiles)
    found = (*(map_findings(one.guess) if one.guess else ()), *column_findings(one.run),
             Finding("digits of the times", DOUBTFUL if one.rounded else PASSED, hint=one.rounded),
             *law_findings(one.run, case, one.task))
    return tuple(each if each.row is None else replace(each, time=float(one.run.time[each.row - 1])) for each in found)


def check_folder(folder: Path, map: Any = None) -> tuple[list[Checked], list[Finding]]:
    """Check the files of a folder whose names speak of a simulation, and say which of the ten are missing.

    A file that cannot be read is a finding and does not stop the others; files that are left out are told and do not fail.
    """
    left_out: list[str] = []
    found = find_files(folder, left_out)
    missing = [task.words for task in TASKS if task not in found]
    folder_findings = [Finding("ten files", FAILED if missing else PASSED, len(found), len(TASKS),
                               hint=f"missing: {listed(missing)}" if missing else "", items=tuple(missing)),
                       *(Finding("file", UNKNOWN, hint=line) for line in left_out)]
    checked = []
    for task, file in found.items():
        try:
            checked.append(check_file(file, task, map))
        except Exception as error:
            checked.append(Checked(file, task, None, (Finding("file", FAILED, hint=complaint(error, file)),)))
    return checked, folder_findings


def map_findings(guess: Guess) -> Iterator[Finding]:
    """What the map says about frame, units and names."""
    matches = guess.matches
    wrong = [f"{m.name} says {m.said}, its numbers are in {m.unit}" for m in matches.values() if m.said and m.said != m.unit]
    yield Finding("units", FAILED if wrong else PASSED, len(wrong), 0, hint=listed(wrong), items=tuple(wrong))
    for words, sense in FRAME.items():
        signs = {column: side_sign(matches[column])*matches[column].sign for column in AXES[words] if column in matches}
        if not signs:
            continue
        turned = [column for column, sign in signs.items() if sign != signs[next(iter(signs))]]
        most = sum(signs.values()) < 0
        if turned:
            odd = [matches[c].name for c in signs if (signs[c] < 0) != most] or [matches[c].name for c in turned]
            yield Finding(f"{words} axis", FAILED, len(odd), 0,
                          hint=f"{listed(odd)}: the sign is another one than that of the other columns", items=tuple(odd))
        else:
            yield Finding(f"{words} axis", DOUBTFUL if most and sense else PASSED,
                          hint=f"positive {sense}; the call has the opposite" if most and sense else "")
    by_name = unlike(guess)
    yield Finding("columns behave as their names say", DOUBTFUL if by_name else PASSED, len(by_name), 0,
                  hint=f"recognised by the name alone: {listed(by_name)}" if by_name else "", items=tuple(by_name))
    if matches["time"].offset:
        yield Finding("zero of time", DOUBTFUL, -matches["time"].offset, 0,
                      hint="the first row is not at t = 0; the map shifts the time")


def unlike(guess: Guess) -> list[str]:
    """Columns that were recognised by their names alone. Codes touch the right flange at other times and with other forces, and
    exercise 5 hardly ever: the laws judge its columns."""
    return [m.name for column, m in guess.matches.items() if m.likeness < SURE and not column.endswith("_RF")]


FRAME = {"lateral": "to the right", "vertical": "downwards", "roll": "for a wheelset whose left wheel goes down",
         # Forces of the wheel on the rail, and the signs of contact angles, are conventions that the call leaves open.
         "lateral force": "", "vertical force": "", "left contact angle": "", "right contact angle": ""}


def column_findings(run: RunData) -> Iterator[Finding]:
    """Which quantities of the call the file has."""
    missing = [quantity(column).words for column in QUANTITIES if column not in run.data]
    yield Finding("quantities", FAILED if missing else PASSED, len(QUANTITIES) - len(missing), len(QUANTITIES),
                  hint=f"missing, or not recognised: {listed(missing)}" if missing else "", items=tuple(missing))
    if doubt := run.data.attrs.get("doubt"):
        yield Finding("commas", DOUBTFUL, hint=f"'{doubt}' is read with a decimal comma; write numbers without marks of thousands")
    yield from cell_findings(run)
