"""Twins of a case: the same case from starts that no measurement tells from its own.

A motion with many impacts multiplies every difference. An answer that the twins do not share depends on more than anybody knows of
the start: it is chaotic, one run is one sample of it, and what can be said of it is the median and the range of the twins.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..case import Case

#: By how much the starts of the twins are moved to the left [m]: to both sides, from far below to just about what anybody measures.
TWINS: tuple[float, ...] = (1e-9, -1e-9, 1.5e-8, -1.5e-8, 2e-7, -2e-7, 3e-6, -3e-6)
#: Share of an answer by which a twin may move it.
SAME = 1e-3
#: Results that say how exact a run is, not what happens in it.
EXACTNESS = "drift", "drift_relative", "drift_reference", "t_drift", "step", "steps"


def twin_cases(case: Case) -> list[Case]:
    """The twins of a case, in the order of `TWINS`."""
    return [case.replace(initial_Y=case.initial_Y + shift) for shift in TWINS]


class Spread(NamedTuple):
    """An answer of a run and its twins [SI]: median and range of those that have it; NaN where none has."""

    median: float
    least: float
    largest: float
    having: int         # how many have it
    of: int             # the run and its twins


#: By case and name, the chaotic answers.
Chaotic = Mapping[str, Mapping[str, Spread]]


def spread_of(values: Sequence[float]) -> Spread:
    """The spread of an answer of a run and its twins; NaN stands for one that did not happen."""
    have = np.asarray(values, float)[np.isfinite(values)]
    if not have.size:
        return Spread(np.nan, np.nan, np.nan, 0, len(values))
    return Spread(float(np.median(have)), float(have.min()), float(have.max()), len(have), len(values))


def is_chaotic(name: str, value: float, twins: Sequence[float]) -> bool:
    """Whether a run and its twins do not share an answer [SI]: one differs from their median by more than SAME of it, or some have
    the answer and some lack it.

    NaN stands for an answer that did not happen. The start itself moves the farthest places by about as much as a twin is moved.
    """
    found = spread_of([value, *twins])
    apart = 2*max(TWINS) if name.startswith("farthest_") else 0.0
    farthest = max(found.largest - found.median, found.median - found.least)
    return 0 < found.having < found.of or farthest > SAME*abs(found.median) + apart


def all_spreads(row: Mapping[str, Any], twins: Sequence[Mapping[str, Any]]) -> dict[str, Spread]:
    """The spreads of all answers of a run that are numbers, by their names: of the answers of the run and of its twins, None for
    what did not happen."""
    return {name: spread_of(values) for name, values in samples(row, twins).items()}


def spreads(row: Mapping[str, Any], twins: Sequence[Mapping[str, Any]]) -> dict[str, Spread]:
    """The spreads of the chaotic answers alone."""
    return {name: spread_of(values) for name, values in samples(row, twins).items()
            if name not in EXACTNESS and is_chaotic(name, values[0], values[1:])}


def samples(row: Mapping[str, Any], twins: Sequence[Mapping[str, Any]]) -> dict[str, list[float]]:
    """The answers of a run that are numbers, by their names: its own, then those of its twins; NaN for what did not happen."""
    own = {name: [one.get(name) for one in (row, *twins)] for name in row}
    return {name: [np.nan if value is None else float(value) for value in values] for name, values in own.items()
            if not any(isinstance(value, str | bool) for value in values)}
