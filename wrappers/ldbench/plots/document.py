"""The document: pages of every run, drawn side by side and bound under bookmarks."""
from __future__ import annotations

import base64
import io
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from PIL import Image
from pypdf import PdfReader, PdfWriter
from pypdf.annotations import Link
from pypdf.generic import Fit

from .._core.errors import Error
from .._core.files import check_ending, check_written, complete, failing_as
from .._core.pools import call_known, processes
from ..geometry.pressures import full_row
from ..results.run_data import RunData, read_all, read_data
from ..results.summary import CHAOTIC_NOTE, Chaotic
from .contents import contents_page, entries, number
from .figures import free
from .geometry import Shape, geometry_page
from .impact import HARDEST, Recomputed, hardest_page, impact_page
from .overview import overview_figures
from .phase import energy_page
from .ramp import is_ramp, ramp_page
from .series import IMPULSES, LAST, PAGES
from .stretches import is_long, last_second
from .style import ldbench_style
from .tables import summary_page
from .times import time_page


@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles
    first: int = 0                # their place in the file


LISTED = 8      # pages from which on a document has a contents page
DPI = 110       # of a picture


class Figures(tuple[Figure, ...]):
    """Figures of matplotlib, which a notebook shows one below the other."""

    def _repr_html_(self) -> str:
        return "".join(f'<img alt="" src="data:image/png;base64,{base64.b64encode(png(figure)).decode()}">' for figure in self)


def png(figure: Figure) -> bytes:
    """A figure as a PNG file."""
    file = io.BytesIO()
    with ldbench_style():
        figure.savefig(file, format="png", dpi=DPI, metadata={"Software": None})
    return file.getvalue()


Fine = tuple[Recomputed, Recomputed]        # around the first and the hardest contact of the left flange


def case_figures(run: RunData, fine: Fine | None = None) -> Iterator[tuple[str, Figure]]:
    """The pages of a run: of what it has columns for."""
    if "time" not in run.data:
        return
    for page in (*PAGES, IMPULSES) if "E_lost" in run.data else PAGES:
        if found := page.of(run):
            yield page.title, time_page(run, found)
    if is_ramp(run):
        yield "energy and lateral force", ramp_page(run)
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
    with failing_as(path, path), PdfPages(path, metadata={"CreationDate": None}) as pdf:
        for title, figure in figures:
            if figure.axes and (layout := figure.get_layout_engine()):
                layout.execute(figure)
            figure.set_layout_engine("none")        # it is done
            FigureCanvasPdf(figure).print_pdf(pdf)  # PdfPages.savefig would draw the page twice
            titles.append(title)
    return tuple(titles)


def save_sheets(figures: Sequence[Figure], target: Path) -> None:
    """Write pages, a .pdf, or a .png with one below the other."""
    with complete(target) as scratch:
        if target.suffix.lower() == ".pdf":
            save_pages(scratch, (("", figure) for figure in figures))
            return
        images = [Image.open(io.BytesIO(png(figure))).convert("RGB") for figure in figures]
        whole = Image.new("RGB", (images[0].width, sum(image.height for image in images)))
        for k, image in enumerate(images):
            whole.paste(image, (0, k*image.height))
        whole.save(scratch, format="PNG")


Chapter = tuple[str, Iterable[tuple[str, Figure]]]        # title, and pages with their titles


def save_parts(target: Path, chapters: Iterable[Chapter]) -> list[Part]:
    """Write chapters into one file, in which they share the fonts: to cut a font takes as long as a page."""
    parts: list[Part] = []

    def figures() -> Iterator[tuple[str, Figure]]:
        for title, pages in chapters:
            names = []
            for name, figure in pages:
                names.append(name)
                yield name, figure
            parts.append(Part(title, target, tuple(names), sum(len(part.pages) for part in parts)))

    save_pages(target, figures())
    return parts


def draw_chapter(chapter: Chapter, target: Path) -> list[Part]:
    """One chapter in a file, for a process that only draws."""
    with ldbench_style():
        return save_parts(target, [chapter])


def check_drawn(parts: Sequence[Part], runs: Sequence[RunData]) -> None:
    """Error where a run has no columns to draw."""
    for part, run in zip(parts, runs, strict=True):
        if not part.pages:
            raise Error(f"{run.file}: expected time and other columns of ours to draw (a map of names, --map, may tell which), "
                        f"found {', '.join(map(str, run.data))}")


def front_parts(rows: Sequence[dict[str, Any]], geometry: Iterable[Shape], runs: Sequence[RunData],
                chaotic: Chaotic | None, target: Path) -> list[Part]:
    """The table of all runs, the pages of geometry functions, and the pages that compare runs."""
    note = "" if chaotic is None else f"{CHAOTIC_NOTE}.  "
    with ldbench_style():
        shapes = [geometry_page(*shape) for shape in geometry]
        chapters: list[Chapter] = [("Summary", [("summary", summary_page(rows, note, chaotic))])]
        chapters += [(figure.texts[0].get_text(), [("geometry", figure)]) for figure in shapes]
        if beside := overview_figures(runs):
            chapters.append(("Side by side", beside))
        return save_parts(target, chapters)


def make_plots(files: Sequence[Path], target: Path, geometry: Sequence[Path] = (), jobs: int | None = None,
               done: Callable[[], None] = lambda: None, map: Any = None) -> int:
    """Write the PDF of plots of column files; the number of its pages.  `done` is called after each file. map: how another
    code names the columns."""
    check_written([target], [*files, *geometry])
    check_ending(target, "a document .pdf, which holds all pages (`view -o FILE.png` makes a picture of one moment)", ".pdf")
    runs = read_all(files, jobs) if map is None else [read_data(file, map) for file in files]
    shapes = [(run := read_data(file), run.data) for file in geometry]
    with drawing(runs, target, shapes, jobs, done) as finish:
        return finish()


def drawn(run: RunData) -> Figures:
    """The pages of a run as figures; Error where it has no columns to draw."""
    with ldbench_style():
        pages = list(case_figures(run))
    check_drawn([Part(run.name, run.file, tuple(title for title, _ in pages))], [run])
    return Figures(figure for _, figure in pages)


def plot_runs(runs: Sequence[RunData], target: Path) -> int:
    """Write the PDF of plots of runs in memory or from files; returns the number of pages."""
    check_written([target], [])
    check_ending(target, "a document .pdf", ".pdf")
    chapters = [(run.heading, case_figures(run)) for run in runs]
    return save_document(chapters, target, f"ldbench: {', '.join(run.name for run in runs)}", runs)


def save_document(chapters: Iterable[Chapter], target: Path, title: str, runs: Sequence[RunData] = ()) -> int:
    """Draw chapters here, one after the other, into a document; the number of its pages. Error where one of `runs`, which have a
    chapter each, has nothing to draw."""
    with tempfile.TemporaryDirectory() as scratch, ldbench_style():
        parts = save_parts(Path(scratch)/"pages.pdf", chapters)
        if runs:
            check_drawn(parts, runs)
        return bind(parts, target, title)


@contextmanager
def drawing(runs: Sequence[RunData], target: Path, geometry: Iterable[Shape] = (), jobs: int | None = None,
            done: Callable[[], None] = lambda: None, further: Sequence[Chapter] = (),
            fine: Mapping[str, Fine] | None = None,
            chaotic: Chaotic | None = None) -> Iterator[Callable[[], int]]:
    """Start drawing in worker processes, and give the function that waits for them and writes the document.

    `further`: last chapters, which are drawn there too; to draw them builds no contact
    tables: OpenMP's threads do not outlive a fork.  `fine`: parts of runs with more rows, by the names of the runs;
    `chaotic`: their results that the summary has in italics."""
    chapters = [*((run.heading, case_figures(run, (fine or {}).get(run.name))) for run in runs), *further]
    # The processes have the runs as they are forked; nothing is sent to them.
    work = [partial(draw_chapter, chapter) for chapter in chapters]
    with tempfile.TemporaryDirectory() as scratch, processes(jobs, len(work), work) as pool:
        tasks: list[Future[list[Part]]] = [pool.submit(call_known, n, Path(scratch)/f"{n}.pdf") for n in range(len(work))]
        for task in tasks[:len(runs)]:
            task.add_done_callback(lambda _: done())
        compared = free(runs)
        front = front_parts([full_row(run) for run in runs], geometry, compared if len(compared) > 1 else [], chaotic,
                            Path(scratch)/"front.pdf")

        def finish() -> int:
            parts = [part for task in tasks for part in task.result()]
            check_drawn(parts[:len(runs)], runs)
            return bind([*front, *parts], target)

        yield finish


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
        files = {part.file: PdfReader(part.file) for part in parts}
        for part in parts:
            start = len(writer.pages)
            writer.append(files[part.file], pages=(part.first, part.first + len(part.pages)), import_outline=False)
            chapter = writer.add_outline_item(title=part.title, page_number=start)
            if len(part.pages) > 1:
                for k, name in enumerate(part.pages):
                    writer.add_outline_item(title=name, page_number=start + k, parent=chapter)
        if listed:
            for rectangle, number_of_page in links:
                writer.add_annotation(0, Link(rect=rectangle, target_page_index=number_of_page - 1, fit=Fit("/Fit")))
    number(writer)
    writer.add_metadata({"/Title": title})
    writer.compress_identical_objects()
    with complete(target) as file:
        writer.write(file)
    return len(writer.pages)
