"""Results that an ensemble keeps beside its store: a database of JSON and plain arrays, which every program with SQLite reads.

Nothing in it is ever executed, so a store may come from anybody. Each record has a checksum; a record that does not fit it is as
good as none. Sweeps are listed with their members, and only `remove` takes away what an earlier one has kept.
"""
from __future__ import annotations

import json
import math
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .._core.calls import version
from .._core.errors import Error, warn
from .._core.files import digest, failing_as
from .._core.kept import kept_in
from .._core.wording import counted
from .members import Coordinates, Record

SCHEMA = 2              # of the database, its user_version; 1, which had none, held pickles
BUSY = 30.0             # wait for another program amid a change of the database [s]
PAUSE = 0.1             # between looks whether another ensemble has finished [s]
NAME = 12               # characters of a sweep's name

# The error of a run is not among its facts, so that queries find it without JSON. `data` has the bytes of a numpy array, whose kind
# and shape stand in the facts.
TABLES = """
CREATE TABLE records (key TEXT PRIMARY KEY, error TEXT NOT NULL, facts TEXT NOT NULL, checksum TEXT NOT NULL);
CREATE TABLE arrays (key TEXT, name TEXT, data BLOB NOT NULL, PRIMARY KEY (key, name));
CREATE TABLE sweeps (sweep TEXT PRIMARY KEY, made TEXT NOT NULL, about TEXT NOT NULL);
CREATE TABLE members (sweep TEXT, number INTEGER, key TEXT NOT NULL, point TEXT NOT NULL, PRIMARY KEY (sweep, number))
    WITHOUT ROWID;
CREATE VIEW results AS SELECT sweep, number, point, error, facts FROM members LEFT JOIN records USING (key);
"""


class Damaged(ValueError):
    """A record does not fit its checksum."""


class Sweep(NamedTuple):
    """An ensemble that a database knows."""

    sweep: str          # its name
    made: str           # when, UTC
    members: int
    done: int           # members with a record
    failed: int         # those of them that have an error
    about: dict[str, Any]       # case, program, sizes of the dimensions


def records_file(store: Path) -> Path:
    """The database beside a store."""
    return kept_in(store.parent)/f"{store.name}.sqlite"


def encoded(record: Record) -> tuple[str, str, dict[str, bytes]]:
    """The error, the facts as JSON, and the bytes of arrays, by name. NaN, which JSON does not have, is null."""
    arrays = {name: np.ascontiguousarray(value, np.asarray(value).dtype.newbyteorder("<"))
              for name, value in record.items() if isinstance(value, np.ndarray)}
    facts = {name: {"kind": arrays[name].dtype.str, "shape": list(value.shape)} if name in arrays else
             None if isinstance(value, float) and math.isnan(value) else value
             for name, value in record.items() if name != "error"}
    return record["error"], json.dumps(facts), {name: array.tobytes() for name, array in arrays.items()}


def decoded(error: str, facts: str, arrays: Mapping[str, bytes]) -> Record:
    """The record that `encoded` took apart."""
    return {name: math.nan if value is None else
            np.frombuffer(arrays[name], value["kind"]).reshape(value["shape"]) if isinstance(value, dict) else value
            for name, value in json.loads(facts).items()} | {"error": error}


def checksum(key: str, error: str, facts: str, arrays: Mapping[str, bytes]) -> str:
    """The checksum of all that belongs to a key."""
    return digest(json.dumps([key, error, facts, {name: digest(arrays[name]) for name in sorted(arrays)}]).encode())


class Records:
    """The records in a database, by the keys of members."""

    def __init__(self, database: sqlite3.Connection, file: Path) -> None:
        self._database, self._file = database, file

    def __getitem__(self, key: str) -> Record:
        with suppress(Damaged):
            if (record := self._intact(key)) is not None:
                return record
        raise Error(file=self._file, expected="a result that was kept just now", found="it damaged",
                    advice=". Run the ensemble again, which computes it anew")

    def __setitem__(self, key: str, record: Record) -> None:
        error, facts, arrays = encoded(record)
        with transaction(self._database) as run:
            run("DELETE FROM arrays WHERE key = ?", (key,))
            run("INSERT OR REPLACE INTO records VALUES (?, ?, ?, ?)", (key, error, facts, checksum(key, error, facts, arrays)))
            for name, data in arrays.items():
                run("INSERT INTO arrays VALUES (?, ?, ?)", (key, name, data))

    def _intact(self, key: str) -> Record | None:
        """The record of a key; None where there is none. Raise Damaged where it is."""
        row = self._database.execute("SELECT error, facts, checksum FROM records WHERE key = ?", (key,)).fetchone()
        if row is None:
            return None
        error, facts, told = row
        arrays = dict(self._database.execute("SELECT name, data FROM arrays WHERE key = ?", (key,)))
        try:
            if told == checksum(key, error, facts, arrays):
                return decoded(error, facts, arrays)
        except (TypeError, ValueError, KeyError):       # a value of another type, as one makes by hand
            pass
        raise Damaged(key)

    def missing(self, keys: Sequence[str]) -> list[int]:
        """Numbers of the members that have no record; those with a damaged one are a Warning."""
        found, damaged = [], 0
        for number, key in enumerate(keys):
            try:
                if self._intact(key) is not None:
                    continue
            except Damaged:
                damaged += 1
            found.append(number)
        if damaged:
            verb = "is" if damaged == 1 else "are"
            warn(f"{self._file}: {counted(damaged, 'result')} {verb} damaged and {verb} computed again")
        return found

    def add_sweep(self, keys: Sequence[str], about: Mapping[str, Any], dims: Mapping[str, int], coordinates: Coordinates) -> None:
        """List an ensemble with its members."""
        name = digest(json.dumps([list(keys), dict(dims), sorted(coordinates)]).encode())[:NAME]
        with transaction(self._database) as run:
            run("INSERT OR IGNORE INTO sweeps VALUES (?, ?, ?)",
                (name, datetime.now(timezone.utc).isoformat(timespec="seconds"),
                 json.dumps({**about, "program": version(), "dims": dict(dims)})))
            for number, (key, point) in enumerate(zip(keys, points(dims, coordinates), strict=True)):
                run("INSERT OR IGNORE INTO members VALUES (?, ?, ?, ?)", (name, number, key, json.dumps(point, default=str)))

    def sweeps(self) -> list[Sweep]:
        """All ensembles in the order in which they were first run."""
        return [Sweep._make([*row[:-1], json.loads(row[-1])]) for row in self._database.execute(
            "SELECT sweep, made, count(*), count(error), coalesce(sum(error != ''), 0), about "
            "FROM sweeps JOIN results USING (sweep) GROUP BY sweep ORDER BY sweeps.rowid")]

    def remove(self, sweeps: Iterable[str]) -> int:
        """Remove ensembles, and the records that no other one has; the number of the latter."""
        with transaction(self._database) as run:
            before, = run("SELECT count(*) FROM records").fetchone()
            for sweep in sweeps:
                run("DELETE FROM members WHERE sweep = ?", (sweep,))
                run("DELETE FROM sweeps WHERE sweep = ?", (sweep,))
            for table in "records", "arrays":
                run(f"DELETE FROM {table} WHERE key NOT IN (SELECT key FROM members)")
            after, = run("SELECT count(*) FROM records").fetchone()
        self._database.execute("VACUUM")
        return int(before - after)


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[Any]:
    """All that is executed within, or nothing of it."""
    database.execute("BEGIN IMMEDIATE")
    try:
        yield database.execute
    except BaseException:
        database.execute("ROLLBACK")
        raise
    database.execute("COMMIT")


def points(dims: Mapping[str, int], coordinates: Coordinates) -> Iterator[dict[str, Any]]:
    """The values of the variables of each member, in the order of members."""
    places = list(dims)
    for index in np.ndindex(*dims.values()):
        yield {name: values[index[places.index(dim)]].item() if hasattr(values[0], "item") else values[index[places.index(dim)]]
               for name, (dim, values, _) in coordinates.items()}


@contextmanager
def open_records(store: Path, waits: bool = True) -> Iterator[Records]:
    """The records of a store, to be changed, while no other ensemble changes them. Readers disturb nobody."""
    file = records_file(store)
    with failing_as(store):
        file.parent.mkdir(parents=True, exist_ok=True)
    with alone(store, waits), opened(store, file) as database:
        database.execute("PRAGMA journal_mode = WAL")        # in which readers and a writer do not wait for each other
        database.execute("PRAGMA synchronous = NORMAL")      # a system that stops may lose the last records, and no others
        if not database.execute("SELECT 1 FROM sqlite_master").fetchone():
            database.executescript(f"BEGIN; {TABLES} PRAGMA user_version = {SCHEMA}; COMMIT;")
        yield Records(database, file)


@contextmanager
def read_records(store: Path) -> Iterator[Records]:
    """The records of a store, to be read, whoever changes them."""
    file = records_file(store)
    if not file.is_file():
        raise Error(file=store, expected="the store of an ensemble", found="none")
    with opened(store, file) as database:
        database.execute("PRAGMA query_only = ON")
        yield Records(database, file)


@contextmanager
def opened(store: Path, file: Path) -> Iterator[sqlite3.Connection]:
    """The database, of this schema or empty; Error in words where SQLite has one."""
    remove = f". `ldbench store {store} --remove all` removes it"
    try:
        with closing(sqlite3.connect(file, timeout=BUSY, isolation_level=None)) as database:
            schema, = database.execute("PRAGMA user_version").fetchone()
            if schema != SCHEMA and database.execute("SELECT 1 FROM sqlite_master").fetchone():
                raise Error(file=file, expected=f"results in the schema {SCHEMA}, found those of another version, {schema or 1}, "
                            "which are not read", advice=remove)
            yield database
    except sqlite3.OperationalError as error:
        raise Error(f"cannot be written completely: {error}", file=store) from None
    except sqlite3.DatabaseError as error:
        raise Error(file=file, expected="results that an ensemble kept", found=f"them damaged: {error}", advice=remove) from None


@contextmanager
def alone(store: Path, waits: bool) -> Iterator[None]:
    """Wait until no other ensemble changes the records, or refuse to. The lock is that of a database without tables, which the
    system releases when a process ends, however it does; the records themselves are not locked."""
    file = records_file(store).with_suffix(".lock")
    with failing_as(store):
        file.touch()
    told = False
    with closing(sqlite3.connect(file, timeout=0, isolation_level=None)) as lock:
        while True:
            try:
                lock.execute("BEGIN EXCLUSIVE")
                break
            except sqlite3.OperationalError as error:
                if "locked" not in str(error):
                    raise Error(f"cannot be written completely: {error}", file=store) from None
            if not waits:
                raise Error(file=store, expected="a store that nobody uses", found="an ensemble that writes it")
            if not told:
                warn(f"{store}: waiting for another process that writes it")
                told = True
            time.sleep(PAUSE)
        yield


def remove_file(store: Path) -> None:
    """Remove all that is kept, of whatever version, without reading it."""
    file = records_file(store)
    if not file.is_file():
        raise Error(file=store, expected="the store of an ensemble", found="none")
    with alone(store, False):
        for ending in "", "-wal", "-shm", "-journal":
            file.with_name(file.name + ending).unlink(missing_ok=True)
    file.with_suffix(".lock").unlink()
