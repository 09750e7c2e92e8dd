"""Derailed means no way back: a sweep of initial lateral velocities in which every run is allowed to go on.

A wheelset has derailed when the tip of a flange is outside the highest point of its rail and the wheelset moves outwards: from
there the crown pushes outwards, and the tread of the other wheel rolls down its cone. That there is no way back is tried:
initial lateral velocities from 1 to 4 m/s in equal steps, both pairs of profiles, in every formulation, each run going on
until the wheelset has returned to the centre after both flanges, or has left what the contact table covers. No run that is
called derailed may come back, its centre of gravity not at all, and every other one has to return. How far the tip of a flange
goes is computed from the profile files and the columns alone. The tables go 6 mm deep, for 4 m/s press the flange farther into
the rail than the shipped tables go.
"""
from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pandas as pd

import ldbench
from checks import Check, Section, limit
from ldbench import Case, ContactTable
from ldbench.case import data_folder
from ldbench.report import formulations
from sheets import Table

PAIRS = "aw", "sw"
SPEEDS = 1.0, 4.0           # initial lateral velocity [m/s]
RUNS = 200
PER_SPEED = 1/30            # roll rate over lateral velocity, as in the call [rad/m]
DEPTH = 6e-3                # largest penetration of the tables: 4 m/s press deeper than the shipped cases [m]
LONGEST = 5.0               # a run that has neither returned nor left by then is a question [s]
RETURN = "return to the centre after both flanges"

@dataclass(frozen=True)
class Fate:
    """What became of one run."""
    speed: float            # [m/s]
    ending: str
    derailed: float         # when [s]; nan: not
    farthest: float         # a flange's tip, outside the highest point of its rail at most [m]
    back: float             # how far the centre of gravity comes back from where it derailed [m]; nan: not derailed

    @property
    def verdict(self) -> str:
        """'returns', 'derails', or what is wrong with the run."""
        if self.ending == RETURN:
            return "returns" if np.isnan(self.derailed) else "derails and returns"
        if np.isnan(self.derailed):
            return "unfinished: " + self.ending
        return "derails" if self.back <= 0 else "derails and comes back"


def past_crown(case: Case, columns: pd.DataFrame) -> np.ndarray:
    """How far the tips of both flanges are outside the highest points of their rails [m], (rows, 2): left, right.

    The treads of the shipped wheels have z = 0 where they run, their rails y = 0 at the gauge point."""
    wheel, rail = (1e-3*np.loadtxt(data_folder()/file) for file in (case.wheel_profile, case.rail_profile))
    tip = wheel[wheel[:, 1].argmin()] + [case.back_to_back/2, -case.rolling_radius]
    crown = case.gauge/2 + rail[rail[:, 1].argmax(), 0]
    roll = columns.roll.to_numpy()[:, None]*[1, -1]
    return columns.Y.to_numpy()[:, None]*[1, -1] - tip[1]*np.sin(roll) + tip[0]*np.cos(roll) - crown


def fate(case: Case, table: ContactTable) -> Fate:
    try:
        run = ldbench.run(case, table=table)
    except ldbench.Error as error:
        return Fate(case.vY, str(error), np.nan, np.nan, np.nan)
    time, past = run.data.time.to_numpy(), past_crown(case, run.data)
    derailed = next((event.t for event in run.events if event.kind == "derailment"), np.nan)
    aside = np.abs(run.data.Y.to_numpy()[time > derailed])
    return Fate(case.vY, run.ending, derailed, float(past.max()),
                float(aside[0] - aside.min()) if aside.size else np.nan if np.isnan(derailed) else 0.0)


def sweep(pair: str, formulation: str) -> list[Fate]:
    """Runs from 1 to 4 m/s, both ends included."""
    case = Case.exercise(4, pair).replace(**formulations.FORMULATIONS[formulation], table_folder="", depth=DEPTH, t_end=LONGEST)
    table = ContactTable(case)
    speeds = np.linspace(*SPEEDS, RUNS).tolist()
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda v: fate(case.replace(vY=v, roll_rate=PER_SPEED*v), table), speeds))


def section() -> Section:
    checks: list[Check] = []
    rows = []
    for pair in PAIRS:
        for name in formulations.FORMULATIONS:
            fates = sweep(pair, name)
            verdicts = [f.verdict for f in fates]
            checks += [
                limit(f"{pair}, {name}: runs of {RUNS} that derail and come back", sum("and" in v for v in verdicts),
                      "derailed means no way back", 0),
                limit(f"{pair}, {name}: runs of {RUNS} that neither return nor derail",
                      sum(v.startswith("unfinished") for v in verdicts), "there is no third way", 0)]
            returning = [f for f in fates if f.verdict == "returns"]
            derailing = [f for f in fates if f.verdict == "derails"]
            rows.append([pair, name, str(len(returning)), str(len(derailing)),
                         f"{min((f.speed for f in derailing), default=np.nan):.3f}",
                         f"{1e3*max(f.farthest for f in returning):.2f}",
                         f"{1e3*min((f.farthest for f in derailing), default=np.nan):.2f}"])
            for f in fates:
                if f.verdict not in ("returns", "derails"):
                    print(f"  {pair}, {name}, {f.speed:.4f} m/s: {f.verdict}")
    return Section("Derailment: no run that is called derailed comes back", __doc__, checks, [Table(
        "Endings, and how far the tip of a flange is outside the highest point of its rail, at most in each run",
        ["pair", "formulation", "return", "derail", "slowest that derails [m/s]", "farthest of those that return [mm]",
         "least of those that derail [mm]"], rows)])
