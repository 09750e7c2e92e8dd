"""Impacts of a run: when each contact closes, for how long, with which largest force and which impulse."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .quantities import CONTACTS
from .run_data import RunData

HERTZ = 2/3         # power of the force that the approach of Hertzian bodies grows with


class Impact(NamedTuple):
    """One closed interval of a contact, or the impact of a rigid contact, which takes no time."""

    contact: str        # 'LF', ...
    start: float        # the contact closes [s]
    end: float          # the contact opens [s]
    peak: float         # largest normal force of the rows [N]; NaN for rigid contacts
    t_peak: float       # time of the largest normal force [s]
    impulse: float      # integral of the normal force over the interval [N s]
    angle: float        # contact angle at the largest normal force [rad]; NaN where the file lacks it

    @property
    def duration(self) -> float:
        """Time between closing and opening [s]."""
        return self.end - self.start


def impacts(run: RunData, contacts: Sequence[str] = CONTACTS) -> list[Impact]:
    """All impacts of some contacts in order of time.

    An impact is a set of successive rows with a positive normal force between two open rows. A contact that is closed in
    the first or last row of the file is left out there, because its length is unknown, and so is a contact that also pulls,
    as bilateral constraints do. A run with rigid contacts adds the impacts among its events, of which the file lists a
    hundred.
    """
    found = [one for contact in contacts for one in closed_intervals(run, contact)]
    found += [Impact(contact, event.t, event.t, np.nan, event.t, impulse, np.nan) for event in run.events
              for contact, impulse in event.impulses.items() if contact in contacts]
    return sorted(found, key=lambda one: (one.start, CONTACTS.index(one.contact)))


def closed_intervals(run: RunData, contact: str, least: float = 0.0) -> Iterator[Impact]:
    """Find the intervals in which a contact is closed, between two open rows; a force up to `least` [N] counts as none."""
    if f"N_{contact}" not in run.data:
        return
    t, force = run.time, np.nan_to_num(run.values(f"N_{contact}"))
    angle = run.values(f"angle_{contact}") if f"angle_{contact}" in run.data else None
    closed = np.append(np.abs(force) > least, False)
    firsts = np.flatnonzero(closed[1:] & ~closed[:-1]) + 1
    for first in map(int, firsts):
        last = first + int(closed[first:].argmin()) - 1
        if last == len(t) - 1:
            return
        own = slice(first, last + 1)
        if force[own].min() < 0:
            continue
        start, end = zero(t, force, first, -1), zero(t, force, last, 1)
        top = first + int(force[own].argmax())
        corners = np.concatenate([[start], t[own], [end]]), np.concatenate([[0.0], force[own], [0.0]])
        impulse = float(np.sum(np.diff(corners[0])*(corners[1][1:] + corners[1][:-1]))/2)
        yield Impact(contact, start, end, float(force[top]), float(t[top]), impulse,
                     float(angle[top]) if angle is not None else np.nan)


def zero(t: np.ndarray, force: np.ndarray, k: int, way: int) -> float:
    """Time [s] at which the force vanishes beside the closed row k, before it (way -1) or after it (way 1).

    A Hertzian force raised to the power 2/3 is the approach, which changes linearly near the ends of an impact. The line
    through row k and its closed neighbour is continued, at most to the open row. So rows at equal intervals give the time
    better than to their spacing, and a row at the event itself gives the time of the event.
    """
    inside, outside = k - way, k + way
    if not 0 <= inside < len(t) or force[inside] <= force[k]:
        return float(t[outside])
    approach, deeper = force[k]**HERTZ, force[inside]**HERTZ
    found = t[k] + (t[k] - t[inside])*approach/(deeper - approach)
    return float(min(found, t[outside]) if way > 0 else max(found, t[outside]))
