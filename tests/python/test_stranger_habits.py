"""Thirty habits of writing a file pass, and thirty planted faults are told: by name, with a number, and where it is.

A third of them is tried; LDBENCH_SLOW=1 tries all.
"""
from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import ldbench
from ldbench import Case, Error, Run, run
from ldbench.__main__ import main
from ldbench.results.columns import read_raw
from ldbench_round.check import check_file, read_submitted
from ldbench_round.column_names import meanings
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED, Finding, apart_text
from ldbench_round.submissions import find_files
from ldbench_round.tasks import QUANTITIES, Task
from stranger_files import ALL, Row, files
from stranger_habits import CHINESE, HABITS, ITALIAN, JAPANESE, PLANTED, POLISH, RUSSIAN, SPANISH, TWO_DIGITS, Fault

SLOW = "LDBENCH_SLOW" in os.environ
pytestmark = [pytest.mark.usefixtures("own"), *([pytest.mark.slow] if SLOW else [])]


def some(names: Mapping[str, Any]) -> list[str]:
    """All names, or every third; other exercises than the second are for the slow tests."""
    return list(names) if SLOW else [name for name in list(names)[::3] if not getattr(names[name], "row", names[name]).cases]


@pytest.fixture
def judge(ours: dict[Task, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Row], tuple[list[Finding], str]]:
    """The findings about the file of a row, and the error where it is refused."""
    def judged(row: Row) -> tuple[list[Finding], str]:
        case = row.cases[0] if row.cases else "ex2_aw"
        frame = next((found.data for task, found in ours.items() if task.name == case), None)
        if frame is None:
            monkeypatch.setattr("ldbench_round.own_runs._OWN", {})      # the shipped runs have no contact table for exercise 5
            frame = run(Case.exercise(int(case[2]), case[-2:]).replace(interval=2.5e-4)).data
        (name, text), = files(row, {case: frame}).items()
        (tmp_path/name).write_bytes(text if isinstance(text, bytes) else text.encode())
        (task, file), = find_files(tmp_path, []).items()
        try:
            return list(check_file(file, task).findings), ""
        except Error as error:
            return [], str(error)
    return judged


def verdict_on(findings: list[Finding]) -> str:
    return next((one for one in (FAILED, DOUBTFUL) if one in {finding.verdict for finding in findings}), PASSED)


@pytest.mark.parametrize("name", some(HABITS))
def test_a_habit_is_no_fault(name: str, judge: Callable[[Row], tuple[list[Finding], str]]):
    findings, refused = judge(HABITS[name])
    assert (refused, verdict_on(findings)) == ("", HABITS[name].verdict or PASSED), \
        [finding for finding in findings if finding.verdict != PASSED]


@pytest.mark.parametrize("name", some(PLANTED))
def test_a_planted_fault_is_told(name: str, judge: Callable[[Row], tuple[list[Finding], str]]):
    """One of the findings, or the refusal, names it; a finding of a row has the time of the row."""
    planted: Fault = PLANTED[name]
    findings, refused = judge(planted.row)
    told = [f"{one.what}: {one.hint}" for one in findings if one.verdict in (DOUBTFUL, FAILED)]
    assert re.search(planted.words, " | ".join([*told, refused])), (told, refused)
    assert all(np.isfinite(one.time) for one in findings if one.row is not None)


def text_with(cells: str) -> str:
    return "time,Y,N_LF\n0,1,2\n" + cells + "0.3,4,5\n"


@pytest.mark.parametrize("word", [
    "#N/A", "#NV", "****", "########", "-1.#IND", "1.#QNAN", "nan(ind)", "n.a.", "--", "\u2014", "NULL"])
def test_a_word_for_no_number_is_counted_and_placed(word: str, tmp_path: Path):
    file = tmp_path/"a.csv"
    file.write_text(text_with(f"0.1,{word},3\n0.2,3,{word}\n"), encoding="utf-8")
    raw = read_raw(file)
    assert np.isnan(raw.numbers).sum() == 2 and raw.numbers.shape == (4, 3)
    assert raw.words == ((word, 2, 3, 2),)
    assert ldbench.read_columns(file).attrs["words"] == raw.words


def test_a_first_cell_without_a_number_is_no_comment(tmp_path: Path):
    file = tmp_path/"a.csv"
    file.write_text(text_with("#N/A,1,3\n****,3,4\n# 1,2,3 of old\n"), encoding="utf-8")
    assert read_raw(file).numbers[:, 1].tolist() == [1, 1, 3, 4]


@pytest.mark.parametrize(("cells", "line"), [("0.2,3\n", 3), ("0.2,3,x\n", 3), ("some words between\n", 3)])
def test_a_row_that_is_none_is_refused(cells: str, line: int, tmp_path: Path):
    file = tmp_path/"a.csv"
    file.write_text(text_with(cells), encoding="utf-8")
    with pytest.raises(Error, match=f"line {line}: expected 3 numbers"):
        read_raw(file)
    file.write_text(text_with("") + "0.4,5\n", encoding="utf-8")        # broke off
    with pytest.raises(Error, match="line 4: expected 3 numbers"):
        read_raw(file)


@pytest.mark.parametrize("names", [ITALIAN, SPANISH, POLISH, RUSSIAN, CHINESE, JAPANESE])
def test_names_of_other_languages_are_understood(names: dict[str, str]):
    assert {column: meanings(names[column]) for column in QUANTITIES} == {column: {column} for column in QUANTITIES}


def test_of_two_digits_either_may_be_the_wheel():
    assert meanings(TWO_DIGITS["Fz_LF"]) == {"Fz_LF", "Fz_RT"} and meanings(TWO_DIGITS["Fz_LT"]) == {"Fz_LT"}


def test_what_is_missing_is_printed_with_its_place(ours: dict[Task, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Words in cells that need no number are told, too, and do not fail."""
    frame = next(found.data for task, found in ours.items() if task.name == "ex2_aw")
    text = files(HABITS["not_available_of_a_spreadsheet"], {"ex2_aw": frame})["ex2_aw.csv"]
    (tmp_path/"ex2_aw.csv").write_text(str(text), encoding="utf-8")
    assert main(["check", str(tmp_path/"ex2_aw.csv")]) == 0
    empty = int(frame[list(ALL)].isna().to_numpy().sum())
    told = rf"words for no number [\d·⁰-⁹.]+: '#N/A' {empty} times, first in line 3, column \d+\n"
    assert re.search(told, capsys.readouterr().out)
    spoilt = frame.assign(vY=frame.vY.mask(frame.index == 40), aZ=frame.aZ.mask(frame.index == 41))
    (tmp_path/"ex2_aw.csv").write_text(str(files(Row(), {"ex2_aw": spoilt})["ex2_aw.csv"]), encoding="utf-8")
    assert main(["check", str(tmp_path/"ex2_aw.csv")]) == 1
    told = capsys.readouterr().out
    assert f"failed: numbers 1 (limit 0), row 41 at {frame.time[40]:.6g} s: cells without a number: 1 of vY" in told
    assert f"doubtful: numbers of accelerations 1 (limit 0), row 42 at {frame.time[41]:.6g} s" in told


def test_times_that_fall_by_more_than_their_rounding_are_refused(ours: dict[Task, Run], tmp_path: Path):
    frame = next(found.data for task, found in ours.items() if task.name == "ex2_aw").copy()
    coarse = frame.assign(time=frame.time.round(3))
    coarse.loc[500, "time"] -= 0.0021
    (tmp_path/"ex2_aw.csv").write_text(str(files(Row(), {"ex2_aw": coarse})["ex2_aw.csv"]), encoding="utf-8")
    with pytest.raises(Error, match=r"found 'time', which falls 1 time, first from .* in row 501"):
        read_submitted(tmp_path/"ex2_aw.csv")
    (tmp_path/"ex2_aw.csv").write_text(
        str(files(Row(), {"ex2_aw": frame.assign(time=frame.time.round(3))})["ex2_aw.csv"]), encoding="utf-8")
    read = read_submitted(tmp_path/"ex2_aw.csv").run
    assert (np.diff(read.time) > 0).all() and np.abs(read.time - frame.time).max() < 1e-3


@pytest.mark.parametrize(("x", "limits", "words"), [
    (0.0204, [0.02], "0.0204"), (0.02004, [0.02], "0.02004"), (0.02, [0.02], "0.02"), (0.5, [0.02], "0.5"),
    (99.9999, [np.nextafter(100.0, 0.0)], "99.9999"), (float("nan"), [0.02], "–")])
def test_a_number_shows_on_which_side_of_its_limit_it_is(x: float, limits: list[float], words: str):
    assert apart_text(x, limits) == words


def test_a_drift_below_what_is_told_passes_and_a_slow_velocity_is_none(ours: dict[Task, Run], tmp_path: Path):
    """A velocity half a row late, as that of a half-step scheme, is no drift."""
    frame: pd.DataFrame = next(found.data for task, found in ours.items() if task.name == "ex2_aw")
    for change, verdict in ((lambda f: f.assign(Y=f.Y + 2e-5*f.time/f.time.iloc[-1]), PASSED),
                            (lambda f: f.assign(Y=f.Y - 5e-6*(f.vY - f.vY.iloc[0])), PASSED),
                            (lambda f: f.assign(Y=f.Y + 2e-4*f.time/f.time.iloc[-1]), DOUBTFUL)):
        (tmp_path/"ex2_aw.csv").write_text(str(files(Row(change), {"ex2_aw": frame})["ex2_aw.csv"]), encoding="utf-8")
        found = {one.what: one for one in check_file(tmp_path/"ex2_aw.csv").findings}["Y does not drift"]
        assert found.verdict == verdict, found
        if verdict == DOUBTFUL:
            assert found.number*np.ptp(frame.Y + 2e-4*frame.time/frame.time.iloc[-1]) == pytest.approx(2e-4, rel=0.15)
            assert found.time == pytest.approx(frame.time.iloc[-1], rel=0.01)
