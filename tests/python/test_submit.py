"""What a participant sends: all of it, checked, and never over anything of somebody's own."""
from __future__ import annotations

import errno
import hashlib
import json
import shutil
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from invented import COARSE
from ldbench import Case, Error, run
from ldbench.__main__ import main
from ldbench.plots.sheets import save_sheets
from ldbench_round import submit
from ldbench_round.check import Checked
from ldbench_round.findings import FAILED, PASSED, Finding
from ldbench_round.submissions import read_submission
from ldbench_round.tasks import CLEARANCES, TASKS, Task, clearances
from running import REPO, Run

ABOUT = """code = "Contura"
version = "3.2"
authors = ["A. Author", "B. Author"]
organisation = "Institute, Town"
email = "a.author@institute.org"
formulation = "elastic"
map = "columns.toml"
"""
NAMES = {*(f"{task.name}.csv" for task in TASKS), "plots.pdf", "abstract.pdf", "submission.toml", "columns.toml", "SHA256SUMS"}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder that lacks nothing, with things that are not sent; `check` finds nothing in files that hold a number."""
    def judged(file: Path, task: Task, map: Any = None) -> Checked:
        fine = file.read_text().strip().isdigit() and map == {"time": 1}
        return Checked(file, task, None, (Finding("mass", PASSED if fine else FAILED, hint="" if fine else "no number"),))

    monkeypatch.setattr(submit, "check_file", judged)
    monkeypatch.chdir(tmp_path)
    here = tmp_path/"outputs"
    here.mkdir()
    for k, task in enumerate(TASKS):
        (here/f"Exercise {task.exercise} {'actual' if task.profiles == 'aw' else 'simplified'}.CSV").write_text(f"{k}\n")
    for name, pages in ("my_plots.pdf", 6), ("Abstract.pdf", 4):
        save_sheets([Figure(figsize=(2, 2)) for _ in range(pages)], here/name)
    (here/"submission.toml").write_text(ABOUT)
    (here/"columns.toml").write_text("time = 1\n")
    (here/"summary.csv").write_text("not sent\n")
    return here


def test_a_template_is_written_once_and_says_nothing_until_it_is_filled_in(folder: Path, capsys: pytest.CaptureFixture[str]):
    """Every key that is missing is in it with an example, which is not sent as it stands."""
    (folder/"submission.toml").unlink()
    assert main(["submit", "outputs", "--template"]) == 0
    template = folder/"submission.toml"
    assert main(["submit", "outputs"]) == 1
    missing = {line.split(" = ")[0].split()[-1] for line in capsys.readouterr().out.splitlines() if "expected " in line}
    words = template.read_text()
    filled = "".join(line.removeprefix("# ") for line in words.splitlines(keepends=True)[1:])
    assert missing == {line.split(" = ")[0] for line in filled.splitlines()}
    template.write_text(filled + 'map = "columns.toml"\n')
    assert main(["submit", "outputs"]) == 0
    assert main(["submit", "outputs", "--template"]) == 1 and template.read_text() != words
    assert "expected no such file, found one" in capsys.readouterr().err


def contents(target: Path) -> dict[str, bytes]:
    if target.suffix == ".zip":
        with zipfile.ZipFile(target) as archive:
            return {name.removeprefix(f"{target.stem}/"): archive.read(name) for name in archive.namelist()}
    return {str(path.relative_to(target)): path.read_bytes() for path in target.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", ["mine", "mine.zip"])
def test_all_is_sent_and_nothing_else(name: str, folder: Path, capsys: pytest.CaptureFixture[str]):
    """Twice with the same bytes; the checksums are those of the files, and an organiser reads all of it."""
    target = Path(name)
    made = []
    for _ in range(2):
        assert main(["submit", "outputs", "-o", name]) == 0
        made.append((contents(target), target.read_bytes() if target.is_file() else b""))
    assert made[0] == made[1]
    found = made[0][0]
    assert found.keys() == NAMES
    assert found["ex2_sw.csv"] == (folder/"Exercise 2 simplified.CSV").read_bytes()
    assert found["plots.pdf"] == (folder/"my_plots.pdf").read_bytes()
    for line in found["SHA256SUMS"].decode().splitlines():
        digest, _, file = line.partition("  ")
        assert hashlib.sha256(found.pop(file)).hexdigest() == digest
    assert found.keys() == {"SHA256SUMS"}
    assert {one.name for one in Path().iterdir()} == {"outputs", name}
    if not target.is_dir():
        shutil.unpack_archive(target)
    code = read_submission(Path("mine"), "Contura")
    assert code.remarks == () and len(code.files) == 10 and code.facts["authors"] == "A. Author, B. Author"
    assert subprocess.run(["sha256sum", "--check", "--quiet", "SHA256SUMS"], cwd="mine", check=True)


@pytest.mark.parametrize(("change", "told"), [
    *((lambda f, key=key: edit(f, key, None), f"submission.toml: expected {key} = ") for key in submit.REQUIRED),
    (lambda f: edit(f, "email", '"A. Author"'), "submission.toml: email: expected one address"),
    (lambda f: edit(f, "formulation", '"magic"'), "submission.toml: formulation: expected elastic or constraints"),
    (lambda f: edit(f, "code", '"One"\ncodes = 2'), "submission.toml: expected keys among"),
    (lambda f: edit(f, "map", '"../outside.toml"'), "map: expected a file of the code's folder"),
    (lambda f: (f/"submission.toml").write_text("code = "), "submission.toml"),
    (lambda f: (f/"submission.toml").unlink(), "submission.toml: expected a file with the keys code, version"),
    (lambda f: (f/"Exercise 4 actual.CSV").unlink(), "ex4_aw: expected the column file of exercise 4, actual profiles"),
    (lambda f: (f/"Exercise 4 actual.CSV").write_text("words"), "Exercise 4 actual.CSV: `check` refuses it: mass: no number"),
    (lambda f: (f/"Abstract.pdf").unlink(), "expected the abstract, one file *abstract*.pdf"),
    (lambda f: shutil.copy(f/"my_plots.pdf", f/"Abstract.pdf"), "Abstract.pdf: expected at most 4 pages, found 6"),
    (lambda f: (f/"my_plots.pdf").write_text("%PDF"), "my_plots.pdf: expected a PDF"),
    (lambda f: shutil.copy(f/"my_plots.pdf", f/"plots_2.pdf"), "expected the PDF of plots, one file *plot*.pdf"),
    (lambda f: edit(f, "code", '"One"\nplots = "none.pdf"'), "plots: expected the PDF of plots")])
def test_what_is_missing_is_one_line_and_nothing_is_written(change: Any, told: str, folder: Path,
                                                                capsys: pytest.CaptureFixture[str]):
    change(folder)
    assert main(["submit", "outputs", "-o", "mine"]) == 1
    said = capsys.readouterr()
    # Without its map no file is read as it should be.
    lines = [line for line in said.out.splitlines() if "`check` refuses" not in line or "`check` refuses" in told]
    assert len(lines) == 1 and told in lines[0], said.out
    assert said.err.startswith("ldbench: error: outputs: expected all that a participant sends, found ")
    assert not Path("mine").exists()
    assert main(["submit", "outputs", "-o", "mine", "--json"]) == 1
    assert lines[0] in json.loads(capsys.readouterr().out)["missing"]


def edit(folder: Path, key: str, value: str | None) -> None:
    """Give a key of the description another value, or remove it."""
    file = folder/"submission.toml"
    lines = [line for line in file.read_text().splitlines() if not line.startswith(f"{key} =")]
    file.write_text("\n".join([*lines, *([f"{key} = {value}"] if value else [])]) + "\n")


@pytest.mark.parametrize("name", ["mine", "mine.zip"])
def test_nothing_of_somebody_s_own_is_replaced(name: str, folder: Path, capsys: pytest.CaptureFixture[str]):
    """Neither a stranger's folder or file, nor a parcel to which somebody has added or changed something."""
    target = Path(name)

    def refused() -> None:
        before = contents(target) if target.is_dir() else target.read_bytes()
        assert main(["submit", "outputs", "-o", name]) == 1
        assert "expected no file or folder, or what " in capsys.readouterr().err
        assert (contents(target) if target.is_dir() else target.read_bytes()) == before

    if name == "mine":
        target.mkdir()
        (target/"thesis.txt").write_text("years of work")
        refused()
        shutil.rmtree(target)
        target.write_text("a file")
        refused()
        target.unlink()
        target.mkdir()      # empty: taken
        assert main(["submit", "outputs", "-o", name]) == 0
        (target/"notes.txt").write_text("mine")
        refused()
        (target/"notes.txt").unlink()
        (target/"submission.toml").write_text("changed")
        refused()
    else:
        target.write_bytes(b"no zip")
        refused()
        target.unlink()
        assert main(["submit", "outputs", "-o", name]) == 0
        with zipfile.ZipFile(target, "a") as archive:
            archive.writestr("notes.txt", "mine")
        refused()


@pytest.mark.parametrize("name", ["mine", "mine.zip"])
def test_a_full_disk_is_one_line_and_leaves_the_earlier_parcel(name: str, folder: Path, capsys: pytest.CaptureFixture[str],
                                                               monkeypatch: pytest.MonkeyPatch):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    assert main(["submit", "outputs", "-o", name]) == 0
    before = contents(Path(name))
    monkeypatch.setattr(Path, "write_bytes", full)
    monkeypatch.setattr(zipfile.ZipFile, "writestr", full)
    capsys.readouterr()
    assert main(["submit", "outputs", "-o", name]) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert said == f"ldbench: error: {name}: cannot be written completely: No space left on device"
    assert contents(Path(name)) == before and {one.name for one in Path().iterdir()} == {"outputs", name}


def test_usage(folder: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["submit"]) == 2 and main(["submit", "none"]) == 1 and main(["submit", "outputs/submission.toml"]) == 1
    assert "expected a folder with the files of a submission, found a file" in capsys.readouterr().err


def test_our_own_runs_are_sent(shipped: dict[str, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The real check has nothing against the shipped runs; test_check.py has those of exercise 5, two files of 75 MB."""
    monkeypatch.chdir(tmp_path)
    real = submit.check_file
    monkeypatch.setattr(submit, "check_file", lambda file, task, map: real(file, task, map) if task.exercise < 5 else
                        Checked(file, task, None, ()))
    for name, one in shipped.items():
        Path(f"{name}.txt").write_bytes(one.file.read_bytes() if name[2] < "5" else b"1\n")
    for name in "plots.pdf", "abstract.pdf":
        save_sheets([Figure(figsize=(2, 2))], Path(name))
    Path("submission.toml").write_text(ABOUT.replace('map = "columns.toml"\n', ""))
    assert main(["submit", ".", "-o", "sent"]) == 0
    assert {one.suffix for one in Path("sent").iterdir()} == {".txt", ".pdf", ".toml", ""}


# ---- the clearances of a round -------------------------------------------------------
@pytest.fixture
def another_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of clearances of a round with profiles of its own."""
    shutil.copytree(REPO/"inputs", tmp_path/"inputs")
    shutil.copytree(REPO/"profiles", tmp_path/"profiles")
    monkeypatch.chdir(tmp_path)
    clearances.cache_clear()
    yield tmp_path/CLEARANCES
    clearances.cache_clear()


def test_clearances_are_those_of_the_file_beside_the_profiles(another_round: Path):
    """`check` judges the first contact by them."""
    from ldbench_round.physics_checks import clearance_findings

    assert {pair: Task(1, pair).clearance for pair in ("aw", "sw")} == {"aw": 10.18e-3, "sw": 16.94e-3}
    found = run(Case.exercise(2).replace(COARSE, t_end=0.03, stop_at="t_end"))
    verdicts = {}
    for clearance in 10.18, 12.5:
        another_round.write_text(f"aw = {clearance}\nsw = 16.94\n")
        clearances.cache_clear()
        (finding,) = clearance_findings(found, Task(2, "aw"))
        verdicts[clearance] = finding.verdict
    assert verdicts == {10.18: PASSED, 12.5: FAILED}


@pytest.mark.parametrize(("text", "told"), [("aw = 10\n", "sw: expected the published clearance .* found none"),
                                            ("aw = 'ten'\nsw = 1\n", "found ten"), ("aw = -1\nsw = 1\n", "found -1"),
                                            ("aw = 10180\nsw = 1\n", "found 10180"), ("aw = \n", "line 1")])
def test_a_wrong_file_of_clearances_is_one_line(text: str, told: str, another_round: Path):
    another_round.write_text(text)
    with pytest.raises(Error, match=told):
        _ = Task(1, "aw").clearance
