"""An ensemble on the workers of a Dask cluster.

Every contact table reaches the workers as the bytes of a table file, together with the profiles: of the case's table
file, or of one that a worker made. So workers need no common file system. When a worker dies, the scheduler gives what
it had to others.

Tasks last about 1 s, by the time that the ones before took; longer with many workers, to spare the scheduler. No more
of them are under way than keep the workers busy: neither client nor scheduler holds what is not begun yet. Members
and records travel as one string of bytes per piece: the scheduler would unpickle the ones, and an array of its own
for each figure costs it more than the task.
"""
from __future__ import annotations

import itertools
import math
import pickle
import tempfile
import threading
import time
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from .._core.errors import Error
from .._core.files import digest
from .._core.optional import needed
from ..case import Case
from ..table import ContactTable, core_files
from .members import Batch, Group, Member, Wanted, run_member, stack

if TYPE_CHECKING:
    import distributed

PIECE = 1.0                 # a task's work [s]
SHORTEST = 0.05             # that of the last ones [s]
RATE = 200                  # tasks per second that a scheduler can do; at 5 ms each
AHEAD = 2                   # tasks that a thread of a worker has, one of which waits
TABLES_KEPT = 4             # by a worker process
COUNT = 1.0                 # between two looks at the workers [s]
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
        return self.case.replace({name: f"{folder}/{name}" for name in (*self.profiles, "table_file")})


@dataclass(frozen=True)
class Loaded:
    """A contact table of this process, and the folder that holds its profiles."""

    table: ContactTable
    folder: tempfile.TemporaryDirectory[str]

    def localised(self, case: Case) -> Case:
        """The case with the profiles of this process."""
        there = {name: Path(self.folder.name, name) for name in case.profile_files()}
        # A right side with the same contents as the left one may go without a file of its own.
        return case._with({name: str(file if file.exists() else file.with_name(name.removesuffix("_right")))
                           for name, file in there.items()})


_loaded: dict[str, Loaded] = {}
_loading = threading.Lock()


def build_table(source: TableFile) -> TableFile:
    """The files with the contact table, which this worker loads or builds."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            ContactTable.quiet(source.place(folder))
        except Error as error:
            return TableFile(source.case, {}, {}, error=str(error))
        return TableFile(source.case, source.profiles, tables_at(f"{folder}/table_file"))


def tables_at(path: str) -> dict[str, bytes]:
    """Contact tables of a table file."""
    return {end: Path(path + end).read_bytes() for end in ("", ".right") if Path(path + end).is_file()}


def load_table(source: TableFile) -> Loaded:
    """The contact table of the files, loaded once per process."""
    key = digest(b"".join(source.tables.values()))
    with _loading:
        if key not in _loaded:
            folder = tempfile.TemporaryDirectory()
            _loaded[key] = Loaded(ContactTable.quiet(source.place(folder.name)), folder)
            for old in list(_loaded)[:-TABLES_KEPT]:
                del _loaded[old]
        return _loaded[key]


def run_piece(pickled: bytes, source: TableFile, wanted: Wanted) -> bytes:
    """Run some members of one table on this worker: their records and the time that they took [s], pickled both ways."""
    members: list[Member] = pickle.loads(pickled)
    if source.error:
        return pickle.dumps((stack([{"error": source.error}]*len(members)), 0.0))
    loaded = load_table(source)
    begin = time.perf_counter()
    batch = stack([run_member(member, loaded.table, wanted, place=loaded.localised) for member in members])
    return pickle.dumps((batch, time.perf_counter() - begin))


class Pieces:
    """What goes to the workers next: members of one table, about a second of work by the time that others of it took.

    At the end ever less, so that the workers end together: C. D. Polychronopoulos and D. J. Kuck, IEEE Trans. Comput.
    C-36 (1987) 1425-1439.
    """

    def __init__(self, groups: Sequence[Group]) -> None:
        self.left = [Left(group) for group in groups]

    def next(self, threads: int) -> tuple[Left, list[int]] | None:
        """Nothing while it is not known how long the members take that could go."""
        trials = max(1, threads//max(1, len(self.left)))
        # As many tables as threads are made ahead, and no more.
        for own in self.left[:threads + 1]:
            if own.measured or own.trials < trials:
                own.trials += 1
                piece = own.take(piece_size(len(own), threads, own.seconds()))
                if not len(own):
                    self.left.remove(own)
                return own, piece
        return None


class Left:
    """Members of one table that have not gone yet, and what is known of those that went."""

    def __init__(self, group: Group) -> None:
        self.group = group
        self.first = self.trials = self.measured = 0
        self.time = 0.0                     # of the measured ones [s]
        self.table: object = None           # the future

    def __len__(self) -> int:
        return len(self.group.numbers) - self.first

    def take(self, size: int) -> list[int]:
        """Take the numbers of the next members away."""
        self.first += size
        return self.group.numbers[self.first - size:self.first]

    def add(self, members: int, time: float) -> None:
        """Count members that took so much time together [s]."""
        self.measured += members
        self.time += time

    def seconds(self) -> float:
        """The time of a member [s]; 0 where none is measured."""
        return max(self.time/self.measured, 1e-6) if self.measured else 0.0


def piece_size(left: int, threads: int, seconds: float) -> int:
    """How many of the members that are left go next, if one takes so many seconds; 0: not known yet."""
    if seconds <= 0:
        return 1
    time = min(PIECE, max(left*seconds/(AHEAD*threads), SHORTEST))
    return min(left, max(1, int(time/seconds), math.ceil(threads/RATE/seconds)))


def run_on_cluster(members: Sequence[Member], groups: Sequence[Group], scheduler: str, wanted: Wanted,
                   ) -> Generator[tuple[list[int], Batch]]:
    """Numbers of members and their records as they come."""
    distributed = needed("distributed", "ensemble", "dask[distributed]")
    try:
        kind, place = distributed.comm.parse_address(scheduler)
        if kind in {"tcp", "tls"}:
            distributed.comm.parse_host_port(place)
        check_security(scheduler, distributed.Security())
        client = distributed.Client(scheduler, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise Error(f"{scheduler}: expected a Dask scheduler, found none: {error}") from None
    # A table is larger than what Dask finds unusual to send.
    large = {"distributed.admin.large-graph-warning-threshold": "1GB"}
    with client, needed("dask", "ensemble").config.set(large):
        pieces = Pieces(groups)
        under_way: dict[object, tuple[Left, list[int]]] = {}
        done = distributed.as_completed(loop=client.loop, with_results=True)
        threads, counted = 1, -math.inf
        while pieces.left or under_way:
            if time.monotonic() > counted + COUNT:
                threads, counted = max(1, sum(client.nthreads().values())), time.monotonic()
            todo: dict[Left, list[list[int]]] = {}
            n = AHEAD*threads - len(under_way)
            for own, numbers in itertools.islice(iter(partial(pieces.next, threads), None), max(0, n)):
                todo.setdefault(own, []).append(numbers)
            for own, some in todo.items():
                try:
                    own.table = own.table or client.submit(build_table, table_source(own.group.case), pure=False)
                except Error as error:
                    own.table = TableFile(own.group.case, {}, {}, error=str(error))
                futures = client.map(run_piece, [pickle.dumps([members[k] for k in numbers]) for numbers in some],
                                     source=own.table, wanted=wanted, pure=False)
                under_way |= zip(futures, ((own, numbers) for numbers in some), strict=True)
                done.update(futures)
            try:
                for future, pickled in done.next_batch():
                    batch, seconds = pickle.loads(pickled)
                    own, numbers = under_way.pop(future)
                    own.add(len(numbers), seconds)
                    yield numbers, batch
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


def table_source(case: Case) -> TableFile:
    """What a worker needs to make the case's table: with what its table file holds."""
    def read(path: str) -> bytes:
        try:
            return Path(path).read_bytes()
        except OSError as error:
            raise Error(f"{path}: cannot be opened for reading: {error.strerror}") from None

    kept = case.table_path()
    return TableFile(case, {name: read(file) for name, file in core_files(case).items()}, tables_at(kept) if kept else {})
