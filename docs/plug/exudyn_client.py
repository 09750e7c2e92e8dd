"""The wheelset of a namelist in Exudyn: three coordinates with our mass matrix, our contact force as a user function, and Exudyn's
own integrator.

usage: python exudyn_client.py libldbench.so ex1_aw.nml
Prints the times at which the wheelset passes the centre [s].
"""
import sys

import exudyn
import numpy as np
from exudyn.itemInterface import MarkerNodeCoordinates, NodeGenericODE2, ObjectGenericODE2

from scipy_client import Wheelset


def passages(library: str, namelist: str, tables: str | None = None, t_end: float = 0.5, step: float = 1e-5) -> list[float]:
    wheelset = Wheelset(library, namelist, tables)
    f = wheelset.facts
    rows = []

    def force(mbs, t, item, q, rate):
        contact = wheelset.contact(q)[1]
        return contact + [f.lateral_force + f.lateral_ramp*t, -f.weight, 0.0]

    def note(mbs, t):
        rows.append((t, mbs.GetNodeOutput(node, exudyn.OutputVariableType.Coordinates)[0]))
        return True

    system = exudyn.SystemContainer()
    mbs = system.AddSystem()
    node = mbs.AddNode(NodeGenericODE2(numberOfODE2Coordinates=3, referenceCoordinates=[0.0]*3, initialCoordinates=list(f.start),
                                       initialCoordinates_t=list(f.velocity)))
    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag([f.mass, f.mass, f.roll_inertia]),
                                    forceUserFunction=force))
    mbs.AddMarker(MarkerNodeCoordinates(nodeNumber=node))
    mbs.SetPostStepUserFunction(note)
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = t_end, round(t_end/step)
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
    t, y = np.array(rows).T
    return [t[k] - y[k]*(t[k + 1] - t[k])/(y[k + 1] - y[k]) for k in np.flatnonzero(y[1:]*y[:-1] < 0)]


if __name__ == "__main__":
    print(*(f"{t:.9f}" for t in passages(*sys.argv[1:])))
