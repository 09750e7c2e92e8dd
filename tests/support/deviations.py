"""How far the ten runs of other builds lie from those of one build, as a table. docs/install.md states the largest.

usage: python tests/support/deviations.py FOLDER OTHER...

Every folder has the ten column files that one build wrote. A line of the table has the largest deviations of a build in
exercises 1 to 4 and in exercise 5, at the times that both files have up to the horizon of the case: behind it, rounding
alone decides.
"""
from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

from running import CASES, REPO, columns

SHOWN = {"Y [m]": ["Y"], "Z [m]": ["Z"], "roll [rad]": ["roll"], "vY [m/s]": ["vY"], "vZ [m/s]": ["vZ"],
         "roll_rate [rad/s]": ["roll_rate"], "N [N]": ["N_LT", "N_LF", "N_RT", "N_RF"]}


def deviations(own: Path, other: Path, case: str, horizon: float) -> list[float]:
    """The largest deviation of each of SHOWN."""
    a, b = (columns(folder/f"{case}.txt") for folder in (own, other))
    times, rows, others = np.intersect1d(a["time"], b["time"], return_indices=True)
    assert len(times) > 0.5*len(a["time"]), f"{other}, {case}: other times"
    kept = times <= horizon
    return [max(float(np.abs(a[name][rows] - b[name][others])[kept].max()) for name in names) for names in SHOWN.values()]


def main(own: Path, *builds: Path) -> None:
    found = next((REPO/"wrappers").rglob("yardsticks.json"))
    horizons = {case: json.loads(found.read_text())[case]["horizon"] for case in CASES}
    print("| build | exercises |", *(f"{name} |" for name in SHOWN))
    print("|---|---|" + "---|"*len(SHOWN))
    for build in builds:
        for words, kept in ("1 to 4", "1234"), ("5", "5"):
            each = [deviations(own, build, case, horizons[case]) for case in CASES if case[2] in kept]
            print(f"| {build.name} | {words} |", *(f"{worst:.1g} |" for worst in np.max(each, axis=0)))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
