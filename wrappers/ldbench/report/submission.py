"""The submission: ten column files, the PDF of plots, the abstract, summary.csv and a page of all results."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path

import pandas as pd
from tqdm import tqdm

from .._core.files import make_results_folder, write_frame
from .._core.kept import hashes, inside, is_up_to_date, kept_in, stamped, write_stamp
from .._core.optional import needed
from ..geometry.pressures import full_row
from ..plots.document import drawing
from ..plots.ramp import is_ramp
from ..results.quantities import si_unit
from ..results.run_data import RunData, read_all
from ..results.summary import Chaotic
from ..viewer import results
from . import abstract, authors, formulations, stretches, twins
from .jobs import Job, case_job, find_namelists, find_stale, run_stale, with_values


def make_report(root: Path, inputs: Path, outputs: Path, jobs: int, force: bool = False) -> list[Path]:
    """Make what is not up to date; the files of the submission."""
    needed("typst", "report")        # before the work, not after it
    namelists = find_namelists(inputs)
    signed = authors.read_authors(root/authors.FILE)
    make_results_folder(outputs)
    kept_in(outputs).mkdir(exist_ok=True)
    cases = [case_job(file, outputs, root) for file in namelists]
    with tqdm(desc="report", disable=None) as bar:
        shapes = geometry_jobs(cases, kept_in(outputs))
        bar.total = len(shapes) + 2*len(cases) + len(shapes) + 2

        def tell(job: Job, ran: bool) -> None:
            bar.update()
            bar.write(f"{job.name}: {'done' if ran else 'up to date'}")

        # The geometry jobs build the contact tables, one each, before the cases share them.
        stale = find_stale(cases, force)
        lacking = {job.table for job in stale if job.table and not job.table.is_file()}
        rebuild = [job for job in shapes if job.table in lacking]
        run_stale(rebuild, jobs, True, tell)
        run_stale([job for job in shapes if job not in rebuild], jobs, force, tell)
        run_stale(cases, jobs, force, tell, stale)
        files = [job.product for job in cases]
        submitted = cache(partial(read_all, files, jobs))
        found = formulations.kept_outcomes(root, inputs, outputs, jobs, force, submitted)
        other = twins.kept_twins(cases, outputs, jobs, force)
        geometry = [job.product for job in shapes]
        plotted, written, summary, shown = products = [
            outputs/name for name in ("ldbench_plots.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html")]
        kept = [formulations.kept_file(outputs), twins.kept_file(outputs)]
        variants = results.find_variants(files)
        sources = {
            plotted: [*files, *geometry, *kept], summary: [*files, kept[1]], written: [*files, *kept, root/authors.FILE],
            shown: [*files, *variants, kept[1]]}
        known = {file: stamped(file, root) if file in files else hashes([file], root)
                 for file in {file for some in sources.values() for file in some}}
        depends = {product: {name: x for file in some for name, x in known[file].items()} for product, some in sources.items()}
        due = [product for product in products if force or not is_up_to_date(product, depends[product])]
        runs = submitted() if due else []
        chaotic = twins.chaotic_results(runs, other)
        # Before other processes are forked: a run starts threads of OpenMP.
        fine = {run.name: around for run, job in zip(runs, cases, strict=False) if plotted in due and is_ramp(run)
                and (around := stretches.first_and_hardest(job, run))}

        def make(product: Path, parts: int, work: Callable[[], object] | None) -> None:
            if work and product in due:
                work()
                write_stamp(product, depends[product])
            else:
                bar.update(parts)
            bar.write(product.name)

        with ExitStack() as stack:
            # Pages are drawn in other processes while the rest is made here.
            finish = stack.enter_context(drawing(
                runs, plotted, geometry, jobs, bar.update, [formulations.chapter(found, inputs)], fine, chaotic
            )) if plotted in due else None
            make(summary, 0, lambda: write_summary(runs, summary, chaotic))
            make(shown, 1, lambda: results.results_page(runs, variants, chaotic).write(shown))
            make(written, 1, lambda: abstract.make_abstract(runs, written, found, chaotic, signed))
            make(plotted, len(files) + len(geometry), finish)
    return files + products


def geometry_jobs(cases: Sequence[Job], folder: Path) -> list[Job]:
    """One job per pair of profiles, a run of a single interval that writes the geometry functions."""
    found: dict[tuple[str, ...], Job] = {}
    for job in cases:
        pair = tuple(str(job.value("profiles", which)) for which in ("wheel_profile", "rail_profile", "wheel_profile_right",
                                                                     "rail_profile_right"))
        name = f"geometry_{job.name.partition('_')[2] or len(found)}"
        if pair in found:
            continue
        product, columns = folder/f"{name}.txt", folder/f"{name}_columns.txt"
        values = {"integrator": {"t_end": job.value("output", "interval", 1e-4), "stop_at": "t_end"},
                  "output": {"file": inside(columns, job.root), "geometry_file": inside(product, job.root)}}
        found[pair] = Job(name, with_values(job.text, values), product, job.root, litter=columns)
    return list(found.values())


def write_summary(runs: Sequence[RunData], target: Path, chaotic: Chaotic) -> None:
    """One row per run; units in brackets behind the names, and the names of results that are chaotic at the end."""
    table = pd.DataFrame([full_row(run) | {"chaotic": " ".join(chaotic.get(run.name, ()))} for run in runs])
    units = {name: si_unit(name) for name in table.columns}
    table.columns = [f"{name} [{unit}]" if unit not in ("", "1") else name for name, unit in units.items()]
    write_frame(table, target)
