"""Answers of a run: rows tell those of the core, and everybody who shows an answer takes the one."""
from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ldbench
from invented import COARSE, altered, invented_run
from ldbench import Case
from ldbench.constants import CONTACTS
from ldbench.report.differences import event_table, event_times
from ldbench.results.answers import EXTREMES, all_events, answers, passages
from ldbench.results.run_data import RunData
from ldbench.results.summary import summary_row
from ldbench.runs import compute
from ldbench_round.round_numbers import numbers_of
from ldbench_round.tasks import Task
from running import CASES, Run, with_kept_table

RIGHT_SW = {"wheel_profile_right": "profiles/swprof.yz", "rail_profile_right": "profiles/srprof.yz"}
TIMES = *(f"t_first_{contact}" for contact in CONTACTS), "t_first_centre", "t_return"
FIRST = "t_first_peak_LF", "t_first_peak_RF", *(f"t_peak_{contact}" for contact in CONTACTS)
PEAKS = *(f"peak_N_{contact}" for contact in CONTACTS), "first_peak_N_LF", "first_peak_N_RF"
IMPULSES = *(f"first_impulse_{contact}" for contact in CONTACTS), "turn_impulse_LF", "turn_impulse_RF"
COUNTS = ("n_left_flange_contact", "n_right_flange_contact", "n_left_wheel_lift_off", "n_right_wheel_lift_off",
          "n_left_wheel_landing", "n_right_wheel_landing", "n_centre_passage", "n_derailment")


def stranger(run: RunData) -> RunData:
    """The rows alone, as another code would have them."""
    return invented_run(run.data)


def assert_near(names: tuple[str, ...], core: Mapping[str, Any], rows: Mapping[str, Any], relative: float = 0.0,
                absolute: float = 0.0) -> None:
    """Both have the answer, or none has."""
    for name in names:
        assert rows[name] == (core[name] if core[name] is None else pytest.approx(core[name], rel=relative, abs=absolute)), name


def assert_rows_tell(run: RunData) -> tuple[dict[str, Any], dict[str, Any]]:
    """Answers of the core and of the rows, which differ by no more than the rows leave open: a displacement turns between two rows
    by what the largest acceleration makes of half the time."""
    core, rows, h = answers(run), answers(stranger(run), run.case), run.case.interval
    assert core.keys() == rows.keys()
    assert_near(TIMES, core, rows, absolute=h/20)
    assert_near(FIRST, core, rows, absolute=1e-9)
    assert_near(PEAKS, core, rows, relative=1e-8)
    assert_near(("first_duration_LF", "first_duration_RF"), core, rows, absolute=h/5)
    assert_near(IMPULSES, core, rows, relative=2e-3)
    for name, (column, _) in EXTREMES.items():
        acceleration = np.abs(run[{"Y": "aY", "Z": "aZ", "roll": "roll_acc"}[column]]).max()
        assert rows[name] == pytest.approx(core[name], abs=acceleration*h**2/8 + 1e-12), name
    assert_near(("kinetic_energy", "drift_reference"), core, rows, relative=1e-8)
    assert 0.5*core["drift"] < rows["drift"] <= core["drift"]*(1 + 1e-8)
    return core, rows


@pytest.mark.parametrize("name", [name for name in CASES if name[2] != "5"])
def test_rows_tell_the_answers_of_the_core(name: str, shipped: dict[str, Run]):
    """The shipped exercises, each by rows of 0.1 ms and by the core."""
    core, rows = assert_rows_tell(ldbench.read_run(shipped[name].file))
    assert_near(COUNTS, core, rows)
    assert core["t_first_LF"] < core["t_first_centre"] < core["t_first_RF"] < core["t_return"] == pytest.approx(core["t"], abs=1e-4)


@pytest.mark.parametrize("name", ["ex5_aw", "ex5_sw"])
def test_rows_of_a_ramp_tell_the_derailment(name: str, shipped: dict[str, Run]):
    """A contact of the left flange has five rows, so its impulse is known to 3 %; contacts shorter than a row are not seen."""
    run = ldbench.read_run(shipped[name].file)
    core, rows = answers(run), answers(stranger(run), run.case)
    assert_near(("t_first_LF", "t_first_centre", "t_return"), core, rows, absolute=run.case.interval/50)
    assert_near(("t_derailment", "t_unloaded"), core, rows, absolute=run.case.interval/2)
    assert_near(("F_derailment", "F_unloaded"), core, rows, absolute=run.case.interval/2*run.case.lateral_ramp)
    assert_near(PEAKS[:4] + PEAKS[4:5], core, rows, relative=1e-8)
    assert_near(("first_impulse_LF", "turn_impulse_LF"), core, rows, relative=0.03)
    assert_near(COUNTS, core, rows, relative=0.05)
    # The core knows the last step, too, in which the wheelset leaves the table.
    assert_near(tuple(EXTREMES), core, rows, relative=1e-2)
    assert core["t_unloaded"] < core["t_derailment"] and core["F_unloaded"] < core["F_derailment"] == run.first("derailment").force


@pytest.mark.parametrize("changes", [
    {"vY": -0.5}, RIGHT_SW | {"vY": 0.8}, {"vY": 0.0, "lateral_ramp": -4e5, "t_end": 2.0, "stop_at": "derailment"}],
    ids=["to the right", "sides that differ", "ramp to the right"])
def test_rows_know_left_from_right(changes: dict[str, Any]):
    run = compute(with_kept_table(Case.exercise(2).replace(**COARSE | changes, dt=1e-5, interval=5e-5)))
    core, rows = assert_rows_tell(run)
    assert_near(("t_derailment", "t_unloaded"), core, rows, absolute=2e-5)
    assert_near(("F_derailment", "F_unloaded"), core, rows, absolute=10.0)
    assert (core["t_first_RF"] < (core["t_first_LF"] or math.inf)) == (changes["vY"] <= 0)
    assert (core["F_derailment"] or 0.0) <= 0.0 and core["derailed"] == rows["derailed"] == ("lateral_ramp" in changes)


@pytest.mark.parametrize("rule", [{"formulation": "bilateral"}, {"formulation": "unilateral", "restitution": 1.0},
                                  {"formulation": "unilateral", "restitution": 0.0}], ids=["held", "e = 1", "e = 0"])
def test_rows_tell_impacts_that_take_no_time(rule: dict[str, Any]):
    """Both wheels may be held on their rails: where a force begins to pull, its contact does not open."""
    run = compute(Case.exercise(2).replace(**rule))
    core, rows = answers(run), answers(stranger(run), run.case)
    assert_near((*TIMES, "first_duration_LF", "first_duration_RF"), core, rows, absolute=1e-8)
    assert_near((*PEAKS, *(f"peak_P_{contact}" for contact in CONTACTS), "lost"), core, rows, relative=1e-6)
    assert_near(IMPULSES, core, rows, relative=0.01)        # forces jump between rows
    assert_near(COUNTS, core, rows)
    assert core["first_peak_N_LF"] is None and (core["first_duration_LF"] == 0) == (rule.get("restitution", 0) > 0)


def test_a_return_below_a_flange_is_one_time(tmp_path: Path):
    """The flange on the right does not touch. The wheelset has turned back on both sides at the second passage of the centre:
    summary, comparison, collation and column file have that return, whatever ends the run."""
    case = with_kept_table(Case(**COARSE | RIGHT_SW, vY=0.0479, roll_link="rails", t_end=9.0, dt=1e-4, interval=1e-2))
    run, longer = (compute(case.replace(stop_at=stop)) for stop in ("return_to_centre", "t_end"))
    back = run.results["t_return"]
    listed = [event.t for event in run.events if event.kind == "centre passage"]
    assert len(listed) == 2 and listed[-1] == back == pytest.approx(run.time[-1], abs=case.interval)
    assert longer.results["n_right_flange_contact"] == 0 < longer.results["n_left_flange_contact"] and longer.time[-1] > 5*back
    assert run.success and run.ending.startswith("return to the centre, turned back below ")
    file = ldbench.read_run(run.write(tmp_path/"run.txt"))
    known = [answers(file)["t_return"], answers(longer)["t_return"], summary_row(file)["t_return"],
             event_times(file)["return to the centre"], numbers_of(file, Task(1, "aw"), [])["t_return"].value]
    assert known == [back]*5
    assert answers(stranger(file))["t_return"] == passages(file)[-1] == pytest.approx(back, abs=1e-3)


def test_comparison_and_collation_tell_the_same_of_a_stranger(shipped: dict[str, Run]):
    """The file of another code lists no events. Its passages of the centre and its derailment are differences of the comparison all
    the same, and those of the collation."""
    first = [f"first {kind}" for kind in ("left flange contact", "centre passage", "left wheel lift-off", "left wheel landing")]
    for name, number, shared in (
            ("ex2_aw", "t_return", [*first, "first right flange contact", "return to the centre"]),
            ("ex5_aw", "F_derailment", ["first left flange contact", "lift for good", "derailment"])):
        run = ldbench.read_run(shipped[name].file)
        theirs = stranger(run).named("theirs")
        table = event_table([run, theirs]).set_index("quantity")
        for quantity in shared:
            known, reference = table.loc[quantity, ["value", "reference"]]
            assert known == pytest.approx(reference, abs=run.case.interval/2), quantity
        value = numbers_of(theirs, Task(run.exercise, "aw"), [])[number].value
        if number == "F_derailment":        # the collation takes rows alone for the exercise, whose ramp is less steep
            value *= run.case.lateral_ramp/5e3
        assert value == pytest.approx(answers(run)[number], rel=1e-5)
        assert number != "t_return" or value == table.loc["return to the centre", "value"]
        kinds = {event.kind for event in all_events(theirs, run.case)}
        assert kinds <= {event.kind for event in run.events} and all_events(run) == run.events


def test_what_did_not_happen_is_none(shipped: dict[str, Run]):
    """A contact that never closes has no peak; a file without forces has motion alone, and its return by the farthest points."""
    run = ldbench.read_run(shipped["ex5_aw"].file)
    known = answers(run)
    assert run.results["peak_N_RF"] == 0 and known["peak_N_RF"] is known["t_peak_RF"] is known["t_first_RF"] is None
    assert known["pmax_contact"] in CONTACTS and known["n_right_flange_contact"] == 0 and known["changes"] is None
    assert answers(altered(run, results={"pmax_contact": "", "F_limit_left": math.nan}))["F_limit_left"] is None
    thrown = ldbench.read_run(shipped["ex2_aw"].file)
    moving = answers(invented_run(thrown.data[["time", "Y"]]), thrown.case)
    assert moving["t_return"] == pytest.approx(thrown.results["t_return"], abs=1e-6)
    assert moving["t_first_LF"] is moving["n_left_flange_contact"] is moving["largest_roll"] is moving["drift"] is None
    assert moving["n_centre_passage"] == 2 and moving["derailed"] is False and moving["F_derailment"] is None
    still = answers(invented_run(pd.DataFrame({"time": [0.0, 0.1]})))
    assert {name for name, value in still.items() if value is not None} == {"t", "rows"}
