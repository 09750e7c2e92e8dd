"""Files by somebody who has not read the code that judges them: mistakes are found, odd but legal forms pass.

A tenth of them is tried; LDBENCH_SLOW=1 tries all.
"""
from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

import stranger_files as strangers
from ldbench import Case, Error, run
from ldbench_round.check import check_file
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED
from ldbench_round.submissions import find_files

CASES = "ex2_aw", "ex2_sw"
NO_FILE = "changes no file of exercise 2 that check takes"
SLOW = "LDBENCH_SLOW" in os.environ
# What check does not see: a missing file is the folder's matter.
SILENT = {"mistake_simulation_missing"}
# Small mistakes, and another stiffness, which a contact law of another code may have.
ONLY_DOUBTFUL = {"mistake_friction_in_the_motion", "mistake_modulus_of_one_body", "mistake_angles_from_the_canted_rail"}
# Frames that are not those of the call, and another zero of time, are told.
TOLD = {"faultless_Y_to_the_right", "faultless_Z_down", "faultless_Y_right_and_Z_down", "faultless_roll_the_other_way",
        "faultless_everything_reversed", "faultless_time_from_minus_100_ms", "faultless_time_from_10_s"}
# Not understood: left and right as numbers, names of columns in a table above, forces outwards on either side, contact points
# from the gauge side, and names of files that no rule gives.
NOT_UNDERSTOOD = {"faultless_numbers_for_sides", "faultless_table_of_columns_in_the_header",
                  "faultless_lateral_forces_on_the_rail_outwards", "faultless_contact_points_from_the_gauge_side",
                  "faultless_names_of_files_with_profiles"}


def some(names: Mapping[str, Any]) -> list[str]:
    """All names, or every tenth; runs with other input are for the slow tests."""
    return list(names) if SLOW else [name for name in names if name not in strangers.RUNS][::10]


@pytest.fixture(scope="module")
def frames() -> dict[str, pd.DataFrame]:
    """Our columns of two simulations."""
    return {name: run(Case.exercise(int(name[2]), name[-2:])).data for name in CASES}


def worst(make: Callable[..., Mapping[str, str | bytes]], name: str, frames: dict[str, pd.DataFrame], folder: Path) -> str:
    """The worst verdict on the files of a stranger that differ from plain ones."""
    arguments: list[Any] = [frames]
    if name in strangers.RUNS:
        cases = [case for case in strangers.RUN_CASES.get(name, CASES) if case in CASES]
        arguments.append({case: run(Case.exercise(int(case[2]), case[-2:]).replace(table_file="", **strangers.RUNS[name])).data
                          for case in cases[:1]})
    made, plain = make(*arguments), strangers._files(frames)
    for file, text in made.items():
        (folder/file).parent.mkdir(parents=True, exist_ok=True)
        (folder/file).write_bytes(text if isinstance(text, bytes) else text.encode())
    found = {task: file for task, file in find_files(folder, []).items() if made[file.name] != plain.get(file.name)}
    verdicts = set()
    for task, file in found.items():
        try:
            verdicts |= {finding.verdict for finding in check_file(file, task).findings}
        except Error:
            verdicts.add(FAILED)
    return next((verdict for verdict in (FAILED, DOUBTFUL) if verdict in verdicts), PASSED if found else NO_FILE)


@pytest.mark.parametrize("name", some(strangers.MISTAKES))
def test_a_mistake_does_not_pass(name: str, frames: dict[str, pd.DataFrame], tmp_path: Path):
    if name in SILENT:
        pytest.skip("check cannot see it")
    verdict = worst(strangers.MISTAKES[name], name, frames, tmp_path)
    if verdict == NO_FILE:
        pytest.skip(NO_FILE)
    assert verdict == (DOUBTFUL if name in ONLY_DOUBTFUL else FAILED)


@pytest.mark.parametrize("name", some(strangers.FAULTLESS))
def test_a_faultless_file_passes(name: str, frames: dict[str, pd.DataFrame], tmp_path: Path):
    verdict = worst(strangers.FAULTLESS[name], name, frames, tmp_path)
    if verdict == NO_FILE:
        pytest.skip(NO_FILE)
    assert verdict == (FAILED if name in NOT_UNDERSTOOD else DOUBTFUL if name in TOLD else PASSED)


@pytest.mark.parametrize("style", list(strangers.STYLES) if SLOW else ["gensys", "german"])
def test_a_style_of_names_is_understood(style: str, frames: dict[str, pd.DataFrame], tmp_path: Path):
    """All quantities of the call are found."""
    text = strangers.STYLES[style](frames["ex2_aw"])
    file = tmp_path/"ex2_aw.txt"
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    checked = check_file(file)
    lost = next(finding for finding in checked.findings if finding.what == "quantities")
    assert lost.number == lost.limit
