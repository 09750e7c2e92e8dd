"""Chromium and the pages that its tests share."""
from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

import ldbench
from browser import Browser, started
from running import Run, once
from specimen import World


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


@pytest.fixture
def report(world: World) -> Path:
    """The page of all runs of the specimen, which shows the thrown wheelset first."""
    return world.outputs/"ldbench_results.html"


def written(folder: Path, *files: Path) -> Path:
    """The page of runs, written once for all workers."""
    with once(folder) as first:
        if first:
            ldbench.view(*files).write(folder/"page.html")
    return folder/"page.html"


@pytest.fixture(scope="session")
def ex5(chromium: Browser, whole_ramps: Mapping[str, Run], common: Path) -> Path:
    """The page of the longest run."""
    return written(common/"page_ex5", whole_ramps["ex5_aw"].file)


@pytest.fixture(scope="session")
def two(chromium: Browser, world: World, common: Path) -> Path:
    """The page of the thrown wheelset and the faster one."""
    return written(common/"page_two", world.thrown.file, world.faster.file)
