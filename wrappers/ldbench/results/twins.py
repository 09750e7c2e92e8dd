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


def is_chaotic(name: str, value: float, twins: Sequence[float]) -> bool:
    """Whether the twins do not share an answer [SI]: one differs by more than SAME of it, or has it or lacks it alone.

    NaN stands for an answer that did not happen. The start itself moves the farthest places of Y by as much as a twin is moved.
    """
    apart = 2*max(TWINS) if name in ("farthest_left", "farthest_right") else 0.0
    happened = np.isfinite([value, *twins])
    if not happened.all():
        return bool(happened.any())
    return bool(np.abs(np.asarray(twins) - value).max(initial=0.0) > SAME*abs(value) + apart)


class Spread(NamedTuple):
    """A chaotic answer [SI]: median and range of those of the run and its twins that have it; NaN where none has."""

    median: float
    least: float
    largest: float
    having: int         # how many have it
    of: int             # the run and its twins


#: By case and name, the chaotic answers.
Chaotic = Mapping[str, Mapping[str, Spread]]


def spreads(row: Mapping[str, Any], twins: Sequence[Mapping[str, Any]]) -> dict[str, Spread]:
    """The chaotic answers of a run, by their names: of the answers of the run and of its twins, None for what did not happen."""
    found = {}
    for name in row.keys() - {*EXACTNESS}:
        values = [one.get(name) for one in (row, *twins)]
        if any(isinstance(value, str | bool) for value in values):
            continue
        numbers = np.array([np.nan if value is None else value for value in values], float)
        if is_chaotic(name, numbers[0], numbers[1:].tolist()):
            have = numbers[np.isfinite(numbers)]
            found[name] = Spread(float(np.median(have)), float(have.min()), float(have.max()), len(have), len(numbers))
    return {name: found[name] for name in row if name in found}
