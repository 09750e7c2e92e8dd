"""How far the ten runs of other builds lie from those of one build, as a table. docs/stated.json has the largest.

usage: python tests/support/deviations.py FOLDER OTHER...

Every folder has the ten column files that one build wrote. A line of the table has the largest deviations of a build in
exercises 1 to 4 and in exercise 5, at the times that both files have up to the horizon of the case: behind it, rounding
alone decides.
"""
import sys
from pathlib import Path

import numpy as np

from ldbench_round.own_runs import yardsticks
from running import CASES, columns

SHOWN = {"Y [m]": ["Y"], "Z [m]": ["Z"], "roll [rad]": ["roll"], "vY [m/s]": ["vY"], "vZ [m/s]": ["vZ"],
         "roll_rate [rad/s]": ["roll_rate"], "N [N]": ["N_LT", "N_LF", "N_RT", "N_RF"]}


def deviations(own: Path, other: Path, case: str) -> list[float]:
    """The largest deviation of each of SHOWN."""
    a, b = (columns(folder/f"{case}.txt") for folder in (own, other))
    times, rows, others = np.intersect1d(a["time"], b["time"], return_indices=True)
    assert len(times) > 0.5*len(a["time"]), f"{other}, {case}: other times"
    kept = times <= yardsticks()[case].horizon
    return [max(float(np.abs(a[name][rows] - b[name][others])[kept].max()) for name in names) for names in SHOWN.values()]


if __name__ == "__main__":
    first, *builds = map(Path, sys.argv[1:])
    print("| build | exercises |", *(f"{name} |" for name in SHOWN), "\n|---|---|" + "---|"*len(SHOWN))
    for build in builds:
        for words, kept in ("1 to 4", "1234"), ("5", "5"):
            worst = np.max([deviations(first, build, case) for case in CASES if case[2] in kept], axis=0)
            print(f"| {build.name} | {words} |", *(f"{x:.1g} |" for x in worst))
