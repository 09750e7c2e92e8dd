"""Runs of the benchmark that are as exact as they can be: explicit steps of sixth order, short ones."""
from __future__ import annotations

from ..case import Case

STEP = 2.5e-5           # [s]
TOLERANCE = 1e-11       # change of the total energy in a step [J]; the smallest initial energy is 8 J
RAMP_TOLERANCE = 1e-9   # in exercise 5, where the total energy grows by the work of the lateral force [J]
ORDER = 6


def exact(case: Case, factor: float = 1.0) -> Case:
    """A case with steps of sixth order, `factor` times as long as ours.

    The energy error of a step that contacts stay closed in grows with the seventh power of its length; that of a step in which a
    contact touches, with a smaller one.
    """
    tolerance = RAMP_TOLERANCE if case.lateral_ramp else TOLERANCE
    return case.replace(scheme="newmark", beta=0.0, order=ORDER, dt=factor*STEP, energy_tolerance=tolerance*factor**3)
