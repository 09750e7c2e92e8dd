"""Mutated inputs: see fuzz.py, and `make fuzz N=100000`."""
import os

from conftest import same_build
from fuzz import fuzz


@same_build
def test_no_mutated_input_does_harm():
    """Two thousand, by their seeds: 333 each of namelists, profiles, column files of other codes and ours, maps of columns and
    tables."""
    assert fuzz(2000, 0, os.cpu_count() or 1) == []
