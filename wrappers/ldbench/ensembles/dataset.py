"""Runs of an ensemble as an xarray Dataset."""
from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._core.calls import descriptions
from .._core.optional import needed
from ..results.events import event_kinds
from ..results.quantities import si_unit
from .members import EVENTS, OCCURRENCES, Coordinates, Record

if TYPE_CHECKING:
    import xarray as xr

Batch = dict[str, np.ndarray]       # records of some members, by name, the first axis over members
MARK = {"made_by": "ldbench"}       # attributes of a Dataset, by which a store is known as ours


class Memory:
    """The records of an ensemble in memory."""

    def __init__(self, dims: Mapping[str, int], coordinates: Coordinates) -> None:
        self.dims, self.coordinates = dims, coordinates
        self.done: dict[int, Record] = {}

    def add(self, numbers: Sequence[int], records: Sequence[Record]) -> None:
        """Keep the records of some members."""
        self.done.update(zip(numbers, records, strict=True))

    def missing(self) -> list[int]:
        """Numbers of the members that are not done."""
        return [number for number in range(math.prod(self.dims.values())) if number not in self.done]

    def finish(self) -> xr.Dataset:
        """The Dataset of all members."""
        return to_dataset(stack([self.done[number] for number in sorted(self.done)]), self.dims, self.coordinates)


def stack(records: Sequence[Record]) -> Batch:
    """Records as arrays. Rows of columns are padded with NaN; what failed has NaN, False and ''."""
    batch = {}
    for name in dict.fromkeys(name for record in records for name in record):
        values = [record.get(name) for record in records]
        like = next(value for value in values if value is not None)
        if not isinstance(like, np.ndarray):
            blank = False if isinstance(like, bool) else "" if isinstance(like, str) else np.nan
            batch[name] = np.array([blank if value is None else value for value in values])
            continue
        longest = max(len(value) for value in values if value is not None)
        batch[name] = np.full((len(records), longest, *like.shape[1:]), np.nan)
        for whole, value in zip(batch[name], values, strict=True):
            if value is not None:
                whole[:len(value)] = value
    return batch


def to_dataset(batch: Batch, dims: Mapping[str, int], coordinates: Coordinates) -> xr.Dataset:
    """Members in the order of the dimensions."""
    shape = tuple(dims.values())
    of_columns = dict(zip(*(line.split() for line in descriptions()[:2]), strict=True))
    coordinates = dict(coordinates)
    data = {}
    for name, array in batch.items():
        inner: tuple[str, ...] = ("row",) if name in of_columns else ()
        if name in EVENTS:
            inner = "kind", "occurrence"
            coordinates["kind"] = ("kind",), np.array(event_kinds()), {}
            coordinates["occurrence"] = ("occurrence",), np.arange(1, OCCURRENCES + 1), {}
        units = {"units": si_unit(name) or of_columns.get(name, "1")} if array.dtype.kind == "f" else {}
        data[name] = (*dims, *inner), array.reshape(shape + array.shape[1:]), units
    return needed("xarray", "ensemble").Dataset(data, coordinates, MARK)
