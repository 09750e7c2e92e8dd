"""The specimen of the tests of shown numbers, made once for all workers."""
from __future__ import annotations

from pathlib import Path

import pytest

from raw import Raw
from running import once
from specimen import World, make_specimen


@pytest.fixture(scope="session")
def world(common: Path) -> World:
    folder = common/"specimen"
    with once(folder) as first:
        if first:
            make_specimen(folder)
    return World(folder, *(Raw(folder/f"outputs/{name}.txt") for name in ("ex2_aw", "ex5_aw")))
