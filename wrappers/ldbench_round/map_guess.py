"""The map of another code's columns, found by trying to agree with our own run of the same simulation.

A column of the file stands for one of ours if, with one of the known units and one of the two signs, it follows ours up to
the end of the first flange contact; the name helps. Codes differ by tens of percent in an impact, and units by factors of
4 and more, so that a wrong unit or sign cannot hide behind the physics.
"""
from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ldbench import Error
from ldbench.constants import CONTACTS
from ldbench.results.columns import UNITS, RawTable
from ldbench.results.run_data import RunData
from ldbench.tools import counted

from .column_names import flat, meanings
from .energies import ENERGIES, energy_named
from .jumps import ACCELERATIONS, VELOCITIES
from .tasks import QUANTITIES

SURE = 0.35         # likeness from which the numbers of a column confirm its name
ALONE = 0.75        # least likeness of a column whose name says nothing
BONUS = 2.0                         # of a name that fits: no likeness without a name outweighs it
NAMED_ALIKE = 0.7                   # likeness of a named column that has our size at other instants, as later impacts do
NEAR = 1.3                          # ratio of a rate to a change over an interval, of which rows are not too far apart
MISSTATED = 30.0                    # how many times nearer to ours a file has to last in another unit of time than it states
EARLY = 0.95                        # weight of the likeness before the flange touches
JOULES = {"N.m": "J", "Nm": "J", "kN.m": "kJ", "kNm": "kJ"}
SYNONYMS = {"sec", "Nm", "kNm", "-"}
RARE = {"in", "lbf", "cm", "in/s", "MN"}     # less likely, unless the file says them
UNUSUAL = {"um", "g", "km/h", "ft", "ft/s", "ft/s2", "in/s2", "cm/s", "cm/s2", "urad", "gon", "daN", "kgf", "kp", "kips",
           "us"}                    # only if the file says them
ROWS = 400                          # instants at which columns are compared
HALF_GAUGE = 0.70, 0.78             # distance of a rail from the centre, by the gauge or by the running circles [m]
ZERO_MAY_DIFFER = {"Z", *(f"{name}_{contact}" for name in ("y", "z") for contact in CONTACTS)}


class Option(NamedTuple):
    """A unit and a sign with which a column may follow one of ours."""

    likeness: float
    unit: str
    sign: int
    offset: float               # [SI]


@dataclass(frozen=True)
class Match:
    """A column of the file that stands for one of ours."""

    column: str                 # ours
    number: int                 # of the file's, from 1
    name: str                   # of the file's
    said: str                   # unit that the file states; '' without one
    unit: str                   # unit that fits
    sign: int
    offset: float               # [SI]
    likeness: float             # 0 to 1, with ours up to the end of the first flange contact; NaN where nothing can be compared
    options: tuple[Option, ...] = ()    # all units and signs, the likeliest first


@dataclass(frozen=True)
class Guess:
    """The map of a file."""

    matches: dict[str, Match]

    @property
    def map(self) -> dict[str, dict[str, Any]]:
        """The column map, as `read_run` takes it."""
        return {column: {"column": m.number, "unit": m.unit, "factor": m.sign, "offset": m.offset}
                for column, m in self.matches.items()}

    def toml(self) -> str:
        """The map as a TOML file, for `--map`."""
        lines = []
        for column, m in self.matches.items():
            # A name that is not unique, or that TOML would have to escape, gives way to the number.
            parts = [f"column = {m.number}"]
            parts += [f'unit = "{m.unit}"'] if m.unit != "1" else []
            parts += ["factor = -1"] if m.sign < 0 else []
            parts += [f"offset = {m.offset!r}"] if m.offset else []
            lines.append(f"{column} = {{ {', '.join(parts)} }}   # {' '.join(m.name.split())}")
        return "\n".join(lines) + "\n"


def guess_map(file: Path, ours: RunData, raw: RawTable, length: float) -> Guess:
    """Find the map of a file by our own run of the same simulation. Error where no column can be the time.

    raw: what the file holds. length: how long such a file lasts, roughly [s].
    """
    time = find_time(file, raw, length)
    t = time.offset + UNITS[time.unit][1]*raw.numbers[:, time.number - 1]
    taken: dict[str, Match] = {"time": time}
    used = {time.number}
    for _, match in sorted(likely_matches(raw, t, ours, time.number), key=lambda found: -found[0]):
        if match.column not in taken and match.number not in used:
            taken[match.column] = match
            used.add(match.number)
    tell_normal_from_vertical(raw, taken)
    agree_on_signs(taken)
    agree_on_units(taken, ours)
    agree_with_velocities(raw, t, taken)
    agree_on_zeros(taken)
    match_energies(raw, taken, used)
    return Guess({column: taken[column] for column in ("time", *QUANTITIES, *ENERGIES) if column in taken})


def match_energies(raw: RawTable, taken: dict[str, Match], used: set[int]) -> None:
    """Find energies by their names alone: the motion judges their numbers, and no unit but the joule is in use."""
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True), 1):
        column = energy_named(flat(name)) if k not in used else ""
        unit = JOULES.get(said, said)
        if column and column not in taken and (not unit or UNITS[unit][0] == "J"):
            taken[column] = Match(column, k, name, unit, unit or "J", 1, 0.0, np.nan)
            used.add(k)


def tell_normal_from_vertical(raw: RawTable, taken: dict[str, Match]) -> None:
    """Exchange N and Fz of a tread whose names say nothing, if Fz is the larger one: they differ by a thousandth."""
    for contact in CONTACTS:
        pair = [taken.get(f"{name}_{contact}") for name in ("N", "Fz")]
        if None in pair or any(meanings(match.name, match.said) for match in pair if match):
            continue
        normal, vertical = (match for match in pair if match)
        sizes = [np.nanmean(np.abs(raw.numbers[:, match.number - 1])) for match in (normal, vertical)]
        if sizes[1] > sizes[0] and normal.unit == vertical.unit:
            taken[f"N_{contact}"] = replace(vertical, column=f"N_{contact}", sign=1)
            taken[f"Fz_{contact}"] = replace(normal, column=f"Fz_{contact}", sign=vertical.sign)


def find_time(file: Path, raw: RawTable, length: float) -> Match:
    """The column that is the time: it never falls, and its name or its place says so. length: of such files, roughly [s]."""
    found = []
    falling = ""
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True)):
        x = raw.numbers[:, k]
        if x.size < 3 or not np.isfinite(x).all() or (np.diff(x) < 0).any() or np.unique(x).size < x.size/2:
            if "time" in meanings(name) and x.size > 1:
                falling = why_no_time(name, x)
            continue
        stated = UNITS.get(said, ("",))[0] == "s"
        # A stated unit is wrong only if the length of the file cannot be explained otherwise.
        costs = {unit: abs(np.log((x[-1] - x[0])*UNITS[unit][1]/length)) + (stated and unit != said)*np.log(MISSTATED)
                 for unit in (*([said] if stated else []), "s", "ms")}
        unit = min(costs, key=lambda unit: costs[unit])
        t = x*UNITS[unit][1]
        # Results may begin at the first step; a longer delay is the time of another zero.
        offset = 0.0 if 0 <= t[0] <= 2*np.median(np.diff(t)) else -float(t[0])
        found.append((0 if "time" in meanings(name) else 1, k, Match("time", k + 1, name, said, unit, 1, offset, np.nan)))
    if not found:
        raise Error(file=file, expected="a column that can be the time, which never falls", found=falling or "none")
    return min(found)[2]


def why_no_time(name: str, x: np.ndarray) -> str:
    """Why a column that is called the time cannot be it."""
    if not np.isfinite(x).all():
        return f"'{name}', which has {counted(int(np.sum(~np.isfinite(x))), 'cell')} without a number, first in row " \
               f"{int(np.argmin(np.isfinite(x))) + 1}"
    falls = np.flatnonzero(np.diff(x) < 0)
    if falls.size:
        k = int(falls[0])
        return f"'{name}', which falls {counted(falls.size, 'time')}, first from {x[k]:g} to {x[k + 1]:g} in row {k + 2}"
    return f"'{name}', which has {np.unique(x).size} different times in {x.size} rows"


def likely_matches(raw: RawTable, t: np.ndarray, ours: RunData, time: int) -> Iterator[tuple[float, Match]]:
    """Every column of the file with every one of ours that it may stand for, with a weight."""
    windows = {side: contact_window(ours, side) for side in ("L", "R")}
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True)):
        meant = meanings(name, said)
        x = raw.numbers[:, k]
        # A column without a name that never changes tells nothing by its numbers.
        if k + 1 == time or not (meant or np.nanmax(x) > np.nanmin(x)):
            continue
        for column in QUANTITIES:
            if column not in ours.data or (meant and column not in meant):
                continue
            found = units_that_fit(x, t, said, ours, column, windows, bool(meant))
            if found and (meant or found[0].likeness >= ALONE):
                likeness, unit, sign, offset = found[0]
                yield (likeness + BONUS*bool(meant),
                       Match(column, k + 1, name, said, unit, sign, offset, likeness, tuple(found)))


def contact_window(ours: RunData, side: str) -> tuple[float, float]:
    """From shortly before the first contact of a flange to shortly after its end [s]."""
    first = ours.first_interval(side + "F")
    if first is None:
        return 0.0, float(ours.time[-1])
    return first.start - 0.2*first.duration, first.end + 0.2*first.duration


def units_that_fit(x: np.ndarray, t: np.ndarray, said: str, ours: RunData, column: str,
                   windows: dict[str, tuple[float, float]], named: bool) -> list[Option]:
    """Units, signs and offsets with which a column of the file may follow one of ours, the likeliest first."""
    si, on_right = ours.data.attrs["units"][column], column.endswith("_RF")
    compared = on_common_instants(x, t, ours, column, windows["R"] if on_right else (0.0, windows["L"][1]))
    early = on_common_instants(x, t, ours, column, (0.0, windows["L"][0])) if named and not on_right else None
    later = while_closed(x, ours, column) if named and on_right else None
    if compared is None and not named:
        return []
    found = []
    for unit, (kind, factor) in UNITS.items():
        if kind != si or unit in SYNONYMS or (unit in UNUSUAL and unit != said):
            continue
        for sign in (1,) if column.startswith("radius") else (1, -1):
            offset = likeness = 0.0
            if compared is not None:
                y, there = sign*factor*compared[0], compared[1]
                if column in ZERO_MAY_DIFFER:
                    offset = float(np.median(there - y))
                    if abs(offset) <= 0.02*rms(there):
                        offset = 0.0
                likeness = follows(y + offset, there)
                if named:
                    likeness = max(likeness, NAMED_ALIKE*is_as_large(y + offset, there))
                if early is not None:
                    # Before the flange touches, the motion is that of the profiles in every code.
                    likeness = max(likeness, EARLY*follows(sign*factor*early[0] + offset, early[1]))
            if later is not None:
                # Impacts on the right come at other times in every code.
                alike = NAMED_ALIKE*is_as_large(sign*factor*later[0], later[1])
                offset, likeness = (0.0, alike) if alike > likeness else (offset, likeness)
            likeness -= 0.05*(offset != 0) + 0.3*(bool(said) and unit != said) + 0.05*(unit in RARE and unit != said)
            found.append(Option(float(likeness), unit, sign, offset))
    return sorted(found, key=lambda option: -option.likeness)


def on_common_instants(x: np.ndarray, t: np.ndarray, ours: RunData, column: str,
                       window: tuple[float, float]) -> tuple[np.ndarray, np.ndarray] | None:
    """A column of the file and ours at equal instants of a window, while the contact is closed in both; None if it never is."""
    r = ours.values(column)
    known, usable = np.isfinite(r), np.isfinite(x)
    if known.sum() < 3 or usable.sum() < 3:
        return None
    shift = start_of_activity(x, t) - start_of_activity(r, ours.time) if column.endswith("_RF") else 0.0
    at = np.linspace(*window, ROWS)
    there = np.interp(at, ours.time[known], r[known])
    there[np.interp(at, ours.time, (~known).astype(float)) > 0] = np.nan
    here = np.interp(at + shift, t[usable], x[usable], left=np.nan, right=np.nan)
    alive = np.isfinite(here) & np.isfinite(there)
    if alive.sum() < 10 or not np.ptp(here[alive]):
        return None
    return here[alive], there[alive]


def while_closed(x: np.ndarray, ours: RunData, column: str) -> tuple[np.ndarray, np.ndarray] | None:
    """The numbers of both columns in all rows in which the contact is closed."""
    here, there = x[np.isfinite(x) & (x != 0)], ours.values(column)[ours.closed(column[-2:])]
    return (here, there) if here.size > 3 and there.size > 3 else None


# What columns have in common: the direction of an axis, and the unit of a quantity.
AXES = {"lateral": ("Y", "vY", "aY", *(f"y_{c}" for c in CONTACTS)), "vertical": ("Z", "vZ", "aZ", *(f"z_{c}" for c in CONTACTS)),
        "roll": ("roll", "roll_rate", "roll_acc"), "lateral force": tuple(f"Fy_{c}" for c in CONTACTS),
        "vertical force": tuple(f"Fz_{c}" for c in CONTACTS),
        "left contact angle": ("angle_LT", "angle_LF"), "right contact angle": ("angle_RT", "angle_RF")}
CLEAR = 0.6         # by how much a column has to be likelier with a sign of its own


def agree_on_signs(taken: dict[str, Match]) -> None:
    """Give all columns of an axis one sign, but for those that clearly have another one."""
    for columns in AXES.values():
        there = [taken[column] for column in columns if column in taken]
        likelier = sum(side_sign(m)*(best_of(m, sign=1) - best_of(m, sign=-1)) for m in there)
        for m in there:
            sign = side_sign(m)*(1 if likelier >= 0 else -1)
            if m.sign != sign and m.likeness - best_of(m, sign=sign) < CLEAR:
                choose(taken, m, sign=sign)


def side_sign(match: Match) -> int:
    """-1 for a column of the right wheel whose name says that it counts outwards or inwards: its axis is turned; 1 otherwise."""
    return -1 if match.column[-2:] in ("RT", "RF") and re.search("outward|inward", match.name.lower()) else 1


def agree_on_units(taken: dict[str, Match], ours: RunData) -> None:
    """Give columns of a kind one unit, but for those whose numbers clearly contradict it: the stated one, if it fits half of them
    at least; where none is stated, the likeliest.

    Forces of codes with constraint equations are of another size than ours, by as much as a pound.
    """
    units = ours.data.attrs["units"]
    for si, said in dict.fromkeys((units[m.column], m.said) for m in taken.values() if m.options):
        there = [m for m in taken.values() if m.options and (units[m.column], m.said) == (si, said)]
        votes = {unit: sum(m.likeness for m in there if m.unit == unit) for unit in {m.unit for m in there}}
        unit = said or max(votes, key=lambda unit: (votes[unit], unit))
        if said and 2*sum(m.unit != said for m in there) > len(there):
            continue
        for m in there:
            # Impacts on the right are as large as they like: their sizes say little of the unit. No code writes forces in
            # several units without saying so, while lengths may be millimetres of motion and metres of contact positions.
            clear = SURE if said else np.inf if si == "N" else CLEAR if m.column.endswith("_RF") else CLEAR/2
            if m.unit != unit and m.likeness - best_of(m, m.sign, unit) < clear:
                choose(taken, m, m.sign, unit)


def agree_on_zeros(taken: dict[str, Match]) -> None:
    """Give contact positions of an axis the zero that those of the treads have: a flange may be touched elsewhere than ours.

    One zero is that of both wheels, unless each counts from its own rail.
    """
    for name in ("y", "z"):
        treads = {side: taken[f"{name}_{side}T"].offset for side in "LR" if f"{name}_{side}T" in taken}
        of_rails = all(HALF_GAUGE[0] < way*treads.get(side, 0.0) < HALF_GAUGE[1] for side, way in (("L", 1), ("R", -1)))
        for column in (f"{name}_LF", f"{name}_RF"):
            if treads and column in taken:
                zero = treads[column[-2]] if of_rails else sum(treads.values())/len(treads)
                taken[column] = replace(taken[column], offset=zero)


def agree_with_velocities(raw: RawTable, t: np.ndarray, taken: dict[str, Match]) -> None:
    """Give an acceleration that does not follow ours the unit in which it is the rate of its velocity, in most intervals.

    The accelerations of codes with constraint equations are of another size than ours, and impulses are in no column.
    """
    for v_name, a_name in zip(VELOCITIES, ACCELERATIONS, strict=True):
        v, a = taken.get(v_name), taken.get(a_name)
        if v is None or a is None or a.likeness >= SURE:
            continue
        change = UNITS[v.unit][1]*np.diff(raw.numbers[:, v.number - 1])
        x = raw.numbers[:, a.number - 1]
        expected = np.diff(t)*(x[1:] + x[:-1])/2
        size = np.abs(expected)
        told = np.isfinite(change) & (size > 0)
        told &= size >= np.median(size[told]) if told.any() else told
        factor = float(np.median(np.abs(change[told])/size[told])) if told.any() else 0.0
        for option in a.options:
            if factor > 0 and option.sign == a.sign and abs(np.log(factor/UNITS[option.unit][1])) < np.log(NEAR):
                choose(taken, a, a.sign, option.unit)
                break


def best_of(match: Match, sign: int, unit: str = "") -> float:
    """The largest likeness with a sign, and with a unit."""
    return max((o.likeness for o in match.options if o.sign == sign and unit in ("", o.unit)), default=0.0)


def choose(taken: dict[str, Match], match: Match, sign: int, unit: str = "") -> None:
    """Take the likeliest option with a sign, and with a unit."""
    found = next((o for o in match.options if o.sign == sign and unit in ("", o.unit)), None)
    if found is not None:
        taken[match.column] = replace(match, unit=found.unit, sign=found.sign, offset=found.offset, likeness=found.likeness)


def rms(x: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(x**2)))


def follows(y: np.ndarray, there: np.ndarray) -> float:
    """How nearly y is ours at the same instants: 1 if it is the same."""
    size = max(rms(y), rms(there))
    return 1 - rms(y - there)/size if size > 0 else 0.0


def is_as_large(y: np.ndarray, there: np.ndarray) -> float:
    """How nearly y has the size and the sign of ours, whatever the instants: 1 if it has, 0 from a factor of 4."""
    sizes = rms(y), rms(there)
    if min(sizes) <= 0:
        return 0.0
    peaks = y[np.abs(y).argmax()]*there[np.abs(there).argmax()] > 0
    return max(0.0, 1 - abs(np.log(sizes[0]/sizes[1]))/np.log(4))*(1.0 if peaks else 0.5)


def start_of_activity(x: np.ndarray, t: np.ndarray) -> float:
    """The first time [s] at which a contact's column is neither zero nor empty."""
    active = np.flatnonzero(np.nan_to_num(x) != 0)
    return float(t[active[0]]) if active.size else np.nan


