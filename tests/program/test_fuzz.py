"""Mutated inputs: see fuzz.py, and `make fuzz N=100000`."""
import pytest

from fuzz import fuzz, in_a_child_of_threads


@pytest.mark.same_build
def test_no_mutated_input_does_harm():
    """The inputs of 390 seeds are 65 each of namelists, profiles, column files of other codes and ours, maps of columns and
    tables; `make fuzz` takes as many as wanted."""
    assert fuzz(390, 0, 1) == []


def test_threads_at_the_same_moment_do_what_one_does_alone():
    """Six cases, four of them mutated, are read, run and written by four threads each, which write one more file together;
    `make fuzz` takes eighty-four."""
    assert in_a_child_of_threads(range(6)) == ""
