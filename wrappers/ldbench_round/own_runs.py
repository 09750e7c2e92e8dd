"""Runs of our own that files are judged by: for maps of columns, as exact as rounding lets them be, with rigid contacts.

Impacts multiply differences. The horizon of a simulation is the first time at which a difference of 1e-9 of the start has grown
to 1e-3 of the motion: then the motion depends on digits of the start that no code promises. yardsticks.json keeps what
`make yardsticks` has measured, see docs/yardsticks.py. From the first impact on, rigid contacts move otherwise than elastic
ones, so codes with rigid contacts are scored against our own run with rigid contacts.
"""
from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ldbench import Case
from ldbench.results.run_data import RunData
from ldbench.runs import Run, compute
from ldbench.tools import complete

from .tasks import Task

FILE = Path(__file__).with_name("yardsticks.json")
BEYOND = 1.2            # times the horizon, up to which runs of exercise 5 go
DISPLACEMENTS = "Y", "Z", "roll"
STEP = 2.5e-5           # [s]
TOLERANCE = 1e-11       # change of the total energy in a step [J]; the smallest kinetic energy at a start is 8 J


#: Laws and formulations that spreads are of: fields of `Yardstick`, and of a score.
LAWS = "hertz", "bodies", "rigid"


@dataclass(frozen=True)
class Yardstick:
    """What scores of a simulation are measured by."""

    horizon: float              # [s]; where a difference has not grown so far, the longest time that was tried
    reached: bool               # whether the difference grew to the limit in that time
    end: float | None           # of our own run [s]; None where it is behind the horizon
    growth: float               # how many times a difference of the start has grown at most until then and the horizon
    hertz: Mapping[str, float]      # relative difference of Hertz's law from half-spaces, by the name of the score
    bodies: Mapping[str, float]     # the same of wheel and rail as elastic bodies
    rigid: Mapping[str, float]      # relative difference of rigid contacts from half-spaces
    independent: float | None = None    # horizon that another integrator sees [s]; None where the difference does not grow so far
    integrators: float = np.nan     # largest relative difference of both integrators from one start, up to the horizon
    earliest: float | None = None   # horizon that `integrators` allows another one to see [s]
    latest: float | None = None     # None where the difference does not grow so far


@functools.cache
def yardsticks() -> dict[str, Yardstick]:
    """The yardsticks of the ten simulations by their names."""
    return {name: Yardstick(**facts) for name, facts in json.loads(FILE.read_text(encoding="utf-8")).items()}


def horizon(task: Task) -> float:
    """The time [s] in a simulation beyond which nothing is scored."""
    return yardsticks()[task.name].horizon


def exact(case: Case, factor: float = 1.0) -> Case:
    """A case with short steps, `factor` times as long as ours.

    The energy error of a step goes with the fifth power of its length while contacts stay closed, and with a smaller one
    where a contact touches; the third power of the factor keeps both from being cut ever more often.
    """
    return case.replace(beta=0.0, order=4, dt=factor*STEP, energy_tolerance=TOLERANCE*factor**3)


def ending(case: Case, horizon: float) -> Case:
    """The case, which ends not far behind the horizon where it would go on for long."""
    return case.replace(t_end=BEYOND*horizon) if case.t_end > BEYOND*horizon else case


_OWN: dict[Task, RunData] = {}


def own_run(task: Task) -> RunData:
    """Our run of a simulation, by strips, which is near enough for a map; exercise 5 for its first seconds."""
    if task not in _OWN:
        case = Case.exercise(task.exercise, task.profiles).replace(model="strip", table_folder="", output_file="")
        if task.exercise == 5:
            case = case.replace(t_end=1.0)
        table = next((other.table for known, other in _OWN.items() if known.profiles == task.profiles
                      and isinstance(other, Run)), None)
        _OWN[task] = compute(case, table=table)
    return _OWN[task]


def write_rigid_run(folder: Path, task: Task, restitution: float, program: str) -> Path:
    """The column file of our run of a simulation with rigid contacts, made where it is not there; `program` stands for ours."""
    target = folder/f"{task.name}_restitution_{restitution:g}-{program[:12]}.txt"
    if not target.exists():
        folder.mkdir(parents=True, exist_ok=True)
        case = exact(Case.exercise(task.exercise, task.profiles)).replace(formulation="unilateral", restitution=restitution,
                                                                          table_folder="", output_file="")
        made = compute(ending(case, horizon(task)))
        with complete(target) as scratch:
            made.write(scratch)
    return target
