"""The ten runs against their stored references, and that the comparison can fail."""

import numpy as np
import pytest

import reference
from reference import Reference, compare
from running import CASES


@pytest.mark.parametrize("case", CASES)
def test_run_is_the_stored_one(case, shipped):
    moved = [move for move in compare(reference.read(case), shipped[case]) if move.share > 1]
    assert not moved, "\n".join(f"{case}: {move}" for move in moved)


# ---- what is stored ------------------------------------------------------------------


@pytest.mark.parametrize("case", CASES)
def test_references_say_something(case):
    """Exercises 1 to 4 are compared to their end; 5 through the first flange contacts, then at derailment."""
    stored = reference.read(case)
    compared = np.mean([np.isfinite(tolerance).mean() for tolerance in stored.tolerances.values()])
    facts = {what: tolerance for what, (_, tolerance) in stored.facts.items() if np.isfinite(tolerance)}
    assert len(stored.columns["time"]) == reference.ROWS
    if case.startswith("ex5"):
        assert stored.columns["time"][-1] > 0.6 and compared > 0.6
        assert facts["left flange contact 3 [s]"] < 0.01 and facts["lateral force at derailment [kN]"] < 15
    else:
        assert stored.columns["time"][-1] == stored.facts["end [s]"][0] and compared > 0.95
        assert len(facts) >= 0.9 * len(stored.facts)
    for name in "Y", "vY", "roll", "E_total":
        first = stored.tolerances[name][1]
        assert first <= 1e-3 * np.abs(stored.columns[name]).max()


# ---- what the comparison finds -------------------------------------------------------
@pytest.fixture
def stored() -> Reference:
    return reference.read("ex2_aw")
