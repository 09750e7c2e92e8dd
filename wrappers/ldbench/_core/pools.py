"""Work side by side, in threads or processes of this machine."""
from __future__ import annotations

import multiprocessing
import os
import queue
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait as wait_for
from typing import Any, TypeVar

from .calls import Progress
from .errors import Error

Task = TypeVar("Task")
Result = TypeVar("Result")

PATIENCE = 0.2              # between looks for Ctrl-C [s]: one that comes just before a wait begins does not end it
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


class HereAndNow:
    """Stands for worker processes where the system has none that are forked: this thread does each work as it is handed in."""

    def __init__(self, known: Sequence[Callable[..., Any]]) -> None:
        self.known = known

    def submit(self, work: Callable[..., Result] | int, *arguments: object) -> Future[Result]:
        future: Future[Result] = Future()
        try:
            future.set_result((self.known[work] if isinstance(work, int) else work)(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future

    map = staticmethod(map)

    def end(self) -> None:
        """Nothing goes on."""


class Processes:
    """Worker processes, each served by a separate thread of this process."""

    def __init__(self, number: int, known: Sequence[Callable[..., Any]] = ()) -> None:
        """known: functions that the processes have from their start, with all data in them. `submit` takes such a function by
        its place in `known`; any other function is sent through a pipe."""
        # Forked: the children have every module from the start. Before the threads: a fork takes only its own along.
        fork = multiprocessing.get_context("fork")
        self.idle: queue.SimpleQueue[Connection] = queue.SimpleQueue()
        self.children = []
        before = signal.pthread_sigmask(signal.SIG_BLOCK, PARENTS)      # a child shall not take them for its own
        try:
            for _ in range(number):
                ours, theirs = fork.Pipe()
                child = fork.Process(target=serve, args=(theirs, known), daemon=True)
                child.start()
                self.children.append(child)
                theirs.close()
                self.idle.put(ours)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        self.threads = ThreadPoolExecutor(number)

    def submit(self, work: Callable[..., Result] | int, *arguments: object) -> Future[Result]:
        return self.threads.submit(self._ask, work, arguments)

    def map(self, work: Callable[[Task], Result], tasks: Iterable[Task]) -> Iterator[Result]:
        return self.threads.map(lambda task: self._ask(work, (task,)), tasks)

    def _ask(self, work: Callable[..., Result] | int, arguments: tuple[object, ...]) -> Result:
        worker = self.idle.get()
        try:
            worker.send((work, arguments))
            result, error = worker.recv()
        except (EOFError, OSError):
            raise Error("a process that read or drew was ended, as systems do where memory ends") from None
        finally:
            self.idle.put(worker)
        if error:
            raise error
        return result

    def end(self) -> None:
        """End the processes, whatever they do; the threads that ask them get an Error."""
        for child in self.children:
            child.kill()
        self.threads.shutdown(cancel_futures=True)
        for child in self.children:
            child.join()


def serve(asked: Connection, known: Sequence[Callable[..., Any]]) -> None:
    """Serve requests until the parent kills this process, or has died."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)        # Ctrl-C goes to the parent as well, which says so in one line
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, PARENTS)
    threading.Thread(target=end_with_parent, daemon=True).start()
    with suppress(EOFError, OSError, MemoryError):
        while True:
            work, arguments = asked.recv()
            try:
                asked.send(((known[work] if isinstance(work, int) else work)(*arguments), None))
            except Exception as error:
                asked.send((None, error))


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
    finally:
        pool.end()
