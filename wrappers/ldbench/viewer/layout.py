"""Where the parts of a picture of runs stand: beside each other on a screen, below each other in a column of a paper."""
from __future__ import annotations

import textwrap
from typing import NamedTuple

import numpy as np

Place = tuple[float, float, float, float]       # left, bottom, width and height, as shares of the picture

SCREEN = 12.8, 7.2          # [in]
SIDE_BY_SIDE = 9.0          # least width of a picture with charts beside the scene [in]
NARROW = 4.6                # width of a column of a paper, at most [in]
TITLE, SMALL_TITLE = 13, 10     # size of the heading's letters [pt]
LETTER = 0.68               # width of a bold letter over its size
ROW = 0.19                  # of letters [in]


class Layout(NamedTuple):
    """A picture's size and places. `runs` rows of values stand above the scene and below each close-up."""

    size: tuple[float, float]       # [in]
    edge: float                     # left end of title and values
    clock: tuple[float, float]      # its upper end, and its right end; the left one where it stands below the title
    clock_below: bool
    values: float                   # upper end of the first row of values
    row: float                      # of values
    scenes: tuple[Place, Place, Place]      # the wheelset, and close-ups of left and right
    forces: float                   # upper end of the first row of forces, below the close-ups
    charts: Place
    gap: float                      # between charts, where their legends stand
    narrow: bool
    heading: str                    # of one run, in lines


def layout(runs: int, panels: int, heading: str, width: float | None = None) -> Layout:
    """The layout of a picture of so many runs and charts, as wide as that [in], or for a screen. heading: of one run."""
    if width is None or width >= SIDE_BY_SIDE:
        return side_by_side(runs, heading, SCREEN[0] if width is None else width)
    return stacked(runs, panels, heading, width)


def side_by_side(runs: int, heading: str, width: float) -> Layout:
    """Scene and close-ups on the left, charts on the right."""
    left, right, close = 0.02, 0.325, 0.295
    row = 0.028 if runs < 5 else 0.02
    header = 0.06 if runs < 3 else 0.025*np.ceil(runs/3) + 0.02
    above, height = runs*row + 0.025, 0.3 if runs < 5 else 0.26
    whole = above + height + 0.04
    scenes = ((left, whole, right + close - left, 0.99 - header - runs*row - whole), (left, above, close, height),
              (right, above, close, height))
    return Layout((width, width*SCREEN[1]/SCREEN[0]), left, (0.985, 0.975), False, 1 - header, row, scenes, runs*row + 0.015,
                  (0.675, 0.075, 0.31, 0.825), 0.065 if runs == 1 else 0.05, False, heading)


def stacked(runs: int, panels: int, heading: str, width: float) -> Layout:
    """Scene, close-ups and charts below each other; what stands where is counted from above [in]."""
    narrow, edge = width < NARROW, 0.1
    words = textwrap.fill(heading, int(72*(width - 2*edge)/(LETTER*(SMALL_TITLE if narrow else TITLE))))
    title = 0.16 + (0.24*(words.count("\n") + 1) if runs == 1 else ROW*(runs if narrow else np.ceil(runs/2)))
    values = title + 0.27
    whole = values + runs*ROW + 0.05, 0.6*width
    close = sum(whole) + 0.3, 0.36*width
    forces = sum(close) + 0.06
    gap = 0.3 if runs > 1 else 0.5 if narrow else 0.34
    charts = forces + runs*ROW + 0.1 + gap
    height = max(0.2*width, 0.95)
    bottom = charts + panels*height + (panels - 1)*gap
    total = bottom + 0.45

    def place(left: float, top: float, wide: float, high: float) -> Place:
        return left/width, 1 - (top + high)/total, wide/width, high/total

    half = (width - 3*edge)/2
    return Layout((width, total), edge/width, (edge/width, 1 - title/total), True, 1 - values/total, ROW/total,
                  (place(edge, whole[0], width - 2*edge, whole[1]), place(edge, close[0], half, close[1]),
                   place(2*edge + half, close[0], half, close[1])),
                  1 - forces/total, place(0.62, charts, width - 0.62 - 2*edge, bottom - charts), gap/total,
                  narrow, words)
