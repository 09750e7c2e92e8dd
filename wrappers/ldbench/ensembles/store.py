"""An ensemble on disk."""
from __future__ import annotations

import glob
import json
import math
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from .._core.errors import Error
from .._core.files import LOG, digest, failing_as
from .._core.kept import kept_in
from .._core.optional import needed
from .dataset import MARK, Batch, stack, to_dataset
from .members import Coordinates, Record

if TYPE_CHECKING:
    import xarray as xr

FLUSH = 10.0            # work that a store may lose when the process dies [s]
BLOCK = 4096            # members of a block of the Dataset, at most, and that wait in memory
HELD = 3e7              # their arrays, about [bytes]
IN_MEMORY = 1e8         # a larger Dataset is left on disk [bytes]
KEYS = "ldbench"        # the group in a Dataset's folder that has the keys of the members that are done
FORMAT: dict[str, Any] = {"zarr_format": 2, "consolidated": False}


@contextmanager
def open_store(path: Path, dims: Mapping[str, int], coordinates: Coordinates, keys: Sequence[str]) -> Iterator[Store]:
    """The store of an ensemble, which other processes wait for. `keys`: of all members, in the order of the dimensions."""
    needed("zarr", "ensemble")
    if not path.name:
        raise Error(f"{path}: expected the name of a Zarr directory, found a folder")
    if path.exists() and not is_ours(path):
        raise Error(f"{path}: expected a Zarr directory that an ensemble has made, or nothing, found something else. "
                    "Remove it or choose another name")
    kept = kept_in(path.parent)
    with ExitStack() as held:
        with failing_as(path):
            kept.mkdir(parents=True, exist_ok=True)
            lock(held.enter_context(open(kept/f"{path.name}.lock", "w")), path)
            store = Store(path, dims, coordinates, keys)
        try:
            yield store
        finally:
            store.flush()


def is_ours(path: Path) -> bool:
    """Whether an ensemble has made a Zarr directory."""
    with suppress(OSError, ValueError):
        return MARK.items() <= dict(json.loads((path/".zattrs").read_bytes())).items()
    return False


def lock(file: TextIO, path: Path) -> None:
    """Wait until no other process has this lock. The system takes it from a process that ends. Windows has no such locks."""
    with suppress(ImportError):
        import fcntl

        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            LOG.warning("%s: waiting for another process that writes it", path)
            fcntl.flock(file, fcntl.LOCK_EX)


class Store:
    """A Dataset that grows in the hidden folder beside its place, block by block, and takes its own name when it is complete.

    A member is done when its key is there, which is written after its results, so that a process may die at any time. What an
    earlier ensemble of this name has, complete or not, is taken over by the keys.
    """

    def __init__(self, path: Path, dims: Mapping[str, int], coordinates: Coordinates, keys: Sequence[str]) -> None:
        self.path, self.dims, self.keys = path, dims, np.array(keys, "S32")
        self.waiting: dict[int, Record] = {}
        self.held, self.flushed = 0, time.monotonic()
        layout = digest(json.dumps([dims, list(keys)]).encode())[:16]
        self.folder = kept_in(path.parent)/f"{path.name}.{layout}"
        self.earlier = [folder for folder in (path, *self.folder.parent.glob(f"{glob.escape(path.name)}.*"))
                        if folder.is_dir() and folder != self.folder]
        self.complete = kept_keys(path)[0] == layout
        if self.complete:
            return
        zarr = needed("zarr", "ensemble")
        if kept_keys(self.folder)[0] != layout:
            shutil.rmtree(self.folder, ignore_errors=True)
            needed("xarray", "ensemble").Dataset(coords=coordinates, attrs=MARK).to_zarr(self.folder, **FORMAT)
            zarr.open_group(self.folder, path=KEYS, mode="a", zarr_format=2).create_array(
                "done", data=np.zeros(len(keys), "S32"), chunks=len(keys), attributes={"layout": layout})
        self.done = zarr.open_array(self.folder/KEYS/"done", mode="r+")
        self._open()
        for folder in self.earlier:
            self._take_over(folder)

    def _open(self) -> None:
        self.stored: xr.Dataset = needed("xarray", "ensemble").open_zarr(self.folder, chunks=None, consolidated=False)

    def _take_over(self, folder: Path) -> None:
        """Copy what another Dataset has of these members."""
        places = {key: k for k, key in enumerate(kept_keys(folder)[1].tolist()) if key}
        numbers = np.array([k for k in self.missing() if self.keys[k] in places], int)
        for some in np.array_split(numbers, math.ceil(numbers.size/BLOCK)) if numbers.size else ():
            with needed("xarray", "ensemble").open_zarr(folder, chunks=None, consolidated=False) as dataset:
                at = np.unravel_index([places[key] for key in self.keys[some].tolist()], dataset.error.shape)
                points = {dim: ("member", k) for dim, k in zip(dataset.error.dims, at, strict=True)}
                found = loaded(dataset.drop_vars(dataset.coords).isel(points), folder)
            self._write(some, {str(name): one.values for name, one in found.items()})

    def missing(self) -> list[int]:
        """Numbers of the members that are not done."""
        return [] if self.complete else np.flatnonzero(self.done[:] != self.keys).tolist()

    def add(self, numbers: Sequence[int], records: Sequence[Record]) -> None:
        """Keep the records of some members; write them when they are many or some time has passed."""
        self.waiting.update(zip(numbers, records, strict=True))
        self.held += sum(8*np.size(value) for record in records for value in record.values())
        if time.monotonic() >= self.flushed + FLUSH or len(self.waiting) >= BLOCK or self.held >= HELD:
            self.flush()

    def flush(self) -> None:
        """Write what waits."""
        if self.waiting:
            with failing_as(self.path):
                self._write(np.array(list(self.waiting)), stack(list(self.waiting.values())))
        self.waiting = {}
        self.held, self.flushed = 0, time.monotonic()

    def _write(self, numbers: np.ndarray, batch: Batch) -> None:
        """Write the results of members into the blocks that have them, and then their keys."""
        self._make_room(batch)
        at = np.array(np.unravel_index(numbers, tuple(self.dims.values())), int).reshape(len(self.dims), len(numbers))
        chunk = np.array(self.stored.error.encoding["chunks"], int)[:, None]
        blocks, block_of = np.unique(at//chunk, axis=1, return_inverse=True)
        for k, block in enumerate(blocks.T):
            own = np.flatnonzero(block_of.ravel() == k)
            region = {dim: slice(int(b*c), int(min((b + 1)*c, n)))
                      for b, c, (dim, n) in zip(block, chunk[:, 0], self.dims.items(), strict=True)}
            part = loaded(self.stored.drop_vars(self.stored.coords).isel(region), self.folder)
            for name, values in batch.items():
                part[name].values[(*(at[:, own] % chunk), *(slice(0, n) for n in values.shape[1:]))] = values[own]
            part.to_zarr(self.folder, region=region, mode="r+", **FORMAT)
        done = self.done[:]
        done[numbers] = self.keys[numbers]
        self.done[:] = done

    def _make_room(self, batch: Batch) -> None:
        """Make the arrays that the folder lacks, and lengthen the rows of columns."""
        shape = tuple(self.dims.values())
        longer = {name: (*shape, *values.shape[1:]) for name, values in batch.items()
                  if name in self.stored and values.shape[1:] > self.stored[name].shape[len(shape):]}
        for name, size in longer.items():
            needed("zarr", "ensemble").open_array(self.folder/name, mode="r+").resize(size)
        lacking = to_dataset({name: values[:1] for name, values in batch.items() if name not in self.stored}, {"member": 1}, {})
        arrays: dict[str, Any] = {}
        encoding: dict[str, Any] = {}
        chunk = self.stored.error.encoding["chunks"] if "error" in self.stored else self._block(batch)
        for name, one in zip(map(str, lacking), lacking.values(), strict=True):
            whole, chunks = (*shape, *one.shape[1:]), (*chunk, *(max(1, n) for n in one.shape[1:]))
            blank = (np.full(whole, "", object) if one.dtype.kind not in "fb" else       # texts have no length that holds for all
                     needed("dask.array", "ensemble").full(whole, np.nan if one.dtype.kind == "f" else False, chunks=chunks))
            arrays[name] = (*self.dims, *one.dims[1:]), blank, one.attrs
            encoding[name] = {"chunks": chunks}
        if arrays:
            needed("xarray", "ensemble").Dataset(arrays, lacking.coords, MARK).to_zarr(
                self.folder, mode="a", compute=False, encoding=encoding, **FORMAT)
        if arrays or longer:
            self._open()

    def _block(self, batch: Batch) -> tuple[int, ...]:
        """Members of a block by dimension: trailing dimensions as a whole while they fit, a slice of the one before, one of the
        others."""
        members = max(1, min(BLOCK, int(HELD/sum(values[:1].nbytes for values in batch.values()))))
        chunk: list[int] = []
        for n in reversed(list(self.dims.values())):
            chunk.insert(0, max(1, min(n, members)))
            members //= n
        return tuple(chunk)

    def finish(self) -> xr.Dataset:
        """The complete Dataset, under its name."""
        self.flush()
        with failing_as(self.path):
            if not self.complete:
                needed("zarr", "ensemble").consolidate_metadata(self.folder, zarr_format=2)
                for folder in self.earlier:
                    shutil.rmtree(folder)
                self.folder.rename(self.path)
            dataset: xr.Dataset = needed("xarray", "ensemble").open_zarr(self.path, chunks=None)
            return dataset.load() if dataset.nbytes <= IN_MEMORY else dataset


def kept_keys(folder: Path) -> tuple[str, np.ndarray]:
    """The layout of the Dataset in a folder, and the keys of its members that are done; none where there is no such Dataset."""
    with suppress(OSError, ValueError, KeyError):       # another folder, or one that is damaged
        done = needed("zarr", "ensemble").open_array(folder/KEYS/"done", mode="r")
        return str(done.attrs["layout"]), done[:]
    return "", np.empty(0, "S32")


def loaded(dataset: xr.Dataset, folder: Path) -> xr.Dataset:
    """A Dataset in memory; Error where the folder is damaged."""
    try:
        return dataset.load()
    except (OSError, ValueError, RuntimeError, KeyError) as error:
        raise Error(f"{folder}: expected results that an ensemble kept, found them damaged: {error}. Remove it") from None
