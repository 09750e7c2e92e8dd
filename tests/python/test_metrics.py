"""Scores of runs against references whose difference is planted, and the horizons they are scored up to."""
from __future__ import annotations

import itertools
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import imaginary_codes as imaginary
import ldbench
from independent import displacements
from ldbench import Case, ContactTable, Error
from ldbench.__main__ import main
from ldbench.results.header import Header
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData
from ldbench.runs import compute
from ldbench_round import own_runs
from ldbench_round.horizon import horizon, yardsticks
from ldbench_round.metrics import LEAST, closed_at, pairs, passages, score
from ldbench_round.own_runs import exact
from ldbench_round.scores import GRADES, KINDS, Scores, grade
from ldbench_round.tasks import MOTION, TASKS, Task
from running import Run
from yardsticks import ASIDE, GROWN, base, growth, growth_seen, measured_yardstick, rounded

TASK = Task(2, "aw")
HERTZ = {"model": "hertz", "table_file": ""}


class Made:
    """Columns that stand for a file."""

    def __init__(self, columns: Mapping[str, np.ndarray] | pd.DataFrame) -> None:
        self.file, self.header, self._columns = Path("made.txt"), Header(), pd.DataFrame(columns)

    def columns(self) -> pd.DataFrame:
        return self._columns

    def case(self) -> Case:
        raise Error("made.txt: no case")


def made(columns: Mapping[str, np.ndarray] | pd.DataFrame) -> RunData:
    return RunData(Made(columns))


@pytest.fixture(scope="module")
def hertz(read_hertz: Callable[[str], ContactTable]) -> dict[str, ldbench.Run]:
    """Runs with Hertz's law and rigid ones."""
    found: dict[str, ldbench.Run] = {}
    for name, case in (("ex1_aw", Case.exercise(1, "aw")), ("ex2_aw", Case.exercise(2, "aw")),
                       ("ramp", Case.exercise(5, "aw").replace(t_end=1.0))):
        case = case.replace(**HERTZ)
        found[name] = compute(case, table=read_hertz("aw").for_case(case))
    for e in (1.0, 0.5):
        found[f"rigid {e}"] = ldbench.run(Case.exercise(2, "aw").replace(formulation="unilateral", restitution=e, table_file=""))
    found["bilateral"] = ldbench.run(Case.exercise(2, "aw").replace(formulation="bilateral", table_file=""))
    return found


@pytest.fixture(scope="module")
def frame(hertz: dict[str, ldbench.Run]) -> pd.DataFrame:
    return hertz["ex2_aw"].data


@pytest.fixture(scope="module")
def reference(frame: pd.DataFrame) -> RunData:
    """The run without its header, as those are that are changed."""
    return made(frame)


def changed(frame: pd.DataFrame, **columns: np.ndarray | pd.Series) -> RunData:
    return made(frame.assign(**columns))


def differences(scores: Scores, kind: str) -> dict[str, float]:
    return {one.name: one.difference for one in scores.of_kind(kind)}


# ---- planted differences -------------------------------------------------------------
@pytest.mark.parametrize(("name", "task"), [
    ("ex1_aw", Task(1, "aw")), ("ex2_aw", TASK), ("ramp", Task(5, "aw")), ("rigid 1.0", TASK), ("rigid 0.5", TASK),
    ("bilateral", TASK)])
def test_a_run_is_itself(name: str, task: Task, hertz: dict[str, ldbench.Run]):
    """Everything is of the best grade, whatever the formulation."""
    found = score(hertz[name], hertz[name], task)
    assert found.share == 1 and not found.unmatched and not found.left_out
    assert [one.name for one in found.of_kind("motion")] == list(MOTION)
    assert {one.difference for one in found.scores} == {0.0} and {one.grade for one in found.scores} == {1e-3}
    if name in ("ex1_aw", "ex2_aw"):
        assert {one.kind for one in found.scores} == set(KINDS)
        assert {"LF 1 impulse", "RF 1 peak", "LF closes 1", "LF opens 1", "centre passage 2"} <= {one.name for one in found.scores}


@pytest.mark.parametrize("shift", [1e-6, 1e-5, 1e-3])
def test_a_shift_of_time(shift: float, reference: RunData, frame: pd.DataFrame):
    """Events differ by the shift. Impulses, peaks and durations do not. Motion differs by the shift times its rate."""
    run = changed(frame, time=frame.time + shift)
    found = score(run, reference, TASK)
    for one in found.of_kind("event"):
        assert one.value - one.reference == pytest.approx(shift, rel=1e-6)
        assert one.difference == pytest.approx(shift/one.reference, rel=1e-6)
    for kind in ("impulse", "peak", "duration"):
        assert max(differences(found, kind).values()) < 1e-9, kind
    # A shift may move the last bounce behind the end.
    assert found.get("unmatched").difference < 1e-12
    t, y, v = (frame[name].to_numpy() for name in ("time", "Y", "vY"))
    size = np.sqrt(np.trapezoid(v**2, t)/np.trapezoid(y**2, t))
    if shift < 1e-3:
        assert found.get("Y").difference == pytest.approx(shift*size, rel=0.05)
        assert found.share == pytest.approx(1, abs=70*shift/t[-1])
    # 58 contacts close or open, and for the time of the shift after each the sets differ, where no other one is near.
    assert 1 - found.share == pytest.approx(58*shift/t[-1], rel=0.35)


def test_motion_is_compared_while_the_same_contacts_are_closed(reference: RunData, frame: pd.DataFrame):
    """A motion that is wrong only where the other file has another contact closed is not wrong."""
    late = changed(frame, time=frame.time + 1e-3)
    dense = np.arange(0, late.time[-1], 1e-6)
    apart = np.zeros(len(dense), bool)
    for contact in CONTACTS:
        mine, theirs = (closed_at(one.intervals(contact), dense) for one in (late, reference))
        apart |= mine != theirs
    # Rows between whose neighbours the sets differ all the time: a row also tells what is half-way to the next.
    inside = np.zeros(len(frame), bool)
    for k in range(1, len(frame) - 1):
        around = slice(*np.searchsorted(dense, late.time[[k - 1, k + 1]] + [-3e-6, 3e-6]))
        inside[k] = apart[around].all() and around.stop > around.start
    assert inside.sum() > 20
    spoilt = changed(frame, time=frame.time + 1e-3, aY=np.where(inside, 1e6, frame.aY))
    assert score(spoilt, reference, TASK).get("aY").difference == score(late, reference, TASK).get("aY").difference < 10


@pytest.mark.parametrize("factor", [1.0009, 0.991, 1.09, 1.2])
def test_scaled_forces(factor: float, reference: RunData, frame: pd.DataFrame):
    """Impulses and peaks are scaled and get the grade; motion, events and durations are as they were."""
    run = changed(frame, **{f"N_{contact}": factor*frame[f"N_{contact}"] for contact in CONTACTS})
    found = score(run, reference, TASK)
    for kind in ("impulse", "peak"):
        for one in found.of_kind(kind):
            assert one.difference == pytest.approx(abs(factor - 1), rel=1e-4)
            assert one.grade == {1.0009: 1e-3, 0.991: 1e-2, 1.09: 0.1, 1.2: None}[factor]
    for kind in ("motion", "contacts", "event", "duration", "unmatched"):
        assert max(differences(found, kind).values()) < 1e-4, kind


def bump(t: np.ndarray, start: float, length: float, peak: float) -> np.ndarray:
    return np.where((t > start) & (t < start + length), peak*np.sin(np.pi*(t - start)/length), 0.0)


@pytest.mark.parametrize("start", [0.009, 0.060])
def test_one_impact_more(start: float, reference: RunData, frame: pd.DataFrame):
    """It is told with its time and impulse, wherever it is, and all others keep their partners."""
    t = frame.time.to_numpy()
    length, peak = 3e-3, 5e4
    assert not frame.N_LF[(t > start - length) & (t < start + 2*length)].any()
    run = changed(frame, N_LF=frame.N_LF + bump(t, start, length, peak))
    more, fewer = score(run, reference, TASK), score(reference, run, TASK)
    for found, where in ((more, "run"), (fewer, "reference")):
        one, = found.unmatched
        assert (one.where, one.name) == (where, "LF")
        assert one.time == pytest.approx(start, abs=1e-4) and one.impulse == pytest.approx(2/np.pi*peak*length, rel=0.01)
        for kind in ("event", "impulse", "peak", "duration"):
            assert set(differences(found, kind).values()) == {0.0}, kind
        assert 1 - found.share == pytest.approx(length/t[-1], rel=0.1)
    whole = sum(one.impulse for contact in CONTACTS for one in reference.intervals(contact) if one.whole)
    assert more.get("unmatched").difference == pytest.approx(more.unmatched[0].impulse/whole)
    # The order in the reference names an impact, whether or not the run has one more before it.
    assert more.get("LF 1 impulse").reference == score(reference, reference, TASK).get("LF 1 impulse").reference


def mirrored(run: RunData) -> RunData:
    """The run seen in a mirror: left is right, and lateral and roll have the other sign."""
    data = run.data
    columns = {}
    for name in data:
        base, _, contact = str(name).partition("_")
        other = f"{base}_{'R' if contact[0] == 'L' else 'L'}{contact[1]}" if contact in CONTACTS else str(name)
        turned = other in ("Y", "roll", "vY", "roll_rate", "aY", "roll_acc") or base in ("Fy", "y")
        columns[other] = (-1 if turned else 1)*data[name].to_numpy()
    return made(columns)


def test_mirrored_runs_have_the_scores_of_the_others_side(hertz: dict[str, ldbench.Run]):
    run, reference = made(hertz["rigid 1.0"].data), made(hertz["ex2_aw"].data)
    found, other = score(run, reference, TASK), score(mirrored(run), mirrored(reference), TASK)

    def turned(name: str) -> str:
        return {"L": "R", "R": "L"}[name[0]] + name[1:] if name[:2] in CONTACTS else name

    assert {turned(one.name): one.difference for one in found.scores if one.kind != "motion"} \
        == pytest.approx({one.name: one.difference for one in other.scores if one.kind != "motion"}, rel=1e-12)
    assert differences(found, "motion") == pytest.approx(differences(other, "motion"), rel=1e-12)
    assert len(found.unmatched) == len(other.unmatched) > 5


def test_scores_are_of_the_order_of_the_integrator(hertz: dict[str, ldbench.Run]):
    """With steps of second order, half the step has a quarter of the differences, and comes from one grade to the next."""
    table, task = hertz["ex1_aw"].table, Task(1, "aw")
    case = Case.exercise(1, "aw").replace(**HERTZ, order=2, energy_tolerance=0.0)
    reference = ldbench.run(exact(case), table=table.for_case(exact(case)))
    coarse, fine = (score(ldbench.run(own := case.replace(dt=dt), table=table.for_case(own)), reference, task)
                    for dt in (1e-4, 5e-5))
    for name in ("Y", "Z", "roll", "vY", "centre passage 1", "RF closes 1", "centre passage 2"):
        assert 3.5 < coarse.get(name).difference/fine.get(name).difference < 4.6, name
    assert fine.worst("event").grade == 1e-3


@pytest.mark.parametrize(("difference", "expected"), [
    (0.0, 1e-3), (1e-3, 1e-3), (-5e-4, 1e-3), (1.1e-3, 1e-2), (0.05, 0.1), (0.11, None), (np.nan, None), (np.inf, None)])
def test_a_grade_is_the_smallest_limit(difference: float, expected: float | None):
    assert grade(difference) == expected and sorted(GRADES) == list(GRADES)


# ---- files of all kinds --------------------------------------------------------------
HOSTILE: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "time and Y alone": lambda f: f[["time", "Y"]],
    "time alone": lambda f: f[["time"]],
    "no flanges": lambda f: f.drop(columns=[name for name in f if name.endswith("F")]),
    "components without N": lambda f: f.drop(columns=[f"N_{contact}" for contact in CONTACTS]),
    "rows every 2 ms": lambda f: f.iloc[::20],
    "a third of the file": lambda f: f.iloc[:len(f)//3],
    "empty cells": lambda f: f.assign(Y=np.where(np.arange(len(f)) % 7 == 0, np.nan, f.Y), N_LF=f.N_LF.where(f.time < 0.03)),
    "nothing but empty cells": lambda f: f.assign(**{name: np.nan for name in f if name != "time"}),
    "huge numbers": lambda f: f.assign(**{name: 1e308*(1 if k % 2 else -1) for k, name in enumerate(f) if name != "time"}),
    "zeros": lambda f: f.assign(**{name: 0.0 for name in f if name != "time"}),
    "two rows": lambda f: f.iloc[[0, len(f)//2]],
    "every row closed or open by chance": lambda f: f.assign(
        N_LF=np.random.default_rng(1).random(len(f)) < 0.5, N_LT=1e5*(np.random.default_rng(2).random(len(f)) < 0.5)),
    "each time twice": lambda f: f.iloc[np.repeat(np.arange(len(f)), 2)],
    "infinite": lambda f: f.assign(vY=np.inf, N_RT=np.inf),
}


@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.filterwarnings("error")
def test_any_file_is_scored(name: str, hertz: dict[str, ldbench.Run], frame: pd.DataFrame):
    """As a run and as a reference; what cannot be scored is told, numbers are differences or NaN, and JSON takes them."""
    spoilt = made(HOSTILE[name](frame).reset_index(drop=True))
    for pair in ((spoilt, hertz["ex2_aw"]), (hertz["ex2_aw"], spoilt), (spoilt, spoilt)):
        found = score(*pair, TASK)
        assert all(np.isnan(one.difference) or one.difference >= 0 for one in found.scores)
        assert np.isnan(found.share) or 0 <= found.share <= 1
        scored = {one.name for one in found.of_kind("motion")}
        assert scored | (found.left_out.keys() - set(CONTACTS)) == set(MOTION) and not scored & found.left_out.keys()
        json.dumps(found.facts())


def test_what_a_poor_file_loses(reference: RunData, frame: pd.DataFrame):
    """Components replace the normal force; a file without forces has motion and passages; a short file ends the scores."""
    by_parts = score(made(HOSTILE["components without N"](frame)), reference, TASK)
    assert max(differences(by_parts, "impulse").values()) < 1e-9 and by_parts.share == pytest.approx(1, abs=1e-9)
    bare = score(made(HOSTILE["time and Y alone"](frame)), reference, TASK)
    assert {one.name for one in bare.scores} == {"Y", "centre passage 1", "centre passage 2"} and np.isnan(bare.share)
    assert set(bare.left_out) == set(CONTACTS) | set(MOTION) - {"Y"}
    cut = score(made(HOSTILE["a third of the file"](frame)), reference, TASK)
    assert cut.end == frame.time[len(frame)//3 - 1] and not cut.unmatched
    assert "LF 1 impulse" in {one.name for one in cut.scores} and "RF 1 impulse" not in {one.name for one in cut.scores}
    holes = score(made(HOSTILE["empty cells"](frame)), reference, TASK)
    assert holes.get("Y").difference < 1e-3


def test_files_that_cannot_be_scored_are_refused(reference: RunData, frame: pd.DataFrame):
    for columns, told in ((frame.iloc[:1], "two times"), (frame.assign(time=frame.time + 9), "times in common"),
                          (frame.iloc[::-1], "ascending"), (frame.drop(columns="time"), "column time")):
        with pytest.raises(Error, match=told):
            score(made(columns.reset_index(drop=True)), reference, TASK)


def test_rigid_impacts_are_those_of_the_columns(hertz: dict[str, ldbench.Run]):
    """Their impulses are all of what the columns P grow by, and times are those of the events."""
    run = hertz["rigid 0.5"]
    for contact in CONTACTS:
        found = run.intervals(contact)
        pushed = np.trapezoid(run.values(f"N_{contact}"), run.time)
        assert sum(one.impulse for one in found) == pytest.approx(run.values(f"P_{contact}")[-1] + pushed, rel=0.02)
    told = [event for event in run.events if "LF" in event.impulses]
    assert told and told[0].t in [one.start for one in run.intervals("LF")]


def test_rigid_impacts_that_a_file_does_not_tell_are_not_missed(hertz: dict[str, ldbench.Run]):
    """A rigid code whose file has no impulses is scored in motion and events. A file of elastic contacts keeps its impacts."""
    told = hertz["rigid 0.5"]
    untold = made(told.data.drop(columns=[f"P_{contact}" for contact in CONTACTS]))
    found = score(untold, told, TASK)
    assert found.rigid == (True, True)
    assert {one.kind for one in found.scores} == {"motion", "contacts", "event"} and not found.unmatched
    assert "impulses" in found.left_out["impacts"]
    assert {one.difference for one in found.of_kind("motion")} == {0.0}
    elastic = score(hertz["ex2_aw"], told, TASK)
    assert elastic.rigid == (False, True) and {"impulse", "unmatched"} <= {one.kind for one in elastic.scores}
    assert score(hertz["ex2_aw"], hertz["ex2_aw"], TASK).rigid == (False, False)


# ---- matching ------------------------------------------------------------------------
@pytest.mark.parametrize("seed", range(20))
def test_pairs_leave_out_what_is_worth_least(seed: int):
    """The best of all ways to leave some out, found by trying them all."""
    chance = np.random.default_rng(seed)
    reference, other = (np.sort(chance.random(chance.integers(0, 8))) for _ in range(2))
    found = pairs(reference, other)
    n = min(len(reference), len(other))
    assert len(found) == n and found == sorted(found) and all(len({one[k] for one in found}) == n for k in (0, 1))

    def cost(chosen: list[tuple[int, int]]) -> float:
        return sum(abs(reference[k] - other[i]) for k, i in chosen)

    ways = [list(zip(left, right, strict=True)) for left in itertools.combinations(range(len(reference)), n)
            for right in itertools.combinations(range(len(other)), n)]
    assert cost(found) == pytest.approx(min(map(cost, ways)))


def test_passages_need_both_sides():
    """Neither rounding at the start nor a touch of the centre is a passage; the end at the centre is one."""
    t = np.arange(951)/1000
    y = np.sin(2*np.pi*1.5*t)
    y[0] = -1e-18
    assert passages(made({"time": t, "Y": y})) == pytest.approx([1/3, 2/3], abs=1e-6)
    assert passages(made({"time": t[:667], "Y": np.where(np.arange(667) == 666, 1e-7, y[:667])})) \
        == pytest.approx([1/3, 0.666], abs=1e-6)
    assert passages(made({"time": t, "Y": y**2})) == []
    assert passages(made({"time": t, "Y": np.zeros(951)})) == []


DIGITS = 0.005      # yardsticks.json keeps three digits


# ---- horizons ------------------------------------------------------------------------
def test_every_simulation_has_a_yardstick():
    known = yardsticks()
    assert list(known) == [task.name for task in TASKS]
    for task in TASKS:
        own = known[task.name]
        assert 0 < own.horizon == horizon(task) <= 4 and 1 < own.growth <= GROWN/ASIDE
        assert set(MOTION) <= own.hertz.keys() and own.hertz["other contacts closed"] < 0.5
        # Rigid contacts with restitution 1 bounce where elastic ones stay closed; then their motion is no measure.
        assert (set(MOTION) <= own.rigid.keys()) == (own.rigid["other contacts closed"] <= 0.5)
        # In the first four exercises only the last impacts of ex3_sw are behind the horizon; most of exercise 5 is.
        beyond = task.name == "ex3_sw" or task.exercise == 5
        assert (own.end is None) == (task.exercise == 5) and ((own.end or np.inf) > own.horizon) == beyond
        assert (own.growth == GROWN/ASIDE) == beyond
        # Another integrator sees the same horizon, and both differ by far less from one start.
        assert (own.independent is not None) == own.reached and 0 < own.integrators < GROWN
        assert not own.reached or own.earliest <= own.independent*(1 + DIGITS)
        assert own.latest is None or own.independent*(1 - DIGITS) <= own.latest
    assert horizon(Task(3, "sw")) < horizon(Task(1, "aw"))


@pytest.fixture(scope="module")
def tables(shipped: dict[str, Run]) -> dict[str, ContactTable]:
    file = shipped["ex1_aw"].file.with_name("aw_halfspace.table")
    return {"elastic": ContactTable(Case.exercise(2, "aw").replace(table_file=str(file)))}


def test_the_yardstick_of_exercise_2_is_measured_again(tables: dict[str, ContactTable]):
    """The horizon and all spreads are those of the file."""
    found = rounded(measured_yardstick(TASK, tables, longest=0.35))
    known = rounded(yardsticks()[TASK.name])
    assert found.keys() == known.keys()
    assert found["horizon"] == pytest.approx(known["horizon"], rel=0.03)
    assert found["growth"] == pytest.approx(known["growth"], rel=0.05)
    for name in ("hertz", "rigid"):
        assert found[name] == pytest.approx(known[name], rel=0.05, abs=1e-4)


@pytest.mark.parametrize("task", [TASK, Task(4, "aw")], ids=lambda task: task.name)
def test_another_integrator_has_this_horizon(task: Task, tables: dict[str, ContactTable]):
    """SciPy's DOP853 on the force of the core, from the six starts aside, against our integrator from the start itself.

    Growth.band says how far apart the horizons of two integrators may be. `make yardsticks` measures all ten in this way.
    """
    case = Case.exercise(task.exercise, task.profiles)
    table = tables["elastic"].for_case(case.replace(table_file=tables["elastic"].case.table_file))
    limit = horizon(task)
    begun = base(case.replace(table_file=table.case.table_file), table, 1.05*limit)
    own = growth(begun)
    seen, differences = growth_seen(begun, displacements, np.inf)
    apart = float(differences[seen.time <= 1.02*limit][-1])
    assert 2*apart < GROWN, "the integrators themselves make the difference"
    first, last = own.band(apart)
    assert first is not None and last is not None and seen.horizon is not None
    assert first <= seen.horizon <= last
    assert own.horizon == pytest.approx(limit, rel=DIGITS)
    assert first*(1 - DIGITS) <= yardsticks()[task.name].independent <= last*(1 + DIGITS)


def test_growth_of_a_free_flight_is_that_of_its_start(hertz: dict[str, ldbench.Run]):
    """Until the flange touches, differences do not grow; impacts multiply them."""
    case = Case.exercise(2, "aw").replace(**HERTZ)
    found = growth(base(case, hertz["ex2_aw"].table, t_end=0.12))
    touch = hertz["ex2_aw"].first_contact("LF")
    assert found.until(0.9*touch) < 1.1 and 5 < found.until(0.03) < found.until(0.12)/100
    assert found.horizon is None and (np.diff(found.factor) >= 0).all()


# ---- the command ---------------------------------------------------------------------
@pytest.fixture
def folders(hertz: dict[str, ldbench.Run], tmp_path: Path) -> tuple[Path, Path]:
    own, reference = tmp_path/"own", tmp_path/"reference"
    for folder in (own, reference):
        folder.mkdir()
        for name in ("ex1_aw", "ex2_aw"):
            hertz[name].write(folder/f"{name}.txt")
    return own, reference


def test_the_command_scores_folders(folders: tuple[Path, Path], hertz: dict[str, ldbench.Run], capsys: pytest.CaptureFixture[str]):
    """One bad file does not stop the others."""
    own, reference = folders
    assert main(["score", str(own), "--reference", str(reference), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert [one["simulation"] for one in facts["files"]] == ["ex1_aw", "ex2_aw"]
    assert {score["grade"] for one in facts["files"] for score in one["scores"]} == {1e-3}
    (own/"ex1_aw.txt").write_text("nothing\n")
    assert main(["score", str(own), "--reference", str(reference)]) == 1
    said = capsys.readouterr().out
    assert "ex2_aw.txt: exercise 2, actual profiles; scored up to" in said and "not scored: " in said and "ex1_aw.txt" in said
    assert said.count(" 0.001 ") > 10 and "centre passage 1" not in said
    assert main(["score", str(own/"ex2_aw.txt"), "--reference", str(reference), "--all"]) == 0
    assert "centre passage 2" in capsys.readouterr().out


def test_the_file_of_another_code_gets_a_map(folders: tuple[Path, Path], hertz: dict[str, ldbench.Run], tmp_path: Path,
                                              monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Guessed, or given: other names, units, signs and an interval of 0.1 ms."""
    monkeypatch.setitem(own_runs._OWN, TASK, hertz["ex2_aw"])
    dialect = imaginary.Dialect(lateral=-1, roll=-1, length="mm", force="kN", scheme=2)
    imaginary.write(imaginary.table_of(hertz["ex2_aw"], 1e-4), tmp_path/"other.csv", dialect)
    words = ["score", str(tmp_path/"other.csv"), "--reference", str(folders[1]), "--simulation", "ex2_aw"]
    assert main([*words, "--json"]) == 0
    found, = json.loads(capsys.readouterr().out)["files"]
    assert found["doubts"] == []
    scores = {one["name"]: one["difference"] for one in found["scores"]}
    assert scores["Y"] < 1e-4 and scores["LF 1 impulse"] < 5e-3 and scores["LF closes 1"] < 1e-3 and found["share"] > 0.98
    assert main(["check", str(tmp_path/"other.csv"), "--simulation", "ex2_aw", "--save-map", str(tmp_path/"map.toml")]) == 0
    capsys.readouterr()
    assert main([*words, "--json", "--map", str(tmp_path/"map.toml")]) == 0
    again, = json.loads(capsys.readouterr().out)["files"]
    assert again["scores"] == found["scores"]
    # Another simulation under this name is scored, with a line for each sign of that.
    (tmp_path/"ex1_sw.csv").write_bytes((tmp_path/"other.csv").read_bytes())
    words = ["score", str(tmp_path/"ex1_sw.csv"), "--reference", str(folders[1]), "--map", str(tmp_path/"map.toml")]
    for simulation, signs in ("ex2_aw", ["a name that says"]), ("ex1_aw", ["a name that says", "initial vY 0.5 instead of 0.1"]):
        assert main([*words, "--simulation", simulation]) == 0
        lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  doubtful: ")]
        assert all(any(sign in line for line in lines) for sign in signs) and (len(lines) == 1) == (simulation == "ex2_aw"), lines


@pytest.mark.parametrize(("words", "told"), [
    (["{own}", "--reference", "{reference}/ex1_aw.txt"], "expected a file, for --reference FILE"),
    (["{own}", "--reference", "{empty}"], "expected files of the simulations in"),
    (["{own}/ex1_aw.txt", "--reference", "{empty}"], "expected a file of exercise 1, actual profiles, found none"),
    (["{empty}/x.csv", "--reference", "{reference}"], "expected a name that says the simulation"),
    (["{own}/ex1_aw.txt", "--reference", "{reference}/ex2_aw.txt"],
     "reference/ex2_aw.txt: expected a file of exercise 1, actual profiles, found the header of exercise 2, actual profiles"),
    (["{own}/ex1_aw.txt", "--reference", "{reference}", "--simulation", "ex2_aw"], "found the header of exercise 1, actual"),
    (["{own}/ex1_aw.txt", "--reference", "{reference}/none_1_aw.txt"], "cannot be opened"),
], ids=["folder", "nothing in common", "no reference", "no name", "another reference", "another file", "no file"])
def test_what_belongs_together_is_told(words: list[str], told: str, folders: tuple[Path, Path], tmp_path: Path,
                                       capsys: pytest.CaptureFixture[str]):
    empty = tmp_path/"empty"
    empty.mkdir()
    assert main(["score", *(word.format(own=folders[0], reference=folders[1], empty=empty) for word in words)]) == 1
    assert told in capsys.readouterr().err


def test_small_impacts_are_counted_but_not_scored(reference: RunData, frame: pd.DataFrame):
    """A touch of the flange's root that is a millionth of an impact is no impact to match forces by."""
    t = frame.time.to_numpy()
    largest = max(one.impulse for one in reference.intervals("LF"))
    small = 0.1*LEAST*largest
    both = [changed(frame, N_LF=frame.N_LF + bump(t, 0.06, 3e-3, factor*small*np.pi/2/3e-3)) for factor in (1.0, 2.0)]
    found = score(*both, TASK)
    assert not found.unmatched and "LF 2 impulse" not in {one.name for one in found.scores}
    assert replace(found, scores=()).share == pytest.approx(1, abs=1e-3)
