"""compare: known shifts, offsets and other codes' files come out as what they are."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

import ldbench
from invented import invented_run
from ldbench import Case, Event
from ldbench.__main__ import main
from ldbench.report import differences as cmp
from ldbench.report.study import SHORT_RAMP, study_jobs
from ldbench.results.header import Comments
from ldbench.results.run_data import RunData
from running import kept_tables

SPEED = 0.5        # of the invented wheelset [m/s]
TOUCH = 0.02       # when its flange touches [s]


def invented(delay: float = 0.0, offset: float = 0.0, dt: float = 1e-4, name: str = "mine") -> RunData:
    """Steady motion to the left; a half-sine of flange force 4 ms long; all of it `delay` later."""
    t = dt*np.arange(round(0.05/dt) + 1)
    since = t - TOUCH - delay
    closed = (since > 1e-9) & (since < 0.004 - 1e-9)
    columns = pd.DataFrame({"time": t, "Y": SPEED*(t - delay) + offset, "angle_LF": np.where(closed, 1.0, np.nan),
                            "N_LF": np.where(closed, 8e5*np.sin(np.pi*np.clip(since, 0, 0.004)/0.004), 0.0)})
    events = Event(TOUCH + delay, "left flange contact"), Event(TOUCH + delay + 0.01, "centre passage")
    comments = Comments(results={"t_first_LF": TOUCH + delay}, events=events, ending="t_end")
    return invented_run(columns, f"{name}.txt", comments=comments)


def test_known_shift_is_found_and_taken_out():
    runs = [invented(), invented(delay=0.003, name="late")]
    rms = cmp.difference_table(cmp.compare(runs)).set_index("quantity")["rms"]
    assert rms["Y"] == pytest.approx(SPEED*0.003, rel=1e-12) and rms["N_LF"] > 1e5
    aligned = cmp.compare(runs, align="first-flange")
    assert aligned.shifts[1] - aligned.shifts[0] == pytest.approx(0.003, abs=1e-15)
    rms = cmp.difference_table(aligned).set_index("quantity")["rms"]
    assert rms["Y"] < 1e-15 and rms["N_LF"] < 1e-6
    events = cmp.event_table(runs).set_index("quantity")["difference"]
    known = events[["first left flange contact", "first centre passage", "end"]]
    assert known.tolist() == pytest.approx([0.003, 0.003, 0], abs=1e-15)


def test_runs_of_one_case_have_names_of_their_own():
    runs = [invented(offset=offset) for offset in (0, 1e-3, 2e-3)]
    table = cmp.difference_table(cmp.compare(runs)).set_index(["file", "quantity"])
    assert table.index.is_unique and table.xs("Y", level="quantity")["rms"].tolist() == pytest.approx([1e-3, 2e-3])


def test_coarser_output_is_interpolated():
    """A straight line stays exact between the rows of a file with ten times the spacing."""
    found = cmp.compare([invented(), invented(dt=1e-3, name="coarse")])
    assert len(found.time) == 501
    assert np.abs(found.difference(1, "Y")).max() < 1e-15


def test_open_contact_has_no_difference():
    """Closed from 20 to 24 ms in one, from 22 to 26 ms in the other: 2 ms in common."""
    found = cmp.compare([invented(), invented(delay=0.002, name="late")])
    known = ~np.isnan(found.difference(1, "angle_LF"))
    assert found.time[known].min() >= 0.022 and found.time[known].max() <= 0.024
    share = cmp.difference_table(found).set_index("quantity").loc["angle_LF", "share compared"]
    # Rows every 0.1 ms, of which 501 are compared and 19 lie inside these 2 ms.
    assert known.sum() == 19 and share == pytest.approx(19/501)


HEADER = "# ldbench 1.0.0\n# &case\n#   name = 'mine'\n# /\n# &setup\n" + "".join(
    f"#   {name} = 0.0\n" for name in ("clearance_left", "clearance_right", "axle_height", "axle_roll")) + "# /\n"


def write_files(folder: Path) -> None:
    """A file with the least that makes it one of ours, and one of another code: its own names, mm and kN, Y to the right."""
    names, _, rows = invented().data[["time", "Y", "N_LF"]].to_string(index=False, float_format="%.12e").partition("\n")
    results = "# &results\n#   end = 't_end'\n#   t_first_LF = 0.02\n#   peak_N_LF = 8e5\n# /\n"
    (folder/"mine.txt").write_text(f"{names}\n{HEADER}{rows}\n{results}")
    late = invented(delay=0.003).data
    theirs = {"t [s]": late.time, "ylat [mm]": -1e3*late.Y, "nfl [kN]": 1e-3*late.N_LF}
    pd.DataFrame(theirs).to_csv(folder/"theirs.csv", index=False)
    (folder/"theirs.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\nN_LF = "nfl"\n')


def test_command_reads_another_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    write_files(tmp_path)
    target = tmp_path/"both.pdf"
    assert main(["compare", str(tmp_path/"mine.txt"), str(tmp_path/"theirs.csv"),
                 "--map", str(tmp_path/"theirs.toml"), "-o", str(target)]) == 0
    assert str(target) in capsys.readouterr().out
    table = pd.read_csv(tmp_path/"both.csv").set_index(["what", "quantity"])
    assert table.loc[("difference", "Y"), "rms"] == pytest.approx(SPEED*0.003, rel=1e-9)
    assert table.loc[("event", "first left flange contact"), "difference"] == pytest.approx(0.003, abs=1e-9)
    assert table.loc[("peak", "N_LF"), "value"] == pytest.approx(8e5, rel=1e-9)
    assert table.loc[("difference", "Y"), ["words", "unit"]].tolist() == ["lateral displacement Y", "m"]
    assert table.loc[("impact", "LF 1 start"), "difference"] == pytest.approx(0.003, abs=1e-6)
    assert table["unit"].notna().all()
    assert [part.title for part in PdfReader(target).outline[1]] == [
        "files, events and peaks", "impacts of theirs", "impacts, laid on each other", "differences of theirs",
        "displacements", "normal forces"]


@pytest.mark.parametrize("exercise", [3, 5])
def test_study_changes_what_it_says(exercise: int, tmp_path: Path):
    case = Case.exercise(exercise).replace(model="strip", dt=2e-5, interval=2e-4)
    jobs = study_jobs(case, tmp_path)
    fine, law, step = (jobs[v].case for v in ("fine", "law", "step"))
    assert law.model == "hertz" and fine.model == step.model == "strip"
    assert (fine.dt, law.dt, step.dt) == (2e-5, 2e-5, 1e-4)
    assert {one.interval for one in (fine, law, step)} == {1e-4}
    assert {one.t_end for one in (fine, law, step)} == {SHORT_RAMP if exercise == 5 else case.t_end}
    groups = [one.namelist() for one in (fine, law, step)]
    for group in ("initial", "loading", "profiles", "case"):
        assert groups[0][group] == groups[1][group] == groups[2][group]


def test_the_function_has_the_tables_of_the_command(tmp_path: Path, undrawn: None):
    """Runs in memory and their files are compared alike, to the digits that files have."""
    case = ldbench.Case.exercise(2).replace(model="hertz", t_end=0.03, table_folder=kept_tables())
    runs = [ldbench.run(case.replace(vY=vY)) for vY in (0.5, 0.51)]
    files = [run.write(tmp_path/f"{k}.txt") for k, run in enumerate(runs)]
    assert main(["compare", *files, "-o", str(tmp_path/"both.pdf")]) == 0
    written, found = pd.read_csv(tmp_path/"both.csv"), ldbench.compare(*files)
    assert list(found) == list(written) and len(found) == len(written)
    assert np.allclose(found.largest.astype(float), written.largest, rtol=1e-9, equal_nan=True) and (found.largest > 0).any()
    assert np.allclose(ldbench.compare(*runs).largest.astype(float), written.largest, rtol=1e-4, atol=1e-6, equal_nan=True)
    with pytest.raises(ldbench.Error, match="at least two"):
        ldbench.compare(files[0])
