"""The wheelset of a namelist in Exudyn: three coordinates with our mass matrix, our contact force as a user function, and Exudyn's
own integrator.

usage: python exudyn_client.py libldbench.so ex1_aw.nml [tables]
Prints the times at which the wheelset passes the centre [s].
"""
import sys

import exudyn
import numpy as np
from exudyn.itemInterface import NodeGenericODE2, ObjectGenericODE2

from ldbench_library import Wheelset, passages


def rows(wheelset: Wheelset, t_end: float, step: float = 1e-5) -> np.ndarray:
    """Rows of `Wheelset.row`, one after each step."""
    f, found = wheelset.facts, []

    def note(mbs, t):
        found.append(wheelset.row(t, *(mbs.GetNodeOutput(node, kind) for kind in (
            exudyn.OutputVariableType.Coordinates, exudyn.OutputVariableType.Coordinates_t))))
        return True

    system = exudyn.SystemContainer()
    mbs = system.AddSystem()
    node = mbs.AddNode(NodeGenericODE2(numberOfODE2Coordinates=3, referenceCoordinates=[0.0]*3, initialCoordinates=list(f.start),
                                       initialCoordinates_t=list(f.velocity)))
    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[node], massMatrix=np.diag([f.mass, f.mass, f.roll_inertia]),
                                    forceUserFunction=lambda mbs, t, item, q, rate: wheelset.force(t, q)))
    mbs.SetPostStepUserFunction(note)
    mbs.Assemble()
    settings = exudyn.SimulationSettings()
    settings.timeIntegration.endTime, settings.timeIntegration.numberOfSteps = t_end, round(t_end/step)
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
    return np.array(found)


if __name__ == "__main__":
    wheelset = Wheelset(*sys.argv[1:])
    print(*(f"{t:.9f}" for t in passages(*rows(wheelset, min(wheelset.facts.t_end, 0.5)).T[:3])))
