"""Runs of an ensemble as an xarray Dataset."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._core.calls import descriptions
from .._core.optional import needed
from ..results.events import event_kinds
from ..results.quantities import si_unit
from .members import EVENTS, OCCURRENCES, Batch, Coordinates, join, row_names

if TYPE_CHECKING:
    import xarray as xr

MARK = {"made_by": "ldbench"}      # attributes of a Dataset, by which a store is known as ours


class Memory:
    """The records of an ensemble in memory, by member's number as its key."""

    def __init__(self, dims: Mapping[str, int], coordinates: Coordinates) -> None:
        self.dims, self.coordinates = dims, coordinates
        self.numbers: list[int] = []
        self.batches: list[Batch] = []

    def __contains__(self, key: str) -> bool:
        return False

    def add(self, keys: Sequence[str], batch: Batch) -> None:
        """Keep the records of some members."""
        self.numbers += map(int, keys)
        self.batches.append(batch)

    def flush(self) -> None:
        """Results in memory need no flush."""

    def finish(self) -> xr.Dataset:
        """Make the Dataset of all members."""
        order = np.argsort(self.numbers)
        batch = {name: array[order] for name, array in join(self.batches).items()}
        return to_dataset(batch, self.dims, self.coordinates)

    def abandon(self) -> None:
        """Results in memory leave no files."""


def to_dataset(batch: Batch, dims: Mapping[str, int], coordinates: Coordinates) -> xr.Dataset:
    """Members in the order of the dimensions."""
    shape = tuple(dims.values())
    of_columns = dict(zip(*(line.split() for line in descriptions()[:2]), strict=True))
    of_rows = row_names()
    coordinates = dict(coordinates)
    data = {}
    for name, array in batch.items():
        inner: tuple[str, ...] = ("row",) if name in of_rows else ()
        if name in EVENTS:
            inner = "kind", "occurrence"
            coordinates["kind"] = ("kind",), np.array(event_kinds()), {}
            coordinates["occurrence"] = ("occurrence",), np.arange(1, OCCURRENCES + 1), {}
        data[name] = ((*dims, *inner), array.reshape(shape + array.shape[1:]), _units(name, array, of_columns))
    return needed("xarray", "ensemble").Dataset(data, coordinates, MARK)


def _units(name: str, array: np.ndarray, of_columns: Mapping[str, str]) -> dict[str, str]:
    if array.dtype.kind != "f":
        return {}
    return {"units": si_unit(name) or of_columns.get(name, "1")}
