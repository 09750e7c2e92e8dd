"""The rows of the walk over what the other commands print: of profiles, of comparisons, of a round, of ensembles, of trust."""
from __future__ import annotations

import json
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from copy import deepcopy
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from matplotlib.figure import Figure

import ldbench
from ldbench import bodies
from ldbench.commands import profile as profile_command
from ldbench.conicity import FINE_PITCH
from ldbench.geometry.pair import Pair, pair
from ldbench.plots.style import ldbench_style
from ldbench.report.compare import comparison_figures
from ldbench.report.differences import compare
from ldbench.report.study import make_study
from ldbench.trust import Trust
from probes import MASS, ROLL_INERTIA, WEIGHT, profile
from raw import Raw, mean_square
from reading import Known, Line, csv_text, places, told_text, words_of
from running import REPO
from specimen import World
from table import CLEARANCE, COLUMNS, CONTACTS, DEG, KN, MM, RESULTS, WORDS, known
from texts import Row, by_title, kept_trust, printed, said

N = r" (\S+)"

# Profiles ----------------------------------------------------------------------------------

RAIL, WHEEL, RIGHT = (REPO/f"profiles/{name}.yz" for name in ("arprof", "awprof", "swprof"))


class Told(NamedTuple):
    """What the command prints of the actual pair with the simplified wheel on the right, and the pair."""

    words: str
    json: str
    pair: Pair


@cache
def told_pair() -> Told:
    found: list[Pair] = []

    def pair_once(*case: object) -> Pair:
        if not found:
            found.append(pair(*case))
        return found[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(profile_command, "pair", pair_once)
        patch.setattr("ldbench.geometry.pair.FINE_PITCH", 10*FINE_PITCH)    # rows of the geometry, ten times as far apart
        patch.setattr(profile_command, "save_page", lambda *page: None)
        patch.chdir(REPO)
        words = "profile", RAIL, WHEEL, "--set", f"wheel_profile_right={RIGHT}", "-o", "page.pdf"
        return Told(said(*words), said(*words, "--json"), found[0])


def measures() -> dict[str, Known]:
    """What the points of the files and the radii that they were made with say, SI."""
    y, z = profile("awprof").T
    face = (y > y[z.argmin()]) & (y < 0.06)
    tape = np.interp(0.07, y, z)
    below, tip = (np.interp(height, z[face], y[face]) for height in (tape - 0.01, z.min() + 0.002))
    rail = profile("arprof")
    return {"wheel": Known(len(y)), "rail": Known(len(rail)), "Sh": Known(tape - z.min(), 0.0, 1e-5),
            "Sd": Known(below - y.min(), 1e-3), "qR": Known(below - tip, 5e-3), "flange_angle": Known(np.radians(75), 1e-4),
            "tread_slope": Known(1/40, 1e-4),
            "hollow": Known(0.0, 0.0, 1e-6), "crown_radius": Known(0.254, 1e-3), "shoulder_radius": Known(0.03175, 2e-3),
            "corner_radius": Known(0.0142875, 1e-3), "gauge_point_y": Known(0.0, 0.0, 1e-6), "inclination": Known(1/40, 1e-3),
            "top_y": Known(rail[rail[:, 1].argmax(), 0], 0.0, 5e-4),
            "clearance_left": Known(CLEARANCE[0]/MM, 1e-3), "clearance_right": Known(told_pair().pair.clearance[1])}


def lines_of_profile(world: World, title: str, text: str) -> list[Line]:
    """From the points of the files; the conicity of the level wheelset before a flange is the taper of its treads."""
    told = measures()
    if title == "json":
        def conicity(match: re.Match[str]) -> Known:
            at = re.search(rf"^pair\.conicity\.{match[1]}\.amplitude\.{match[2]} = (.*)$", text, re.MULTILINE)
            assert float(at[1]) < 9.7e-3
            return Known(1/40, 0.03)

        before = "|".join(str(k) for k in range(90))
        return places(text, {
            r"profiles\.0\.points": told["wheel"], r"profiles\.1\.points": told["rail"],
            r"profiles\.\d\.(?:noise|smoothing)": Known(0.0, 0.0, 1e-9), r"profiles\.\d\.(\w+)": lambda m: told[m[1]],
            r"pair\.(clearance_\w+)": lambda m: told[m[1]], r"pair\.rail_inclination\.\d": 0.0,
            rf"pair\.conicity\.(level|with roll)\.(?:EN 15302|harmonic linearisation)\.({before})": conicity,
            r"pair\.conicity\.(?:level|with roll)\.nonlinearity_parameter": Known(0.0, 0.0, 1e-4),
            r"pair\.conicity\.level\.contact_angle_parameter": Known(0.0, 0.0, 1e-4),
            r"pair\.conicity\.(?:level|with roll)\.(?:roll|contact)_angle_parameter": Known(1/40, 0.03),
            r"pair\.zones\.\w+\.(\d)\.flange": lambda m: float(m[1] > "0"),
            r"pair\.zones\.\w+\.0\.angle": Known(np.arctan(1/40), 1e-3)})
    facts = told_pair().pair.facts()
    both = [facts["conicity"][kept] for kept in ("level", "with roll")]
    lines = [Line(pattern, pattern, lambda w, x=x: x) for pattern, x in (
        (r"^wheel awprof.yz: (\d+) points", told["wheel"]), (r"^rail arprof.yz: (\d+) points", told["rail"]),
        (r"height Sh (\S+) mm", told["Sh"].of(MM)), (r"thickness Sd (\S+) mm", told["Sd"].of(MM)),
        (r"qR (\S+) mm", told["qR"].of(MM)),
        (r"flange angle (\S+) °", told["flange_angle"].of(DEG)), (r"tread slope (\S+) \(1:(\S+)\)", (1/40, 40)),
        (r"hollow of the tread (\S+) mm", told["hollow"].of(MM)), (r"crown radius (\S+) mm", told["crown_radius"].of(MM)),
        (r"shoulder radius (\S+) mm", told["shoulder_radius"].of(MM)), (r"corner radius (\S+) mm", told["corner_radius"].of(MM)),
        (r"gauge point at y (\S+) mm", told["gauge_point_y"].of(MM)), (r"inclination (\S+) \(1:(\S+)\)", (1/40, 40)),
        (r"top of rail at y (\S+) mm", told["top_y"].of(MM)),
        (r"clearance left (\S+), right (\S+) mm", [told[f"clearance_{side}"].of(MM) for side in ("left", "right")]),
        *((rf"{words}: level (\S+), with roll (\S+)$", [scale*one[name] for one in both]) for words, name, scale in (
            (r"nonlinearity parameter \[1/mm\]", "nonlinearity_parameter", 1/MM),
            ("rolling radii coefficient in a curve of 300 m", "rolling_radii_coefficient", 1),
            ("contact angle parameter at 3 mm", "contact_angle_parameter", 1),
            ("roll angle parameter at 3 mm", "roll_angle_parameter", 1))))]
    lines.append(Line(r"equivalent conicity at [234] mm: level (\S+), with roll (\S+) \(EN 15302\), (\S+) \(harmonic",
                      "conicities: the taper of the tread", lambda w, m: [Known(1/40, 0.03)]*3, often=True))
    return [*lines, *(Line(rf"^  {side} zone of the {'flange' if one['flange'] else 'tread'}: y (\S+) to (\S+) mm, angle (\S+)°$",
                           f"zone of the JSON, {side}", lambda w, m, side=side: zone_of(facts, side, m), often=True)
                      for side, zones in facts["zones"].items() for one in zones[:2])]


def zone_of(facts: Mapping[str, Any], side: str, match: re.Match[str]) -> list[float]:
    """The zone of the JSON with the inclination that is printed."""
    one = min(facts["zones"][side], key=lambda one: abs(DEG*one["angle"] - float(match[3])))
    return [MM*one["y_first"], MM*one["y_last"], DEG*one["angle"]]


# Comparisons -------------------------------------------------------------------------------

def between_rows(a: Raw, b: Raw, column: str) -> np.ndarray:
    """A column of the second file at the rows of the first, along straight lines; where a contact is closed on either side."""
    x = np.interp(a.t, b.t, b.c[column])
    x[a.t > b.t[-1]] = np.nan
    if column.partition("_")[0] in ("angle", "y", "z", "radius"):
        k = np.clip(np.searchsorted(b.t, a.t), 1, len(b.t) - 1)
        closed = np.isfinite(b.c[column])
        x[~(closed[k] & (closed[k - 1] | (a.t == b.t[k])))] = np.nan
    return x


def difference(a: Raw, b: Raw, column: str) -> np.ndarray:
    """Second file less first at the rows of the first."""
    return between_rows(a, b, column) - a.c[column]


@cache
def comparison(world: World) -> dict[str, Figure]:
    """The pages of a comparison of the thrown wheelset with the one that is thrown faster."""
    with ldbench_style():
        return dict(comparison_figures(compare([world.run("ex2_aw"), world.run("ex3_aw")])))


def compared(world: World, folder: Path) -> dict[str, str]:
    found = {title: text.replace("−", "-") for title, text in by_title(comparison(world).items()).items()}
    said("compare", world.thrown.file, world.faster.file, "-o", folder/"c.pdf", "-q")
    parts = "files", "differences", "impacts of", "laid on each other"
    assert len(found) > 12 and all(any(words in title for title in found) for words in parts)
    return {**found, "csv": csv_text(folder/"c.csv", "what", "quantity")}


def back(raw: Raw) -> float | None:
    """The passage of the centre after turning back on both sides [s]."""
    return next((t for t in raw.passages() if t > raw.start("LF") and t > raw.start("RF")), None)


def event_of(raw: Raw, kind: str) -> float | None:
    """A first event, return, end [s] or largest force [N]."""
    kind = kind.removeprefix("first ")
    contact = CONTACTS.get(kind.removeprefix("largest normal force, "))
    if contact:
        return raw.peak(contact)[0] or None
    return raw.t[-1] if kind == "end" else back(raw) if kind == "return to the centre" else next(
        (t for t, what, _ in raw.events if what == kind), None)


def impact_of(raw: Raw, contact: str, number: int) -> dict[str, float] | None:
    """The contact with a number, from 1, that begins in the run."""
    rows = [rows for rows in raw.episodes(contact) if rows.start > 0]
    return raw.exchange(contact, rows[number - 1]) if number <= len(rows) else None


def difference_of(a: Raw, b: Raw, column: str) -> dict[str, Known]:
    """Root of the mean square, the largest difference, its time and the share of the time in which both files have the column."""
    d = difference(a, b, column)
    there = np.isfinite(d)
    if not there.any():
        return {"rms": Known(None), "largest": Known(None), "at [s]": Known(None), "share compared": Known(0.0)}
    k, whole = int(np.nanargmax(np.abs(d))), (there | (a.t > b.t[-1])).all()
    return {"rms": Known(np.sqrt(mean_square(a.t[there], d[there])), 2e-4 if whole else 0.5), "largest": Known(d[k], 2e-4),
            "at [s]": Known(a.t[k]), "share compared": Known(there[a.t <= b.t[-1]].mean(), 0.0 if whole else 0.1)}


EXCHANGE = ("start", 1e3), ("duration", 1e3), ("peak", KN), ("impulse", KN), ("angle", DEG)


def lines_of_comparison(world: World, title: str, text: str) -> list[Line]:
    """Rows and times of the files, events, peaks, impacts by number, differences of every column."""
    a, b = world.thrown, world.faster
    if title == "csv":
        return lines_of_differences(a, b, text)

    def events(_: object, match: re.Match[str]) -> list[float | None]:
        kind, unit = re.match(r"ex3_aw (.*) \[(\S+)\]", match[0]).groups()
        found = [event_of(raw, kind) for raw in (a, b)]
        found = [None if x is None else {"ms": 1e3, "kN": KN}[unit]*x for x in found]
        return [*found, None if None in found else found[1] - found[0]]

    def impacts(_: object, match: re.Match[str]) -> list[float | None]:
        side, part, number = match[0].partition(":")[0].split()[:3]
        found = [impact_of(raw, CONTACTS[f"{side} {part}"], int(number)) for raw in (a, b)]
        return [None if one is None else Known(scale*one[key], 2e-4) for key, scale in EXCHANGE for one in found]

    def differences(_: object, match: re.Match[str]) -> list[Known]:
        column, _, scale = COLUMNS[match[0].strip().partition(" [")[0]]
        one = difference_of(a, b, column)
        return [one["rms"].of(scale), one["largest"].of(scale), one["at [s]"].of(1e3), one["share compared"].of(100)]

    lines = {
        "files": [*(Line(rf"^{raw.file.stem} .* ldbench \S+ halfspace{N} 0 to{N} ", "rows; last time [s]",
                         lambda w, raw=raw: (len(raw.t), raw.t[-1]), 1e-4) for raw in (a, b)),
                  Line(rf"^ex3_aw [a-z -]+(?:, [a-z ]+)? \[\S+\]{N}{N}{N}$", "events and forces", events, often=True)],
        "differences": [Line(rf"^ +(?:.* )?\[\S+\]{N}{N}{N}{N}$", "differences", differences, often=True)],
        "impacts of": [Line(rf"^(?:left|right) (?:flange|tread) \d+{N*10}$", "impacts", impacts, often=True)],
        "laid on each other": [Line(r"^(?:left|right) (?:flange|tread) \d+: (\S+) ms$", "begin of an impact [ms]",
                                    lambda w, m: impacts(w, m)[0], often=True)]}
    return [line for words, some in lines.items() if words in title for line in some]


def lines_of_differences(a: Raw, b: Raw, text: str) -> list[Line]:
    """The tables of the CSV file, in SI: differences of columns, events and impacts."""
    sides = ("reference", a), ("value", b)

    def of_pair(match: re.Match[str], of: Any) -> Known:
        found = {side: of(raw) for side, raw in sides}
        found["difference"] = None if None in found.values() else found["value"] - found["reference"]
        return Known(found.get(match[match.re.groups]), 2e-4, 1e-9)

    def impact(match: re.Match[str]) -> Known:
        key = {"largest normal force": "peak"}.get(match[3], match[3])
        return of_pair(match, lambda raw: (impact_of(raw, match[1], int(match[2])) or {}).get(key))

    return places(text, {
        r"difference\.(\w+)\.(rms|largest|at \[s\]|share compared)": lambda m: difference_of(a, b, m[1])[m[2]],
        r"difference\.\w+\.\w+": None,
        r"event\.(.*)\.(\w+|at \[s\]|share compared)": lambda m: of_pair(m, lambda raw: event_of(raw, m[1])),
        r"peak\.N_(\w+)\.(\w+|at \[s\]|share compared)": lambda m: of_pair(m, lambda raw: raw.peak(m[1])[0] or None),
        r"impact\.(\w+) (\d+) (\w+)\.(\w+|at \[s\]|share compared)": impact})


@cache
def study(world: World) -> tuple[list[Raw], list[Figure], str]:
    """The runs of a study of the thrown wheelset, its pages and its table; runs that are there stay."""
    drawn: list[Figure] = []
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        patch.chdir(world.folder)
        patch.setattr("ldbench.report.study.save_document", lambda chapters, *_: drawn.extend(
            figure for _, pages in chapters for _, figure in pages))
        (folder/"inputs").mkdir()
        shutil.copy("inputs/ex2_aw.nml", folder/"inputs")
        with ldbench_style():
            make_study(folder/"inputs", folder, 2)
        times = {file: file.stat().st_mtime_ns for file in (folder/"study").glob("*.txt")}
        pages = [*drawn]
        make_study(folder/"inputs", folder, 2)
        assert times == {file: file.stat().st_mtime_ns for file in (folder/"study").glob("*.txt")}
        raws = [Raw(folder/f"study/ex2_aw_{which}.txt") for which in ("fine", "law", "step")]
        return raws, pages, csv_text(folder/"ldbench_study.csv", "variant")


def rms_of(fine: Raw, one: Raw, column: str, early: bool) -> float:
    """Root of the mean square of a difference, over the whole run or up to the end of the first contact."""
    rows = fine.t <= min(fine.t[fine.first("LF").stop - 1] if early else np.inf, one.t[-1])
    return float(np.sqrt(mean_square(fine.t[rows], difference(fine, one, column)[rows])))


def lines_of_study(world: World, title: str, text: str) -> list[Line]:
    """The differences of both variants from their files: rms of Y and of the left flange, first peak, end."""
    (fine, *variants), _, _ = study(world)
    if title == "csv":
        def of(match: re.Match[str]) -> Known | None:
            one, what = variants[("law", "step").index(match[1])], match[2]
            if rms := re.fullmatch(r"(\w+) rms(, first contact| of the reference)? \[\w+\]", what):
                until = fine.t <= one.t[-1]
                return Known(np.sqrt(mean_square(fine.t[until], fine.c[rms[1]][until])) if "reference" in what else
                             rms_of(fine, one, rms[1], bool(rms[2])), 0.01)
            if what.startswith("N_LF"):
                a, b = (raw.impact("LF")["peak"] if "first" in what else raw.peak("LF")[0] for raw in (fine, one))
                return Known(b/a - 1, 1e-6, 4e-9)       # files have nine digits of each
            found = [event_of(raw, what.partition(" [")[0]) for raw in (fine, one)]
            return Known(None if None in found else found[1] - found[0], 1e-6, 1e-9)
        return places(text, {r"(law|step)\.(.*)": of})
    if title != "summary":
        return []
    row = [scale*rms_of(fine, one, column, early) for column, early, scale in (
        ("Y", True, 1e6), ("Y", False, MM), ("N_LF", True, KN), ("N_LF", False, KN)) for one in variants]
    row += [100*(one.impact("LF")["peak"]/fine.impact("LF")["peak"] - 1) for one in variants]
    row += [1e3*(one.t[-1] - fine.t[-1]) for one in variants]
    return [Line("^ex2_aw" + 12*N + "$", "differences, of law and step in turn", lambda w: row, 0.01)]


# The round ---------------------------------------------------------------------------------

OVER = {name: 1 + 6e-4*(k + 1) for k, name in enumerate((
    *("Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc"),
    *(f"{name}_{c}" for name in ("N", "Fy", "Fz", "angle", "y", "z", "radius") for c in WORDS), "kinetic", "potential"))}


def factor(column: str) -> float:
    """By which a column of the file that is scored differs from the reference; parts of an energy differ by one factor."""
    return OVER.get("kinetic" if column[:2] == "KE" else "potential" if column[:2] in ("PE", "W_") else column, 1.0)


@cache
def scored(world: World) -> tuple[dict[str, str], list[dict[str, Any]]]:
    """The thrown wheelset against itself, each column of the file by a factor of its own: in words and numbers, and the scores."""
    raw = world.thrown
    rows = np.column_stack([factor(column)*x for column, x in raw.c.items()])
    changed = iter(" ".join(f"{x:.17g}" for x in row) for row in rows)
    first, *lines = raw.text.splitlines()
    with tempfile.TemporaryDirectory() as name:
        file = Path(name)/"ex2_aw.txt"
        file.write_text("\n".join([first, *(line if line[0] == "#" else next(changed) for line in lines)]))
        words = "score", file, "--reference", raw.file, "--simulation", "ex2_aw"
        told = printed(*words, "--json")
        found = {"json": told_text(json.loads(told)), "all": said(*words, "--all"), "worst": said(*words)}
        return {title: text.replace(f"{name}/", "") for title, text in found.items()}, json.loads(told)["files"][0]["scores"]


YARDSTICKS = json.loads((REPO/"wrappers/ldbench_round/yardsticks.json").read_text())["ex2_aw"]
LAWS = "hertz", "bodies", "rigid"


def expected_score(raw: Raw, name: str) -> Known:
    """By how much a quantity of the file differs from the reference, by the factors of its columns: rms over rms, of places and
    radii over the clearance; times are equal, and impulses and largest forces go with the normal force."""
    column = {"KE": "kinetic", "PE": "potential"}.get(name, name)
    if column in OVER:
        one = OVER[column] - 1
        if column[:2] not in ("y_", "z_", "ra"):
            return Known(one, 1e-6)
        closed = np.isfinite(raw.c[column])
        both, steps = closed[1:] & closed[:-1], np.diff(raw.t)
        squares = np.where(closed, raw.c[column], 0.0)**2
        mean = np.sum(np.where(both, steps, 0.0)*(squares[1:] + squares[:-1]))/2/np.sum(steps[both])
        return Known(one*np.sqrt(mean)*MM/CLEARANCE[0], 2e-3)
    contact, _, what = name.partition(" ")
    return Known(OVER[f"N_{contact}"] - 1 if what.endswith(("impulse", "peak")) else 0.0, 1e-4, 1e-9)


def of_yardsticks(name: str) -> tuple[float | None, float | None]:
    """The difference of our run with Hertz's law, and the largest one of all laws; None where it is not known or nothing."""
    own = [YARDSTICKS[law].get(name) for law in LAWS]
    return own[0], max((x for x in own if x is not None), default=None)


def times(difference: float, yardstick: float | None) -> Known:
    """How many times a yardstick, in two digits; beyond a hundred times and below a hundredth only that is said."""
    if not yardstick:
        return Known(None)
    return Known(float(np.clip(difference/yardstick, 0.01 if difference > 1e-9 else 0.0, 100)), 0.0, 1e-9)


def grade_of(difference: float) -> float | None:
    return next((limit for limit in (1e-3, 1e-2, 0.1) if difference <= limit), None)


def lines_of_scores(world: World, title: str, text: str) -> list[Line]:
    """Differences by the factors of the columns, grades, and the differences of our own runs beside them."""
    raw, names = world.thrown, [one["name"] for one in scored(world)[1]]
    expected = {name: expected_score(raw, name) for name in names}
    if title == "json":
        def of_score(match: re.Match[str]) -> Known | float | None:
            name, key = names[int(match[1])], match[2]
            one, shown = expected[name], scored(world)[1][int(match[1])]
            if key in LAWS:
                return YARDSTICKS[key].get(name)
            if key == "value" and name in OVER:
                return Known((OVER[name] - 1)*shown["reference"], 1e-6)
            if key == "reference":
                return Known(np.sqrt(mean_square(raw.t, raw.c[name])), 1e-6)
            largest = of_yardsticks(name)[1]
            return {"difference": one, "grade": grade_of(one.value), "share": 1.0,
                    "of_spread": Known(one.value/largest, 2e-3, 1e-9) if largest else None}[key]

        motion = "|".join(str(k) for k, name in enumerate(names) if name in [*OVER][:9])
        columns = "|".join(str(k) for k, name in enumerate(names) if name in OVER)
        return places(text, {
            r"files\.0\.end": raw.t[-1], r"files\.0\.horizon": YARDSTICKS["horizon"], r"files\.0\.share": 1.0,
            rf"files\.0\.scores\.({motion})\.(reference)": of_score, rf"files\.0\.scores\.({columns})\.(value)": of_score,
            r"files\.0\.scores\.(\d+)\.((?!value|reference)\w+)": of_score})
    words = {column: what for what, (column, _, _) in COLUMNS.items()}
    lines = [Line(r"scored up to (\S+) s \(horizon (\S+) s\), where a difference of the start has grown (\d+) times",
                  "end, horizon [s], growth", lambda w: (raw.t[-1], YARDSTICKS["horizon"], YARDSTICKS["growth"])),
             Line(r"closed for (\S+) % of it", "share of the time with equal contacts [%]", lambda w: 100.0),
             Line(r"found initial vY (\S+) instead of (\S+)$", "initial vY [m/s] of file and call", lambda w, m: (
                 raw.c["vY"][0]*(1.0 if "reference" in m[0] else OVER["vY"]), 0.5), 1e-3, often=True)]
    shown = [(words.get(name, name), name) for name in names] if title == "all" else [*worst(expected)]
    for label, name in shown:
        one, (hertz, largest) = expected[name], of_yardsticks(name)
        lines.append(Line(rf"^  {re.escape(label)} +(\S+) +(\S+) +(\S+) % +(?:[<>] )?(\S+) +(?:[<>] )?(\S+)$", f"score of {name}",
                          lambda w, one=one, hertz=hertz, largest=largest: (
                              Known(one.value, 0.0, max(5e-2*one.value, 1e-9)), grade_of(one.value), 100.0, times(one.value, hertz),
                              times(one.value, largest))))
    return lines


KINDS = {"displacements": ("Y", "Z", "roll"), "velocities": ("vY", "vZ", "roll_rate"), "accelerations": ("aY", "aZ", "roll_acc"),
         **{words: tuple(f"{name}_{c}" for name in names for c in WORDS) for words, names in (
             ("contact forces", ("N", "Fy", "Fz")), ("contact angles", ("angle",)), ("contact points", ("y", "z")),
             ("rolling radii", ("radius",)))}, "energies": ("KE", "PE")}


def worst(expected: Mapping[str, Known]) -> Iterator[tuple[str, str]]:
    """The line of each kind and the quantity that grades it: the one that differs most; no time differs."""
    words = {column: what for what, (column, _, _) in COLUMNS.items()}
    for kind, names in KINDS.items():
        name = max((name for name in names if name in expected), key=lambda name: expected[name].value)
        yield f"{kind}, worst: {words.get(name, name)}", name
    yield from (("impulses of impacts, worst: right flange", "RF 1 impulse"), ("times of events, worst: left tread", "LT opens 1"),
                ("largest forces of impacts, worst: right flange", "RF 1 peak"),
                ("durations of impacts, worst: left tread", "LT 1 duration"),
                ("time with other contacts closed", "other contacts closed"))


@cache
def checked(world: World) -> list[dict[str, Any]]:
    """The findings of the command, which prints them in words, too."""
    return json.loads(printed("check", world.thrown.file, "--json", status=1))["files"][0]["findings"]


def findings(world: World, folder: Path) -> dict[str, str]:
    return {"words": said("check", world.thrown.file, "--all", status=1), "json": told_text({"findings": checked(world)})}


def lines_of_findings(world: World, title: str, text: str) -> list[Line]:
    """A finding in words is that of the JSON; what differs from the call is by how much the specimen does."""
    raw, found = world.thrown, checked(world)
    sure = {"initial vY": raw.c["vY"][0] - 0.5, "initial Y": 0.0, "initial Z": abs(raw.c["Z"][0]), "initial roll": 0.0,
            "initial vZ": 0.0, "initial roll_rate": 0.0, "quantities": 37,
            "mass by the lateral forces": Known(raw.setting("mass")/MASS - 1, 1e-3),
            "roll inertia": Known(raw.setting("roll_inertia")/ROLL_INERTIA - 1, 1e-3),
            "kinetic energy, lateral is that of the motion": Known(raw.setting("mass")/MASS - 1, 2e-3),
            "kinetic energy, vertical is that of the motion": Known(raw.setting("mass")/MASS - 1, 2e-3),
            "kinetic energy, roll is that of the motion": Known(raw.setting("roll_inertia")/ROLL_INERTIA - 1, 2e-3)}
    if title == "json":
        def number(match: re.Match[str]) -> Known | float | None:
            one = found[int(match[1])]
            if match[2] == "time":
                return None if one["row"] is None else raw.t[one["row"] - 1]
            return sure[one["what"]]

        known_ones = "|".join(str(k) for k, one in enumerate(found) if one["what"] in sure)
        return places(text, {rf"findings\.({known_ones})\.(number)": number, r"findings\.(\d+)\.(time)": number})
    lines = [Line(r"; (\d+) passed, (\d+) doubtful, (\d+) failed$", "how many findings of each kind", lambda w: [
                 sum(one["verdict"] == kind for one in found) for kind in ("passed", "doubtful", "failed")]),
             Line("expected (\\S+), found (\\S+)$", "initial vY [m/s]", lambda w: (0.5, raw.c["vY"][0])),
             Line("expected (\\S+) kN, found (\\S+) kN where", "weight and load [kN]: of the call, of the file", lambda w: (
                 KN*WEIGHT, Known(KN*raw.weight, 0.03))),
             Line("expected (\\S+) kg, found (\\S+) kg$", "mass [kg]", lambda w: (MASS, Known(raw.setting("mass"), 1e-3))),
             Line("expected (\\S+) kg m2, found (\\S+) kg m2$", "inertia [kg m2]", lambda w: (
                 ROLL_INERTIA, Known(raw.setting("roll_inertia"), 1e-3)))]
    for one in found:
        parts = {"number": r" (\S+)", "limit": r" \(limit (\S+)\)", "row": r", row (\S+)", "time": r" at (\S+) s"}
        shown = [name for name in parts if one[name] is not None and (one["number"] is not None or name != "limit")]
        lines.append(Line(rf"^  {one['verdict']}: {re.escape(one['what'])}{''.join(parts[name] for name in shown)}(?:: .*)?$",
                          f"finding: {one['what']}", lambda w, one=one, shown=shown: [Known(one[name], 6e-3) for name in shown]))
    return lines


@cache
def fingerprints(world: World) -> dict[str, str]:
    return {"words": said("fingerprint", world.thrown.file), "json": said("fingerprint", world.thrown.file, "--json")}


def lines_of_fingerprint(world: World, title: str, text: str) -> list[Line]:
    """Elastic contact of half-spaces without loss: Hertz's exponent and force within the uncertainty, the force of the rows at the
    approach that the blows reach; each number in words is that of the JSON."""
    raw = world.thrown
    told = {key: None if x == "–" else float(x)
            for key, x in re.findall(r"^files\.0\.(\S+) = (.*)$", fingerprints(world)["json"], re.MULTILINE)}
    if title == "json":
        peaks = [(raw.overlap(c, raw.first_peak(c)), raw.impact(c)["peak"]) for c in ("LF", "RF")]
        reached = float(np.mean([overlap for overlap, _ in peaks]))
        stiffness = float(np.mean([peak/overlap**1.5 for overlap, peak in peaks]))
        return places(text, {
            r"files\.0\.(?:step|pitch)\.\w+": None, r"files\.0\.exponent\.value": Known(1.5, 0.0, told["exponent.uncertainty"]),
            r"files\.0\.hertz\.value": Known(1.0, 0.0, told["hertz.uncertainty"]),
            r"files\.0\.restitution\.value": Known(1.0, 5e-3), r"files\.0\.(?:loss|damping)\.value": Known(0.0, 0.0, 1e-3),
            r"files\.0\.approach": Known(reached, 0.2),
            r"files\.0\.force\.value": Known(stiffness*told["approach"]**1.5, 0.2)})

    def both(key: str, scale: float = 1.0) -> tuple[float, float]:
        return scale*told[f"{key}.value"], abs(scale)*told[f"{key}.uncertainty"]

    number, once = r"(\S+) ± (\S+)", {
        r"elastic, {} times Hertz": both("hertz"), r"exponent {}, loses": both("exponent"), r"loses {} % per": both("loss", 100),
        r"^  exponent of the approach: {} \(": both("exponent"), r"approach of \S+ mm: {} kN": both("force", KN),
        r"^  force over that of Hertz: {} \(": both("hertz"), r"^  restitution of the energy: {} \(": both("restitution"),
        r"^  energy lost per impact: {} %": both("loss", 100), r"^  no damping: {} s/m": both("damping")}
    return [Line(r"force at an approach of (\S+) mm", "approach [mm]", lambda w: MM*told["approach"]),
            *(Line(pattern.replace("{}", number), pattern, lambda w, x=x: x) for pattern, x in once.items())]


def lines_of_parcel(world: World, title: str, text: str) -> list[Line]:
    """What `check` refuses in both files, in numbers of the call and of the specimen."""
    lines = [Line("initial vY: expected (\\S+), found (\\S+)$", "initial vY [m/s]", lambda w: (0.5, world.thrown.c["vY"][0]))]
    for raw, name in ((world.thrown, "ex2_aw"), (world.pushed, "ex5_aw")):
        start = rf"^{name}\.txt: `check` refuses it: "
        lines += [Line(start + r"weight and vertical load: expected (\S+) kN, found (\S+) kN where", "weight and load [kN]",
                       lambda w, raw=raw: (KN*WEIGHT, Known(KN*raw.weight, 0.03))),
                  Line(start + r"mass by the (?:lateral|vertical) forces: expected (\S+) kg, found (\S+) kg$", "mass [kg]",
                       lambda w, raw=raw: (MASS, Known(raw.setting("mass"), 2e-3))),
                  Line(start + r"roll inertia: expected (\S+) kg m2, found (\S+) kg m2$", "inertia [kg m2]",
                       lambda w, raw=raw: (ROLL_INERTIA, Known(raw.setting("roll_inertia"), 1e-3)))]
    return lines


# Ensembles, bodies, trust ------------------------------------------------------------------

SPEEDS = 0.7, 0.8, 0.95     # of the members [m/s]


def members(world: World, folder: Path) -> dict[str, str]:
    """What is printed of an ensemble, and of its store."""
    words = "ensemble", "inputs/ex2_aw.nml", "--set", "t_end=0.02", "--over", f"vY={','.join(map(str, SPEEDS))}", "-j", "1"
    return {"ensemble": said(*words, "-o", folder/"s.zarr"), "store": said("store", folder/"s.zarr"),
            "json": said("store", folder/"s.zarr", "--json")}


@cache
def members_of(world: World) -> list[Raw]:
    """The members, run one by one."""
    case = ldbench.Case.from_namelist(world.folder/"inputs/ex2_aw.nml")
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.chdir(world.folder)
        return [Raw(Path(ldbench.run(case.replace(vY=speed, t_end=0.02)).write(Path(folder)/"run.txt"))) for speed in SPEEDS]


def lines_of_members(world: World, title: str, text: str) -> list[Line]:
    n, raws = len(SPEEDS), members_of(world)
    if title == "json":
        return places(text, {"removed": 0, r"sweeps\.0\.(?:members|done|about\.dims\.vY)": n, r"sweeps\.0\.failed": 0})
    if title == "store":
        return [Line(r"(\d+) sweep", "sweeps", lambda w: 1),
                Line(r"(\d+) members \((\d+) vY\), (\d+) done, (\d+) failed$", "members", lambda w: (n, n, n, 0))]
    results = {"t": 1.0, **{f"{kind}_N_{c}": KN for kind in ("peak", "first_peak") for c in WORDS}}
    lines = [Line(r"^(\d+) vY: (\d+) runs, (\d+) failed$", "members", lambda w: (n, n, 0)),
             Line("^(\\d+) ended with t_end", "endings", lambda w: n)]
    for name, scale in results.items():
        if found := re.search(rf"^{name} \[.*\]", text, re.MULTILINE):
            own = [scale*(known(raw)[name].value or 0.0) for raw in raws]
            lines.append(Line(rf"^{re.escape(found[0])}: (\S+) to (\S+), median (\S+)$", f"{name}: least, largest, median",
                              lambda w, own=own: (min(own), max(own), float(np.median(own)))))
    assert len(lines) == 2 + 1 + 4 + 1
    return lines


@cache
def rail_body() -> tuple[str, str, bodies.Body]:
    """What is printed of a rail's body of few waves, and the body."""
    written: list[bodies.Body] = []
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.setattr("ldbench.bodies.influence.WAVES", WAVES)
        patch.setattr(bodies, "write", lambda file, found: written.extend(found))
        found: list[bodies.Body] = []
        find = bodies.find
        patch.setattr(bodies, "find", lambda *given: found or found.extend(find(*given)) or found)
        patch.chdir(REPO)
        words = "bodies", "inputs/ex2_aw.nml", "--only", "rail", "-o", f"{folder}/rail.bodies"
        return said(*words).replace(folder, ""), said(*words, "--json"), written[0]


WAVES = np.geomspace(0.2, 800, 4)       # wave numbers [1/m]


def lines_of_bodies(world: World, title: str, text: str) -> list[Line]:
    """The influence between the strips whose angles are nearest, over that of a half-space."""
    body = rail_body()[2]
    facing = slice(int(np.argmax(body.angles)) + 1)      # of a rail from the crown to the steepest place

    def ratio(one: float, other: float) -> float:
        i, j = (int(np.argmin(np.abs(DEG*body.angles[facing] - angle))) for angle in (one, other))
        return float(np.trapezoid(body.whole[:, i, j], WAVES)/np.trapezoid(body.halfspace[:, i, j], WAVES))

    if title == "json":
        return places(text, {r"bodies\.0\.nodes": body.nodes, r"bodies\.0\.strips": len(body.angles),
                             r"bodies\.0\.influence over half-space\.(\d+) on (\d+)": lambda m: Known(
                                 ratio(float(m[1]), float(m[2])), 1e-6)})
    return [Line(r"(\d+) strips, (\d+) nodes$", "strips, nodes", lambda w: (len(body.angles), body.nodes)),
            *(Line(rf"\b{one} on {other} (\S+?)(?:,|$)", f"influence, {one} on {other}",
                   partial(lambda at, w: ratio(*at), (one, other)))
              for one, other in ((60, 45), (60, 30), (60, 0), (45, 0)))]


@cache
def varied(world: World) -> dict[str, Any]:
    """The variations that the report has kept, with twins of two answers that do not share them: medians are no values."""
    told = deepcopy(kept_trust(world))
    for name in "farthest_left", "first_peak_N_LF":
        one = told["answers"][name]
        one["chaotic"] = True
        one["values"] = [x*(1.02 + 1e-3*k) if part["kind"] == "twin" else x
                         for k, (part, x) in enumerate(zip(told["variations"], one["values"], strict=True))]
    return told


def trusted(world: World, folder: Path) -> dict[str, str]:
    """What the command prints of the variations."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench.commands.trust.trust", lambda *case, **how: Trust.of_facts(varied(world)))
        return {"json": told_text(json.loads(printed("trust", "inputs/ex2_aw.nml", "--json", "-"))),
                # Lines are broken anywhere.
                "words": re.sub(r"\n {8}", " ", said("trust", "inputs/ex2_aw.nml"))}


PROGRAM = "twin", "accuracy", "influence", "bodies"       # kinds of variations that leave the data as they are


class Spread(NamedTuple):
    """What the variations of an answer say, SI."""

    value: float | None
    median: float | None
    low: float | None
    high: float | None
    low_inputs: float | None
    high_inputs: float | None
    causes: Mapping[str, float | None]      # None: it makes the answer come or go
    twins: list[float]


def spread_of(world: World, name: str) -> Spread:
    """From the values of the variations, by kinds: inputs count to either side of an answer that the twins share."""
    told = varied(world)
    one = told["answers"][name]
    value, kinds = one["value"], [(part["kind"], part["cause"]) for part in told["variations"]]
    own = [(kind, cause, x) for (kind, cause), x in zip(kinds, one["values"], strict=True)]
    twins = [x for kind, _, x in own if kind == "twin"]
    program = [x for x in [value, *(x for kind, _, x in own if kind in PROGRAM)] if x is not None]
    every = [x for x in [value, *(x for *_, x in own)] if x is not None]
    if not one["chaotic"] and value is not None:
        every += [2*value - x for kind, _, x in own if kind == "input" and x is not None]
    causes: dict[str, float | None] = {}
    for _, cause, x in own:
        if (x is None) != (value is None):
            causes[cause] = None
        elif x is not None and causes.get(cause, 0.0) is not None and abs(x - value) > abs(causes.get(cause) or 0.0):
            causes[cause] = x - value
    return Spread(value, *((float(np.median(program)), min(program), max(program)) if program else (None,)*3),
                  *((min(every), max(every)) if every else (None,)*2), causes, [x for x in twins if x is not None])


def lines_of_trust(world: World, title: str, text: str) -> list[Line]:
    told = varied(world)
    if title == "json":
        def of_answer(match: re.Match[str]) -> Known | float | None:
            one = spread_of(world, match[1])
            if match[2] == "value" and match[1] in known(world.thrown):
                shown = known(world.thrown)[match[1]]
                return shown if shown.value else one.value
            return one.causes[match[3]] if match[2].startswith("causes") else getattr(one, match[2])

        return places(text, {r"answers\.(\w+)\.(causes\.(.*)|(?!values)\w+)": of_answer})
    kinds = [one["kind"] for one in told["variations"]]
    lines = [Line(r"^(\d+) runs: the case, (\d+) twins and (\d+) other variations", "runs", lambda w: (
                 len(kinds) + 1, kinds.count("twin"), len(kinds) - kinds.count("twin")))]
    for name, one in RESULTS.items():
        if re.search(rf"^{re.escape(one.words.partition(' [')[0])}: ", text, re.MULTILINE):
            lines += lines_of_answer(spread_of(world, name), one.words.partition(" [")[0], one.scale, text)
    assert len(lines) > 40
    return lines


def lines_of_answer(one: Spread, words: str, scale: float, text: str) -> Iterator[Line]:
    """Value, median and ranges with their share of the value in %, twins, and the causes that are a hundredth of the largest."""
    def shares(*ends: float) -> list[float]:
        return [100*abs(x/one.value - 1) for x in ends] if one.value else []

    start, of_value = rf"^{re.escape(words)}: .*\n(?:    .*\n)*?    ", r" \(−(\S+) to \+(\S+) %\)"*bool(one.value)
    yield Line(rf"^{re.escape(words)}: (\S+)", f"{words}: value", lambda w: None if one.value is None else scale*one.value)
    yield Line(rf"{start}the program leaves open: median (\S+), (\S+) to (\S+){of_value}$", f"{words}: median, range, range [%]",
               lambda w: [*(scale*x for x in (one.median, one.low, one.high)), *shares(one.low, one.high)])
    yield Line(rf"{start}with inputs: (\S+) to (\S+){of_value}$", f"{words}: range with inputs, range [%]",
               lambda w: [*(scale*x for x in (one.low_inputs, one.high_inputs)), *shares(one.low_inputs, one.high_inputs)])
    if re.search(rf"{start}run and twins: ", text, re.MULTILINE):
        own = [x for x in (one.value, *one.twins) if x is not None]
        yield Line(rf"{start}run and twins: median (\S+), (\S+) to (\S+); (\d+) of 9 have it$", f"{words}: twins", lambda w: (
            *(Known(scale*x, 0.0, chaotic=True) for x in (np.median(own), min(own), max(own))), len(own)))
    sizes = {cause: abs(x) for cause, x in one.causes.items() if x is not None and x}
    small = [x for x in sizes.values() if x < 0.01*max(sizes.values())]
    for cause, size in sizes.items():
        if size not in small:
            yield Line(rf"{start}causes: (?:.*; )?{re.escape(cause)}: (\S+) %", f"{words}: {cause} [%]",
                       lambda w, x=one.causes[cause]: 100*x/abs(one.value))
    if small:
        yield Line(rf"{start}causes: .*; others: up to (\S+) %$", f"{words}: other causes [%]",
                   lambda w: 100*sum(small)/abs(one.value))


def lines_of_variables(world: World, title: str, text: str) -> list[Line]:
    """The defaults are those of a case."""
    case = ldbench.Case()
    lines = []
    for group, block in re.findall(r"^&(\w+)\n((?:  .*\n)+)", text, re.MULTILINE):
        lines += [Line(rf"^&{group}\n(?:  .*\n)*?  {name} = (\S+)", f"default of {name}",
                       lambda w, name=f"{group}_{name}": float(getattr(case, name)))
                  for name in re.findall(r"^  (\w+) = [-\d]", block, re.MULTILINE)]
    assert len(lines) > 30
    return lines


COMMANDS = [
    Row("profile", lambda world, folder: {"words": told_pair().words, "json": told_pair().json}, lines_of_profile, [
        r"CRC-32 [0-9A-F]{8}", r"below \S+ mm", r"conicity at [234] mm", r"nonlinearity parameter \[1/mm\]", "in a curve of 300 m",
        r"(?:contact|roll) angle parameter at 3 mm", "EN 15302", r"^  (?:left|right) zone of the flange: .*$",
        # test_en15302 computes what is beyond the taper of the treads.
        r"^pair\.conicity\..*\.(?:9\d|\d{3}) = .*$", r"^pair\.conicity\..*\.amplitude\.\d+ = .*$",
        r"^pair\.conicity\..*rolling_radii_coefficient = .*$", r"^pair\.zones\..*\.(?:y_first|y_last|angle) = .*$"]),
    Row("compare", compared, lines_of_comparison, [r"\bex\d_aw\b", r"\d+ more impacts", r"\d+ impacts have fewer than 6 rows",
                                                   r"^difference\.\w+\.unit = .*$"]),
    Row("study", lambda world, folder: dict(zip(("summary", "curves"), map(words_of, study(world)[1]), strict=True)) | {
        "csv": study(world)[2]}, lines_of_study, [
            r"steps? (?:of )?0\.1 ms", r"exercise 5 cut short", r"\bex\d_aw\b", r"^Exercise \d"]),
    Row("score", lambda world, folder: scored(world)[0], lines_of_scores, [
        "^ex2_aw.txt: exercise 2, actual profiles", "a file of exercise 2", r"^files\.0\.scores\.\d+\.(?:reference|value) = .*$",
        ]),
    Row("check", findings, lines_of_findings, [
        r"exercise 2, actual", r"about \S+ times what", r"\S+ times the integral", r"of \d+ rows",
        r"^findings\.\d+\.(?:number|limit|row) = .*$"]),
    Row("fingerprint", lambda world, folder: fingerprints(world), lines_of_fingerprint, [
        r"in 2 blows|\(2 blows", r"^files\.0\.\w+\.uncertainty = .*$"]),
    Row("submit", lambda world, folder: {"": said("submit", world.outputs, status=1)}, lines_of_parcel,
        [r"^ex\d_[as]w: .*$", r"\S+ times the integral"]),
    Row("ensemble and store", members, lines_of_members, [r"^  [0-9a-f]{12}  \S+  "]),
    Row("bodies", lambda world, folder: {"words": rail_body()[0], "json": rail_body()[1]}, lines_of_bodies,
        [r"\b\d\d on \d\d?\b(?! =)"]),
    Row("trust", trusted, lines_of_trust, [
        r"^ex2_aw: .*$", r"\+ 1 %|\+ 0\.1 mm|within 3 µm|table accuracy 0\.00\d", r"^answers\.\w+\.values\.\d+ = .*$"]),
    Row("variables", lambda world, folder: {"": said("variables")}, lines_of_variables,
        [r"   a number from .*$|   a whole number from .*$|   an? .*$", r"^      .*$"]),      # test_inputs tries the ranges
]
