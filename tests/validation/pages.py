"""The PDF of the validation: an overview of all checks, then text, tables and figures of each section."""
from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable, Sequence
from pathlib import Path

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path
from pypdf import PdfReader, PdfWriter

import ldbench
from checks import Check, Section, Table, number
from ldbench._core import complete
from ldbench.style import GREY, PAGE, RED, ldbench_style

WIDTH, HEIGHT = (72*x for x in PAGE)    # [pt]
LEFT, RIGHT, TOP, BOTTOM = 34.0, WIDTH - 34.0, HEIGHT - 40.0, 40.0
GAP = 10.0                              # between columns [pt]
LEADING = 1.35                          # line distance over font size
CELL = 7.5                              # font size of tables [pt]

OVERVIEW = "section", "quantity", "value", "reference", "source of the reference", "deviation", "bar", "verdict"


def write_pdf(path: Path, sections: dict[str, Section]) -> None:
    """Write the document; same sections, same bytes. It appears under its name when it is complete."""
    writer, pages = PdfWriter(), io.BytesIO()
    with ldbench_style(), PdfPages(pages, metadata={"CreationDate": None, "ModDate": None}) as pdf:
        chapters = [("Overview", "overview", overview(sections)),
                    *((s.title, name, (*text_pages(s), *s.figures)) for name, s in sections.items())]
        for _, name, figures in chapters:
            for figure in figures:
                save(pdf, figure, name)
    writer.append(PdfReader(pages), import_outline=False)
    k = 0
    for title, _, figures in chapters:
        chapter = writer.add_outline_item(title=title, page_number=k)
        for figure in figures:
            writer.add_outline_item(title=figure.texts[0].get_text(), page_number=k, parent=chapter)
            k += 1
    writer.add_metadata({"/Title": f"ldbench {ldbench.__version__}: validation"})
    with complete(path) as scratch:
        writer.write(scratch)


def save(pdf: PdfPages, figure: Figure, name: str) -> None:
    """Write a page with a footer."""
    footer = figure.text(RIGHT/WIDTH, 7/HEIGHT, f"ldbench {ldbench.__version__}, validation: {name}, "
                         f"page {pdf.get_pagecount() + 1}", fontsize=6.5, ha="right", va="bottom", color=GREY)
    pdf.savefig(figure)
    footer.remove()


def overview(sections: dict[str, Section]) -> list[Figure]:
    """What was checked, how many checks hold, and all of them."""
    checks = [c for s in sections.values() for c in s.checks]
    outside = sum(not c.inside for c in checks)
    sheets = Sheets("ldbench validation")
    sheets.paragraph(
        f"ldbench {ldbench.__version__}. Every number here is compared with an answer that was found without the code "
        "that is checked: a closed form, another numerical method, or a solution refined until it no longer changes. "
        "The bar is the largest deviation that the stated error estimate allows; it was fixed beforehand. "
        f"{len(checks)} checks: {len(checks) - outside} inside their bars, {outside} outside.")
    sheets.table(Table("Sections", ("section", "", "checks", "inside", "largest deviation over its bar"), [
        (name, s.title, str(len(s.checks)), str(sum(c.inside for c in s.checks)), nearest(s.checks))
        for name, s in sections.items()]))
    sheets.table(Table("All checks", OVERVIEW, [
        (name, c.quantity, number(c.value), number(c.reference), c.source, f"{c.deviation:.1e}", f"{c.bar:.0e}",
         c.verdict) for name, s in sections.items() for c in s.checks]))
    return sheets.figures


def nearest(checks: Sequence[Check]) -> str:
    """The check that comes nearest to its bar, or exceeds it most."""
    shares = [(c.deviation/c.bar, c.quantity) for c in checks if c.bar > 0]
    return "" if not shares else "{:.2g}: {}".format(*max(shares))


def text_pages(section: Section) -> list[Figure]:
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
    """Of a row of a table [pt]."""
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
    """Of a line, without kerning [pt]."""
    advance = advances(weight)
    return size*sum(advance(letter) for letter in text)


@functools.cache
def advances(weight: str) -> Callable[[str], float]:
    """Width of a letter at size 1; looking the font up takes longer than anything else here."""
    font = FontProperties("DejaVu Sans", size=1.0, weight=weight)
    return functools.cache(lambda letter: text_to_path.get_text_width_height_descent(letter, font, ismath=False)[0])


def is_number(cell: str) -> bool:
    return re.fullmatch(r"[-+−–]?[\d.,]*(e[-+]?\d+)?|", cell) is not None
