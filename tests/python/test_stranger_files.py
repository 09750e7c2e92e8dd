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

import stranger_files as strangers
from ldbench import Case, Error, run
from ldbench_round.check import check_file, check_folder, read_submitted
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED
from ldbench_round.submissions import find_files
from ldbench_round.tasks import QUANTITIES, TASKS

SLOW = "LDBENCH_SLOW" in os.environ
CASES = "ex2_aw", "ex2_sw"
# What shows in files of other exercises alone.
OTHER_CASES = {
    "mistake_exercises_3_and_4_exchanged": ("ex3_aw", "ex4_aw"), "mistake_exercise_2_sent_as_3": ("ex2_aw", "ex3_aw"),
    "mistake_roll_rate_reversed": ("ex3_aw",), "mistake_exercise_5_stopped_at_40_s": ("ex5_aw",), "mistake_ramp_4": ("ex5_aw",),
    "mistake_ramp_6": ("ex5_aw",), "mistake_ramp_starts_at_50_kN": ("ex5_aw",), "faultless_exercise_1_at_2_kHz": ("ex1_aw",)}
OF_THE_FOLDER = "mistake_simulation_missing"
# Small mistakes, and another stiffness, which a contact law of another code may have.
ONLY_DOUBTFUL = {"mistake_friction_in_the_motion", "mistake_modulus_of_one_body", "mistake_angles_from_the_canted_rail"}
# Frames that are not those of the call, and another zero of time, are told.
TOLD = {"faultless_Y_to_the_right", "faultless_Z_down", "faultless_Y_right_and_Z_down", "faultless_roll_the_other_way",
        "faultless_everything_reversed", "faultless_time_from_minus_100_ms", "faultless_time_from_10_s"}


@pytest.fixture(scope="module", autouse=True)
def new_own_runs() -> Iterator[None]:
    """Our own runs, by which maps are guessed, are made here, whatever a test of another file has put there."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench_round.own_runs._OWN", {})
        yield


def some(names: Mapping[str, Any]) -> list[str]:
    """All names, or every tenth; runs with other input, and whole ramps, are for the slow tests."""
    quick = [name for name in names if name not in strangers.RUNS and name not in OTHER_CASES]
    return [name for name in names if name != OF_THE_FOLDER] if SLOW else quick[::10]


def computed(name: str, **changes: Any) -> pd.DataFrame:
    """Our columns of a simulation; a ramp has four rows in a millisecond, so that they show each contact."""
    return run(Case.exercise(int(name[2]), name[-2:]).replace(**({"interval": 2.5e-4} if name[2] == "5" else {}), **changes)).data


frame_of = functools.cache(computed)


def write(files: Mapping[str, str | bytes], folder: Path) -> None:
    for name, text in files.items():
        (folder/name).write_bytes(text if isinstance(text, bytes) else text.encode())


def worst(make: Callable[..., Mapping[str, str | bytes]], name: str, folder: Path) -> str:
    """The worst verdict on the files of a stranger that differ from plain ones."""
    frames = {case: frame_of(case) for case in OTHER_CASES.get(name, CASES)}
    arguments: list[Any] = [frames]
    if name in strangers.RUNS:
        case = next(case for case in frames if case in strangers.RUN_CASES.get(name, frames))
        arguments.append({case: computed(case, table_file="", **strangers.RUNS[name])})
    made, plain = make(*arguments), strangers._files(frames)
    write(made, folder)
    found = {task: file for task, file in find_files(folder, []).items() if made[file.name] != plain.get(file.name)}
    assert found
    verdicts = set()
    for task, file in found.items():
        try:
            verdicts |= {finding.verdict for finding in check_file(file, task).findings}
        except Error:
            verdicts.add(FAILED)
    return next((verdict for verdict in (FAILED, DOUBTFUL) if verdict in verdicts), PASSED)


@pytest.mark.parametrize("name", some(strangers.MISTAKES))
def test_a_mistake_does_not_pass(name: str, tmp_path: Path):
    assert worst(strangers.MISTAKES[name], name, tmp_path) == (DOUBTFUL if name in ONLY_DOUBTFUL else FAILED)


@pytest.mark.parametrize("name", some(strangers.FAULTLESS))
def test_a_faultless_file_passes(name: str, tmp_path: Path):
    assert worst(strangers.FAULTLESS[name], name, tmp_path) == (DOUBTFUL if name in TOLD else PASSED)


@pytest.mark.parametrize("case", ["ex3_aw", "ex4_aw", "ex5_aw"] if SLOW else ["ex3_aw"])
def test_a_plain_file_of_another_exercise_passes(case: str, tmp_path: Path):
    """So mistakes in it are not found for being there."""
    write(strangers._files({case: frame_of(case)}), tmp_path)
    assert {finding.verdict for finding in check_file(tmp_path/f"{case}.csv").findings} == {PASSED}


def test_a_missing_simulation_is_told(tmp_path: Path):
    frames = {task.name: frame_of("ex2_aw").iloc[:2] for task in TASKS}
    write(strangers.MISTAKES[OF_THE_FOLDER](frames), tmp_path)
    finding = check_folder(tmp_path)[1][0]
    assert (finding.verdict, finding.hint) == (FAILED, "missing: exercise 3, simplified profiles")
    write(strangers._files(frames), tmp_path)
    assert check_folder(tmp_path)[1][0].verdict == PASSED


@pytest.mark.parametrize("style", list(strangers.STYLES) if SLOW else ["gensys", "matlab"])
def test_a_style_of_names_has_one_map(style: str, tmp_path: Path):
    """All quantities of the call are found where they are, with the same units and signs in all files of a code."""
    truth = {column: number for number, column in enumerate(strangers.ALL, 1) if column in QUANTITIES}
    maps = []
    for case in [task.name for task in TASKS] if SLOW else CASES[:1]:
        text = strangers.STYLES[style](frame_of(case, t_end=4.0) if case[2] == "5" else frame_of(case))
        write({f"{case}.txt": text}, tmp_path)
        matches = read_submitted(tmp_path/f"{case}.txt").guess.matches
        assert {column: matches[column].number for column in matches if column in truth} == truth
        maps.append({column: (match.unit, match.sign) for column, match in matches.items()})
    assert all(one == maps[0] for one in maps)
