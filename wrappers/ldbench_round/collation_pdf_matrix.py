"""The frame of a page of a collation that has a row for every code and a column for every simulation."""
from __future__ import annotations

from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ldbench.plots.frame import new_page
from ldbench.plots.style import plain
from ldbench.results.quantities import PAIRS

from .collation import Collation
from .collation_style import CODES_ON_PAGE, cut, line_of
from .submissions import Submission


@dataclass(frozen=True)
class Matrix:
    """A page with the heads of its columns."""

    figure: Figure
    ax: Axes                        # from 0 to 1 in both directions
    codes: tuple[Submission, ...]   # one for every row
    start: int                      # place of the first of them among all codes
    first: float                    # where the first column begins
    width: float                    # of a column
    height: float                   # of a row

    def name_row(self, i: int, longest: int) -> float:
        """Draw line and name of a code, cut to its `longest` characters; returns the middle of the row."""
        y = 1 - (i + 1.5)*self.height
        self.ax.plot([0.002, 0.022], [y, y], **line_of(self.start + i).kwargs() | {"linewidth": 1.6})
        self.ax.text(0.028, y, plain(cut(self.codes[i].name, longest)), ha="left", va="center", fontsize=7.5, weight="bold")
        return y


def new_matrix(found: Collation, start: int, title: str, facts: str, note: str, first: float,
               least: int) -> Matrix:
    """A page with rows for the codes from one on. facts: beside the title; note: below the matrix; least: rows of a page."""
    codes = found.codes[start:start + CODES_ON_PAGE]
    figure = new_page(title, facts, note)
    ax = figure.add_subplot()
    ax.set_axis_off()
    ax.set(xlim=(0, 1), ylim=(0, 1))
    width, height = (1 - first)/len(found.tasks), 1/(max(len(codes), least) + 1)
    for j, task in enumerate(found.tasks):
        ax.text(first + (j + 0.5)*width, 1 - 0.5*height, f"exercise {task.exercise}\n{PAIRS[task.profiles].split()[0]}",
                ha="center", va="center", fontsize=7, weight="bold")
    return Matrix(figure, ax, codes, start, first, width, height)
