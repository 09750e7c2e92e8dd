"""The grades in the PDF of a collation: codes by simulations, and the scores of a simulation."""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ldbench.plots.frame import LEFT, RIGHT
from ldbench.results.quantities import quantity

from .collation import Collation
from .collation_pdf_matrix import new_matrix
from .collation_style import CODES_ON_PAGE, Table
from .round_grades import KINDS, Graded
from .scores import GRADES
from .submissions import Submission
from .tasks import MOTION, Task

# Shades of a difference by its grade, light enough for black words, which say the same.
SHADES: dict[float | None, str] = {GRADES[0]: "#A9D8B8", GRADES[1]: "#D9F0DF", GRADES[2]: "#FDF0C4", None: "#F9D6CF"}
UNKNOWN = "#ECECEC"
WORDS: dict[float | None, str] = {**{limit: f"grade {limit:g}" for limit in GRADES}, None: f"beyond {GRADES[-1]:g}"}
OTHERWISE = 0.1     # share of time with other contacts closed, above which the motion stands in brackets

MATRIX_NOTE = (
    "each line: median … worst relative difference from the reference up to the horizon, of the nine columns of motion while "
    "both have the same contacts\nclosed, of the times of all events, of the impulses of all impacts; shade: grade of the median; "
    "rigid: the reference is our own run with rigid contacts and that restitution\n"
    f"( ): for more than {100*OTHERWISE:.0f} % of the time other contacts are closed than in the reference, and the motion is "
    "compared in the rest alone; –: none, and collation.csv tells why")
SCORES_NOTE = (
    "differences are relative to the reference, up to the horizon; the grade is that of the median; other contacts: share of the "
    "time in which other contacts are closed than in the reference; (rigid): against our own run with rigid contacts\n"
    "of spread: the median in units of what Hertz's law or rigid contacts change in our own runs; below 1, a code differs by less "
    "than modelling does; –: collation.csv tells why")


def text(x: float) -> str:
    """A relative difference with two digits; a dash for none."""
    if np.isnan(x):
        return "–"
    if x == 0:
        return "0"
    if x >= 1000 or x < 0.00095:
        mantissa, exponent = f"{x:.1e}".split("e")
        return f"{mantissa}e{int(exponent)}".replace("-", "−")
    return f"{x:.0f}" if x >= 9.95 else f"{x:.2g}"


def shade(one: Graded) -> str:
    """The shade of a difference."""
    return UNKNOWN if np.isnan(one.difference) else SHADES[one.grade]


# ---- the matrix ----------------------------------------------------------------------
def grade_pages(found: Collation) -> Iterator[tuple[str, Figure]]:
    """Codes by simulations: grades of motion, events and impulses; none without a reference."""
    for start in range(0, len(found.codes) if found.referred else 0, CODES_ON_PAGE):
        yield "grades against the reference", grade_page(found, start)


def grade_page(found: Collation, start: int) -> Figure:
    """The rows of the matrix from one code on."""
    page = new_matrix(found, start, "Grades against the reference", f"{len(found.codes)} codes, reference: {found.reference}",
                      MATRIX_NOTE, 0.19)
    ax, first, width, height = page.ax, page.first, page.width, page.height
    draw_key(page.figure)
    band = 0.92*height/len(KINDS)
    for i, code in enumerate(page.codes):
        y = page.name_row(i, 20)
        if any(found.against(code, task) for task in found.tasks):
            ax.text(0.028, y - 0.3*height, f"rigid, restitution {code.restitution:g}", ha="left", va="center", fontsize=6,
                    color="#404040")
        for k, kind in enumerate(KINDS):
            middle = y + (1 - k)*band
            ax.text(first - 0.004, middle, kind, ha="right", va="center_baseline", fontsize=6, color="#404040")
            for j, task in enumerate(found.tasks):
                place = first + j*width + 0.0015, middle - band/2
                one = found.grade(code, task, f"score_{kind}")
                ax.add_patch(Rectangle(place, width - 0.003, band, facecolor=shade(one), linewidth=0, zorder=0))
                ax.text(place[0] + width/2, middle, words_of(found, code, task, kind), ha="center", va="center_baseline",
                        fontsize=6.3)
    return page.figure


def words_of(found: Collation, code: Submission, task: Task, kind: str) -> str:
    """The median and the worst difference, in brackets where other contacts are closed for long."""
    middle, worst = (found.grade(code, task, f"score_{kind}{ending}").difference for ending in ("", "_worst"))
    if np.isnan(middle):
        return "–"
    words = text(middle) if text(middle) == text(worst) else f"{text(middle)} … {text(worst)}"
    other = found.grade(code, task, "score_contacts").difference
    return f"({words})" if kind == "motion" and other > OTHERWISE else words


def draw_key(figure: Figure) -> None:
    """What the shades mean, above the matrix."""
    ax = figure.add_axes((LEFT, 0.908, RIGHT - LEFT, 0.02))
    ax.set_axis_off()
    for k, (limit, colour) in enumerate(SHADES.items()):
        ax.add_patch(Rectangle((0.085*k, 0), 0.082, 1, facecolor=colour, linewidth=0))
        ax.text(0.085*k + 0.041, 0.5, WORDS[limit], ha="center", va="center_baseline", fontsize=6.5)
    ax.set(xlim=(0, 1), ylim=(0, 1))


# ---- a chapter -----------------------------------------------------------------------
def score_table(found: Collation, task: Task) -> Table:
    """The scores of a simulation, a line for each code; none without a reference."""
    header, second = ["", "other contacts"], ["", "[share of time]"]
    for kind in KINDS:
        header += [kind, "", "", "", ""]
        second += ["median", "grade", "of spread", "worst", ""]
    rows = [[f"{code.name} (rigid)" if found.against(code, task) else code.name, *cells(found, code, task)] for code in found.codes
            if task in found.referred and (entry := found.entry(code, task)) and not entry.error]
    widths = [1.5, 1.2, *[0.75, 0.65, 0.85, 0.75, 1.4]*(len(KINDS) - 1), 0.85, 0.65, 0.85, 0.75, 0.7]
    return Table(f"Scores, reference: {found.reference}", header, rows, widths, (0,), SCORES_NOTE, second)


def cells(found: Collation, code: Submission, task: Task) -> Iterator[str]:
    """The cells of a code's line."""
    yield text(found.grade(code, task, "score_contacts").difference)
    for kind in KINDS:
        middle, worst = (found.grade(code, task, f"score_{kind}{ending}") for ending in ("", "_worst"))
        yield text(middle.difference)
        yield "–" if np.isnan(middle.difference) else f"> {GRADES[-1]:g}" if middle.grade is None else f"{middle.grade:g}"
        yield text(middle.of_spread)
        yield text(worst.difference)
        words = quantity(worst.name).words if worst.name in MOTION else worst.name.removesuffix(" impulse")
        yield words if worst.difference > 0 else ""
