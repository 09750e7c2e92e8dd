"""An FMU of `ldbench fmu` by FMPy: CVODE on its derivatives and event indicators, or its own integrator in co-simulation.

usage: python fmpy_client.py wheelset.fmu
Prints the times at which the wheelset passes the centre [s], by both.
"""
import sys

import numpy as np
from fmpy import simulate_fmu

from ldbench_library import passages

OPTIONS = {"ModelExchange": {"solver": "CVode", "relative_tolerance": 1e-11}, "CoSimulation": {}}
OUTPUT = "y", "vy", "N_LF", "z", "elastic_energy", "kinetic_energy"


def rows(fmu: str, kind: str, t_end: float = 0.15, interval: float = 1e-4) -> np.ndarray:
    """Time and the variables of OUTPUT, a row each."""
    found = simulate_fmu(fmu, fmi_type=kind, stop_time=t_end, output_interval=interval, output=list(OUTPUT), **OPTIONS[kind])
    return np.array([found[name] for name in ("time", *OUTPUT)])


if __name__ == "__main__":
    for kind in OPTIONS:
        print(kind, *(f"{t:.9f}" for t in passages(*rows(sys.argv[1], kind)[:3])))
