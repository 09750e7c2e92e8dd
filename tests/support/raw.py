"""What a run's numbers are, from the rows of its column file and the namelist in its head, by numpy alone.

Nothing of the package is used, so that a fault of the package cannot hide itself. Sides are 'L' and 'R', contacts 'LT', 'LF',
'RT' and 'RF'; all numbers are SI.
"""
from __future__ import annotations

import re
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.integrate import trapezoid

from probes import gaps, left_rail, left_wheel, profile, turned

FLANGE_ANGLE = np.radians(25)       # from which a contact is one of the flange (&contact flange_angle)
GRAVITY = 9.81
PAIR = {"L": "aw", "R": "sw"}       # the profiles of each side of the specimen


class Raw:
    """A column file as text and rows."""

    def __init__(self, file: Path) -> None:
        self.file, self.text = file, file.read_text()
        names, *lines = self.text.splitlines()
        rows = np.array([line.split() for line in lines if not line.startswith("#")], float)
        self.c = dict(zip(names.split(), rows.T, strict=True))
        self.t = self.c["time"]
        self.rounding = 1e-9        # share by which what is drawn from this file may differ from its numbers
        told = "\n".join(line for line in lines if line.startswith("#"))
        self.head, _, self.results = told.partition("# &results")      # before the rows or behind them

    def setting(self, name: str) -> float:
        """A number of the namelist."""
        return float(re.search(rf"^#   {name} = (\S+)", self.head, re.MULTILINE)[1])

    def settings(self, name: str) -> tuple[float, ...]:
        """Numbers in a row that the core knew before the run."""
        return tuple(map(float, re.search(rf"^#   {name} = ([^!\n]+)", self.head, re.MULTILINE)[1].split(",")))

    def errors(self) -> dict[str, tuple[float, float]]:
        """Errors of the contact force, rms and largest, by place."""
        return {place: (float(rms), float(largest)) for place, rms, largest in re.findall(
            r"^#   table_error_(\w+) = ([^,!\n]+), ([^!\n]+)", self.results, re.MULTILINE)}

    @cached_property
    def weight(self) -> float:
        return self.setting("mass")*GRAVITY + self.setting("vertical_load")

    @cached_property
    def sinking(self) -> float:
        """How far wheels and rails at rest overlap."""
        return float(np.mean([self.overlap(c, 0, at_rest=True) for c in ("LT", "RT")]))

    def peak(self, contact: str) -> tuple[float, float]:
        """The largest normal force and its time."""
        k = int(self.c[f"N_{contact}"].argmax())
        return self.c[f"N_{contact}"][k], self.t[k]

    def episodes(self, contact: str) -> list[slice]:
        """Rows from the open one before to the open one after each time in which a contact carries more than a newton."""
        closed = np.concatenate([[False], self.c[f"N_{contact}"] > 1.0, [False]])
        edges = np.flatnonzero(closed[1:] != closed[:-1]).reshape(-1, 2)
        return [slice(max(a - 1, 0), min(b + 1, len(self.t))) for a, b in edges]

    def first(self, contact: str) -> slice | None:
        """The first episode of a contact, of a flange not of its root."""
        for rows in self.episodes(contact):
            k = rows.start + int(self.c[f"N_{contact}"][rows].argmax())
            if contact[1] == "T" or abs(self.c[f"angle_{contact}"][k]) >= FLANGE_ANGLE:
                return rows
        return None

    def start(self, contact: str) -> float:
        """When the first contact begins: the row in which it carries nothing yet."""
        rows = self.first(contact)
        return self.t[rows.start] if rows else np.nan

    def first_peak(self, contact: str) -> int | None:
        """The row of the largest force in the first contact."""
        rows = self.first(contact)
        return rows.start + int(self.c[f"N_{contact}"][rows].argmax()) if rows else None

    def impact(self, contact: str) -> dict[str, float]:
        """The numbers of the first contact."""
        rows = self.first(contact)
        return {} if rows is None else self.exchange(contact, rows)

    def exchange(self, contact: str, rows: slice) -> dict[str, float]:
        """The numbers of an episode."""
        t, n = self.t[rows], self.c[f"N_{contact}"][rows]
        k = rows.start + int(n.argmax())
        found = {"start": t[0], "duration": t[-1] - t[0], "peak": n.max(), "angle": abs(self.c[f"angle_{contact}"][k]),
                 "impulse": float(trapezoid(n, t)),
                 "elastic": (self.c["PE_elastic_L"] + self.c["PE_elastic_R"])[rows].max()}
        for part in "lat", "vert", "roll":
            found |= {f"{part}_before": self.c[f"KE_{part}"][rows][0], f"{part}_after": self.c[f"KE_{part}"][rows][-1]}
        return found

    def turned(self, contact: str) -> float:
        """Impulse of a flange from its first touch until the wheelset moves back [N s]."""
        first = self.first(contact).start
        back = first + int(np.argmax({"L": 1, "R": -1}[contact[0]]*self.c["vY"][first:] < 0))
        until = [float(trapezoid(self.c[f"N_{contact}"][first:k + 1], self.t[first:k + 1])) for k in (back - 1, back)]
        return float(np.interp(0.0, sorted(self.c["vY"][back - 1:back + 1]), until if self.c["vY"][back] > 0 else until[::-1]))

    @cached_property
    def events(self) -> list[tuple[float, str, dict[str, float]]]:
        """Time, kind and other numbers of each event in the results of the file."""
        found: dict[int, dict[str, str]] = {}
        for k, name, text in re.findall(r"event\((\d+)\)%(\w+) = ('[^']*'|[^,\s]+)", self.results):
            found.setdefault(int(k), {})[name] = text
        return [(float(one.pop("t")), one.pop("kind").strip("'"), {name: float(x) for name, x in one.items() if name != "cause"})
                for one in found.values()]

    def result(self, name: str) -> float:
        """A number of &results that rows do not tell."""
        return float(re.search(rf"^#   {name} = (\S+)", self.results, re.MULTILINE)[1])

    def loads(self, side: str) -> np.ndarray:
        """Vertical force on a wheel."""
        return self.c[f"Fz_{side}T"] + self.c[f"Fz_{side}F"]

    def ratio(self, side: str) -> np.ndarray:
        """L/V: outwards is to the left on the left and to the right on the right, where the rail pushes the other way."""
        outwards = {"L": -1, "R": 1}[side]*(self.c[f"Fy_{side}T"] + self.c[f"Fy_{side}F"])
        with np.errstate(all="ignore"):
            return np.where(self.loads(side) > 0, outwards/self.loads(side), np.nan)

    def lift_offs(self, side: str, landings: bool = False) -> int:
        """How often a wheel leaves its rail, or comes down on it."""
        closed = self.c[f"N_{side}T"] + self.c[f"N_{side}F"] > 0
        return int(np.sum((closed[:-1] != closed[1:]) & (closed[1:] == landings)))

    def changes(self, kind: str) -> np.ndarray:
        """When the rows show an event of a kind: a flange closes, a wheel leaves its rail or comes down on it, the wheelset passes
        the centre; any row of other kinds."""
        if kind == "centre passage":
            return self.passages()
        side = kind[0].upper()
        if not kind.endswith(("flange contact", "wheel lift-off", "wheel landing")):
            return self.t
        closed = self.c[f"N_{side}F"] + (0 if "flange" in kind else self.c[f"N_{side}T"]) > 0
        way = closed[1:] < closed[:-1] if "lift" in kind else closed[1:] > closed[:-1]
        # The row of an event is the last one before it or the first one after it.
        return np.unique([self.t[:-1][way], self.t[1:][way]])

    def passages(self) -> np.ndarray:
        """When the wheelset passes the centre, by straight lines between rows."""
        y, t = self.c["Y"], self.t
        k = np.flatnonzero(y[1:-1]*y[2:] < 0) + 1
        return t[k] - y[k]*(t[k + 1] - t[k])/(y[k + 1] - y[k])

    def extreme(self, column: str, sign: int) -> float:
        """The largest (1) or smallest (-1) value, on the parabola through its three rows."""
        x = sign*self.c[column]
        k = int(x.argmax())
        if not 0 < k < len(x) - 1:
            return sign*x[k]
        t = (self.t[k - 1:k + 2] - self.t[k])/(self.t[k + 1] - self.t[k - 1])
        a, b, c = np.polyfit(t, x[k - 1:k + 2], 2)
        return sign*(c - b*b/(4*a) if a < 0 else x[k])

    def overlap(self, contact: str, k: int, at_rest: bool = False) -> float:
        """How deep the outline of the wheel is in that of the rail at row k or at rest, both from the profile files."""
        side, mirror = contact[0], {"L": 1, "R": -1}[contact[0]]
        wheel, rail = left_wheel(PAIR[side]), left_rail(PAIR[side])
        y, z, roll = (0.0, 0.0, self.setting("axle_roll")) if at_rest else (self.c[name][k] for name in ("Y", "Z", "roll"))
        wheel = turned(wheel, mirror*roll) + [mirror*y, self.setting("axle_height") + z]
        near = np.hypot(*(wheel - [mirror*self.c[f"y_{contact}"][k], self.c[f"z_{contact}"][k]]).T) < 8e-3
        away = gaps(wheel[near], rail)
        return float(max(-away.min(), away.max()) if rail[0, 0] < rail[-1, 0] else -away.min())

    def drift(self) -> tuple[float, float]:
        """The largest energy error of the rows, absolute and over the kinetic energy at the start or the work of the force."""
        found = np.abs(self.c["E_drift"]).max()
        kinetic = sum(self.c[f"KE_{part}"][0] for part in ("lat", "vert", "roll"))
        return found, found/(kinetic or np.abs(self.c["W_ext"]).max())


def mean_square(t: np.ndarray, x: np.ndarray) -> float:
    """The mean over time."""
    return float(trapezoid(x**2, t)/(t[-1] - t[0]))


def flange_slope() -> float:
    """The steepest angle of the actual wheel's flange, from its points."""
    y, z = profile("awprof").T
    face = (y > 0.02) & (y < 0.045)
    return float(np.abs(np.arctan2(np.diff(z[face]), np.diff(y[face]))).max())
