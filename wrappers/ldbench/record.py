"""One run as its column file tells it: the columns and what the header says.

A file without our header, another code's submission, has the columns only.
"""
from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ._core import Error, complete
from .case import variables
from .columns import read_columns
from .pools import processes
from .table import CONTACT_NAMES, CONTACTS

PAIRS = {"aw": "actual profiles", "sw": "simplified profiles"}

Setting = float | str


@dataclass(frozen=True)
class Event:
    time: float                  # [s]
    kind: str                    # 'left flange contact', 'derailment', ...
    force: float = np.nan        # lateral force then [N], nan in a run without one
    impulses: Mapping[str, float] = field(default_factory=dict)     # of an impact, by contact [N s]
    loss: float = 0.0            # energy lost in it [J]


@dataclass(frozen=True)
class Record:
    """A run: columns in SI units, and the facts of the header."""
    file: Path
    columns: pd.DataFrame
    name: str
    title: str = ""
    version: str = ""
    settings: Mapping[str, Mapping[str, Setting]] = field(default_factory=dict)
    profiles: Mapping[str, str] = field(default_factory=dict)   # 'wheel', 'rail', or 'left wheel' ...: file and checksum
    reconstruction: bool = False          # whether the profiles are ours, not the organisers'
    clearance: float = np.nan             # rigid-axle flange clearance to the left [m]
    clearance_right: float = np.nan       # to the right [m]
    table_points: str = ""                # of the contact table, by zone: '111 x 100 x 15 + 200 x 100 x 18'
    table_errors: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # rms, largest by place, of max(|F|, 5 kN)
    axle_height: float = np.nan           # at equilibrium, above top of rail: Z is measured from it [m]
    axle_roll: float = 0.0                # then: roll is measured from it [rad]
    events: tuple[Event, ...] = ()        # the first few of each kind
    counts: Mapping[str, int] = field(default_factory=dict)     # of all events, by kind
    peaks: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # per contact: N [N], time [s]
    blows: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # of impacts: impulse [N s], time [s]
    extremes: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # 'left', 'right' (Y), 'up' (Z) [m], time [s]
    drift: float = np.nan                 # largest |energy drift| over all steps [J]
    steps: int = 0
    missed: int = 0                       # steps that change the energy by more than energy_tolerance, cut as often as allowed
    step: float = np.nan                  # [s]
    ending: str = ""

    @cached_property
    def time(self) -> np.ndarray:
        time = self.values("time")
        if not (np.isfinite(time).all() and np.all(np.diff(time) >= 0)):
            raise Error(f"{self.file}: expected rows with ascending times, found others")
        return time

    def values(self, column: str) -> np.ndarray:
        if column not in self.columns:
            raise Error(f"{self.file}: expected a column {column}, found none")
        return self.columns[column].to_numpy()

    @property
    def exercise(self) -> int | None:
        found = re.match(r"ex(\d)_", self.name)
        return int(found[1]) if found else None

    @property
    def formulation(self) -> str:
        """How contact is treated: 'elastic', 'bilateral' or 'unilateral'; '' in another code's file."""
        return str(self.setting("contact", "formulation") or ("elastic" if self.settings else ""))

    @property
    def heading(self) -> str:
        """'Exercise 1, actual profiles', or the case's name."""
        pair = PAIRS.get(self.name.partition("_")[2])
        return f"Exercise {self.exercise}, {pair}" if self.exercise and pair else self.name

    def setting(self, group: str, name: str) -> Any:
        """A number or a word of a namelist; None where the file does not say."""
        return self.settings.get(group, {}).get(name)

    def number(self, group: str, name: str) -> float:
        """A number of a namelist."""
        value = self.setting(group, name)
        if isinstance(value, str | None):
            raise Error(f"{self.file}: expected a number for &{group} {name} in the header, found {value or 'none'}")
        return float(value)

    def first(self, kind: str) -> Event | None:
        return next((event for event in self.events if event.kind == kind), None)

    def first_contact(self, contact: str) -> float | None:
        """Time [s] at which a contact first closes: of the event, or of the first row with a force."""
        event = self.first(CONTACT_NAMES[contact] + " contact")
        if event:
            return event.time
        if f"N_{contact}" not in self.columns:
            return None
        closed = np.flatnonzero(self.values(f"N_{contact}") > 0)
        return float(self.time[closed[0]]) if closed.size else None

    def passages(self) -> list[float]:
        """Times [s] of the passages of the centre after the left flange's first contact, of those that are listed."""
        contact = self.first_contact("LF")
        return [e.time for e in self.events if e.kind == "centre passage" and contact and e.time > contact]


def read_record(path: str | PathLike[str], columns: str | PathLike[str] | None = None) -> Record:
    """Read a column file.  `columns` is the map of another code's names, see read_columns: it is for a file without our
    header, which is named after itself."""
    path = Path(path)
    facts = read_header(path)
    table = read_columns(path, None if facts["settings"] else columns)
    return Record(**{"file": path, "columns": table, "name": path.stem} | facts)


def read_records(files: Sequence[Path], jobs: int | None = None) -> list[Record]:
    """Column files, read by several processes, the longest first."""
    order = sorted(range(len(files)), key=lambda k: -files[k].stat().st_size)
    with processes(jobs, len(files)) as pool:
        found = dict(zip(order, pool.map(read_record, [files[k] for k in order]), strict=True))
    return [found[k] for k in range(len(files))]


def read_header(path: Path) -> dict[str, Any]:
    """Keyword arguments of Record from the comment lines before the numbers; `settings` is empty without our header."""
    lines = []
    try:
        with open(path, encoding="utf-8-sig", errors="replace") as file:
            for k, line in enumerate(file):
                if line.startswith("#"):
                    lines.append(line[1:].removeprefix(" ").rstrip())
                elif k > 0:
                    break
    except (OSError, ValueError):           # a name with a zero byte
        raise Error(f"{path}: cannot be opened for reading") from None
    try:
        return parse_header(lines)
    except Error as error:
        raise Error(f"{path}, header: {error}") from None


def number(word: str) -> float:
    """A number of the header, which is finite."""
    with suppress(ValueError):
        if np.isfinite(x := float(word)):
            return x
    raise Error(f"expected a number, found '{word}'")


def parse_header(lines: Iterable[str]) -> dict[str, Any]:
    """Keyword arguments of Record from the header's lines."""
    facts: dict[str, Any] = {}
    settings: dict[str, dict[str, Setting]] = {}
    profiles: dict[str, str] = {}
    events: list[Event] = []
    group = ""
    for line in lines:
        if line.startswith("&"):
            group = line[1:].strip()
        elif found := re.match(r"  t = (\S+) s  ([^,]+)(?:, lateral force (\S+) kN)?"
                               r"(?:, impulses \[N s\]([^,]*), energy lost \[J\] (\S+))?", line):
            impulses = {c: number(x) for c, x in re.findall(r"(\w\w) (\S+)", found[4] or "")}
            force = 1e3*number(found[3]) if found[3] else np.nan
            events.append(Event(number(found[1]), found[2], force, impulses, number(found[5] or "0")))
        elif found := re.match(r"  (\w+) = (.*?)(?:  ! .*)?$", line):
            settings.setdefault(group, {})[found[1]] = setting_value(group, found[1], found[2])
        elif line.startswith("  in all: "):
            facts["counts"] = {kind: int(number(n)) for n, kind in re.findall(r"(\d+) ([^,]+)", line)}
        elif found := re.match(r"ldbench (\S+)$", line):
            facts["version"] = found[1]
        elif found := re.match(r"case ([^:]*): (.*)", line):
            facts["name"], facts["title"] = found[1], found[2]
        elif found := re.match(r"((?:left |right )?(?:wheel|rail)) profile: (.*?)(, RECONSTRUCTION.*)?$", line):
            profiles[found[1]] = found[2]
            facts["reconstruction"] = facts.get("reconstruction", False) or bool(found[3])
        elif found := re.match(r"rigid-axle clearance \[mm\]: 2 x (\S+)", line):
            facts["clearance"] = facts["clearance_right"] = 1e-3*number(found[1])
        elif found := re.match(r"rigid-axle clearance \[mm\]: left (\S+), right (\S+)", line):
            facts["clearance"], facts["clearance_right"] = 1e-3*number(found[1]), 1e-3*number(found[2])
        elif found := re.match(r"(?:\w+ )?contact table: model \w+, (.*) points$", line):
            facts.setdefault("table_points", found[1])
        elif line.startswith("its error, rms (largest)"):
            facts.setdefault("table_errors", {place: (number(rms), number(largest)) for place, rms, largest in
                                              re.findall(r"(\w+(?: \w+)?) (\S+) \((\S+)\)", line.partition(":")[2])})
        elif found := re.match(r"roll at equilibrium \[rad\]: (\S+)", line):
            facts["axle_roll"] = number(found[1])
        elif found := re.match(r"axle height at equilibrium \[m\]: (\S+)", line):
            facts["axle_height"] = number(found[1])
        elif line.startswith("peak normal forces"):
            facts["peaks"] = {contact: (1e3*number(N), number(t)) for contact, N, t in
                              re.findall(r"(\w\w) (\S+) at (\S+) s", line)}
        elif line.startswith("farthest"):
            facts["extremes"] = {way: (number(x + "e-3"), number(t)) for way, x, t in
                                 re.findall(r"(left|right|up) (\S+) at (\S+) s", line)}
        elif line.startswith("largest impulses"):
            facts["blows"] = {contact: (number(P), number(t)) for contact, P, t in
                              re.findall(r"(\w\w) (\S+) at (\S+) s", line)}
        elif found := re.match(r"energy drift, largest \[J\]: +([^ ,]+)", line):
            facts["drift"] = number(found[1])
        elif found := re.match(r"steps: (\d+) of at most (\S+) s(?:, \d+ cut, (\d+) over energy_tolerance)?", line):
            facts["steps"], facts["step"], facts["missed"] = int(number(found[1])), number(found[2]), int(found[3] or 0)
        elif found := re.match(r"ended at t = \S+ s: (.*)", line):
            facts["ending"] = found[1]
    facts.update(settings=settings, profiles=profiles, events=tuple(events))
    return facts


@cache
def kinds() -> dict[tuple[str, str], str]:
    """Kinds of the namelist's variables, by group and name."""
    return {(variable.group, variable.name): variable.kind for variable in variables()}


def setting_value(group: str, name: str, word: str) -> Setting:
    """A text without its quotes, or a number; of a variable that this version does not know, whichever it is."""
    word = word.strip()
    kind = kinds().get((group, name), "")
    if kind == "text" or word.startswith("'"):
        return word.removeprefix("'").removesuffix("'").replace("''", "'")
    if kind:
        return number(word)
    with suppress(ValueError):
        return float(word)
    return word


def energy_reference(record: Record) -> float:
    """What the energy drift is measured by [J]: the kinetic energy of lateral, vertical and roll
    motion at the start, or the work of the lateral force where the wheelset starts at rest."""
    kinetic = sum(record.values(column)[0] for column in ("KE_lat", "KE_vert", "KE_roll"))
    return float(kinetic) or float(np.abs(record.values("W_ext")).max())


def summary_row(record: Record) -> dict[str, Any]:
    """The run in one row, SI units; None for what did not happen."""
    passages = record.passages()
    derailment = record.first("derailment")
    returned = "return" in record.ending
    reference = energy_reference(record)
    row: dict[str, Any] = {
        "case": record.name,
        "exercise": record.exercise,
        "profiles": PAIRS.get(record.name.partition("_")[2], ""),
        "model": record.setting("contact", "model") if record.formulation == "elastic" else record.formulation,
        "dt": record.step,
        "steps": record.steps,
        "ending": record.ending,
        "t_end": float(record.time[-1]),
        "t_first_LF": record.first_contact("LF"),
        "t_first_RF": record.first_contact("RF"),
        "t_first_centre": passages[0] if passages else None,
        "t_return": passages[-1] if passages and returned else None,
        "t_derailment": derailment.time if derailment else None,
        "F_derailment": derailment.force if derailment and np.isfinite(derailment.force) else None,
    }
    for column in ("Y", "Z", "roll"):
        row[f"{column}_min"] = float(record.values(column).min())
        row[f"{column}_max"] = float(record.values(column).max())
    # Between the rows, too, where the file says it.
    for way, name in ("left", "Y_max"), ("right", "Y_min"), ("up", "Z_max"):
        row[name] = record.extremes.get(way, (row[name], None))[0]
    for contact in CONTACTS:
        row[f"N_max_{contact}"], row[f"t_N_max_{contact}"] = record.peaks.get(contact, (None, None))
    for side in ("left", "right"):
        row[f"{side}_flange_contacts"] = record.counts.get(f"{side} flange contact")
        row[f"{side}_lift_offs"] = record.counts.get(f"{side} wheel lift-off")
    return row | {"E_reference": reference, "E_drift_max": record.drift,
                  "E_drift_relative": record.drift/(reference or np.nan)}


def write_frame(frame: pd.DataFrame, target: Path) -> None:
    """A table as CSV."""
    with complete(target) as scratch:
        frame.to_csv(scratch, index=False)
