"""The collation of a round: every file of every code read once, and the table of numbers."""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ldbench import Error
from ldbench.results.header import read_header
from ldbench.tools import PROCESS_DIED, processes, write_frame

from .jumps import is_rigid
from .kept_entries import Entry, Work, failed_entry, keep, kept, key_of, make_entry, program
from .own_runs import own_run, write_rigid_run
from .round_grades import ROW_ENDINGS, Reference, read_reference, reference_of, row_of
from .round_numbers import SI, VERDICTS, names_of
from .scores import GRADED, Score, unscored
from .submissions import Submission, find_submissions, printable
from .tasks import TASKS, Task

LARGE = 30_000_000          # from which the files that are read at the same time are limited by memory [bytes]
PER_BYTE = 6                # of memory, while a file is read
MEMORY = 1_300_000_000      # for files that are read at the same time [bytes]


@dataclass(frozen=True)
class Collation:
    """All codes of a round."""

    codes: tuple[Submission, ...]
    entries: Mapping[tuple[str, Task], Entry]           # by the name of the code and simulation
    remarks: tuple[str, ...] = ()                       # about what is no code
    computed: tuple[tuple[str, Task], ...] = ()         # that were not kept
    tasks: tuple[Task, ...] = field(default=TASKS)
    referred: tuple[Task, ...] = ()                     # that have a reference
    reference: str = ""                                 # the name of its folder
    rigid: frozenset[tuple[str, Task]] = frozenset()    # that are scored against our own run with rigid contacts

    def entry(self, code: Submission, task: Task) -> Entry | None:
        """What is known of a simulation of a code; None where the code has not submitted it."""
        return self.entries.get((code.name, task))

    def value(self, code: Submission, task: Task, number: str) -> float:
        """A number, SI; NaN where there is none."""
        entry = self.entry(code, task)
        return entry.numbers[number].value if entry and number in entry.numbers else np.nan

    def grade(self, code: Submission, task: Task, kind: str) -> Score:
        """A difference from the reference by its kind of GRADED, or why there is none."""
        entry = self.entry(code, task)
        why = "not submitted" if entry is None else entry.error or \
            ("" if task in self.referred else "the reference has no file of this simulation") or entry.unscored
        return unscored(kind, why) if entry is None or kind not in entry.grades else entry.grades[kind]

    def against(self, code: Submission, task: Task) -> str:
        """What a simulation of a code is scored against, in words; '' for the reference."""
        return f"our own run with rigid contacts, restitution {code.restitution:g}" if (code.name, task) in self.rigid else ""

    def median(self, task: Task, number: str) -> float:
        """The median of a number over the codes that have it; NaN where none has."""
        known = [x for code in self.codes if np.isfinite(x := self.value(code, task, number))]
        return float(np.median(known)) if known else np.nan

    def lines(self) -> list[str]:
        """What could not be used, a line each: the code, the file or simulation, and why."""
        found = list(self.remarks)
        for code in self.codes:
            found += [f"{code.name}: {remark}" for remark in code.remarks]
            found += [f"{code.name}: {line}" for task in self.tasks if (entry := self.entry(code, task))
                      for line in (entry.error, entry.unscored) if line]
        return found

    @property
    def used(self) -> int:
        """How many files could be used."""
        return sum(not entry.error for entry in self.entries.values())


def collate(folder: Path, store: Path, jobs: int | None = None, leave_out: Path | None = None,
            done: Callable[[], object] = lambda: None, references: Mapping[Task, Reference] | None = None) -> Collation:
    """Read a folder of codes, but for what `store`, a folder that is there, keeps of an earlier time.

    jobs: files that are read at the same time. leave_out: a folder that is no code. done: called after each file.
    references: what the files of a simulation are scored against. Error if the folder cannot be read, or a reference that is
    needed.
    """
    codes, remarks = find_submissions(folder, leave_out)
    references = references or {}
    rigid = rigid_references(codes, references, store)
    work = [Work(code.name, task, file, code.map, code.seconds.get(task.name, np.nan),
                 rigid.get((code.name, task), references.get(task))) for code in codes for task, file in code.files.items()]
    entries = {(code.name, task): entry for code in codes for task, entry in kept(store, code.name, code.files).items()}
    program()       # once, before processes begin
    work = [replace(one, key="" if isinstance(key, Error) else key)
            for one, key in zip(work, side_by_side(key_of, work, jobs), strict=True)]
    new = [one for one in work if not one.key or (entry := entries.get((one.code, one.task))) is None or entry.key != one.key]
    # Threads of OpenMP do not outlive a fork, so our own runs are computed before.
    for task in sorted({one.task for one in new if one.map is None and needs_map(one.file)}, key=TASKS.index):
        own_run(task)
    for reference in {one.reference.key: one.reference for one in new if one.reference}.values():
        read_reference(reference)       # once for all processes, and an Error here is that of no code
    found: dict[tuple[str, Task], Entry] = {}
    for group, at_once in by_memory(new, jobs):
        for one, entry in zip(group, side_by_side(make_entry, group, at_once), strict=True):
            found[one.code, one.task] = failed_entry(one.task, "", f"{printable(one.file.name)}: {entry}") \
                if isinstance(entry, Error) else entry
            done()
    ordered = {(one.code, one.task): found.get((one.code, one.task)) or entries[one.code, one.task] for one in work}
    for code in codes:
        mine = {task: ordered[code.name, task] for task in code.files}
        if any((code.name, task) in found for task in mine):
            keep(store, code.name, mine)
    return Collation(tuple(codes), ordered, tuple(remarks), tuple((one.code, one.task) for one in new),
                     referred=tuple(task for task in TASKS if task in references),
                     reference=next((printable(one.file.resolve().parent.name, 40) for one in references.values()), ""),
                     rigid=frozenset(rigid))


def rigid_references(codes: Sequence[Submission], references: Mapping[Task, Reference],
                     store: Path) -> dict[tuple[str, Task], Reference]:
    """Our own runs with rigid contacts for the codes that tell their restitution, where the reference is elastic, by code and
    simulation. Error where a reference cannot be read."""
    told = [(code.name, task, code.restitution) for code in codes if code.restitution is not None for task in code.files
            if task in references]
    elastic = {task for _, task, _ in told if not is_rigid(read_reference(references[task]), task)}
    return {(name, task): reference_of(task, write_rigid_run(store/"rigid", task, restitution, program()), None)
            for name, task, restitution in told if task in elastic}


def side_by_side(work: Callable[[Work], Any], tasks: Sequence[Work], jobs: int | None) -> list[Any]:
    """The results of some work in the order of the tasks, the largest file first.

    Where a process ends that worked on a file, as systems end what takes too much memory, the files that it left are taken once
    more, each by a process of its own; then the result is the Error.
    """
    order = sorted(range(len(tasks)), key=lambda k: -tasks[k].size)
    if not order:
        return []
    with processes(jobs, len(order)) as pool:
        asked = {k: pool.submit(work, tasks[k]) for k in order}
        found = {k: result_or_error(asked[k].result) for k in order}
    for k in order:
        if isinstance(found[k], Error):
            with processes(1, 1) as pool:
                found[k] = result_or_error(pool.submit(work, tasks[k]).result)
    return [found[k] for k in range(len(tasks))]


def result_or_error(result: Callable[[], Any]) -> Any:
    """A result, or the Error instead of it."""
    try:
        return result()
    except BrokenExecutor:
        return Error(PROCESS_DIED)
    except Error as error:
        return error


def needs_map(file: Path) -> bool:
    """Whether a file lacks ldbench's header."""
    try:
        return not read_header(file).settings
    except (Error, OSError, ValueError):
        return False


def by_memory(work: Sequence[Work], jobs: int | None) -> list[tuple[list[Work], int | None]]:
    """The files in groups, each with how many may be read at the same time."""
    large = [one for one in work if one.size > LARGE]
    small = [one for one in work if one.size <= LARGE]
    found: list[tuple[list[Work], int | None]] = []
    if large:
        fitting = max(1, int(MEMORY/(PER_BYTE*max(one.size for one in large))))
        found.append((large, min(fitting, jobs) if jobs else fitting))
    return [*found, (small, jobs)] if small else found


def write_csv(found: Collation, target: Path) -> None:
    """Write a row for each code, simulation and number, SI units; the rows of a code depend on no other code."""
    import pandas as pd

    rows: list[tuple[str, str, str, float | None, str, str]] = []
    for code in found.codes:
        for task in found.tasks:
            entry = found.entry(code, task)
            missing = "not submitted" if entry is None else entry.error
            for name in names_of(task):
                number = entry.numbers.get(name) if entry else None
                value = number.value if number else np.nan
                rows.append((code.name, task.name, name, value, SI[name], (number.reason if number else "") or
                             ("" if np.isfinite(value) else missing or "not computed")))
            for kind, ending in product(GRADED, ROW_ENDINGS) if found.referred else ():
                value, why = row_of(found.grade(code, task, kind), ending)
                rows.append((code.name, task.name, f"score_{kind}{ending}", value, "1",
                             why or (found.against(code, task) if not ending else "")))
            for name in VERDICTS.values():
                count = entry.verdict.get(name) if entry else None
                rows.append((code.name, task.name, f"checks_{name}", count, "1", "" if count is not None else missing))
    write_frame(pd.DataFrame(rows, columns=["code", "simulation", "number", "value", "unit", "remark"]), target)
