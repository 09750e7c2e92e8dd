"""The stored cases against their stored references."""
from __future__ import annotations

import pytest

import golden
import reference
from reference import STEEP, STORED, UNLIKE, compare
from running import Run


def run_of(name: str) -> Run:
    """The run of a stored case, from the golden world."""
    if name == UNLIKE:
        return golden.unlike_run()
    return golden.shipped_runs()[STEEP[name]] if name in STEEP else (
        golden.whole_ramps() if name.startswith("ex5") else golden.shipped_runs())[name]


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.slow) if name in STEEP.values() else name for name in STORED])
def test_run_is_the_stored_one(name: str):
    """Rows, and every result of the header."""
    moved = [move for move in compare(reference.read(name), run_of(name)) if move.share > 1]
    assert not moved, "\n".join(f"{name}: {move}" for move in moved)
