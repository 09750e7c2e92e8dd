"""Contact law or time step: how much of the spread between codes is which?"""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from tqdm import tqdm

from .._core.files import make_results_folder, write_frame
from .._core.kept import inside
from ..case import Case
from ..constants import KN, MM
from ..number_text import number_text
from ..plots.document import save_document
from ..plots.frame import legend_of_page, new_page
from ..plots.named import named_bars
from ..plots.sheets import Chapter
from ..plots.style import SERIES, powers_of_ten
from ..plots.tables import draw_table
from ..results.answers import answers
from ..results.columns import time_mean
from ..results.quantities import quantity
from ..results.run_data import read_data
from .compare import quantity_page
from .differences import Comparison, compare, event_times
from .jobs import Job, find_cases, run_stale

VARIANTS: dict[str, dict[str, float | str]] = {
    "fine": {},
    "law": {"model": "hertz"},
    "step": {"order": 2, "beta": 0.25, "dt": 1e-4, "energy_tolerance": 0.0, "error_tolerance": 0.0},
}
VARIANT_WORDS = {"fine": "half-spaces, cut steps", "law": "one Hertz spring per zone", "step": "average acceleration, step 0.1 ms"}
SHORT_RAMP = 3.0           # of exercise 5, in the study [s]


def study_jobs(case: Case, folder: Path, ramp_end: float = SHORT_RAMP) -> dict[str, Job]:
    """The runs of one exercise, by variant.  Exercise 5 is cut short; all are written every 0.1 ms."""
    base = case.replace(interval=1e-4, dt=min(1e-4, case.dt))
    if case.stop_at == "derailment":
        base = base.replace(t_end=ramp_end, stop_at="t_end")
    found = {}
    for name, changes in VARIANTS.items():
        product = folder/f"{case.case_name}_{name}.txt"
        variant = base.replace(changes, output_file=inside(product, Path()))
        found[name] = Job(variant, product)
    return found


def study_row(found: Comparison, case: str, variant: str) -> dict[str, Any]:
    """What a variant changes in one exercise: up to the end of the first flange contact, and overall."""
    first = found.runs[0].first_interval("LF")
    early = found.time <= (first.end if first else found.time[-1])
    row: dict[str, Any] = {"case": case, "variant": variant}
    for column in ("Y", "Z", "roll", "N_LF", "N_LT"):
        d, x = found.difference(1, column), found.values[0][column]
        unit = found.unit(column)
        row[f"{column} rms, first contact [{unit}]"] = np.sqrt(time_mean(found.time[early], d[early]**2))
        row[f"{column} rms [{unit}]"] = np.sqrt(time_mean(found.time, d**2))
        row[f"{column} rms of the reference [{unit}]"] = np.sqrt(time_mean(found.time, x**2))
    before, after = map(event_times, found.runs)
    for name in ("first left flange contact", "first right flange contact", "end"):
        row[f"{name} [s]"] = after.get(name, np.nan) - before.get(name, np.nan)
    known = [answers(run) for run in found.runs]
    for name, key in ("N_LF peak of the first contact", "first_peak_N_LF"), ("N_LF largest", "peak_N_LF"):
        a, b = (one[key] or np.nan for one in known)
        row[f"{name}, relative"] = (b - a)/a
    return row | {"ending": found.runs[1].ending}


# Words above a pair of columns, the column of the rows, the factor from SI, and the unit.
TABLE = (("Y, first contact", "Y rms, first contact [m]", 1e6, "µm"),
         ("Y, whole run", "Y rms [m]", MM, "mm"),
         ("left flange, first contact", "N_LF rms, first contact [N]", KN, "kN"),
         ("left flange, whole run", "N_LF rms [N]", KN, "kN"),
         ("peak of the first contact", "N_LF peak of the first contact, relative", 100.0, "%"),
         ("end of the run", "end [s]", 1e3, "ms"))


def study_summary(rows: pd.DataFrame) -> Figure:
    """Contact law against time step: differences of every exercise in numbers, and as bars over the reference."""
    figure = new_page(
        "Contact law or time step?", "all exercises; reference: half-spaces with cut steps",
        "table: root mean squares of the differences in lateral displacement Y and in the normal force of the left flange; "
        "differences of the first peak and of the end of the run\nbars: root mean square of the difference over that of the "
        "reference; no bar: no difference, or no contact in the reference\n"
        "law: one Hertz spring per zone instead of half-spaces, same steps; step: average acceleration with whole steps of "
        "0.1 ms instead of the shipped integrator, same law; exercise 5 cut short\nfirst contact: from the start to "
        "the end of the first contact of the left flange; over the whole run every impact multiplies what the ones "
        "before it left")
    body = figure.add_gridspec(2, 1, height_ratios=(1, 1.7))
    table = [["", *(word for words, *_ in TABLE for word in ("", words))],
             ["", *(f"{variant} [{unit}]" for *_, unit in TABLE for variant in ("law", "step"))]]
    for case, both in rows.groupby("case", sort=False):
        law, step = (both[both["variant"] == v].iloc[0] for v in ("law", "step"))
        table.append([str(case), *(number_text(scale*row[name]) for _, name, scale, _ in TABLE for row in (law, step))])
    draw_table(figure.add_subplot(body[0]), table, [0, *np.linspace(0.08, 1, 2*len(TABLE) + 1)],
               look=lambda i, j: {"weight": "bold" if i < 2 else "normal"})
    axes = body[1].subgridspec(2, 2).subplots(sharex=True)
    cases = list(dict.fromkeys(rows["case"]))
    for line, (column, unit) in zip(axes, (("Y", "m"), ("N_LF", "N")), strict=True):
        for ax, (key, words) in zip(line, ((f"{column} rms, first contact [{unit}]", "to the end of the first flange contact"),
                                           (f"{column} rms [{unit}]", "whole run")), strict=True):
            for shift, variant, style in ((-0.2, "law", SERIES[2]), (0.2, "step", SERIES[1])):
                part = rows[rows["variant"] == variant].set_index("case").loc[cases]
                share = part[key]/part[f"{column} rms of the reference [{unit}]"]
                bars = ax.bar(np.arange(len(cases)) + shift, share, width=0.38, color=style.color,
                              label=f"{variant}: {VARIANT_WORDS[variant]}")
                named_bars(bars, [f"{case} {variant}" for case in cases], f"rms of {column}, {words}")
            ax.set(yscale="log", xlim=(-0.6, len(cases) - 0.4), xticks=np.arange(len(cases)), xticklabels=cases)
            powers_of_ten(ax.yaxis)
            ax.grid(axis="x", visible=False)
            ax.set_title(f"{quantity(column).words}, {words}", loc="left", pad=3)
        line[0].set_ylabel("difference over reference")
    legend_of_page(figure, axes[0, 0].get_legend_handles_labels()[0])
    return figure


def make_study(inputs: Path, outputs: Path, workers: int, ramp_end: float = SHORT_RAMP) -> list[Path]:
    """Run what is not up to date; write the PDF and the CSV file of the study."""
    cases = find_cases(inputs)
    folder = outputs/"study"
    make_results_folder(outputs)
    folder.mkdir(exist_ok=True)
    jobs = {case.case_name: study_jobs(case, folder, ramp_end) for case in cases}
    flat = [job for variants in jobs.values() for job in variants.values()]
    target = outputs/"ldbench_study.pdf"
    with tqdm(total=len(flat) + len(jobs), desc="study", disable=None, leave=False) as bar:
        run_stale(flat, workers, done=lambda job, ran: bar.update())
        runs = {case: {v: read_data(job.product) for v, job in variants.items()} for case, variants in jobs.items()}
        table = pd.DataFrame([study_row(compare([own["fine"], own[variant]]), case, variant)
                              for case, own in runs.items() for variant in ("law", "step")])

        def chapters() -> Iterator[Chapter]:
            yield "Summary", [("summary", study_summary(table))]
            for own in runs.values():
                heading = own["fine"].heading
                found = compare([run.named(VARIANT_WORDS[v]) for v, run in own.items()])
                yield heading, [(heading, quantity_page(found, ("Y", "Z", "N_LF"), f"{heading}: contact law or time step?"))]
                bar.update()

        save_document(chapters(), target, "ldbench: contact law or time step?")
    write_frame(table, target.with_suffix(".csv"))
    return [target, target.with_suffix(".csv")]
