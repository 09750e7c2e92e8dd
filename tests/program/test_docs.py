"""The pages of the documentation say what the program does."""
import re
import subprocess
import sys
from pathlib import Path

import pytest

import documents
import ldbench
from running import CASES, REPO, environment, once

RUN = [page for page in documents.PAGES if documents.blocks(page)]


def name(page: Path) -> str:
    return str(page.relative_to(REPO))


@pytest.fixture(scope="session")
def prepared(common):
    with once(common/"documents") as first:
        if first:
            documents.prepare(common/"documents")
    return common/"documents"


@pytest.mark.parametrize("page", RUN, ids=name)
def test_commands_print_what_the_page_shows(page, prepared, tmp_path):
    for shown in documents.run_page(page, prepared, tmp_path/"page"):
        assert shown.status == 0, f"{shown.command}\n{shown.found}"
        assert shown.fits, f"{shown.command}\nshown:\n{shown.expected}\nprinted:\n{shown.found}"


@pytest.mark.parametrize("page", documents.PAGES, ids=name)
def test_links_lead_to_files(page):
    for link in documents.links(page):
        file = (page.parent/link.partition("#")[0]).resolve()
        assert file.exists() and file.is_relative_to(REPO), link


def test_tables_of_variables_and_columns_are_those_of_the_program():
    done = subprocess.run([sys.executable, REPO/"docs/make_tables.py", "--check"], env=environment(), capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr


def test_numbers_of_the_readme_are_those_of_the_runs(shipped):
    """The energy's error is at most what the README says, and the peak in its picture that of the run."""
    text = " ".join((REPO/"README.md").read_text().split())
    runs = [ldbench.read_run(shipped[case].file) for case in CASES if "ex5" not in case]
    error, share = map(float, re.search(r"largest energy error is (\S+) J, at most (\S+) of", text).groups())
    assert max(run.result("drift") for run in runs) == pytest.approx(error, rel=0.2)
    assert max(run.result("drift")/run.result("kinetic_energy") for run in runs) == pytest.approx(share, rel=0.2)
    peak = ldbench.read_run(shipped["ex2_aw"].file).peak("LF")
    assert float(re.search(r"left flange carries (\d+) kN", text)[1]) == pytest.approx(1e-3*peak[0], rel=2e-3)


@pytest.mark.parametrize(("expected", "found", "same"), [
    ("t = 0.102304 s\n", "t = 0.102305 s\n", True),
    ("t = 0.102304 s", "t = 0.112304 s", False),
    ("drift 5.88E-09 J", "drift 9.1E-09 J", True),
    ("a\n...\nc 1", "a\nb 2\nb 3\nc 1", True),
    ("a\n...\nc 1", "a\nb 2\nb 3\nc 2", False),
    ("seconds: ... rows", "seconds: 0.01 (found) rows", True),
    ("one word", "one  word", True),
    ("one word", "two words", False),
])
def test_words_are_compared_exactly_and_numbers_nearly(expected, found, same):
    assert documents.alike(expected, found) is same
