"""The submission: ten column files, the PDF of plots, that of extras, the abstract, summary.csv and a page of all results.

Each case runs with its twins (`results/twins.py`): the median and the range of all stand in the place of a chaotic result.
"""
from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from .._core.calls import Progress, version
from .._core.errors import warn
from .._core.files import make_results_folder, write_frame
from .._core.kept import hashes, is_up_to_date, kept_in, kept_json, stamped, write_stamp
from .._core.optional import needed
from .._core.pools import in_threads
from .._core.wording import counted
from ..case import Case
from ..constants import DESCRIPTION
from ..ensembles.members import table_keys
from ..plots.document import Document, drawing, extra_chapters, general_chapters, run_chapters, summary_chapter
from ..plots.energies import is_ramp
from ..plots.figures import by_pair
from ..plots.geometry import Shape
from ..plots.impact import Recomputed
from ..plots.sheets import Chapter
from ..results.answers import answers
from ..results.quantities import si_unit
from ..results.run_data import RunData, read_data
from ..results.summary import IDENTITY, summary_row
from ..results.twins import Spread, all_spreads, spreads, twin_cases
from ..runs import compute
from ..table import ContactTable
from ..trust.page import TITLE, report_pages
from ..viewer import results
from . import abstract, formulations
from .jobs import Job, case_job, find_cases, run_stale
from .trusted import kept_file, kept_trusts

# Parts of a long run are computed again, with rows as close as impacts need.
INTERVAL = 2e-5         # between rows [s]
LENGTH = 0.03           # of a part [s]
BEFORE = 0.3            # share of a part before the moment for which it is computed
STATE = ("Y", "Z", "roll", "vY", "vZ", "roll_rate")


def make_report(inputs: Path, outputs: Path, jobs: int, force: bool = False) -> list[Path]:
    """Make what is not up to date; the files of the submission."""
    needed("typst", "report")        # before the work, not after it
    cases = [case_job(case, outputs) for case in find_cases(inputs)]
    description = outputs/DESCRIPTION
    signed = abstract.read_authors(description)
    if not signed:
        warn(f"{description}: the abstract names no authors; expected 'authors = [...]', as `submit --template` writes it")
    make_results_folder(outputs)
    with tqdm(total=3*len(cases) + 7, desc="report", disable=None) as bar:
        def tell(job: Job, ran: bool) -> None:
            bar.update()
            bar.write(f"{job.name}: {'done' if ran else 'up to date'}")

        run_stale(cases, jobs, force, tell)
        files = [job.product for job in cases]
        submitted = cache(lambda: [read_data(file) for file in files])
        found = formulations.kept_outcomes(inputs, outputs, jobs, force, submitted)
        trusted = kept_trusts(inputs, outputs, jobs, force)
        twins = kept_twins(cases, jobs, force)
        compared, sampled = formulations.kept_file(outputs), [twins_file(job) for job in cases]
        plotted, more, written, summary, shown = products = [outputs/name for name in (
            "ldbench_plots.pdf", "ldbench_extras.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html")]
        variants = results.find_variants(files)
        sources = {
            plotted: [*files, *sampled], more: [*files, compared, kept_file(outputs)], summary: [*files, *sampled],
            written: [*files, *sampled, compared, kept_file(outputs), description],
            shown: [*files, *sampled, *variants, kept_file(outputs)]}
        known = {file: stamped(file, Path()) if file in files else hashes([file], Path())
                 for file in {file for some in sources.values() for file in some}}
        depends = {product: {name: x for file in some for name, x in known[file].items()} for product, some in sources.items()}
        due = [product for product in products if force or not is_up_to_date(product, depends[product])]
        runs = submitted() if due else []
        chaotic = {run.name: spreads(summary_row(run), twins[run.name]) for run in runs}
        bodies = {one.case: peaks for one in trusted if (peaks := one.range_of("bodies", results.FIRST_PEAK))}
        # Before other processes are forked: a run starts threads of OpenMP.
        fine = {run.name: around for run in runs if more in due and is_ramp(run)
                and (around := first_and_hardest(run))}

        work: dict[Path, Callable[[], object]] = {
            summary: lambda: write_summary(runs, summary, twins),
            shown: lambda: results.results_page(runs, variants, chaotic, bodies).write(shown),
            written: lambda: abstract.make_abstract(runs, written, found, chaotic, signed, trusted),
            plotted: lambda: None, more: lambda: None}
        with ExitStack() as stack:
            # Pages are drawn in other processes while the rest is made here.
            documents = [one for one in (
                Document(plotted, SHEETS_TITLE, sheets_words(runs), front_of_sheets(runs, chaotic), run_chapters(runs)),
                Document(more, EXTRAS_TITLE, EXTRAS_WORDS, general_chapters(runs, shapes(runs)), [
                    *extra_chapters(runs, fine), (formulations.TITLE, formulations.figures(found, inputs)),
                    *([(TITLE, report_pages(trusted))] if trusted else [])])) if one.target in due]
            if documents:
                finish = stack.enter_context(drawing(documents, jobs, bar.update))
                work |= {one.target: partial(finish, one.target) for one in documents}
            for product, make in work.items():
                if product in due:
                    make()
                    write_stamp(product, depends[product])
                drawn = {plotted: len(files), more: len(files) + 1 + bool(trusted)}.get(product, 0)     # chapters
                bar.update(1 if product in due else 1 + drawn)
                bar.write(product.name)
    return files + products


SHEETS_TITLE = "ldbench: LD benchmark, plots of all results"
EXTRAS_TITLE = "ldbench: LD benchmark, more plots than the call asks for"
EXTRAS_WORDS = (
    "What the call does not ask for: contact geometry, runs side by side, impacts with cross-sections, phase portraits and "
    "spectra, exercise 5 over the lateral force and its first and hardest contact, contact formulations, and how far to trust an "
    "answer.",
    "The plots that the call asks for are in ldbench_plots.pdf.")


def sheets_words(runs: Sequence[RunData]) -> list[str]:
    """The first page of the plots in words."""
    return [
        f"ldbench {version()}: dynamics of a single wheelset on two rails, without friction. This document shows "
        f"{counted(len(runs), 'run')}: exercises with the actual (aw) and the simplified (sw) profiles of wheel and rail. The "
        "table of results comes first; each run then has four sheets with the quantities of the call in its order.",
        "A row of a sheet shows one quantity: in the wide panel the whole run, beside it the first contact of the left flange and "
        "that of the right flange, each over the time since the flange touched. Exercise 5 has its last second in the place of the "
        "right flange, which is not touched. Curves go through the rows of the column files. Where a curve swings too fast to be "
        "drawn, a light band goes from its smallest to its largest value, with the mean.",
        "Track frame: Y is positive to the left, Z upwards, a positive roll Φ lifts the left wheel. The left side is blue, the "
        "right side red; treads are dark and solid, flanges light and dashed; dotted lines mark events.",
        "ldbench_extras.pdf has more plots than the call asks for."]


def front_of_sheets(runs: Sequence[RunData], chaotic: Mapping[str, Mapping[str, Spread]]) -> Iterator[Chapter]:
    """The table of results, when it is asked for."""
    yield summary_chapter(runs, chaotic)


def shapes(runs: Sequence[RunData]) -> Iterator[Shape]:
    """The geometry functions of each pair of profiles."""
    return ((run, ContactTable(run.case).geometry()) for run, *_ in by_pair(runs).values())


def write_summary(runs: Sequence[RunData], target: Path, twins: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Five rows per run, as column `of` says: the run; median, least and largest of the answers of the run and its twins; and how
    many of these have an answer. Units stand in brackets behind the names."""
    rows = []
    for run in runs:
        row = summary_row(run)
        known = {name: row.pop(name) for name in IDENTITY}
        found = all_spreads(row, twins[run.name])
        rows += [known | {"of": of} | own for of, own in (
            ("run", row), *((of, {name: getattr(one, of) for name, one in found.items()}) for of in Spread._fields[:-1]))]
    table = pd.DataFrame(rows)
    units = {name: si_unit(name) for name in table.columns}
    table.columns = [f"{name} [{unit}]" if unit not in ("", "1") else name for name, unit in units.items()]
    write_frame(table, target)


def around(whole: RunData, t: float) -> Recomputed:
    """The run about the time t [s], from the state of one of its rows on."""
    k = max(int(np.searchsorted(whole.time, t - BEFORE*LENGTH, "right")) - 1, 0)
    case = whole.case.replace(
        {f"initial_{name}": float(whole.values(name)[k]) for name in STATE}, lateral_force=float(whole.values("F_ext")[k]),
        t_end=LENGTH, interval=INTERVAL, dt=INTERVAL, stop_at="t_end", rows="interval_and_events", roll_link="none")
    return Recomputed(compute(case), float(whole.time[k]))


def first_and_hardest(whole: RunData) -> tuple[Recomputed, Recomputed] | None:
    """The first and the hardest contact of the left flange; None in a run without one."""
    known = answers(whole)
    first, peak = known["t_first_LF"], known["t_peak_LF"]
    return None if first is None or peak is None else (around(whole, first), around(whole, peak))


def twins_file(job: Job) -> Path:
    """The file that keeps the answers of the twins of a case."""
    return kept_in(job.product.parent)/f"{job.name}_twins.json"


def kept_twins(jobs: Sequence[Job], workers: int, force: bool = False) -> dict[str, list[dict[str, Any]]]:
    """The answers of the twins by the names of the cases, in the order of `TWINS`. The twins of a case run anew where something
    they depend on has changed since their answers were kept."""
    def work(task: tuple[str, int, Case], tell: Progress) -> dict[str, Any]:
        return summary_row(compute(task[2], tell, tables[key(task[2])]))

    depends = {job.name: stamped(job.product, Path()) for job in jobs}
    stale = [job for job in jobs if force or not is_up_to_date(twins_file(job), depends[job.name])]
    tasks = [(job.name, k, twin) for job in sorted(stale, key=lambda job: -job.cost) for k, twin in enumerate(twin_cases(job.case))]
    key = table_keys()
    one_of_each = {key(job.case): job.case for job in stale}
    tables = {name: ContactTable(case) for name, case in one_of_each.items()}
    made: dict[str, dict[int, dict[str, Any]]] = {job.name: {} for job in stale}
    with tqdm(total=len(tasks), desc="twins", disable=None, leave=False) as bar:
        for (name, k, _), row in in_threads(work, tasks, workers):
            made[name][k] = row
            bar.update()

    def kept(job: Job) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = kept_json(twins_file(job), depends[job.name], job in stale,
                                               lambda: [row for _, row in sorted(made[job.name].items())])
        return rows

    return {job.name: kept(job) for job in jobs}
