"""Stretches of time of a run, and curves as a printer can show them: a line, and a band where the line would turn black."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..results.answers import answers
from ..results.contact_intervals import ContactInterval
from ..results.run_data import RunData

LAST = 1.0                 # of a long run, shown by itself at the end [s]
LONG = 2.0                 # from which a run is long [s]
COLUMNS = 2000             # of a curve: 250 to the inch where it goes from edge to edge
PANEL = 800                # columns of a curve in a panel: 160 to the inch on the widest, 250 on most
BEFORE, AFTER = 0.2, 0.4   # shown before and after a contact, as shares of its length
MOST = 0.05                # of a contact that stays closed, shown after its first touch [s]
RIGID = 0.01               # shown after the impact of a rigid contact, which takes no time [s]
SWINGS = 1.5               # turns in a drawn column, from which a curve is a band there: half of what is drawn would be black
RIPPLE = 0.02              # share of the height of a curve that its turns have at least: others are as thin as the line
AROUND = 9                 # columns over which turns are counted


@dataclass(frozen=True)
class Window:
    """A stretch of time that a panel shows."""
    start: float                  # [s]
    end: float                    # [s]
    since: str = ""               # the contact from whose first touch the axis counts milliseconds, 'LF'; '' for seconds of the run
    zero: float = 0.0             # the time from which the axis counts [s]
    opens: float = np.nan         # the time at which that contact opens [s]

    @property
    def scale(self) -> float:
        """The factor from seconds to the unit of the time axis."""
        return 1e3 if self.since else 1.0

    @property
    def axis(self) -> str:
        """The label of the time axis."""
        return "time since the touch [ms]" if self.since else "time [s]"

    @property
    def clock(self) -> str:
        """The name of what the time axis shows, for `named.shows`."""
        return f"time since {self.since} [ms]" if self.since else "time [s]"

    def of(self, t: Any) -> Any:
        """A time or an array of times [s] as the axis shows them."""
        return self.scale*(t - self.zero)

    def rows(self, run: RunData) -> slice:
        """The rows inside and one more at either side."""
        return rows_between(run.time, self.start, self.end)


def rows_between(t: np.ndarray, start: float, end: float) -> slice:
    """The rows from `start` to `end` [s], and one more at either side."""
    return slice(max(np.searchsorted(t, start) - 1, 0), np.searchsorted(t, end, "right") + 1)


def whole(run: RunData, after: float | None = None) -> Window:
    """The whole run, or what of it lies before a time [s]."""
    return Window(run.time[0], run.time[-1] if after is None else after)


def last_second(run: RunData) -> Window | None:
    """The end of a long run; None of a short one."""
    t = run.time
    return Window(t[-1] - LAST, t[-1]) if t[-1] - t[0] > LONG else None


def first_contact(run: RunData, contact: str) -> Window | None:
    """The first contact of a flange and some time before and after it; None where the flange is not touched."""
    touched, first = answers(run)[f"t_first_{contact}"], run.first_interval(contact)
    rigid = run.formulation == "unilateral"
    if touched is None or not (rigid or first):
        return None
    return around(run, contact, touched, None if rigid else first)


def around(run: RunData, contact: str, touched: float, one: ContactInterval | None) -> Window:
    """The time around an interval of a contact, which counts from its first touch; `one` is None of a rigid impact."""
    t = run.time
    length = RIGID if one is None else min(max(one.end - touched, 4*(t[1] - t[0])), MOST)
    opens = np.nan if one is None or not one.ends else one.end
    return Window(max(t[0], touched - BEFORE*length), min(t[-1], touched + (1 + AFTER)*length), contact, touched, opens)


class Band(NamedTuple):
    """Columns of a curve that swings too fast for a line, (columns,) each; NaN between bands."""
    middle: np.ndarray
    low: np.ndarray
    high: np.ndarray
    mean: np.ndarray        # over time


def split(t: np.ndarray, x: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray, Band | None]:
    """A curve as it is drawn in so many columns of equal width, of about a millimetre: rows of its line, with gaps where it swings
    more than once a column, and the band from its smallest to its largest value there."""
    if len(t) < 4 or not t[-1] > t[0]:
        return t, x, None
    column = np.minimum(((t - t[0])*(columns/(t[-1] - t[0]))).astype(int), columns - 1)
    dense = is_dense(x, column, columns)
    if not dense.any():
        return *thin(t, x, PANEL), None
    starts = np.flatnonzero(np.diff(column, prepend=-1))
    there = column[starts]
    known = np.isfinite(x)
    weight = np.where(known, np.gradient(t), 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.add.reduceat(np.where(known, x, 0.0)*weight, starts)/np.add.reduceat(weight, starts)
    values = np.full((3, columns), np.nan)
    values[:, there] = np.fmin.reduceat(x, starts), np.fmax.reduceat(x, starts), mean
    values[:, ~dense] = np.nan
    middle = t[0] + (np.arange(columns) + 0.5)*(t[-1] - t[0])/columns
    # The line goes on into the outermost columns of a band, whose edge begins in the middle of these.
    inside = dense & np.append(dense[1:], True) & np.insert(dense[:-1], 0, True)
    return *thin(t, np.where(inside[column], np.nan, x), PANEL), Band(middle, *values)


def is_dense(x: np.ndarray, column: np.ndarray, columns: int) -> np.ndarray:
    """In which columns a curve makes more than one oscillation, or is known and unknown in turn, (columns,)."""
    moves = np.flatnonzero(np.nan_to_num(np.diff(x)))
    turns = moves[1:][(x[moves[1:] + 1] > x[moves[1:]]) != (x[moves[:-1] + 1] > x[moves[:-1]])]
    if turns.size:
        turns = turns[np.abs(np.diff(x[turns], append=x[turns[-1]])) > RIPPLE*(np.nanmax(x) - np.nanmin(x))]
    gaps = np.flatnonzero(np.diff(np.isnan(x)))
    count = np.bincount(column[np.concatenate([turns, gaps])], minlength=columns)
    dense = beside(count, np.mean) > SWINGS
    # No gap between bands and no band is narrower than the room over which turns are counted.
    for change in np.max, np.min, np.min, np.max:
        dense = beside(dense, change)
    return dense


def beside(x: np.ndarray, change: Callable[..., np.ndarray]) -> np.ndarray:
    """What `change`, as a mean, makes of each number and its neighbours within AROUND columns."""
    return change(np.lib.stride_tricks.sliding_window_view(np.pad(x, AROUND//2, mode="edge"), AROUND), axis=-1)


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
