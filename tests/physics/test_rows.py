"""Rows at events, changes of contacts, impacts and peaks, between those at equal intervals."""
import functools

import numpy as np
import pandas as pd
import pytest

import ldbench
from ldbench import Case, run
from ldbench.constants import CONTACTS
from probes import MASS, ROLL_INERTIA
from running import kept_tables

NEAR = 5e-8     # of a time, what nine digits tell apart
LATE = 1.3e-7   # the row of a change is the first one that shows it [s]


@functools.cache
def both(number: int, formulation: str) -> tuple[ldbench.Run, ldbench.Run]:
    """A run of an exercise with the actual profiles, and the run with rows at equal intervals alone."""
    case = Case.exercise(number).replace(FORMULATIONS[formulation], t_end=0.12, stop_at="t_end", judged="no", pressures="no",
                                         table_folder=kept_tables())
    return run(case), run(case.replace(rows="interval"))


FORMULATIONS = {"elastic": {}, "implicit": {"beta": 0.25, "order": 2}, "bilateral": {"formulation": "bilateral"},
                "unilateral": {"formulation": "unilateral", "restitution": 0.5}}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_rows_at_equal_intervals_remain(formulation: str):
    """Rows at events are steps of their own: the run, its events and its rows at equal intervals are the same bytes."""
    more, alone = both(2, formulation)
    rows = np.rint(alone.data.time/1e-4)
    assert (rows == np.arange(len(rows))).all()
    assert len(more.data) > len(alone.data) + 10
    # After an impact at a row of the grid: the last of equal times.
    kept = more.data[more.data.time.isin(alone.data.time)].groupby("time", as_index=False).tail(1)
    assert kept.to_numpy().tobytes() == alone.data.to_numpy().tobytes()
    assert [str(e) for e in more.events] == [str(e) for e in alone.events]
    for c in CONTACTS:
        assert more.results[f"peak_N_{c}"] == alone.results[f"peak_N_{c}"]


@pytest.mark.parametrize("formulation", ["elastic", "unilateral"])
def test_events_are_rows(formulation: str):
    """Every event has a row of its time."""
    more, alone = both(3, formulation)
    times = more.data.time.to_numpy()
    assert len(more.events) >= 5
    for event in more.events:
        assert np.abs(times - event.t).min() <= NEAR*event.t + LATE, event
    assert sum(np.abs(alone.data.time - e.t).min() > 1e-6 for e in more.events) >= 4


def test_events_of_long_implicit_steps_are_rows():
    """Also where a contact closes and turns within a step, so that it is dated to the start of the step."""
    for dt in 2e-4, 1.4e-3:
        done = run(Case.exercise(2).replace(dt=dt, interval=dt, energy_tolerance=0.0, error_tolerance=0.0, stop_at="t_end",
                                            t_end=0.12, table_folder=kept_tables(), beta=0.25, order=2, judged="no"))
        assert np.isfinite(done.data.to_numpy()[:, :5]).all()
        for event in done.events:
            if event.kind.endswith(("contact", "landing", "lift-off")):
                assert np.abs(done.data.time - event.t).min() < 1e-6*dt + NEAR*event.t + LATE, event


def test_contacts_change_at_rows():
    """Elastic forces begin and end at zero: at nearly every change of a contact there is a row, on either side of it. The row has
    less than a newton, or none and lies where the force of the closed rows, to the power 2/3 as the approach, ends within 2 µs.
    The exceptions are mostly patches that cross the border between tread and flange."""
    def at_rows(columns: pd.DataFrame) -> np.ndarray:
        """Whether each opening or closing is at a row."""
        found, t = [], columns.time.to_numpy()
        for contact in CONTACTS:
            force = columns[f"N_{contact}"].to_numpy()
            for k in np.flatnonzero((force[:-1] > 0) != (force[1:] > 0)):
                opened, last, before = (k + 1, k, k - 1) if force[k] > 0 else (k, k + 1, k + 2)
                depth = force[[last, before]]**(2/3)
                end = t[last] + (t[last] - t[before])*depth[0]/max(depth[1] - depth[0], 1e-9)
                found.append(force[last] < 1.0 or abs(end - t[opened]) < 2e-6)
        return np.array(found)

    more, alone = both(3, "elastic")
    assert len(at_rows(more.data)) >= 30
    assert np.mean(at_rows(more.data)) > 0.75
    assert np.mean(at_rows(alone.data)) < 0.1


@pytest.mark.parametrize("formulation", ["bilateral", "unilateral"])
def test_impacts_have_two_rows(formulation: str):
    """Before and after an impact: one time, one pose, and velocities that differ by impulse over mass."""
    more, alone = both(2, formulation)
    c = more.data
    after = np.flatnonzero(np.diff(c.time) == 0) + 1
    struck = [e for e in more.events if e.kind == "impact"]
    assert len(struck) == len(after) > 2
    for i in CONTACTS:
        jumps = c[f"P_{i}"].to_numpy()[after] - c[f"P_{i}"].to_numpy()[after - 1]
        assert more.results[f"peak_P_{i}"] == pytest.approx(jumps.max(), rel=1e-12)
    # Rows at equal intervals have no pair.
    assert (np.diff(alone.data.time) > 0).all()
    for k in after:
        before, then = c.iloc[k - 1], c.iloc[k]
        assert (before[["Y", "Z", "roll"]] == then[["Y", "Z", "roll"]]).all()
        impulse = [then[f"P_{i}"] - before[f"P_{i}"] for i in CONTACTS]
        assert max(impulse) > 0
        gain = MASS*np.hypot(then.vY - before.vY, then.vZ - before.vZ)
        assert 0 < gain <= sum(impulse)*(1 + 1e-9)
        energy = [0.5*(MASS*(x.vY**2 + x.vZ**2) + ROLL_INERTIA*x.roll_rate**2) for x in (before, then)]
        assert energy[0] - energy[1] == pytest.approx(then.E_lost - before.E_lost, abs=1e-8*energy[0])
