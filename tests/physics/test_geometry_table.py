"""Measures, clearance and conicity of many pairs, level and rolled, beside those of numpy from the raw points."""
from pathlib import Path

import pytest

from geometry_table import PAIRS, numbers, outside

QUICK = (("S1002", "1:40"), ("cone 1:20", "upright"), ("EN A", "1:20"), ("S1002, noise 3 um", "1:40"),
         ("S1002, waves 10 um", "upright"))


@pytest.mark.parametrize(("wheel", "lean"), [pytest.param(*one, marks=() if one in QUICK else pytest.mark.slow) for one in PAIRS])
def test_numbers_are_those_of_the_points(wheel: str, lean: str, tmp_path: Path):
    ours, theirs, _ = numbers(wheel, lean, tmp_path)
    assert outside(ours, theirs) == []
