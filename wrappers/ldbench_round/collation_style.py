"""What the pages of a collation share: the look of a code's lines, and words that fit their places."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from matplotlib.figure import Figure

from ldbench.plots.style import CODE_LINES, Line
from ldbench.plots.tables import draw_listing

CODES_ON_PAGE = 14
LINES = 50          # of tables on a page
BELOW = "    "      # begins a line that belongs to the one above it


class Table(NamedTuple):
    """A table of a simulation, which stands on a page with others."""

    name: str
    header: list[str]
    rows: list[list[str]]
    widths: list[float]
    left: tuple[int, ...]           # columns that are set to the left
    note: str = ""                  # below the page
    second: Sequence[str] = ()      # a second line of the heading

    @property
    def lines(self) -> int:
        """The lines that it takes: name, heading, rows, and one that stays free; none without rows."""
        return len(self.rows) + 3 + bool(self.second) if self.rows else 0

    def parts(self) -> Iterator[Table]:
        """The table in pieces that fit a page; none without rows."""
        most, start = LINES - 4, 0
        while start < len(self.rows):
            end = start + most
            while start < end < len(self.rows) and self.rows[end][0].startswith(BELOW):
                end -= 1
            yield self._replace(rows=self.rows[start:end])
            start = end


def draw_tables(figure: Figure, tables: Sequence[Table], above: int = 0) -> None:
    """Draw tables one below the other, below so many lines of the page."""
    for table in tables:
        name = [table.name, *[""]*(len(table.header) - 1)]
        heads = [table.header, *([list(table.second)] if table.second else [])]
        draw_listing(figure, name, [*heads, *table.rows], table.widths, table.left, 1 + len(heads), above, LINES)
        above += table.lines


def line_of(k: int) -> Line:
    """The look of a code's lines."""
    return CODE_LINES[k % len(CODE_LINES)]


def capital(words: str) -> str:
    """Words that begin with a capital letter."""
    return words[0].upper() + words[1:]


def cut(words: str, longest: int) -> str:
    """Words that fit a place."""
    return words if len(words) <= longest else f"{words[:longest - 1]}…"
