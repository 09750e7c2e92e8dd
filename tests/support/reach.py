"""Runs tests in a new process for each call, notes what each reaches, and says which failed."""
from __future__ import annotations

import importlib
import json
import os
import pickle
import shutil
import signal
import sys
import time
from array import array
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

import marks

IMPORTED = ("numpy pandas scipy.optimize scipy.interpolate scipy.linalg scipy.signal scipy.sparse matplotlib.figure xarray dask "
            "distributed "
            "matplotlib.backends.backend_pdf matplotlib.backends.backend_svg pypdf PIL.Image")     # by the tests, and takes long


class World:
    """The parts of the golden world: as they are without a fault, those anew whose making reaches the fault."""

    def __init__(self, folder: str, anew: list[str], recorder: Recorder | None = None) -> None:
        self.folder, self.anew, self.recorder = Path(folder), anew, recorder
        sys.path.insert(0, "tests/support")
        with suppress(ImportError):
            importlib.import_module("golden").kept = self.kept

    def kept(self, part: str, key: str, make: Callable[[Path], object], *recipe: str) -> Path:
        folder = self.folder/"plain"/part
        if part in self.anew or not (self.recorder or (folder/"whole").exists()):
            folder = self.folder/"anew"/part
        if not (folder/"whole").exists():
            shutil.rmtree(folder, ignore_errors=True)
            (folder/"made").mkdir(parents=True)
            if self.recorder:
                with self.recorder.noted(part):
                    make(folder/"made")
                (folder/"reach").write_bytes(pickle.dumps(self.recorder.shared[part]))
            else:
                make(folder/"made")
            (folder/"whole").touch()
        if self.recorder:
            self.recorder.shared[part] = pickle.loads((folder/"reach").read_bytes())
            self.recorder.marks.put(set(self.recorder.shared[part][1]))
            self.recorder.parts.add(part)
        return folder/"made"


class Recorder:
    """Writes what each test reaches, and each shared fixture and part of the golden world, and their processor time."""

    def __init__(self, file: str) -> None:
        self.file, self.marks = file, marks.Marks()
        self.parts = set[str]()
        self.tests: dict[str, tuple[float, float, array[int], list[str]]] = {}
        self.shared: dict[str, tuple[float, array[int]]] = {}
        self.failed: set[str] = set()
        self.loaded = array("H")
        self.inside = 0.0

    def pytest_runtestloop(self) -> None:
        self.loaded = array("H", sorted(self.marks.take()))

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Generator[None, Any, Any]:
        if fixturedef.scope == "function":
            return (yield)
        with self.noted(name_of(fixturedef)):
            return (yield)

    @contextmanager
    def noted(self, name: str) -> Iterator[None]:
        """Counts what several tests share for itself; what it reaches counts for the test, too."""
        begun, before, around = seconds(), self.inside, self.marks.take()
        try:
            yield
        finally:
            found, (spent, known) = self.marks.take(), self.shared.get(name, (0.0, array("H")))
            self.shared[name] = max(spent, seconds() - begun - self.inside + before), array("H", sorted(found.union(known)))
            self.inside = before + seconds() - begun
            self.marks.put(found | around)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Generator[None, Any, Any]:
        self.marks.take()
        self.inside, begun, now = 0.0, seconds(), time.monotonic()
        self.parts.clear()
        result = yield
        fixtures = (found[-1] for found in item._fixtureinfo.name2fixturedefs.values())
        shared = [*self.parts, *(name_of(found) for found in fixtures if found.scope != "function")]
        self.tests[item.nodeid] = (seconds() - begun - self.inside, time.monotonic() - now,
                                   array("H", sorted(self.marks.take())), shared)
        return result

    def pytest_runtest_logreport(self, report: Any) -> None:
        if not report.passed:
            self.failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        with open(self.file, "wb") as file:
            pickle.dump((self.tests, self.shared, self.failed, self.loaded), file)


class Chosen:
    """Runs the tests that have a limit of time, in their order, up to that which fails."""

    def __init__(self, limits: dict[str, float]) -> None:
        self.limits, self.failed = limits, list[str]()

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        found = {item.nodeid: item for item in items}
        items[:] = [found[name] for name in self.limits if name in found]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Generator[None, Any, Any]:
        signal.setitimer(signal.ITIMER_REAL, self.limits[item.nodeid])      # ends this process, wherever it is
        result = yield
        signal.setitimer(signal.ITIMER_REAL, 0)
        return result

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.failed += [report.nodeid]*report.failed


def name_of(fixturedef: Any) -> str:
    return f"{fixturedef.baseid}::{fixturedef.argname}"


def seconds() -> float:
    return sum(os.times()[:4])


def run(job: dict[str, Any]) -> tuple[int, list[str]]:
    """The status of pytest and the tests that failed."""
    os.setsid()
    os.environ.update(job["environment"])
    sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"]
    log = os.open(job["log"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(log, 1)
    os.dup2(log, 2)
    plugin: Any = Recorder(job["record"]) if "record" in job else Chosen(job["limits"])
    World(job["world"], job.get("anew", []), plugin if "record" in job else None)
    status = int(pytest.main(job["words"], plugins=[plugin]))
    return status, sorted(plugin.failed)


def serve() -> None:
    """Answers jobs, one a line, each from a child that ends within its limit."""
    for name in IMPORTED.split():
        with suppress(ImportError):
            importlib.import_module(name)
    for line in sys.stdin:
        job = json.loads(line)
        end, (reading, writing) = time.monotonic() + job["limit"], os.pipe()
        child = os.fork()
        if not child:
            os.write(writing, json.dumps(run(job)).encode())
            os._exit(0)
        os.close(writing)
        while not (ended := os.waitpid(child, os.WNOHANG)[0]) and time.monotonic() < end:
            time.sleep(0.01)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)        # with what its tests left running
        if not ended:
            os.waitpid(child, 0)
        with os.fdopen(reading) as answer:
            print(answer.read() or '[-1, ["hangs"]]', flush=True)


if __name__ == "__main__":
    serve()
