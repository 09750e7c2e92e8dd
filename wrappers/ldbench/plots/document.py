"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
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
    with PdfPages(path, metadata={"CreationDate": None}) as pdf:
        for title, figure in figures:
            pdf.savefig(figure)
            titles.append(title)
    return tuple(titles)


def case_part(source: Path, target: Path) -> Part:
    """All pages of one run."""
    record = read_record(source)
    with ldbench_style():
        return Part(record.heading, target, save_pages(target, case_figures(record)), summary_row(record))


def geometry_part(source: Path, target: Path) -> Part:
    with ldbench_style():
        figure = geometry_page(source)
        return Part(figure.texts[0].get_text(), target, save_pages(target, [("geometry", figure)]))


def make_plots(files: Sequence[Path], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, further: Callable[[Path], Part] | None = None) -> int:
    """Write the PDF of plots of column files; the number of its pages.  `done` is called after
    each file; `further` makes a last part in a file."""
    check_written([target], [*files, *geometry])
    with tempfile.TemporaryDirectory() as scratch, ProcessPoolExecutor(jobs or usable_cores()) as pool:
        # The longest first; the order of the document is that of the files.
        work = [(case_part, f) for f in files] + [(geometry_part, f) for f in geometry]
        order = sorted(range(len(work)), key=lambda k: -work[k][1].stat().st_size)
        tasks = {k: pool.submit(work[k][0], work[k][1], Path(scratch)/f"{k}.pdf") for k in order}
        for task in tasks.values():
            task.add_done_callback(lambda _: done())
        try:
            parts = [tasks[k].result() for k in range(len(work))]
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
        runs, shapes = parts[:len(files)], parts[len(files):]
        with ldbench_style():
            first = Path(scratch)/"summary.pdf"
            figure = summary_page([part.summary for part in runs], SUMMARY_NOTE)
            parts = [Part("Summary", first, save_pages(first, [("summary", figure)])), *shapes, *runs]
        if further:
            parts.append(further(Path(scratch)/"further.pdf"))
        return bind(parts, target)


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
