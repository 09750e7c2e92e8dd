"""Runs of an ensemble as an xarray Dataset."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ._core import descriptions, needed
from .members import EVENTS, OCCURRENCES, Coordinates, Record
from .run import _event_kinds

if TYPE_CHECKING:
    import xarray as xr

UNITS = {"clearance": "m", "clearance_right": "m", "equilibrium": "m", "equilibrium_roll": "rad", "rest_Y": "m",
         "rest_Z": "m", "rest_roll": "rad", "approach": "m", "load_per_wheel": "N", "kinetic_energy": "J",
         "drift": "J", "step": "s", "t": "s", "event_time": "s", "event_force": "N"}


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
    return needed("xarray", "ensemble").Dataset(data, coordinates)


def _padded(values: Sequence[float], n: int) -> np.ndarray:
    return np.concatenate([values, np.full(n - len(values), np.nan)])


def _units(name: str, array: np.ndarray, of_columns: Mapping[str, str]) -> dict[str, str]:
    if array.dtype.kind != "f":
        return {}
    for start, unit in ("frequency_", "Hz"), ("peak_", "N"), ("t_peak_", "s"):
        if name.startswith(start):
            return {"units": unit}
    return {"units": UNITS.get(name) or of_columns.get(name, "1")}
