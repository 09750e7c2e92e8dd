"""The short form of `make bench`: files that are complete, figures that are finite, whatever they are."""
import csv
import math
from pathlib import Path

import pytest
from pypdf import PdfReader

from conftest import LongProgram

Lines = list[dict[str, str]]


@pytest.fixture(scope="module")
def folder(long_programs: dict[str, LongProgram]) -> Path:
    program = long_programs["test_bench"]
    status, _, errors = program.finish()
    assert status == 0 and not errors, errors
    return program.folder


@pytest.fixture(scope="module")
def lines(folder: Path) -> Lines:
    with (folder/"bench.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_every_figure_is_finite(lines: Lines):
    assert {line["section"] for line in lines} == {"precision", "steps", "evaluation", "cases", "ensemble"}
    for line in lines:
        low, middle, high = (float(line[name]) for name in ("lower quartile", "median", "upper quartile"))
        assert -math.inf < low <= middle <= high < math.inf, line
        # Of a sweep it is a difference of wall times: no bound on a busy machine.
        assert low >= 0 or line["section"] == "ensemble", line


def test_the_look_up_is_compared_with_what_it_replaces(lines: Lines):
    """Time over time, each at least three times: how much it is, is the machine's."""
    rounds = {line["subject"]: int(line["rounds"]) for line in lines if line["quantity"] == "time over the look-up's"}
    assert {"direct", "half-space", "floor", "Python's own law"} <= set(rounds) and min(rounds.values()) >= 3


def test_evaluations_of_all_integrators_are_counted(lines: Lines):
    counts = {line["subject"].split(",")[0]: float(line["median"]) for line in lines
              if line["quantity"] == "force evaluations"}
    assert {"energy 4", "cut 4", "LSODA", "CVODE Adams"} <= set(counts) and min(counts.values()) > 100


def test_pdf(folder: Path):
    pages = PdfReader(folder/"ldbench_bench.pdf").pages
    text = " ".join(page.extract_text() for page in pages)
    assert len(pages) >= 6 and "Work and precision" in text and "Cost of an evaluation" in text
