"""Column files: ours, and other codes' labelled columns."""
from __future__ import annotations

import csv
import os
import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.errors import Error
from .._core.files import read_bytes, read_text
from ..constants import GRAVITY

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
    "m/s2": ("m/s2", 1.0), "mm/s2": ("m/s2", 1e-3), "g": ("m/s2", GRAVITY),
    "rad/s2": ("rad/s2", 1.0), "mrad/s2": ("rad/s2", 1e-3), "deg/s2": ("rad/s2", np.pi / 180),
    "N": ("N", 1.0), "kN": ("N", 1e3), "MN": ("N", 1e6), "lbf": ("N", 4.4482216152605), "kip": ("N", 4448.2216152605),
    "N.m": ("N.m", 1.0), "Nm": ("N.m", 1.0), "kN.m": ("N.m", 1e3), "kNm": ("N.m", 1e3),
    "J": ("J", 1.0), "kJ": ("J", 1e3),
}


def time_mean(time: np.ndarray, x: np.ndarray) -> float:
    """Mean of x over the time that its rows stand for, half the way to either neighbour; rows where x is NaN are left
    out. Rows at events and peaks do not count more than their time."""
    known = np.flatnonzero(~np.isnan(x))
    if known.size < 2:
        return float(x[known].mean()) if known.size else np.nan
    edges = np.concatenate([time[known[:1]], (time[known[1:]] + time[known[:-1]])/2, time[known[-1:]]])
    return float(np.average(x[known], weights=np.diff(edges)))


COMMENT_MARKS = "#%!;*"
EMPTY = {"n/a", "na", "none", "null", "-", "--"}     # words of a cell without a number
MISSING = -999.0, -9999.0, -99999.0, 1e30, -1e30, 1e33     # numbers that codes write where they have none
EXPONENT = re.compile(r"(?<=[\d.])(?=[+-]\d{3}(?!\d))")   # where Fortran leaves out the letter of an exponent of three digits
SEPARATORS = ";", "\t", ",", ""          # the last one stands for blanks
LISTED = re.compile(r"\W*(?:column|colonne|spalte)?\s*(\d+)\s*[:=)]\s*(.*\S)\s*", re.IGNORECASE)       # a name in a list
UNIT_IN_BRACKETS = re.compile(r"(.*?\S)\s*[\[(](.*)[\])]")


@dataclass(frozen=True)
class Source:
    """The column of another code's file that gives one of ours."""

    column: str | int           # its name in the file, or its number from 1
    unit: str | None = None     # its unit there; None: as the file says, else SI
    factor: float = 1.0         # applied after the unit; -1 turns a sign
    offset: float = 0.0         # added at last, SI

    def __post_init__(self) -> None:
        """What a map says may be of any type."""
        numbers = self.factor, self.offset
        if not (isinstance(self.column, str | int) and isinstance(self.unit, str | None)
                and all(isinstance(x, Real) and np.isfinite(x) for x in numbers)):
            raise TypeError


@dataclass(frozen=True)
class Layout:
    """How a file is laid out."""

    separator: str              # one of SEPARATORS
    names: list[str]
    units: list[str]            # '' where not given
    start: int                  # of the numbers, in lines


def read_columns(path: str | os.PathLike[str],
                 columns: str | os.PathLike[str] | Mapping[str, Any] | None = None) -> pd.DataFrame:
    """Read labelled columns in SI units; units in `attrs["units"]`.

    Takes numbers separated by blanks, tabs, commas or semicolons under a line of names, with comments (# % ! *), and units
    in a line of their own below the names or in brackets behind each name. An empty cell is NaN; where commas do not
    separate the cells they are decimal commas; `attrs["doubt"]` is a cell if all of them may mean thousands.

    columns: how another code names ours, a mapping or a TOML file:

        time = "t"                                                  # unit as the file says, else SI
        Y = { column = "ylat", unit = "mm" }
        roll = { column = "phi", unit = "mrad", factor = -1 }       # of opposite sign
        Z = { column = 4, unit = "mm", offset = -0.457 }            # fourth column; offset in SI

    Then only these columns are returned, in this order; otherwise all, under their own names.
    """
    path = Path(path)
    return converted(path, read_raw(path), columns)


@dataclass(frozen=True)
class RawTable:
    """A file as it stands: names and units of the columns, and the numbers."""

    names: list[str]
    units: list[str]            # '' where not given
    numbers: np.ndarray         # (rows, columns)
    doubt: str = ""             # a cell whose comma may mean thousands


def read_raw(path: Path) -> RawTable:
    """Read a file of labelled columns without a change of units."""
    lines = read_text(path).split("\n")
    layout = _find_layout(path, lines)
    numbers = _read_numbers(path, lines, layout)
    numbers[np.isin(numbers, MISSING)] = np.nan
    return RawTable(layout.names, layout.units, numbers, _thousands(lines, layout))


def _thousands(lines: Sequence[str], layout: Layout) -> str:
    """The first cell with a comma, as 90,000, if every comma of the file may mean thousands; '' where one must be decimal."""
    mark = layout.separator
    rows = (line for line in lines[layout.start:] if mark != "," in line and not _is_comment(line, mark))
    commas = (cell for line in rows for cell in _cells(line, mark) if "," in cell)
    first = next(commas, "")
    return first if all(re.fullmatch(r"[+-]?[1-9]\d{0,2},\d{3}", cell) for cell in (first, *commas)) else ""


def converted(path: Path, raw: RawTable,
              columns: str | os.PathLike[str] | Mapping[str, Any] | None = None) -> pd.DataFrame:
    """A table that was read as it stands, in SI units and by a map, as `read_columns` gives it; `path` is for messages."""
    import pandas as pd

    sources = _sources(columns) if columns is not None else {name: Source(name) for name in raw.names}
    data, units = {}, {}
    for name, source in sources.items():
        k = _find_column(path, raw.names, source.column)
        units[name], factor = _si(path, source.unit if source.unit is not None else raw.units[k])
        data[name] = factor * source.factor * raw.numbers[:, k] + source.offset
    frame = pd.DataFrame(data)
    frame.attrs |= {"units": units} | ({"doubt": raw.doubt} if raw.doubt else {})
    return frame


def _find_layout(path: Path, lines: Sequence[str]) -> Layout:
    """Names and units: lines above the numbers with as many words as there are cells in a row."""
    start, separator = next(((k, mark) for k, line in enumerate(lines) if (mark := _separator(line)) is not None), (0, None))
    if separator is None:
        raise _no_rows(path, lines)
    first = _cells(lines[start], separator)
    count = len(first)
    heading = {k: _heading_words(line, separator) for k, line in enumerate(lines[:start]) if re.search(r"\w", line)}
    rows = [k for k, words in heading.items() if len(words) == count]
    if not rows and not first[-1]:          # every row ends with a separator
        count -= 1
        rows = [k for k, words in heading.items() if len(words) == count]
    units, below = [""]*count, start
    if rows and any(heading[rows[-1]]) and all(_plain_unit(word) in (*UNITS, "") for word in heading[rows[-1]]):
        below = rows.pop()
        units = [_plain_unit(word) for word in heading[below]]
    if not rows:
        raise Error(file=path, expected=f"a line with the names of {count} columns above the numbers", found="none")
    # Our header follows the names as comments; other codes' names may be a comment themselves.
    at = next((k for k in reversed(rows) if not _is_comment(lines[k], separator)), rows[-1])
    names = heading[at]
    strange = [k for k in heading if at < k != below and not _is_comment(lines[k], separator)]
    if _is_number(names[0], separator) or (len(rows) > 1 and any(_is_number(name, separator) for name in names)):
        strange.insert(0, at)
    if strange:
        raise _wrong_row(path, strange[0], lines, count)
    names = _listed_names(lines[:start], count) or names
    for k, name in enumerate(names):
        found = UNIT_IN_BRACKETS.fullmatch(name)
        if found and _plain_unit(found[2]) in UNITS:
            names[k], units[k] = found[1], _plain_unit(found[2])
    return Layout(separator, names, units, start)


def _listed_names(lines: Sequence[str], count: int) -> list[str]:
    """Names of all columns from a numbered list above the numbers, as '# column 3: roll angle [rad]'; none without it."""
    found = [match for line in lines if (match := LISTED.fullmatch(line))]
    return [match[2] for match in found] if [int(match[1]) for match in found] == [*range(1, count + 1)] else []


def _separator(line: str) -> str | None:
    """What separates the cells of a row of numbers; None of another line."""
    for mark in SEPARATORS:
        cells = _cells(line, mark)
        if len(cells) > 1 and any(cells) and all(_is_number(cell, mark) for cell in cells if cell):
            return mark
    return None


def _is_number(word: str, separator: str) -> bool:
    if word.lower() in EMPTY:
        return True
    try:
        float(EXPONENT.sub("e", _plain_number(word, separator)))
    except ValueError:
        return False
    return word.isascii() and "_" not in word


def _plain_number(words: str, separator: str) -> str:
    """Rewrite Fortran's exponents and decimal commas as Python reads them."""
    words = words if separator == "," else words.replace(",", ".")
    return re.sub("[dD]", "e", words) if "d" in words or "D" in words else words


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in line.split(separator)] if separator else line.split()


def _is_comment(line: str, separator: str) -> bool:
    mark = line.lstrip()[:1]
    return mark != separator and mark in tuple(COMMENT_MARKS)


def _heading_words(line: str, separator: str) -> list[str]:
    """Words of a heading without comment mark; a unit in brackets stays with the name before it."""
    line = line.strip().lstrip(COMMENT_MARKS)
    if separator and line.startswith('"'):
        return [word.strip() for word in next(csv.reader([line.rstrip(separator)], delimiter=separator))]
    if not separator:
        line = re.sub(r"(?<=[^\s\])])\s+(?=[\[(]\S*[\])])", "", line)
    return [word.strip("\"'") for word in _cells(line.rstrip(separator or None), separator)]


def _plain_unit(unit: str) -> str:
    """'[m/s^2]', 'm.s-2' and 'm/s**2' as 'm/s2', degrees as 'deg'."""
    plain = unit.strip("[]() ").replace("^", "").replace("²", "2").replace("⁻", "-").replace("**", "").replace("·", ".")
    plain = plain.replace("*", ".").replace("/s/s", "/s2").replace("°", "deg")
    plain = re.sub(r"[. ]?s-1", "/s", re.sub(r"[. ]?s-2", "/s2", plain))
    return {"degrees": "deg", "degree": "deg"}.get(plain, plain)


def _read_numbers(path: Path, lines: Sequence[str], layout: Layout) -> np.ndarray:
    """All rows, shape (rows, columns)."""
    count, mark = len(layout.names), layout.separator
    given = {k: line for k, line in enumerate(lines[layout.start:], layout.start) if line.strip() and not _is_comment(line, mark)}
    with suppress(ValueError):          # something else than numbers
        table = np.loadtxt(given.values(), delimiter=mark or None, comments=None, ndmin=2)
        if table.shape[1] == count:
            return table
    rows: dict[int, str] = {}
    for k, line in given.items():
        cells = _cells(line, mark)
        if len(cells) == count + 1 and not cells[-1]:
            cells.pop()
        if len(cells) != count:
            raise _wrong_row(path, k, lines, count)
        row = " ".join(["nan" if not cell or cell.lower() in EMPTY else cell for cell in cells])
        rows[k] = EXPONENT.sub("e", _plain_number(row, mark))
    with suppress(ValueError):
        return np.loadtxt(rows.values(), comments=None, ndmin=2)
    wrong = (k for k, row in rows.items() if len(row.split()) != count or not all(_is_number(cell, " ") for cell in row.split()))
    raise _wrong_row(path, next(wrong, layout.start), lines, count)


def _wrong_row(path: Path, k: int, lines: Sequence[str], count: int) -> Error:
    return Error(file=path, line=k + 1, expected=f"{count} numbers", found=f"'{lines[k].strip()[:80]}'")


def _no_rows(path: Path, lines: Sequence[str]) -> Error:
    """What to say of a file whose rows all have something else among their numbers, or that has no rows."""
    for k, line in enumerate(lines):
        cells = max((_cells(line, mark) for mark in SEPARATORS), key=len)
        odd = next((cell for cell in cells if cell and not _is_number(cell, " ")), "")
        if odd and len(cells) > 2 and sum(_is_number(cell, " ") for cell in cells) > len(cells)/2:
            return Error(file=path, line=k + 1, expected="numbers",
                         found=f"'{odd[:40]}', and no row without such a cell")
    return Error(file=path, expected="rows of numbers", found="none")


def _sources(columns: str | os.PathLike[str] | Mapping[str, Any]) -> dict[str, Source]:
    """The column map: a mapping, or the path of a TOML file."""
    where = "column map"
    if not isinstance(columns, Mapping):
        where, columns = os.fspath(columns), read_toml(Path(columns))
    sources = {}
    for name, value in columns.items():
        try:
            sources[name] = Source(**value) if isinstance(value, Mapping) else Source(value)
        except TypeError:
            raise Error(file=where, place=name, expected="column, unit, factor, offset", found=str(value)) from None
    return sources


def read_toml(path: Path) -> dict[str, Any]:
    """A TOML file; Error where there is none or it cannot be understood."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib
    try:
        return tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except UnicodeDecodeError as error:
        raise Error(file=path, expected="UTF-8", found=f"byte {error.object[error.start]} at {error.start}") from None
    except RecursionError:
        raise Error(file=path, expected="TOML", found="brackets nested too deeply") from None
    except tomllib.TOMLDecodeError as error:
        raise Error(str(error), file=path) from None


def _find_column(path: Path, names: Sequence[str], column: str | int) -> int:
    if isinstance(column, int) and 1 <= column <= len(names):
        return column - 1
    if names.count(str(column)) > 1:
        raise Error(file=path, expected=f"one column {column}", found=names.count(str(column)),
                    advice="a map may tell them apart by their numbers")
    if column in names:
        return names.index(str(column))
    raise Error(file=path, expected=f"a column {column}", found=", ".join(names))


def _si(path: Path, unit: str) -> tuple[str, float]:
    """SI unit of a unit, and the factor to it."""
    plain = _plain_unit(unit)
    if plain and plain not in UNITS:
        raise Error(file=path, expected=f"a unit among {', '.join(UNITS)}", found=unit)
    return UNITS[plain] if plain else ("", 1.0)
