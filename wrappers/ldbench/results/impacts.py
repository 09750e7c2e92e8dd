"""Closed intervals of contacts: when each contact closes, for how long, with which largest force and which impulse.

Any code's file will do: rows may be coarse, cells empty, columns missing, contacts rigid. `RunData.closed` is the one rule for
when a contact is closed.
"""
from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .events import FLANGE_ANGLE
from .quantities import CONTACTS
from .run_data import LARGEST, RunData

HERTZ = 2/3         # power of the force that the approach of Hertzian bodies grows with


class Impact(NamedTuple):
    """A time in which a contact is closed, or the impact of a rigid contact, which takes no time."""

    contact: str        # 'LF', ...
    start: float        # the contact closes [s]
    end: float          # the contact opens [s]
    peak: float         # largest normal force of the rows [N]; NaN where a rigid impact has none
    t_peak: float       # time of the largest normal force [s]
    impulse: float      # integral of the normal force over the interval, and the impulses of rigid impacts [N s]
    angle: float        # contact angle at the largest normal force [rad]; NaN where the file lacks it
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


def impacts(run: RunData, contacts: Sequence[str] = CONTACTS) -> list[Impact]:
    """All impacts of some contacts in order of time.

    An impact is a set of successive closed rows between two open rows. A contact that is closed in the first or last row of the
    file is left out there, because its length is unknown, and so is a contact that also pulls. A run with rigid contacts adds
    the impacts among its events, of which the file lists a hundred.
    """
    found = [one for contact in contacts for one in closed_intervals(run, contact)]
    found += [Impact(contact, event.t, event.t, np.nan, event.t, impulse, np.nan) for event in run.events
              for contact, impulse in event.impulses.items() if contact in contacts]
    return sorted(found, key=lambda one: (one.start, CONTACTS.index(one.contact)))


def closed_intervals(run: RunData, contact: str) -> list[Impact]:
    """The intervals with a force in which a contact is closed, between two open rows."""
    return [one for one in intervals(run, contact, rigid=False) or [] if one.whole and not one.pulls]


def first_impact(run: RunData, contact: str) -> Impact | None:
    """The first of these intervals, of a flange not of its root: the contact angle, where the file has it, tells the root."""
    return next((one for one in closed_intervals(run, contact) if contact[1] == "T" or not abs(one.angle) < FLANGE_ANGLE), None)


def first_rows(run: RunData, contact: str) -> slice | None:
    """The closed rows of the first contact, of a flange not of its root; None where there is none."""
    begin = run.first_contact(contact)
    closed = np.append(run.closed(contact) & (run.time >= (np.inf if begin is None else begin - 1e-9)), False)
    if not closed.any():
        return None
    first = int(closed.argmax())
    return slice(first, first + int(closed[first:].argmin()))


def first_peak(run: RunData, contact: str) -> int | None:
    """The row of the largest normal force in the first contact, of a flange not of its root; None where there is none."""
    rows, force = first_rows(run, contact), run.normal_force(contact)
    return None if rows is None or force is None else rows.start + int(force[rows].argmax())


def intervals(run: RunData, contact: str, until: float = np.inf, rigid: bool = True) -> list[Impact] | None:
    """The intervals in which a contact is closed, in the rows up to a time [s]; None where the file has no force of it.

    With `rigid`, jumps of the column P of rigid impacts count too. A file of ours that has rows at events has them where contacts
    close and open, see `zero`.
    """
    force = run.normal_force(contact)
    jumps = run.values(f"P_{contact}") if rigid and f"P_{contact}" in run.data else None
    if force is None and jumps is None:
        return None
    rows = int(np.searchsorted(run.time, until, "right"))
    t, blows = run.time[:rows], np.zeros(rows)
    force = np.zeros(rows) if force is None else force[:rows]
    if jumps is not None and rows:
        blows[1:] = np.diff(np.clip(np.nan_to_num(jumps[:rows]), -LARGEST, LARGEST))
    angle = run.values(f"angle_{contact}") if f"angle_{contact}" in run.data else np.full(rows, np.nan)
    at_rows = run.setting("output", "rows") == "interval_and_events"
    # A jump downwards, which no impact makes, is one of rounding.
    closed = np.concatenate([[False], run.closed(contact)[:rows] | (blows > 0), [False]])
    found = []
    for first, after in np.flatnonzero(closed[1:] != closed[:-1]).reshape(-1, 2).tolist():
        own, last = slice(first, after), after - 1
        struck = bool(blows[own].any())
        begins, ends = first > 0, last < rows - 1
        start = zero(t, force, first, -1, at_rows) if begins and not struck else float(t[first])
        end = zero(t, force, last, 1, at_rows) if ends and force[last] else float(t[last])
        x = np.concatenate([[start], t[own], [end]])
        # The force does not vanish at an end that the file cuts off, nor beside a blow.
        y = np.concatenate([[force[first] if x[0] == x[1] else 0.0], force[own], [force[last] if x[-1] == x[-2] else 0.0]])
        top = first + int(force[own].argmax())
        found.append(Impact(contact, start, end, np.nan if struck else float(force[top]), float(t[top]),
                            float(np.sum(np.diff(x)*(y[1:] + y[:-1])/2) + blows[own].sum()), float(angle[top]), begins, ends,
                            bool(force[own].min() < 0)))
    return found


def zero(t: np.ndarray, force: np.ndarray, k: int, way: int, at_rows: bool = False) -> float:
    """Time [s] at which the force vanishes beside the closed row k, before it (way -1) or after it (way 1).

    A Hertzian force raised to the power 2/3 is the approach, which changes linearly near the ends of an impact. The line
    through row k and its closed neighbour is continued, at most to the open row. So rows at equal intervals give the time
    better than to their spacing. at_rows: a row stands where the force vanishes, the open row or, as its time is rounded, row k.
    """
    inside, outside = k - way, k + way
    if not 0 <= inside < len(t) or not 0 < force[k] < force[inside]:
        return float(t[outside])
    approach, deeper = force[k]**HERTZ, force[inside]**HERTZ
    found = t[k] + (t[k] - t[inside])*approach/(deeper - approach)
    if at_rows:
        return float(min(t[outside], t[k], key=lambda row: abs(row - found)))
    return float(min(found, t[outside]) if way > 0 else max(found, t[outside]))
