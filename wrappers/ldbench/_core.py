"""Calls into the Fortran core: its errors, and long calls that can be watched and stopped."""
from __future__ import annotations

import errno
import fcntl
import functools
import glob
import hashlib
import os
import threading
import weakref
from argparse import ArgumentTypeError
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn, TypeVar

import numpy as np

from . import _flat

Result = TypeVar("Result")
Progress = Callable[[str, float], object]
Shared = tuple[np.ndarray, np.ndarray]

STAGES = "", "table", "integration"
WRITERS = 100        # of one file at the same time, at most: the numbers of scratch files have two digits
DEFAULT_FOLDER = "outputs"        # of outputs that are given no name; no other folder is made
PATIENCE = 0.2       # between looks for Ctrl-C [s]: one that comes just before a wait begins does not end it


class Error(RuntimeError):
    """What the core refuses; the text is that of the executable after `ldbench: error: `: one line, for any terminal."""

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in message)
        super().__init__(line if len(line) < 2048 else f"{line[:2044]}...")


def text(buffer: bytes, length: int) -> str:
    """A text of the core from its buffer."""
    return bytes(buffer)[:length].decode(errors="replace")


def check(message: bytes, length: int, label: str = "") -> None:
    """Raise the error that a core procedure reports, if it does; `label` says which case."""
    if length:
        words = text(message, length)
        raise Error(f"{label}{', ' if words.startswith('&') else ': '}{words}" if label else words)


@functools.cache
def descriptions() -> list[str]:
    """Names and units of the columns, of the geometry columns, one line each; kinds of events; version."""
    return text(*_flat.describe_results()).splitlines()


def version() -> str:
    """Of the core."""
    return descriptions()[-1]


class Handle:
    """Something of the core, which is freed with the last reference to this; so nothing is used after it is freed.

    It stays in its process, and cannot be copied.
    """

    def __init__(self, free: Callable[[int], object], address: int, lender: Handle | None = None) -> None:
        """lender: what this one uses, and keeps."""
        self._address, self._lender = address, lender
        weakref.finalize(self, free, address).atexit = False     # at the end of the process all goes anyway

    def __int__(self) -> int:
        """The address, for a call."""
        return self._address

    def __reduce__(self) -> NoReturn:
        raise TypeError("what the core holds cannot leave its process")


def needed(module: str, extra: str, package: str = "") -> ModuleType:
    """A module of an optional package; an Error that says how to get it where it is not installed.

    extra: ours that has the package; package: its name, where that is not the module's.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name != module:        # it is there and lacks something itself
            raise
        raise Error(f"needs {package or module}, which is not installed: pip install 'ldbench[{extra}]'") from None


def path_bytes(path: str | os.PathLike[str]) -> bytes:
    return text_bytes(os.fspath(path))


def text_bytes(words: str) -> bytes:
    """A text for the core, where the zero byte would end it and hide the rest."""
    if "\0" in words:
        raise Error(f"expected a text without zero bytes, found {words!r}")
    try:
        return os.fsencode(words)
    except UnicodeEncodeError:
        raise Error(f"expected a text that a file can hold, found {words!r}") from None


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def usable_cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(word: str) -> int:
    """A number of threads or processes from the command line."""
    number = int(word) if word.isdecimal() else 0
    if number < 1:
        raise ArgumentTypeError(f"expected a number from 1, found {word}")
    return number


@contextmanager
def complete(target: Path) -> Iterator[Path]:
    """A file to write beside `target`, which takes its name, and the permissions of an earlier file, when all went well."""
    check_target(target)
    file = target.resolve()     # that a link leads to
    mode = file.stat().st_mode & 0o777 if file.exists() else None
    try:
        scratch, lock = new_scratch(file, 0o666 if mode is None else mode | 0o600)
    except OSError as error:
        raise Error(f"{target}: cannot be written completely: {error.strerror or error}") from None
    try:
        with failing_as(target, scratch):
            yield scratch
            if mode is not None:
                scratch.chmod(mode)
            scratch.replace(file)
    except BaseException:
        scratch.unlink(missing_ok=True)
        raise
    finally:
        os.close(lock)          # not before: the name is free from then on


def new_scratch(file: Path, mode: int) -> tuple[Path, int]:
    """A new file beside `file`, and the descriptor that holds its lock.

    The core names, locks and removes its scratch files in the same way: fortran/system.f90.
    """
    found = None
    for k in range(WRITERS):
        path = file.with_name(f"{file.name}.ldbench-part{k:02}")
        remove_left(path)
        if found:
            continue
        with suppress(FileExistsError):
            lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, mode)
            with suppress(OSError):         # not every file system has locks
                fcntl.flock(lock, fcntl.LOCK_EX)
            if os.fstat(lock).st_nlink:
                found = path, lock
            else:                           # another writer found it before it was locked, and removed it
                os.close(lock)
    if not found:
        raise OSError(errno.EEXIST, f"{WRITERS} others write it")
    return found


def remove_left(scratch: Path) -> None:
    """Remove a scratch file that nobody has locked: its process is dead."""
    with suppress(OSError):
        lock = os.open(scratch, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # The writer may just have finished this file, and the name may lead to another writer's file.
            if os.path.samestat(os.fstat(lock), scratch.lstat()):
                scratch.unlink()
        finally:
            os.close(lock)


@contextmanager
def failing_as(target: Path, scratch: Path) -> Iterator[None]:
    """An Error that names `target`, where `scratch`, which is to become it, cannot be written."""
    try:
        yield
    except Exception as error:
        # Some libraries raise something else when they close what they could not write.
        cause = error if isinstance(error, OSError) else error.__context__
        if not isinstance(cause, OSError) or cause.filename not in (None, str(scratch)):
            raise
        raise Error(f"{target}: cannot be written completely: {cause.strerror or cause}") from None


def left_by_dead(target: Path, ends: str) -> Iterator[Path]:
    """What dead processes left of a folder that they wrote: its name, and `ends` with * for the process, or for process-thread."""
    before, after = ends.split("*")
    for path in sorted(target.parent.glob(glob.escape(target.name) + ends)):
        process = path.name[len(target.name) + len(before):len(path.name) - len(after)].partition("-")[0]
        if process.isdecimal() and not is_alive(int(process)):
            yield path


def is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def check_target(file: Path) -> None:
    """Refuse to write where there is something else than a file, or no folder; the default one is made."""
    if file.exists() and not file.is_file():
        raise Error(f"{file}: expected a file to write, found a {'folder' if file.is_dir() else 'device'}")
    make_folder(file)
    if not file.parent.is_dir():
        raise Error(f"{file}: expected a folder that is there, found none")


def check_ending(file: Path, what: str, *endings: str) -> None:
    """Refuse to write something else than the name of a file says; `what` is written, with one of these endings."""
    if file.suffix.lower() not in endings:
        raise Error(f"{file}: expected {what}, found {file.suffix or 'no ending'}")


def make_folder(file: Path) -> None:
    """Make the default folder, if that is what a file lacks."""
    if file.parent == Path(DEFAULT_FOLDER):
        file.parent.mkdir(exist_ok=True)


def check_written(written: Sequence[Path], read: Iterable[Path]) -> None:
    """Refuse to write two files into one, over one that is read, or where no file can be."""
    taken = {file.resolve() for file in read}
    for file in written:
        check_target(file)
        if file.resolve() in taken:
            raise Error(f"{file}: expected a file of its own to write, found one that is read or written besides")
        taken.add(file.resolve())


def watched(work: Callable[[Shared], Result], progress: Progress | bool | None) -> Result:
    """Do `work(shared)` in a thread of its own and wait for it.

    `shared` goes to the core: how far it is, and whether it shall stop. Meanwhile `progress(stage, share)`
    is called here with stage 'table' or 'integration' and the share done, 0 to 1; True draws a bar on a
    terminal. An exception here, such as KeyboardInterrupt, stops the work before it goes on its way.
    """
    shared = np.zeros(2), np.zeros(1, np.intc)
    results: list[Result] = []
    errors: list[BaseException] = []
    done = threading.Event()        # Thread.join takes a thread for finished when Ctrl-C interrupts it (Python 3.11)

    def keep_outcome() -> None:
        try:
            results.append(work(shared))
        except BaseException as error:
            errors.append(error)
        finally:
            done.set()

    bar = Bar() if progress is True else None
    tell = bar or (progress if callable(progress) else None)
    worker = threading.Thread(target=keep_outcome, name="ldbench")
    try:
        worker.start()
        while not done.wait(0.05):
            stage, share = shared[0]
            if tell and stage:
                tell(STAGES[int(stage)], float(share))
    except BaseException:
        shared[1][0] = 1
        if worker.is_alive():
            done.wait()
        raise
    finally:
        if done.is_set():
            worker.join()       # it only has to end
        if bar:
            bar.close()
    if errors:
        raise errors[0]
    return results[0]


class Bar:
    """A progress bar per stage on a terminal, for work of more than a second."""

    def __init__(self) -> None:
        self.stage = ""
        self.bar: Any = None        # of tqdm

    def __call__(self, stage: str, share: float) -> None:
        from tqdm import tqdm

        if stage != self.stage:
            self.close()
            self.stage = stage
            self.bar = tqdm(desc=stage, total=1.0, delay=1, disable=None, leave=False,
                            bar_format="{desc}: {percentage:3.0f} %|{bar}| {elapsed} < {remaining}")
        self.bar.update(share - self.bar.n)

    def close(self) -> None:
        if self.bar is not None:
            self.bar.close()
