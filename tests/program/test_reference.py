"""The ten runs against their stored references, and that the comparison can fail."""

import pytest

import reference
from reference import compare
from running import CASES


@pytest.mark.parametrize("case", CASES)
def test_run_is_the_stored_one(case, shipped):
    moved = [move for move in compare(reference.read(case), shipped[case]) if move.share > 1]
    assert not moved, "\n".join(f"{case}: {move}" for move in moved)
