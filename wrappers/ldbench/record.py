"""One run as its column file tells it: the columns and what the header says.

A file without our header, another code's submission, has the columns only.
"""
from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import f90nml
import numpy as np
import pandas as pd

from ._core import Error, complete
from .case import variables
from .columns import read_columns
from .pools import processes
from .run import count_name, event_kinds
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
    if facts["settings"] and "ending" not in facts and "time" in table.columns:
        raise Error(f"{path}: expected the group &results after the last row, found none: the run is not finished, or the "
                    "file is cut")
    return Record(**{"file": path, "columns": table, "name": path.stem} | facts)


def read_records(files: Sequence[Path], jobs: int | None = None) -> list[Record]:
    """Column files, read by several processes, the longest first."""
    order = sorted(range(len(files)), key=lambda k: -files[k].stat().st_size)
    with processes(jobs, len(files)) as pool:
        found = dict(zip(order, pool.map(read_record, [files[k] for k in order]), strict=True))
    return [found[k] for k in range(len(files))]


TAIL = 2**17        # where the results at the end of a file are looked for [bytes]; longer ones are read whole


def read_header(path: Path) -> dict[str, Any]:
    """Keyword arguments of Record from the comment lines before and after the numbers; `settings` is empty without ours."""
    try:
        with open(path, "rb") as file:
            head = _comments(file)
            end = file.seek(0, os.SEEK_END)
            size = min(TAIL, end)
            while True:
                file.seek(end - size)
                lines = file.read(size).split(b"\n")
                whole = size == end or any(line and not line.startswith(b"#") for line in lines[1:])
                if whole:
                    break
                size = min(2*size, end)
    except (OSError, ValueError):           # a name with a zero byte
        raise Error(f"{path}: cannot be opened for reading") from None
    tail: list[str] = []
    for line in reversed(lines):
        if line.startswith(b"#"):
            tail.append(_plain(line))
        elif line.strip():
            break
    try:
        return parse_header(head, tail[::-1])
    except Error as error:
        raise Error(f"{path}, header: {error}") from None


def _comments(file: BinaryIO) -> list[str]:
    """The comment lines at the beginning of a file, before or after the line of names."""
    lines = []
    for k, line in enumerate(file):
        if line.removeprefix(b"\xef\xbb\xbf").startswith(b"#"):
            lines.append(_plain(line.removeprefix(b"\xef\xbb\xbf")))
        elif k > 0:
            break
    return lines


def _plain(line: bytes) -> str:
    return line.decode(errors="replace")[1:].removeprefix(" ").rstrip()


def parse_header(head: Sequence[str], tail: Sequence[str]) -> dict[str, Any]:
    """Keyword arguments of Record from the comment lines of a file of ours before and after the rows."""
    facts: dict[str, Any] = {"settings": {}, "profiles": {}}
    if not (head and (found := re.match(r"ldbench (\S+)$", head[0]))):
        return facts
    facts["version"] = found[1]
    for line in head:
        if found := re.match(r"case ([^:]*): (.*)", line):
            facts["name"], facts["title"] = found[1], found[2]
        elif found := re.match(r"((?:left |right )?(?:wheel|rail)) profile: (.*?)(, RECONSTRUCTION.*)?$", line):
            facts["profiles"][found[1]] = found[2]
            facts["reconstruction"] = facts.get("reconstruction", False) or bool(found[3])
    groups = read_groups(head)
    setup = groups.pop("setup", {})
    facts["settings"] = {group: {known_name(group, name): setting_value(group, name, value) for name, value in values.items()}
                         for group, values in groups.items()}
    facts["clearance"], facts["clearance_right"] = number(setup, "clearance_left"), number(setup, "clearance_right")
    facts["axle_height"], facts["axle_roll"] = number(setup, "axle_height"), number(setup, "axle_roll")
    facts["table_points"] = str(setup.get("table_points", ""))
    facts["table_errors"] = {place.replace("_", " "): (number(setup, name, 0), number(setup, name, 1))
                             for name in setup if (place := name.removeprefix("table_error_")) != name
                             and not place.endswith("_right")}
    results = read_groups(tail).get("results")
    return facts | (read_results(results) if results else {})


def read_results(results: Mapping[str, Any]) -> dict[str, Any]:
    """Keyword arguments of Record from the group `&results`."""
    def pairs(value: str, time: str, names: Sequence[str]) -> dict[str, tuple[float, float]]:
        found = {name: (number(results, value + name.lower()), number(results, time + name.lower())) for name in names
                 if value + name.lower() in results}
        return {name: pair for name, pair in found.items() if pair[0] or "farthest" in value}

    listed = results.get("event", [])
    events = listed if isinstance(listed, list) else [listed]
    return {
        "peaks": pairs("peak_n_", "t_peak_", CONTACTS), "blows": pairs("peak_p_", "t_peak_p_", CONTACTS),
        "extremes": pairs("farthest_", "t_farthest_", ("left", "right", "up")),
        "drift": number(results, "drift"), "step": number(results, "step"),
        "steps": int(number(results, "steps")), "missed": int(number(results, "missed")), "ending": str(results.get("end", "")),
        "counts": {kind: int(number(results, count_name(kind))) for kind in event_kinds() if count_name(kind) in results},
        "events": tuple(Event(number(event, "t"), str(event.get("kind", "")),
                              number(event, "force") if "force" in event else np.nan,
                              {c: number(event, f"p_{c.lower()}") for c in CONTACTS if f"p_{c.lower()}" in event},
                              number(event, "loss") if "loss" in event else 0.0)
                        for event in events if isinstance(event, Mapping))}


def read_groups(lines: Iterable[str]) -> dict[str, dict[str, Any]]:
    """The namelist groups among comment lines; names in small letters."""
    kept: list[str] = []
    inside = False
    for line in lines:
        inside = inside or line.startswith("&")
        if inside:
            kept.append(line)
        inside = inside and line.strip() != "/"
    try:
        found = f90nml.reads("\n".join(kept) + "\n")
        return {group: dict(values) for group, values in found.items() if isinstance(values, Mapping)}
    except Exception as error:      # whatever f90nml finds wrong with a text
        raise Error(f"expected namelist groups, found {type(error).__name__}: {error}") from None


def number(group: Mapping[str, Any], name: str, k: int | None = None) -> float:
    """A finite number of a group, or the k-th of several."""
    value = group.get(name)
    if k is not None and isinstance(value, list) and len(value) > k:
        value = value[k]
    if not isinstance(value, int | float) or isinstance(value, bool) or not np.isfinite(value):
        raise Error(f"expected a number for {name}, found {value!r}")
    return float(value)


@cache
def kinds() -> dict[tuple[str, str], tuple[str, str]]:
    """Names and kinds of the namelist's variables, by group and name in small letters."""
    return {(variable.group, variable.name.lower()): (variable.name, variable.kind) for variable in variables()}


def known_name(group: str, name: str) -> str:
    return kinds().get((group, name), (name, ""))[0]


def setting_value(group: str, name: str, value: Any) -> Setting:
    """A text or a number; of a variable that this version does not know, whichever it is."""
    kind = kinds().get((group, name), ("", ""))[1]
    if kind == "text":
        return str(value or "")
    return number({name: value}, name) if kind else value


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
