"""What each test reaches, noted while it runs; and a server that runs tests against faults, in a new process for each.

The marks are bytes of a file that all processes of a test see, those of the core too: byte k is 1 if block k ran. Programs of Python
that find this module set up mark by themselves; faults.blocks says what they mark.
"""
from __future__ import annotations

import ast
import builtins
import functools
import importlib
import importlib.machinery
import json
import mmap
import os
import pickle
import signal
import sys
import time
from array import array
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import faults

SIZE = 65536                # of the file of marks
FOLDER = "/wrappers/"
USED = ("numpy pandas scipy.optimize scipy.interpolate scipy.linalg scipy.signal scipy.sparse matplotlib.figure xarray "
        "matplotlib.backends.backend_pdf matplotlib.backends.backend_svg dask distributed pypdf PIL.Image pytest _pytest.assertion.rewrite")
Marks = int                 # with byte k 1 for block k


class Reach:
    """The marks of this process and of those that it starts."""

    def __init__(self, file: str) -> None:
        with open(file, "r+b") as opened:
            self.bytes = mmap.mmap(opened.fileno(), SIZE)
        with open(f"{file}.json", encoding="utf-8") as opened:
            self.firsts = json.load(opened)
        builtins.__mark__ = self.bytes.__setitem__  # type: ignore[attr-defined]

    def take(self) -> Marks:
        """The marks since the last call."""
        found = int.from_bytes(self.bytes[:], "little")
        self.bytes[:] = bytes(SIZE)
        return found

    @contextmanager
    def noted(self, known: dict[Any, Marks], key: Any) -> Iterator[None]:
        """Adds the marks of the block to those known of a key, all of which count for what is around it: as if all ran again."""
        around = self.take()
        try:
            yield
        finally:
            known[key] = known.get(key, 0) | self.take()
            self.bytes[:] = (around | known[key]).to_bytes(SIZE, "little")

    def install(self) -> None:
        """Marks blocks of the packages, and gives those who take a kept value the marks of its making."""
        plain, cache, lasting = importlib.machinery.SourceFileLoader.source_to_code, functools.lru_cache, functools.cached_property

        def marked(loader: Any, data: Any, path: Any, *more: Any, **options: Any) -> Any:
            first = self.firsts.get(str(path).rpartition(FOLDER)[2])
            if first is None or not isinstance(data, bytes):
                return plain(loader, data, path, *more, **options)
            tree = ast.parse(data)
            for k, (_, body) in enumerate(faults.blocks(tree)):
                texts = isinstance(body[0], ast.Expr) and isinstance(body[0].value, ast.Constant)
                call = ast.Expr(ast.Call(ast.Name("__mark__", ast.Load()), [ast.Constant(first + k), ast.Constant(1)], []))
                body.insert(int(texts), ast.copy_location(call, body[0]))
            return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

        def ours(function: Any) -> bool:
            code = getattr(function, "__code__", None)
            return code is not None and (FOLDER in code.co_filename or "/tests/" in code.co_filename)

        def kept(function: Any) -> Any:
            inner, known = cache(maxsize=None)(function), dict[Any, Marks]()

            @functools.wraps(function)
            def call(*words: Any, **named: Any) -> Any:
                with self.noted(known, (words, *named.items())):
                    return inner(*words, **named)
            call.cache_clear, call.cache_info = inner.cache_clear, inner.cache_info  # type: ignore[attr-defined]
            return call

        def lru_cache(maxsize: Any = 128, typed: bool = False) -> Any:
            if callable(maxsize):
                return kept(maxsize) if ours(maxsize) else cache(maxsize)
            return lambda function: kept(function) if ours(function) else cache(maxsize, typed)(function)

        class Lasting(lasting):
            """A property whose readers get the marks of the first one."""

            def __init__(self, function: Callable[[Any], Any]) -> None:
                super().__init__(function)
                self.known: dict[int, Marks] = {}

            def __get__(self, instance: Any, owner: Any = None) -> Any:
                if instance is None or not ours(self.func):
                    return super().__get__(instance, owner)
                if self.attrname in instance.__dict__ and id(instance) not in self.known:
                    return instance.__dict__[self.attrname]
                with here.noted(self.known, id(instance)):
                    return super().__get__(instance, owner)

            def __set__(self, instance: Any, value: Any) -> None:
                instance.__dict__[self.attrname] = value

        here = self
        importlib.machinery.SourceFileLoader.source_to_code = marked  # type: ignore[method-assign]
        functools.lru_cache, functools.cached_property = lru_cache, Lasting  # type: ignore[misc]
        functools.cache = lambda function: lru_cache(maxsize=None)(function)


class Recorder:
    """Writes what tests and their shared fixtures reach, and what they cost."""

    def __init__(self, file: str, reach: Reach) -> None:
        self.file, self.reach = file, reach
        self.tests: dict[str, tuple[float, float, array[int], list[str]]] = {}
        self.costs: dict[str, float] = {}
        self.fixtures: dict[str, Marks] = {}
        self.failed: set[str] = set()
        self.inside = 0.0
        self.loaded = array("H")

    def pytest_runtestloop(self) -> None:
        self.loaded = places(self.reach.take())

    @importlib.import_module("pytest").hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Generator[None, Any, Any]:
        if fixturedef.scope == "function":
            return (yield)
        begun, name, before = seconds(), name_of(fixturedef), self.inside
        with self.reach.noted(self.fixtures, name):
            result = yield
        self.costs[name] = max(self.costs.get(name, 0.0), seconds() - begun - self.inside + before)
        self.inside = before + seconds() - begun
        return result

    @importlib.import_module("pytest").hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Generator[None, Any, Any]:
        self.reach.take()
        self.inside, begun, now = 0.0, seconds(), time.monotonic()
        result = yield
        shared = [name_of(found[-1]) for found in item._fixtureinfo.name2fixturedefs.values() if found[-1].scope != "function"]
        self.tests[item.nodeid] = (max(seconds() - begun - self.inside, 1e-3), time.monotonic() - now,
                                   places(self.reach.take()), shared)
        return result

    def pytest_runtest_logreport(self, report: Any) -> None:
        if not report.passed:
            self.failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        with open(self.file, "wb") as file:
            pickle.dump((self.tests, {name: (self.costs[name], places(found)) for name, found in self.fixtures.items()},
                         self.failed, self.loaded), file)


class Chosen:
    """Runs some tests of files, in their order, each with a limit of time."""

    def __init__(self, limits: dict[str, float]) -> None:
        self.limits, self.failed = limits, ""

    @importlib.import_module("pytest").hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        found = {item.nodeid: item for item in items}
        items[:] = [found[name] for name in self.limits if name in found]

    @importlib.import_module("pytest").hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: Any) -> Generator[None, Any, Any]:
        signal.setitimer(signal.ITIMER_REAL, self.limits[item.nodeid])
        result = yield
        signal.setitimer(signal.ITIMER_REAL, 0)
        return result

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid


def places(found: Marks) -> array[int]:
    return array("H", (k for k, byte in enumerate(found.to_bytes(SIZE, "little")) if byte))


def name_of(fixturedef: Any) -> str:
    return f"{fixturedef.baseid}::{fixturedef.argname}"


def seconds() -> float:
    return sum(os.times()[:4])


def work(job: dict[str, Any], answer: int) -> None:
    """What the child does: the tests of a job, and its answer."""
    os.setsid()
    os.environ.update(job["environment"])
    sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"]
    out = os.open(job["log"], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(out, 1)
    os.dup2(out, 2)
    if "record" in job:
        reach = Reach(os.environ["LDBENCH_MARKS"])
        reach.install()
        plugin: Any = Recorder(job["record"], reach)
    else:
        plugin = Chosen(job["limits"])
    status = int(importlib.import_module("pytest").main(job["words"], plugins=[plugin]))
    os.write(answer, json.dumps([status, getattr(plugin, "failed", "") if "record" not in job else ""]).encode())
    os._exit(0)


def serve() -> None:
    """Answers one job a line: the status of pytest and the first test that failed; the signal that ended the tests."""
    for name in USED.split():
        with suppress(ImportError):
            importlib.import_module(name)
    for line in sys.stdin:
        job = json.loads(line)
        begun, (reading, writing) = time.monotonic(), os.pipe()
        child = os.fork()
        if not child:
            work(job, writing)
        os.close(writing)
        ended, status = 0, 0
        while not ended and time.monotonic() < begun + job["limit"]:
            ended, status = os.waitpid(child, os.WNOHANG)
            time.sleep(0.01)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        if not ended:
            os.waitpid(child, 0)
        with os.fdopen(reading, "rb") as found:
            answer = json.loads(found.read() or b"[-1, \"\"]") if ended and not status else [-1, "hangs"]
        print(json.dumps([*answer, seconds()]), flush=True)


if __name__ == "__main__":
    serve()
elif "LDBENCH_MARKS" in os.environ:
    Reach(os.environ["LDBENCH_MARKS"]).install()
