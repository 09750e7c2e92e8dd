"""What the tests share: where things are, how to run a case and read its columns."""
from __future__ import annotations

import fcntl
import functools
import hashlib
import math
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

if TYPE_CHECKING:
    from ldbench import Case

REPO = Path(__file__).resolve().parents[2]
LDBENCH = Path(os.environ.get("LDBENCH", REPO / "ldbench")).resolve()
FORTRAN_TESTS = Path(os.environ.get("LDBENCH_TESTS", REPO / "build/release/tests")).resolve()
MODULES = REPO / "tests/support", REPO / "profiles"     # folders of Python modules that are no package
WINDOWS = LDBENCH.parent.name == "windows"              # under wine: make test-windows
PAIRS = "aw", "sw"
CASES = [f"ex{exercise}_{pair}" for exercise in range(1, 6) for pair in PAIRS]

HANG = 1800     # a program that takes so long hangs [s]; no verdict on how fast it is

Columns = dict[str, np.ndarray]
T = TypeVar("T")


def environment(**changes: str) -> dict[str, str]:
    """The environment of a Python program that is started here and imports from MODULES."""
    inherited = os.environ.get("PYTHONPATH", "")
    path = os.pathsep.join([*map(str, MODULES), *([inherited] if inherited else [])])
    return os.environ | {"PYTHONPATH": path} | changes


def bare_environment() -> dict[str, str]:
    """The environment of a Python program that a user starts on a machine that sets no variables for Python."""
    here = {name: os.environ[name] for name in ("HOME", "PATH", "TMPDIR", "PYTHONPYCACHEPREFIX") if name in os.environ}
    return here | {"LANG": "C.UTF-8", "PYTHONPATH": environment()["PYTHONPATH"]}


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


@functools.cache
def kept_tables() -> Path:
    """The folder of contact tables that earlier tests of the very same program left in build/tables.

    What is solved is a function of its case and of the program, to the last byte, so the first tests of a program solve it and
    later ones read it.
    """
    folder = REPO / "build/tables" / f"{LDBENCH.name}-{hashlib.sha256(LDBENCH.read_bytes()).hexdigest()[:16]}"
    folder.mkdir(parents=True, exist_ok=True)
    for outdated in folder.parent.glob(f"{LDBENCH.name}-{'[0-9a-f]'*16}"):
        if outdated != folder:
            shutil.rmtree(outdated, ignore_errors=True)
    return folder


def with_kept_table(case: Case) -> Case:
    """The case with its contact table among the kept ones."""
    return case.replace(table_folder=kept_tables())


def short_case(folder: Path, **changes: dict[str, object]) -> str:
    """A case of 2 ms with a coarse contact table, of the law whose tables are built in the least time, that writes
    folder/columns.txt."""
    groups = {
        "profiles": {"wheel_profile": REPO / "profiles/awprof.yz", "rail_profile": REPO / "profiles/arprof.yz"},
        "initial": {"vY": 0.5, "roll_rate": 0.01667},
        "contact": {"model": "hertz"},
        "table": {"folder": kept_tables()},
        "integrator": {"dt": 1e-5, "t_end": 2e-3},
        "output": {"file": folder / "columns.txt", "rows": "interval"},
    }
    for group, variables in changes.items():
        groups[group] = groups.get(group, {}) | variables
    return namelist(**groups)


def alike(one: object, other: object, rel: float = 0.0) -> bool:
    """Whether facts are the same, numbers to a relative error and NaN like NaN; of any depth of mappings and sequences."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return one.keys() == other.keys() and all(alike(one[key], other[key], rel) for key in one)
    if isinstance(one, tuple | list) and isinstance(other, tuple | list):
        return len(one) == len(other) and all(alike(*pair, rel) for pair in zip(one, other, strict=True))
    if isinstance(one, float) and isinstance(other, float):
        return one == other or math.isclose(one, other, rel_tol=rel) or (math.isnan(one) and math.isnan(other))
    return type(one) is type(other) and one == other


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
    """A shipped input, run; its file is read when a test asks for what it holds."""
    file: Path       # of columns
    summary: str     # what it printed

    @cached_property
    def header(self) -> str:
        return header(self.file)

    @cached_property
    def columns(self) -> Columns:
        return columns(self.file)


def read_interval(text: str) -> float:
    return float(re.search(r"\binterval *= *([-+.0-9eEdD]+)", text)[1])


def on_grid(run: Run) -> Run:
    """The run with its rows at equal intervals alone: those at events come at other times in a perturbed run."""
    rows = run.columns["time"]/read_interval(run.header)
    kept = np.abs(rows - np.rint(rows)) < 1e-6
    kept[-1] = True
    gridded = replace(run)
    gridded.header = run.header
    gridded.columns = {name: values[kept] for name, values in run.columns.items()}
    return gridded


def shipped_text(case: str, folder: Path) -> str:
    """A shipped input that writes to `folder`, with its contact table among the kept ones."""
    text = (REPO / "inputs" / f"{case}.nml").read_text()
    return text.replace("'outputs/tables'", f"'{kept_tables()}'").replace("'outputs/", f"'{folder}/")


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
    return Run(file, (folder / case / "summary").read_text())


@contextmanager
def once(folder: Path) -> Iterator[bool]:
    """Whether `folder` is still to be filled; other workers wait meanwhile, and get a no unless this one failed."""
    folder.mkdir(exist_ok=True)
    filled = folder.with_suffix(".filled")
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield not filled.exists()
        filled.touch()
