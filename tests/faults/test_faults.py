"""What goes wrong around the program: it is killed, the disk is full, memory ends, files are damaged, streams are closed.

Every time the earlier result is whole, one line says what is the matter, and the next run goes on.
"""
from __future__ import annotations

import itertools
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import ldbench
from ldbench.__main__ import main
from ldbench.plots.document import case_figures
from running import FORTRAN_TESTS, HANG, LDBENCH, REPO, bare_environment, contents, short_case

KILLS = 6
SEED = 11
KEPT = "columns.1.txt"      # the column file of another case from then on


def run(folder: Path, **limits: object) -> subprocess.CompletedProcess[str]:
    """The case of a folder, by the executable."""
    return subprocess.run([LDBENCH, "case.nml"], cwd=folder, capture_output=True, text=True, timeout=HANG, **limits)


def one_line(done: subprocess.CompletedProcess[str], *words: str) -> None:
    assert done.returncode == 1, done.stderr
    assert re.fullmatch(r"ldbench: error: [^\n]+\n", done.stderr), done.stderr
    for word in words:
        assert word in done.stderr


def limited(folder: Path, what: int, most: int) -> subprocess.CompletedProcess[str]:
    return run(folder, preexec_fn=lambda: resource.setrlimit(what, (most, most)))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a case that writes a table and columns; and these."""
    folder = tmp_path_factory.mktemp("made")
    (folder/"case.nml").write_text(short_case(
        Path(), table={"folder": "."}, output={"file": "columns.txt"}))
    assert run(folder).returncode == 0
    return folder


@pytest.fixture(scope="module")
def table(made: Path) -> str:
    """The name of the table's file."""
    file, = made.glob("*.table")
    return file.name


@pytest.fixture
def case(made: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return shutil.copytree(made, tmp_path, dirs_exist_ok=True)


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != "case.nml"}


def test_memory_does_not_grow_with_the_length_of_a_run(tmp_path):
    """Forty thousand rows, 18 MB as numbers and 36 MB as text, in hardly more memory than four."""
    peaks = []
    for t_end in 4e-4, 4.0:
        (tmp_path/"case.nml").write_text(short_case(tmp_path, table={"folder": tmp_path},
                                                    integrator={"dt": 1e-4, "t_end": t_end, "stop_at": "t_end"},
                                                    initial={"vY": 0.1, "roll_rate": 0.00333}))
        with subprocess.Popen([LDBENCH, tmp_path/"case.nml"], stdout=subprocess.PIPE, text=True) as child:
            said = child.stdout.read()
            _, status, used = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode == 0 and f"{round(t_end/1e-4) + 1} rows\n" in said
        peaks.append(used.ru_maxrss/1e3)
    assert peaks[1] < peaks[0] + 4


@pytest.mark.same_build
def test_out_of_memory_is_told(case, table):
    """Address space from where the stack can grow to where it is enough: a library says what is missing, and no file is
    half-written."""
    whole = bytes_of(case)
    outcomes = set()
    for megabytes in (16, 30, 4000):
        (case/table).unlink()
        done = limited(case, resource.RLIMIT_AS, int(megabytes*1e6))
        outcomes.add(done.returncode)
        if done.returncode:
            assert re.search("memory|Error allocating|shared object|Thread creation failed", done.stderr), (megabytes, done.stderr)
        left = {name: data for name, data in bytes_of(case).items() if ".ldbench-part" not in name}
        assert {**left, table: whole[table]} == whole, megabytes
        (case/table).write_bytes(whole[table])
    assert 0 in outcomes and 1 in outcomes


def test_killed_at_any_moment_earlier_results_are_whole_and_the_next_run_goes_on(case, table):
    """While it builds the table and writes it, while rows and files are written; scratch files may be left. The column file of the
    other case has its name or the one under which it is kept."""
    earlier = bytes_of(case)
    (case/"case.nml").write_text((case/"case.nml").read_text().replace("t_end = 0.002", "t_end = 0.05"))
    began = time.monotonic()
    assert run(case).returncode == 0
    span = time.monotonic() - began
    later = bytes_of(case)
    assert later["columns.txt"] != earlier["columns.txt"]
    draw = random.Random(SEED)
    killed = 0
    for k in range(KILLS):
        for name, data in earlier.items():
            (case/name).write_bytes(data)
        (case/KEPT).unlink(missing_ok=True)
        if k % 2:
            (case/table).unlink()
        child = subprocess.Popen([LDBENCH, "case.nml"], cwd=case, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            child.wait(draw.uniform(0, 1.1*span if k % 2 else 0.3*span))
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
            killed += 1
        for name, data in bytes_of(case).items():
            if name == KEPT:
                assert data == earlier["columns.txt"]
            elif ".ldbench-part" not in name:
                assert data in (earlier[name], later[name]), (k, name)
        assert (case/KEPT).exists() or (case/"columns.txt").exists()
    assert killed
    assert run(case).returncode == 0
    assert {name: data for name, data in bytes_of(case).items() if ".ldbench-part" not in name and name != KEPT} == {
        name: data for name, data in later.items() if name != KEPT}


def wait_for(folder: Path, tables: int, process: subprocess.Popen) -> None:
    """Until a process has made so many tables."""
    give_up = time.monotonic() + HANG
    while len(list(folder.glob("*.table"))) < tables:
        assert process.poll() is None, f"ended with {process.returncode} without its tables"
        assert time.monotonic() < give_up, "hangs without its tables"
        time.sleep(0.01)


def test_a_report_stops_its_runs(tmp_path):
    """They would never end by themselves; nothing half-written is left, nor a file of a run that was stopped."""
    (tmp_path/"inputs").mkdir()
    for pair in "aw", "sw":
        ldbench.Case.exercise(3, pair).replace(
            model="hertz", table_folder="tables", vY=0.0, roll_rate=0.0, t_end=1e5, dt=1e-5, stop_at="t_end",
            interval=0.1, rows="interval").to_namelist(tmp_path/f"inputs/ex3_{pair}.nml")
    (tmp_path/"out").mkdir()
    (tmp_path/"out/submission.toml").write_text('authors = ["A. Author"]\n')
    process = subprocess.Popen([sys.executable, "-m", "ldbench", "report", "--inputs", "inputs", "-o", "out", "-j", "2"],
                               cwd=tmp_path, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    for number in 1, 2:
        wait_for(tmp_path/"tables", number, process)      # after them comes the integration
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=HANG)[1]
    assert (process.returncode, said.rpartition("\r")[2]) == (128 + signal.SIGINT, "ldbench: stopped\n")
    assert not list(tmp_path.rglob("*.ldbench-part*")) and not list((tmp_path/"out").glob("ex3_*"))


@pytest.mark.parametrize("without", ["columns", "table"])
def test_a_file_that_cannot_be_written_to_its_end(case, without, table):
    """Where the process may write no longer files, as where the disk is full: a run without its column file is an error, one whose
    table cannot be kept goes on."""
    whole = bytes_of(case)
    if without == "table":
        (case/table).unlink()
        done = limited(case, resource.RLIMIT_FSIZE, len(whole.pop(table)) - 1)
        assert done.returncode == 0
        assert re.fullmatch(rf"ldbench: warning: [^\n]*/{re.escape(table)}: cannot be written; [^\n]*\n", done.stderr)
    else:
        one_line(limited(case, resource.RLIMIT_FSIZE, len(whole["columns.txt"]) - 1), "cannot be written", "columns.txt")
    assert bytes_of(case) == whole


@contextmanager
def longest_file(most: int) -> Iterator[None]:
    """In this process; Python has it as an error, not as a signal. Its byte code of modules it would cut off unseen, and
    fail on it ever after."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "dont_write_bytecode", True)
        patch.setenv("PYTHONDONTWRITEBYTECODE", "1")
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(("product", "command"), [
    ("new.txt", ["run", "{case}", "--output", "{out}/new.txt"]),
    ("geometry.txt", ["table", "{case}", "-o", "{out}/geometry.txt"]),
    ("plot.pdf", ["plot", "{columns}", "-o", "{out}/plot.pdf"]),
    ("plot.svg", ["plot", "{columns}", "-o", "{out}/plot.svg"]),
    ("moment.pdf", ["view", "{columns}", "-o", "{out}/moment.pdf"]),
    ("sweep.png", ["ensemble", "{case}", "--over", "mass=1400,1500", "-o", "{out}/sweep.png"]),
    ("page.html", ["view", "{columns}", "-o", "{out}/page.html"]),
    ("compare.pdf", ["compare", "{columns}", "{columns}", "-o", "{out}/compare.pdf"]),
    ("sweep.zarr", ["ensemble", "{case}", "--over", "mass=1400,1500", "-o", "{out}/sweep.zarr"])],
    ids=lambda value: value if isinstance(value, str) else "")
def test_commands_of_python_tell_what_cannot_be_written(product, command, made, undrawn, tmp_path, capsys):
    """In a folder for which there is no space: one line, status 1, and nothing half-written."""
    target = tmp_path/product
    if target.suffix != ".zarr":
        target.write_text("earlier\n")
    words = [word.format(case=made/"case.nml", columns=made/"columns.txt", out=tmp_path) for word in command]
    before = contents(tmp_path)
    with longest_file(200):
        status = main(words)
    said = capsys.readouterr().err
    assert status == 1 and re.fullmatch(r"ldbench: error: [^\n]+\n", said.split("\r")[-1]), said
    assert product in said or "cannot be written completely: File too large" in said
    left = contents(tmp_path)
    assert {path: data for path, data in left.items() if ".ldbench" not in str(path)} == before


def test_no_damaged_table_is_used(case, table):
    """A bit of the file turned over, or the file cut off."""
    draw, whole = random.Random(SEED), (case/table).read_bytes()
    reader = subprocess.Popen([FORTRAN_TESTS/"load_tables", "case.nml"], cwd=case, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True)

    def answer(data: bytes) -> str:
        (case/"damaged").write_bytes(data)
        print("damaged", file=reader.stdin, flush=True)
        return reader.stdout.readline()[:-1]

    assert answer(whole) == "used"
    for at in [*range(300), *draw.sample(range(300, len(whole)), 1500), *range(len(whole) - 20, len(whole))]:
        assert answer(whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1:]) == "missing", at
    assert {answer(whole[:end]) for end in [*range(30), *draw.sample(range(len(whole)), 300)]} == {"missing"}
    reader.communicate()


@pytest.mark.parametrize(("groups", "right"), [
    ({"contact": {"formulation": "bilateral"}}, True),
    ({"contact": {"formulation": "unilateral", "restitution": 0.5}}, True),
    ({"contact": {"model": "halfspace"}}, False),
    ({"contact": {"model": "hertz"}, "integrator": {"order": 2, "beta": 0.25, "dt": 2e-5}}, True),
    ({"contact": {"formulation": "unilateral"}, "track": {"gauge": 1.435}, "wheelset": {"back_to_back": 1.36},
      "profiles": {"wheel_profile": REPO/"profiles/s1002.yz", "rail_profile": REPO/"profiles/60e1.yz"}}, False)],
    ids=["bilateral", "unilateral", "halfspace", "hertz", "unilateral S1002"])
def test_every_kind_of_run_ends_well(groups, right, tmp_path):
    """Above all in the build that looks at every access to memory and every leak: SANITIZE=1."""
    profiles = {f"{what}_profile_right": REPO/f"profiles/s{what[0]}prof.yz" for what in ("wheel", "rail")} if right else {}
    (tmp_path/"case.nml").write_text(short_case(
        Path(), **{"profiles": profiles, "initial": {"vY": 1.0, "roll_rate": 0.0333}, **groups}))
    done = run(tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and "columns.txt" in bytes_of(tmp_path)


def shell(script: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["sh", "-c", script], cwd=folder, capture_output=True, text=True, timeout=HANG,
                          env=bare_environment() | {"LDBENCH": str(LDBENCH)})


def test_closed_and_full_streams(case, undrawn, monkeypatch):
    """The executable is tried here; tests/program/test_commands.py tries the commands of Python."""
    assert run(case).returncode == 0
    whole = bytes_of(case)
    one_line(shell("$LDBENCH <&-", case), "standard input")
    assert shell("$LDBENCH case.nml <&-", case).returncode == 0
    for command in "$LDBENCH case.nml", "$LDBENCH --help", "$LDBENCH --version":
        for full in ">/dev/full", ">&-":
            one_line(shell(f"{command} {full}", case), "standard output")
    assert shell("$LDBENCH case.nml 2>&-", case).returncode == 0
    assert shell("$LDBENCH nothing.nml 2>/dev/full", case).returncode == 1
    assert bytes_of(case) == whole
    # A name that is not UTF-8 is drawn with another letter, of which no line has to tell.
    odd = case/os.fsdecode(b"n\xe9.txt")
    odd.write_bytes(whole["columns.txt"])
    monkeypatch.setattr("ldbench.plots.document.case_figures", lambda *given: itertools.islice(case_figures(*given), 1))
    monkeypatch.setattr(sys, "stderr", None)
    assert main(["plot", str(odd), "-o", str(case/"odd.pdf")]) == 0 and (case/"odd.pdf").stat().st_size > 1000
    sys.stderr.close()
