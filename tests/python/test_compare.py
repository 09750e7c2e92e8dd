"""compare: known shifts, offsets and other codes' files come out as what they are."""
from __future__ import annotations

import io
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

from invented import altered, invented_run
from ldbench import Case, Event
from ldbench.__main__ import main
from ldbench.plots.style import ldbench_style
from ldbench.report import differences as cmp
from ldbench.report.compare import quantity_page
from ldbench.report.study import SHORT_RAMP, make_study, study_jobs
from ldbench.results.header import Header
from ldbench.results.run_data import RunData, read_data
from running import REPO, namelist

SPEED = 0.5        # of the invented wheelset [m/s]
TOUCH = 0.02       # when its flange touches [s]


def invented(delay: float = 0.0, offset: float = 0.0, force: float = 8e5, dt: float = 1e-4,
             name: str = "mine") -> RunData:
    """Steady motion to the left; a half-sine of flange force 4 ms long; all of it `delay` later."""
    t = dt*np.arange(round(0.05/dt) + 1)
    since = t - TOUCH - delay
    closed = (since > 1e-9) & (since < 0.004 - 1e-9)
    columns = pd.DataFrame({
        "time": t, "X": t, "Y": SPEED*(t - delay) + offset,
        "N_LF": np.where(closed, force*np.sin(np.pi*np.clip(since, 0, 0.004)/0.004), 0.0),
        "angle_LF": np.where(closed, 1.0, np.nan)})
    events = Event(TOUCH + delay, "left flange contact"), Event(TOUCH + delay + 0.01, "centre passage")
    return invented_run(columns, f"{name}.txt", header=Header(events=events))


def rms(table: pd.DataFrame, quantity: str) -> float:
    return float(table.set_index("quantity").loc[quantity, "rms"])


def test_a_file_does_not_differ_from_itself():
    table = cmp.difference_table(cmp.compare([invented(), invented(name="same")]))
    assert set(table["quantity"]) == {"Y", "N_LF", "angle_LF"}
    assert (table["rms"] == 0).all() and (table["largest"] == 0).all()


def test_known_shift_is_found_and_taken_out():
    runs = [invented(), invented(delay=0.003, name="late")]
    as_is = cmp.difference_table(cmp.compare(runs))
    assert rms(as_is, "Y") == pytest.approx(SPEED*0.003, rel=1e-12)
    assert rms(as_is, "N_LF") > 1e5
    aligned = cmp.compare(runs, align="first-flange")
    assert aligned.shifts[1] - aligned.shifts[0] == pytest.approx(0.003, abs=1e-15)
    table = cmp.difference_table(aligned)
    assert rms(table, "Y") < 1e-15 and rms(table, "N_LF") < 1e-6
    events = cmp.event_table(runs).set_index("quantity")
    assert events.loc["first left flange contact", "difference"] == pytest.approx(0.003, abs=1e-15)
    assert events.loc["first centre passage", "difference"] == pytest.approx(0.003, abs=1e-15)
    assert events.loc["end", "difference"] == 0


def test_offset_and_peak_are_measured():
    runs = [invented(), invented(offset=-2e-4, force=8.8e5, name="harder")]
    table = cmp.difference_table(cmp.compare(runs))
    assert rms(table, "Y") == pytest.approx(2e-4, rel=1e-9)
    worst = table.set_index("quantity").loc["N_LF"]
    assert worst["largest"] == pytest.approx(0.8e5, rel=1e-9) and worst["at [s]"] == pytest.approx(TOUCH + 0.002)
    peak = cmp.event_table(runs).set_index("quantity").loc["N_LF"]
    assert (peak["reference"], peak["value"], peak["difference"]) == pytest.approx((8e5, 8.8e5, 0.8e5))


def test_runs_of_one_case_have_names_of_their_own():
    runs = [invented(offset=offset) for offset in (0, 1e-3, 2e-3)]
    table = cmp.difference_table(cmp.compare(runs)).set_index(["file", "quantity"])
    assert table.index.is_unique
    assert table.xs("Y", level="quantity")["rms"].tolist() == pytest.approx([1e-3, 2e-3])


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
    assert share == pytest.approx(known.mean()) and 0.03 < share < 0.045


def test_page_draws_overlay_and_difference():
    runs = [invented(), invented(delay=0.003, name="late"), invented(offset=1e-3, name="aside")]
    with ldbench_style():
        figure = quantity_page(cmp.compare(runs), ["Y", "N_LF"], "two")
    overlay, difference, forces, _ = figure.axes
    for line, run in zip(overlay.get_lines(), runs, strict=True):
        assert line.get_label() == run.name
        np.testing.assert_allclose(line.get_ydata(), 1e3*run.values("Y"))
    late, aside = difference.get_lines()
    np.testing.assert_allclose(late.get_ydata(), -1e3*SPEED*0.003)
    np.testing.assert_allclose(aside.get_ydata(), 1.0)
    assert overlay.get_title("left") == "lateral displacement Y [mm]"
    assert difference.get_title("left") == "difference from the reference [mm]"
    assert forces.get_lines()[0].get_ydata().max() == pytest.approx(800)       # kN
    assert len({(line.get_color(), str(line.get_linestyle())) for line in overlay.get_lines()}) == 3


def test_impacts_are_compared_by_number():
    """Start, duration, peak and impulse of a later and harder half-sine of 4 ms; the second file lacks the second impact."""
    first, second = invented(), invented(delay=0.012)
    both = altered(first, data=first.data.assign(N_LF=first.values("N_LF") + second.values("N_LF")))
    harder = invented(delay=0.003, force=8.8e5, name="harder")
    table = cmp.impact_table([both, harder]).set_index("quantity")
    impulse = 2/np.pi*8e5*0.004
    for name, unit, reference, difference in (("start", "s", TOUCH, 0.003), ("duration", "s", 0.004, 0.0),
                                              ("peak", "N", 8e5, 0.8e5), ("impulse", "N.s", impulse, 0.1*impulse)):
        row = table.loc[f"LF 1 {name}"]
        assert (row["file"], row["unit"]) == ("harder", unit) and row["words"].startswith("left flange 1, ")
        assert (row["reference"], row["difference"]) == pytest.approx((reference, difference), rel=1e-3, abs=2e-6)
    assert pd.isna(table.loc["LF 2 peak", "value"])
    assert table.loc["LF 2 start", "reference"] == pytest.approx(TOUCH + 0.012, abs=2e-6)


def other_code(run: RunData, path: Path) -> None:
    """Write the run as another code would: its own names, mm and kN, commas, Y to the right."""
    lines = ["t [s], ylat [mm], nfl [kN]"]
    lines += [f"{t:.9g}, {-1e3*y:.12g}, {1e-3*n:.12g}" for t, y, n in
              zip(run.time, run.values("Y"), run.values("N_LF"), strict=True)]
    path.write_text("\n".join(lines) + "\n")


def ours(run: RunData, path: Path) -> None:
    run.data[["time", "Y", "N_LF"]].to_string(path, index=False, float_format="%.12e")


HEADER = "# ldbench 1.0.0\n# &case\n#   name = 'mine'\n# /\n# &setup\n" + "".join(
    f"#   {name} = 0.0\n" for name in ("clearance_left", "clearance_right", "axle_height", "axle_roll")) + "# /\n"


def with_header(path: Path) -> None:
    """Add the least that makes a file one of ours, for which no map is."""
    names, _, rows = path.read_text().partition("\n")
    path.write_text(f"{names}\n{HEADER}{rows}\n# &results\n#   end = 't_end'\n# /\n")


def test_command_reads_another_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    ours(invented(), tmp_path/"mine.txt")
    with_header(tmp_path/"mine.txt")
    other_code(invented(delay=0.003), tmp_path/"theirs.csv")
    (tmp_path/"theirs.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\nN_LF = "nfl"\n')
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
    document = PdfReader(target)
    assert [part.title for part in document.outline[1]] == [
        "files, events and peaks", "impacts of theirs", "impacts, laid on each other", "differences of theirs",
        "displacements", "normal forces"]
    texts = [page.extract_text() for page in document.pages]
    assert len(texts) == 6 and "theirs.csv" in texts[0] and "first left flange contact [ms]" in texts[0]
    assert "impulse [kN·s]" in texts[1] and "lateral displacement Y [mm]" in texts[4]


def test_command_aligns(tmp_path: Path):
    for name, delay in (("a", 0.0), ("b", 0.003)):
        ours(invented(delay=delay), tmp_path/f"{name}.txt")
    assert main(["compare", str(tmp_path/"a.txt"), str(tmp_path/"b.txt"), "--align", "first-flange",
                 "-o", str(tmp_path/"ab.pdf")]) == 0
    table = pd.read_csv(tmp_path/"ab.csv").set_index(["what", "quantity"])
    assert table.loc[("difference", "Y"), "rms"] < 1e-9


def small_project(root: Path) -> Path:
    """Inputs of two exercises with coarse tables, in a project folder of their own."""
    inputs = root/"inputs"
    inputs.mkdir(parents=True)
    (root/"outputs").mkdir()
    for exercise, values in ((3, {"initial": {"vY": 1.0, "roll_rate": 0.0333}}),
                             (5, {"loading": {"lateral_ramp": 1e5}})):
        name = f"ex{exercise}_aw"
        text = namelist(
            case={"name": name, "title": "small"}, **values,
            profiles={"wheel_profile": REPO/"profiles/awprof.yz", "rail_profile": REPO/"profiles/arprof.yz"},
            contact={"model": "strip"},
            table={"file": "outputs/aw_strip.table", "n_lateral": 60, "n_roll": 9, "n_depth": 9},
            integrator={"scheme": "energy", "order": 4, "dt": 2e-5, "t_end": 0.03,
                        "stop_at": "derailment" if exercise == 5 else "t_end"},
            output={"file": f"outputs/{name}.txt", "interval": 2e-4})
        (inputs/f"{name}.nml").write_text(text)
    return root


def test_study_changes_what_it_says(tmp_path: Path):
    root = small_project(tmp_path)
    for exercise in (3, 5):
        jobs = study_jobs(Case.from_namelist(root/f"inputs/ex{exercise}_aw.nml"), root/"outputs/study")
        fine, law, step = (jobs[v].case for v in ("fine", "law", "step"))
        assert law.model == "hertz" and fine.model == step.model == "strip"
        assert law.table_file == "outputs/aw_hertz.table" and fine.table_file == step.table_file == "outputs/aw_strip.table"
        assert (fine.dt, law.dt, step.dt) == (2e-5, 2e-5, 1e-4)
        assert {case.interval for case in (fine, law, step)} == {1e-4}
        assert {case.t_end for case in (fine, law, step)} == ({SHORT_RAMP} if exercise == 5 else {0.03})
        groups = [case.namelist() for case in (fine, law, step)]
        for group in ("initial", "loading", "profiles", "case"):
            assert groups[0][group] == groups[1][group] == groups[2][group]


def test_study_of_a_small_project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    root = small_project(tmp_path)
    said = io.StringIO()
    said.isatty = lambda: True
    monkeypatch.setattr("sys.stderr", said)
    monkeypatch.chdir(root)
    document, table = make_study(Path("inputs"), Path("outputs"), workers=2, ramp_end=0.1)
    assert re.search(r"\rstudy: .*\d+/\d+ \[", said.getvalue())      # a bar on a terminal
    monkeypatch.setattr("sys.stderr", sys.__stderr__)
    rows = pd.read_csv(table).set_index(["case", "variant"])
    assert set(rows.index) == {(c, v) for c in ("ex3_aw", "ex5_aw") for v in ("law", "step")}
    # On the way to the flange laws and steps agree; at the impact the law tells more than the step.
    law, step = rows.loc[("ex3_aw", "law")], rows.loc[("ex3_aw", "step")]
    column = "N_LF peak of the first contact, relative"
    assert 0.01 > abs(step[column]) < abs(law[column]) < 0.3
    assert law["Y rms, first contact [m]"] > 10*step["Y rms, first contact [m]"] > 0
    runs = {v: read_data(root/f"outputs/study/ex3_aw_{v}.txt") for v in ("fine", "law")}
    peaks = [run.first_interval("LF").peak for run in runs.values()]
    assert law[column] == pytest.approx(peaks[1]/peaks[0] - 1, rel=1e-9)
    pages = PdfReader(document)
    assert [part.title for part in pages.outline if not isinstance(part, list)] == [
        "Summary", "Exercise 3, actual profiles", "Exercise 5, actual profiles"]
    texts = [page.extract_text() for page in pages.pages]
    assert len(texts) == 3 and "law [µm]" in texts[0] and "normal force, left flange" in texts[0]
    assert "Exercise 3, actual profiles: contact law or time step?" in texts[1]
    before = {file: file.stat().st_mtime_ns for file in (root/"outputs/study").glob("*.txt")}
    monkeypatch.setattr("ldbench.report.study.save_document", lambda *drawn: None)
    make_study(Path("inputs"), Path("outputs"), workers=2, ramp_end=0.1)
    assert before == {file: file.stat().st_mtime_ns for file in (root/"outputs/study").glob("*.txt")}
