"""Every number that a user sees is the one that the rows say, with its unit, side and moment; see table.py."""
from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pypdf import PdfReader
from scipy.integrate import trapezoid

import ldbench
import table
from browser import facts
from ldbench.__main__ import main
from ldbench.results.quantities import si_unit
from ldbench.results.summary import summary_row
from raw import Raw
from reading import Line, agree, differing, words_of
from specimen import World
from table import DEG, FULLNESS, KN, MM, PRESSED, RESULTS, WORDS, fits_contact

NAMES = "ex2_aw", "ex5_aw"
FORMULATIONS = "Elastic contact or constraint equations: "


def csv_rows(world: World) -> list[dict[str, str]]:
    with (world.outputs/"summary.csv").open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


def cells(text: str, words: str) -> list[str]:
    """The numbers beside a name in a table."""
    found = re.findall(rf"^{re.escape(words)} (.*)$", text, re.MULTILINE)
    assert len(found) == 1, (words, found)
    return found[0].split(" ")


def abstract_text(world: World) -> str:
    return "\n".join(page.extract_text() for page in PdfReader(world.outputs/"ldbench_abstract.pdf").pages)


# A run's results ---------------------------------------------------------------------------

@pytest.mark.parametrize("name", NAMES)
def test_summary(name: str, world: World):
    lines, labels = table.text_of_summary(world.raw(name))
    assert differing(world.run(name).text, lines, world, labels) == []


@pytest.mark.parametrize("name", NAMES)
def test_results_in_the_column_file(name: str, world: World):
    """Every entry of &results is known here; events have rows of their own."""
    raw = world.raw(name)
    results = raw.text[raw.text.index("# &results"):]
    for key, unit in re.findall(r"^#   (\w+) = [^!\n]+?  ! ([^,\n]+)", results, re.MULTILINE):
        assert unit.replace(" ", ".") == (si_unit(key) or "Pa" if key.startswith("pmax") else si_unit(key)), key
    entries = dict(re.findall(r"^#   (\w+) = ([^!\n]+?)(?:  !.*)?$", results, re.MULTILINE))
    for place in raw.errors():
        del entries[f"table_error_{place}"]       # tests/physics/test_tables.py compares them with direct solutions
    for key, truth in table.in_results(raw).items():
        number = entries.pop(key)
        assert truth is None or float(number) == pytest.approx(truth[0], rel=truth[1], abs=truth[2]), key
    assert set(entries) == {"end"} and len(raw.events) > 15
    for t, kind, more in raw.events:
        k, side = int(np.abs(raw.t - t).argmin()), kind[0].upper()
        # The row of a change is the first one that shows it, up to 128 ns later.
        assert raw.t[k] == pytest.approx(t, rel=5e-9, abs=1.3e-7), kind
        force = raw.c["F_ext"][k] + raw.setting("lateral_ramp")*(t - raw.t[k])
        expected = {"force": pytest.approx(force, rel=1e-8)} if name == "ex5_aw" else {}
        if "contact" in kind:
            angles = raw.c[f"angle_{side}F"][k:]
            expected["angle"] = pytest.approx(abs(angles[np.isfinite(angles)][0]), rel=0.03)
        assert more == expected, kind
        if kind.endswith(("flange contact", "lift-off", "landing")):
            loads = raw.c[f"N_{side}F"] + (0 if "flange" in kind else raw.c[f"N_{side}T"])
            assert (loads[k - 2] > loads[k + 2]) == kind.endswith("lift-off"), (t, kind)


def test_summary_csv(world: World):
    """In SI, under names with their units. Least, median and largest are those of the run and its twins."""
    for row in csv_rows(world):
        raw = world.raw(row["case"])
        if row["of"] != "run":
            continue
        assert float(row["steps"]) == raw.result("steps") and row["exercise"] == row["case"][2]
        for column, text in row.items():
            key, _, unit = column.partition(" ")
            if key in table.CSV_WORDS or key.startswith(("pmax_", "patch_")):
                continue
            truth, expected_unit, slack = table.in_csv(raw, key)
            assert unit == (f"[{expected_unit}]" if expected_unit else ""), column
            if truth is None or np.isnan(truth):
                assert text in ("", "0", "0.0"), (column, text)
            else:
                rounding = 1e-9 if slack < 1e-3 else 1e-6
                assert text and float(text) == pytest.approx(truth, rel=slack, abs=rounding), (row["case"], column)
        for contact in PRESSED:
            if (k := raw.first_peak(contact)) is not None:
                fits_contact(raw, contact, k, float(row[f"pmax_{contact} [Pa]"]), float(row[f"patch_{contact} [m2]"]))
    # The twins of the ramp run again, by their starts alone.
    case = ldbench.Case.from_namelist(world.folder/"inputs/ex5_aw.nml")
    starts = 0.0, 1e-9, -1e-9, 1.5e-8, -1.5e-8, 2e-7, -2e-7, 3e-6, -3e-6
    runs = [ldbench.run(case.replace(Y=case.Y + shift, table_folder=""), table=world.run("ex5_aw").table) for shift in starts]
    for name in "F_derailment", "peak_N_LF", "farthest_up":
        found = [run.results[name] for run in runs]
        expected = {"run": found[0], "least": min(found), "median": float(np.median(found)), "largest": max(found), "having": 9}
        for row in csv_rows(world):
            if row["case"] == "ex5_aw":
                number = next(float(text) for column, text in row.items() if column.partition(" ")[0] == name)
                assert number == pytest.approx(expected[row["of"]], rel=1e-12), (name, row["of"])


def chaotic(world: World, name: str, key: str) -> tuple[float, float, float] | None:
    """Least, median and largest of a result in summary.csv [SI], where one is a thousandth off the median."""
    rows = {row["of"]: row for row in csv_rows(world) if row["case"] == name}
    ends = ("least", "median", "largest")
    text = [next(text for column, text in rows[of].items() if column.partition(" ")[0] == key) for of in ends]
    if "" in text or key in ("drift", "drift_relative", "step"):
        return None
    least, median, largest = map(float, text)
    start = 6e-6 if key in ("farthest_left", "farthest_right") else 0.0       # by which the starts themselves differ
    return (least, median, largest) if max(largest - median, median - least) > 1e-3*abs(median) + start else None


def ranges(text: str, words: str) -> list[tuple[str, str]]:
    """The ranges below a row of a table, or behind its numbers."""
    row = re.search(rf"^{re.escape(words)} .*\n((?:{RANGE}\n)*)", text, re.MULTILINE)
    return re.findall(r"([−\d.]+)(?:–|…)([−\d.]+)", row[1] if row else "")


RANGE = r"[−\d.]+(?:–|…)[−\d.]+(?:, \d of \d)?(?: [−\d.]+(?:–|…)[−\d.]+)*"


def in_a_table(text: str, world: World, label: str, pressed: dict[str, tuple[str, str]] = PRESSED) -> list[str]:
    """Compare the rows of RESULTS and of pressures in a text, a number for each of both runs, with the ranges of chaotic ones;
    their labels."""
    shown = {key: getattr(result, label) for key, result in RESULTS.items() if getattr(result, label)}
    for key, words in shown.items():
        below = iter(ranges(text, words))
        for name, cell in zip(NAMES, cells(text, words), strict=True):
            result, spread = RESULTS[key], chaotic(world, name, key)
            # The end of a run that derails is not an extreme pose.
            ended = key.startswith(("farthest_", "largest_roll", "smallest_roll")) and name == "ex5_aw"
            if spread and not ended:
                for number, cell_of in zip(spread, (None, cell, None), strict=True):
                    assert cell_of is None or agree(cell_of, result.scale*number, 0.0, True), (name, key, cell, spread)
                for number, end in zip((spread[0], spread[2]), next(below), strict=True):
                    assert agree(end, result.scale*number, 0.0, True), (name, key, end, spread)
                continue
            truth = None if ended else result.truth(world.raw(name))
            rough = name == "ex5_aw" or key.startswith(("approach", "drift", "first_impulse", "first_duration"))
            slack = result.slack if rough else min(result.slack, 1e-3)
            truth = None if truth is None else result.scale*truth
            assert agree(cell, truth, slack), (name, key, cell, truth)
        assert next(below, None) is None, (key, "a range that is nobody's")
    for contact, words in pressed.items():
        for name, pressure, area in zip(NAMES, *(cells(text, one) for one in words), strict=True):
            k = world.raw(name).first_peak(contact)
            if k is None:
                assert (pressure, area) == ("–", "–")
            else:
                fits_contact(world.raw(name), contact, k, 1e6*float(pressure), 1e-6*float(area))
    named = (*shown.values(), *(one for both in pressed.values() for one in both))
    return [rf"^{RANGE}$", *(rf"^{re.escape(words)} .*$" for words in named)]


def test_summary_page(world: World):
    text = world.sheets("Table of results: ")["table of results"]
    labels = [*in_a_table(text, world, "brief", {}), *pressures(text, world), r"of 8 twins|up to 3 µm|than 0\.1 %", r"at Y = 0"]
    assert re.search("^ *ex2_aw ex5_aw$", text, re.MULTILINE) and differing(text, [], world, labels) == []


def pressures(text: str, world: World) -> list[str]:
    """The largest pressures of first contacts are those of summary.csv, which go with the forces; their labels."""
    labels = []
    for contact in PRESSED:
        words = f"peak pressure, {WORDS[contact]} [MPa]"
        for cell, name in zip(cells(text, words), NAMES, strict=True):
            spread, row = chaotic(world, name, f"pmax_{contact}"), next(
                row for row in csv_rows(world) if row["case"] == name and row["of"] == "run")
            known = row[f"pmax_{contact} [Pa]"]
            truth = spread[1] if spread else float(known) if known else None
            assert agree(cell, None if truth is None else 1e-6*truth, 0.0, bool(spread)), (words, name)
        labels.append(rf"^{re.escape(words)} .*$")
    return labels


def test_table_of_the_results_page(world: World):
    """The page of all runs has the numbers of the summary, each with the moment that a click opens."""
    rows = {row["words"]: row["cells"] for row in facts(world.outputs/"ldbench_results.html")["summary"]}
    # What the report has kept of the variations of the cases that end with a return.
    kept = {one["case"]: one for one in json.loads(next(world.outputs.rglob("trust.json")).read_text())}
    for cell, name in zip(rows.pop("peak N, first contact, left flange [kN], wheel and rail as bodies"), NAMES, strict=True):
        told = kept.get(name, {"variations": []})
        peaks = [1e-3*peak for one, peak in zip(told["variations"], told["answers"]["first_peak_N_LF"]["values"], strict=True)
                 if one["kind"] == "bodies"] if told["variations"] else []
        assert len(peaks) == 2*(name in kept) and (cell["text"] == "–") == (not peaks)
        assert not peaks or [float(x) for x in cell["text"].split(" to ")] == pytest.approx([min(peaks), max(peaks)], rel=1e-3)
    lines = []
    for words, row in rows.items():
        parts = [re.fullmatch(r"(\S+)(?: \((\S+) to ([^\s,]+).*\))?", cell["text"]) for cell in row]
        lines += [f"{words} {' '.join(part[1] for part in parts)}", *(f"{part[2]}–{part[3]}" for part in parts if part[2])]
    in_a_table("\n".join([*lines, ""]), world, "words")
    for k, name in enumerate(NAMES):
        raw = world.raw(name)
        assert all(row[k]["run"] == name for row in rows.values())
        for contact, words in WORDS.items():
            t = rows[f"peak N, {words} [kN]"][k]["t"]
            assert t is None or t == pytest.approx(raw.peak(contact)[1], abs=1e-8)
        for contact, words in ("LF", "left flange"), ("RF", "right flange"):      # also where a later contact is harder
            first = raw.t[raw.first_peak(contact)] if (raw.c[f"N_{contact}"] > 0).any() else None
            assert rows[f"peak pressure, first contact, {words} [MPa]"][k]["t"] == (first and pytest.approx(first, abs=1e-6))
        for words, column, sign in (("Y, largest [mm]", "Y", 1), ("Z, smallest [mm]", "Z", -1), ("Φ, smallest [mrad]", "roll", -1)):
            t = rows[words][k]["t"]
            assert t is None if name == "ex5_aw" else t == pytest.approx(raw.t[int((sign*raw.c[column]).argmax())], abs=1e-3)


def test_page_facts(world: World):
    """What the page of a run says of its events, peaks, clearance and pressures; the page is small."""
    page = world.outputs/"ldbench_results.html"
    assert page.stat().st_size < 0.25*sum(world.raw(name).file.stat().st_size for name in NAMES)
    for shown, name in zip(facts(page)["runs"], NAMES, strict=True):
        raw = world.raw(name)
        assert shown["name"] == name and shown["clearance"] == pytest.approx([10.18e-3, 16.94e-3], abs=1e-5)
        assert shown["firstFlange"] == pytest.approx(raw.start("LF"), abs=1e-8)
        peaks = {event["what"]: (event["peak"], event["t"]) for event in shown["events"] if event.get("peak")}
        assert peaks == {f"largest normal force, {words}": pytest.approx(raw.peak(contact), rel=1e-8)
                         for contact, words in WORDS.items() if raw.peak(contact)[0]}
        for entry in shown["pressure"]:
            k = int(np.abs(raw.t - entry["t"]).argmin())
            for patch in entry["patches"]:
                share = raw.c[f"N_{patch['c']}"][k]/(patch["pmax"]*patch["area"])
                assert share == pytest.approx(FULLNESS[0], abs=0.06), patch["c"]


# Documents ---------------------------------------------------------------------------------

@pytest.mark.parametrize("name", NAMES)
def test_every_number_in_the_words_of_the_pages(name: str, world: World):
    """Each number is a setting, or follows from the rows, or is a label."""
    sheets, raw = world.sheets(f"Exercise {name[2]}, actual profiles (left), simplified profiles (right): "), world.raw(name)
    assert len(sheets) == (6 if name == "ex2_aw" else 8)
    for title, text in sheets.items():
        lines, labels = table.words_of_a_page(raw, text)
        assert differing(text, lines, world, labels) == [], title
    # Forces and angles above the cross-sections: first contact of either flange, in exercise 5 also the hardest one.
    shown = re.findall(r"^(left|right): (.*)$", sheets["more pages: impacts of flanges"], re.MULTILINE)
    places = [(at, side) for at in table.pictured(raw) for side in ("left", "right")]
    for (at, expected), (side, words) in zip(places, shown, strict=True):
        closed = [(part, c) for part, c in (("tread", f"{side[0].upper()}T"), ("flange", f"{side[0].upper()}F"))
                  if raw.c[f"N_{c}"][at] > 0]
        lines = [Line(rf"{part} (\S+) kN at (\S+)°", f"{part} [kN, deg]", lambda w, c=c, at=at: (
            KN*raw.c[f"N_{c}"][at], DEG*raw.c[f"angle_{c}"][at])) for part, c in closed]
        assert side == expected and (closed or words == "no contact") and differing(words, lines, world, []) == []


def shown_values(world: World, words: str, exercise: int) -> list[float]:
    """A row of the page of values by formulation, which test_values_of_formulations compares with the rows; NaN for dashes."""
    text = world.sheets(FORMULATIONS)["values"].split("\nExercise 5 ")[exercise == 5]
    found = re.search(rf"^{re.escape(words)}(?: \[.*\])? ([-\d.–]+(?: [-\d.–]+){{4}})$", text, re.MULTILINE)
    return [float("nan" if cell == "–" else cell) for cell in found[1].split(" ")] if found else [np.nan]*5


BODIES = {"peak N, first contact, left flange": "first_peak_N_LF", "duration, first contact, left flange": "first_duration_LF",
          "impulse, first contact, left flange": "first_impulse_LF", "first right flange contact": "t_first_RF",
          "return to the centre": "t_return", "first peak of the left flange by": "first_peak_N_LF",
          "its impulse by": "first_impulse_LF", "static limit of the lateral force by": "F_limit_left"}


def changed_by_bodies(world: World, text: str) -> Iterator[Line]:
    """By how much the answers of the one run with bodies change [%]: least and largest, one number where both are written alike, or
    a dash where the twins do not share the answer."""
    told, = json.loads(next(world.outputs.rglob("trust.json")).read_text())
    kinds = [one["kind"] for one in told["variations"]]
    for words, name in BODIES.items():
        value, found = told["answers"][name]["value"], told["answers"][name]["values"]
        twins, own = ([x for kind, x in zip(kinds, found, strict=True) if kind == which and x is not None]
                      for which in ("twin", "bodies"))
        shared = bool(value and own) and max(abs(x/value - 1) for x in twins) <= 1e-3
        for k, end in enumerate((min, max)):
            behind = r"\S+ to " if k and re.search(rf"{words} [^\s\[]+ to ", text) else ""
            change = 100*(end(own)/value - 1) if shared else np.nan
            yield Line(rf"{words} {behind}(?!\[)(\S+)", f"{words}: {end.__name__} by bodies [%]", lambda w, x=change: x)


def test_abstract(world: World):
    lines = abstract_text(world)
    rows = [f"{label.removeprefix('^').removesuffix('.*$')}\\S+ \\S+" if label.endswith(".*$") else label.strip("^$")
            for label in in_a_table(lines, world, "short", {})]
    # The pressures are those of summary.csv, which go with the forces.
    pressures = [float(row["pmax_LF [Pa]"]) for row in csv_rows(world) if row["of"] == "run"]
    words = "peak pressure, left flange [MPa]"
    assert all(agree(cell, 1e-6*x) for cell, x in zip(cells(lines, words), pressures, strict=True))
    rows.append(rf"{re.escape(words)} \S+ \S+")

    def spread(x: list[float]) -> float:
        return 100*max(abs(one/x[0] - 1) for one in x[1:])

    def shown(words: str, exercise: int = 2) -> list[float]:
        return shown_values(world, words, exercise)

    back, force = shown("return to the centre"), shown("lateral force at derailment", 5)
    lines_of_formulations = [
        Line(r"agrees within about (\S+) %", "first contacts [%]",
             lambda w: max(spread(shown("first left flange contact", k)) for k in (2, 5)), 0.02),       # from four digits
        Line(r"this contact differs by up to (\S+) %", "impulses [%]",
             lambda w: spread(shown("impulse until the wheelset moves back, left flange"))),
        Line(r"lateral force of (\S+) kN \(ex5_aw\) on", "a rail pulls [kN]",
             lambda w: shown("lateral force from which a rail pulls", 5)[1]),
        Line(r"ex2_aw (\S+) s (\S+) s does not return does not return does not return", "returns [s]", lambda w: back[:2]),
        Line(r"overturns, (\S+) kN does not derail overturns, (\S+) kN overturns, (\S+) kN overturns, (\S+) kN", "forces [kN]",
             lambda w: [force[k] for k in (0, 2, 3, 4)])]
    flat = " ".join(lines.split())
    assert differing(flat, [*table.ABSTRACT, *lines_of_formulations, *changed_by_bodies(world, flat)], world,
                     [*rows, *table.ABSTRACT_LABELS]) == []


# Formulations ------------------------------------------------------------------------------

def impulse_of(raw: Raw) -> float:
    """Impulse of forces and impacts on the left flange, from the first touch until the wheelset moves back [N s]."""
    blows = raw.c.get("P_LF", np.zeros(len(raw.t)))
    touched = int(np.argmax((raw.c["N_LF"] > 1) | (blows > 0)))
    end = touched + int(np.argmax(raw.c["vY"][touched:] < 0))
    until = [float(trapezoid(raw.c["N_LF"][:k + 1], raw.t[:k + 1]) + blows[k]) for k in (end - 1, end)]
    return until[1] if blows[end] > blows[end - 1] else float(np.interp(0.0, -raw.c["vY"][end - 1:end + 1], until))


@pytest.mark.parametrize(("column", "changes"), [
    (0, {}), (1, {"formulation": "bilateral"}), (2, {"formulation": "unilateral", "restitution": 1.0}),
    (3, {"formulation": "unilateral", "restitution": 0.5}), (4, {"formulation": "unilateral", "restitution": 0.0})])
def test_values_of_formulations(column: int, changes: dict[str, object], world: World, tmp_path: Path):
    """The page of values: each from the rows of a run of that formulation."""
    text = world.sheets(FORMULATIONS)["values"].partition("Exercise 5")[0]
    case = ldbench.Case.from_namelist(world.folder/"inputs/ex2_aw.nml").replace(table_folder="", **changes)
    raw = Raw(Path(ldbench.run(case).write(tmp_path/"run.txt"))) if changes else world.thrown
    blows = raw.c.get("P_LF", np.zeros(len(raw.t)))
    returned = len(raw.passages()) > 1
    assert returned or summary_row(ldbench.read_run(raw.file))["t_return"] is None
    truths = {
        "first left flange contact [s]": table.first_touch(raw, "LF"), "largest Y [mm]": MM*raw.extreme("Y", 1),
        "largest Z [mm]": MM*raw.c["Z"].max(), "impulse until the wheelset moves back, left flange [kN·s]": KN*impulse_of(raw),
        "peak N, left flange [kN]": KN*raw.c["N_LF"].max() or None,
        "largest impulse, left flange [kN·s]": KN*np.diff(blows).max() or None,
        "first right flange contact [s]": table.first_touch(raw, "RF"),
        "return to the centre [s]": raw.passages()[-1] if returned else None,
        "energy lost [J]": raw.c["E_lost"][-1] if "E_lost" in raw.c else 0.0}
    for words, truth in truths.items():
        cell = cells(text, words)[column]
        # A force of rigid contacts that jumps by 200 kN between rows of 0.2 ms leaves 20 N·s of 1.6 kN·s open.
        slack = 2e-3 if words.startswith(("largest Y", "largest Z")) else 0.013 if words.startswith("impulse") else 1e-5
        assert agree(cell, None if truth is None or np.isinf(truth) else truth, slack), (words, cell, truth)
    if not changes:
        assert int(cells(text, "lift-offs of both wheels")[0]) == raw.lift_offs("L") + raw.lift_offs("R")


def test_formulations(world: World):
    """How much results depend on the formulation, from the values beside; exercise 5 with elastic contact from its rows."""
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
    lines.append(Line(r"^lift-offs of both wheels (\d+) to (\d+) (\d+) to (\d+)$", "fewest and most lift-offs",
                      lambda w: [end(x) for x in hops for end in (min, max)]))
    labels = [r"\bex\d_aw\b", r"e = (?:1|0\.5|0)\b", r"^exercise [1-5]$", r"restitution 1, 0\.5 and 0\.", r"below 3 %|to\s+30 %",
              r"exercises 1 to 4|^Exercise \d"]
    for title, text in world.sheets(FORMULATIONS).items():
        if title != "values":
            assert differing(text, lines if title.startswith("which") else [], world, labels) == [], title
    raw = world.pushed
    for words, truth in (
            ("first left flange contact", raw.start("LF")), ("peak N, left flange", KN*raw.peak("LF")[0]),
            ("derailment", raw.t[-1]), ("lateral force at derailment", KN*raw.c["F_ext"][-1])):
        assert shown_values(world, words, 5)[0] == pytest.approx(truth, rel=5e-4), words


# Pressure ----------------------------------------------------------------------------------

@pytest.mark.parametrize("contact", PRESSED)
def test_pressure(contact: str, world: World, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Every number that the command prints and draws of a patch; its place is that of the contact, in the frame of the track."""
    raw, k, drawn = world.thrown, world.thrown.first_peak(contact), []
    monkeypatch.setattr("ldbench.plots.pressure_page.save_sheets", lambda sheets, target: drawn.extend(sheets))
    assert main(["pressure", str(raw.file), "--at", f"{raw.t[k]:.9g}", "--contact", contact, "-o", "pressure.pdf"]) == 0
    said = capsys.readouterr().out
    force, area = raw.c[f"N_{contact}"][k], float(re.search(r"area (\S+) mm", said)[1])
    length, width = map(float, re.search(r", (\S+) mm along the rail, (\S+) mm across", said).groups())
    assert length > 2*width         # a flange's patch is long along the rail, for its profile curves most
    lines = [
        Line(r"t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
        Line(r"flange: (\S+) kN at (\S+)°, in the columns", "force [kN], angle [deg]",
             lambda w: (KN*force, DEG*abs(raw.c[f"angle_{contact}"][k]))),
        Line(r"largest pressure (\S+) MPa", "largest pressure [MPa]", lambda w: force/area/FULLNESS[0], 0.05),
        Line(r"mean (\S+) MPa", "mean pressure [MPa]", lambda w: force/area, 0.04),
        Line(r"vector sum of these pressures (\S+) kN", "vector sum of the pressures [kN]", lambda w: KN*force, 0.01),
        Line(r"∫p dA (\S+) kN$", "integral of the pressure [kN]", lambda w: KN*force, 0.04),
        Line(r"area (\S+) mm², (\S+) mm along the rail, (\S+) mm across", "area [mm2], length, width [mm]: nearly an ellipse",
             lambda w: (area, length, 4*area/np.pi/length), 0.25),
        Line(r"approach (\S+) mm", "approach [mm]", lambda w: MM*raw.overlap(contact, k), 4e-3),
        Line(r"track at y (\S+) mm", "centre y in the track [mm]", lambda w: MM*raw.c[f"y_{contact}"][k], 3e-3),
        Line(r", z (\S+) mm", "centre z in the track [mm]", lambda w: MM*raw.c[f"z_{contact}"][k], 0.15)]
    assert differing(said, lines, world, [r"^ex2_aw", r"  Hertz's ellipse .*"]) == []
    length, width, largest = map(float, re.search(r"ellipse with ∫p dA: (\S+) mm x (\S+) mm, (\S+) MPa", said).groups())
    integral = float(re.search(r"∫p dA (\S+) kN", said)[1])
    assert largest*np.pi*length*width/6 == pytest.approx(1e3*integral, rel=5e-3)
    text = words_of(drawn[0])
    lines = [*table.words_of_a_page(raw, text)[0],
             Line(r"pressure at t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
             Line(r"^(?:left|right) flange: (\S+) kN at (\S+)°$", "force [kN], angle [deg]",
                  lambda w: (KN*force, DEG*abs(raw.c[f"angle_{contact}"][k]))),
             Line(r"^∫p dA (\S+) kN on (\S+) mm²$", "integral [kN], area [mm2]", lambda w: (integral, area), 1e-4),
             Line(r"pressure at x = 0, (\S+) MPa at most", "largest pressure [MPa]",
                  lambda w: float(re.search(r"largest pressure (\S+) MPa", said)[1])),
             Line(r"^largest (\S+) MPa, mean (\S+) MPa\nHertz: (\S+) MPa on (\S+) mm²", "pressures [MPa], area [mm2]",
                  lambda w: (force/area/FULLNESS[0], force/area, largest, np.pi*length*width/4), 0.05)]
    assert differing(text, lines, world, table.PAGE_LABELS) == []
