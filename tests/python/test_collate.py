"""Collation of codes that do not exist: planted numbers, late submissions, files of every kind that stop nobody."""
from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

import imaginary_round
import ldbench
from browser import facts
from hostile_files import HARMLESS, HOSTILE
from imaginary_round import (
    ADAMS,
    BORA,
    CODES,
    CONTURA,
    FAST,
    FILE,
    GENSIM,
    IMPAKT,
    KINEMA,
    SLOW,
    Code,
    damped,
    graded_round,
    hostile_round,
    own_are_of,
    run_of,
    table_of,
    the_round,
)
from invented import invented_run
from ldbench.__main__ import main
from ldbench._core.files import write_frame
from ldbench.plots.style import ldbench_style
from ldbench.results.events import FLANGE_ANGLE
from ldbench.results.run_data import RunData
from ldbench.results.summary import summary_row
from ldbench_round import check, round_numbers
from ldbench_round.collation import Collation, collate, write_csv
from ldbench_round.collation_matrix import grade_pages
from ldbench_round.collation_pdf import code_pages, curves_page, number_table
from ldbench_round.contact_groups import FILE as GROUPS_FILE, write_groups
from ldbench_round.kept_entries import SCORED_AS_ELASTIC, find_references
from ldbench_round.round_numbers import NUMBERS, SI, names_of, numbers_of
from ldbench_round.scores import GRADED, Score
from ldbench_round.submissions import find_submissions
from ldbench_round.tasks import TASKS, Task
from of_codes import File, check_numbers, walk_codes
from running import Run


@pytest.fixture(scope="module", autouse=True)
def own() -> Iterator[None]:
    with own_are_of(BORA, run_of):
        yield


@pytest.fixture(scope="module")
def written() -> Path:
    return the_round()/"codes"


@pytest.fixture
def codes(written: Path, tmp_path: Path) -> Path:
    """A copy of three of them."""
    for code in ADAMS, BORA, CONTURA:
        shutil.copytree(written/code.name, tmp_path/"codes"/code.name)
    return tmp_path/"codes"


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    """A copy of what a collation of all codes keeps."""
    return shutil.copytree(the_round()/"kept", tmp_path/"kept")


@pytest.fixture(scope="module")
def collated() -> Collation:
    return imaginary_round.collated(the_round())


def table(found: Collation, file: Path) -> list[str]:
    """The lines of the CSV."""
    write_csv(found, file)
    return file.read_text().splitlines()


def frame_of(found: Collation, file: Path) -> pd.DataFrame:
    """The CSV as a table."""
    table(found, file)
    return pd.read_csv(file, keep_default_na=False, na_values=[""])


# ---- numbers -------------------------------------------------------------------------
@pytest.mark.parametrize("code", [ADAMS, BORA, CONTURA, GENSIM], ids=lambda code: code.name)
def test_planted_numbers_come_back(code: Code, collated: Collation):
    """Times, forces and impulses of the run that a file was written from, through units, signs, zeros and names of the code."""
    submission = next(one for one in collated.codes if one.name == code.name)
    run = run_of(code, FAST)
    first, right = (next(one for one in run.impacts([contact]) if one.angle > FLANGE_ANGLE) for contact in ("LF", "RF"))
    value = {name: collated.value(submission, FAST, name) for name in NUMBERS}
    assert collated.lines() == []
    # The file has a row every 0.1 ms, where the run has events, too.
    assert value["t_first_LF"] == pytest.approx(first.start, abs=2e-5)
    assert value["t_first_RF"] == pytest.approx(right.start, abs=5e-5)
    assert value["first_duration_LF"] == pytest.approx(first.duration, abs=5e-5)
    assert value["first_peak_N_LF"] == pytest.approx(table_of(run)["N_LF"].max(), rel=1e-6)
    assert value["first_impulse_LF"] == pytest.approx(first.impulse, rel=1e-2)
    if code == GENSIM:          # which has changed velocities
        assert value["energy_error"] > 0.01
    else:
        before, after = np.interp([first.start, first.end], run.time, run.values("vY"))
        assert value["rebound"] == pytest.approx(-after/before, abs=2e-3)
        assert value["t_return"] == pytest.approx(run.results["t_return"], abs=1e-6)
        assert value["energy_error"] < 1e-3


def test_an_impact_of_rigid_contacts_takes_no_time(collated: Collation):
    """The file has no force of the impact. The velocities tell when it was; there is no force, and the CSV says why."""
    run = run_of(IMPAKT, FAST)
    event = next(one for one in run.events if one.impulses.get("LF", 0.0) > 0)
    numbers = collated.entries["Impakt", FAST].numbers
    assert numbers["t_first_LF"].value == pytest.approx(event.t, abs=1.01e-4) and numbers["first_duration_LF"].value == 0
    assert np.isnan(numbers["first_peak_N_LF"].value) and "no time" in numbers["first_peak_N_LF"].reason
    before, *_, after = run.values("vY")[np.abs(run.time - event.t) < 1e-9]
    assert numbers["rebound"].value == pytest.approx(-after/before, abs=2e-3)


def half_sine(peak: float = 2e5, start: float = 0.02, duration: float = 0.005, interval: float = 1e-5) -> RunData:
    """An impact of a half sine that turns 0.5 m/s into -0.3 m/s; the way back to -10 mm, and the centre."""
    t = np.arange(0, 0.2, interval)
    phase = np.clip((t - start)/duration, 0, 1)
    force = np.where((phase > 0) & (phase < 1), peak*np.sin(np.pi*phase), 0.0)
    v = np.where(t > 0.1, 0.4, 0.5 - 0.8*(1 - np.cos(np.pi*phase))/2)
    y = np.concatenate([[0.0], np.cumsum((v[1:] + v[:-1])/2*interval)])
    return invented_run(pd.DataFrame({"time": t, "Y": y, "vY": v, "N_LF": force, "angle_LF": 1.0,
                                      "N_RF": np.where((t > 0.098) & (t < 0.1), 3e4, 0.0)}))


def test_numbers_of_a_half_sine_are_exact():
    run = half_sine()
    found = numbers_of(run, FAST, [], seconds=3.0)
    back = 0.1 - run.values("Y")[np.searchsorted(run.time, 0.1)]/0.4
    for name, expected, error in (
            ("t_first_LF", 0.02, 1e-6), ("first_duration_LF", 0.005, 2e-6), ("first_peak_N_LF", 2e5, 2.0),
            ("first_impulse_LF", 2e5*0.005*2/np.pi, 6e-3), ("rebound", 0.6, 1e-6), ("t_first_RF", 0.098, 1.1e-5),
            ("t_return", back, 2e-5), ("processor_time", 3.0, 0.0)):
        assert found[name].value == pytest.approx(expected, abs=error), name
    assert "not checked" in found["energy_error"].reason


@pytest.mark.parametrize(("missing", "number", "reason"), [
    ("N_LF", "first_peak_N_LF", "no normal force of the left flange"), ("vY", "rebound", "no lateral velocity"),
    ("Y", "t_return", "no lateral displacement"), ("N_RF", "t_first_RF", "no normal force of the right flange")])
def test_a_number_that_cannot_be_had_has_its_reason(missing: str, number: str, reason: str):
    found = numbers_of(invented_run(half_sine().data.drop(columns=missing)), FAST, [])
    assert np.isnan(found[number].value) and reason in found[number].reason
    assert all(np.isfinite(one.value) != bool(one.reason) for one in found.values())


def test_there_is_one_force_at_derailment(shipped: dict[str, Run]):
    """Summary and collation have the force of the event, to the last bit. Rows alone have that of the exercise's own ramp, which is
    24 times less steep than here, to what a row adds."""
    run = ldbench.read_run(shipped["ex5_aw"].file)
    event = run.first("derailment").force
    rows = run.data[["time", "Y", "roll"]]
    known, by_rows, cut = (numbers_of(one, Task(5, "aw"), [])["F_derailment"]
                           for one in (run, invented_run(rows), invented_run(rows.iloc[:-50])))
    assert known.value == summary_row(run)["F_derailment"] == event and by_rows.value == pytest.approx(event/24, abs=1.25)
    assert np.isnan(cut.value) and "before the derailment" in cut.reason


# ---- the table -----------------------------------------------------------------------
def test_the_table_has_every_code_simulation_and_number(collated: Collation, tmp_path: Path):
    frame = frame_of(collated, tmp_path/"table.csv")
    assert list(frame) == ["code", "simulation", "number", "value", "unit", "remark"]
    for code in CODES:
        for task in TASKS:
            rows = frame[(frame.code == code.name) & (frame.simulation == task.name)]
            assert list(rows.number) == [*names_of(task), *(f"checks_{name}" for name in round_numbers.VERDICTS.values())]
            assert (rows.value.isna() == rows.remark.notna()).all()
            assert task in (FAST, SLOW) or (rows.remark == "not submitted").all()
    peak = frame[(frame.code == "Bora") & (frame.simulation == FAST.name) & (frame.number == "first_peak_N_LF")].iloc[0]
    assert peak.value == collated.value(collated.codes[1], FAST, "first_peak_N_LF") and peak.unit == SI["first_peak_N_LF"] == "N"
    checks = frame[(frame.code == "Adams") & (frame.simulation == FAST.name) & frame.number.str.startswith("checks_")]
    assert checks.value.sum() == sum(collated.entries["Adams", FAST].verdict.values()) > 30
    known = [x for code in collated.codes if np.isfinite(x := collated.value(code, FAST, "first_peak_N_LF"))]
    assert 4 <= len(known) < len(CODES) and collated.median(FAST, "first_peak_N_LF") == np.median(known)
    assert np.isnan(collated.median(Task(1, "sw"), "first_peak_N_LF"))


def test_a_late_submission_costs_its_own_files_alone(codes: Path, tmp_path: Path):
    """So does a file that has changed; the bytes of before give the lines of before."""
    late, store = tmp_path/"late", tmp_path/"store"
    shutil.move(codes/"Contura", late)
    store.mkdir()
    first = collate(codes, store)
    before = table(first, tmp_path/"before.csv")
    kept = {file: (file.read_bytes(), file.stat().st_mtime_ns) for file in store.iterdir()}
    assert len(first.computed) == 2 + len(kept) == 4
    shutil.move(late, codes/"Contura")
    second = collate(codes, store)
    assert second.computed == (("Contura", FAST),)
    after = table(second, tmp_path/"after.csv")
    assert [line for line in after if not line.startswith("Contura,")] == before and len(after) > len(before) + 10
    assert all((file.read_bytes(), file.stat().st_mtime_ns) == known for file, known in kept.items())
    file = codes/"Contura"/FILE
    text = file.read_text()
    for changed in text.rsplit("\n", 3)[0] + "\n", text:
        file.write_text(changed)
        found = collate(codes, store)
        assert found.computed == (("Contura", FAST),)
    assert table(found, tmp_path/"again.csv") == after


# ---- descriptions --------------------------------------------------------------------
def described(folder: Path, text: str) -> Path:
    """A folder with one code of that description."""
    (folder/"one").mkdir(parents=True, exist_ok=True)
    (folder/"one/submission.toml").write_text(text)
    return folder


def test_a_description_is_read(tmp_path: Path):
    text = ('code = "One"\nversion = 2\nauthors = ["A", "B"]\nstep = 1e-5\nprocessor_time = { ex1_aw = 1.5, ex2_sw = 2 }\n'
            '[map]\ntime = 1\nY = { column = "ylat", unit = "mm" }\n')
    (code,), remarks = find_submissions(described(tmp_path, text))
    assert remarks == [] and code.name == "one"
    assert code.facts == {"code": "One", "version": "2", "authors": "A, B", "step": "1e-05", "processor_time": "3.5"}
    assert code.seconds == {"ex1_aw": 1.5, "ex2_sw": 2.0}
    assert code.map == {"time": 1, "Y": {"column": "ylat", "unit": "mm"}}
    assert code.remarks == ("expected files such as ex1_aw.csv, found none",)


@pytest.mark.parametrize(("told", "said"), [
    ("step = nan", "step: expected a time in seconds, found nan"), ("step = 0", "step: expected a time in seconds, found 0"),
    ("step = -1e-5", "step: expected a time in seconds"), ("step = true", "step: expected a time in seconds"),
    ("step = [1, 2]\nlaw = [[1]]", "law: expected words"), ("step = 0x" + "f"*9000, ""),
    ("processor_time = -5", "processor_time: expected a time in seconds, found -5"), ("processor_time = inf", "expected a time"),
    ("processor_time = { ex1_aw = -5 }", "found ex1_aw = -5"),
    ('formulation = "quantum"', "expected elastic or constraints, found q"),
    ("formulation = 3", "expected elastic or constraints, found 3"), ("code = nan", "code: expected words"),
    ("version = " + "1"*9000, ""), ("restitution = nan", "expected a number from 0 to 1, found nan")])
def test_what_cannot_be_in_a_description_is_one_line(told: str, said: str, tmp_path: Path):
    (code,), _ = find_submissions(described(tmp_path, told))
    first, *rest = code.remarks
    assert said in first and len(first) < 420 and rest == ["expected files such as ex1_aw.csv, found none"], code.remarks
    assert told.partition(" =")[0] not in code.facts or "[" in told or "{" in told


def test_the_map_of_a_description_is_used(written: Path, tmp_path: Path):
    """Nothing is guessed where a description names a map."""
    codes, store = tmp_path/"mapped", tmp_path/"store"
    (codes/"Bora").mkdir(parents=True)
    store.mkdir()
    shutil.copy(written/"Bora"/FILE, codes/"Bora")
    (codes/"Bora/columns.toml").write_text(check.check_file(codes/"Bora"/FILE).guess.toml())
    (codes/"Bora/submission.toml").write_text('map = "columns.toml"\n')
    found = collate(codes, store)
    guessed = numbers_of(check.read_submitted(codes/"Bora"/FILE, FAST).run, FAST, [])
    assert found.lines() == [] and found.entries["Bora", FAST].numbers["first_peak_N_LF"].value == guessed["first_peak_N_LF"].value
    (codes/"Bora/columns.toml").write_text('time = "time"\nY = "no such column"\n')
    again = collate(codes, store)
    assert again.computed == (("Bora", FAST),)
    assert len(again.lines()) == 1 and "no such column" in again.lines()[0]


# ---- hostile files -------------------------------------------------------------------
@pytest.fixture(scope="module")
def hostile() -> tuple[Collation, Path]:
    """A code for each kind of file, beside two that are as they should be."""
    return imaginary_round.collated(hostile_round()), hostile_round()/"codes"


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_hostile_file_is_one_line(kind: str, hostile: tuple[Collation, Path]):
    """It names the code and the file, or what is missing; a file that can be read but is nonsense fails in its checks."""
    found, folder = hostile
    lines = [line for line in found.lines() if line.startswith(f"{kind}: ")]
    entry = found.entries.get((kind, FAST))
    if kind in HARMLESS:        # milliseconds become seconds with an error of rounding
        assert lines == []
        known = found.entries["Bora", FAST].numbers
        assert [one.reason for one in entry.numbers.values()] == [one.reason for one in known.values()]
        assert [one.value for one in entry.numbers.values()] == pytest.approx(
            [one.value for one in known.values()], nan_ok=True, rel=1e-9)
    elif lines:
        assert len(lines) == 1 and FAST.name in lines[0], lines
        assert lines[0].isprintable() and len(lines[0]) < 500 and str(folder) not in lines[0]
        assert "Traceback" not in lines[0] and "cannot be used: " not in lines[0], "an error that nobody foresaw"
    else:
        assert entry is not None and entry.verdict["failed"] > 0


def test_hostile_files_harm_no_others(hostile: tuple[Collation, Path], collated: Collation):
    found, _ = hostile
    assert repr(found.entries["Adams", FAST].numbers) == repr(collated.entries["Adams", FAST].numbers)
    # The description alone is lost.
    spoilt = "TOML that does not parse"
    assert repr(found.entries[spoilt, FAST].numbers) == repr(found.entries["Bora", FAST].numbers)
    for start in spoilt, "no files", "zz loop":
        assert sum(line.startswith(f"{start}: ") for line in found.lines()) == 1


# ---- document, page, command ---------------------------------------------------------
def test_the_command_writes_three_files(codes: Path, written: Path, tmp_path: Path,
                                        capsys: pytest.CaptureFixture[str]):
    """Matrices of files and of grades; for each simulation curves, and numbers, scores and findings of the codes on a page."""
    (codes/"Contura/ex2_aw.csv").write_text("nothing\n")
    out = tmp_path/"out"
    assert main(["collate", str(codes), "-o", str(out), "--reference", str(written/"Bora"/FILE)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("Contura: ex2_aw.csv: expected rows of numbers") and "3 codes, 5 of 6 files used, 6 read" in said
    assert said[-3:] == [str(out/f"collation.{ending}") for ending in ("csv", "pdf", "html")]
    assert {file.name for file in out.iterdir() if file.is_file()} == {"collation.csv", "collation.pdf", "collation.html"}
    reader = PdfReader(out/"collation.pdf")
    titles = [item.title for item in reader.outline if not isinstance(item, list)]
    assert titles == ["Codes", "Grades", "Exercise 2, actual profiles", "Exercise 4, actual profiles"]
    pages = [page.extract_text() for page in reader.pages]
    tables = [text for text in pages if "Numbers, scores and findings" in text]
    assert len(tables) == 2 and all("Numbers\n" in text and "Findings\n" in text for text in tables)
    assert ["Scores, reference: " in text and "of spread" in text for text in tables] == [False, True]
    assert all(code.name in pages[0] for code in CODES[:3]) and "cannot" in pages[0]
    grades = next(text for text in pages if "Grades against the reference" in text and "grade 0.001" in text)
    assert all(code.name in grades for code in CODES[:3])
    told = facts(out/"collation.html")
    assert [code["name"] for code in told["codes"]] == ["Adams", "Bora", "Contura"]
    assert told["codes"][2]["entries"][2]["shade"] == "unusable" and told["lines"] == [said[0]]


# ---- grades --------------------------------------------------------------------------
@pytest.fixture(scope="module")
def graded(written: Path) -> Collation:
    return imaginary_round.collated(graded_round(), written/"Bora"/FILE)


def grade(graded: Collation, code: str, kind: str) -> Score:
    return graded.grade(next(one for one in graded.codes if one.name == code), FAST, kind)


def test_the_reference_itself_has_the_best_grade_everywhere(graded: Collation):
    found = {kind: grade(graded, "Itself", kind) for kind in GRADED}
    energy = found.pop("energy")        # which the file does not have
    assert np.isnan(energy.difference) and "in common" in energy.reason
    assert {(one.difference, one.grade, one.share) for one in found.values()} == {(0.0, 1e-3, 1.0)}


def test_what_cannot_be_scored_is_a_remark(graded: Collation):
    """Everything else is known of the late code."""
    lines = graded.lines()
    assert len(lines) == 2 and lines[0].startswith(f"Late: {FILE}: not scored: ") and "times in common" in lines[0]
    assert lines[1].startswith("Spoilt: ")
    entry = graded.entries["Late", FAST]
    assert not entry.error and not entry.grades and np.isfinite(entry.numbers["first_peak_N_LF"].value)


def test_a_rigid_code_is_scored_against_rigid_contacts(written: Path, tmp_path: Path):
    """Against our run with the restitution that the description tells, its motion has the best grade. Against an elastic run, and
    against a run with another restitution, it has none. A reference that is rigid itself is taken as it stands."""
    codes, kept = tmp_path/"codes", tmp_path/"kept"
    kept.mkdir()
    for name, told in ("Told", "restitution = 0.5\n"), ("Untold", 'formulation = "unilateral"\n'), ("Wrong", "restitution = 1\n"):
        (codes/name).mkdir(parents=True)
        shutil.copy(written/"Impakt"/FILE, codes/name)
        (codes/name/"submission.toml").write_text(told)
    references = find_references(written/"Bora"/FILE)
    found = collate(codes, kept, 2, references=references)
    assert found.lines() == []
    for code in found.codes:
        velocity, rigid = found.grade(code, FAST, "velocity"), code.name in ("Told", "Wrong")
        assert (velocity.grade, velocity.difference > 0.1) == ((1e-3, False) if code.name == "Told" else (None, True)), code.name
        assert bool(found.against(code, FAST)) == rigid
        assert (SCORED_AS_ELASTIC in found.entries[code.name, FAST].findings) == (not rigid)
    scored = [line for line in table(found, tmp_path/"collation.csv") if ",score_velocity," in line and "run with rigid" in line]
    assert [line.split(",")[0] for line in scored] == ["Told", "Wrong"]
    assert collate(codes, kept, 2, references=references).computed == ()
    assert collate(codes, kept, 2, references=find_references(written/"Impakt"/FILE)).rigid == frozenset()


def test_grades_are_rows_of_the_table(graded: Collation, collated: Collation, tmp_path: Path):
    frame = frame_of(graded, tmp_path/"table.csv")
    assert (frame.value.isna() == frame.remark.notna()).all()

    def row(code: str, number: str, task: Task = FAST) -> tuple[float, str]:
        one = frame[(frame.code == code) & (frame.simulation == task.name) & (frame.number == number)]
        return one.value.item(), one.remark.item()

    assert row("Itself", "score_velocity_grade")[0] == 1e-3 and row("Itself", "score_impulse_of_spread")[0] == 0
    assert row("Near", "score_impulse")[0] == pytest.approx(0.005, rel=2e-3) == row("Near", "score_force")[0]
    assert row("Near", "score_impulse_grade")[0] == 1e-2 and row("Near", "score_impulse_share")[0] == 1
    assert row("Softer", "score_displacement_of_spread")[0] == grade(graded, "Softer", "displacement").of_spread > 0
    assert row("Double", "score_impulse_grade")[1] == "beyond 0.1"
    assert "times in common" in row("Late", "score_event")[1] and "expected rows" in row("Spoilt", "score_event")[1]
    assert row("Itself", "score_event", Task(1, "sw"))[1] == "not submitted"
    assert row("Itself", "score_event", SLOW)[1] == "the reference has no file of this simulation"
    assert not any("score_" in line for line in table(collated, tmp_path/"without.csv"))


def test_no_cell_of_a_table_is_a_formula(tmp_path: Path):
    write_frame(pd.DataFrame({"code": ["=1+1", "@x", "-2e-3", "-", "+a"]}), tmp_path/"formulas.csv")
    assert list(pd.read_csv(tmp_path/"formulas.csv").code) == ["'=1+1", "'@x", "-2e-3", "-", "'+a"]


def test_given_contact_is_beside_own_contact(codes: Path, kept: Path, written: Path, tmp_path: Path):
    """Three codes with their own forces, two of them with one given force: the latter differ by their rows alone."""
    assert not write_groups(collate(codes, kept, 2), tmp_path/GROUPS_FILE) and not (tmp_path/GROUPS_FILE).exists()
    for code, name in (BORA, "Adams given"), (KINEMA, "Contura given"):
        shutil.copytree(written/code.name, codes/name)
        with (codes/name/"submission.toml").open("a") as file:
            file.write('contact_force = "given"\n')
    found = collate(codes, kept, 2)
    assert found.lines() == [] and write_groups(found, tmp_path/GROUPS_FILE)
    table = pd.read_csv(tmp_path/GROUPS_FILE).set_index(["simulation", "number"])
    first = table.loc[(FAST.name, "t_first_LF")]
    peak = table.loc[(FAST.name, "first_peak_N_LF")]
    planted = {code.name: found.value(code, FAST, "first_peak_N_LF") for code in found.codes}
    assert (peak.own_codes, peak.given_codes, peak.unit) == (3, 2, "N")
    assert peak.own_spread == pytest.approx(planted["Adams"] - planted["Contura"]) and peak.own_median == planted["Bora"]
    assert peak.given_median == pytest.approx((planted["Adams given"] + planted["Contura given"])/2)
    assert peak.given_less_own == pytest.approx(peak.given_median - peak.own_median)
    assert first.given_spread < 1e-3 and peak.own_spread > 0.05*peak.own_median
    assert table.loc[("ex1_aw", "t_return")].given_codes == 0


def test_a_contact_force_is_own_or_given(codes: Path, tmp_path: Path):
    with (codes/"Bora/submission.toml").open("a") as file:
        file.write('contact_force = "theirs"\n')
    bora = next(code for code in find_submissions(codes)[0] if code.name == "Bora")
    assert bora.remarks == ("submission.toml: contact_force: expected own or given, found theirs",)
    assert "contact_force" not in bora.facts


# ---- what is drawn -------------------------------------------------------------------
def test_everything_that_is_drawn_is_of_its_code(collated: Collation, graded: Collation):
    """Curves of all codes from the runs that they were written from, marks and shades of both matrices."""
    files = {}
    for code in CODES:
        rows = table_of(run_of(code, FAST))
        files[code.name] = File(damped(rows) if code is GENSIM else rows.iloc[::20].reset_index() if code is KINEMA else rows,
                                code is not IMPAKT)
    with ldbench_style():
        assert walk_codes([*dict(code_pages(collated)).values(), curves_page(collated, FAST)], files) > 60
        assert walk_codes(list(dict(grade_pages(graded)).values()), files) > 60


def test_the_table_of_numbers_is_the_csv(collated: Collation, tmp_path: Path):
    """Under the names and units of its heads, in the document as in collation.csv."""
    frame, found = frame_of(collated, tmp_path/"table.csv"), number_table(collated, FAST)
    heads = [f"{name} {unit}".strip() for name, unit in zip(found.header, found.second, strict=True)]
    assert check_numbers(found.rows, heads, frame[frame.simulation == FAST.name]) > 100
