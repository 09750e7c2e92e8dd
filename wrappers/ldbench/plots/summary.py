"""All runs in one table."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..results.quantities import OUTCOME
from ..results.summary import SUMMARY, Chaotic, shown
from .frame import new_page
from .tables import draw_table


def summary_page(rows: Sequence[dict[str, Any]], note: str = "",
                 chaotic: Chaotic | None = None) -> Figure:
    """All runs in one table, `chaotic` results in italics."""
    figure = new_page("LD benchmark: summary of all runs", "single wheelset without friction", note)
    cells = [[shown(row, key, chaotic or {}) for row in rows] for key in SUMMARY]
    lines = [["", *(str(row["case"]) for row in rows)],
             *([OUTCOME[key].label, *(words for words, _ in own)] for key, own in zip(SUMMARY, cells, strict=True))]
    draw_table(figure, (0.055, 0.10, 0.93, 0.80), lines, [0, *np.linspace(0.24, 1, max(len(rows), 1) + 1)], pad=0.003,
               look=lambda i, j: {"weight": "normal" if i else "bold",
                                  "style": "italic" if i and j and cells[i - 1][j - 1][1] else "normal"})
    return figure


SUMMARY_NOTE = (
    "Event times and peaks of forces lie within the steps; Y, Z and Φ are those of the rows. –: did not happen.  aw: "
    "actual wheel and rail profiles, sw: simplified.\n"
    "In all plots: Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0; left blue, right "
    "red; tread dark and solid, flange light and dashed; dotted in panels over time: events.")
