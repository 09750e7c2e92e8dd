"""Files that are written whole or not at all, and checks before the work that they can be."""
from __future__ import annotations

import hashlib
import logging
import os
import re
import secrets
import stat
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import Error, unreadable

if TYPE_CHECKING:
    import pandas as pd

LOG = logging.getLogger("ldbench")
DEFAULT_FOLDER = "outputs"        # of outputs that are given no name; no other folder is made


def digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def read_text(path: Path, encoding: str = "latin-1") -> str:
    """A text file of anybody's, with line feeds as the ends of lines: in UTF-8, in UTF-16 with its mark, else in an encoding."""
    if path.is_dir():
        raise Error(file=path, expected="a file", found="a folder", advice="name a file in it")
    data = read_bytes(path)
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        text = data.decode("utf-16", errors="replace")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode(encoding, errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def read_bytes(path: Path) -> bytes:
    """The contents of a file; Error where it cannot be read."""
    try:
        return path.read_bytes()
    except (OSError, ValueError):           # ValueError: a name with a zero byte
        raise unreadable(path) from None


@contextmanager
def complete(target: Path) -> Iterator[Path]:
    """Give a scratch file to write, beside the target. On success it takes the name of the target."""
    check_target(target)
    make_folder(target)
    file = target.resolve()     # that a link leads to
    scratch = file.with_name(f"{file.name}.ldbench-part{secrets.token_hex(8)}")
    try:
        with failing_as(target, scratch):
            scratch.open("xb").close()
            yield scratch
            if file.exists():       # who may read an earlier file may read this one, and nobody else
                scratch.chmod(stat.S_IMODE(file.stat().st_mode))
            scratch.replace(file)
            LOG.info("written: %s", target)
    except BaseException:
        scratch.unlink(missing_ok=True)
        raise


@contextmanager
def failing_as(target: Path, scratch: Path | None = None) -> Iterator[None]:
    """An Error that names `target`, where `scratch`, which is to become it, or any file cannot be written."""
    try:
        yield
    except Exception as error:
        # Some libraries raise something else when they close what they could not write.
        cause = error if isinstance(error, OSError) else error.__context__
        if (isinstance(error, Error) or not isinstance(cause, OSError)
                or (scratch and cause.filename not in (None, str(scratch)))):
            raise
        raise Error(f"cannot be written completely: {cause.strerror or cause}", file=target) from None


def make_folder(file: Path) -> None:
    """Make the default folder, if a file needs it and it does not exist."""
    if file.parent == Path(DEFAULT_FOLDER):
        make_results_folder(file.parent)


def check_target(file: Path) -> None:
    """Refuse a target that is no file or has no folder; the default folder will be made later."""
    if file.exists() and not file.is_file():
        raise Error(file=file, expected="a file to write", found=f"a {'folder' if file.is_dir() else 'device'}")
    if file.exists() and not os.access(file, os.W_OK):
        raise Error(file=file, expected="a file that may be written", found="one that is protected")
    if not file.parent.is_dir() and file.parent != Path(DEFAULT_FOLDER):
        raise Error(file=file, expected="a folder that is there", found="none")


def check_ending(file: Path, what: str, *endings: str) -> None:
    """Refuse to write something else than the name of a file says; `what` is written, with one of these endings."""
    if file.suffix.lower() not in endings:
        raise Error(file=file, expected=what, found=file.suffix or "no ending")


def make_results_folder(folder: Path) -> None:
    """Make the folder of several results where it is missing, with those above it."""
    if folder.exists() and not folder.is_dir():
        raise Error(file=folder, expected="a folder for the results", found="a file")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Error(f"cannot be made: {error.strerror}", file=folder,
                    advice="go to a folder where you may write, or name another one") from None


def check_written(written: Sequence[Path], read: Iterable[Path]) -> None:
    """Refuse to write two files into one, over one that is read, or where no file can be."""
    taken = {file.resolve() for file in read}
    for file in written:
        check_target(file)
        if file.resolve() in taken:
            raise Error(file=file, expected="a file of its own to write", found="one that is read or written besides")
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
