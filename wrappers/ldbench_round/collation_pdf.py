"""The PDF of a collation: codes and simulations, what could not be used, grades, and a chapter per simulation."""
from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ldbench.plots.document import Part, bind, save_parts
from ldbench.plots.frame import legend_of_page, new_page
from ldbench.plots.style import ldbench_style, plain
from ldbench.results.quantities import CONTACT_NAMES, KN, quantity, significant
from ldbench.tools import check_ending, check_written, processes

from .collation import Collation
from .collation_pdf_grades import grade_pages, score_table
from .collation_style import CODES_ON_PAGE, LINES, Table, capital, cut, draw_tables, line_of, new_matrix
from .kept_entries import CLOSE, IMPACTS, Entry
from .round_numbers import NUMBERS, names_of
from .submissions import FACTS, Submission
from .tasks import Task

# Shades of a cell by its verdict, light enough for black words; the words say the same.
SHADES = {"passed": "#D9F0DF", "doubtful": "#FDF0C4", "failed": "#F9D6CF", "unusable": "#C9C9C9", "none": "#F4F4F4"}
MATRIX_NOTE = (
    "each cell: checks that passed / are doubtful / failed, and below the largest force of the first left flange impact (exercise "
    "5: the lateral force at derailment) [kN] with its distance from the median of all codes\n"
    "shade: green, every check passed; yellow, some are doubtful; red, some failed; grey, the file could not be used; –, not "
    "submitted or without this number")
TABLE_NOTE = ("beside each number: how far it is from the median of all codes that have it; –: the file does not give it, and "
              "collation.csv tells why\nrebound: lateral velocity after over before the first left flange impact, reversed; below "
              "0 the wheelset still moves towards the flange")
CURVES_NOTE = (
    "energy: kinetic, of weight and load, and elastic of the treads by Hertz's law, without the work of the lateral force, less "
    "that of the first row; it dips while a flange stores energy\n"
    "forces of the flanges: each code from the moment at which its contact closes; an impact of rigid contacts takes no time and "
    "has no force to show; exercise 5: the panels over time are fitted to what comes before the derailment")
WIDE = "t_return", "energy_error", "processor_time"     # numbers whose columns need more room
FAR = 3.0           # ranges of the median code, beyond which a curve leaves its panel
MANY = 10.0         # a relative difference that is told as a factor
LONGEST_NUMBER = 10     # characters of a number, beyond which three digits are shown
FLANGES = 20e-3     # lateral displacement between the flanges, at most [m]
BEGUN = 5e-4        # within which an impact begins whose contact is told to close at 0 [s]


def shade(entry: Entry | None) -> str:
    """The verdict that a cell's shade stands for."""
    if entry is None:
        return "none"
    if entry.error:
        return "unusable"
    return "failed" if entry.verdict.get("failed") else "doubtful" if entry.verdict.get("doubtful") else "passed"


def deviation(found: Collation, code: Submission, task: Task, name: str) -> float:
    """How far a number is from the median of all codes, relative to it; NaN where one of them is not known."""
    value, median = found.value(code, task, name), found.median(task, name)
    return (value - median)/abs(median) if median else np.nan


def signed_percent(x: float) -> str:
    """A relative difference in percent with its sign, or as a factor where it is large; a dash for none."""
    if not np.isfinite(x):
        return "–"
    if abs(x) >= MANY:
        return f"× {1 + x:.3g}".replace("-", "−")
    words = f"{100*x:+.0f}" if abs(x) >= 0.0995 else f"{100*x:+.1f}" if abs(x) >= 0.00995 else f"{100*x:+.2f}"
    return f"{'0' if float(words) == 0 else words} %".replace("-", "−")


def text(name: str, x: float, digits: int | None = None) -> str:
    """A number as it is shown, without its unit."""
    words = NUMBERS[name].text(x, digits)
    return (words if len(words) <= LONGEST_NUMBER else f"{NUMBERS[name].scale*x:.3g}").replace("-", "−")


def main_number(task: Task) -> str:
    """The number of a simulation that the matrix shows."""
    return "F_derailment" if task.exercise == 5 else "peak"


# ---- the matrix ----------------------------------------------------------------------
def matrix_pages(found: Collation) -> Iterator[tuple[str, Figure]]:
    """Codes by simulations: verdict and main number. The codes are described below if that fits, and on other pages if not."""
    told = code_table(found), remark_table(found)
    above = -(-LINES*(len(found.codes) + 1) // (CODES_ON_PAGE + 1)) + 1
    fits = above + sum(table.lines for table in told) <= LINES
    for start in range(0, len(found.codes), CODES_ON_PAGE):
        page = matrix_page(found, start)
        if fits:
            draw_tables(page, [table for table in told if table.rows], above)
        yield "codes and simulations", page
    if not fits:
        yield from stacked("the codes", f"{len(found.codes)} codes", told)


def matrix_page(found: Collation, start: int) -> Figure:
    """The rows of the matrix from one code on."""
    page = new_matrix(found, start, "Codes and simulations", f"{len(found.codes)} codes", MATRIX_NOTE, 0.15, CODES_ON_PAGE)
    ax, width, height = page.ax, page.width, page.height
    for i, code in enumerate(page.codes):
        y = page.name_row(i, 24)
        for j, task in enumerate(found.tasks):
            entry = found.entry(code, task)
            left = page.first + j*width
            ax.add_patch(Rectangle((left + 0.0015, y - 0.46*height), width - 0.003, 0.92*height, facecolor=SHADES[shade(entry)],
                                   linewidth=0, zorder=0))
            ax.text(left + width/2, y, cell_words(found, code, task, entry), ha="center", va="center", fontsize=6.6,
                    linespacing=1.35)
    return page.figure


def cell_words(found: Collation, code: Submission, task: Task, entry: Entry | None) -> str:
    """The words of a cell of the matrix."""
    if entry is None:
        return "–"
    if entry.error:
        return "cannot\nbe used"
    name = main_number(task)
    counts = " / ".join(str(entry.verdict.get(verdict, 0)) for verdict in ("passed", "doubtful", "failed"))
    value = found.value(code, task, name)
    shown = text(name, value, 1 if np.isfinite(value) and value*NUMBERS[name].scale < 1000 else 0)
    return f"{counts}\n{shown}\n{signed_percent(deviation(found, code, task, name))}" if np.isfinite(value) else f"{counts}\n–"


# ---- the codes -----------------------------------------------------------------------
def code_table(found: Collation) -> Table:
    """What the submissions tell of the codes."""
    header = ["folder", *(key.replace("_", " ") for key in FACTS), "files"]
    rows = []
    for code in found.codes:
        entries = [found.entry(code, task) for task in found.tasks]
        rows.append([code.name, *(code.facts.get(key, "–") for key in FACTS), f"{sum(not one.error for one in entries if one)}"])
    return Table("The codes, as submission.toml tells", header, rows, [1.2, 1.1, 0.7, 1.7, 1.5, 1.2, 1.8, 1.0, 1.2, 1.2, 0.4],
                 tuple(range(len(header) - 1)))


def remark_table(found: Collation) -> Table:
    """What could not be used, a line each."""
    lines = [[str(k), line] for k, line in enumerate(found.lines(), 1)]
    return Table(f"What could not be used: {len(lines)} remarks", ["", "code: what, and why"], lines, [0.04, 1], (1,))


# ---- a chapter -----------------------------------------------------------------------
def chapter(found: Collation, task: Task) -> Iterator[tuple[str, Figure]]:
    """The pages of a simulation: curves of all codes, and the table of numbers."""
    if not any(entry and not entry.error for code in found.codes for entry in [found.entry(code, task)]):
        return
    yield "curves", curves_page(found, task)
    tables = number_table(found, task), score_table(found, task), finding_table(found, task)
    for _, figure in stacked(f"numbers, scores and findings, {task.words}", f"all codes, {task.name}", tables):
        yield "numbers, scores, findings", figure       # which is short enough for the contents


def curves_page(found: Collation, task: Task) -> Figure:
    """Motion and energy over the whole run, and the forces of the flanges from their first contacts on."""
    figure = new_page(capital(task.words), f"all codes, {task.name}", CURVES_NOTE)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.35, 1))
    shared: Axes | None = None
    for k, (name, words, unit, scale) in enumerate((
            ("Y", "lateral Y", "mm", 1e3), ("roll", quantity("roll").words, "mrad", 1e3), ("energy", "energy − start", "J", 1.0))):
        ax = figure.add_subplot(grid[k, 0], sharex=shared)
        shared = shared or ax
        draw(ax, found, task, name, 1.0, scale)
        if limits := common_limits(found, task, name):
            ax.set_xlim(0 if limits.start >= 0 else limits.start, limits.end)
            spare = 0.04*(limits.high - limits.low) or 1e-3/scale
            ax.set_ylim(scale*(limits.low - spare), scale*(limits.high + spare))
        ax.set_ylabel(f"{words} [{unit}]")
        if k < 2:
            ax.tick_params(labelbottom=False)
        else:
            ax.set_xlabel("time [s]")
    struck = [name for name in IMPACTS if curves_of(found, task, name)]
    for k, name in enumerate(struck):
        ax = figure.add_subplot(grid[:, 1] if len(struck) == 1 else grid[:2, 1] if k == 0 else grid[2, 1])
        draw(ax, found, task, name, 1e3, KN)
        ax.set_title(f"normal force, {CONTACT_NAMES[name[2:]]}, first contact", loc="left", pad=3)
        ax.set_ylabel("N [kN]")
        end = end_of(found, task, name)
        ax.set_xlim(1e3*CLOSE[0], 1e3*end)
        ax.set_ylim(0, KN*1.06*(largest_until(found, task, name, end) or 1.0))
        if name == struck[-1]:
            ax.set_xlabel("time since the contact closed [ms]")
    drawn = [(i, code) for i, code in enumerate(found.codes) if (entry := found.entry(code, task)) and entry.curves]
    handles = [figure.axes[0].plot([], [], label=plain(cut(code.name, 22 if len(drawn) <= 12 else 11)), **line_of(i).kwargs())[0]
               for i, code in drawn]
    legend_of_page(figure, handles, max(6, -(-len(handles)//2)))
    return figure


def end_of(found: Collation, task: Task, name: str) -> float:
    """Where a panel of an impact ends [s]: after the longest of the first impacts."""
    lengths = [opening for _, _, t, x in curves_of(found, task, name) if np.isfinite(opening := opening_of(t, x))]
    return min(1.25*max(lengths), CLOSE[1]) if lengths else CLOSE[1]


def opening_of(t: np.ndarray, x: np.ndarray) -> float:
    """When the force of an impact is gone that begins at 0 [s]; NaN where none begins there."""
    closed = (t > 0) & (x > 0.001*np.nanmax(x, initial=0.0))
    begun = int(closed.argmax())
    if not closed.any() or t[begun] > BEGUN or closed[begun:].all():
        return np.nan
    return float(t[begun + int(closed[begun:].argmin())])


class Limits(NamedTuple):
    """What a panel shows, SI."""

    start: float
    end: float
    low: float
    high: float


def common_limits(found: Collation, task: Task, name: str) -> Limits | None:
    """Limits that hold the curves of all codes, but for those that go beyond FAR times the range of the median code: nonsense of
    one code shall not hide the others. What follows a derailment is not counted. None where no code has the curve."""
    known = [(t[0], t[-1], np.nanmin(shown), np.nanmax(shown)) for _, entry, t, x in curves_of(found, task, name)
             if np.isfinite(shown := x[t <= shown_until(entry)]).any()]
    if not known:
        return None
    start, end, low, high = np.array(known, float).T
    middle = np.median(high - low)
    far = FAR*middle if middle > 0 else np.inf
    return Limits(float(max(start.min(), np.median(start) - FAR*np.median(end - start))),
                  float(min(end.max(), np.median(start) + FAR*np.median(end - start))),
                  float(max(low.min(), np.median(low) - far)), float(min(high.max(), np.median(high) + far)))


def shown_until(entry: Entry) -> float:
    """When the wheelset goes farther than between its flanges and does not come back [s], for the limits of axes; infinity where
    it does not."""
    if "Y" not in entry.curves:
        return np.inf
    t, y = entry.curves["Y"]
    inside = np.flatnonzero(np.abs(y) <= FLANGES)
    return float(t[inside[-1]]) if inside.size and inside[-1] < len(t) - 1 and abs(y[-1]) > FLANGES else np.inf


def largest_until(found: Collation, task: Task, name: str, end: float) -> float:
    """The largest force of the codes in a panel of an impact [N], but for those FAR beyond the median."""
    known = [float(np.nanmax(x[t <= end], initial=0.0)) for _, _, t, x in curves_of(found, task, name)]
    return min(max(known), FAR*float(np.median([x for x in known if x > 0] or [0.0]))) if known else 0.0


def curves_of(found: Collation, task: Task, name: str) -> list[tuple[int, Entry, np.ndarray, np.ndarray]]:
    """The place, the entry, times and values of every code that has a curve."""
    return [(k, entry, *entry.curves[name]) for k, code in enumerate(found.codes)
            if (entry := found.entry(code, task)) and name in entry.curves]


def draw(ax: Axes, found: Collation, task: Task, name: str, time_scale: float, scale: float) -> None:
    """Draw a curve of all codes."""
    curves = curves_of(found, task, name)
    for k, _, t, x in curves:
        ax.plot(time_scale*t, scale*x, **line_of(k).kwargs())
    if not curves:
        ax.text(0.5, 0.5, "no code has it", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])


def number_table(found: Collation, task: Task) -> Table:
    """The numbers of all codes, each with its distance from the median."""
    names = [name for name in names_of(task) if np.isfinite(found.median(task, name))]
    header = ["", *(NUMBERS[name].short for name in names), "checks"]
    units = ["", *(f"[{NUMBERS[name].unit}]" if NUMBERS[name].unit else "" for name in names), "passed / doubtful / failed"]
    medians = ["median", *(text(name, found.median(task, name)) for name in names), ""]
    rows: list[list[str]] = [medians, spread_row(found, task, names)]
    for code in found.codes:
        if not (entry := found.entry(code, task)):
            continue
        if entry.error:
            rows.append([code.name, *["–"]*len(names), "cannot be used"])
            continue
        counts = " / ".join(str(entry.verdict[x]) for x in ("passed", "doubtful", "failed"))
        rows.append([code.name, *(f"{text(name, x)}  {distance(found, code, task, name)}" if np.isfinite(x) else "–"
                                  for name in names for x in (found.value(code, task, name),)), counts])
    return Table("Numbers", header, rows, [1.3, *(1.25 if name in WIDE else 1.0 for name in names), 1.75], (0,), TABLE_NOTE, units)


def distance(found: Collation, code: Submission, task: Task, name: str) -> str:
    """How far a number is from the median: of errors and processor times as a factor, of others in percent."""
    value, median = found.value(code, task, name), found.median(task, name)
    if name == "energy_error":      # how far one is from no error is what counts
        return ""
    if name == "processor_time":
        return f"× {significant(value/median)}" if np.isfinite(value) and median > 0 else "–"
    if name == "rebound":           # it may be 0
        return f"{value - median:+.4f}".replace("-", "−") if np.isfinite(value) else "–"
    return signed_percent(deviation(found, code, task, name))


def spread_row(found: Collation, task: Task, names: Sequence[str]) -> list[str]:
    """The smallest and the largest of each number."""
    cells = ["smallest to largest"]
    for name in names:
        known = [x for code in found.codes if np.isfinite(x := found.value(code, task, name))]
        digits = min(NUMBERS[name].digits or 0, 2) or None
        shown = [f"{NUMBERS[name].scale*x:.0e}".replace("-", "−") if name == "energy_error" else text(name, x, digits)
                 for x in (min(known), max(known))]
        cells.append("…".join(shown))
    return cells


def finding_table(found: Collation, task: Task) -> Table:
    """What the checks found, two to a line: the first half on the left."""
    told = [[code.name, line] for code in found.codes if (entry := found.entry(code, task))
            for line in ([entry.error] if entry.error else entry.findings)]
    half = -(-len(told)//2)
    rows = [one + other for one, other in zip(told[:half], [*told[half:], ["", ""]], strict=False)]
    return Table("Findings", ["code", "what failed or is doubtful"]*2, rows, [0.15, 1, 0.15, 1], (0, 1, 2, 3))


def stacked(title: str, facts: str, tables: Iterable[Table]) -> Iterator[tuple[str, Figure]]:
    """Tables one below the other, on as few pages as hold them; a table that is longer than a page is continued."""
    page: list[Table] = []
    for part in (part for table in tables for part in table.parts()):
        if sum(one.lines for one in (*page, part)) > LINES:
            yield title, stack(title, facts, page)
            page = []
        page.append(part)
    if page:
        yield title, stack(title, facts, page)


def stack(title: str, facts: str, tables: Sequence[Table]) -> Figure:
    """A page with tables one below the other."""
    figure = new_page(capital(title), facts, "\n".join(table.note for table in tables if table.note))
    draw_tables(figure, tables)
    return figure


# ---- the document --------------------------------------------------------------------
def parts_of(pickled: bytes, tasks: Sequence[Task], target: Path) -> list[Part]:
    """The chapters of some simulations in one file; without a simulation, the matrix with the codes, and the grades."""
    found: Collation = pickle.loads(pickled)
    chapters = [(capital(task.words), chapter(found, task)) for task in tasks] or \
        [("Codes", matrix_pages(found)), ("Grades", grade_pages(found))]
    with ldbench_style():
        return [part for part in save_parts(target, chapters) if part.pages]


def make_document(found: Collation, target: Path, jobs: int | None = None) -> int:
    """Write the PDF of a collation; returns the number of its pages."""
    check_written([target], [])
    check_ending(target, "a document .pdf", ".pdf")
    pickled = pickle.dumps(found, pickle.HIGHEST_PROTOCOL)
    files = [(), *(found.tasks[k:k + 2] for k in range(0, len(found.tasks), 2))]
    with tempfile.TemporaryDirectory() as scratch, processes(jobs, len(files)) as pool:
        asked = [pool.submit(parts_of, pickled, tasks, Path(scratch)/f"{k}.pdf") for k, tasks in enumerate(files)]
        return bind([part for one in asked for part in one.result()], target, "ldbench: collation of codes")
