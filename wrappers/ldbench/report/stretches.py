"""Parts of a long run, computed again with rows as close as impacts need."""
from __future__ import annotations

import numpy as np

from ..plots.impact import Recomputed
from ..results.run_data import RunData
from ..runs import compute

INTERVAL = 2e-5         # between rows [s]
LENGTH = 0.03           # of a part [s]
BEFORE = 0.3            # share of a part before the moment for which it is computed
STATE = ("Y", "Z", "roll", "vY", "vZ", "roll_rate")


def around(whole: RunData, t: float) -> Recomputed:
    """The run about the time t [s], from the state of one of its rows on."""
    k = max(int(np.searchsorted(whole.time, t - BEFORE*LENGTH, "right")) - 1, 0)
    case = whole.case.replace(
        {f"initial_{name}": float(whole.values(name)[k]) for name in STATE}, lateral_force=float(whole.values("F_ext")[k]),
        t_end=LENGTH, interval=INTERVAL, dt=INTERVAL, stop_at="t_end", rows="interval_and_events", roll_link="none")
    return Recomputed(compute(case), float(whole.time[k]))


def first_and_hardest(whole: RunData) -> tuple[Recomputed, Recomputed] | None:
    """The first and the hardest contact of the left flange; None in a run without one."""
    first, peak = whole.first_contact("LF"), whole.peak("LF")
    return (around(whole, first), around(whole, peak[1])) if first is not None and peak else None
