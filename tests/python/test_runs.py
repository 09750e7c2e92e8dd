"""There is one Run: a run in memory and the same run read from its file are alike and serve for the same."""
from __future__ import annotations

import copy
import errno
import math
import multiprocessing
import pickle
import re
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
from invented import COARSE
from ldbench.constants import CONTACT_NAMES
from ldbench.profile import Profile
from ldbench.results.answers import answers
from ldbench.results.header import Header, read_groups
from ldbench.results.run_data import read_data
from ldbench.runs import compute
from running import alike, with_kept_table

# The wheelset of exercise 3 goes to the left flange and off it; every kind has other fields in its header.
KINDS: dict[str, dict[str, Any]] = {
    "elastic": {},
    "two sides": {"lateral_ramp": 5e5, "model": "strip", "wheel_profile_right": "profiles/swprof.yz",
                  "rail_profile_right": "profiles/srprof.yz"},
    "unilateral": {"formulation": "unilateral", "restitution": 0.5},
}
NINE_DIGITS = {"rtol": 5.1e-9, "atol": 1e-98, "equal_nan": True}


def small(**changes: Any) -> ldbench.Case:
    return with_kept_table(ldbench.Case.exercise(3).replace(
        **COARSE | {"dt": 2e-5, "t_end": 0.02, "energy_tolerance": 0.0, "error_tolerance": 0.0} | changes))


@pytest.fixture(scope="module", params=KINDS)
def both(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[ldbench.Run, ldbench.Run]:
    """Run a case and read its file: the run in memory, and the same run from the file."""
    memory = ldbench.run(small(**KINDS[request.param]))
    return memory, ldbench.read_run(memory.write(tmp_path_factory.mktemp("runs")/"columns.txt"))


@pytest.fixture(scope="module")
def elastic(tmp_path_factory: pytest.TempPathFactory) -> tuple[ldbench.Run, ldbench.Run]:
    """Make both of the elastic run alone."""
    memory = compute(small())
    return memory, ldbench.read_run(memory.write(tmp_path_factory.mktemp("elastic")/"columns.txt"))


OTHER_MAP = {"time": "t", "Y": {"column": "ylat", "factor": -1}, "N_LF": "nfl"}


@pytest.fixture
def other(elastic: tuple[ldbench.Run, ldbench.Run], tmp_path: Path) -> ldbench.Run:
    """Write the run as another code would, with three columns, Y to the right, mm and kN, and read it by a map."""
    lines = ["t [s], ylat [mm], nfl [kN]"]
    lines += [f"{t:.12g}, {-1e3*y:.12g}, {1e-3*n:.12g}" for t, y, n in elastic[0].data[["time", "Y", "N_LF"]].to_numpy()]
    (tmp_path/"theirs.csv").write_text("\n".join(lines) + "\n")
    return ldbench.read_run(tmp_path/"theirs.csv", OTHER_MAP)


def test_memory_and_file_tell_the_same(both: tuple[ldbench.Run, ldbench.Run], tmp_path: Path):
    memory, file = both
    assert alike(vars(memory.header), vars(file.header))
    assert alike(memory.results, file.results) and memory.ending == file.ending != ""
    assert alike(memory.events, file.events) and {event.kind for event in file.events} >= {"left flange contact"}
    assert memory.case == file.case and memory.file == Path(memory.case.output_file) != file.file
    assert list(memory.data) == list(file.data) and memory.data.attrs["units"] == file.data.attrs["units"]
    np.testing.assert_allclose(memory.data, file.data, **NINE_DIGITS)
    for name in "name", "heading", "exercise", "formulation", "ending":
        assert getattr(memory, name) == getattr(file, name) not in (None, ""), name
    assert answers(memory) == answers(file)
    for kind in "left flange contact", "centre passage", "derailment":
        assert alike(memory.first(kind), file.first(kind))
    assert memory.seconds > 0 and math.isnan(file.seconds)
    written = []
    for k, run in enumerate((memory, file)):
        columns = tmp_path/f"{k}.txt"
        assert run.write(columns) == str(columns)
        written.append(columns.read_bytes())
    assert set(written) == {file.file.read_bytes()}


def test_a_file_reruns_to_its_bytes(both: tuple[ldbench.Run, ldbench.Run], tmp_path: Path):
    memory, file = both
    again = ldbench.run(file.case)
    assert Path(again.write(tmp_path/"again.txt")).read_bytes() == file.file.read_bytes()
    assert without_work(again.text) == without_work(memory.text) == without_work(file.text)
    assert file.table.equilibrium == memory.table.equilibrium


def without_work(summary: str) -> list[str]:
    """A summary without what depends on what a table had solved before."""
    return [line for line in summary.splitlines() if not re.match("processor time|contact table: [0-9]", line)]


def test_a_file_of_a_run_is_written_whole_and_never_over_its_own(elastic: tuple[ldbench.Run, ldbench.Run], tmp_path: Path):
    file = elastic[1]
    before = file.file.read_bytes()
    for run in elastic:
        with pytest.raises(ldbench.Error):
            run.write(tmp_path/"missing/x.txt")
    for path in None, file.file:
        with pytest.raises(ldbench.Error) as error:
            file.write(path)
        assert error.value.file == str(file.file)
    assert file.file.read_bytes() == before and len(list(file.file.parent.iterdir())) == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize("saved", [
    lambda text: b"\xef\xbb\xbf" + text, lambda text: text.replace(b"\n", b"\r\n"),
    lambda text: re.sub(rb"(?<=\d)E(?=[-+]\d\d)", b"D", text), lambda text: text.replace(b" Y ", b" Y[m] ", 1)],
    ids=["mark of the order of bytes", "ends of lines", "D exponents", "a unit in brackets"])
def test_a_file_that_an_editor_has_saved_is_the_run(saved: Callable[[bytes], bytes], elastic: tuple[ldbench.Run, ldbench.Run],
                                                    tmp_path: Path):
    file = elastic[1]
    (tmp_path/"saved.txt").write_bytes(saved(file.file.read_bytes()))
    again = ldbench.read_run(tmp_path/"saved.txt")
    assert again.data.equals(file.data) and again.data.attrs == file.data.attrs
    assert alike(vars(again.header), vars(file.header)) and again.case == file.case


@pytest.mark.filterwarnings("error")
def test_a_damaged_file_of_ours_is_told(elastic: tuple[ldbench.Run, ldbench.Run], tmp_path: Path):
    text = elastic[1].file.read_text()
    lines = text.splitlines()
    first, *_, last = rows = [k for k, line in enumerate(lines) if k and not line.startswith("#")]
    comments = [line for line in lines[first:] if line.startswith("#")]
    cut, word = lines[rows[3]][:100], lines[rows[3]].replace("NaN", "nil")
    for kept, line, expected in (
            (lines[:first] + comments, None, "rows of numbers"),
            (lines[:rows[3]] + [cut] + lines[rows[4]:], rows[3] + 1, "56 numbers"),
            (lines[:rows[3]] + [word] + lines[rows[4]:], rows[3] + 1, "56 numbers"),
            ([lines[0].replace(" vY ", "  Y ")] + lines[1:], None, "one column Y"),
            (lines[:last + 1], None, "the group &results after the last row")):
        (tmp_path/"damaged").write_text("\n".join(kept) + "\n")
        with pytest.raises(ldbench.Error) as error:
            ldbench.read_run(tmp_path/"damaged")
        told = error.value
        assert (told.file, told.line) == (str(tmp_path/"damaged"), line) and told.expected.startswith(expected), told
    # Without entries of &results, or with a text for a number.
    (tmp_path/"lacking").write_text(re.sub(r"# +(t|rows|steps|step|drift|kinetic_energy) = .*\n", "", text))
    lacking = ldbench.read_run(tmp_path/"lacking")
    assert math.isnan(lacking.results["drift"]) and "Run('ex3_aw', " in repr(lacking) and "ended" in lacking._repr_html_()
    (tmp_path/"text").write_text(re.sub(r"( n_derailment| t) = .*\n", r"\1 = 'x'\n", text))
    with pytest.raises(ldbench.Error, match=r"text, header: expected a number for (t|n_derailment), found 'x'"):
        ldbench.read_run(tmp_path/"text")


def test_runs_go_to_processes_and_come_back(elastic: tuple[ldbench.Run, ldbench.Run], tmp_path: Path):
    file = elastic[1]
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        there = list(pool.map(copy.copy, elastic))
        written = [pool.submit(run.write, tmp_path/f"{k}.txt").result() for k, run in enumerate(elastic)]
        read = pool.submit(ldbench.read_run, file.file).result()
    for again, run in (read, file), *zip(there, elastic, strict=True):
        assert again.data.equals(run.data) and alike(again.results, run.results) and again.case == run.case
    assert {Path(path).read_bytes() for path in written} == {file.file.read_bytes()}


def test_xarray_has_columns_units_and_results(both: tuple[ldbench.Run, ldbench.Run]):
    pytest.importorskip("xarray")
    for run in both:
        found, units = run.to_xarray(), run.data.attrs["units"]
        assert {str(name) for name in found.variables if not str(name).startswith("event_")} == {*run.data, "contact"}
        for name in run.data:
            assert found[name].dims == ("time",) and np.array_equal(found[name], run.data[name], equal_nan=True)
            assert found[name].attrs == {"units": units[name] or "1"}
        assert found.event_time.values.tolist() == [event.t for event in run.events]
        assert found.event_kind.values.tolist() == [event.kind for event in run.events]
        struck = [sum(event.impulses.values()) for event in run.events]
        assert found.event_impulse.sum("contact").values == pytest.approx(struck) and found.event_impulse.units == "N.s"
        told = {name: value for name, value in run.results.items() if not (isinstance(value, float) and math.isnan(value))}
        assert found.attrs == {"case": run.name, "title": run.header.title, "end": run.ending, **told}


def test_another_code_s_file_has_columns_and_no_results(other: ldbench.Run, elastic: tuple[ldbench.Run, ldbench.Run]):
    memory = elastic[0]
    assert type(other) is ldbench.Run and other.name == "theirs" and list(other.data) == ["time", "Y", "N_LF"]
    assert other.data.attrs["units"] == {"time": "s", "Y": "m", "N_LF": "N"}
    np.testing.assert_allclose(other.values("Y"), memory.values("Y"), rtol=1e-11)
    assert other.results == {} and other.events == [] and other.header == Header()
    assert (other.ending, other.success, other.formulation, other.law) == ("", False, "", "")
    assert (other.exercise, other.heading) == (None, "theirs") and math.isnan(other.seconds)
    with pytest.raises(KeyError, match=r"theirs\.csv: expected a result drift, found none"):
        other.results["drift"]
    force, t = (answers(other)[name] for name in ("peak_N_LF", "t_peak_LF"))
    k = int(memory.values("N_LF").argmax())
    assert (force, t) == pytest.approx((memory.values("N_LF")[k], memory.time[k]), rel=1e-9)
    assert answers(other)["peak_N_RF"] is None
    before, row = memory.time[np.flatnonzero(memory.closed("LF"))[0] + [-1, 0]]
    assert before < answers(other)["t_first_LF"] < row
    for question in ("case", "table", "text"):
        with pytest.raises(ldbench.Error) as error:
            getattr(other, question)
        assert error.value.file == str(other.file) and error.value.found == "none"
    assert repr(other).startswith("Run('theirs', ") and "theirs" in other._repr_html_()
    shown = other._repr_html_()
    known = {contact: words for contact, words in CONTACT_NAMES.items() if f"N_{contact}" in other.data}
    assert known
    for contact, words in known.items():       # the largest force and its time, in a row of the table
        force = other.values(f"N_{contact}")
        row = f'{1e-3*force.max():.3f} kN</td><td style="text-align: left">at {other.time[force.argmax()]:.6f} s'
        assert (f"largest normal force, {words}" in shown) == (row in shown) == (force.max() > 0), contact
    assert pickle.loads(pickle.dumps(other)).data.equals(other.data)


def missing(folder: Path) -> dict[str, Callable[[], object]]:
    (folder/"theirs.csv").write_text("t,y\n0,1\n1,2\n")
    case = small(t_end=1e-3)
    return {
        "namelist.nml": lambda: ldbench.Case.from_namelist(folder/"namelist.nml"),
        "run.nml": lambda: ldbench.run(folder/"run.nml"),
        "table.nml": lambda: ldbench.ContactTable(str(folder/"table.nml")),
        "columns.txt": lambda: ldbench.read_run(folder/"columns.txt"),
        "data.txt": lambda: read_data(folder/"data.txt"),
        "numbers.txt": lambda: ldbench.read_columns(folder/"numbers.txt"),
        "view.txt": lambda: ldbench.view(folder/"view.txt"),
        "map.toml": lambda: ldbench.read_run(folder/"theirs.csv", folder/"map.toml"),
        "wheel.yz": lambda: ldbench.run(case.replace(wheel_profile=folder/"wheel.yz")),
        "rail.yz": lambda: ldbench.ContactTable(case.replace(rail_profile=folder/"rail.yz")),
        "profile.yz": lambda: Profile(folder/"profile.yz"),
    }


def test_a_file_that_is_not_there_is_not_found(tmp_path: Path):
    for name, work in missing(tmp_path).items():
        with pytest.raises(FileNotFoundError) as error:
            work()
        assert isinstance(error.value, ldbench.Error) and error.value.errno == errno.ENOENT
        assert error.value.file == str(tmp_path/name)


def test_a_run_is_a_mapping_of_columns(elastic: tuple[ldbench.Run, ldbench.Run]):
    for run in elastic:
        assert len(run) == run.results["rows"] and list(run) == list(run.data) and "Y" in run and "y" not in run
        assert np.array_equal(run["vY"], run.data["vY"])
        assert run["N_RF"].max() == 0 and answers(run)["peak_N_RF"] is None, "no peak of a contact that never closes"


@pytest.mark.parametrize(("stop_at", "vY", "t_end", "ending", "success"), [
    ("t_end", 0.5, 1e-3, "t_end", True),
    ("t_end", 2.5, 0.3, "derailed, and then left what the contact table covers", False),
    ("return_to_centre", 0.5, 1.0, "return to the centre after both flanges", True),
    ("return_to_centre", 0.5, 1e-3, "t_end, return_to_centre not reached", False),
    ("derailment", 2.5, 0.3, "derailment", True), ("derailment", 0.5, 1e-3, "t_end, derailment not reached", False)])
def test_a_run_succeeds_where_it_ends_as_stop_at_asks(stop_at: str, vY: float, t_end: float, ending: str, success: bool):
    run = ldbench.run(ldbench.Case.exercise(4).replace(
        formulation="bilateral", interval=1e-4, dt=2e-5, table_folder="", stop_at=stop_at, vY=vY, t_end=t_end))
    assert (run.ending, run.success) == (ending, success)


def test_unknown_names_are_key_errors_with_the_nearest(elastic: tuple[ldbench.Run, ldbench.Run]):
    run = elastic[1]
    refused: dict[str, tuple[Callable[[], object], str]] = {
        "column": (lambda: run["N_Lf"], "N_LF"), "values": (lambda: run.values("rol"), "roll"),
        "contact": (lambda: run.closed("LFF"), "LF"), "intervals": (lambda: run.intervals("lf"), "LF"),
        "event": (lambda: run.first("derailments"), "derailment"), "result": (lambda: run.results["peak_N_Lf"], "peak_N_LF"),
        "case": (lambda: ldbench.Case(vYY=0.3), "vY"), "mapping": (lambda: ldbench.Case({"masss": 1.0}), "mass"),
        "ensemble": (lambda: ldbench.ensemble(run.case, {"mass": [1.5e3]}, columns=["NLF"]), "N_LF")}
    for what, (work, near) in refused.items():
        with pytest.raises(KeyError) as error:
            work()
        assert isinstance(error.value, ldbench.Error) and str(error.value).endswith(f"; {near} is the nearest"), what


def test_bad_arguments_are_value_or_type_errors(elastic: tuple[ldbench.Run, ldbench.Run]):
    case = elastic[0].case
    wrong: dict[type[Exception], list[Callable[[], object]]] = {
        ValueError: [lambda: ldbench.Case(dt=-1.0), lambda: case.replace(model="herz"), lambda: case.replace(max_halvings=5.5),
                     lambda: ldbench.ensemble(case, {"mass": []}), lambda: ldbench.ensemble(case, {"mass": [1e3]}, threads=0),
                     lambda: elastic[0].table.force(0.0, 0.4, 0.0, wheel="front")],
        TypeError: [lambda: ldbench.Case(dt="small"), lambda: ldbench.Case(title=3), lambda: ldbench.Case(vY=1.0, initial_vY=1.0),
                    lambda: ldbench.Case({"vY": 1.0}, vY=2.0), lambda: ldbench.Case([1.0]), lambda: ldbench.run({"vY": 0.3}),
                    lambda: ldbench.run(3), ldbench.view, lambda: ldbench.view([elastic[0]])]}
    for kind, calls in wrong.items():
        for call in calls:
            with pytest.raises(kind) as error:
                call()
            assert isinstance(error.value, ldbench.Error)
            assert type(pickle.loads(pickle.dumps(error.value))) is type(error.value)
    with pytest.raises(TypeError, match=r"found dict: Case\(values\) makes a case of a mapping of values"):
        ldbench.run({"vY": 0.3})


@pytest.mark.parametrize(("line", "values"), [
    ("  n = 3, 4  ! of it", {"n": [3, 4]}), ("word = 'it''s, so!'", {"word": "it's, so!"}), ("n=1", {"n": 1}),
    ("n = 1.5D-3,m = -2", {"n": 1.5e-3, "m": -2}), ("event(2)%t = 1.0, event(2)%kind = 'b', event(1)%t = 0.5",
                                                  {"event": [{"t": 0.5}, {"t": 1.0, "kind": "b"}]}),
    ("n = 1 2", None), ("n = 'open", None), ("n", None), ("= 3", None), ("n = 0.O1", {"n": "0.O1"}), ("n = 3*4", {"n": "3*4"})])
def test_lines_of_groups(line: str, values: dict[str, Any] | None, capfd: pytest.CaptureFixture[str]):
    """A line that is none of a group is told in the error and nowhere else."""
    if values is None:
        with pytest.raises(ldbench.Error) as error:
            read_groups(["&results", line, "/"])
        assert (error.value.expected, error.value.found) == ("name = value", repr(line))
    else:
        assert read_groups(["before", "&Results", line, "", "/", "after = 3"]) == {"results": values}
    assert capfd.readouterr() == ("", "")
