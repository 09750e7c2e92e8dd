"""Compare column files: ours with other models or steps, or other codes' submissions.

The first file is the reference. Every quantity that the files share is drawn over the others' and as a
difference from the reference, on the reference's instants in the time that all files cover; tables of
differences, events and peaks go to a CSV file. Angle, position and radius of a contact are compared while
it is closed in both files.

--formulations runs all exercises with elastic contact, with both wheels held on their rails (bilateral) and with rigid
contacts that only push (unilateral, restitution 1, 0.5 and 0), and tabulates which results depend on that.

--study runs all exercises with another contact law and with a coarse step: how much of the spread
between codes is contact law, how much is time step?

examples:
  python -m ldbench compare outputs/ex2_aw.txt other_code.csv --columns other_code.toml
  python -m ldbench compare a.txt b.txt c.txt --align first-flange -o three.pdf
  python -m ldbench compare --formulations
  python -m ldbench compare --study
"""
from __future__ import annotations

import argparse
import itertools
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tqdm import tqdm

from . import formulations
from ._core import Error, check_ending, check_written, side_by_side, usable_cores
from .batch import Job, find_executable, find_namelists, inside, run_stale, shipped_inputs, with_values
from .columns import time_mean
from .plots import DEG, KN, MM, Part, bind, first_episode, label_x, label_y, new_page, save_pages, thin
from .record import Record, read_record, write_frame
from .style import SERIES, ldbench_style, plain
from .table import CONTACT_NAMES, CONTACTS

# How quantities are shown: unit and factor from SI, by the beginning of the column's name.
SHOWN = {
    **dict.fromkeys(("Y", "Z", "y", "z", "radius"), ("mm", MM)),
    **dict.fromkeys(("N", "Fy", "Fz"), ("kN", KN)),
    **dict.fromkeys(("vY", "vZ"), ("m/s", 1.0)),
    **dict.fromkeys(("aY", "aZ"), ("m/s²", 1.0)),
    **dict.fromkeys(("KE", "PE", "W", "E"), ("J", 1.0)),
    "P": ("N·s", 1.0), "roll": ("mrad", 1e3), "angle": ("°", DEG), "M": ("N·m", 1.0)}
SHOWN_WHOLE = {"roll_rate": ("mrad/s", 1e3), "roll_acc": ("rad/s²", 1.0)}
GIVEN = {"time", "X", "vX", "pitch", "pitch_rate", "F_ext", "KE_long", "KE_pitch"}   # not outcomes


# Differences ------------------------------------------------------------------------------

@dataclass(frozen=True)
class Comparison:
    """Runs on common instants: `time` of the reference, counted from its alignment, and per run its
    columns there."""
    time: np.ndarray                     # [s]
    records: tuple[Record, ...]          # the first is the reference
    shifts: tuple[float, ...]            # instants of each file that are taken as the same [s]
    columns: tuple[str, ...]             # that all files have
    values: tuple[dict[str, np.ndarray], ...]

    def difference(self, k: int, column: str) -> np.ndarray:
        """File k less the reference; nan where either contact is open."""
        return self.values[k][column] - self.values[0][column]


def alignment(record: Record, align: str) -> float:
    """The instant of a file [s] that counts as zero."""
    if align == "time":
        return 0.0
    instants = [t for c in ("LF", "RF") if (t := record.first_contact(c)) is not None]
    if not instants:
        raise Error(f"{record.file}: expected a flange contact to align by, found none")
    return min(instants)


def compare(records: Sequence[Record], align: str = "time") -> Comparison:
    """Bring runs onto common instants.  align: 'time', or 'first-flange' for the first flange contact of each."""
    if len(records) < 2:
        raise Error("expected at least two column files")
    shifts = tuple(alignment(record, align) for record in records)
    starts = [record.time[0] - shift for record, shift in zip(records, shifts, strict=True)]
    ends = [record.time[-1] - shift for record, shift in zip(records, shifts, strict=True)]
    time = records[0].time - shifts[0]
    room = 1e-9*max(abs(t) for t in starts + ends)
    time = time[(time >= max(starts) - room) & (time <= min(ends) + room)]
    if time.size < 2:
        raise Error(f"{records[0].file}: expected files that overlap in time, found no common rows")
    columns = tuple(column for column in records[0].columns
                    if column not in GIVEN and all(column in record.columns for record in records))
    if not columns:
        raise Error(f"{records[0].file}: expected a column besides time that all files have, found none; --columns TOML says "
                    "how other codes name ours")
    values = tuple({column: np.interp(time, record.time - shift, record.values(column)) for column in columns}
                   for record, shift in zip(records, shifts, strict=True))
    return Comparison(time, tuple(records), shifts, columns, values)


def difference_table(found: Comparison) -> pd.DataFrame:
    """Root mean square and largest difference of every quantity of every file, SI."""
    rows = []
    for k in range(1, len(found.records)):
        for column in found.columns:
            d = found.difference(k, column)
            known = ~np.isnan(d)
            worst = int(np.nanargmax(np.abs(d))) if known.any() else None
            rows.append({
                "file": found.records[k].name, "what": "difference", "quantity": column,
                "rms": np.sqrt(time_mean(found.time, d**2)),
                "largest": d[worst] if worst is not None else np.nan,
                "at [s]": found.time[worst] if worst is not None else np.nan,
                "share compared": float(known.mean())})
    return pd.DataFrame(rows)


def event_times(record: Record) -> dict[str, float]:
    """Instants [s] worth comparing: the first of each kind of event, the end."""
    found: dict[str, float] = {}
    for event in record.events:
        found.setdefault(f"first {event.kind}" if event.kind != "derailment" else event.kind, event.time)
    for contact in ("LF", "RF"):
        if (t := record.first_contact(contact)) is not None:
            found.setdefault(f"first {CONTACT_NAMES[contact]} contact", t)
    return found | {"end": float(record.time[-1])}


def peaks(record: Record) -> dict[str, tuple[float, float]]:
    """Largest normal force [N] of each contact and its instant [s]: the header's, of all steps, or the columns'."""
    found = {}
    for c in CONTACTS:
        if c in record.peaks:
            found[f"N_{c}"] = record.peaks[c]
        elif f"N_{c}" in record.columns and record.values(f"N_{c}").max() > 0:
            k = int(record.values(f"N_{c}").argmax())
            found[f"N_{c}"] = (float(record.values(f"N_{c}")[k]), float(record.time[k]))
    return found


def event_table(records: Sequence[Record]) -> pd.DataFrame:
    """Times of events and peaks of forces in every file against the reference, SI."""
    rows = []
    times, forces = event_times(records[0]), peaks(records[0])
    for other in records[1:]:
        mine = event_times(other)
        rows += [pair_row(other, "event [s]", name, times.get(name), mine.get(name))
                 for name in [*times, *(n for n in mine if n not in times)]]
        tops = peaks(other)
        rows += [pair_row(other, "peak [N]", name, forces.get(name, (None,))[0], tops.get(name, (None,))[0])
                 for name in (f"N_{c}" for c in CONTACTS) if name in forces or name in tops]
    return pd.DataFrame(rows)


def pair_row(other: Record, what: str, name: str, reference: float | None, value: float | None) -> dict[str, Any]:
    return {"file": other.name, "what": what, "quantity": name, "reference": reference, "value": value,
            "difference": np.nan if reference is None or value is None else value - reference}


# Pages ------------------------------------------------------------------------------------

def shown(column: str) -> tuple[str, float]:
    return SHOWN_WHOLE.get(column) or SHOWN.get(column.split("_")[0], ("SI", 1.0))


def quantity_page(found: Comparison, columns: Sequence[str], title: str) -> Figure:
    """Overlay and difference of up to three quantities."""
    figure = new_page(title, f"reference: {found.records[0].name}", footnote(found))
    axes = figure.subplots(len(columns), 2, squeeze=False, sharex=True, gridspec_kw={
        "left": 0.07, "right": 0.985, "top": 0.875, "bottom": 0.125, "hspace": 0.2, "wspace": 0.17})
    for (overlay, difference), column in zip(axes, columns, strict=True):
        draw_overlay(overlay, found, column)
        draw_difference(difference, found, column)
    axes[0, 1].set_title("difference from the reference", loc="left", color="#404040")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower left", bbox_to_anchor=(0.065, 0.88), ncols=4)
    for ax in axes[-1]:
        label_x(ax, "time [s]" if not any(found.shifts) else "time from the first flange contact [s]")
    return figure


def draw_overlay(ax: Axes, found: Comparison, column: str) -> None:
    unit, scale = shown(column)
    for k, (record, line) in enumerate(zip(found.records, itertools.cycle(SERIES), strict=False)):
        t, x = thin(found.time, scale*found.values[k][column])
        ax.plot(t, x, label=plain(record.name), **line.kwargs())
    label_y(ax, f"{column} [{unit}]")


def draw_difference(ax: Axes, found: Comparison, column: str) -> None:
    unit, scale = shown(column)
    for k, line in zip(range(1, len(found.records)), itertools.cycle(SERIES[1:]), strict=False):
        t, x = thin(found.time, scale*found.difference(k, column))
        ax.plot(t, x, label=plain(found.records[k].name), **line.kwargs())
    label_y(ax, f"Δ{column} [{unit}]")
    if all(np.isnan(found.difference(k, column)).all() for k in range(1, len(found.records))):
        ax.text(0.5, 0.5, "never in contact together", transform=ax.transAxes, ha="center", va="center",
                color="#606060")
        ax.set_yticks([])


def footnote(found: Comparison) -> str:
    words = (
        "difference: file − reference, interpolated linearly to the reference's instants; angles, positions and radii "
        "only where the contact is closed in both")
    if any(found.shifts):
        words += "\nthe first flange contacts are laid on each other: " + ", ".join(
            f"{record.name} {shift:.6f} s" for record, shift in zip(found.records, found.shifts, strict=True))
    return words


def table_page(title: str, subtitle: str, header: Sequence[str], rows: Sequence[Sequence[str]], widths: Sequence[float],
               note: str = "") -> Figure:
    """A page with one table; the first column is text."""
    figure = new_page(title, subtitle, note)
    ax = figure.add_axes((0.055, 0.08, 0.93, 0.83))
    ax.set_axis_off()
    height = 1/max(len(rows) + 1, 30)
    edges = np.concatenate([[0.0], np.cumsum(widths)/np.sum(widths)])
    for i, row in enumerate([header, *rows]):
        y = 1 - (i + 0.5)*height
        if i and i % 2 == 0:
            ax.axhspan(y - height/2, y + height/2, color="#F0F0F0", linewidth=0)
        for j, word in enumerate(row):
            ax.text(edges[j] + 0.005 if j == 0 else edges[j + 1] - 0.005, y, plain(word), ha="left" if j == 0 else "right",
                    va="center", fontsize=7, weight="bold" if i == 0 else "normal")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    return figure


def short(x: float | None) -> str:
    return "–" if x is None or not np.isfinite(x) else f"{x:.4g}"


def comparison_figures(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """Tables, then overlays of everything, three quantities to a page."""
    table = difference_table(found)
    for record in found.records[1:]:
        rows = []
        for _, row in table[table["file"] == record.name].iterrows():
            unit, scale = shown(row["quantity"])
            rows.append([f"{row['quantity']} [{unit}]", short(scale*row["rms"]), short(scale*row["largest"]),
                         short(row["at [s]"]), f"{100*row['share compared']:.1f}"])
        title = f"differences of {record.name}"
        yield title, table_page(title[0].upper() + title[1:], f"reference: {found.records[0].name}",
                                ["quantity", "root mean square", "largest", "at [s]", "compared [%]"], rows,
                                [2, 1.2, 1.2, 1.2, 1], footnote(found))
    events = event_table(found.records)
    rows = []
    for _, row in events.iterrows():
        numbers = (row["reference"], row["value"], row["difference"])
        if row["what"] == "event [s]":
            words = ["–" if x is None or not np.isfinite(x) else f"{x:.6f}" for x in numbers]
            rows.append([f"{row['file']}: {row['quantity']} [s]", *words])
        else:
            rows.append([f"{row['file']}: peak {row['quantity']} [kN]", *(short(x and KN*x) for x in numbers)])
    for start in range(0, len(rows), 45):
        yield "events and peaks", table_page("Events and peaks", f"reference: {found.records[0].name}",
                                             ["", "reference", "file", "difference"], rows[start:start + 45],
                                             [3, 1, 1, 1])
    for start in range(0, len(found.columns), 3):
        columns = found.columns[start:start + 3]
        title = ", ".join(columns)
        yield title, quantity_page(found, columns, title)


def write_tables(found: Comparison, target: Path) -> None:
    write_frame(pd.concat([difference_table(found), event_table(found.records)]), target)


# The study --------------------------------------------------------------------------------

REFERENCE = "fine"
VARIANTS: dict[str, dict[str, dict[str, Any]]] = {
    "fine": {},
    "law": {"contact": {"model": "hertz"}},
    "step": {"integrator": {"scheme": "newmark", "order": 2, "beta": 0.25, "dt": 1e-4, "energy_tolerance": 0.0}},
}
VARIANT_WORDS = {"fine": "half-spaces, cut steps", "law": "one Hertz spring per zone",
                 "step": "average acceleration, step 0.1 ms"}
SHORT_RAMP = 3.0           # of exercise 5, in the study [s]


def study_jobs(namelist: Path, folder: Path, root: Path, ramp_end: float = SHORT_RAMP) -> dict[str, Job]:
    """The runs of one exercise, by variant.  Exercise 5 is cut short; all are written every 0.1 ms."""
    text = namelist.read_text()
    plain = Job(namelist.stem, text, namelist, root)
    base: dict[str, dict[str, Any]] = {
        "output": {"interval": 1e-4, "geometry_file": ""},
        "integrator": {"dt": min(1e-4, float(plain.value("integrator", "dt", 1e-4)))}}
    if plain.value("integrator", "stop_at") == "derailment":
        base["integrator"] |= {"t_end": ramp_end, "stop_at": "t_end"}
    found = {}
    for name, changes in VARIANTS.items():
        product = folder/f"{namelist.stem}_{name}.txt"
        values = {group: dict(variables) for group, variables in base.items()}
        for group, variables in changes.items():
            values.setdefault(group, {}).update(variables)
        values["output"]["file"] = inside(product, root)
        if "contact" in changes and plain.table:
            table = plain.table.with_name(plain.table.stem.rpartition("_")[0] + f"_{changes['contact']['model']}.table")
            values["table"] = {"file": inside(table, root)}
        found[name] = Job(product.stem, with_values(text, values), product, root)
    return found


def study_row(found: Comparison, variant: str) -> dict[str, Any]:
    """What a variant changes in one exercise: up to the end of the first flange contact, and overall."""
    reference, other = found.records
    episode = first_episode(reference, "LF")
    early = found.time <= (episode[1] if episode else found.time[-1])
    row: dict[str, Any] = {"case": reference.name, "variant": variant}
    for column in ("Y", "Z", "roll", "N_LF", "N_LT"):
        d, x = found.difference(1, column), found.values[0][column]
        row[f"{column} rms, first contact"] = np.sqrt(time_mean(found.time[early], d[early]**2))
        row[f"{column} rms"] = np.sqrt(time_mean(found.time, d**2))
        row[f"{column} rms of the reference"] = np.sqrt(time_mean(found.time, x**2))
    for name in ("first left flange contact", "first right flange contact", "end"):
        a, b = event_times(reference).get(name), event_times(other).get(name)
        row[f"{name} [s]"] = np.nan if a is None or b is None else b - a
    row["N_LF peak of the first contact, relative"] = relative(first_peak(reference), first_peak(other))
    a, b = (peaks(record).get("N_LF", (np.nan,))[0] for record in (reference, other))
    row["N_LF largest, relative"] = relative(a, b)
    row["ending"] = other.ending
    return row


def first_peak(record: Record) -> float:
    """Largest normal force [N] of the first contact of the left flange."""
    episode = first_episode(record, "LF")
    if episode is None:
        return np.nan
    inside_it = (record.time >= episode[0]) & (record.time <= episode[1])
    return float(record.values("N_LF")[inside_it].max())


def relative(reference: float, value: float) -> float:
    return (value - reference)/reference if reference else np.nan


STUDY_COLUMNS = ("Y", "Z", "N_LF")


def study_table(rows: pd.DataFrame) -> Figure:
    """Contact law against time step, one row per exercise."""
    header = ["", "", "Y, first contact", "", "Y, whole run", "", "N_LF, first contact", "", "N_LF, whole run", "",
              "first N_LF peak", "", "end of the run"]
    units = ["rms difference", *(["law [mm]", "step [mm]"]*2), *(["law [kN]", "step [kN]"]*2), "law [%]", "step [%]",
             "law [ms]", "step [ms]"]
    table = [units]
    for case, both in rows.groupby("case", sort=False):
        law, step = (both[both["variant"] == v].iloc[0] for v in ("law", "step"))
        words = [case]
        for name, scale in (("Y rms, first contact", MM), ("Y rms", MM), ("N_LF rms, first contact", KN),
                            ("N_LF rms", KN), ("N_LF peak of the first contact, relative", 100.0), ("end [s]", 1e3)):
            words += [f"{scale*row[name]:.3g}" if np.isfinite(row[name]) else "–" for row in (law, step)]
        table.append(words)
    return table_page(
        "Contact law or time step?", "all exercises; reference: half-spaces with cut steps", header, table,
        [1.3] + [1]*12,
        "law: one Hertz spring per zone instead of half-spaces, same steps; step: average acceleration with whole steps of "
        "0.1 ms instead of the shipped integrator, same law; exercise 5 cut short.\nfirst contact: from the start to "
        "the end of the first contact of the left flange; over the whole run every impact multiplies what the ones "
        "before it left.")


def study_figure(rows: pd.DataFrame) -> Figure:
    """The same as bars, relative to the reference's root mean square."""
    figure = new_page("Contact law or time step?", "rms difference over the rms of the reference")
    axes = figure.subplots(2, 2, gridspec_kw={
        "left": 0.07, "right": 0.985, "top": 0.885, "bottom": 0.09, "hspace": 0.3, "wspace": 0.15})
    cases = list(dict.fromkeys(rows["case"]))
    for line, column in zip(axes, ("Y", "N_LF"), strict=True):
        for ax, (key, words) in zip(line, ((f"{column} rms, first contact", "to the end of the first flange contact"),
                                           (f"{column} rms", "whole run")), strict=True):
            for shift, variant, style in ((-0.2, "law", SERIES[2]), (0.2, "step", SERIES[1])):
                part = rows[rows["variant"] == variant].set_index("case").loc[cases]
                share = part[key]/part[f"{column} rms of the reference"]
                ax.bar(np.arange(len(cases)) + shift, share, width=0.38, color=style.color,
                       label=VARIANT_WORDS[variant])
            ax.set_yscale("log")
            ax.set_xticks(np.arange(len(cases)), cases, fontsize=6.5)
            ax.grid(axis="x", visible=False)
            ax.margins(x=0.02)
            ax.set_title(f"{column}: {words}", loc="left", color="#404040")
    axes[0, 1].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    return figure


def study_page(case: str, records: Sequence[Record]) -> Figure:
    """One exercise with all variants: overlay and difference of the quantities that matter."""
    return quantity_page(compare(records), STUDY_COLUMNS, f"{case}: contact law or time step?")


def make_study(root: Path, inputs: Path, outputs: Path, workers: int, ramp_end: float = SHORT_RAMP) -> list[Path]:
    """Run what is not up to date; write the PDF and the CSV file of the study."""
    executable = find_executable(root)
    namelists = find_namelists(inputs)
    folder = outputs/"study"
    folder.mkdir(parents=True, exist_ok=True)
    jobs = {file.stem: study_jobs(file, folder, root, ramp_end) for file in namelists}
    flat = [job for variants in jobs.values() for job in variants.values()]
    with tqdm(total=len(flat), desc="study", disable=None) as bar:
        run_stale(flat, executable, workers, done=lambda job, ran: bar.update())
    rows, pages = [], []
    with ldbench_style(), tempfile.TemporaryDirectory() as scratch:
        for case, variants in jobs.items():
            records = [replace(read_record(job.product), name=VARIANT_WORDS[v]) for v, job in variants.items()]
            for variant, other in zip(list(variants)[1:], records[1:], strict=True):
                rows.append(study_row(compare([records[0], other]), variant) | {"case": case})
            part = Path(scratch)/f"{case}.pdf"
            pages.append(Part(case, part, save_pages(part, [(case, study_page(case, records))])))
        table = pd.DataFrame(rows)
        first = Path(scratch)/"summary.pdf"
        figures = [("table", study_table(table)), ("bars", study_figure(table))]
        summary = Part("Summary", first, save_pages(first, figures))
        target = outputs/"ldbench_study.pdf"
        bind([summary, *pages], target, "ldbench: contact law or time step?")
    write_frame(table, target.with_suffix(".csv"))
    return [target, target.with_suffix(".csv")]


# Command ----------------------------------------------------------------------------------

def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE", help="column files; the first is the reference")
    parser.add_argument("-o", "--output", type=Path, default=Path("comparison.pdf"),
                        help="PDF; the tables go beside it as CSV (%(default)s)")
    parser.add_argument("--align", choices=("time", "first-flange"), default="time",
                        help="lay equal times, or the first flange contacts, on each other (%(default)s)")
    parser.add_argument("--columns", type=Path, metavar="TOML",
                        help="how the other files name our columns; files with our header need no map")
    parser.add_argument("--study", action="store_true", help="contact law against time step, all exercises")
    parser.add_argument("--formulations", action="store_true",
                        help="elastic contact against constraint equations, all exercises")
    parser.add_argument("--outputs", type=Path, metavar="DIR",
                        help="where the study and the formulations go (outputs, in this folder)")
    parser.add_argument("--jobs", type=side_by_side, default=usable_cores(), help="runs side by side (%(default)s)")


def main(args: argparse.Namespace) -> int:
    if args.formulations:
        root = Path.cwd()
        made = formulations.make_comparison(root, shipped_inputs(root), args.outputs or root/"outputs", args.jobs)
    elif args.study:
        root = Path.cwd()
        made = make_study(root, shipped_inputs(root), args.outputs or root/"outputs", args.jobs)
    else:
        records = [read_record(file, args.columns if k else None) for k, file in enumerate(args.files)]
        made = make_comparison(distinct(records), args.output, args.align)
    print("\n".join(str(file) for file in made))
    return 0


def distinct(records: Sequence[Record]) -> list[Record]:
    """Files of the same case get their paths as names."""
    names = [record.name for record in records]
    return [replace(record, name=str(record.file)) if names.count(record.name) > 1 else record for record in records]


def make_comparison(records: Sequence[Record], target: Path, align: str = "time") -> list[Path]:
    """Write the PDF of a comparison and its tables."""
    read = [record.file for record in records]
    check_written([target], read)
    tables = target.with_suffix(".csv")
    check_written([target, tables], read)
    check_ending(target, "a document .pdf, beside which the tables go as .csv", ".pdf")
    found = compare(records, align)
    with ldbench_style(), tempfile.TemporaryDirectory() as scratch:
        part = Path(scratch)/"pages.pdf"
        pages = save_pages(part, comparison_figures(found))
        bind([Part("Comparison", part, pages)], target, "ldbench: comparison")
    write_tables(found, tables)
    return [target, tables]
