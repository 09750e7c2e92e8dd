"""Column files: ours, and other codes' labelled columns."""
from __future__ import annotations

import os
import re
import sys
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.errors import Error
from .._core.files import read_bytes, read_text
from ..constants import GRAVITY
from .cells import (
    COMMENT_MARKS,
    SEPARATORS,
    Word,
    cells_of,
    is_comment,
    is_number,
    numbers_columns,
    plain_lines,
    read_rows,
    row_separator,
)

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd

FOOT, POUND, KILOPOND = 0.3048, 4.4482216152605, 9.80665      # [m], [N], [N]
# Unit: its SI unit, and how many of these it is.
UNITS: dict[str, tuple[str, float]] = {
    "1": ("1", 1.0), "-": ("1", 1.0),
    "s": ("s", 1.0), "sec": ("s", 1.0), "ms": ("s", 1e-3), "us": ("s", 1e-6),
    "m": ("m", 1.0), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "um": ("m", 1e-6), "in": ("m", 0.0254), "ft": ("m", FOOT),
    "rad": ("rad", 1.0), "mrad": ("rad", 1e-3), "urad": ("rad", 1e-6), "deg": ("rad", np.pi / 180), "gon": ("rad", np.pi / 200),
    "N.s": ("N.s", 1.0), "kN.s": ("N.s", 1e3),
    "m/s": ("m/s", 1.0), "mm/s": ("m/s", 1e-3), "cm/s": ("m/s", 1e-2), "in/s": ("m/s", 0.0254), "ft/s": ("m/s", FOOT),
    "km/h": ("m/s", 1 / 3.6),
    "rad/s": ("rad/s", 1.0), "mrad/s": ("rad/s", 1e-3), "deg/s": ("rad/s", np.pi / 180),
    "m/s2": ("m/s2", 1.0), "mm/s2": ("m/s2", 1e-3), "cm/s2": ("m/s2", 1e-2), "in/s2": ("m/s2", 0.0254), "ft/s2": ("m/s2", FOOT),
    "g": ("m/s2", GRAVITY),
    "rad/s2": ("rad/s2", 1.0), "mrad/s2": ("rad/s2", 1e-3), "deg/s2": ("rad/s2", np.pi / 180),
    "N": ("N", 1.0), "kN": ("N", 1e3), "MN": ("N", 1e6), "daN": ("N", 10.0), "kgf": ("N", KILOPOND), "kp": ("N", KILOPOND),
    "lbf": ("N", POUND), "kip": ("N", 1e3 * POUND), "kips": ("N", 1e3 * POUND),
    "N.m": ("N.m", 1.0), "Nm": ("N.m", 1.0), "kN.m": ("N.m", 1e3), "kNm": ("N.m", 1e3),
    "J": ("J", 1.0), "kJ": ("J", 1e3), "ft-lbf": ("J", FOOT * POUND), "ft.lbf": ("J", FOOT * POUND),
}


def time_mean(time: np.ndarray, x: np.ndarray) -> float:
    """Mean of x over the time that its rows stand for, half the way to either neighbour; rows where x is NaN are left
    out. Rows at events and peaks do not count more than their time."""
    known = np.flatnonzero(~np.isnan(x))
    if known.size < 2:
        return float(x[known].mean()) if known.size else np.nan
    edges = np.concatenate([time[known[:1]], (time[known[1:]] + time[known[:-1]])/2, time[known[-1:]]])
    return float(np.average(x[known], weights=np.diff(edges)))


MISSING = -999.0, -9999.0, -99999.0, 1e30, -1e30, 1e33     # numbers that codes write where they have none
LISTED = re.compile(r"\W*(?:column|colonne|spalte)?\s*(\d+)\s*[:=)]\s*(.*\S)\s*", re.IGNORECASE)       # a name in a list
# A unit of one column: in the last brackets, behind a stroke between blanks, or between the dots that R makes of brackets.
UNIT_IN_NAME = [*map(re.compile, (r"(.*[^\s\[(<{])\s*[\[(<{](.*)[\])>}]", r"(.*\S)\s+/\s*(\S+)", r"(.*\w)\.\.+([^\W\d].*?)\."))]
UNIT_AT_END = re.compile(r"(.*[^\W_])[_ ]+(\S+?)")
MOSTLY = 0.9        # share of the names from which a unit at the end is one


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

    Takes numbers separated by blanks, tabs, commas, semicolons or strokes (|) under a line of names, with comments (# % ! *), and
    units in a line of their own or behind each name. Cells may be quoted. An empty cell, and one of stars, `#N/A` or another
    word for no number, is NaN; `attrs["words"]` tells such words, how many there are and where. Where commas do not separate
    the cells they are decimal commas; `attrs["doubt"]` is a cell if all of them may mean thousands.

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
    words: tuple[Word, ...] = ()    # that stand in cells for no number


def read_raw(path: Path, encoding: str = "latin-1") -> RawTable:
    """Read a file of labelled columns without a change of units. encoding: of a file that is not in UTF-8 or UTF-16."""
    lines = plain_lines(read_text(path, encoding))
    layout = _find_layout(path, lines)
    table = read_rows(lines, layout.start, len(layout.names), layout.separator)
    if table.wrong is not None:
        raise _wrong_row(path, table.wrong, lines, len(layout.names))
    table.numbers[np.isin(table.numbers, MISSING)] = np.nan
    return RawTable(layout.names, layout.units, table.numbers, _thousands(lines, layout), table.words)


def _thousands(lines: Sequence[str], layout: Layout) -> str:
    """The first cell with a comma, as 90,000, if every comma of the file may mean thousands; '' where one must be decimal."""
    mark = layout.separator
    rows = (line for line in lines[layout.start:] if "," in line and (mark != "," or '"' in line) and not is_comment(line, mark))
    commas = (cell for line in rows for cell in cells_of(line, mark) if "," in cell)
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
    frame.attrs |= {"units": units} | ({"doubt": raw.doubt} if raw.doubt else {}) | ({"words": raw.words} if raw.words else {})
    return frame


def _find_layout(path: Path, lines: Sequence[str]) -> Layout:
    """Names and units: lines above the numbers with as many words as there are cells in a row."""
    start, separator = next(((k, mark) for k, line in enumerate(lines)
                             if (mark := row_separator(line)) is not None and not numbers_columns(line, mark)), (0, None))
    if separator is None:
        raise _no_rows(path, lines)
    first = cells_of(lines[start], separator)
    count = len(first)
    heading, rows = _heading(lines[:start], separator, count)
    if not rows and not first[-1]:          # every row ends with a separator
        count -= 1
        rows = [k for k, words in heading.items() if len(words) == count]
    # Names may stand between other separators than the numbers do.
    for mark in SEPARATORS if not rows else ():
        heading, rows = (heading, rows) if rows else _heading(lines[:start], mark, count)
    units, named = [""]*count, _listed_names(lines[:start], count)
    of_units = [k for k in rows if 2*sum(bool(known_unit(word)) for word in heading[k]) > sum(map(bool, heading[k]))][-1:]
    # A lone line of units would be one of names, as t and N.
    if of_units and (len(rows) > 1 or named or of_units[0] != rows[-1]):
        rows.remove(of_units[0])
        units = [known_unit(word) for word in heading[of_units[0]]]
    rows = [k for k in rows if not numbers_columns(lines[k], separator)]
    if not (rows or named):
        raise Error(file=path, expected=f"a line with the names of {count} columns above the numbers", found="none")
    if rows:
        # Our header follows the names as comments; other codes' names may be a comment themselves.
        at = next((k for k in reversed(rows) if not is_comment(lines[k], separator)), rows[-1])
        strange = [k for k in heading if at < k and k not in of_units and not is_comment(lines[k], separator)
                   and not numbers_columns(lines[k], separator)]
        if is_number(heading[at][0]) or (len(rows) > 1 and any(map(is_number, heading[at]))):
            strange.insert(0, at)
        if strange and not named:
            raise _wrong_row(path, strange[0], lines, count)
    names = named or heading[at]
    _take_units(names, units)
    return Layout(separator, names, units, start)


def _heading(lines: Sequence[str], separator: str, count: int) -> tuple[dict[int, list[str]], list[int]]:
    """The words of the lines above the numbers, and which of these have as many as there are columns."""
    words = {k: _heading_words(line, separator, count) for k, line in enumerate(lines) if re.search(r"\w", line)}
    return words, [k for k, some in words.items() if len(some) == count]


def _take_units(names: list[str], units: list[str]) -> None:
    """Move units from the names to the units: those in brackets, behind a stroke, in the dots that R makes of brackets, and those
    at the end of nearly all names."""
    found = [next(((match[1], unit) for form in UNIT_IN_NAME if (match := form.fullmatch(name))
                   and (unit := known_unit(match[2]))), None) for name in names]
    ends = [(match[1], unit) if (match := UNIT_AT_END.fullmatch(name)) and (unit := known_unit(match[2])) else None
            for name in names]
    if sum(one is not None for one in ends) > MOSTLY*len(names):
        found = [own or end for own, end in zip(found, ends, strict=True)]
    for k, one in enumerate(found):
        if one:
            names[k], units[k] = one


def _listed_names(lines: Sequence[str], count: int) -> list[str]:
    """Names of all columns from a numbered list above the numbers, as '# column 3: roll angle [rad]', or from Tecplot's variables,
    which may stand on lines of their own; none without it."""
    found = [match for line in lines if (match := LISTED.fullmatch(line))]
    if [int(match[1]) for match in found] == [*range(1, count + 1)]:
        return [match[2] for match in found]
    variables = re.search(r"^\s*variables\s*=(.*?)(?:^\s*zone\b|\Z)", "\n".join(lines), re.IGNORECASE | re.DOTALL | re.MULTILINE)
    names = re.findall(r'"([^"]*)"', variables[1]) or re.split(r"[\s,]+", variables[1].strip()) if variables else []
    return names if len(names) == count else []


def _heading_words(line: str, separator: str, count: int) -> list[str]:
    """Words of a heading without comment mark; a unit in brackets stays with the name before it, and an index may have no name."""
    line = line.rstrip().lstrip((" \t" + COMMENT_MARKS).replace(separator, ""))
    if separator and line.startswith('"'):
        return cells_of(line.rstrip(separator), separator)
    if not separator:
        line = re.sub(r"(?<=[^\s\])])\s+(?=[\[(]\S*[\])])", "", line)
    words = [word.strip("\"'") for word in cells_of(line.rstrip(separator or None), separator, quoted=not separator)]
    while len(words) > count and not words[0]:      # the separator indents the line or marks a comment
        del words[0]
    return words


def known_unit(unit: str) -> str:
    """A unit as `UNITS` writes it; '' of other words."""
    return plain if (plain := plain_unit(unit)) in UNITS else ""


def plain_unit(unit: str) -> str:
    """'[m/s^2]', 'm.s-2', 'm/s**2', 'mps2' and R's 'm.s.2' as 'm/s2', degrees as 'deg', 'µs' as 'us'."""
    plain = unicodedata.normalize("NFKC", unit).strip("[](){}<> ").replace("^", "").replace("\u2212", "-").replace("**", "")
    plain = plain.replace("·", ".").replace("*", ".").replace("°", "deg").replace("\u03bc", "u")
    plain = re.sub(r"[. ]?s[-.]1", "/s", re.sub(r"[./ ]?s([-.]+2|[./]s)", "/s2", plain))
    if plain not in UNITS:
        plain = next((one for one in (re.sub(r"ps(2?)$", r"/s\1", plain), plain.replace(".", "/", 1)) if one in UNITS), plain)
    return {"degrees": "deg", "degree": "deg", "grad": "gon"}.get(plain, plain)


def _wrong_row(path: Path, k: int, lines: Sequence[str], count: int) -> Error:
    return Error(file=path, line=k + 1, expected=f"{count} numbers", found=f"'{lines[k].strip()[:80]}'")


def _no_rows(path: Path, lines: Sequence[str]) -> Error:
    """What to say of a file whose rows all have something else among their numbers, or that has no rows."""
    for k, line in enumerate(lines):
        cells = max((cells_of(line, mark) for mark in SEPARATORS), key=len)
        odd = next((cell for cell in cells if cell and not is_number(cell)), "")
        if odd and len(cells) > 2 and sum(map(is_number, cells)) > len(cells)/2:
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
    plain = plain_unit(unit)
    if plain and plain not in UNITS:
        raise Error(file=path, expected=f"a unit among {', '.join(UNITS)}", found=unit)
    return UNITS[plain] if plain else ("", 1.0)
