"""Fixtures and hooks of all tests; what they import stands in tests/support."""
from __future__ import annotations

import functools
import gc
import hashlib
import logging
import os
import shutil
import signal
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from running import (
    CASES,
    FORTRAN_TESTS,
    LDBENCH,
    PAIRS,
    REPO,
    Run,
    for_all_cases,
    once,
    read_shipped,
    run_shipped,
)

if TYPE_CHECKING:
    import ldbench
    from ldbench import ContactTable
    from ldbench_round.tasks import Task
    from specimen import World

# A shell makes what it starts in the background ignore Ctrl-C, and so would the programs that tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what this build or this call does not run."""
    if item.get_closest_marker("same_build") and LDBENCH.name != "ldbench":
        pytest.skip("the executable is not the extension's build")
    if item.get_closest_marker("slow") and "LDBENCH_SLOW" not in os.environ:
        pytest.skip("slow: LDBENCH_SLOW=1 runs it")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
        item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Tests of the core's modules need programs that `make test` builds and `make` does not: without them they are skipped."""
    report = yield
    error = call.excinfo.value if call.excinfo else None
    if isinstance(error, FileNotFoundError) and Path(str(error.filename)).parent == FORTRAN_TESTS:
        report.outcome = "skipped"
        report.longrepr = str(item.path), 0, f"no {error.filename}: make test builds it"
    return report


def pytest_collection_finish() -> None:
    """What was imported and collected lives to the end: the search for garbage, again and again, need not look at it."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def tables_in_memory() -> Iterator[None]:
    """Contact tables that go to no file stay in memory: hundreds of tests run cases whose tables are the same. A test of the
    building of a table names a file."""
    from ldbench import Case, ContactTable  # programs that only start the executable need no package
    from ldbench.ensembles.members import table_keys

    make, kept = ContactTable._make, {}

    def remembered(table: ContactTable, case: Case, progress: object) -> None:
        key = table_keys()(case)
        if case.table_file or key not in kept:
            make(table, case, progress)
            if not case.table_file:
                kept[key] = table
            return
        table._own(case, kept[key].for_case(case)._handle)
        logging.getLogger("ldbench.table").info("%s: %r", case.label, table)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ContactTable, "_make", remembered)
        yield


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


@pytest.fixture(scope="session")
def common(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all workers see."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@contextmanager
def kept_tables(files: Iterable[Path]) -> Iterator[None]:
    """Contact tables that the block builds, unless earlier tests of the very same program left them in build/tables.

    A table is a function of its case and of the program, to the last byte, so the first tests of a program build it and later
    ones read it. The core looks at the file as at any other and builds a table that does not fit.
    """
    program = hashlib.sha256(LDBENCH.read_bytes()).hexdigest()[:16]
    folder = REPO / "build/tables" / f"{LDBENCH.name}-{program}"
    for file in files:
        if (folder / file.name).exists():
            shutil.copyfile(folder / file.name, file)
    yield
    for outdated in folder.parent.glob(f"{LDBENCH.name}-{'[0-9a-f]'*16}"):
        if outdated != folder:
            shutil.rmtree(outdated, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    for file in files:
        if not (folder / file.name).exists():
            part = folder / f"{file.name}.part{os.getpid()}"
            shutil.copyfile(file, part)
            part.replace(folder / file.name)


def tables_of(model: str, folder: Path, **points: int) -> dict[str, Path]:
    """Files of a law's contact tables of both pairs of profiles, as fine as those of the shipped inputs unless points are given,
    made in a folder."""
    files = {pair: folder / f"{folder.name}_{pair}.table" for pair in PAIRS}
    with once(folder) as first:
        if first:
            from ldbench import Case, ContactTable  # programs that only start the executable need no package

            with kept_tables(files.values()):
                for pair, file in files.items():
                    ContactTable(Case.exercise(2, pair).replace(model=model, table_file=file, **points))
    return files


@pytest.fixture(scope="session")
def strip_tables(common: Path) -> dict[str, Path]:
    """Files of the strips' contact tables of both pairs of profiles."""
    return tables_of("strip", common / "strips")


@pytest.fixture(scope="session")
def hertz_tables(common: Path) -> dict[str, Path]:
    """Files of the contact tables of Hertz's law of both pairs of profiles."""
    return tables_of("hertz", common / "hertz")


@pytest.fixture(scope="session")
def read_hertz(hertz_tables: dict[str, Path]) -> Callable[[str], ContactTable]:
    """The contact tables of Hertz's law by the pair of profiles, each read once."""
    from ldbench import Case, ContactTable  # programs that only start the executable need no package

    return functools.cache(lambda pair: ContactTable.quiet(
        Case.exercise(2, pair).replace(model="hertz", table_file=hertz_tables[pair])))


@pytest.fixture(scope="session")
def fine_hertz(common: Path) -> Callable[[str], ContactTable]:
    """The contact tables of Hertz's law that fingerprints build, by the pair of profiles, each read once."""
    from ldbench import Case, ContactTable  # programs that only start the executable need no package
    from ldbench_round.fingerprint import FINE

    files = tables_of("hertz", common / "fine_hertz", **FINE)
    return functools.cache(lambda pair: ContactTable.quiet(
        Case.exercise(2, pair).replace(model="hertz", table_file=files[pair], **FINE)))


@pytest.fixture
def known_hertz(fine_hertz: Callable[[str], ContactTable], monkeypatch: pytest.MonkeyPatch) -> None:
    """Fingerprints do not build the tables of Hertz's law."""
    monkeypatch.setattr("ldbench_round.fingerprint.hertz_table", fine_hertz)


@pytest.fixture(scope="session")
def shipped(common: Path) -> dict[str, Run]:
    """The ten shipped inputs, each run once."""
    folder = common / "shipped"
    with once(folder) as first:
        if first:
            with kept_tables([folder / f"{pair}_halfspace.table" for pair in PAIRS]):
                for_all_cases(lambda case: run_shipped(case, folder))
    return {case: read_shipped(case, folder) for case in CASES}


@pytest.fixture(scope="session")
def ours(shipped: dict[str, Run]) -> dict[Task, ldbench.Run]:
    """The shipped runs of exercises 1 to 4, read."""
    from ldbench import read_run  # programs that only start the executable need no package
    from ldbench_round.tasks import TASKS

    return {task: read_run(shipped[task.name].file) for task in TASKS if task.exercise < 5}


@pytest.fixture(scope="session")
def world(common: Path) -> World:
    """A small project and its report, made once for all workers."""
    from raw import Raw
    from specimen import World, make_specimen

    folder = common / "specimen"
    with once(folder) as first:
        if first:
            make_specimen(folder)
    return World(folder, *(Raw(folder / f"outputs/{name}.txt") for name in ("ex2_aw", "ex5_aw")))


@pytest.fixture
def own(ours: dict[Task, ldbench.Run], monkeypatch: pytest.MonkeyPatch) -> None:
    """Our own runs, by which maps are guessed, are the shipped ones, whatever a test of another file has put there."""
    from ldbench_round import own_runs

    for task, run in ours.items():
        monkeypatch.setitem(own_runs._OWN, task, run)
