"""What an ensemble gives, an xarray Dataset; on disk it is a Zarr directory, which is written when all records are there."""
from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .._core.calls import descriptions
from .._core.errors import Error
from .._core.files import failing_as
from .._core.kept import kept_in
from .._core.optional import needed
from ..results.events import event_kinds
from ..results.quantities import si_unit
from .members import EVENTS, OCCURRENCES, Coordinates, Record
from .records import Records

if TYPE_CHECKING:
    import xarray as xr

MARK = {"made_by": "ldbench"}       # attributes of a Dataset, by which a store is known as ours
HELD = 3e7              # members of a Dataset that are written at once, about [bytes]
IN_MEMORY = 1e8         # a larger Dataset is left on disk [bytes]
LEVEL = 1               # of the compression, which takes no longer than writing


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


def check_store(store: Path) -> None:
    """Refuse to write a store where something else is."""
    needed("zarr", "ensemble")
    if not store.name:
        raise Error(file=store, expected="the name of a Zarr directory", found="a folder")
    if store.exists() and not is_ours(store):
        raise Error(file=store, expected="a Zarr directory that an ensemble has made, or nothing", found="something else",
                    advice=". Remove it or choose another name")


def is_ours(store: Path) -> bool:
    """Whether an ensemble has made a Zarr directory."""
    with suppress(OSError, ValueError):
        return MARK.items() <= dict(json.loads((store/".zattrs").read_bytes())).items()
    return False


def write_store(store: Path, records: Records, keys: Sequence[str], dims: Mapping[str, int],
                coordinates: Coordinates) -> xr.Dataset:
    """The Dataset of all members, written by parts along its longest dimension, which then takes the place of an earlier one."""
    xarray = needed("xarray", "ensemble")
    like = longest(records[key] for key in keys)
    members = xarray.DataArray(np.arange(len(keys)).reshape(*dims.values()), dims=list(dims))
    along = max(dims, key=lambda dim: dims[dim])
    step = max(1, int(HELD/sum(np.asarray(one).nbytes for one in like.values())*dims[along]/len(keys)))
    scratch = kept_in(store.parent)/store.name
    # The frames of Zstandard have checksums, so that whoever reads the store is told of damage.
    checked = {"compressors": needed("numcodecs", "ensemble").Zstd(level=LEVEL, checksum=True)}
    with failing_as(store):
        shutil.rmtree(scratch, ignore_errors=True)
        for begin in range(0, dims[along], step):
            own = members.isel({along: slice(begin, begin + step)})
            part = {name: (dim, values[begin:begin + step] if dim == along else values, attributes)
                    for name, (dim, values, attributes) in coordinates.items()}
            dataset = to_dataset([records[keys[k]] for k in own.values.flat], like, dict(own.sizes), part)
            how = {"append_dim": along} if begin else {"encoding": dict.fromkeys(dataset.variables, checked)}
            dataset.to_zarr(scratch, zarr_format=2, **how)
        if store.exists():
            shutil.rmtree(store)
        scratch.rename(store)
        dataset = xarray.open_zarr(store, chunks=None)
        return dataset.load() if dataset.nbytes <= IN_MEMORY else dataset
