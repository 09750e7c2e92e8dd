"""All runs in one table."""
from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.figure import Figure

from ..style import plain
from .frame import KN, MM, new_page


def scaled(scale: float, digits: int) -> Callable[[float], str]:
    return lambda x: f"{scale*x:.{digits}f}"


SUMMARY_LINES: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("first contact of the left flange [s]", "t_first_LF", scaled(1, 6)),
    ("first contact of the right flange [s]", "t_first_RF", scaled(1, 6)),
    ("first passage of the centre [s]", "t_first_centre", scaled(1, 6)),
    ("return to the centre after both flanges [s]", "t_return", scaled(1, 6)),
    ("derailment [s]", "t_derailment", scaled(1, 6)),
    ("lateral force at derailment [kN]", "F_derailment", scaled(KN, 3)),
    ("Y, largest [mm]", "Y_max", scaled(MM, 4)),
    ("Y, smallest [mm]", "Y_min", scaled(MM, 4)),
    ("Z, largest [mm]", "Z_max", scaled(MM, 4)),
    ("Z, smallest [mm]", "Z_min", scaled(MM, 4)),
    ("Φ, largest [mrad]", "roll_max", scaled(1e3, 4)),
    ("Φ, smallest [mrad]", "roll_min", scaled(1e3, 4)),
    ("peak N, left tread [kN]", "N_max_LT", scaled(KN, 2)),
    ("peak N, left flange [kN]", "N_max_LF", scaled(KN, 2)),
    ("peak N, right tread [kN]", "N_max_RT", scaled(KN, 2)),
    ("peak N, right flange [kN]", "N_max_RF", scaled(KN, 2)),
    ("contacts of the left flange", "left_flange_contacts", str),
    ("contacts of the right flange", "right_flange_contacts", str),
    ("lift-offs of the left wheel", "left_lift_offs", str),
    ("lift-offs of the right wheel", "right_lift_offs", str),
    ("largest energy drift [J]", "E_drift_max", lambda x: f"{x:.1e}"),
    ("the same over initial kinetic energy or work", "E_drift_relative", lambda x: f"{x:.1e}"),
    ("time step [µs]", "dt", scaled(1e6, 0)),
    ("end of the run [s]", "t_end", scaled(1, 4)),
)


def summary_page(rows: Sequence[dict[str, Any]], note: str = "") -> Figure:
    """All runs in one table."""
    figure = new_page("LD benchmark: summary of all runs", "single wheelset without friction", note)
    ax = figure.add_axes((0.055, 0.10, 0.93, 0.80))
    ax.set_axis_off()
    names = [plain(str(row["case"])) for row in rows]
    cells = [[text if (x := row.get(key)) is not None and (text := write(x)) != "nan" else "–" for row in rows]
             for _, key, write in SUMMARY_LINES]
    share = 0.24
    table = ax.table(cells, rowLabels=None, colLabels=names, cellLoc="right", loc="center",
                     bbox=(share, 0.0, 1 - share, 1.0))
    labels = ax.table([[label] for label, _, _ in SUMMARY_LINES], colLabels=[""], cellLoc="left",
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


SUMMARY_NOTE = (
    "Event times and peaks of forces lie within the steps; Y, Z and Φ are those of the rows. –: did not happen.  aw: "
    "actual wheel and rail profiles, sw: simplified.\n"
    "In all plots: Y left, Z up, Φ lifts the left wheel; Z and Φ from static equilibrium at Y = 0; left blue, right "
    "red; tread dark and solid, flange light and dashed; grey: the stretch of time enlarged beside it.")
