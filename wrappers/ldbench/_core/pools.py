"""Work side by side, in threads or processes of this machine."""
from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing.connection import wait as wait_for
from typing import Any, TypeVar

from .calls import Progress
from .errors import Error

Task = TypeVar("Task")
Result = TypeVar("Result")

PATIENCE = 0.2              # between looks for Ctrl-C [s]: one that comes just before a wait begins does not end it
PROCESS_DIED = "a worker process died, probably out of memory"
FORKS = sys.platform == "linux"     # Windows has no fork; libraries of macOS, Accelerate among them, may hang in a forked process
PARENTS = signal.SIGINT, signal.SIGTERM     # that the parent ends its children by


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_threads(work: Callable[[Task, Progress], Result], tasks: Sequence[Task], workers: int,
               done: Callable[[Task, Result], object]) -> None:
    """Do `work(task, tell)` in threads, in the order of the tasks; `done(task, result)` is called here after each.

    When one fails with an Error, those at work are waited for, the others are not begun. At Ctrl-C `tell`, which runs
    take for their progress, stops them too.
    """
    stop = threading.Event()

    def tell(stage: str, share: float) -> None:
        if stop.is_set():
            raise Error("stopped")

    workers = max(1, min(workers, len(tasks)))
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


class HereAndNow:
    """Stands for worker processes where the system has none that are forked: this thread does each work as it is handed in."""

    def __init__(self, known: Sequence[Callable[..., Any]]) -> None:
        self._known = known

    def submit(self, work: Callable[..., Result] | int, *arguments: object) -> Future[Result]:
        future: Future[Result] = Future()
        try:
            future.set_result((self._known[work] if isinstance(work, int) else work)(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    map = staticmethod(map)

    def kill(self) -> None:
        """Nothing goes on."""

    close = kill


class Processes:
    """Worker processes, forked: they have every module from their start, and the functions in `known` with all data in them."""

    def __init__(self, number: int, known: Sequence[Callable[..., Any]] = ()) -> None:
        fork = multiprocessing.get_context("fork")
        self._children = fork.SimpleQueue()
        self._pool = ProcessPoolExecutor(number, fork, begin, (self._children, known))
        before = signal.pthread_sigmask(signal.SIG_BLOCK, PARENTS)      # a child shall not take them for its own
        try:
            self._pool.submit(usable_cores).result()        # forks all of them, before other threads begin
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)

    def submit(self, work: Callable[..., Result] | int, *arguments: object) -> Future[Result]:
        """Ask for the result of a function, or of one in `known` by its place there."""
        return self._pool.submit(call_known, work, *arguments) if isinstance(work, int) else self._pool.submit(work, *arguments)

    def map(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        """Results in the order of the tasks."""
        return self._pool.map(work, tasks)

    def kill(self) -> None:
        """End the processes, whatever they do."""
        while not self._children.empty():
            with suppress(ProcessLookupError):
                os.kill(self._children.get(), signal.SIGKILL)

    def close(self) -> None:
        """Wait for the processes to end; what has not begun is not done."""
        self._pool.shutdown(cancel_futures=True)


_known: Sequence[Callable[..., Any]] = ()


def begin(children: Any, known: Sequence[Callable[..., Any]]) -> None:
    """Begin a worker process, which ends with its parent."""
    global _known       # noqa: PLW0603, a process has one parent
    _known = known
    children.put(os.getpid())
    signal.signal(signal.SIGINT, signal.SIG_IGN)        # Ctrl-C goes to the parent as well, which says so in one line
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PARENTS)
    threading.Thread(target=end_with_parent, daemon=True).start()


def call_known(number: int, *arguments: object) -> Any:
    """The result of a function that this process had from its start."""
    return _known[number](*arguments)


def end_with_parent() -> None:
    """End this process when its parent has ended. Each process holds what would tell the earlier ones, so the last ends first."""
    parent = multiprocessing.parent_process()
    assert parent
    wait_for([parent.sentinel])
    os._exit(1)


@contextmanager
def processes(jobs: int | None, tasks: int, known: Sequence[Callable[..., Any]] = ()) -> Iterator[Processes | HereAndNow]:
    """Start worker processes, one per core by default, but no more than there are tasks. known: see `Processes`."""
    pool = Processes(max(1, min(jobs or usable_cores(), tasks)), known) if FORKS else HereAndNow(known)
    try:
        yield pool
    except BaseException as error:
        pool.kill()
        if isinstance(error, BrokenExecutor):
            raise Error(PROCESS_DIED) from None
        raise
    finally:
        pool.close()
