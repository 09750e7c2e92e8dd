"""The golden world: what many tests read, made once and kept on disk below build/world.

A part has a folder build/world/<part>-<hash>/made. The hash is that of all that decides what is in it: the executable; for what
Python makes also the extension, the text of all modules of wrappers, and the versions of Python and of the packages that write;
and the texts of inputs, profiles and of the modules here that make it. A part is made when the first test asks for it, each for
itself. Folders of an earlier hash that nobody uses are removed. Several workers take turns by a lock, and a making that was
interrupted, or whose files have changed since, is made anew.

Tests read what is here; a test that changes something works on a copy.
"""
from __future__ import annotations

import fcntl
import functools
import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Generic, TypeVar

from running import CASES, LDBENCH, REPO, Run, read_shipped, run_shipped

if TYPE_CHECKING:
    import ldbench

FOLDER = REPO/"build/world"
HERE = Path(__file__).resolve().parent
LANGUAGES = {".py", ".js", ".css", ".html", ".json", ".toml", ".typ", ".xml", ".yz", ".bodies", ".nml"}
PACKAGES = "numpy", "scipy", "pandas", "matplotlib", "xarray", "zarr", "typst"

K, V = TypeVar("K"), TypeVar("V")


@functools.cache
def digest(*files: Path) -> str:
    found = hashlib.sha256()
    for file in files:
        data = file.read_bytes()
        found.update(f"{file.name} {len(data)}\n".encode() + data)
    return found.hexdigest()


def texts(folder: Path) -> list[Path]:
    """The files of a folder that say what a program does."""
    return sorted(file for file in folder.rglob("*") if file.suffix in LANGUAGES and "__pycache__" not in file.parts)


@functools.cache
def of_runs() -> str:
    """The hash of what decides a run of the executable."""
    return digest(LDBENCH, *texts(REPO/"inputs"), *texts(REPO/"profiles"), HERE/"golden.py", HERE/"running.py")


@functools.cache
def of_python() -> str:
    """The hash of what decides what Python makes."""
    # Whoever changes modules after they are imported says so by this variable.
    versions = sys.version + "".join(version(name) for name in PACKAGES) + os.environ.get("LDBENCH_WORLD", "")
    return hashlib.sha256("".join((
        versions, of_runs(), digest(*sorted((REPO/"wrappers/ldbench/_core").glob("_flat*.so")), *texts(REPO/"wrappers")))).encode(),
    ).hexdigest()


def listed(folder: Path) -> list[list[object]]:
    """Every file of a folder with its size and time."""
    return sorted([str(file.relative_to(folder)), file.stat().st_size, file.stat().st_mtime_ns]
                  for file in folder.rglob("*") if file.is_file())


def kept(part: str, key: str, make: Callable[[Path], object], *recipe: str) -> Path:
    """The folder of a part, which `make` fills if nothing whole is there. recipe: modules of the tests that make it."""
    files = [file for name in recipe for folder in ("support", "shown") if (file := REPO/f"tests/{folder}/{name}.py").exists()]
    assert len(files) == len(recipe), recipe
    name = f"{LDBENCH.name}-{part}"
    folder = FOLDER/f"{name}-{hashlib.sha256((key + digest(*files)).encode()).hexdigest()[:16]}"
    made, whole = folder/"made", folder/"whole.json"
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER/f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not whole.exists() or json.loads(whole.read_text()) != listed(made):
            for earlier in FOLDER.glob(f"{name}-{'[0-9a-f]'*16}"):
                if earlier == folder or not in_use(earlier):
                    shutil.rmtree(earlier, ignore_errors=True)
            made.mkdir(parents=True)
            make(made)
            scratch = folder/"part"
            scratch.write_text(json.dumps(listed(made)))
            scratch.rename(whole)
        HELD.append(os.open(folder/USED, os.O_RDWR | os.O_CREAT))
        fcntl.flock(HELD[-1], fcntl.LOCK_SH)
    return made


USED = "used"                   # a file that is locked while somebody uses the folder
HELD: list[int] = []            # those of this process, to its end


def in_use(folder: Path) -> bool:
    """Whether a process uses a part."""
    try:
        with (folder/USED).open("r+") as mark:
            fcntl.flock(mark, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:       # of a making that was interrupted
        return False
    except BlockingIOError:
        return True
    return False


class Parts(Mapping[K, V], Generic[K, V]):
    """A mapping whose values are made when they are asked for, each once."""

    def __init__(self, keys: Iterator[K] | list[K], make: Callable[[K], V]) -> None:
        self.names, self.make = list(keys), functools.cache(make)

    def __getitem__(self, key: K) -> V:
        if key not in self.names:
            raise KeyError(key)
        return self.make(key)

    def __contains__(self, key: object) -> bool:
        return key in self.names

    def __iter__(self) -> Iterator[K]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


# The ramp of exercise 5, so much steeper that the wheelset derails after 2.6 s, and rows as often as its steps allow.
STEEPER = {"lateral_ramp": "1.2e5", "interval": "2.5e-4"}
# A wheelset that is thrown from flange to flange between unlike sides.
UNLIKE = {"wheel_profile_right": "'profiles/swprof.yz'", "rail_profile_right": "'profiles/srprof.yz'", "vY": "1.5", "t_end": "0.05"}


def changed(text: str, values: Mapping[str, str]) -> str:
    """A shipped namelist with other values."""
    for name, value in values.items():
        text, found = re.subn(rf"(\b{name} *= *)\S+", rf"\g<1>{value}", text)
        assert found == 1, name
    return text


def steeper(text: str) -> str:
    """The namelist of exercise 5 with the steeper ramp."""
    return changed(text, STEEPER)


def unlike(text: str) -> str:
    """The namelist of exercise 3 with unlike sides, for 50 ms."""
    return changed(text, UNLIKE)


def run_of(part: str, case: str, change: Callable[[str], str] = lambda text: text) -> Run:
    """A shipped input, its text changed, run by the executable."""
    return read_shipped(case, kept(part, of_runs(), lambda folder: run_shipped(case, folder, change)))


def shipped_run(case: str) -> Run:
    """A shipped input, exercise 5 with the steeper ramp."""
    return run_of(f"run-{case}", case, steeper) if case.startswith("ex5") else run_of(f"run-{case}", case)


def unlike_run() -> Run:
    """The actual profiles on the left, the simplified ones on the right."""
    return run_of("run-unlike", "ex3_aw", unlike)


@functools.cache
def shipped_runs() -> Mapping[str, Run]:
    """The ten shipped inputs, exercise 5 with a steeper ramp."""
    return Parts(CASES, shipped_run)


@functools.cache
def whole_ramps() -> Mapping[str, Run]:
    """Exercise 5 as it is shipped: 50 s, two files of 75 MB. For slow tests alone."""
    return Parts([case for case in CASES if case.startswith("ex5")], lambda case: run_of(f"run-{case}-whole", case))


@functools.cache
def our_runs() -> Mapping[object, ldbench.Run]:
    """The shipped runs of exercises 1 to 4 by their task, read."""
    from ldbench import read_run  # programs that only start the executable need no package
    from ldbench_round.tasks import TASKS

    runs = shipped_runs()
    return Parts([task for task in TASKS if task.exercise < 5], lambda task: read_run(runs[task.name].file))


def specimen() -> Path:
    """The folder of the specimen's report."""
    from specimen import make_specimen

    return kept("specimen", of_python(), make_specimen, "specimen", "reading", "named_artists")
