"""How far into a simulation a score means something, and how far formulations of our own differ until then.

Impacts multiply differences. The horizon of a simulation is the first time at which a difference of 1e-9 of the start has grown
to 1e-3 of the motion: then the motion depends on digits of the start that no code promises. It is measured on twins of an exact
run, whose start is aside in one coordinate each. yardsticks.json keeps what `make yardsticks` has measured.
"""
from __future__ import annotations

import functools
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..case import Case
from ..results.run_data import RunData
from ..runs import run
from ..table import ContactTable
from .call import Task
from .exact import exact

FILE = Path(__file__).with_name("yardsticks.json")
ASIDE = 1e-9            # of a start, as a share of the largest value of the coordinate in the case
GROWN = 1e-3            # largest difference of a displacement, as a share of its largest value, at the horizon
LONGEST = 4.0           # that twins run [s]
ROWS = 1e-4             # between rows of twins [s]
DISPLACEMENTS = "Y", "Z", "roll"
# The coordinates of the start and the variables of the namelist that set them.
STARTS = {"Y": "initial_Y", "Z": "initial_Z", "roll": "initial_roll", "vY": "vY", "vZ": "vZ", "roll_rate": "roll_rate"}


@dataclass(frozen=True)
class Yardstick:
    """What scores of a simulation are measured by."""

    horizon: float              # [s]; where a difference has not grown so far, the longest time that was tried
    reached: bool               # whether the difference grew to the limit in that time
    end: float | None           # of our own run [s]; None where it is behind the horizon
    growth: float               # how many times a difference of the start has grown at most until then and the horizon
    hertz: Mapping[str, float]      # relative difference of Hertz's law from half-spaces, by the name of the score
    rigid: Mapping[str, float]      # relative difference of rigid contacts from half-spaces


@functools.cache
def yardsticks() -> dict[str, Yardstick]:
    """The yardsticks of the ten simulations by their names."""
    return {name: Yardstick(**facts) for name, facts in json.loads(FILE.read_text(encoding="utf-8")).items()}


def horizon(task: Task) -> float:
    """The time [s] in a simulation beyond which nothing is scored."""
    return yardsticks()[task.name].horizon


def spreads(task: Task) -> dict[str, dict[str, float]]:
    """Relative differences of our own runs with Hertz's law ('hertz') and with rigid contacts ('rigid') from that with
    half-spaces, by the name of the score."""
    known = yardsticks()[task.name]
    return {"hertz": dict(known.hertz), "rigid": dict(known.rigid)}


# Measurement ------------------------------------------------------------------------------

@dataclass(frozen=True)
class Growth:
    """How the difference of twins grows: the largest of all displacements and twins so far, in units of that of the start."""

    time: np.ndarray        # (rows,) [s]
    factor: np.ndarray      # (rows,)

    @property
    def horizon(self) -> float | None:
        """The first time at which the difference has grown to GROWN [s]; None where it has not."""
        grown = np.flatnonzero(self.factor >= GROWN/ASIDE)
        return float(self.time[grown[0]]) if grown.size else None

    def until(self, t: float) -> float:
        """The growth up to a time [s] and to the horizon."""
        return float(min(self.factor[:np.searchsorted(self.time, t, "right")].max(), GROWN/ASIDE))


def growth(case: Case, table: ContactTable | None = None, t_end: float = LONGEST) -> Growth:
    """Run a case and its six twins up to a time [s], whatever ends the case else.

    Coordinates are measured by their largest values in the case as it stands, up to that time.
    """
    case = exact(case).replace(interval=ROWS, rows="interval", t_end=t_end)
    own = run(case, table=table)
    sizes = {column: float(np.abs(own.values(column)).max()) for column in STARTS}
    case = case.replace(stop_at="t_end")
    first = run(case, table=own.table.for_case(case))
    twins = (run(twin, table=first.table) for twin in beside(case, sizes))
    return grown(first, twins, sizes)


def beside(case: Case, sizes: Mapping[str, float]) -> Iterator[Case]:
    """The case with each coordinate of the start aside."""
    for column, variable in STARTS.items():
        yield case.replace(**{variable: getattr(case, variable) + ASIDE*sizes[column]})


def grown(first: RunData, twins: Iterator[RunData], sizes: Mapping[str, float]) -> Growth:
    """The growth of the difference between a run and its twins, whose rows are at the same times."""
    t = first.time
    found = np.zeros(len(t))
    for twin in twins:
        rows = min(len(t), len(twin.time))
        for column in DISPLACEMENTS:
            apart = np.abs(first.values(column)[:rows] - twin.values(column)[:rows])/sizes[column]
            found[:rows] = np.maximum(found[:rows], apart)
    return Growth(t, np.maximum.accumulate(found)/ASIDE)
