"""The wheelset of a namelist by DOP853 of SciPy on the contact force of libldbench, called by ctypes.

usage: python scipy_client.py libldbench.so ex1_aw.nml
Prints the times at which the wheelset passes the centre [s], and the largest change of the total energy [J].
"""
import ctypes
import sys

import numpy as np
from scipy.integrate import solve_ivp

OUTSIDE = 2
FACTS = ("mass", 1), ("roll_inertia", 1), ("pitch_inertia", 1), ("weight", 1), ("held", 3), ("rest", 3), ("start", 3), \
        ("velocity", 3), ("lateral_force", 1), ("lateral_ramp", 1), ("t_end", 1), ("clearance", 2)


class Facts(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double*n if n > 1 else ctypes.c_double) for name, n in FACTS] + [("columns", ctypes.c_int)]


class Wheelset:
    def __init__(self, library: str, namelist: str, tables: str | None = None):
        self.lib, self.words, self.handle = ctypes.CDLL(library), ctypes.create_string_buffer(1024), ctypes.c_int64()
        self.call("open", namelist.encode(), tables and tables.encode(), ctypes.byref(self.handle))
        self.facts = Facts()
        self.call("facts", self.handle, ctypes.byref(self.facts))

    def call(self, name, *arguments):
        status = getattr(self.lib, f"ldbench_{name}")(*arguments, self.words, len(self.words))
        if status not in (0, OUTSIDE):
            raise RuntimeError(self.words.value.decode())
        return status

    def contact(self, pose):
        """Elastic energy, force and moment in a pose; None where the pose is outside the table."""
        energy, force = ctypes.c_double(), (ctypes.c_double*3)()
        status = self.call("contact", self.handle, (ctypes.c_double*3)(*pose), ctypes.byref(energy), force, None, None)
        return None if status == OUTSIDE else (energy.value, np.array(force))

    def rates(self, t, x):
        found, f = self.contact(x[:3]), self.facts
        if found is None:
            return np.full(6, 1e15)         # so that the integrator tries a shorter step
        force = found[1] + [f.lateral_force + f.lateral_ramp*t, -f.weight, 0.0]
        return np.concatenate([x[3:], force/[f.mass, f.mass, f.roll_inertia]])

    def energy(self, x):
        f = self.facts
        return self.contact(x[:3])[0] + f.weight*x[1] + 0.5*(x[3:]**2) @ [f.mass, f.mass, f.roll_inertia]


if __name__ == "__main__":
    wheelset = Wheelset(*sys.argv[1:])
    centre = lambda t, x: x[0]      # noqa: E731
    start = [*wheelset.facts.start, *wheelset.facts.velocity]
    found = solve_ivp(wheelset.rates, (0, min(wheelset.facts.t_end, 0.5)), start, "DOP853", rtol=1e-11, atol=1e-13, max_step=1e-4,
                      events=centre)
    drift = max(abs(wheelset.energy(x) - wheelset.energy(found.y[:, 0])) for x in found.y.T)
    print(*(f"{t:.9f}" for t in found.t_events[0] if t > 1e-6), f"{drift:.2e}")
