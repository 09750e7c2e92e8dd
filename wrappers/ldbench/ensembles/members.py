"""What an ensemble runs: its members, and what is kept of each run."""
from __future__ import annotations

import functools
import itertools
import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._core.calls import Progress, descriptions
from .._core.errors import BadValue, Error, unknown
from .._core.files import digest
from .._core.kept import program_digest
from ..case import Case, Value, find_variable, find_variables, variables
from ..results.events import event_kinds
from ..runs import Run, compute
from ..table import ContactTable, bound_places

Member = Case | str                 # a case before the core has checked its values, or why they are no values at all
Record = dict[str, Any]             # what is kept of a run, by name; of one that failed its `error` alone
TableKey = tuple[object, ...]       # equal for cases that share a contact table
Group = tuple[TableKey | None, Case | None, list[int]]
Coordinates = dict[str, tuple[str, np.ndarray, dict[str, str]]]

OCCURRENCES = 5                     # of each kind of event that a run lists
EVENTS = "event_time", "event_force"


class Wanted(NamedTuple):
    """What is kept of a run beside its results and events."""

    columns: tuple[str, ...] = ()
    rows: int | None = None     # at most


def plan(case: Case | Sequence[Case], over: Mapping[str, Sequence[Value]], n: int | None, seed: int, draw: str,
         ) -> tuple[list[Member], dict[str, int], Coordinates]:
    """The members; sizes of the dimensions; coordinates."""
    if not isinstance(case, Case):
        if over or n is not None:
            raise BadValue(place="ensemble", expected="one case with `over` and n", found="a list of cases")
        if not case:
            raise BadValue(place="ensemble", expected="at least one case", found="none")
        return list(case), {"member": len(case)}, {}
    known = {name: variables()[k] for name, k in zip(over, find_variables(over), strict=True)}
    if n is None:
        points: Sequence[tuple[Value, ...]] = list(itertools.product(*over.values()))
        dims, values = {name: len(listed) for name, listed in over.items()}, over
        if not points:
            raise BadValue(place="ensemble", expected="at least one value of every variable", found="none")
    else:
        points = draws(over, n, seed, draw)
        dims, values = {"member": n}, dict(zip(over, zip(*points, strict=True), strict=True))

    def member(point: tuple[Value, ...]) -> Member:
        try:
            return case._with(dict(zip(over, point, strict=True)))
        except Error as error:
            return str(error)

    coordinates: Coordinates = {name: (name if n is None else "member", np.array(listed), {
        "units": known[name].unit or "1", "long_name": known[name].meaning}) for name, listed in values.items()}
    return [member(point) for point in points], dims, coordinates


def draws(over: Mapping[str, Sequence[Value]], n: int, seed: int, draw: str) -> list[tuple[float, ...]]:
    """n points of the box with the sides (low, high).

    'even' is the additive recurrence of Roberts (2018) with the root of x^(d+1) = x + 1, shifted at random.
    """
    if draw not in ("random", "even"):
        raise BadValue(place="ensemble", expected="draw = 'random' or 'even'", found=f"{draw!r}")
    for name, side in over.items():
        if len(side) != 2 or any(isinstance(x, str) for x in side):
            raise BadValue(place="ensemble", expected=f"a range (low, high) of {name} to draw from", found=f"{side!r}")
    if not over or not 1 <= n < 2**31:
        raise BadValue(place="ensemble", expected=f"at least one range and 1 to {2**31 - 1} draws",
                       found=f"{len(over)} and {n}")
    if seed < 0:
        raise BadValue(place="ensemble", expected="a seed from 0", found=seed)
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


def check_wanted(wanted: Wanted, over: Iterable[str]) -> None:
    """Raise Error where a wanted column does not exist or has the name of a variable, or where too few rows are wanted."""
    known = descriptions()[0].split()
    for name in wanted.columns:
        if name not in known:
            raise unknown(f"columns among {', '.join(known)}", name, known, place="ensemble")
        if name in over:
            variable = variables()[find_variable(name)]
            raise BadValue(f"{name} is both a column and a variable of the case: call the latter "
                           f"{variable.group}_{variable.name}", place="ensemble")
    if wanted.rows is not None and wanted.rows < 2:
        raise BadValue(place="ensemble", expected="rows of at least 2", found=wanted.rows)


def table_keys() -> Callable[[Case], TableKey]:
    """The key of the table of a case: the values that the table depends on, and the contents of the profiles. Files are read once:
    they do not change while an ensemble runs."""
    @functools.cache
    def contents(path: str) -> str:
        with suppress(OSError):         # the run will say so
            return digest(Path(path).read_bytes())
        return ""

    def key(case: Case) -> TableKey:
        files = case.files()
        profiles = [contents(files.get(f"{which}{side}", files[which]))
                    for side in ("", "_right") for which in ("wheel_profile", "rail_profile")]
        return (*(case.values[k] for k in bound_places()), *profiles, contents(files["bodies"]) if "bodies" in files else "")

    return key


def keys_of(members: Sequence[Member], wanted: Wanted) -> list[str]:
    """The key of each member; it changes with anything that the result depends on."""
    table, tail = table_keys(), json.dumps([program_digest(), *wanted])
    return [digest((json.dumps([member] if isinstance(member, str) else [member.values, table(member)]) + tail).encode())
            for member in members]


def groups_of(members: Sequence[Member], missing: Iterable[int], base: Case | None = None) -> Iterator[Group]:
    """Members that share a contact table: its key, the case to build it for, None if all are refused, and their numbers. With
    `base`, what is solved for other tables than its own is not kept: a sweep of the gauge would leave a file for every value."""
    key = table_keys()
    found: dict[TableKey | None, list[int]] = {}
    for number in missing:
        member = members[number]
        found.setdefault(None if isinstance(member, str) else key(member), []).append(number)
    for table, numbers in found.items():
        case = next(filter(None, (accepted(members[number]) for number in numbers)), None)
        if case and base and table != key(base):
            case = case.replace(table_folder="")
        yield table, case, numbers


def accepted(member: Member) -> Case | None:
    """The case of a member; None where its values are refused."""
    with suppress(Error):
        return None if isinstance(member, str) else member.replace()
    return None


def run_member(member: Member, table: ContactTable | None, wanted: Wanted, progress: Progress | None = None,
               files: Mapping[str, str] = {}) -> Record:
    """The record of a member. files: the profiles in this process, by variable."""
    if isinstance(member, str):
        return {"error": member}
    try:
        # Rows at equal intervals are common to all members; without columns, each has those among which its largest pressure is.
        rows = {"rows": "interval"} if wanted.columns else {}
        return record(compute(member.replace({**files, **rows}), progress, table), wanted)
    except Error as error:
        return {"error": str(error)}


def record(done: Run, wanted: Wanted) -> Record:
    """Results, events and wanted columns of a run."""
    found: Record = {name: value if isinstance(value, (bool, str)) else float(value) for name, value in done.results.items()}
    found["end"] = done.ending
    times, forces = np.full((2, len(event_kinds()), OCCURRENCES), np.nan)     # [s], [N]
    for k, kind in enumerate(event_kinds()):
        for place, event in enumerate([event for event in done.events if event.kind == kind][:OCCURRENCES]):
            times[k, place], forces[k, place] = event.t, event.force
    found |= dict(zip(EVENTS, (times, forces), strict=True))
    if wanted.columns:
        n = len(done.data)
        rows = np.arange(n)
        if wanted.rows and n > wanted.rows:
            rows = np.linspace(0, n - 1, wanted.rows).round().astype(int)
        # Elastic contacts have no impulses.
        found |= {name: done.data[name].to_numpy()[rows] if name in done.data else np.full(len(rows), np.nan)
                  for name in wanted.columns}
    return found | {"error": ""}
