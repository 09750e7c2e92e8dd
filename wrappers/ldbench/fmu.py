"""Functional Mock-up Units (FMI 2.0) of a case: the wheelset for model exchange and co-simulation, or its contacts alone.

The binary is `fortran/library/fmi2.c` on the library for C. Value references are those of its list.
"""
from __future__ import annotations

import hashlib
import tempfile
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from ._core.calls import version
from ._core.errors import Error
from ._core.files import check_ending, complete
from .case import Case, find_variable, variables
from .constants import CONTACTS
from .runs import compute
from .table import core_files

PLATFORMS = {"linux64": "wheelset.so", "win64": "wheelset.dll"}     # folders of binaries by FMI 2.0, and the file in ours
BINARIES = Path(__file__).parent/"_core"/"fmu"
EPOCH = 1980, 1, 1, 0, 0, 0         # of all files in the archive: the same case gives the same bytes
STATES = (("y", "m", "lateral position of the axle's centre, to the left"),
          ("z", "m", "height of the axle's centre above the rails"),
          ("roll", "rad", "roll angle; a positive one lifts the left wheel"), ("vy", "m/s", "lateral velocity"),
          ("vz", "m/s", "vertical velocity"), ("roll_rate", "rad/s", "roll rate"))
RATES = "m/s", "m/s", "rad/s", "m/s2", "m/s2", "rad/s2"
ELASTIC, KINETIC, FORCE, LOAD, CONTACT, PARAMETER = 12, 13, 14, 17, 20, 100     # value references
OF_CONTACT = (("N", "N", "normal force"), ("angle", "rad", "contact angle"), ("Fy", "N", "lateral force on the wheel"),
              ("Fz", "N", "vertical force on the wheel"), ("y", "m", "lateral position of the contact"),
              ("z", "m", "height of the contact"), ("radius", "m", "rolling radius"), ("energy", "J", "elastic energy"))
PARAMETERS = ("wheelset_mass", "wheelset_roll_inertia", "wheelset_pitch_inertia", "wheelset_vertical_load",
              "loading_lateral_force", "loading_lateral_ramp",
              "initial_Y", "initial_Z", "initial_roll", "initial_vY", "initial_vZ", "initial_roll_rate")
INDICATORS = 4


@dataclass(frozen=True)
class FmuVariable:
    """A variable of a modelDescription.xml."""

    name: str
    reference: int
    unit: str
    description: str
    causality: str = "output"
    variability: str = "continuous"
    initial: str | None = "calculated"
    start: float | None = None
    derivative_of: int | None = None        # place of the state in the list, from 1


def write_fmu(case: Case, path: str | Path, contact: bool = False) -> None:
    """Write the FMU of a case with elastic contacts to `path`, which ends in .fmu: the wheelset or, with `contact`, its contacts
    alone, whose pose comes from outside. It holds the profiles and the contact tables that a run of the case needs."""
    target, model = Path(path), "contact" if contact else "wheelset"
    check_ending(target, "an FMU, with the ending .fmu", ".fmu")
    if case.formulation != "elastic":
        raise Error(file=case.label, expected="&contact formulation = 'elastic', which alone has forces that follow from the pose",
                    found=case.formulation)
    binaries = [BINARIES/platform/name for platform, name in PLATFORMS.items() if (BINARIES/platform/name).is_file()]
    if not binaries:
        raise Error(file=BINARIES, expected="binaries of FMUs, which `make fmu` makes in a folder of the sources", found="none")
    with tempfile.TemporaryDirectory() as folder, complete(target) as scratch:
        resources = Path(folder)
        start = write_resources(case, resources)
        files = sorted(file for file in resources.rglob("*") if file.is_file())
        digest = hashlib.sha256(b"".join(file.name.encode() + file.read_bytes() for file in files)).hexdigest()[:32]
        with zipfile.ZipFile(scratch, "w", zipfile.ZIP_DEFLATED) as archive:
            add(archive, "modelDescription.xml", description(case, model, f"{model}-{digest}", start))
            for binary in binaries:
                for file in sorted(binary.parent.iterdir()):
                    name = model + file.suffix if file == binary else file.name
                    add(archive, f"binaries/{binary.parent.name}/{name}", file.read_bytes())
            for file in files:
                add(archive, f"resources/{file.relative_to(resources).as_posix()}", file.read_bytes())


def add(archive: zipfile.ZipFile, name: str, data: bytes) -> None:
    """Add a file that is the same at any time."""
    entry = zipfile.ZipInfo(name, EPOCH)
    entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
    archive.writestr(entry, data)


def write_resources(case: Case, folder: Path) -> tuple[float, float, float]:
    """The namelist, the profiles and the contact tables that a run of the case needs; the pose at rest that it has at first."""
    names = {}
    for variable, file in core_files(case).items():
        data = Path(file).read_bytes()
        names[variable] = f"{variable}-{hashlib.sha256(data).hexdigest()[:12]}{Path(file).suffix}"
        (folder/names[variable]).write_bytes(data)
    tables = folder/"tables"
    tables.mkdir()
    run = compute(case.replace(table_folder=str(tables), judged="no", pressures="no"))
    case.replace(names | {"table_folder": ""}).to_namelist(folder/"case.nml")
    return 0.0, run.table.equilibrium, run.table.equilibrium_roll


def fmu_variables(case: Case, model: str, pose: tuple[float, float, float]) -> Iterator[FmuVariable]:
    """The variables of a model in the order of its description; states come first, so that their places are 1 to 6."""
    states = STATES if model == "wheelset" else STATES[:3]
    for k, (name, unit, words) in enumerate(states):
        if model == "wheelset":
            yield FmuVariable(name, k, unit, words)
        else:
            yield FmuVariable(name, k, unit, words, "input", initial=None, start=pose[k])
    if model == "wheelset":
        for k, ((name, _, words), unit) in enumerate(zip(STATES, RATES, strict=True)):
            yield FmuVariable(f"der({name})", 6 + k, unit, f"rate of: {words}", "local", derivative_of=k + 1)
        yield FmuVariable("kinetic_energy", KINETIC, "J", "energy of lateral, vertical and roll motion")
        yield FmuVariable("F_ext", LOAD, "N", "lateral force on the centre of gravity")
    yield FmuVariable("elastic_energy", ELASTIC, "J", "elastic energy of all contacts")
    for k, (name, unit, words) in enumerate((("F_y", "N", "lateral force"), ("F_z", "N", "vertical force"),
                                             ("M_x", "N.m", "moment about the axle's centre"))):
        yield FmuVariable(name, FORCE + k, unit, f"{words} of the rails on the wheels")
    for k, place in enumerate(CONTACTS):
        for j, (name, unit, words) in enumerate(OF_CONTACT):
            yield FmuVariable(f"{name}_{place}", CONTACT + 10*k + j, unit, f"{words}, {place}")
    if model == "wheelset":
        for k, name in enumerate(PARAMETERS):
            variable = variables()[find_variable(name)]
            variability = "tunable" if k < 6 else "fixed"
            yield FmuVariable(name.replace("_", ".", 1), PARAMETER + k, variable.unit.replace(" ", "."), variable.meaning,
                              "parameter", variability, "exact", float(getattr(case, name)))


def description(case: Case, model: str, guid: str, pose: tuple[float, float, float]) -> bytes:
    """The modelDescription.xml of a model."""
    listed = list(fmu_variables(case, model, pose))
    root = ElementTree.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=f"{case.case_name}.{model}", guid=guid, version=version(),
        description=case.title, generationTool=f"ldbench {version()}", variableNamingConvention="structured",
        numberOfEventIndicators=str(INDICATORS))
    ability = {"modelIdentifier": model, "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true"}
    ElementTree.SubElement(root, "ModelExchange", ability)
    ElementTree.SubElement(root, "CoSimulation", ability | {"canHandleVariableCommunicationStepSize": "true"})
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for unit in sorted({one.unit for one in listed}):
        ElementTree.SubElement(units, "Unit", name=unit)
    categories = ElementTree.SubElement(root, "LogCategories")
    ElementTree.SubElement(categories, "Category", name="logStatusError")
    ElementTree.SubElement(root, "DefaultExperiment", startTime="0", stopTime=repr(case.t_end), stepSize=repr(case.interval))
    scalars = ElementTree.SubElement(root, "ModelVariables")
    for one in listed:
        given = {"name": one.name, "valueReference": str(one.reference), "description": one.description,
                 "causality": one.causality, "variability": one.variability, "initial": one.initial}
        scalar = ElementTree.SubElement(scalars, "ScalarVariable", {name: word for name, word in given.items() if word})
        real = {"unit": one.unit, "start": repr(one.start) if one.start is not None else None,
                "derivative": str(one.derivative_of) if one.derivative_of else None}
        ElementTree.SubElement(scalar, "Real", {name: word for name, word in real.items() if word})
    structure = ElementTree.SubElement(root, "ModelStructure")
    for group, chosen in (("Outputs", [one for one in listed if one.causality == "output"]),
                          ("Derivatives", [one for one in listed if one.derivative_of]),
                          ("InitialUnknowns", [one for one in listed if one.initial == "calculated"])):
        if not chosen:
            continue
        unknowns = ElementTree.SubElement(structure, group)
        for one in chosen:
            ElementTree.SubElement(unknowns, "Unknown", index=str(listed.index(one) + 1))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
