"""What the ten cases cost as a user runs them: wall time, table, files, memory."""
from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from ldbench import Case
from measure import Section, absolute, measure, ratio
from running import CASES, LDBENCH, PAIRS, REPO

MODELS = "strip", "halfspace"      # the first is what the other's tables are compared with
ROUNDS = 3
THREADS = 1, 2

TEXT = """Every shipped input by the executable, as a child process, its contact table kept from an earlier run: wall and
processor time from start to exit with all files written, and peak resident memory. Table: built by the
executable for each model of normal contact, with one thread and with two, in a run that ends at once."""


# A process begins with the peak memory of the one that it was forked from: this one has hardly any.
LAUNCHER = """
import os, sys, time
begin = time.perf_counter()
child = os.fork()
if child == 0:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        os.execvp(sys.argv[1], sys.argv[1:])
    finally:
        os._exit(127)
_, status, usage = os.wait4(child, 0)
print(os.waitstatus_to_exitcode(status), time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""


def resources(command: list[str], cwd: Path) -> tuple[float, float, float]:
    """Wall time [s], processor time [s] and peak memory [MB] of a program, its own: 10 MB are the least that is told."""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", LAUNCHER, *command], cwd=cwd, capture_output=True, text=True,
                          check=True)
    status, wall, processor, peak = map(float, done.stdout.split())
    if status:
        raise RuntimeError(f"{' '.join(command)}: exit status {status:.0f}, {done.stderr.strip()}")
    return wall, processor, peak/1024


def child(case: str, folder: Path) -> tuple[float, float, float]:
    """Run a shipped input with its files in `folder`."""
    namelist = folder/f"{case}.nml"
    text = (REPO/"inputs"/namelist.name).read_text()
    namelist.write_text(text.replace("'outputs/", f"'{folder}/").replace("'profiles/", f"'{REPO}/profiles/"))
    return resources([str(LDBENCH), str(namelist)], folder)


def case_measures(out: Section, folder: Path) -> None:
    # The first round solves what the others find.
    found = np.array([[child(case, folder) for case in CASES] for _ in range(1 + ROUNDS)])[1:]
    for case, samples in zip(CASES, found.transpose(1, 2, 0), strict=True):
        out.measures += [measure(case, "executable", quantity, unit, values) for (quantity, unit), values in zip(
            (("wall time", "s"), ("processor time", "s"), ("peak memory", "MB")), samples, strict=True)]
    out.measures.append(measure("all cases", "executable", "wall time", "s", found.sum(axis=1)[:, 0],
                                f"{len(CASES)} cases, one after the other", True))


def table_measures(out: Section, folder: Path) -> None:
    """A run of one step whose table is not kept; threads and models take turns."""
    kinds = [(model, threads) for model in MODELS for threads in THREADS]
    for pair in PAIRS:
        case = absolute(Case.exercise(1, pair)).replace(
            table_folder="", dt=1e-4, interval=1e-4, t_end=1e-4, stop_at="t_end", output_file=folder/"columns.txt")
        found = np.array([[built(case.replace(contact_model=model), threads, folder) for model, threads in kinds]
                          for _ in range(ROUNDS)])
        for (model, threads), seconds in zip(kinds, found.transpose(1, 2, 0), strict=True):
            subject = f"table, {model}, {threads} thread{'s'*(threads > 1)}"
            out.measures += [measure(pair, subject, f"{what} time of building", "s", x, headline=True)
                             for what, x in zip(("wall", "processor"), seconds, strict=True)]
            out.measures.append(ratio(pair, subject, "wall time over the strip table's", seconds[0],
                                      found[:, THREADS.index(threads), 0], headline=False))


def built(case: Case, threads: int, folder: Path) -> tuple[float, float]:
    """Wall and processor time [s] of a run whose table has to be built."""
    case.to_namelist(folder/"case.nml")
    return resources(["env", f"OMP_NUM_THREADS={threads}", str(LDBENCH), str(folder/"case.nml")], folder)[:2]


def section() -> Section:
    out = Section("The cases as they are run", TEXT)
    with tempfile.TemporaryDirectory() as folder:
        case_measures(out, Path(folder))
        table_measures(out, Path(folder))
    return out
