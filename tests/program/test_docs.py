"""The pages of the documentation say what the program does."""
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

import documents
import ldbench
import make_tables
from ldbench.bodies.influence import WAVES
from ldbench.commands import COMMANDS
from ldbench.conicity import FINE_PITCH
from measure import of_runs
from running import CASES, HANG, REPO, once

RUN = [page for page in documents.PAGES if documents.blocks(page)]
RAMPS = [case for case in CASES if case.startswith("ex5")]
# What takes less time, and prints what the page shows all the same: other words of commands by those that the pages have.
SHORTER = {"--set name=ex2_s1002_bodies": "--set name=ex2_s1002_bodies --set t_end=2e-3"}


def name(page: Path) -> str:
    return str(page.relative_to(REPO))


@pytest.fixture(scope="session")
def prepared(common):
    folder = common/"documents"
    with once(folder) as first:
        if first:
            documents.prepare(folder)
    return folder


@pytest.mark.parametrize("page", RUN, ids=name)
def test_commands_print_what_the_page_shows(page, prepared, tmp_path, undrawn, monkeypatch):
    # What pages show of conicity and of bodies needs neither the finest pitch nor all waves, by which most of the time goes.
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", 4*FINE_PITCH)
    monkeypatch.setattr("ldbench.bodies.influence.WAVES", WAVES[::6])
    for shown in documents.run_page(page, prepared, tmp_path/"page", SHORTER):
        assert shown.status == 0, f"{shown.command}\n{shown.found}"
        assert shown.fits, f"{shown.command}\nshown:\n{shown.expected}\nprinted:\n{shown.found}"


def test_links_lead_to_files_and_commands_are_those_of_the_program():
    for page in documents.PAGES:
        for link in documents.links(page):
            file = (page.parent/link.partition("#")[0]).resolve()
            assert file.exists() and file.is_relative_to(REPO), f"{page}: {link}"
        assert set(re.findall(r"python -m ldbench ([a-z]\w*)", page.read_text())) <= COMMANDS.keys(), page


def test_tables_are_those_of_the_program(capsys):
    assert make_tables.main(["--check"]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["exercises 1 to 4", "whole ramps"])
def test_measured_results_of_the_runs_are_those_of_the_program(whole, shipped, whole_ramps):
    """Drifts are sums of rounding errors and truncation errors: another processor has others. A chaotic answer is one of a range;
    on another processor the run is one more sample, which is outside of the range of nine by no more than its width."""
    measured = json.loads((REPO/"docs/measured.json").read_text())
    found = of_runs([ldbench.read_run((whole_ramps if whole and case in RAMPS else shipped)[case].file) for case in CASES], {})
    known, ranges = measured["report"]["values"], 0
    for name, value in found.items():
        if not whole and re.search(r"ex5|ramp|F_derailment", name):
            continue
        if name in known:
            loose = 0.3 if name.startswith("drift") and "reference" not in name else 0.01
            assert value == pytest.approx(known[name], rel=loose), f"{name}: run make report and docs/measure.py report"
        else:
            key, _, unit = name.partition(" ")
            least, median, largest = (known[f"{key}.{end} {unit}"] for end in ("least", "median", "largest"))
            assert least < median < largest and 2*least - largest <= value <= 2*largest - least, name
            ranges += 1
    assert ranges >= (2 if whole else 1) and {f"F_derailment.{pair}.median [kN]" for pair in ("aw", "sw")} <= known.keys()


# A number with a unit, or with a power of ten.
UNIT = re.compile(r"""(?<![\w.,/:^-])\d[\d.,]*(?:
    (?:e-?\d+)?[ \u00a0-]?(?:
        [GMk]?N | [GMkh]?Pa | [mµunckd]?m | [mµun]?s | m?rad | [Mk]?J | [mkµ]?g | [kM]?Hz | [kMG]?B | [°%] | percent | h | min
        | \w*(?:metres?|newtons?|pascals?|minutes?|hours?|days?|bytes|degrees?|radians?|joules?|grams?|hertz|seconds?)
        | lines | rows | points | runs | times)(?!\w)
    | e-?\d+(?!\w))""", re.VERBOSE)
# A decimal number that fills a cell of a table, whose unit stands in the heading.
CELL = re.compile(r"(?<=\|) *[-−+]?\d+\.\d+(?:e-?\d+)? *(?=\|)")
# Tables that make_tables.py makes, code, mathematics, comments, and addresses of links.
MADE = re.compile(r"^<!-- table: .*?^<!-- end of table -->$|<!--.*?-->|^```.*?^```$|^ {4}.*?$|``.*?``|`[^`\n]*`|\$\$.*?\$\$"
                  r"|\$(?:[^$\n]|\n(?!\n))*\$|\]\(<?[^)\s]*>?\)", re.DOTALL | re.MULTILINE)


def numbers_in_sentences(text: str) -> list[str]:
    """Numbers with a unit, outside of what is made by the program and of what a user types."""
    words = MADE.sub(" ` ", text)
    return [found[0].strip() for pattern in (UNIT, CELL) for found in pattern.finditer(words)]


def words_of(page: Path) -> str:
    """The text of a page; of a notebook its words."""
    if page.suffix == ".md":
        return page.read_text()
    return "\n\n".join("".join(cell["source"]) for cell in json.loads(page.read_text())["cells"] if cell["cell_type"] == "markdown")


def test_no_sentence_has_a_number_with_a_unit():
    """Results and constants stand in tables that the program makes, so that none ages unseen."""
    pages = [REPO/"README.md", REPO/"CHANGELOG.md", *sorted((REPO/"docs").glob("*.md")), *sorted((REPO/"docs").glob("*.ipynb"))]
    assert len(pages) > 15
    assert {page: found for page in pages if (found := numbers_in_sentences(words_of(page)))} == {}


UNITS = ("kN N MN GPa MPa Pa mm um µm m ms us µs s degrees mrad rad J kg Hz % kB MB GB lines rows minutes times micrometres m/s "
         "kN/s N·s").split()
SENTENCES = [*(f"The first peak is about {number} {unit}, which is large."
               for unit in UNITS for number in ("3", "0.1", "1,500", "2e-9", "10 to 15", "−3.5", "3.8 to 16.3")),
             "it turns by 33.4° within a patch", "a drift of 4.6e-10 of the energy", "| aw | 273.31 |"]
PLAIN = ("EN 15302, section 5.3, Python 3.10, exercise 2 and 1:40 cones", "type `dt = 5e-6` or `--at 0.02 s`",
         "$5\\,\\mathrm{mm}$ of it, K. L. Johnson 1985, section 4.2", "Exercises 1 to 4 stop; 2 start")


def test_what_counts_as_a_number_with_a_unit():
    assert [text for text in SENTENCES if not numbers_in_sentences(text)] == []
    assert [text for text in PLAIN if numbers_in_sentences(text)] == []


# All set-up of a stranger: what runs exercise 1, and what passes the tests.
SETUP = "./bootstrap && make && ./ldbench < inputs/ex1_aw.nml", "./bootstrap && make test"


def test_two_commands_of_the_readme_do_all_the_setup_and_are_what_ci_runs():
    blocks = re.findall(r"\n\n {4}(.*)\n\n", (REPO/"README.md").read_text())
    assert [block for block in blocks if block.startswith("./bootstrap")] == list(SETUP)
    calls = [line for line in (REPO/".ci/run").read_text().splitlines() if line.startswith("./bootstrap ")]
    assert [call for call in calls if call != "./bootstrap --browser"] == [f"{one} || exit" for one in SETUP]


def test_a_failing_setup_ends_ci(tmp_path):
    """A copy of the script, with commands that fail in place of the real ones, ends with their status."""
    (tmp_path/".ci").mkdir()
    shutil.copy(REPO/".ci/run", tmp_path/".ci/run")
    for name, status in ("bootstrap", 1), ("make", 0):
        (tmp_path/name).write_text(f"#!/bin/sh\necho {name} $* >> \"$0.log\"\nexit {status}\n")
        (tmp_path/name).chmod(0o755)
    done = subprocess.run([tmp_path/".ci/run"], env={"PATH": f"{tmp_path}:/usr/bin:/bin"}, capture_output=True, timeout=HANG)
    assert done.returncode == 1 and (tmp_path/"bootstrap.log").read_text() == "bootstrap\n" and not (tmp_path/"make.log").exists()
