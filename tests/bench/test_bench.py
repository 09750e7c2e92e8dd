"""The short form of `make bench`: files that are complete, figures that are finite, whatever they are."""
import csv
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader

from programs import fortran_test, resources
from running import FORTRAN_TESTS, LongProgram

PEERS = (FORTRAN_TESTS/"peers").exists()
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
        # For a sweep it is a difference of wall times, which has no bound on a busy machine.
        assert low >= 0 or line["section"] == "ensemble", line


def test_the_look_up_is_compared_with_what_it_replaces(lines: Lines):
    """Time over time, each at least three times: how much it is, is the machine's."""
    rounds = {line["subject"]: int(line["rounds"]) for line in lines if line["quantity"] == "time over the look-up's"}
    assert {"direct", "half-space", "floor", "Python's own law"} <= set(rounds) and min(rounds.values()) >= 3


def test_evaluations_of_all_integrators_are_counted(lines: Lines):
    counts = {line["subject"].split(",")[0]: float(line["median"]) for line in lines if line["quantity"] == "force evaluations"}
    peers = {"CVODE Adams", "CVODE BDF", "ARKODE 5"} if PEERS else set()
    assert {"energy 4", "cut 4", "LSODA"} | peers <= set(counts) and min(counts.values()) > 100


def test_peers_or_what_is_missing(long_programs: dict[str, LongProgram], lines: Lines):
    """Compared with every output, or one line says where they are to be had."""
    _, said, _ = long_programs["test_bench"].finish()
    outputs = {line["quantity"].split(", ")[1] for line in lines if "best of SUNDIALS over ours" in line["quantity"]}
    assert outputs == ({"end alone", "events and states", "events and columns"} if PEERS else set())
    assert said.count("./bootstrap --sundials") == (not PEERS)


@pytest.mark.skipif(not PEERS, reason="no SUNDIALS: ./bootstrap --sundials")
def test_all_integrators_reach_one_end_and_find_the_same_events():
    """All integrators end exercise 2 alike, with two flange contacts, whatever output is given on the way."""
    peers = "adams", "adams newton", "bdf", "erk 4", "erk 5", "erk 6"
    ours = "energy_tolerance=1e-9", "energy_tolerance=0 dt=5e-6"
    outputs = "", "events=T", "events=T interval=1e-4", "events=T interval=1e-4 rows=T"
    jobs = [f"{how} {output}" for how in (*ours, *(f"method='{x}' tolerance=1e-11" for x in peers)) for output in outputs]
    said = fortran_test("peers", "inputs/ex2_aw.nml", stdin="\n".join(f"&job t_end=0.05 {job} /" for job in jobs) + "\n")
    numbers = np.array([line.split() for line in said.splitlines()], float)
    assert len(numbers) == len(jobs) and np.ptp(numbers[:, :3], axis=0).max() < 1e-8
    found = numbers[:, 7].reshape(-1, len(outputs))
    assert not found[:, 0].any() and len(set(found[:2, 1:].flat)) == 1 == len(set(found[2:, 1:].flat)) and found[0, 1] > 5


def test_pdf(folder: Path):
    pages = PdfReader(folder/"ldbench_bench.pdf").pages
    text = " ".join(page.extract_text() for page in pages)
    assert len(pages) >= 7 and "Work and precision" in text and "Cost of an evaluation" in text


def test_first_page_has_the_five_figures(folder: Path, lines: Lines):
    """Each as the CSV file has it."""
    text = " ".join(PdfReader(folder/"ldbench_bench.pdf").pages[0].extract_text().split())
    assert text.startswith("Five figures")
    medians = [float(line["median"]) for line in lines if any((
        line["case"] == "all cases", line["quantity"] == "peak memory",
        (line["section"], line["subject"], line["quantity"]) == ("evaluation", "force alone", "time of an evaluation"),
        line["section"] == "ensemble" and line["quantity"].startswith("times faster")))]
    assert len(medians) == 4 and all(f"{median:.3g}" in text for median in medians)
    compiled = [f"{float(line['median']):.3g}" for line in lines if "SUNDIALS over ours" in line["quantity"]]
    assert any(x in text for x in compiled) or not PEERS


def test_peak_memory_is_the_programs_own(tmp_path: Path):
    """Not that of what was run before, nor that of this process."""
    ballast = np.ones(20_000_000)           # 160 MB, touched

    def peak(megabytes: int) -> float:
        return resources([sys.executable, "-I", "-S", "-c", f"x = b'x' * {megabytes}_000_000"], tmp_path)[2]

    large, small = peak(100), peak(10)
    assert large - small == pytest.approx(90e6/2**20, rel=0.05) and small < 40 < ballast.nbytes/2**20
    with pytest.raises(RuntimeError, match="exit status 3, so it is"):
        resources(["sh", "-c", "echo so it is >&2; exit 3"], tmp_path)
