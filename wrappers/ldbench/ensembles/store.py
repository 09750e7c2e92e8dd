"""What an ensemble gives, an xarray Dataset, and on disk: records in a database beside the store, which is written when all are
there."""
from __future__ import annotations

import json
import pickle
import shutil
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._core.calls import descriptions
from .._core.errors import Error
from .._core.files import LOG, failing_as
from .._core.kept import kept_in
from .._core.optional import needed
from ..results.events import event_kinds
from ..results.quantities import si_unit
from .members import EVENTS, OCCURRENCES, Coordinates, Record

if TYPE_CHECKING:
    import xarray as xr

MARK = {"made_by": "ldbench"}       # attributes of a Dataset, by which a store is known as ours
HELD = 3e7              # members of a Dataset that are written at once, about [bytes]
IN_MEMORY = 1e8         # a larger Dataset is left on disk [bytes]
PAUSE = 0.1             # between looks whether another process has finished [s]


def longest(records: Iterable[Record]) -> Record:
    """The longest text or array of each name, or any number."""
    found: Record = {}
    for record in records:
        for name, value in record.items():
            if name not in found or (isinstance(value, str | np.ndarray) and len(value) > len(found[name])):
                found[name] = value
    return found


def to_dataset(records: Sequence[Record], like: Record, dims: Mapping[str, int], coordinates: Coordinates) -> xr.Dataset:
    """Members in the order of the dimensions. Arrays are as long as those of `like`: rows of columns are padded with NaN. What
    failed has NaN, False and ''."""
    of_columns = dict(zip(*(line.split() for line in descriptions()[:2]), strict=True))
    if EVENTS[0] in like:
        coordinates = coordinates | {"kind": ("kind", np.array(event_kinds()), {}),
                                     "occurrence": ("occurrence", np.arange(1, OCCURRENCES + 1), {})}
    data = {}
    for name, value in like.items():
        one = np.asarray(value)
        blank = {"b": False, "U": ""}.get(one.dtype.kind, np.nan)
        if one.ndim:
            whole = np.full((len(records), *one.shape), blank)
            for k, record in enumerate(records):
                if name in record:
                    whole[k, :len(record[name])] = record[name]
        else:
            whole = np.array([record.get(name, blank) for record in records], one.dtype)
        inner = ("kind", "occurrence") if name in EVENTS else ("row",)*one.ndim
        units = {"units": si_unit(name) or of_columns.get(name, "1")} if one.dtype.kind == "f" else {}
        data[name] = (*dims, *inner), whole.reshape(*dims.values(), *one.shape), units
    return needed("xarray", "ensemble").Dataset(data, coordinates, MARK)


@contextmanager
def open_records(store: Path) -> Iterator[Records]:
    """The records of a store, which other processes wait for."""
    needed("zarr", "ensemble")
    if not store.name:
        raise Error(file=store, expected="the name of a Zarr directory", found="a folder")
    if store.exists() and not is_ours(store):
        raise Error(file=store, expected="a Zarr directory that an ensemble has made, or nothing", found="something else",
                    advice=". Remove it or choose another name")
    file = kept_in(store.parent)/f"{store.name}.sqlite"
    try:
        with failing_as(store):
            file.parent.mkdir(parents=True, exist_ok=True)
        with closing(sqlite3.connect(file, timeout=0, isolation_level=None)) as database:
            lock(database, store)
            yield Records(database)
    except sqlite3.OperationalError as error:
        raise Error(f"cannot be written completely: {error}", file=store) from None
    except (sqlite3.DatabaseError, pickle.UnpicklingError) as error:
        raise Error(file=file, expected="results that an ensemble kept", found=f"them damaged: {error}",
                    advice=". Remove it") from None


def is_ours(store: Path) -> bool:
    """Whether an ensemble has made a Zarr directory."""
    with suppress(OSError, ValueError):
        return MARK.items() <= dict(json.loads((store/".zattrs").read_bytes())).items()
    return False


def lock(database: sqlite3.Connection, store: Path) -> None:
    """Wait until no other process has the database. A process that is killed loses nothing: the log of what it wrote is read."""
    database.execute("PRAGMA locking_mode = EXCLUSIVE")
    told = False
    while True:
        try:
            database.execute("PRAGMA journal_mode = WAL")
            database.execute("CREATE TABLE IF NOT EXISTS records (key TEXT PRIMARY KEY, record BLOB)")
            break
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise
        if not told:
            LOG.warning("%s: waiting for another process that writes it", store)
            told = True
        time.sleep(PAUSE)
    database.execute("PRAGMA synchronous = OFF")        # a system that stops may lose records; a process does not


class Records:
    """The records in a database, by the keys of members."""

    def __init__(self, database: sqlite3.Connection) -> None:
        self._database = database

    def __contains__(self, key: object) -> bool:
        return bool(self._database.execute("SELECT 1 FROM records WHERE key = ?", (key,)).fetchone())

    def __getitem__(self, key: str) -> Record:
        row, = self._database.execute("SELECT record FROM records WHERE key = ?", (key,)).fetchone()
        record: Record = pickle.loads(row)
        return record

    def __setitem__(self, key: str, record: Record) -> None:
        self._database.execute("INSERT OR REPLACE INTO records VALUES (?, ?)", (key, pickle.dumps(record)))

    def keep(self, keys: Sequence[str]) -> None:
        """Remove all records but some."""
        found = {key for key, in self._database.execute("SELECT key FROM records")}
        self._database.executemany("DELETE FROM records WHERE key = ?", [(key,) for key in found.difference(keys)])


def write_store(store: Path, records: Records, keys: Sequence[str], dims: Mapping[str, int],
                coordinates: Coordinates) -> xr.Dataset:
    """The Dataset of all members, written by parts along its longest dimension, which then takes the place of an earlier one."""
    xarray = needed("xarray", "ensemble")
    like = longest(records[key] for key in keys)
    members = xarray.DataArray(np.arange(len(keys)).reshape(*dims.values()), dims=list(dims))
    along = max(dims, key=lambda dim: dims[dim])
    step = max(1, int(HELD/sum(np.asarray(one).nbytes for one in like.values())*dims[along]/len(keys)))
    scratch = kept_in(store.parent)/store.name
    with failing_as(store):
        shutil.rmtree(scratch, ignore_errors=True)
        for begin in range(0, dims[along], step):
            own = members.isel({along: slice(begin, begin + step)})
            part = {name: (dim, values[begin:begin + step] if dim == along else values, attributes)
                    for name, (dim, values, attributes) in coordinates.items()}
            to_dataset([records[keys[k]] for k in own.values.flat], like, dict(own.sizes), part).to_zarr(
                scratch, append_dim=along if begin else None, zarr_format=2)
        if store.exists():
            shutil.rmtree(store)
        scratch.rename(store)
        records.keep(keys)
        dataset: xr.Dataset = xarray.open_zarr(store, chunks=None)
        return dataset.load() if dataset.nbytes <= IN_MEMORY else dataset
