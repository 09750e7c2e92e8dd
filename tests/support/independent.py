"""An integrator that has nothing in common with that of the core but the force: SciPy's DOP853."""
from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.integrate import solve_ivp

from ldbench import Case, ContactTable, Error
from ldbench._core import flat

RELATIVE = 2.3e-14      # tolerance; SciPy's least is 100 times the spacing of numbers at 1, 2.22e-14
ABSOLUTE = 3e-14        # tolerance of one motion, in units of SIZES
LONGEST_STEP = 2.5e-5   # a longer one may pass through a contact, and error control does not see all kinks of the force [s]
SIZES = np.repeat([1e-2, 1.0], 3)       # of the motion [m, rad] and of its rates


def rates_of(case: Case, table: ContactTable, motions: int = 1) -> Callable[[float, np.ndarray], np.ndarray]:
    """The rates of y, z of the axle, roll and their velocities, of several motions of one wheelset under one load, (6*motions,)."""
    handle = table._handle      # flat.contact_values: ContactTable.force, 5 times faster for single poses
    inertia = np.array([[case.mass], [case.mass], [case.roll_inertia]])
    load = np.array([[case.lateral_force], [-table.weight], [0.0]])
    ramp = np.array([[case.lateral_ramp], [0.0], [0.0]])

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        x = x.reshape(6, motions)
        found = np.empty_like(x)
        force, status = flat.contact_values(handle, 0, 3, x[0], x[1], x[2])
        found[:3] = x[3:]
        found[3:] = (force + load + ramp*t)/inertia
        if status.any():
            found[:] = np.nan           # the step is tried again with a shorter one
        return found.ravel()

    return rates


def start_of(case: Case, table: ContactTable) -> list[float]:
    """The state at the start of a case."""
    return [case.Y, table.equilibrium + case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate]


def displacements(cases: Sequence[Case], table: ContactTable, t: np.ndarray) -> list[np.ndarray]:
    """Y, Z and roll at times that ascend from 0 [s], as rows have them, (rows, 3) for each case; the cases differ in their starts.

    All motions are integrated together. SciPy takes the mean square of all errors, of which one motion alone may be the cause
    where it meets a rail: tolerances are smaller by the root of the number of motions. Error where SciPy gives up.
    """
    start = np.transpose([start_of(case, table) for case in cases])
    found = solve_ivp(rates_of(cases[0], table, len(cases)), (0, t[-1]), start.ravel(), "DOP853", t_eval=t, rtol=RELATIVE,
                      max_step=LONGEST_STEP, atol=np.repeat(ABSOLUTE/np.sqrt(len(cases))*SIZES, len(cases)))
    if not found.success:
        raise Error(f"DOP853: {found.message}")
    motions = found.y[:3*len(cases)].reshape(3, len(cases), -1) - np.array([0.0, table.equilibrium, 0.0])[:, None, None]
    return list(motions.transpose(1, 2, 0))
