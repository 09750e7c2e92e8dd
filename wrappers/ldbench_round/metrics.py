"""Scores that survive impacts: docs/benchmark.md, Score, defines every number.

Two codes put an impact at slightly different times, and there a pointwise difference is as large as the force itself. So
motion is compared pointwise only while the same contacts are closed, events are matched by contact, kind and order, forces
are compared by the impulse of each impact, and nothing counts beyond the horizon.
"""
from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ldbench import Error
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData

from .horizon import horizon, spreads
from .jumps import IMPULSES, is_rigid, tells_impulses
from .scores import Score, Scores, Unmatched
from .tasks import MOTION, Task

MATCHED_BEYOND = 1.1    # times the horizon, up to which partners are looked for
MOST = 1000             # intervals of a contact that are matched, at most
LEAST = 1e-3            # share of the largest impulse of a contact's impacts below which an impact is not scored by itself
PASSAGE = "centre passage"
CROSSED = 1e-4          # share of the largest |Y| beyond which the wheelset is on one side
OF_IMPACTS = "impulse", "peak", "duration", "unmatched"         # kinds of scores


def score(run: RunData, reference: RunData, task: Task) -> Scores:
    """Score a run against a reference, by our names and in SI units; any column but the time may be missing. task: the simulation
    of both, which has a horizon and spreads. Error if a file has no times, or if the files do not overlap in time."""
    limit = horizon(task)
    # Rigid impacts of a file without their impulses are not seen, and so they cannot be matched.
    unseen = tells_impulses(reference) and not tells_impulses(run) and is_rigid(run, task)
    found = scored(run, without_impulses(reference) if unseen else reference, task, limit)
    if unseen:
        kept = tuple(one for one in found.scores if one.kind not in OF_IMPACTS)
        found = replace(found, scores=kept, unmatched=(),
                        left_out={**found.left_out, "impacts": "the file does not tell the impulses of its rigid contacts"})
    return replace(with_spreads(found, spreads(task)), rigid=(is_rigid(run, task), is_rigid(reference, task)))


def without_impulses(run: RunData) -> RunData:
    """A run without the impulses of rigid impacts."""
    other = copy.copy(run)
    other.__dict__["data"] = run.data.drop(columns=list(IMPULSES), errors="ignore")
    return other


def scored(run: RunData, reference: RunData, task: Task, limit: float) -> Scores:
    """Score a run against a reference up to a horizon [s], without spreads."""
    for one in run, reference:
        if len(one.time) < 2:
            raise Error(f"{one.file}: expected rows at two times at least, found {len(one.time)}")
    end = min(limit, float(run.time[-1]), float(reference.time[-1]))
    begin = max(float(run.time[0]), float(reference.time[0]))
    if end <= begin:
        raise Error(f"{run.file}: expected times in common with {reference.file} before the horizon {limit:.4g} s, found none")
    left_out: dict[str, str] = {}
    known: dict[str, tuple[list[ContactInterval], list[ContactInterval]]] = {}
    for contact in CONTACTS:
        mine, theirs = (one.intervals(contact, MATCHED_BEYOND*limit) for one in (run, reference))
        if mine is None or theirs is None:
            left_out[contact] = f"no force of this contact in the {'run' if mine is None else 'reference'}"
        else:
            known[contact] = mine[:MOST], theirs[:MOST]
    share = share_of_time(known.values(), begin, end) if known else np.nan
    t = np.unique(run.time)
    t = t[(t >= begin) & (t <= end)]
    same = np.ones(len(t), bool)
    for mine, theirs in known.values():
        same &= closed_at(mine, t) == closed_at(theirs, t)
    found: list[Score] = []
    for column in MOTION:
        missing = [where for where, one in (("run", run), ("reference", reference)) if column not in one.data]
        if missing:
            left_out[column] = f"no such column in the {' and the '.join(missing)}"
        else:
            found.append(motion_score(column, run, reference, t, same))
    if known:
        found.append(Score("contacts", "other contacts closed", 1 - share, end - begin, (1 - share)*(end - begin)))
    alone: list[Unmatched] = []
    for contact, (mine, theirs) in known.items():
        matched = pairs([one.start for one in theirs], [one.start for one in mine])
        found += contact_scores(contact, mine, theirs, matched, limit)
        alone += without_partner(contact, mine, theirs, matched, end)
    found += passage_scores(passages(run, MATCHED_BEYOND*limit), passages(reference, MATCHED_BEYOND*limit), limit, end, alone)
    if known:
        found.append(unmatched_score(alone, [one for _, theirs in known.values() for one in theirs], end))
    return Scores(task, limit, end, share, tuple(found), tuple(sorted(alone, key=lambda one: one.time)), left_out)


def with_spreads(scores: Scores, known: Mapping[str, Mapping[str, float]]) -> Scores:
    """The scores with the spreads of formulations beside each."""
    return replace(scores, scores=tuple(replace(one, hertz=known["hertz"].get(one.name, np.nan),
                                                rigid=known["rigid"].get(one.name, np.nan)) for one in scores.scores))


# Motion -----------------------------------------------------------------------------------

def share_of_time(known: Iterable[tuple[Sequence[ContactInterval], Sequence[ContactInterval]]], begin: float, end: float) -> float:
    """The share of the time from `begin` to `end` [s] in which both files have the same contacts closed."""
    both = list(known)
    changes = [time for pair in both for found in pair for one in found for time in (one.start, one.end)]
    t = np.clip(np.unique([*changes, begin, end]), begin, end)
    middle, steps = (t[1:] + t[:-1])/2, np.diff(t)
    same = np.ones(len(steps), bool)
    for mine, theirs in both:
        same &= closed_at(mine, middle) == closed_at(theirs, middle)
    return float(np.sum(steps[same])/np.sum(steps))


def motion_score(column: str, run: RunData, reference: RunData, t: np.ndarray, same: np.ndarray) -> Score:
    """The root mean square of the difference over that of the reference, at those times `t` of rows of the run at which the
    same contacts are closed; a time counts by how far its neighbours are."""
    mine, theirs = (np.interp(t, one.time, one.values(column)) for one in (run, reference))
    good = same & np.isfinite(mine) & np.isfinite(theirs)
    steps = np.where(good[1:] & good[:-1], np.diff(t), 0.0)
    whole = float(np.sum(steps))
    if not whole:
        return Score("motion", column, np.nan)

    def rms(x: np.ndarray) -> float:
        squares = np.where(good, x, 0.0)**2
        return float(np.sqrt(np.sum(steps*(squares[1:] + squares[:-1]))/(2*whole)))

    with np.errstate(over="ignore", invalid="ignore"):
        error, size = rms(mine - theirs), rms(theirs)
    return Score("motion", column, relative(error, 0.0, size), size, error)


def relative(value: float, expected: float, size: float | None = None) -> float:
    """|value - expected| over |expected|, or over a size; NaN where that is zero or unknown."""
    size = abs(expected) if size is None else size
    difference = abs(value - expected)
    return difference/size if np.isfinite(difference) and 0 < size < np.inf else np.nan


# Contacts ---------------------------------------------------------------------------------

def contact_scores(contact: str, mine: Sequence[ContactInterval], theirs: Sequence[ContactInterval],
                   matched: Sequence[tuple[int, int]], limit: float) -> Iterator[Score]:
    """Times at which a contact closes and opens, and the impacts: those that both files have, before the horizon."""
    largest = max((one.impulse for one in theirs if one.whole and one.end <= limit), default=0.0)
    partner = dict(matched)
    closed = opened = struck = 0
    for k, one in enumerate(theirs):
        other = mine[partner[k]] if k in partner else None
        closed, opened, struck = closed + one.begins, opened + one.ends, struck + one.whole
        if other is None or (one.whole and one.impulse < LEAST*largest):
            continue
        if one.begins and other.begins and one.start <= limit:
            yield event_score(f"{contact} closes {closed}", other.start, one.start)
        if one.ends and other.ends and one.end <= limit and one.end > one.start:
            yield event_score(f"{contact} opens {opened}", other.end, one.end)
        if one.whole and other.whole and one.end <= limit:
            for kind, value, expected in (("impulse", other.impulse, one.impulse), ("peak", other.peak, one.peak),
                                          ("duration", other.end - other.start, one.end - one.start)):
                if np.isfinite(value) and np.isfinite(expected) and expected > 0 and (kind != "duration" or value > 0):
                    yield Score(kind, f"{contact} {struck} {kind}", relative(value, expected), expected, value)


def event_score(name: str, value: float, expected: float) -> Score:
    """The difference of two times of an event over the time of the reference."""
    return Score("event", name, relative(value, expected), expected, value)


def without_partner(contact: str, mine: Sequence[ContactInterval], theirs: Sequence[ContactInterval],
                    matched: Sequence[tuple[int, int]], end: float) -> Iterator[Unmatched]:
    """The intervals that only one file has, before the end of both and the horizon."""
    for where, own, taken in (("reference", theirs, {k for k, _ in matched}), ("run", mine, {i for _, i in matched})):
        for k, one in enumerate(own):
            if k not in taken and one.end <= end:
                yield Unmatched(where, contact, one.start, one.impulse if one.whole else 0.0)


def passage_scores(mine: Sequence[float], theirs: Sequence[float], limit: float, end: float,
                   alone: list[Unmatched]) -> Iterator[Score]:
    """Passages of the centre; those without a partner are added to `alone`."""
    matched = pairs(theirs, mine)
    for k, i in matched:
        if theirs[k] <= limit:
            yield event_score(f"{PASSAGE} {k + 1}", mine[i], theirs[k])
    for where, own, taken in (("reference", theirs, {k for k, _ in matched}), ("run", mine, {i for _, i in matched})):
        alone += [Unmatched(where, PASSAGE, time, 0.0) for k, time in enumerate(own) if k not in taken and time <= end]


def unmatched_score(alone: Sequence[Unmatched], theirs: Sequence[ContactInterval], end: float) -> Score:
    """The impulse of impacts that only one file has, over the impulse of all impacts of the reference."""
    whole = sum(one.impulse for one in theirs if one.whole and one.end <= end)
    lost = sum(one.impulse for one in alone)
    difference = lost/whole if whole > 0 else 0.0 if not lost else np.inf
    return Score("unmatched", "unmatched", float(difference), float(whole), float(lost))


# Partners ---------------------------------------------------------------------------------

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
