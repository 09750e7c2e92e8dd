"""What an ensemble runs: its members, and what is kept of each run."""
from __future__ import annotations

import functools
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._core.calls import Progress, descriptions
from .._core.errors import BadValue, Error, unknown
from .._core.files import digest
from .._core.kept import program_digest
from ..case import Case, Value, Variable, find_variable, find_variables, variables
from ..results.events import Event, event_kinds
from ..runs import Run, compute
from ..table import FREE_GROUPS, FREE_NAMES, ContactTable

Record = dict[str, Any]              # what is kept of a run, by name; of one that failed its `error` alone
Batch = dict[str, np.ndarray]           # records of some members, by name, the first axis over members
TableKey = tuple[object, ...]
Coordinates = dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]

OCCURRENCES = 5                         # of each kind of event that a run lists
EVENTS = "event_time", "event_force"


@dataclass(frozen=True)
class Member:
    """One run of an ensemble: a case with other values of some variables. Small: the case is many members'."""

    base: Case
    changes: tuple[tuple[str, Value], ...] = ()

    def case(self) -> Case:
        """Raises Error where the values are refused."""
        return self.base.replace(dict(self.changes)) if self.changes else self.base

    def unchecked(self) -> Case:
        """The case before its values are checked, for names and keys; the common case where they are no values at all."""
        try:
            return self.base._with(dict(self.changes))
        except Error:
            return self.base


@dataclass(frozen=True)
class Wanted:
    """What is kept of a run beside its results and events."""

    columns: tuple[str, ...] = ()
    rows: int | None = None     # at most


# What to run ------------------------------------------------------------------------------

def plan(case: Case | Sequence[Case], over: dict[str, Sequence[Value]], n: int | None, seed: int, draw: str,
          ) -> tuple[Sequence[Member], dict[str, int], Coordinates]:
    """The members; sizes of the dimensions; coordinates."""
    if not isinstance(case, Case):
        if over or n is not None:
            raise BadValue("ensemble: expected one case with `over` and n, found a list of cases")
        if not case:
            raise BadValue("ensemble: expected at least one case, found none")
        return [Member(each) for each in case], {"member": len(case)}, {}
    find_variables(over)
    if n is None:
        values: Sequence[tuple[Value, ...]] = list(itertools.product(*over.values()))
        if not values:
            raise BadValue("ensemble: expected at least one value of every variable, found none")
        dims = {name: len(listed) for name, listed in over.items()}
        coordinates: Coordinates = {name: ((name,), np.array(listed), _described(name)) for name, listed in over.items()}
    else:
        values = draws(over, n, seed, draw)
        dims = {"member": n}
        coordinates = {name: (("member",), np.array(drawn), _described(name))
                       for name, drawn in zip(over, zip(*values, strict=True), strict=True)}
    return Variations(case, tuple(over), values), dims, coordinates


@dataclass(frozen=True)
class Variations(Sequence[Member]):
    """A case with each of many values, of which a member is made when it is asked for."""

    base: Case
    names: tuple[str, ...]
    values: Sequence[tuple[Value, ...]]

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, k: int) -> Member:    # type: ignore[override]  # no slices
        return Member(self.base, tuple(zip(self.names, self.values[k], strict=True)))


def draws(over: Mapping[str, Sequence[Value]], n: int, seed: int, draw: str) -> list[tuple[float, ...]]:
    """n points of the box with the sides (low, high).

    'even' is the additive recurrence of Roberts (2018) with the root of x^(d+1) = x + 1, shifted at random.
    """
    if draw not in ("random", "even"):
        raise BadValue(f"ensemble: expected draw = 'random' or 'even', found {draw!r}")
    for name, side in over.items():
        if len(side) != 2 or any(isinstance(x, str) for x in side):
            raise BadValue(f"ensemble: expected a range (low, high) of {name} to draw from, found {side!r}")
    if not over or not 1 <= n < 2**31:
        raise BadValue(f"ensemble: expected at least one range and 1 to {2**31 - 1} draws, found {len(over)} and {n}")
    if seed < 0:
        raise BadValue(f"ensemble: expected a seed from 0, found {seed}")
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
    """Raise Error where a wanted column does not exist or has the name of a variable, or where too few rows are wanted."""
    known = descriptions()[0].split()
    for name in wanted.columns:
        if name not in known:
            raise unknown(f"ensemble: expected columns among {', '.join(known)}", name, known)
        if name in over:
            variable = variables()[find_variable(name)]
            raise BadValue(f"ensemble: {name} is both a column and a variable of the case: call the latter "
                        f"{variable.group}_{variable.name}")
    if wanted.rows is not None and wanted.rows < 2:
        raise BadValue(f"ensemble: expected rows of at least 2, found {wanted.rows}")


def table_key(case: Case, contents: Callable[[str], str]) -> TableKey:
    """Equal for cases that share a contact table; `contents`: what stands for that of a file."""
    files = case.profile_files()
    profiles = [contents(files.get(f"{which}_right", files[which]) if right else files[which])
                for right in (False, True) for which in ("wheel_profile", "rail_profile")]
    return (*(value for variable, value in zip(variables(), case.values, strict=True) if of_table(variable)), *profiles)


def of_table(variable: Variable) -> bool:
    """Whether the contact table depends on a variable."""
    return variable.group not in FREE_GROUPS and variable.name not in FREE_NAMES


def contents(path: str) -> str:
    """The digest of a file; the empty text where it cannot be read."""
    try:
        return digest(Path(path).read_bytes())
    except OSError:
        return ""               # the run will say so


class TableKeys:
    """Keys of the members' contact tables, kept, because most variables do not affect the table."""

    def __init__(self) -> None:
        self.contents = functools.cache(contents)
        self.known: dict[tuple[object, ...], TableKey] = {}

    def __call__(self, member: Member) -> TableKey:
        """The key of the table of a member."""
        what = id(member.base), tuple(change for change in member.changes if matters(change[0]))
        if what not in self.known:
            self.known[what] = table_key(member.unchecked(), self.contents)
        return self.known[what]


@functools.cache
def matters(name: str) -> bool:
    """Whether the contact table or its file depends on a variable."""
    variable = variables()[find_variable(name)]
    return of_table(variable) or variable.kind == "text"


def keys_of(members: Sequence[Member], wanted: Wanted) -> list[str]:
    """The key of each member; it changes with anything that the result depends on."""
    table = TableKeys()
    tail = json.dumps([program_digest(), wanted.columns, wanted.rows])

    def key(member: Member) -> str:
        case = member.unchecked()
        refused = member.changes if case is member.base else ()
        return digest((json.dumps([case.values, refused, table(member)], default=str) + tail).encode())

    return [key(member) for member in members]


@dataclass(frozen=True)
class Group:
    """Members that share a contact table."""

    case: Case                  # whose contact table the group shares, with its table file if it has one
    numbers: list[int]


def groups_of(members: Sequence[Member], numbers: Iterable[int], base: Case | None = None,
              ) -> tuple[list[Group], list[int]]:
    """The numbered members by table, and those of which all that would share one are refused.

    A table file holds the table of the first case that names it, `base` before all.
    """
    key = TableKeys()
    files = {base.table_file: key(Member(base))} if base else {}
    found: dict[TableKey, list[int]] = {}
    for number in numbers:
        found.setdefault(key(members[number]), []).append(number)
    groups: list[Group] = []
    refused: list[int] = []
    for table, own in found.items():
        if case := _first_case((members[number] for number in own), files, table):
            groups.append(Group(case, own))
        else:
            refused += own
    return groups, refused


def _first_case(members: Iterable[Member], files: dict[str, TableKey], table: TableKey) -> Case | None:
    for member in members:
        try:
            case = member.case()
        except Error:
            continue
        return case if files.setdefault(case.table_file, table) == table else case.replace(table_file="")
    return None


# One run ----------------------------------------------------------------------------------

def run_member(member: Member, table: ContactTable | None, wanted: Wanted, progress: Progress | None = None,
               place: Callable[[Case], Case] = lambda case: case) -> Record:
    """Run a member, its case after `place`; without a table: one whose values are refused."""
    try:
        # Rows at equal intervals are common to all members.
        return record(compute(place(member.case()).replace(rows="interval"), progress, table), wanted)
    except Error as error:
        return {"error": str(error)}


def record(done: Run, wanted: Wanted) -> Record:
    """Results, events and wanted columns of a run."""
    found: Record = {name: value if isinstance(value, (bool, str)) else float(value) for name, value in done.results.items()}
    found |= dict(zip(EVENTS, _event_tables(done.events), strict=True))
    if wanted.columns:
        n = len(done.data)
        rows = np.arange(n)
        if wanted.rows and n > wanted.rows:
            rows = np.linspace(0, n - 1, wanted.rows).round().astype(int)
        # Elastic contacts have no impulses.
        found |= {name: done.data[name].to_numpy()[rows] if name in done.data else np.full(len(rows), np.nan)
                  for name in wanted.columns}
    return found | {"error": ""}


def _event_tables(events: Iterable[Event]) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] and lateral forces [N], shape (kind, occurrence)."""
    kinds = event_kinds()
    times, forces = np.full((2, len(kinds), OCCURRENCES), np.nan)
    counts = dict.fromkeys(kinds, 0)
    for event in events:
        place = kinds.index(event.kind), counts[event.kind]
        counts[event.kind] += 1
        if place[1] < OCCURRENCES:
            times[place], forces[place] = event.t, event.force
    return times, forces


# Many of them -----------------------------------------------------------------------------

def stack(records: Sequence[Record]) -> Batch:
    """Records as arrays. Rows of columns are padded with NaN; what failed has NaN, False and ''."""
    names = next((list(r) for r in records if not r["error"]), ["error"])
    rows = max((len(r["time"]) for r in records if "time" in r), default=0)
    of_rows, batch = row_names(), {}
    for name in names:
        like = next(r[name] for r in records if name in r)
        if name in of_rows:
            batch[name] = np.array([_padded(r.get(name, ()), rows) for r in records])
            continue
        blank = np.full_like(like, np.nan) if isinstance(like, np.ndarray) else _blank(type(like))
        batch[name] = np.array([r.get(name, blank) for r in records])
    return batch


def join(batches: Sequence[Batch]) -> Batch:
    """Batches one after another."""
    names = dict.fromkeys(name for batch in batches for name in batch)
    of_rows, joined = row_names(), {}
    for name in names:
        like = next(batch[name] for batch in batches if name in batch)
        inner = like.shape[1:]
        if name in of_rows:
            inner = (max(batch[name].shape[1] for batch in batches if name in batch),)
        blank = _blank({"f": float, "b": bool, "U": str}[like.dtype.kind])
        parts = []
        for batch in batches:
            part = batch.get(name)
            if part is None or part.shape[1:] != inner:
                whole = np.full((len(batch["error"]), *inner), blank)
                if part is not None:
                    whole[:, :part.shape[1]] = part
                part = whole
            parts.append(part)
        joined[name] = np.concatenate(parts)
    return joined


def row_names() -> set[str]:
    """The names of the columns, which are arrays over rows."""
    return set(descriptions()[0].split())


def _blank(kind: type) -> Value:
    return False if kind is bool else "" if kind is str else np.nan


def _padded(values: Sequence[float], n: int) -> np.ndarray:
    return np.concatenate([values, np.full(n - len(values), np.nan)])
