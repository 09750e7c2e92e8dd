"""A4 pages of texts, tables and figures, for the PDF files of the validation and of the benchmark."""
from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path

from ldbench.plots.style import GREY, PAGE, RED

WIDTH, HEIGHT = (72*x for x in PAGE)    # [pt]
LEFT, RIGHT, TOP, BOTTOM = 34.0, WIDTH - 34.0, HEIGHT - 40.0, 40.0
GAP = 10.0                              # between columns [pt]
LEADING = 1.35                          # line distance over font size
CELL = 7.5                              # font size of tables [pt]


@dataclass
class Table:
    """A table of a page; cells are text."""

    title: str
    head: Sequence[str]
    rows: list[Sequence[str]]


class Chapter(Protocol):
    """What `text_pages` needs of a section."""

    title: str
    text: str
    tables: list[Table]


def page(title: str, caption: str) -> Figure:
    """An empty A4 page with a title and a caption below; axes go into its constrained layout."""
    figure = Figure(figsize=PAGE, layout="constrained")
    figure.get_layout_engine().set(rect=(0.03, 0.07, 0.94, 0.86), w_pad=0.12, h_pad=0.1)
    figure.text(0.04, 0.955, title, fontsize=12, weight="bold", va="center")
    figure.text(0.04, 0.04, caption, fontsize=7.5, va="center", wrap=True)
    return figure


def text_pages(section: Chapter) -> list[Figure]:
    """Title, text and tables of a section."""
    sheets = Sheets(section.title)
    for paragraph in re.split(r"\n\s*\n", section.text):
        sheets.paragraph(paragraph)
    for table in section.tables:
        sheets.table(table)
    return sheets.figures


class Sheets:
    """Pages that are filled from top to bottom."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.figures: list[Figure] = []
        self.turn()

    def turn(self) -> None:
        """Begin a page."""
        figure = Figure(figsize=PAGE)
        title = self.title if not self.figures else f"{self.title} ({len(self.figures) + 1})"
        figure.text(LEFT/WIDTH, TOP/HEIGHT, title, fontsize=12, weight="bold", va="top")
        self.figures.append(figure)
        self.y = TOP - 26       # below which there is nothing yet [pt]

    def write(self, x: float, line: int, text: str, size: float, **style: object) -> None:
        """A text in one of the lines below self.y."""
        y = self.y - size - line*LEADING*size
        self.figures[-1].text(x/WIDTH, y/HEIGHT, text, fontsize=size, va="baseline", **style)

    def rule(self, width: float = 0.4) -> None:
        y = (self.y + 2)/HEIGHT
        self.figures[-1].add_artist(Line2D((LEFT/WIDTH, RIGHT/WIDTH), (y, y), linewidth=width, color=GREY))

    def paragraph(self, text: str, size: float = 9.0) -> None:
        for line in wrapped(text, RIGHT - LEFT, size):
            if self.y - LEADING*size < BOTTOM:
                self.turn()
            self.write(LEFT, 0, line, size)
            self.y -= LEADING*size
        self.y -= size/2

    def table(self, table: Table) -> None:
        """A table; its title and head are repeated on every page that it runs over."""
        widths = column_widths(table)
        right = [all(is_number(row[j]) for row in table.rows) for j in range(len(table.head))]
        rows = [[wrapped(cell, width, CELL) for cell, width in zip(row, widths, strict=True)] for row in table.rows]
        head = [wrapped(cell, width, CELL, "bold") for cell, width in zip(table.head, widths, strict=True)]
        begin = height(head) + 9*LEADING + 18
        if self.y - begin - (height(rows[0]) if rows else 0) < BOTTOM:
            self.turn()
        self.head(table.title, head, widths, right)
        for row in rows:
            if self.y - height(row) < BOTTOM:
                self.turn()
                self.head(f"{table.title}, continued", head, widths, right)
            self.row(row, widths, right)
        self.y -= 12

    def head(self, title: str, cells: Sequence[Sequence[str]], widths: Sequence[float], right: Sequence[bool]) -> None:
        self.write(LEFT, 0, title, 9, weight="bold")
        self.y -= 9*LEADING + 3
        self.row(cells, widths, right, weight="bold")
        self.rule(0.8)

    def row(self, cells: Sequence[Sequence[str]], widths: Sequence[float], right: Sequence[bool],
            **style: object) -> None:
        x = LEFT
        for lines, width, to_right in zip(cells, widths, right, strict=True):
            colour = {"color": RED, "weight": "bold"} if lines == ["OUTSIDE"] else {}
            for k, line in enumerate(lines):
                self.write(x + width*to_right, k, line, CELL, ha="right" if to_right else "left", **style, **colour)
            x += width + GAP
        self.y -= height(cells)
        self.rule()


def height(cells: Sequence[Sequence[str]]) -> float:
    """The height of a row of a table [pt]."""
    return LEADING*CELL*max(map(len, cells)) + 4


def column_widths(table: Table) -> list[float]:
    """What each column needs [pt]; the widest share what is left when there is not enough."""
    needed = [max((text_width(cell, CELL, "bold") for cell in column), default=0.0) + 1
              for column in zip(table.head, *table.rows, strict=True)]
    left, open_columns = RIGHT - LEFT - GAP*(len(needed) - 1), sorted(needed)
    while open_columns and open_columns[0] <= left/len(open_columns):
        left -= open_columns.pop(0)
    widest = left/len(open_columns) if open_columns else max(needed)
    return [min(width, widest) for width in needed]


def wrapped(text: str, width: float, size: float, weight: str = "normal") -> list[str]:
    """Lines of at most `width` [pt]; a longer word is broken."""
    lines, line = [], ""
    for word in text.split():
        while text_width(word, size, weight) > width and len(word) > 1:
            fits = next(n for n in range(len(word) - 1, 0, -1) if n == 1 or text_width(word[:n], size, weight) <= width)
            lines += [line] if line else []
            lines.append(word[:fits])
            line, word = "", word[fits:]
        longer = f"{line} {word}" if line else word
        if line and text_width(longer, size, weight) > width:
            lines.append(line)
            longer = word
        line = longer
    return [*lines, line]


def text_width(text: str, size: float, weight: str = "normal") -> float:
    """The width of a line, without kerning [pt]."""
    advance = advances(weight)
    return size*sum(advance(letter) for letter in text)


@functools.cache
def advances(weight: str) -> Callable[[str], float]:
    """Width of a letter at size 1; looking the font up takes longer than anything else here."""
    font = FontProperties("DejaVu Sans", size=1.0, weight=weight)
    return functools.cache(lambda letter: text_to_path.get_text_width_height_descent(letter, font, ismath=False)[0])


def is_number(cell: str) -> bool:
    return re.fullmatch(r"[-+−–]?[\d.,]*(e[-+]?\d+)?|", cell) is not None
