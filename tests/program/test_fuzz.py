"""Mutated inputs: see fuzz.py, and `make fuzz N=100000`."""
import pytest

from fuzz import fuzz
from running import FORTRAN_TESTS


@pytest.mark.same_build
@pytest.mark.skipif(not (FORTRAN_TESTS/"load_tables").exists(), reason="no load_tables: make test builds it")
def test_no_mutated_input_does_harm():
    """The inputs of 390 seeds are 65 each of namelists, profiles, column files of other codes and ours, maps of columns and
    tables; `make fuzz` takes as many as wanted."""
    assert fuzz(390, 0, 1) == []
