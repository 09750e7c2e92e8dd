"""The matrices of a collation, codes by simulations: verdicts with the main number, and grades against the reference."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.figure import Figure

from ldbench.number_text import number_text, percent_text, two_digits
from ldbench.plots.frame import new_page
from ldbench.plots.named import decoration, shows
from ldbench.plots.style import CODE_LINES, Line
from ldbench.plots.tables import draw_table

from .collation import Collation
from .round_numbers import NUMBERS, main_number
from .scores import GRADED, GRADES, Score
from .submissions import Submission
from .tasks import Task

CODES_ON_PAGE = 14
GRADED_ON_PAGE = 8      # codes, each with five lines of grades
LITTLE = 0.9            # share that was scored, below which a difference stands in brackets
MANY = 10.0             # a relative difference that is told as a factor
# Shades of a cell by its verdict, and of a difference by its grade, light enough for black words; the notes name them.
VERDICTS = {"passed": "#D9F0DF", "doubtful": "#FDF0C4", "failed": "#F9D6CF", "unusable": "#C9C9C9"}
EMPTY = "#F4F4F4"
BY_GRADE: dict[float | None, str] = {GRADES[0]: "#A9D8B8", GRADES[1]: "#D9F0DF", GRADES[2]: "#FDF0C4", None: "#F9D6CF"}
PAIRED = tuple(zip(("displacement", "velocity", "acceleration", "energy", "event"),
                   ("force", "angle", "place", "radius", "impulse"), strict=True))      # kinds side by side

VERDICT_NOTE = (
    "each cell: checks that passed / are doubtful / failed, and below the largest force of the first left flange impact (exercise "
    "5: the lateral force at derailment) [kN] with its distance from the median of all codes\n"
    "shade: green, every check passed; yellow, some are doubtful; red, some failed; grey, the file could not be used; –, not "
    "submitted or without this number")
GRADE_NOTE = (
    "relative difference from the reference up to the horizon, of the worst quantity of each kind: a column, or the events or "
    f"impulses of a contact; what has no partner counts as a difference of 1; shade: dark green, grade {GRADES[0]:g}; light green, "
    f"{GRADES[1]:g}; yellow, {GRADES[2]:g}; red, beyond\n"
    f"( ): less than {100*LITTLE:.0f} % of the time, or of the events or impacts, could be scored; rigid: the reference is our own "
    "run with rigid contacts and that restitution; –: none, and collation.csv tells why")

Cells = list[list[tuple[str, str]]]         # rows of words, each with its shade


def line_of(k: int) -> Line:
    """The look of a code's lines."""
    return CODE_LINES[k % len(CODE_LINES)]


def cut(words: str, longest: int) -> str:
    """Words that fit a place."""
    return words if len(words) <= longest else f"{words[:longest - 1]}…"


def deviation(found: Collation, code: Submission, task: Task, name: str) -> float:
    """How far a number is from the median of all codes, relative to it; NaN where one of them is not known."""
    value, median = found.value(code, task, name), found.median(task, name)
    return (value - median)/abs(median) if median else np.nan


def signed_percent(x: float) -> str:
    """A relative difference in percent with its sign, or as a factor where it is large; a dash for none."""
    return f"× {number_text(1 + x, digits=3)}" if abs(x) >= MANY and np.isfinite(x) else percent_text(x, sign=True)


def draw_matrix(found: Collation, start: int, most: int, page: Figure, cells: Sequence[Cells], name: float, labels: int) -> None:
    """Draw codes from one on, each with the same number of rows of cells. most: codes of a page; name: width of their names;
    labels: columns before those of the simulations."""
    deep, columns = len(cells[0]), (len(cells[0][0]) - labels)//len(found.tasks)
    head = [""]*(1 + labels)
    for task in found.tasks:
        head += [""]*(columns - 1) + [task.name]
    rows, shades = [head], [[""]*len(head)]
    for code, own in zip(found.codes[start:], cells, strict=False):
        rigid = any(found.against(code, task) for task in found.tasks)
        below = [f"rigid, restitution {code.restitution:g}"] if rigid and deep > 1 else []
        names = [cut(code.name, round(145*name)), *below, *[""]*deep]
        rows += [[names[k], *(words for words, _ in row)] for k, row in enumerate(own)]
        shades += [["", *(shade for _, shade in row)] for row in own]
    first = name + 0.09*labels
    edges = [0.024, *np.linspace(name, first, labels + 1)[:-1], *np.linspace(first, 1, columns*len(found.tasks) + 1)]
    height, ax = 1/(deep*max(len(cells), most) + 1), page.add_subplot()
    draw_table(ax, rows, edges, height, pad=0.004, band=lambda i: "", shade=lambda i, j: shades[i][j],
               look=lambda i, j: {"weight": "bold", "fontsize": 7.0} if not i or (j == 0 and (i - 1) % deep == 0) else
               {"fontsize": 6.0 if deep == 1 or not j else 5.2})
    for k in range(len(cells)):
        y = 1 - (1.5 + k*deep)*height
        decoration(ax.axhline(y + height/2, color="#808080", linewidth=0.5))
        look, = ax.plot([0.002, 0.022], [y, y], **line_of(start + k).kwargs() | {"linewidth": 1.6})
        shows(look, "look of a code", how="legend", of=found.codes[start + k].name)


def verdict_page(found: Collation, start: int) -> Figure:
    """Verdicts and main numbers of the codes from one on."""
    page = new_page("Codes and simulations", f"{len(found.codes)} codes", VERDICT_NOTE)
    cells = [[[verdict_cell(found, code, task) for task in found.tasks]] for code in found.codes[start:start + CODES_ON_PAGE]]
    draw_matrix(found, start, CODES_ON_PAGE, page, cells, 0.15, 0)
    return page


def verdict_cell(found: Collation, code: Submission, task: Task) -> tuple[str, str]:
    """The words of a cell, and its shade."""
    entry, name = found.entry(code, task), main_number(task)
    if entry is None:
        return "–", EMPTY
    if entry.error:
        return "cannot\nbe used", VERDICTS[entry.shade]
    counts = " / ".join(str(entry.verdict.get(verdict, 0)) for verdict in ("passed", "doubtful", "failed"))
    value = found.value(code, task, name)
    shown = NUMBERS[name].text(value, 1 if np.isfinite(value) and value*NUMBERS[name].scale < 1000 else 0)
    apart = f"\n{signed_percent(deviation(found, code, task, name))}" if np.isfinite(value) else ""
    return f"{counts}\n{shown}{apart}", VERDICTS[entry.shade]


def grade_pages(found: Collation) -> Iterator[tuple[str, Figure]]:
    """Grades of every kind."""
    for start in range(0, len(found.codes), GRADED_ON_PAGE):
        page = new_page("Grades against the reference", f"{len(found.codes)} codes, reference: {found.reference}", GRADE_NOTE)
        cells = [[[(" | ".join(GRADED[kind] for kind in kinds), ""),
                   *(grade_cell(found.grade(code, task, kind)) for task in found.tasks for kind in kinds)] for kinds in PAIRED]
                 for code in found.codes[start:start + GRADED_ON_PAGE]]
        draw_matrix(found, start, GRADED_ON_PAGE, page, cells, 0.14, 1)
        yield "grades against the reference", page


def grade_cell(one: Score) -> tuple[str, str]:
    """A difference, in brackets where little was scored, and the shade of its grade."""
    if np.isnan(one.difference):
        return "–", EMPTY
    words = two_digits(one.difference)
    return f"({words})" if one.share < LITTLE else words, BY_GRADE[one.grade]
