"""Chromium and the pages that its tests share."""
from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from browser import Browser, started
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from ldbench.viewer import results
from running import CASES, Run


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    with started(tmp_path_factory.mktemp("chromium")) as browser:
        browser.size(1366, 860)
        yield browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def one(shipped: dict[str, Run], folder: Path) -> Path:
    """The page of exercise 1."""
    assert main(["view", str(shipped["ex1_aw"].file), "-o", str(folder/"one.html")]) == 0
    return folder/"one.html"


@pytest.fixture(scope="module")
def two(shipped: dict[str, Run], folder: Path) -> Path:
    """Two runs in one page."""
    files = [str(shipped[case].file) for case in ("ex2_aw", "ex2_sw")]
    assert main(["view", *files, "-o", str(folder/"two.html")]) == 0
    return folder/"two.html"


@pytest.fixture(scope="module")
def all_runs(shipped: dict[str, Run], folder: Path) -> Path:
    """The page of the report."""
    runs = [read_data(shipped[case].file) for case in CASES]
    return results.results_page(runs).write(folder/"all.html")
