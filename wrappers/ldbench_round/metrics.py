"""Scores that survive impacts: docs/organiser.md, Score, defines every number.

Two codes put an impact at slightly different times, and there a pointwise difference is as large as the force itself.
"""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from ldbench import Error
from ldbench.constants import CONTACTS
from ldbench.results.answers import passages
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.run_data import RunData

from .cell_checks import missing_forces
from .energies import SUMS, told
from .jumps import IMPULSES, is_rigid, tells_impulses
from .own_runs import LAWS, horizon, yardsticks
from .scores import OVER_TIME, Score, Scores, Unmatched
from .tasks import MOTION, Task

MATCHED_BEYOND = 1.1    # times the horizon, up to which partners are looked for
MOST = 1000             # intervals of a contact that are matched, at most
LEAST = 1e-3            # share of the largest impulse of a contact's impacts below which an impact is not scored by itself
PASSAGE = "centre passage"
WHOLE = 0.9             # share of the reference's time from which a file is whole: simulations end when the wheelset returns
FORCES = OVER_TIME["force"]
OF_IMPACTS = "impulse", "peak", "duration"        # kinds of scores


def score(run: RunData, reference: RunData, task: Task) -> Scores:
    """Score a run against a reference, by our names and in SI units; any column but the time may be missing. task: the simulation
    of both, which has a horizon and spreads. Error if a file has no times, or if the files do not overlap in time."""
    limit = horizon(task)
    # Rigid impacts of a file without their impulses are not seen, and so they cannot be matched.
    unseen = tells_impulses(reference) and not tells_impulses(run) and is_rigid(run, task)
    compared = reference.with_data(reference.data.drop(columns=list(IMPULSES), errors="ignore")) if unseen else reference
    found = scored(run, compared, task, limit)
    if unseen:
        kept = tuple(one for one in found.scores if one.kind not in OF_IMPACTS)
        found = replace(found, scores=kept, unmatched=(),
                        left_out={**found.left_out, "impacts": "the file does not tell the impulses of its rigid contacts"})
    own = yardsticks()[task.name]
    beside = tuple(replace(one, **{law: getattr(own, law).get(one.name, np.nan) for law in LAWS}) for one in found.scores)
    return replace(found, scores=beside, rigid=(is_rigid(run, task), is_rigid(reference, task)))


def scored(run: RunData, reference: RunData, task: Task, limit: float) -> Scores:
    """Score a run against a reference up to a horizon [s], without spreads."""
    for one in run, reference:
        if len(one.time) < 2:
            raise Error(file=one.file, expected="rows at two times at least", found=len(one.time))
    first, last = float(reference.time[0]), min(limit, float(reference.time[-1]))
    begin, end = max(float(run.time[0]), first), min(last, float(run.time[-1]))
    if end <= begin:
        raise Error(file=run.file, expected=f"times in common with {reference.file} before the horizon {limit:.4g} s",
                    found="none")
    present = (end - begin)/(last - first)
    lost = 1 - present if present < WHOLE else 0.0
    left_out: dict[str, str] = {}
    known: dict[str, tuple[list[ContactInterval], list[ContactInterval]]] = {}
    lacking: dict[str, list[ContactInterval]] = {}      # intervals of the reference, of contacts without forces in the run
    for contact in CONTACTS:
        mine, theirs = (one.intervals(contact, MATCHED_BEYOND*limit) for one in (run, reference))
        if mine is None or theirs is None:
            left_out[contact] = f"no force of this contact in the {'run' if mine is None else 'reference'}"
            lacking[contact] = theirs[:MOST] if theirs else []
        else:
            known[contact] = mine[:MOST], theirs[:MOST]
    share = share_of_time(known.values(), begin, end) if known else np.nan
    found: list[Score | Unmatched] = [*scores_over_time(run, reference, task, known, (begin, end), lost, left_out)]
    if known:
        other = (1 - share)*(1 - lost) + lost
        found.append(Score("contacts", "other contacts closed", other, end - begin, other*(end - begin), present))
    until = last if lost else end
    for contact, both in known.items():
        found += contact_scores(contact, *both, limit, until)
    for contact, theirs in lacking.items():
        found += [one for one in contact_scores(contact, [], theirs, limit, until) if isinstance(one, Score)]
    passed, expected = (passages(one, MATCHED_BEYOND*limit) for one in (run, reference))
    found += passage_scores(passed, expected, limit, until)
    alone = sorted((one for one in found if isinstance(one, Unmatched)), key=lambda one: one.time)
    return Scores(task, limit, end, share, tuple(one for one in found if isinstance(one, Score)), tuple(alone), left_out)


# Over time --------------------------------------------------------------------------------

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


def scores_over_time(run: RunData, reference: RunData, task: Task,
                     known: Mapping[str, tuple[Sequence[ContactInterval], Sequence[ContactInterval]]],
                     window: tuple[float, float], lost: float, left_out: dict[str, str]) -> Iterator[Score]:
    """The scores of columns at those times of rows of the run at which the same contacts are closed.

    lost: share of the reference's time that the file does not have; it counts as wrong by the size of the quantity. What cannot
    be compared is added to `left_out`.
    """
    t = np.unique(run.time)
    t = t[(t >= window[0]) & (t <= window[1])]
    closed = {contact: [closed_at(own, t) for own in both] for contact, both in known.items()}
    same = np.all([mine == theirs for mine, theirs in closed.values()] or [np.ones(t.size, bool)], axis=0)
    elastic = all("PE_elastic_L" in one.data for one in (run, reference))
    missing = {column: np.interp(t, run.time, where.astype(float)) > 0
               for contact in CONTACTS for column, where in missing_forces(run, contact)}
    for kind, column in ((kind, column) for kind, columns in OVER_TIME.items() for column in columns):
        contact = column[-2:]
        asked = closed[contact][1] if contact in closed else np.ones(t.size, bool)
        if not (asked[1:] & asked[:-1]).any():
            continue            # a contact that the reference never closes
        mine, theirs = (values_at(one, column, t, elastic) for one in (run, reference))
        if mine is None or theirs is None:
            where = [where for where, x in (("run", mine), ("reference", theirs)) if x is None]
            left_out[column] = f"no such column in the {' and the '.join(where)}"
            # What the reference has and the run has not is wrong altogether.
            yield Score(kind, column, np.nan if theirs is None else 1.0, share=0.0)
        elif contact in closed and not (same & asked).any():
            yield Score(kind, column, 1.0, share=0.0)
        elif one := score_over_time(kind, column, mine, theirs, t, asked & (same | missing.get(column, False)), asked, lost,
                                    task.clearance if kind in ("place", "radius") else None):
            yield one


def values_at(one: RunData, column: str, t: np.ndarray, elastic: bool) -> np.ndarray | None:
    """A column at times, (times,), or the change of an energy since the first; None where the file has none. A force without a
    number is none, and the motion goes straight over rows without one: what is missing counts."""
    if column not in SUMS:
        if column not in one.data:
            return None
        x = one.values(column)
        known = np.isfinite(x)
        if column in FORCES:
            return np.interp(t, one.time, np.where(known, x, 0.0))
        return np.interp(t, one.time[known], x[known]) if column in MOTION and known.any() else np.interp(t, one.time, x)
    energy = told(one, column, elastic)
    if energy is None:
        return None
    x = np.interp(t, one.time, energy)
    return x - x[:1]


def score_over_time(kind: str, column: str, mine: np.ndarray, theirs: np.ndarray, t: np.ndarray, same: np.ndarray,
                    asked: np.ndarray, lost: float, size: float | None) -> Score | None:
    """The root mean square of a difference over a size, by default over that of the reference; a time counts by how far its
    neighbours are. same, asked: where to compare, and where the reference has the contact closed, (times,). None where the
    reference has no numbers."""
    steps = np.diff(t)

    def whole(where: np.ndarray) -> float:
        return float(np.sum(steps[where[1:] & where[:-1]]))

    good = same & np.isfinite(mine) & np.isfinite(theirs)
    time, all_time = whole(good), whole(asked & np.isfinite(theirs))
    if not time:
        return Score(kind, column, np.nan, share=0.0) if all_time else None

    def rms(x: np.ndarray) -> float:
        squares = np.where(good, x, 0.0)**2
        return float(np.sqrt(np.sum(np.where(good[1:] & good[:-1], steps, 0.0)*(squares[1:] + squares[:-1]))/(2*time)))

    with np.errstate(over="ignore", invalid="ignore"):
        error, usual = rms(mine - theirs), rms(theirs)
    difference = relative(error, 0.0, usual if size is None else size) if error else 0.0
    return Score(kind, column, float(np.hypot(difference*np.sqrt(1 - lost), np.sqrt(lost))), usual, error,
                 (1 - lost)*time/max(all_time, time))


def relative(value: float, expected: float, size: float | None = None) -> float:
    """|value - expected| over |expected|, or over a size; NaN where that is zero or unknown."""
    size = abs(expected) if size is None else size
    difference = abs(value - expected)
    return difference/size if np.isfinite(difference) and 0 < size < np.inf else np.nan


# Contacts ---------------------------------------------------------------------------------

def contact_scores(contact: str, mine: Sequence[ContactInterval], theirs: Sequence[ContactInterval],
                   limit: float, until: float) -> Iterator[Score | Unmatched]:
    """Times at which a contact closes and opens, and the impacts, before the horizon.

    An impact of either file without a partner, up to a time, is wrong altogether: its difference is 1.
    """
    largest = max((one.impulse for one in theirs if one.whole and one.end <= limit), default=0.0)
    partner = dict(pairs([one.start for one in theirs], [one.start for one in mine]))
    closed = opened = struck = 0
    for k, one in enumerate(theirs):
        closed, opened, struck = closed + one.begins, opened + one.ends, struck + one.whole
        small = one.whole and one.impulse < LEAST*largest
        if k not in partner:
            if one.end > until:
                continue
            yield Unmatched("reference", contact, one.start, one.impulse if one.whole else 0.0)
            if one.begins and not small:
                yield Score("event", f"{contact} closes {closed}", 1.0, one.start, share=0.0)
            if one.whole and not small:
                yield from (Score(kind, f"{contact} {struck} {kind}", 1.0, size, 0.0, share=0.0) for kind, size in sizes(one))
            continue
        other = mine[partner[k]]
        if small:
            continue
        if one.begins and other.begins and one.start <= limit:
            yield event_score(f"{contact} closes {closed}", other.start, one.start)
        if one.ends and other.ends and one.end <= limit and one.end > one.start:
            yield event_score(f"{contact} opens {opened}", other.end, one.end)
        if one.whole and other.whole and one.end <= limit:
            for kind in OF_IMPACTS:
                value, expected = getattr(other, kind), getattr(one, kind)
                if np.isfinite(value) and np.isfinite(expected) and expected > 0 and (kind != "duration" or value > 0):
                    yield Score(kind, f"{contact} {struck} {kind}", relative(value, expected), expected, value)
    for one in (one for i, one in enumerate(mine) if i not in partner.values() and one.end <= until):
        yield Unmatched("run", contact, one.start, one.impulse if one.whole else 0.0)
        if one.whole and one.impulse >= LEAST*largest:
            yield Score("event", f"{contact} closes in the file alone at {one.start:.6f} s", 1.0, value=one.start, share=0.0)
            yield from (Score(kind, f"{contact} {kind} of the file alone at {one.start:.6f} s", 1.0, 0.0, size, share=0.0)
                        for kind, size in sizes(one))


def sizes(one: ContactInterval) -> Iterator[tuple[str, float]]:
    """The kinds of scores of an impact, and the sizes that it has: a rigid one has neither a largest force nor a duration."""
    yield from ((kind, size) for kind in OF_IMPACTS if np.isfinite(size := getattr(one, kind)) and size > 0)


def event_score(name: str, value: float, expected: float) -> Score:
    """The difference of two times of an event over the time of the reference."""
    return Score("event", name, relative(value, expected), expected, value)


def passage_scores(mine: Sequence[float], theirs: Sequence[float], limit: float, end: float) -> Iterator[Score | Unmatched]:
    """Passages of the centre."""
    partner = dict(pairs(theirs, mine))
    for k, time in enumerate(theirs):
        if k in partner and time <= limit:
            yield event_score(f"{PASSAGE} {k + 1}", mine[partner[k]], time)
        elif k not in partner and time <= end:
            yield Score("event", f"{PASSAGE} {k + 1}", 1.0, time, share=0.0)
            yield Unmatched("reference", PASSAGE, time, 0.0)
    yield from (Unmatched("run", PASSAGE, time, 0.0) for i, time in enumerate(mine) if i not in partner.values() and time <= end)


# Partners ---------------------------------------------------------------------------------

def closed_at(found: Sequence[ContactInterval], t: np.ndarray) -> np.ndarray:
    """Whether a contact is closed at times that ascend, by its intervals."""
    starts, ends = np.array([one.start for one in found]), np.array([one.end for one in found])
    k = np.searchsorted(starts, t, "right") - 1
    return (k >= 0) & (t <= ends[np.clip(k, 0, None)]) if len(found) else np.zeros(len(t), bool)


def pairs(reference: Sequence[float], other: Sequence[float]) -> list[tuple[int, int]]:
    """Match two ascending lists of times in their order.

    As many are matched as the shorter list has, such that the sum of the differences in time is the least.
    """
    chosen = linear_sum_assignment(np.abs(np.subtract.outer(np.asarray(reference), np.asarray(other))))
    # Equal sums may cross over; in order they are no larger.
    return list(zip(*(np.sort(places).tolist() for places in chosen), strict=True))
