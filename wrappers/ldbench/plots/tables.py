"""Tables on a page: the one way in which all documents draw rows of words."""
from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ..results.quantities import OUTCOME
from ..results.summary import CHAOTIC_NOTE, SUMMARY, shown
from ..results.twins import Chaotic
from .frame import new_page
from .named import decoration, shows
from .style import SIZE, plain

CHARACTERS = 210        # of a line of a table
ROWS = 45               # of a table on a page, at most
LINES = 34              # of a page of tables with room between them
STRIPE = "#F0F0F0"

Rows = Sequence[Sequence[str]]
Look = Callable[[int, int], dict[str, Any]]     # of a cell by row and column: what matplotlib takes for a text


def draw_table(ax: Axes, rows: Rows, edges: Sequence[float] | np.ndarray, height: float | np.ndarray = 0.0, *, above: int = 0,
               left: Sequence[int] = (0,), pad: float = 0.005, size: float = 7.0,
               look: Look = lambda i, j: {"weight": "normal" if i else "bold"},
               band: Callable[[int], str] = lambda i: STRIPE if i and i % 2 == 0 else "",
               shade: Callable[[int, int], str] = lambda i, j: "") -> None:
    """Draw rows of words in axes, column j from edges[j] to edges[j + 1]; shares of the axes.

    height: of a row, or of each, by default such that the rows fill the axes. above: rows that stay free. left: columns that are
    set to the left; the others end at their right edge, `pad` before it. band: the colour behind a row; shade: behind a cell.
    """
    ax.set_axis_off()
    ax.set(xlim=(0, 1), ylim=(0, 1))
    heights = height if isinstance(height, np.ndarray) else np.full(len(rows), height or 1/(above + len(rows)))
    bottoms = 1 - above*heights[0] - np.cumsum(heights) if len(rows) else heights
    for i, row in enumerate(rows):
        y = bottoms[i] + heights[i]/2
        if colour := band(i):
            decoration(ax.axhspan(bottoms[i], bottoms[i] + heights[i], color=colour, linewidth=0))
        for j, words in enumerate(row):
            if colour := shade(i, j):
                box = Rectangle((edges[j], bottoms[i]), edges[j + 1] - edges[j], heights[i], facecolor=colour, edgecolor="white",
                                linewidth=1.5, zorder=0)
                ax.add_patch(shows(box, words, row[0], "shade", rows[0][j]))
            if words:
                x, side = (edges[j] + pad, "left") if j in left else (edges[j + 1] - pad, "right")
                ax.text(x, y, plain(words), ha=side, va="center", in_layout=False, **{"fontsize": size} | look(i, j))


def draw_listing(figure: Figure, header: Sequence[str], rows: Rows, widths: Sequence[float], left: Sequence[int], heads: int = 1,
                 above: int = 0, page: int = LINES) -> None:
    """Draw a table over a whole page below so many lines of headings, with room for so many lines `above` it.

    The columns `left` are set to the left, numbers to the right. Words below the headings are cut off where they do not fit their
    column. A line with words in the first column alone is a heading, too. page: lines of the page.
    """
    edges = np.concatenate([[0.0], np.cumsum(widths)/np.sum(widths)])
    fits = (np.diff(edges)*CHARACTERS).astype(int)
    lines = [list(header), *map(list, rows)]
    heading = [i < heads or not any(line[1:]) for i, line in enumerate(lines)]
    lines = [line if head else [word if len(word) <= n else word[:max(n - 1, 1)] + "…" for word, n in zip(line, fits, strict=False)]
             for line, head in zip(lines, heading, strict=True)]
    draw_table(figure.add_subplot(), lines, edges, 1/max(above + len(lines), page), above=above, left=left,
               look=lambda i, j: {"weight": "bold" if heading[i] else "normal"},
               band=lambda i: STRIPE if i >= heads and i % 2 == 0 else "")


def paged(title: str, subtitle: str, header: Sequence[str], rows: Rows, widths: Sequence[float], left: Sequence[int],
          note: str = "", second: Sequence[str] = ()) -> Iterator[tuple[str, Figure]]:
    """A table on as many pages as it needs; `second` is a second line of the heading."""
    for start in range(0, len(rows), ROWS):
        figure = new_page(title[0].upper() + title[1:], subtitle, note)
        draw_listing(figure, header, [*([second] if second else []), *rows[start:start + ROWS]], widths, left, 2 if second else 1)
        yield title, figure


SUMMARY_NOTE = (
    "All numbers lie within the steps, not at the rows. –: did not happen, or only in a derailment's fall.  aw: actual wheel and "
    "rail profiles, sw: simplified.  Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0.")
LEFT_OUT = "patch_LF", "patch_RF", "step", "t"      # of the page; summary.csv has them
TWO_LINES = 1.7         # height of a row with a range, of that of one without
FREE = 1.5              # digits between columns
LETTER = 0.85           # width of a letter, of that of a digit
WIDE, NARROW = "−…", ".–"       # signs of twice and half the width of a digit


def summary_page(rows: Sequence[dict[str, Any]], chaotic: Chaotic | None = None) -> Figure:
    """All runs in one table; `chaotic` results with their ranges."""
    note = "" if chaotic is None else f"{CHAOTIC_NOTE}.  "
    figure = new_page("LD benchmark: table of results", "single wheelset without friction", f"{note}{SUMMARY_NOTE}")
    keys = [key for key in SUMMARY if key not in LEFT_OUT]
    cells = [[shown(row, key, chaotic or {}) for row in rows] for key in keys]
    lines = [["", *(str(row["case"]) for row in rows)],
             *([OUTCOME[key].brief, *(f"{one.text}\n{one.range}".strip() for one in own)]
               for key, own in zip(keys, cells, strict=True))]
    heights = np.array([TWO_LINES if any("\n" in words for words in line) else 1.0 for line in lines])
    widths = [FREE + max(width_of(part) for line in lines for part in line[j].split("\n")) for j in range(len(rows) + 1)]
    widths[0] *= LETTER
    draw_table(figure.add_subplot(), lines, [0, *np.cumsum(widths)/np.sum(widths)], heights/max(heights.sum(), ROWS), pad=0.003,
               size=SIZE, look=lambda i, j: {"weight": "normal" if i else "bold", "linespacing": 0.95})
    return figure


def width_of(words: str) -> float:
    """About how wide words are, in digits."""
    return len(words) + 0.5*sum(words.count(sign) for sign in WIDE) - 0.5*sum(words.count(sign) for sign in NARROW)
