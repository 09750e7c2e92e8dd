"""One look for every figure: colours, lines, page, units.

Left is blue, right is red; tread is dark and drawn through, flange light and dashed. The colours are those of Okabe and Ito, which
colour-blind readers tell apart, and differ in lightness for print.
"""
from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import matplotlib
from matplotlib.axis import Axis
from matplotlib.ticker import NullFormatter

from ..number_text import scientific

PAGE = 11.69, 8.27          # A4 landscape [in]
SIZE = 8.0                  # of letters [pt]

BLACK, BLUE, SKY, RED, ORANGE, GREEN, PURPLE, GREY = (
    "#000000", "#0072B2", "#56B4E9", "#D55E00", "#E69F00", "#009E73", "#CC79A7", "#7F7F7F")


@dataclass(frozen=True)
class Line:
    """The look of a line: colour, dashes, width [pt]."""
    color: str
    dashes: str | tuple[float, tuple[float, ...]] = "-"
    width: float = 0.9

    def kwargs(self) -> dict[str, Any]:
        """The look as keyword arguments of matplotlib."""
        return {"color": self.color, "linestyle": self.dashes, "linewidth": self.width}


DASHED = (0, (3.5, 0.9))
DOTTED = (0, (1.0, 1.0))
DASH_DOT = (0, (4.0, 1.0, 1.0, 1.0))

CONTACT_LINES = {"LT": Line(BLUE), "LF": Line(SKY, DASHED, 1.3), "RT": Line(RED), "RF": Line(ORANGE, DASHED, 1.3)}
SERIES = (Line(BLACK), Line(RED, DASHED), Line(BLUE, DASH_DOT), Line(GREEN, DOTTED, 1.2),
          Line(PURPLE), Line(ORANGE, DASHED), Line(SKY, DASH_DOT), Line(GREY, DASHED, 1.2))
# Codes of a round: a colour and dashes each, so that twelve are told apart, the first six by their colours alone.
CODE_LINES = tuple(Line(color, dashes, width) for dashes, width in (("-", 0.9), (DASHED, 1.1), (DOTTED, 1.2))
                   for color in (BLACK, RED, BLUE, GREEN, PURPLE, ORANGE))

RC = {
    "font.family": "DejaVu Sans",
    "font.size": SIZE,
    "axes.titlesize": SIZE,
    "axes.labelsize": SIZE,
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.useoffset": False,
    "axes.xmargin": 0.0,
    "grid.color": "#D9D9D9",
    "grid.linewidth": 0.4,
    "xtick.labelsize": SIZE,
    "ytick.labelsize": SIZE,
    "legend.fontsize": SIZE,
    "legend.framealpha": 0.85,
    "legend.edgecolor": "none",
    "legend.borderpad": 0.2,
    "legend.handlelength": 2.6,
    "pdf.fonttype": 42,
    "figure.dpi": 72,
}


_style = threading.RLock()      # matplotlib's settings are those of the process: one thread at a time changes and restores them
os.register_at_fork(before=_style.acquire, after_in_parent=_style.release, after_in_child=_style.release)


@contextmanager
def ldbench_style() -> Iterator[None]:
    """Draw with the look of ldbench within this context; other threads that draw so wait."""
    with _style, matplotlib.rc_context(RC):
        yield


def powers_of_ten(axis: Axis) -> None:
    """Numbers of a logarithmic axis over many decades, in letters of one size: small ones do not print."""
    axis.set_major_formatter(lambda x, _: scientific(x))
    axis.set_minor_formatter(NullFormatter())


def short_numbers(axis: Axis) -> None:
    """Numbers of a linear axis, each with its own power of ten where it needs one: a power beside the axis would lie over the panel
    above."""
    axis.set_major_formatter(lambda x, _: f"{x:.6g}".replace("e-0", "e-").replace("-", "−"))


def plain_numbers(axis: Axis) -> None:
    """Numbers of a logarithmic axis over few decades."""
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def plain(words: str) -> str:
    """Text of files and cases for matplotlib, which takes dollar signs for formulas and refuses half letters of odd file names."""
    return words.encode(errors="replace").decode().replace("$", r"\$")
