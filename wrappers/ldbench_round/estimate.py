"""A number that was fitted to a file, with its uncertainty, or the reason why the file does not tell it."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

COVERAGE = 2.0      # standard deviations in an uncertainty


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

    def holds(self, truth: float) -> bool:
        """Whether a true number is within the uncertainty."""
        return self.known and abs(self.value - truth) <= self.uncertainty


def untold(why: str, unit: str = "") -> Estimate:
    """No number, and why."""
    return Estimate(unit=unit, why=why)


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
        return untold(why or "no value", unit)
    x, u = x[usable], np.maximum(u[usable], 1e-12*max(float(np.abs(x[usable]).max()), 1e-3))
    weight = u**-2/np.sum(u**-2)
    mean = float(weight @ x)
    spread = float(np.sqrt(weight @ (x - mean)**2))*np.sqrt(x.size/max(x.size - 1, 1))
    return Estimate(mean, float(np.hypot(min(u), spread)), unit, why)
