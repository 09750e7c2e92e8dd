"""Make the submission: ten column files, the PDF of plots, the abstract, summary.csv and a page of all results.

What is up to date is left alone: a case is run again when its namelist, its profiles
or the program have changed.

examples:
  python -m ldbench report
  python -m ldbench report --outputs /tmp/trial --jobs 4
"""
from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cache, partial
from pathlib import Path

import pandas as pd
from tqdm import tqdm

from . import abstract, columns, formulations, outlines, plots, record, style
from ._core import needed, side_by_side, usable_cores
from .batch import (
    Job,
    case_job,
    find_executable,
    find_namelists,
    find_stale,
    hashes,
    inside,
    is_up_to_date,
    run_stale,
    shipped_inputs,
    stamped,
    with_values,
    write_stamp,
)
from .record import Record, read_records, summary_row, write_frame
from .view import page, results

UNITS = {"t": "s", "dt": "s", "F": "N", "N": "N", "Y": "m", "Z": "m", "roll": "rad", "E": "J"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--outputs", type=Path, metavar="DIR", help="where everything goes (outputs, in this folder)")
    parser.add_argument("--inputs", type=Path, metavar="DIR",
                        help="namelists exN_PAIR.nml (inputs in this folder, or those shipped)")
    parser.add_argument("--jobs", type=side_by_side, default=usable_cores(), help="runs side by side (%(default)s)")
    parser.add_argument("--force", action="store_true", help="make everything again")


def main(args: argparse.Namespace) -> int:
    root = Path.cwd()
    made = make_report(root, args.inputs or shipped_inputs(root), args.outputs or root/"outputs", args.jobs, args.force)
    for file in made:
        print(f"{inside(file, Path.cwd())}  {file.stat().st_size/1e6:.2f} MB")
    return 0


def make_report(root: Path, inputs: Path, outputs: Path, jobs: int, force: bool = False) -> list[Path]:
    """Make what is not up to date; the files of the submission."""
    needed("typst", "report")        # before the work, not after it
    executable = find_executable(root)
    namelists = find_namelists(inputs)
    outputs.mkdir(parents=True, exist_ok=True)
    cases = [case_job(file, outputs, root) for file in namelists]
    with tqdm(desc="report", disable=None) as bar:
        shapes = geometry_jobs(cases, outputs)
        bar.total = len(shapes) + 2*len(cases) + len(shapes) + 2

        def tell(job: Job, ran: bool) -> None:
            bar.update()
            bar.write(f"{job.name}: {'done' if ran else 'up to date'}")

        # The geometry jobs build the contact tables, one each, before the cases share them.
        stale = find_stale(cases, executable, force)
        lacking = {job.table for job in stale if job.table and not job.table.is_file()}
        rebuild = [job for job in shapes if job.table in lacking]
        run_stale(rebuild, executable, jobs, True, tell)
        run_stale([job for job in shapes if job not in rebuild], executable, jobs, force, tell)
        run_stale(cases, executable, jobs, force, tell, stale)
        files = [job.product for job in cases]
        submitted = cache(partial(read_records, files, jobs))
        found = formulations.kept_outcomes(root, inputs, outputs, jobs, force, submitted)
        geometry = [job.product for job in shapes]
        plotted, written, summary, shown = products = [
            outputs/name for name in ("ldbench_plots.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html")]
        kept = outputs/"formulations.json"
        code = [Path(str(module.__file__)) for module in (columns, formulations, outlines, record, style)]
        code += sorted(Path(plots.__file__).parent.glob("*.py"))
        variants = results.find_variants(files)
        sources = {
            plotted: [*files, *geometry, kept, *code],
            summary: [*files, *code, Path(__file__)],
            written: [*files, kept, *code, Path(abstract.__file__), *sorted(abstract.TEMPLATE.parent.glob("*"))],
            shown: [*files, *variants, *code, *sorted(file for file in page.FOLDER.iterdir() if file.is_file())]}
        known = {file: stamped(file, root) if file in files else hashes([file], root)
                 for file in {file for some in sources.values() for file in some}}
        depends = {product: {name: x for file in some for name, x in known[file].items()}
                   for product, some in sources.items()}
        due = [product for product in products if force or not is_up_to_date(product, depends[product])]
        records = submitted() if due else []

        def make(product: Path, parts: int, work: Callable[[], object] | None) -> None:
            if work and product in due:
                work()
                write_stamp(product, depends[product])
            else:
                bar.update(parts)
            bar.write(product.name)

        with ExitStack() as stack:
            # Pages are drawn in other processes while the rest is made here.
            finish = stack.enter_context(plots.drawing(
                records, plotted, geometry, jobs, bar.update, [partial(formulations.make_part, found, inputs)]
            )) if plotted in due else None
            make(summary, 0, lambda: write_summary(records, summary))
            make(shown, 1, lambda: results.results_page(records, variants).write(shown))
            make(written, 1, lambda: abstract.make_abstract(records, written, found))
            make(plotted, len(files) + len(geometry), finish)
    return files + products


def geometry_jobs(cases: Sequence[Job], outputs: Path) -> list[Job]:
    """For each pair of profiles one run of a single interval: it writes the geometry functions."""
    found: dict[tuple[str, ...], Job] = {}
    for job in cases:
        pair = tuple(str(job.value("profiles", which)) for which in ("wheel_profile", "rail_profile", "wheel_profile_right",
                                                                     "rail_profile_right"))
        name = f"geometry_{job.name.partition('_')[2] or len(found)}"
        if pair in found:
            continue
        product, columns = outputs/f"{name}.txt", outputs/f"{name}_columns.txt"
        values = {"integrator": {"t_end": job.value("output", "interval", 1e-4), "stop_at": "t_end"},
                  "output": {"file": inside(columns, job.root), "geometry_file": inside(product, job.root)}}
        found[pair] = Job(name, with_values(job.text, values), product, job.root, litter=columns)
    return list(found.values())


def write_summary(records: Sequence[Record], target: Path) -> None:
    """One row per run; units in brackets behind the names."""
    table = pd.DataFrame([summary_row(run) for run in records])
    table.columns = [with_unit(name) for name in table.columns]
    write_frame(table, target)


def with_unit(name: str) -> str:
    unit = UNITS.get(name.split("_")[0])
    return f"{name} [{unit}]" if unit and name != "E_drift_relative" else name
