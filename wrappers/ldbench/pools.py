"""Work side by side, in threads or processes of this machine."""
from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool, ProcessPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from ._core import PATIENCE, Error, Progress, look_for_memory, usable_cores

Task = TypeVar("Task")
Result = TypeVar("Result")


def in_threads(work: Callable[[Task, Progress], Result], tasks: Sequence[Task], workers: int,
               done: Callable[[Task, Result], object]) -> None:
    """Do `work(task, tell)` in threads, in the order of the tasks; `done(task, result)` is called here after each.

    When one fails with an Error, those at work are waited for, the others are not begun. At Ctrl-C `tell`, which runs
    take for their progress, stops them too; an executable gets it by itself.
    """
    stop = threading.Event()

    def tell(stage: str, share: float) -> None:
        if stop.is_set():
            raise Error("stopped")

    workers = max(1, min(workers, len(tasks)))
    look_for_memory(workers)
    with ThreadPoolExecutor(workers) as pool:
        try:
            going = {pool.submit(work, task, tell): task for task in tasks}
            while going:
                for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
                    done(going.pop(future), future.result())
        except BaseException as error:
            if not isinstance(error, Error):
                stop.set()
            pool.shutdown(cancel_futures=True)
            raise


@contextmanager
def processes(jobs: int | None, tasks: int) -> Iterator[ProcessPoolExecutor]:
    """So many processes, or one per core, that take work; no more than there are tasks."""
    look_for_memory(2)      # the pool's own threads
    try:
        with ProcessPoolExecutor(max(1, min(jobs or usable_cores(), tasks))) as pool:
            try:
                yield pool
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    except BrokenProcessPool:
        raise Error("a process that read or drew was ended, as systems do where memory ends") from None
