"""Where the members of an ensemble run: in this process, or on the workers of a Dask cluster.

A contact table reaches the workers of a cluster as the bytes of a table file, together with the profiles, so that workers need
no common files. The scheduler gives the work of a worker that dies to others. Members and records travel as one string of bytes
per task: the scheduler would unpickle them, which costs it more than the task.
"""
from __future__ import annotations

import functools
import pickle
import tempfile
import threading
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .._core.errors import Error
from .._core.optional import needed
from .._core.pools import PATIENCE
from ..case import Case
from ..table import PROFILES, ContactTable, core_files
from .members import Member, Record, TableKey, Wanted, groups_of, run_members, table_keys

if TYPE_CHECKING:
    import distributed

AHEAD = 3           # tasks of a thread, so that it has some while this process hands on what is done
MOST = 20           # members of a task on a cluster: a scheduler does some hundred tasks per second
CONNECT = 30        # wait for the scheduler [s]
TABLES_KEPT = 4     # by a worker process


class Here:
    """The threads of this process. A thread that needs a table waits for the one that builds it."""

    died: Any = ()      # what tells that workers die again and again
    most = 1            # members of a task

    def __init__(self, threads: int) -> None:
        self._threads, self._stop = threads, threading.Event()
        self._pool = ThreadPoolExecutor(threads, "ldbench ensemble")

    def _tell(self, stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if self._stop.is_set():
            raise Error("stopped")

    def threads(self) -> int:
        """Members that can run at the same time."""
        return self._threads

    def build(self, case: Case) -> Future[ContactTable]:
        """The table of a case, for `run`."""
        return self._pool.submit(ContactTable.quiet, case, self._tell)

    def run(self, members: Sequence[Member], table: Future[ContactTable] | ContactTable | None, wanted: Wanted) -> Future[bytes]:
        """The pickled records of members of one table; an Error where the table cannot be made."""
        def work() -> bytes:
            made = table.result() if isinstance(table, Future) else table
            return pickle.dumps(run_members(members, made, wanted, self._tell))

        return self._pool.submit(work)

    def close(self) -> None:
        """Stop what runs; what has not begun is not done."""
        self._stop.set()
        self._pool.shutdown(cancel_futures=True)


class Cluster:
    """The workers of a Dask cluster."""

    most = MOST

    def __init__(self, scheduler: str) -> None:
        distributed = needed("distributed", "ensemble", "dask[distributed]")
        self.died = distributed.KilledWorker
        try:
            kind, place = distributed.comm.parse_address(scheduler)
            if kind in {"tcp", "tls"}:
                distributed.comm.parse_host_port(place)
            check_security(scheduler, distributed.Security())
            # A table is larger than what Dask finds unusual to send.
            needed("dask", "ensemble").config.set({"distributed.admin.large-graph-warning-threshold": "1GB"})
            self._client = distributed.Client(scheduler, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as error:
            raise Error(f"{scheduler}: expected a Dask scheduler, found none: {error}") from None
        self._pool = self._client.get_executor(pure=False)

    def threads(self) -> int:
        """Members that can run at the same time; workers come and go."""
        return max(1, sum(self._client.nthreads().values()))

    def build(self, case: Case) -> distributed.Future | None:
        """The table of a case, which stays on the workers, for `run`; None where the profiles cannot be read, as runs will say."""
        try:
            return self._client.submit(build_there, files_of(case), pure=False)
        except (Error, OSError):
            return None

    def run(self, members: Sequence[Member], table: distributed.Future | None, wanted: Wanted) -> Future[bytes]:
        """The pickled records of members of one table; an Error where the table cannot be made."""
        return self._pool.submit(run_there, pickle.dumps(members), table, wanted)

    def close(self) -> None:
        """Leave the cluster; what has not begun is not done."""
        self._client.close()


def check_security(scheduler: str, security: distributed.Security) -> None:
    """Find out what a client of Dask's configuration would trip over, and then try to close for a minute."""
    found = security.get_connection_args("client")
    if scheduler.startswith("tls://"):
        if not found.get("ssl_context"):
            raise Error(f"{scheduler}: expected certificates in Dask's configuration, distributed.comm.tls, found none")
    elif found.get("require_encryption"):
        raise Error(f"{scheduler}: expected tls://, which Dask's configuration requires")


class Files(NamedTuple):
    """A contact table on its way: a case, and the contents of its profiles and its table file by the names of the variables. The
    table of a right side that differs has a file of its own, whose name ends with '.right'."""

    case: Case
    contents: tuple[tuple[str, bytes], ...]

    def write(self, folder: str) -> dict[str, str]:
        """Write all files to a folder; their paths by variable."""
        for name, data in self.contents:
            Path(folder, name).write_bytes(data)
        return dict.fromkeys(PROFILES, "") | {name: f"{folder}/{name}" for name, _ in self.contents if name in PROFILES}


def files_of(case: Case) -> Files:
    """What a worker needs to make the table of a case, with what its table file holds."""
    tables = {f"table_file{end}": case.table_path() + end for end in ("", ".right")}
    found = core_files(case) | {name: path for name, path in tables.items() if Path(path).is_file()}
    return Files(case, tuple((name, Path(path).read_bytes()) for name, path in found.items()))


def build_there(files: Files) -> Files:
    """The files with the contact table, which this worker loads or builds."""
    with tempfile.TemporaryDirectory() as folder:
        case = files.case.replace({**files.write(folder), "table_file": f"{folder}/table_file"})
        ContactTable.quiet(case)
        return files_of(case)


@functools.lru_cache(TABLES_KEPT)
def load_there(files: Files) -> tuple[ContactTable, dict[str, str], tempfile.TemporaryDirectory[str]]:
    """The contact table in this process, the paths of the profiles by variable, and the folder that has them."""
    folder = tempfile.TemporaryDirectory()
    paths = files.write(folder.name)
    return ContactTable.quiet(files.case.replace({**paths, "table_file": f"{folder.name}/table_file"})), paths, folder


def run_there(pickled: bytes, files: Files | None, wanted: Wanted) -> bytes:
    """Run members on this worker, pickled as their records are."""
    table, paths, _ = load_there(files) if files else (None, {}, None)
    return pickle.dumps(run_members(pickle.loads(pickled), table, wanted, files=paths))


def run_missing(members: Sequence[Member], missing: Sequence[int], base: object, tables: Iterable[ContactTable], wanted: Wanted,
                scheduler: str | None, threads: int) -> Generator[tuple[int, Record]]:
    """Numbers of members that are missing and their records, as they come. No more tasks are handed in than keep the threads or
    the cluster busy. base: the case whose table file it is."""
    if not missing:
        return
    key = table_keys()
    at_hand: dict[TableKey | None, ContactTable] = {} if scheduler else {key(table.case): table for table in tables}
    place = Cluster(scheduler) if scheduler else Here(threads)
    tasks = tasks_of(groups_of(members, missing, base), at_hand, place)
    going: dict[Future[bytes], list[int]] = {}
    try:
        while True:
            for table, numbers in islice(tasks, max(0, AHEAD*place.threads() - len(going))):
                going[place.run([members[k] for k in numbers], table, wanted)] = numbers
            if not going:
                return
            for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
                numbers = going.pop(future)
                try:
                    records = pickle.loads(future.result())
                except Error as error:
                    records = [{"error": str(error)}]*len(numbers)
                yield from zip(numbers, records, strict=True)
    except place.died as error:
        raise Error(f"ensemble: workers died again and again at the same task: {error}") from None
    finally:
        place.close()


def tasks_of(groups: Iterable[tuple[TableKey | None, Case | None, list[int]]], tables: Mapping[TableKey | None, ContactTable],
             place: Here | Cluster) -> Iterator[tuple[Any, list[int]]]:
    """A table and the numbers of members that a task runs with it: fewer at the end, so that all threads end together. A table
    that is not at hand is asked for with its first task."""
    for key, case, left in groups:
        table = tables.get(key) or (place.build(case) if case else None)
        while left:
            size = max(1, min(place.most, len(left)//(AHEAD*place.threads())))
            yield table, left[:size]
            left = left[size:]
