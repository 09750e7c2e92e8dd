"""Findings of a check."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

PASSED, DOUBTFUL, FAILED, UNKNOWN = "passed", "doubtful", "failed", "not checked"
SHOWN = 4       # items of a list in a hint


@dataclass(frozen=True)
class Finding:
    """One check and its outcome."""

    what: str
    verdict: str                    # 'passed', 'doubtful', 'failed', 'not checked'
    number: float = np.nan          # what was found
    limit: float = np.nan           # what was expected at most; of a count, how many
    row: int | None = None          # row of the file's numbers, from 1, where it is worst
    hint: str = ""                  # what it may come from


def judged(what: str, number: float, doubtful: float, failed: float, row: int | None = None, hint: str = "") -> Finding:
    """A finding by two limits of a number, which is best at 0."""
    verdict = FAILED if not number <= failed else DOUBTFUL if number > doubtful else PASSED
    return Finding(what, verdict, float(number), doubtful, row if verdict != PASSED else None, hint if verdict != PASSED else "")


def listed(items: Sequence[str]) -> str:
    """The first few of many items."""
    more = len(items) - SHOWN
    return ", ".join(items[:SHOWN]) + (f" and {more} more" if more > 0 else "")
