"""An ensemble in the threads of this process."""
from __future__ import annotations

import queue
import threading
from collections.abc import Generator, Iterable, Sequence

from ._core import Error
from .members import Member, Record, Wanted, by_table, members_of, run_member
from .table import ContactTable


class Stopped(Exception):
    """Ends a thread's work when the ensemble is stopped."""


class Schedule:
    """Which thread does what next.

    The core builds one table at a time, so one thread is kept building while the others run members; no more
    than one table is made ahead.
    """

    def __init__(self, members: Sequence[Member], tables: Iterable[ContactTable]) -> None:
        self.condition = threading.Condition()
        self.stopped = False
        self.building = False
        self.unbuilt = by_table(members)
        self.ready: list[tuple[ContactTable, list[Member]]] = []
        at_hand = {member.table: table for table in tables for member in members_of([table.case], Wanted())}
        for key in list(self.unbuilt):
            if key in at_hand:
                self.ready.append((at_hand[key], self.unbuilt.pop(key)))

    def next(self) -> tuple[ContactTable | None, list[Member]]:
        """A table and one member to run, or no table and the members to build one for; nothing at the end."""
        with self.condition:
            while True:
                if self.stopped:
                    raise Stopped
                if self.unbuilt and not self.building and len(self.ready) < 2:
                    self.building = True
                    return None, self.unbuilt.pop(next(iter(self.unbuilt)))
                if self.ready:
                    table, members = self.ready[0]
                    member = members.pop(0)
                    if not members:
                        self.ready.pop(0)
                    return table, [member]
                if not self.building and not self.unbuilt:
                    return None, []
                self.condition.wait()

    def built(self, table: ContactTable | None, members: list[Member]) -> None:
        with self.condition:
            self.building = False
            if table:
                self.ready.append((table, list(members)))
            self.condition.notify_all()

    def stop(self) -> None:
        with self.condition:
            self.stopped = True
            self.condition.notify_all()

    def tell(self, stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if self.stopped:
            raise Stopped


def run_in_threads(members: Sequence[Member], tables: Iterable[ContactTable], threads: int, wanted: Wanted,
                   ) -> Generator[tuple[Member, Record]]:
    """Members and their records as they come."""
    schedule = Schedule(members, tables)
    done: queue.SimpleQueue[tuple[Member, Record] | BaseException] = queue.SimpleQueue()

    def build(group: list[Member]) -> None:
        table = None
        try:
            table = ContactTable(group[0].table_case, schedule.tell)
        except Error as error:
            for member in group:
                done.put((member, {"error": str(error)}))
        finally:
            schedule.built(table, group)

    def work() -> None:
        try:
            while True:
                table, group = schedule.next()
                if table:
                    done.put((group[0], run_member(group[0].case, table, wanted, schedule.tell)))
                elif group:
                    build(group)
                else:
                    return
        except Stopped:
            pass
        except BaseException as error:
            done.put(error)

    pool = [threading.Thread(target=work, name="ldbench ensemble") for _ in range(min(threads, len(members)))]
    try:
        for thread in pool:
            thread.start()
        for _ in members:
            result = done.get()
            if isinstance(result, BaseException):
                raise result
            yield result
    finally:
        schedule.stop()
        for thread in pool:
            if thread.ident:
                thread.join()
