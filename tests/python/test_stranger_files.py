"""Files by somebody who has not read the code that judges them: mistakes are found, odd but legal forms pass.

A tenth of them is tried; LDBENCH_SLOW=1 tries all.
"""
from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from ldbench import Case, Error, Run, run
from ldbench_round.check import check_file, check_folder, read_submitted
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED
from ldbench_round.submissions import find_files
from ldbench_round.tasks import QUANTITIES, TASKS, Task
from stranger_files import ALL, FAULTLESS, MISTAKES, STYLES, Row, files

SLOW = "LDBENCH_SLOW" in os.environ
CASES = ("ex2_aw", "ex2_sw") if SLOW else ("ex2_aw",)
pytestmark = [pytest.mark.usefixtures("new_own_runs"), pytest.mark.slow] if SLOW else [pytest.mark.usefixtures("own")]


@pytest.fixture(scope="module")
def new_own_runs() -> Iterator[None]:
    """Our own runs, by which maps are guessed, are made here: the shipped ones have no contact table for exercise 5."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench_round.own_runs._OWN", {})
        yield


def some(rows: Mapping[str, Row], expected: str) -> list[pytest.ParameterSet]:
    """All rows, or every tenth; runs with other input, and simulations beside exercise 2, are for the slow tests."""
    quick = [name for name, row in rows.items() if not (row.run or row.cases or row.exchanged)][::10]
    return [pytest.param(rows[name], rows[name].verdict or expected, id=name) for name in (rows if SLOW else quick)]


@functools.cache
def computed(name: str, **changes: Any) -> pd.DataFrame:
    """Our columns of a simulation; a ramp has four rows in a millisecond, so that they show each contact."""
    return run(Case.exercise(int(name[2]), name[-2:]).replace(**({"interval": 2.5e-4} if name[2] == "5" else {}), **changes)).data


@pytest.fixture
def frame_of(ours: dict[Task, Run]) -> Callable[..., pd.DataFrame]:
    known = {task.name: found.data for task, found in ours.items()}
    return lambda name: known[name] if name in known else computed(name)


def write(made: Mapping[str, str | bytes], folder: Path) -> None:
    for name, text in made.items():
        (folder/name).write_bytes(text if isinstance(text, bytes) else text.encode())


@pytest.mark.parametrize(("row", "verdict"), [*some(MISTAKES, FAILED), *some(FAULTLESS, PASSED)])
def test_a_file_gets_its_verdict(row: Row, verdict: str, frame_of: Callable[..., pd.DataFrame], tmp_path: Path):
    """The worst verdict on the files that differ from plain ones."""
    frames = {case: frame_of(case) for case in row.cases or CASES}
    case = next(iter(frames))
    made = files(row, frames, {case: computed(case, table_folder="", **row.run)} if row.run else None)
    plain = files(Row(), frames)
    write(made, tmp_path)
    found = {task: file for task, file in find_files(tmp_path, []).items() if made[file.name] != plain.get(file.name)}
    assert found
    verdicts = set()
    for task, file in found.items():
        try:
            verdicts |= {finding.verdict for finding in check_file(file, task).findings}
        except Error:
            verdicts.add(FAILED)
    assert next((one for one in (FAILED, DOUBTFUL) if one in verdicts), PASSED) == verdict


@pytest.mark.parametrize("case", ["ex3_aw", "ex4_aw", "ex5_aw"] if SLOW else ["ex3_aw"])
def test_a_plain_file_of_another_exercise_passes(case: str, frame_of: Callable[..., pd.DataFrame], tmp_path: Path):
    """So mistakes in it are not found for being there."""
    write(files(Row(), {case: frame_of(case)}), tmp_path)
    assert {finding.verdict for finding in check_file(tmp_path/f"{case}.csv").findings} == {PASSED}


def test_a_missing_simulation_is_told(frame_of: Callable[..., pd.DataFrame], tmp_path: Path):
    """The last one of the mistakes."""
    write(files(Row(), {task.name: frame_of("ex2_aw").iloc[:2] for task in TASKS if task.name != "ex3_sw"}), tmp_path)
    finding = check_folder(tmp_path)[1][0]
    assert (finding.verdict, finding.hint) == (FAILED, "missing: exercise 3, simplified profiles")


@pytest.mark.parametrize("style", STYLES if SLOW else ["gensys", "matlab"])
def test_a_style_of_names_has_one_map(style: str, frame_of: Callable[..., pd.DataFrame], tmp_path: Path):
    """All quantities of the call are found where they are, with the same units and signs in all files of a code."""
    truth = {column: number for number, column in enumerate(ALL, 1) if column in QUANTITIES}
    maps = []
    for case in [task.name for task in TASKS] if SLOW else CASES:
        write(files(STYLES[style], {case: computed(case, t_end=4.0) if case[2] == "5" else frame_of(case)}), tmp_path)
        matches = read_submitted(tmp_path/f"{case}.csv").guess.matches
        assert {column: matches[column].number for column in matches if column in truth} == truth
        maps.append({column: (match.unit, match.sign) for column, match in matches.items()})
    assert all(one == maps[0] for one in maps)
