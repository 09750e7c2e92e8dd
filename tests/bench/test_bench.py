"""The short form of `make bench`: files that are complete, finite ratios, an order that no machine turns round."""
import csv
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest
from pypdf import PdfReader

from conftest import FORTRAN_TESTS, LDBENCH, REPO

Lines = list[dict[str, str]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bench")
    done = subprocess.run([sys.executable, REPO/"tests/bench", "--short", "--out", folder], cwd=REPO, text=True,
                          env={**os.environ, "LDBENCH": str(LDBENCH), "LDBENCH_TESTS": str(FORTRAN_TESTS)},
                          capture_output=True)
    assert done.returncode == 0 and not done.stderr, done.stderr
    return folder


@pytest.fixture(scope="module")
def lines(folder: Path) -> Lines:
    with (folder/"bench.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def median(lines: Lines, subject: str, quantity: str) -> float:
    found, = (float(line["median"]) for line in lines if (line["subject"], line["quantity"]) == (subject, quantity))
    return found


def test_every_figure_is_finite(lines: Lines):
    assert {line["section"] for line in lines} == {"precision", "steps", "evaluation", "cases", "ensemble"}
    for line in lines:
        low, middle, high = (float(line[name]) for name in ("lower quartile", "median", "upper quartile"))
        assert 0 <= low <= middle <= high < math.inf, line


def test_look_up_is_cheaper_than_direct_evaluation(lines: Lines):
    """By factors of thousands on a quiet machine."""
    assert median(lines, "direct", "time over the look-up's") > 10
    assert median(lines, "half-space", "time over the look-up's") > 10


def test_evaluations_of_all_integrators_are_counted(lines: Lines):
    counts = {line["subject"].split(",")[0]: float(line["median"]) for line in lines
              if line["quantity"] == "force evaluations"}
    assert {"energy 4", "cut 4", "LSODA", "CVODE Adams"} <= set(counts) and min(counts.values()) > 100


def test_pdf(folder: Path):
    pages = PdfReader(folder/"ldbench_bench.pdf").pages
    text = " ".join(page.extract_text() for page in pages)
    assert len(pages) >= 6 and "Work and precision" in text and "Cost of an evaluation" in text
