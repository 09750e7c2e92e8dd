"""The ten runs against their stored references, and that the comparison can fail."""

import pytest

import reference
from reference import compare
from running import CASES


RAMPS = [case for case in CASES if case.startswith("ex5")]


@pytest.mark.parametrize("case", [case if case not in RAMPS else pytest.param(case, marks=pytest.mark.slow) for case in CASES])
def test_run_is_the_stored_one(case, shipped, whole_ramps):
    run = whole_ramps[case] if case in RAMPS else shipped[case]
    moved = [move for move in compare(reference.read(case), run) if move.share > 1]
    assert not moved, "\n".join(f"{case}: {move}" for move in moved)
