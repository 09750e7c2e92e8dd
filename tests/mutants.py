"""Whether the tests notice faults: `make mutants N=300 SEED=0 FAULTS="fortran/profile ldbench/bodies"`.

usage: python tests/mutants.py [-n N] [--seed SEED] [--tests FOLDER] [--part FILE ...] [--limit SECONDS] [WORD ...]
N faults are drawn by the rules of support/faults.py, of every folder of fortran/ and wrappers/ by the root of its size; words
choose folders. With N = 0 the faults of mutants.txt are taken whose file or text has one of the words: `file | tests`, then for
each fault the old text after `- ` and the new one after `+ `; `...` is test_walk.py. Faults of mutants_equivalent.txt, which
nobody can see, are not drawn.
What each test reaches is recorded once, by one run of the tests or of a part of them, and kept in build/mutants. For a fault those
tests run that reach it, the cheapest first, until one fails or their processor time comes to the limit. Faults of Fortran are
compiled all at once; LDBENCH_FAULT is the number of the one that a program has.
"""
from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import pickle
import queue
import random
import re
import shutil
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

REPO = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPO/"tests/support"))

from faults import EXECUTED, Change, Statement, blocks, constant, faults, marks, part, statements, switched  # noqa: E402

FOLDER = REPO/"build/mutants"
CORE, HOOK = FOLDER/"core", FOLDER/"hook"
SWITCH = b"""module ldbench_fault
  use, intrinsic :: iso_c_binding, only: c_int
  integer(c_int), bind(c, name='ldbench_fault_number') :: fault_number
  interface
    pure subroutine fault_mark(k) bind(c, name='ldbench_fault_mark')
      import :: c_int
      integer(c_int), value :: k
    end subroutine fault_mark
  end interface
end module ldbench_fault
"""
MARKS = b"""#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
int ldbench_fault_number;
static char marks[1 << 16] __attribute__((aligned(4096)));
void ldbench_fault_mark(int k) { marks[k] = 1; }
__attribute__((constructor)) static void begin(void) {
  const char *number = getenv("LDBENCH_FAULT"), *file = getenv("LDBENCH_MARKS");
  int opened = file ? open(file, O_RDWR) : -1;
  if (number) ldbench_fault_number = atoi(number);
  if (opened >= 0) mmap(marks, sizeof marks, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, opened, 0);
}
"""
# What decides a contact table.
IN_TABLES = re.compile("fortran/(profile|contact|table|support/kinds|support/root|program/run_[st])")
T = TypeVar("T")


class Fault(NamedTuple):
    """A change of a file, and the marks that tell that it is reached; the tests that a list names for it."""

    file: str
    change: Change
    marks: frozenset[int] = frozenset()
    tests: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Place, and the lines before and after."""
        source, change = read(self.file), self.change
        first, last = source.rfind(b"\n", 0, change.start) + 1, source.find(b"\n", change.end)
        new = change.of(source)[first:len(change.of(source)) - len(source) + last]
        before, after = (" ".join(text.decode().split()) for text in (source[first:last], new))
        return f"{self.file}:{source[:change.start].count(10) + 1}: {before} -> {after}"


@cache
def read(file: str) -> bytes:
    return (REPO/file).read_bytes()


@cache
def parsed(file: str) -> tuple[list[Statement], list[int | None]]:
    found = statements(read(file), Path(file).suffix)
    return found, marks(read(file), Path(file).suffix, found)


@cache
def sources() -> dict[str, int]:
    """The sources that have faults, and the first mark of each."""
    names = [str(path.relative_to(REPO)) for folder in ("fortran", "wrappers/ldbench", "wrappers/ldbench_round")
             for path in sorted((REPO/folder).rglob("*"))
             if path.suffix in (".py", ".f90") and path.parent.name not in ("windows", "lapack")]
    sizes = [len(blocks(ast.parse(read(name))) if name.endswith(".py") else parsed(name)[0]) for name in names]
    return dict(zip(names, accumulate(sizes, initial=0), strict=False))


@cache
def users(name: str, suffix: str) -> frozenset[int]:
    """The marks of the statements that have a name, or one that is made of it outside of functions."""
    found, names = set[int](), {name}
    for file, first in sources().items():
        if file.endswith(suffix) and name.encode() in read(file):
            for one, mark in zip(*parsed(file), strict=True):
                if any((word.lower() if suffix == ".f90" else word) == name for word in one.words):
                    found |= {first + mark} if mark is not None else set()
                    names |= {one.words[0]} if mark is None and suffix == ".py" and one.words[1:2] in (["="], [":"]) else set()
    return frozenset(found.union(*(users(other, suffix) for other in names - {name} if suffix == ".py")))


def located(file: str, change: Change) -> Fault | None:
    """The fault with its marks; None if it cannot be compiled behind a number."""
    found, lead = parsed(file)
    suffix, first = Path(file).suffix, sources()[file]
    n = next(n for n, one in enumerate(found) if one.end > change.start)
    if suffix == ".f90" and (found[n].kind not in EXECUTED | {"parameter"} or (
            part(found[n], change) if found[n].kind in EXECUTED - {"simple"} else
            constant(found[n], read(file), change) if found[n].kind == "parameter" else True) is None):
        return None
    if (mark := lead[n]) is not None:
        return Fault(file, change, frozenset({first + mark}))
    if found[n].kind == "parameter":
        name = constant(found[n], read(file), change)[0]
    else:
        name = next((one.words[0] for one in reversed(found[:n + 1]) if one.words[1:2] in (["="], [":"])), "")
    return Fault(file, change, users(name, suffix))


def compiles(fault: Fault) -> bool:
    """Whether the fault can be compiled and changes the program."""
    if fault.file.endswith(".py"):
        try:
            return ast.dump(ast.parse(fault.change.of(read(fault.file)))) != ast.dump(ast.parse(read(fault.file)))
        except SyntaxError:
            return False
    (FOLDER/"try.f90").write_bytes(switched(read(fault.file), {1: fault.change}))
    words = ["gfortran", "-fsyntax-only", "-std=f2018", "-fall-intrinsics", "-fopenmp", "-ffree-line-length-none", "-w",
             "-I", FOLDER, "-I", REPO/"build/release", "-J", FOLDER/"modules", FOLDER/"try.f90"]
    return bool(fault.marks) and subprocess.run(words, capture_output=True).returncode == 0


def folder_of(file: str) -> str:
    return re.sub(r"(support)/posix|(round)/commands", r"\1\2", str(Path(file).parent))


def sampled(number: int, seed: str, words: list[str]) -> list[Fault]:
    """Faults of every folder by the root of its size: a line is drawn, then a rule, then a change."""
    listed = (REPO/"tests/mutants_equivalent.txt").read_text(encoding="utf-8").splitlines()
    equivalent = {re.sub(r":\d+:", ":", line) for line in listed}
    shares: dict[str, dict[tuple[str, int], dict[str, list[Change]]]] = {}
    for file in sources():
        for one in parsed(file)[0]:
            for change in faults(read(file), one, Path(file).suffix):
                place = file, read(file)[:change.start].count(10)
                shares.setdefault(folder_of(file), {}).setdefault(place, {}).setdefault(change.rule, []).append(change)
    whole = sum(len(share)**0.5 for share in shares.values())
    found = []
    for folder, share in shares.items():
        draw, drawn = random.Random(f"{seed} {folder}"), dict[Change, Fault]()
        chosen = not words or folder.split("/")[0] in words or any(folder.endswith(word) for word in words)
        wanted = round(number*len(share)**0.5/whole)*chosen
        for _ in range(20*wanted):
            place = draw.choice(sorted(share))
            change = draw.choice(share[place][draw.choice(sorted(share[place]))])
            fault = located(place[0], change) if change not in drawn and len(drawn) < wanted else None
            if fault and re.sub(r":\d+:", ":", str(fault)) not in equivalent and compiles(fault):
                drawn[change] = fault
        found += drawn.values()
    return found


def listed(words: list[str]) -> list[Fault]:
    found = []
    for block in (REPO/"tests/mutants.txt").read_text(encoding="utf-8").strip().split("\n\n"):
        head, *lines = (line for line in block.splitlines() if not line.startswith("#"))
        file, _, tests = head.partition(" | ")
        for old, new in zip(lines[::2], lines[1::2], strict=True):
            start, size = read(file).find(old[2:].encode()), len(old[2:].encode())
            if read(file).count(old[2:].encode()) != 1:
                raise SystemExit(f"mutants.txt, {file}: expected once, found {read(file).count(old[2:].encode())} times: {old[2:]}")
            change = Change(start, start + size, new[2:], "listed")
            fault = located(file, change) if file in sources() else Fault(file, change)
            if fault is None:
                raise SystemExit(f"mutants.txt, {file}: expected a change within a statement, found {old[2:]}")
            if not words or any(word in str(fault) for word in words):
                found.append(fault._replace(tests=tuple(tests.replace("...", "tests/shown/test_walk.py").split())))
    return found


def run(words: list[Any], **options: Any) -> None:
    done = subprocess.run(words, capture_output=True, text=True, **options)
    if done.returncode:
        raise SystemExit(f"{words[:2]}: {done.stdout[-2000:]}{done.stderr[-4000:]}")


def put(path: Path, new: bytes) -> None:
    """Writes a file unless it is so already, for `make` looks at times."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.is_file() or path.read_bytes() != new:
        path.write_bytes(new)


def plain(folder: Path) -> None:
    """A copy of the repository without tests, with a virtual environment whose packages are those of the copy and then ours."""
    names = subprocess.run(["git", "ls-files"], cwd=REPO, capture_output=True, text=True, check=True).stdout.splitlines()
    for name in names:
        if (REPO/name).is_file() and not name.startswith("tests/") and not (folder == CORE and name in sources()):
            put(folder/name, (REPO/name).read_bytes())
            (folder/name).chmod((REPO/name).stat().st_mode)
    site = folder/".venv"/Path(sysconfig.get_path("purelib")).relative_to(sys.prefix)
    put(site/"faults.pth", f"{folder}/wrappers\n{HOOK}\nimport site; site.addsitedir({sysconfig.get_path('purelib')!r})\n"
                           "import os; 'LDBENCH_MARKS' in os.environ and __import__('marks')\n".encode())
    for name in ("pyvenv.cfg", "stamp"):
        put(folder/".venv"/name, (REPO/".venv"/name).read_bytes())
    (folder/".venv/bin").mkdir(exist_ok=True)
    if not (folder/".venv/bin/python").exists():
        (folder/".venv/bin/python").symlink_to(Path(sys.executable).resolve())


def build(changes: dict[int, Fault]) -> None:
    """What `make` builds, with all faults of Fortran and with marks."""
    plain(CORE)
    for file, first in sources().items():
        if file.endswith(".f90"):
            put(CORE/file, switched(read(file), {k: fault.change for k, fault in changes.items() if fault.file == file}, first))
    for path in (REPO/"tests/fortran").iterdir():
        put(CORE/path.relative_to(REPO), path.read_bytes())
    put(CORE/"fortran/support/ldbench_fault.f90", SWITCH)
    put(CORE/"marks.c", MARKS)
    put(CORE/"build/release/fingerprint.f90", (REPO/"build/release/fingerprint.f90").read_bytes())
    (CORE/"build/release/fingerprint.f90").touch()      # tables are those of the plain sources
    run(["gcc", "-O2", "-fPIC", "-c", "marks.c"], cwd=CORE)
    programs = [f"build/release/tests/{path.stem}" for path in (CORE/"tests/fortran").glob("*.f90") if path.stem != "shared"]
    run(["make", f"-j{os.cpu_count()}", "ldbench", "build/wrapper/installed", "build/release/lib/libldbench.so",
         "wrappers/ldbench/_core/fmu/linux64/wheelset.so", *programs, "FC=gfortran -ffree-line-length-none", "WARN=",
         "OWN=marks.o"],
        cwd=CORE, env={"HOME": os.environ["HOME"], "PATH": f"{REPO}/.venv/bin:{os.environ['PATH']}"})


class Worker:
    """A copy of the repository with the core that has faults, and the process that runs tests there."""

    def __init__(self, number: int, tests: Path, state: str) -> None:
        self.folder, self.world = FOLDER/str(number), FOLDER/f"world{number}-{state[:16]}"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.tables = self.folder/"build/tables"/f"ldbench-{hashlib.sha256((CORE/'ldbench').read_bytes()).hexdigest()[:16]}"
        plain(self.folder)
        for pattern in ("ldbench", "build/release/**/*", "wrappers/ldbench/_core/_flat*.so", "wrappers/ldbench/_core/fmu/**/*"):
            for path in CORE.glob(pattern):
                if path.is_file():
                    (self.folder/path.relative_to(CORE)).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy2(path, self.folder/path.relative_to(CORE))
        shutil.copytree(tests, self.folder/"tests", ignore=shutil.ignore_patterns("__pycache__"))
        environment = {name: os.environ[name] for name in ("HOME", "PATH")} | {
            "OMP_NUM_THREADS": "1", "LDBENCH": f"{self.folder}/ldbench", "LDBENCH_TESTS": f"{self.folder}/build/release/tests"}
        words = [self.folder/".venv/bin/python", HOOK/"reach.py"]
        self.server = subprocess.Popen(words, cwd=self.folder, env=environment, text=True,
                                       stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def ask(self, files: list[str], limit: float, environment: dict[str, str], **more: Any) -> tuple[int, list[str]]:
        """The status of pytest, and which tests failed."""
        words = ["-q", "--tb=short", "-n0", "-p", "no:randomly", f"--basetemp={self.folder}/t", *["-x"]*("limits" in more), *files]
        environment = {"PYTHONPYCACHEPREFIX": f"{self.folder}/build/bytecode"} | environment
        self.server.stdin.write(json.dumps({"words": words, "limit": limit, "environment": environment,
                                            "world": str(self.world), "log": f"{self.folder}/log", **more}) + "\n")
        self.server.stdin.flush()
        answer = json.loads(self.server.stdout.readline())
        shutil.rmtree(self.folder/"t", ignore_errors=True)
        return answer

    def record(self, file: str, into: Path) -> None:
        """Writes what the tests of a file reach."""
        (self.folder/"marks").write_bytes(bytes(1 << 16))
        firsts = {name.removeprefix("wrappers/"): first for name, first in sources().items() if name.endswith(".py")}
        (self.folder/"marks.json").write_text(json.dumps(firsts), encoding="utf-8")
        begun = time.monotonic()
        status, failed = self.ask([file], 3600.0, {"LDBENCH_MARKS": f"{self.folder}/marks",
                                                   "PYTHONPYCACHEPREFIX": f"{self.folder}/build/marked"}, record=f"{into}.part")
        print(f"recorded {file}: {time.monotonic() - begun:.0f} s; not passed: {failed}", flush=True)
        if status in (0, 1, 5):
            Path(f"{into}.part").rename(into)
            if self.tables.is_dir():
                shutil.copytree(self.tables, self.world/"tables", dirs_exist_ok=True)
        else:
            print((self.folder/"log").read_text(encoding="utf-8", errors="replace")[-1500:])


class Known(NamedTuple):
    """A test: processor time and time that passes, what it reaches itself, what tests of its file reach, what it shares."""

    name: str
    seconds: float
    elapsed: float
    marks: frozenset[int]
    nearby: frozenset[int]
    shared: frozenset[str]


def spread(work: Callable[[Worker, Any], T], jobs: list[Any], workers: list[Worker]) -> list[T]:
    """work(worker, job) of all jobs, each worker one at a time."""
    free = queue.SimpleQueue[Worker]()
    for worker in workers:
        free.put(worker)

    def one(job: Any) -> T:
        worker = free.get()
        try:
            return work(worker, job)
        finally:
            free.put(worker)

    with ThreadPoolExecutor(len(workers)) as pool:
        return list(pool.map(one, jobs))


def state_of(tests: Path) -> str:
    """The hash of what decides what tests reach, but for their own files."""
    hooks = (path.read_bytes() for path in sorted(HOOK.glob("*.py")))
    state = hashlib.sha256(b"".join([*(read(name) for name in sources()), *hooks]))
    for path in sorted(path for path in tests.rglob("*.py") if not path.name.startswith("test_")):
        state.update(path.read_bytes())
    return state.hexdigest()


def recorded(files: list[str], workers: list[Worker], tests: Path,
             state: str) -> tuple[list[Known], dict[str, tuple[float, set[int]]]]:
    """The tests of files that pass, and what is shared by several, what it costs and reaches."""
    kept = {file: FOLDER/"reach"/hashlib.sha256(state.encode() + file.encode() + (tests.parent/file).read_bytes()).hexdigest()
            for file in files}
    missing = [file for file, path in kept.items() if not path.is_file()]
    spread(lambda worker, file: worker.record(file, kept[file]), missing, workers)
    made = [pickle.loads(path.read_bytes()) for path in kept.values() if path.is_file()]
    shared, found = dict[str, tuple[float, set[int]]](), list[Known]()
    for _, several, _, _ in made:
        for name, (cost, reached) in several.items():
            spent, before = shared.get(name, (0.0, set()))
            shared[name] = max(cost, spent), before.union(reached)
    tables = {first + k for file, first in sources().items() if IN_TABLES.search(file) for k in range(len(parsed(file)[0]))}
    first = sources()["fortran/table/table_file.f90"]
    reading = set(range(first, first + len(parsed("fortran/table/table_file.f90")[0])))
    making = tables.intersection(mark for known, _, _, _ in made for _, _, reached, _ in known.values() for mark in reached)
    for known, _, failed, loaded in made:
        own = {name: frozenset(reached).union(*(shared[one][1] for one in uses if one in shared))
               for name, (_, _, reached, uses) in known.items()}
        nearby = frozenset(loaded).union(*own.values())
        nearby |= making if nearby & reading else set()         # tables that an earlier file has made
        found += [Known(name, seconds, elapsed, own[name], nearby, frozenset(uses))
                  for name, (seconds, elapsed, _, uses) in known.items() if name not in failed]
    spent = sum(one.seconds for one in found) + sum(cost for cost, _ in shared.values())
    print(f"{len(found)} tests, {spent:.0f} s of processor time", flush=True)
    return found, shared


class Verdict(NamedTuple):
    """Which test noticed a fault, how many were run, and how many reach it."""

    fault: Fault
    by: str
    tried: int
    reaching: int


class Campaign:
    """Tests against faults."""

    def __init__(self, tests: list[Known], shared: dict[str, tuple[float, set[int]]], limit: float) -> None:
        self.tests, self.shared, self.limit = tests, shared, limit
        self.noticed: dict[tuple[str, str], int] = {}       # by file and test

    def cost(self, one: Known, fault: Fault, made: frozenset[str] = frozenset()) -> float:
        """Processor time of a test with the fixtures and parts of the golden world that are made anew for it."""
        return one.seconds + sum(cost for name, (cost, reached) in self.shared.items() if name in one.shared - made and (
            "::" in name or reached & fault.marks))

    def chunks(self, fault: Fault) -> Iterator[list[Known]]:
        """Tests that reach a fault, each time for three times as long: first those that are named, reach it themselves, cost
        little, reach little else, and noticed other faults of the file."""
        def rank(one: Known) -> tuple[bool, bool, float]:
            return (not one.name.startswith(fault.tests or ("?",)), not one.marks & fault.marks,
                    (self.cost(one, fault) + 0.2)*len(one.marks)/(1 + self.noticed.get((fault.file, one.name), 0)))

        room, total, chunk, cost, made = 3.0, 0.0, list[Known](), 0.0, frozenset[str]()
        for one in sorted(self.reaching(fault), key=rank):
            new = self.cost(one, fault, made)
            if total + new > self.limit and total:
                break
            if chunk and cost + new > room:
                yield chunk
                room, chunk, cost, made = 3*room, [], 0.0, frozenset()
            chunk, cost, total, made = [*chunk, one], cost + new, total + new, made | one.shared
        if chunk:
            yield chunk

    def reaching(self, fault: Fault) -> list[Known]:
        return [one for one in self.tests if one.nearby & fault.marks or one.name.startswith(fault.tests or ("?",))]

    def limits(self, tests: list[Known]) -> dict[str, float]:
        """A test that takes much longer than ever hangs."""
        return {one.name: 60 + 20*(one.elapsed + sum(cost for name, (cost, _) in self.shared.items() if name in one.shared))
                for one in tests}

    def judge(self, worker: Worker, numbered: tuple[int, Fault]) -> Verdict:
        k, fault = numbered
        file, begun, tried, failed = worker.folder/fault.file, time.monotonic(), 0, list[str]()
        anew = [name for name, (_, reached) in self.shared.items() if "::" not in name and reached & fault.marks]
        shutil.rmtree(worker.world/"anew", ignore_errors=True)
        shutil.rmtree(worker.tables, ignore_errors=True)
        if not IN_TABLES.search(fault.file) and (worker.world/"tables").is_dir():
            shutil.copytree(worker.world/"tables", worker.tables)
        if not fault.file.endswith(".f90"):
            file.write_bytes(fault.change.of(read(fault.file)))
            os.utime(file, (1e9 + k, 1e9 + k))      # byte code of another fault is not taken for that of this one
        for chunk in self.chunks(fault):
            tried += len(chunk)
            files = list(dict.fromkeys(one.name.partition("::")[0] for one in chunk))
            status, failed = worker.ask(files, 900.0, {"LDBENCH_FAULT": str(k)},
                                        limits=self.limits(chunk), anew=anew)
            if status not in (0, 5):
                failed = failed or [f"{chunk[0].name} is not collected"]
                break
        if not fault.file.endswith(".f90"):
            shutil.copy2(REPO/fault.file, file)
        for name in failed:
            self.noticed[fault.file, name] = self.noticed.get((fault.file, name), 0) + 1
        found = Verdict(fault, " ".join(failed), tried, len(self.reaching(fault)))
        took = f"{tried} of {found.reaching} tests, {time.monotonic() - begun:.0f} s"
        print(f"{k:3} {fault}\n    {found.by or 'SURVIVED'} ({took})", flush=True)
        return found

    def unreliable(self, worker: Worker, verdicts: list[Verdict]) -> set[str]:
        """Which of the tests that noticed something fail without a fault, run as they were then."""
        names = {found.by for found in verdicts}
        return {name for one in self.tests if one.name in names
                for name in worker.ask([one.name.partition("::")[0]], 900.0, {}, limits=self.limits([one]))[1]}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-n", type=int, default=300)
    parser.add_argument("--seed", default="0")
    parser.add_argument("--tests", type=Path, default=REPO/"tests")
    parser.add_argument("--part", nargs="*", default=[""])
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("words", nargs="*")
    options = parser.parse_args()
    begun, tests = time.monotonic(), options.tests.resolve()
    for folder in (HOOK, FOLDER/"modules", FOLDER/"reach"):
        folder.mkdir(parents=True, exist_ok=True)
    for name in ("faults.py", "marks.py", "reach.py"):
        shutil.copy(REPO/"tests/support"/name, HOOK)
    put(FOLDER/"switch.f90", SWITCH)
    run(["gfortran", "-fsyntax-only", "-J", FOLDER, FOLDER/"switch.f90"])
    numbered = dict(enumerate(sampled(options.n, options.seed, options.words) if options.n else listed(options.words), 1))
    build(numbered)
    print(f"{len(numbered)} faults, compiled after {time.monotonic() - begun:.0f} s", flush=True)
    state = state_of(tests)
    workers = [Worker(number, tests, state) for number in range(options.workers)]
    files = sorted(f"tests/{path.relative_to(tests)}" for path in tests.rglob("test_*.py"))
    files = [file for file in files if any(part in file for part in options.part)]
    campaign = Campaign(*recorded(files, workers, tests, state), options.limit)
    for worker in workers:
        shutil.rmtree(worker.folder/"build/bytecode", ignore_errors=True)
    verdicts = spread(campaign.judge, list(numbered.items()), workers)
    wrong = campaign.unreliable(workers[0], verdicts)
    print("".join(f"\nfails without a fault: {name}" for name in wrong) + "\nnoticed by folder")
    for folder in (*dict.fromkeys(folder_of(found.fault.file) for found in verdicts), "all"):
        mine = [bool(found.by) and found.by not in wrong for found in verdicts if folder in (folder_of(found.fault.file), "all")]
        print(f"{folder}: {sum(mine)} of {len(mine)}")
    print(f"{time.monotonic() - begun:.0f} s\nsurvivors")
    for found in verdicts:
        if not found.by or found.by in wrong:
            print(f"{found.fault} ({found.tried} of {found.reaching} tests that reach it)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
