"""Column files: ours, and other codes' labelled columns."""
from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import Error

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd

# Unit: its SI unit, and how many of these it is.
UNITS: dict[str, tuple[str, float]] = {
    "1": ("1", 1.0), "-": ("1", 1.0),
    "s": ("s", 1.0), "sec": ("s", 1.0), "ms": ("s", 1e-3),
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6), "in": ("m", 0.0254),
    "rad": ("rad", 1.0), "mrad": ("rad", 1e-3), "deg": ("rad", np.pi / 180),
    "N.s": ("N.s", 1.0), "kN.s": ("N.s", 1e3),
    "m/s": ("m/s", 1.0), "mm/s": ("m/s", 1e-3), "in/s": ("m/s", 0.0254), "km/h": ("m/s", 1 / 3.6),
    "rad/s": ("rad/s", 1.0), "mrad/s": ("rad/s", 1e-3), "deg/s": ("rad/s", np.pi / 180),
    "m/s2": ("m/s2", 1.0), "mm/s2": ("m/s2", 1e-3), "g": ("m/s2", 9.81),
    "rad/s2": ("rad/s2", 1.0), "mrad/s2": ("rad/s2", 1e-3), "deg/s2": ("rad/s2", np.pi / 180),
    "N": ("N", 1.0), "kN": ("N", 1e3), "MN": ("N", 1e6), "lbf": ("N", 4.4482216152605),
    "N.m": ("N.m", 1.0), "Nm": ("N.m", 1.0), "kN.m": ("N.m", 1e3), "kNm": ("N.m", 1e3),
    "J": ("J", 1.0), "kJ": ("J", 1e3),
}

COMMENT_MARKS = "#%!;*"
UNIT_IN_BRACKETS = re.compile(r"(.*?\S)\s*[\[(](.*)[\])]")


@dataclass(frozen=True)
class Source:
    """Where one of our columns comes from."""

    column: str | int           # its name in the file, or its number from 1
    unit: str | None = None     # its unit there; None: as the file says, else SI
    factor: float = 1.0         # applied after the unit; -1 turns a sign
    offset: float = 0.0         # added at last, SI


@dataclass(frozen=True)
class Layout:
    """How a file is laid out."""

    separator: str              # ',' ';' or '' for blanks
    names: list[str]
    units: list[str]            # '' where not given
    start: int                  # of the numbers, in characters


def read_columns(path: str | os.PathLike[str],
                 columns: str | os.PathLike[str] | Mapping[str, Any] | None = None) -> pd.DataFrame:
    """Read labelled columns in SI units; units in `attrs["units"]`.

    Takes blank-, comma- or semicolon-separated numbers under a line of names, with comments (# % ! *), and units
    in a line of their own below the names or in brackets behind each name.

    columns: how another code names ours, a mapping or a TOML file:

        time = "t"                                                  # unit as the file says, else SI
        Y = { column = "ylat", unit = "mm" }
        roll = { column = "phi", unit = "mrad", factor = -1 }       # of opposite sign
        Z = { column = 4, unit = "mm", offset = -0.457 }            # fourth column; offset in SI

    Then only these columns are returned, in this order; otherwise all, under their own names.
    """
    import pandas as pd

    path = Path(path)
    try:
        content = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        raise Error(f"{path}: cannot be opened for reading") from None
    layout = _find_layout(path, content)
    table = _read_numbers(path, content[layout.start:], layout)
    sources = _sources(columns) if columns is not None else {name: Source(name) for name in layout.names}
    data, units = {}, {}
    for name, source in sources.items():
        k = _find_column(path, layout, source.column)
        units[name], factor = _si(path, source.unit if source.unit is not None else layout.units[k])
        data[name] = factor * source.factor * table[:, k] + source.offset
    frame = pd.DataFrame(data)
    frame.attrs["units"] = units
    return frame


def _find_layout(path: Path, content: str) -> Layout:
    """Names and units: lines above the numbers with as many words as there are numbers in a row."""
    heading, start = [], 0
    for match in re.finditer(r".*\n?", content):
        line = match[0]
        if _is_numbers(line):
            break
        heading.append(line)
        start = match.end()
    else:
        raise Error(f"{path}: expected rows of numbers, found none")
    separator = next((mark for mark in ";," if mark in line), "")
    count = len(_words(line, separator))
    rows = [words for line in heading if len(words := _heading_words(line, separator)) == count]
    units = [""] * count
    if rows and all(_plain_unit(word) in UNITS for word in rows[-1]):
        units = [_plain_unit(word) for word in rows.pop()]
    if not rows:
        raise Error(f"{path}: expected a line with the names of {count} columns above the numbers, found none")
    # Our own names are in the first line, others' in the last one above the numbers.
    ours = len(_words(heading[0], separator)) == count and heading[0].lstrip()[0] not in COMMENT_MARKS
    names = rows[0] if ours else rows[-1]
    for k, name in enumerate(names):
        found = UNIT_IN_BRACKETS.fullmatch(name)
        if found and _plain_unit(found[2]) in UNITS:
            names[k], units[k] = found[1], _plain_unit(found[2])
    return Layout(separator, names, units, start)


def _is_numbers(line: str) -> bool:
    words = re.sub("[,;]", " ", line).split()
    return len(words) > 1 and all(map(_is_number, words))


def _is_number(word: str) -> bool:
    try:
        float(re.sub("[dD]", "e", word))
    except ValueError:
        return False
    return True


def _words(line: str, separator: str) -> list[str]:
    words = line.strip().rstrip(separator).split(separator) if separator else line.split()
    return [word.strip().strip("\"'") for word in words]


def _heading_words(line: str, separator: str) -> list[str]:
    """Words of a heading without comment mark; a unit in brackets stays with the name before it."""
    line = line.strip().lstrip(COMMENT_MARKS)
    if not separator:
        line = re.sub(r"(?<=[^\s\])])\s+(?=[\[(]\S*[\])])", "", line)
    return _words(line, separator)


def _plain_unit(unit: str) -> str:
    """'[m/s^2]' as 'm/s2'."""
    return unit.strip("[]() ").replace("^", "").replace("²", "2").replace("·", ".").replace("*", ".")


def _read_numbers(path: Path, body: str, layout: Layout) -> np.ndarray:
    """All rows, shape (rows, columns)."""
    if any(mark in body for mark in COMMENT_MARKS.replace(layout.separator or " ", "")):
        body = "\n".join(line for line in body.splitlines() if line.lstrip()[:1] not in tuple(COMMENT_MARKS))
    if layout.separator:
        empty = re.compile(rf"(?<={layout.separator})[ \t]*(?={layout.separator})")     # an open contact
        body = empty.sub("nan", body).replace(layout.separator, " ")
    numbers = re.sub("[dD]", "e", body) if "d" in body or "D" in body else body
    count = len(layout.names)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)      # numpy's way of saying: not a number
        try:
            table = np.fromstring(numbers, sep=" ")
        except (DeprecationWarning, ValueError):
            table = np.empty(0)
    rows = sum(1 for line in body.splitlines() if line.strip())
    if table.size != count * rows:
        raise Error(f"{path}: expected {count} numbers in every row, found '{_first_wrong(body, count)}'")
    return table.reshape(rows, count)


def _first_wrong(body: str, count: int) -> str:
    lines = (line for line in body.splitlines() if line.strip())
    return next((line.strip()[:80] for line in lines if not _is_numbers(line) or len(line.split()) != count), "")


def _sources(columns: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Source]:
    """The column map: a mapping, or the path of a TOML file."""
    where = "column map"
    if not isinstance(columns, Mapping):
        where, columns = os.fspath(columns), _read_toml(Path(columns))
    sources = {}
    for name, value in columns.items():
        try:
            sources[name] = _checked(Source(**value) if isinstance(value, Mapping) else Source(value))
        except TypeError:
            raise Error(f"{where}, {name}: expected column, unit, factor, offset, found {value}") from None
    return sources


def _checked(source: Source) -> Source:
    """What a map says may be of any type: TypeError where it is none of these."""
    numbers = source.factor, source.offset
    if not (isinstance(source.column, str | int) and isinstance(source.unit, str | None)
            and all(isinstance(x, Real) and np.isfinite(x) for x in numbers)):
        raise TypeError
    return source


def _read_toml(path: Path) -> dict[str, Any]:
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise Error(f"{path}: cannot be opened for reading") from None
    except UnicodeDecodeError as error:
        raise Error(f"{path}: expected UTF-8, found byte {error.object[error.start]} at {error.start}") from None
    except tomllib.TOMLDecodeError as error:
        raise Error(f"{path}: {error}") from None


def _find_column(path: Path, layout: Layout, column: str | int) -> int:
    if isinstance(column, int) and 1 <= column <= len(layout.names):
        return column - 1
    if column in layout.names:
        return layout.names.index(column)
    raise Error(f"{path}: expected a column {column}, found {', '.join(layout.names)}")


def _si(path: Path, unit: str) -> tuple[str, float]:
    """SI unit of a unit, and the factor to it."""
    plain = _plain_unit(unit)
    if plain and plain not in UNITS:
        raise Error(f"{path}: expected a unit among {', '.join(UNITS)}, found {unit}")
    return UNITS[plain] if plain else ("", 1.0)
