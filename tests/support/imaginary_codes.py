"""Imaginary codes: runs of ours written as somebody else would write them."""
from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ldbench.results.columns import UNITS
from ldbench.results.run_data import RunData
from ldbench_round.tasks import QUANTITIES

LATERAL = {"Y", "vY", "aY"}, ("Fy_", "y_")
VERTICAL = {"Z", "vZ", "aZ"}, ("Fz_", "z_")
ROLL = {"roll", "roll_rate", "roll_acc"}, ()

# Units of length, angle and force; the velocities and accelerations go with them.
LENGTHS, ANGLES, FORCES = ("m", "mm", "in"), ("rad", "mrad", "deg"), ("N", "kN", "lbf")
LONG = {"LT": "left tread", "LF": "left flange", "RT": "right tread", "RF": "right flange"}


def ours(column: str) -> str:
    return column


def short(column: str) -> str:
    base, _, contact = column.partition("_")
    if contact in LONG:
        return {"angle": "gam", "N": "Fn", "Fz": "Fz", "Fy": "Fy", "y": "yc", "z": "zc", "radius": "rr"}[base] + contact
    return {"time": "t", "Y": "y", "Z": "z", "roll": "phi", "vY": "yd", "vZ": "zd", "roll_rate": "phid", "aY": "ydd", "aZ": "zdd",
            "roll_acc": "phidd"}[column]


def long(column: str) -> str:
    base, _, contact = column.partition("_")
    if contact in LONG:
        words = {"angle": "contact angle", "N": "normal force", "Fz": "vertical force", "Fy": "lateral force",
                 "y": "lateral position", "z": "vertical position", "radius": "rolling radius"}[base]
        return f"{words} {LONG[contact]}".replace(" ", "_")
    return {"time": "Time", "Y": "Lateral displacement", "Z": "Vertical displacement", "roll": "Roll angle",
            "vY": "Lateral velocity", "vZ": "Vertical velocity", "roll_rate": "Roll velocity", "aY": "Lateral acceleration",
            "aZ": "Vertical acceleration", "roll_acc": "Roll acceleration"}[column].replace(" ", "_")


TEXT = ["Results of the code EXAMPLE 3.1", "date: 31 May 2006, 10:22:05", "mass 1568 kg", ""]
PREAMBLES = "", "comments", "text", "units below"       # units below: in a row of their own under the names


SCHEMES: tuple[Callable[[str], str], ...] = ours, short, long


@dataclass(frozen=True)
class Dialect:
    """How a code writes its results."""

    lateral: int = 1            # sign of the lateral axis, seen from ours
    vertical: int = 1
    roll: int = 1
    length: str = "m"
    angle: str = "rad"
    force: str = "N"
    clock: str = "s"
    start: float = 0.0          # time of the first row [s]
    height: float = 0.0         # added to Z [m]
    scheme: int | None = 0      # of SCHEMES; None: columns are numbered
    says_units: bool = True
    separator: str = ","
    interval: float = 1e-4      # of the rows [s]
    shuffled: int | None = None     # seed of the order of the columns
    preamble: str = ""          # of PREAMBLES: what stands above the numbers beside the names

    def sign(self, column: str) -> int:
        """The sign of a column, seen from ours."""
        for (names, beginnings), sign in zip((LATERAL, VERTICAL, ROLL), (self.lateral, self.vertical, self.roll), strict=True):
            if column in names or column.startswith(beginnings or "\0"):
                return sign
        return 1

    def unit(self, column: str, si: str) -> str:
        """The unit of a column."""
        if column == "time":
            return self.clock
        rate = si.partition("/")
        base = {"m": self.length, "rad": self.angle, "N": self.force}[rate[0]]
        if si == "m/s2" and base == "in":
            base = "m"              # no unit of ours has inches there
        return base + rate[1] + rate[2]


def invent(seed: int) -> Dialect:
    """A dialect by chance."""
    chance = random.Random(seed)
    return Dialect(*(chance.choice((1, 1, -1)) for _ in range(3)), chance.choice(LENGTHS), chance.choice(ANGLES),
                   chance.choice(FORCES), chance.choice(("s", "s", "ms")), chance.choice((0.0, 0.0, 0.5, -1.0)),
                   chance.choice((0.0, 0.0, 0.457)), chance.choice((0, 1, 2, 1, 2, None)), chance.choice((True, True, False)),
                   chance.choice(",;\t "), chance.choice((1e-4, 1e-4, 5e-5)), chance.choice((None, seed)),
                   chance.choice(PREAMBLES))


def table_of(run: RunData, interval: float) -> pd.DataFrame:
    """The quantities of the call, on equal intervals; SI units in attrs."""
    t = np.arange(run.time[0], run.time[-1] + interval/2, interval)
    found = {"time": t}
    for column in QUANTITIES:
        x = run.values(column)
        if np.isfinite(x).all():
            found[column] = np.interp(t, run.time, x)
        else:                       # of a contact that is open for a while: between two closed rows
            found[column] = np.interp(t, run.time, np.nan_to_num(x))
            found[column][np.interp(t, run.time, np.isnan(x).astype(float)) > 0] = np.nan
    frame = pd.DataFrame(found)
    frame.attrs["units"] = {name: run.data.attrs["units"][name] for name in frame}
    return frame


def write(frame: pd.DataFrame, path: Path, dialect: Dialect) -> dict[str, int]:
    """Write a table in a dialect; the numbers of the columns, from 1."""
    names = list(frame)
    if dialect.shuffled is not None:
        rest = names[1:]
        random.Random(dialect.shuffled).shuffle(rest)
        names = [names[0], *rest]
    si = frame.attrs["units"]
    heading, below, columns = [], [], []
    for k, name in enumerate(names, 1):
        unit = dialect.unit(name, si[name])
        x = frame[name].to_numpy().copy()
        if name == "time":
            x = x + dialect.start
        if name == "Z":
            x = x + dialect.height
        columns.append(dialect.sign(name)*x/UNITS[unit][1])
        called = f"c{k}" if dialect.scheme is None else SCHEMES[dialect.scheme](name)
        below.append(f"[{unit}]")
        heading.append(f"{called}[{unit}]" if dialect.says_units and dialect.preamble != "units below" else called)
    mark = dialect.separator
    row = mark.join(["%.8g"]*len(columns))
    numbers = "\n".join([row % cells for cells in zip(*(x.tolist() for x in columns), strict=True)])
    if mark != " ":
        numbers = numbers.replace("nan", "")        # an empty cell
    above = {"comments": [f"# {line}" for line in TEXT], "text": TEXT}.get(dialect.preamble, [])
    under = [mark.join(below)] if dialect.says_units and dialect.preamble == "units below" else []
    path.write_text("\n".join([*above, mark.join(heading), *under, numbers]) + "\n")
    return {name: k for k, name in enumerate(names, 1)}


# ---- codes that err ------------------------------------------------------------------
def thinned(frame: pd.DataFrame) -> pd.DataFrame:
    """A row every 2 ms."""
    changed = frame.iloc[::max(1, round(2e-3/(frame["time"].iloc[1] - frame["time"].iloc[0])))]
    changed.attrs = frame.attrs
    return changed


def damped(frame: pd.DataFrame) -> pd.DataFrame:
    """The velocities die away, by a quarter over the run."""
    t = frame["time"].to_numpy()
    fading = 1 - 0.25*t/t[-1]
    changed = frame.assign(**{name: frame[name]*fading for name in ("vY", "vZ", "roll_rate")})
    changed.attrs = frame.attrs
    return changed
