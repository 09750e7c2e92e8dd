"""Hostile files: check, score and fingerprint tell each in one line and go on; collate is tried in test_collate.py."""
from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import imaginary_codes as imaginary
from hostile_files import HOSTILE
from ldbench import Case
from ldbench.__main__ import main
from ldbench.runs import compute
from ldbench_round import own_runs
from ldbench_round.findings import FAILED
from ldbench_round.tasks import TASKS, Task

TASK = Task(4, "aw")
UNNAMED = ("Traceback", "cannot be used: ")     # an error that nobody foresaw
NAMES = [task.name for task in TASKS if task != TASK]


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A good file of another code; our own run, by which maps are guessed, is that of every simulation."""
    run = compute(Case.exercise(4, "aw").replace(model="hertz", table_file="", n_lateral=60, n_roll=13, n_depth=11))
    file = tmp_path_factory.mktemp("good")/f"{TASK.name}.csv"
    imaginary.write(imaginary.table_of(run, 1e-4), file, imaginary.Dialect(scheme=1))
    before = dict(own_runs._OWN)
    own_runs._OWN.update(dict.fromkeys(TASKS, run))
    yield file
    own_runs._OWN.clear()
    own_runs._OWN.update(before)


@pytest.fixture(scope="module")
def folders(good: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[Path, dict[str, str]]:
    """Folders with the good file and files of all kinds under the names of the other simulations: the kinds by their names."""
    kinds, found = list(HOSTILE), {}
    for k in range(0, len(kinds), len(NAMES)):
        folder = tmp_path_factory.mktemp("hostile")
        (folder/good.name).write_bytes(good.read_bytes())
        found[folder] = {f"{name}.csv": kind for name, kind in zip(NAMES, kinds[k:], strict=False)}
        for name, kind in found[folder].items():
            HOSTILE[kind](folder/name, good)
    return found


def is_a_line(line: str, folder: Path) -> bool:
    return line.isprintable() and len(line) < 500 and str(folder) not in line and not any(word in line for word in UNNAMED)


def printed(words: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, Any]:
    """The status and the facts of a command that prints JSON and nothing else."""
    status = main([*words, "--json"])
    said = capsys.readouterr()
    assert said.err == "", said.err
    return status, json.loads(said.out)


@pytest.mark.filterwarnings("error")
def test_check_goes_on(good: Path, folders: dict[Path, dict[str, str]], capsys: pytest.CaptureFixture[str]):
    """A file that cannot be read is one finding; one that can is nonsense and fails in some."""
    _, alone = printed(["check", str(good)], capsys)
    for folder, kinds in folders.items():
        status, facts = printed(["check", str(folder)], capsys)
        assert status == 1
        files = {Path(one["file"]).name: one["findings"] for one in facts["files"]}
        assert files.pop(good.name) == alone["files"][0]["findings"]
        strange = [one["hint"] for one in facts["folder"][1:]]
        for name, kind in kinds.items():
            if name not in files:
                line, = (line for line in strange if line.startswith(f"{name}: "))
                assert is_a_line(line, folder), (kind, line)
                continue
            failed = [one for one in files[name] if one["verdict"] == FAILED]
            # The good numbers under the name of another simulation have other initial conditions.
            assert failed, kind
            assert len(files[name]) > 1 or is_a_line(failed[0]["hint"], folder), (kind, failed)


@pytest.mark.parametrize("command", ["check", "fingerprint"])
@pytest.mark.parametrize("kind", ["a device", "a pipe", "a loop", "a folder", "binary"])
def test_a_hostile_file_alone_is_one_line(command: str, kind: str, good: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    HOSTILE[kind](tmp_path/good.name, good)
    if (command, kind) != ("check", "a folder"):        # which is one of ten files that are missing
        assert main([command, str(tmp_path/good.name)]) == 1
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1 and good.name in said.err
