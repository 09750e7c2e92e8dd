"""Faults that hide in the sums of a whole run: slow drifts, single wrong values, rows that break Newton's law.

Impacts are hundreds of times as large as what happens between them, so that a balance of the whole run lets some percent pass. Here
a drift is measured beyond what the trapezoidal rule, the digits and the times of the rows can leave.
"""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ldbench import Case
from ldbench.constants import CONTACTS
from ldbench.results.derived import cumulative
from ldbench.results.run_data import RunData

from .column_names import UNIT_OF
from .findings import Finding, judged
from .lattice import digit_noise
from .row_checks import has, lateral_force, total, weight_of

DRIFT = 3e-3, 0.1           # of the range of a displacement: doubtful, wrong
ALONE = 3e-3, 0.02          # of the range of a displacement, of one value beside its neighbours: doubtful, wrong
ASIDE = 1e-3                # of one place or radius of a contact: doubtful [m]
LONELY = 10.0               # how many times larger than its neighbours' a bend is that one wrong value makes
ALIKE = 0.3                 # relative error of the bends of the rows before and behind, which have half the size
OBEYING = 1e-3, 0.9         # of the largest force: what is left of Newton's law in rows that obey it; share of such rows
BROKEN = 0.005, 0.1         # of the largest force, in a row of a file that obeys: doubtful, wrong
TIME_ERROR = "time_error"   # in the attributes of a frame: by what times of few digits may be wrong [s]
PLACES = "y", "z", "radius"
DISPLACEMENTS = ("Y", "vY", "lateral"), ("Z", "vZ", "vertical"), ("roll", "roll_rate", "roll")


def by_times(run: RunData, rate: np.ndarray) -> np.ndarray:
    """What times of few digits may change in the integral of a rate, (rows,)."""
    error = float(run.data.attrs.get(TIME_ERROR, 0.0))
    return error*np.cumsum(np.abs(np.diff(np.nan_to_num(rate), prepend=rate[:1]))) if error else np.zeros(rate.size)


def drift_findings(run: RunData, case: Case, closed: list[str], rigid: bool, dense: bool) -> Iterator[Finding]:
    """All findings of this module. closed: displacements whose balance with the velocity closes."""
    for x, v, words in DISPLACEMENTS:
        if not has(run, x) or run.time.size < 8 or not np.isfinite(run.values(x)).all():
            continue
        yield lonely_finding(x, words, run)
        if x in closed and has(run, v) and np.isfinite(run.values(v)).all():
            yield drift_finding(x, v, words, run, rigid)
    for contact in CONTACTS:
        yield from (place_finding(column, run) for name in PLACES if has(run, column := f"{name}_{contact}"))
    if dense:
        yield from newton_findings(run, case)


def drift_finding(x: str, v: str, words: str, run: RunData, rigid: bool) -> Finding:
    """Whether a displacement drifts from the integral of its velocity.

    A velocity may belong to another moment of the step; that makes no drift.
    """
    t, place, rate = run.time, run.values(x), run.values(v)
    over = place - place[0] - cumulative(t, rate)
    change = rate - rate[0]
    late = float(np.clip((over @ change)/max(change @ change, 1e-300), *(np.median(np.diff(t))*np.array([-1, 1]))))
    left = np.abs(over - late*change)
    # The trapezoidal rule misses h/12 times the second difference of a rate, and half the jump of one that jumps.
    bend = np.pad(np.abs(np.diff(rate, 2)), 1, mode="edge")
    step = np.diff(t)*(np.abs(np.diff(rate))/2 if rigid else np.maximum(bend[1:], bend[:-1])/12)
    vague = np.concatenate([[0.0], np.cumsum(step)]) + 2*digit_noise(place) + digit_noise(rate)*(t - t[0]) + by_times(run, rate)
    size = max(float(np.ptp(place)), 1e-300)
    beyond = np.maximum(left - vague, 0.0)/size
    row = int(beyond.argmax())
    return judged(f"{x} does not drift", float(beyond[row]), *DRIFT, row + 1,
                  f"{x} and the integral of the {words} velocity go {left[row]:.3g} {UNIT_OF[x]} apart")


def lonely_finding(x: str, words: str, run: RunData) -> Finding:
    """Whether one value of a displacement stands apart from those before and behind it."""
    bend, row = loneliest(run.time, run.values(x))
    return judged(f"no value of {x} stands alone", bend/max(float(np.ptp(run.values(x))), 1e-300), *ALONE, row + 1,
                  f"the {words} displacement of one row is {bend:.3g} {UNIT_OF[x]} beside those before and behind it")


def place_finding(column: str, run: RunData) -> Finding:
    """Whether one place or radius of a closed contact stands apart from those before and behind it."""
    force = f"N_{column[-2:]}"
    closed = np.nan_to_num(run.values(force)) > 0 if has(run, force) else np.ones(run.time.size, bool)
    bend, row = loneliest(run.time, np.where(closed, run.values(column), np.nan))
    return judged(f"no value of {column} stands alone", bend, ASIDE, np.inf, row + 1,
                  f"[m]; {column} of one row is so far from those before and behind it")


def loneliest(t: np.ndarray, place: np.ndarray) -> tuple[float, int]:
    """By how much the loneliest of some values stands apart from those before and behind it, and its row from 0; 0 where none does.
    Values that are no number are no neighbours."""
    before, behind = np.maximum(np.diff(t)[:-1], 0.0), np.maximum(np.diff(t)[1:], 0.0)
    share = np.divide(before, before + behind, out=np.full(before.size, 0.5), where=before + behind > 0)
    bend = np.zeros(t.size)
    bend[1:-1] = place[1:-1] - (1 - share)*place[:-2] - share*place[2:]
    around = np.lib.stride_tricks.sliding_window_view(np.pad(np.abs(bend), 3, mode="edge"), 7)
    others = np.maximum(np.max(around[:, [0, 1, 5, 6]], axis=1), digit_noise(place))
    halves = [np.abs(np.roll(bend, way) + np.concatenate([[0.5], weight, [0.5]])*bend) for way, weight in (
        (1, _moved(share, -1)), (-1, 1 - _moved(share, 1)))]
    alone = (np.abs(bend) > LONELY*others) & (np.maximum(*halves) < ALIKE*np.abs(bend))
    alone[:2] = alone[-2:] = False
    size = np.where(alone, np.abs(bend), 0.0)
    row = int(size.argmax())
    return float(size[row]), row


def _moved(share: np.ndarray, way: int) -> np.ndarray:
    """Shares of the row before (-1) or behind (1)."""
    return np.concatenate([share[:1], share[:-1]]) if way < 0 else np.concatenate([share[1:], share[-1:]])


def newton_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """Whether every row obeys Newton's law, if nearly all do: forces and accelerations are then those of one moment."""
    for a, force, words, load in (("aY", "Fy", "lateral", lateral_force(run, case)), ("aZ", "Fz", "vertical", -weight_of(case))):
        names = [f"{force}_{contact}" for contact in CONTACTS]
        if not has(run, a, *names):
            continue
        acting = total(run, force) + load
        left = np.abs(case.mass*run.values(a) - acting)/max(float(np.max(np.abs(total(run, force)))), 1e-300)
        if not np.isfinite(left).any() or not float(np.nanquantile(left, OBEYING[1])) <= OBEYING[0]:
            continue
        row = int(np.nanargmax(left))
        count = int(np.sum(left > BROKEN[0]))
        yield judged(f"every row obeys Newton's law, {words}", float(left[row]), *BROKEN, row + 1,
                     f"{a} of {count} rows is not that of the {words} forces, which it is in the others")
