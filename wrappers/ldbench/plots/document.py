"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import gc
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from pypdf import PdfReader, PdfWriter

from .._core.errors import Error
from .._core.files import check_ending, check_written, complete, failing_as
from .._core.pools import processes
from ..profiles.pressures import full_row
from ..results.run_data import RunData, read_all, read_data
from .contents import contents_page, entries, link, number
from .geometry import geometry_page
from .impact import HARDEST, Stretch, hardest_page, impact_page
from .overview import overview_figures
from .phase import energy_page
from .ramp import is_ramp, ramp_page
from .series import IMPULSES, LAST, PAGES
from .stretches import ENVELOPE_ROWS, is_long, last_second
from .style import ldbench_style
from .summary import CHAOTIC_NOTE, SUMMARY_NOTE, summary_page
from .times import time_page


@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles


LISTED = 6      # pages from which on a document has a contents page

# Around the first and the hardest contact of the left flange, computed again.
Stretches = tuple[Stretch, Stretch]


def case_figures(run: RunData, fine: Stretches | None = None) -> Iterator[tuple[str, Figure]]:
    """The pages of a run: of what it has columns for."""
    if "time" not in run.data:
        return
    for page in (*PAGES, IMPULSES) if "E_lost" in run.data else PAGES:
        if found := page.of(run):
            yield page.title, time_page(run, found)
    if is_ramp(run):
        yield "energy, and quantities over the lateral force", ramp_page(run)
    elif picture := energy_page(run):
        yield "energy, phase portrait, spectrum", picture
    if is_long(run) and (found := LAST.of(run)):
        yield LAST.title, time_page(run, found, last_second(run))
    if picture := impact_page(run, fine[0] if fine else None):
        yield "impacts of flanges", picture
    if fine:
        yield HARDEST, hardest_page(run, fine[1])


def save_pages(path: Path, figures: Iterable[tuple[str, Figure]]) -> tuple[str, ...]:
    """Write figures as the pages of a PDF; returns their titles."""
    titles = []
    with failing_as(path, path), PdfPages(path, metadata={"CreationDate": None}) as pdf, no_collection():
        for title, figure in figures:
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
    run, fine = pickle.loads(pickled)
    with ldbench_style():
        return run_part(run, target, fine)


def run_part(run: RunData, target: Path, fine: Stretches | None = None) -> Part:
    """All pages of one run, in the style that is set; Error where it has no columns to draw."""
    if not (titles := save_pages(target, case_figures(run, fine))):
        raise Error(f"{run.file}: expected time and other columns of ours to draw (a map of names, --map, may tell which), "
                    f"found {', '.join(map(str, run.data))}")
    return Part(run.heading, target, titles)


def overview_part(pickled: bytes, target: Path) -> Part:
    """The pages that compare runs."""
    with ldbench_style():
        return Part("Side by side", target, save_pages(target, overview_figures(pickle.loads(pickled))))


def geometry_part(source: Path, target: Path) -> Part:
    """Draw the page of a geometry file."""
    with ldbench_style():
        figure = geometry_page(source)
        title = figure.texts[0].get_text()
        return Part(title, target, save_pages(target, [("geometry", figure)]))


def summary_part(rows: Sequence[dict[str, Any]], target: Path, chaotic: Mapping[str, Sequence[str]] | None = None) -> Part:
    """Draw the page with the table of all runs."""
    note = SUMMARY_NOTE if chaotic is None else CHAOTIC_NOTE + SUMMARY_NOTE
    with ldbench_style():
        return Part("Summary", target, save_pages(target, [("summary", summary_page(rows, note, chaotic))]))


def make_plots(files: Sequence[Path], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, map: Any = None) -> int:
    """Write the PDF of plots of column files; the number of its pages.  `done` is called after each file. map: how another
    code names the columns."""
    check_written([target], [*files, *geometry])
    check_ending(target, "a document .pdf, which holds all pages (`view -o FILE.png` makes a picture of one moment)", ".pdf")
    runs = read_all(files, jobs) if map is None else [read_data(file, map) for file in files]
    with drawing(runs, target, geometry, jobs, done) as finish:
        return finish()


def plot_runs(runs: Sequence[RunData], target: Path) -> int:
    """Write the PDF of plots of runs in memory or from files; returns the number of pages."""
    check_written([target], [])
    check_ending(target, "a document .pdf", ".pdf")
    with tempfile.TemporaryDirectory() as scratch, ldbench_style():
        parts = [run_part(run, Path(scratch)/f"{k}.pdf") for k, run in enumerate(runs)]
        return bind(parts, target, f"ldbench: {', '.join(run.name for run in runs)}")


@contextmanager
def drawing(runs: Sequence[RunData], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
            done: Callable[[], None] = lambda: None, further: Sequence[Callable[[Path], Part]] = (),
            fine: Mapping[str, Stretches] | None = None,
            chaotic: Mapping[str, Sequence[str]] | None = None) -> Iterator[Callable[[], int]]:
    """`make_plots` beside what else is to do: other processes draw from the start, and the function that this gives waits
    for them and writes the document.  `further` make last parts in a file, there too; they build no contact tables:
    OpenMP's threads do not outlive a fork.  `fine`: stretches of runs with more rows, by the names of the runs; `chaotic`:
    their results that the summary marks."""
    compared = [run for run in runs if run.exercise in range(1, 5)]
    tasks_in_all = len(runs) + len(geometry) + len(further) + (len(compared) > 1)
    with tempfile.TemporaryDirectory() as scratch, processes(jobs, tasks_in_all) as pool:
        # Pickled here: the pool would do it in a thread, while the caller goes on with the runs.
        drawn = [partial(case_part, pickle.dumps((run, (fine or {}).get(run.name)), pickle.HIGHEST_PROTOCOL)) for run in runs]
        beside = [partial(overview_part, pickle.dumps(compared, pickle.HIGHEST_PROTOCOL))] if len(compared) > 1 else []
        work = [partial(geometry_part, file) for file in geometry] + beside + drawn + list(further)
        # The longest first; the order of the document is another.
        sizes = [0]*(len(geometry) + len(beside)) + [len(run.time) for run in runs] + [ENVELOPE_ROWS]*len(further)
        order = sorted(range(len(work)), key=lambda k: -sizes[k])
        tasks = {k: pool.submit(work[k], Path(scratch)/f"{k}.pdf") for k in order}
        for k in [*range(len(geometry)), *range(len(geometry) + len(beside), len(work) - len(further))]:
            tasks[k].add_done_callback(lambda _: done())
        summary = summary_part([full_row(run) for run in runs], Path(scratch)/"summary.pdf", chaotic)
        yield lambda: bind([part for part in (summary, *(tasks[k].result() for k in range(len(work)))) if part.pages], target)


def bind(parts: Sequence[Part], target: Path, title: str = "ldbench: plots of all results") -> int:
    """Put parts together with bookmarks and page numbers; returns the number of pages. Several parts of many pages get a
    contents page."""
    writer = PdfWriter()
    listed = len(parts) > 1 and sum(len(part.pages) for part in parts) >= LISTED
    lines = entries([(part.title, part.pages) for part in parts], 2)
    with tempfile.TemporaryDirectory() as scratch, ldbench_style():
        if listed:
            page, links = contents_page(title.removeprefix("ldbench: ").capitalize(), lines)
            save_pages(Path(scratch)/"contents.pdf", [("contents", page)])
            writer.append(PdfReader(Path(scratch)/"contents.pdf"), import_outline=False)
            writer.add_outline_item(title="Contents", page_number=0)
        for part in parts:
            start = len(writer.pages)
            writer.append(PdfReader(part.file), import_outline=False)
            chapter = writer.add_outline_item(title=part.title, page_number=start)
            if len(part.pages) > 1:
                for k, name in enumerate(part.pages):
                    writer.add_outline_item(title=name, page_number=start + k, parent=chapter)
        if listed:
            link(writer, 0, links)
    number(writer)
    writer.add_metadata({"/Title": title})
    writer.compress_identical_objects()
    with complete(target) as file:
        writer.write(file)
    return len(writer.pages)
