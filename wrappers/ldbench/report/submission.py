"""The submission: ten column files, the PDF of plots, the abstract, summary.csv and a page of all results.

Which results are sensitive? Each case runs once more, as a twin with the start moved by 1 µm. A result that the twin changes by
more than a thousandth depends on more than any measurement tells: many impacts have multiplied the difference, and it is one sample
of a chaotic motion. Tables have it in italics, with the digits that hold.
"""
from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from tqdm import tqdm

from .._core.calls import Progress
from .._core.files import make_results_folder, write_frame
from .._core.kept import hashes, is_up_to_date, kept_in, kept_json, stamped, write_stamp
from .._core.optional import needed
from .._core.pools import in_threads
from ..geometry.pressures import full_row
from ..plots.document import drawing
from ..plots.energies import is_ramp
from ..plots.figures import by_pair
from ..plots.impact import Recomputed
from ..results.answers import answers
from ..results.quantities import si_unit
from ..results.run_data import RunData, read_all
from ..results.summary import Chaotic, summary_row
from ..runs import compute
from ..table import ContactTable
from ..trust.page import TITLE, report_pages
from ..viewer import results
from . import abstract, formulations
from .jobs import Job, case_job, find_cases, run_stale
from .trusted import kept_file, kept_trusts

ASIDE = 1e-6            # of the start of a twin [m]
SAME = 1e-3             # share of a result by which a twin may move it
# Results that say how exact a run is, not what happens in it.
EXACTNESS = "drift", "drift_relative", "drift_reference", "step", "steps"

# Parts of a long run are computed again, with rows as close as impacts need.
INTERVAL = 2e-5         # between rows [s]
LENGTH = 0.03           # of a part [s]
BEFORE = 0.3            # share of a part before the moment for which it is computed
STATE = ("Y", "Z", "roll", "vY", "vZ", "roll_rate")


def make_report(inputs: Path, outputs: Path, jobs: int, force: bool = False) -> list[Path]:
    """Make what is not up to date; the files of the submission."""
    needed("typst", "report")        # before the work, not after it
    cases = [case_job(case, outputs) for case in find_cases(inputs)]
    signed = abstract.read_authors(Path(abstract.AUTHORS))
    make_results_folder(outputs)
    with tqdm(total=2*len(cases) + 4, desc="report", disable=None) as bar:
        def tell(job: Job, ran: bool) -> None:
            bar.update()
            bar.write(f"{job.name}: {'done' if ran else 'up to date'}")

        run_stale(cases, jobs, force, tell)
        files = [job.product for job in cases]
        submitted = cache(partial(read_all, files, jobs))
        found = formulations.kept_outcomes(inputs, outputs, jobs, force, submitted)
        kept = [formulations.kept_file(outputs), kept_in(outputs)/"twins.json"]
        trusted = kept_trusts(inputs, outputs, jobs, force)
        other = kept_twins(cases, kept[1], jobs, force)
        plotted, written, summary, shown = products = [
            outputs/name for name in ("ldbench_plots.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html")]
        variants = results.find_variants(files)
        sources = {
            plotted: [*files, *kept, kept_file(outputs)], summary: [*files, kept[1]],
            written: [*files, *kept, Path(abstract.AUTHORS)], shown: [*files, *variants, kept[1]]}
        known = {file: stamped(file, Path()) if file in files else hashes([file], Path())
                 for file in {file for some in sources.values() for file in some}}
        depends = {product: {name: x for file in some for name, x in known[file].items()} for product, some in sources.items()}
        due = [product for product in products if force or not is_up_to_date(product, depends[product])]
        runs = submitted() if due else []
        chaotic = {run.name: chaotic_results(summary_row(run), other[run.name]) for run in runs}
        # Before other processes are forked: a run starts threads of OpenMP.
        fine = {run.name: around for run in runs if plotted in due and is_ramp(run)
                and (around := first_and_hardest(run))}

        work: dict[Path, Callable[[], object]] = {
            summary: lambda: write_summary(runs, summary, chaotic),
            shown: lambda: results.results_page(runs, variants, chaotic).write(shown),
            written: lambda: abstract.make_abstract(runs, written, found, chaotic, signed),
            plotted: lambda: None}
        with ExitStack() as stack:
            if plotted in due:      # pages are drawn in other processes while the rest is made here
                further = [(formulations.TITLE, formulations.figures(found, inputs)),
                           *([(TITLE, report_pages(trusted))] if trusted else [])]
                shapes = ((run, ContactTable.quiet(run.case).geometry()) for run, *_ in by_pair(runs).values())
                work[plotted] = stack.enter_context(drawing(runs, plotted, shapes, jobs, bar.update, further, fine, chaotic))
            for product, make in work.items():
                if product in due:
                    make()
                    write_stamp(product, depends[product])
                bar.update(len(files) + 1 if product == plotted and product not in due else 1)
                bar.write(product.name)
    return files + products


def write_summary(runs: Sequence[RunData], target: Path, chaotic: Chaotic) -> None:
    """One row per run; units in brackets behind the names, and the names of results that are chaotic at the end."""
    table = pd.DataFrame([full_row(run) | {"chaotic": " ".join(chaotic.get(run.name, ()))} for run in runs])
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
    first, peak = answers(whole)["t_first_LF"], whole.peak("LF")
    return (around(whole, first), around(whole, peak[1])) if first is not None and peak else None


def chaotic_results(row: Mapping[str, Any], twin: Mapping[str, Any]) -> dict[str, float]:
    """The results of a run that its twin does not share, and how far its twin is from them; infinite where one comes or goes."""
    found = {}
    for key in twin.keys() - set(EXACTNESS):
        one, other = row.get(key), twin.get(key)
        if isinstance(one, str) or isinstance(other, str) or one == other or (one is not None and np.isnan(one)):
            continue
        spread = np.inf if one is None or other is None or np.isnan(other) else abs(one - other)
        apart = 2*ASIDE if key.startswith("Y_") else 0.0        # by the start itself
        if spread > SAME*abs(one or 0.0) + apart:
            found[key] = float(spread)
    return {key: found[key] for key in twin if key in found}


def kept_twins(jobs: Sequence[Job], kept: Path, workers: int, force: bool = False) -> dict[str, dict[str, Any]]:
    """The results of the twins by the names of the cases, run anew where something they depend on has changed since they were
    kept in a file."""
    def work(job: Job, tell: Progress) -> dict[str, Any]:
        return summary_row(compute(job.case.replace(initial_Y=job.case.initial_Y + ASIDE), tell))

    def make() -> dict[str, dict[str, Any]]:
        found = in_threads(work, sorted(jobs, key=lambda job: -job.cost), workers)
        return {job.name: row for job, row in found}

    depends = {name: x for job in jobs for name, x in stamped(job.product, Path()).items()}
    rows: dict[str, dict[str, Any]] = kept_json(kept, depends, force, make)
    return rows
