"""Calls into the Fortran core: texts, errors and handles, and long calls that can be watched and stopped."""
from __future__ import annotations

import functools
import os
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing, nullcontext
from typing import Any, NoReturn, TypeVar

import numpy as np

from . import flat
from .errors import Error, error_of_core

Result = TypeVar("Result")
Progress = Callable[[str, float], object]
Shared = tuple[np.ndarray, np.ndarray]

STAGES = "", "integration"


def text(buffer: bytes, length: int) -> str:
    """Decode a text of the core from its buffer."""
    return bytes(buffer)[:length].decode(errors="replace")


def check(message: bytes, length: int, label: str = "") -> None:
    """Raise the error that a core procedure reports, if it does; `label` says which case."""
    if length:
        error = error_of_core(*text(message, length).split("\x1c"))
        raise error.within(label) if label else error


@functools.cache
def descriptions() -> list[str]:
    """Names and units of the columns, of the geometry columns, one line each; kinds of events; version."""
    return text(*flat.describe_results()).splitlines()


def version() -> str:
    """The version of the core."""
    return descriptions()[-1]


class Handle:
    """An object of the core, which is freed with the last reference to this handle, so that it is never used after it is freed.

    It stays in its process, and cannot be copied.
    """

    def __init__(self, free: Callable[[int], object], address: int, lender: Handle | None = None) -> None:
        """Keep a reference to `lender`, whose memory this object uses."""
        self._address, self._lender = address, lender
        weakref.finalize(self, free, address).atexit = False     # at the end of the process all goes anyway

    def __int__(self) -> int:
        """Return the address for a call of the core."""
        return self._address

    def __reduce__(self) -> NoReturn:
        raise TypeError("a contact table or run of the core cannot be pickled; give the other process the case")


def path_bytes(path: str | os.PathLike[str]) -> bytes:
    return text_bytes(os.fspath(path))


def kept_folder(named: str) -> str:
    """The folder for what saves time: the one named, or the user's cache where that may not be written; '' where neither may be."""
    path, size = flat.kept_folder(path_bytes(named))
    return os.fsdecode(bytes(path)[:size])


def text_bytes(words: str) -> bytes:
    """Encode a text for the core; refuse a zero byte, which would end the text there."""
    if "\0" in words:
        raise Error(expected="a text without zero bytes", found=f"{words!r}")
    try:
        return os.fsencode(words)
    except UnicodeEncodeError:
        raise Error(expected="a text that a file can hold", found=f"{words!r}") from None


def watched(work: Callable[[Shared], Result], progress: Progress | bool | None) -> Result:
    """Do `work(shared)` in a thread of its own and wait for it.

    `shared` goes to the core: how far it is, and whether it shall stop. Meanwhile `progress(stage, share)`
    is called here with stage 'integration' and the share done, 0 to 1; True draws a bar on a
    terminal. An exception here, such as KeyboardInterrupt, stops the work before it goes on its way.
    """
    shared = np.zeros(2), np.zeros(1, np.intc)
    bar = Bar() if progress is True else None
    tell = bar or (progress if callable(progress) else None)
    with ThreadPoolExecutor(1, "ldbench") as pool, closing(bar) if bar else nullcontext():
        try:
            future = pool.submit(work, shared)
            while not wait([future], 0.05).done:
                stage, share = shared[0]
                if tell and stage:
                    tell(STAGES[int(stage)], float(share))
            return future.result()
        except BaseException:
            shared[1][0] = 1
            raise


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
