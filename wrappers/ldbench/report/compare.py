"""Column files laid over each other, and what differs between them."""
from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._core.errors import Error
from .._core.files import check_ending, check_written, write_frame
from ..plots.document import Part, bind, save_pages
from ..plots.frame import label_x, label_y, new_page
from ..plots.stretches import thin
from ..plots.style import SERIES, ldbench_style, plain
from ..results.columns import time_mean
from ..results.quantities import CONTACT_NAMES, CONTACTS, KN, quantity
from ..results.run_data import RunData

GIVEN = {"time", "X", "vX", "pitch", "pitch_rate", "F_ext", "KE_long", "KE_pitch"}   # not outcomes


@dataclass(frozen=True)
class Comparison:
    """Runs on common instants: `time` of the reference, counted from its alignment, and per run its
    columns there."""
    time: np.ndarray                     # [s]
    runs: tuple[RunData, ...]          # the first is the reference
    shifts: tuple[float, ...]            # instants of each file that are taken as the same [s]
    columns: tuple[str, ...]             # that all files have
    values: tuple[dict[str, np.ndarray], ...]

    def difference(self, k: int, column: str) -> np.ndarray:
        """File k less the reference; nan where either contact is open."""
        return self.values[k][column] - self.values[0][column]


def alignment(run: RunData, align: str) -> float:
    """The instant of a file [s] that counts as zero."""
    if align == "time":
        return 0.0
    instants = [t for c in ("LF", "RF") if (t := run.first_contact(c)) is not None]
    if not instants:
        raise Error(f"{run.file}: expected a flange contact to align by, found none")
    return min(instants)


def compare(runs: Sequence[RunData], align: str = "time") -> Comparison:
    """Bring runs onto common instants.  align: 'time', or 'first-flange' for the first flange contact of each."""
    if len(runs) < 2:
        raise Error("expected at least two column files")
    shifts = tuple(alignment(run, align) for run in runs)
    starts = [run.time[0] - shift for run, shift in zip(runs, shifts, strict=True)]
    ends = [run.time[-1] - shift for run, shift in zip(runs, shifts, strict=True)]
    time = runs[0].time - shifts[0]
    room = 1e-9*max(abs(t) for t in starts + ends)
    time = time[(time >= max(starts) - room) & (time <= min(ends) + room)]
    if time.size < 2:
        raise Error(f"{runs[0].file}: expected files that overlap in time, found no common rows")
    columns = tuple(column for column in runs[0].data
                    if column not in GIVEN and all(column in run.data for run in runs))
    if not columns:
        raise Error(f"{runs[0].file}: expected a column besides time that all files have, found none; --map TOML says "
                    "how other codes name ours")
    values = tuple({column: np.interp(time, run.time - shift, run.values(column)) for column in columns}
                   for run, shift in zip(runs, shifts, strict=True))
    return Comparison(time, tuple(runs), shifts, columns, values)


def difference_table(found: Comparison) -> pd.DataFrame:
    """Root mean square and largest difference of every quantity of every file, SI."""
    rows = []
    for k in range(1, len(found.runs)):
        for column in found.columns:
            d = found.difference(k, column)
            known = ~np.isnan(d)
            worst = int(np.nanargmax(np.abs(d))) if known.any() else None
            rows.append({
                "file": found.runs[k].name, "what": "difference", "quantity": column,
                "rms": np.sqrt(time_mean(found.time, d**2)),
                "largest": d[worst] if worst is not None else np.nan,
                "at [s]": found.time[worst] if worst is not None else np.nan,
                "share compared": float(known.mean())})
    return pd.DataFrame(rows)


def event_times(run: RunData) -> dict[str, float]:
    """Instants [s] worth comparing: the first of each kind of event, the end."""
    found: dict[str, float] = {}
    for event in run.events:
        found.setdefault(f"first {event.kind}" if event.kind != "derailment" else event.kind, event.t)
    for contact in ("LF", "RF"):
        if (t := run.first_contact(contact)) is not None:
            found.setdefault(f"first {CONTACT_NAMES[contact]} contact", t)
    return found | {"end": float(run.time[-1])}


def peaks(run: RunData) -> dict[str, float]:
    """The largest normal force [N] of each contact that closes."""
    return {f"N_{c}": peak[0] for c in CONTACTS if (peak := run.peak(c))}


def event_table(runs: Sequence[RunData]) -> pd.DataFrame:
    """Times of events and peaks of forces in every file against the reference, SI."""
    rows = []
    times, forces = event_times(runs[0]), peaks(runs[0])
    for other in runs[1:]:
        mine = event_times(other)
        rows += [pair_row(other, "event [s]", name, times.get(name), mine.get(name))
                 for name in [*times, *(n for n in mine if n not in times)]]
        tops = peaks(other)
        rows += [pair_row(other, "peak [N]", name, forces.get(name), tops.get(name))
                 for name in (f"N_{c}" for c in CONTACTS) if name in forces or name in tops]
    return pd.DataFrame(rows)


def pair_row(other: RunData, what: str, name: str, reference: float | None, value: float | None) -> dict[str, Any]:
    """A row of the table of events and peaks, SI."""
    return {"file": other.name, "what": what, "quantity": name, "reference": reference, "value": value,
            "difference": np.nan if reference is None or value is None else value - reference}


def shown(column: str) -> tuple[str, float]:
    """The unit in which a column is shown, and the factor from SI."""
    known = quantity(column)
    return known.unit or ("SI" if known.group == "other columns" else ""), known.scale


def quantity_page(found: Comparison, columns: Sequence[str], title: str) -> Figure:
    """Overlay and difference of up to three quantities."""
    figure = new_page(title, f"reference: {found.runs[0].name}", footnote(found))
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
    """Draw a column of all runs over each other."""
    unit, scale = shown(column)
    for k, (run, line) in enumerate(zip(found.runs, itertools.cycle(SERIES), strict=False)):
        t, x = thin(found.time, scale*found.values[k][column])
        ax.plot(t, x, label=plain(run.name), **line.kwargs())
    label_y(ax, f"{column} [{unit}]")


def draw_difference(ax: Axes, found: Comparison, column: str) -> None:
    """Draw the difference of a column from the reference."""
    unit, scale = shown(column)
    for k, line in zip(range(1, len(found.runs)), itertools.cycle(SERIES[1:]), strict=False):
        t, x = thin(found.time, scale*found.difference(k, column))
        ax.plot(t, x, label=plain(found.runs[k].name), **line.kwargs())
    label_y(ax, f"Δ{column} [{unit}]")
    if all(np.isnan(found.difference(k, column)).all() for k in range(1, len(found.runs))):
        ax.text(0.5, 0.5, "never in contact together", transform=ax.transAxes, ha="center", va="center",
                color="#606060")
        ax.set_yticks([])


def footnote(found: Comparison) -> str:
    """Tell below a page how differences are computed."""
    words = (
        "difference: file − reference, interpolated linearly to the reference's instants; angles, positions and radii "
        "only where the contact is closed in both")
    if any(found.shifts):
        words += "\nthe first flange contacts are laid on each other: " + ", ".join(
            f"{run.name} {shift:.6f} s" for run, shift in zip(found.runs, found.shifts, strict=True))
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
    """Write a number with four digits; a dash for none."""
    return "–" if x is None or not np.isfinite(x) else f"{x:.4g}"


def comparison_figures(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """Tables, then overlays of everything, three quantities to a page."""
    table = difference_table(found)
    for run in found.runs[1:]:
        rows = []
        for _, row in table[table["file"] == run.name].iterrows():
            unit, scale = shown(row["quantity"])
            rows.append([f"{row['quantity']} [{unit}]", short(scale*row["rms"]), short(scale*row["largest"]),
                         short(row["at [s]"]), f"{100*row['share compared']:.1f}"])
        title = f"differences of {run.name}"
        yield title, table_page(title[0].upper() + title[1:], f"reference: {found.runs[0].name}",
                                ["quantity", "root mean square", "largest", "at [s]", "compared [%]"], rows,
                                [2, 1.2, 1.2, 1.2, 1], footnote(found))
    events = event_table(found.runs)
    rows = []
    for _, row in events.iterrows():
        numbers = (row["reference"], row["value"], row["difference"])
        if row["what"] == "event [s]":
            words = ["–" if x is None or not np.isfinite(x) else f"{x:.6f}" for x in numbers]
            rows.append([f"{row['file']}: {row['quantity']} [s]", *words])
        else:
            rows.append([f"{row['file']}: peak {row['quantity']} [kN]", *(short(x and KN*x) for x in numbers)])
    for start in range(0, len(rows), 45):
        yield "events and peaks", table_page("Events and peaks", f"reference: {found.runs[0].name}",
                                             ["", "reference", "file", "difference"], rows[start:start + 45],
                                             [3, 1, 1, 1])
    for start in range(0, len(found.columns), 3):
        columns = found.columns[start:start + 3]
        title = ", ".join(columns)
        yield title, quantity_page(found, columns, title)


def write_tables(found: Comparison, target: Path) -> None:
    """Write differences, events and peaks as CSV."""
    write_frame(pd.concat([difference_table(found), event_table(found.runs)]), target)


def distinct(runs: Sequence[RunData]) -> list[RunData]:
    """Files of the same case get their paths as names."""
    names = [run.name for run in runs]
    return [run.named(str(run.file)) if names.count(run.name) > 1 else run for run in runs]


def make_comparison(runs: Sequence[RunData], target: Path, align: str = "time") -> list[Path]:
    """Write the PDF of a comparison and its tables."""
    read = [run.file for run in runs]
    check_written([target], read)
    tables = target.with_suffix(".csv")
    check_written([target, tables], read)
    check_ending(target, "a document .pdf, beside which the tables go as .csv", ".pdf")
    found = compare(runs, align)
    with ldbench_style(), tempfile.TemporaryDirectory() as scratch:
        part = Path(scratch)/"pages.pdf"
        pages = save_pages(part, comparison_figures(found))
        bind([Part("Comparison", part, pages)], target, "ldbench: comparison")
    write_tables(found, tables)
    return [target, tables]
