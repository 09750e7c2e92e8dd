"""When a wheelset derails, and at which lateral force: the one definition, for the files of all codes."""
from __future__ import annotations

import numpy as np

from ..case import Case
from ..results.events import Event
from ..results.run_data import RunData
from .outlines import case_outlines


def derailment(run: RunData, case: Case) -> Event | None:
    """The event of the core; of a file without results of ours, what its rows tell by the same criterion; None without either.

    The tip of a flange passes the highest point of its rail outwards, and the lateral force does not draw it inwards: from there
    is no way back (`fortran/dynamics/events.f90`). case: whose profiles and lateral force the file has.
    """
    if run.header.results:
        return run.first("derailment")
    t, y = run.time, run.values("Y")
    roll = run.values("roll") if "roll" in run.data else np.zeros(len(t))
    force = case.lateral_force + case.lateral_ramp*t
    found: list[float] = []
    for side, sign in case_outlines(case).sides:
        tip, crown = side.wheel[side.wheel[:, 1].argmin()], side.rail[side.rail[:, 1].argmax(), 0]
        past = sign*(y - tip[1]*np.sin(roll)) + tip[0]*np.cos(roll) - crown
        out = np.flatnonzero((past[1:] > 0) & (past[1:] > past[:-1]) & (sign*force[1:] >= 0))
        found += [float(np.interp(0.0, past[k:k + 2], t[k:k + 2])) for k in out[:1]]
    return Event(min(found), "derailment", float(case.lateral_force + case.lateral_ramp*min(found))) if found else None
