"""Exercises 1 to 4 by other programs on our force, up to the first passage of the centre after the left flange.

`python docs/measure.py plug` stores how far these are from ours.
"""
from __future__ import annotations

import ctypes
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Model

import ldbench
from ldbench import Case
from ldbench.fmu import write_fmu

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT/"docs/plug"))
LIBRARY = ROOT/"build/release/lib"
CASES = [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
INTERVAL = 1e-5             # of rows [s]
DOUBLES = ctypes.POINTER(ctypes.c_double)
Rows = np.ndarray           # time, Y, vY, normal force of the left flange, total energy, one after the other


def measure() -> dict[str, float]:
    """Passages, peaks, drifts and times per force."""
    subprocess.run(["make", "lib", "fmu"], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    values: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run(["cc", "-O2", ROOT/"docs/plug/client.c", f"-I{LIBRARY}", f"-L{LIBRARY}", "-lldbench", "-o", folder/"client"],
                       check=True)
        for case in CASES:
            values |= of_case(case, folder)
            print(case, flush=True)
    return values


def of_case(name: str, folder: Path) -> dict[str, float]:
    """The answers of a case: ours, and the differences of each client's."""
    case = Case.exercise(int(name[2]), name[-2:])
    case = case.replace({key: ROOT/value for key, value in case.files().items()} | {
        "table_folder": folder/"tables", "stop_at": "t_end", "judged": "no", "pressures": "no"})
    centre = ldbench.run(case).results["t_first_centre"]
    case = case.replace(t_end=np.ceil(1.02*centre/INTERVAL)*INTERVAL)
    namelist, fmu = folder/f"{name}.nml", folder/f"{name}.fmu"
    case.to_namelist(namelist)
    write_fmu(case, fmu)
    ours = ldbench.run(case)
    kinetic, peak = ours.results["kinetic_energy"], ours.results["first_peak_N_LF"]
    values = {f"{name}.passage [s]": centre, f"{name}.peak [kN]": peak/1e3, f"{name}.drift": ours.results["drift_relative"]}
    for client, run in programs(namelist, fmu, folder, case.t_end):
        t, force, drift = answers(run())
        values |= {f"{name}.{client}.passage [s]": t - centre, f"{name}.{client}.peak [kN]": (force - peak)/1e3,
                   f"{name}.{client}.drift": drift/kinetic}
    if name == CASES[2]:
        with zipfile.ZipFile(fmu) as archive:
            values["size [MB]"] = sum(one.compress_size for one in archive.infolist() if "win64" not in one.filename)/1e6
        values |= {f"per force.{words} [us]": 1e6*x for words, x in times(namelist, fmu, folder, ours)}
    return values


def programs(namelist: Path, fmu: Path, folder: Path, t_end: float) -> Iterator[tuple[str, Callable[[], Rows]]]:
    """Each client, and what gives its rows."""
    import fmpy_client
    import scipy_client
    from ldbench_library import Wheelset

    words = str(LIBRARY/"libldbench.so"), str(namelist), str(folder/"tables")
    wheelset = Wheelset(*words)

    def by_fmu(kind: str) -> Rows:
        t, y, v, force, z, elastic, kinetic = fmpy_client.rows(str(fmu), kind, t_end, INTERVAL)
        return np.array([t, y, v, force, elastic + kinetic + wheelset.facts.weight*z])

    def by_c() -> Rows:
        said = subprocess.run([folder/"client", namelist, repr(t_end), repr(INTERVAL), folder/"tables"], check=True,
                              capture_output=True, text=True, env={**os.environ, "LD_LIBRARY_PATH": str(LIBRARY)}).stdout
        return np.array([line.split() for line in said.splitlines()], float).T

    yield "ctypes, SciPy", lambda: scipy_client.rows(wheelset, t_end, INTERVAL)[0].T
    yield "FMU, FMPy", lambda: by_fmu("ModelExchange")
    yield "FMU, FMPy, co-simulation", lambda: by_fmu("CoSimulation")
    yield "C", by_c
    if importlib.util.find_spec("exudyn"):
        import exudyn_client
        yield "ctypes, Exudyn", lambda: exudyn_client.rows(wheelset, t_end).T
    wheelset.call("close", wheelset.handle)


def answers(rows: Rows) -> tuple[float, float, float]:
    """The first passage of the centre [s], the largest force of the left flange before it [N], the largest change of energy [J]."""
    from ldbench_library import passages

    t, y, v, force, energy = rows
    centre = passages(t, y, v)[0]
    k = int(force[t < centre].argmax())
    before, at, behind = force[k - 1:k + 2]         # a parabola through three rows
    return centre, at + (behind - before)**2/(8*(2*at - before - behind)), float(np.abs(energy - energy[0]).max())


def times(namelist: Path, fmu: Path, folder: Path, ours: ldbench.Run) -> Iterator[tuple[str, float]]:
    """Processor time of one force [s], in poses of the run."""
    from ldbench_library import Wheelset

    wheelset = Wheelset(str(LIBRARY/"libldbench.so"), str(namelist), str(folder/"tables"))
    rows = ours.data.iloc[::10]
    poses = np.array([rows["Y"], rows["Z"] + wheelset.facts.held[1], rows["roll"]]).T

    def per_pose(call: Callable[[np.ndarray], object]) -> float:
        for _ in range(2):
            start = time.process_time()
            for pose in poses:
                call(pose)
        return (time.process_time() - start)/len(poses)

    yield "our program", ours.seconds/ours.results["evaluations"]
    yield "ctypes", per_pose(wheelset.contact)
    about = read_model_description(fmu)
    unzipped = extract(fmu, folder/"unzipped")
    model = FMU2Model(guid=about.guid, unzipDirectory=unzipped, modelIdentifier="wheelset", instanceName="one")
    model.instantiate()
    model.setupExperiment()
    model.enterInitializationMode()
    model.exitInitializationMode()
    states, rates = np.zeros(6), np.zeros(6)

    def by_fmu(pose: np.ndarray) -> None:
        states[:3] = pose
        model.setContinuousStates(states.ctypes.data_as(DOUBLES), 6)
        model.getDerivatives(rates.ctypes.data_as(DOUBLES), 6)

    yield "FMU, FMPy", per_pose(by_fmu)
    model.terminate()
    model.freeInstance()
