"""The map of another code's columns, found by trying to agree with our own run of the same simulation.

A column of the file stands for one of ours if, with one of the known units and one of the two signs, it follows ours up to
the end of the first flange contact; the name helps. Codes differ by tens of percent in an impact, and units by factors of
4 and more, so that a wrong unit or sign cannot hide behind the physics.
"""
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .._core.errors import Error
from ..results.columns import UNITS, RawTable, Source, read_raw
from ..results.quantities import CONTACTS
from ..results.run_data import RunData
from .call import QUANTITIES
from .names import meanings

NAMED, ALONE = 0.35, 0.75           # least likeness of a column with a fitting name, and of one without
BONUS = 0.5                         # of a name that fits
ROWS = 400                          # instants at which columns are compared
ZERO_MAY_DIFFER = {"Z", *(f"{name}_{contact}" for name in ("y", "z") for contact in CONTACTS)}


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

    @property
    def source(self) -> Source:
        """The entry of a column map."""
        return Source(self.number, self.unit, self.sign, self.offset)


@dataclass(frozen=True)
class Guess:
    """The map of a file."""

    file: Path
    matches: dict[str, Match]
    left_out: list[str] = field(default_factory=list)       # columns of the file that stand for nothing of ours

    @property
    def map(self) -> dict[str, Source]:
        """The column map."""
        return {column: match.source for column, match in self.matches.items()}

    def toml(self) -> str:
        """The map as a TOML file, for `--map`."""
        lines = []
        for column, m in self.matches.items():
            # A name that is not unique, or that TOML would have to escape, gives way to the number.
            parts = [f"column = {m.number}"]
            parts += [f'unit = "{m.unit}"'] if m.unit != "1" else []
            parts += ["factor = -1"] if m.sign < 0 else []
            parts += [f"offset = {m.offset:.9g}"] if m.offset else []
            lines.append(f"{column} = {{ {', '.join(parts)} }}   # {' '.join(m.name.split())}")
        return "\n".join(lines) + "\n"


def guess_map(file: Path, ours: RunData) -> Guess:
    """Find the map of a file by our own run of the same simulation. Error where no column can be the time."""
    raw = read_raw(file)
    time = find_time(file, raw, ours)
    t = time.offset + UNITS[time.unit][1]*raw.numbers[:, time.number - 1]
    candidates = sorted(likely_matches(raw, t, ours, time.number), key=lambda found: -found[0])
    taken: dict[str, Match] = {"time": time}
    used = {time.number}
    for _, match in candidates:
        if match.column not in taken and match.number not in used:
            taken[match.column] = match
            used.add(match.number)
    order = ["time", *QUANTITIES]
    rest = [name for k, name in enumerate(raw.names, 1) if k not in used]
    return Guess(file, {column: taken[column] for column in order if column in taken}, rest)


def find_time(file: Path, raw: RawTable, ours: RunData) -> Match:
    """The column that is the time: it never falls, and its name or its place says so."""
    length = ours.time[-1] - ours.time[0]
    found = []
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True)):
        x = raw.numbers[:, k]
        if x.size < 3 or not np.isfinite(x).all() or (np.diff(x) < 0).any() or np.unique(x).size < x.size/2:
            continue
        units = [said] if UNITS.get(said, ("",))[0] == "s" else ["s", "ms"]
        unit = min(units, key=lambda unit: abs(np.log((x[-1] - x[0])*UNITS[unit][1]/length)))
        t = x*UNITS[unit][1]
        # Results may begin at the first step; a longer delay is the time of another zero.
        offset = 0.0 if 0 <= t[0] <= 2*np.median(np.diff(t)) else -t[0]
        found.append((0 if "time" in meanings(name) else 1, k, Match("time", k + 1, name, said, unit, 1, offset, np.nan)))
    if not found:
        raise Error(f"{file}: expected a column that can be the time, which never falls; found none")
    return min(found)[2]


def likely_matches(raw: RawTable, t: np.ndarray, ours: RunData, time: int) -> Iterator[tuple[float, Match]]:
    """Every column of the file with every one of ours that it may stand for, with a weight."""
    windows = {side: contact_window(ours, side) for side in ("L", "R")}
    for k, (name, said) in enumerate(zip(raw.names, raw.units, strict=True)):
        if k + 1 == time:
            continue
        meant = meanings(name)
        for column in QUANTITIES:
            if column not in ours.data:
                continue
            found = best_unit(raw.numbers[:, k], t, said, ours, column, windows, column in meant)
            if found is None:
                continue
            unit, sign, offset, likeness = found
            named = column in meant
            if likeness >= (NAMED if named else ALONE) and (named or not meant):
                yield likeness + BONUS*named, Match(column, k + 1, name, said, unit, sign, offset, likeness)


def contact_window(ours: RunData, side: str) -> tuple[float, float]:
    """From the start, or from shortly before the first contact of the right flange, to shortly after its end [s]."""
    contact = side + "F"
    begin = ours.first_contact(contact)
    if begin is None:
        return 0.0, float(ours.time[-1])
    later = (ours.time > begin) & (ours.values(f"N_{contact}") <= 0)
    end = float(ours.time[later][0]) if later.any() else float(ours.time[-1])
    spare = 0.2*(end - begin)
    return (0.0 if side == "L" else begin - spare), end + spare


def best_unit(x: np.ndarray, t: np.ndarray, said: str, ours: RunData, column: str, windows: dict[str, tuple[float, float]],
              named: bool) -> tuple[str, int, float, float] | None:
    """Unit, sign, offset and likeness with which a column of the file follows one of ours best."""
    si = ours.data.attrs["units"][column]
    right = column.endswith(("_RF",))
    begin, end = windows["R" if right else "L"]
    shift = start_of_activity(x, t) - start_of_activity(ours.values(column), ours.time) if right else 0.0
    if not np.isfinite(shift):
        return None
    at = np.linspace(begin, end, ROWS)
    r = ours.values(column)
    known = np.isfinite(r)
    if known.sum() < 3:
        return None
    there = np.interp(at, ours.time[known], r[known])
    open_ = np.interp(at, ours.time, np.isnan(r).astype(float)) > 0
    usable = np.isfinite(x)
    if usable.sum() < 3:
        return None
    here = np.interp(at + shift, t[usable], x[usable], left=np.nan, right=np.nan)
    alive = np.isfinite(here) & ~open_
    if alive.sum() < 10 or not np.ptp(here[alive]):
        return None
    here, there = here[alive], there[alive]
    best = None
    for unit, (kind, factor) in UNITS.items():
        if kind != si or unit in ("sec", "Nm", "kNm", "-"):
            continue
        for sign in (1, -1):
            y = sign*factor*here
            offset = 0.0
            if column in ZERO_MAY_DIFFER:
                offset = float(np.median(there - y))
                if abs(offset) <= 0.02*np.sqrt(np.mean(there**2)):
                    offset = 0.0
            size = max(np.sqrt(np.mean((y + offset)**2)), np.sqrt(np.mean(there**2)))
            likeness = 1 - np.sqrt(np.mean((y + offset - there)**2))/size if size > 0 else 0.0
            # A zero of another place is less likely than none, and the unit that the file says likelier than another.
            likeness -= 0.05*(offset != 0) + 0.02*(bool(said) and unit != said) + 0.01*(unit in ("in", "lbf", "um", "g", "in/s"))
            if best is None or likeness > best[3]:
                best = unit, sign, offset, float(likeness)
    return best


def start_of_activity(x: np.ndarray, t: np.ndarray) -> float:
    """The first time [s] at which a contact's column is neither zero nor empty."""
    active = np.flatnonzero(np.nan_to_num(x) != 0)
    return float(t[active[0]]) if active.size else np.nan


