"""The rows of the walk over words: every text, JSON and CSV in which a user reads numbers, and which quantity each number is."""
from __future__ import annotations

import io
import json
import re
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from matplotlib.figure import Figure
from pypdf import PdfReader
from scipy.integrate import trapezoid

import ldbench
import table
from browser import facts
from ldbench import ContactTable
from ldbench.__main__ import main
from ldbench.plots.figures import overview_figures
from ldbench.plots.style import ldbench_style
from probes import turned
from raw import Raw
from reading import Known, Line, csv_text, places, told_text, words_of
from running import HANG, LDBENCH
from specimen import World
from table import CLEARANCE, DEG, FULLNESS, KN, MM, PRESSED, RESULTS, WORDS, known, patches, unit_of

NAMES = "ex2_aw", "ex5_aw"
NUMBER = r"(\S+)"
FORMULATIONS = "Elastic contact or constraint equations: "


class Row(NamedTuple):
    """A place where a user reads numbers."""

    what: str
    texts: Callable[[World, Path], Mapping[str, str]]       # by their titles; from the specimen, with files in a folder
    lines: Callable[[World, str, str], list[Line]]          # of a title and its text
    labels: Sequence[str] = ()                              # what has numbers that are none of a run


def printed(*words: object, status: int = 0) -> str:
    """What a command prints."""
    with redirect_stdout(io.StringIO()) as out:
        assert main([str(word) for word in words]) == status, words
    return out.getvalue()


def said(*words: object, status: int = 0) -> str:
    """What a command prints, JSON as lines of numbers."""
    text = printed(*words, status=status)
    return told_text(json.loads(text)) if "--json" in words else text


def by_title(pages: Sequence[tuple[str, Figure]]) -> dict[str, str]:
    return {title: words_of(figure) for title, figure in pages}


# Results of a run --------------------------------------------------------------------------

def summary(name: str, world: World, folder: Path) -> dict[str, str]:
    """What the executable prints of a case that it runs; of the ramp, what the run keeps of that."""
    if name == "ex5_aw":
        return {"": world.run(name).text}
    text = (world.folder/f"inputs/{name}.nml").read_text().replace("'outputs/", f"'{folder}/")
    (folder/"case.nml").write_text(text)
    done = subprocess.run([LDBENCH, folder/"case.nml"], capture_output=True, text=True, cwd=world.folder, timeout=HANG)
    assert done.returncode == 0, done.stderr
    return {"": done.stdout}


def results(name: str, world: World, folder: Path) -> dict[str, str]:
    """The entries of &results with their units, and the events."""
    text = world.raw(name).results
    entries = re.findall(r"^#   (\w+) = ([^!\n,]+?)(?:, ([^!\n]+?))?(?:  ! ([^,\n]+)(?:,.*)?)?$", text, re.MULTILINE)
    found = "".join(f"{key}{'.rms' if more else ''}{f' [{unit}]'.replace(' s]', '.s]') if unit else ''} = {number}\n"
                    + (f"{key}.largest = {more}\n" if more else "") for key, number, more, unit in entries if number[0] != "'")
    return {"": found + "".join(f"event.{k}.{key} = {number}\n" for k, key, number in re.findall(
        r"event\((\d+)\)%(\w+) = ([^',\s]+)", text))}


def event(raw: Raw, match: re.Match[str]) -> Known:
    """A number of an event: its time is one at which the rows show a change of its kind, with force and angle of that row."""
    t, kind, _ = raw.events[int(match[1]) - 1]
    times = raw.changes(kind)
    when = times[np.abs(times - t).argmin()]
    k, side = int(np.abs(raw.t - when).argmin()), kind[0].upper()
    if match[2] == "t":
        return Known(when, 5e-9, 1.3e-7)        # the row of a change is the first one that shows it, up to 128 ns later
    if match[2] == "force":
        return Known(raw.c["F_ext"][k] + raw.setting("lateral_ramp")*(t - raw.t[k]))
    angles = raw.c[f"angle_{side}F"][k:]
    return Known(abs(angles[np.isfinite(angles)][0]), 0.03)


def lines_of_results(name: str, world: World, title: str, text: str) -> list[Line]:
    raw = world.raw(name)
    return places(text, {**{rf"{key}{re.escape(unit_of(key))}": one for key, one in known(raw).items()},
                         r"event\.(\d+)\.(t|force|angle)": partial(event, raw)})


def run_json(name: str, world: World, folder: Path) -> dict[str, str]:
    file = folder/f"{name}.txt"
    return {str(file): said("run", f"inputs/{name}.nml", "-o", file, "--json", "-q")}


def lines_of_run(world: World, title: str, text: str) -> list[Line]:
    """Results and events of the rows that the run has written; what did not happen is null; the file has what no row tells."""
    raw = Raw(Path(title))

    def of_event(match: re.Match[str]) -> Known:
        t, _, more = raw.events[int(match[1])]
        return Known({"t": t, "loss": 0.0}.get(match[2], more.get(match[2])))

    return places(text, {
        **of_place(raw), **known(raw), r"frequency_(\d)": lambda m: raw.settings("eigenfrequencies")[int(m[1]) - 1],
        r"rest_\w+": lambda m: raw.setting(m[0]), r"(?:t_)?peak_P_\w\w|lost|n_impact|n_rail_pulls": 0.0,      # of rigid contacts
        r"events\.(\d+)\.(\w+)": of_event,
        r"(?!seconds)\w+": lambda m: raw.result(m[0]) if f" {m[0]} = " in raw.results else None})


def of_place(raw: Raw) -> dict[str, Known]:
    """What the core knows of the place of the wheelset before the run: clearances of the call, equilibrium."""
    return {"clearance_left": Known(CLEARANCE[0]/MM, 1e-3), "clearance_right": Known(CLEARANCE[1]/MM, 1e-3),
            "axle_height": Known(raw.setting("axle_height")), "axle_roll": Known(raw.setting("axle_roll"))}


def lines_of_table(world: World, title: str, text: str) -> list[Line]:
    """Place, load and errors as in the head of the column file; the axle sinks by what wheels and rails overlap."""
    raw = world.thrown
    if title == "json":
        return places(text, {
            **of_place(raw), "sinking": Known(raw.sinking, 5e-3), "load_per_wheel": raw.weight/2,
            r"frequencies\.(\d)": lambda m: raw.settings("eigenfrequencies")[int(m[1])],
            r"error\.(\w+)\.(rms|largest)": lambda m: raw.errors()[m[1]][m[2] == "largest"],
            r"solutions\.not_converged": 0})
    found, step = ContactTable("inputs/ex2_aw.nml"), 1e-7
    up, down = (found.force(0.0, found.equilibrium + way*step, 0.0)[1] for way in (1, -1))
    return [
        Line(r"left (\S+), right (\S+)$", "clearances [mm]", lambda w: CLEARANCE, 1e-3),
        Line(r"axle (\S+) m above", "height of the axle [m]", lambda w: raw.setting("axle_height")),
        Line(r"rails, (\S+) mm lower", "sinking of the axle [mm]", lambda w: MM*raw.sinking, 5e-3),
        Line(r"(\S+) kN per wheel", "load of a wheel [kN]", lambda w: KN*raw.weight/2),
        Line(r"vertical stiffness (\S+) kN/mm", "by how much the rails push more when the resting wheelset is lowered [kN/mm]",
             lambda w: 1e-6*(down - up)/(2*step), 1e-3),
        *(Line(rf"force, {place.replace('_', ' ')}: rms (\S+), largest (\S+) of", f"errors of the force, {place}",
               lambda w, both=both: both) for place, both in raw.errors().items())]


@cache
def rigid(world: World) -> tuple[ldbench.Run, Raw]:
    """The thrown wheelset with rigid contacts, in memory and as a file."""
    case = ldbench.Case.from_namelist(world.folder/"inputs/ex2_aw.nml")
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.chdir(world.folder)
        run = ldbench.run(case.replace(table_folder="", **CHANGES["unilateral, e = 0.5"]))
        return run, Raw(Path(run.write(Path(folder)/"run.txt")))


def dataset(world: World, folder: Path) -> dict[str, str]:
    """The events of the Dataset of xarray, with impulses of contacts by their names."""
    found = rigid(world)[0].to_xarray()
    names = {f"event_{name}": name for name in ("time", "angle", "loss")}
    told = {"events": [{**{name: float(found[key][k]) for key, name in names.items()},
                        **{contact: float(found.event_impulse.sel(contact=contact)[k]) for contact in WORDS}}
                       for k in range(found.sizes["event"])]}
    return {"": told_text(told).replace(" = nan", " = –")}


def lines_of_dataset(world: World, title: str, text: str) -> list[Line]:
    """Times, angles and losses of the file's events; by how much the impulses of the rows jump there."""
    raw = rigid(world)[1]

    def of_event(match: re.Match[str]) -> Known:
        t, kind, more = raw.events[int(match[1])]
        if match[2] in WORDS and kind != "impact":
            return Known(0.0)
        if match[2] in WORDS:
            jump = raw.c[f"P_{match[2]}"][np.abs(raw.t - t) < 2e-9 + 1e-8*t]
            return Known(np.ptp(jump), 1e-6, 1e-4)           # rows have nine digits
        return Known(t if match[2] == "time" else more.get(match[2], {"loss": 0.0}.get(match[2])))

    return places(text, {r"events\.(\d+)\.(\w+)": of_event})


# Tables of results -------------------------------------------------------------------------

@cache
def csv_of(world: World) -> dict[str, dict[str, float | None]]:
    """The numbers of summary.csv by case and row, then by their names."""
    found: dict[str, dict[str, float | None]] = {}
    for line in csv_text(world.outputs/"summary.csv", "case", "of").splitlines():
        place, _, number = line.rpartition(" = ")
        case, of, key = place.split(".", 2)
        found.setdefault(f"{case}.{of}", {})[key.partition(" ")[0]] = None if number == "–" else float(number)
    return found


def twins_of(world: World, name: str) -> list[dict[str, Any]]:
    """The results of a run and of its twins, as the report keeps them beside summary.csv; the run's own are those of the table."""
    return [csv_of(world)[f"{name}.run"], *json.loads((world.outputs/f".ldbench/{name}_twins.json").read_text())]


def lines_of_csv(world: World, title: str, text: str) -> list[Line]:
    """In SI, under names with their units. Least, median and largest are those of the run and its twins that have the result."""
    def of_run(match: re.Match[str]) -> Known | float | None:
        raw, key = world.raw(match[1]), match[2].partition(" ")[0]
        assert match[2] == key + unit_of(key), match[2]
        contact = key.rpartition("_")[2]
        if key in (f"pmax_{contact}", f"patch_{contact}") and contact in WORDS:
            k, own = raw.first_peak(contact), csv_of(world)[f"{match[1]}.run"]
            return None if k is None else patches(raw, contact, k, own[f"pmax_{contact}"], own[f"patch_{contact}"])[key[1] == "a"]
        if key == "exercise":
            return float(match[1][2])
        one = known(raw).get(key) or (raw.result(key) if key in table.BEYOND_ROWS else None)
        return None if isinstance(one, Known) and not one.value and key[:6] in ("peak_N", "t_peak") else one

    def of_twins(match: re.Match[str]) -> Known | float | None:
        key = match[3].partition(" ")[0]
        own = [one[key] for one in twins_of(world, match[1]) if one.get(key) is not None and not isinstance(one[key], str)]
        if key in ("pmax_contact", "end"):
            return None
        if match[2] == "having":
            return float(len(own))
        return {"median": np.median, "least": np.min, "largest": np.max}[match[2]](own) if own else None

    return places(text, {r"(\w+)\.run\.(.*)": of_run, r"(\w+)\.\w+\.exercise": lambda m: float(m[1][2]),
                         r"(\w+)\.(\w+)\.(.*)": of_twins})


def chaotic(world: World, name: str, key: str) -> tuple[float, float, float] | None:
    """Least, median and largest of a result in summary.csv [SI], where one is a thousandth off the median."""
    least, median, largest = (csv_of(world)[f"{name}.{of}"][key] for of in ("least", "median", "largest"))
    if None in (least, median, largest) or key in ("drift", "drift_relative", "step"):
        return None
    start = 6e-6 if key in ("farthest_left", "farthest_right") else 0.0       # by which the starts themselves differ
    return (least, median, largest) if max(largest - median, median - least) > 1e-3*abs(median) + start else None


def row_of_results(world: World, words: str, key: str, scale: float) -> Line:
    """A result of both runs in a table, with the ranges of chaotic ones in lines below."""
    cells, ends = [], []
    for name in NAMES:
        spread = chaotic(world, name, key)
        # The end of a run that derails is not an extreme pose.
        if ended := key.startswith(("farthest_", "largest_roll", "smallest_roll")) and name == "ex5_aw":
            spread = None
        one = known(world.raw(name)).get(key) or Known(csv_of(world)[f"{name}.run"][key])
        nothing = ended or (not one.value and key.startswith("peak_N"))
        cells.append(Known(None) if nothing else Known(spread[1], chaotic=True).of(scale) if spread else one.of(scale))
        ends += [Known(x, chaotic=True).of(scale) for x in spread[::2]] if spread else []
    below = r"\s(\S+?)[–…](\S+?)(?:, \d of \d)?"*(len(ends)//2)
    return Line(rf"(?:^|(?<=\s)){re.escape(words)} (\S+) (\S+){below}(?=\s|$)", f"{words}: {key}", lambda w: [*cells, *ends])


def table_of_results(label: str, world: World, title: str, text: str) -> list[Line]:
    """The results of RESULTS under their words of a table, and the pressures and patches of first contacts."""
    shown = {getattr(one, label): (key, one.scale) for key, one in RESULTS.items() if getattr(one, label)}
    for contact, (pressure, area) in PRESSED.items():
        if label == "words":
            shown |= {pressure: (f"pmax_{contact}", 1e-6), area: (f"patch_{contact}", 1e6)}
        elif label == "brief" or contact == "LF":
            shown[f"peak pressure, {WORDS[contact]} [MPa]"] = f"pmax_{contact}", 1e-6
    return [row_of_results(world, words, *one) for words, one in shown.items()]


@cache
def kept_trust(world: World) -> dict[str, Any]:
    """What the report has kept of the variations of its case that ends with a return."""
    found, = json.loads(next(world.outputs.rglob("trust.json")).read_text())
    return found


def of_bodies(world: World, answer: str) -> list[float]:
    """An answer of the thrown wheelset with wheel and rail as bodies, least and largest [SI]."""
    told = kept_trust(world)
    own = [x for one, x in zip(told["variations"], told["answers"][answer]["values"], strict=True) if one["kind"] == "bodies" and x]
    return [min(own), max(own)] if own else []


BESIDE = "peak N, first contact, left flange [kN], wheel and rail as bodies"


def page_table(world: World, folder: Path) -> dict[str, str]:
    """The table of the page of all runs, and the moments that a click on its numbers opens."""
    lines = []
    for row in facts(world.outputs/"ldbench_results.html")["summary"]:
        assert [cell["run"] for cell in row["cells"]] == [*NAMES]
        parts = [re.fullmatch(r"(\S+(?: to \S+)?)(?: \((\S+) to ([^\s,]+).*\))?", cell["text"]) for cell in row["cells"]]
        lines += [f"{row['words']} {' '.join(part[1] for part in parts)}", *(f"{part[2]}–{part[3]}" for part in parts if part[2])]
        moments = ["–" if cell["t"] is None else repr(cell["t"]) for cell in row["cells"]]
        lines.append(f"{row['words']}: moments {' '.join(moments)}")
    return {"": "\n".join(lines) + "\n"}


def moment_of(raw: Raw, key: str) -> Known:
    """When a result was, which is what a click on it opens."""
    contact = key.rpartition("_")[2]
    name = {"first_duration": "t_first_", "first_impulse": "t_first_", "first_peak_N": "t_first_peak_", "pmax": "t_first_peak_",
            "patch": "t_first_peak_", "approach": "t_first_peak_", "peak_N": "t_peak_"}.get(key.removesuffix(f"_{contact}"), "")
    told, ended = known(raw), key.startswith(("farthest_", "largest_roll", "smallest_roll")) and table.end_of_ramp(raw)
    if key in ("pmax", "drift"):
        return Known(raw.result(f"t_{key}"))
    if ended or (name == "t_peak_" and not raw.peak(contact)[0]):
        return Known(None)
    return told.get(key if key.startswith("t_") else name + contact if name else f"t_{key.removeprefix('F_')}") or Known(None)


def lines_of_page_table(world: World, title: str, text: str) -> list[Line]:
    least, largest = (KN*x for x in of_bodies(world, "first_peak_N_LF"))
    keys = {one.words: key for key, one in RESULTS.items()} | {
        words: f"{name}_{c}" for c, both in PRESSED.items() for name, words in zip(("pmax", "patch"), both, strict=True)}
    return [*table_of_results("words", world, title, text),
            Line(rf"^{re.escape(BESIDE)} (\S+) to (\S+) –$", "peak with bodies [kN]: of the thrown wheelset",
                 lambda w: (least, largest)),
            Line(rf"^{re.escape(BESIDE)}: moments (\S+) (\S+)$", "no moment", lambda w: (None, None)),
            *(Line(rf"^{re.escape(words)}: moments (\S+) (\S+)$", f"moment of {key} [s]",
                   lambda w, key=key: [moment_of(w.raw(name), key) for name in NAMES])
              for words, key in keys.items() if words != RESULTS["step"].words)]


def page_facts(world: World, folder: Path) -> dict[str, str]:
    """What the page of a run says of its clearance, events, peaks and pressures."""
    shown = "clearance", "firstFlange", "opens", "hardest", "events", "unlisted", "pressure"
    return {one["name"]: told_text({key: one[key] for key in shown} | {"rows": one["index"]["rows"]})
            for one in facts(world.outputs/"ldbench_results.html")["runs"]}


def lines_of_facts(world: World, title: str, text: str) -> list[Line]:
    raw, told = world.raw(title), known(world.raw(title))
    shown, = (one for one in facts(world.outputs/"ldbench_results.html")["runs"] if one["name"] == title)

    def of_event(match: re.Match[str]) -> Known:
        """Events of the file and, between them, the largest force of each contact."""
        one = shown["events"][int(match[1])]
        words = one["what"].removeprefix("largest normal force, ")
        if words != one["what"]:
            contact = next(c for c, own in WORDS.items() if own == words)
            return {"t": told[f"t_peak_{contact}"], "peak": told[f"peak_N_{contact}"], "force": Known(None)}[match[2]]
        if one["what"].startswith("largest pressure, "):
            return Known({"t": raw.result("t_pmax"), "pressure": raw.result("pmax"), "force": None}[match[2]])
        mine = min((e for e in raw.events if e[1] == one["what"]), key=lambda e: abs(e[0] - one["t"]))
        return Known(mine[0] if match[2] == "t" else mine[2].get(match[2]))

    def of_patch(match: re.Match[str]) -> Known:
        one = shown["pressure"][int(match[1])]
        k, patch = int(np.abs(raw.t - one["t"]).argmin()), one["patches"][int(match[2])]
        return Known(raw.c[f"N_{patch['c']}"][k]/(patch["pmax"]*patch["area"])*patch[match[3]]/FULLNESS[0], 0.1)

    def left_out(match: re.Match[str]) -> int:
        """Events of a kind that the list does not have."""
        listed = sum(one["what"] == match[1] for one in shown["events"])
        return int(raw.result(f"n_{match[1].replace(' ', '_').replace('-', '_')}")) - listed

    return places(text, {
        r"clearance\.(\d)": lambda m: Known(CLEARANCE[int(m[1])]/MM, 1e-3), "firstFlange": told["t_first_LF"],
        "opens": told["t_first_peak_LF"], r"hardest\.p": raw.result("pmax"), r"hardest\.t": raw.result("t_pmax"),
        r"hardest\.([yz])": lambda m: raw.result(f"pmax_{m[1]}"), r"events\.(\d+)\.(\w+)": of_event, r"unlisted\.(.*)": left_out,
        r"pressure\.(\d+)\.t": lambda m: Known(raw.t[np.abs(raw.t - shown["pressure"][int(m[1])]["t"]).argmin()], 1e-8, 1e-9),
        r"pressure\.(\d+)\.patches\.(\d+)\.(pmax|area)": of_patch, "rows": len(raw.t)})


def abstract(world: World, folder: Path) -> dict[str, str]:
    """In one line, for the text of a PDF is broken into lines anywhere."""
    return {"": " ".join(" ".join(page.extract_text() for page in PdfReader(world.outputs/"ldbench_abstract.pdf").pages).split())}


BODIES = {"peak N, first contact, left flange": "first_peak_N_LF", "duration, first contact, left flange": "first_duration_LF",
          "impulse, first contact, left flange": "first_impulse_LF", "first right flange contact": "t_first_RF",
          "return to the centre": "t_return", "first peak of the left flange by": "first_peak_N_LF",
          "its impulse by": "first_impulse_LF", "static limit of the lateral force by": "F_limit_left"}


def changed_by_bodies(world: World, text: str) -> Iterator[Line]:
    """By how much the answers of the one run with bodies change [%]: least and largest, one number where both are written alike, or
    a dash where the twins do not share the answer."""
    told = kept_trust(world)
    for words, name in BODIES.items():
        value, found = told["answers"][name]["value"], told["answers"][name]["values"]
        twins = [x for one, x in zip(told["variations"], found, strict=True) if one["kind"] == "twin" and x is not None]
        own = of_bodies(world, name)
        shared = bool(value and own) and max(abs(x/value - 1) for x in twins) <= 1e-3
        change = [100*(x/value - 1) for x in own] if shared else [None]*2
        both = bool(re.search(rf"{words} [^\s\[]+ to ", text))
        yield Line(rf"{words} (?!\[)(\S+)" + r" to (\S+)"*both, f"{words}: by bodies [%]", lambda w, x=change[:1 + both]: x)


def lines_of_abstract(world: World, title: str, text: str) -> list[Line]:
    def spread(x: list[float]) -> float:
        return 100*max(abs(one/x[0] - 1) for one in x[1:])

    def shown(words: str, exercise: int = 2) -> list[float]:
        return shown_values(world, words, exercise)

    back, force = shown("return to the centre"), shown("lateral force at derailment", 5)
    lines = [*table.ABSTRACT, *changed_by_bodies(world, text),
             Line(r"agrees within about (\S+) %", "first contacts [%]",
                  lambda w: max(spread(shown("first left flange contact", k)) for k in (2, 5)), 0.02),       # from four digits
             Line(r"this contact differs by up to (\S+) %", "impulses [%]",
                  lambda w: spread(shown("impulse until the wheelset moves back, left flange"))),
             Line(r"lateral force of (\S+) kN \(ex5_aw\) on", "a rail pulls [kN]",
                  lambda w: shown("lateral force from which a rail pulls", 5)[1]),
             Line(r"ex2_aw (\S+) s (\S+) s does not return does not return does not return", "returns [s]", lambda w: back[:2]),
             Line(r"overturns, (\S+) kN does not derail overturns, (\S+) kN overturns, (\S+) kN overturns, (\S+) kN", "forces [kN]",
                  lambda w: [force[k] for k in (0, 2, 3, 4)])]
    return [*table_of_results("short", world, title, text), *lines]


# Pages of runs -----------------------------------------------------------------------------

def pages(name: str, world: World, folder: Path) -> dict[str, str]:
    found = world.sheets(f"Exercise {name[2]}, actual profiles (left), simplified profiles (right): ")
    assert len(found) == (6 if name == "ex2_aw" else 8)
    return found


def lines_of_pages(name: str, world: World, title: str, text: str) -> list[Line]:
    """Settings of the case and numbers of the rows; forces and angles above the cross-sections of the impacts."""
    raw, lines = world.raw(name), table.words_of_a_page(world.raw(name), text)
    if "impacts of flanges" in title:
        for at in table.pictured(raw):
            for side in "left", "right":
                closed = [(part, f"{side[0].upper()}{part[0].upper()}") for part in ("tread", "flange")
                          if raw.c[f"N_{side[0].upper()}{part[0].upper()}"][at] > 0]
                words = ", ".join(rf"{part} (\S+) kN at (\S+)°" for part, _ in closed) or "no contact"
                start = rf"^t = {raw.t[at]:.4f} s: .*\n(?:(?!t = ).*\n)*?"
                lines.append(Line(f"{start}{side}: {words}$", f"{side}: force [kN], angle [deg]",
                                  lambda w, closed=closed, at=at: [x for _, c in closed for x in (
                                      KN*raw.c[f"N_{c}"][at], DEG*abs(raw.c[f"angle_{c}"][at]))]))
    return lines


# Formulations ------------------------------------------------------------------------------

CHANGES = {"bilateral": {"formulation": "bilateral"}, **{f"unilateral, e = {e:g}": {"formulation": "unilateral", "restitution": e}
                                                         for e in (1.0, 0.5, 0.0)}}


@cache
def formulations(world: World) -> dict[str, Raw]:
    """Runs of both cases in each formulation and, without a ramp, of the wheelset that rolls over its flange."""
    made = {f"{name} elastic": world.raw(name) for name in NAMES}
    with pytest.MonkeyPatch.context() as patch, tempfile.TemporaryDirectory() as folder:
        patch.chdir(world.folder)

        def raw(case: ldbench.Case, **changes: object) -> Raw:
            found = Raw(Path(ldbench.run(case.replace(table_folder="", **changes)).write(Path(folder)/"run.txt")))
            found.rounding = 1e-8           # pages have the core's numbers, of which the file has nine digits
            return found

        cases = {name: ldbench.Case.from_namelist(f"inputs/{name}.nml") for name in NAMES}
        rare = {"ex2_aw": {}, "ex5_aw": {"interval": 5e-3, "dt": 1e-3}}
        made |= {f"{name} {words}": raw(case, **changes, **rare[name]) for name, case in cases.items()
                 for words, changes in CHANGES.items()}
        made["over the flange, aw"] = raw(cases["ex5_aw"], **CHANGES["bilateral"], vY=2.5, lateral_ramp=0.0, interval=2e-5, dt=2e-5,
                                          t_end=0.1)
    return made


def impulse_of(raw: Raw) -> float:
    """Impulse of forces and impacts on the left flange, from the first touch until the wheelset moves back [N s]."""
    blows = raw.c.get("P_LF", np.zeros(len(raw.t)))
    touched = int(np.argmax((raw.c["N_LF"] > 1) | (blows > 0)))
    end = touched + int(np.argmax(raw.c["vY"][touched:] < 0))
    until = [float(trapezoid(raw.c["N_LF"][:k + 1], raw.t[:k + 1]) + blows[k]) for k in (end - 1, end)]
    return until[1] if blows[end] > blows[end - 1] else float(np.interp(0.0, -raw.c["vY"][end - 1:end + 1], until))


def of_formulation(raw: Raw) -> dict[str, Known | None]:
    """The values of a run by the words of the page. Rows of rigid contacts on the ramp are rare: there the core tells lift-offs."""
    blows, returned, ramp = raw.c.get("P_LF", np.zeros(len(raw.t))), len(raw.passages()) > 1, raw.setting("lateral_ramp") > 0
    rigid, derailed = "P_LF" in raw.c or raw.c["N_LT"].min() < -1, ramp and "end = 'derailment'" in raw.results
    pulls = int(np.argmax(raw.c["N_RT"] < -1)) if raw.c["N_RT"].min() < -1 else 0
    found = {
        "first left flange contact [s]": Known(table.first_touch(raw, "LF"), 0.0, 5e-3*(rigid and ramp)),
        "largest Y [mm]": Known(MM*raw.extreme("Y", 1), 2e-3), "largest Z [mm]": Known(MM*raw.c["Z"].max(), 2e-3),
        # A force of rigid contacts that jumps by 200 kN between rows of 0.2 ms leaves 20 N·s of 1.6 kN·s open.
        "impulse until the wheelset moves back, left flange [kN·s]": None if ramp else Known(KN*impulse_of(raw), 0.013),
        "peak N, left flange [kN]": Known(KN*raw.peak("LF")[0] or None, 1e-5 + 0.05*(rigid and ramp)),
        "largest impulse, left flange [kN·s]": Known(KN*np.diff(blows).max() or None, 1e-5 + 0.05*ramp),
        "first right flange contact [s]": Known(table.first_touch(raw, "RF")),
        "return to the centre [s]": Known(raw.passages()[-1] if returned else None, 1e-5),
        "lift-offs of both wheels": Known(raw.lift_offs("L") + raw.lift_offs("R") if not rigid else sum(
            raw.result(f"n_{side}_wheel_lift_off") for side in ("left", "right"))),
        "energy lost [J]": Known(raw.c["E_lost"][-1] if "E_lost" in raw.c else 0.0, 1e-5),
        "derailment [s]": Known(raw.t[-1] if derailed else None, 5e-4),
        "lateral force at derailment [kN]": Known(KN*raw.c["F_ext"][-1] if derailed else None, 5e-4),
        "lateral force from which a rail pulls [kN]": Known(KN*raw.c["F_ext"][pulls] if ramp and pulls else None, 0.02)}
    return {words: one._replace(value=None) if one and one.value is not None and np.isinf(one.value) else one
            for words, one in found.items()}


def lines_of_values(world: World, title: str, text: str) -> list[Line]:
    """The page of values: each from the rows of a run of that formulation."""
    lines = []
    for name in NAMES:
        truths = [of_formulation(raw) for words, raw in formulations(world).items() if words.startswith(name)]
        block = text.split("\nExercise 5 ")[name == "ex5_aw"]
        for words in truths[0]:
            if re.search(rf"^{re.escape(words)} .*$", block, re.MULTILINE):
                start = rf"^Exercise {name[2]} (?:(?!Exercise).*\n)*?{re.escape(words)}"
                lines.append(Line(start + 5*r" (\S+)" + "$", f"{name}: {words}", lambda w, own=[one[words] for one in truths]: own))
    return lines


def shown_values(world: World, words: str, exercise: int) -> list[float]:
    """A row of the page of values by formulation, which has a row of its own in this table; NaN for dashes."""
    text = world.sheets(FORMULATIONS)["values"].split("\nExercise 5 ")[exercise == 5]
    found = re.search(rf"^{re.escape(words)}(?: \[.*\])? ([-\d.–]+(?: [-\d.–]+){{4}})$", text, re.MULTILINE)
    return [float("nan" if cell == "–" else cell) for cell in found[1].split(" ")] if found else [np.nan]*5


def lines_of_verdicts(world: World, title: str, text: str) -> list[Line]:
    """How much results depend on the formulation, from the page of values."""
    lines = []
    for words in ("first left flange contact", "largest Y", "largest Z", "impulse until the wheelset moves back, left flange",
                  "first right flange contact", "return to the centre", "derailment", "lateral force at derailment"):
        shown = [np.array(shown_values(world, words, exercise)) for exercise in (2, 5)]
        known = [np.isfinite(one[0]) and np.isfinite(one[1:]).any() for one in shown]
        shares = [100*np.nanmax(np.abs(one[1:]/one[0] - 1)) for one, there in zip(shown, known, strict=True) if there]
        parts = [(r"(\S+) %" + ("" if np.isfinite(one).all() else r" \*")) if there else "–"
                 for one, there in zip(shown, known, strict=True)]
        # The values beside have four digits, which is up to 0.1 % of their ratio.
        slack = max(2e-3, *(0.1/share for share in shares if share > 0))
        # Below it stand the elastic value and the farthest one.
        factor = 1e3 if "contact" in words or "return" in words else 1
        pairs = [factor*x for one, there in zip(shown, known, strict=True) if there for x in (
            one[0], one[1 + int(np.nanargmax(np.abs(one[1:] - one[0])))])]
        both = " ".join(r"(\S+) / (\S+)" for there in known if there)
        lines.append(Line(rf"^{words} {' '.join(parts)}\n +elastic / farthest \[\S+\] {both} ?$", f"{words} [%], values",
                          lambda w, shares=shares, pairs=pairs: [*shares, *pairs], slack))
    hops = [shown_values(world, "lift-offs of both wheels", exercise) for exercise in (2, 5)]
    return [*lines, Line(r"^lift-offs of both wheels (\d+) to (\d+) (\d+) to (\d+)$", "fewest and most lift-offs",
                         lambda w: [end(x) for x in hops for end in (min, max)])]


# Pressure ----------------------------------------------------------------------------------

def pressure(contact: str, world: World, folder: Path) -> dict[str, str]:
    """The numbers of a patch in words, as JSON, and on its page."""
    raw, drawn = world.thrown, []
    words = "pressure", raw.file, "--at", f"{raw.t[raw.first_peak(contact)]:.9g}", "--contact", contact, "-o", folder/"pressure.pdf"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench.plots.pressure_page.save_sheets", lambda sheets, target: drawn.extend(sheets))
        found = {"words": said(*words), "json": said(*words, "--json", "-q")}
    return {**found, "page": words_of(drawn[0])}


def lines_of_pressure(contact: str, world: World, title: str, text: str) -> list[Line]:
    """Force, place and angle are those of the columns, the approach is the overlap, the rest goes with them as in an ellipse."""
    raw, k = world.thrown, world.thrown.first_peak(contact)
    force, angle, overlap = raw.c[f"N_{contact}"][k], abs(raw.c[f"angle_{contact}"][k]), Known(raw.overlap(contact, k), 4e-3)
    place = raw.c[f"y_{contact}"][k], raw.c[f"z_{contact}"][k]

    def number(pattern: str, *more: str) -> float | list[float]:
        found = re.search(pattern, text, re.MULTILINE).groups()
        return float(found[0]) if len(found) == 1 else [*map(float, found)]

    if title == "json":
        one = {key: float(x) for key, x in re.findall(r"^patches\.0\.(\S+) = (.*)$", text, re.MULTILINE)}
        side, whole = {"L": 1, "R": -1}[contact[0]], np.pi*one["half_x"]*one["half_s"]
        # The place as the wheel has it, seen from the centre of the axle.
        away = np.array(place)*[side, 1] - [side*raw.c["Y"][k], raw.setting("axle_height") + raw.c["Z"][k]]
        in_wheel, = turned(away[None], -side*(raw.c["roll"][k] + raw.setting("axle_roll")))
        largest, area = patches(raw, contact, k, one["largest"], one["area"])
        truths = {
            "force": force, "integral": Known(force, 0.04), "largest": largest, "mean": Known(force/one["area"], 0.04),
            "angle": angle, "approach": overlap, "area": area, "energy": Known(0.4*force*overlap.value, 0.1),
            r"centre\.([01])": lambda m: Known(place[int(m[1])], 2e-3, 2e-4),
            "half_x": Known(one["area"]/np.pi/one["half_s"], 0.25), "half_s": Known(one["area"]/np.pi/one["half_x"], 0.25),
            "s_centre": Known(np.mean([one["s_ends.0"], one["s_ends.1"]]), 0.1),
            r"s_ends\.([01])": lambda m: Known(one["s_centre"] + (-1, 1)[int(m[1])]*one["half_s"], 0.1),
            r"centre_wheel\.([01])": lambda m: Known([side, 1][int(m[1])]*in_wheel[int(m[1])], 2e-3),
            r"hertz\.area": np.pi*one["hertz.half_x"]*one["hertz.half_s"],
            r"hertz\.half_(\w)": lambda m: Known(one[f"half_{m[1]}"], 0.3),
            r"hertz\.largest": Known(1.5*one["integral"]/one["hertz.area"], 1e-6)}
        assert one["half_x"] > 1.7*one["half_s"] and one["area"] == pytest.approx(whole, rel=0.25)
        return places(text, {"time": raw.t[k], **{rf"patches\.0\.{name}": truth for name, truth in truths.items()}})
    if title == "page":
        integral, area = number(r"^∫p dA (\S+) kN on (\S+) mm²$")
        largest, ellipse = number(r"^largest (\S+) MPa, mean")*1e6, number(r"^Hertz: (\S+) MPa on (\S+) mm²$")
        by_force, by_overlap = patches(raw, contact, k, largest, 1e-6*area)
        return [*table.words_of_a_page(raw, text),
                Line(r"pressure at t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
                Line(r"^(?:left|right) flange: (\S+) kN at (\S+)°$", "force [kN], angle [deg]", lambda w: (KN*force, DEG*angle)),
                Line(r"^∫p dA (\S+) kN on (\S+) mm²$", "integral [kN], area [mm2]", lambda w: (
                    Known(KN*force, 0.04), by_overlap.of(1e6))),
                Line(r"pressure at x = 0, (\S+) MPa at most", "largest pressure [MPa]", lambda w: 1e-6*largest),
                Line(r"^largest (\S+) MPa, mean (\S+) MPa\nHertz: (\S+) MPa on (\S+) mm²", "pressures, area [mm2]", lambda w: (
                    by_force.of(1e-6), Known(force/area, 0.04), Known(1.5e3*integral/ellipse[1], 5e-3),
                    Known(1.5e3*integral/ellipse[0], 5e-3)))]
    area, length, width = number(r"area (\S+) mm², (\S+) mm along the rail, (\S+) mm across")
    largest, integral = 1e6*number(r"largest pressure (\S+) MPa"), number(r"∫p dA (\S+) kN$")
    by_force, by_overlap = patches(raw, contact, k, largest, 1e-6*area)
    axes = number(r"ellipse with ∫p dA: (\S+) mm x (\S+) mm, (\S+) MPa")
    assert length > 1.7*width         # a flange's patch is long along the rail, for its profile curves most
    return [
        Line(r"t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
        Line(r"flange: (\S+) kN at (\S+)°, in the columns", "force [kN], angle [deg]", lambda w: (KN*force, DEG*angle)),
        Line(r"largest pressure (\S+) MPa", "largest pressure [MPa]", lambda w: by_force.of(1e-6)),
        Line(r"mean (\S+) MPa", "mean pressure [MPa]", lambda w: force/area, 0.04),
        Line(r"vector sum of these pressures (\S+) kN", "vector sum of the pressures [kN]", lambda w: KN*force, 0.01),
        Line(r"∫p dA (\S+) kN$", "integral of the pressure [kN]", lambda w: KN*force, 0.04),
        Line(r"area (\S+) mm², (\S+) mm along the rail, (\S+) mm across", "area [mm2], length, width [mm]: nearly an ellipse",
             lambda w: (by_overlap.of(1e6), Known(4*area/np.pi/width, 0.25), Known(4*area/np.pi/length, 0.25))),
        Line(r"approach (\S+) mm", "approach [mm]", lambda w: overlap.of(MM)),
        Line(r"track at y (\S+) mm", "centre y in the track [mm]", lambda w: MM*place[0], 3e-3),
        Line(r", z (\S+) mm", "centre z in the track [mm]", lambda w: Known(MM*place[1], 2e-3, 0.2)),
        Line(r"ellipse with ∫p dA: (\S+) mm x (\S+) mm, (\S+) MPa", "Hertz's ellipse [mm, mm, MPa]", lambda w: (
            Known(length, 0.3), Known(width, 0.3), Known(6e3*integral/np.pi/axes[0]/axes[1], 5e-3)))]


# Pages of geometry and of first contacts ---------------------------------------------------

def geometry(world: World, folder: Path) -> dict[str, str]:
    return world.sheets("Contact geometry, ")


def first_contacts(world: World, folder: Path) -> dict[str, str]:
    with ldbench_style():
        return by_title(overview_figures([world.run("ex2_aw"), world.run("ex3_aw")]))


def lines_of_first_contacts(world: World, title: str, text: str) -> list[Line]:
    """Shares of the kinetic energies after a contact, of those that are long enough to have words."""
    if "%" not in text:
        return []
    lines = []
    for raw, words, behind in ((world.thrown, "exercise 2", r"(?<!%) "), (world.faster, "exercise 3", "^")):
        one = raw.impact("LF")
        shares = [100*one[f"{part}_after"]/sum(one[f"{other}_before"] for other in ("lat", "vert", "roll"))
                  for part in ("lat", "vert", "roll")]
        written = [x for x in shares if x > 6]
        lines.append(Line(behind + " ".join([r"(\d+) %"]*len(written)) + "$", f"shares of motions, {words} [%]",
                          lambda w, written=written: written))
    return lines


TEXTS = [
    *(Row(f"summary of {name}", partial(summary, name),
          lambda world, title, text, name=name: table.text_of_summary(world.raw(name)), table.SUMMARY_LABELS) for name in NAMES),
    *(Row(f"results of {name}", partial(results, name), partial(lines_of_results, name),
          # What the integration counts and what tests of the physics compare with direct solutions.
          [rf"^(?:{'|'.join(table.BEYOND_ROWS)}|(?:pmax|patch)_\w\w|table_error_\w+)(?: \[\w+\])?(?:\.\w+)? = .*$"])
      for name in NAMES),
    *(Row(f"run --json of {name}", partial(run_json, name), lines_of_run, ["^seconds = .*$"]) for name in NAMES),
    Row("table", lambda world, folder: {"words": said("table", "inputs/ex2_aw.nml"),
                                        "json": said("table", "inputs/ex2_aw.nml", "--json")},
        lines_of_table, [r"^ex2_aw: .*$", r"contact table: .*$", r"5 kN", r"^solutions\.(?:solved|found) = .*$"]),
    Row("to_xarray", dataset, lines_of_dataset),
    Row("summary.csv", lambda world, folder: {"": csv_text(world.outputs/"summary.csv", "case", "of")}, lines_of_csv),
    Row("table of results", lambda world, folder: world.sheets("Table of results: "), partial(table_of_results, "brief"),
        [r"of\s+8\s+twins|up\s+to\s+3\s+µm|than\s+0\.1\s+%", r"at\s+Y\s+=\s+0", "^ *ex2_aw ex5_aw$"]),
    Row("table of the page", page_table, lines_of_page_table),
    Row("facts of the page", page_facts, lines_of_facts, [r"^pressure\.\d+\.patches\.\d+\.(?:[pw]\.\d+|[xs]) = .*$"]),
    Row("abstract", abstract, lines_of_abstract, table.ABSTRACT_LABELS),
    *(Row(f"pages of {name}", partial(pages, name), partial(lines_of_pages, name), table.PAGE_LABELS) for name in NAMES),
    Row("formulations: values", lambda world, folder: {"": world.sheets(FORMULATIONS)["values"]}, lines_of_values,
        ["^Exercise [25] elastic bilateral e = 1 e = 0.5 e = 0$"]),
    Row("formulations: verdicts", lambda world, folder: {title: text for title, text in world.sheets(FORMULATIONS).items()
                                                        if title != "values"},
        lambda world, title, text: lines_of_verdicts(world, title, text) if title.startswith("which") else [],
        [r"\bex\d_aw\b", r"e = (?:1|0\.5|0)\b", r"^exercise [1-5]$", r"restitution 1, 0\.5 and 0\.", r"below 3 %|to\s+30 %",
         r"exercises 1 to 4|^Exercise \d"]),
    *(Row(f"pressure of {contact}", partial(pressure, contact), partial(lines_of_pressure, contact), table.PAGE_LABELS)
      for contact in PRESSED),
    Row("contact geometry", geometry, lambda world, title, text: [
        Line(r"left (\S+), right (\S+) mm", "clearances [mm]", lambda w: CLEARANCE, 1e-3)], [r"CRC-32 [0-9A-F]{8}"]),
    Row("first contacts", first_contacts, lines_of_first_contacts,
        [r"[Ee]xercises? \d(?: to \d)?", r"powers 6/5, -1/5 and 1 of"]),
]
