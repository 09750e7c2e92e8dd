"""An empty page with its title and the settings of a run, and legends above panels."""
from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from .._core.errors import Error
from ..constants import MM
from ..number_text import scientific
from ..results.run_data import RunData
from .style import PAGE, SIZE, plain

EDGE = 10/25.4          # free on all sides of a page, so that every printer prints it [in]
LEFT, FOOT = EDGE/PAGE[0], EDGE/PAGE[1]     # the same as shares of the page
RIGHT, TOP = 1 - LEFT, 1 - FOOT
LINE = 1.18*SIZE/72/PAGE[1]     # height of a line of the caption
HEAD = 0.045            # height of title and subtitle
LINE_LENGTH = 190       # characters of a caption; its last line, which is short, leaves room for the number of the page


def new_page(title: str, subtitle: str = "", caption: str = "") -> Figure:
    """Make an empty page with title, subtitle and caption; what is drawn is laid out between them."""
    figure = Figure(figsize=PAGE)
    figure.text(LEFT, TOP, plain(title), fontsize=12, weight="bold", va="top")
    figure.text(RIGHT, TOP - 0.004, plain(subtitle), va="top", ha="right", color="#404040")
    lines = [part for line in caption.splitlines() for part in textwrap.wrap(line, LINE_LENGTH)]
    figure.text(LEFT, FOOT, plain("\n".join(lines)), va="bottom", color="#404040", linespacing=1.15)
    bottom = FOOT + LINE*max(len(lines), 1) + 0.006
    figure.set_layout_engine(ConstrainedLayoutEngine(rect=(LEFT, bottom, RIGHT - LEFT, TOP - HEAD - bottom), w_pad=0.05, h_pad=0.04,
                                                     wspace=0.02, hspace=0.02))
    return figure


def caption(run: RunData) -> str:
    """The settings and the profiles of a run; the file where it does not tell its settings."""
    try:
        case, results = run.case, run.results
    except Error:               # another code's file, or that of a version with other variables
        return f"{run.file}\n{profile_words(run)}".rstrip()
    cut = ""
    limits = [f"{scientific(tolerance)} {unit}" for tolerance, unit in ((case.error_tolerance, "m"), (case.energy_tolerance, "J"))
              if tolerance]
    if limits:
        cut = f" at most, cut beyond errors of {' and '.join(limits)}"
    if missed := results.get("missed"):
        cut += f" ({missed} of {results['steps']} steps still do)"
    events = {"interval": "", "interval_and_events": " and at events", "contacts": ", at events and close in contacts"}[case.rows]
    law = f"normal contact '{case.model}'; {'Newmark' if case.beta else 'explicit'}, order {case.order}"
    if run.formulation == "bilateral":
        law = "rigid contacts, both wheels held on the rails; explicit along the path, order 4"
    if run.formulation == "unilateral":
        law = f"rigid contacts that only push, restitution {case.restitution:g}; from event to event, order 4"
    settings = (
        f"ldbench {run.header.version}: {law}, step {1e6*results['step']:.3g} µs{cut}; "
        f"output every {1e3*case.interval:.3g} ms{events}; "
        f"axle {MM*results['axle_height']:.3f} mm above the rails at equilibrium; Y left, Z up")
    return f"{settings}\n{profile_words(run)}"


def profile_words(run: RunData) -> str:
    """The profiles of a run with their checksums, and which of them are reconstructions; '' where the file does not tell them."""
    two_sided = len(run.header.profiles) > 2
    profiles = "; ".join(f"{which} {Path(text).name if two_sided else text}" for which, text in run.header.profiles.items())
    if run.header.reconstruction:
        which = "some of the" if two_sided else "both"
        profiles += f"; {which} profiles are reconstructions, not the organisers' files"
    return profiles


def legend_above(ax: Axes, ncols: int = 5, raised: float = 0.0, **more: Any) -> None:
    """The legend of axes in a row above their right corner, `raised` by so many of the heights of its letters."""
    ax.legend(**{"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "ncols": ncols, "borderaxespad": 0.1 + raised,
                 "columnspacing": 0.8, "handlelength": 1.6, "handletextpad": 0.4} | more)


def legend_of_page(figure: Figure, handles: Sequence[Any], ncols: int = 5) -> None:
    """One legend for all panels of a page, in rows above them; means of bands have no words and no entry."""
    handles = [one for one in handles if not one.get_label().startswith("_")]
    figure.legend(handles=handles, loc="upper right", bbox_to_anchor=(RIGHT, TOP - 0.024), ncols=ncols, borderaxespad=0)
    layout = figure.get_layout_engine()
    assert layout
    left, bottom, width, height = layout.get()["rect"]
    layout.set(rect=(left, bottom, width, height - 0.016*(-(-len(handles)//ncols) - 1)))


def body(figure: Figure) -> tuple[float, float]:
    """Lower and upper edge of what is free on a page, for panels at places of their own."""
    layout = figure.get_layout_engine()
    assert layout
    _, bottom, _, height = layout.get()["rect"]
    figure.set_layout_engine("none")
    return bottom, bottom + height
