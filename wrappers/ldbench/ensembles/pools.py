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
from collections import deque
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
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
MOST = 1000         # tasks on a cluster, each of which a thread of this process waits for
PIECE = 1.0         # work of a task on a cluster [s], longer with more threads than RATE
SHORTEST = 0.05     # work of the last tasks [s]
RATE = 100          # tasks per second that a scheduler can do
COUNT = 1.0         # between two looks at the workers [s]
CONNECT = 30        # wait for the scheduler [s]
TABLES_KEPT = 4     # by a worker process


class Here:
    """The threads of this process."""

    def __init__(self, threads: int) -> None:
        self.workers, self._stop = threads, threading.Event()

    def _tell(self, stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if self._stop.is_set():
            raise Error("stopped")

    def threads(self) -> int:
        """Members that can run at the same time."""
        return self.workers

    def tables(self) -> int:
        """Tables that are built ahead. The core builds one at a time, so one thread builds while the others run members."""
        return 1

    def size(self, left: int) -> int:
        """How many of the members that are left make a task."""
        return 1

    def build(self, case: Case) -> ContactTable:
        """The table of a case, for `run`."""
        return ContactTable.quiet(case, self._tell)

    def run(self, members: Sequence[Member], table: ContactTable, wanted: Wanted) -> list[Record]:
        """The records of members of one table."""
        return run_members(members, table, wanted, self._tell)

    def close(self) -> None:
        """Stop what runs."""
        self._stop.set()


class Cluster:
    """The workers of a Dask cluster. Tasks take about a second, by the time of members that have run, and less at the end, so that
    the workers end together."""

    workers = MOST

    def __init__(self, scheduler: str) -> None:
        self._distributed = distributed = needed("distributed", "ensemble", "dask[distributed]")
        self._scheduler, self._counted, self._threads, self._seconds = scheduler, -math.inf, 1, 0.0
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

    def threads(self) -> int:
        """Members that can run at the same time; workers come and go."""
        if time.monotonic() > self._counted + COUNT:
            self._threads, self._counted = max(1, sum(self._client.nthreads().values())), time.monotonic()
        return self._threads

    tables = threads

    def size(self, left: int) -> int:
        """How many of the members that are left make a task."""
        if not self._seconds:
            return 1
        longest, share = PIECE*max(1.0, self._threads/RATE), left*self._seconds/(AHEAD*self._threads)
        return max(1, int(min(longest, max(share, SHORTEST))/self._seconds))

    def build(self, case: Case) -> distributed.Future:
        """The table of a case, which stays on the workers, for `run`."""
        table = self._client.submit(build_there, files_of(case), pure=False)
        with self._dying():
            if error := table.exception():
                raise error
        return table

    def run(self, members: Sequence[Member], table: distributed.Future, wanted: Wanted) -> list[Record]:
        """The records of members of one table."""
        with self._dying():
            done = self._client.submit(run_there, pickle.dumps(members), table, wanted, pure=False).result()
        records: list[Record]
        records, self._seconds = pickle.loads(done)
        return records

    @contextmanager
    def _dying(self) -> Iterator[None]:
        try:
            yield
        except self._distributed.KilledWorker as error:
            raise Error(f"{self._scheduler}: workers died again and again at the same task: {error}") from None

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


def run_there(pickled: bytes, files: Files, wanted: Wanted) -> bytes:
    """Run members on this worker: their records and the time that a member took [s], pickled both ways."""
    table, paths, _ = load_there(files)
    begin = time.perf_counter()
    records = run_members(pickle.loads(pickled), table, wanted, files=paths)
    return pickle.dumps((records, (time.perf_counter() - begin)/len(records)))


def run_groups(members: Sequence[Member], groups: Iterable[Group], tables: Mapping[TableKey, ContactTable], place: Here | Cluster,
               wanted: Wanted) -> Generator[tuple[list[int], list[Record]]]:
    """Numbers of members and their records as they come; `tables` by their keys are at hand.

    A thread of this process does each task, or waits for it. No more tasks are handed in than keep the place busy.
    """
    waiting = deque(groups)
    ready: deque[tuple[Any, deque[int]]] = deque()              # tables, and the members that have not begun
    going: dict[Future[Any], Group | list[int]] = {}            # tables and members that are under way
    with ThreadPoolExecutor(place.workers, "ldbench ensemble") as pool:
        try:
            while waiting or ready or going:
                while len(going) < AHEAD*place.threads():
                    building = sum(isinstance(what, Group) for what in going.values())
                    if waiting and building + len(ready) <= place.tables():
                        group = waiting.popleft()
                        if group.case is None:
                            yield group.numbers, run_members([members[k] for k in group.numbers], None, wanted)
                        elif group.key in tables:
                            ready.append((tables[group.key], deque(group.numbers)))
                        else:
                            going[pool.submit(place.build, group.case)] = group
                    elif ready:
                        table, left = ready[0]
                        numbers = [left.popleft() for _ in range(min(len(left), place.size(len(left))))]
                        if not left:
                            ready.popleft()
                        going[pool.submit(place.run, [members[k] for k in numbers], table, wanted)] = numbers
                    else:
                        break
                for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
                    done = going.pop(future)
                    if isinstance(done, list):
                        yield done, future.result()
                        continue
                    try:
                        ready.append((future.result(), deque(done.numbers)))
                    except Error as error:
                        yield done.numbers, [{"error": str(error)}]*len(done.numbers)
        finally:
            place.close()
            pool.shutdown(cancel_futures=True)
