"""Tables of measured wheels on measured rails: their errors, and their processor time beside that of the shipped pair.

usage: python tests/support/measured_pairs.py FOLDER

FOLDER holds the profiles of CONTACT's test bank (https://github.com/eve70a/CONTACT, folder testbank/profiles), which are not
part of this repository. Each pair has the defaults of exercise 2, a table of its own, and one thread.
"""
from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
WHEELS = ("Car7216_0001r.whl", "Car7358_0001r.whl", "Car7422_0001r.whl", "Car7813_0001r.whl", "avg_wheel.whl",
          "left-wheel-v1-pre-dry.whl", "right-wheel-v1-pre-dry.whl", "whl_left_iter288.whl", "MBench_S1002_v3.prw")
RAILS = "site_b_hr.prr", "uic60_true.prr"
MORE = (("left-wheel-v1-pre-dry.whl", "MBench_UIC60_v3.prr"), ("MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"),
        ("whl_left_iter288.whl", "rail_left_iter288.ban"), ("avg_wheel.whl", "avg_HR.BAN"))
PLACES = {"tread": 2e-3, "flange": 2e-3, "both": 2e-3, "going over": 1e-2}      # aims of the rms error


def pairs() -> Iterator[tuple[str, str]]:
    """Names of the files of every wheel and rail."""
    yield from ((wheel, rail) for wheel in WHEELS for rail in RAILS)
    yield from MORE


def built(folder: Path, *profiles: Path) -> tuple[dict[str, float], float]:
    """The rms error of a new table at each place, the larger of both wheels, and its processor time [s]."""
    settings = [f"--set=table_file={folder/'pair.table'}"]
    settings += [f"--set={name}={file}" for name, file in zip(("wheel_profile", "rail_profile"), profiles, strict=False)]
    (folder/"pair.table").unlink(missing_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([sys.executable, "-m", "ldbench", "table", REPO/"inputs/ex2_aw.nml", "--json", *settings], check=False,
                          capture_output=True, text=True, cwd=folder, env=os.environ | {"OMP_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if done.returncode:
        print(done.stderr.strip())
        return {}, seconds
    sides = json.loads(done.stdout)["error"].values()
    return {place: max(side[place]["rms"] for side in sides if place in side) for place in PLACES
            if any(place in side for side in sides)}, seconds


def main() -> None:
    """Print a line per pair, and how many meet the aims."""
    profiles = Path(sys.argv[1]).resolve()
    met = dict.fromkeys(PLACES, 0)
    ratios = []
    with tempfile.TemporaryDirectory() as scratch:
        _, shipped = built(Path(scratch))
        print(f"shipped actual pair: {shipped:.1f} s")
        print(f"{'wheel':28}{'rail':22}{'time':>6}" + "".join(f"{place:>12}" for place in PLACES))
        for wheel, rail in pairs():
            errors, seconds = built(Path(scratch), profiles/wheel, profiles/rail)
            numbers = "".join(f"{errors.get(place, float('nan')):12.1e}" for place in PLACES)
            print(f"{wheel:28}{rail:22}{seconds/shipped:6.1f}{numbers}", flush=True)
            if errors:
                ratios.append(seconds/shipped)
                for place, aim in PLACES.items():
                    met[place] += errors.get(place, 0.0) <= aim
    print(f"{len(ratios)} pairs; time {min(ratios):.1f} to {max(ratios):.1f} times that of the shipped actual pair, "
          f"{sum(ratio <= 3 for ratio in ratios)} at most 3 times; rms error within the aim: "
          + ", ".join(f"{place} {met[place]}" for place in PLACES))


if __name__ == "__main__":
    main()
