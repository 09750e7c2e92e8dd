"""One case many times: `ensemble`."""
from __future__ import annotations

import itertools
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from typing import TYPE_CHECKING, Literal

from .._core.calls import Progress
from .._core.errors import BadValue
from .._core.optional import needed
from .._core.pools import usable_cores
from ..case import Case, Value
from ..table import ContactTable
from .cluster import run_on_cluster
from .dataset import Memory
from .members import Wanted, check_wanted, groups_of, keys_of, plan, run_member, stack
from .store import Store
from .threads import run_in_threads

if TYPE_CHECKING:
    import xarray as xr


def ensemble(case: Case | Sequence[Case], over: Mapping[str, Sequence[Value]] | None = None, n: int | None = None, *,
             seed: int = 0, draw: Literal["random", "even"] = "random", columns: Sequence[str] = (),
             rows: int | None = None, tables: Iterable[ContactTable] = (), threads: int | None = None,
             scheduler: str | None = None, store: str | os.PathLike[str] | None = None,
             progress: Progress | bool | None = None) -> xr.Dataset:
    """Run a case with other values of the variables in `over`, named as in `Case.replace`; an xarray Dataset.

    Without n: every combination of the listed values, a dimension per variable. With n: n draws from a range
    (low, high) per variable, dimension `member`; 'random', or 'even' (low discrepancy: covers the ranges more
    evenly). The first n of a larger number of draws are the same. Or give a list of cases, dimension `member`.

    Data variables are `run.results`, `event_time` and `event_force` (lateral
    force then) over kind and occurrence, and the column file's `columns` over `row`, with `time`: shorter runs
    end in NaN, and of more than `rows` rows as many are kept, evenly spaced. `error` tells why a member failed;
    its numbers are NaN. The result does not depend on the number of threads.

    Members that differ only in what a contact table does not depend on share one; `tables` are some that threads
    find at hand. The case's table file serves the members that keep its table.

    threads: all cores by default. scheduler: address of a Dask scheduler, whose workers then do it all.
    store: the Dataset goes to this Zarr directory, under its name when it is complete; what is there is replaced if an
    ensemble has made it, and refused if not. Members that are done are kept
    beside it, in STORE.parts; when the ensemble is run again, only what is missing or has changed is computed. Then
    memory does not grow with the number of members, and a Dataset of more than 100 MB is read from the store when it
    is used. A progress function is called as `progress("ensemble", share)`. Ctrl-C stops the runs.
    """
    needed("xarray", "ensemble")
    if threads is not None and threads < 1:
        raise BadValue(f"ensemble: expected at least one thread, found {threads}")
    over = dict(over or {})
    wanted = Wanted(tuple(dict.fromkeys(("time", *columns))) if columns else (), rows)
    check_wanted(wanted, over)
    members, dims, coordinates = plan(case, over, n, seed, draw)
    keys = keys_of(members, wanted) if store else [str(number) for number in range(len(members))]
    kept: Store | Memory = Store(store, dims, coordinates, keys) if store else Memory(dims, coordinates)
    missing = [number for number, key in enumerate(keys) if key not in kept]
    groups, without = groups_of(members, missing, case if isinstance(case, Case) else None)
    refused = (([number], stack([run_member(members[number], None, wanted)])) for number in without)
    if scheduler and groups:
        results = run_on_cluster(members, groups, scheduler, wanted)
    else:
        results = run_in_threads(members, groups, tables, threads or usable_cores(), wanted)
    try:
        try:
            with closing(results), _counted(len(members) - len(missing), len(members), progress) as tell:
                for numbers, batch in itertools.chain(refused, results):
                    kept.add([keys[number] for number in numbers], batch)
                    for _ in numbers:
                        tell()          # what is told is kept, whatever comes then
        finally:
            kept.flush()
        return kept.finish()
    finally:
        kept.abandon()


@contextmanager
def _counted(done: int, total: int, progress: Progress | bool | None) -> Iterator[Callable[[], None]]:
    """A function to call for every member that is done; it moves the bar or calls `progress`."""
    from tqdm import tqdm

    numbers = itertools.count(done + 1)
    with tqdm(desc="ensemble", total=total, initial=done, unit="run", delay=1, leave=False,
              disable=None if progress is True else True) as bar:
        def tell() -> None:
            number = next(numbers)
            bar.update()
            if callable(progress):
                progress("ensemble", number/total)

        yield tell
