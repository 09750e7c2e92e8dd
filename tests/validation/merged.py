"""Where tread and flange are pressed in together: forces up to 2.5 MN, for eight pairs.

The patches of tread and flange meet there, and the contact table couples what each of them knows alone. Its force is compared
with half-spaces pressed together in the pose itself, by classes of the wheel's force, for shipped, modern, worn, conforming and
measured pairs. Loads press and never pull, so the force of a wheel is at most the sum of its loads. Sixty-four drops of a
wheelset beside its flange show what the errors do to a run: the table's largest force against the direct one of that pose.
"""
from __future__ import annotations

import itertools
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import ldbench
import models
import shapes
from checks import Check, Section, limit
from ldbench import Case, ContactTable, Profile
from sheets import Table

EACH = 5e3                              # that tread and flange carry at least [N]
CLASSES = 10e3, 100e3, 300e3, 700e3, 1.5e6, 2.6e6   # of the wheel's force [N]
POSES = 25                              # in every class
BEFORE = 0.1e-3                         # the clearance, where the tread alone touches a rigid rail [m]
SPACING = 0.25                          # of measured points [mm]
DRAWN = 700
HALF_WIDTH = 0.75                       # from the axle's centre to the tread's contact, about [m]
NOISE = 0.01                            # of measured profiles [mm]
# The rms errors that are allowed: measured 1.5e-3 and 1.2e-3 for the shipped pairs, 2.1e-2 for the conforming wheel, whose patch
# is long and winds, and at most 1.2e-2 for the others. Direct solutions themselves leave about 1e-2 there: on 64 elements for 24
# the worst of the thin flange's 86 poses moves by 9 %, away from its table's error of 1.2 %.
RMS = {"aw": 3e-3, "sw": 3e-3, "conforming wheel, actual rail": 4e-2}
OTHERS = 2e-2
LOADS = 5e-3                            # by which a force may exceed the sum of loads [of the force]
DROPS = np.linspace(9.6e-3, 11.0e-3, 8), np.linspace(0.3, 1.0, 8)     # lateral positions [m], speeds downwards [m/s]
DROPPED = 1.5e-2                        # error of a drop's largest force; measured 1.1e-2, at 2.8 MN


def pairs(folder: Path) -> Iterator[tuple[str, Case]]:
    """Cases by the name of their profiles."""
    yield from models.pairs(folder)
    wheel, rail = shapes.shape("awprof"), shapes.shape("arprof")
    yield made(folder, "worn wheel, side-worn rail", shapes.hollow(shapes.thin_flange(wheel)), shapes.side_worn(rail))
    for name in "aw", "sw":
        wheel, rail = (shapes.noisy(shapes.shape(file, SPACING), NOISE, seed)
                       for seed, file in enumerate((f"{name}prof", f"{name[0]}rprof")))
        yield made(folder, f"measured {name}", wheel, rail)


def made(folder: Path, name: str, wheel: np.ndarray, rail: np.ndarray) -> tuple[str, Case]:
    """A case with these points, smoothed by their noise."""
    files = {}
    for kind, points in ("wheel", wheel), ("rail", rail):
        files[f"{kind}_profile"] = str(folder/f"{name} {kind}.yz")
        Profile(points, kind, wheel_back=0.0 if kind == "wheel" else None).write(files[f"{kind}_profile"])
    return name, Case.exercise(1, "aw").replace(files)


def pressed_together(table: ContactTable) -> tuple[np.ndarray, np.ndarray]:
    """Poses (n, 3) in which tread and flange of the left wheel carry at least EACH, some in every class; forces [N]."""
    rng = np.random.default_rng(7)
    before = table.clearance - BEFORE
    rigid = table.geometry([before])
    y, tread, roll = rng.uniform([-0.1e-3, 0.0, -3e-3], [1.2e-3, 1.0e-3, 3e-3], (DRAWN, 3)).T
    poses = np.column_stack([before + y, table.rigid_height + rigid.Z[0] - tread - HALF_WIDTH*roll, rigid.roll[0] + roll])
    with np.errstate(invalid="ignore"):
        both = (np.linalg.norm(table.forces_by_contact(*poses.T, outside="nan")[:, :2, :2], axis=2) > EACH).all(axis=1)
    poses = poses[both]
    force = np.linalg.norm(table.force(*poses.T, wheel="left", outside="nan")[:, :2], axis=1)
    chosen = np.concatenate([np.flatnonzero((force > low) & (force < high))[:POSES]
                             for low, high in itertools.pairwise(CLASSES)])
    return poses[chosen], force[chosen]


def over_loads(table: ContactTable, pose: np.ndarray, force: float) -> float:
    """By how much a force exceeds the sum of the loads of the wheel's patches, of itself."""
    loads = sum(patch.integral for patch in table.pressure(*pose) if patch.contact[0] == "L")
    return float(force/loads - 1)


def drop_errors(table: ContactTable) -> tuple[np.ndarray, np.ndarray]:
    """The largest forces [N] of the left wheel in drops beside its flange, and their errors."""
    poses = []
    for lateral, speed in itertools.product(*DROPS):
        case = table.case.replace(Y=lateral, vY=0.0, vZ=-speed, roll_rate=0.0, t_end=0.01, stop_at="t_end")
        run = ldbench.run(case, table=table)
        rows = run.data[["Y", "Z", "roll"]].to_numpy() + [0, run.results["axle_height"], 0]
        force = np.linalg.norm(table.force(*rows.T, wheel="left")[:, :2], axis=1)
        poses.append(rows[np.argmax(force)])
    error, force = table.errors(*np.array(poses).T)
    return force, error


def section() -> Section:
    checks: list[Check] = []
    rows, tables = [], {}
    with tempfile.TemporaryDirectory() as folder:
        for name, case in pairs(Path(folder)):
            table = tables[name] = ContactTable(case.replace(table_folder=""))
            poses, force = pressed_together(table)
            error, direct = table.errors(*poses.T)
            rms = np.sqrt(np.mean(error**2))
            checks.append(limit(f"error of the force, {len(error)} poses, {name} [1]", rms, "direct half-spaces",
                                RMS.get(name, OTHERS)))
            heaviest = np.argsort(force)[-3:]
            checks.append(limit(f"force over the sum of loads, {name} [1]",
                                max(0.0, *(over_loads(table, poses[k], force[k]) for k in heaviest)), "loads press", LOADS))
            of_class = [error[(direct >= low) & (direct < high)] for low, high in itertools.pairwise(CLASSES)]
            rows.append([name, *(f"{np.sqrt(np.mean(e**2)):.1e} ({e.max():.1e})" if len(e) else "" for e in of_class)])
        force, error = drop_errors(tables["aw"])
        checks.append(limit(f"error of the largest force in {len(force)} drops of exercise 2's wheelset, up to "
                            f"{1e-6*force.max():.1f} MN [1]", error.max(), "direct half-spaces", DROPPED))
    head: list[str] = ["pair", *(f"{1e-3*low:g} to {1e-3*high:g} kN" for low, high in itertools.pairwise(CLASSES))]
    return Section("Tread and flange pressed together", __doc__ or "", checks, [
        Table("Error of the force by force, rms (largest)", head, rows)])
