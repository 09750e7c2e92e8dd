"""Where the members of an ensemble run: in this process, or on the workers of a Dask cluster.

A contact table is made by one worker of a cluster and reaches the others as the bytes of its files, together with the profiles, so
that workers need no common files. The scheduler gives the work of a worker that dies to others. Members and records travel as one
string of bytes per task: the scheduler would unpickle them, which costs it more than the task.
"""
from __future__ import annotations

import functools
import pickle
import tempfile
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from .._core.calls import Progress
from .._core.errors import Error
from .._core.files import read_bytes
from .._core.optional import needed
from .._core.pools import AHEAD, as_they_come, in_threads
from ..case import Case
from ..runs import compute
from ..table import FILES, ContactTable, core_files
from .members import Group, Member, Record, TableKey, Wanted, run_member

if TYPE_CHECKING:
    import distributed

MOST = 20           # members of a task on a cluster: a scheduler does some hundred tasks per second
CONNECT = 30        # wait for the scheduler [s]
TABLES_KEPT = 4     # by a worker process


def run_here(members: Sequence[Member], groups: Iterable[Group], tables: Mapping[TableKey | None, ContactTable], wanted: Wanted,
             threads: int) -> Generator[tuple[int, Record]]:
    """Numbers of members and their records as they come, in threads of this process. The first member that needs a table that is
    not at hand, in `tables`, makes it; the others wait for it."""
    def tasks() -> Iterator[tuple[int, Case | None, Future[ContactTable | None]]]:
        for key, case, numbers in groups:
            table: Future[ContactTable | None] = Future()
            if not case or key in tables:
                table.set_result(tables.get(key))
                case = None
            for number in numbers:
                yield number, case, table
                case = None

    def work(task: tuple[int, Case | None, Future[ContactTable | None]], tell: Progress) -> Record:
        number, case, table = task
        if case:
            try:
                table.set_result(ContactTable(case))
            except BaseException as error:      # which else the others would wait for
                table.set_exception(error)
        try:
            return run_member(members[number], table.result(), wanted, tell)
        except Error as error:
            return {"error": str(error)}

    for (number, *_), record in in_threads(work, tasks(), threads):
        yield number, record


def run_there(members: Sequence[Member], groups: Iterable[Group], wanted: Wanted, scheduler: str) -> Generator[tuple[int, Record]]:
    """Numbers of members and their records as they come, from a Dask cluster, whose workers come and go."""
    distributed = needed("distributed", "ensemble", "dask[distributed]")
    with connected(scheduler) as client:
        pool = client.get_executor(pure=False)

        def threads() -> int:
            return max(1, sum(client.nthreads().values()))

        def table_of(case: Case) -> Any:
            try:
                return client.submit(build_table, files_of(case), pure=False)
            except Error as error:
                return str(error)

        def tasks() -> Iterator[tuple[list[int], Any]]:
            for _, case, left in groups:
                table = case and table_of(case)
                while left:     # tasks are smaller at the end, so that all threads end together
                    size = max(1, min(MOST, len(left)//(AHEAD*threads())))
                    yield left[:size], table
                    left = left[size:]

        def submit(task: tuple[list[int], Any]) -> Future[bytes]:
            numbers, table = task
            return pool.submit(run_task, pickle.dumps([members[k] for k in numbers]), table, wanted)

        try:
            for (numbers, _), records in as_they_come(submit, tasks(), threads):
                yield from zip(numbers, pickle.loads(records), strict=True)
        except distributed.KilledWorker as error:
            raise Error(f"workers died again and again at the same task: {error}", place="ensemble") from None


def connected(scheduler: str) -> distributed.Client:
    """The client of a scheduler."""
    distributed = needed("distributed", "ensemble", "dask[distributed]")
    try:
        kind, place = distributed.comm.parse_address(scheduler)
        if kind in {"tcp", "tls"}:
            distributed.comm.parse_host_port(place)
        check_security(scheduler, distributed.Security())
        # A table is larger than what Dask finds unusual to send.
        needed("dask", "ensemble").config.set({"distributed.admin.large-graph-warning-threshold": "1GB"})
        return distributed.Client(scheduler, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise Error(file=scheduler, expected="a Dask scheduler", found=f"none: {error}") from None


def check_security(scheduler: str, security: distributed.Security) -> None:
    """Find out what a client of Dask's configuration would trip over, and then try to close for a minute."""
    found = security.get_connection_args("client")
    if scheduler.startswith("tls://"):
        if not found.get("ssl_context"):
            raise Error(file=scheduler, expected="certificates in Dask's configuration, distributed.comm.tls",
                        found="none")
    elif found.get("require_encryption"):
        raise Error(file=scheduler, expected="tls://, which Dask's configuration requires")


class Files(NamedTuple):
    """A contact table on its way: a case, the contents of its profiles by the names of the variables, and those of the table's
    files by the names of the files."""

    case: Case
    contents: tuple[tuple[str, bytes], ...]

    def write(self, folder: str) -> dict[str, str]:
        """Write all files to a folder; the paths of those that a run reads, by variable."""
        for name, data in self.contents:
            Path(folder, name).write_bytes(data)
        return dict.fromkeys(FILES, "") | {name: f"{folder}/{name}" for name, _ in self.contents if name in FILES}


def files_of(case: Case, tables: Iterable[Path] = ()) -> Files:
    """What a worker needs to make the table of a case, with what the files of tables hold."""
    found = core_files(case) | {path.name: str(path) for path in tables}
    return Files(case, tuple((name, read_bytes(Path(path))) for name, path in found.items()))


def build_table(files: Files) -> Files | str:
    """The files with the contact table that has what a run of the case needs; or why it cannot."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            case = files.case.replace({**files.write(folder), "table_folder": folder})
            compute(case)
            return files_of(case, Path(folder).glob("*.table"))
    except Error as error:
        return str(error)


@functools.lru_cache(TABLES_KEPT)
def load_table(files: Files) -> tuple[ContactTable, dict[str, str], tempfile.TemporaryDirectory[str]]:
    """The contact table in this process, the paths of the profiles by variable, and the folder that has them."""
    folder = tempfile.TemporaryDirectory()
    paths = files.write(folder.name)
    return ContactTable(files.case.replace({**paths, "table_folder": folder.name})), paths, folder


def run_task(pickled: bytes, files: Files | str | None, wanted: Wanted) -> bytes:
    """Run members on this worker; their records are pickled as they are."""
    members = pickle.loads(pickled)
    if isinstance(files, str):
        return pickle.dumps([{"error": files}]*len(members))
    table, paths, _ = load_table(files) if files else (None, {}, None)
    return pickle.dumps([run_member(member, table, wanted, files=paths) for member in members])
