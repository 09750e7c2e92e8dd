"""The grades in the PDF of a collation: codes by simulations, and the scores of a simulation."""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ldbench.plots.frame import LEFT, RIGHT

from .collation import Collation
from .collation_style import BELOW, CODES_ON_PAGE, Table, new_matrix
from .scores import GRADED, GRADES, Score
from .tasks import Task

# Shades of a difference by its grade, light enough for black words, which say the same.
SHADES: dict[float | None, str] = {GRADES[0]: "#A9D8B8", GRADES[1]: "#D9F0DF", GRADES[2]: "#FDF0C4", None: "#F9D6CF"}
UNKNOWN = "#ECECEC"
WORDS: dict[float | None, str] = {**{limit: f"grade {limit:g}" for limit in GRADES}, None: f"beyond {GRADES[-1]:g}"}
LEAST_ROWS = 8      # whose height a row has where there are fewer codes
LITTLE = 0.9        # share that was scored, below which a difference stands in brackets
ON_THE_LEFT = ("displacement", "velocity", "acceleration", "energy", "event")
ON_THE_RIGHT = ("force", "angle", "place", "radius", "impulse")

MATRIX_NOTE = (
    "relative difference from the reference up to the horizon, of the worst quantity of each kind: a column, or the events or "
    "impulses of a contact; shade: its grade; what has no partner counts as a difference of 1\n"
    f"( ): less than {100*LITTLE:.0f} % of the time, or of the events or impacts, could be scored; rigid: the reference is our own "
    "run with rigid contacts and that restitution; –: none, and collation.csv tells why")
SCORES_NOTE = (
    "difference of the worst quantity of each kind from the reference, up to the horizon; below it the share of time, events or "
    "impacts that was scored; contacts: time with other contacts closed\n"
    "(rigid): against our own run with rigid contacts; of spread: in units of what Hertz's law or rigid contacts change in our own "
    "runs; –: collation.csv tells why")


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


def shade(one: Score) -> str:
    """The shade of a difference."""
    return UNKNOWN if np.isnan(one.difference) else SHADES[one.grade]


# ---- the matrix ----------------------------------------------------------------------
def grade_pages(found: Collation) -> Iterator[tuple[str, Figure]]:
    """Codes by simulations: grades of every kind; none without a reference."""
    for start in range(0, len(found.codes) if found.referred else 0, CODES_ON_PAGE):
        yield "grades against the reference", grade_page(found, start)


def grade_page(found: Collation, start: int) -> Figure:
    """The rows of the matrix from one code on."""
    page = new_matrix(found, start, "Grades against the reference", f"{len(found.codes)} codes, reference: {found.reference}",
                      MATRIX_NOTE, 0.2, LEAST_ROWS)
    ax, first, width, height = page.ax, page.first, page.width, page.height
    draw_key(page.figure)
    band, half = 0.94*height/len(ON_THE_LEFT), (width - 0.003)/2
    for i, code in enumerate(page.codes):
        y = page.name_row(i, 16)
        if any(found.against(code, task) for task in found.tasks):
            ax.text(0.028, y - 0.3*height, f"rigid, restitution {code.restitution:g}", ha="left", va="center", fontsize=6,
                    color="#404040")
        for k, kinds in enumerate(zip(ON_THE_LEFT, ON_THE_RIGHT, strict=True)):
            middle = y + (2 - k)*band
            ax.text(first - 0.004, middle, " | ".join(GRADED[kind] for kind in kinds), ha="right", va="center_baseline",
                    fontsize=5.2, color="#404040")
            for j, task in enumerate(found.tasks):
                for side, kind in enumerate(kinds):
                    place = first + j*width + 0.0015 + side*half, middle - band/2
                    one = found.grade(code, task, kind)
                    ax.add_patch(Rectangle(place, half, band, facecolor=shade(one), linewidth=0.4, edgecolor="white", zorder=0))
                    ax.text(place[0] + half/2, middle, words_of(one), ha="center", va="center_baseline", fontsize=5.2)
    return page.figure


def words_of(one: Score) -> str:
    """A difference, in brackets where little was scored."""
    return f"({text(one.difference)})" if one.share < LITTLE and not np.isnan(one.difference) else text(one.difference)


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
    """The scores of a simulation, two lines for each code; none without a reference."""
    rows: list[list[str]] = []
    for code in found.codes:
        if task not in found.referred or not (entry := found.entry(code, task)) or entry.error:
            continue
        lines: list[list[str]] = [[f"{code.name} (rigid)" if found.against(code, task) else code.name],
                                  [f"{BELOW}scored, of spread"]]
        for one in (found.grade(code, task, kind) for kind in GRADED):
            known = not np.isnan(one.difference)
            quantity = one.quantity.removeprefix("angle_").removeprefix("radius_").removesuffix("other") if known else ""
            cells = (f"{text(one.difference)} {quantity}".strip() if known else "–",
                     f"{100*one.share:.3g} %, {text(one.of_spread)}" if known else "–")
            for line, cell in zip(lines, cells, strict=True):
                line.append(cell)
        rows += lines
    return Table(f"Scores, reference: {found.reference}", ["", *GRADED.values()], rows, [1.5, *[1.1]*len(GRADED)], (0,),
                 SCORES_NOTE)
