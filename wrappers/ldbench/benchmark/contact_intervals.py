"""When the contacts of a run are closed, and when the wheelset passes the centre: what scores are matched by.

Any code's file will do: rows may be coarse, cells empty, columns missing, contacts rigid.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..results.impacts import zero
from ..results.run_data import RunData

# A contact with a larger force is closed [N]. The smallest weight on a wheel is near 1e5 N. In a row of ours at which a contact
# closes or opens, rounding of the time leaves some tenths of a newton. A contact of steel that opens has 1 N for 0.2 us at most.
CLOSED = 1.0
LARGEST = 1e30          # force of a file that is taken as it stands; integrals of larger ones overflow [N]
CROSSED = 1e-4          # share of the largest |Y| beyond which the wheelset is on one side


@dataclass(frozen=True)
class Interval:
    """A time in which a contact is closed; the impact of a rigid contact takes no time."""

    contact: str        # 'LF', ...
    start: float        # [s]
    end: float          # [s]
    begins: bool        # False: it is closed in the first row of the file
    ends: bool          # False: it is closed in the last row that was read
    impulse: float      # integral of the normal force, and the impulses of rigid impacts [N s]
    peak: float         # largest normal force of the rows [N]; NaN where a rigid impact has none

    @property
    def whole(self) -> bool:
        """Whether the file shows both ends."""
        return self.begins and self.ends


def normal_force(run: RunData, contact: str) -> np.ndarray | None:
    """The normal force of a contact, (rows,) [N], 0 in empty cells; of a file without it, that of its components; None
    without these."""
    if f"N_{contact}" in run.data:
        force = run.values(f"N_{contact}")
    else:
        parts = [run.values(f"{name}_{contact}") for name in ("Fy", "Fz") if f"{name}_{contact}" in run.data]
        if not parts:
            return None
        with np.errstate(over="ignore"):
            force = np.hypot(parts[0], parts[-1]) if len(parts) == 2 else np.abs(parts[0])
    return np.clip(np.nan_to_num(np.asarray(force, float), nan=0.0, posinf=0.0, neginf=0.0), -LARGEST, LARGEST)


def intervals(run: RunData, contact: str, until: float = np.inf) -> list[Interval] | None:
    """The intervals in which a contact is closed, in the rows up to a time [s]; None where the file has no force of it.

    A contact is closed in rows with a force above CLOSED, or with a jump of the column P of rigid impacts. A file of ours that
    has rows at events has them where contacts close and open. In other files these times are found as
    those of impacts: the force to the power 2/3 is continued linearly, at most to the open row.
    """
    force = normal_force(run, contact)
    jumps = run.values(f"P_{contact}") if f"P_{contact}" in run.data else None
    if force is None:
        if jumps is None:
            return None
        force = np.zeros(len(jumps))
    rows = int(np.searchsorted(run.time, until, "right"))
    t, force = run.time[:rows], force[:rows]
    blows = np.zeros(rows)
    if jumps is not None and rows:
        blows[1:] = np.diff(np.clip(np.nan_to_num(jumps[:rows]), -LARGEST, LARGEST))
    at_rows = run.setting("output", "rows") == "interval_and_events"
    # A jump downwards, which no impact makes, is one of rounding.
    closed = np.concatenate([[False], (np.abs(force) > CLOSED) | (blows > 0), [False]])
    edges = np.flatnonzero(closed[1:] != closed[:-1])
    return [interval(contact, t, force, blows, int(first), int(after) - 1, at_rows)
            for first, after in zip(edges[::2], edges[1::2], strict=True)]


def interval(contact: str, t: np.ndarray, force: np.ndarray, blows: np.ndarray, first: int, last: int, at_rows: bool) -> Interval:
    """The interval of the closed rows from `first` to `last`; at_rows: it begins and ends at the open rows beside them."""
    own = slice(first, last + 1)
    struck = bool(blows[own].any())
    begins, ends = first > 0, last < len(t) - 1
    start, end = float(t[first]), float(t[last])
    if begins and not struck:
        start = float(t[first - 1]) if at_rows else zero(t, force, first, -1)
    if ends and force[last]:
        end = float(t[last + 1]) if at_rows else zero(t, force, last, 1)
    x = np.concatenate([[start], t[own], [end]])
    # The force does not vanish at an end that the file cuts off, nor beside a blow.
    y = np.concatenate([[force[first] if x[0] == x[1] else 0.0], force[own], [force[last] if x[-1] == x[-2] else 0.0]])
    impulse = float(np.sum(np.diff(x)*(y[1:] + y[:-1])/2) + blows[own].sum())
    return Interval(contact, start, end, begins, ends, impulse, np.nan if struck else float(force[own].max()))


def closed_at(found: Sequence[Interval], t: np.ndarray) -> np.ndarray:
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
