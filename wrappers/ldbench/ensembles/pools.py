"""Where the members of an ensemble run: in this process, or on the workers of a Dask cluster.

A contact table reaches the workers of a cluster as the bytes of a table file, together with the profiles, so that workers need
no common files. The scheduler gives the work of a worker that dies to others. Members and records travel as one string of bytes
per task: the scheduler would unpickle them, which costs it more than the task.
"""
from __future__ import annotations

import functools
import math
import pickle
import tempfile
import threading
import time
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
from .members import Group, Member, Record, TableKey, Wanted, run_members

if TYPE_CHECKING:
    import distributed

AHEAD = 3           # tasks of a thread, so that it has some while this process hands on what is done
PIECE = 1.0         # work of a task on a cluster [s], longer with more threads than RATE
SHORTEST = 0.05     # work of the last tasks [s]
RATE = 100          # tasks per second that a scheduler can do
COUNT = 1.0         # between two looks at the workers [s]
CONNECT = 30        # wait for the scheduler [s]
TABLES_KEPT = 4     # by a worker process


class Here:
    """The threads of this process. A thread that needs a table waits for the one that builds it."""

    died: Any = ()      # what tells that workers die again and again

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

    def size(self, left: int) -> int:
        """How many of the members that are left make a task."""
        return 1

    def build(self, case: Case) -> Future[ContactTable]:
        """The table of a case, for `run`."""
        return self._pool.submit(ContactTable.quiet, case, self._tell)

    def run(self, members: Sequence[Member], table: Future[ContactTable] | ContactTable | None,
            wanted: Wanted) -> Future[list[Record]]:
        """The records of members of one table."""
        def work() -> list[Record]:
            return run_members(members, table.result() if isinstance(table, Future) else table, wanted, self._tell)

        return self._pool.submit(work)

    def records(self, done: Future[list[Record]]) -> list[Record]:
        """What a task has brought; an Error where its table cannot be made."""
        return done.result()

    def close(self) -> None:
        """Stop what runs; what has not begun is not done."""
        self._stop.set()
        self._pool.shutdown(cancel_futures=True)


class Cluster:
    """The workers of a Dask cluster. Tasks take about a second, by the time of members that have run, and less at the end, so that
    the workers end together."""

    def __init__(self, scheduler: str) -> None:
        distributed = needed("distributed", "ensemble", "dask[distributed]")
        self.died = distributed.KilledWorker
        self._counted, self._threads, self._seconds = -math.inf, 1, 0.0
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
        if time.monotonic() > self._counted + COUNT:
            self._threads, self._counted = max(1, sum(self._client.nthreads().values())), time.monotonic()
        return self._threads

    def size(self, left: int) -> int:
        """How many of the members that are left make a task."""
        if not self._seconds:
            return 1
        longest, share = PIECE*max(1.0, self._threads/RATE), left*self._seconds/(AHEAD*self._threads)
        return max(1, int(min(longest, max(share, SHORTEST))/self._seconds))

    def build(self, case: Case) -> distributed.Future | None:
        """The table of a case, which stays on the workers, for `run`; None where the profiles cannot be read, as runs will say."""
        try:
            return self._client.submit(build_there, files_of(case), pure=False)
        except Error:
            return None

    def run(self, members: Sequence[Member], table: distributed.Future | None, wanted: Wanted) -> Future[bytes]:
        """The records of members of one table."""
        return self._pool.submit(run_there, pickle.dumps(members), table, wanted)

    def records(self, done: Future[bytes]) -> list[Record]:
        """What a task has brought; an Error where its table cannot be made."""
        records: list[Record]
        records, self._seconds = pickle.loads(done.result())
        return records

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
    """A contact table on its way: a case, and the contents of its profiles, by variable, and of its table file, by what the names
    of the parts end with: '', and '.right' of a right side that differs."""

    case: Case
    profiles: tuple[tuple[str, bytes], ...]
    tables: tuple[tuple[str, bytes], ...]

    def table_in(self, folder: str) -> tuple[ContactTable, dict[str, str]]:
        """The table, loaded or built with all files in a folder, and the paths of the profiles there by variable."""
        for name, data in (*self.profiles, *((f"table_file{end}", data) for end, data in self.tables)):
            Path(folder, name).write_bytes(data)
        paths = dict.fromkeys(PROFILES, "") | {name: f"{folder}/{name}" for name, _ in self.profiles}
        return ContactTable.quiet(self.case.replace(paths | {"table_file": f"{folder}/table_file"})), paths


def files_of(case: Case) -> Files:
    """What a worker needs to make the table of a case, with what its table file holds."""
    def read(path: str) -> bytes:
        try:
            return Path(path).read_bytes()
        except OSError as error:
            raise Error(f"{path}: cannot be opened for reading: {error.strerror}") from None

    return Files(case, tuple((name, read(path)) for name, path in core_files(case).items()), tables_at(case.table_path()))


def tables_at(path: str) -> tuple[tuple[str, bytes], ...]:
    """Contact tables of a table file."""
    return tuple((end, Path(path + end).read_bytes()) for end in ("", ".right") if path and Path(path + end).is_file())


def build_there(files: Files) -> Files:
    """The files with the contact table, which this worker loads or builds."""
    with tempfile.TemporaryDirectory() as folder:
        files.table_in(folder)
        return files._replace(tables=tables_at(f"{folder}/table_file"))


@functools.lru_cache(TABLES_KEPT)
def load_there(files: Files) -> tuple[ContactTable, dict[str, str], tempfile.TemporaryDirectory[str]]:
    """The contact table in this process, the paths of the profiles by variable, and the folder that has them."""
    folder = tempfile.TemporaryDirectory()
    return *files.table_in(folder.name), folder


def run_there(pickled: bytes, files: Files | None, wanted: Wanted) -> bytes:
    """Run members on this worker: their records and the time that a member took [s], pickled both ways."""
    table, paths, _ = load_there(files) if files else (None, {}, None)
    begin = time.perf_counter()
    records = run_members(pickle.loads(pickled), table, wanted, files=paths)
    return pickle.dumps((records, (time.perf_counter() - begin)/len(records)))


def run_groups(members: Sequence[Member], groups: Iterable[Group], tables: Mapping[TableKey, ContactTable], place: Here | Cluster,
               wanted: Wanted) -> Generator[tuple[list[int], list[Record]]]:
    """Numbers of members and their records as they come; `tables` by their keys are at hand. No more tasks are handed in than keep
    the place busy."""
    tasks = tasks_of(groups, tables, place)
    going: dict[Future[Any], list[int]] = {}
    try:
        while True:
            for table, numbers in islice(tasks, max(0, AHEAD*place.threads() - len(going))):
                going[place.run([members[k] for k in numbers], table, wanted)] = numbers
            if not going:
                return
            for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
                numbers = going.pop(future)
                try:
                    records = place.records(future)
                except Error as error:
                    records = [{"error": str(error)}]*len(numbers)
                yield numbers, records
    except place.died as error:
        raise Error(f"ensemble: workers died again and again at the same task: {error}") from None
    finally:
        place.close()


def tasks_of(groups: Iterable[Group], tables: Mapping[TableKey, ContactTable],
             place: Here | Cluster) -> Iterator[tuple[Any, list[int]]]:
    """A table and the numbers of members that a task runs with it. A table that is not at hand is asked for with its first task."""
    for group in groups:
        table = tables.get(group.key) or (place.build(group.case) if group.case else None)
        begun = 0
        while begun < len(group.numbers):
            end = begun + place.size(len(group.numbers) - begun)
            yield table, group.numbers[begun:end]
            begun = end
