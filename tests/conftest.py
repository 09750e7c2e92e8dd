"""What the tests share: where things are, how to run a case and read its columns."""
import fcntl
import os
import re
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np
import pytest

REPO = Path(__file__).resolve().parent.parent
LDBENCH = Path(os.environ.get("LDBENCH", REPO / "ldbench")).resolve()
FORTRAN_TESTS = Path(os.environ.get("LDBENCH_TESTS", REPO / "build/release/tests")).resolve()
PAIRS = "aw", "sw"
CASES = [f"ex{exercise}_{pair}" for exercise in range(1, 6) for pair in PAIRS]

HANG = 1800     # a program that takes so long hangs [s]; no verdict on how fast it is

Columns = dict[str, np.ndarray]
T = TypeVar("T")

# A shell makes what it starts in the background ignore Ctrl-C, and so would the programs that tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


# The Python extension is the release build: another build of the executable rounds differently.
same_build = pytest.mark.skipif(LDBENCH.name != "ldbench", reason="the executable is not the extension's build")


def run_case(text: str, tmp_path: Path, cwd: Path = REPO) -> subprocess.CompletedProcess[str]:
    """Run ldbench on a namelist text, written to tmp_path/case.nml."""
    file = tmp_path / "case.nml"
    file.write_text(text)
    return subprocess.run([LDBENCH, file], cwd=cwd, capture_output=True, encoding="utf-8",
                          errors="surrogateescape", timeout=HANG)


def namelist(**groups: dict[str, object]) -> str:
    """Namelist text: namelist(initial={"vY": 0.1}, output={"file": path})."""
    def value(x: object) -> str:
        return str(x) if isinstance(x, (int, float)) else f"'{x}'"

    return "".join(
        f"&{group}\n" + "".join(f"  {name} = {value(x)}\n" for name, x in variables.items()) + "/\n"
        for group, variables in groups.items())


def short_case(folder: Path, **changes: dict[str, object]) -> str:
    """A case of 2 ms with a coarse, quickly built contact table that writes folder/columns.txt."""
    groups = {
        "profiles": {"wheel_profile": REPO / "profiles/awprof.yz", "rail_profile": REPO / "profiles/arprof.yz"},
        "initial": {"vY": 0.5, "roll_rate": 0.01667},
        "contact": {"model": "strip"},
        "table": {"n_lateral": 40, "n_roll": 9, "n_depth": 9},
        "integrator": {"dt": 1e-5, "t_end": 2e-3},
        "output": {"file": folder / "columns.txt", "rows": "interval"},
    }
    for group, variables in changes.items():
        groups[group] = groups.get(group, {}) | variables
    return namelist(**groups)


def refusal(text: str, folder: Path) -> str:
    """The error message of an input that must be refused in one line, with no file made or touched.

    `folder` gets an earlier result, columns.txt, unless something is there under that name.
    """
    earlier = folder / "columns.txt"
    if not earlier.exists():
        earlier.write_text("an earlier result\n")
        os.utime(earlier, (1e9, 1e9))
    before = contents(folder)
    done = run_case(text, folder, cwd=folder)
    assert done.returncode == 1, f"exit status {done.returncode}, {done.stdout}{done.stderr}"
    assert done.stdout == ""
    line, end, rest = done.stderr.partition("\n")
    assert line.startswith("ldbench: error: ") and end and not rest, done.stderr
    assert not any(character < " " or character == "\x7f" for character in line), repr(line)
    assert len(line) < 800, line
    after = contents(folder)
    assert after == before, f"files made or touched: {sorted(set(after.items()) ^ set(before.items()))}"
    return line


def wait_for(file: Path, process: subprocess.Popen) -> None:
    """Until a process has made a file."""
    give_up = time.monotonic() + HANG
    while not file.exists():
        assert process.poll() is None, f"ended with {process.returncode} without {file}"
        assert time.monotonic() < give_up, f"hangs without {file}"
        time.sleep(0.01)


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """Descriptors of a terminal's two ends, ours and the program's; skips where the system has none."""
    pty = pytest.importorskip("pty", reason="this system has no terminals")
    try:
        ours, theirs = pty.openpty()
    except OSError as error:
        pytest.skip(f"this system gives no terminal: {error}")
    with open(ours, "rb", buffering=0), open(theirs, "rb", buffering=0):
        yield ours, theirs


def read_until(fd: int, end: bytes) -> bytes:
    """What comes from a terminal until `end` does."""
    text = b""
    while end not in text:
        assert select.select([fd], [], [], HANG)[0], f"hangs after {text!r}"
        text += os.read(fd, 1000)
    return text


def contents(folder: Path) -> dict[Path, tuple[bytes, int]]:
    """Every file in a folder but the namelist, with bytes and time; folders count as files."""
    return {path: (path.read_bytes(), path.stat().st_mtime_ns) if path.is_file() else (b"", 0)
            for path in folder.rglob("*") if path.name != "case.nml"}


def rows(file: Path) -> bytes:
    """The numbers of a column file as they stand there, without header."""
    return b"".join(line for line in file.read_bytes().splitlines(True)[1:] if not line.startswith(b"#"))


def columns(file: Path) -> Columns:
    """The columns of a file that ldbench wrote, by name."""
    with open(file) as lines:
        names = lines.readline().split()
        values = np.loadtxt(lines, comments="#", ndmin=2)
    return dict(zip(names, values.T, strict=True))


def header(file: Path) -> str:
    """The comment lines of a file that ldbench wrote, before and after the rows, without the `# `."""
    with open(file) as lines:
        return "".join(line[2:] for line in lines if line.startswith("# "))


@dataclass
class Run:
    """A shipped input, run."""
    file: Path       # of columns
    summary: str     # what it printed
    header: str
    columns: Columns


def read_interval(text: str) -> float:
    return float(re.search(r"\binterval *= *([-+.0-9eEdD]+)", text)[1])


def on_grid(run: Run) -> Run:
    """The run with its rows at equal intervals alone: those at events come at other times in a perturbed run."""
    interval = read_interval(run.header)
    rows = run.columns["time"]/interval
    kept = np.abs(rows - np.rint(rows)) < 1e-6
    kept[-1] = True
    return replace(run, columns={name: values[kept] for name, values in run.columns.items()})


def shipped_text(case: str, folder: Path) -> str:
    """A shipped input that writes to `folder`; one table per pair of profiles is kept there."""
    text = (REPO / "inputs" / f"{case}.nml").read_text()
    return text.replace("'outputs/", f"'{folder}/")


def run_shipped(case: str, folder: Path, change: Callable[[str], str] = lambda text: text) -> Run:
    """Run a shipped input, its text changed, with files in `folder`."""
    work = folder / case
    work.mkdir(exist_ok=True)
    done = run_case(change(shipped_text(case, folder)), work)
    assert done.returncode == 0, f"{case}: {done.stderr}"
    (work / "summary").write_text(done.stdout)
    return read_shipped(case, folder)


def read_shipped(case: str, folder: Path) -> Run:
    """What run_shipped left in `folder`."""
    file = folder / f"{case}.txt"
    return Run(file, (folder / case / "summary").read_text(), header(file), columns(file))


def for_all_cases(work: Callable[[str], T]) -> dict[str, T]:
    """work(case) of the ten cases, the two pairs of profiles side by side; a pair shares its table."""
    def of_pair(pair: str) -> dict[str, T]:
        return {case: work(case) for case in CASES if case.endswith(pair)}

    with ThreadPoolExecutor(len(PAIRS)) as pool:
        found = {case: result for results in pool.map(of_pair, PAIRS) for case, result in results.items()}
    return {case: found[case] for case in CASES}


# ---- once for all workers of pytest-xdist ---------------------------------------------
@pytest.fixture(scope="session")
def common(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all workers see."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@contextmanager
def once(folder: Path) -> Iterator[bool]:
    """Whether `folder` is still to be filled; other workers wait meanwhile, and get a no unless this one failed."""
    folder.mkdir(exist_ok=True)
    filled = folder.with_suffix(".filled")
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield not filled.exists()
        filled.touch()


# ---- beside the tests ----------------------------------------------------------------
@dataclass
class LongProgram:
    """A program of many seconds that a test module waits for; it goes on beside the tests before that one."""
    folder: Path     # of what it writes, given to it

    def begin(self, command: list[object]) -> subprocess.Popen:
        environment = os.environ | {"LDBENCH": str(LDBENCH), "LDBENCH_TESTS": str(FORTRAN_TESTS)}
        # Its exit status goes to a file: to other workers it is no child.
        shell = ["sh", "-c", '"$@"; echo $? >"$0.part" && mv "$0.part" "$0"', self.folder / "status"]
        with (self.folder / "stdout").open("w") as out, (self.folder / "stderr").open("w") as err:
            return subprocess.Popen([*shell, *command], cwd=REPO, env=environment, stdout=out, stderr=err)

    def finish(self) -> tuple[int, str, str]:
        """Exit status and what it said."""
        give_up = time.monotonic() + HANG
        while not (self.folder / "status").exists():
            assert time.monotonic() < give_up, f"hangs: {self.folder.name}"
            time.sleep(0.05)
        status, out, err = ((self.folder / name).read_text() for name in ("status", "stdout", "stderr"))
        return int(status), out, err


# By the modules that wait for them, which are the last ones.
LONG_PROGRAMS: dict[str, Callable[[Path], list[object]]] = {
    "test_validation": lambda folder: [sys.executable, REPO / "tests/validation", "--short", "--out", folder],
    "test_bench": lambda folder: [sys.executable, REPO / "tests/bench", "--short", "--out", folder],
}


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.stem in LONG_PROGRAMS)


@pytest.fixture(scope="session", autouse=True)
def long_programs(request: pytest.FixtureRequest, common: Path) -> Iterator[dict[str, LongProgram]]:
    """Those that the chosen tests need."""
    programs, begun = {}, []
    for name in sorted({item.path.stem for item in request.session.items} & LONG_PROGRAMS.keys()):
        programs[name] = LongProgram(common / name)
        with once(common / name) as first:
            if first:
                begun.append(programs[name].begin(LONG_PROGRAMS[name](common / name)))
    yield programs
    for process in begun:
        process.wait(HANG)          # another worker may wait for it


@pytest.fixture(scope="session")
def shipped(common: Path) -> dict[str, Run]:
    """The ten shipped inputs, each run once."""
    folder = common / "shipped"
    with once(folder) as first:
        if first:
            return for_all_cases(lambda case: run_shipped(case, folder))
    return {case: read_shipped(case, folder) for case in CASES}
