"""At which times contacts are closed, and when the wheelset passes the centre: what scores are matched by."""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.run_data import RunData

CROSSED = 1e-4          # share of the largest |Y| beyond which the wheelset is on one side


def closed_at(found: Sequence[ContactInterval], t: np.ndarray) -> np.ndarray:
    """Whether a contact is closed at times that ascend, by its intervals."""
    starts, ends = np.array([one.start for one in found]), np.array([one.end for one in found])
    k = np.searchsorted(starts, t, "right") - 1
    return (k >= 0) & (t <= ends[np.clip(k, 0, None)]) if len(found) else np.zeros(len(t), bool)


def passages(run: RunData, until: float = np.inf) -> list[float]:
    """Times [s] at which the wheelset passes the centre, between rows on either side; none without the column Y.

    A row is on a side if |Y| is above a ten thousandth of the largest |Y|, so that rounding makes no passage. A run that ends at
    the centre has its last passage there.
    """
    if "Y" not in run.data:
        return []
    good = np.isfinite(run.values("Y")) & (run.time <= until)
    t, y = run.time[good], run.values("Y")[good]
    size = np.abs(y).max(initial=0.0)
    sided = np.flatnonzero(np.abs(y) > CROSSED*size)
    if not sided.size:
        return []
    found = []
    for change in np.flatnonzero(np.diff(np.sign(y[sided]))):
        before, after = sided[change], sided[change + 1]
        k = before + int(np.argmax(y[before + 1:after + 1]*np.sign(y[after]) >= 0))
        found.append(float(t[k] + (t[k + 1] - t[k])*y[k]/(y[k] - y[k + 1])))
    if sided[-1] < len(y) - 1:
        found.append(float(t[sided[-1] + 1 + int(np.abs(y[sided[-1] + 1:]).argmin())]))
    return found


def pairs(reference: Sequence[float], other: Sequence[float]) -> list[tuple[int, int]]:
    """Match two ascending lists of times in their order.

    As many are matched as the shorter list has. Of the longer one, those are left out without which the sum of the
    differences in time is the least.
    """
    if len(reference) > len(other):
        return [(i, k) for k, i in pairs(other, reference)]
    n, more = len(reference), len(other) - len(reference)
    if not n or not more:
        return [(k, k) for k in range(n)]
    x, y = np.asarray(reference), np.asarray(other)
    # cost[s]: least sum so far when s of the longer list have been left out; skipped[i, s]: how many before number i.
    cost, skipped = np.zeros(more + 1), np.zeros((n, more + 1), int)
    for i in range(n):
        best = np.minimum.accumulate(cost)
        at = np.maximum.accumulate(np.where(cost <= best, np.arange(more + 1), 0))
        skipped[i] = at
        cost = best + np.abs(x[i] - y[i:i + more + 1])
    s, found = int(cost.argmin()), []
    for i in range(n - 1, -1, -1):
        found.append((i, i + s))
        s = int(skipped[i, s])
    return found[::-1]
