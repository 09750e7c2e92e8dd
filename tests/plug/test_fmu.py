"""FMUs: valid by FMPy, and the same motion by another integrator and by our own."""
from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

import ldbench
from fmpy_client import __file__ as client
from ldbench.__main__ import main
from ldbench.fmu import BINARIES, write_fmu
from running import kept_tables


@pytest.fixture(scope="module")
def case() -> ldbench.Case:
    """A case of the law whose tables take the least time, fine enough for another integrator to agree."""
    return ldbench.Case.exercise(2).replace(table_folder=kept_tables(), t_end=0.15, model="hertz", accuracy=5e-4)


@pytest.fixture(scope="module")
def fmus(case: ldbench.Case, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMUs of the wheelset and of its contacts alone, as the command writes them."""
    if not (BINARIES/"linux64/wheelset.so").is_file():
        pytest.skip("no binary of FMUs, which `make fmu` makes by gfortran alone")
    folder = tmp_path_factory.mktemp("fmus")
    case.to_namelist(folder/"case.nml")
    for name, *options in ["wheelset"], ["contact", "--contact"]:
        assert main(["fmu", str(folder/"case.nml"), "-o", str(folder/f"{name}.fmu"), *options]) == 0
    return folder


def test_they_are_valid(fmus: Path):
    assert {name: validate_fmu(fmus/f"{name}.fmu") for name in ("wheelset", "contact")} == {"wheelset": [], "contact": []}


def test_it_is_the_same_bytes_again(fmus: Path, tmp_path: Path):
    """Also from Python."""
    write_fmu(ldbench.Case.from_namelist(fmus/"case.nml"), tmp_path/"again.fmu")
    assert (tmp_path/"again.fmu").read_bytes() == (fmus/"wheelset.fmu").read_bytes()


def test_the_client_passes_the_centre_at_the_same_time(fmus: Path, case: ldbench.Case):
    """By the integrator of another program, and by our own in co-simulation."""
    said = subprocess.run([sys.executable, client, fmus/"wheelset.fmu"], capture_output=True, text=True, check=True,
                          env={**os.environ, "PYTHONPATH": ""}).stdout
    events = [event.t for event in ldbench.run(case).events if event.kind == "centre passage"]
    found = {kind: [float(t) for t in times] for kind, *times in map(str.split, said.splitlines())}
    assert found.keys() == {"ModelExchange", "CoSimulation"} and events
    assert found["ModelExchange"] == pytest.approx(events, abs=1e-7)
    assert found["CoSimulation"] == pytest.approx(events, abs=1e-8)


@pytest.mark.filterwarnings("ignore:&initial roll_rate. expected about")
def test_parameters_are_those_of_the_namelist(fmus: Path, case: ldbench.Case):
    other = case.replace(vY=0.3, mass=2000, lateral_force=5e3, rows="interval", interval=1e-3, t_end=0.03, stop_at="t_end")
    found = simulate_fmu(fmus/"wheelset.fmu", fmi_type="CoSimulation", stop_time=0.03, output_interval=1e-3,
                        output=["y", "vy", "N_RT"],
                        start_values={"initial.vY": 0.3, "wheelset.mass": 2000.0, "loading.lateral_force": 5e3})
    data = ldbench.run(other).data
    assert found["y"] == pytest.approx(data["Y"].to_numpy(), abs=1e-9)
    assert found["vy"] == pytest.approx(data["vY"].to_numpy(), abs=1e-6)
    assert found["N_RT"] == pytest.approx(data["N_RT"].to_numpy(), rel=1e-4)


def test_contact_gives_what_the_program_s_row_has(fmus: Path, case: ldbench.Case):
    """Forces of all contacts to the last bit, and each number of each contact."""
    data = ldbench.run(case).data
    row = data.iloc[data["N_LF"].argmax()]
    table = ldbench.ContactTable(case)
    pose = row["Y"], row["Z"] + table.equilibrium, row["roll"]
    of_contacts = [f"{what}_{contact}" for contact in ("LT", "LF", "RT", "RF")
                   for what in ("N", "angle", "Fy", "Fz", "y", "z", "radius")]
    found = simulate_fmu(fmus/"contact.fmu", fmi_type="CoSimulation", stop_time=1e-3, output_interval=1e-3,
                        start_values=dict(zip(("y", "z", "roll"), pose, strict=True)),
                        output=["F_y", "F_z", "M_x", "elastic_energy", *of_contacts])[-1]
    assert [found[name] for name in ("F_y", "F_z", "M_x")] == table.force(*pose).tolist()
    assert found["elastic_energy"] == table.potential(*pose)
    closed = [name for name in of_contacts if row[f"N_{name[-2:]}"] > 0]
    assert {name[-2:] for name in closed} >= {"LF", "RT"}
    assert [found[name] for name in closed] == pytest.approx([row[name] for name in closed], rel=1e-7)


def test_variables_say_what_they_are(fmus: Path):
    """Words and units by the letters of the names: F_y is the lateral force, Fz_LF the vertical one of the left flange."""
    meant = {"F_y": ("lateral force", "N"), "F_z": ("vertical force", "N"), "M_x": ("moment", "N.m"), "N": ("normal force", "N"),
             "Fy": ("lateral force", "N"), "Fz": ("vertical force", "N"), "F_ext": ("lateral force", "N"),
             "kinetic_energy": ("energy", "J"), "elastic_energy": ("elastic energy", "J"), "y": ("lateral", "m"),
             "z": ("height", "m"), "roll": ("roll", "rad"), "vy": ("lateral velocity", "m/s"), "vz": ("vertical velocity", "m/s"),
             "roll_rate": ("roll", "rad/s")}
    for model in "wheelset", "contact":
        said = {one.name: one for one in read_model_description(fmus/f"{model}.fmu").modelVariables}
        seen = {name: one for name, one in said.items() if (name if name in meant else name.rpartition("_")[0]) in meant}
        assert len(seen) > 12
        for name, one in seen.items():
            words, unit = meant[name if name in meant else name.rpartition("_")[0]]
            assert words in one.description and one.unit == unit, (name, one.description, one.unit)
            assert name in meant or one.description.endswith(name[-2:])


def test_eight_instances_at_once_have_the_same_bits(fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """In one folder, which stays: FMPy changes the working folder of the process while it loads a library."""
    monkeypatch.chdir(tmp_path)
    folder = extract(fmus/"wheelset.fmu", tmp_path/"unzipped")

    def work(_: int) -> bytes:
        found = simulate_fmu(folder, fmi_type="CoSimulation", stop_time=0.03, output_interval=1e-3, output=["y", "N_LF"])
        return found.tobytes()

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(work, range(8)))) == 1


def test_a_state_is_given_back(fmus: Path, case: ldbench.Case, tmp_path: Path):
    """With its parameters; accelerations and energies are those of the forces. The folder's name has blanks and other letters."""
    folder, about = extract(fmus/"wheelset.fmu", tmp_path/"a pläce"), read_model_description(fmus/"wheelset.fmu")
    at = {one.name: one.valueReference for one in about.modelVariables}
    model = FMU2Slave(guid=about.guid, unzipDirectory=folder, modelIdentifier="wheelset", instanceName="one")

    def values(*names: str) -> np.ndarray:
        return np.array(model.getReal([at[name] for name in names]))

    states = "y", "z", "roll", "vy", "vz", "roll_rate"
    model.instantiate()
    model.setupExperiment()
    model.setReal([at["loading.lateral_ramp"]], [1e6])
    model.enterInitializationMode()
    model.exitInitializationMode()
    bytes_of_it = model.serializeFMUState(model.getFMUState())
    model.doStep(0.0, 1e-2)
    there = values(*states)
    assert values("F_ext") == pytest.approx(1e4) and np.isfinite(there).all()
    inertia = [case.mass, case.mass, case.roll_inertia]
    forces = values("F_y", "F_z", "M_x") + [1e4, -ldbench.ContactTable(case).weight, 0]
    assert values("der(vy)", "der(vz)", "der(roll_rate)") == pytest.approx(forces/inertia)
    assert values("der(y)", "der(z)", "der(roll)") == pytest.approx(there[3:])
    assert values("kinetic_energy") == pytest.approx(0.5*np.square(there[3:]) @ inertia)
    model.setReal([at["loading.lateral_ramp"]], [0.0])
    with pytest.raises(FMICallException):        # after the initialization
        model.setReal([at["initial.vY"]], [1.0])
    model.setFMUState(model.deserializeFMUState(bytes_of_it))
    assert values("y") == [0.0]
    model.doStep(0.0, 1e-2)
    assert values(*states).tolist() == there.tolist()
    model.terminate()
    model.freeInstance()


def test_it_runs_without_the_libraries_of_the_compiler(fmus: Path, tmp_path: Path):
    """Only the C library and the libraries inside are asked for."""
    with zipfile.ZipFile(fmus/"wheelset.fmu") as archive:
        archive.extractall(tmp_path)
    folder = tmp_path/"binaries/linux64"
    said = subprocess.run(["ldd", folder/"wheelset.so"], capture_output=True, text=True, check=True,
                          env={**os.environ, "LD_LIBRARY_PATH": ""}).stdout
    needed = {line.split()[0]: line.split()[2] for line in said.splitlines() if "=>" in line}
    own = {name: Path(path).parent for name, path in needed.items() if not name.startswith(("libc.", "libm.", "libpthread"))}
    assert len(own) >= 3 and set(own.values()) == {folder}
    assert "not found" not in said


def test_refusals(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    ldbench.Case.exercise(2).replace(formulation="bilateral").to_namelist(tmp_path/"rigid.nml")
    rigid, fmu, archive = (str(tmp_path/name) for name in ("rigid.nml", "a.fmu", "a.zip"))
    for words, status, told in ((["none.nml"], 1, "none.nml"), ([rigid, "-o", fmu], 1, "'elastic'"), ([], 2, "required"),
                                (["inputs/ex2_aw.nml", "-o", archive], 1, "with the ending .fmu")):
        assert main(["fmu", *words]) == status
        assert told in capsys.readouterr().err
    assert not list(tmp_path.glob("a.*"))


def test_an_installation_without_binaries_says_what_to_do(case: ldbench.Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A wheel has none."""
    monkeypatch.setattr("ldbench.fmu.BINARIES", tmp_path/"none")
    with pytest.raises(ldbench.Error, match=r"none: expected binaries of FMUs, which `make fmu` makes in a folder of the sources"):
        write_fmu(case, tmp_path/"a.fmu")
    assert list(tmp_path.iterdir()) == []
