"""The Python package: cases, runs, the contact table, column files, the command line.

The executable is the reference: a run from Python must write the same bytes and say the same words.
"""
import base64
import copy
import itertools
import pickle
import re
import signal
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest

import ldbench
from invented import COARSE
from ldbench.__main__ import main
from ldbench.case import variables
from ldbench.results.header import read_comments
from running import HANG, LDBENCH, REPO, kept_tables


def coarse(exercise: int, pair: str, **changes: object) -> ldbench.Case:
    """A shipped case with a small table that is built in a moment."""
    return ldbench.Case.exercise(exercise, pair).replace(**COARSE | changes)


def to_flange(pair: str, **changes: object) -> ldbench.Case:
    """The wheelset thrown at the left flange: impact, wheel lift-off and landing within 30 ms."""
    return coarse(3, pair, t_end=0.03, dt=1e-5, **changes)


def endless(folder: Path, **changes: object) -> ldbench.Case:
    """Hours of integration, on whatever machine: a wheelset that rests on its rails."""
    return coarse(5, "aw", **{"lateral_ramp": 0.0, "t_end": 9e4, "dt": 1e-5, "interval": 1e-2,
                              "output_file": folder / "columns.txt"} | changes)


@pytest.fixture(scope="module")
def table() -> ldbench.ContactTable:
    return ldbench.ContactTable(coarse(1, "aw", model="strip"))


@pytest.fixture(scope="module")
def flange_run() -> ldbench.Run:
    return ldbench.run(to_flange("aw"))


def touching_poses(table: ldbench.ContactTable, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random poses with tread contact on both wheels, some with flange contact."""
    random = np.random.default_rng(5)
    y = random.uniform(-0.0105, 0.0105, n)
    return y, table.equilibrium + 0.068*y**2 - random.uniform(0, 5e-5, n), 0.0337*y


# Cases


def test_names_in_any_case_of_letters_and_with_their_group():
    case = ldbench.Case.exercise(3, "sw")
    assert case.vY == case.vy == case.initial_vY == 1.0
    assert case.output_file == "outputs/ex3_sw.txt" and case.initial_roll == 0 and case.table_roll == 0.5
    with pytest.raises(AttributeError, match="initial_roll or table_roll, found roll, which is ambiguous"):
        _ = case.roll
    with pytest.raises(AttributeError):
        case.dt = 1e-5
    assert not hasattr(case, "vy0")


def test_replace_makes_another_case():
    case = ldbench.Case.exercise(1)
    other = case.replace(VY=np.float64(0.3), max_halvings=np.int64(9), OUTPUT_FILE=Path("x.txt"))
    assert (other.vY, other.max_halvings, other.output_file) == (0.3, 9, "x.txt") and case.vY == 0.1 and case != other
    same = other.replace(vY=0.1, max_halvings=20.0, output_file=case.output_file)
    assert same == case and hash(same) == hash(case)


@pytest.mark.parametrize("name", ["ex1_aw", "ex5_sw"])
def test_namelists_go_round(name):
    case = ldbench.Case.from_namelist(REPO / "inputs" / f"{name}.nml")
    assert case == ldbench.Case.exercise(int(name[2]), name[4:]), "the shipped input"
    odd = case.replace(title="Pascal's wheelset", dt=case.dt*(1 - 2**-52), friction=1e-7/3)
    for original in case, odd:
        again = ldbench.Case.from_namelist(original.to_namelist())
        assert again == original and again.values == original.values
        groups = original.namelist()
        assert ldbench.Case.from_namelist(groups) == original and groups["initial"]["vY"] == original.vY
        assert {type(groups), *map(type, groups.values())} == {dict}
    assert pickle.loads(pickle.dumps(odd)) == odd


@pytest.mark.parametrize("title", ["'", '"', "it''s \"so\"", "a  'b'", "\xa0", "back\\slash", "車輪\u200b", "\udce9"], ids=ascii)
def test_texts_go_round(title, flange_run, tmp_path):
    """Through namelists, groups of values, and the header of a column file."""
    case = coarse(1, "aw", title=title, t_end=1e-3)
    case.to_namelist(tmp_path/"case.nml")
    for source in tmp_path/"case.nml", case.to_namelist(), case.namelist():
        assert ldbench.Case.from_namelist(source) == case
    assert eval(repr(case), {"Case": ldbench.Case}) == case
    file = Path(ldbench.run(case, table=flange_run.table).write(tmp_path/"columns.txt"))
    lines = file.read_bytes().decode(errors="surrogateescape").split("\n")
    settings = [line[1:].partition("  !")[0] for line in lines if line.startswith(("# &case", "#   title ="))]
    assert ldbench.Case.from_namelist("\n".join([*settings, "/"])).title == title
    if title.isprintable():
        assert read_comments(file).settings["case"]["title"] == title


START = {1: "initial lateral velocity 0.1 m/s", 2: "initial lateral velocity 0.5 m/s", 3: "initial lateral velocity 1 m/s",
         4: "initial lateral velocity 2 m/s", 5: "lateral force growing by 5 kN/s up to derailment"}


def test_a_title_that_nobody_wrote_is_made_from_the_values():
    """In the call's words for the ten exercises; `namelist` has what was written."""
    titles = [*((k, {}, words) for k, words in START.items()),
              (2, {"title": "its own"}, "its own"), (1, {"vY": 0}, "initial roll rate 0.00333 rad/s"),
              (5, {"lateral_ramp": 0}, "at rest"), (1, {"vY": 0, "roll_link": "rails"}, "at rest"),
              (5, {"lateral_force": -1e4, "lateral_ramp": 2e3, "stop_at": "t_end"},
               "lateral force -10 kN, lateral force growing by 2 kN/s"),
              (3, {"Y": -0.002, "Z": 1e-4, "initial_roll": 0.01, "vZ": 10},
               "initial lateral displacement -0.002 m, initial vertical displacement 1.0E-4 m, initial roll angle 0.01 rad, "
               "initial lateral velocity 1 m/s, initial vertical velocity 10 m/s")]
    pairs = [("aw", {}, "actual profiles"), ("sw", {}, "simplified profiles"),
             ("aw", {"wheel_profile": "a/own.yz"}, "own.yz on arprof.yz"),
             ("aw", {"rail_profile_right": "b.yz"}, "actual profiles (left), awprof.yz on b.yz (right)")]
    for exercise, changes, title in titles:
        for pair, profiles, words in pairs:
            case = ldbench.Case.exercise(exercise, pair).replace(**changes, **profiles)
            assert case.title == case.case_title == (title if title == "its own" else f"{title}, {words}")
            assert case.namelist()["case"]["title"] == changes.get("title", "")
            assert ldbench.Case.from_namelist(case.to_namelist()) == case


@pytest.mark.filterwarnings("ignore:&initial roll_rate. expected about")
def test_vY_can_set_the_roll_rate(table):
    """As rigid contacts do; so a slow wheelset does not start as if it were fast. The shipped cases keep the call's roll rate."""
    case = coarse(2, "aw", model="strip", vY=0.1, t_end=1e-3, stop_at="t_end")
    linked = case.replace(roll_link="rails")
    runs = [ldbench.run(case, table=table), ldbench.run(linked, table=table),
            ldbench.run(linked.replace(formulation="bilateral", roll_rate=0.0))]
    given, elastic, rigid = (run.data.roll_rate[0] for run in runs)
    assert given == 0.01667 and elastic == pytest.approx(rigid, rel=1e-7) == pytest.approx(0.1*0.03366, rel=1e-3)
    slow, fast = ldbench.ensemble(linked, {"vY": [0.1, 1.0]}, columns=["roll_rate"], tables=[table]).roll_rate.values[:, 0]
    assert fast == pytest.approx(10*slow, rel=1e-12)
    with pytest.raises(ldbench.Error, match="expected a wheelset that can stand on both rails, for roll_link = 'rails', found"):
        ldbench.run(linked.replace(Y=0.05, gauge=1.5, model="hertz"))


def test_a_changed_case_has_its_title_everywhere(tmp_path, capsys):
    """In the summary, the header and the page of a run with another velocity and a wheel of its own."""
    (tmp_path/"own.yz").write_bytes((REPO/"profiles/awprof.yz").read_bytes())
    (tmp_path/"case.nml").write_text(coarse(1, "aw", t_end=1e-3, wheel_profile=str(tmp_path/"own.yz")).to_namelist())
    title, file = "initial lateral velocity 0.3 m/s, own.yz on arprof.yz", tmp_path/"columns.txt"
    assert main(["run", str(tmp_path/"case.nml"), "--set", "vY=0.3", "-o", str(file)]) == 0
    run = ldbench.read_run(file)
    assert capsys.readouterr().out.startswith(f"ex1_aw: {title}\n") and f"# case ex1_aw: {title}\n" in file.read_text()
    facts = re.search('id="facts">(.*?)<', run.view().html)[1]
    assert f'"title":"{title}"' in zlib.decompress(base64.b64decode(facts)).decode()
    assert title in run._repr_html_() and title in run.case._repr_html_() and run.to_xarray().title == run.case.title == title


REAL, TEXT = "a number from ", "a text in quotes of at most 256 printable bytes"


@pytest.mark.parametrize(("change", "place", "expected", "found"), [
    ({"dt": float("nan")}, "integrator dt", REAL, "NaN"), ({"dt": "fast"}, "integrator dt", REAL, "'fast'"),
    ({"dt": True}, "integrator dt", REAL, "True"),
    ({"max_halvings": 9.5}, "integrator max_halvings", "a whole number from 0 to 30", "9.5"),
    ({"model": "rigid"}, "contact model", "one of halfspace strip hertz", "'rigid'"), ({"title": 3}, "case title", TEXT, "3"),
    ({"title": 129*"ä"}, "case title", TEXT, f"'{129*'ä'}'"), ({"title": "two\nlines"}, "case title", TEXT, "'two?lines'"),
    ({"interval": 1e-5}, "output interval", "at least the step", ""),
    ({"order": 2**32 + 4}, "integrator order", "a whole number from ", f"{2**32 + 4}"),
    ({"vY": 10**400}, "initial vY", REAL, f"{10**400}"), ({"vY0": 0.3}, "", "a namelist variable ", "vY0"),
    ({"roll": 0.1}, "", "initial_roll or table_roll", "roll, which is ambiguous")])
def test_changes_are_refused(change, place, expected, found):
    """The constructor refuses what `replace` refuses, unless the default step is shorter than that of the exercise."""
    case = ldbench.Case.exercise(1)
    for make in (case.replace, ldbench.Case)[:1 if place == "output interval" else 2]:
        with pytest.raises(ldbench.Error) as error:
            make(**change)
        told = error.value
        assert f"{told.group or ''} {told.variable or ''}".strip() == place and told.expected.startswith(expected), told
        assert told.found.startswith(found), told
        assert told.file == ({case.replace: case.label, ldbench.Case: "case"}[make] if place else None)


# Runs

@pytest.mark.same_build
@pytest.mark.parametrize("case", [
    to_flange("aw", model="strip"), to_flange("sw", beta=0.0), coarse(5, "aw", t_end=0.6)],
    ids=["strip", "explicit", "ramp"])
def test_file_and_summary_are_the_executables(case, tmp_path):
    reference = tmp_path/"executable.txt"
    case = case.replace(output_file=reference, table_folder=kept_tables())
    case.to_namelist(tmp_path/"case.nml")
    done = subprocess.run([LDBENCH, tmp_path/"case.nml"], cwd=REPO, capture_output=True, text=True, timeout=HANG)
    assert done.returncode == 0, done.stderr
    run = ldbench.run(case)
    assert Path(run.write(tmp_path / "python.txt")).read_bytes() == reference.read_bytes()
    ours, theirs = (re.sub("processor time.*|contact table: [0-9].*", "", text) for text in (run.text, done.stdout))
    assert ours == theirs


def test_numbers_of_the_file_are_rounded_to_nine_digits(flange_run, tmp_path):
    """As Python rounds them, cell by cell; what would need three digits of the exponent is zero."""
    def cell(x: float) -> str:
        return f"{'NaN':>16}" if np.isnan(x) else f"{x if abs(x) >= 1e-98 else 0.0:16.8E}"

    lines = [line for line in Path(flange_run.write(tmp_path / "columns.txt")).read_text().splitlines()[1:] if line[0] != "#"]
    assert lines == ["".join(map(cell, row)) for row in flange_run.data.to_numpy()]


def test_cases_with_other_profiles_under_the_same_names_differ(tmp_path):
    cases = []
    for folder, wheel in (tmp_path / "a", "awprof"), (tmp_path / "b", "swprof"):
        (folder / "profiles").mkdir(parents=True)
        (folder / "profiles/own.yz").write_bytes((REPO / f"profiles/{wheel}.yz").read_bytes())
        (folder / "case.nml").write_text("&profiles wheel_profile = 'profiles/own.yz' /")
        cases.append(ldbench.Case.from_namelist(folder / "case.nml"))
    one, other = cases
    assert one.values == other.values and one != other and len({one, other}) == 2
    assert one == ldbench.Case.from_namelist(tmp_path / "a/case.nml") == copy.deepcopy(one)


# One table for many runs

def test_a_table_serves_other_runs():
    first = to_flange("aw")
    other = first.replace(vY=0.9, roll_rate=0.03, mass=1600, vertical_load=150e3, lateral_force=2e3,
                          title="heavier", wheel_profile=str(REPO / "profiles/awprof.yz"))
    table = ldbench.ContactTable(first)
    shared, alone = ldbench.run(other, table=table), ldbench.run(other.replace(table_folder=kept_tables()))
    assert shared.data.equals(alone.data)
    assert shared.table.equilibrium == alone.table.equilibrium != table.equilibrium
    assert shared.table.weight == pytest.approx(1600*9.81 + 150e3)
    assert ldbench.run(first, table=shared.table).data.equals(ldbench.run(first, table=table).data)


@pytest.mark.parametrize(("change", "place", "expected", "found"), [
    ({"model": "hertz"}, "contact model", "'strip', for which the contact table was made", "'hertz'"),
    ({"gauge": 1.4352}, "track gauge", "1.4351, for", "1.4352"), ({"accuracy": 3e-3}, "table accuracy", "0.002, for", "0.003"),
    ({"table_roll": 0.3}, "table roll", "0.5, for", "0.3"),
    ({"wheel_profile": "profiles/swprof.yz"}, "", "the profile of the contact table", ""),
    ({"wheel_profile": "nothing.yz"}, "", None, None)])
def test_a_table_that_does_not_fit_is_refused(table, change, place, expected, found):
    with pytest.raises(ldbench.Error) as error:
        ldbench.run(table.case.replace(**change), table=table)
    told = error.value
    assert f"{told.group or ''} {told.variable or ''}".strip() == place, vars(told)
    assert told.expected == expected or told.expected.startswith(expected), vars(told)
    assert told.found == found or told.found.startswith(found), vars(told)
    assert told.file == table.case.label if place else Path(told.file).name == Path(change["wheel_profile"]).name


def test_a_load_beyond_the_table_is_refused():
    """One wheel is pressed half a millimetre into its rail by 1 MN, two do not carry 3 MN."""
    table = ldbench.ContactTable(coarse(1, "aw", depth=5e-4))
    with pytest.raises(ldbench.Error, match=r"&wheelset vertical_load = 3000000\.0 N: expected an equilibrium") as shared:
        ldbench.run(table.case.replace(vertical_load=3e6), table=table)
    assert (shared.value.group, shared.value.variable, shared.value.file) == ("wheelset", "vertical_load", table.case.label)


@pytest.mark.parametrize("accuracy", [1e-2, 2e-3, 1e-4])
def test_an_upright_wheelset_has_equal_wheels(accuracy: float):
    """To the last bit, wherever rounding puts zero on the axis of the roll angle."""
    table = ldbench.ContactTable(coarse(1, "aw", accuracy=accuracy))
    (tread, _), (other, _) = table.forces_by_contact(0.0, table.equilibrium, 0.0).reshape(2, 2, 3)
    assert np.array_equal(tread, other*[-1, 1, -1]) and tread[1] > 8e4


# Threads, progress, interruption

class Enough(Exception):
    pass


def test_progress_of_a_run_grows_until_an_exception_stops_it(tmp_path):
    """Integration without end, in the core, without the interpreter's lock."""
    told = []

    def stop_at_the_third(stage: str, share: float) -> None:
        told.append((stage, share))
        if len({share for stage, share in told if stage == "integration"}) == 3:
            raise Enough

    with pytest.raises(Enough):
        ldbench.run(endless(tmp_path, table_folder=""), progress=stop_at_the_third)
    shares = [share for stage, share in told if stage == "integration"]
    assert shares == sorted(shares) and 0 <= shares[0] < shares[-1] <= 1
    assert {stage for stage, _ in told} == {"integration"}
    assert not list(tmp_path.iterdir())


INTERRUPTED = """
import sys, warnings, ldbench
warnings.simplefilter("ignore", ldbench.Warning)
case = ldbench.Case.from_namelist(sys.argv[1])
try:
    ldbench.run(case, progress=lambda stage, share: stage == "integration" and print("running", flush=True))
except KeyboardInterrupt:
    print("stopped", len(ldbench.run(case.replace(t_end=0.01)).data))
"""


def test_control_c_stops_a_run_cleanly(tmp_path):
    """And the process goes on: a further run works."""
    endless(tmp_path, table_folder=kept_tables()).to_namelist(tmp_path / "case.nml")
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, tmp_path / "case.nml"], cwd=tmp_path, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == "running\n"
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=HANG)
    assert (out.splitlines()[-1], process.returncode, err) == ("stopped 2", 0, "")


# The contact table at poses

def test_wheels_and_contacts_add_up(table, flange_run):
    poses = touching_poses(table, 200)
    for function in table.potential, table.force, table.tangent:
        left, right = (function(*poses, wheel=wheel) for wheel in ("left", "right"))
        np.testing.assert_allclose(left + right, function(*poses), rtol=1e-12, atol=1e-6)
        assert np.abs(left).max() > 0 and not np.array_equal(left, right)
    contacts = table.forces_by_contact(*poses)
    assert (np.abs(contacts).max(axis=(0, 2)) > 1e3).all(), "all four contacts are tested"
    for wheel, own in ("left", slice(0, 2)), ("right", slice(2, 4)):
        np.testing.assert_allclose(contacts[:, own].sum(axis=1), table.force(*poses, wheel=wheel), rtol=1e-12, atol=1e-6)
    # At the poses of a run, they are what its columns say; z = equilibrium + Z is rounded to 1e-16 m, at 1e9 N/m.
    columns = flange_run.data
    contacts = flange_run.table.forces_by_contact(columns["Y"], flange_run.table.equilibrium + columns["Z"], columns["roll"])
    for k, contact in enumerate(("LT", "LF", "RT", "RF")):
        for axis, name in enumerate(("Fy", "Fz")):
            np.testing.assert_allclose(contacts[:, k, axis], columns[f"{name}_{contact}"], rtol=1e-9, atol=1e-5)


def test_shapes_follow_the_poses(table):
    z, y = table.equilibrium, np.linspace(-1e-3, 1e-3, 6).reshape(3, 2)
    for function, shape in ((table.potential, ()), (table.force, (3,)), (table.tangent, (3, 3)), (table.forces_by_contact, (4, 3))):
        assert function(0, z, 0).shape == shape and function(y, z, 0).shape == (3, 2, *shape)
    assert table.force(y[:, :1], z, y[:1]).shape == (3, 2, 3) and table.force([], [], []).shape == (0, 3)
    assert np.array_equal(table.force(y, z, 0)[2, 1], table.force(y[2, 1], z, 0))
    with pytest.raises(ValueError, match="'front'"):
        table.force(0, z, 0, wheel="front")


def test_poses_off_the_table_are_refused_or_nan(table):
    z = table.equilibrium
    y, deep, roll = np.array([0, 0.12, 0, 0]), np.array([0, 0, -0.005, 0]), np.array([0, 0, 0, 0.55])
    off = [(y[1], z, 0, "lateral = 0.08 m"), (0, z + deep[2], 0, "depth = 0.0022 m"), (0, z, roll[3], "roll = 0.5 rad"),
           (0, -5, 0, "drop = 0.01 m")]
    for *pose, variable in off:
        with pytest.raises(ldbench.Error, match=f"expected poses within &table {variable}, found y = .* outside"):
            table.force(*pose)
    for function in table.potential, table.force, table.tangent, table.forces_by_contact:
        values = function(y, z + deep, roll, outside="nan")
        assert np.isfinite(values[0]).all() and np.isnan(values[1:]).all()
    assert table.potential(0, z + 1.0, 0) == 0, "in the air there is no contact, wherever"
    for lift, k, number in itertools.product((0.0, 1.0), range(3), (np.nan, -np.inf)):
        pose = [0.0, z + lift, 0.0]
        pose[k] = number
        with pytest.raises(ldbench.Error, match=f"expected finite numbers, found the pose .*{number}"):
            table.force(*pose)
        assert np.isnan(table.force(*pose, outside="nan")).all()


def test_geometry_is_that_of_the_geometry_file(table, tmp_path):
    table.write_geometry(tmp_path / "geometry.txt")
    file, frame = ldbench.read_columns(tmp_path / "geometry.txt"), table.geometry()
    assert list(file) == list(frame) and file.attrs["units"] == frame.attrs["units"]
    wide = np.isin(np.round(1e4*frame["Y"]), np.round(1e4*file["Y"]))
    np.testing.assert_allclose(frame[wide].to_numpy(), file.to_numpy(), rtol=1e-8, atol=1e-9)


# Column files

def test_column_map_sets_units_signs_and_datum(tmp_path):
    path = tmp_path / "theirs.txt"
    path.write_text("T Z PHI N V\n0.5 456.0 90 1.5 36\n1.0 458.0 -180 -2 72\n")
    columns = ldbench.read_columns(path, {
        "time": {"column": "T", "unit": "ms"}, "Z": {"column": 2, "unit": "mm", "offset": -0.457},
        "roll": {"column": "PHI", "unit": "deg"}, "N_LF": {"column": "N", "unit": "kN", "factor": -1},
        "vX": {"column": "V", "unit": "km/h"}})
    np.testing.assert_allclose(columns, [[5e-4, -1e-3, np.pi/2, -1500, 10], [1e-3, 1e-3, -np.pi, 2000, 20]], rtol=1e-12)
    assert columns.attrs["units"] == {"time": "s", "Z": "m", "roll": "rad", "N_LF": "N", "vX": "m/s"}


FACTS = "column, unit, factor, offset"


@pytest.mark.parametrize(("content", "columns", "line", "expected", "found"), [
    ("", None, None, "rows of numbers", "none"), ("0 1\n1 2\n", None, None, "a line with the names of 2 columns", "none"),
    ("t Y\n0 1\n1 x\n", None, 3, "2 numbers", "'1 x'"), ("t Y\n0 1\n1 2\n3", None, 4, "2 numbers", "'3'"),
    ("t Y\n0 1\n1 2 end of file\n", None, 3, "2 numbers", "'1 2 end of file'"),
    ("t Y N\n0 1 2\n1 2\n3 4 5 6\n", None, 3, "3 numbers", "'1 2'"), ("t Y\n0 1x\n1 2\n", None, 2, "2 numbers", "'0 1x'"),
    ("t Y\n# s m\n0 1 1\n1 2\n", None, None, "a line with the names of 3 columns", "none"),
    ("t;Y\n0;1.234,5\n1;2\n", None, 2, "2 numbers", "'0;1.234,5'"), ("t,Y\n0,1\n1,1_0\n", None, 3, "2 numbers", "'1,1_0'"),
    ("t Y Y\n0 1 2\n", None, None, "one column Y", "2"),
    ("t Y\n0 1\n", {"Y": "ylat"}, None, "a column ylat", "t, Y"), ("t Y\n0 1\n", {"Y": 3}, None, "a column 3", "t, Y"),
    ("t Y\n0 1\n", {"Y": {"column": "Y", "unit": "furlong"}}, None, "a unit among 1, -, s", "furlong"),
    *(("t Y\n0 1\n", {"Y": wrong}, None, FACTS, str(wrong)) for wrong in (
        2.0, {"name": "Y"}, {"column": "Y", "factor": "2"}, {"column": "Y", "offset": float("nan")}))])
def test_unreadable_columns_are_refused(content, columns, line, expected, found, tmp_path):
    (tmp_path / "a.txt").write_text(content)
    with pytest.raises(ldbench.Error) as error:
        ldbench.read_columns(tmp_path / "a.txt", columns)
    told = error.value
    assert (told.line, told.found) == (line, found) and told.expected.startswith(expected), told
    assert told.file == ("column map" if expected == FACTS else str(tmp_path / "a.txt"))


# The command line


def test_a_changed_case_does_not_replace_the_file_of_the_unchanged_one(tmp_path, capsys):
    file, namelist = tmp_path/"columns.txt", str(tmp_path/"case.nml")
    coarse(3, "aw", t_end=1e-3, table_folder=kept_tables(), output_file=file).to_namelist(namelist)
    assert main(["run", namelist]) == 0
    earlier = file.read_bytes()
    capsys.readouterr()
    assert main(["run", namelist, "--set", "vY=0.9"]) == 1
    assert capsys.readouterr().err == (f"ldbench: error: {namelist}: expected -o FILE with --set, found none: "
                                       f"{file} is the file of the unchanged case\n")
    for changed in ldbench.Case.from_namelist(namelist).replace(vY=0.9), ldbench.read_run(file).case.replace(vY=0.9):
        with pytest.raises(ldbench.Error, match=r"expected a path, .*columns.txt is the file of the unchanged case"):
            pickle.loads(pickle.dumps(ldbench.run(changed))).write()
    assert file.read_bytes() == earlier
    assert main(["run", namelist, "--set", "vY=0.9", "--set", f"output_file={tmp_path}/other.txt"]) == 0
    assert main(["run", namelist, *"--set=VY=0.6 --set=vY=0.5 --set=VY=0.7 -o".split(), f"{tmp_path}/last.txt"]) == 0
    assert [ldbench.read_run(tmp_path/f"{name}.txt").case.vY for name in ("columns", "other", "last")] == [1.0, 0.9, 0.7]


def test_variables_command(capsys):
    """The command lists all variables, a group or some, each with default, range and meaning."""
    said = []
    for words in [], ["initial_roll", "MASS"], ["&integrator"]:
        assert main(["variables", *words]) == 0
        said.append(capsys.readouterr().out)
    every, chosen, group = said
    assert [line.split()[0] for line in every.splitlines() if re.match(r"  \S+ = ", line)] == [v.name for v in variables()]
    assert all(v.range in every and v.meaning in every for v in variables())
    assert [line for line in chosen.splitlines() if line.startswith("&")] == ["&wheelset", "&initial"]
    assert group.startswith("&integrator\n") and group in every and len(re.findall("^&", group, re.M)) == 1


@pytest.mark.parametrize(("number", "profiles"), [(6, "aw"), (0, "sw"), (2, "xw"), ("2", "aw")])
def test_an_exercise_that_is_none_is_told_with_those_that_are(number, profiles):
    with pytest.raises(ValueError, match=r"expected exercise 1 to 5 with the profiles 'aw' or 'sw', found "):
        ldbench.Case.exercise(number, profiles)


def test_impacts_of_one_contact_by_its_name():
    run = ldbench.read_run(REPO/"outputs/reference/ex2_aw.txt")
    assert run.impacts("LF") == run.impacts(["LF"]) != []
    with pytest.raises(ldbench.Error, match="expected a contact LT, LF, RT, RF"):
        run.impacts("L")
