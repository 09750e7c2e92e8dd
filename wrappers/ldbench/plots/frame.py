"""An empty page with its title and the settings of a run, and labels of axes."""
from __future__ import annotations

import textwrap
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from ..results.quantities import MM
from ..results.run_data import RunData
from .style import PAGE, plain
from .ticks import placed

LINE_LENGTH = 236       # characters of a caption that fit between the edges of a page


def new_page(title: str, subtitle: str = "", caption: str = "") -> Figure:
    """Make an empty page with title, subtitle and caption."""
    figure = Figure(figsize=PAGE)
    figure.text(0.055, 0.962, plain(title), fontsize=12, weight="bold", va="top")
    figure.text(0.985, 0.959, plain(subtitle), fontsize=8, va="top", ha="right", color="#404040")
    lines = [part for line in caption.splitlines() for part in textwrap.wrap(line, LINE_LENGTH)]
    figure.text(0.055, 0.014, plain("\n".join(lines)), fontsize=6.5, va="bottom", color="#404040", linespacing=1.4)
    return figure


def caption(run: RunData) -> str:
    """The settings of a run."""
    scheme = run.setting("integrator", "scheme")
    if not scheme:
        return str(run.file)
    explicit = scheme == "newmark" and not run.number("integrator", "beta")
    names = {"energy": "average acceleration with discrete gradient", "newmark": "explicit" if explicit else "Newmark"}
    order, tolerance = (run.number("integrator", name) for name in ("order", "energy_tolerance"))
    cut = f" at most, cut where it changes the energy by more than {tolerance:.0e} J" if tolerance else ""
    if run.result("missed") > 0:
        cut += f" ({run.result('missed'):.0f} of {run.result('steps'):.0f} steps still do)"
    events = " and at events" if run.setting("output", "rows") == "interval_and_events" else ""
    law = f"normal contact '{run.setting('contact', 'model')}'; {names.get(str(scheme), scheme)}, order {order:.0f}"
    if run.formulation == "bilateral":
        law = "rigid contacts, both wheels held on the rails; explicit along the path, order 4"
    if run.formulation == "unilateral":
        law = (f"rigid contacts that only push, restitution {run.number('contact', 'restitution'):g}; from event to "
               "event, order 4")
    settings = (
        f"ldbench {run.header.version}: {law}, step {1e6*run.result('step'):.3g} µs{cut}; "
        f"output every {1e3*run.number('output', 'interval'):.3g} ms{events}; "
        f"axle {MM*run.result('axle_height'):.3f} mm above the rails at equilibrium; Y left, Z up")
    two_sided = len(run.header.profiles) > 2
    profiles = "; ".join(f"{which} {Path(text).name if two_sided else text}" for which, text in run.header.profiles.items())
    if run.header.reconstruction:
        which = "some of the" if two_sided else "both"
        profiles += f"; {which} profiles are reconstructions, not the organisers' files"
    return f"{settings}\n{profiles}"


def label_x(ax: Axes, text: str, below: float = 19) -> None:
    """The label of the horizontal axis, at a fixed distance [pt]: matplotlib would measure all ticks first."""
    ax.set_xlabel(plain(text))
    ax.xaxis.set_label_coords(0.5, 0.0, ax.transAxes + ScaledTranslation(0, -below/72, ax.figure.dpi_scale_trans))
    ax.xaxis.label.set_verticalalignment("center")
    placed.add(ax.xaxis.label)


def label_y(ax: Axes, text: str, left: float = 40) -> None:
    """Write the label of the vertical axis at a fixed distance [pt]."""
    ax.set_ylabel(plain(text))
    ax.yaxis.set_label_coords(0.0, 0.5, ax.transAxes + ScaledTranslation(-left/72, 0, ax.figure.dpi_scale_trans))
    placed.add(ax.yaxis.label)
