"""The wheelset of a namelist by DOP853 of SciPy on the contact force of libldbench, called by ctypes.

usage: python scipy_client.py libldbench.so ex1_aw.nml [tables]
Prints the times at which the wheelset passes the centre [s], and the largest change of the total energy [J].
"""
import sys

import numpy as np
from scipy.integrate import solve_ivp

from ldbench_library import Wheelset, passages


def rows(wheelset: Wheelset, t_end: float, interval: float, tolerance: float = 1e-11):
    """Rows of `Wheelset.row` at equal intervals, and how many forces they took."""
    f = wheelset.facts

    def rates(t, x):
        force = wheelset.force(t, x[:3])
        if force is None:
            return np.full(6, 1e15)         # so that the integrator tries a shorter step
        return np.concatenate([x[3:], force/[f.mass, f.mass, f.roll_inertia]])

    found = solve_ivp(rates, (0, t_end), [*f.start, *f.velocity], "DOP853", rtol=tolerance, atol=tolerance/100, max_step=1e-4,
                      t_eval=np.arange(round(t_end/interval) + 1)*interval*(1 - 1e-15))
    return np.array([wheelset.row(t, x[:3], x[3:]) for t, x in zip(found.t, found.y.T, strict=True)]), found.nfev


if __name__ == "__main__":
    wheelset = Wheelset(*sys.argv[1:])
    t, y, v, _, energy = rows(wheelset, min(wheelset.facts.t_end, 0.5), 1e-4)[0].T
    print(*(f"{t:.9f}" for t in passages(t, y, v)), f"{np.abs(energy - energy[0]).max():.2e}")
