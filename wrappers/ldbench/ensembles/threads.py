"""An ensemble in the threads of this process."""
from __future__ import annotations

import threading
from collections import deque
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import Any

from .._core.errors import Error
from .._core.pools import PATIENCE
from ..table import ContactTable
from .members import Batch, Group, Member, Wanted, contents, run_member, stack, table_key

AHEAD = 4       # tasks of a thread, so that it has some while this one hands on what is done


class Stopped(Exception):
    """Ends a thread's work when the ensemble is stopped."""


def run_in_threads(members: Sequence[Member], groups: Sequence[Group], tables: Iterable[ContactTable], threads: int,
                   wanted: Wanted) -> Generator[tuple[list[int], Batch]]:
    """Numbers of members and their records as they come.

    The core builds one table at a time, so one thread builds while the others run members; no more than one table is made ahead.
    """
    stop = threading.Event()

    def tell(stage: str, share: float) -> None:
        """Progress of a table or a run; stops it."""
        if stop.is_set():
            raise Stopped

    at_hand = {table_key(table.case, contents): table for table in tables}
    known = [(group, at_hand.get(table_key(group.case, contents)) if at_hand else None) for group in groups]
    ready = deque((table, deque(group.numbers)) for group, table in known if table)
    unbuilt = deque(group for group, table in known if not table)
    going: dict[Future[Any], Group | int] = {}
    with ThreadPoolExecutor(max(1, min(threads, sum(len(group.numbers) for group in groups))), "ldbench ensemble") as pool:
        try:
            while going or ready or unbuilt:
                building = any(isinstance(what, Group) for what in going.values())
                while len(going) < AHEAD*threads:
                    if unbuilt and not building and len(ready) < 2:
                        group = unbuilt.popleft()
                        going[pool.submit(ContactTable.quiet, group.case, tell)] = group
                        building = True
                    elif ready:
                        table, numbers = ready[0]
                        number = numbers.popleft()
                        if not numbers:
                            ready.popleft()
                        going[pool.submit(run_member, members[number], table, wanted, tell)] = number
                    else:
                        break
                for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
                    what = going.pop(future)
                    if isinstance(what, int):
                        yield [what], stack([future.result()])
                        continue
                    try:
                        ready.append((future.result(), deque(what.numbers)))
                    except Error as error:
                        yield what.numbers, stack([{"error": str(error)}]*len(what.numbers))
        finally:
            stop.set()
            pool.shutdown(cancel_futures=True)
