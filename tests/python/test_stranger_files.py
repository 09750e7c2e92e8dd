"""Column files by somebody who has not read the code that reads and judges them: all that is written in odd form is read right, and
what is wrong is told, by name and where it is.

Forms and faults are put together by hypothesis, so that combinations are tried that nobody wrote down. `make fuzz` tries more.
"""
from __future__ import annotations

import functools
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, strategies as st

import stranger_faults as faulty
import stranger_files as files
from generated import covering, examples
from invented import invented_run
from ldbench import Case, Error, read_columns, run
from ldbench.__main__ import main
from ldbench.results import answers
from ldbench.results.columns import RawTable, read_raw
from ldbench.results.header import Comments
from ldbench_round import check, own_runs
from ldbench_round.column_names import meanings, understood
from ldbench_round.findings import DOUBTFUL, FAILED, PASSED, Finding, apart_text
from ldbench_round.languages import encoding_of
from ldbench_round.physics_checks import law_findings
from ldbench_round.submissions import find_files
from ldbench_round.tasks import QUANTITIES, Task
from running import kept_tables
from stranger_files import ALL, CALL, ENERGY, NAMES, Frame, both, each, of, plus, text_of, times

TASK = Task(2, "aw")
# Names of energies that mean nothing to the program.
UNTOLD = {"letters and numbers", "two digits", "capitals", "Simpack", "Nucars", "Gensys", "Matlab", "finite elements"}


@functools.cache
def thrown(**changes: Any) -> Frame:
    """Our columns of exercise 2, by Hertz's law."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")     # of an input that is not as it should be
        return run(Case.exercise(2, "aw").replace(**{"model": "hertz", "table_folder": kept_tables(), **changes})).data


@pytest.fixture(scope="module", autouse=True)
def own() -> Iterator[None]:
    """Our own run, by which maps are guessed, has the columns of the call alone; profiles are placed once."""
    frame = thrown()[list(CALL)].copy()
    frame.attrs = {"units": {column: thrown().attrs["units"][column] for column in CALL}}
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(own_runs._OWN, TASK, invented_run(frame))
        patch.setattr(answers, "placed_outlines", functools.cache(answers.placed_outlines))
        yield


def told(frame: Frame) -> list[Finding]:
    """What is not passed in a file with these columns, which is not written; the refusal of a file is a finding, too."""
    columns = [column for column in ALL if column in frame]
    raw = RawTable([files.PLAIN[column] for column in columns], [files.unit_of(column, files.SI)[0] for column in columns],
                   frame[columns].to_numpy(float))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(check, "read_raw", lambda *_: raw)
        patch.setattr(check, "encoding_of", lambda *_: "utf-8")
        patch.setattr(check, "read_comments", lambda *_: Comments())
        try:
            one = check.read_submitted(Path("ex2_aw.csv"))
        except Error as error:
            return [Finding("refused", FAILED, hint=str(error))]
    one.run.data.attrs.pop("units")     # which pandas copies with every column
    found = check.findings_of(one)
    assert all(np.isfinite(finding.time) for finding in found if finding.row is not None)
    return [finding for finding in found if finding.verdict in (DOUBTFUL, FAILED)]


# ---- forms ---------------------------------------------------------------------------
@examples(1)
@given(covering(files.LAYERS))
def test_a_file_in_any_form_is_read_right(tmp_path: Path, forms: list[dict[str, str]]):
    """All numbers are those that were written, by a code with softer contacts, and nothing is told of the map."""
    frame = thrown(stiffness_scale=0.8).iloc[::5].reset_index(drop=True)
    for options in forms:
        name, data = files.written(frame, options)
        (tmp_path/name).write_bytes(data)
        (task, file), = find_files(tmp_path, []).items()
        one = check.read_submitted(file)
        file.unlink()
        found = one.run.data.iloc[::2 if options["lines"] == "rows twice" else 1]
        assert (task, len(found)) == (TASK, len(frame)), options
        expected = CALL if options["orders"] in ("no energies", "sums") else ALL
        assert {*found} >= {*(expected if options["names"] not in UNTOLD else CALL)}, (options, {*expected} - {*found})
        for column in {*expected} & {*found}:
            x, y = found[column].to_numpy(), frame[column].to_numpy()
            assert np.array_equal(np.isnan(x), np.isnan(y)), (column, options)
            # Heights of contacts have a free zero: that of our own run is taken.
            off = np.nanmedian(y - x) if column[:2] == "z_" else 0.0
            assert np.nanmax(np.abs(x + off - y)) < 1e-5*np.nanmax(np.abs(y)), (column, options)
        assert [finding for finding in check.map_findings(one.guess) if finding.verdict != PASSED] == [], options
        words = found.attrs.get("words", ())
        mark = files.MISSING[options["missing"]]["na"]
        assert {word.word for word in words} <= {mark}, options


ROWS: dict[str, tuple[files.Change, set[str]]] = {
    "all": (lambda f: f, set()), "at 10 kHz": (faulty.at_intervals(1e-4), set()), "at events twice": (faulty.events_twice, set()),
    "dense at impacts": (faulty.dense_at_impacts, set()), "times to a µs": (each(["time"], lambda t: t.round(6)), set()),
    "start three times": (lambda f: pd.concat([f.iloc[[0, 0]], f], ignore_index=True), set()),
    "times to a ms": (each(["time"], lambda t: t.round(3)), {"digits of the times"}),
    "times to a ms between events": (faulty.coarse_between_events, {"digits of the times"}),
    "times half as dense": (each(["time"], lambda t: (t*5e3).round()/5e3), {"digits of the times"})}
FRAMES: dict[str, tuple[files.Change, set[str]]] = {
    "to the right": (times(-1.0, *files.RIGHT, *of("Fy")), {"lateral axis"}),
    "down": (times(-1.0, *files.DOWN, *of("Fz")), {"vertical axis"}),
    "rolled": (times(-1.0, *files.ROLL), {"roll axis"}), "from 10 s": (plus(10.0, "time"), {"zero of time"}),
    "from -100 ms": (plus(-0.1, "time"), {"zero of time"}), "on the rail": (times(-1.0, *of("Fy", "Fz")), set()),
    "signed angles": (times(-1.0, "angle_RT", "angle_RF"), set()), "from the axle": (plus(-0.457, *of("z")), set()),
    "from the rails": (plus(0.457, "Z"), set()), "energies from the rails": (plus(1e5, "PE_grav", "PE_load"), set()),
    "from the gauge side": (both(plus(-1.4351/2, "y_LT", "y_LF"), plus(1.4351/2, "y_RT", "y_RF")), set()),
    "last places": (each(of(*files.PLACES), lambda x: x.ffill().fillna(0.0)), set()),
    "zero places": (each(of(*files.PLACES), lambda x: x.fillna(0.0)), set()),
    "huge places": (each(of(*files.PLACES), lambda x: x.fillna(1e30)), set())}


@examples(1)
@given(covering({"rows": ROWS, "frame": FRAMES, "other": FRAMES}))
def test_another_frame_is_told_and_nothing_else(choices: list[dict[str, str]]):
    """Signs, zeros and coarse times; the laws of physics hold in all of them."""
    for choice in choices:
        (rows, doubt), *frames = ROWS[choice["rows"]], *(FRAMES[name] for name in sorted({choice["frame"], choice["other"]}))
        changed = both(rows, *(change for change, _ in frames))(thrown())
        expected = doubt.union(*(words for _, words in frames))
        assert expected <= {one.what for one in told(changed)} <= expected | ({"Y does not drift"} if doubt else set()), choice


# ---- faults --------------------------------------------------------------------------
def check_told(**faults: faulty.Fault) -> None:
    """All faults of a file are told, each as wrong or as doubtful as it is."""
    found = told(both(*(change for change, _ in faults.values()))(thrown()))
    assert all("\n" not in one.hint for one in found)
    for name, (_, words) in faults.items():
        named = {one.verdict for one in found if re.search(words, f"{one.what}: {one.hint}")}
        expected = {FAILED} if name in {*faulty.PLACES_WRONG, *faulty.REST_WRONG} - faulty.MILD else {DOUBTFUL, FAILED}
        assert named & expected, (list(faults), name, [one.what for one in found])


@examples(1)
@given(covering({"places": faulty.PLACES_WRONG, "rest": faulty.REST_WRONG}))
def test_faults_with_a_name_are_told(pairs: list[dict[str, str]]):
    """Two faults in one file do not hide each other."""
    for pair in pairs:
        place = {} if pair["rest"] in faulty.ALONE else {pair["places"]: faulty.PLACES_WRONG[pair["places"]]}
        check_told(**place, **{pair["rest"]: faulty.REST_WRONG[pair["rest"]]})


@examples(16)
@given(st.sampled_from(faulty.GENERATED))
def test_a_fault_in_one_column_is_told(fault: tuple[str, str]):
    check_told(**{" ".join(fault): faulty.generated(*fault)})


@examples(2)
@given(st.sampled_from(sorted(faulty.OTHER_INPUT)))
def test_other_input_is_told(name: str):
    changes, words = faulty.OTHER_INPUT[name]
    found = told(thrown(table_folder="", **changes))
    assert re.search(words, " | ".join(one.what for one in found if one.verdict == FAILED)), [one.what for one in found]


def test_laws_of_a_ramp():
    """A ramp steeper than that of exercise 5 is over sooner. Another one, and energies that are not told, break its laws."""
    case = Case.exercise(5, "aw").replace(
        model="hertz", table_folder=kept_tables(), lateral_ramp=1.2e5, interval=2.5e-4, t_end=3.0)
    frame = run(case).data

    def wrong(frame: Frame, **changes: float) -> set[str]:
        found = law_findings(invented_run(frame), case.replace(**changes), Task(5, "aw"))
        return {one.what for one in found if one.verdict == FAILED}

    assert wrong(frame) == set()
    assert wrong(frame, lateral_ramp=1e5) >= {"lateral momentum closes", "energy closes"}
    assert wrong(times(0.0, *ENERGY[-2:])(frame)) == {"contacts give back what they have stored"}
    assert wrong(frame[frame["time"] < 1.0]) == {"up to derailment"}


def test_columns_that_are_no_longer_what_they_are_called(tmp_path: Path):
    """Faults of the text: a name that is missing, one that stands twice, forces that do not fit into their cells."""
    file, text = tmp_path/"ex2_aw.csv", text_of(thrown(), units=files.MM_KN)
    for wrong, words in (
            (text.replace("vertical velocity [m/s],", "").replace("\n", ",spare [m]\n", 1), "quantities|velocity|axis"),
            (text_of(thrown(), {**files.PLAIN, "N_RF": files.PLAIN["N_LF"]}), "normal force, right flange"),
            (text_of(thrown(), decimal=","), "refused"), (text_of(thrown(), digits="%.3g"), "digits|momentum|rate"),
            (text_of(thrown(), order=[column for column in ALL if "elastic" not in column]), "elastic energy .* is missing"),
            (re.sub(r"(?<=,)-?[3-9]\d{2}\.\d+", "********", text), "cells without a number: .*N_LF")):
        file.write_text(wrong)
        try:
            found = [f"{one.what}: {one.hint}" for one in check.check_file(file).findings if one.verdict == FAILED]
        except Error as error:
            found = [f"refused: {error}"]
        assert re.search(words, " | ".join(found)), (words, found)


# ---- cells and rows ------------------------------------------------------------------
def text_with(cells: str) -> str:
    return "time,Y,N_LF\n0,1,2\n" + cells + "0.3,4,5\n"


@examples(16)
@given(st.sampled_from(sorted(files.MISSING.keys() - {"nothing", "NaN", "-999", "1e30"})), st.integers(0, 2), st.integers(1, 2))
def test_a_word_for_no_number_is_counted_and_placed(tmp_path: Path, word: str, row: int, column: int):
    cells = [["0.1", "1", "3"], ["0.15", "2", "4"], ["0.2", "3", "4"]]
    cells[row][column] = word
    cells[2][2] = word
    file = tmp_path/"a.csv"
    file.write_text(text_with("".join(",".join(line) + "\n" for line in cells)), encoding="utf-8")
    raw = read_raw(file)
    count = sum(line.count(word) for line in cells)
    assert np.isnan(raw.numbers).sum() == count and raw.numbers.shape == (5, 3)
    assert raw.words == ((word, count, row + 3, column + 1),) == read_columns(file).attrs["words"]


def test_a_first_cell_without_a_number_is_no_comment(tmp_path: Path):
    file = tmp_path/"a.csv"
    file.write_text(text_with("#N/A,1,3\n****,3,4\n# 1,2,3 of old\n"), encoding="utf-8")
    assert read_raw(file).numbers[:, 1].tolist() == [1, 1, 3, 4]


@examples(12)
@given(st.sampled_from(["0.2,3", "0.2,3,x", "some words between", "0.2,3,4,5", "0.2 3 4", "0.2;3;4"]), st.integers(0, 30))
def test_a_row_that_is_none_is_refused(tmp_path: Path, line: str, row: int):
    file, rows = tmp_path/"a.csv", [f"{k},1,2" for k in range(30)]
    file.write_text("\n".join(["time,Y,N_LF", *rows[:row], line, *rows[row:], "31,4,5"]) + "\n")
    with pytest.raises(Error, match=f"line {row + 2}: expected 3 numbers" if row or line != "0.2,3" else "names of 2 columns"):
        read_raw(file)
    file.write_text("\n".join(["time,Y,N_LF", "0,1,2", *rows[:row], "0.4,5"]) + "\n")        # broke off
    with pytest.raises(Error, match=f"line {row + 3}: expected 3 numbers"):
        read_raw(file)


# ---- names, times, numbers -----------------------------------------------------------
@pytest.mark.parametrize("name", NAMES)
def test_names_are_understood(name: str, tmp_path: Path):
    """With their units, without a look at numbers; in the encodings of their countries, too."""
    unnamed = {"dotted wheelset": "radius_..", "symbols": "radius_..", "Gensys": "Y|Z|roll"}.get(name, "$.")
    units = {column: files.unit_of(column, files.SI)[0] for column in QUANTITIES}
    found = {column: meanings(NAMES[name][column], units[column]) for column in QUANTITIES if not re.fullmatch(unnamed, column)}
    either = {column for column in found if name == "two digits" and column[-2:] in ("LF", "RT")}
    if name in files.COUNTRY:
        text = ";".join(NAMES[name].values()) + "\n1;2\n"
        (tmp_path/"a.csv").write_bytes(text.encode(files.COUNTRY[name]))
        assert text.encode(files.COUNTRY[name]).decode(encoding_of(tmp_path/"a.csv", understood)) == text
        found = {column: meanings(NAMES[name][column]) for column in QUANTITIES}
    assert [column for column in found if column not in found[column]] == []
    exact = {column for column in found if found[column] == {column}}
    assert found.keys() - exact <= either | ({"roll_acc"} if name == "letters and numbers" else set())


@pytest.mark.parametrize(("head", "names", "units"), [
    (";time [s];Y [mm]", ["", "time", "Y"], ["", "s", "mm"]), ("\ttime\tY\n\ts\tmm", ["", "time", "Y"], ["", "s", "mm"]),
    ("#;time;Y;N_LF", ["time", "Y", "N_LF"], ["", "", ""]), ("\ttime\tY\tN_LF", ["time", "Y", "N_LF"], ["", "", ""]),
    ("time,Lateral Force (track) [N],Y [(mm)]", ["time", "Lateral Force (track)", "Y"], ["", "N", "mm"]),
    ("time;spin;PE_grav\ns;1/m;kJ", ["time", "spin", "PE_grav"], ["s", "", "kJ"]),
    ("time..ms.,aY..ft.s.2.,vY..m.s.1.", ["time", "aY", "vY"], ["ms", "ft/s2", "m/s"]),
    ("aZ..m.s..2.,aY..m.s.s.,Lateral.Force..track...N.", ["aZ", "aY", "Lateral.Force..track"], ["m/s2", "m/s2", "N"])])
def test_names_and_units_of_a_head(tmp_path: Path, head: str, names: list[str], units: list[str]):
    """With an index that has no name, two brackets, a unit that nobody knows, and R's dots for all signs."""
    separator = next(mark for mark in ";\t," if mark in head)
    (tmp_path/"a.csv").write_text(f"{head}\n{separator.join('456')}\n")
    raw = read_raw(tmp_path/"a.csv")
    assert (raw.names, raw.units) == (names, units)


def test_what_is_missing_is_printed_with_its_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Words in cells that need no number are told, too, and do not fail."""
    file, frame = tmp_path/"ex2_aw.csv", thrown()
    file.write_text("sep=;\n" + text_of(frame, na="#N/A", **files.COMMAS))
    assert main(["check", str(file)]) == 0
    empty = int(frame[list(ALL)].isna().to_numpy().sum())
    told_words = rf"words for no number [\d·⁰-⁹.]+: '#N/A' {empty} times, first in line 3, column \d+\n"
    assert re.search(told_words, capsys.readouterr().out)
    file.write_text(text_of(frame.assign(vY=frame.vY.mask(frame.index == 40), aZ=frame.aZ.mask(frame.index == 41))))
    assert main(["check", str(file)]) == 1
    said = capsys.readouterr().out
    assert f"failed: numbers 1 (limit 0), row 41 at {frame.time[40]:.6g} s: cells without a number: 1 of vY" in said
    assert f"doubtful: numbers of accelerations 1 (limit 0), row 42 at {frame.time[41]:.6g} s" in said


def test_times_that_fall_by_more_than_their_rounding_are_refused(tmp_path: Path):
    file, frame = tmp_path/"ex2_aw.csv", thrown()
    coarse = frame.assign(time=frame.time.round(3))
    file.write_text(text_of(coarse))
    read = check.read_submitted(file).run
    assert (np.diff(read.time) > 0).all() and np.abs(read.time - frame.time).max() < 1e-3
    coarse.loc[500, "time"] -= 0.0021
    file.write_text(text_of(coarse))
    with pytest.raises(Error, match=r"found 'time', which falls 1 time, first from .* in row 501"):
        check.read_submitted(file)


def test_a_drift_below_what_is_told_passes_and_a_slow_velocity_is_none():
    """A velocity half a row late, as that of a half-step scheme, is no drift."""
    frame = thrown()
    assert told(faulty.drift(2e-5, "Y")(frame)) == [] and told(frame.assign(Y=frame.Y - 5e-6*(frame.vY - frame.vY.iloc[0]))) == []
    changed = faulty.drift(2e-4, "Y")(frame)
    (found,) = told(changed)
    assert (found.what, found.verdict) == ("Y does not drift", DOUBTFUL)
    assert found.number*np.ptp(changed.Y) == pytest.approx(2e-4, rel=0.15)
    assert found.time == pytest.approx(frame.time.iloc[-1], rel=0.01)


@pytest.mark.parametrize(("x", "limits", "words"), [
    (0.0204, [0.02], "0.0204"), (0.02004, [0.02], "0.02004"), (0.02, [0.02], "0.02"), (0.5, [0.02], "0.5"),
    (99.9999, [np.nextafter(100.0, 0.0)], "99.9999"), (float("nan"), [0.02], "–")])
def test_a_number_shows_on_which_side_of_its_limit_it_is(x: float, limits: list[float], words: str):
    assert apart_text(x, limits) == words
