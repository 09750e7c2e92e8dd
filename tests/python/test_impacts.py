"""Impacts: closed intervals of a contact, their duration, peak and impulse, from any file with time and a normal force."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ldbench
from invented import invented_run
from ldbench import Event
from ldbench.plots.impact import chosen_impacts
from ldbench.plots.stretches import BEFORE, first_contact
from ldbench.report.differences import event_times
from ldbench.results.contact_intervals import CLOSED
from ldbench.results.derived import exchange
from ldbench.results.header import Comments
from ldbench.results.summary import summary_row
from ldbench.viewer.page import FOLDER, event_entries
from ldbench_round.round_numbers import numbers_of
from ldbench_round.tasks import Task
from running import Run

PULSE, TOP = 0.004, 8e5         # length [s] and peak [N] of a half-sine


def pulses(*starts: float, dt: float = 1e-5, end: float = 0.05, lag: float = 0.0) -> pd.DataFrame:
    """Rows every dt with half-sines of force that begin at `starts`; the rows stand `lag` after whole multiples of dt."""
    t = dt*np.arange(round(end/dt) + 1) + lag
    force = sum(np.where((t > s) & (t < s + PULSE), TOP*np.sin(np.pi*(t - s)/PULSE), 0.0) for s in starts)
    return pd.DataFrame({"time": t, "N_LF": np.where(force > 1e-3, force, 0.0)})


@pytest.mark.parametrize("residue", [0.0, 0.9])
def test_a_half_sine_is_measured(residue: float):
    """Time, length, peak, and the impulse 2/pi of peak times length; a residue of an iteration is no contact."""
    frame = pulses(0.02)
    frame["N_LF"] += residue
    [one] = invented_run(frame).impacts()
    assert one.contact == "LF" and np.isnan(one.angle)
    assert (one.start, one.end, one.duration) == pytest.approx((0.02, 0.024, PULSE), abs=1e-7 if residue else 1e-10)
    assert (one.peak - residue, one.t_peak) == pytest.approx((TOP, 0.022), rel=1e-9)
    assert one.impulse == pytest.approx(2/np.pi*TOP*PULSE, rel=1e-5)


@pytest.mark.parametrize("lag", [1e-4, 3.9e-4])
def test_rows_beside_the_ends_do_not_matter(lag: float):
    """Another code writes rows at equal intervals, ten to a pulse: ends come out to a tenth of the interval."""
    interval = PULSE/10
    frame = pulses(0.02, dt=interval, lag=lag)
    frame["N_LF"] = TOP*(frame["N_LF"]/TOP)**1.5            # by Hertz from an approach that is a half-sine
    [one] = invented_run(frame).impacts()
    assert (one.start, one.end) == pytest.approx((0.02, 0.02 + PULSE), abs=interval/10)
    assert one.impulse == pytest.approx(0.5564*TOP*PULSE, rel=0.005)       # mean of sin**1.5 over half a turn


def test_contact_that_is_closed_at_an_end_of_the_file_is_no_impact():
    """Nobody knows how long such a contact lasts."""
    rolling = pulses(0.02)
    rolling["N_LT"] = 2.0
    rolling["N_RT"] = np.where(rolling["time"] < 0.01, 2.0, 0.0)
    rolling["N_RF"] = np.where(rolling["time"] < 0.045, np.nan, 2.0)
    run = invented_run(rolling)
    assert [one.contact for one in run.impacts()] == ["LF"]
    assert [(one.begins, one.ends) for contact in ("LT", "RT", "RF") for one in run.intervals(contact)] == [
        (False, False), (False, True), (True, False)]
    assert invented_run(rolling[["time"]]).impacts() == [] and invented_run(rolling[["time"]]).intervals("LF") is None


def test_one_rule_says_when_a_contact_is_closed(shipped: dict[str, Run]):
    """Exercise 5, whose rows at events have some tenths of a newton: plots, page, score, collation and summary agree on the first
    contact, the page of impacts and the summary on the number of contacts."""
    run = ldbench.read_run(shipped["ex5_sw"].file)
    assert ((run.values("N_LF") > 0) & ~run.closed("LF")).sum() > 100 and run.values("N_LF")[run.closed("LF")].min() > CLOSED
    summary = summary_row(run)
    start = summary["t_first_LF"]
    [first, *_] = found = run.intervals("LF")
    force = run.values("N_LF")
    assert sum(one.whole for one in found) == len(run.impacts(["LF"])) == (np.diff(np.sign(force)) > 0).sum() - (force[-1] > 0)
    collated = numbers_of(run, Task(5, "sw"), [])
    assert (first.start, collated["t_first_LF"].value, run.first_interval("LF").rows.start) == pytest.approx(
        (start, start, np.searchsorted(run.time, start + 1e-8)), abs=1e-8)
    assert collated["first_peak_N_LF"].value == summary["first_peak_N_LF"] == pytest.approx(first.peak, rel=1e-8)
    assert chosen_impacts(run)[1] == summary["n_left_flange_contact"] + summary["n_right_flange_contact"]
    assert f"const CLOSED = {CLOSED:g}, isClosed = N => Math.abs(N) > CLOSED;" in (FOLDER/"series.js").read_text()


def test_everyone_tells_the_same_first_contact():
    """A touch of the flange's root, then two impacts, over a residue of an iteration: the second touch is the first contact of the
    flange for the table of all runs, the page, the comparison and the collation."""
    frame = pulses(0.01, 0.02, 0.03)
    frame["angle_LF"] = np.where(frame["N_LF"] > 0, np.radians(np.where(frame["time"] < 0.015, 10.0, 50.0)), np.nan)
    frame["N_LF"] += 0.9
    run = invented_run(frame.assign(Y=0.01*np.sin(60*frame["time"]), vY=0.6*np.cos(60*frame["time"])))
    first = run.first_interval("LF")
    assert (first.start, first.end, first.peak) == pytest.approx((0.02, 0.02 + PULSE, TOP + 0.9), abs=1e-6)
    assert [one.at_root for one in run.intervals("LF")] == [True, False, False]
    assert run.values("N_LF")[first.rows].min() > CLOSED and run.time[first.top] == first.t_peak
    window = first_contact(run, "LF")
    assert (window.start, window.zero, window.opens) == pytest.approx(
        (first.start - BEFORE*first.duration, first.start, first.end), abs=1e-12)
    on_page = next(event["t"] for event in event_entries(run) if "contact" in event["what"])
    assert {summary_row(run)["t_first_LF"], on_page, event_times(run)["first left flange contact"],
            numbers_of(run, Task(2, "aw"), [])["t_first_LF"].value} == {first.start}


def test_impacts_of_rigid_contacts(tmp_path: Path):
    """An impact takes no time and has no force. Energies before and after it differ by the loss of the event."""
    run = ldbench.run(ldbench.Case.exercise(2).replace(formulation="unilateral", restitution=0.5, t_end=0.03))
    for one in run, ldbench.read_run(run.write(tmp_path/"rigid.txt")):
        events = {event.t: event for event in one.events if event.kind == "impact"}
        found = one.impacts(["LF"])
        assert found
        for impact in found:
            energies, event = exchange(one, impact.start, impact.end), events[impact.start]
            assert (impact.duration, impact.t_peak, impact.impulse) == (0.0, event.t, event.impulses["LF"])
            assert np.isnan(impact.peak)
            assert sum(energies.before.values()) - sum(energies.after.values()) == pytest.approx(event.loss, rel=1e-6)
    two = Event(0.02, "impact", impulses={"LF": 2000.0, "RT": 30.0}), Event(0.03, "centre passage")
    assert [(one.contact, one.start, one.impulse) for one in invented_run(pulses(), comments=Comments(events=two)).impacts()] == [
        ("LF", 0.02, 2000.0), ("RT", 0.02, 30.0)]
