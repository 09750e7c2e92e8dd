"""Runs as one HTML file that holds everything: data, style and script; it asks the network for nothing.

Text of files goes into the page as JSON and is put on the screen as text. The page's policy lets run only the script
whose hash it carries, so nothing from a file is ever run.
"""
from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .. import style
from .._core import Error, complete, version
from ..case import Case
from ..record import Record
from ..run import Run, count_name, event_kinds, output_path
from ..table import CONTACT_NAMES, CONTACTS
from .labels import GROUPS, label
from .pack import CELLS, pack
from .shapes import Placing, Settings, Shape, Side, checksum, shape

FOLDER = Path(__file__).resolve().parent
SCRIPTS = ("decode.js", "series.js", "scene.js", "chart.js", "parts.js", "keys.js", "panel.js", "values.js",
           "page.js")
EVERY_ROW = "Y", "Z", "roll", "N_LT", "N_LF", "N_RT", "N_RF"
PEAKS = "N_LT", "N_LF", "N_RT", "N_RF"


@dataclass(frozen=True)
class Page:
    """A finished page; a notebook shows it in a frame of its own."""
    html: str = field(repr=False)
    height: int = 900           # in a notebook [px]

    def write(self, path: str | Path) -> Path:
        """Write the page; returns its path."""
        path = Path(path)
        with complete(path) as scratch:
            scratch.write_text(self.html, encoding="utf-8", errors="replace")
        return path

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts" title="ldbench" '
                f'style="width: 100%; height: {self.height}px; border: 0"></iframe>')


@dataclass(frozen=True)
class Cell:
    """Of the summary table; `time` is the moment that its number is of."""
    text: str
    run: str = ""
    time: float | None = None
    beside: tuple[str, ...] = ()    # runs to show with it


def make_page(records: Sequence[Record], title: str = "", settings: Settings | None = None, shown: int | None = None,
              summary: Sequence[tuple[str, Sequence[Cell]]] = (), cells: Mapping[str, int] | None = None) -> Page:
    """The page of some runs.

    settings: what places wheel and rail of runs without our header; by default those of the first run with one, else
    the benchmark's actual profiles. shown: how many runs are shown at first; the others are one click away.
    summary: lines of a table, each with its name and cells. cells: of some runs, how many numbers are kept whole.
    """
    assumed = assumed_placing(records, settings)
    shapes: list[Shape] = []
    runs: list[dict[str, Any]] = []
    bodies: list[str] = []
    for record in records:
        entry, body = run_entry(record, assumed, shapes, (cells or {}).get(record.name, CELLS))
        entry["shown"] = shown is None or len(runs) < shown
        runs.append(entry)
        bodies.append(base64.b64encode(body).decode())
    title = title or ", ".join(record.heading for record in records)
    facts = {
        "title": title, "version": version(), "groups": GROUPS, "contacts": CONTACT_NAMES,
        "shapes": [shape_entry(one) for one in shapes], "runs": runs,
        "summary": [{"words": words, "cells": [cell_entry(cell) for cell in row]} for words, row in summary],
    }
    return Page(fill(title, facts, bodies))


def assumed_placing(records: Sequence[Record], settings: Settings | None) -> Placing:
    """What places wheel and rail of runs without our header: the settings given, those of the first run with a header,
    or the benchmark's."""
    if settings:
        return Placing(settings)
    first = next((record for record in records if record.settings), None)
    return own_placing(first) if first else Placing(case_settings(Case.exercise(1, "aw")))


def own_placing(record: Record) -> Placing:
    return Placing(record.settings, record.axle_height, record.axle_roll)


def case_settings(case: Case) -> Settings:
    """Of a Case, as a header has them; profiles by the paths where they were found."""
    groups = {group: dict(values) for group, values in case.namelist().items()}
    groups["profiles"].update(case.profile_files())
    return groups


def run_record(run: Run) -> Record:
    """A finished run as its column file would tell it."""
    from ..record import Event

    case, summary = run.case, run.summary
    columns = run.columns
    loaded = bool(case.lateral_force or case.lateral_ramp)
    paths = case.profile_files()
    files = {}
    for which in ("wheel", "rail"):
        left, right = paths[f"{which}_profile"], paths.get(f"{which}_profile_right", "")
        if right in ("", left):
            files[which] = Path(left)
        else:
            files |= {f"left {which}": Path(left), f"right {which}": Path(right)}
    return Record(
        file=Path(output_path(case)), columns=columns, name=str(case.case_name), title=str(case.title),
        version=version(), settings=case_settings(case),
        profiles={which: f"{file.name}, CRC-32 {checksum(file)}" for which, file in files.items()},
        reconstruction=any(b"reconstruction" in file.read_bytes().lower() for file in files.values()),
        clearance=summary["clearance"], clearance_right=summary["clearance_right"],
        axle_height=summary["equilibrium"], axle_roll=summary["equilibrium_roll"], drift=summary["drift"],
        steps=summary["steps"], step=summary["step"], counts={kind: summary[count_name(kind)] for kind in event_kinds()},
        events=tuple(Event(e.t, e.kind, e.force if loaded else np.nan) for e in run.events),
        peaks={c: (summary[f"peak_N_{c}"], summary[f"t_peak_{c}"]) for c in CONTACTS},
        blows={c: (summary[f"peak_P_{c}"], summary[f"t_peak_P_{c}"]) for c in CONTACTS if summary[f"peak_P_{c}"]},
        ending=summary["end"])


def run_entry(record: Record, assumed: Placing, shapes: list[Shape], cells: int) -> tuple[dict[str, Any], bytes]:
    """What the page is told of a run, and its columns; its outlines are added to `shapes` unless they are there."""
    time, columns = checked(record)
    own = bool(record.settings)
    outline, remark = shape(record, own_placing(record) if own else assumed)
    notes = [remark] if remark else []
    if not own and outline:
        names = " and ".join(Path(str(assumed.settings["profiles"][f"{which}_profile"])).name for which in ("wheel", "rail"))
        notes.append(f"the file does not name its profiles: drawn are {names}")
    if record.reconstruction:
        notes.append("profiles are reconstructions, not the organisers' files")
    units = record.columns.attrs.get("units", {})
    packed = pack(time, columns, EVERY_ROW, [event.time for event in record.events], PEAKS, cells)
    labels = {name: label(name, units.get(name, "")) for name in columns}
    entry = {
        "name": record.name, "heading": record.heading, "title": record.title, "file": record.file.name,
        "profiles": [f"{which}: {text}" for which, text in record.profiles.items()],
        "model": str(record.setting("contact", "model") or ""), "ending": record.ending, "notes": notes,
        "columns": [{"name": name, "words": known.words, "unit": known.unit, "scale": known.scale,
                     "group": known.group, "si": units.get(name, "")} for name, known in labels.items()],
        "events": events(record), "index": packed.index,
        "shape": place(outline, shapes), "clearance": number(record.clearance),
    }
    return entry, packed.body


def checked(record: Record) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time and the other columns; the times ascend."""
    if "time" not in record.columns:
        raise Error(f"{record.file}: expected a column time (a map of names, --columns, may tell which), "
                    f"found {', '.join(map(str, record.columns))}")
    time = record.time
    if len(time) < 2:
        raise Error(f"{record.file}: expected two or more rows, found one")
    return time, {str(name): record.values(name) for name in record.columns if name != "time"}


def events(record: Record) -> list[dict[str, Any]]:
    """What happened, in order; where the file does not say, first contacts by its forces. Largest forces too."""
    found = [{"t": event.time, "what": event.kind, "force": number(event.force)} for event in record.events]
    if not record.events:
        for contact in ("LF", "RF"):
            t = record.first_contact(contact)
            if t is not None:
                found.append({"t": t, "what": f"{CONTACT_NAMES[contact]} contact, first row", "force": None})
    for contact, (force, t) in peak_forces(record).items():
        found.append({"t": t, "what": f"largest normal force, {CONTACT_NAMES[contact]}", "force": None, "peak": force})
    return sorted(found, key=lambda event: event["t"])


def peak_forces(record: Record) -> dict[str, tuple[float, float]]:
    """Largest normal force [N] and its time [s] of every contact that closes: the header's, or the rows'."""
    found = {}
    for contact in CONTACTS:
        force, t = record.peaks.get(contact, (0.0, np.nan))
        if not record.peaks and f"N_{contact}" in record.columns:
            x = record.values(f"N_{contact}")
            if np.nanmax(x, initial=0.0) > 0:
                k = int(np.nanargmax(x))
                force, t = float(x[k]), float(record.time[k])
        if force > 0 and np.isfinite(t):
            found[contact] = force, t
    return found


def place(outline: Shape | None, shapes: list[Shape]) -> int | None:
    """Number of an outline among `shapes`."""
    if outline is None:
        return None
    for k, other in enumerate(shapes):
        if shape_entry(other) == shape_entry(outline):
            return k
    shapes.append(outline)
    return len(shapes) - 1


def shape_entry(outline: Shape) -> dict[str, Any]:
    """For the page; sides that are mirror images go there once."""
    def side(one: Side) -> dict[str, list[float]]:
        return {name: getattr(one, name).ravel().round(7).tolist() for name in ("wheel", "rail", "flank", "gauge")}

    left, right = side(outline.left), side(outline.right)
    return {"sides": [left] if left == right else [left, right], "axle": outline.axle, "roll": outline.roll}


def cell_entry(cell: Cell) -> dict[str, Any]:
    return {"text": cell.text, "run": cell.run, "t": cell.time, "with": cell.beside}


def number(x: float) -> float | None:
    """For JSON, which has no NaN."""
    return float(x) if np.isfinite(x) else None


# The file ---------------------------------------------------------------------------------

def fill(title: str, facts: Mapping[str, object], bodies: Sequence[str]) -> str:
    """The template with everything in its place."""
    looks = colours() + (FOLDER/"page.css").read_text(encoding="utf-8")
    script = "(() => {\n\"use strict\";\n" + "\n".join(
        (FOLDER/name).read_text(encoding="utf-8") for name in SCRIPTS) + "})();\n"
    policy = (f"default-src 'none'; script-src '{content_hash(script)}'; style-src '{content_hash(looks)}'; "
              "img-src data:; base-uri 'none'; form-action 'none'")
    data = [f'<script type="application/json" id="facts">{as_json(facts)}</script>']
    data += [f'<script type="text/plain" id="run{k}">{body}</script>' for k, body in enumerate(bodies)]
    pieces = {"policy": html.escape(policy, quote=False), "title": html.escape(title), "style": looks,
              "data": "\n".join(data), "script": script}
    template = (FOLDER/"page.html").read_text(encoding="utf-8")
    return re.sub(r"\{\{(\w+)\}\}", lambda found: pieces[found[1]], template)


def colours() -> str:
    """Those of the plots, as variables of the style sheet."""
    named = {contact: line.color for contact, line in style.CONTACT_LINES.items()}
    named |= {f"series{k}": line.color for k, line in enumerate(style.SERIES)}
    return ":root {" + "".join(f" --{name}: {color};" for name, color in named.items()) + " }\n"


def content_hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def as_json(facts: Mapping[str, object]) -> str:
    """JSON that holds no tag, whatever its texts say."""
    text = json.dumps(facts, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for mark in "<>&\u2028\u2029":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return re.sub("[\ud800-\udfff\x00]", "\ufffd", text)
