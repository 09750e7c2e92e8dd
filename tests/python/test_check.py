"""Submissions of imaginary codes: the map of their columns, and what is wrong with them."""
from __future__ import annotations

import importlib
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import imaginary_codes as imaginary
import imaginary_physics as physics
import ldbench
from hostile_files import HOSTILE
from ldbench import Case, ContactTable
from ldbench.__main__ import main
from ldbench.results.columns import RawTable
from ldbench.results.header import Header
from ldbench.results.run_data import RunData
from ldbench_round import check
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding
from ldbench_round.kept_entries import find_references
from ldbench_round.map_guess import find_time
from ldbench_round.submissions import find_files
from ldbench_round.tasks import QUANTITIES, TASKS, Task
from running import Run

TASK = Task(2, "aw")
SMALL = {"n_lateral": 60, "n_roll": 9, "n_depth": 9, "table_file": ""}      # a contact table that is built in no time
PLAIN = imaginary.Dialect(length="mm", force="kN", scheme=2)


@pytest.fixture(scope="module")
def another() -> dict[Task, ldbench.Run]:
    """Exercises 1 to 3 by a code with another contact law, of a steel that is softer by a fifth."""
    change = {"model": "hertz", "stiffness_scale": 0.8} | SMALL
    return {Task(exercise, "aw"): ldbench.run(Case.exercise(exercise, "aw").replace(**change)) for exercise in (1, 2, 3)}


def submitted(run: ldbench.Run, task: Task, folder: Path, dialect: imaginary.Dialect) -> tuple[Path, dict[str, int]]:
    """A file as an imaginary code would write it, and the numbers of its columns."""
    file = folder/f"{task.name}.csv"
    return file, imaginary.write(imaginary.table_of(run, dialect.interval), file, dialect)


# ---- maps ----------------------------------------------------------------------------
@pytest.mark.parametrize("seed", range(3))
def test_the_map_of_a_code_with_names_is_found(seed: int, own: None, another: dict[Task, ldbench.Run], tmp_path: Path):
    """Order, signs, units, zeros and names are those of another code; steel and contact law, too."""
    task = list(another)[seed % len(another)]
    dialect = imaginary.invent(seed)
    dialect = replace(dialect, scheme=dialect.scheme or seed % 3)
    file, truth = submitted(another[task], task, tmp_path, dialect)
    found = check.check_file(file)
    units = another[task].data.attrs["units"]
    assert {c: m.number for c, m in found.guess.matches.items()} == truth
    assert {c: (m.unit, m.sign) for c, m in found.guess.matches.items() if c != "time"} \
        == {c: (dialect.unit(c, units[c]), dialect.sign(c)) for c in QUANTITIES}
    assert [finding for finding in found.findings if finding.verdict == FAILED] == []
    back = ldbench.read_run(file, map=found.guess.map)
    t = np.linspace(0, 0.9*another[task].time[-1], 50)
    assert np.interp(t, back.time, back.values("Y")) == pytest.approx(np.interp(t, another[task].time, another[task].values("Y")),
                                                                     abs=2e-6)


def test_a_file_without_names_is_mapped_by_its_numbers(own: None, shipped: dict[str, Run], tmp_path: Path):
    """Where the physics is ours, every one of 38 nameless columns is found."""
    run = ldbench.read_run(shipped["ex2_aw"].file)
    file, truth = submitted(run, TASK, tmp_path, replace(PLAIN, scheme=None, says_units=False, lateral=-1, shuffled=3))
    found = check.check_file(file)
    assert {c: m.number for c, m in found.guess.matches.items()} == truth


def test_the_map_that_is_printed_is_the_map(own: None, another: dict[Task, ldbench.Run], tmp_path: Path,
                                             capsys: pytest.CaptureFixture):
    file, _ = submitted(another[TASK], TASK, tmp_path, replace(PLAIN, roll=-1, height=0.457))
    toml = tmp_path/"map.toml"
    assert main(["check", str(file), "--save-map", str(toml)]) == 0
    capsys.readouterr()
    assert main(["check", str(file)]) == 0
    assert " = { column" not in capsys.readouterr().out
    assert main(["check", str(file), "--show-map"]) == 0
    assert [line.strip() for line in toml.read_text().splitlines()] \
        == [line.strip() for line in capsys.readouterr().out.splitlines() if " = { column" in line]
    mapped = check.check_file(file, map=toml)
    guessed = check.check_file(file)
    assert mapped.guess is None
    assert mapped.findings == guessed.findings[-len(mapped.findings):]


# ---- findings ------------------------------------------------------------------------
@pytest.mark.parametrize("task", [
    pytest.param(task, marks=() if task.name in ("ex1_sw", "ex2_aw", "ex5_sw") else pytest.mark.slow, id=task.name)
    for task in TASKS])
def test_our_runs_fail_in_nothing(task: Task, shipped: dict[str, Run]):
    """In exercise 5 rows are too far apart for the impacts; everything else is passed."""
    found = check.check_file(shipped[task.name].file)
    assert found.guess is None and not any(finding.verdict == FAILED for finding in found.findings)
    doubtful = {finding.hint for finding in found.findings if finding.verdict == DOUBTFUL}
    assert doubtful <= ({"rows too far apart for the impacts"} if task.exercise == 5 else set()), doubtful


@pytest.fixture(scope="module")
def ramp(read_hertz: Callable[[str], ContactTable]) -> pd.DataFrame:
    """Exercise 5 up to the derailment by a code with Hertz's law: thousands of impacts, with a row every 0.2 ms."""
    case = Case.exercise(5, "aw").replace(model="hertz", table_file="", rows="interval", interval=2e-4, dt=2e-4)
    return ldbench.run(case, table=read_hertz("aw").for_case(case)).data


def findings_of(frame: pd.DataFrame, task: Task) -> dict[str, Finding]:
    """The findings about columns of ours, by what they are about."""
    run = RunData(Path("other_code.csv"), header=Header(), data=frame)
    return {finding.what: finding for finding in check.findings_of(check.SubmittedFile(task, run, None))}


@pytest.mark.slow
def test_nothing_is_wrong_in_thousands_of_impacts(ramp: pd.DataFrame):
    """What rows and places of contacts leave of a balance grows with the time, and is nobody's mistake."""
    assert ramp["time"].iloc[-1] > 50
    assert {what: finding.verdict for what, finding in findings_of(ramp, Task(5, "aw")).items() if finding.verdict != PASSED} == {}


@pytest.mark.slow
@pytest.mark.parametrize("mistakes", [
    {"roll acceleration is the rate of the velocity": ("roll_acc", 0.9, 0.0), "roll momentum closes": ("y_LF", 1.0, 0.03),
     "angle_LF is that of the force": ("angle_LF", 1.0, -0.3)},
    {"lateral momentum closes": ("Fy_LF", 0.9, 0.0)}], ids=["three columns", "a force"])
def test_mistakes_are_found_in_thousands_of_impacts(mistakes: dict[str, tuple[str, float, float]], ramp: pd.DataFrame):
    """Columns with another factor and another zero, of which each is in one law alone, in the last 20 s."""
    late = ramp[ramp["time"] > ramp["time"].iloc[-1] - 20]
    wrong = late.assign(**{column: factor*late[column] + zero for column, factor, zero in mistakes.values()})
    found = findings_of(wrong, Task(5, "aw"))
    assert all(found[what].verdict in (FAILED, DOUBTFUL) for what in mistakes)


@pytest.mark.parametrize("said", ["[s]", ""])
@pytest.mark.parametrize(("length", "factor", "unit"), [(54.0, 1.0, "s"), (54.0, 1e3, "ms"), (0.5, 1.0, "s"), (0.05, 1e3, "ms")])
def test_the_unit_of_the_time_is_that_of_the_length(said: str, length: float, factor: float, unit: str):
    """Also where the file states another one; the length is known within a factor of 5."""
    t = factor*np.linspace(0, length, 100)
    for expected in (length/5, length, 5*length):
        found = find_time(Path("x.csv"), RawTable(["t", "y"], [said.strip("[]"), "m"], np.column_stack([t, t])), expected)
        assert found.unit == unit and found.said == said.strip("[]")


@pytest.mark.parametrize(("task", "restitution"), [(TASK, 0.0), (Task(2, "sw"), 1.0)], ids=str)
def test_a_rigid_code_is_not_wrong_for_being_rigid(task: Task, restitution: float, own: None, tmp_path: Path):
    """It has no column of impulses: momentum jumps, closes between, and is doubtful with a hint; so is a restitution below 1."""
    file = tmp_path/f"{task.name}.csv"
    frame = imaginary.table_of(physics.rigid(task, restitution), 1e-4)
    imaginary.write(frame, file, PLAIN)
    found = {finding.what: finding for finding in check.check_file(file).findings}
    assert [finding.what for finding in found.values() if finding.verdict == FAILED] == []
    assert found["vertical momentum closes"].verdict == DOUBTFUL and found["vertical momentum closes"].hint
    assert (found["energy closes"].verdict == DOUBTFUL) == (restitution < 1)
    if restitution == 0:        # between impacts, forces have to agree with velocities: here the vertical ones lack a fifth
        frame[[f"Fz_{contact}" for contact in imaginary.LONG]] *= 0.8
        imaginary.write(frame, file, PLAIN)
        found = {finding.what: finding for finding in check.check_file(file).findings}
        assert found["vertical momentum closes"].verdict == FAILED


def test_another_law_of_contact_is_no_mistake(own: None, tmp_path: Path):
    """A damped contact loses energy, and this alone is found."""
    file = tmp_path/"ex2_aw.csv"
    imaginary.write(physics.simulate(TASK, physics.Physics(hunt_crossley=0.2)), file, PLAIN)
    found = {finding.what: finding.verdict for finding in check.check_file(file).findings}
    assert {what for what, verdict in found.items() if verdict == FAILED} <= {"energy closes"}
    assert found["energy closes"] in (DOUBTFUL, FAILED)


def test_a_folder_says_what_is_missing_and_goes_on(own: None, another: dict[Task, ldbench.Run], tmp_path: Path,
                                                    capsys: pytest.CaptureFixture):
    submitted(another[TASK], TASK, tmp_path, PLAIN)
    (tmp_path/"ex1_aw.csv").write_text("nothing\n")
    (tmp_path/"ex3_aw.csv").write_bytes(bytes(range(256))*40)
    (tmp_path/"notes.txt").write_text("read me\n")
    assert main(["check", str(tmp_path), "--json"]) == 1
    facts = json.loads(capsys.readouterr().out)
    by_name = {Path(one["file"]).name: one["findings"] for one in facts["files"]}
    assert not any(finding["verdict"] == FAILED for finding in by_name["ex2_aw.csv"])
    for name in ("ex1_aw.csv", "ex3_aw.csv"):
        only, = by_name[name]
        assert only["verdict"] == FAILED and name in only["hint"] and "\n" not in only["hint"]
    assert facts["folder"][0]["number"] == 3 and "exercise 1, simplified" in facts["folder"][0]["hint"]
    assert facts["folder"][1]["verdict"] == UNKNOWN and "notes.txt" in facts["folder"][1]["hint"]


@pytest.mark.parametrize("kind", ["a device", "a pipe", "a loop", "binary"])
def test_a_hostile_file_is_one_line(kind: str, own: None, another: dict[Task, ldbench.Run], tmp_path: Path,
                                    capsys: pytest.CaptureFixture[str]):
    """For check and fingerprint; test_collate.py has all kinds."""
    good, _ = submitted(another[TASK], TASK, tmp_path, PLAIN)
    (tmp_path/"hostile").mkdir()
    HOSTILE[kind](tmp_path/"hostile"/good.name, good)
    for command in "check", "fingerprint":
        assert main([command, str(tmp_path/"hostile"/good.name)]) == 1
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1 and good.name in said.err


def test_a_file_that_is_no_simulation_is_told_and_does_not_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                                capsys: pytest.CaptureFixture):
    """As a folder of ours has summary.csv and files of other models beside the ten; check, score and collate take the same ones."""
    for name in (*(f"{task.name}.txt" for task in TASKS), "summary.csv", "ex2_aw_hertz.txt"):
        (tmp_path/name).write_text("time Y\n")
    importlib.import_module("ldbench_round.commands.check")     # which would keep what stands there for a while
    monkeypatch.setattr(check, "check_file", lambda file, task, map: check.Checked(file, task, None, ()))
    assert main(["check", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert f"{tmp_path}: 1 {PASSED}, 2 {UNKNOWN}" in told
    lines = [line for line in told.splitlines() if line.startswith(f"  {UNKNOWN}: file: ")]
    assert len(lines) == 2 and "summary.csv" in lines[1] and "ex2_aw_hertz.txt: expected one file" in lines[0]
    taken = find_files(tmp_path, remarks := [])
    assert {file.name for file in taken.values()} == {f"{task.name}.txt" for task in TASKS}
    assert {one.file for one in find_references(tmp_path).values()} == set(taken.values())
    assert [line.partition(": file: ")[2] for line in lines] == remarks
