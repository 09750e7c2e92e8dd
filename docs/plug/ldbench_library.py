"""libldbench by ctypes: a case, its contact force in a pose, and its energy."""
import ctypes

import numpy as np

OUTSIDE = 2
FACTS = ("mass", 1), ("roll_inertia", 1), ("pitch_inertia", 1), ("weight", 1), ("held", 3), ("rest", 3), ("start", 3), \
        ("velocity", 3), ("lateral_force", 1), ("lateral_ramp", 1), ("t_end", 1), ("clearance", 2)
POINT = ("energy", 1), ("force", 3), ("angle", 1), ("normal_force", 1), ("y", 1), ("z", 1), ("radius", 1)


def fields(names):
    return [(name, ctypes.c_double*n if n > 1 else ctypes.c_double) for name, n in names]


class Facts(ctypes.Structure):
    _fields_ = [*fields(FACTS), ("columns", ctypes.c_int)]


class Point(ctypes.Structure):
    _fields_ = fields(POINT)


class Wheelset:
    """A namelist's wheelset; contact tables are kept in the folder `tables`."""

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

    def contact(self, pose, points=None):
        """Elastic energy, force and moment in a pose; None where the pose is outside the table."""
        energy, force = ctypes.c_double(), (ctypes.c_double*3)()
        status = self.call("contact", self.handle, (ctypes.c_double*3)(*pose), ctypes.byref(energy), force, points, None)
        return None if status == OUTSIDE else (energy.value, np.array(force))

    def force(self, t, pose):
        """Force and moment of contacts, weight and load; None where the pose is outside the table."""
        found, f = self.contact(pose), self.facts
        return None if found is None else found[1] + [f.lateral_force + f.lateral_ramp*t, -f.weight, 0.0]

    def row(self, t, pose, velocity):
        """Time, lateral position and velocity, normal force of the left flange, total energy."""
        f, points = self.facts, (Point*4)()
        elastic = self.contact(pose, points)[0]
        kinetic = 0.5*np.square(velocity) @ [f.mass, f.mass, f.roll_inertia]
        return t, pose[0], velocity[0], points[1].normal_force, elastic + f.weight*pose[1] + kinetic


def passages(t, y, v):
    """Times of passages of the centre, by a cubic between rows [s]."""
    found = []
    for k in np.flatnonzero((y[1:]*y[:-1] < 0) & (np.diff(t) > 0)):
        h = t[k + 1] - t[k]
        cubic = [2*(y[k] - y[k + 1]) + h*(v[k] + v[k + 1]), 3*(y[k + 1] - y[k]) - h*(2*v[k] + v[k + 1]), h*v[k], y[k]]
        found.append(t[k] + h*next(s.real for s in np.roots(cubic) if abs(s.imag) < 1e-9 and 0 <= s.real <= 1))
    return np.array(found)
