"""Mutated inputs: see fuzz.py, and `make fuzz N=100000`."""
import os

import pytest

from fuzz import fuzz, in_a_child_of_threads


@pytest.mark.same_build
def test_no_mutated_input_does_harm():
    """Eight hundred, by their seeds: 133 each of namelists, profiles, column files of other codes and ours, maps of columns and
    tables."""
    assert fuzz(800, 0, os.cpu_count() or 1) == []


def test_threads_at_the_same_moment_do_what_one_does_alone():
    """Twenty-four mutated cases are read, run and written by four threads each, which write one more file together."""
    assert in_a_child_of_threads(range(24)) == ""
