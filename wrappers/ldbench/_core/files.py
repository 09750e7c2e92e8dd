"""Files that are written whole or not at all, and checks before the work that they can be."""
from __future__ import annotations

import errno
import fcntl
import glob
import hashlib
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import Error

if TYPE_CHECKING:
    import pandas as pd

WRITERS = 100        # of one file at the same time, at most: the numbers of scratch files have two digits
DEFAULT_FOLDER = "outputs"        # of outputs that are given no name; no other folder is made


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


@contextmanager
def complete(target: Path) -> Iterator[Path]:
    """Give a scratch file to write. On success it takes the name of `target` and the permissions of an earlier file."""
    check_target(target)
    make_folder(target)
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
    """Make a scratch file beside `file`; return its path and the descriptor that holds its lock.

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
    """Remove a scratch file that no process has locked, because its process is dead."""
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
    """Refuse a target that is no file or has no folder; the default folder will be made later."""
    if file.exists() and not file.is_file():
        raise Error(f"{file}: expected a file to write, found a {'folder' if file.is_dir() else 'device'}")
    if not file.parent.is_dir() and file.parent != Path(DEFAULT_FOLDER):
        raise Error(f"{file}: expected a folder that is there, found none")


def check_ending(file: Path, what: str, *endings: str) -> None:
    """Refuse to write something else than the name of a file says; `what` is written, with one of these endings."""
    if file.suffix.lower() not in endings:
        raise Error(f"{file}: expected {what}, found {file.suffix or 'no ending'}")


def make_folder(file: Path) -> None:
    """Make the default folder, if a file needs it and it does not exist."""
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


def write_frame(frame: pd.DataFrame, target: Path) -> None:
    """Write a table as CSV."""
    texts = frame.select_dtypes(exclude=["number", "bool"])
    frame = frame.assign(**{name: texts[name].astype(object).where(~texts[name].map(is_formula), "'" + texts[name].astype(str))
                            for name in texts})
    with complete(target) as scratch:
        frame.to_csv(scratch, index=False)


def is_formula(cell: object) -> bool:
    """Whether a spreadsheet would take a text for a formula; an apostrophe before the text prevents that."""
    return isinstance(cell, str) and re.match(r"(?s)[=@\t\r].|[+-](?![\d.eE+-]+$).", cell) is not None
