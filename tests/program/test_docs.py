"""The pages of the documentation say what the program does."""
import json
import re
import shutil
from pathlib import Path

import pytest

import documents
import ldbench
import make_tables
from measure import of_runs
from probes import table_file
from running import CASES, REPO, keep, kept_tables, once

RUN = [page for page in documents.PAGES if documents.blocks(page)]


def name(page: Path) -> str:
    return str(page.relative_to(REPO))


@pytest.fixture(scope="session")
def prepared(common, shipped, hertz_tables):
    folder = common/"documents"
    with once(folder) as first:
        if first:
            documents.prepare(folder, table_file(shipped, "aw"))
            shutil.copy(hertz_tables["aw"], folder/"aw_hertz.table")
    return folder


@pytest.mark.parametrize("page", RUN, ids=name)
def test_commands_print_what_the_page_shows(page, prepared, tmp_path, undrawn):
    """The contact table of S1002 on 60E1 is kept for the next time."""
    there, kept = tmp_path/"page/outputs/s1002.table", kept_tables()/"s1002_hertz.table"
    there.parent.mkdir(parents=True)
    if kept.exists():
        shutil.copy(kept, there)
    for shown in documents.run_page(page, prepared, tmp_path/"page"):
        assert shown.status == 0, f"{shown.command}\n{shown.found}"
        assert shown.fits, f"{shown.command}\nshown:\n{shown.expected}\nprinted:\n{shown.found}"
    if there.exists():
        keep(there, kept)


def test_links_lead_to_files():
    for page in documents.PAGES:
        for link in documents.links(page):
            file = (page.parent/link.partition("#")[0]).resolve()
            assert file.exists() and file.is_relative_to(REPO), f"{page}: {link}"


def test_tables_and_quoted_numbers_are_those_of_the_program(capsys):
    assert make_tables.main(["--check"]) == 0, capsys.readouterr().err


@pytest.fixture(scope="module")
def measured() -> dict[str, dict[str, float]]:
    """The measured results by group and name."""
    return {name: group["values"] for name, group in json.loads((REPO/"docs/measured.json").read_text()).items()}


def test_measured_results_of_the_runs_are_those_of_the_program(shipped, measured):
    """Drifts are sums of rounding errors and truncation errors, and exercise 5 is chaotic: another processor has others."""
    found = of_runs([ldbench.read_run(shipped[case].file) for case in CASES])
    assert found
    for name, value in found.items():
        loose = 0.3 if name.startswith("drift") and "reference" not in name else 0.015 if name.startswith("F_") else 0.01
        assert value == pytest.approx(measured["report"][name], rel=loose), f"{name}: run make report and docs/measure.py report"


def test_measured_results_of_the_validation_are_of_the_same_contact_tables(measured):
    """The contact law has not changed between `make report` and `make validate`. The validation prints two digits."""
    shared = measured["report"].keys() & measured["validate"].keys()
    assert len(shared) == 16        # rms and largest errors of two tables in four places
    for name in shared:
        assert measured["report"][name] == pytest.approx(measured["validate"][name], rel=0.06), name


UNIT = re.compile(r"(?<![\w.#,^])\d[\d.,]*(?:e-?\d+)?(?: (?:kN|MN|J|kJ|Hz|ms|s|MB|mm|µm|µs|nm|m/s|times|%)(?!\w))")
# Numbers of docs/accuracy.md that are not measured: the input, definitions, and rounded statements of what is expected.
STATED = {"0.1 %", "3 kN", "2 µs", "10 µm", "1 nm", "5 kN",
          # Estimates of what half-spaces leave out.
          "4 MN", "133 mm", "5 %", "15 %",
          # EN 15302 states these.
          "3 mm", "2 µm",
          # The clearances of the APTA wheels.
          "10.40 mm", "10.76 mm",
          # Tests of pictures compare these of README and index; the input, definitions and examples state these of other pages.
          "21.9 ms", "816 kN", "1 µm", "1.6 times"}


@pytest.mark.parametrize(("page", "least"), [
    ("README.md", 15), ("docs/accuracy.md", 23), ("docs/compare.md", 10), ("docs/install.md", 0), ("docs/index.md", 0),
    ("docs/output.md", 0), ("docs/ensembles.md", 0)])
def test_every_measured_number_is_quoted(page: str, least: int):
    """A number with a unit is a quotation of docs/measured.json, stands in a table made from it, or is known as stated."""
    text = (REPO/page).read_text()
    text = re.sub(r"<!-- table:.*?<!-- end of table -->", "", text, flags=re.DOTALL)
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", text, flags=re.DOTALL | re.MULTILINE)
    text, quotations = re.subn(r"[\d.e-]+<!-- [^<>]+? -->", "#", text)
    assert quotations >= least
    assert {found[0] for found in UNIT.finditer(text)} <= STATED
