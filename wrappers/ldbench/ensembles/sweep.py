"""One case many times: `ensemble`."""
from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._core.calls import Progress
from .._core.errors import BadValue
from .._core.optional import needed
from .._core.pools import usable_cores
from ..case import Case, Value
from ..table import ContactTable
from .members import Wanted, check_wanted, groups_of, keys_of, plan, table_keys
from .pools import run_here, run_there
from .records import open_records
from .store import check_store, longest, to_dataset, write_store

if TYPE_CHECKING:
    import xarray as xr


def ensemble(case: Case | str | os.PathLike[str] | Sequence[Case], over: Mapping[str, Sequence[Value] | np.ndarray] | None = None,
             n: int | None = None, *, seed: int = 0, draw: Literal["random", "even"] = "random", columns: Sequence[str] = (),
             rows: int | None = None, tables: Iterable[ContactTable] = (), threads: int | None = None,
             scheduler: str | None = None, store: str | os.PathLike[str] | None = None,
             progress: Progress | bool | None = None) -> xr.Dataset:
    """Run a case, or a namelist file, with other values of the variables in `over`, named as in `Case.replace`; an xarray Dataset.

    Without n: every combination of the listed values, a dimension per variable. With n: n draws from a range
    (low, high) per variable, dimension `member`; 'random', or 'even' (low discrepancy: covers the ranges more
    evenly). The first n of a larger number of draws are the same. Or give a list of cases, dimension `member`.

    Data variables are `run.results`, `event_time` and `event_force` (lateral
    force then) over kind and occurrence, and the column file's `columns` over `row`, with `time`: shorter runs
    end in NaN, and of more than `rows` rows as many are kept, evenly spaced. `error` tells why a member failed;
    its numbers are NaN. The result does not depend on the number of threads.

    Members that differ only in what a contact table does not depend on share one; `tables` are some that threads
    find at hand. The case's table folder serves the members that share its table, of a list those that share the first one's.

    threads: all cores by default. scheduler: address of a Dask scheduler, whose workers then do it all.
    store: the Dataset goes to this Zarr directory when it is complete; what is there is replaced if an ensemble has made it,
    and refused if not. The result of every run is kept at once in a database beside it, in the folder .ldbench; when the
    ensemble is run again, only what is missing or has changed is computed. Then memory does not grow with the results, and
    a Dataset of more than 100 MB is read from the store when it is used. A progress function is called as
    `progress("ensemble", share)`. Ctrl-C stops the runs.
    """
    from tqdm import tqdm

    needed("xarray", "ensemble")
    if threads is not None and threads < 1:
        raise BadValue(place="ensemble", expected="at least one thread", found=threads)
    listed: dict[str, Sequence[Value]] = {name: values.tolist() if isinstance(values, np.ndarray) else values for name, values in
                                          (over or {}).items()}
    if isinstance(case, str | os.PathLike):
        case = Case.given(case)
    wanted = Wanted(tuple(dict.fromkeys(("time", *columns))) if columns else (), rows)
    check_wanted(wanted, listed)
    members, dims, coordinates = plan(case, listed, n, seed, draw)
    first = case if isinstance(case, Case) else case[0]
    keys: Sequence[Any] = keys_of(members, wanted) if store else range(len(members))
    if store:
        check_store(Path(store))
    with open_records(Path(store)) if store else nullcontext[Any]({}) as records:
        missing: Sequence[int] = range(len(members))
        if store:
            records.add_sweep(keys, {"case": first.case_name, "over": list(listed)}, dims, coordinates)
            missing = records.missing(keys)
        done = len(members) - len(missing)
        groups = groups_of(members, missing, first)
        key = table_keys()
        going = (run_there(members, groups, wanted, scheduler) if scheduler and missing else
                 run_here(members, groups, {key(table.case): table for table in tables}, wanted, threads or usable_cores()))
        with (closing(going) as results,
              tqdm(desc="ensemble", total=len(members), initial=done, unit="run", delay=1, leave=False,
                   disable=None if progress is True else True) as bar):
            for number, record in results:
                records[keys[number]] = record
                bar.update()
                done += 1
                if callable(progress):      # what is told is kept, whatever comes then
                    progress("ensemble", done/len(members))
        if store:
            return write_store(Path(store), records, keys, dims, coordinates)
        found = [records[key] for key in keys]
        return to_dataset(found, longest(found), dims, coordinates)
