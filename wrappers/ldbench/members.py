"""What an ensemble runs: its members, and what is kept of each run."""
from __future__ import annotations

import functools
import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from . import _flat
from ._core import Error, Progress, descriptions, digest
from .case import Case, Value, find_variable, variables
from .run import Event, Run, _event_kinds, run
from .table import FREE_GROUPS, FREE_NAMES, ContactTable

Record = dict[str, object]              # what is kept of a run, by name; of one that failed its `error` alone
TableKey = tuple[object, ...]
Coordinates = dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]

OCCURRENCES = 5                         # of each kind of event that a run lists
EVENTS = "event_time", "event_force"
NOT_KEPT = "table_seconds", "seconds", "table_found"        # of the summary: not the same every time


@dataclass(frozen=True)
class Member:
    """One run of an ensemble."""

    number: int
    case: Case | None           # None where the values are refused
    key: str = ""               # changes with anything that the result depends on
    table: TableKey = ()        # equal for members that share a contact table
    in_file: bool = False       # whether that is the one that the case's table file holds
    error: str = ""

    @property
    def table_case(self) -> Case:
        """The case to build the table for."""
        return self.case if self.in_file else self.case.replace(table_file="")


@dataclass(frozen=True)
class Wanted:
    """What is kept of a run beside its summary and events."""

    columns: tuple[str, ...] = ()
    rows: int | None = None     # at most


# What to run ------------------------------------------------------------------------------

def plan(case: Case | Sequence[Case], over: dict[str, Sequence[Value]], n: int | None, seed: int, draw: str,
          ) -> tuple[list[Case | str], dict[str, int], Coordinates]:
    """The cases, or why one is refused; sizes of the dimensions; coordinates."""
    if not isinstance(case, Case):
        if over or n is not None:
            raise Error("ensemble: expected one case with `over` and n, found a list of cases")
        if not case:
            raise Error("ensemble: expected at least one case, found none")
        return list(case), {"member": len(case)}, {}
    for name in over:
        find_variable(name)
    if n is None:
        values = list(itertools.product(*over.values()))
        if not values:
            raise Error("ensemble: expected at least one value of every variable, found none")
        dims = {name: len(listed) for name, listed in over.items()}
        coordinates = {name: ((name,), np.array(listed), _described(name)) for name, listed in over.items()}
    else:
        values = draws(over, n, seed, draw)
        dims = {"member": n}
        coordinates = {name: (("member",), np.array(drawn), _described(name))
                       for name, drawn in zip(over, zip(*values, strict=True), strict=True)}

    def changed(changes: tuple[Value, ...]) -> Case | str:
        try:
            return case.replace(**dict(zip(over, changes, strict=True)))
        except Error as error:
            return str(error)

    return [changed(v) for v in values], dims, coordinates


def draws(over: Mapping[str, Sequence[float]], n: int, seed: int, draw: str) -> list[tuple[float, ...]]:
    """n points of the box with the sides (low, high).

    'even' is the additive recurrence of Roberts (2018) with the root of x^(d+1) = x + 1, shifted at random.
    """
    if draw not in ("random", "even"):
        raise Error(f"ensemble: expected draw = 'random' or 'even', found {draw!r}")
    for name, side in over.items():
        if len(side) != 2 or any(isinstance(x, str) for x in side):
            raise Error(f"ensemble: expected a range (low, high) of {name} to draw from, found {side!r}")
    if not over or n < 1:
        raise Error("ensemble: expected at least one range and one draw")
    generator, d = np.random.default_rng(seed), len(over)
    if draw == "random":
        unit = generator.random((n, d))
    else:
        root = 2.0
        for _ in range(60):
            root = (1 + root)**(1/(d + 1))
        unit = (generator.random(d) + np.outer(np.arange(n), root**-np.arange(1.0, d + 1))) % 1
    low, high = np.array(list(over.values()), float).T
    return [tuple(point) for point in (low + unit*(high - low)).tolist()]


def _described(name: str) -> dict[str, str]:
    variable = variables()[find_variable(name)]
    return {"units": variable.unit or "1", "long_name": variable.meaning}


def check_wanted(wanted: Wanted, over: Mapping[str, object]) -> None:
    known = descriptions()[0].split()
    for name in wanted.columns:
        if name not in known:
            raise Error(f"ensemble: expected columns among {', '.join(known)}, found {name}")
        if name in over:
            variable = variables()[find_variable(name)]
            raise Error(f"ensemble: {name} is both a column and a variable of the case: call the latter "
                        f"{variable.group}_{variable.name}")
    if wanted.rows is not None and wanted.rows < 2:
        raise Error(f"ensemble: expected rows of at least 2, found {wanted.rows}")


def members_of(cases: Sequence[Case | str], wanted: Wanted, base: Case | None = None) -> list[Member]:
    """The members. A table file holds the table of the first case that names it, `base` before all."""
    @functools.cache
    def contents(path: str) -> str:
        try:
            return digest(Path(path).read_bytes())
        except OSError:
            return ""           # the run will say so

    def profiles(case: Case) -> list[str]:
        files = case.profile_files()
        return [contents(files.get(f"{which}_right", files[which]) if right else files[which])
                for right in (False, True) for which in ("wheel_profile", "rail_profile")]

    def table_key(case: Case) -> TableKey:
        return (*(value for variable, value in zip(variables(), case.values, strict=True)
                  if variable.group not in FREE_GROUPS and variable.name not in FREE_NAMES), *profiles(case))

    files = {base.table_file: table_key(base)} if base else {}
    members: list[Member] = []
    for number, case in enumerate(cases):
        if isinstance(case, str):
            members.append(Member(number, None, error=case))
            continue
        table = table_key(case)
        key = json.dumps([case.values, table, core_digest(), wanted.columns, wanted.rows])
        members.append(Member(number, case, digest(key.encode()), table,
                              files.setdefault(case.table_file, table) == table))
    return members


@functools.cache
def core_digest() -> str:
    """Of the compiled core: another build's results are not taken for its own."""
    return digest(Path(_flat.__file__).read_bytes())


def by_table(members: Iterable[Member]) -> dict[TableKey, list[Member]]:
    groups: dict[TableKey, list[Member]] = {}
    for member in members:
        groups.setdefault(member.table, []).append(member)
    return groups


# One run ----------------------------------------------------------------------------------

def run_member(case: Case, table: ContactTable, wanted: Wanted, progress: Progress | None = None) -> Record:
    try:
        return record(run(case, progress, table), wanted)
    except Error as error:
        return {"error": str(error)}


def record(done: Run, wanted: Wanted) -> Record:
    """Summary, events and wanted columns of a run."""
    found = {name: value if isinstance(value, (bool, str)) else float(value)
             for name, value in done.summary.items() if name not in NOT_KEPT}
    found |= dict(zip(EVENTS, _event_tables(done.events), strict=True))
    if wanted.columns:
        n = len(done.columns)
        rows = np.arange(n)
        if wanted.rows and n > wanted.rows:
            rows = np.linspace(0, n - 1, wanted.rows).round().astype(int)
        # Elastic contacts have no impulses.
        found |= {name: done.columns[name].to_numpy()[rows] if name in done.columns else np.full(len(rows), np.nan)
                  for name in wanted.columns}
    return found | {"error": ""}


def _event_tables(events: Iterable[Event]) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and lateral forces [N], shape (kind, occurrence)."""
    kinds = _event_kinds()
    times, forces = np.full((2, len(kinds), OCCURRENCES), np.nan)
    counts = dict.fromkeys(kinds, 0)
    for event in events:
        place = kinds.index(event.kind), counts[event.kind]
        counts[event.kind] += 1
        if place[1] < OCCURRENCES:
            times[place], forces[place] = event.t, event.force
    return times, forces
