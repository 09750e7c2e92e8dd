"""Errors and warnings of ldbench, each with a one-line reason: refused input, failed runs, doubtful results."""
from __future__ import annotations

import difflib
import errno
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

LONGEST = 2048          # of a message in the core [characters]

UNREADABLE = "cannot be opened for reading"
# Where something is wrong besides the file: 'FILE, line 3, &group variable = value', each of which may be missing.
PLACE = re.compile(r"(?:, |: |^)(?:line (\d+)|&(\w+)(?: (\w+)(?: = (?:(?!, |: ).)*)?)?)(?=, |: |$)")


class Error(RuntimeError):
    """Input that ldbench refuses, or a run that fails. The text is the line that the executable prints after `ldbench: error: `.

    An Error about an argument is a ValueError or a TypeError as well, one about a name that stands for nothing a KeyError, and one
    about a file that is not there a FileNotFoundError.

    Where the text says so, the attributes tell the parts of it: `file`, `line` (a number), `group` and `variable` of the
    namelist, what was `expected` and what was `found`; the others are None.
    """

    file: str | None
    line: int | None
    group: str | None
    variable: str | None
    expected: str | None
    found: str | None

    def __init__(self, message: str) -> None:
        line = "".join(c if c.isprintable() else " " if c.isspace() else "?" for c in message)
        super().__init__(line if len(line) < LONGEST else f"{line[:LONGEST - 4]}...")
        self.file = self.line = self.group = self.variable = self.expected = self.found = None
        where, wanted, rest = f": {self}".partition(": expected ")
        if wanted:
            self.expected, _, found = rest.partition(", found ")
            self.found = re.sub(r"  \[.*\]$", "", found)        # the line of the namelist follows in brackets
        else:
            where, unreadable, _ = where.partition(f": {UNREADABLE}")
            where = where if unreadable else ""
        for number, group, variable in PLACE.findall(where):
            self.line = int(number) if number else self.line
            self.group, self.variable = (group, variable or None) if group else (self.group, self.variable)
        # A file that a case or a variable names comes after it: 'FILE, &group variable: FILE'.
        files = PLACE.sub("", where).replace(", header", "").split(": ")
        self.file = next(filter(None, reversed(files)), None)

    def __str__(self) -> str:
        return str(self.args[0])


class MissingFile(Error, FileNotFoundError):
    """A file that does not exist; `except FileNotFoundError` catches this error too."""

    def __new__(cls, *arguments: object) -> MissingFile:
        """Make it as a FileNotFoundError is made, also without a message: Dask unpickles exceptions so."""
        return FileNotFoundError.__new__(cls, *arguments)

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.errno = errno.ENOENT


class BadValue(Error, ValueError):
    """An argument, or the value of a variable, that cannot be."""


class BadType(Error, TypeError):
    """An argument, or the value of a variable, of another type than it has to be."""


class UnknownName(Error, KeyError):
    """A name that stands for nothing."""


def unknown(what: str, name: str, known: Mapping[str, str] | Iterable[str], found: str = "") -> UnknownName:
    """The error that a name stands for nothing, with the nearest of the known names, or with what this one is called else; `found`
    where that is not the name itself."""
    called = {one.lower(): (known[one] if isinstance(known, Mapping) else one) for one in known}
    near = difflib.get_close_matches(str(name).lower(), called, 1)
    return UnknownName(f"{what}, found {found or name}" + (f"; {called[near[0]]} is the nearest" if near else ""))


class Warning(UserWarning):
    """A profile or a contact table does not fulfil what the case asks for, and the run goes on."""


class Usage(Error):
    """A command line that the command does not understand."""


def error_of(message: str) -> Error:
    """Make the Error of a message, or a MissingFile if the file that cannot be read does not exist."""
    before, unreadable, _ = message.partition(f": {UNREADABLE}")
    path = before.rpartition(": ")[2].rpartition(", ")[2]
    return MissingFile(message) if unreadable and not Path(path).exists() else Error(message)
