"""The header of a column file: the case, the profiles, the setup and the results in its comments.

The core writes them as namelist groups in comment lines, before and after the rows; a run in memory is told by the same
lines. A file without these lines, another code's, has empty comments.
"""
from __future__ import annotations

import itertools
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .._core.errors import Error, UnknownName, unreadable
from ..case import Value, find_variable, variables
from ..constants import CONTACTS
from .events import Event, count_name, event_kinds

TAIL = 2**17        # where the results at the end of a file are looked for [bytes]: those with the most events take half of it
MARK = b"\xef\xbb\xbf"      # of the order of bytes, with which spreadsheets begin a file
SETUP = "clearance_left", "clearance_right", "axle_height", "axle_roll"
ALWAYS = "t", "rows", "drift", "kinetic_energy", "steps", "step"      # numbers of every run; a damaged header may lack them
# Answers that only some runs have: what did not happen is NaN, or '' for a text.
ABSENT: dict[str, Any] = {
    **dict.fromkeys((
        "F_limit_left", "F_limit_right", "t_first_centre", "t_return", "t_unloaded", "F_unloaded", "t_derailment", "F_derailment",
        "pmax", "t_pmax", "pmax_y", "pmax_z", "drift_reference", "drift_relative",
        "frequency_1", "frequency_2", "frequency_3"), np.nan),
    **{f"{name}_{contact}": np.nan for contact in CONTACTS
       for name in ("t_first", "first_peak_N", "t_first_peak", "first_duration", "first_impulse")},
    **{f"{name}_{contact}": np.nan for contact in ("LF", "RF") for name in ("turn_impulse", "pmax", "patch", "approach")},
    **{f"{name}_{contact}": 0.0 for contact in CONTACTS for name in ("peak_P", "t_peak_P")},
    "rest_Y": 0.0, "rest_Z": 0.0, "rest_roll": 0.0, "lost": 0.0, "pmax_contact": "", "changes": ""}


@dataclass(frozen=True)
class Header:
    """What made a run; empty for another code's file."""

    version: str = ""                       # of ldbench
    name: str = ""                          # of the case
    title: str = ""
    profiles: Mapping[str, str] = field(default_factory=dict)   # 'wheel', 'rail', or 'left wheel' ...: file and checksum
    reconstruction: bool = False            # whether a profile says that it is not the organisers' file
    table_points: str = ""                  # of the contact table, by zone: '111 x 100 x 15 + 200 x 100 x 18'
    table_errors: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # rms, largest by place, of max(|F|, 5 kN)


@dataclass(frozen=True)
class Comments:
    """What the comments of a column file say; empty for another code's file. Runs have it as their `header`, `case`, `results`,
    `events` and `ending`."""

    header: Header = field(default_factory=Header)
    settings: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)   # the groups of the namelist
    results: Mapping[str, Any] = field(default_factory=dict)    # the groups &setup and &results, SI units
    events: tuple[Event, ...] = ()          # the first few of each kind
    ending: str = ""                        # why the run ended, which the core writes after the last row


def read_comments(path: Path) -> Comments:
    """The comments of a column file: the lines at its beginning, before or after the line of names, and those at its end."""
    head = []
    try:
        with open(path, "rb") as file:
            for k, line in enumerate(file):
                if line.removeprefix(MARK).startswith(b"#"):
                    head.append(_plain(line.removeprefix(MARK)))
                elif k > 0:
                    break
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
            last = file.read().split(b"\n")
    except (OSError, ValueError):           # ValueError: a name with a zero byte
        raise unreadable(path) from None
    tail = itertools.takewhile(lambda line: line.startswith(b"#"), filter(bytes.strip, reversed(last)))
    try:
        return parse_comments(head, [*map(_plain, tail)][::-1])
    except Error as error:
        raise error.within(f"{path}, header") from None


def _plain(line: bytes) -> str:
    return line.decode(errors="replace")[1:].removeprefix(" ").rstrip()


def parse_comments(head: Sequence[str], tail: Sequence[str]) -> Comments:
    """Parse the comment lines before and after the rows. All is empty if ldbench has not written them."""
    if not (head and (found := re.match(r"ldbench (\S+)$", head[0]))):
        return Comments()
    version, name, title = found[1], "", ""
    profiles: dict[str, str] = {}
    reconstruction = False
    for line in head:
        if found := re.match(r"case ([^:]*): (.*)", line):
            name, title = found[1], found[2]
        elif found := re.match(r"((?:left |right )?(?:wheel|rail)) profile: (.*?)(, RECONSTRUCTION.*)?$", line):
            profiles[found[1]] = found[2]
            reconstruction = reconstruction or bool(found[3])
    groups = read_groups(head)
    setup = groups.pop("setup", {})
    settings = {group: dict(setting(group, key, value) for key, value in values.items()) for group, values in groups.items()}
    results: dict[str, Any] = {key: number(setup, key) for key in SETUP}
    results |= {key: number(setup, key) for key in setup if key in ABSENT}
    frequencies = setup.get("eigenfrequencies", [])
    for k, frequency in enumerate(frequencies if isinstance(frequencies, list) else [frequencies], 1):
        results[f"frequency_{k}"] = number({"eigenfrequencies": frequency}, "eigenfrequencies")
    events: tuple[Event, ...] = ()
    ending = ""
    errors: dict[str, tuple[float, float]] = {}
    if told := read_groups(tail).get("results"):
        for key in [key for key in told if key.startswith("table_error_")]:
            errors[key.removeprefix("table_error_").replace("_", " ")] = number(told, key, 0), number(told, key, 1)
            del told[key]
        events, ending = tuple(map(read_event, told.pop("event", []))), str(told.pop("end", ""))
        results |= {count_name(kind): 0 for kind in event_kinds()}
        results |= dict.fromkeys(ALWAYS, np.nan)
        results |= {key: value if isinstance(value, str) and key not in ALWAYS else int(value) if isinstance(value, int)
                    else number(told, key) for key, value in told.items()}
        results["derailed"] = number(results, "n_derailment") > 0
    results |= {key: value for key, value in ABSENT.items() if key not in results}
    header = Header(version, name, title, profiles, reconstruction, str(setup.get("table_points", "")), errors)
    return Comments(header, settings, results, events, ending)


def read_event(event: Mapping[str, Any]) -> Event:
    """An event from its part of the group &results."""
    told = {name: number(event, name) for name in ("force", "angle", "loss") if name in event}
    impulses = {c: number(event, f"p_{c.lower()}") for c in CONTACTS if f"p_{c.lower()}" in event}
    return Event(number(event, "t"), str(event.get("kind", "")), impulses=impulses, cause=str(event.get("cause", "")), **told)


WORD = r"[^\s,'\"!=]+"
VALUE = rf"'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\"|{WORD}(?: *, *(?!event\(|\w+ *=){WORD})*"      # a text, or one or more numbers
ITEM = re.compile(rf" *(?:event\((\d+)\)%)?([A-Za-z]\w*) *= *({VALUE}) *(?:, *(?=\w)|(?:!.*)?$)", re.IGNORECASE)


def read_groups(lines: Iterable[str]) -> dict[str, dict[str, Any]]:
    """The namelist groups among comment lines; names as they are written there. Error where a line of a group is none.

    Other programs and editors may have written them: blanks and the letter of an exponent do not matter. A word that is no
    number stays a text, which those refuse that need a number.
    """
    groups: dict[str, dict[str, Any]] = {}
    group: dict[str, Any] | None = None
    for line in lines:
        if line.startswith("&"):
            group = groups.setdefault(line[1:].strip().lower(), {})
        elif line.strip() == "/":
            group = None
        elif group is not None:
            read_line(line, group)
    for group in groups.values():
        if "event" in group:
            group["event"] = [event for _, event in sorted(group["event"].items())]
    return groups


def read_line(line: str, group: dict[str, Any]) -> None:
    """Add the items of a line to a group, those of events by their number."""
    at, end = 0, len(line.rstrip())
    while at < end and not line[at:].lstrip().startswith("!"):
        if not (found := ITEM.match(line, at)):
            raise Error(expected="name = value", found=f"{line.strip()!r}")
        at = found.end()
        event, name, word = found.groups()
        if event:
            group.setdefault("event", {}).setdefault(int(event), {})[name.lower()] = plain_value(word)
        else:
            group[name] = plain_value(word)


def plain_value(word: str) -> Any:
    """A text, a number or a list of numbers; what is no number stays a text."""
    if word[0] in "'\"":
        return word[1:-1].replace(2*word[0], word[0])
    numbers = [plain_number(x.strip()) for x in word.split(",")]
    return numbers if len(numbers) > 1 else numbers[0]


def plain_number(word: str) -> int | float | str:
    """A whole or real number, of which Fortran may write the exponent with D; another word stays as it is."""
    try:
        return int(word) if word.lstrip("+-").isdecimal() else float(re.sub("[dD]", "e", word))
    except ValueError:
        return word


def number(group: Mapping[str, Any], name: str, k: int | None = None) -> float:
    """A finite number of a group, or the k-th of several."""
    value = group.get(name)
    if k is not None and isinstance(value, list) and len(value) > k:
        value = value[k]
    if not isinstance(value, int | float) or isinstance(value, bool) or not np.isfinite(value):
        raise Error(expected=f"a number for {name}", found=f"{value!r}")
    return float(value)


def setting(group: str, name: str, value: Any) -> tuple[str, Value]:
    """A variable as the namelist calls it, and its text or number; one that this version does not know stays as it is."""
    try:
        variable = variables()[find_variable(f"{group}_{name}")]
    except UnknownName:
        return name, value
    if variable.kind == "text":
        return variable.name, str(value or "")
    found = number({name: value}, name)
    return variable.name, int(found) if variable.kind == "integer" and found == int(found) else found
