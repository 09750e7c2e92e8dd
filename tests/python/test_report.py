"""report: makes the submission, and only what is not up to date."""
from __future__ import annotations

import json
import os
import re
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pypdf import PdfReader

from invented import COARSE, altered
from ldbench import Case, Error, Warning, _core, run
from ldbench._core.kept import is_up_to_date, program_digest, write_stamp
from ldbench.report import abstract, formulations, submission, trusted
from ldbench.report.jobs import case_job, run_stale
from ldbench.report.submission import make_report
from ldbench.results.answers import answers
from ldbench.results.run_data import read_data
from ldbench.results.summary import shown, summary_row
from ldbench.results.twins import Spread, spreads
from ldbench.runs import compute
from ldbench.table import ContactTable
from ldbench.trust import Trust
from running import CASES, REPO, kept_tables
from specimen import World

SENT = {"ldbench_plots.pdf", "ldbench_extras.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html"}
KEPT = {"formulations.json", "trust.json"}
LONG_AGO = 10**9      # [s]


def twins(*names: str) -> set[str]:
    """Names of the files that keep the answers of twins."""
    return {f"{name}_twins.json" for name in names}


def test_products_are_there_and_nothing_else(world: World):
    sent = {"ex2_aw.txt", "ex5_aw.txt", *SENT}
    assert {file.name for file in world.outputs.iterdir() } == {*sent, ".ldbench"}
    kept = {file.name for file in (world.outputs/".ldbench").iterdir()}
    known = KEPT | twins("ex2_aw", "ex5_aw")
    assert kept == known | {f"{name}.stamp" for name in sent | known}


def remake() -> set[str]:
    """Report here, without trust, drawing and typesetting; the names of what was written."""
    for file in Path("outputs").rglob("*"):
        if file.is_file() and file.suffix != ".stamp":
            os.utime(file, (LONG_AGO, LONG_AGO))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trusted, "trust", lambda case, jobs: Trust(case.case_name, "", (), {}, {}, (), ()))
        patch.setattr(submission, "drawing", lambda *given: nullcontext(lambda target: target.write_text("plots")))
        patch.setattr(abstract, "make_abstract", lambda runs, target, *rest: target.write_text("abstract"))
        with pytest.warns(Warning, match=r"outputs/submission\.toml: the abstract names no authors"):
            make_report(Path("inputs"), Path("outputs"), jobs=2)
    return {file.name for file in Path("outputs").rglob("*") if file.is_file() and file.suffix not in (".stamp", ".table")
            and file.stat().st_mtime != LONG_AGO}


def test_up_to_date_is_skipped_and_change_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Exercise 3 to the first flange contact, twice with one pair of profiles."""
    monkeypatch.chdir(tmp_path)
    Path("inputs").mkdir()
    profiles = {f"{one}_profile": str(REPO/f"profiles/a{one[0]}prof.yz") for one in ("wheel", "rail")}
    for pair in ("aw", "sw"):
        case = Case.exercise(3, pair).replace(**COARSE | {"table_folder": "outputs/tables"}, **profiles, dt=1e-5, t_end=0.013)
        case.to_namelist(f"inputs/ex3_{pair}.nml")
    assert remake() == {"ex3_aw.txt", "ex3_sw.txt", *SENT, *KEPT, *twins("ex3_aw", "ex3_sw")}
    assert remake() == set()
    inputs = Path("inputs/ex3_sw.nml")
    Case.from_namelist(inputs).replace(vY=0.9).to_namelist(inputs)
    assert remake() == {"ex3_sw.txt", *SENT, *KEPT, *twins("ex3_sw")}
    columns = Path("outputs/ex3_aw.txt")
    columns.write_text(columns.read_text().replace("1.0", "1.1", 1))
    assert remake() == {"ex3_aw.txt"}      # the same columns again: the rest still holds


def test_abstract_of_ten_runs(world: World, tmp_path: Path):
    """Four pages with all authors, columns and figures; however narrow the columns of ten runs are, each number is one line; a
    run whose derailment its twins do not share tells median and range."""
    alike = {}          # the specimen as if both sides were alike, as they are in the submission
    for raw in world.thrown, world.pushed:
        file = tmp_path/"runs"/raw.file.name
        file.parent.mkdir(exist_ok=True)
        file.write_text(re.sub(r"_profile_right = '.*?'", "_profile_right = ''", raw.text))
        alike[raw.file.stem] = read_data(file)
    last = alike["ex5_aw"]
    alike["ex5_aw"] = altered(last, results={"t_derailment": 2.987654, "F_derailment": 271234.0})
    ten = {name: "ex5_aw" if name[2] == "5" else "ex2_aw" for name in CASES}
    runs = [altered(alike[source], name=name) for name, source in ten.items()]
    kept = outcomes(world)
    found = [replace(one, case=name, profiles=last.pair) for name in CASES for one in kept if one.case == ten[name]]
    target = tmp_path/"abstract.pdf"
    written = [{"name": "A. Author", "affiliation": "First Institute"}, {"name": "B. Author", "affiliation": "Second Institute"}]
    abstract.make_abstract(runs, target, found, {"ex5_sw": {
        "t_derailment": Spread(2.976, 2.961, 3.012, 9, 9), "F_derailment": Spread(270.13e3, 268.32e3, 271.31e3, 9, 9)}}, written)
    pages = [page.extract_text() for page in PdfReader(target).pages]
    words = " ".join(" ".join(pages).split())
    assert len(pages) == 4 and all(name in words for name in CASES) and "A. Author" in words and "Second Institute" in words
    assert "271.2 kN after 2.99 s" in words and words.count("271.2") == 2 and "~" not in words
    assert "270.1 (268.3 to 271.3) kN after 2.98 (2.96 to 3.01) s" in words and "268.3–271.3" in words and "2.96–3.01" in words
    assert all(f"Figure {k}" in words and f"Table {k}" in words for k in (1, 2, 3, 4))
    assert set(tmp_path.iterdir()) == {target, tmp_path/"runs"}
    row = next(line for page in pages for line in page.splitlines() if line.startswith("energy drift, relative"))
    drifts = " ".join(abstract.scientific(summary_row(run)["drift_relative"]) for run in runs)
    plain = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789")       # the text of a PDF may have a raised 1 as any other
    assert row.removeprefix("energy drift, relative").translate(plain).split() == drifts.translate(plain).split()


def test_errors_of_tables_stand_with_their_pair(world: World, tmp_path: Path):
    """The largest of a pair's runs, at each place; another pair's are other ones."""
    runs = []
    for k, (name, pair, largest) in enumerate((("ex1_aw", "a", 2e-3), ("ex2_aw", "a", 3e-3), ("ex2_sw", "s", 5e-3))):
        text = re.sub(r"_profile_right = '.*?'", "_profile_right = ''", world.thrown.text)
        text = re.sub(r"(?<=/)a([wr])prof(?=\.yz)", rf"{pair}\1prof", text)
        text = re.sub(r"table_error_tread = \S+ \S+", f"table_error_tread = {(k + 1)*1e-4}, {largest}", text)
        file = tmp_path/f"{name}.txt"
        file.write_text(text)
        runs.append(read_data(file).named(name))
    actual, simplified = abstract.facts(runs, {})["errors"]
    assert (actual[:2], simplified[:2]) == (["actual profiles", "0.020 % (0.30 %)"], ["simplified profiles", "0.030 % (0.50 %)"])


def test_authors_come_from_the_description(tmp_path: Path):
    """They are those of the file that is sent; its other keys are the business of `submit`."""
    file = tmp_path/"submission.toml"
    assert abstract.read_authors(file) == []
    file.write_text('code = "One"\nauthors = ["A. Author", " B "]\norganisation = "Institute, Town"\n')
    assert abstract.read_authors(file) == [{"name": name, "affiliation": "Institute, Town"} for name in ("A. Author", "B")]
    file.write_text('authors = ["A. Author"]\n')
    assert abstract.read_authors(file) == [{"name": "A. Author", "affiliation": ""}]
    for text, place in (('authors = "A. Author"', "authors"), ("authors = [3]", "authors"), ('authors = [" "]', "authors"),
                        ('authors = ["A"]\norganisation = ["B"]', "organisation")):
        file.write_text(text)
        with pytest.raises(Error) as error:
            abstract.read_authors(file)
        assert str(error.value).startswith(f"{file}, {place}: expected ")


def test_what_bodies_change():
    """The least and the largest change of an answer over the runs with bodies; none of an answer that the twins do not share."""
    peaks, impulses, returns = (200e3, 200e3, 190e3, 150e3, 900e3), (1e3, 1e3, 1.02e3, 1.01e3, 5.0), (0.5, 0.6, 0.4, 0.3, 9.0)
    kinds = ("twin", "a"), ("bodies", "b"), ("bodies", "c"), ("law", "d")
    one = Trust("ex2_aw", "", kinds, {"first_peak_N_LF": peaks, "first_impulse_LF": impulses, "t_return": returns,
                                      "F_limit_left": (1e5, 1e5, 1.1e5, 1.1e5, 1.0)}, {}, (), ())
    other = replace(one, case="ex3_aw", values={"first_peak_N_LF": (100e3, 100e3, 101e3, 99e3, 7.0)})
    without = replace(one, case="ex5_aw", variations=(("twin", "a"),), values={"first_peak_N_LF": (1.0, 1.0)})
    found = abstract.bodies_facts([one, other, without])
    assert found["names"] == ["ex2_aw", "ex3_aw"]
    rows = {words: cells for words, *cells in found["rows"]}
    assert rows["peak N, first contact, left flange"] == ["−25 to −5.0", "−1.0 to +1.0"]
    assert rows["impulse, first contact, left flange"] == ["+1.0 to +2.0", "–"]
    assert rows["return to the centre"] == ["–", "–"]
    assert found["over_all"] == {
        "first_peak_N_LF": "−25 to +1.0", "first_impulse_LF": "+1.0 to +2.0", "F_limit_left": "+10"}
    assert abstract.bodies_facts([without]) is None


def test_a_change_of_the_program_makes_its_products_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Any file counts: scripts of the page, modules, the compiled core. What Python keeps of its own does not."""
    package, product = tmp_path/"package", tmp_path/"page.html"
    names = "viewer/__pycache__/page.pyc", "viewer/static/scene.js", "viewer/page.py", "_core/_flat.so", "results/columns.py"
    for name in names:
        (package/name).parent.mkdir(parents=True, exist_ok=True)
        (package/name).write_text("before")
    monkeypatch.setattr(_core.kept, "program_digest", lambda: program_digest.__wrapped__(package))
    product.write_text("page")
    for name in names:
        write_stamp(product, {})
        (package/name).write_text("after")
        assert is_up_to_date(product, {}) == name.endswith(".pyc")


def outcomes(world: World) -> list[formulations.Outcome]:
    return [formulations.Outcome(**one) for one in json.loads((world.outputs/".ldbench/formulations.json").read_text())]


def test_values_of_formulations_stand_under_their_pair(world: World):
    """Each value in the row of its result and in the column of its pair and formulation."""
    both = [replace(one, case=name) for name in ("ex2_aw", "ex2_sw") for one in outcomes(world) if one.exercise == 2]
    found = [replace(one, results={**one.results, "farthest_left": 1e-3*(k + 1)}) for k, one in enumerate(both)]
    texts = formulations.values_page(found).axes[0].texts
    row = next(text.get_position()[1] for text in texts if text.get_text() == "largest Y [mm]")
    cells = sorted((text.get_position()[0], text.get_text()) for text in texts if text.get_position()[1] == row)
    assert [words for _, words in cells] == ["largest Y [mm]", *(f"{k + 1:#.4g}" for k in range(10))]
    heads = [text for text in texts if text.get_text() in ("elastic", "bilateral", "e = 1", "e = 0.5", "e = 0")]
    assert [text.get_text() for text in heads] == 2*["elastic", "bilateral", "e = 1", "e = 0.5", "e = 0"]
    assert [text.get_position()[0] for text in heads] == [x for x, _ in cells[1:]]


def test_answers_that_twins_do_not_share_are_chaotic(world: World, tmp_path: Path):
    """Numbers, counts, and what happens to some; exactness, texts and the start itself do not count."""
    row = {"case": "ex1_aw", "t_return": 0.1, "peak_N_LF": 100e3, "t_first_LF": 0.02, "farthest_right": 0.0, "t_derailment": None,
           "n_left_flange_contact": 1, "drift": 1e-9, "F_derailment": np.nan, "pmax_contact": "LF"}
    twins = [row | {"t_return": 0.1003, "peak_N_LF": 100.05e3, "farthest_right": -3e-6, "drift": 5e-9, "pmax_contact": "RF"},
             row | {"t_return": 0.1002, "t_derailment": 3.0, "n_left_flange_contact": 2}]
    found = spreads(row, twins)
    assert found == {"t_return": (0.1002, 0.1, 0.1003, 3, 3), "t_derailment": (3.0, 3.0, 3.0, 1, 3),
                     "n_left_flange_contact": (1.0, 1.0, 2.0, 3, 3)}
    assert spreads(row, [row, row]) == {} and spreads(row, []) == {}
    lines = [shown(row, name, {"ex1_aw": found}).line for name in ("t_return", "t_derailment", "n_left_flange_contact", "drift")]
    assert lines == ["0.10020 (0.10000 to 0.10030)", "3.000 (3.000 to 3.000, 1 of 3)", "1 (1 to 2)", "10⁻⁹"]
    runs = [world.run("ex3_aw"), world.run("ex2_aw")]
    rows = [summary_row(run) for run in runs]
    back = rows[1]["t_return"]
    submission.write_summary(runs, tmp_path/"summary.csv", {
        "ex3_aw": [rows[0], rows[0]], "ex2_aw": [rows[1] | {"t_return": back + 0.01}, rows[1] | {"t_return": None}]})
    table = pd.read_csv(tmp_path/"summary.csv").set_index(["case", "of"])
    assert table.index.tolist() == [(name, of) for name in ("ex3_aw", "ex2_aw")
                                    for of in ("run", "median", "least", "largest", "having")]
    assert table.loc["ex2_aw", "t_return [s]"].tolist() == pytest.approx([back, back + 0.005, back, back + 0.01, 2])
    assert table.loc["ex3_aw", "t_first_LF [s]"].tolist() == pytest.approx([*[rows[0]["t_first_LF"]]*4, 3])
    assert set(table.exercise) == {2, 3} and table.loc[("ex2_aw", "run"), "end"] == rows[1]["end"]


def test_twins_of_a_changed_case_alone_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The answers of eight starts aside, in their order, are those of runs from there; they are kept by the case."""
    cases = [Case.exercise(3, "aw").replace(**COARSE | {"table_folder": kept_tables()}, dt=1e-5, t_end=t,
                                              stop_at="t_end", name=name) for name, t in (("ex3_aw", 0.013), ("ex4_aw", 0.012))]
    jobs = [case_job(case, tmp_path) for case in cases]
    run_stale(jobs, 1)
    found = submission.kept_twins(jobs, 2)
    asides = 1e-9, -1e-9, 1.5e-8, -1.5e-8, 2e-7, -2e-7, 3e-6, -3e-6
    table = ContactTable(cases[0])
    own = [summary_row(compute(cases[0].replace(initial_Y=aside), table=table))["t_first_LF"] for aside in asides]
    assert [row["t_first_LF"] for row in found["ex3_aw"]] == own and len(set(own)) == 8
    started: list[str] = []
    monkeypatch.setattr(submission, "compute", lambda case, *rest: started.append(case.case_name) or compute(case, *rest))
    assert submission.kept_twins(jobs, 2) == found and started == []
    changed = [jobs[0], case_job(cases[1].replace(vY=0.99), tmp_path)]
    run_stale(changed, 2)
    assert submission.kept_twins(changed, 2)["ex3_aw"] == found["ex3_aw"] and started == ["ex4_aw"]*8


def test_a_ramp_is_computed_again_and_derails_at_one_load(tmp_path: Path):
    """Computed again from a row on, the motion is that of the run for some hundredths of a second. Also without a report, the
    formulations have the load of the column file."""
    case = Case.exercise(5, "aw").replace(**COARSE | {"table_folder": kept_tables()}, accuracy=0.1, lateral_ramp=4e5,
                                          interval=1e-3, dt=1e-5)
    job = case_job(case.replace(t_end=0.15, stop_at="t_end"), tmp_path)
    run_stale([job], 1)
    whole = read_data(job.product)
    first, hardest = submission.first_and_hardest(whole)
    assert hardest.start < answers(whole)["t_peak_LF"] < hardest.start + hardest.run.time[-1]
    assert first.start < answers(whole)["t_first_LF"] < first.start + first.run.time[-1]
    for stretch in (first, hardest):
        assert np.diff(stretch.run.time).max() < 2.1e-5 and stretch.start in whole.time
        rows = (whole.time >= stretch.start) & (whole.time <= stretch.start + stretch.run.time[-1])
        for column, apart in ("Y", 1e-7), ("Z", 1e-7), ("roll", 1e-7), ("F_ext", 1.0):
            again = np.interp(whole.time[rows] - stretch.start, stretch.run.time, stretch.run.values(column))
            np.testing.assert_allclose(again, whole.values(column)[rows], atol=apart)
    steep = case.replace(lateral_ramp=4e6)
    (tmp_path/"inputs").mkdir()
    steep.to_namelist(tmp_path/"inputs/ex5_aw.nml")
    found = formulations.outcomes(tmp_path/"inputs", 2)[0]
    assert (found.formulation, found.ending.partition(" over")[0]) == ("elastic", "derails")
    assert found.results["F_derailment"] == pytest.approx(run(steep).first("derailment").force, abs=1)
