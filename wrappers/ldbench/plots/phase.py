"""Velocity against displacement."""
from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ..results.quantities import CONTACT_NAMES, MM
from ..results.run_data import RunData
from .frame import caption, label_x, label_y, new_page
from .stretches import ENVELOPE_ROWS, first_episode
from .style import BLACK, CONTACT_LINES, GREEN, PURPLE


def phase_page(run: RunData) -> Figure:
    """Velocity against displacement of the three degrees of freedom."""
    t = run.time
    stretches: list[tuple[str, slice]] = [("whole run", slice(None))]
    if len(t) > ENVELOPE_ROWS:
        episode = first_episode(run, "LF") or (t[0], t[0])
        early = min(episode[1] + 1.0, t[-1])
        stretches = [(f"first {early:.2f} s", slice(0, np.searchsorted(t, early))),
                     ("last second", slice(np.searchsorted(t, t[-1] - 1), None))]
    figure = new_page(f"{run.heading}: phase portrait", run.header.title, caption(run))
    axes = figure.subplots(len(stretches), 3, squeeze=False, gridspec_kw={
        "left": 0.065, "right": 0.985, "top": 0.885, "bottom": 0.135, "hspace": 0.3, "wspace": 0.24})
    for row, (title, rows) in zip(axes, stretches, strict=True):
        row[0].set_title(title, loc="left", color="#404040")
        for ax, (q, v, x_label, y_label, x_scale, y_scale) in zip(row, (
                ("Y", "vY", "Y [mm]", "dY/dt [m/s]", MM, 1.0), ("Z", "vZ", "Z [mm]", "dZ/dt [m/s]", MM, 1.0),
                ("roll", "roll_rate", "Φ [mrad]", "dΦ/dt [mrad/s]", 1e3, 1e3)), strict=True):
            x, y = x_scale*run.values(q)[rows], y_scale*run.values(v)[rows]
            ax.plot(x, y, color=BLACK, linewidth=0.6)
            ax.plot(x[:1], y[:1], "o", color=GREEN, markersize=5, label="start")
            for contact, marker in (("LF", "<"), ("RF", ">")):
                first = run.first_contact(contact)
                if first is not None and t[rows][0] <= first <= t[rows][-1]:
                    k = np.searchsorted(t[rows], first)
                    ax.plot(x[k:k + 1], y[k:k + 1], marker, color=CONTACT_LINES[contact].color, markersize=6,
                            markeredgecolor=BLACK, markeredgewidth=0.4, linestyle="none",
                            label=f"{CONTACT_NAMES[contact]} first touches")
            ax.plot(x[-1:], y[-1:], "s", color=PURPLE, markersize=5, label="end")
            ax.margins(0.04)
            label_x(ax, x_label)
            label_y(ax, y_label)
        row[2].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.1, columnspacing=1.0)
    return figure
