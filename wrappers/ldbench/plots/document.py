"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import tempfile
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure
from pypdf import PdfReader, PdfWriter
from pypdf.annotations import Link
from pypdf.generic import Fit

from .._core.errors import Error
from .._core.files import check_written, complete
from .._core.pools import call_known, processes
from ..results.run_data import RunData, read_data
from ..results.summary import summary_row
from ..results.twins import Chaotic
from .call_sheets import SHEETS, run_sheet
from .energies import is_ramp, portrait_page, ramp_page
from .figures import overview_figures
from .frame import FOOT, LEFT, RIGHT, new_page
from .geometry import FUNCTIONS, Shape, geometry_page
from .impact import CLOSEUPS, Recomputed, close_page, impact_page
from .sheets import PDF, Chapter, Figures, Part, check_sheets, save_pages, save_parts, save_sheets
from .style import PAGE, SIZE, ldbench_style, plain
from .tables import summary_page

LISTED = 8      # pages from which on a document has a contents page
COLUMNS = 3     # of the contents page
LETTERS = 165   # of a line of its words
TOP, BOTTOM, LINE = 0.88, 0.09, 0.0205      # of its lines, over the height of the page
Rectangle = tuple[float, float, float, float]       # left, bottom, right, top [pt]
Fine = tuple[Recomputed, Recomputed]        # around the first and the hardest contact of the left flange
BUNDLE = 3      # chapters that share a file, at most
FILES = 4       # of a document, at least, where it has as many chapters
TITLE = "ldbench: plots of all results"
EXTRAS = "more pages"       # about a run than the call asks for


class Document(NamedTuple):
    """A document of chapters."""
    target: Path
    title: str
    words: Sequence[str]            # paragraphs on its first page
    front: Iterable[Chapter]        # drawn in this process
    chapters: Sequence[Chapter]     # drawn in others; they build no contact tables: OpenMP's threads do not outlive a fork


def case_figures(run: RunData) -> Iterator[tuple[str, Figure]]:
    """The sheets of a run: of what it has columns for; Error where these make no sheet."""
    drawn = False
    for sheet in SHEETS if "time" in run.data else ():
        if figure := run_sheet(run, sheet):
            drawn = True
            yield sheet.title, figure
    if not drawn:
        raise Error(file=run.file, expected="time and other columns of ours to draw (a map of names, --map, may tell which)",
                    found=", ".join(map(str, run.data)))


def extra_figures(run: RunData, fine: Fine | None = None) -> Iterator[tuple[str, Figure]]:
    """More pages of a run than the call asks for: of what it has columns for."""
    pages = [("impacts of flanges", impact_page(run)),
             ("over the lateral force", ramp_page(run)) if is_ramp(run) else ("phase portraits and spectra", portrait_page(run)),
             *((title, close_page(run, again, title)) for title, again in zip(CLOSEUPS, fine or (), strict=False))]
    yield from ((title, figure) for title, figure in pages if figure)


def check_plots(target: Path, files: Sequence[Path], geometry: Sequence[Path] = ()) -> None:
    """Check before the work that plots of these files can be written."""
    check_written([target], [*files, *geometry])
    check_sheets(target)


def make_plots(runs: Sequence[RunData], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, extras: bool = False) -> int:
    """Write the pages of runs as the ending of `target` says; the number of pages. `done` is called after each run. extras: also
    more pages than the call asks for."""
    check_plots(target, [run.file for run in runs], geometry)
    shapes = [(run := read_data(file), run.data) for file in geometry]
    for run, functions in shapes:
        if lacking := [name for name in FUNCTIONS if name not in functions]:
            raise Error(file=run.file, expected="geometry functions as `ldbench table NAMELIST -o FILE` writes them",
                        found=f"a file without {lacking[0]}")

    def front() -> Iterator[Chapter]:
        yield summary_chapter(runs)
        yield from general_chapters(runs if extras else (), shapes)

    chapters = [*run_chapters(runs), *(extra_chapters(runs) if extras else ())]
    if target.suffix.lower() == PDF:
        with drawing([Document(target, TITLE, (), front(), chapters)], jobs, done) as finish:
            return finish(target)
    with ldbench_style():
        figures = [page for _, pages in front() for _, page in pages]
        for _, pages in chapters:
            figures += [page for _, page in pages]
            done()
        save_sheets(figures, target)
    return len(figures)


def run_chapters(runs: Iterable[RunData]) -> list[Chapter]:
    """The sheets of runs."""
    return [(run.heading, case_figures(run)) for run in runs]


def extra_chapters(runs: Iterable[RunData], fine: Mapping[str, Fine] | None = None) -> list[Chapter]:
    """More pages of runs; `fine`: parts of runs with more rows, by the names of the runs."""
    return [(f"{run.heading}: {EXTRAS}", extra_figures(run, (fine or {}).get(run.name))) for run in runs]


def summary_chapter(runs: Sequence[RunData], chaotic: Chaotic | None = None) -> Chapter:
    """The table of results; `chaotic` ones with their ranges."""
    return "Table of results", [("table of results", summary_page([summary_row(run) for run in runs], chaotic))]


def general_chapters(runs: Sequence[RunData], geometry: Iterable[Shape]) -> Iterator[Chapter]:
    """Geometry functions, and runs side by side."""
    for run, functions in geometry:
        shape = geometry_page(run, functions)
        yield shape.texts[0].get_text(), [("geometry", shape)]
    if beside := list(overview_figures(runs)):
        yield "Side by side", beside


def drawn(run: RunData) -> Figures:
    """The sheets of a run as figures; Error where it has no columns to draw."""
    with ldbench_style():
        return Figures(figure for _, figure in case_figures(run))


def plot_runs(runs: Sequence[RunData], target: Path) -> int:
    """Write the sheets of runs in memory or from files, as the ending of `target` says; returns the number of pages."""
    check_written([target], [])
    check_sheets(target)
    if target.suffix.lower() != PDF:
        figures = [figure for run in runs for figure in drawn(run)]
        save_sheets(figures, target)
        return len(figures)
    return save_document(run_chapters(runs), target, f"ldbench: {', '.join(run.name for run in runs)}")


def save_document(chapters: Iterable[Chapter], target: Path, title: str) -> int:
    """Draw chapters here, one after the other, into a document; the number of its pages."""
    with tempfile.TemporaryDirectory() as scratch:
        return bind(save_parts(Path(scratch)/"pages.pdf", chapters), target, title)


def bundles(chapters: Sequence[Chapter]) -> list[Sequence[Chapter]]:
    """Chapters that share a file, and its fonts: of a few chapters each has its own, so that they are drawn side by side."""
    size = min(BUNDLE, -(-len(chapters)//FILES))
    return [chapters[first:first + size] for first in range(0, len(chapters), size or 1)]


@contextmanager
def drawing(documents: Sequence[Document], jobs: int | None = None,
            done: Callable[[], None] = lambda: None) -> Iterator[Callable[[Path], int]]:
    """Start drawing in worker processes, and give the function that waits for the pages of a document, by its target, and writes
    it; it returns their number. `done` is called for each chapter that is drawn there."""
    # The processes have the runs as they are forked; nothing is sent to them.
    work = [(one.target, bundle) for one in documents for bundle in bundles(one.chapters)]
    known = [partial(save_parts, chapters=bundle) for _, bundle in work]
    with tempfile.TemporaryDirectory() as scratch, processes(jobs, len(work), known) as pool:
        tasks: list[Future[list[Part]]] = [pool.submit(call_known, n, Path(scratch)/f"{n}.pdf") for n in range(len(work))]
        for task, (_, bundle) in zip(tasks, work, strict=True):
            for _ in bundle:
                task.add_done_callback(lambda _: done())
        fronts = {}
        for k, one in enumerate(documents):
            with ldbench_style():
                fronts[one.target] = one, save_parts(Path(scratch)/f"front{k}.pdf", list(one.front))

        def finish(target: Path) -> int:
            one, front = fronts[target]
            rest = [part for task, (own, _) in zip(tasks, work, strict=True) if own == target for part in task.result()]
            return bind([*front, *rest], target, one.title, one.words)

        yield finish


def bind(parts: Sequence[Part], target: Path, title: str = TITLE, words: Sequence[str] = ()) -> int:
    """Put parts together with bookmarks, page numbers and, if they are many, a first page with `words` and the contents; the number
    of pages."""
    writer = PdfWriter()
    listed = len(parts) > 1 and sum(len(part.pages) for part in parts) >= LISTED
    lines = entries([(part.title, part.pages) for part in parts], 2 if listed else 1)
    links: list[tuple[Rectangle, int]] = []
    with tempfile.TemporaryDirectory() as scratch, ldbench_style():
        if listed:
            heading = title.removeprefix("ldbench: ")
            page, links = contents_page(heading[0].upper() + heading[1:], lines, words)
            save_pages(Path(scratch)/"contents.pdf", [("contents", page)])
            writer.append(PdfReader(Path(scratch)/"contents.pdf"), import_outline=False)
            writer.add_outline_item(title="Contents", page_number=0)
        files = {part.file: PdfReader(part.file) for part in parts}
        for part in parts:
            writer.append(files[part.file], pages=(part.first, part.first + len(part.pages)), import_outline=False)
        chapter = None
        for line in lines:
            item = writer.add_outline_item(title=line.words, page_number=line.page - 1, parent=None if line.chapter else chapter)
            chapter = item if line.chapter else chapter
        for rectangle, page_number in links:
            writer.add_annotation(0, Link(rect=rectangle, target_page_index=page_number - 1, fit=Fit("/Fit")))
        number(writer, Path(scratch)/"numbers.pdf")
    writer.add_metadata({"/Title": title})
    writer.compress_identical_objects()
    with complete(target) as file:
        writer.write(file)
    return len(writer.pages)


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


def contents_page(title: str, lines: Sequence[Entry], words: Sequence[str] = ()) -> tuple[Figure, list[tuple[Rectangle, int]]]:
    """The page of `words` and contents, the places of its links, and the numbers of the pages to which they lead, from 1."""
    figure = new_page(title, "contents", "each line leads to its page; the bookmarks of the document are the same")
    highest = TOP
    for line in (part for paragraph in words for part in (*textwrap.wrap(paragraph, LETTERS), "")):
        figure.text(LEFT, highest, plain(line), fontsize=SIZE + 1, va="top")
        highest -= LINE
    columns = arranged(lines)
    rows = max(map(len, columns), default=1)
    height = min(LINE, (highest - BOTTOM)/rows)
    width = (RIGHT - LEFT)/COLUMNS
    targets = []
    for column, row, entry in ((j, k, entry) for j, found in enumerate(columns) for k, entry in enumerate(found)):
        left, top = LEFT + width*column, highest - height*row
        indent = 0.0 if entry.chapter else 0.012
        weight = "bold" if entry.chapter else "normal"
        size = SIZE*min(1.0, height/LINE)
        figure.text(left + indent, top, plain(entry.words), fontsize=size, weight=weight, va="top")
        figure.text(left + width - 0.03, top, f"{entry.page}", fontsize=size, weight=weight, va="top", ha="right")
        x, y = 72*PAGE[0], 72*PAGE[1]
        targets.append(((left*x, (top - 0.85*height)*y, (left + width - 0.03)*x, (top + 0.15*height)*y), entry.page))
    return figure, targets


def arranged(lines: Sequence[Entry]) -> list[list[Entry]]:
    """The lines in columns as short as possible; a chapter is not broken."""
    starts = [k for k, line in enumerate(lines) if line.chapter]
    chapters = [lines[first:after] for first, after in zip(starts, [*starts[1:], len(lines)], strict=True)]
    for rows in range(max(map(len, chapters), default=1), len(lines) + 1):
        columns: list[list[Entry]] = [[]]
        for chapter in chapters:
            if len(columns[-1]) + len(chapter) > rows:
                columns.append([])
            columns[-1] += chapter
        if len(columns) <= COLUMNS:
            return columns
    return [list(lines)]


def number(writer: PdfWriter, scratch: Path) -> None:
    """Write 'page / pages' at the foot of every page, by way of a scratch file."""
    numbers = []
    for k in range(len(writer.pages)):
        numbers.append(("", Figure(figsize=PAGE, facecolor="none")))
        numbers[-1][1].text(RIGHT, FOOT, f"{k + 1} / {len(writer.pages)}", color="0.25", ha="right", va="baseline")
    save_pages(scratch, numbers)
    for page, own in zip(writer.pages, PdfReader(scratch).pages, strict=True):
        page.merge_page(own)
        page.compress_content_streams()
