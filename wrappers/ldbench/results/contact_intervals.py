"""When a contact is closed, and each time in which it is: start, end, largest force, impulse.

`RunData.intervals`, `RunData.impacts` and `RunData.first_interval` find these times in a run. Any code's file will do: rows may
be coarse, cells empty, columns missing, contacts rigid.
"""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .events import FLANGE_ANGLE

# A contact with a larger force is closed, in every file [N]. The smallest weight on a wheel is near 1e5 N, and a contact of steel
# that opens has 1 N for 0.2 us at most. Rows of other codes have residues of iterations, and rows of ours at which a contact closes
# or opens have a small force, because their times are rounded: a limit of zero joins contacts that are apart.
CLOSED = 1.0
LARGEST = 1e30          # force of a file that is taken as it stands; integrals of larger ones overflow [N]
HERTZ = 2/3             # power of the force that the approach of Hertzian bodies grows with


def is_closed(force: Any) -> Any:
    """Whether a contact with a normal force of either sign is closed, one force or an array of them [N]."""
    return np.abs(force) > CLOSED


class ContactInterval(NamedTuple):
    """A time in which a contact is closed, or the impact of a rigid contact, which takes no time."""

    contact: str        # 'LF', ...
    start: float        # the contact closes [s]
    end: float          # the contact opens [s]
    peak: float         # largest normal force of the rows [N]; NaN where a rigid impact has none
    t_peak: float       # time of the largest normal force [s]
    impulse: float      # integral of the normal force over the interval, and the impulses of rigid impacts [N s]
    angle: float        # contact angle at the largest normal force [rad]; NaN where the file lacks it
    rows: slice = slice(0, 0)       # in which the contact is closed; none of the impact of a rigid contact
    top: int = 0                    # row of the largest normal force
    begins: bool = True     # False: the contact is closed in the first row of the file
    ends: bool = True       # False: the contact is closed in the last row that was read
    pulls: bool = False     # whether the rail also pulls, as bilateral constraints do

    @property
    def duration(self) -> float:
        """Time between closing and opening [s]."""
        return self.end - self.start

    @property
    def whole(self) -> bool:
        """Whether the file shows both ends."""
        return self.begins and self.ends

    @property
    def is_impact(self) -> bool:
        """Whether the contact opens again without a pull: its length is known."""
        return self.whole and not self.pulls

    @property
    def at_root(self) -> bool:
        """Whether it is a contact of a flange's root, which the contact angle tells, where that is known."""
        return bool(self.contact[1] == "F" and abs(self.angle) < FLANGE_ANGLE)


def find_intervals(contact: str, t: np.ndarray, force: np.ndarray, blows: np.ndarray, angle: np.ndarray,
                   at_rows: bool = False) -> list[ContactInterval]:
    """The intervals in which a contact is closed, in rows at times t [s] with normal force [N], impulse of rigid impacts since the
    row before [N s] and contact angle [rad], (rows,) each. at_rows: see `zero`."""
    # A jump downwards, which no impact makes, is one of rounding.
    closed = np.concatenate([[False], is_closed(force) | (blows > 0), [False]])
    # A contact that begins to pull does not open where its force vanishes.
    closed[2:-2] |= closed[1:-3] & closed[3:-1] & (force[:-2]*force[2:] < 0)
    found = []
    for first, after in np.flatnonzero(closed[1:] != closed[:-1]).reshape(-1, 2).tolist():
        own, last = slice(first, after), after - 1
        struck = bool(blows[own].any())
        begins, ends = first > 0, last < len(t) - 1
        start = zero(t, force, first, -1, at_rows) if begins and not struck else float(t[first])
        end = zero(t, force, last, 1, at_rows) if ends and force[last] else float(t[last])
        x = np.concatenate([[start], t[own], [end]])
        # The force does not vanish at an end that the file cuts off, nor beside a blow.
        y = np.concatenate([[force[first] if x[0] == x[1] else 0.0], force[own], [force[last] if x[-1] == x[-2] else 0.0]])
        top = first + int(force[own].argmax())
        found.append(ContactInterval(
            contact, start, end, np.nan if struck else float(force[top]), float(t[top]),
            float(np.sum(np.diff(x)*(y[1:] + y[:-1])/2) + blows[own].sum()), float(angle[top]), own, top, begins, ends,
            bool(force[own].min() < 0)))
    return found


def zero(t: np.ndarray, force: np.ndarray, k: int, way: int, at_rows: bool = False) -> float:
    """Time [s] at which the force vanishes beside the closed row k, before it (way -1) or after it (way 1).

    A Hertzian force raised to the power 2/3 is the approach, which changes linearly near the ends of an impact. The line
    through row k and its closed neighbour is continued, at most to the open row. So rows at equal intervals give the time
    better than to their spacing. Where the force does not grow inwards, it is the middle of both rows. at_rows: a row stands where
    the force vanishes, the open row or, as its time is rounded, row k.
    """
    inside, outside = k - way, k + way
    if not 0 <= inside < len(t) or not 0 < force[k] < force[inside]:
        return float(t[outside] if at_rows else (t[k] + t[outside])/2)
    approach, deeper = force[k]**HERTZ, force[inside]**HERTZ
    found = t[k] + (t[k] - t[inside])*approach/(deeper - approach)
    if at_rows:
        return float(min(t[outside], t[k], key=lambda row: abs(row - found)))
    return float(min(found, t[outside]) if way > 0 else max(found, t[outside]))
