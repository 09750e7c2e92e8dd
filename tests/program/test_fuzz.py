"""Mutated inputs: see fuzz.py, and `make fuzz N=100000`."""
import pytest

from fuzz import fuzz
from running import FORTRAN_TESTS


@pytest.mark.same_build
@pytest.mark.skipif(not (FORTRAN_TESTS/"load_tables").exists(), reason="no load_tables: make test builds it")
def test_no_mutated_input_does_harm():
    """Namelists, profiles as Python and as the core read them, column files of other codes and ours, maps of columns and tables:
    30 of each; `make fuzz` takes as many as wanted."""
    assert fuzz(range(210)) == []
