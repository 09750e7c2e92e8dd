"""The short form of `make validate`: every section, every line inside its bar, a CSV and a PDF that are complete."""
import csv
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader

from running import LongProgram

SECTIONS = "halfspace", "models", "linear", "conicity", "parameters", "quasistatic", "derailment", "rigid", "integration", \
    "sensitivity", "unknown", "measured", "stiffness", "manchester"


@pytest.fixture(scope="module")
def folder(long_programs: dict[str, LongProgram]) -> Path:
    program = long_programs["test_validation"]
    _, _, errors = program.finish()
    assert not errors, errors
    return program.folder


@pytest.fixture(scope="module")
def lines(folder: Path) -> list[dict[str, str]]:
    with (folder/"validation.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("section", SECTIONS)
def test_every_line_is_inside_its_bar(section: str, lines: list[dict[str, str]]):
    mine = [line for line in lines if line["section"] == section]
    assert mine
    assert not [line for line in mine if line["verdict"] != "inside" or not float(line["deviation"]) <= float(line["bar"])]
    assert all(np.isfinite(float(line[name])) for line in mine for name in ("value", "reference"))


def test_status_says_the_same(long_programs: dict[str, LongProgram], lines: list[dict[str, str]]):
    status, _, _ = long_programs["test_validation"].finish()
    assert status == any(line["verdict"] != "inside" for line in lines)


def test_pdf(folder: Path):
    """All sections have their bookmarks; all checks stand in the overview."""
    pdf = PdfReader(folder/"ldbench_validation.pdf")
    chapters = [item.title for item in pdf.outline if not isinstance(item, list)]
    assert len(chapters) == 1 + len(SECTIONS)
    text = " ".join(page.extract_text() for page in pdf.pages)
    assert "OUTSIDE" not in text
    assert all(section in text for section in SECTIONS)
    assert text.count("inside") >= sum(1 for _ in (folder/"validation.csv").open()) - 1
