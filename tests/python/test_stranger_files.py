"""Files by somebody who has not read the code that judges them: mistakes are found, odd but legal forms pass."""
from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

import ldbench
import stranger_files as strangers
from ldbench import Case, ContactTable, Error
from ldbench_round.check import check_file
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED
from ldbench_round.submissions import find_files
from ldbench_round.tasks import Task

TASK = Task(2, "aw")
# Small mistakes, and another stiffness, which a contact law of another code may have.
ONLY_DOUBTFUL = {"friction in the motion", "modulus of one body", "angles from the canted rail"}
# Frames that are not those of the call, and another zero of time, are told.
TOLD = {"Y to the right", "Z down", "roll the other way", "everything reversed", "time from -100 ms", "time from 10 s"}
# Not understood: left and right as numbers, contact points from the gauge side.
NOT_UNDERSTOOD = {"numbers for sides", "contact points from the gauge side"}

pytestmark = pytest.mark.usefixtures("own")


@pytest.fixture(scope="module")
def frame(ours: dict[Task, ldbench.Run]) -> pd.DataFrame:
    return ours[TASK].data


def written(made: str | bytes, folder: Path) -> Path:
    file = folder/f"{TASK.name}.csv"
    file.write_bytes(made if isinstance(made, bytes) else made.encode())
    return file


def worst(made: str | bytes, folder: Path) -> str:
    """The worst verdict on a file."""
    try:
        verdicts = {finding.verdict for finding in check_file(written(made, folder)).findings}
    except Error:
        return FAILED
    return next((verdict for verdict in (FAILED, DOUBTFUL) if verdict in verdicts), PASSED)


@pytest.mark.parametrize("name", strangers.MISTAKES)
def test_a_mistake_does_not_pass(name: str, frame: pd.DataFrame, tmp_path: Path):
    assert worst(strangers.MISTAKES[name](frame), tmp_path) == (DOUBTFUL if name in ONLY_DOUBTFUL else FAILED)


@pytest.mark.parametrize("name", strangers.RUNS)
def test_another_input_does_not_pass(name: str, read_hertz: Callable[[str], ContactTable], tmp_path: Path):
    """Hertz's law is no mistake."""
    case = Case.exercise(2, "aw").replace(model="hertz", table_file="", **strangers.RUNS[name])
    if strangers.RUNS[name].keys() & {"stiffness_scale", "rail_profile"}:
        run = ldbench.run(case.replace(n_lateral=60, n_roll=9, n_depth=9))
    else:
        run = ldbench.run(case, table=read_hertz("aw").for_case(case))
    assert worst(strangers.text_of(run.data), tmp_path) == (DOUBTFUL if name in ONLY_DOUBTFUL else FAILED)


@pytest.mark.parametrize("task", [Task(2, "sw"), Task(3, "aw"), Task(4, "aw")], ids=str)
def test_the_file_of_another_simulation_does_not_pass(task: Task, ours: dict[Task, ldbench.Run], tmp_path: Path):
    assert worst(strangers.text_of(ours[task].data), tmp_path) == FAILED


@pytest.mark.parametrize("name", strangers.FAULTLESS)
def test_a_faultless_file_passes(name: str, frame: pd.DataFrame, tmp_path: Path):
    expected = FAILED if name in NOT_UNDERSTOOD else DOUBTFUL if name in TOLD else PASSED
    assert worst(strangers.FAULTLESS[name](frame), tmp_path) == expected


@pytest.mark.parametrize("name", ["Exercise 2 actual.txt", "MyCode_LDbench_EX2_AW.CSV"])
def test_the_name_of_a_file_tells_its_simulation(name: str, tmp_path: Path):
    (tmp_path/name).write_text("time Y\n")
    assert find_files(tmp_path, []) == {TASK: tmp_path/name}


@pytest.mark.parametrize("style", strangers.STYLES)
def test_a_style_of_names_is_understood(style: str, frame: pd.DataFrame, tmp_path: Path):
    """All quantities of the call are found."""
    checked = check_file(written(strangers.STYLES[style](frame), tmp_path))
    lost = next(finding for finding in checked.findings if finding.what == "quantities")
    assert lost.number == lost.limit
