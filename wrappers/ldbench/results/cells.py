"""Cells and rows of column files of any code: what is a number, what stands for none, and which lines are no rows."""
from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np

COMMENT_MARKS = "#%!;*"
SEPARATORS = ";", "\t", ",", "|", ""        # the last one stands for blanks
EXPONENT = re.compile(r"(?<=[\d.])(?=[+-]\d{3}(?!\d))")   # where Fortran leaves out the letter of an exponent of three digits
# Words of a cell without a number: of people, of spreadsheets, of Fortran where the field is too narrow, of C on Windows.
NO_NUMBER = re.compile(
    r"n/?a|n\.[adv]\.|none|null|missing|undef(?:ined)?|[-\u2013\u2014]+|##+|#[\w/]+[!?]?|\*\*+|[+-]?nan(?:\(\w*\))?|"
    r"[+-]?\d\.?#\w+", re.IGNORECASE)
# A group of digits ends at such a mark; a cell of a sheet may have them where a thousand is marked.
GROUPS = "\u00a0\u202f\u2009'\u2019"
_GROUP = re.compile(rf"(?<=\d)[{GROUPS}](?=\d{{3}}(?!\d))")
_OPENS = re.compile(r"\s*\w*\s*=?\s*[\[{(]\s*(?:\.\.\.)?\s*")         # the line that opens a matrix, as of MATLAB


USUAL = "", "nan"       # what stands for no number and needs no telling


class Word(NamedTuple):
    """A word that stands for no number, beside those of USUAL."""

    word: str
    number: int         # how often
    line: int           # where it is first, from 1
    column: int         # there, from 1


class Table(NamedTuple):
    """The rows of a file."""

    numbers: np.ndarray         # (rows, columns)
    words: tuple[Word, ...]     # that stand for no number
    wrong: int | None           # the first line that is no row, from 0; None without one


def plain_lines(text: str) -> list[str]:
    """The lines of a text as plain numbers and separators: without marks of pages and of groups of digits, with hyphens for minus
    signs, without the strokes at both ends of a row and the brackets about a matrix."""
    return [_plain_line(line) for line in text.replace("\u2212", "-").replace("\f", "").split("\n")]


def _plain_line(line: str) -> str:
    if "'" in line or not line.isascii():       # else it has no mark of GROUPS
        line = _GROUP.sub("", line).replace("\u00a0", " ")
    bare = line.strip(" ")
    if bare[:1] == "|" == bare[-1:] and len(bare) > 1:
        return bare[1:-1]
    if bare[-1:] == ";" and bare.count(";") == 1 and len(bare.split()) > 1:
        return bare[:-1]            # ends a row of a matrix
    return "" if bare and _OPENS.fullmatch(bare) else line


def row_separator(line: str) -> str | None:
    """What separates the cells of a row of numbers; None of another line."""
    for mark in SEPARATORS:
        cells = cells_of(line, mark)
        if len(cells) > 1 and any(has_digits(cell) for cell in cells) and all(is_number(cell) for cell in cells if cell):
            return mark
    return None


def numbers_columns(line: str, separator: str) -> bool:
    """Whether a line counts the columns: 1, 2, 3 and on."""
    cells = [cell.strip("()[]") for cell in cells_of(line.lstrip(COMMENT_MARKS), separator)]
    return len(cells) > 2 and cells == [str(k) for k in range(1, len(cells) + 1)]


def has_digits(cell: str) -> bool:
    """Whether a cell is a number and no word that stands for none."""
    return bool(cell) and not stands_for_none(cell) and is_number(cell)


def stands_for_none(cell: str) -> bool:
    """Whether a cell is empty or has a word for no number."""
    return not cell or ((not cell[-1].isdigit() or "#" in cell) and NO_NUMBER.fullmatch(cell) is not None)


def is_number(cell: str) -> bool:
    """Whether a cell is a number, or a word that stands for none."""
    if cell and stands_for_none(cell):
        return True
    try:
        float(EXPONENT.sub("e", plain_number(cell)))
    except ValueError:
        return False
    return cell.isascii() and "_" not in cell


def plain_number(words: str) -> str:
    """Rewrite Fortran's exponents and decimal commas as Python reads them."""
    words = words.replace(",", ".")
    return re.sub("[dD]", "e", words) if "d" in words or "D" in words else words


def cells_of(line: str, separator: str, quoted: bool = True) -> list[str]:
    """The cells of a line; quotes about a cell, if any, keep its separators and are taken away."""
    if quoted and '"' in line:
        if separator:
            with suppress(csv.Error):
                return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
        return [inside or bare for inside, bare in re.findall(r'"([^"]*)"|([^\s"]+)', line)]
    return [cell.strip() for cell in line.split(separator)] if separator else line.split()


def is_comment(line: str, separator: str) -> bool:
    """Whether a line is a comment; a row may begin with stars or #N/A for a number."""
    mark = line.lstrip()[:1]
    return mark != separator and mark in tuple(COMMENT_MARKS) and (
        mark not in "#*" or NO_NUMBER.fullmatch(cells_of(line, separator)[0]) is None or row_separator(line) is None)


def read_rows(lines: Sequence[str], start: int, count: int, separator: str) -> Table:
    """The rows from a line on. Words below the last row, and a head that stands again between rows, are no rows."""
    given = {k: line for k, line in enumerate(lines[start:], start) if line.strip() and not is_comment(line, separator)}
    with suppress(ValueError):          # something else than numbers
        table = np.loadtxt(given.values(), delimiter=separator or None, comments=None, ndmin=2)
        if table.shape[1] == count:
            return Table(table, (), None)
    head = {line.strip() for line in lines[:start] if re.search(r"\w", line)}
    rows: dict[int, str] = {}
    words: dict[str, list[tuple[int, int]]] = {}
    odd: list[int] = []
    for k, line in given.items():
        cells = cells_of(line, separator)
        if len(cells) == count + 1 and not cells[-1]:
            cells.pop()
        if len(cells) != count:
            if line.strip() not in head and re.search(r"\w", line):
                odd.append(k)
            continue
        if line.strip() in head:
            continue
        for at, cell in enumerate(cells):
            if stands_for_none(cell):
                words.setdefault(cell, []).append((k, at))
                cells[at] = "nan"
        rows[k] = EXPONENT.sub("e", plain_number(" ".join(cells)))
    last = max(rows, default=start)
    wrong = next((k for k in odd if k < last or _has_numbers(lines[k], separator)), None)
    if wrong is None:
        with suppress(ValueError):
            return Table(np.loadtxt(rows.values(), comments=None, ndmin=2), _of_words(words), None)
        wrong = next((k for k, row in rows.items()
                      if len(row.split()) != count or not all(is_number(cell) for cell in row.split())), start)
    return Table(np.empty((0, count)), (), wrong)


def _has_numbers(line: str, separator: str) -> bool:
    """Whether the first or most of the cells of a line are numbers: it is a row that broke off, and no words."""
    cells = cells_of(line, separator)
    return has_digits(cells[0]) or 2*sum(map(has_digits, cells)) > len(cells)


def _of_words(found: dict[str, list[tuple[int, int]]]) -> tuple[Word, ...]:
    """The words, but NaN and empty cells, which every code may write."""
    return tuple(Word(word, len(at), at[0][0] + 1, at[0][1] + 1) for word, at in found.items() if word.lower() not in USUAL)
