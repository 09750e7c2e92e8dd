"""Times of rows that were written with few digits: many rows have the same, or fall back by the rounding."""
from __future__ import annotations

from dataclasses import replace

import numpy as np

from ldbench.results.columns import UNITS, RawTable

from .column_names import meanings

MOST_DIGITS = 12
MOSTLY = 0.5        # share of the times that have no further digits
TIED = 0.5          # share of different times below which rows of equal times differ by rounding


def rounding_of(t: np.ndarray) -> float:
    """The last digit that most of some times have, as 0.001; 0 where they have more digits than are counted."""
    size = max(float(np.max(np.abs(t), initial=0.0)), 1e-300)
    for digits in range(MOST_DIGITS):
        step = 10.0**-digits
        if np.mean(np.abs(t/step - np.round(t/step)) < 1e-9*size/step + 1e-6) >= MOSTLY:
            return step
    return 0.0


def spread_times(raw: RawTable) -> tuple[RawTable, float, str]:
    """A table whose rows have times of their own, by what these may be wrong [s], and what was done, in words; 0 and '' where
    nothing was.

    Rows of equal times that differ otherwise were one after the other: the time goes evenly from row to row through the middle of
    each group. A time that falls back by no more than the last digit is that of the row before.
    """
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True)):
        t = raw.numbers[:, k]
        if "time" not in meanings(name) or t.size < 3 or not np.isfinite(t).all():
            continue
        step, fall = rounding_of(t), float(-np.diff(t).min(initial=0.0))
        tied = np.unique(t).size < TIED*len(np.unique(raw.numbers, axis=0)) if fall <= 0 else True
        if not tied or not 0 < step or fall > 1.0001*step or t[-1] <= t[0]:
            return raw, 0.0, ""
        level = np.maximum.accumulate(t)
        first = np.flatnonzero(np.concatenate([[True], np.diff(level) > 0]))
        last = np.concatenate([first[1:], [t.size]]) - 1
        at, value = (first + last)/2, level[first]
        at[0], at[-1] = 0, t.size - 1
        numbers = raw.numbers.copy()
        numbers[:, k] = np.interp(np.arange(t.size), at, value)
        what = f"{t.size - first.size} of {t.size} rows have the time of the row before" + (
            f", or an earlier one by up to {fall:.3g} {said or 's'}" if fall > 0 else "")
        factor = UNITS[said][1] if UNITS.get(said, ("",))[0] == "s" else 1.0
        return (replace(raw, numbers=numbers), factor*float(np.max(np.abs(numbers[:, k] - t))),
                f"times have steps of {step:g} {said or 's'}: {what}; rows are taken to be evenly apart")
    return raw, 0.0, ""
