"""Contact tables: their errors, what they keep, and that no result depends on what came before."""
import os
import random
import re
import subprocess
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import ldbench
import shapes
from ldbench import Case, ContactTable
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from probes import MODERN, left_rail, left_wheel, tangent_angles, turned
from running import HANG, LDBENCH, REPO, Run, header, kept_tables, rows, run_case, short_case

SERVICE = "tread", "flange", "both"


def stated(words: str) -> dict[str, tuple[str, str]]:
    """'tread': (rms, largest) and so on, as a summary has them."""
    line, = re.findall(r"error of the contact force in poses of the run, rms \(largest\), relative to max\(\|F\|, 5 kN\):\n"
                       r"((?:  .*\n)+)", words)
    return {place: (rms, largest) for place, rms, largest in re.findall(r"  ([a-z ]+) (\S+) \((\S+)\)\n", line)}


def drawn(pair: str, n: int) -> np.ndarray:
    """Poses of the left wheel near those of service, pressed in anywhere: a point of its tread or flange at the rail's point
    of the same normal."""
    rng = np.random.default_rng(11)
    wheel, rail = left_wheel(pair), left_rail(pair)
    angle, rail_angle = tangent_angles(wheel), tangent_angles(rail)
    on_flange = angle > np.radians(10)
    flange = rng.random(n) < 0.5
    k = np.where(flange, rng.choice(np.flatnonzero(on_flange), n), rng.choice(np.flatnonzero(~on_flange), n))
    roll = rng.uniform(-0.02, 0.02, n)
    normal_angle = angle[k] + roll
    order = np.argsort(rail_angle)
    point = np.column_stack([np.interp(normal_angle, rail_angle[order], x[order]) for x in rail.T])
    normal = np.column_stack([-np.sin(normal_angle), np.cos(normal_angle)])
    depth = np.where(flange, 0.5e-3, 0.3e-3)*rng.random(n)**2      # [m]
    centre = point - turned(wheel[k], roll) - depth[:, None]*normal
    return np.column_stack([centre, roll])


@pytest.mark.parametrize(("pair", "model", "n"), [
    ("aw", "strip", 40), ("aw", "halfspace", 25), *(pytest.param(pair, model, 150, marks=pytest.mark.slow) for pair, model in (
        ("aw", "halfspace"), ("aw", "hertz"), ("sw", "strip"), ("sw", "halfspace"), ("sw", "hertz")))])
def test_errors_in_poses_that_no_run_chose(pair: str, model: str, n: int):
    """The force is the central difference of the energy of direct solutions, in poses that a wheelset on both rails can have."""
    case = Case.exercise(2, pair).replace(table_folder=kept_tables())
    springs, table = (ContactTable(case.replace(model=one)) for one in ("hertz", model))
    poses = drawn(pair, 30*n)
    force = np.linalg.norm(springs.forces_by_contact(*poses.T, outside="nan")[..., :2], axis=2)
    poses = poses[(force.max(axis=1) < 8e5) & (np.abs(poses[:, 0]) < table.clearance + 2e-3)][:n]
    assert len(poses) == n
    error, _ = table.errors(*poses.T)
    assert np.sqrt(np.mean(error**2)) < 2e-3 and error.max() < 1e-2, np.sqrt(np.mean(error**2))


def test_merged_patches_have_the_force_of_the_whole_wheel():
    """Where a wheel that is dropped on tread and flange carries up to 2.5 MN, its table is right, and its force does not exceed the
    sum of the loads of the pressed patches."""
    table = ContactTable(Case.exercise(2, "aw").replace(table_folder=kept_tables()))
    rng = np.random.default_rng(3)
    y, drop, roll = rng.uniform([9.8e-3, 0.2e-3, -1e-3], [10.8e-3, 0.9e-3, 1e-3], (40, 3)).T
    z = table.equilibrium - drop
    by_contact = np.linalg.norm(table.forces_by_contact(y, z, roll, outside="nan")[:, :2, :2], axis=2)
    wheel = np.linalg.norm(table.force(y, z, roll, wheel="left", outside="nan")[:, :2], axis=1)
    heavy = np.flatnonzero((by_contact > 5e3).all(axis=1) & (wheel < 2.5e6))
    assert len(heavy) >= 6 and wheel[heavy].max() > 1.5e6
    error, _ = table.errors(y[heavy], z[heavy], roll[heavy])
    assert np.sqrt(np.mean(error**2)) < 5e-3 and error.max() < 1.5e-2, error
    for k in heavy[:2]:
        loads = sum(patch.integral for patch in table.pressure(y[k], z[k], roll[k]) if patch.contact[0] == "L")
        assert wheel[k] < 1.005*loads


def test_every_mouth_tells_the_same_error(shipped: dict[str, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Summary, results of the column file, the run in Python and `python -m ldbench table`."""
    run = shipped["ex2_aw"]
    case = Case.exercise(2, "aw").replace(table_folder=kept_tables(), pressures="no")
    told_by_file = read_data(run.file).header.table_errors
    assert set(told_by_file) == set(SERVICE) and ldbench.run(case).header.table_errors == told_by_file
    assert {place: (f"{rms:.2E}", f"{largest:.2E}") for place, (rms, largest) in told_by_file.items()} == stated(run.summary)
    assert all(rms < 2e-3 for rms, _ in told_by_file.values())
    over = read_data(shipped["ex5_aw"].file).header.table_errors
    assert set(over) > {"flange", "going over"} and all(rms < 2e-2 for rms, _ in over.values())
    case.to_namelist(tmp_path / "told.nml")
    assert main(["table", str(tmp_path / "told.nml")]) == 0
    said = capsys.readouterr().out
    assert re.search(r"contact table: model halfspace, 0 solutions, \d+ found, ", said)
    assert {place: (rms, largest) for place, rms, largest in re.findall(
        r"error of the contact force, (.+): rms (\S+), largest (\S+) of", said)} \
        == {place: (f"{rms:.1e}", f"{largest:.1e}") for place, (rms, largest) in told_by_file.items()}


def test_less_accuracy_than_was_asked_for_is_told(tmp_path: Path):
    hard = {"initial": {"Y": 0.0101}, "table": {"accuracy": 1e-6}}
    done = run_case(short_case(tmp_path, **hard), tmp_path)
    assert done.returncode == 0, done.stderr
    worst = max(float(rms) for place, (rms, _) in stated(done.stdout).items() if place in SERVICE)
    for words in done.stdout, (tmp_path / "columns.txt").read_text().replace("\n#", "\n"):
        assert f"accuracy = 1.0E-6 on the tread, on the flange and on both at once, found {worst:.2E}" in " ".join(words.split())
    assert "warning" not in run_case(short_case(tmp_path, output={"judged": "no"}, **hard), tmp_path).stdout


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
def test_more_accuracy_is_more_points_and_less_error():
    error, size = [], []
    for accuracy in 3e-2, 1e-4:
        run = ldbench.run(Case.exercise(2).replace(model="strip", table_folder="", t_end=0.03, stop_at="t_end", accuracy=accuracy))
        points = re.findall(r"(\d+) x (\d+) x (\d+)", run.text)        # of every zone: across, over roll, over root of the depth
        size.append(sum(int(a)*int(b)*int(c) for a, b, c in points))
        error.append(max(rms for rms, _ in run.header.table_errors.values()))
    assert 0 < size[0] < size[1] and error[0] > 4*error[1], (size, error)


@pytest.mark.parametrize(("law", "pair", "curves"), [
    ("halfspace", "aw", 5), ("strip", "aw", 16), ("hertz", "S1002 on 60E1", 24), *(
        pytest.param(law, pair, 55, marks=pytest.mark.slow) for law, pair in (
            ("halfspace", "aw"), ("halfspace", "sw"), ("hertz", "measured")))])
def test_force_grows_with_sinking(law: str, pair: str, curves: int, tmp_path: Path):
    """On curves to 1.1 times the clearance on either side and 10 mrad of roll, F_z of the left wheel never falls while the
    wheel sinks by 0.4 mm in steps of 10 um. The measured profiles have noise of 10 um."""
    case = Case.exercise(2, "sw" if pair == "sw" else "aw").replace(model=law, table_folder=kept_tables())
    if law == "hertz":
        case = case.replace(accuracy=6e-3)
    if pair == "S1002 on 60E1":
        case = case.replace(**MODERN)
    if pair == "measured":
        for name, points in ("wheel", shapes.shape("awprof")), ("rail", shapes.shape("arprof")):
            (tmp_path/name).write_text(shapes.rows(shapes.noisy(points, 0.01, 4)))
            case = case.replace(**{f"{name}_profile": str(tmp_path/name)})
    table = ContactTable(case)
    y, roll, z = np.meshgrid(1.1*table.clearance*np.linspace(-1, 1, curves), np.linspace(-0.01, 0.01, 3),
                             table.rest[1] + np.arange(2e-2, -1e-2, -1e-5), indexing="ij")
    force = table.force(y, z, roll, "left", "nan")[..., 1]
    sinks = (force > 0) & (np.cumsum(force > 0, axis=2) <= 40)
    growth = np.diff(force, axis=2)[sinks[..., :-1] & sinks[..., 1:]]
    assert len(growth) > 90*curves and growth.min() > 0


# What came before


def tables_in(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def columns_of(case: Case, folder: Path) -> bytes:
    return Path(ldbench.run(case).write(folder/f"{case.name}.txt")).read_bytes()


def test_results_do_not_depend_on_what_a_table_has_solved(tmp_path: Path):
    """From nothing, from a folder, after another case on the same table, and in threads that grow it at once."""
    case = Case.exercise(2, "aw").replace(model="strip", t_end=0.022, stop_at="t_end", table_folder=tmp_path/"tables")
    other = Case.exercise(3, "aw").replace(model="strip", t_end=0.022, stop_at="t_end", vY=0.9)
    alone = columns_of(case.replace(table_folder=""), tmp_path)
    table = ContactTable(other.replace(table_folder=""))
    ldbench.run(other.replace(table_folder=""), table=table)
    before, _, _ = table.solutions
    after = ldbench.run(case.replace(table_folder=""), table=table)
    assert table.solutions[0] > before > 0
    assert Path(after.write(tmp_path/"after.txt")).read_bytes() == alone
    shared, found = ContactTable(case.replace(table_folder="")), {}

    def work(k: int) -> None:
        run = ldbench.run((case, other)[k % 2].replace(table_folder=""), table=shared)
        found[k] = Path(run.write(tmp_path/f"{k}.txt")).read_bytes()

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found[0] == found[2] == alone and found[1] == found[3] != alone
    kept = [columns_of(case, tmp_path) for _ in range(2)]
    assert ContactTable(case).solutions[1] > 0 and kept[0] == kept[1]
    assert kept[0].replace(str(tmp_path/"tables").encode(), b"") == alone


def test_any_number_of_threads_makes_the_same_bytes(tmp_path: Path):
    """Columns, from an empty table and from the table that is found again; with bodies, whose law takes the most."""
    found = []
    for threads in 1, 3:
        work = tmp_path / str(threads)
        work.mkdir()
        contact = {"model": "halfspace", "influence": "bodies", "bodies": REPO/"profiles/aw.bodies"}
        (work / "case.nml").write_text(short_case(Path(), contact=contact, table={"folder": "tables"}, integrator={"t_end": 5e-4},
                                                    output={"pressures": "no"}))
        for words in r" [1-9]\d* solutions, 0 found", r" 0 solutions, [1-9]\d* found":
            done = subprocess.run([LDBENCH, "case.nml"], cwd=work, capture_output=True, text=True, timeout=HANG,
                                  env=os.environ | {"OMP_NUM_THREADS": str(threads)})
            assert done.returncode == 0 and re.search(words, done.stdout), done.stdout + done.stderr
            found.append((tables_in(work / "tables"), rows(work / "columns.txt"), header(work / "columns.txt")))
    assert all(other == found[0] for other in found)


def test_a_damaged_file_costs_time_and_nothing_else(tmp_path: Path):
    """Every file that is cut short, has another bit or is something else is found to be none, and replaced."""
    case = short_case(tmp_path, table={"folder": tmp_path/"tables"})
    first = run_case(case, tmp_path)
    file, = (tmp_path/"tables").iterdir()
    whole, told = file.read_bytes(), header(tmp_path/"columns.txt")
    assert re.search(r" [1-9]\d* solutions, 0 found", first.stdout)
    for damaged in whole[:-8], whole[:len(whole)//2], whole[:-200] + bytes([whole[-200] ^ 1]) + whole[-199:], b"", b"some text\n":
        file.write_bytes(damaged)
        done = run_case(case, tmp_path)
        assert re.search(r" [1-9]\d* solutions, 0 found", done.stdout) and header(tmp_path/"columns.txt") == told
        assert file.read_bytes() == whole


SIMPLIFIED = {f"{what}_profile": REPO/f"profiles/s{what[0]}prof.yz" for what in ("wheel", "rail")}


def test_cases_of_other_keys_share_a_folder(tmp_path: Path):
    """Another speed grows the file of a pair; another pair, material or law has a file of its own. Each side of a wheelset has the
    file of its pair."""
    folder = tmp_path/"tables"

    def run(**changes: dict[str, object]) -> dict[str, bytes]:
        done = run_case(short_case(tmp_path, table={"folder": folder}, **changes), tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        return tables_in(folder)

    (first, before), = run().items()
    assert re.fullmatch(r"hertz_[0-9a-f]{16}\.table", first)
    faster = run(initial={"vY": 0.9}, integrator={"t_end": 2e-2, "dt": 1e-5})
    assert faster.keys() == {first} and len(faster[first]) > len(before)
    two = run(profiles=SIMPLIFIED)
    run(material={"youngs_modulus": 2.06e11})
    four = run(contact={"model": "strip"})
    assert [len(two), len(four)] == [2, 4] and [name.startswith("hertz_") for name in sorted(four)] == [True, True, True, False]
    assert two[first] == four[first] == faster[first]
    both = run(profiles={f"{name}_right": file for name, file in SIMPLIFIED.items()})
    assert {name for name, data in both.items() if four.get(name) != data} <= two.keys()


def test_runs_at_the_same_time_both_add(tmp_path: Path):
    """A run that ends keeps what another has kept since it began; one run after the other leaves the same bytes."""
    case = Case.exercise(3).replace(model="hertz", t_end=0.03, stop_at="t_end", table_folder=tmp_path/"at once", vY=0.7,
                                    roll_link="rails")
    other = case.replace(vY=-0.9, output_file=tmp_path/"columns.txt")
    table = ContactTable(case)
    for name in "at once", "in turn":
        assert run_case(other.replace(table_folder=tmp_path/name).to_namelist(), tmp_path).returncode == 0
    before, = tables_in(tmp_path/"at once").values()
    ldbench.run(case, table=table)
    ldbench.run(case.replace(table_folder=tmp_path/"in turn"))
    assert tables_in(tmp_path/"at once") == tables_in(tmp_path/"in turn")
    after, = tables_in(tmp_path/"at once").values()
    assert len(after) > len(before)
    for one in case, other:
        assert " 0 solutions, " in ldbench.run(one).text


def test_threads_that_keep_one_file_lose_nothing(tmp_path: Path):
    """Short runs that end at about the same time, each of which has solved for another velocity: later runs solve nothing."""
    case = Case.exercise(3).replace(model="hertz", t_end=0.012, stop_at="t_end", roll_link="rails", table_folder=tmp_path/"tables")
    cases = [case.replace(vY=vY) for vY in np.linspace(0.5, 1.2, 4)]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(ldbench.run, cases))
    for one in cases:
        assert " 0 solutions, " in ldbench.run(one).text


def test_order_of_runs_changes_nothing(tmp_path: Path):
    """Four runs that share a folder: their columns, and in the end the tables."""
    cases = {f"{speed} {len(profiles)}": short_case(Path(), profiles=profiles, table={"folder": "tables"}, initial={"vY": speed})
             for speed in (0.3, -0.9) for profiles in ({}, SIMPLIFIED)}
    found = []
    for seed in range(2):
        work = tmp_path/str(seed)
        work.mkdir()
        columns = {}
        for name in random.Random(seed).sample(sorted(cases), len(cases)):
            assert run_case(cases[name], work, cwd=work).returncode == 0
            columns[name] = (work/"columns.txt").read_bytes()
        found.append((columns, tables_in(work/"tables")))
    assert found[0] == found[1] and len(found[0][1]) == 2


@pytest.mark.parametrize("folder", ["a file", "missing/tables"])
def test_a_folder_that_cannot_be_written_is_a_warning(folder: str, tmp_path: Path):
    (tmp_path/"a file").touch()
    assert run_case(short_case(tmp_path, table={"folder": ""}), tmp_path).returncode == 0
    expected = rows(tmp_path/"columns.txt")
    done = run_case(short_case(tmp_path, table={"folder": tmp_path/folder}), tmp_path)
    assert done.returncode == 0 and rows(tmp_path/"columns.txt") == expected
    assert re.fullmatch(r"ldbench: warning: &table folder: [^\n]*/" + folder + r"/hertz_[^\n]*\.table: cannot be written; [^\n]*\n",
                        done.stderr)
