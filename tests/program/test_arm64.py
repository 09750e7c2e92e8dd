"""The executable for another processor, emulated: `make test-arm64`.

Half-space solutions end where their residual is small enough, so that last digits differ by what that leaves open; runs
make more of it with every impact. What may not differ: the points of the tables, first contacts, and how runs end."""
import re
import subprocess
from pathlib import Path

import pytest

import reference
from running import LDBENCH, PAIRS, REPO, Run, read_interval

pytestmark = pytest.mark.skipif("arm64" not in str(LDBENCH), reason="only by make test-arm64")


@pytest.mark.parametrize("pair", PAIRS)
def test_tables_have_the_same_points(pair: str, shipped: dict[str, Run], tmp_path: Path):
    """Where an axis is halved does not depend on last digits; the stated errors are the same to a twentieth."""
    (tmp_path/"inputs").mkdir()
    (tmp_path/"outputs").mkdir()
    (tmp_path/"profiles").symlink_to(REPO/"profiles")
    here = subprocess.run([REPO/"ldbench"], input=(REPO/f"inputs/ex1_{pair}.nml").read_text(), cwd=tmp_path, capture_output=True,
                          text=True, check=True).stdout
    said = shipped[f"ex1_{pair}"].summary
    points = r"^contact table: .*$"
    assert re.findall(points, said, re.M) == re.findall(points, here, re.M) != []
    stated = r"^its error, .*$"
    there, own = ([float(x) for x in re.findall(r"\d\.\d+E-\d+", re.search(stated, text, re.M)[0])] for text in (said, here))
    assert len(there) == 8 and there == pytest.approx(own, rel=0.05)


@pytest.mark.parametrize("case", [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4) for pair in PAIRS])
def test_runs_tell_the_same(case: str, shipped: dict[str, Run]):
    """First contacts to 1 us, ends to a row, the peaks of exercises 1 to 3, some after ten impacts, to 1e-3, energy to the bar."""
    run, stored = shipped[case], reference.read(case)
    found = reference.read_facts(run.header)
    for what in "left flange contact 1, t [s]", "right flange contact 1, t [s]":
        if case in ("ex4_aw", "ex4_sw") and what.startswith("right"):
            continue
        assert found[what] == pytest.approx(stored.facts[what][0], abs=2e-6 if what.startswith("left") else 2e-5)
    assert found["t [s]"] == pytest.approx(stored.facts["t [s]"][0], abs=1.01*read_interval(run.header))
    assert reference.read_words(run.header)["end"] == stored.words["end"]
    if case[2] != "4":
        for contact in "LT", "LF", "RT", "RF":
            assert found[f"peak_N_{contact} [N]"] == pytest.approx(stored.facts[f"peak_N_{contact} [N]"][0], rel=1e-3)
    c = run.columns
    assert abs(c["E_drift"]).max() < 1e-9*(c["KE_lat"] + c["KE_vert"] + c["KE_roll"])[0]
