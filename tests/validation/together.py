"""What two half-space systems, tread and flange, leave out: the same patches in one system."""
from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import ldbench
from checks import Check, limit, relative
from programs import fortran_test
from sheets import Table

SHIPPED = "aw", "sw"
EXERCISES = 1, 2
LOAD = 90e3                 # on the tread [N]
POSES = 40                  # of the first flange contact
FLOOR = 5e3                 # smallest force that deviations refer to [N]


def first_contact(exercise: int, pair: str, count: int) -> tuple[ldbench.Case, np.ndarray]:
    """Some `count` poses (y, z, roll) of the left wheel during the first contact of its flange."""
    case = ldbench.Case.exercise(exercise, pair).replace(dt=1e-5, interval=1e-5)
    run = ldbench.run(case)
    flange = run.data.N_LF.to_numpy() > 0
    begin = int(np.argmax(flange))
    end = begin + int(np.argmin(flange[begin:]))
    poses = run.data[["Y", "Z", "roll"]].to_numpy() + [0, run.results["axle_height"], 0]
    return case, poses[begin:end:max(1, (end - begin)//count)]


def far_field(apart: np.ndarray, depth: np.ndarray, compliance: np.ndarray) -> np.ndarray:
    """Forces [N] of two Hertz springs of which each lowers the surface under the other, (poses, 2).

    `apart`: without that; `compliance`: 1/(pi E* d), of a point load at the distance d (Boussinesq)."""
    force = apart.copy()
    for _ in range(100):
        force = apart*np.clip(1 - compliance[:, None]*force[:, ::-1]/depth, 0, None)**1.5
    return force


def one_system(short: bool) -> tuple[list[Check], Table]:
    checks: list[Check] = []
    rows = []
    for pair in SHIPPED:
        for exercise in EXERCISES[:1] if short else EXERCISES:
            case, poses = first_contact(exercise, pair, POSES//4 if short else POSES)
            with tempfile.TemporaryDirectory() as folder:
                case.to_namelist(Path(folder)/"case.nml")
                lines = "".join(" ".join(map(repr, pose)) + "\n" for pose in poses.tolist())
                found = fortran_test("tread_and_flange", Path(folder)/"case.nml", stdin=lines).splitlines()
            numbers = np.array([line.split() for line in found], float)
            # Both are pressed, alone and in one system; a spring that lets go has no far field to compare with.
            numbers = numbers[(numbers[:, :4] > 0).all(axis=1)]
            apart, whole, depth, (moved, distance) = numbers[:, :2], numbers[:, 2:4], numbers[:, 4:6], numbers[:, 6:].T
            e_star = case.youngs_modulus/(2*(1 - case.poisson**2))
            compliance = 1/(np.pi*e_star*distance)
            by_load, change = LOAD*moved/apart[:, 0], whole - apart
            name = f"ex{exercise}_{pair}"
            checks.append(relative(
                f"{name}: displacement at the flange by {1e-3*LOAD:g} kN on the tread [um]", 1e6*by_load[0],
                1e6*LOAD*compliance[0], "point load (Boussinesq); bar (a/d)^2/4 for a = 5 mm", 5e-3))
            miss = np.abs(far_field(apart, depth, compliance) - whole)/np.maximum(apart, FLOOR)
            checks.append(limit(f"{name}: forces in one system, off by at most [of max(|F|, 5 kN)]", miss.max(),
                                "Hertz springs with far fields; bar a tenth of the largest change", 0.1*np.abs(
                                    change/np.maximum(apart, FLOOR)).max()))
            k = int(apart[:, 1].argmax())
            rows.append([name, f"{1e3*distance[0]:.1f}", f"{1e6*by_load[0]:.1f}", f"{1e-3*change[:, 1].min():.1f}",
                         f"{1e-3*apart[k, 1]:.0f}", f"{100*change[k, 1]/apart[k, 1]:.1f}",
                         f"{1e-3*change[:, 0].min():.1f}"])
    return checks, Table(
        "Tread and flange in one half-space system against two, same poses: first contact of the left flange",
        ["case", "distance [mm]", f"displacement at the flange by {1e-3*LOAD:g} kN on the tread [um]",
         "flange's force, largest change [kN]", "flange's force, largest with tread [kN]", "its change there [%]",
         "tread's force, largest change [kN]"], rows)
