"""Submissions of imaginary codes: the map of their columns, and what is wrong with them."""
from __future__ import annotations

import importlib
import itertools
import json
import re
from pathlib import Path

import numpy as np
import pytest

import imaginary_physics as physics
import ldbench
from hostile_files import HOSTILE
from imaginary_round import RIGHTWARDS, table_of, write
from invented import COARSE, altered, invented_run
from ldbench import Case, ContactTable
from ldbench.__main__ import main
from ldbench.results.columns import RawTable
from ldbench_round import check, physics_checks
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding
from ldbench_round.kept_entries import find_references
from ldbench_round.map_guess import find_time
from ldbench_round.submissions import find_files
from ldbench_round.tasks import TASKS, Task
from running import Run, kept_tables
from stranger_files import CALL, MM_KN, ROLL, Row, both, of, plus, times

TASK = Task(2, "aw")
PLAIN = Row(form={"units": MM_KN})
SHUFFLED = ["time", *np.random.default_rng(3).permutation(CALL[1:]).tolist()]


@pytest.fixture(scope="module")
def another() -> ldbench.Run:
    """Exercise 2 by a code with another contact law, of a steel that is softer by a fifth."""
    return ldbench.run(Case.exercise(2, "aw").replace(COARSE, stiffness_scale=0.8))


def findings_in(file: Path) -> dict[str, Finding]:
    """The findings by what they are about."""
    return {finding.what: finding for finding in check.check_file(file).findings}


def test_a_wrong_clearance_is_told_with_both_numbers(another: ldbench.Run):
    wide = altered(another, data=another.data.assign(Y=lambda rows: 1.2*rows.Y))
    found, = physics_checks.clearance_findings(wide, TASK)
    expected, seen = map(float, re.search(r"expected Y = (\S+) mm, found (\S+) mm", found.hint).groups())
    assert found.verdict == FAILED and expected == 10.18 and seen == pytest.approx(1.2*10.18, rel=0.02)


# ---- maps ----------------------------------------------------------------------------
def test_a_file_without_names_is_mapped_by_its_numbers(own: None, shipped: dict[str, Run], tmp_path: Path):
    """Where the physics is ours, every one of 38 nameless columns is found."""
    file = tmp_path/"ex2_aw.csv"
    write(table_of(ldbench.read_run(shipped["ex2_aw"].file)), file, Row(RIGHTWARDS, {
        "units": MM_KN, "head": ("{name}",), "order": SHUFFLED, "names": {column: f"c{k}" for k, column in enumerate(SHUFFLED)}}))
    found = check.check_file(file)
    assert {column: match.number for column, match in found.guess.matches.items()} == {c: k for k, c in enumerate(SHUFFLED, 1)}


def test_the_map_that_is_printed_is_the_map(own: None, another: ldbench.Run, tmp_path: Path, capsys: pytest.CaptureFixture):
    file, toml = tmp_path/"ex2_aw.csv", tmp_path/"map.toml"
    write(table_of(another), file, Row(both(times(-1.0, *ROLL), plus(0.457, "Z")), PLAIN.form))
    assert main(["check", str(file), "--save-map", str(toml)]) == 0
    capsys.readouterr()
    assert main(["check", str(file)]) == 0
    assert " = { column" not in capsys.readouterr().out
    assert main(["check", str(file), "--show-map"]) == 0
    assert [line.strip() for line in toml.read_text().splitlines()] \
        == [line.strip() for line in capsys.readouterr().out.splitlines() if " = { column" in line]
    mapped, guessed = check.check_file(file, map=toml), check.check_file(file)
    assert mapped.guess is None and mapped.findings == guessed.findings[-len(mapped.findings):]


# ---- findings ------------------------------------------------------------------------
@pytest.mark.parametrize("task", [
    pytest.param(task, marks=() if task.name == "ex2_aw" else pytest.mark.slow, id=task.name) for task in TASKS])
def test_our_runs_fail_in_nothing(task: Task, shipped: dict[str, Run]):
    """In exercise 5 rows are too far apart for the impacts; everything else is passed."""
    found = check.check_file(shipped[task.name].file)
    assert found.guess is None and not any(finding.verdict == FAILED for finding in found.findings)
    doubtful = {finding.hint for finding in found.findings if finding.verdict == DOUBTFUL}
    assert doubtful <= ({"rows too far apart for the impacts"} if task.exercise == 5 else set()), doubtful


@pytest.mark.slow
def test_mistakes_are_found_in_thousands_of_impacts():
    """Columns with another factor and another zero, of which each is in one law alone, in the last 20 s of exercise 5."""
    case = Case.exercise(5, "aw").replace(model="hertz", table_folder=kept_tables(), rows="interval", interval=2e-4, dt=2e-4)
    ramp = ldbench.run(case, table=ContactTable(case)).data
    late = ramp[ramp["time"] > ramp["time"].iloc[-1] - 20]
    for mistakes in ({"roll acceleration is the rate of the velocity": ("roll_acc", 0.9, 0.0),
                      "roll momentum closes": ("y_LF", 1.0, 0.03), "angle_LF is that of the force": ("angle_LF", 1.0, -0.3)},
                     {"lateral momentum closes": ("Fy_LF", 0.9, 0.0)}):
        wrong = late.assign(**{column: factor*late[column] + zero for column, factor, zero in mistakes.values()})
        findings = check.findings_of(check.SubmittedFile(Task(5, "aw"), invented_run(wrong), None))
        assert mistakes.keys() <= {finding.what for finding in findings if finding.verdict in (FAILED, DOUBTFUL)}


def test_the_unit_of_the_time_is_that_of_the_length():
    """Also where the file states another one; the length is known within a factor of 5."""
    for length, factor, unit in (54.0, 1.0, "s"), (54.0, 1e3, "ms"), (0.5, 1.0, "s"), (0.05, 1e3, "ms"):
        t = factor*np.linspace(0, length, 100)
        for said, expected in itertools.product(["s", ""], [length/5, length, 5*length]):
            found = find_time(Path("x.csv"), RawTable(["t", "y"], [said, "m"], np.column_stack([t, t])), expected)
            assert (found.unit, found.said) == (unit, said), (length, expected)


@pytest.mark.parametrize(("task", "restitution"), [(TASK, 0.0), (Task(2, "sw"), 1.0)], ids=["plastic", "elastic"])
def test_a_rigid_code_is_not_wrong_for_being_rigid(task: Task, restitution: float, own: None, tmp_path: Path):
    """It has no column of impulses: momentum jumps, closes between, and is doubtful with a hint; so is a restitution below 1."""
    file, frame = tmp_path/f"{task.name}.csv", table_of(physics.rigid(task, restitution))
    write(frame, file, PLAIN)
    found = findings_in(file)
    assert [finding.what for finding in found.values() if finding.verdict == FAILED] == []
    assert found["vertical momentum closes"].verdict == DOUBTFUL and found["vertical momentum closes"].hint
    assert (found["energy closes"].verdict == DOUBTFUL) == (restitution < 1)
    if restitution == 0:        # between impacts, forces have to agree with velocities: here the vertical ones lack a fifth
        write(times(0.8, *of("Fz"))(frame), file, PLAIN)
        assert findings_in(file)["vertical momentum closes"].verdict == FAILED


def test_a_loss_of_energy_is_the_only_finding(own: None, tmp_path: Path):
    """An integrator that damps loses energy at impacts; momentum, rates and geometry are as they should be."""
    case = Case.exercise(2, "aw").replace(COARSE, order=2, beta=0.3025, gamma=0.6, dt=5e-5, energy_tolerance=0.0,
                                          error_tolerance=0.0)
    write(table_of(ldbench.run(case)), tmp_path/"ex2_aw.csv", PLAIN)
    found = {what: finding.verdict for what, finding in findings_in(tmp_path/"ex2_aw.csv").items() if finding.verdict != PASSED}
    assert list(found) == ["energy closes"] and found["energy closes"] in (DOUBTFUL, FAILED)


def test_a_folder_says_what_is_missing_and_goes_on(own: None, another: ldbench.Run, tmp_path: Path,
                                                    capsys: pytest.CaptureFixture):
    write(table_of(another), tmp_path/"ex2_aw.csv", PLAIN)
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


@pytest.mark.parametrize("kind", ["a device", "binary"])
def test_a_hostile_file_is_one_line(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """For check and fingerprint; test_collate.py has all kinds."""
    file = tmp_path/"ex2_aw.csv"
    (tmp_path/"good.csv").write_text("time,Y\n0.0,1.0\n")
    HOSTILE[kind](file, tmp_path/"good.csv")
    for command in "check", "fingerprint":
        assert main([command, str(file)]) == 1
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1 and file.name in said.err


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
