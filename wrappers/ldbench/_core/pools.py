"""Work side by side, in threads or processes of this machine."""
from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from multiprocessing.connection import wait as wait_for
from typing import Any, TypeVar

from .calls import Progress
from .errors import Error

Task = TypeVar("Task")
Result = TypeVar("Result")

AHEAD = 3                   # tasks of a worker, so that it has some while this process hands on what is done
PATIENCE = 0.2              # between looks for Ctrl-C [s]: one that comes just before a wait begins does not end it
PROCESS_DIED = "a worker process died, probably out of memory"
FORKS = sys.platform == "linux"     # Windows has no fork; libraries of macOS, Accelerate among them, may hang in a forked process
PARENTS = signal.SIGINT, signal.SIGTERM     # that the parent ends its children by


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def as_they_come(submit: Callable[[Task], Future[Result]], tasks: Iterable[Task],
                 workers: Callable[[], int]) -> Iterator[tuple[Task, Result]]:
    """Hand in tasks, no more than keep the workers busy; each task and its result, as they come."""
    waiting = iter(tasks)
    going: dict[Future[Result], Task] = {}
    while True:
        for task in islice(waiting, max(0, AHEAD*workers() - len(going))):
            going[submit(task)] = task
        if not going:
            return
        for future in wait(going, PATIENCE, FIRST_COMPLETED).done:
            yield going.pop(future), future.result()


def in_threads(work: Callable[[Task, Progress], Result], tasks: Iterable[Task], workers: int) -> Iterator[tuple[Task, Result]]:
    """Do `work(task, tell)` in threads, in the order of the tasks; each task and its result, as they come.

    When one fails with an Error, those at work are waited for, the others are not begun. At Ctrl-C `tell`, which runs
    take for their progress, stops them too.
    """
    stop = threading.Event()

    def tell(stage: str, share: float) -> None:
        if stop.is_set():
            raise Error("stopped")

    with ThreadPoolExecutor(workers, "ldbench") as pool:
        try:
            yield from as_they_come(lambda task: pool.submit(work, task, tell), tasks, lambda: workers)
        except BaseException as error:
            if not isinstance(error, Error):
                stop.set()
            pool.shutdown(cancel_futures=True)
            raise


def one_of_each(tasks: Iterable[Task], what: Callable[[Task], object]) -> list[list[Task]]:
    """Tasks in two batches: one for everything that tasks share, as a contact table that the first of them makes, then the rest.
    `what` tells it, or nothing."""
    first: dict[object, Task] = {}
    rest = []
    for task in tasks:
        if (shared := what(task)) and shared not in first:
            first[shared] = task
        else:
            rest.append(task)
    return [list(first.values()), rest]


class HereAndNow(Executor):
    """Stands for worker processes where the system has none that are forked: this thread does each work as it is handed in."""

    def submit(self, work: Callable[..., Result], /, *arguments: Any, **options: Any) -> Future[Result]:
        future: Future[Result] = Future()
        try:
            future.set_result(work(*arguments, **options))
        except Exception as error:
            future.set_exception(error)
        return future


_known: Sequence[Callable[..., Any]] = ()


def call_known(number: int, *arguments: object) -> Any:
    """The result of one of the functions that `processes` was given, by its place there."""
    return _known[number](*arguments)


def begin() -> None:
    """Begin a worker process, which ends with its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)        # Ctrl-C goes to the parent as well, which says so in one line
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PARENTS)
    threading.Thread(target=end_with_parent, daemon=True).start()


def end_with_parent() -> None:
    """End this process when its parent has ended. Each process holds what would tell the earlier ones, so the last ends first."""
    parent = multiprocessing.parent_process()
    assert parent
    wait_for([parent.sentinel])
    os._exit(1)


@contextmanager
def processes(jobs: int | None, tasks: int, known: Sequence[Callable[..., Any]] = ()) -> Iterator[Executor]:
    """Start worker processes, one per core by default, but no more than there are tasks.

    They are forked: they have every module from their start, and the functions in `known` with all data in them, for `call_known`.
    """
    global _known       # noqa: PLW0603, forked processes have it
    _known, others = known, multiprocessing.active_children()
    pool: Executor = HereAndNow()
    try:
        if FORKS:
            pool = ProcessPoolExecutor(max(1, min(jobs or usable_cores(), tasks)), multiprocessing.get_context("fork"), begin)
            before = signal.pthread_sigmask(signal.SIG_BLOCK, PARENTS)      # a child shall not take them for its own
            try:
                pool.submit(usable_cores).result()      # forks all of them, before other threads begin
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
        yield pool
    except BaseException as error:
        for child in multiprocessing.active_children():
            if child not in others:
                child.kill()
        if isinstance(error, BrokenExecutor):
            raise Error(PROCESS_DIED) from None
        raise
    finally:
        _known = ()
        pool.shutdown(cancel_futures=True)
