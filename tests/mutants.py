"""Faults, put one at a time into a scratch copy, and whether the tests that should notice do: `make mutants`.

usage: python tests/mutants.py [WORD | NUMBER | FROM-TO ...]      only faults whose file or text has a word, or with these numbers
The faults are in mutants.txt: `file | tests`, then for each fault the old text after `- ` and the new one after `+ `; `...` stands
for test_walk.py.
A fault in fortran/ is compiled into the executable alone, so its tests must call that.
"""
from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

REPO = Path(__file__).resolve().parents[1]
SCRATCH = REPO/"build/mutants"
SHOWN = "tests/shown/test_walk.py"
HANG = 900                  # a test that takes longer has noticed [s]


class Fault(NamedTuple):
    """A line that is changed, and the tests that should fail."""

    file: str
    tests: list[str]
    old: str
    new: str


def read_faults() -> list[Fault]:
    found = []
    for block in (Path(__file__).with_suffix(".txt")).read_text(encoding="utf-8").strip().split("\n\n"):
        head, *lines = (line for line in block.splitlines() if not line.startswith("#"))
        file, _, tests = head.partition(" | ")
        for old, new in zip(lines[::2], lines[1::2], strict=True):
            found.append(Fault(file, [word.replace("...", SHOWN) for word in tests.split()], old[2:], new[2:]))
    return found


def copy() -> None:
    """The repository as it stands, with its executable, extension and objects, but without Git and results."""
    shutil.rmtree(SCRATCH, ignore_errors=True)
    names = subprocess.run(["git", "ls-files"], cwd=REPO, capture_output=True, text=True, check=True).stdout.splitlines()
    built = ["ldbench", *(str(path.relative_to(REPO)) for pattern in (
        "wrappers/ldbench/_core/_flat*.so", "wrappers/ldbench/_core/fmu/**/*", "build/release/**/*")
                          for path in REPO.glob(pattern) if path.is_file())]
    for name in [*names, *built]:
        if (REPO/name).is_file():
            (SCRATCH/name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(REPO/name, SCRATCH/name)


def noticed(fault: Fault) -> str:
    """Which test failed; nothing if the fault survived."""
    file = SCRATCH/fault.file
    before = file.read_text(encoding="utf-8")
    if before.count(fault.old) != 1:
        return f"OUTDATED: {before.count(fault.old)} times in the file"
    environment = os.environ | {"PYTHONPATH": str(SCRATCH/"wrappers"), "LDBENCH": str(SCRATCH/"ldbench"),
                                "LDBENCH_TESTS": str(SCRATCH/"build/release/tests"), "OMP_NUM_THREADS": "1"}
    file.write_text(before.replace(fault.old, fault.new), encoding="utf-8")
    try:
        if fault.file.startswith("fortran/"):
            made = subprocess.run(["make", "ldbench", "PYTHON=false"], cwd=SCRATCH, capture_output=True, text=True)
            if made.returncode:
                return f"OUTDATED: does not compile: {made.stderr[-200:]}"
        words = [sys.executable, "-m", "pytest", "-q", "-x", "--tb=no", *fault.tests]
        try:
            done = subprocess.run(words, cwd=SCRATCH, env=environment, capture_output=True, text=True, timeout=HANG)
        except subprocess.TimeoutExpired:
            return "hangs"
    finally:
        file.write_text(before, encoding="utf-8")
        if fault.file.startswith("fortran/"):
            subprocess.run(["make", "ldbench", "PYTHON=false"], cwd=SCRATCH, capture_output=True)
    failed = [line.split(" - ")[0] for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    if done.returncode not in (0, 1) or (done.returncode == 1 and not failed):
        return f"OUTDATED: pytest ended with {done.returncode}: {done.stdout[-200:]}"
    return failed[0] if failed else ""


def main() -> int:
    words = sys.argv[1:]
    ranges = [(int(first), int(last or first)) for first, _, last in (word.partition("-") for word in words) if first.isdecimal()]
    faults = {k: fault for k, fault in enumerate(read_faults(), 1) if not words or any(
        first <= k <= last for first, last in ranges) or any(
            word in f"{fault.file} {fault.old}" for word in words if not word[0].isdecimal())}
    if not faults:
        print(f"no fault has one of {words}")
        return 2
    copy()
    begun, survivors = time.monotonic(), 0
    one = next(iter(faults.values()))
    control = Fault(one.file, sorted({test for fault in faults.values() for test in fault.tests}), one.old, one.old)
    if found := noticed(control):
        print(f"without any fault: {found}")
        return 1
    for k, fault in faults.items():
        start = time.monotonic()
        found = noticed(fault)
        survivors += not found or found.startswith("OUTDATED")
        print(f"{k:2} {fault.file}: {fault.new.strip()[:70]}: {found or 'SURVIVED'} ({time.monotonic() - start:.0f} s)", flush=True)
    print(f"{len(faults)} faults, {survivors} survivors, {time.monotonic() - begun:.0f} s")
    return bool(survivors)


if __name__ == "__main__":
    sys.exit(main())
