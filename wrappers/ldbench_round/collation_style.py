"""What the pages of a collation share: tables, the matrix of codes by simulations, the look of a code's lines."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ldbench.plots.frame import new_page
from ldbench.plots.style import CODE_LINES, Line, plain
from ldbench.plots.tables import draw_listing
from ldbench.results.quantities import PAIRS

from .collation import Collation
from .submissions import Submission

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


@dataclass(frozen=True)
class Matrix:
    """A page with the heads of its columns."""

    figure: Figure
    ax: Axes                        # from 0 to 1 in both directions
    codes: tuple[Submission, ...]   # one for every row
    start: int                      # place of the first of them among all codes
    first: float                    # where the first column begins
    width: float                    # of a column
    height: float                   # of a row

    def name_row(self, i: int, longest: int) -> float:
        """Draw line and name of a code, cut to its `longest` characters; returns the middle of the row."""
        y = 1 - (i + 1.5)*self.height
        self.ax.plot([0.002, 0.022], [y, y], **line_of(self.start + i).kwargs() | {"linewidth": 1.6})
        self.ax.text(0.028, y, plain(cut(self.codes[i].name, longest)), ha="left", va="center", fontsize=7.5, weight="bold")
        return y


def new_matrix(found: Collation, start: int, title: str, facts: str, note: str, first: float,
               least: int) -> Matrix:
    """A page with rows for the codes from one on. facts: beside the title; note: below the matrix; least: rows of a page."""
    codes = found.codes[start:start + CODES_ON_PAGE]
    figure = new_page(title, facts, note)
    ax = figure.add_subplot()
    ax.set_axis_off()
    ax.set(xlim=(0, 1), ylim=(0, 1))
    width, height = (1 - first)/len(found.tasks), 1/(max(len(codes), least) + 1)
    for j, task in enumerate(found.tasks):
        ax.text(first + (j + 0.5)*width, 1 - 0.5*height, f"exercise {task.exercise}\n{PAIRS[task.profiles].split()[0]}",
                ha="center", va="center", fontsize=7, weight="bold")
    return Matrix(figure, ax, codes, start, first, width, height)
