"""Column files laid over each other: a document with files, events, impacts, differences and every quantity, and its tables."""
from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .._core.files import check_written, write_frame
from ..constants import DEG, KN
from ..number_text import number_text
from ..plots.document import save_document
from ..plots.frame import legend_of_page, new_page
from ..plots.named import name, shows
from ..plots.sheets import PDF, check_sheets, save_sheets
from ..plots.stretches import rows_between, thin
from ..plots.style import SERIES, ldbench_style, plain
from ..plots.tables import LINES, draw_listing, paged
from ..results.quantities import GROUPS
from ..results.run_data import RunData
from .differences import Comparison, Pairing, compare, difference_table, event_table, impact_table, paired_impacts

PANELS = 4              # quantities on a page
OVERLAYS = 12           # impacts on a page
OVERLAY_PAGES = 2
ENOUGH_ROWS = 6         # of an impact, for its peak and times
IMPACT_COLUMNS = ("start", 1e3), ("duration", 1e3), ("peak", KN), ("impulse", KN), ("angle", DEG)
TIMES = "start", "duration"     # in microseconds, as events
TIME_DECIMALS = 3       # of a time in ms
MARGIN = 0.35           # time before and after an impact, of the longest one


def make_comparison(runs: Sequence[RunData], target: Path, align: str = "time") -> list[Path]:
    """Write the pages of a comparison, as the ending of `target` says; differences, events, peaks and impacts as CSV, SI units."""
    tables, read = target.with_suffix(".csv"), [run.file for run in runs]
    check_written([target], read)
    check_written([target, tables], read)
    check_sheets(target)
    found = compare(runs, align)
    if target.suffix.lower() == PDF:
        save_document([("Comparison", comparison_figures(found))], target, "ldbench: comparison")
    else:
        with ldbench_style():
            save_sheets([figure for _, figure in comparison_figures(found)], target)
    write_frame(pd.concat([difference_table(found), event_table(found.runs), impact_table(found.runs)]), tables)
    return [target, tables]


def themes(found: Comparison) -> dict[str, list[str]]:
    """The columns by theme, in the order of the table of quantities."""
    return {group: columns for group in GROUPS
            if (columns := [column for column in found.columns if found.shown(column).group == group])}


def looks(found: Comparison) -> list[dict[str, Any]]:
    """Name and look of the curves of each file."""
    return [{"label": plain(run.name), **line.kwargs()} for run, line in zip(found.runs, itertools.cycle(SERIES), strict=False)]


def quantity_page(found: Comparison, columns: Sequence[str], title: str) -> Figure:
    """Overlay and difference of a few quantities."""
    figure = new_page(title[0].upper() + title[1:], f"reference: {found.runs[0].name}", footnote(found))
    axes = figure.subplots(len(columns), 2, squeeze=False, sharex=True)
    for (overlay, difference), column in zip(axes, columns, strict=True):
        known = found.shown(column)
        apart = [found.difference(k, column) for k in range(1, len(found.runs))]
        for ax, curves, first, how in ((overlay, [values[column] for values in found.values], 0, "between rows"),
                                       (difference, apart, 1, "difference")):
            for x, look, run in zip(curves, looks(found)[first:], found.runs[first:], strict=True):
                curve, = ax.plot(*thin(found.time, known.scale*x), **look)
                shows(curve, name(column, known.unit), "time [s]", how, run.name)
        overlay.set_title(plain(known.label), loc="left", pad=3)
        unit = f" [{known.unit}]" if known.unit else ""
        difference.set_title(plain(f"difference from the reference{unit}"), loc="left", color="#404040", pad=3)
        if all(np.isnan(x).all() for x in apart):
            difference.text(0.5, 0.5, "never in contact together", transform=difference.transAxes, ha="center", va="center",
                            color="#606060")
            difference.set_yticks([])
    legend_of_page(figure, axes[0, 0].get_lines(), 4)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]" if not any(found.shifts) else "time from the first flange contact [s]")
    return figure


def footnote(found: Comparison) -> str:
    """Tell below a page how differences are computed."""
    words = (
        "difference: file − reference, interpolated linearly to the reference's instants; angles, positions and radii "
        "only where the contact is closed in both")
    if any(found.shifts):
        words += "\nthe first flange contacts are laid on each other: " + ", ".join(
            f"{run.name} {shift:.6f} s" for run, shift in zip(found.runs, found.shifts, strict=True))
    return words


def comparison_figures(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """Files, events and peaks, impacts, differences in numbers, then overlays by theme."""
    yield from first_pages(found)
    yield from impact_pages(found)
    yield from difference_pages(found)
    for group, columns in themes(found).items():
        for start in range(0, len(columns), PANELS):
            yield group, quantity_page(found, columns[start:start + PANELS], group)


def first_pages(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """What is compared, a row for each file; events and peaks stand below, on pages of their own where they are many."""
    files = [[run.name + (" (reference)" if run is found.runs[0] else ""), run.file.name, run.header.title or "–",
              f"ldbench {run.header.version}" if run.is_ours else "–", run.law or "–", f"{len(run.time)}",
              f"{run.time[0]:g} to {run.time[-1]:g}", run.ending or "–"] for run in found.runs]
    reference = f"reference: {found.runs[0].name}"
    page = new_page("Comparison", reference)
    draw_listing(page, ["name", "file", "title", "program", "contact", "rows", "time [s]", "end"], files,
                 [2.4, 1.7, 4.2, 1.2, 1.1, 0.8, 1.5, 3], (0, 1, 2))
    events = []
    for _, row in event_table(found.runs).iterrows():
        scale, decimals, unit = (1e3, TIME_DECIMALS, "ms") if row["unit"] == "s" else (KN, None, "kN")
        events.append([row["file"], f"{row['words']} [{unit}]",
                       *(number_text(None if row[name] is None else scale*row[name], decimals)
                         for name in ("reference", "value", "difference"))])
    header, widths = ["events and peaks", "", "reference", "file", "difference"], [1.5, 3, 1, 1, 1]
    above = len(files) + 3
    together = above + len(events) < LINES
    if together and events:
        draw_listing(page, header, events, widths, (0, 1), above=above)
    yield "files, events and peaks" if together else "files", page
    if not together:
        yield from paged("events and peaks", reference, header, events, widths, (0, 1))


def impact_pages(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """Tables of impacts, and the normal forces of all files from the beginning of each impact on."""
    pairings, left_out = paired_impacts(found.runs)
    if not pairings:
        return
    note = ("impact: a closed interval of a contact between two open rows, or an impact of rigid contacts; impacts of a contact "
            "are compared by their number\npeak: largest normal force of the rows; impulse: integral of the normal force; angle: "
            "contact angle at the largest force") + (f"; {left_out} more impacts are left out" if left_out else "")
    few = [f"{run.name}: {n} impacts have fewer than {ENOUGH_ROWS} rows, so their numbers are rough"
           for k, run in enumerate(found.runs)
           if (n := sum(0 < impact.rows.stop - impact.rows.start < ENOUGH_ROWS for one in pairings if (impact := one.impacts[k])))]
    note = "\n".join([note, *(["; ".join(few)] if few else [])])
    reference = found.runs[0].name
    for k, run in enumerate(found.runs[1:], 1):
        rows = []
        for one in pairings:
            a, b = one.impacts[0], one.impacts[k]
            if a or b:
                rows.append([one.words, *(
                    number_text(scale*getattr(x, name) if x else None, TIME_DECIMALS if name in TIMES else None)
                    for name, scale in IMPACT_COLUMNS for x in (a, b))])
        units = "start [ms]", "duration [ms]", "peak [kN]", "impulse [kN·s]", "angle [°]"
        header = ["impact", *(word for unit in units for word in (unit, ""))]
        names = ["", *["reference", "file"]*len(units)]
        yield from paged(f"impacts of {run.name}", f"reference: {reference}", header, rows, [1.6] + [1]*10, (0,), note, names)
    lasting = [[bool(impact and impact.duration > 0) for impact in one.impacts] for one in pairings]
    drawn = [one for one, known in zip(pairings, lasting, strict=True) if known[0] and any(known[1:])]
    for start in range(0, min(len(drawn), OVERLAYS*OVERLAY_PAGES), OVERLAYS):
        more = len(drawn) - OVERLAYS*OVERLAY_PAGES
        yield "impacts, laid on each other", overlay_page(found, drawn[start:start + OVERLAYS], more)


def overlay_page(found: Comparison, pairings: Sequence[Pairing], more: int) -> Figure:
    """Normal forces of a few impacts, each from the beginning of the impact in each file."""
    figure = new_page("Impacts, laid on each other", f"reference: {found.runs[0].name}",
                      "normal force [kN] over the time [ms] since the contact closed in each file; above each panel stands when "
                      "that was in the reference; an impact that the reference or all other files lack is in the tables alone"
                      + (f"\n{more} more impacts are in the tables alone" if more > 0 else ""))
    axes = figure.subplots(3, 4).ravel()
    for ax, one in zip(axes, pairings, strict=False):
        longest = max(impact.duration for impact in one.impacts if impact)
        for run, impact, look in zip(found.runs, one.impacts, looks(found), strict=True):
            force = run.normal_force(one.contact)
            if force is None or impact is None or not impact.duration > 0:
                continue
            rows = rows_between(run.time, impact.start - MARGIN*longest, impact.start + (1 + MARGIN)*longest)
            curve, = ax.plot(1e3*(run.time[rows] - impact.start), KN*force[rows], **look)
            shows(curve, f"N_{one.contact} [kN]", f"time since {one.name} [ms]", of=run.name)
        ax.set_xlim(-1e3*MARGIN*longest, 1e3*(1 + MARGIN)*longest)
        ax.set_ylim(bottom=0)
        ax.set_title(f"{one.words}: {1e3*one.impacts[0].start:.3f} ms" if one.impacts[0] else one.words, loc="left", pad=3)
    for unused in axes[len(pairings):]:
        unused.remove()
    legend_of_page(figure, [Line2D([], [], **look) for look in looks(found)], 4)
    return figure


def difference_pages(found: Comparison) -> Iterator[tuple[str, Figure]]:
    """Root mean square and largest difference of every quantity, by theme."""
    table = difference_table(found).set_index(["file", "quantity"])
    for run in found.runs[1:]:
        rows = []
        for group, columns in themes(found).items():
            rows.append([group, "", "", "", ""])
            for column in columns:
                row, known = table.loc[(run.name, column)], found.shown(column)
                rows.append(["   " + known.label, number_text(known.scale*row["rms"]), number_text(known.scale*row["largest"]),
                             number_text(1e3*row["at [s]"], TIME_DECIMALS), number_text(100*row["share compared"], 1)])
        yield from paged(f"differences of {run.name}", f"reference: {found.runs[0].name}",
                         ["quantity", "root mean square", "largest", "at [ms]", "compared [% of rows]"], rows,
                         [2, 1.2, 1.2, 1.2, 1], (0,), footnote(found))
