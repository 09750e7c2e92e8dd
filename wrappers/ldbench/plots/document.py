"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import gc
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from pypdf import PdfReader, PdfWriter

from .._core import check_ending, check_written, complete, failing_as
from ..pools import processes
from ..record import Record, read_records, summary_row
from ..style import ldbench_style
from .geometry import geometry_page
from .phase import phase_page
from .quantities import IMPULSES, PAGES
from .sections import section_page
from .stretches import ENVELOPE_ROWS
from .summary import SUMMARY_NOTE, summary_page
from .ticks import simplify_ticks
from .times import time_page


@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles


def case_figures(record: Record) -> Iterable[tuple[str, Figure]]:
    for page in (*PAGES, IMPULSES) if "E_lost" in record.columns else PAGES:
        yield page.title, time_page(record, page)
    yield "phase portrait", phase_page(record)
    picture = section_page(record)
    if picture is not None:
        yield "cross-sections", picture


def save_pages(path: Path, figures: Iterable[tuple[str, Figure]]) -> tuple[str, ...]:
    titles = []
    with failing_as(path, path), PdfPages(path, metadata={"CreationDate": None}) as pdf, no_collection():
        for title, figure in figures:
            simplify_ticks(figure)
            pdf.savefig(figure)
            titles.append(title)
    return tuple(titles)


@contextmanager
def no_collection() -> Iterator[None]:
    """Without looking for garbage: a figure is a million objects that all live until it is saved, and a search through
    them takes a quarter of the time of drawing."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def case_part(pickled: bytes, target: Path) -> Part:
    """All pages of one run."""
    record = pickle.loads(pickled)
    with ldbench_style():
        return Part(record.heading, target, save_pages(target, case_figures(record)))


def geometry_part(source: Path, target: Path) -> Part:
    with ldbench_style():
        figure = geometry_page(source)
        title = figure.texts[0].get_text()
        return Part(title, target, save_pages(target, [("geometry", figure)]))


def summary_part(rows: Sequence[dict[str, Any]], target: Path) -> Part:
    with ldbench_style():
        return Part("Summary", target, save_pages(target, [("summary", summary_page(rows, SUMMARY_NOTE))]))


def make_plots(files: Sequence[Path], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None) -> int:
    """Write the PDF of plots of column files; the number of its pages.  `done` is called after each file."""
    check_written([target], [*files, *geometry])
    check_ending(target, "a document .pdf, which holds all pages (`view --film FILE.png` makes a picture of one moment)", ".pdf")
    with drawing(read_records(files, jobs), target, geometry, jobs, done) as finish:
        return finish()


@contextmanager
def drawing(records: Sequence[Record], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
            done: Callable[[], None] = lambda: None,
            further: Sequence[Callable[[Path], Part]] = ()) -> Iterator[Callable[[], int]]:
    """`make_plots` beside what else is to do: other processes draw from the start, and the function that this gives waits
    for them and writes the document.  `further` make last parts in a file, there too; they build no contact tables:
    OpenMP's threads do not outlive a fork."""
    tasks_in_all = len(records) + len(geometry) + len(further)
    with tempfile.TemporaryDirectory() as scratch, processes(jobs, tasks_in_all) as pool:
        # Pickled here: the pool would do it in a thread, while the caller goes on with the records.
        runs = [partial(case_part, pickle.dumps(record, pickle.HIGHEST_PROTOCOL)) for record in records]
        work = [partial(geometry_part, file) for file in geometry] + runs + list(further)
        # The longest first; the order of the document is another.
        sizes = [0]*len(geometry) + [len(record.time) for record in records] + [ENVELOPE_ROWS]*len(further)
        order = sorted(range(len(work)), key=lambda k: -sizes[k])
        tasks = {k: pool.submit(work[k], Path(scratch)/f"{k}.pdf") for k in order}
        for k in range(len(geometry) + len(records)):
            tasks[k].add_done_callback(lambda _: done())
        summary = summary_part([summary_row(record) for record in records], Path(scratch)/"summary.pdf")
        yield lambda: bind([summary, *(tasks[k].result() for k in range(len(work)))], target)


def bind(parts: Sequence[Part], target: Path, title: str = "ldbench: plots of all results") -> int:
    """Put parts together with bookmarks."""
    writer = PdfWriter()
    for part in parts:
        start = len(writer.pages)
        writer.append(PdfReader(part.file), import_outline=False)
        chapter = writer.add_outline_item(title=part.title, page_number=start)
        if len(part.pages) > 1:
            for k, name in enumerate(part.pages):
                writer.add_outline_item(title=name, page_number=start + k, parent=chapter)
    writer.add_metadata({"/Title": title})
    writer.compress_identical_objects()
    with complete(target) as scratch:
        writer.write(scratch)
    return len(writer.pages)
