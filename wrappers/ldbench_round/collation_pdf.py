"""The PDF of a collation: codes and simulations, what could not be used, grades, and a chapter per simulation."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ldbench.constants import CONTACT_NAMES, KN
from ldbench.number_text import number_text, two_digits
from ldbench.plots.document import save_document
from ldbench.plots.frame import legend_of_page, new_page
from ldbench.plots.named import name as named, shows
from ldbench.plots.style import plain
from ldbench.plots.tables import draw_listing
from ldbench.results.quantities import quantity
from ldbench.tools import check_ending

from .collation import Collation
from .collation_matrix import CODES_ON_PAGE, cut, deviation, grade_pages, line_of, signed_percent, verdict_page
from .findings import times_text
from .kept_entries import CLOSE, IMPACTS, Entry
from .round_numbers import NUMBERS, names_of
from .scores import GRADED
from .submissions import FACTS, Submission
from .tasks import Task

LINES = 50              # of tables on a page
BELOW = "    "          # begins a line that belongs to the one above it
WIDE = "t_return", "energy_error", "processor_time"     # numbers whose columns need more room
FAR = 3.0               # ranges of the median code, beyond which a curve leaves its panel
FLANGES = 20e-3         # lateral displacement between the flanges, at most [m]
BEGUN = 5e-4            # within which an impact begins whose contact is told to close at 0 [s]
NUMBER_NOTE = ("below each number: how far it is from the median of all codes that have it; –: the file does not give it, and "
               "collation.csv tells why\nrebound: lateral velocity after over before the first left flange impact, reversed; below "
               "0 the wheelset still moves towards the flange")
SCORE_NOTE = (
    "difference of the worst quantity of each kind from the reference, up to the horizon; below it the share of time, events or "
    "impacts that was scored; contacts: time with other contacts closed\n"
    "(rigid): against our own run with rigid contacts; of spread: in units of what Hertz's law, bodies or rigid contacts change in "
    "our own runs; –: collation.csv tells why")
CURVES_NOTE = (
    "energy: kinetic, of weight and load, and elastic of the treads by Hertz's law, without the work of the lateral force, less "
    "that of the first row; it dips while a flange stores energy\n"
    "forces of the flanges: each code from the moment at which its contact closes; an impact of rigid contacts takes no time and "
    "has no force to show; exercise 5: the panels over time are fitted to what comes before the derailment")


# ---- tables --------------------------------------------------------------------------
class Table(NamedTuple):
    """A table, which stands on a page with others."""

    name: str
    header: list[str]
    rows: list[list[str]]
    widths: list[float]
    left: tuple[int, ...]           # columns that are set to the left
    note: str = ""                  # below the page
    second: Sequence[str] = ()      # a second line of the heading

    @property
    def lines(self) -> int:
        """The lines that it takes: name, heading, rows, and one that stays free; none without rows."""
        return len(self.rows) + 3 + bool(self.second) if self.rows else 0

    def parts(self) -> Iterator[Table]:
        """The table in pieces that fit a page; none without rows."""
        most, start = LINES - 4, 0
        while start < len(self.rows):
            end = start + most
            while start < end < len(self.rows) and self.rows[end][0].startswith(BELOW):
                end -= 1
            yield self._replace(rows=self.rows[start:end])
            start = end


def draw_tables(figure: Figure, tables: Iterable[Table], above: int = 0) -> Figure:
    """Draw tables one below the other, below so many lines of the page."""
    for table in tables:
        name = [table.name, *[""]*(len(table.header) - 1)]
        heads = [table.header, *([list(table.second)] if table.second else [])]
        draw_listing(figure, name, [*heads, *table.rows], table.widths, table.left, 1 + len(heads), above, LINES)
        above += table.lines
    return figure


def stacked(title: str, facts: str, tables: Iterable[Table]) -> Iterator[tuple[str, Figure]]:
    """Tables on as few pages as hold them; a table that is longer than a page is continued."""
    pages: list[list[Table]] = [[]]
    for part in (part for table in tables for part in table.parts()):
        if sum(one.lines for one in (*pages[-1], part)) > LINES:
            pages.append([])
        pages[-1].append(part)
    for page in pages:
        notes = "\n".join(table.note for table in page if table.note)
        yield title, draw_tables(new_page(title.capitalize(), facts, notes), page)


# ---- the codes -----------------------------------------------------------------------
def code_pages(found: Collation) -> Iterator[tuple[str, Figure]]:
    """Codes by simulations. The codes are described below if that fits, and on other pages if not."""
    told = code_table(found), remark_table(found)
    above = -(-LINES*(len(found.codes) + 1) // (CODES_ON_PAGE + 1)) + 1
    fits = above + sum(table.lines for table in told) <= LINES
    for start in range(0, len(found.codes), CODES_ON_PAGE):
        page = verdict_page(found, start)
        yield "codes and simulations", draw_tables(page, [table for table in told if table.rows], above) if fits else page
    if not fits:
        yield from stacked("the codes", f"{len(found.codes)} codes", told)


def code_table(found: Collation) -> Table:
    """What the submissions tell of the codes."""
    header = ["folder", *(key.replace("_", " ") for key in FACTS), "files"]
    rows = [[code.name, *(code.facts.get(key, "–") for key in FACTS),
             str(sum(not one.error for task in found.tasks if (one := found.entry(code, task))))] for code in found.codes]
    return Table("The codes, as submission.toml tells", header, rows, [1.2, 1.1, 0.7, 1.6, 1.4, 1.0, 1.7, 0.9, 0.7, 1.1, 1.2, 0.4],
                 tuple(range(len(header) - 1)))


def remark_table(found: Collation) -> Table:
    """What could not be used, a line each."""
    lines = [[str(k), line] for k, line in enumerate(found.lines(), 1)]
    return Table(f"What could not be used: {len(lines)} remarks", ["", "code: what, and why"], lines, [0.04, 1], (0, 1))


# ---- a chapter -----------------------------------------------------------------------
def chapter(found: Collation, task: Task) -> Iterator[tuple[str, Figure]]:
    """The pages of a simulation: curves of all codes, and the table of numbers."""
    yield "curves", curves_page(found, task)
    tables = number_table(found, task), score_table(found, task), finding_table(found, task)
    for _, figure in stacked(f"numbers, scores and findings, {task.words}", f"all codes, {task.name}", tables):
        yield "numbers, scores, findings", figure       # which is short enough for the contents


def curves_page(found: Collation, task: Task) -> Figure:
    """Motion and energy over the whole run, and the forces of the flanges from their first contacts on."""
    figure = new_page(task.words.capitalize(), f"all codes, {task.name}", CURVES_NOTE)
    grid = figure.add_gridspec(3, 2, width_ratios=(1.35, 1))
    drawn: dict[int, Line2D] = {}
    shared: Axes | None = None
    for k, (name, words, unit, scale) in enumerate((
            ("Y", "lateral Y", "mm", 1e3), ("roll", quantity("roll").words, "mrad", 1e3), ("energy", "energy − start", "J", 1.0))):
        ax = figure.add_subplot(grid[k, 0], sharex=shared)
        shared = shared or ax
        drawn |= draw(ax, found, task, name, scale, named(name, unit), "time [s]")
        if limits := common_limits(found, task, name):
            start, end, low, high = limits
            ax.set_xlim(min(start, 0), end)
            spare = 0.04*(high - low) or 1e-3/scale
            ax.set_ylim(scale*(low - spare), scale*(high + spare))
        ax.set_ylabel(f"{words} [{unit}]")
        ax.tick_params(labelbottom=k == 2)
    figure.axes[-1].set_xlabel("time [s]")
    struck = [name for name in IMPACTS if curves_of(found, task, name)]
    for k, name in enumerate(struck):
        ax = figure.add_subplot(grid[:, 1] if len(struck) == 1 else grid[:2, 1] if k == 0 else grid[2, 1])
        drawn |= draw(ax, found, task, name, KN, named(name, "kN"), f"time since {name[2:]} [ms]", 1e3)
        ax.set_title(f"normal force, {CONTACT_NAMES[name[2:]]}, first contact", loc="left", pad=3)
        ax.set_ylabel("N [kN]")
        opened = [time for _, _, t, x in curves_of(found, task, name) if np.isfinite(time := opening(t, x))]
        end = min(1.25*max(opened, default=np.inf), CLOSE[1])
        peaks = [float(np.nanmax(x[t <= end], initial=0.0)) for _, _, t, x in curves_of(found, task, name)]
        usual = FAR*float(np.median([x for x in peaks if x > 0] or [0.0]))
        ax.set_xlim(1e3*CLOSE[0], 1e3*end)
        ax.set_ylim(0, KN*1.06*(min(max(peaks), usual) or 1.0))
        ax.set_xlabel("time since the contact closed [ms]" if name == struck[-1] else "")
    legend_of_page(figure, [drawn[k] for k in sorted(drawn)], max(6, -(-len(drawn)//2)))
    return figure


def opening(t: np.ndarray, x: np.ndarray) -> float:
    """When the force of an impact that begins at 0 is gone [s]; NaN where it is never there, or never gone."""
    closed = x > 0.001*np.nanmax(x, initial=0.0)
    gone = t[(t > BEGUN) & ~closed]
    return float(gone[0]) if gone.size and closed[(t > 0) & (t <= BEGUN)].any() else np.nan


def common_limits(found: Collation, task: Task, name: str) -> tuple[float, float, float, float] | None:
    """Start, end, least and largest value, SI, that hold the curves of all codes, but for those that go beyond FAR times the range
    of the median code: nonsense of one code shall not hide the others. What follows a derailment is not counted. None where no
    code has the curve."""
    known = [(t[0], t[-1], np.nanmin(shown), np.nanmax(shown)) for _, entry, t, x in curves_of(found, task, name)
             if np.isfinite(shown := x[t <= shown_until(entry)]).any()]
    if not known:
        return None
    start, end, low, high = np.array(known, float).T
    long, middle = FAR*np.median(end - start), np.median(high - low)
    far = FAR*middle if middle > 0 else np.inf
    return (float(max(start.min(), np.median(start) - long)), float(min(end.max(), np.median(start) + long)),
            float(max(low.min(), np.median(low) - far)), float(min(high.max(), np.median(high) + far)))


def shown_until(entry: Entry) -> float:
    """When the wheelset goes farther than between its flanges and does not come back [s], for the limits of axes; infinity where
    it does not."""
    t, y = entry.curves.get("Y", (np.empty(0), np.empty(0)))
    inside = np.flatnonzero(np.abs(y) <= FLANGES)
    return float(t[inside[-1]]) if inside.size and inside[-1] < len(t) - 1 and abs(y[-1]) > FLANGES else np.inf


def curves_of(found: Collation, task: Task, name: str) -> list[tuple[int, Entry, np.ndarray, np.ndarray]]:
    """The place, the entry, times and values of every code that has a curve."""
    return [(k, entry, *entry.curves[name]) for k, code in enumerate(found.codes)
            if (entry := found.entry(code, task)) and name in entry.curves]


def draw(ax: Axes, found: Collation, task: Task, name: str, scale: float, what: str, clock: str,
         time_scale: float = 1.0) -> dict[int, Line2D]:
    """Draw a curve of all codes; the lines by the places of the codes. what, clock: the names of what the axes show."""
    curves = curves_of(found, task, name)
    letters, lines = 22 if len(found.codes) <= 12 else 11, {}
    for k, _, t, x in curves:
        code = found.codes[k].name
        lines[k], = ax.plot(time_scale*t, scale*x, label=plain(cut(code, letters)), **line_of(k).kwargs())
        shows(lines[k], what, clock, of=code)
    if not curves:
        ax.text(0.5, 0.5, "no code has it", transform=ax.transAxes, ha="center", va="center", color="#606060", fontsize=7)
        ax.set_yticks([])
    return lines


def number_table(found: Collation, task: Task) -> Table:
    """The numbers of all codes, each with its distance from the median below it."""
    names = [name for name in names_of(task) if np.isfinite(found.median(task, name))]
    header = ["", *(NUMBERS[name].short for name in names), "checks"]
    units = ["", *(f"[{NUMBERS[name].unit}]" if NUMBERS[name].unit else "" for name in names), "passed / doubtful / failed"]
    medians = ["median", *(NUMBERS[name].text(found.median(task, name)) for name in names), ""]
    rows: list[list[str]] = [medians, ["smallest to largest", *(extremes(found, task, name) for name in names)]]
    for code in found.codes:
        if not (entry := found.entry(code, task)):
            continue
        if entry.error:
            rows.append([code.name, *["–"]*len(names), "cannot be used"])
            continue
        counts = " / ".join(str(entry.verdict[x]) for x in ("passed", "doubtful", "failed"))
        values = {name: found.value(code, task, name) for name in names}
        rows += [[code.name, *(NUMBERS[name].text(x) for name, x in values.items()), counts],
                 [f"{BELOW}from the median", *(distance(found, code, task, name) if np.isfinite(x) else ""
                                               for name, x in values.items()), ""]]
    return Table("Numbers", header, rows, [1.3, *(1.25 if name in WIDE else 1.0 for name in names), 1.75], (0,), NUMBER_NOTE, units)


def distance(found: Collation, code: Submission, task: Task, name: str) -> str:
    """How far a number that is known is from the median: of processor times as a factor, of others in percent."""
    value, median = found.value(code, task, name), found.median(task, name)
    if name == "energy_error":      # how far one is from no error is what counts
        return ""
    if name == "processor_time":
        return f"× {number_text(value/median)}" if median > 0 else "–"
    if name == "rebound":           # it may be 0
        return number_text(value - median, 4, sign=True)
    return signed_percent(deviation(found, code, task, name))


def extremes(found: Collation, task: Task, name: str) -> str:
    """The smallest and the largest of a number."""
    known = [x for code in found.codes if np.isfinite(x := found.value(code, task, name))]
    digits = min(NUMBERS[name].digits or 0, 2) or None
    return "…".join(NUMBERS[name].text(x, digits) for x in (min(known), max(known)))


def score_table(found: Collation, task: Task) -> Table:
    """The scores of a simulation, two lines for each code; none without a reference."""
    rows: list[list[str]] = []
    for code in found.codes:
        if task not in found.referred or not (entry := found.entry(code, task)) or entry.error:
            continue
        differences = [f"{code.name} (rigid)" if found.against(code, task) else code.name]
        shares = [f"{BELOW}scored, of spread"]
        for one in (found.grade(code, task, kind) for kind in GRADED):
            known = not np.isnan(one.difference)
            where = one.quantity.removeprefix("angle_").removeprefix("radius_").removesuffix("other")
            differences.append(f"{two_digits(one.difference)} {where}".strip() if known else "–")
            shares.append(f"{number_text(100*one.share, digits=3, trim=True)} %, {times_text(one.of_spread)}" if known else "–")
        rows += [differences, shares]
    return Table(f"Scores, reference: {found.reference}", ["", *GRADED.values()], rows, [1.5, *[1.1]*len(GRADED)], (0,),
                 SCORE_NOTE)


def finding_table(found: Collation, task: Task) -> Table:
    """What the checks found, two to a line: the first half on the left."""
    told = [[code.name, line] for code in found.codes if (entry := found.entry(code, task))
            for line in ([entry.error] if entry.error else entry.findings)]
    half = -(-len(told)//2)
    rows = [one + other for one, other in zip(told[:half], [*told[half:], ["", ""]], strict=False)]
    return Table("Findings", ["code", "what failed or is doubtful"]*2, rows, [0.15, 1, 0.15, 1], (0, 1, 2, 3))


# ---- the document --------------------------------------------------------------------
def make_document(found: Collation, target: Path) -> int:
    """Write the PDF of a collation; returns the number of its pages."""
    check_ending(target, "a document .pdf", ".pdf")
    used = [task for task in found.tasks if any((entry := found.entry(code, task)) and not entry.error for code in found.codes)]
    chapters = [("Codes", code_pages(found)), *([("Grades", grade_pages(found))] if found.referred else []),
                *((task.words.capitalize(), chapter(found, task)) for task in used)]
    return save_document(chapters, target, "ldbench: collation of codes")
