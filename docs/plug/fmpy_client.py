"""An FMU of `ldbench fmu` by FMPy: CVODE on its derivatives and event indicators, or its own integrator in co-simulation.

usage: python fmpy_client.py wheelset.fmu
Prints the times at which the wheelset passes the centre [s], by both.
"""
import sys

import numpy as np
from fmpy import simulate_fmu


def passages(fmu: str, kind: str, t_end: float = 0.15, interval: float = 1e-4, **options) -> np.ndarray:
    """Times of passages of the centre, by cubic interpolation between rows [s]."""
    rows = simulate_fmu(fmu, fmi_type=kind, stop_time=t_end, output_interval=interval, output=["y", "vy"], **options)
    t, y, v = rows["time"], rows["y"], rows["vy"]
    found = []
    for k in np.flatnonzero((y[1:]*y[:-1] < 0) & (np.diff(t) > 0)):
        h = t[k + 1] - t[k]
        cubic = [2*(y[k] - y[k + 1]) + h*(v[k] + v[k + 1]), 3*(y[k + 1] - y[k]) - h*(2*v[k] + v[k + 1]), h*v[k], y[k]]
        root = next(s.real for s in np.roots(cubic) if abs(s.imag) < 1e-9 and 0 <= s.real <= 1)
        found.append(t[k] + h*root)
    return np.array(found)


if __name__ == "__main__":
    for kind, options in (("ModelExchange", {"solver": "CVode", "relative_tolerance": 1e-11}), ("CoSimulation", {})):
        print(kind, *(f"{t:.9f}" for t in passages(sys.argv[1], kind, **options)))
