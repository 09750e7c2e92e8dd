"""Contents page and page numbers of a document."""
from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.figure import Figure
from pypdf import PageObject, PdfWriter
from pypdf.generic import ArrayObject, DecodedStreamObject, DictionaryObject, NameObject

from .frame import FOOT, LEFT, RIGHT, new_page
from .style import PAGE, plain

COLUMNS = 3             # of the contents page
TOP, BOTTOM, LINE = 0.88, 0.09, 0.0195      # of its lines, over the height of the page
Rectangle = tuple[float, float, float, float]       # left, bottom, right, top [pt]
SIZE = 7                # of page numbers [pt]
CORNER = RIGHT*72*PAGE[0], FOOT*72*PAGE[1]      # where a page number ends [pt]
FONT = NameObject("/PageNumber")
WIDTH = {" ": 0.278, "/": 0.278}            # of characters of Helvetica over the size; digits are 0.556 wide


class Entry(NamedTuple):
    """A line of the contents page."""
    words: str
    page: int           # number of the page, from 1
    chapter: bool


def entries(parts: Sequence[tuple[str, Sequence[str]]], first: int) -> list[Entry]:
    """The lines for parts of the document, of which the first begins on page `first`. A part of one page has one line."""
    found, page = [], first
    for title, pages in parts:
        found.append(Entry(title, page, True))
        if len(pages) > 1:
            found += [Entry(words, page + k, False) for k, words in enumerate(pages)]
        page += len(pages)
    return found


def contents_page(title: str, lines: Sequence[Entry]) -> tuple[Figure, list[tuple[Rectangle, int]]]:
    """The contents page, the places of its links, and the numbers of the pages to which they lead, from 1."""
    figure = new_page(title, "contents", "each line leads to its page; the bookmarks of the document are the same")
    columns = arranged(lines)
    rows = max(map(len, columns), default=1)
    height = min(LINE, (TOP - BOTTOM)/rows)
    width = (RIGHT - LEFT)/COLUMNS
    targets = []
    for column, row, entry in ((j, k, entry) for j, found in enumerate(columns) for k, entry in enumerate(found)):
        left, top = LEFT + width*column, TOP - height*row
        indent = 0.0 if entry.chapter else 0.012
        weight = "bold" if entry.chapter else "normal"
        size = 8*min(1.0, height/LINE)
        figure.text(left + indent, top, plain(entry.words), fontsize=size, weight=weight, va="top")
        figure.text(left + width - 0.03, top, f"{entry.page}", fontsize=size, weight=weight, va="top", ha="right")
        x, y = 72*PAGE[0], 72*PAGE[1]
        targets.append(((left*x, (top - 0.85*height)*y, (left + width - 0.03)*x, (top + 0.15*height)*y), entry.page))
    return figure, targets


def arranged(lines: Sequence[Entry]) -> list[list[Entry]]:
    """The lines in columns as short as possible; a chapter is not broken."""
    chapters: list[list[Entry]] = []
    for line in lines:
        if line.chapter or not chapters:
            chapters.append([])
        chapters[-1].append(line)
    for rows in range(max(map(len, chapters), default=1), len(lines) + 1):
        columns: list[list[Entry]] = [[]]
        for chapter in chapters:
            if len(columns[-1]) + len(chapter) > rows:
                columns.append([])
            columns[-1] += chapter
        if len(columns) <= COLUMNS:
            return columns
    return [list(lines)]


def number(writer: PdfWriter) -> None:
    """Write 'page / pages' at the foot of every page."""
    font = writer._add_object(DictionaryObject({
        NameObject("/Type"): NameObject("/Font"), NameObject("/Subtype"): NameObject("/Type1"),
        NameObject("/BaseFont"): NameObject("/Helvetica"), NameObject("/Encoding"): NameObject("/WinAnsiEncoding")}))
    for k, page in enumerate(writer.pages):
        words = f"{k + 1} / {len(writer.pages)}"
        x = CORNER[0] - SIZE*sum(WIDTH.get(character, 0.556) for character in words)
        stream = DecodedStreamObject()
        stream.set_data(f"q BT {FONT} {SIZE} Tf 0.25 g {x:.2f} {CORNER[1]:.2f} Td ({words}) Tj ET Q\n".encode())
        append(page, writer, stream)
        resources = page["/Resources"].get_object()
        assert isinstance(resources, DictionaryObject)
        fonts = resources.setdefault(NameObject("/Font"), DictionaryObject()).get_object()
        assert isinstance(fonts, DictionaryObject)
        fonts[FONT] = font


def append(page: PageObject, writer: PdfWriter, stream: DecodedStreamObject) -> None:
    """Add a stream behind the contents of a page."""
    contents = page.raw_get("/Contents")
    earlier = contents if isinstance(contents, ArrayObject) else ArrayObject([contents])
    page[NameObject("/Contents")] = ArrayObject([*earlier, writer._add_object(stream)])
