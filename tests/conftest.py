"""Fixtures and hooks of all tests; what they import stands in tests/support."""
from __future__ import annotations

import functools
import gc
import os
import signal
import tempfile
from collections import ChainMap
from collections.abc import Callable, Generator, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import golden
from running import FORTRAN_TESTS, LDBENCH, WINDOWS, Run, kept_tables

if TYPE_CHECKING:
    import ldbench
    from ldbench import ContactTable
    from ldbench_round.tasks import Task
    from specimen import World

# A shell makes what it starts in the background ignore Ctrl-C, and so would the programs that tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Executables for other systems have tests of their own, which are no part of other calls.
collect_ignore = [*(["program/test_arm64.py"] if "arm64" not in str(LDBENCH) else []),
                  *(["program/test_windows.py"] if not WINDOWS else [])]


def pytest_report_header() -> list[str]:
    """What this call leaves out."""
    return [] if "LDBENCH_SLOW" in os.environ else ["slow tests are left out: LDBENCH_SLOW=1 runs them"]


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave slow tests out, which take minutes each, unless they are asked for."""
    slow = [item for item in items if item.get_closest_marker("slow") and "LDBENCH_SLOW" not in os.environ]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in set(slow)]


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what this build does not run."""
    if item.get_closest_marker("same_build") and LDBENCH.name != "ldbench":
        pytest.skip("the executable is not the extension's build")


@pytest.fixture(scope="session", autouse=True)
def scratch(common: Path) -> None:
    """Whatever tests and their programs leave in the temporary folder goes with pytest's own."""
    folder = common/"t"         # short: the names of sockets below it may not be long
    folder.mkdir(exist_ok=True)
    os.environ["TMPDIR"] = str(folder)
    tempfile.tempdir = None     # asked for anew


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


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made and stay empty in files: tests of pictures draw them."""
    monkeypatch.setattr("matplotlib.figure.Figure.draw", lambda *_: None)
    monkeypatch.setattr("matplotlib.layout_engine.ConstrainedLayoutEngine.execute", lambda *_: None)


FEW = "error", "end", "t", "time", "Y", "N_LF", "event_time", "event_force"


@pytest.fixture
def few_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Datasets of ensembles have few results: a Zarr directory of all 110 takes a second to be written. Records have all."""
    from ldbench.ensembles import store, sweep

    whole = store.longest

    def few(records: Iterable[dict[str, object]]) -> dict[str, object]:
        return {name: value for name, value in whole(records).items() if name in FEW or name.startswith("peak_N_")}

    for module in store, sweep:
        monkeypatch.setattr(module, "longest", few)


@pytest.fixture(scope="session")
def common(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that all workers see."""
    own = tmp_path_factory.getbasetemp()
    return own.parent if "PYTEST_XDIST_WORKER" in os.environ else own


@functools.cache
def fine_hertz(pair: str) -> ContactTable:
    """The contact table of Hertz's law for a pair of profiles, as fingerprints have it."""
    from ldbench import Case, ContactTable  # programs that only start the executable need no package

    return ContactTable(Case.exercise(2, pair).replace(model="hertz", table_folder=kept_tables()))


@pytest.fixture(scope="session")
def read_hertz() -> Callable[[str], ContactTable]:
    """The contact tables of Hertz's law by the pair of profiles, each read once."""
    return fine_hertz


@pytest.fixture
def known_hertz(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fingerprints do not build the tables of Hertz's law."""
    monkeypatch.setattr("ldbench_round.fingerprint.hertz_table", fine_hertz)


@pytest.fixture(scope="session")
def shipped() -> Mapping[str, Run]:
    """The ten shipped inputs, run by the executable; exercise 5 with a steeper ramp, so that it ends after 2.6 s."""
    return golden.shipped_runs()


@pytest.fixture(scope="session")
def whole_ramps() -> Mapping[str, Run]:
    """Exercise 5 as it is shipped, 50 s: for slow tests alone."""
    return golden.whole_ramps()


@pytest.fixture(scope="session")
def ours() -> Mapping[Task, ldbench.Run]:
    """The shipped runs of exercises 1 to 4, read."""
    return golden.our_runs()


@pytest.fixture(scope="session")
def world() -> World:
    """A small project and its report."""
    from raw import Raw
    from specimen import World

    folder = golden.specimen()
    return World(folder, *(Raw(folder / name) for name in ("outputs/ex2_aw.txt", "outputs/ex5_aw.txt", "faster/ex3_aw.txt")))


@pytest.fixture
def own(ours: Mapping[Task, ldbench.Run], monkeypatch: pytest.MonkeyPatch) -> None:
    """Our own runs, by which maps are guessed, are the shipped ones, whatever a test of another file has put there."""
    from ldbench_round import own_runs

    monkeypatch.setattr(own_runs, "_OWN", ChainMap({}, ours))
