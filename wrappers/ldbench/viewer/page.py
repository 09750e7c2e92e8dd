"""Runs as one HTML file that holds everything: data, style and script; it asks the network for nothing.

Text of files goes into the page as deflated JSON and is put on the screen as text. The page's policy lets run only the script
whose hash it carries, so nothing from a file is ever run.
"""
from __future__ import annotations

import base64
import hashlib
import html
import json
import re
import zlib
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from .._core.errors import BadType, Error
from .._core.files import complete
from ..case import Case
from ..constants import CONTACT_NAMES, CONTACTS, KN, SIDES
from ..geometry.outlines import Outlines, Side, run_outlines
from ..geometry.pressures import FLANGES, known_patches
from ..pressure import Patch
from ..results.answers import answers, first_flange
from ..results.derived import lateral_over_vertical
from ..results.events import count_name, event_kinds
from ..results.quantities import GROUPS, PAIRS, quantity
from ..results.run_data import RunData, read_data
from .pack import CELLS, CELLS_BESIDE, pack

FOLDER = Path(__file__).resolve().parent/"static"
SCRIPTS = [f"{name}.js" for name in (
    "decode number_text reading series derived parts labels views scene pressure axes chart vector export hover picker panel "
    "values events runs player address keys page").split()]
HEIGHT = 900                # of the frame in a notebook [px]
FLANK = np.radians(20)      # steeper parts of wheel and rail may touch as a flange
NAMED = 4                   # runs of a page without exercises that its title names
LEVELS = 99                 # of a pressure and of half a width, from 0 to the largest


@dataclass(frozen=True)
class Page:
    """A finished page; a notebook shows it in a frame of its own."""
    html: str = field(repr=False)

    def write(self, path: str | Path) -> Path:
        """Write the page; returns its path."""
        path = Path(path)
        with complete(path) as scratch:
            scratch.write_text(self.html, encoding="utf-8", errors="replace")
        return path

    def _repr_html_(self) -> str:
        return (f'<iframe srcdoc="{html.escape(self.html)}" sandbox="allow-scripts allow-downloads" title="ldbench" '
                f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>')


def view(*runs: RunData | str | PathLike[str], title: str = "", case: Case | None = None) -> Page:
    """Runs, or column files, as a page: `ldbench.view(run, "other.txt").write("both.html")`; a notebook shows it.

    The first one is the reference of the differences. case: whose profiles are drawn for files that name none.
    """
    strange = [run for run in runs if not isinstance(run, RunData | str | PathLike)]
    if strange or not runs:
        raise BadType(place="view", expected="runs or column files, each an argument",
                      found=type(strange[0]).__name__ if strange else "none")
    return make_page(distinct([run if isinstance(run, RunData) else read_data(run) for run in runs]), title, case)


def distinct(runs: Sequence[RunData]) -> list[RunData]:
    """Give runs of the same name different names: by contact law or formulation, by file, or by number."""
    choices = [[run.name for run in runs], [f"{run.name} {run.law or run.file.name}" for run in runs],
               [f"{run.name} {run.file.name}" for run in runs], [str(run.file) for run in runs],
               [f"{run.name} ({k})" for k, run in enumerate(runs, 1)]]
    chosen = next(names for names in choices if len(set(names)) == len(names))
    return [run if run.name == name else run.named(name) for run, name in zip(runs, chosen, strict=True)]


def make_page(runs: Sequence[RunData], title: str = "", case: Case | None = None, shown: int | None = None,
              summary: Sequence[Mapping[str, object]] = (), note: str = "", beside: Collection[RunData] = (),
              patches: Sequence[str] = CONTACTS) -> Page:
    """The page of some runs.

    case: whose profiles stand for those of runs without our header, see `assumed_profiles`. shown: how many runs are shown at
    first; the others are one click away. summary: lines of a table, each with its `words` and `cells`, see `results.cell`; note:
    words about them. beside: runs that are there for comparison, with fewer rows. patches: contacts at whose largest forces the
    other runs show pressed patches.
    """
    assumed = assumed_profiles(runs, case)
    shapes: list[dict[str, Any]] = []
    entries: list[dict[str, Any]] = []
    bodies: list[str] = []
    for run in runs:
        entry, body = run_entry(run, assumed, shapes, CELLS_BESIDE if run in beside else CELLS)
        entry["pressure"] = [] if run in beside else pressure_entries(run, patches)
        entry["shown"] = shown is None or len(entries) < shown
        entries.append(entry)
        bodies.append(base64.b64encode(body).decode())
    title = title or title_of(runs)
    facts = {"groups": GROUPS, "contacts": CONTACT_NAMES, "shapes": shapes, "runs": entries, "note": note, "summary": summary}
    return Page(fill(title, facts, bodies, FOLDER/"page.html", [FOLDER/name for name in SCRIPTS]))


def title_of(runs: Sequence[RunData]) -> str:
    """The title of a page: headings of one run or two; of more runs, what exercises and profiles they have, or their names."""
    if len(runs) < 3:
        return "; ".join(run.heading for run in runs)
    exercises, pairs = sorted({run.exercise or 0 for run in runs}), {run.pair for run in runs}
    if 0 in exercises or not pairs.issubset(PAIRS.values()):
        names = ", ".join(run.name for run in runs[:NAMED])
        return f"{len(runs)} runs: {names}" + (f" and {len(runs) - NAMED} more" if len(runs) > NAMED else "")
    *rest, last = map(str, exercises)
    is_row = len(rest) > 1 and exercises[-1] - exercises[0] == len(rest)
    numbers = f"{rest[0]} to {last}" if is_row else f"{', '.join(rest)} and {last}" if rest else last
    profiles = " and ".join(words.removesuffix(" profiles") for words in PAIRS.values() if words in pairs)
    return f"{len(runs)} runs: exercise{'s' if rest else ''} {numbers}, {profiles} profiles"


def assumed_profiles(runs: Sequence[RunData], case: Case | None) -> RunData | Case:
    """Whose profiles are drawn for runs without our header: those of the case given, of the first run with a header, or the
    benchmark's actual ones."""
    return case or next((run for run in runs if run.is_ours), None) or Case.exercise(1, "aw")


def run_entry(run: RunData, assumed: RunData | Case, shapes: list[dict[str, Any]], cells: int) -> tuple[dict[str, Any], bytes]:
    """Collect the data of a run for the page; outlines are added to `shapes` unless they are there already."""
    time, columns = checked(run)
    outlines, remark = run_outlines(run, assumed)
    shape = outline_entry(outlines) if outlines else None
    if shape and shape not in shapes:
        shapes.append(shape)
    notes = [remark] if remark else []
    if not run.is_ours and outlines:
        case = assumed.case if isinstance(assumed, RunData) else assumed
        names = " and ".join(Path(str(name)).name for name in (case.wheel_profile, case.rail_profile))
        notes.append(f"the file does not name its profiles: drawn are {names}")
    if run.header.reconstruction:
        notes.append("profiles are reconstructions, not the organisers' files")
    units = run.data.attrs.get("units", {})
    known = {name: quantity(name, units.get(name, "")) for name in columns}
    answered, events = answers(run), event_entries(run)
    derived = derived_columns(columns)
    index, body = pack(time, columns, [event["t"] for event in events], cells, derived_values(run, derived))
    entry = {
        "name": run.name, "heading": run.heading, "title": run.header.title,
        "task": run.heading if run.exercise else "", "file": run.file.name,
        "profiles": [f"{which}: {text}" for which, text in run.header.profiles.items()],
        "model": run.law, "ending": run.ending, "notes": notes,
        "columns": [{"name": name, "words": one.words, "unit": one.unit, "scale": one.scale, "group": one.group,
                     "si": units.get(name, "")} | belonging(name) for name, one in known.items()],
        "derived": derived,
        "events": events, "unlisted": unlisted(run), "firstFlange": first_flange(answered), "opens": opening(answered),
        "hardest": hardest_entry(answered), "index": index,
        "shape": shapes.index(shape) if shape else None, "clearance": outlines.clearance if outlines else None,
        "namelist": namelist_text(run),
    }
    return entry, body


def belonging(name: str) -> dict[str, str]:
    """The contact and the side, 'L' or 'R', to which a column belongs: N_LF, PE_elastic_L; nothing for others."""
    end = name.rpartition("_")[2]
    return {"contact": end, "side": end[0]} if end in CONTACTS else {"side": end} if end in ("L", "R") else {}


def checked(run: RunData) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time and the other columns; the times ascend."""
    if "time" not in run.data:
        raise Error(file=run.file, expected="a column time (a map of names, --map, may tell which)",
                    found=", ".join(map(str, run.data)))
    time = run.time
    if len(time) < 2:
        raise Error(file=run.file, expected="two or more rows", found="one")
    return time, {str(name): run.values(name) for name in run.data if name != "time"}


def derived_columns(columns: Collection[str]) -> list[dict[str, Any]]:
    """What the page makes of the forces of a run that has these columns: L/V, vertical and lateral force of the rail on each
    wheel, and sums over all contacts. Each is `sign` times the sum of the columns `of`, over the sum of those in `over`, if any."""
    def entry(name: str, words: str, kind: str, contacts: Sequence[str], over: str = "", sign: float = 1.0) -> dict[str, Any]:
        unit, si, scale = ("", "1", 1.0) if over else ("kN", "N", KN)
        return {"name": name, "words": words, "unit": unit, "si": si, "scale": scale, "group": "derived", "sign": sign,
                **belonging(name), "of": [f"{kind}_{contact}" for contact in contacts],
                "over": [f"{over}_{contact}" for contact in contacts if over]}

    found = []
    for wheel, contacts in SIDES.items():
        side = contacts[0][0]
        found += [entry(f"LV_{side}", f"L/V, {wheel} wheel", "Fy", contacts, "Fz", -1.0 if wheel == "left" else 1.0),
                  entry(f"Fz_{side}", f"vertical force, {wheel} wheel", "Fz", contacts),
                  entry(f"Fy_{side}", f"lateral force, {wheel} wheel", "Fy", contacts)]
    found += [entry("Fz_sum", "vertical force, all contacts", "Fz", CONTACTS),
              entry("Fy_sum", "lateral force, all contacts", "Fy", CONTACTS)]
    return [one for one in found if one["name"] not in columns and {*one["of"], *one["over"]}.issubset(columns)]


def derived_values(run: RunData, derived: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """The columns of `derived_columns` at all rows, (rows,) each, SI. L/V is that of `lateral_over_vertical`."""
    wheels = {f"LV_{contacts[0][0]}": wheel for wheel, contacts in SIDES.items()}
    return {one["name"]: lateral_over_vertical(run, wheels[one["name"]]) if one["over"]
            else np.sum([run.values(column) for column in one["of"]], axis=0) for one in derived}


def event_entries(run: RunData) -> list[dict[str, Any]]:
    """What happened, in order; where the file does not say, first contacts by its forces. Largest forces too."""
    found: list[dict[str, Any]] = [{"t": event.t, "what": event.kind, "force": number(event.force)} for event in run.events]
    known = answers(run)
    for contact, words in CONTACT_NAMES.items():
        if not run.events and contact[1] == "F" and (t := known[f"t_first_{contact}"]) is not None:
            found.append({"t": t, "what": f"{words} contact, by its force", "force": None})
        if peak := known[f"peak_N_{contact}"]:
            found.append({"t": known[f"t_peak_{contact}"], "what": f"largest normal force, {words}", "force": None,
                          "peak": number(peak)})
    if hardest := hardest_entry(known):
        found.append({"t": hardest["t"], "what": f"largest pressure, {hardest['what']}", "force": None, "pressure": hardest["p"]})
    return sorted((event for event in found if np.isfinite(event["t"])), key=lambda event: event["t"])


def opening(known: Mapping[str, Any]) -> float | None:
    """When the flange that touches first has its first peak, or touches, where a rigid contact has no force; by the answers of a
    run."""
    touches = [(t, known[f"t_first_peak_{c}"]) for c in FLANGES if (t := known[f"t_first_{c}"]) is not None]
    return next((touch if peak is None else peak for touch, peak in sorted(touches, key=lambda both: both[0])), None)


def hardest_entry(known: Mapping[str, Any]) -> dict[str, Any] | None:
    """The largest pressure of a run [Pa], its contact, moment [s] and place in the frame of the track [m], by the answers of the
    run; None where no pressure is known."""
    if not known["pmax"] or known["t_pmax"] is None:
        return None
    return {"p": number(known["pmax"]), "what": CONTACT_NAMES[known["pmax_contact"]], "t": number(known["t_pmax"]),
            "y": number(known["pmax_y"]), "z": number(known["pmax_z"])}


def unlisted(run: RunData) -> dict[str, int]:
    """How many events of each kind happened that the file does not list."""
    listed = Counter(event.kind for event in run.events)
    return {kind: more for kind in event_kinds() if (more := run.results.get(count_name(kind), 0) - listed[kind]) > 0}


def namelist_text(run: RunData) -> str:
    """The namelist of a run, for reading; '' in another code's file."""
    try:
        return run.case.to_namelist()
    except Error:               # no header, or one that was changed
        return ""


def outline_entry(outlines: Outlines) -> dict[str, Any]:
    """Outlines for the page; sides that are mirror images stand there once."""
    left, right = (side_entry(side) for side, _ in outlines.sides)
    return {"sides": [left] if left == right else [left, right], "axle": outlines.axle, "roll": outlines.roll}


def side_entry(side: Side) -> dict[str, list[float]]:
    """Wheel and rail, and the faces between which there is a gap, where they are steep: the flange's outer side, and the rail's
    side from below its gauge corner up to the top; each from below, Y and Z in turns [m]."""
    by_y = side.wheel[np.argsort(side.wheel[:, 0], kind="stable")]
    top = int(np.argmax(side.rail[:, 1]))
    inner = side.rail[:top + 1] if side.rail[0, 0] < side.rail[-1, 0] else side.rail[top:]
    faces = {"wheel": side.wheel, "rail": side.rail, "flank": steep(by_y[int(np.argmin(by_y[:, 1])):]),
             "gauge": steep(inner[np.argsort(inner[:, 1], kind="stable")])}
    return {name: points.ravel().round(7).tolist() for name, points in faces.items()}


def steep(points: np.ndarray) -> np.ndarray:
    """The connected stretch that begins with the first steep piece."""
    d = np.diff(points, axis=0)
    pieces = np.flatnonzero(np.arctan2(d[:, 1], np.abs(d[:, 0])) > FLANK)
    return points[pieces[0]:pieces[-1] + 2] if pieces.size else points[:0]


def pressure_entries(run: RunData, contacts: Sequence[str]) -> list[dict[str, Any]]:
    """The patches that are known at the largest normal force of each of some contacts, at the peak of the first contact of each
    flange and at the largest pressure, in order of time."""
    rows = {one.top for contact in ("LF", "RF") if (one := run.first_interval(contact))}
    known = answers(run)
    moments = [known[name] for name in (*(f"t_peak_{contact}" for contact in contacts), "t_pmax")]
    rows |= {int(np.abs(run.time - t).argmin()) for t in moments if t is not None}
    return [{"t": float(run.time[k]), "patches": [patch_entry(patch) for patch in patches]} for k in sorted(rows)
            if (patches := known_patches(run, k))]


def patch_entry(patch: Patch) -> dict[str, Any]:
    """A patch for the page; lengths x in rolling direction (half) and s along the profile [m]."""
    half = patch.p[len(patch.x)//2:]                        # from the middle of the patch in rolling direction
    dx, ds = patch.x[1] - patch.x[0], patch.s[1] - patch.s[0]
    widths = np.minimum(patch.width/(len(half)*dx), 1)
    middle = half[0]/max(patch.largest, half.max())
    return {"c": patch.contact, "also": patch.also, "pmax": float(f"{patch.largest:.5g}"), "area": float(f"{patch.area:.5g}"),
            "x": float(f"{len(half)*dx:.4g}"), "s": float(f"{len(patch.s)*ds:.4g}"),
            "p": np.rint(LEVELS*middle).astype(int).tolist(), "w": np.rint(LEVELS*widths).astype(int).tolist()}


def number(x: float | None) -> float | None:
    """A number for JSON, which has no NaN: None instead."""
    return float(x) if x is not None and np.isfinite(x) else None


def fill(title: str, facts: Mapping[str, object], bodies: Sequence[str], template: Path,
         scripts: Sequence[Path]) -> str:
    """Fill the template of a page, beside which its style lies, with scripts and data."""
    looks = template.with_suffix(".css").read_text(encoding="utf-8")
    script = "(() => {\n\"use strict\";\n" + "".join(path.read_text(encoding="utf-8") for path in scripts) + "})();\n"
    hashes = [base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in (script, looks)]
    policy = (f"default-src 'none'; script-src 'sha256-{hashes[0]}'; style-src 'sha256-{hashes[1]}'; "
              "img-src data:; base-uri 'none'; form-action 'none'")
    data = [f'<script type="text/plain" id="facts">{packed_json(facts)}</script>']
    data += [f'<script type="text/plain" id="run{k}">{body}</script>' for k, body in enumerate(bodies)]
    pieces = {"policy": html.escape(policy, quote=False), "title": html.escape(title), "style": looks,
              "data": "\n".join(data), "script": script}
    return re.sub(r"\{\{(\w+)\}\}", lambda found: pieces[found[1]], template.read_text(encoding="utf-8"))


def packed_json(facts: Mapping[str, object]) -> str:
    """JSON as deflated bytes in base64, which hold no tag, whatever the texts say."""
    text = json.dumps(facts, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    text = re.sub("[\ud800-\udfff\x00]", "\ufffd", text)
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()
