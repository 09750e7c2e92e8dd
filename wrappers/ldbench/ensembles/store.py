"""An ensemble on disk."""
from __future__ import annotations

import errno
import functools
import json
import math
import os
import shutil
import socket
import threading
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.errors import Error
from .._core.files import complete, digest, left_by_dead, make_folder
from .._core.optional import needed
from .dataset import MARK, to_dataset
from .members import Batch, Coordinates, join

if TYPE_CHECKING:
    import xarray as xr
    import zarr

FLUSH = 10.0                            # work that a store may lose when the process dies [s]
BLOCK = 4096                            # members of a part, about, and of a block of the Dataset, at most
HELD = 3e7                              # of their arrays, about [bytes]
IN_MEMORY = 1e8                         # a larger Dataset is left on disk [bytes]
UNREADABLE = ValueError, KeyError


class Store:
    """An ensemble on disk: the Dataset, written block by block, and beside it what is done of it, by keys.

    A part holds the arrays of some members. It comes under its name when it is complete, so that a process may die
    at any time; one that cannot be read counts as missing. The Dataset grows in the folder of the parts, as far as
    all members before are done, and takes its own name at the end.
    """

    def __init__(self, path: str | os.PathLike[str], dims: Mapping[str, int], coordinates: Coordinates,
                 keys: Sequence[str]) -> None:
        """`keys`: of all members of the ensemble, in the order of the dimensions."""
        needed("zarr", "ensemble")
        self.path = Path(path)
        if not self.path.name:
            raise Error(f"{path}: expected the name of a Zarr directory, found a folder")
        self.parts = self.path.with_name(self.path.name + ".parts")
        self.dims, self.coordinates, self.keys = dims, coordinates, keys
        self.waiting: list[tuple[Sequence[str], Batch]] = []
        self.members = self.held = 0                    # that wait, and their bytes
        self.flushed = time.monotonic()
        restore(self.path)
        self.growing: Growing | None = None
        self._refuse_others()
        try:
            make_folder(self.path)
            self.parts.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Error(f"{self.parts}: cannot be made: {error.strerror}") from None
        # What processes of this machine that were killed have left.
        for folder in left_by_dead(self.parts/socket.gethostname(), ".*.zarr"):
            shutil.rmtree(folder, ignore_errors=True)
        self.places = read_places(self.parts)
        self._part = functools.lru_cache(maxsize=4)(read_part)

    def _refuse_others(self) -> None:
        """An Error where the path is that of something that no ensemble has made."""
        # Another process may just be putting its own there.
        if not self._is_ours() and self.path.exists() and not self._is_ours():
            raise Error(f"{self.path}: expected a Zarr directory that an ensemble has made, or nothing, found something else. "
                        "Remove it or choose another name")

    def _is_ours(self) -> bool:
        with suppress(OSError, ValueError):
            return MARK.items() <= dict(json.loads((self.path/".zattrs").read_bytes())).items()
        return False

    def __contains__(self, key: str) -> bool:
        return key in self.places

    def add(self, keys: Sequence[str], batch: Batch) -> None:
        """Keep the records of some members; write them when they are many or some time has passed."""
        self.waiting.append((keys, batch))
        self.members += len(keys)
        self.held += size_of(batch)
        if time.monotonic() >= self.flushed + FLUSH or self.members >= BLOCK or self.held >= HELD:
            self.flush()

    def flush(self) -> None:
        """Write what waits, and the blocks of the Dataset that are complete."""
        if self.waiting:
            keys = [key for some, _ in self.waiting for key in some]
            self._write(keys, join([batch for _, batch in self.waiting]))
        self.waiting = []
        self.members = self.held = 0
        try:
            self._grow()
        except OSError as error:
            raise Error(f"{self.path}: cannot be written completely: {error.strerror or error}") from None
        self.flushed = time.monotonic()

    def _write(self, keys: Sequence[str], batch: Batch) -> Path:
        part = self.parts/f"{digest(' '.join(sorted(keys)).encode())[:16]}.npz"
        arrays: dict[str, Any] = {"key": np.array(keys), **batch}
        with complete(part) as scratch, open(scratch, "wb") as file:
            np.savez_compressed(file, **arrays)
        self.places |= {key: (part, k) for k, key in enumerate(keys)}
        return part

    def _grow(self) -> Growing:
        if not self.growing:
            scratch = self.parts/f"{socket.gethostname()}.{writer()}.zarr"
            first = next((key for key in self.keys if key in self.places), None)
            members = min(BLOCK, HELD//size_of(self._records([first]))) if first else BLOCK
            self.growing = Growing(scratch, self.dims, self.coordinates, max(1, int(members)))
        while (block := self.growing.next_block()) and all(self.keys[k] in self.places for k in block):
            self.growing.write(block, self._records([self.keys[k] for k in block]))
        return self.growing

    def _records(self, keys: Sequence[str]) -> Batch:
        try:
            return self._gather(keys)
        except UNREADABLE:
            # Another process may have put the parts together.
            self.places = read_places(self.parts)
            try:
                return self._gather(keys)
            except UNREADABLE:
                raise Error(f"{self.parts}: expected the parts that were there, found one gone or damaged") from None

    def _gather(self, keys: Sequence[str]) -> Batch:
        by_part: dict[Path, list[int]] = {}
        for number, key in enumerate(keys):
            by_part.setdefault(self.places[key][0], []).append(number)
        batches = [{name: array[[self.places[keys[number]][1] for number in numbers]]
                    for name, array in self._part(part).items() if name != "key"} for part, numbers in by_part.items()]
        order = np.argsort([number for numbers in by_part.values() for number in numbers])
        return {name: array[order] for name, array in join(batches).items()}

    def finish(self) -> xr.Dataset:
        """The complete Dataset, under its name; and few parts in place of many."""
        xarray = needed("xarray", "ensemble")
        try:
            whole = self._grow()
            whole.close()
            # Another ensemble may replace the folder under its final name at any time: chunks that are gone would be read as NaN.
            with xarray.open_zarr(whole.folder, chunks=None) as dataset:
                small = dataset.load() if dataset.nbytes <= IN_MEMORY else None
            self._refuse_others()
            replace_folder(whole.folder, self.path)
        except OSError as error:
            raise Error(f"{self.path}: cannot be written completely: {error.strerror or error}") from None
        self._put_together(set(self.keys))
        return xarray.open_zarr(self.path, chunks=None) if small is None else small

    def abandon(self) -> None:
        """Remove the Dataset that is not complete."""
        if self.growing:
            shutil.rmtree(self.growing.folder, ignore_errors=True)

    def _put_together(self, keys: set[str]) -> None:
        small: list[tuple[Path, Batch]] = []
        for path in sorted(self.parts.glob("*.npz")):
            try:
                part = read_part(path)
            except UNREADABLE:
                continue
            if not keys.issuperset(part["key"].tolist()) or len(part["key"]) >= BLOCK:
                continue
            small.append((path, part))
            if sum(len(some["key"]) for _, some in small) >= BLOCK or sum(size_of(some) for _, some in small) >= HELD:
                self._merge(small)
                small = []
        self._merge(small)

    def _merge(self, small: Sequence[tuple[Path, Batch]]) -> None:
        if len(small) < 2:
            return
        records = join([{name: array for name, array in part.items() if name != "key"} for _, part in small])
        whole = self._write([key for _, part in small for key in part["key"].tolist()], records)
        for path, _ in small:
            if path != whole:
                path.unlink(missing_ok=True)        # another process may do the same


class Growing:
    """A Zarr group that is written in blocks of members, each a row of chunks, from the first member on."""

    def __init__(self, folder: Path, dims: Mapping[str, int], coordinates: Coordinates, members: int) -> None:
        """`members`: largest number of members per block."""
        self.folder, self.dims, self.done = folder, dims, 0
        self.shape = tuple(dims.values())
        # Trailing dimensions as a whole while they fit, a slice of the one before, one of all others.
        chunk: list[int] = []
        size = 1
        for n in reversed(self.shape):
            chunk.insert(0, max(1, min(n, members//size)))
            size *= n
        self.chunk = tuple(chunk)
        shutil.rmtree(folder, ignore_errors=True)
        needed("xarray", "ensemble").Dataset(coords=coordinates, attrs=MARK).to_zarr(folder, zarr_format=2, consolidated=False)
        self.group: zarr.Group = needed("zarr", "ensemble").open_group(folder, mode="r+", zarr_format=2)
        self.arrays: dict[str, zarr.Array] = dict(self.group.arrays())      # the group would read the metadata of each again

    def next_block(self) -> range:
        """Numbers of the members of the next one; none at the end."""
        if self.done >= math.prod(self.shape):
            return range(0)
        return range(self.done, self.done + math.prod(piece.stop - piece.start for piece in self._region()))

    def _region(self) -> tuple[slice, ...]:
        starts = np.unravel_index(self.done, self.shape)
        return tuple(slice(int(a), min(int(a) + c, n)) for a, c, n in zip(starts, self.chunk, self.shape, strict=True))

    def write(self, block: range, batch: Batch) -> None:
        """Write the records of a block of members."""
        region = self._region()
        dataset = to_dataset(batch, {"member of block": len(block)}, {})
        for name, variable in dataset.variables.items():
            values, of_members = variable.values, variable.dims[0] == "member of block"
            inner = values.shape[1:] if of_members else values.shape
            if name not in self.arrays:
                self._new_array(str(name), variable.dims[of_members:], variable, inner, of_members)
            array = self.arrays[str(name)]
            if not of_members:
                array[...] = values
                continue
            if array.shape[len(self.shape):] < inner:
                array.resize(self.shape + inner)        # more rows than any member before
            pieces = *region, *(slice(0, n) for n in inner)
            array[pieces] = values.reshape(tuple(piece.stop - piece.start for piece in pieces))
        self.done = block.stop

    def _new_array(self, name: str, inner: Iterable[object], variable: xr.Variable, size: tuple[int, ...],
                   of_members: bool) -> None:
        text = variable.dtype.kind == "U"
        self.arrays[name] = self.group.create_array(
            name, shape=self.shape + size if of_members else size, dtype=str if text else variable.dtype,
            chunks=self.chunk + tuple(max(1, n) for n in size) if of_members else size,
            fill_value=np.nan if variable.dtype.kind == "f" else None,       # xarray takes any other for "missing"
            attributes={"_ARRAY_DIMENSIONS": [*(self.dims if of_members else ()), *inner], **variable.attrs})

    def close(self) -> None:
        """Write the metadata of all arrays into one file."""
        needed("zarr", "ensemble").consolidate_metadata(self.folder, zarr_format=2)


def writer() -> str:
    """Process and thread, for names of folders that no one else writes."""
    return f"{os.getpid()}-{threading.get_ident()}"


def size_of(batch: Batch) -> int:
    """The size of the arrays [bytes]."""
    return sum(array.nbytes for array in batch.values())


def read_places(parts: Path) -> dict[str, tuple[Path, int]]:
    """Part and place in it of all members that are done, of this ensemble or another one, by their keys."""
    found: dict[str, tuple[Path, int]] = {}
    for part in sorted(parts.glob("*.npz")):
        with suppress(*UNREADABLE):
            found |= {key: (part, k) for k, key in enumerate(read_part(part)["key"].tolist())}
    return found


def read_part(path: Path) -> Batch:
    """A part's arrays, the keys among them; ValueError whatever the file is instead."""
    try:
        if not path.is_file():      # a pipe would be waited for
            raise FileNotFoundError
        with np.load(path) as part:
            arrays = dict(part)
        members = len(arrays["key"])
        if "error" in arrays and all(len(array) == members and array.dtype.kind in "fbU" for array in arrays.values()):
            return arrays
    except MemoryError:
        raise
    except Exception as error:      # numpy, zipfile and zlib have a dozen for damaged files
        raise ValueError(f"{path}: {error}") from None
    raise ValueError(f"{path}: expected records of members, found something else")


def replace_folder(new: Path, target: Path) -> None:
    """Give a folder its name, in place of the one that has it; other processes may do the same at the same time."""
    old = target.with_name(f"{target.name}.ldbench-{writer()}.old")
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
    for old in left_by_dead(target, ".ldbench-*.old"):
        if target.exists():
            shutil.rmtree(old, ignore_errors=True)
        else:
            with suppress(OSError):         # another process does the same
                old.rename(target)
