"""Ensembles: the members are runs, whatever the threads, the store or the cluster."""
from __future__ import annotations

import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import threading
from collections import Counter
from contextlib import closing

import numpy as np
import pytest

pytest.importorskip("xarray")
pytest.importorskip("zarr")

import xarray as xr

import ldbench
from invented import COARSE
from ldbench.__main__ import main
from ldbench.ensembles import members, pools
from ldbench.ensembles.members import draws
from local_cluster import Cluster
from running import HANG, kept_tables

MASSES = [1300.0, 1500.0, 1700.0]


def short(**changes: object) -> ldbench.Case:
    """To the left flange and off it, within 20 ms."""
    return ldbench.Case.exercise(3).replace(**COARSE | {"dt": 1e-5, "t_end": 0.02} | changes)


@pytest.fixture(scope="module")
def table() -> ldbench.ContactTable:
    return ldbench.ContactTable(short())


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Counts runs and tables built."""
    counts, lock = Counter(), threading.Lock()

    def counting(name: str, work):
        def counted_work(*arguments):
            with lock:
                counts[name] += 1
            return work(*arguments)
        return counted_work

    monkeypatch.setattr(members, "compute", counting("runs", members.compute))
    monkeypatch.setattr(pools, "ContactTable", counting("tables", pools.ContactTable))
    return counts


def test_a_member_is_a_run(table):
    """With its results, columns, events and units."""
    linked = short(roll_link="rails")
    found = ldbench.ensemble(linked, {"mass": MASSES, "vY": [0.9, 1.1]}, columns=["Y", "N_LF"], tables=[table])
    assert dict(found.error.sizes) == {"mass": 3, "vY": 2} and not (found.error != "").any()
    one = found.sel(mass=1500, vY=1.1)
    run = ldbench.run(linked.replace(mass=1500, vY=1.1, rows="interval"), table=table)
    for name, value in run.results.items():
        assert one[name].item() == value or (np.isnan(one[name].item()) and np.isnan(value)), name
    for name in "time", "Y", "N_LF":
        assert np.array_equal(one[name], run.data[name])
    listed = [(float(one.event_time.sel(kind=kind, occurrence=k)), kind)
              for kind in one.kind.values.tolist() for k in one.occurrence.values
              if np.isfinite(one.event_time.sel(kind=kind, occurrence=k))]
    assert sorted(listed) == sorted((event.t, event.kind) for event in run.events)
    for name, unit in {"mass": "kg", "peak_N_LF": "N", "t_peak_LF": "s", "drift": "J", "frequency_1": "Hz", "steps": "1",
                       "event_time": "s", "event_force": "N", "Y": "m"}.items():
        assert found[name].attrs["units"] == unit, name


def test_threads_make_no_difference(table, counted):
    over = {"stiffness_scale": [1.0, 2.0], "mass": MASSES}
    one, three = (ldbench.ensemble(short(), over, columns=["roll"], tables=[table], threads=n) for n in (1, 3))
    assert one.identical(three)
    assert all(one[name].values.tobytes() == three[name].values.tobytes() for name in one.data_vars)
    assert counted == {"runs": 12, "tables": 2}
    assert (one.axle_height.sel(stiffness_scale=2) > one.axle_height.sel(stiffness_scale=1)).all()


def test_failures_are_recorded(table, tmp_path, few_results):
    """Also in a store, from which they come again."""
    first, found = (ldbench.ensemble(short(), {"mass": [-1.0, 1500.0], "vertical_load": [164618.0, 9e9]}, tables=[table],
                                     store=tmp_path/"sweep.zarr") for _ in range(2))
    assert found.identical(first)
    assert np.array_equal(found.error != "", [[True, True], [False, True]])
    assert "&wheelset mass: expected" in found.error.values[0, 0]
    assert np.array_equal(np.isnan(found.t), found.error != "") and found.end.values[0, 0] == ""
    assert found.peak_N_LF.values[1, 0] > 1e6


def test_a_table_that_cannot_be_built_fails_its_members(table):
    found = ldbench.ensemble(short(), {"wheel_profile": ["profiles/awprof.yz", "none.yz"], "mass": MASSES}, tables=[table])
    assert (found.error[0] == "").all() and all("none.yz" in error for error in found.error[1].values)


def test_rows_are_thinned_or_padded(table):
    cases = [short(t_end=t) for t in (0.02, 1e-3)]
    full = ldbench.ensemble(cases, columns=["Y"], tables=[table])
    assert full.Y.shape == (2, 201) and np.isnan(full.Y[1, 11:]).all() and not np.isnan(full.Y[1, :11]).any()
    thin = ldbench.ensemble(cases, columns=["Y"], rows=21, tables=[table])
    assert np.array_equal(thin.Y[0], full.Y[0, ::10]) and np.array_equal(thin.Y[1, :11], full.Y[1, :11])


@pytest.mark.parametrize(("arguments", "expected", "found"), [
    ({"over": {"mas": [1]}}, "a namelist variable", "mas"),
    ({"over": {"vY": (0, 1), "VY": (0, 2)}, "n": 3}, "every variable once", "vY and VY"),
    ({"over": {"mass": []}}, "at least one value", "none"),
    ({"over": {"mass": [1, 2, 3]}, "n": 4}, "a range (low, high) of mass", "[1, 2, 3]"),
    ({"over": {"mass": [1, 2]}, "n": 0}, "at least one range and 1 to 2147483647 draws", "1 and 0"),
    ({"over": {"mass": [1, 2]}, "n": 4, "draw": "sobol"}, "draw = 'random' or 'even'", "'sobol'"),
    ({"over": {"vY": [1.0]}, "columns": ["vY"]}, None, None),
    ({"over": {"mass": [1500]}, "columns": ["speed"]}, "columns among time, X", "speed"),
    ({"over": {"mass": [1500]}, "rows": 1}, "rows of at least 2", "1"),
    ({"over": {"mass": [1500]}, "threads": 0}, "at least one thread", "0"),
    ({"over": {"mass": [1500]}, "scheduler": "tcp://127.0.0.1:9"}, "a Dask scheduler", "none")])
def test_refusals(arguments, expected, found, monkeypatch):
    if "scheduler" in arguments:
        pytest.importorskip("distributed")
        monkeypatch.setattr("ldbench.ensembles.pools.CONNECT", 0.2)
    with pytest.raises(ldbench.Error) as error:
        ldbench.ensemble(short(), **arguments)
    told = error.value
    assert told.found == found if found is None else told.found.startswith(found), told
    assert told.expected.startswith(expected) if expected else "initial_vY" in str(told), told


@pytest.mark.parametrize("draw", ["random", "even"])
def test_draws(draw):
    over = {"mass": (1000, 2000), "vY": (-1, 1)}
    points = np.array(draws(over, 400, 3, draw))
    assert points.shape == (400, 2) and (points.min(0) >= [1000, -1]).all() and (points.max(0) < [2000, 1]).all()
    assert draws(over, 100, 3, draw) == draws(over, 400, 3, draw)[:100] != draws(over, 100, 4, draw)
    # Points in each of 20 x 20 cells: one of an even cover; Poisson for random ones, with exp(-1) of the cells empty.
    cells = np.histogram2d(*points.T, bins=20, range=((1000, 2000), (-1, 1)))[0]
    assert (cells == 0).mean() < (0.25 if draw == "even" else 0.45)


INTERRUPTED = """
import sys, threading, ldbench
case = ldbench.Case.from_namelist(sys.argv[1])
try:
    ldbench.ensemble([case, case.replace(t_end=2e-2)] + 3*[case], store="sweep.zarr", threads=2,
                     progress=lambda *report: print("one", flush=True))
except KeyboardInterrupt:
    print("stopped", [t.name for t in threading.enumerate() if "ldbench" in t.name])
"""


def test_control_c_stops_it_and_keeps_what_is_done(tmp_path, counted, few_results):
    """The second member is told; the first one and the others would take hours."""
    endless = short(table_folder=kept_tables(), vY=0.0, roll_rate=0.0, t_end=9e4, interval=1e-2, stop_at="t_end")
    endless.to_namelist(tmp_path/"case.nml")
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, tmp_path/"case.nml"], cwd=tmp_path, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        assert process.stdout.readline() == "one\n"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=HANG)
    finally:
        process.kill()
    assert (out.splitlines()[-1], process.returncode, err) == ("stopped []", 0, "")
    with closing(sqlite3.connect(tmp_path/".ldbench/sweep.zarr.sqlite")) as kept:
        assert kept.execute("SELECT count(*) FROM records").fetchone() == (1,)


def test_only_what_is_missing_is_run(tmp_path, table, counted, few_results):
    store = tmp_path/"sweep.zarr"
    first = ldbench.ensemble(short(), {"mass": MASSES}, columns=["Y"], store=store, tables=[table])
    assert counted["runs"] == 3
    again = ldbench.ensemble(short(), {"mass": MASSES}, columns=["Y"], store=store, tables=[table])
    assert counted["runs"] == 3 and again.identical(first)
    more = ldbench.ensemble(short(), {"mass": [*MASSES, 1900.0, -1.0]}, columns=["Y"], store=store, tables=[table])
    assert counted["runs"] == 4 and more.isel(mass=slice(3)).drop_vars("error").identical(first.drop_vars("error"))
    with xr.open_zarr(store) as stored:
        assert stored.load().identical(more)
    assert {path.name for path in (tmp_path/".ldbench").iterdir()} == {"sweep.zarr.sqlite", "sweep.zarr.lock"}


def test_a_changed_case_uses_no_old_result(tmp_path, table, counted, monkeypatch, few_results):
    """The key of a member, under which its result is kept, changes with all that the result depends on, and comes back."""
    for name in "awprof.yz", "arprof.yz":
        shutil.copy(ldbench.Case.exercise(3).find(f"profiles/{name}"), tmp_path)
    wheel = tmp_path/"awprof.yz"
    case = short(t_end=1e-3, wheel_profile=wheel, rail_profile=tmp_path/"arprof.yz")

    def keys(case: ldbench.Case, *columns: str) -> set[str]:
        some, _, _ = members.plan(case, {"mass": MASSES[:2]}, None, 0, "random")
        return set(members.keys_of(some, members.Wanted(columns, None)))

    def new_runs() -> int:
        before = counted["runs"]
        ldbench.ensemble(case, {"mass": MASSES[:2]}, store=tmp_path/"sweep.zarr", tables=[table])
        return counted["runs"] - before

    known = keys(case)
    assert (new_runs(), new_runs()) == (2, 0)
    found = [known, keys(case.replace(dt=2e-5)), keys(case.replace(vertical_load=164619.0)), keys(case, "time", "Y")]
    original = wheel.read_text()
    wheel.write_text(re.sub(r"(\d\.\d{8})[1-9]\n", r"\g<1>0\n", original, count=1))
    assert wheel.read_text() != original and new_runs() == 2
    found.append(keys(case))
    wheel.write_text(original)
    assert keys(case) == known
    monkeypatch.setattr(members, "program_digest", lambda: "another build")
    found.append(keys(case))
    assert len(set().union(*found)) == 2*len(found) == 12


def test_a_store_is_written_in_parts(tmp_path, table, monkeypatch, few_results):
    """Along the longest dimension; texts and rows of columns of the parts differ in length."""
    over = {"t_end": [1e-3, 2e-3], "mass": [-1.0, 1500.0]}
    expected = ldbench.ensemble(short(), over, columns=["Y"], tables=[table])
    monkeypatch.setattr("ldbench.ensembles.store.HELD", 1.0)
    assert ldbench.ensemble(short(), over, columns=["Y"], tables=[table], store=tmp_path/"sweep.zarr").identical(expected)


def test_damaged_results_are_told(tmp_path, table, few_results):
    over = {"mass": MASSES}
    ldbench.ensemble(short(t_end=1e-3), over, store=tmp_path/"sweep.zarr", tables=[table])
    (tmp_path/".ldbench/sweep.zarr.sqlite").write_bytes(b"no records")
    with pytest.raises(ldbench.Error, match="expected results that an ensemble kept, found them damaged"):
        ldbench.ensemble(short(t_end=1e-3), {"mass": [*MASSES, 1900.0]}, store=tmp_path/"sweep.zarr", tables=[table])


WAITED = rb"(?:<string>:1: Warning: sweep\.zarr: waiting for another process that writes it\n)?"


@pytest.mark.filterwarnings("ignore:.*sweep.zarr. waiting for another process")
def test_two_processes_with_one_store_leave_what_one_would(tmp_path, table):
    """Whichever is first; what one has done the other one need not do. The other one begins when this one is told to."""
    over, case = {"mass": MASSES}, short(t_end=1e-3, table_folder=kept_tables())
    expected = ldbench.ensemble(case, over, tables=[table])
    script = ("import ldbench, xarray, zarr; case = ldbench.Case.from_namelist('case.nml'); print(flush=True); input(); "
              f"ldbench.ensemble(case, {over}, store='sweep.zarr')")
    case.to_namelist(tmp_path/"case.nml")
    other = subprocess.Popen([sys.executable, "-c", script], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE)
    try:
        assert other.stdout.readline() == b"\n"
        other.stdin.write(b"\n")
        other.stdin.flush()
        here = ldbench.ensemble(case, over, tables=[table], store=tmp_path/"sweep.zarr")
        said = other.communicate(timeout=HANG)[1]
        assert other.returncode == 0 and re.fullmatch(WAITED, said), said
        assert here.identical(expected)
    finally:
        other.kill()
    with xr.open_zarr(tmp_path/"sweep.zarr") as stored:
        assert stored.load().identical(expected)
    assert {file.name for file in tmp_path.iterdir()} == {".ldbench", "case.nml", "sweep.zarr"}


def test_a_store_is_not_written_over_something_else(tmp_path, few_results):
    (tmp_path/"notes.txt").write_text("mine\n")
    for k, version in enumerate((2, 3)):
        xr.Dataset({"mine": ("x", [1.0, 2.0])}).to_zarr(tmp_path/f"mine{k}.zarr", zarr_format=version)
    (tmp_path/"folder").mkdir()
    for name in "notes.txt", "mine0.zarr", "mine1.zarr", "folder":
        with pytest.raises(ldbench.Error, match=f"{name}: expected a Zarr directory that an ensemble has made, or nothing"):
            ldbench.ensemble(short(), {"mass": MASSES}, store=tmp_path/name)
    assert xr.open_zarr(tmp_path/"mine0.zarr").mine.values.tolist() == [1, 2]
    assert not (tmp_path/".ldbench").exists()


def test_a_worker_dies_and_nothing_is_lost(tmp_path, table, counted, few_results):
    """The other one goes on; the results are those of this process's threads."""
    pytest.importorskip("distributed")
    over = {"vY": [0.9, 1.0], "mass": np.linspace(1000, 2000, 5).tolist() + [-1.0]}
    case, store = short(table_folder=kept_tables()), tmp_path/"sweep.zarr"
    cluster, done = Cluster(tmp_path, 2), []

    def kill(stage: str, share: float) -> None:
        done.append(share)
        if len(done) == 4:
            cluster.processes[1].kill()

    try:
        found = ldbench.ensemble(case, over, columns=["Y"], scheduler=cluster.address, store=store, progress=kill)
        assert cluster.processes[1].wait(HANG) == -signal.SIGKILL and done[-1] == 1 and not counted
    finally:
        cluster.stop()
    # Restarted without the cluster: nothing is left to do.
    assert ldbench.ensemble(case, over, columns=["Y"], store=store).identical(found) and not counted
    assert found.identical(ldbench.ensemble(case, over, columns=["Y"], tables=[table]))


def test_command(tmp_path, capsys):
    short(t_end=1e-3).to_namelist(tmp_path/"case.nml")
    assert main(["ensemble", str(tmp_path/"case.nml"), "--over", "mass=1400,-1", "--over", "vY=0:1:2", "--columns", "Y,N_LF",
                 "-j", "2", "-o", str(tmp_path/"sweep.zarr")]) == 1     # not all is done
    out = capsys.readouterr().out
    with xr.open_zarr(tmp_path/"sweep.zarr") as stored:
        assert {"Y", "N_LF"} <= set(stored.data_vars) and dict(stored.error.sizes) == {"mass": 2, "vY": 2}
    assert out.startswith("2 mass x 2 vY: 4 runs, 2 failed\nfirst failure: ")
    assert "2 ended with t_end" in out and "sweep.zarr" in out
    assert main(["ensemble", str(tmp_path/"case.nml"), "--over", "mass=1200,1400,3000", "-o", str(tmp_path/"mass.zarr")]) == 0
    line = re.search(r"peak_N_LT \[kN\]: (\S+) to (\S+), median (\S+)", capsys.readouterr().out)
    least, largest, median = map(float, line.groups())
    with xr.open_zarr(tmp_path/"mass.zarr") as stored:
        peaks = np.sort(1e-3*stored.peak_N_LT.values)
    assert (least, median, largest) == pytest.approx(peaks, rel=1e-5) and abs(peaks[1] - peaks.mean()) > 1e-3*peaks[1]
    assert main(["ensemble", str(tmp_path/"case.nml"), "--over", "mass=-1,-2"]) == 1
    said = capsys.readouterr().err
    assert said.startswith("ldbench: error: ensemble: expected a run that succeeds, found 2 that failed, the first one with: ")


def test_an_ensemble_takes_a_path_and_arrays(tmp_path):
    """As `run` does; a text is no list of cases."""
    short(t_end=1e-3).to_namelist(tmp_path/"case.nml")
    table = ldbench.ContactTable(short())
    expected = ldbench.ensemble(short(t_end=1e-3), {"mass": [1400.0, 1500.0]}, tables=[table])
    assert dict(expected.error.sizes) == {"mass": 2}
    for path in tmp_path/"case.nml", str(tmp_path/"case.nml"):
        assert ldbench.ensemble(path, {"mass": np.linspace(1400, 1500, 2)}, tables=[table]).identical(expected)
    with pytest.raises(FileNotFoundError):
        ldbench.ensemble("none.nml", {"mass": [1400.0]})
