"""Whether the tests notice faults: `make mutants N=300 SEED=0 FAULTS="fortran/profile bodies"`.

usage: python tests/mutants.py [-n N] [--seed SEED] [--tests FOLDER] [--part FILE ...] [--limit SECONDS] [WORD ...]
N faults are drawn by the rules of support/faults.py, of every folder of fortran/ and wrappers/ by the root of its size; with N = 0 the
faults of mutants.txt are taken: `file | tests`, then for each fault the old text after `- ` and the new one after `+ `. Words choose
faults whose file or text has one of them. Those of mutants_equivalent.txt, which change nothing that can be seen, are not drawn.
What tests reach is recorded once, by one run of all tests or of parts (--part), and kept in build/mutants; for a fault those tests run
that reach it, the cheapest first, until one fails or their processor time comes to the limit. Fortran faults are compiled all at once,
each behind a number that the variable LDBENCH_FAULT has.
"""
from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import pickle
import random
import re
import shutil
import subprocess
import sys
import sysconfig
import threading
import time
from array import array
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

REPO = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPO/"tests/support"))

from faults import (  # noqa: E402
    EXECUTED,
    Change,
    block_at,
    blocks,
    constant,
    fortran_faults,
    leaders,
    part,
    python_faults,
    statements,
    switched,
)

FOLDER = REPO/"build/mutants"
HOOK = FOLDER/"hook"
SWITCH = """module ldbench_fault
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  integer(c_int), bind(c, name='ldbench_fault_number') :: fault_number
  interface
    pure subroutine fault_mark(k) bind(c, name='ldbench_fault_mark')
      import :: c_int
      integer(c_int), value :: k
    end subroutine fault_mark
  end interface
end module ldbench_fault
"""
MARKS = """#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
int ldbench_fault_number;
static char marks[65536] __attribute__((aligned(4096)));
void ldbench_fault_mark(int k) { marks[k] = 1; }
__attribute__((constructor)) static void begin(void) {
  const char *number = getenv("LDBENCH_FAULT"), *file = getenv("LDBENCH_MARKS");
  int opened = file ? open(file, O_RDWR) : -1;
  if (number) ldbench_fault_number = atoi(number);
  if (opened >= 0) mmap(marks, sizeof marks, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, opened, 0);
}
"""


class Fault(NamedTuple):
    """A change of a file; the marks of blocks that have it; names of which all users have it, where it stands outside of functions."""

    file: str
    change: Change
    marks: frozenset[int] = frozenset()
    tests: tuple[str, ...] = ()

    @property
    def line(self) -> int:
        return read(self.file)[:self.change.start].count(b"\n") + 1

    def texts(self) -> tuple[str, str]:
        """The lines that are changed, before and after."""
        source, (start, end, new, _) = read(self.file), self.change
        first, last = source.rfind(b"\n", 0, start) + 1, source.find(b"\n", end)
        return tuple(" ".join(text.decode().split()) for text in (
            source[first:last], source[first:start] + new.encode() + source[end:last]))  # type: ignore[return-value]


@cache
def read(file: str) -> bytes:
    return (REPO/file).read_bytes()


@cache
def sources() -> dict[str, int]:
    """The sources that have faults, and the mark of the first block or statement of each."""
    names = [str(path.relative_to(REPO)) for folder in ("fortran", "wrappers") for path in sorted((REPO/folder).rglob("*"))
             if path.suffix in (".py", ".f90") and path.parent.name not in ("windows", "lapack")]
    sizes = [len(blocks(ast.parse(read(name))) if name.endswith(".py") else list(statements(read(name)))) for name in names]
    return dict(zip(names, accumulate(sizes, initial=1), strict=False))


@cache
def parsed(file: str) -> Any:
    return ast.parse(read(file)) if file.endswith(".py") else list(statements(read(file)))


@cache
def users(name: str, files: str) -> frozenset[int]:
    """The marks of blocks and statements that have a name, or names that are made of it outside of functions."""
    found: set[int] = set()
    for file, first in sources().items():
        if not file.endswith(files) or not re.search(rf"\b{name}\b".encode(), read(file)):
            continue
        if file.endswith(".py"):
            for k, (_, body) in enumerate(blocks(parsed(file))):
                if any(name in (getattr(node, "id", ""), getattr(node, "attr", "")) for one in body for node in ast.walk(one)):
                    found.add(first + k)
        else:
            lead = leaders(parsed(file))
            found |= {first + lead[n] for n, one in enumerate(parsed(file))
                      if one.kind in EXECUTED and any(token[0].lower() == name for token in one.tokens)}
    return frozenset(found)


def names_at(file: str, at: int) -> set[str]:
    """What a statement outside of functions gives a value to, and what is made of that in the same file."""
    line = read(file)[:at].count(b"\n") + 1
    outside = [node for top in parsed(file).body for node in ([top, *top.body] if isinstance(top, ast.ClassDef) else [top])]
    made = {node: {getattr(target, "id", getattr(target, "name", "")) for target in [
        node, *getattr(node, "targets", ()), getattr(node, "target", node)]} - {""} for node in outside}
    names = set().union(*(found for node, found in made.items() if node.lineno <= line <= node.end_lineno))
    for _ in range(3):
        names |= set().union(*(found for node, found in made.items() if not isinstance(node, ast.ClassDef) and any(
            getattr(inner, "id", "") in names for inner in ast.walk(node))))
    return names


def located(file: str, change: Change) -> Fault | None:
    """The fault with the marks of what has it; nothing if it cannot be switched."""
    first = sources()[file]
    if file.endswith(".py"):
        k = block_at(parsed(file), read(file), change.start)
        marks = {first + k} if k is not None else set().union(*(users(name, ".py") for name in names_at(file, change.start)))
        return Fault(file, change, frozenset(marks))
    found = parsed(file)
    n = next(n for n, one in enumerate(found) if one.end > change.start)
    if found[n].kind == "parameter":
        known = constant(found[n], read(file), change)
        return Fault(file, change, users(known[0], file)) if known and users(known[0], file) else None
    if found[n].kind not in EXECUTED or (found[n].kind != "simple" and not part(found[n], change)):
        return None
    return Fault(file, change, frozenset({first + leaders(found)[n]}))


def candidates(file: str) -> Iterator[Change]:
    source = read(file)
    if file.endswith(".py"):
        yield from python_faults(source)
    else:
        known = set(re.findall(r"\w+", source.decode()))
        for one in parsed(file):
            yield from fortran_faults(source, one, known)


def compiles(fault: Fault) -> bool:
    """Whether the fault can be compiled, and is one."""
    source, change = read(fault.file), fault.change
    if fault.file.endswith(".py"):
        new = source[:change.start] + change.new.encode() + source[change.end:]
        try:
            return ast.dump(ast.parse(new)) != ast.dump(parsed(fault.file))
        except SyntaxError:
            return False
    scratch = FOLDER/"try.f90"
    scratch.write_bytes(with_faults(fault.file, {1: fault}))
    words = ["gfortran", "-fsyntax-only", "-std=f2018", "-fall-intrinsics", "-fopenmp", "-ffree-line-length-none", "-w", "-I", FOLDER,
             "-I", REPO/"build/release", "-J", FOLDER/"modules", scratch]
    return subprocess.run(words, capture_output=True).returncode == 0


def with_faults(file: str, numbered: dict[int, Fault], first_mark: int | None = None) -> bytes:
    changes = {k: fault.change for k, fault in numbered.items() if fault.file == file}
    constants: dict[str, str] = {}
    for one in parsed(file):
        for k, change in changes.items():
            if one.kind == "parameter" and one.start <= change.start < one.end:
                name, new = constant(one, read(file), change)  # type: ignore[misc]
                constants[name] = f"merge({new}, {constants.get(name, name)}, fault_number == {k})"
    return switched(read(file), changes, constants, first_mark)


def folder_of(file: str) -> str:
    """The folder that a share is told of."""
    folder = str(Path(file).parent)
    return folder.removesuffix("/posix").removesuffix("/commands") if "fortran" in folder or "round" in folder else folder


def listed() -> list[Fault]:
    found = []
    for block in (REPO/"tests/mutants.txt").read_text(encoding="utf-8").strip().split("\n\n"):
        head, *lines = (line for line in block.splitlines() if not line.startswith("#"))
        file, _, tests = head.partition(" | ")
        names = tuple(f"tests/{word}".replace("tests/...", "tests/shown/test_shown.py").replace("tests/tests/", "tests/")
                      for word in tests.split())
        for old, new in zip(lines[::2], lines[1::2], strict=True):
            start = read(file).find(old[2:].encode())
            if start < 0 or read(file).count(old[2:].encode()) != 1:
                raise SystemExit(f"mutants.txt: expected once in {file}, found {read(file).count(old[2:].encode())} times: {old[2:]}")
            change = Change(start, start + len(old[2:].encode()), new[2:], "listed")
            fault = located(file, change) if file in sources() else None
            found.append((fault or Fault(file, change))._replace(tests=names))
    return found


def sampled(number: int, seed: str, words: list[str]) -> list[Fault]:
    """Faults of every folder by the root of its size: a line is drawn, then a rule, then a change."""
    equivalent = (REPO/"tests/mutants_equivalent.txt").read_text(encoding="utf-8").splitlines()
    shares: dict[str, dict[tuple[str, int], dict[str, list[Change]]]] = {}
    for file in sources():
        for change in candidates(file):
            line = read(file)[:change.start].count(b"\n")
            shares.setdefault(folder_of(file), {}).setdefault((file, line), {}).setdefault(change.rule, []).append(change)
    whole = sum(len(share)**0.5 for share in shares.values())
    found = []
    for folder, share in shares.items():
        if words and not any(word in folder + "/" for word in words):
            continue
        draw, wanted, drawn = random.Random(f"{seed} {folder}"), round(number*len(share)**0.5/whole), set[Change]()
        for _ in range(20*wanted):
            if len(drawn) == wanted:
                break
            place = draw.choice(sorted(share))
            change = draw.choice(share[place][draw.choice(sorted(share[place]))])
            fault = located(place[0], change)
            if fault and change not in drawn and compiles(fault) and "{}: {} -> {}".format(place[0], *fault.texts()) not in equivalent:
                drawn.add(change)
                found.append(fault)
    return found


def run(words: list[Any], **options: Any) -> None:
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)
    if done.returncode:
        raise SystemExit(f"{words[:3]}: {done.stdout[-2000:]}{done.stderr[-4000:]}")


def write(path: Path, new: bytes) -> None:
    """Writes a file if it is not so already: `make` looks at its time."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_bytes() != new:
        path.write_bytes(new)


def build(numbered: dict[int, Fault], core: Path, own: Fault | None = None) -> None:
    """The executable, the library of the Python extension and programs of the tests, with every fault of Fortran and with marks.

    A fault of its own, which no branch can have, is compiled instead of what stands there.
    """
    environment = {name: value for name, value in os.environ.items() if not name.startswith("MAKE") and name != "MFLAGS"}
    for path in REPO.glob("tests/fortran/*"):
        write(core/path.relative_to(REPO), path.read_bytes())
    for name in ("Makefile", "fortran/fingerprint.sh", "fortran/library/fmi2.map", "fortran/library/fmi2.c", "fortran/library/ldbench.h",
                 "fortran/library/exports.map", "fortran/support/lapack/lapack.f90"):
        write(core/name, read(name))
    for file, first in sources().items():
        if file.endswith(".f90"):
            new = with_faults(file, numbered, first)
            if own and own.file == file:
                new = with_own(own)
            write(core/file, new)
    write(core/"fortran/support/ldbench_fault.f90", SWITCH.encode())
    write(core/"marks.c", MARKS.encode())
    release = core/"build/release"
    release.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(REPO/"build/release/fingerprint.f90", release/"fingerprint.f90")    # tables are those of the plain sources
    run(["gcc", "-O2", "-fPIC", "-c", "marks.c"], cwd=core)
    scalar = subprocess.run(["gfortran", "-print-file-name=finclude"], capture_output=True, text=True, check=True).stdout.strip()
    programs = [f"build/release/tests/{path.stem}" for path in REPO.glob("tests/fortran/*.f90") if path.stem != "shared"]
    made = ["ldbench", "build/release/flat.o", "wrappers/ldbench/_core/fmu/linux64/wheelset.so", *programs]
    run(["make", f"-j{os.cpu_count()}", *made, "PYTHON=false", "WARN=", "FFLAGS=-O2 -fPIC -fopenmp -frecursive -ffp-contract=off "
         f"-ffree-line-length-none -nostdinc -fintrinsic-modules-path {scalar}", f"LIBS={core}/marks.o -llapack -lblas",
         f"ALONE={core}/marks.o -Wl,-rpath,'$$ORIGIN',--disable-new-dtags"], cwd=core, env=environment)
    import numpy as np
    import numpy.f2py
    flat = core/"flat"
    run([sys.executable, "-m", "numpy.f2py", REPO/"wrappers/ldbench/_core/flat.f90", "-m", "_flat", "--lower", "--build-dir", flat,
         "--quiet"], cwd=core)
    include = [f"-I{np.get_include()}", f"-I{numpy.f2py.get_include()}", f"-I{sysconfig.get_path('include')}"]
    run(["gcc", "-O2", "-fPIC", "-w", *include, "-c", flat/"_flatmodule.c", f"{numpy.f2py.get_include()}/fortranobject.c"], cwd=core)
    objects = [path for path in release.glob("*.o") if path.stem not in ("ldbench", "core", "lapack", "fmi2")]
    run(["gfortran", "-shared", "-fPIC", "-fopenmp", f"-I{release}", "-o", "flat.so", flat/"_flat-f2pywrappers2.f90", "_flatmodule.o",
         "fortranobject.o", "marks.o", *objects, "-llapack", "-lblas"], cwd=core)


def with_own(fault: Fault) -> bytes:
    source, change = read(fault.file), fault.change
    return source[:change.start] + change.new.encode() + source[change.end:]


class Worker:
    """A copy of the repository with the core that has faults, and the process that runs tests there."""

    def __init__(self, number: int, core: Path, tests: Path) -> None:
        self.folder = FOLDER/str(number)
        shutil.rmtree(self.folder, ignore_errors=True)
        names = subprocess.run(["git", "ls-files"], cwd=REPO, capture_output=True, text=True, check=True).stdout.splitlines()
        for name in names:
            if (REPO/name).is_file() and not name.startswith("tests/"):
                (self.folder/name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(REPO/name, self.folder/name)
        shutil.copytree(tests, self.folder/"tests", ignore=shutil.ignore_patterns("__pycache__"))
        self.install(core)
        site = self.folder/".venv/lib"/f"python{sys.version_info.major}.{sys.version_info.minor}"/"site-packages"
        site.mkdir(parents=True)
        (self.folder/".venv/bin").mkdir()
        for name in ("python", "python3"):
            (self.folder/".venv/bin"/name).symlink_to(Path(sys.base_prefix)/"bin/python3")
        shutil.copy(REPO/".venv/pyvenv.cfg", self.folder/".venv")
        (site/"faults.pth").write_text(f"{self.folder}/wrappers\n{HOOK}\nimport site; site.addsitedir({sysconfig.get_path('purelib')!r})\n"
                                       "import os; os.environ.get('LDBENCH_MARKS') and __import__('reach')\n", encoding="utf-8")
        self.environment = {name: os.environ[name] for name in ("HOME", "PATH") if name in os.environ} | {
            "LANG": "C.UTF-8", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "LDBENCH": str(self.folder/"ldbench"),
            "LDBENCH_TESTS": str(self.folder/"build/release/tests"), "PYTHONPYCACHEPREFIX": str(self.folder/"build/bytecode"),
            "TMPDIR": str(self.folder/"t")}
        (self.folder/"t").mkdir()
        self.server = subprocess.Popen([self.folder/".venv/bin/python", HOOK/"reach.py"], cwd=self.folder, env=self.environment, text=True,
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def install(self, core: Path) -> None:
        shutil.copytree(core/"build/release", self.folder/"build/release", dirs_exist_ok=True)
        for name in ("libgcc_s.so.1", "libgfortran.so.5", "libgomp.so.1", "libquadmath.so.0", "wheelset.so"):
            if (core/"wrappers/ldbench/_core/fmu/linux64"/name).is_file():
                (self.folder/"wrappers/ldbench/_core/fmu/linux64").mkdir(parents=True, exist_ok=True)
                shutil.copy2(core/"wrappers/ldbench/_core/fmu/linux64"/name, self.folder/"wrappers/ldbench/_core/fmu/linux64")
        shutil.copy2(core/"ldbench", self.folder)
        shutil.copy2(core/"flat.so", self.folder/"wrappers/ldbench/_core"/f"_flat{sysconfig.get_config_var('EXT_SUFFIX')}")

    def ask(self, files: list[str], limit: float, environment: dict[str, str], **more: Any) -> list[Any]:
        shutil.rmtree(self.folder/"t", ignore_errors=True)
        (self.folder/"t").mkdir()
        words = ["-q", "--tb=short", "-n0", "-p", "no:randomly", f"--basetemp={self.folder}/t/p",
                 *(["-x"] if "limits" in more else []), *files]
        job = {"words": words, "limit": limit, "environment": environment, "log": str(self.folder/"log"), **more}
        (self.folder/"log").unlink(missing_ok=True)
        self.server.stdin.write(json.dumps(job) + "\n")
        self.server.stdin.flush()
        return json.loads(self.server.stdout.readline())

    def record(self, file: str, into: Path) -> None:
        """What the tests of a file reach."""
        marks = self.folder/"build/marks"
        marks.write_bytes(bytes(65536))
        (self.folder/"build/marks.json").write_text(json.dumps(
            {name.removeprefix("wrappers/"): first for name, first in sources().items() if name.endswith(".py")}), encoding="utf-8")
        answer = self.ask([file], 3600, {"LDBENCH_MARKS": str(marks), "PYTHONPYCACHEPREFIX": str(self.folder/"build/marked")},
                          record=f"{into}.part")
        print(f"recorded {file}: status {answer[0]}, {answer[2]:.0f} s", flush=True)
        if answer[0] not in (0, 1, 5):
            print((self.folder/"log").read_text(encoding="utf-8", errors="replace")[-1500:])
        else:
            Path(f"{into}.part").rename(into)


class Known(NamedTuple):
    """A test: seconds, those of its shared fixtures by name, time that passes, and what both reach."""

    name: str
    seconds: float
    elapsed: float
    marks: frozenset[int]
    fixtures: frozenset[str]


def recorded(files: list[str], workers: list[Worker], tests: Path) -> tuple[list[Known], dict[str, float]]:
    """The tests of files that pass, and the cost of their fixtures."""
    shared = hashlib.sha256()
    for path in [*(REPO/name for name in sources()), tests/"conftest.py", *sorted((tests/"support").glob("*.py")),
                 *sorted((tests/"shown").glob("[!t]*.py"))]:
        shared.update(path.read_bytes())
    reach = FOLDER/"reach"
    reach.mkdir(exist_ok=True)
    kept = {file: reach/hashlib.sha256(shared.digest() + file.encode() + (tests.parent/file).read_bytes()).hexdigest() for file in files}
    missing = [file for file, path in kept.items() if not path.is_file()]
    spread(lambda worker, file: worker.record(file, kept[file]), missing, workers)
    made, fixtures, costs, found = {}, dict[str, set[int]](), dict[str, float](), []
    for file, path in kept.items():
        if path.is_file():
            made[file] = pickle.loads(path.read_bytes())
            for name, (cost, marks) in made[file][1].items():
                costs[name] = max(cost, costs.get(name, 0.0))
                fixtures.setdefault(name, set()).update(marks)
    for known, _, failed, loaded in made.values():
        for name, (seconds, elapsed, marks, uses) in known.items():
            if name not in failed:
                reached = set(marks).union(loaded, *(fixtures.get(fixture, ()) for fixture in uses))
                found.append(Known(name, seconds, elapsed, frozenset(reached), frozenset(uses)))
    print(f"{len(found)} tests known, {sum(one.seconds for one in found) + sum(costs.values()):.0f} s; not passed: "
          f"{sorted(name for _, _, failed, _ in made.values() for name in failed)}", flush=True)
    return found, costs


def spread(work: Any, jobs: list[Any], workers: list[Worker]) -> list[Any]:
    """work(worker, job) of all jobs, each worker one at a time."""
    free = list(workers)
    lock = threading.Lock()

    def one(job: Any) -> Any:
        with lock:
            worker = free.pop()
        try:
            return work(worker, job)
        finally:
            with lock:
                free.append(worker)

    with ThreadPoolExecutor(len(workers)) as pool:
        return list(pool.map(one, jobs))


class Verdict(NamedTuple):
    fault: Fault
    by: str                     # the test that notices; nothing if none does
    tried: int
    reaching: int
    seconds: float


class Campaign:
    """Faults against tests."""

    def __init__(self, tests: list[Known], costs: dict[str, float], limit: float, core: Path) -> None:
        self.tests, self.costs, self.limit, self.core = tests, costs, limit, core
        self.keen: dict[str, int] = {}       # how often a test noticed

    def chunks(self, fault: Fault) -> Iterator[list[Known]]:
        """The tests that reach a fault, those first that cost little, reach little else, and noticed other faults."""
        def price(one: Known) -> float:
            named = any(one.name.startswith(name.partition("[")[0]) for name in fault.tests)
            cost = one.seconds + sum(self.costs.get(name, 0.0) for name in one.fixtures)
            return (cost + 0.2)*len(one.marks)/(1 + self.keen.get(f"{fault.file} {one.name}", 0))/(1e6 if named else 1)

        room, chunk, cost, met, total = 3.0, list[Known](), 0.0, set[str](), 0.0
        for one in sorted((one for one in self.tests if one.marks & fault.marks or any(
                one.name.startswith(name.partition("[")[0]) for name in fault.tests)), key=price):
            new = one.seconds + sum(self.costs.get(name, 0.0) for name in one.fixtures - met)
            met |= one.fixtures
            if chunk and cost + new > room:
                yield chunk
                room, chunk, cost, met = 3*room, [], 0.0, set(one.fixtures)
            if total + new > self.limit and total:
                break
            chunk, cost, total = [*chunk, one], cost + new, total + new
        if chunk:
            yield chunk

    def judge(self, worker: Worker, numbered: tuple[int, Fault]) -> Verdict:
        k, fault = numbered
        file = worker.folder/fault.file
        before, times = file.read_bytes(), (file.stat().st_atime, file.stat().st_mtime)
        environment = {}
        if fault.file.endswith(".f90") and fault.marks:
            environment["LDBENCH_FAULT"] = str(k)
            shutil.rmtree(worker.folder/"build/tables", ignore_errors=True)
        elif fault.file.endswith(".f90"):
            own = FOLDER/f"own{worker.folder.name}"
            build({}, own, fault)
            worker.install(own)
        else:
            file.write_bytes(with_own(fault))
            os.utime(file, (1e9 + k, 1e9 + k))      # byte code of another fault is not taken for that of this one
        begun, tried, by = time.monotonic(), 0, ""
        for chunk in self.chunks(fault):
            tried += len(chunk)
            limits = {one.name: 20*one.elapsed + 20*sum(self.costs.get(name, 0.0) for name in one.fixtures) + 30 for one in chunk}
            status, failed, _ = worker.ask(list(dict.fromkeys(one.name.partition("::")[0] for one in chunk)), 600, environment, limits=limits)
            if status not in (0, 5):
                by = failed or f"{chunk[0].name} or so: {status}"
                self.keen[f"{fault.file} {failed}"] = self.keen.get(f"{fault.file} {failed}", 0) + 1
                break
        file.write_bytes(before)
        os.utime(file, times)
        if fault.file.endswith(".f90"):
            shutil.rmtree(worker.folder/"build/tables", ignore_errors=True)
            if not fault.marks:
                worker.install(self.core)
        found = Verdict(fault, by, tried, sum(bool(one.marks & fault.marks) for one in self.tests), time.monotonic() - begun)
        old, new = fault.texts()
        print(f"{k:3} {fault.file}:{fault.line} {fault.change.rule}: {old} -> {new}\n      "
              f"{by or 'SURVIVED'} ({found.tried} of {found.reaching} tests, {found.seconds:.0f} s)", flush=True)
        return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=300)
    parser.add_argument("--seed", default="0")
    parser.add_argument("--tests", type=Path, default=REPO/"tests")
    parser.add_argument("--part", nargs="*", default=[])
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    begun = time.monotonic()
    shutil.rmtree(HOOK, ignore_errors=True)
    HOOK.mkdir(parents=True)
    for name in ("faults", "reach"):
        shutil.copy(REPO/f"tests/support/{name}.py", HOOK)
    (FOLDER/"modules").mkdir(exist_ok=True)
    (FOLDER/"switch.f90").write_text(SWITCH, encoding="utf-8")
    run(["gfortran", "-fsyntax-only", "-J", FOLDER, FOLDER/"switch.f90"])
    faults = sampled(options.n, options.seed, options.words) if options.n else [fault for fault in listed() if not options.words or any(
        word in f"{fault.file} {fault.texts()[0]}" for word in options.words)]
    numbered = dict(enumerate(faults, 1))
    print(f"{len(faults)} faults ({time.monotonic() - begun:.0f} s)", flush=True)
    build({k: fault for k, fault in numbered.items() if fault.marks}, FOLDER/"core")
    print(f"compiled ({time.monotonic() - begun:.0f} s)", flush=True)
    tests = options.tests.resolve()
    workers = [Worker(number, FOLDER/"core", tests) for number in range(options.workers)]
    files = sorted(f"tests/{path.relative_to(tests)}" for path in tests.rglob("test_*.py"))
    known, costs = recorded([file for file in files if not options.part or any(part in file for part in options.part)], workers, tests)
    campaign = Campaign(known, costs, options.limit, FOLDER/"core")
    verdicts = spread(campaign.judge, list(numbered.items()), workers)
    print("\nshare noticed by folder")
    for folder in dict.fromkeys(folder_of(fault.file) for fault in faults):
        mine = [found for found in verdicts if folder_of(found.fault.file) == folder]
        print(f"{folder}: {sum(bool(found.by) for found in mine)} of {len(mine)}")
    print(f"all: {sum(bool(found.by) for found in verdicts)} of {len(verdicts)}, {time.monotonic() - begun:.0f} s\n\nsurvivors")
    for found in verdicts:
        if not found.by:
            old, new = found.fault.texts()
            print(f"{found.fault.file}: {old} -> {new} ({found.tried} of {found.reaching} tests that reach it)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
