"""Instructions per step and per evaluation, counted by valgrind: they do not depend on the machine's load."""
from __future__ import annotations

import re
import shutil
import tempfile
from pathlib import Path

import numpy as np

import ldbench
from evaluation import poses_of, write_poses
from ldbench import Case
from measure import Form, Section, measure
from problem import absolute
from programs import run_program
from running import FORTRAN_TESTS, LDBENCH
from sheets import Table

LOOPS = 5                       # of tests/fortran/force_loop
RUNS = ((1, "aw", 0.02, 0.06), (1, "sw", 0.02, 0.06), (5, "aw", 0.1, 0.25), (5, "sw", 0.1, 0.25))     # end times [s]

TEXT = """Instructions executed, by valgrind's callgrind. Per step: difference of two runs of the executable that end
at two times, over the steps between, so that start, table and end drop out; rows, events and energies are included. A
step of fourth order takes six evaluations of the contacts. Exercise 5 is run while the wheelset still creeps towards
the flange. Per evaluation (force, or force and tangent, both wheels): tests/fortran/force_loop over the poses of
exercise 2, once and twice."""


def instructions(*command: object) -> int:
    done = run_program("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command)
    return int(re.search(r"Collected : (\d+)", done.stderr)[1])


def per_step(exercise: int, pair: str, first: float, last: float, folder: Path) -> tuple[float, float]:
    """Instructions per step, evaluations of the contacts per step."""
    case = absolute(Case.exercise(exercise, pair)).replace(stop_at="t_end", output_file=str(folder/"columns.txt"))
    counts, steps, evaluations = [], [], []
    for t_end in (first, last):
        part = case.replace(t_end=t_end)
        results = ldbench.run(part).results     # the table is in its file afterwards
        part.to_namelist(folder/"case.nml")
        counts.append(instructions(LDBENCH, folder/"case.nml"))
        steps.append(results["steps"])
        evaluations.append(results["evaluations"])
    between = steps[1] - steps[0]
    return (counts[1] - counts[0])/between, (evaluations[1] - evaluations[0])/between


def per_evaluation(folder: Path, *words: str) -> float:
    run = ldbench.run(Case.exercise(2, "aw"))
    absolute(run.case).to_namelist(folder/"case.nml")
    poses, counts = poses_of(run), []
    for times in (1, 2):
        write_poses(folder/"poses", np.tile(poses, (times, 1)))
        counts.append(instructions(FORTRAN_TESTS/"force_loop", folder/"case.nml", folder/"poses", *words))
    return (counts[1] - counts[0])/(LOOPS*len(poses))


def section(form: Form) -> Section:
    short = form is Form.SHORT
    out = Section("Instructions", TEXT)
    if short or not shutil.which("valgrind"):
        out.text += f"\n\nNot counted: {'short form' if short else 'valgrind is not installed'}."
        return out
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for exercise, pair, first, last in RUNS if form is Form.FULL else RUNS[:1]:
            case = Case.exercise(exercise, pair)
            count, evaluations = per_step(exercise, pair, first, last, folder)
            scheme = f"{case.scheme} {case.order}, {1e6*case.dt:g} µs"
            out.measures += [measure(case.case_name, scheme, "instructions per step", "1", count, headline=True),
                             measure(case.case_name, scheme, "evaluations per step", "1", evaluations)]
            rows.append([case.case_name, scheme, f"{count:.0f}", f"{evaluations:.2f}"])
        for kind, words in ("force and tangent", ("tangent",)), ("force", ()):
            count = per_evaluation(folder, *words)
            out.measures.append(measure("ex2_aw", kind, "instructions per evaluation", "1", count, headline=True))
            rows.append(["ex2_aw", f"{kind}, both wheels", f"{count:.0f}", ""])
    out.tables.append(Table("Instructions per step", ["case", "scheme", "instructions", "evaluations"], rows))
    return out
