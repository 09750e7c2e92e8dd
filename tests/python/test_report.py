"""report: makes the submission, and only what is not up to date."""
from __future__ import annotations

import json
import os
import shutil
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

from invented import altered
from ldbench import Case, Error, Event, _core, run
from ldbench._core import pools
from ldbench._core.kept import is_up_to_date, program_digest, write_stamp
from ldbench._core.pools import call_known, processes
from ldbench.conicity import GEOMETRY_PITCH
from ldbench.plots.series import PAGES
from ldbench.report import abstract, formulations, submission
from ldbench.report.jobs import case_job, run_stale
from ldbench.report.submission import make_report
from ldbench.results.run_data import RunData, read_data
from ldbench.results.summary import summary_row
from running import CASES, REPO, namelist, once

SMALL = {"n_lateral": 40, "n_roll": 9, "n_depth": 9}


SOME = tuple(page for page in PAGES if page.title in ("motion", "contact forces"))       # stand for all pages of a run

@pytest.fixture(scope="module")
def project(common: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Exercise 3 to the first flange contact with both pairs of profiles and coarse tables, reported."""
    made = common/"reported"
    with once(made) as first:
        if first:
            report_small_project(made)
    return Path(shutil.copytree(made, tmp_path_factory.mktemp("project"), dirs_exist_ok=True))


def report_small_project(root: Path) -> None:
    (root/"inputs").mkdir()
    for pair in ("aw", "sw"):
        (root/"inputs"/f"ex3_{pair}.nml").write_text(namelist(
            case={"name": f"ex3_{pair}", "title": f"small {pair}"}, initial={"vY": 1.0, "roll_rate": 0.0333},
            profiles={"wheel_profile": REPO/f"profiles/{pair[0]}wprof.yz",
                      "rail_profile": REPO/f"profiles/{pair[0]}rprof.yz"},
            contact={"model": "strip"}, table={"file": f"outputs/{pair}_strip.table", **SMALL},
            integrator={"scheme": "energy", "dt": 1e-5, "t_end": 0.03}, output={"file": f"outputs/ex3_{pair}.txt"}))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench.plots.document.PAGES", SOME)
        for module in "table", "conicity":          # rows of the geometry, five times as far apart
            patch.setattr(f"ldbench.{module}.GEOMETRY_PITCH", 5*GEOMETRY_PITCH)
        patch.chdir(root)
        made = make_report(Path("inputs"), Path("outputs"), jobs=2)
    assert [file.name for file in made] == [
        "ex3_aw.txt", "ex3_sw.txt", "ldbench_plots.pdf", "ldbench_abstract.pdf", "summary.csv",
        "ldbench_results.html"]


def test_products_are_there_and_nothing_else(project: Path):
    sent = {"ex3_aw.txt", "ex3_sw.txt", "ldbench_plots.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html"}
    kept = {"formulations.json", "twins.json"}
    assert {file.name for file in (project/"outputs").iterdir()} == sent | {"aw_strip.table", "sw_strip.table", ".ldbench"}
    assert {file.name for file in (project/"outputs/.ldbench").iterdir()} == kept | {f"{name}.stamp" for name in sent | kept}


def test_plots_have_pages_and_bookmarks(project: Path):
    document = PdfReader(project/"outputs/ldbench_plots.pdf")
    per_run = len(SOME) + 2
    formulations = 3         # the table with what it takes to go over the flange, exercise 3, values of both pairs
    first = 1 + 1 + 2 + 2    # contents, summary, geometry, side by side
    assert len(document.pages) == first + 2*per_run + formulations
    chapters = [part for part in document.outline if not isinstance(part, list)]
    assert [part.title for part in chapters] == [
        "Contents", "Summary", "Contact geometry, actual profiles", "Contact geometry, simplified profiles", "Side by side",
        "Exercise 3, actual profiles", "Exercise 3, simplified profiles", "Elastic contact or constraint equations"]
    assert [document.get_destination_page_number(part) for part in chapters] == [
        0, 1, 2, 3, 4, first, first + per_run, first + 2*per_run]
    run = read_data(project/"outputs/ex3_aw.txt")
    assert f"{run.first_contact('LF'):.6f}" in document.pages[1].extract_text()
    inner = [part for part in document.outline if isinstance(part, list)]
    for parts, pair in zip(inner[1:3], ("actual", "simplified"), strict=True):
        assert [part.title for part in parts] == [
            *(page.title for page in SOME), "energy, phase portrait, spectrum", "impacts of flanges"]
        for part in parts:
            page = document.pages[document.get_destination_page_number(part)]
            assert f"Exercise 3, {pair} profiles: {part.title}" in page.extract_text()
    words = document.pages[first].extract_text()
    for word in ("lateral Y [mm]", "vertical Z [mm]", "roll Φ [mrad]", "time [s]", "reconstructions", "'strip'"):
        assert word in words
    assert "time [ms]" in document.pages[first + per_run - 1].extract_text()
    for k, page in enumerate(document.pages):
        assert f"{k + 1} / {len(document.pages)}" in page.extract_text()


LONG_AGO = 10**9      # [s]


def remake(project: Path) -> set[str]:
    """Report again; the names of what was written."""
    files = [file for file in (project/"outputs").rglob("*") if file.is_file() and file.suffix != ".stamp"]
    for file in files:
        os.utime(file, (LONG_AGO, LONG_AGO))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(project)
        make_report(Path("inputs"), Path("outputs"), jobs=2)
    return {file.name for file in files if file.stat().st_mtime != LONG_AGO}


def test_up_to_date_is_skipped_and_change_is_not(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    project = Path(shutil.copytree(project, tmp_path/"project"))       # the other tests' stays as it is
    # Pages and typesetting are not the point here.
    monkeypatch.setattr(submission, "drawing", lambda runs, target, *rest: nullcontext(lambda: target.write_text("plots")))
    monkeypatch.setattr(abstract, "make_abstract", lambda runs, target, *rest: target.write_text("abstract"))
    assert remake(project) == set()
    inputs = project/"inputs/ex3_sw.nml"
    inputs.write_text(inputs.read_text().replace("vY = 1.0", "vY = 0.9"))
    assert remake(project) == {
        "ex3_sw.txt", "formulations.json", "twins.json", "ldbench_plots.pdf", "ldbench_abstract.pdf",
        "summary.csv", "ldbench_results.html"}
    assert remake(project) == set()
    columns = project/"outputs/ex3_aw.txt"
    columns.write_text(columns.read_text().replace("1.0", "1.1", 1))
    assert remake(project) == {"ex3_aw.txt"}      # the same columns again: the rest still holds


@pytest.fixture(scope="module")
def ten(project: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[list[RunData], Path]:
    """Ten runs with all rows filled, both endings, and every formulation, and their abstract."""
    runs = {pair: read_data(project/f"outputs/ex3_{pair}.txt") for pair in ("aw", "sw")}
    ending = {"end": "return to the centre after both flanges"}
    ten = [altered(runs[name[-2:]], results=ending, name=name) for name in CASES]
    for k in (8, 9):         # exercise 5: three seconds long, derailed
        ten[k] = altered(ten[k], {"events": (*ten[k].events, Event(2.987654, "derailment", 271234.0))},
                         data=ten[k].data.assign(time=100*ten[k].time))
    kept = [formulations.Outcome(**o) for o in json.loads((project/"outputs/.ldbench/formulations.json").read_text())]
    outcomes = [replace(found, case=name) for name in CASES for found in kept if found.pair == name[-2:]]
    written = [{"name": "A. Author", "affiliation": "First Institute"}, {"name": "B. Author", "affiliation": "Second Institute"}]
    target = tmp_path_factory.mktemp("ten")/"abstract.pdf"
    abstract.make_abstract(ten, target, outcomes, {"ex5_sw": {"t_derailment": 0.02, "F_derailment": 1500.0}}, written)
    return ten, target


def test_abstract_of_ten_runs_has_four_pages(ten: tuple[list[RunData], Path]):
    """The abstract has ten columns of results."""
    file = ten[1]
    document = PdfReader(file)
    assert len(document.pages) == 4
    words = " ".join(" ".join(page.extract_text() for page in document.pages).split())
    assert all(name in words for name in CASES) and "about 271 kN after about 2.99 s" in words and "~" not in words
    assert "A. Author" in words and "Second Institute" in words
    assert all(f"Figure {k}" in words and f"Table {k}" in words for k in (1, 2, 3, 4))
    assert words.count("271.2 kN") == 1 and words.count("271.2") == 2        # of the other run, in the text and in the table
    assert list(file.parent.iterdir()) == [file]


def test_numbers_of_tables_are_on_one_line(ten: tuple[list[RunData], Path]):
    """However narrow the columns of ten runs are, each cell is one line."""
    runs, file = ten
    lines = "\n".join(page.extract_text() for page in PdfReader(file).pages).splitlines()
    row = next(line for line in lines if line.startswith("energy drift, relative"))
    drifts = " ".join(abstract.scientific(summary_row(run)["drift_relative"]) for run in runs)
    plain = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")       # the text of a PDF may have a raised 1 as any other
    assert row.removeprefix("energy drift, relative").translate(plain).split() == drifts.translate(plain).split()


def test_authors_come_from_a_file(tmp_path: Path):
    file = tmp_path/"authors.toml"
    assert abstract.read_authors(file) == []
    file.write_text('[[author]]\nname = "A. Author"\naffiliation = "Institute, Town"\n[[author]]\nname = "B"\n')
    assert abstract.read_authors(file) == [
        {"name": "A. Author", "affiliation": "Institute, Town"}, {"name": "B", "affiliation": ""}]


@pytest.mark.parametrize(("text", "expected", "found"), [
    ('[[author]]\naffiliation = "Institute"\n', "a name", "none"),
    ('[[author]]\nname = 3\n', "a text for name or affiliation", "3"),
    ('author = "A"\n', "tables [[author]]", "str"), ('[[writer]]\nname = "A"\n', "tables [[author]] alone", "another name")])
def test_wrong_authors_are_told(text: str, expected: str, found: str, tmp_path: Path):
    file = tmp_path/"authors.toml"
    file.write_text(text)
    with pytest.raises(Error) as error:
        abstract.read_authors(file)
    assert str(error.value).startswith(f"{file}, ")
    assert error.value.expected == expected and error.value.found.startswith(found)


@pytest.mark.parametrize("changed", ["viewer/static/scene.js", "viewer/page.py", "_core/_flat.so", "results/columns.py"])
def test_a_change_of_the_program_makes_its_products_again(changed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Any file counts: scripts of the page, modules, the compiled core. What Python keeps of its own does not."""
    package, product = tmp_path/"package", tmp_path/"page.html"
    for name in ("viewer/static/scene.js", "viewer/page.py", "_core/_flat.so", "results/columns.py", "viewer/__pycache__/page.pyc"):
        (package/name).parent.mkdir(parents=True, exist_ok=True)
        (package/name).write_text("before")
    monkeypatch.setattr(_core.kept, "program_digest", lambda: program_digest.__wrapped__(package))
    product.write_text("page")
    write_stamp(product, {})
    (package/"viewer/__pycache__/page.pyc").write_text("after")
    assert is_up_to_date(product, {})
    (package/changed).write_text("after")
    assert not is_up_to_date(product, {})


def test_values_of_formulations_stand_under_their_pair(project: Path):
    """Each value in the row of its result and in the column of its pair and formulation."""
    kept = [formulations.Outcome(**o) for o in json.loads((project/"outputs/.ldbench/formulations.json").read_text())]
    found = [replace(o, results={**o.results, "Y_max": 1e-3*(k + 1)}) for k, o in enumerate(kept)]
    texts = formulations.values_page(found).axes[0].texts
    row = next(text.get_position()[1] for text in texts if text.get_text() == "largest Y [mm]")
    cells = sorted((text.get_position()[0], text.get_text()) for text in texts if text.get_position()[1] == row)
    assert [words for _, words in cells] == ["largest Y [mm]", *(f"{k + 1:#.4g}" for k in range(len(kept)))]
    heads = [text for text in texts if text.get_text() in ("elastic", "bilateral", "e = 1", "e = 0.5", "e = 0")]
    assert [text.get_text() for text in heads] == 2*["elastic", "bilateral", "e = 1", "e = 0.5", "e = 0"]
    assert [text.get_position()[0] for text in heads] == [x for x, _ in cells[1:]]


def test_results_that_a_twin_does_not_share_are_chaotic():
    """Numbers, counts, and what happens to one of two; exactness and the start itself do not count."""
    row = {"case": "ex1_aw", "t_return": 0.1, "peak_N_LF": 100e3, "t_first_LF": 0.02, "Y_min": 0.0, "t_derailment": None,
           "n_left_flange_contact": 1, "drift": 1e-9, "F_derailment": np.nan}
    twin = row | {"t_return": 0.1002, "peak_N_LF": 100.05e3, "Y_min": 1e-6, "t_derailment": 3.0, "n_left_flange_contact": 2,
                  "drift": 5e-9}
    assert submission.chaotic_results(row, twin) == {
        "t_return": pytest.approx(2e-4), "t_derailment": np.inf, "n_left_flange_contact": 1.0}
    assert submission.chaotic_results(row, dict(row)) == {}


def test_summary_names_chaotic_results(tmp_path: Path, project: Path):
    runs = [read_data(project/f"outputs/ex3_{pair}.txt") for pair in ("aw", "sw")]
    submission.write_summary(runs, tmp_path/"summary.csv", {"ex3_sw": {"Z_max": 1e-3, "t": 0.1}})
    assert list(pd.read_csv(tmp_path/"summary.csv").chaotic.fillna("")) == ["", "Z_max t"]


def test_stretches_of_a_run_follow_its_rows(tmp_path: Path):
    """Computed again from a row on, the motion is that of the run for some hundredths of a second."""
    case = Case.exercise(5, "aw").replace(model="hertz", **SMALL, table_file="", lateral_ramp=4e5, t_end=0.15,
                                          interval=1e-3, stop_at="t_end")
    job = case_job(case, tmp_path)
    run_stale([job], 1)
    whole = read_data(job.product)
    first, hardest = submission.first_and_hardest(whole)
    assert hardest.start < whole.peak("LF")[1] < hardest.start + hardest.run.time[-1]
    assert first.start < whole.first_contact("LF") < first.start + first.run.time[-1]
    for stretch in (first, hardest):
        assert np.diff(stretch.run.time).max() < 2.1e-5 and stretch.start in whole.time
        rows = (whole.time >= stretch.start) & (whole.time <= stretch.start + stretch.run.time[-1])
        t = whole.time[rows] - stretch.start
        for column, apart in ("Y", 1e-7), ("Z", 1e-7), ("roll", 1e-7), ("F_ext", 1.0):
            again = np.interp(t, stretch.run.time, stretch.run.values(column))
            np.testing.assert_allclose(again, whole.values(column)[rows], atol=apart)


def test_exercise_5_derails_at_one_load(tmp_path: Path):
    """That of the column file, from which the formulations are tabulated with a report and without."""
    case = Case.exercise(5, "aw").replace(model="hertz", accuracy=0.1, table_file=tmp_path/"aw.table", lateral_ramp=4e6, dt=1e-5,
                                          interval=1e-3)
    case.to_namelist(tmp_path/"ex5_aw.nml")
    file = read_data(run(case).write(tmp_path/"ex5_aw.txt"))
    derailment = file.first("derailment")
    for submitted in (), (file,):
        found = formulations.outcomes(tmp_path, 2, submitted=submitted)[0]
        assert (found.formulation, found.ending.partition(" over")[0]) == ("elastic", "derails")
        assert found.results["F_derailment"] == pytest.approx(derailment.force, abs=1 if not submitted else 0)


def test_work_of_processes_is_done_here_where_the_system_has_no_fork(monkeypatch):
    """Results come in the order of the tasks, and an error comes with the result that is asked for."""
    monkeypatch.setattr(pools, "FORKS", False)
    seen: list[int] = []
    with processes(4, 3, [lambda n: seen.append(n) or 10*n]) as pool:
        asked = [pool.submit(call_known, 0, n) for n in (1, 2)] + [pool.submit(int, "no number")]
        assert seen == [1, 2] and [future.result() for future in asked[:2]] == [10, 20]
        assert list(pool.map(abs, [-1, -2])) == [1, 2]
        with pytest.raises(ValueError, match="no number"):
            asked[2].result()
