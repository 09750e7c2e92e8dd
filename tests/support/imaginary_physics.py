"""An imaginary code with laws of its own: wheels and rails are circles, whose depth in each other makes forces by planted laws.

Fingerprints look at forces, motion and points of a contact, not at its profiles. Nothing of ldbench is in here but the input.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.optimize import brentq

import ldbench
from ldbench import Case
from ldbench_round.tasks import Task
from stranger_files import CALL, G

SIDE = np.array([1.0, 1.0, -1.0, -1.0])                     # right wheels are left ones in a mirror
SLOPE = np.tile([1/40, np.radians(65)], 2)                  # contact angles of tread and flange where they touch first [rad]
OUT_OF = np.column_stack([-np.sin(SLOPE), np.cos(SLOPE)])   # normal of the rail there
WHEEL, RAIL = np.tile([0.5, 0.014], 2), np.tile([0.3, 0.013], 2)       # radii of the circles [m]
HEIGHT, CLEARANCE = 0.457, np.tile([[0.0, 0.0], [0.010, 0.0]], (2, 1))  # of the axle, and of the flange [m]
RAIL_CENTRES = np.tile([[0.75, -0.3], [0.7306, -0.0137]], (2, 1))       # as on the left [m]
WHEEL_CENTRES = RAIL_CENTRES + (WHEEL + RAIL)[:, None]*OUT_OF - CLEARANCE - [0.0, HEIGHT]      # from that of the axle [m]


@dataclass(frozen=True)
class Physics:
    """The laws of a code."""

    k: float = 9e10                         # N = k δⁿ [N/mⁿ]
    n: float = 1.5
    hunt_crossley: float = 0.0              # factor χ of N = k δⁿ (1 + χ dδ/dt) [s/m]
    kelvin_voigt: float = 0.0               # c of N = k δⁿ + c dδ/dt, not below 0 [N s/m]
    euler: bool = False                     # symplectic Euler steps instead of Newmark's with β = 0, γ = 1/2
    step: float = 5e-5                      # [s]
    every: int = 2                          # steps from row to row
    pitch: float = 0.0                      # of a table of contact angles over Y, of which the nearest point counts [m]; 0: none


def contacts(q: np.ndarray, laws: Physics) -> tuple[np.ndarray, ...]:
    """Depth (4,), normal (4, 2) and arm (4, 2) of the contacts in a pose, as on the left."""
    c, s = np.cos(SIDE*q[2]), np.sin(SIDE*q[2])
    arm = np.column_stack([c*WHEEL_CENTRES[:, 0] - s*WHEEL_CENTRES[:, 1], s*WHEEL_CENTRES[:, 0] + c*WHEEL_CENTRES[:, 1]])

    def apart(y: float) -> np.ndarray:
        return arm + np.column_stack([SIDE*y, np.full(4, q[1])]) - RAIL_CENTRES

    normal = apart(laws.pitch*round(q[0]/laws.pitch) if laws.pitch else q[0])
    normal /= np.hypot(*normal.T)[:, None]
    return WHEEL + RAIL - np.hypot(*apart(q[0]).T), normal, arm - WHEEL[:, None]*normal


@functools.cache
def simulate(laws: Physics, t_end: float) -> pd.DataFrame:
    """The columns of the call in SI units, of exercise 2."""
    case = Case.exercise(2, "aw")
    inertia, weight = np.array([case.mass, case.mass, case.roll_inertia]), case.mass*G + case.vertical_load

    def acceleration(q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Acceleration, and angle, N, Fy, Fz, y, z and radius of the contacts (4, 7)."""
        depth, normal, arm = contacts(q, laws)
        rate = SIDE*v[2]
        closing = -((SIDE*v[0] - rate*arm[:, 1])*normal[:, 0] + (v[1] + rate*arm[:, 0])*normal[:, 1])
        n = laws.k*np.maximum(depth, 0.0)**laws.n*(1 + laws.hunt_crossley*closing) + (depth > 0)*laws.kelvin_voigt*closing
        fy, fz = np.maximum(n, 0.0)*normal.T
        total = [SIDE @ fy, fz.sum() - weight, SIDE @ (arm[:, 0]*fz - arm[:, 1]*fy)]
        radius = SIDE*np.sin(q[2])*arm[:, 0] - np.cos(q[2])*arm[:, 1]
        places = np.stack([np.arctan2(-normal[:, 0], normal[:, 1]), q[0] + SIDE*arm[:, 0], q[1] + arm[:, 1], radius])
        places[:, n <= 0] = np.nan
        return total/inertia, np.stack([places[0], np.maximum(n, 0.0), SIDE*fy, fz, *places[1:]], axis=1)

    rest = np.array([0.0, brentq(lambda z: acceleration(np.array([0.0, z, 0.0]), np.zeros(3))[0][1], HEIGHT - 1e-3, HEIGHT), 0.0])
    q, v, h, rows = rest, np.array([case.vY, case.vZ, case.roll_rate]), laws.step, []
    a, points = acceleration(q, v)
    for step in range(round(t_end/h)):
        if step % laws.every == 0:
            rows.append([step*h, *(q - rest), *v, *a, *points.ravel()])
        v = v + (h if laws.euler else h/2)*a
        q = q + h*v
        a, points = acceleration(q, v)
        if not laws.euler:
            v = v + h/2*a
    return pd.DataFrame(rows, columns=CALL)


@functools.cache
def rigid(task: Task, restitution: float) -> ldbench.Run:
    """A run of ours with rigid contacts."""
    case = Case.exercise(task.exercise, task.profiles)
    return ldbench.run(case.replace(formulation="unilateral", restitution=restitution, table_folder="", output_file=""))
