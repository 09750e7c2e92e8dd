"""The reference package, made of short cases with Hertz's law."""
from __future__ import annotations

import hashlib
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ldbench
from invented import COARSE
from ldbench import Case
from ldbench_round.metrics import score
from ldbench_round.own_runs import horizon
from ldbench_round.tasks import Task
from reference_package import INTERVAL, error_row, solve, write_package
from running import HANG, LDBENCH, environment

FREE, RAMP = Task(2, "aw"), Task(5, "aw")
CASES = [(FREE, Case.exercise(2, "aw").replace(**COARSE, t_end=0.03)), (RAMP, Case.exercise(5, "aw").replace(**COARSE, t_end=0.8))]


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("package")
    write_package(folder/"reference.zip", CASES)
    with zipfile.ZipFile(folder/"reference.zip") as archive:
        assert archive.testzip() is None
        archive.extractall(folder)
    return folder


def test_all_files_are_there_and_have_their_sums(package: Path):
    with zipfile.ZipFile(package/"reference.zip") as archive:
        names = archive.namelist()
    sums = dict(reversed(line.split("  ")) for line in (package/"SHA256SUMS").read_text().splitlines())
    assert sorted([*sums, "SHA256SUMS"]) == sorted(names)
    assert all(hashlib.sha256((package/name).read_bytes()).hexdigest() == known for name, known in sums.items())
    assert {"README.md", "LICENSE", "CITATION.cff", "profiles/awprof.yz", "profiles/arprof.yz", "columns/ex5_aw.txt",
            "namelists/ex2_aw.nml", "events.csv", "impulses.csv", "horizons.csv", "yardsticks.json", "exactness.csv"} <= set(names)
    text = (package/"README.md").read_text()
    assert "{" not in text and all(f"`{name}" in text for name in (
        "columns/", "events.csv", "impulses.csv", "exactness.csv", "namelists/", "SHA256SUMS"))


def test_a_namelist_of_the_package_that_is_run_writes_over_nothing(package: Path, monkeypatch: pytest.MonkeyPatch):
    """A user who unpacks the package and runs a namelist gets a file beside the README. Its scores are the best."""
    monkeypatch.chdir(package)
    before = {file: file.read_bytes() for file in package.rglob("*") if file.is_file()}
    done = subprocess.run([LDBENCH, "namelists/ex2_aw.nml"], capture_output=True, text=True, env=environment(), timeout=HANG)
    assert done.returncode == 0, done.stderr
    assert {file for file in package.rglob("*") if file.is_file()} - before.keys() == {package/"ex2_aw.txt"}
    assert all(file.read_bytes() == known for file, known in before.items())
    found = score(ldbench.read_run("ex2_aw.txt"), ldbench.read_run("columns/ex2_aw.txt"), FREE)
    assert {one.difference for one in found.scores} == {0.0}
    (package/"ex2_aw.txt").unlink()


@pytest.mark.parametrize("task", [FREE, RAMP], ids=lambda task: task.name)
def test_columns_events_and_impulses_belong_together(task: Task, package: Path):
    """Tables hold the events of a whole run of ours and all of its impulse up to the horizon."""
    run = ldbench.read_run(package/f"columns/{task.name}.txt")
    events, impulses = (table[table.simulation == task.name] for table in map(pd.read_csv, (package/"events.csv",
                                                                                           package/"impulses.csv")))
    assert list(zip(events["time [s]"], events["event"], strict=True)) == [(event.t, event.kind) for event in run.events]
    kept = run.time <= horizon(task)
    for contact in ("LF", "RF"):
        mine = impulses[impulses["contact"] == contact]
        assert list(mine["number"]) == list(range(1, len(mine) + 1))
        # A flange that is open at both ends has all of its impulse in whole impacts.
        force = run.values(f"N_{contact}")[kept]
        if force[-1] == 0:
            assert mine["impulse [N s]"].sum() == pytest.approx(np.trapezoid(force, run.time[kept]), rel=1e-4)
    assert (impulses["opens [s]"] <= horizon(task)).all()


def test_the_error_that_is_told_is_that_of_another_solution(package: Path):
    """A run with a quarter of the step is as near as the package says of half the step, within ten times of rounding."""
    told = pd.read_csv(package/"exactness.csv").set_index("simulation")
    found = solve(*CASES[0], {})
    assert all(told.loc["ex2_aw", name] == x for name, x in error_row(found).items() if name != "simulation")
    assert (told["drift, relative"] < 1e-9).all() and told.loc["ex2_aw", "displacements"] < 1e-8
    case = found.run.case.replace(dt=found.run.case.dt/4, rows="interval")
    quarter = ldbench.run(case, table=found.run.table.for_case(case))
    t = found.run.time
    same = np.isin(np.round(t/INTERVAL, 6), np.round(quarter.time/INTERVAL, 6))
    for column in ("Y", "Z", "roll"):
        apart = np.abs(np.interp(t[same], quarter.time, quarter.values(column)) - found.run.values(column)[same])
        assert apart.max()/np.abs(found.run.values(column)).max() < 1e-8
