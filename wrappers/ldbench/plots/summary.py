"""All runs in one table."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from ..results.quantities import OUTCOME
from ..results.summary import SUMMARY, Chaotic, shown
from .frame import new_page
from .style import plain


def summary_page(rows: Sequence[dict[str, Any]], note: str = "",
                 chaotic: Chaotic | None = None) -> Figure:
    """All runs in one table, `chaotic` results in italics."""
    figure = new_page("LD benchmark: summary of all runs", "single wheelset without friction", note)
    ax = figure.add_axes((0.055, 0.10, 0.93, 0.80))
    ax.set_axis_off()
    names = [plain(str(row["case"])) for row in rows]
    cells = [[shown(row, key, chaotic or {}) for row in rows] for key in SUMMARY]
    share, height = 0.24, 1/(len(SUMMARY) + 1)
    width = (1 - share)/max(len(names), 1)
    for k, name in enumerate(names):
        ax.text(share + width*(k + 1) - 0.003, 1 - height/2, name, ha="right", va="center", fontsize=7, weight="bold")
    for i, (key, row) in enumerate(zip(SUMMARY, cells, strict=True), 1):
        y = 1 - height*(i + 0.5)
        if i % 2 == 0:
            ax.axhspan(y - height/2, y + height/2, color="#F0F0F0", linewidth=0)
        ax.text(0.003, y, OUTCOME[key].label, ha="left", va="center", fontsize=7)
        for k, (words, leaning) in enumerate(row):
            ax.text(share + width*(k + 1) - 0.003, y, words, ha="right", va="center", fontsize=7,
                    style="italic" if leaning else "normal")
    ax.set(xlim=(0, 1), ylim=(0, 1))
    return figure


SUMMARY_NOTE = (
    "Event times and peaks of forces lie within the steps; Y, Z and Φ are those of the rows. –: did not happen.  aw: "
    "actual wheel and rail profiles, sw: simplified.\n"
    "In all plots: Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0; left blue, right "
    "red; tread dark and solid, flange light and dashed; dotted in panels over time: events.")
