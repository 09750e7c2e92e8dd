"""The collation of a round: every file of every code read once, and the table of numbers."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future
from dataclasses import dataclass, field, replace
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from ldbench import Error
from ldbench.results.header import read_comments
from ldbench.tools import PROCESS_DIED, processes, usable_cores, write_frame

from .jumps import is_rigid
from .kept_entries import (
    Entry,
    Reference,
    Work,
    failed_entry,
    keep,
    kept,
    key_of,
    make_entry,
    program,
    read_reference,
    reference_of,
)
from .own_runs import own_run, write_rigid_run
from .round_numbers import SI, VERDICTS, names_of
from .scores import GRADED, GRADES, Score, unscored
from .submissions import Submission, complaint, find_submissions, printable
from .tasks import TASKS, Task

LARGE = 30_000_000          # from which the files that are read at the same time are limited by memory [bytes]
PER_BYTE = 6                # of memory, while a file is read
MEMORY = 1_300_000_000      # for files that are read at the same time [bytes]
#: What the table tells of each kind of score: the difference, its grade, its share of the spread of formulations, what was scored.
ROW_ENDINGS = "", "_grade", "_of_spread", "_share"


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
            references: Mapping[Task, Reference] | None = None) -> Collation:
    """Read a folder of codes, but for what `store`, a folder that is there, keeps of an earlier time.

    jobs: files that are read at the same time. leave_out: a folder that is no code. references: what the files of a simulation are
    scored against. Error if the folder cannot be read, or a reference that is needed.
    """
    codes, remarks = find_submissions(folder, leave_out)
    references = references or {}
    rigid = rigid_references(codes, references, store)
    found: dict[tuple[str, Task], Entry] = {}
    new: list[Work] = []
    computed: list[tuple[str, Task]] = []
    for code in codes:
        earlier = kept(store, code.name, code.files)
        for task, file in code.files.items():
            place = code.name, task
            one = Work(*place, file, code.map, code.seconds.get(task.name, np.nan), rigid.get(place, references.get(task)))
            try:
                one = replace(one, key=key_of(one))
            except Error as error:
                found[place] = failed_entry(one, complaint(error, file))
            if task in earlier and earlier[task].key == one.key:
                found[place] = earlier[task]
                continue
            computed.append(place)
            if one.key:
                new.append(one)
    # Threads of OpenMP do not outlive a fork, so our own runs are computed before.
    for task in sorted({one.task for one in new if one.map is None and needs_map(one.file)}, key=TASKS.index):
        own_run(task)
    for reference in {one.reference.key: one.reference for one in new if one.reference}.values():
        read_reference(reference)       # once for all processes, and an Error here is that of no code
    for group in [one for one in new if one.size > LARGE], [one for one in new if one.size <= LARGE]:
        found |= make_entries(group, jobs)
    for code in codes:
        if any(name == code.name for name, _ in computed):
            keep(store, code.name, {task: found[code.name, task] for task in code.files})
    ordered = {(code.name, task): found[code.name, task] for code in codes for task in code.files}
    return Collation(tuple(codes), ordered, tuple(remarks), tuple(computed), referred=tuple(t for t in TASKS if t in references),
                     reference=next((printable(one.file.resolve().parent.name, 40) for one in references.values()), ""),
                     rigid=frozenset(rigid))


def rigid_references(codes: Sequence[Submission], references: Mapping[Task, Reference],
                     store: Path) -> dict[tuple[str, Task], Reference]:
    """Our own runs with rigid contacts for the codes that tell their restitution, where the reference is elastic, by code and
    simulation. Error where a reference cannot be read."""
    told = [(code.name, task, code.restitution) for code in codes if code.restitution is not None for task in code.files
            if task in references]
    elastic = {task for _, task, _ in told if not is_rigid(read_reference(references[task]), task)}
    return {(name, task): reference_of(task, write_rigid_run(store/"rigid", task, restitution, program()))
            for name, task, restitution in told if task in elastic}


def make_entries(work: Sequence[Work], jobs: int | None) -> dict[tuple[str, Task], Entry]:
    """The entries of files of a like size, the largest file first, as many at the same time as fit into memory.

    Where a process ends that worked on a file, as systems end what takes too much memory, the files that it left are taken once
    more, each by a process of its own.
    """
    order = sorted(work, key=lambda one: -one.size)
    if not order:
        return {}
    fitting = max(1, int(MEMORY/(PER_BYTE*max(order[0].size, 1))))
    with processes(min(jobs or usable_cores(), fitting), len(order)) as pool:
        first = [finished(future) for future in [pool.submit(make_entry, one) for one in order]]
    found: dict[tuple[str, Task], Entry] = {}
    for one, entry in zip(order, first, strict=True):
        if entry is None:
            with processes(1, 1) as pool:
                entry = finished(pool.submit(make_entry, one))
        found[one.code, one.task] = entry or failed_entry(one, f"{printable(one.file.name)}: {PROCESS_DIED}")
    return found


def finished(asked: Future[Entry]) -> Entry | None:
    """The result of a process; None where it ended before."""
    try:
        return asked.result()
    except BrokenExecutor:
        return None


def needs_map(file: Path) -> bool:
    """Whether a file lacks ldbench's header."""
    try:
        return not read_comments(file).settings
    except (Error, OSError, ValueError):
        return False


def row_of(one: Score, ending: str) -> tuple[float, str]:
    """The value of a row of the table, and why it is NaN. ending: of the name of the row."""
    if np.isnan(one.difference):
        return np.nan, one.reason or "no difference is known"
    value, why = {"": (one.difference, ""), "_share": (one.share, ""),
                  "_grade": (np.nan if one.grade is None else one.grade, f"beyond {GRADES[-1]:g}"),
                  "_of_spread": (one.of_spread, "the spread of this quantity is not known")}[ending]
    return value, "" if np.isfinite(value) else why


def write_csv(found: Collation, target: Path) -> None:
    """Write a row for each code, simulation and number, SI units; the rows of a code depend on no other code."""
    rows: list[tuple[str, str, str, float | None, str, str]] = []
    for code, task in product(found.codes, found.tasks):
        entry = found.entry(code, task)
        missing = "not submitted" if entry is None else entry.error
        for name in names_of(task):
            number = entry.numbers.get(name) if entry else None
            value, why = number or (np.nan, missing or "not computed")
            rows.append((code.name, task.name, name, value, SI[name], why))
        for kind, ending in product(GRADED, ROW_ENDINGS) if found.referred else ():
            value, why = row_of(found.grade(code, task, kind), ending)
            rows.append((code.name, task.name, f"score_{kind}{ending}", value, "1",
                         why or ("" if ending else found.against(code, task))))
        for name in VERDICTS.values():
            count = entry.verdict.get(name) if entry else None
            rows.append((code.name, task.name, f"checks_{name}", count, "1", "" if count is not None else missing))
    write_frame(pd.DataFrame(rows, columns=["code", "simulation", "number", "value", "unit", "remark"]), target)
