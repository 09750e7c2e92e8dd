"""An ensemble on the workers of a Dask cluster.

Every contact table reaches the workers as the bytes of a table file, together with the profiles: of the case's table
file, or of one that a worker made. So workers need no common file system. When a worker dies, the scheduler gives what
it had to others.
"""
from __future__ import annotations

import tempfile
import threading
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ._core import Error, digest, needed
from .case import Case
from .members import Member, Record, Wanted, by_table, run_member
from .table import ContactTable

if TYPE_CHECKING:
    import distributed

PIECE = 16                  # members of a task, at most
TABLES_KEPT = 4             # by a worker process
CONNECT = 30                # wait for the scheduler [s]


@dataclass(frozen=True)
class TableFile:
    """A contact table on its way."""

    case: Case
    profiles: dict[str, bytes]              # by variable
    tables: dict[str, bytes]                # by what their names end with: '', and '.right' of a right side that differs
    error: str = ""                         # why there is none

    def place(self, folder: str) -> Case:
        """The case with all its files in `folder`."""
        for name, data in self.profiles.items():
            Path(folder, name).write_bytes(data)
        for end, data in self.tables.items():
            Path(folder, f"table_file{end}").write_bytes(data)
        return self.case.replace(**{name: f"{folder}/{name}" for name in (*self.profiles, "table_file")})


@dataclass(frozen=True)
class Loaded:
    """A contact table of this process, and the folder that holds its profiles."""

    table: ContactTable
    folder: tempfile.TemporaryDirectory[str]

    def localised(self, case: Case) -> Case:
        there = {name: Path(self.folder.name, name) for name in case.profile_files()}
        # A right side with the same contents as the left one may go without a file of its own.
        return case.replace(**{name: str(file if file.exists() else file.with_name(name.removesuffix("_right")))
                               for name, file in there.items()})


_loaded: dict[str, Loaded] = {}
_loading = threading.Lock()


def build_table(source: TableFile) -> TableFile:
    """On a worker: the same with the table that it needs."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            ContactTable(source.place(folder))
        except Error as error:
            return TableFile(source.case, {}, {}, error=str(error))
        return TableFile(source.case, source.profiles, tables_at(f"{folder}/table_file"))


def tables_at(path: str) -> dict[str, bytes]:
    """Contact tables of a table file."""
    return {end: Path(path + end).read_bytes() for end in ("", ".right") if Path(path + end).is_file()}


def load_table(source: TableFile) -> Loaded:
    key = digest(b"".join(source.tables.values()))
    with _loading:
        if key not in _loaded:
            folder = tempfile.TemporaryDirectory()
            _loaded[key] = Loaded(ContactTable(source.place(folder.name)), folder)
            for old in list(_loaded)[:-TABLES_KEPT]:
                del _loaded[old]
        return _loaded[key]


def run_piece(cases: Sequence[Case], source: TableFile, wanted: Wanted) -> list[Record]:
    """On a worker: some members of one table."""
    if source.error:
        return [{"error": source.error} for _ in cases]
    loaded = load_table(source)
    return [run_member(loaded.localised(case), loaded.table, wanted) for case in cases]


def pieces_of(members: Sequence[Member], workers: int) -> Generator[Sequence[Member]]:
    """Members cut into ever smaller pieces, so that the workers end together.

    C. D. Polychronopoulos and D. J. Kuck, IEEE Trans. Comput. C-36 (1987) 1425-1439.
    """
    done = 0
    while done < len(members):
        size = max(1, min(PIECE, (len(members) - done)//(2*workers)))
        yield members[done:done + size]
        done += size


def run_on_cluster(members: Sequence[Member], scheduler: str, wanted: Wanted) -> Generator[tuple[Member, Record]]:
    """Members and their records as they come."""
    distributed = needed("distributed", "ensemble", "dask[distributed]")
    try:
        check_security(scheduler, distributed.Security())
        client = distributed.Client(scheduler, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise Error(f"{scheduler}: expected a Dask scheduler, found none: {error}") from None
    # A table is larger than what Dask finds unusual to send.
    large = {"distributed.admin.large-graph-warning-threshold": "1GB"}
    with client, needed("dask", "ensemble").config.set(large):
        workers = max(1, len(client.nthreads()))
        pieces = {}
        for group in by_table(members).values():
            try:
                source = table_source(group[0])
            except Error as error:
                yield from ((member, {"error": str(error)}) for member in group)
                continue
            table = client.submit(build_table, source, pure=False)
            for piece in pieces_of(group, workers):
                future = client.submit(run_piece, [member.case for member in piece], table, wanted, pure=False)
                pieces[future] = piece
        try:
            for future, records in distributed.as_completed(list(pieces), client.loop, with_results=True):
                yield from zip(pieces.pop(future), records, strict=True)
        except distributed.KilledWorker as error:
            raise Error(f"{scheduler}: workers died again and again at the same task: {error}") from None


def check_security(scheduler: str, security: distributed.Security) -> None:
    """Find out what a client of Dask's configuration would trip over, and then try to close for a minute."""
    found = security.get_connection_args("client")
    if scheduler.startswith("tls://"):
        if not found.get("ssl_context"):
            raise Error(f"{scheduler}: expected certificates in Dask's configuration, distributed.comm.tls, found none")
    elif found.get("require_encryption"):
        raise Error(f"{scheduler}: expected tls://, which Dask's configuration requires")


def table_source(member: Member) -> TableFile:
    """What a worker needs to make the member's table: with it, if the case's table file may hold it."""
    def read(path: str) -> bytes:
        try:
            return Path(path).read_bytes()
        except OSError as error:
            raise Error(f"{path}: cannot be opened for reading: {error.strerror}") from None

    case = member.case
    kept = case.table_path() if member.in_file else ""
    return TableFile(case, {name: read(file) for name, file in case.profile_files().items()},
                     tables_at(kept) if kept else {})
