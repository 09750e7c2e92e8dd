"""Stretches of time of a run: which ones a page shows, and a long one as a band."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..results.answers import answers
from ..results.run_data import RunData

ENVELOPE_ROWS = 20_000     # longer runs are drawn as bands
BINS = 400                 # of a band
COLUMNS = 2000             # of a curve: 250 to the inch where it goes from edge to edge
PANEL = 800                # columns of a curve in a panel: 160 to the inch on the widest, 250 on most
LAST = 1.0                 # of a long run, shown by itself at the end [s]


@dataclass(frozen=True)
class Window:
    """A stretch of time that a page shows."""
    title: str
    start: float                  # [s]
    end: float                    # [s]
    milliseconds: bool = False
    band: bool = False            # smallest and largest value, not the curve
    zero: float = 0.0             # the time from which the axis counts [s]

    @property
    def scale(self) -> float:
        """The factor from seconds to the unit of the time axis."""
        return 1e3 if self.milliseconds else 1.0

    @property
    def axis(self) -> str:
        """The label of the time axis."""
        return "time [ms]" if self.milliseconds else "time [s]"

    def rows(self, run: RunData) -> slice:
        """The rows inside and one more at either side."""
        return rows_between(run.time, self.start, self.end)


def rows_between(t: np.ndarray, start: float, end: float) -> slice:
    """The rows from `start` to `end` [s], and one more at either side."""
    return slice(max(np.searchsorted(t, start) - 1, 0), np.searchsorted(t, end, "right") + 1)


def is_long(run: RunData) -> bool:
    """Whether a run is drawn as bands."""
    return len(run.time) > ENVELOPE_ROWS


def overall(run: RunData) -> Window:
    """The whole run, or all but the last second of a long one."""
    t = run.time
    if is_long(run):
        return Window("up to the last second: bands from the smallest to the largest value, and the mean", t[0],
                      max(t[-1] - LAST, t[0]), band=True)
    return Window("", t[0], t[-1])


def last_second(run: RunData) -> Window:
    """The end of a long run."""
    return Window("", max(run.time[-1] - LAST, run.time[0]), run.time[-1])


def first_impact(run: RunData, contact: str = "LF") -> Window | None:
    """The first contact of a flange and some time before and after it; None where it stays open."""
    t, first = run.time, run.first_interval(contact)
    touched = answers(run)[f"t_first_{contact}"]
    if touched is not None and run.formulation == "unilateral":
        start, end = touched, touched + 0.01
    elif first:
        start, end = first.start, first.end
    else:
        return None
    length = max(end - start, 4*(t[1] - t[0]))
    return Window("", max(t[0], start - 0.6*length), min(t[-1], end + 1.2*length), milliseconds=True)


def band(t: np.ndarray, x: np.ndarray, bins: int = BINS) -> tuple[np.ndarray, ...]:
    """Bin centres, smallest, largest and mean value of x in `bins` equal numbers of rows; nan where all are nan."""
    edges = np.linspace(0, len(t), min(bins, len(t)) + 1).astype(int)[:-1]
    known = ~np.isnan(x)
    count = np.add.reduceat(known.astype(float), edges)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.add.reduceat(np.where(known, x, 0.0), edges)/count
    low, high = np.fmin.reduceat(x, edges), np.fmax.reduceat(x, edges)
    ends = np.append(edges[1:], len(t)) - 1
    return (t[edges] + t[ends])/2, low, high, mean


def thin(t: np.ndarray, x: np.ndarray, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """A curve as it is drawn in so many columns of equal width: of each the first, last, smallest and largest value, in
    their order, and the ends of gaps.  Nothing is cut off; a curve of few rows stays as it is."""
    if len(t) <= 4*columns:
        return t, x
    column = np.minimum(((t - t[0])*(columns/(t[-1] - t[0]))).astype(int), columns - 1)
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    group = np.repeat(np.arange(len(starts)), np.diff(starts, append=len(t)))
    gaps = np.flatnonzero(np.diff(np.isnan(x)))
    keep = [starts, starts - 1, gaps, gaps + 1]         # row -1 is the last one
    for extreme in np.fmin, np.fmax:
        there = np.flatnonzero(x == extreme.reduceat(x, starts)[group])
        keep.append(there[np.diff(group[there], prepend=-1) > 0])       # the first of equals
    rows = np.unique(np.concatenate(keep) % len(t))
    return t[rows], x[rows]
