"""An ensemble on disk."""
from __future__ import annotations

import errno
import os
import shutil
import time
import zipfile
import zlib
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ._core import Error, complete, descriptions, digest, left_by_dead, needed
from .dataset import to_dataset
from .members import Record

if TYPE_CHECKING:
    import xarray as xr

FLUSH = 10.0                            # work that a store may lose when the process dies [s]


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
        restore(self.path)
        # Another process may just be putting its own there.
        if not self._is_zarr() and self.path.exists() and not self._is_zarr():
            raise Error(f"{self.path}: expected a Zarr directory or nothing, found something else")
        try:
            self.parts.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Error(f"{self.parts}: cannot be made: {error.strerror}") from None

    def _is_zarr(self) -> bool:
        return any((self.path/name).exists() for name in (".zgroup", "zarr.json"))

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
        try:
            dataset.to_zarr(scratch, zarr_format=2)
            replace_folder(scratch, self.path)
        except OSError as error:
            shutil.rmtree(scratch, ignore_errors=True)
            raise Error(f"{self.path}: cannot be written completely: {error.strerror or error}") from None
        earlier = [part for part in self.parts.glob("*.npz") if read_part(part).keys() <= records.keys()]
        if len(earlier) > 1:
            whole = self._write(records)
            for part in earlier:
                if part != whole:
                    part.unlink(missing_ok=True)        # another process may do the same

    def _write(self, records: dict[str, Record]) -> Path:
        part = self.parts/f"{digest(' '.join(sorted(records)).encode())[:16]}.npz"
        keys = {"key": (("member",), np.array(list(records)), {})}
        members = to_dataset(list(records.values()), {"member": len(records)}, keys)
        with complete(part) as scratch, open(scratch, "wb") as file:
            np.savez_compressed(file, **{name: variable.values for name, variable in members.variables.items()})
        return part


def replace_folder(new: Path, target: Path) -> None:
    """Give a folder its name, in place of the one that has it; other processes may do the same at the same time."""
    old = target.with_name(f"{target.name}.{os.getpid()}.old")
    while True:
        try:
            new.rename(target)
            break
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
                raise
        shutil.rmtree(old, ignore_errors=True)      # not before another one is there
        with suppress(FileNotFoundError):
            target.rename(old)
    shutil.rmtree(old, ignore_errors=True)


def restore(target: Path) -> None:
    """Remove what `replace_folder` left where it was killed; give the folder back that it had put aside."""
    for old in left_by_dead(target, ".*.old"):
        if target.exists():
            shutil.rmtree(old, ignore_errors=True)
        else:
            with suppress(OSError):         # another process does the same
                old.rename(target)
    for new in left_by_dead(target, ".*.new"):
        shutil.rmtree(new, ignore_errors=True)


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
