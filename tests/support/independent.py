"""An integrator that has nothing in common with that of the core but the force: SciPy's DOP853."""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from ldbench import Case, ContactTable, Error
from ldbench._core import _flat

TOLERANCE = 3e-14       # relative; SciPy's least is 2e-14
LONGEST_STEP = 2.5e-5   # a longer one may pass through a contact, and error control does not see all kinks of the force [s]
SIZES = np.repeat([1e-2, 1.0], 3)       # of the motion [m, rad] and of its rates


def rates_of(case: Case, table: ContactTable) -> Callable[[float, np.ndarray], np.ndarray]:
    """The rates of the state: y, z of the axle, roll and their velocities, (6,)."""
    forces, handle = _flat.forces, table._handle        # ContactTable.force, 5 times faster for single poses
    inertia = np.array([case.mass, case.mass, case.roll_inertia])
    load = np.array([case.lateral_force, -table.weight, 0.0])
    ramp = np.array([case.lateral_ramp, 0.0, 0.0])

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        force, status = forces(handle, 0, x[0], x[1], x[2])
        if status[0]:
            return np.full(6, np.nan)       # the step is tried again with a shorter one
        return np.concatenate([x[3:], (force[:, 0] + load + ramp*t)/inertia])

    return rates


def start_of(case: Case, table: ContactTable) -> list[float]:
    """The state at the start of a case."""
    return [case.Y, table.equilibrium + case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate]


def displacements(case: Case, table: ContactTable, t: np.ndarray) -> np.ndarray:
    """Y, Z and roll of a case at times that ascend from 0 [s], as its rows have them, (rows, 3). Error where SciPy gives up."""
    found = solve_ivp(rates_of(case, table), (0, t[-1]), start_of(case, table), "DOP853", t_eval=t, rtol=TOLERANCE,
                      max_step=LONGEST_STEP, atol=TOLERANCE*SIZES)
    if not found.success:
        raise Error(f"DOP853: {found.message}")
    return found.y[:3].T - [0.0, table.equilibrium, 0.0]
