"""Findings of a check, and numbers that are fitted to a file."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ldbench.number_text import number_text, two_digits

PASSED, DOUBTFUL, FAILED, UNKNOWN = "passed", "doubtful", "failed", "not checked"
SHOWN = 4           # items of a list in a hint
MOST_DIGITS = 12    # of a number beside a limit
MANY_TIMES = 100    # a yardstick, which says no more
COVERAGE = 2.0      # standard deviations in an uncertainty


@dataclass(frozen=True)
class Finding:
    """One check and its outcome."""

    what: str
    verdict: str                    # 'passed', 'doubtful', 'failed', 'not checked'
    number: float = np.nan          # what was found
    limit: float = np.nan           # what was expected at most; of a count, how many
    row: int | None = None          # row of the file's numbers, from 1, where it is worst
    hint: str = ""                  # what it may come from
    time: float = np.nan            # of the row [s]
    items: tuple[str, ...] = ()     # all of them, where the hint has the first few of many

    def told(self, whole: bool) -> str:
        """The hint; with the whole list of its items, or with the option of `check` that gives it."""
        short = listed(self.items)
        if not self.items or short == ", ".join(self.items):
            return self.hint
        return self.hint.replace(short, "; ".join(self.items) if whole else f"{short} (-v names all)")


def judged(what: str, number: float, doubtful: float, failed: float, row: int | None = None, hint: str = "") -> Finding:
    """A finding by two limits of a number, which is best at 0."""
    verdict = FAILED if not number <= failed else DOUBTFUL if number > doubtful else PASSED
    return Finding(what, verdict, float(number), doubtful, row if verdict != PASSED else None, hint if verdict != PASSED else "")


def apart_text(x: float, limits: Sequence[float], digits: int = 3) -> str:
    """A number in so many digits, or in as many as show on which side of each limit it is: beside 'doubtful' or a grade, 0.0204
    does not read as 0.02, nor 0.00104 as 0.001."""
    while digits < MOST_DIGITS and any((float(f"{x:.{digits - 1}e}") <= limit) != (x <= limit) for limit in limits):
        digits += 1
    return number_text(x, digits=digits, trim=True)


def times_text(x: float) -> str:
    """How many times a yardstick a number is, in two digits. Beyond a hundred times and below a hundredth only that is said: so
    small a yardstick, or such a small number, measures nothing."""
    return f"> {MANY_TIMES}" if x > MANY_TIMES else f"< {1/MANY_TIMES:g}" if 0 < x < 1/MANY_TIMES else two_digits(x)


def listed(items: Sequence[str]) -> str:
    """The first few of many items."""
    more = len(items) - SHOWN
    return ", ".join(items[:SHOWN]) + (f" and {more} more" if more > 0 else "")


@dataclass(frozen=True)
class Estimate:
    """A fitted number. It is NaN, and `why` says the reason, where the file does not tell it."""

    value: float = np.nan
    uncertainty: float = np.nan     # to either side, two standard deviations
    unit: str = ""                  # SI; '' for a number without unit
    why: str = ""                   # why there is no number, or what it rests upon

    @property
    def known(self) -> bool:
        """Whether the file tells the number."""
        return bool(np.isfinite(self.value))

    @property
    def none(self) -> bool:
        """Whether the number may be zero: words of nothing may stand beside it."""
        return self.holds(0.0)

    def holds(self, truth: float) -> bool:
        """Whether a true number is within the uncertainty."""
        return self.known and abs(self.value - truth) <= self.uncertainty


def combined(values: Sequence[float], uncertainties: Sequence[float], unit: str = "", why: str = "",
             floor: float = 0.0) -> Estimate:
    """One number from several of equal meaning.

    Values count by their own uncertainties, but none for more than `floor` allows. If they differ by more than these
    explain, the spread widens the result, and it is not divided by the number of values: what makes them differ is the
    same in all blows.
    """
    x, u = np.asarray(values, float), np.hypot(np.asarray(uncertainties, float), floor)
    usable = np.isfinite(x) & np.isfinite(u)
    if not usable.any():
        return Estimate(unit=unit, why=why or "no value")
    x, u = x[usable], np.maximum(u[usable], 1e-12*max(float(np.abs(x[usable]).max()), 1e-3))
    weight = u**-2/np.sum(u**-2)
    mean = float(weight @ x)
    spread = float(np.sqrt(weight @ (x - mean)**2))*np.sqrt(x.size/max(x.size - 1, 1))
    return Estimate(mean, float(np.hypot(min(u), spread)), unit, why)
