"""All runs in one table."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.figure import Figure

from ..results.quantities import OUTCOME
from ..results.summary import SUMMARY
from .frame import new_page
from .style import plain


def summary_page(rows: Sequence[dict[str, Any]], note: str = "",
                 chaotic: Mapping[str, Sequence[str]] | None = None) -> Figure:
    """All runs in one table. `chaotic`: the results of each run that get a mark."""
    figure = new_page("LD benchmark: summary of all runs", "single wheelset without friction", note)
    ax = figure.add_axes((0.055, 0.10, 0.93, 0.80))
    ax.set_axis_off()
    names = [plain(str(row["case"])) for row in rows]
    cells = [[marked(OUTCOME[key].text(row.get(key)), key in (chaotic or {}).get(str(row["case"]), ())) for row in rows]
             for key in SUMMARY]
    share = 0.24
    table = ax.table(cells, rowLabels=None, colLabels=names, cellLoc="right", loc="center",
                     bbox=(share, 0.0, 1 - share, 1.0))
    labels = ax.table([[OUTCOME[key].label] for key in SUMMARY], colLabels=[""], cellLoc="left",
                      bbox=(0.0, 0.0, share, 1.0))
    for part in (table, labels):
        part.auto_set_font_size(False)
        part.set_fontsize(7)
        for (i, _), cell in part.get_celld().items():
            cell.set(linewidth=0, facecolor="#F0F0F0" if i and i % 2 == 0 else "white")
            cell.PAD = 0.03
            if i == 0:
                cell.set_text_props(weight="bold")
    return figure


def marked(words: str, chaotic: bool) -> str:
    """A number with the mark of a chaotic one."""
    return f"~{words}" if chaotic else words


CHAOTIC_NOTE = ("~: chaotic, one sample: a start one micrometre aside changes the number by more than 0.1 %, or makes it come "
                "or go.  ")
SUMMARY_NOTE = (
    "Event times and peaks of forces lie within the steps; Y, Z and Φ are those of the rows. –: did not happen.  aw: "
    "actual wheel and rail profiles, sw: simplified.\n"
    "In all plots: Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0; left blue, right "
    "red; tread dark and solid, flange light and dashed; grey: the stretch of time enlarged beside it.")
