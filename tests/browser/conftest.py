"""Chromium and the pages that its tests share."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

import ldbench
from browser import Browser, started
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from ldbench.viewer import results
from running import CASES, Run, once


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The browser of this worker."""
    with started(tmp_path_factory.mktemp("chromium")) as browser:
        yield browser


@pytest.fixture
def browser(chromium: Browser) -> Browser:
    """The browser with the window of a desk; a test opens a page of its own in it."""
    chromium.driver.switch_to.default_content()
    chromium.size(1366, 860)
    return chromium


def shared_page(folder: Path, write: Callable[[Path], object]) -> Path:
    """A page that is written once for all workers."""
    with once(folder) as first:
        if first:
            write(folder/"page.html")
    return folder/"page.html"


@pytest.fixture(scope="session")
def page_of(shipped: dict[str, Run], common: Path) -> Callable[[str], Path]:
    """The page of a shipped case."""
    return lambda case: shared_page(common/f"page_{case}", lambda file: ldbench.view(shipped[case].file).write(file))


@pytest.fixture(scope="session")
def one(page_of: Callable[[str], Path]) -> Path:
    """The page of exercise 1."""
    return page_of("ex1_aw")


@pytest.fixture(scope="session")
def ex5(page_of: Callable[[str], Path]) -> Path:
    """The page of the longest run."""
    return page_of("ex5_aw")


@pytest.fixture(scope="session")
def two(shipped: dict[str, Run], common: Path) -> Path:
    """The page that the command makes of two runs."""
    def write(file: Path) -> None:
        assert main(["view", *(str(shipped[case].file) for case in ("ex2_aw", "ex2_sw")), "-o", str(file)]) == 0

    return shared_page(common/"page_two", write)


@pytest.fixture(scope="session")
def all_runs(shipped: dict[str, Run], common: Path) -> Path:
    """The page of the report."""
    return shared_page(common/"page_all",
                       lambda file: results.results_page([read_data(shipped[case].file) for case in CASES]).write(file))
