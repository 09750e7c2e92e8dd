"""An ensemble in the threads of this process."""
from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Generator, Iterable, Sequence

from .._core.errors import Error
from .._core.pools import PATIENCE
from ..table import ContactTable
from .members import Batch, Group, Member, Wanted, contents, run_member, stack, table_key


class Stopped(Exception):
    """Ends a thread's work when the ensemble is stopped."""


class Schedule:
    """Which thread does what next.

    The core builds one table at a time, so one thread is kept building while the others run members; no more
    than one table is made ahead.
    """

    def __init__(self, groups: Sequence[Group], tables: Iterable[ContactTable]) -> None:
        self.condition = threading.Condition()
        self.stopped = False
        self.building = False
        self.unbuilt: deque[Group] = deque()
        self.ready: deque[tuple[ContactTable, deque[int]]] = deque()
        at_hand = {table_key(table.case, contents): table for table in tables}
        for group in groups:
            if at_hand and (table := at_hand.get(table_key(group.case, contents))):
                self.ready.append((table, deque(group.numbers)))
            else:
                self.unbuilt.append(group)

    def next(self) -> tuple[ContactTable, int] | Group | None:
        """A table and the member to run, or a group to build one for; nothing at the end."""
        with self.condition:
            while True:
                if self.stopped:
                    raise Stopped
                if self.unbuilt and not self.building and len(self.ready) < 2:
                    self.building = True
                    return self.unbuilt.popleft()
                if self.ready:
                    table, numbers = self.ready[0]
                    number = numbers.popleft()
                    if not numbers:
                        self.ready.popleft()
                    return table, number
                if not self.building and not self.unbuilt:
                    return None
                self.condition.wait()

    def built(self, table: ContactTable | None, group: Group) -> None:
        """Note that a table is built, or could not be, and wake the waiting threads."""
        with self.condition:
            self.building = False
            if table:
                self.ready.append((table, deque(group.numbers)))
            self.condition.notify_all()

    def stop(self) -> None:
        """Stop all threads as soon as they look."""
        with self.condition:
            self.stopped = True
            self.condition.notify_all()

    def tell(self, stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if self.stopped:
            raise Stopped


def run_in_threads(members: Sequence[Member], groups: Sequence[Group], tables: Iterable[ContactTable], threads: int,
                   wanted: Wanted) -> Generator[tuple[list[int], Batch]]:
    """Numbers of members and their records as they come."""
    schedule = Schedule(groups, tables)
    total = sum(len(group.numbers) for group in groups)
    done: queue.SimpleQueue[tuple[list[int], Batch] | BaseException] = queue.SimpleQueue()

    def build(group: Group) -> None:
        table = None
        try:
            table = ContactTable.quiet(group.case, schedule.tell)
        except Error as error:
            done.put((group.numbers, stack([{"error": str(error)}]*len(group.numbers))))
        finally:
            schedule.built(table, group)

    def work() -> None:
        try:
            while todo := schedule.next():
                if isinstance(todo, Group):
                    build(todo)
                else:
                    table, number = todo
                    done.put(([number], stack([run_member(members[number], table, wanted, schedule.tell)])))
        except Stopped:
            pass
        except BaseException as error:
            done.put(error)

    pool = [threading.Thread(target=work, name="ldbench ensemble") for _ in range(min(threads, total))]
    try:
        for thread in pool:
            thread.start()
        while total:
            try:
                result = done.get(timeout=PATIENCE)
            except queue.Empty:
                continue
            if isinstance(result, BaseException):
                raise result
            total -= len(result[0])
            yield result
    finally:
        schedule.stop()
        for thread in pool:
            if thread.ident:
                thread.join()
