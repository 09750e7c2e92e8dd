"""Contact tables: the error that they state, their size, their bytes, half-spaces under them."""
import os
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import ldbench
import running
from ldbench import Case, ContactTable
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from ldbench.table import Accuracy
from probes import left_rail, left_wheel, probe, stated_error, table_file, tangent_angles, turned
from running import HANG, LDBENCH, Run, columns, header, rows, run_case

PLACES = "tread", "flange", "both", "going over"
MODELS = "strip", "halfspace"
COARSE = {"n_lateral": 40, "n_roll": 9, "n_depth": 9}


def short_case(folder: Path, **changes: dict[str, object]) -> str:
    """A short case with strips, whose table states its error."""
    return running.short_case(folder, **{"contact": {"model": "strip"}} | changes)


def table_case(pair: str, model: str, shipped: dict[str, Run], strip_tables: dict[str, Path]) -> Case:
    """A case with the table of the shipped inputs, or one of strips that the tests share."""
    file = table_file(shipped, pair) if model == "halfspace" else strip_tables[pair]
    return Case.exercise(2, pair).replace(model=model, table_file=file)


def stated(words: str) -> dict[str, tuple[str, str]]:
    """'tread': (rms, largest) and so on, as a line of a header or a summary has them."""
    line, = re.findall(r"error of the contact force, rms \(largest\), relative to max\(\|F\|, 5 kN\):\n((?:  .*\n)+)", words)
    return {place: (rms, largest) for place, rms, largest in re.findall(r"  ([a-z ]+) (\S+) \((\S+)\)\n", line)}


def drawn(pair: str, n: int) -> np.ndarray:
    """Poses of the left wheel in service, pressed in anywhere: a point of its tread or flange at the rail's point
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
    depth = np.where(flange, 2.2e-3, 1e-3)*rng.random(n)**2      # [m]
    centre = point - turned(wheel[k], roll) - depth[:, None]*normal
    return np.column_stack([centre, roll])


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("pair", ["aw", pytest.param("sw", marks=pytest.mark.slow)])
def test_stated_error_is_that_of_other_poses(pair: str, model: str, shipped: dict[str, Run], strip_tables: dict[str, Path],
                                             tmp_path: Path):
    """800 poses in service, drawn here and evaluated directly on finer elements, have the stated rms errors
    within a factor of 2."""
    case = table_case(pair, model, shipped, strip_tables)
    table = ContactTable(case)
    accuracy = table.accuracy
    place, tread, flange, error = stated_error(table, drawn(pair, 16000), tmp_path, 800)
    there = place == 1
    assert there.sum() == 800
    figures = {}
    for name, of in (("tread", flange == 0), ("flange", tread == 0), ("both", tread*flange == 1)):
        of = of & there
        assert of.sum() >= 50, name
        figures[name] = np.sqrt(np.mean(error[of]**2))/accuracy[name].rms
    assert all(0.5 < rms < 2 for rms in figures.values()), figures


@pytest.mark.slow
def test_poses_of_another_gauge_are_covered(tmp_path: Path):
    """A wheelset of metre gauge that goes over is, in its service and until it derails, where its table is made
    for, with the stated error."""
    case = Case.exercise(5).replace(model="strip", table_file=tmp_path / "gauge.table", accuracy=6e-3, gauge=1.0,
                                    back_to_back=0.917)
    run = ldbench.run(case.replace(lateral_ramp=50e3))
    poses = run.data[["Y", "Z", "roll"]].to_numpy()[run.data["N_LF"] > 0][-2000:]
    place, _, _, error = stated_error(run.table, poses + [0, run.table.equilibrium, 0], tmp_path)
    assert 0.2 < -poses[:, 2].min() < 0.6 and (place > 0).mean() > 0.99
    assert np.sqrt(np.mean(error[place == 2]**2)) < 2*run.table.accuracy["going over"].rms


def test_every_mouth_tells_the_same_error(shipped: dict[str, Run], strip_tables: dict[str, Path], tmp_path: Path,
                                          capsys: pytest.CaptureFixture[str]):
    """Summary, header, the table file as Python reads it, and `python -m ldbench table`."""
    run = shipped["ex2_aw"]
    case = table_case("aw", "halfspace", shipped, strip_tables)
    accuracy = ContactTable(case).accuracy
    assert tuple(accuracy) == PLACES and all(error.poses >= 20 for error in accuracy.values())
    told_by_file = read_data(run.file).header.table_errors
    assert {place: (f"{rms:.2E}", f"{largest:.2E}") for place, (rms, largest) in told_by_file.items()} == stated(run.summary)
    assert {place: tuple(map(float, numbers)) for place, numbers in stated(run.summary).items()} \
        == {place: (float(f"{error.rms:.2e}"), float(f"{error.largest:.2e}")) for place, error in accuracy.items()}
    case.to_namelist(tmp_path/"told.nml")
    assert main(["table", str(tmp_path / "told.nml")]) == 0
    said = capsys.readouterr().out
    assert "contact table: model halfspace, found, " in said
    told = {place: Accuracy(int(poses), float(rms), float(largest)) for place, rms, largest, poses in re.findall(
        r"error, (.+): rms (\S+), largest (\S+) of max\(\|F\|, 5 kN\) at (\d+) poses", said)}
    assert told == {place: Accuracy(error.poses, float(f"{error.rms:.1e}"), float(f"{error.largest:.1e}"))
                    for place, error in accuracy.items()}


def test_solutions_that_do_not_converge_are_counted_and_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """A solution that is asked for no error at all is counted; what a table's file counts is in
    summary, header and `python -m ldbench table`, and nothing where there is nothing to count."""
    file = tmp_path / "case.nml"
    file.write_text(short_case(tmp_path, contact={"model": "strip"}, table=COARSE | {"file": tmp_path / "a.table"}))
    assert not re.search("did not converge", run_case(file.read_text(), tmp_path).stdout)
    assert probe("table_faults", file, "unsolved").tolist() == [[2, 1]]
    done = run_case(file.read_text(), tmp_path)
    assert done.returncode == 0 and "(found)" in done.stdout, done.stderr
    assert main(["table", str(file)]) == 0
    told = capsys.readouterr().out
    assert ContactTable(Case.from_namelist(file)).solutions == (1000, 3, 2)
    for words in (" ".join(printed.split()) for printed in (done.stdout, header(tmp_path / "columns.txt"), told)):
        assert "contact table: 3 of 1000 half-space solutions did not converge; its stated error" in words, words
        assert re.search(r"contact table: 2 .*poses for its error did not converge; the stated", words), words


def test_a_contact_that_the_table_misses_is_an_error(tmp_path: Path):
    """A table of strips whose flange is taken away has all of the flange's force as its error; a table whose contacts pull
    misses all of the tread's force, and is no table to run with."""
    file = tmp_path / "case.nml"
    file.write_text(short_case(tmp_path, contact={"model": "strip"}, table=COARSE | {"file": tmp_path / "a.table"}))
    whole, missing, pulling = probe("table_faults", file, "missed")
    assert max(whole[:2]) < 0.5 and missing[0] == whole[0] and missing[1] == 1, (whole, missing)
    assert pulling[0] == 1 and (whole[2], pulling[2]) == (0, 4), pulling


WARNING = (r"warning: contact table: expected an rms error of at most &table accuracy = 0\.002 of a wheel's force on the tread, on "
           r"the flange and on both at once, reached ([^;\s]+);")
ROLLOVER_WARNING = (r"warning: contact table: expected an rms error of at most 10 x &table accuracy while the wheelset "
                    r"rolls over a rail, reached (\S+); do not trust")


def test_a_table_at_its_limits_warns_and_the_run_goes_on(tmp_path: Path):
    done = run_case(short_case(tmp_path, table=COARSE), tmp_path)
    assert done.returncode == 0, done.stderr
    worst, = re.findall(WARNING, " ".join(done.stdout.split()))
    assert float(worst) == max(float(rms) for place, (rms, _) in stated(done.stdout).items() if place != "going over")
    assert float(worst) > 2e-3 and len(columns(tmp_path / "columns.txt")["time"]) == 21
    for words in done.stdout, header(tmp_path / "columns.txt"):
        over, = re.findall(ROLLOVER_WARNING, " ".join(words.replace("\n#", "\n").split()))
        assert over == stated(done.stdout)["going over"][0] and float(over) > 2e-2
    done = run_case(short_case(tmp_path, table=COARSE | {"accuracy": 0.5}), tmp_path)
    assert done.returncode == 0 and "warning" not in done.stdout + done.stderr


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
def test_more_accuracy_is_more_points_and_less_error():
    """In poses of the tread or the flange alone: where both touch, a table of 1e-2 may still have a contact that pulls. Forces are
    the gradient of whatever the table holds."""
    size, error = [], []
    for accuracy in 1e-1, 1e-2:
        done = ldbench.run(Case.exercise(2).replace(
            model="strip", table_file="", t_end=0.03, stop_at="t_end", order=4, beta=0.0, energy_tolerance=1e-9, accuracy=accuracy,
            n_lateral=400, n_roll=200, n_depth=60))
        points = re.findall(r"(\d+) x (\d+) x (\d+)", done.text)        # of every zone: across, over roll, over root of the depth
        size.append(sum(int(a)*int(b)*int(c) for a, b, c in points))
        error.append(np.hypot(done.table.accuracy["tread"].rms, done.table.accuracy["flange"].rms))
        assert done.results["drift"] < 1e-9*done.results["kinetic_energy"] and (done.data.N_LF > 0).any()
    assert 0 < size[0] < size[1] and error[0] > error[1], (size, error)


def test_any_number_of_threads_makes_the_same_bytes(tmp_path: Path):
    """Table file and columns; and the same rows from the table that is found again. Half-spaces are built on strips."""
    found = []
    for threads in 1, 5:
        work = tmp_path / str(threads)
        work.mkdir()
        (work / "case.nml").write_text(short_case(Path(), contact={"model": "halfspace"}, table=COARSE | {"file": "a.table"}))
        for words in "(built)", "(found)":
            done = subprocess.run([LDBENCH, "case.nml"], cwd=work, capture_output=True, text=True, timeout=HANG,
                                  env=os.environ | {"OMP_NUM_THREADS": str(threads)})
            assert done.returncode == 0 and words in done.stdout, done.stdout + done.stderr
            found.append(((work / "a.table").read_bytes(), rows(work / "columns.txt")))
    assert all(other == found[0] for other in found)


@pytest.mark.slow
def test_last_digits_of_the_strips_do_not_grow_in_half_spaces(tmp_path: Path):
    """Strips that differ by 1e-13, as another processor rounds them, have the same points, and ratios that differ by no more
    than the spline makes of 1e-13."""
    case = Case.exercise(2).replace(model="strip", table_file=tmp_path / "strips.table", accuracy=5e-3)
    case.to_namelist(tmp_path / "case.nml")
    found = probe("table_faults", tmp_path / "case.nml", "shaken")
    assert (found[:, :3] == found[:, 3:6]).all() and found[:, 6].max() < 1e-9, found
