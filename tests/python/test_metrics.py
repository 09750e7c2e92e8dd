"""Scores of runs against references whose difference is planted, and the horizons they are scored up to."""
from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ldbench
from imaginary_physics import rigid
from imaginary_round import RIGHTWARDS, table_of, write
from invented import invented_run
from ldbench import Case, ContactTable
from ldbench.__main__ import main
from ldbench.constants import CONTACTS
from ldbench.results.run_data import RunData
from ldbench.runs import compute
from ldbench_round import own_runs
from ldbench_round.energies import SUMS
from ldbench_round.findings import times_text
from ldbench_round.metrics import score
from ldbench_round.own_runs import LAWS, yardsticks
from ldbench_round.scores import KINDS, Score, Scores
from ldbench_round.tasks import MOTION, QUANTITIES, Task
from running import Run, kept_tables
from stranger_files import KINETIC, MM_KN, ROLL, Row, both, of, swap, times
from yardsticks import measured_yardstick, rounded

TASK = Task(2, "aw")
HERTZ = {"model": "hertz", "table_folder": ""}


@pytest.fixture(scope="module")
def hertz(read_hertz: Callable[[str], ContactTable]) -> dict[str, ldbench.Run]:
    """Runs with Hertz's law, and rigid ones."""
    found: dict[str, ldbench.Run] = {}
    for name, case in (("ex1_aw", Case.exercise(1, "aw")), ("ex2_aw", Case.exercise(2, "aw")),
                       ("ramp", Case.exercise(5, "aw").replace(t_end=1.0))):
        case = case.replace(**HERTZ)
        found[name] = compute(case, table=read_hertz("aw").for_case(case))
    return found | {"rigid": rigid(TASK, 0.5)}


@pytest.fixture(scope="module")
def frame(hertz: dict[str, ldbench.Run]) -> pd.DataFrame:
    return hertz["ex2_aw"].data


@pytest.fixture(scope="module")
def reference(frame: pd.DataFrame) -> RunData:
    """The run without its header, as those are that are changed."""
    return invented_run(frame)


def differences(scores: Scores, kind: str) -> dict[str, float]:
    return {one.name: one.difference for one in scores.of_kind(kind)}


@pytest.mark.parametrize(("name", "task"), [
    ("ex2_aw", TASK), ("ramp", Task(5, "aw")), ("rigid", TASK)])
def test_a_run_is_itself(name: str, task: Task, hertz: dict[str, ldbench.Run]):
    """Everything is of the best grade, whatever the formulation."""
    found = score(hertz[name], hertz[name], task)
    assert found.share == 1 and not found.unmatched and not found.left_out
    assert [one.name for kind in ("displacement", "velocity", "acceleration") for one in found.of_kind(kind)] == list(MOTION)
    assert {one.difference for one in found.scores} == {0.0} and {one.grade for one in found.scores} == {1e-3}
    assert {one.share for one in found.scores if one.kind in ("displacement", "force", "event", "impulse")} == {1.0}
    if name == "ex2_aw":
        assert {one.kind for one in found.scores} == set(KINDS)
        assert {"LF 1 impulse", "RF 1 peak", "LF closes 1", "LF opens 1", "centre passage 2"} <= {one.name for one in found.scores}


def test_a_shift_of_time(reference: RunData, frame: pd.DataFrame):
    """Events differ by the shift. Impulses, peaks and durations do not. Motion differs by the shift times its rate."""
    shift = 1e-5
    found = score(invented_run(frame.assign(time=frame.time + shift)), reference, TASK)
    for one in found.of_kind("event"):
        assert one.value - one.reference == pytest.approx(shift, rel=1e-6)
        assert one.difference == pytest.approx(shift/one.reference, rel=1e-6)
    for kind in ("impulse", "peak", "duration"):
        assert max(differences(found, kind).values()) < 1e-9, kind
    # A shift may move the last bounce behind the end.
    assert sum(one.impulse for one in found.unmatched) < 1e-9
    t, y, v = (frame[name].to_numpy() for name in ("time", "Y", "vY"))
    size = np.sqrt(np.trapezoid(v**2, t)/np.trapezoid(y**2, t))
    assert found.get("Y").difference == pytest.approx(shift*size, rel=0.05)
    # 58 contacts close or open, and for the time of the shift after each the sets differ, where no other one is near.
    assert 1 - found.share == pytest.approx(58*shift/t[-1], rel=0.35)


@pytest.mark.parametrize(("factor", "grade"), [(1.0009, 1e-3), (1.09, 0.1)])
def test_scaled_forces(factor: float, grade: float, reference: RunData, frame: pd.DataFrame):
    """Impulses and peaks are scaled and get the grade; motion, events and durations are as they were."""
    found = score(invented_run(times(factor, *of("N"))(frame)), reference, TASK)
    for kind in ("impulse", "peak"):
        for one in found.of_kind(kind):
            assert one.difference == pytest.approx(abs(factor - 1), rel=1e-4)
            assert one.grade == grade
    for kind in ("displacement", "acceleration", "radius", "contacts", "event", "duration"):
        assert max(differences(found, kind).values()) < 1e-4, kind
    assert found.get("N_LF").difference == pytest.approx(abs(factor - 1), rel=1e-3)


@pytest.mark.parametrize("start", [0.009, 0.060])
def test_one_impact_more(start: float, reference: RunData, frame: pd.DataFrame):
    """It is told with its time and impulse, wherever it is, and all others keep their partners."""
    t = frame.time.to_numpy()
    length, peak = 3e-3, 5e4
    assert not frame.N_LF[(t > start - length) & (t < start + 2*length)].any()
    bump = np.where((t > start) & (t < start + length), peak*np.sin(np.pi*(t - start)/length), 0.0)
    run = invented_run(frame.assign(N_LF=frame.N_LF + bump))
    more, fewer = score(run, reference, TASK), score(reference, run, TASK)
    for found, where in ((more, "run"), (fewer, "reference")):
        one, = found.unmatched
        assert (one.where, one.name) == (where, "LF")
        assert one.time == pytest.approx(start, abs=1e-4) and one.impulse == pytest.approx(2/np.pi*peak*length, rel=0.01)
        for kind, wrong in ("event", 1), ("impulse", 1), ("peak", 1), ("duration", 1):
            told = list(differences(found, kind).values())
            assert sorted(told) == [0.0]*(len(told) - wrong) + [1.0]*wrong, kind
        assert 1 - found.share == pytest.approx(length/t[-1], rel=0.1)
    # The order in the reference names an impact, whether or not the run has one more before it.
    assert more.get("LF 1 impulse").reference == score(reference, reference, TASK).get("LF 1 impulse").reference


SPOILT: dict[str, tuple[Callable[[pd.DataFrame], pd.DataFrame], set[str]]] = {
    "a flange never touched": (
        both(times(0.0, "N_LF", "Fy_LF", "Fz_LF"), times(np.nan, "angle_LF", "y_LF", "z_LF", "radius_LF")),
        {"force", "angle", "place", "radius", "event", "impulse", "peak", "duration"}),
    "the largest force has no number": (lambda f: f.assign(**{c: f[c].mask(f.N_LF > 0.5*f.N_LF.max()) for c in of(
        "N", "Fy", "Fz", contacts=["LF"])}), {"force", "event", "impulse", "peak", "duration"}),
    "no velocities": (lambda f: f.drop(columns=["vY", "vZ"]), {"velocity"}),
    "the first 3 ms": (lambda f: f[f.time < 3e-3], {
        "displacement", "velocity", "acceleration", "contacts", "event", "impulse", "peak", "duration"}),
    "angles 1.3 times": (times(1.3, *of("angle")), {"angle"}), "one radius doubled": (times(2.0, "radius_RF"), {"radius"}),
    "vertical forces exchanged": (swap("LT RT", quantities=["Fz"]), {"force"}),
    "points aside": (lambda f: f.assign(y_LF=f.y_LF + 5e-3), {"place"}),
    "kinetic energy doubled": (times(2.0, *KINETIC), {"energy"}), "energy of the load missing": (times(0.0, "PE_load"), {"energy"})}


@pytest.mark.parametrize("what", SPOILT)
def test_what_has_no_partner_or_is_wrong_gets_a_bad_grade(what: str, reference: RunData, frame: pd.DataFrame):
    """Every quantity of the call has a grade, and a quantity that is as it should be keeps its good one."""
    change, bad = SPOILT[what]
    found = score(invented_run(change(frame)), reference, TASK)
    grades = {kind: one.grade for kind in KINDS if (one := found.graded(kind))}
    assert {kind for kind in bad if grades.get(kind) is None} == bad, grades
    if what == "the first 3 ms":
        assert found.share_of("displacement") == pytest.approx(3e-3/frame.time.iloc[-1], rel=0.1) and found.share_of("event") < 0.1
    else:
        assert {kind for kind, limit in grades.items() if limit is None} <= bad | {"contacts"}, grades


def test_what_a_poor_file_loses(reference: RunData, frame: pd.DataFrame):
    """Components replace the normal force; a file without forces has motion and passages; a short file ends the scores."""
    by_parts = score(invented_run(frame.drop(columns=of("N"))), reference, TASK)
    assert max(differences(by_parts, "impulse").values()) < 1e-9 and by_parts.share == pytest.approx(1, abs=1e-9)
    bare = score(invented_run(frame[["time", "Y"]]), reference, TASK)
    scored = {one.name for one in bare.scores if one.difference < 1}
    assert scored == {"Y", "centre passage 1", "centre passage 2"} and np.isnan(bare.share)
    assert {one.difference for one in bare.scores if one.name not in scored} == {1.0}       # what the reference has is missing
    assert all(found.grade is None for kind in KINDS if (found := bare.graded(kind)))
    assert set(bare.left_out) == {*CONTACTS, *QUANTITIES, *SUMS} - {"Y"}
    assert bare.share_of("displacement") == pytest.approx(1/3)
    cut = score(invented_run(frame.iloc[:len(frame)//3]), reference, TASK)
    assert cut.end == frame.time[len(frame)//3 - 1] and {one.where for one in cut.unmatched} == {"reference"}
    assert cut.get("LF 1 impulse").grade == 1e-3 and cut.get("RF 1 impulse").difference == 1
    holes = score(invented_run(frame.assign(Y=np.where(np.arange(len(frame)) % 7 == 0, np.nan, frame.Y))), reference, TASK)
    assert holes.get("Y").difference < 1e-3


@pytest.mark.slow
def test_the_yardstick_of_exercise_2_is_measured_again(shipped: dict[str, Run]):
    """The horizon and all spreads are those of the file."""
    table = ContactTable(Case.exercise(2, "aw").replace(table_folder=kept_tables()))
    found = rounded(measured_yardstick(TASK, {"elastic": table}, longest=0.35))
    known = rounded(yardsticks()[TASK.name])
    assert found.keys() == known.keys()
    assert found["horizon"] == pytest.approx(known["horizon"], rel=0.03)
    assert found["growth"] == pytest.approx(known["growth"], rel=0.05)
    for name in LAWS:
        assert found[name] == pytest.approx(known[name], rel=0.05, abs=1e-4)


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


def test_it_is_told_which_file_is_rigid(folders: tuple[Path, Path], hertz: dict[str, ldbench.Run], tmp_path: Path,
                                        capsys: pytest.CaptureFixture[str]):
    file = tmp_path/"rigid/ex2_aw.txt"
    file.parent.mkdir()
    hertz["rigid"].write(file)
    for path, reference, expected in ((file, folders[1], (True, False)), (folders[1]/"ex2_aw.txt", file, (False, True))):
        assert main(["score", str(path), "--reference", str(reference), "--simulation", "ex2_aw", "--json"]) == 0
        told, = json.loads(capsys.readouterr().out)["files"]
        assert (told["rigid"], told["reference_rigid"]) == expected


def test_the_file_of_another_code_gets_a_map(folders: tuple[Path, Path], hertz: dict[str, ldbench.Run], tmp_path: Path,
                                              monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """A map is guessed, or given: other names, units, signs and an interval of 0.1 ms."""
    monkeypatch.setitem(own_runs._OWN, TASK, hertz["ex2_aw"])
    write(table_of(hertz["ex2_aw"]), tmp_path/"other.csv", Row(both(RIGHTWARDS, times(-1.0, *ROLL)), {"units": MM_KN}))
    words = ["score", str(tmp_path/"other.csv"), "--reference", str(folders[1]), "--simulation", "ex2_aw"]
    assert main([*words, "--json"]) == 0
    found, = json.loads(capsys.readouterr().out)["files"]
    scores = {one["name"]: one["difference"] for one in found["scores"]}
    assert scores["Y"] < 1e-4 and scores["LF 1 impulse"] < 5e-3 and scores["LF closes 1"] < 1e-3 and found["share"] > 0.98
    assert main(["check", str(tmp_path/"other.csv"), "--simulation", "ex2_aw", "--save-map", str(tmp_path/"map.toml")]) == 0
    capsys.readouterr()
    assert main([*words, "--json", "--map", str(tmp_path/"map.toml")]) == 0
    again, = json.loads(capsys.readouterr().out)["files"]
    assert again["scores"] == found["scores"]
    # Another simulation under this name is scored, with a line for each sign of that.
    file = (tmp_path/"other.csv").rename(tmp_path/"ex1_sw.csv")
    words = ["score", str(file), "--reference", str(folders[1]), "--simulation", "ex1_aw"]
    assert main([*words, "--map", str(tmp_path/"map.toml")]) == 0
    said = capsys.readouterr().out
    assert "  doubtful: " in said and "a name that says" in said and "initial vY 0.5 instead of 0.1" in said


@pytest.mark.parametrize(("x", "words"), [(14986.0, "> 100"), (100.0, "100"), (6.1, "6.1"), (0.17, "0.17"), (2.7e-10, "< 0.01"),
                                          (0.0, "0"), (float("nan"), "–")])
def test_how_many_times_a_yardstick(x: float, words: str):
    assert times_text(x) == words


@pytest.mark.parametrize(("name", "words"), [
    ("roll_acc", "roll acceleration"), ("Fy_RF", "lateral force, right flange"), ("LF closes 1", "left flange"),
    ("centre passage 2", "passage of the centre"), ("RT 3 impulse", "right tread")])
def test_what_a_score_is_of(name: str, words: str):
    assert Score("", name, 0.1).words == words
