"""Runs of an ensemble as an xarray Dataset."""
from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._core.calls import descriptions
from .._core.optional import needed
from ..results.events import event_kinds
from ..results.quantities import si_unit
from .members import EVENTS, OCCURRENCES, Coordinates, Record

if TYPE_CHECKING:
    import xarray as xr

MARK = {"made_by": "ldbench"}       # attributes of a Dataset, by which a store is known as ours


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
