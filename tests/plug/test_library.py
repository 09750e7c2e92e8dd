"""The library for other languages: its forces and motions are those of the program, and bad input is a status and a line."""
from __future__ import annotations

import ctypes
import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import ldbench
from ldbench_library import Facts, Wheelset
from running import FORTRAN_TESTS, REPO, kept_tables

CLIENTS = REPO/"docs/plug"
LIBRARY = FORTRAN_TESTS.parent/"lib/libldbench.so"
NO_ROOM = 3       # a status of ldbench.h
Pose = ctypes.c_double*3

if not LIBRARY.is_file():
    pytest.skip(f"no {LIBRARY}, which `make test` makes by gfortran alone", allow_module_level=True)
needs_cc = pytest.mark.skipif(not shutil.which("cc"), reason="no compiler of C by the name cc")


@pytest.fixture(scope="module")
def namelist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("case")/"ex2_aw.nml"
    ldbench.Case.exercise(2).replace(t_end=0.15, table_folder=kept_tables(), wheel_profile=REPO/"profiles/awprof.yz",
                                     rail_profile=REPO/"profiles/arprof.yz").to_namelist(file)
    return file


@pytest.fixture(scope="module")
def wheelset(namelist: Path) -> Iterator[Wheelset]:
    found = Wheelset(str(LIBRARY), str(namelist), str(kept_tables()))
    yield found
    found.call("close", found.handle)


@pytest.fixture(scope="module")
def table(namelist: Path) -> ldbench.ContactTable:
    return ldbench.ContactTable(ldbench.Case.from_namelist(namelist))


def poses(table: ldbench.ContactTable, n: int) -> np.ndarray:
    """Poses along a run, for which the kept table has all that they need, (3, n)."""
    data = ldbench.run(table.case, table=table).data
    rows = data.iloc[np.linspace(0, len(data) - 1, n).astype(int)]
    return np.array([rows["Y"], rows["Z"] + table.equilibrium, rows["roll"]])


@pytest.mark.same_build
def test_forces_are_the_program_s_to_the_last_bit(wheelset: Wheelset, table: ldbench.ContactTable):
    y, z, roll = poses(table, 200)
    energy, force = table.potential(y, z, roll), table.force(y, z, roll)
    for k in range(200):
        found = wheelset.contact((y[k], z[k], roll[k]))
        assert found[0] == energy[k] and list(found[1]) == force[k].tolist()
    assert energy.max() > 10*energy.min()


@pytest.mark.same_build
def test_rows_are_the_program_s_to_the_last_bit(wheelset: Wheelset, namelist: Path):
    run = ldbench.run(namelist)
    n, shape = ctypes.c_int(), (len(run.data), len(run.data.columns))
    rows, results = np.zeros(shape), ctypes.create_string_buffer(100000)
    address = rows.ctypes.data_as(ctypes.c_void_p)
    wheelset.call("simulate", wheelset.handle, len(rows), address, ctypes.byref(n), 0, None, None, results, len(results))
    assert n.value == len(run.data) and np.array_equal(rows, run.data.to_numpy(), equal_nan=True)
    assert f"t_return = {run.results['t_return']!r}" in results.value.decode()
    names = ctypes.create_string_buffer(4096)
    assert wheelset.lib.ldbench_columns(wheelset.handle, names, len(names)) == 0
    assert [line.split()[0] for line in names.value.decode().splitlines()] == list(run.data.columns)
    # Fewer rows than the run has: as many as there is room for, and all are counted.
    few = np.zeros((10, shape[1]))
    status = wheelset.lib.ldbench_simulate(wheelset.handle, 10, few.ctypes.data_as(ctypes.c_void_p), ctypes.byref(n), 0, None, None,
                                           None, 0, None, 0)
    assert status == NO_ROOM and n.value == len(run.data) and np.array_equal(few, rows[:10], equal_nan=True)


@pytest.mark.same_build
def test_stiffness_is_the_gradient_of_the_force(wheelset: Wheelset, table: ldbench.ContactTable):
    pose, stiffness = (0.002, table.equilibrium, 1e-4), (ctypes.c_double*6)()
    wheelset.call("contact", wheelset.handle, Pose(*pose), None, None, None, stiffness)
    assert np.array(stiffness)[[0, 1, 2, 3, 4, 5]].tolist() == table.tangent(*pose)[np.triu_indices(3)].tolist()


@pytest.fixture(scope="module")
def centre(namelist: Path) -> list[float]:
    """Times at which our run passes the centre [s]."""
    return [event.t for event in ldbench.run(namelist).events if event.kind == "centre passage"]


def said_by(*command: object, **environment: str) -> list[str]:
    """The words that a client prints."""
    return subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, **environment}).stdout.split()


def test_another_integrator_passes_the_centre_at_the_same_time(namelist: Path, centre: list[float]):
    said = said_by(sys.executable, CLIENTS/"scipy_client.py", LIBRARY, namelist, str(kept_tables()))
    assert [float(t) for t in said[:-1]] == pytest.approx(centre, abs=1e-7)
    assert abs(float(said[-1])) < 1e-5          # energy [J], of which 196 move


def test_exudyn_passes_the_centre_at_the_same_time(namelist: Path, centre: list[float]):
    pytest.importorskip("exudyn", reason="no Exudyn: pip install exudyn")
    import exudyn_client
    import ldbench_library

    wheelset = Wheelset(str(LIBRARY), str(namelist), str(kept_tables()))
    t, y, v, *_ = exudyn_client.rows(wheelset, 0.07).T
    assert ldbench_library.passages(t, y, v) == pytest.approx(centre[:1], abs=1e-7)
    wheelset.call("close", wheelset.handle)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str]]:
    """Where `make install-lib` has installed, and what pkg-config tells a compiler. Names of folders have blanks."""
    if not shutil.which("pkg-config"):
        pytest.skip("no pkg-config, which tells a compiler where the library is")
    prefix = tmp_path_factory.mktemp("a place")/"a prefix"
    options = ["DEBUG=1"] if LIBRARY.parents[1].name == "debug" else []
    subprocess.run(["make", "install-lib", *options, f"PREFIX={prefix}"], cwd=REPO, check=True, stdout=subprocess.DEVNULL)
    told = subprocess.run(["pkg-config", "--cflags", "--libs", "ldbench"], capture_output=True, text=True, check=True,
                          env={**os.environ, "PKG_CONFIG_PATH": str(prefix/"lib/pkgconfig")}).stdout
    return prefix/"lib", shlex.split(told)


@needs_cc
def test_a_program_in_c(namelist: Path, installed: tuple[Path, list[str]], tmp_path: Path):
    """It is built by what pkg-config tells alone."""
    folder, told = installed
    subprocess.run(["cc", "-Wall", "-Wextra", "-Werror", CLIENTS/"client.c", *told, "-o", tmp_path/"client"], check=True)
    said = said_by(tmp_path/"client", namelist, "0.15", "0.001", kept_tables(), LD_LIBRARY_PATH=str(folder))
    t, y, vy, force, energy = np.array(said, float).reshape(-1, 5)[:151].T
    case = ldbench.Case.from_namelist(namelist).replace(rows="interval", interval=1e-3, stop_at="t_end", t_end=0.15)
    data = ldbench.run(case).data
    assert np.allclose(t, data["time"], atol=1e-12) and np.allclose(y, data["Y"], atol=1e-10, rtol=0)
    assert np.allclose(vy, data["vY"], atol=1e-7) and np.allclose(force, data["N_LF"], rtol=1e-5) and np.ptp(energy) < 1e-6


def test_octave_passes_the_centre_at_the_same_time(namelist: Path, centre: list[float], installed: tuple[Path, list[str]],
                                                   tmp_path: Path):
    if not (shutil.which("mkoctfile") and shutil.which("octave-cli")):
        pytest.skip("no Octave: apt-get install octave octave-dev")
    folder, told = installed
    subprocess.run(["mkoctfile", "--mex", "-o", tmp_path/"ldbench_octave", CLIENTS/"ldbench_octave.c",
                    f"-I{REPO/'fortran/library'}", f"-L{LIBRARY.parent}", told[-1]], cwd=tmp_path, check=True)
    done = subprocess.run(["octave-cli", "--quiet", "--path", tmp_path, CLIENTS/"octave_client.m", namelist, "0.07"], check=True,
                          capture_output=True, text=True, env={**os.environ, "LD_LIBRARY_PATH": str(folder)})
    assert [float(t) for t in done.stdout.split()] == pytest.approx(centre[:1], abs=1e-7)


def test_numbers_of_the_case_can_be_changed(namelist: Path):
    wheelset = Wheelset(str(LIBRARY), str(namelist), str(kept_tables()))
    for name, value in (("vY", 0.3), ("mass", 2000.0)):
        wheelset.call("set", wheelset.handle, name.encode(), ctypes.c_double(value))
    found, facts = ctypes.c_double(), Facts()
    wheelset.call("get", wheelset.handle, b"vY", ctypes.byref(found))
    wheelset.call("facts", wheelset.handle, ctypes.byref(facts))
    case = ldbench.Case.from_namelist(namelist).replace(vY=0.3, mass=2000)
    heavier = ldbench.ContactTable(case)
    assert found.value == 0.3 and facts.mass == 2000 and facts.weight == heavier.weight and facts.held[1] == heavier.equilibrium
    text = ctypes.create_string_buffer(1024)
    assert wheelset.lib.ldbench_warnings(wheelset.handle, text, len(text)) == 0
    assert text.value.decode().startswith("&initial roll_rate: expected about 0.0101")
    wheelset.call("close", wheelset.handle)


@pytest.mark.same_build
@pytest.mark.parametrize(("kept", "n"), [(True, 2000), (False, 50)], ids=["table kept", "table empty"])
def test_eight_threads_get_the_same_bits(kept: bool, n: int, namelist: Path, table: ldbench.ContactTable):
    """With an empty table all of them solve what it lacks."""
    wheelset = Wheelset(str(LIBRARY), str(namelist), str(kept_tables()) if kept else None)
    y, z, roll = poses(table, n)
    expected = table.force(y, z, roll)
    different = []

    def work(seed: int) -> None:
        for k in np.random.default_rng(seed).permutation(n):
            energy, force = ctypes.c_double(), Pose()
            pose = Pose(y[k], z[k], roll[k])
            status = wheelset.lib.ldbench_contact(wheelset.handle, pose, ctypes.byref(energy), force, None, None, None, 0)
            if status or list(force) != expected[k].tolist():
                different.append(k)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert different == []
    wheelset.call("close", wheelset.handle)


@needs_cc
def test_bad_input_from_a_program_in_c(tmp_path: Path):
    """A status and a line, and nothing is changed. With SANITIZE=1 the program and the library are watched: no access outside what
    was given, nothing lost at the end."""
    sanitize = ["-fsanitize=address,undefined", "-fno-sanitize-recover"] if LIBRARY.parents[1].name == "sanitize" else []
    subprocess.run(["cc", "-g", "-Wall", "-Wextra", "-Werror", *sanitize, REPO/"tests/plug/abuse.c", f"-I{REPO/'fortran/library'}",
                    LIBRARY, "-lm", f"-Wl,-rpath,{LIBRARY.parent}", "-o", tmp_path/"abuse"], check=True)
    (tmp_path/"case.nml").write_text("&contact model = 'hertz' / &integrator t_end = 1e-3 /\n")
    done = subprocess.run([tmp_path/"abuse", tmp_path/"case.nml", tmp_path], cwd=REPO, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.skipif(not shutil.which("nm"), reason="no nm, which lists the names in a library")
def test_nothing_but_the_functions_is_exported():
    said = subprocess.run(["nm", "-D", "--defined-only", LIBRARY], capture_output=True, text=True, check=True).stdout
    declared = set(re.findall(r"^int (ldbench_\w+)\(", (REPO/"fortran/library/ldbench.h").read_text(), re.MULTILINE))
    assert {line.split()[-1] for line in said.splitlines()} == declared
