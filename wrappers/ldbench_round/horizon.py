"""How far into a simulation a score means something, and how far formulations of our own differ until then.

Impacts multiply differences. The horizon of a simulation is the first time at which a difference of 1e-9 of the start has grown
to 1e-3 of the motion: then the motion depends on digits of the start that no code promises. It is measured on twins of an exact
run, whose start is aside in one coordinate each. Another integrator on the same forces tells whether our own has made it.
yardsticks.json keeps what `make yardsticks` has measured, see docs/yardsticks.py.
"""
from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .tasks import Task

FILE = Path(__file__).with_name("yardsticks.json")
BEYOND = 1.2            # times the horizon, up to which runs of exercise 5 go
DISPLACEMENTS = "Y", "Z", "roll"


@dataclass(frozen=True)
class Yardstick:
    """What scores of a simulation are measured by."""

    horizon: float              # [s]; where a difference has not grown so far, the longest time that was tried
    reached: bool               # whether the difference grew to the limit in that time
    end: float | None           # of our own run [s]; None where it is behind the horizon
    growth: float               # how many times a difference of the start has grown at most until then and the horizon
    hertz: Mapping[str, float]      # relative difference of Hertz's law from half-spaces, by the name of the score
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
