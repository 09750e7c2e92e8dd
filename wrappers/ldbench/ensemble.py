"""Run one case many times over lists or ranges of its variables.

Variables go by their names in the namelist. A list, 1,2,4, or a grid, 1:4:7 (seven values), makes a run for
every combination; with -n that many runs are drawn, each variable from its range 1:4.
Needs xarray, zarr for --store and dask[distributed] for --scheduler: pip install ldbench[ensemble].

examples:
  python -m ldbench ensemble inputs/ex3_aw.nml --over mass=1200:2000:9 vY=0.5,1,2 --store sweep.zarr
  python -m ldbench ensemble inputs/ex3_aw.nml --over mass=1200:2000 gauge=1.43:1.44 -n 50 --seed 1
  python -m ldbench ensemble inputs/ex3_aw.nml --over mass=1200:2000:99 --scheduler tcp://node1:8786
  python -m ldbench ensemble --demo
"""
from __future__ import annotations

import argparse
import functools
import itertools
import json
import os
import queue
import re
import shutil
import threading
import time
import zipfile
import zlib
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Literal

import numpy as np

from . import _flat
from ._core import Error, Progress, complete, descriptions, digest, needed, side_by_side, usable_cores
from .case import Case, Value, find_variable, variables
from .run import Event, Run, _event_kinds, parse_setting, run
from .table import FREE_GROUPS, FREE_NAMES, ContactTable

if TYPE_CHECKING:
    import xarray as xr

Record = dict[str, object]              # what is kept of a run, by name; of one that failed its `error` alone
TableKey = tuple[object, ...]

OCCURRENCES = 5                         # of each kind of event that a run lists
EVENTS = "event_time", "event_force"
NOT_KEPT = "table_seconds", "seconds", "table_found"        # of the summary: not the same every time
UNITS = {"clearance": "m", "clearance_right": "m", "equilibrium": "m", "equilibrium_roll": "rad", "rest_Y": "m",
         "rest_Z": "m", "rest_roll": "rad", "approach": "m", "load_per_wheel": "N", "kinetic_energy": "J",
         "drift": "J", "step": "s", "t": "s", "event_time": "s", "event_force": "N"}
FLUSH = 10.0                            # work that a store may lose when the process dies [s]


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


def ensemble(case: Case | Sequence[Case], over: Mapping[str, Sequence[Value]] | None = None, n: int | None = None, *,
             seed: int = 0, draw: Literal["random", "even"] = "random", columns: Sequence[str] = (),
             rows: int | None = None, tables: Iterable[ContactTable] = (), threads: int | None = None,
             scheduler: str | None = None, store: str | os.PathLike[str] | None = None,
             progress: Progress | bool | None = None) -> xr.Dataset:
    """Run a case with other values of the variables in `over`, named as in `Case.replace`; an xarray Dataset.

    Without n: every combination of the listed values, a dimension per variable. With n: n draws from a range
    (low, high) per variable, dimension `member`; 'random', or 'even' (low discrepancy: covers the ranges more
    evenly). The first n of a larger number of draws are the same. Or give a list of cases, dimension `member`.

    Data variables are the numbers of `run.summary` but processor times, `event_time` and `event_force` (lateral
    force then) over kind and occurrence, and the column file's `columns` over `row`, with `time`: shorter runs
    end in NaN, and of more than `rows` rows as many are kept, evenly spaced. `error` tells why a member failed;
    its numbers are NaN. The result does not depend on the number of threads.

    Members that differ only in what a contact table does not depend on share one; `tables` are some that threads
    find at hand. The case's table file serves the members that keep its table.

    threads: all cores by default. scheduler: address of a Dask scheduler, whose workers then do it all.
    store: the Dataset goes to this Zarr directory when it is complete. Members that are done are kept beside it, in
    STORE.parts; when the ensemble is run again, only what is missing or has changed is computed. A progress
    function is called as `progress("ensemble", share)`. Ctrl-C stops the runs.
    """
    _xarray()
    if threads is not None and threads < 1:
        raise Error(f"ensemble: expected at least one thread, found {threads}")
    over = dict(over or {})
    wanted = Wanted(tuple(dict.fromkeys(("time", *columns))) if columns else (), rows)
    _check_wanted(wanted, over)
    cases, dims, coordinates = _plan(case, over, n, seed, draw)
    members = _members(cases, wanted, case if isinstance(case, Case) else None)
    records: dict[int, Record] = {m.number: {"error": m.error} for m in members if m.error}
    kept = Store(store) if store else None
    found = kept.read() if kept else {}
    records |= {m.number: found[m.key] for m in members if m.key in found}
    missing = [m for m in members if m.number not in records]
    if scheduler and missing:
        from .cluster import run_on_cluster
        results = run_on_cluster(missing, scheduler, wanted)
    else:
        results = run_in_threads(missing, tables, threads or usable_cores(), wanted)
    try:
        with closing(results), _counted(len(records), len(members), progress) as tell:
            for member, record in results:
                records[member.number] = record
                if kept:
                    kept.add(member.key, record)
                tell()              # what is told is kept, whatever comes then
    finally:
        if kept:
            kept.flush()
    dataset = to_dataset([records[k] for k in range(len(members))], dims, coordinates)
    if kept:
        kept.finish(dataset, {m.key: records[m.number] for m in members if m.key})
    return dataset


# What to run ------------------------------------------------------------------------------

Coordinates = dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, str]]]


def _plan(case: Case | Sequence[Case], over: dict[str, Sequence[Value]], n: int | None, seed: int, draw: str,
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


def _check_wanted(wanted: Wanted, over: Mapping[str, object]) -> None:
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


def _members(cases: Sequence[Case | str], wanted: Wanted, base: Case | None = None) -> list[Member]:
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


# Threads ----------------------------------------------------------------------------------

class Stopped(Exception):
    """Ends a thread's work when the ensemble is stopped."""


class Schedule:
    """Which thread does what next.

    The core builds one table at a time, so one thread is kept building while the others run members; no more
    than one table is made ahead.
    """

    def __init__(self, members: Sequence[Member], tables: Iterable[ContactTable]) -> None:
        self.condition = threading.Condition()
        self.stopped = False
        self.building = False
        self.unbuilt = by_table(members)
        self.ready: list[tuple[ContactTable, list[Member]]] = []
        at_hand = {member.table: table for table in tables for member in _members([table.case], Wanted())}
        for key in list(self.unbuilt):
            if key in at_hand:
                self.ready.append((at_hand[key], self.unbuilt.pop(key)))

    def next(self) -> tuple[ContactTable | None, list[Member]]:
        """A table and one member to run, or no table and the members to build one for; nothing at the end."""
        with self.condition:
            while True:
                if self.stopped:
                    raise Stopped
                if self.unbuilt and not self.building and len(self.ready) < 2:
                    self.building = True
                    return None, self.unbuilt.pop(next(iter(self.unbuilt)))
                if self.ready:
                    table, members = self.ready[0]
                    member = members.pop(0)
                    if not members:
                        self.ready.pop(0)
                    return table, [member]
                if not self.building and not self.unbuilt:
                    return None, []
                self.condition.wait()

    def built(self, table: ContactTable | None, members: list[Member]) -> None:
        with self.condition:
            self.building = False
            if table:
                self.ready.append((table, list(members)))
            self.condition.notify_all()

    def stop(self) -> None:
        with self.condition:
            self.stopped = True
            self.condition.notify_all()

    def tell(self, stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if self.stopped:
            raise Stopped


def run_in_threads(members: Sequence[Member], tables: Iterable[ContactTable], threads: int, wanted: Wanted,
                   ) -> Generator[tuple[Member, Record]]:
    """Members and their records as they come."""
    schedule = Schedule(members, tables)
    done: queue.SimpleQueue[tuple[Member, Record] | BaseException] = queue.SimpleQueue()

    def build(group: list[Member]) -> None:
        table = None
        try:
            table = ContactTable(group[0].table_case, schedule.tell)
        except Error as error:
            for member in group:
                done.put((member, {"error": str(error)}))
        finally:
            schedule.built(table, group)

    def work() -> None:
        try:
            while True:
                table, group = schedule.next()
                if table:
                    done.put((group[0], run_member(group[0].case, table, wanted, schedule.tell)))
                elif group:
                    build(group)
                else:
                    return
        except Stopped:
            pass
        except BaseException as error:
            done.put(error)

    pool = [threading.Thread(target=work, name="ldbench ensemble") for _ in range(min(threads, len(members)))]
    try:
        for thread in pool:
            thread.start()
        for _ in members:
            result = done.get()
            if isinstance(result, BaseException):
                raise result
            yield result
    finally:
        schedule.stop()
        for thread in pool:
            if thread.ident:
                thread.join()


@contextmanager
def _counted(done: int, total: int, progress: Progress | bool | None) -> Iterator[Callable[[], None]]:
    """To call for every member that is done: their number goes on a bar or to a function."""
    from tqdm import tqdm

    numbers = itertools.count(done + 1)
    with tqdm(desc="ensemble", total=total, initial=done, unit="run", delay=1, leave=False,
              disable=None if progress is True else True) as bar:
        def tell() -> None:
            number = next(numbers)
            bar.update()
            if callable(progress):
                progress("ensemble", number/total)

        yield tell


# Dataset ----------------------------------------------------------------------------------

def to_dataset(records: Sequence[Record], dims: Mapping[str, int], coordinates: Coordinates) -> xr.Dataset:
    """Records in the order of the dimensions; columns are padded with NaN."""
    shape = tuple(dims.values())
    names = next((list(r) for r in records if not r["error"]), ["error"])
    columns = set(descriptions()[0].split())
    rows = max((len(r["time"]) for r in records if "time" in r), default=0)
    of_columns = dict(zip(*(line.split() for line in descriptions()[:2]), strict=True))
    coordinates = dict(coordinates)
    data = {}
    for name in names:
        inner: tuple[str, ...] = ()
        if name in columns:
            inner, values = ("row",), [_padded(r.get(name, ()), rows) for r in records]
        elif name in EVENTS:
            inner = "kind", "occurrence"
            blank = np.full((len(_event_kinds()), OCCURRENCES), np.nan)
            values = [r.get(name, blank) for r in records]
            coordinates["kind"] = ("kind",), np.array(_event_kinds()), {}
            coordinates["occurrence"] = ("occurrence",), np.arange(1, OCCURRENCES + 1), {}
        else:
            kind = type(next(r[name] for r in records if name in r))
            values = [r.get(name, {bool: False, str: ""}.get(kind, np.nan)) for r in records]
        array = np.array(values)
        data[name] = ((*dims, *inner), array.reshape(shape + array.shape[1:]), _units(name, array, of_columns))
    return _xarray().Dataset(data, coordinates)


def _padded(values: Sequence[float], n: int) -> np.ndarray:
    return np.concatenate([values, np.full(n - len(values), np.nan)])


def _units(name: str, array: np.ndarray, of_columns: Mapping[str, str]) -> dict[str, str]:
    if array.dtype.kind != "f":
        return {}
    for start, unit in ("frequency_", "Hz"), ("peak_", "N"), ("t_peak_", "s"):
        if name.startswith(start):
            return {"units": unit}
    return {"units": UNITS.get(name) or of_columns.get(name, "1")}


def _xarray() -> ModuleType:
    return needed("xarray", "ensemble")


# Store ------------------------------------------------------------------------------------

class Store:
    """An ensemble on disk: the complete Dataset, and beside it what is done of it, by keys.

    A part holds the arrays of some members. It comes under its name when it is complete, so that a process may die
    at any time; one that cannot be read counts as missing.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        needed("zarr", "ensemble")
        self.path = Path(path)
        self.parts = self.path.with_name(self.path.name + ".parts")
        self.waiting: dict[str, Record] = {}
        self.flushed = time.monotonic()
        if self.path.exists() and not any((self.path/name).exists() for name in (".zgroup", "zarr.json")):
            raise Error(f"{self.path}: expected a Zarr directory or nothing, found something else")
        try:
            self.parts.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Error(f"{self.parts}: cannot be made: {error.strerror}") from None

    def read(self) -> dict[str, Record]:
        """Records of all members that are done, of this ensemble or another one, by their keys."""
        found: dict[str, Record] = {}
        for part in sorted(self.parts.glob("*.npz")):
            found |= read_part(part)
        return found

    def add(self, key: str, done: Record) -> None:
        self.waiting[key] = done
        if time.monotonic() >= self.flushed + FLUSH:
            self.flush()

    def flush(self) -> None:
        """Write what waits."""
        if self.waiting:
            self._write(self.waiting)
        self.waiting = {}
        self.flushed = time.monotonic()

    def finish(self, dataset: xr.Dataset, records: dict[str, Record]) -> None:
        """Write the complete Dataset, and one part in place of all."""
        scratch = self.path.with_name(f"{self.path.name}.{os.getpid()}.new")
        shutil.rmtree(scratch, ignore_errors=True)
        dataset.to_zarr(scratch, zarr_format=2)
        if self.path.exists():
            shutil.rmtree(self.path)
        scratch.rename(self.path)
        earlier = [part for part in self.parts.glob("*.npz") if read_part(part).keys() <= records.keys()]
        if len(earlier) > 1:
            whole = self._write(records)
            for part in earlier:
                if part != whole:
                    part.unlink()

    def _write(self, records: dict[str, Record]) -> Path:
        part = self.parts/f"{digest(' '.join(sorted(records)).encode())[:16]}.npz"
        keys = {"key": (("member",), np.array(list(records)), {})}
        members = to_dataset(list(records.values()), {"member": len(records)}, keys)
        with complete(part) as scratch, open(scratch, "wb") as file:
            np.savez_compressed(file, **{name: variable.values for name, variable in members.variables.items()})
        return part


def read_part(path: Path) -> dict[str, Record]:
    """Records by key; none of a file that cannot be read."""
    try:
        with np.load(path) as part:
            arrays = dict(part)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
        return {}
    in_rows = arrays.keys() & set(descriptions()[0].split())
    for name in "kind", "occurrence":
        arrays.pop(name, None)
    found = {}
    for k, key in enumerate(arrays.pop("key").tolist()):
        if arrays["error"][k]:
            found[key] = {"error": str(arrays["error"][k])}
            continue
        found[key] = {name: array[k] if array.ndim > 1 else array[k].item() for name, array in arrays.items()}
        for name in in_rows:
            found[key][name] = found[key][name][:int(found[key]["rows"])]
    return found


# Command line -----------------------------------------------------------------------------

def parse_values(setting: str) -> tuple[str, list[Value]]:
    """mass=1,2,4 or mass=1:4:7 or mass=1:4 as a name and values."""
    name, words = setting.partition("=")[::2]
    try:
        if found := re.fullmatch(r"([^:]+):([^:]+):(\d+)", words):
            return name, np.linspace(float(found[1]), float(found[2]), int(found[3])).tolist()
        return name, [parse_setting(f"{name}={word}")[1] for word in re.split("[,:]", words)]
    except ValueError:
        raise Error(f"expected name=1,2,4 or name=1:4:7 or name=1:4 after --over, found {setting}") from None


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", nargs="?", help="namelist file")
    parser.add_argument("--over", metavar="NAME=VALUES", nargs="+", action="extend", default=[],
                        help="variables and their values: 1,2,4 or 1:4:7 (from, to, number), or with -n a range 1:4")
    parser.add_argument("-n", type=int, help="number of draws")
    parser.add_argument("--draw", choices=("random", "even"), default="random", help="how (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of the draws (%(default)s)")
    parser.add_argument("--set", metavar="NAME=VALUE", nargs="+", action="extend", default=[],
                        help="replace values of the namelist for all runs")
    parser.add_argument("--store", metavar="DIR", help="Zarr directory for the results; what is done is not run again")
    parser.add_argument("--columns", metavar="NAME", nargs="+", default=[], help="keep these columns of every run")
    parser.add_argument("--rows", type=int, help="keep at most so many rows of them (all)")
    parser.add_argument("--threads", type=side_by_side, help="runs side by side (all cores)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="run on the workers of this Dask scheduler")
    parser.add_argument("--demo", action="store_true",
                        help="peak flange force and derailment force over mass, gauge and flange angle, some minutes: "
                             "outputs/derailment_demo.pdf")


def main(args: argparse.Namespace) -> int:
    if args.demo:
        from .derailment import derailment_demo
        print(derailment_demo(scheduler=args.scheduler, threads=args.threads, progress=True))
        return 0
    if not args.namelist or not args.over:
        raise Error("ensemble: expected a namelist file and --over, or --demo")
    case = Case.from_namelist(args.namelist).replace(**dict(map(parse_setting, args.set)))
    dataset = ensemble(case, dict(map(parse_values, args.over)), args.n, seed=args.seed, draw=args.draw,
                       columns=args.columns, rows=args.rows, threads=args.threads, scheduler=args.scheduler,
                       store=args.store, progress=True)
    print(outcome(dataset))
    if args.store:
        print(f"{args.store}: xarray.open_zarr reads it")
    return 0


def outcome(dataset: xr.Dataset) -> str:
    """Numbers of runs, and the ranges of what they answer."""
    errors = dataset.error.values.ravel()
    failed = np.flatnonzero(errors != "")
    lines = [" x ".join(f"{size} {name}" for name, size in dataset.sizes.items()
                        if name in dataset.error.dims) + f": {errors.size} runs, {failed.size} failed"]
    if failed.size:
        lines.append(f"first failure: {errors[failed[0]]}")
    if failed.size < errors.size:
        ends, counts = np.unique(dataset.end.values[dataset.error.values == ""], return_counts=True)
        lines += [f"{count} ended with {end}" for end, count in zip(ends, counts, strict=True)]
        for name, unit, scale in ("peak_N_LT", "kN", 1e-3), ("peak_N_LF", "kN", 1e-3), ("peak_N_RT", "kN", 1e-3), \
                ("peak_N_RF", "kN", 1e-3), ("t", "s", 1.0):
            values = scale*dataset[name].values
            lines.append(f"{name} [{unit}]: {np.nanmin(values):.6g} to {np.nanmax(values):.6g}, "
                         f"median {np.nanmedian(values):.6g}")
    return "\n".join(lines)
