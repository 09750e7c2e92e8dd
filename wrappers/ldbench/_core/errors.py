"""Errors and warnings of ldbench, each with a one-line reason: refused input, failed runs, doubtful results."""
from __future__ import annotations

import difflib
import errno
import os
import sys
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

LONGEST = 2048          # of a message in the core [characters]

HEADER = ", header"     # follows the file in the label of a case that a column file tells

# Names that users know of files that stand for theirs in this process, by the path of such a file.
OWN_NAMES: dict[str, str] = {}

Kind = TypeVar("Kind", bound="Error")


def one_line(text: object) -> str:
    return "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in str(text))


class Error(RuntimeError):
    """Input that ldbench refuses, or a run that fails. The text is the line that the executable prints after `ldbench: error: `.

    An Error about an argument is a ValueError or a TypeError as well, one about a name that stands for nothing a KeyError, and one
    about a file that is not there a FileNotFoundError.

    Attributes tell the parts of the text as far as it has them: `file`, `line` (a number), `group` and `variable` of the namelist,
    what was `expected` and what was `found`; the others are None.
    """

    file: str | None
    line: int | None
    group: str | None
    variable: str | None
    expected: str | None
    found: str | None

    def __init__(self, statement: str = "", *, file: str | os.PathLike[str] | None = None, line: int | None = None,
                 group: str | None = None, variable: str | None = None, place: str = "", expected: object = None,
                 found: object = None, advice: str = "") -> None:
        """Compose 'FILE, line LINE, &GROUP VARIABLE, PLACE: expected EXPECTED, found FOUND; ADVICE', or with a statement instead of
        what was expected. `place` says where in other words; advice that is a sentence of its own begins with a stop."""
        where = [os.fspath(file) if file else "", "" if line is None else f"line {line}",
                 f"&{group}{f' {variable}' if variable else ''}" if group else "", place]
        if expected is not None:
            statement = f"expected {expected}" + ("" if found is None else f", found {found}")
        if advice:
            statement += advice if advice.startswith(".") else f"; {advice}"
        self._tell(": ".join(filter(None, (", ".join(filter(None, where)), statement))))
        self.file, self.line, self.group, self.variable = _file(file) if file else None, line, group, variable
        self.expected, self.found = (None if part is None else one_line(part) for part in (expected, found))

    def _tell(self, message: str) -> None:
        line = one_line(message)
        self.args = line if len(line) < LONGEST else f"{line[:LONGEST - 4]}...",

    def turned(self, kind: type[Kind]) -> Kind:
        """This error as one of another kind."""
        told = kind(str(self))
        vars(told).update(vars(self))
        return told

    def within(self, label: str) -> Error:
        """This error with the file before it that led there: a case, of which this may be a variable, or a list of files."""
        told = self.turned(type(self))
        told._tell(f"{label}{', ' if self.group else ': '}{self}")
        told.file = self.file or _file(label)
        return told

    def __str__(self) -> str:
        return str(self.args[0])


class MissingFile(Error, FileNotFoundError):
    """A file that does not exist; `except FileNotFoundError` catches this error too."""

    def __new__(cls, *arguments: object, **fields: object) -> MissingFile:
        """Make it as a FileNotFoundError is made, also without a message: Dask unpickles exceptions so."""
        return FileNotFoundError.__new__(cls, *arguments)

    def __init__(self, statement: str = "", **fields: Any) -> None:
        super().__init__(statement, **fields)
        self.errno = errno.ENOENT


class BadValue(Error, ValueError):
    """An argument, or the value of a variable, that cannot be."""


class BadType(Error, TypeError):
    """An argument, or the value of a variable, of another type than it has to be."""


class UnknownName(Error, KeyError):
    """A name that stands for nothing."""


def unknown(expected: str, name: str, known: Mapping[str, str] | Iterable[str], found: str = "", **place: Any) -> UnknownName:
    """The error that a name stands for nothing, with the nearest of the known names, or with what this one is called else; `found`
    where that is not the name itself."""
    called = {one.lower(): (known[one] if isinstance(known, Mapping) else one) for one in known}
    near = difflib.get_close_matches(str(name).lower(), called, 1)
    return UnknownName(expected=expected, found=found or name, advice=f"{called[near[0]]} is the nearest" if near else "", **place)


class Warning(UserWarning):
    """What was found is doubtful, damaged or in use, and the work goes on."""


def warn(words: str) -> None:
    """Issue a Warning, as of the line outside this package that led here."""
    level, frame = 1, sys._getframe()
    while frame.f_back and frame.f_globals["__name__"].partition(".")[0] in (__name__.partition(".")[0], "contextlib"):
        level, frame = level + 1, frame.f_back
    warnings.warn(words, Warning, stacklevel=level)


class Usage(Error):
    """A command line that the command does not understand."""


def unreadable(path: str | os.PathLike[str]) -> Error:
    """The Error that a file cannot be read, a MissingFile if it does not exist."""
    return (Error if Path(path).exists() else MissingFile)("cannot be opened for reading", file=path)


def error_of_core(message: str, file: str, line: str, group: str, variable: str, expected: str, found: str, missing: str) -> Error:
    """The Error of the message and the fields that the core tells, '' where it has none; with the users' names of their files."""
    for stand_in, own in OWN_NAMES.items():
        if stand_in in message:
            message = message.replace(stand_in, own)
    error = (MissingFile if missing else Error)(message)
    error.file, error.line = OWN_NAMES.get(file, file) or None, int(line) if line else None
    error.group, error.variable = group or None, variable or None
    error.expected, error.found = (expected, found) if expected else (None, None)
    return error


def _file(label: str | os.PathLike[str]) -> str:
    """The file of a label."""
    return one_line(os.fspath(label)).removesuffix(HEADER)
