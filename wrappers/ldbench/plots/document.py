"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import gc
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from pypdf import PdfReader, PdfWriter

from .._core import check_written, complete, usable_cores
from ..record import Record, read_record, summary_row
from ..style import ldbench_style
from .geometry import geometry_page
from .phase import phase_page
from .quantities import IMPULSES, PAGES
from .sections import section_page
from .summary import SUMMARY_NOTE, summary_page
from .ticks import simplify_ticks
from .times import time_page


@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles
    summary: dict[str, object] | None = None


def case_figures(record: Record) -> Iterable[tuple[str, Figure]]:
    for page in (*PAGES, IMPULSES) if "E_lost" in record.columns else PAGES:
        yield page.title, time_page(record, page)
    yield "phase portrait", phase_page(record)
    picture = section_page(record)
    if picture is not None:
        yield "cross-sections", picture


def save_pages(path: Path, figures: Iterable[tuple[str, Figure]]) -> tuple[str, ...]:
    titles = []
    with PdfPages(path, metadata={"CreationDate": None}) as pdf, no_collection():
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


def case_part(source: Path | bytes, target: Path) -> Part:
    """All pages of one run, from its column file or a pickled Record."""
    record = pickle.loads(source) if isinstance(source, bytes) else read_record(source)
    with ldbench_style():
        return Part(record.heading, target, save_pages(target, case_figures(record)), summary_row(record))


def geometry_part(source: Path, target: Path) -> Part:
    with ldbench_style():
        figure = geometry_page(source)
        title = figure.texts[0].get_text()
        return Part(title, target, save_pages(target, [("geometry", figure)]))


def summary_part(rows: Sequence[dict[str, object]], target: Path) -> Part:
    with ldbench_style():
        return Part("Summary", target, save_pages(target, [("summary", summary_page(rows, SUMMARY_NOTE))]))


def make_plots(files: Sequence[Path | Record], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, further: Sequence[Callable[[Path], Part]] = ()) -> int:
    """Write the PDF of plots of column files, or of what was read of them; the number of its pages.  `done` is called
    after each; `further` make last parts in a file, in other processes."""
    with drawing(files, target, geometry, jobs, done, further) as finish:
        return finish()


@contextmanager
def drawing(files: Sequence[Path | Record], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
            done: Callable[[], None] = lambda: None,
            further: Sequence[Callable[[Path], Part]] = ()) -> Iterator[Callable[[], int]]:
    """`make_plots` beside what else is to do: pages are drawn from the start, and the function that it gives waits for
    them and writes the document.  `further` build no contact tables: OpenMP's threads do not outlive a fork."""
    sources = [file.file if isinstance(file, Record) else file for file in files]
    check_written([target], [*sources, *geometry])
    with tempfile.TemporaryDirectory() as scratch, ProcessPoolExecutor(jobs or usable_cores()) as pool:
        # Pickled here: the pool would do it in a thread, while the caller goes on with the records.
        runs = [pickle.dumps(f, pickle.HIGHEST_PROTOCOL) if isinstance(f, Record) else f for f in files]
        # The longest first; the order of the document is that of the files.
        work = [partial(case_part, run) for run in runs] + [partial(geometry_part, f) for f in geometry] + list(further)
        sizes = [f.stat().st_size for f in (*sources, *geometry)] + [1 << 24]*len(further)
        order = sorted(range(len(work)), key=lambda k: -sizes[k])
        tasks = {k: pool.submit(work[k], Path(scratch)/f"{k}.pdf") for k in order}
        for k in range(len(files) + len(geometry)):
            tasks[k].add_done_callback(lambda _: done())

        def finish() -> int:
            parts = [tasks[k].result() for k in range(len(work))]
            runs, shapes = parts[:len(files)], parts[len(files):len(files) + len(geometry)]
            summary = summary_part([part.summary for part in runs], Path(scratch)/"summary.pdf")
            return bind([summary, *shapes, *runs, *parts[len(files) + len(geometry):]], target)

        try:
            yield finish
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


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
