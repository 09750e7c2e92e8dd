"""Every number that a user sees is the one that the rows say, with its unit, side and moment; see table.py."""
from __future__ import annotations

import csv
import functools
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from pypdf import PdfReader

import ldbench
import table
from browser import facts
from ldbench.__main__ import main
from ldbench.commands import COMMANDS
from ldbench.geometry.pressures import run_patches
from ldbench.plots.document import case_figures
from ldbench.plots.energies import ramp_page
from ldbench.plots.impact import impact_page
from ldbench.plots.pressure_page import pressure_page
from ldbench.plots.style import ldbench_style
from ldbench.results.summary import summary_row
from ldbench.viewer.film import Picture
from raw import Raw, flange_slope
from reading import Line, agree, differing, words_of
from specimen import World
from table import DEG, FULLNESS, KN, MM, RESULTS, TICKS, WORDS, fits_contact

NAMES = "ex2_aw", "ex5_aw"


def raw_of(world: World, name: str) -> Raw:
    return world.thrown if name == "ex2_aw" else world.pushed


def chaotic(world: World, name: str) -> set[str]:
    """The results of a run that are told with the digits that hold."""
    return set(next(row for row in csv_rows(world.outputs/"summary.csv") if row["case"] == name)["chaotic"].split())


def csv_rows(file: Path) -> list[dict[str, str]]:
    with file.open(newline="", encoding="utf-8") as opened:
        return list(csv.DictReader(opened))


@functools.cache
def pages(file: Path) -> list[str]:
    return [page.extract_text() for page in PdfReader(file).pages]


def cells(text: str, words: str) -> list[str]:
    """The numbers beside a name in a table."""
    found = re.findall(rf"^{re.escape(words)} (.*)$", text, re.MULTILINE)
    assert len(found) == 1, (words, found)
    return found[0].split(" ")


# A run's results ---------------------------------------------------------------------------

@pytest.mark.parametrize("name", NAMES)
def test_summary(name: str, world: World):
    lines, labels = table.text_of_summary(raw_of(world, name))
    assert differing(world.run(name).text, lines, world, labels) == []


@pytest.mark.parametrize("name", NAMES)
def test_results_in_the_column_file(name: str, world: World):
    """Every entry of &results is known here; events have rows of their own."""
    raw = raw_of(world, name)
    units = {"t": "s", "f": "m", "p": "N", "d": "J", "k": "J"}
    for key, unit in re.findall(r"^#   (\w+) = [^!\n]+?  ! ([^,\n]+)", raw.text[raw.text.index("# &results"):], re.MULTILINE):
        assert unit == ("s" if key in ("step", "t") else "N" if "peak_N" in key else units[key[0]]), key
    entries = dict(re.findall(r"^#   (\w+) = ([^!\n]+?)(?:  !.*)?$", raw.text[raw.text.index("# &results"):], re.MULTILINE))
    for key, truth in table.in_results(raw).items():
        number = float(entries.pop(key))
        assert truth is None or number == pytest.approx(truth[0], rel=truth[1], abs=truth[2]), key
    assert set(entries) == {"end"}
    assert len(raw.events) > 15
    for t, kind, more in raw.events:
        k = int(np.abs(raw.t - t).argmin())
        assert raw.t[k] == pytest.approx(t, rel=5e-9), kind
        assert set(more) == {*(("angle",) if "contact" in kind else ()), *(("force",) if name == "ex5_aw" else ())}
        if "force" in more:
            assert more["force"] == pytest.approx(raw.c["F_ext"][k], rel=1e-8)
        if "angle" in more:
            angles = raw.c[f"angle_{kind[0].upper()}F"][k:]
            assert more["angle"] == pytest.approx(abs(angles[np.isfinite(angles)][0]), rel=0.03)
        if kind.endswith(("flange contact", "lift-off", "landing")):
            side = kind[0].upper()
            loads = raw.c[f"N_{side}F"] + (0 if "flange" in kind else raw.c[f"N_{side}T"])
            opens = kind.endswith("lift-off")
            near = loads[k - 2:k + 3]
            assert (near[0] > near[-1]) if opens else (near[0] < near[-1]), (t, kind)


def test_summary_csv(world: World):
    """In SI, under names with their units."""
    for row in csv_rows(world.outputs/"summary.csv"):
        raw = raw_of(world, row["case"])
        for column, text in row.items():
            key, _, unit = column.partition(" ")
            if key in table.CSV_WORDS:
                assert key != "steps" or int(text) == raw.result("steps")
                assert key != "exercise" or text == row["case"][2]
                continue
            if key.startswith(("pmax_", "patch_")):
                continue
            truth, expected_unit, slack = table.in_csv(raw, key)
            assert unit == (f"[{expected_unit}]" if expected_unit else ""), column
            if truth is None or np.isnan(truth):
                assert text in ("", "0", "0.0"), (column, text)
            else:
                rounding = 1e-9 if slack < 1e-3 else 0.0
                assert text and float(text) == pytest.approx(truth, rel=slack, abs=rounding), (row["case"], column)
        for contact in "LF", "RF":
            if (k := raw.first_peak(contact)) is not None:
                fits_contact(raw, contact, k, float(row[f"pmax_{contact} [Pa]"]), float(row[f"patch_{contact} [m2]"]))


def in_a_table(text: str, world: World, label: str) -> None:
    """The rows of RESULTS in a text, a number for each of both runs."""
    for key, result in RESULTS.items():
        words = getattr(result, label)
        if not words:
            continue
        for name, cell in zip(NAMES, cells(text, words), strict=True):
            truth = result.truth(raw_of(world, name))
            slack = result.slack if name == "ex5_aw" or key.startswith(("approach", "drift")) else min(result.slack, 1e-5)
            truth = None if truth is None else result.scale*truth
            assert agree(cell, truth, slack, key in chaotic(world, name)), (name, key, cell, truth)


def pressures_fit(values: dict[str, tuple[str, str]], raw: Raw) -> None:
    """Largest pressure [MPa] times area [mm2] of each flange's first patch goes with the force of its contact."""
    for contact, (pressure, area) in values.items():
        k = raw.first_peak(contact)
        if k is None:
            assert (pressure, area) == ("–", "–")
            continue
        fits_contact(raw, contact, k, 1e6*float(pressure), 1e-6*float(area))


def test_summary_page(world: World):
    text = pages(world.outputs/"ldbench_plots.pdf")[1]
    assert text.startswith("ex2_aw ex5_aw\n")
    in_a_table(text, world, "words")
    for k, name in enumerate(NAMES):
        pressures_fit({c: tuple(cells(text, words)[k] for words in table.PRESSED[c]) for c in ("LF", "RF")}, raw_of(world, name))
    known = [result.words for result in RESULTS.values()] + [words for both in table.PRESSED.values() for words in both]
    labels = [*(rf"^{re.escape(words)} .*$" for words in known), r"moved by 1 µm|than 0\.1 %", r"at Y = 0;", r"\d+ / \d+$"]
    assert differing(text, [], world, labels) == []


def test_table_of_the_results_page(world: World):
    """The page of all runs has the numbers of the summary, each with the moment that a click opens."""
    shown = facts(world.outputs/"ldbench_results.html")
    rows = {row["words"]: row["cells"] for row in shown["summary"]}
    text = "\n".join(f"{words} {' '.join(cell['text'] for cell in row)}" for words, row in rows.items())
    in_a_table(text, world, "words")
    for k, name in enumerate(NAMES):
        raw = raw_of(world, name)
        pressures_fit({c: tuple(rows[words][k]["text"] for words in table.PRESSED[c]) for c in ("LF", "RF")}, raw)
        assert all(row[k]["run"] == name for row in rows.values())
        for contact, words in WORDS.items():
            t = rows[f"peak N, {words} [kN]"][k]["t"]
            assert t is None or t == pytest.approx(raw.peak(contact)[1], abs=1e-8)
        for words, column, sign in (("Y, largest [mm]", "Y", 1), ("Z, smallest [mm]", "Z", -1), ("Φ, smallest [mrad]", "roll", -1)):
            at = int((sign*raw.c[column]).argmax())
            assert rows[words][k]["t"] == raw.t[at]


def test_table_of_the_abstract(world: World):
    text = "\n".join(pages(world.outputs/"ldbench_abstract.pdf"))
    in_a_table(text, world, "short")
    for k, name in enumerate(NAMES):
        values = tuple(cells(text, words)[k] for words in ("peak pressure, left flange [MPa]", "patch area, left flange [mm²]"))
        pressures_fit({"LF": values}, raw_of(world, name))


# Documents ---------------------------------------------------------------------------------

def four_digits(x: float) -> str:
    return f"{x:.{max(3 - int(np.floor(np.log10(x))), 0)}f}"


@pytest.mark.parametrize("name", NAMES)
def test_page_of_impacts(name: str, world: World):
    """The forces and angles above the cross-sections: first contact of either flange, in exercise 5 also the hardest one."""
    raw = raw_of(world, name)
    title = f"Exercise {name[2]}, actual profiles (left), simplified profiles (right): impacts"
    text = next(page for page in pages(world.outputs/"ldbench_plots.pdf") if title in page)
    for k, at in enumerate(table.pictured(raw)):
        for side in "left", "right":
            words = [f"{what} {four_digits(KN*raw.c[f'N_{side[0].upper()}{part}'][at])} kN at "
                     f"{DEG*raw.c[f'angle_{side[0].upper()}{part}'][at]:.1f}°" for part, what in (("T", "tread"), ("F", "flange"))
                     if raw.c[f"N_{side[0].upper()}{part}"][at] > 0]
            assert f"{side}: {', '.join(words) or 'no contact'}" in text, (k, side)


@pytest.mark.parametrize("name", NAMES)
def test_every_number_in_the_words_of_the_pages(name: str, world: World):
    """Each number is a setting, or follows from the rows, or is a label: in the figures, and in the document beside its ticks."""
    exercise = f"Exercise {name[2]}, actual profiles (left), simplified profiles (right): "
    raw, seen = raw_of(world, name), 0
    for text in pages(world.outputs/"ldbench_plots.pdf"):
        if exercise not in text or text.startswith("Plots of all"):
            continue
        seen += 1
        lines, labels = table.words_of_a_page(raw, text)
        assert differing(text, lines, world, [*labels, *TICKS]) == []
    assert seen == (5 if name == "ex2_aw" else 6)
    with ldbench_style():
        for title, figure in case_figures(world.run(name)):
            lines, labels = table.words_of_a_page(raw, text := words_of(figure))
            assert differing(text, lines, world, labels) == [], title


def test_patch_on_the_page_of_impacts(world: World):
    """Largest pressure and area over the time of the first contact, in milliseconds."""
    raw = world.thrown
    axes = {ax.get_ylabel(): ax for ax in impact_page(world.run("ex2_aw")).axes}
    t, pressure = axes["pressure [GPa]"].get_lines()[0].get_data()
    again, area = axes["patch area [mm²]"].get_lines()[0].get_data()
    k = raw.first_peak("LF")
    at = int(np.argmin(np.abs(t - 1e3*raw.t[k])))
    assert t[at] == again[at] == pytest.approx(1e3*raw.t[k], abs=1e-9) and raw.start("LF") < 1e-3*t[0] < 1e-3*t[-1]
    fits_contact(raw, "LF", k, 1e9*pressure[at], 1e-6*area[at])


def test_words_of_the_abstract(world: World):
    text = " ".join(" ".join(pages(world.outputs/"ldbench_abstract.pdf")).split())
    rows = [rf"{re.escape(result.short)} \S+ \S+" for result in RESULTS.values() if result.short]     # test_table_of_the_abstract
    rows += [r"peak pressure, left flange \[MPa\] \S+ \S+", r"patch area, left flange \[mm²\] \S+ \S+"]
    values = pages(world.outputs/"ldbench_plots.pdf")[-1]

    def shown(words: str, exercise: int = 2) -> list[float]:
        """A row of the page of values, which test_values_of_formulations compares with the rows."""
        part = values.split("Exercise 5")[exercise == 5]
        return [float("nan" if cell == "–" else cell) for cell in cells(part, words)]

    def spread(x: list[float]) -> float:
        return 100*max(abs(one/x[0] - 1) for one in x[1:])

    back, force = shown("return to the centre [s]"), shown("lateral force at derailment [kN]", 5)
    first, impulse = "first left flange contact [s]", "impulse of the first left flange contact [kN·s]"
    lines = [Line(r"agrees within about (\S+) %", "first contacts [%]", lambda w: max(spread(shown(first, k)) for k in (2, 5)),
                  0.02),        # The page has four digits of times.
             Line(r"this contact differs by up to (\S+) %", "impulses [%]", lambda w: spread(shown(impulse))),
             Line(r"lateral force of (\S+) kN \(ex5_aw\) on", "a rail pulls [kN]",
                  lambda w: shown("lateral force from which a rail pulls [kN]", 5)[1]),
             Line(r"ex2_aw (\S+) s (\S+) s does not return does not return does not return", "returns [s]", lambda w: back[:2]),
             Line(r"overturns, (\S+) kN does not derail overturns, (\S+) kN overturns, (\S+) kN overturns, (\S+) kN", "forces [kN]",
                  lambda w: [force[k] for k in (0, 2, 3, 4)])]
    assert differing(text, [*table.ABSTRACT, *lines], world, [*rows, *table.ABSTRACT_LABELS]) == []


def test_ramp_page(world: World):
    """L/V of both wheels over the lateral force, loads, forces and displacements; Nadal's limits."""
    raw = world.pushed
    figure = ramp_page(world.run("ex5_aw"))
    axes = {ax.get_ylabel(): ax for ax in figure.axes}
    force = KN*raw.c["F_ext"]

    def agrees(label: str, k: int, x: np.ndarray) -> None:
        """A curve of rows, extremes among them, or a mean with a band of the rows below the last second."""
        line = [one for one in axes[label].get_lines() if len(one.get_xdata()) > 10][k]
        f, y = line.get_data()
        bands = [one for one in axes[label].collections if isinstance(one, PolyCollection)]
        if not bands:
            np.testing.assert_allclose(y, x[np.searchsorted(force, f)], rtol=1e-9)
            assert np.nanmax(y) == np.nanmax(x) and np.nanmin(y) == np.nanmin(x)
            return
        low, high = (np.nanmin(bands[k].get_paths()[0].vertices[:, 1]), np.nanmax(bands[k].get_paths()[0].vertices[:, 1]))
        inside = force <= f[-1] + 0.5*(f[1] - f[0])
        assert high == pytest.approx(np.nanmax(x[inside]), rel=1e-6) and low == pytest.approx(np.nanmin(x[inside]), rel=1e-6)

    for k, side in enumerate("LR"):
        agrees("L/V", k, raw.ratio(side))
    assert abs(np.nanmax(raw.ratio("L")) - np.nanmax(raw.ratio("R"))) > 0.5, "an exchange would show"
    for k, side in enumerate("LR"):
        agrees("vertical load [kN]", k, KN*raw.loads(side))
    for k, contact in enumerate(("LT", "LF", "RT")):
        agrees("normal N [kN]", k, KN*raw.c[f"N_{contact}"])
    agrees("lateral Y [mm]", 0, MM*raw.c["Y"])
    agrees("roll Φ [mrad]", 0, 1e3*raw.c["roll"])
    slope = np.tan(flange_slope())
    levels = [line.get_ydata()[0] for line in axes["L/V"].get_lines() if len(line.get_xdata()) == 2]
    np.testing.assert_allclose(sorted(levels), sorted((slope - mu)/(1 + mu*slope) for mu in (0.0, 0.3)), rtol=1e-5)


# Formulations ------------------------------------------------------------------------------

def impulse_of(raw: Raw) -> float:
    """Impulse of forces and impacts on the left flange, from the first touch until the wheelset moves back [N s]."""
    blows = raw.c.get("P_LF", np.zeros(len(raw.t)))
    touched = int(np.argmax((raw.c["N_LF"] > 1) | (blows > 0)))
    end = touched + int(np.argmax(raw.c["vY"][touched:] < 0))
    n, t = raw.c["N_LF"][:end + 1], raw.t[:end + 1]
    return float(np.sum(np.diff(t)*(n[1:] + n[:-1])/2) + blows[end])


@pytest.mark.parametrize(("column", "changes"), [
    (0, {}), (1, {"formulation": "bilateral"}), (2, {"formulation": "unilateral", "restitution": 1.0}),
    (3, {"formulation": "unilateral", "restitution": 0.5}), (4, {"formulation": "unilateral", "restitution": 0.0})])
def test_values_of_formulations(column: int, changes: dict[str, object], world: World, tmp_path: Path):
    """The page of values: each from the rows of a run of that formulation."""
    text = pages(world.outputs/"ldbench_plots.pdf")[-1]
    text = text[:text.index("Exercise 5")]
    case = ldbench.Case.from_namelist(world.folder/"inputs/ex2_aw.nml").replace(table_file="", **changes)
    raw = Raw(Path(ldbench.run(case).write(tmp_path/"run.txt"))) if changes else world.thrown
    blows = {c: raw.c.get(f"P_{c}", np.zeros(len(raw.t))) for c in WORDS}
    left, returned = raw.t <= table.first_touch(raw, "RF"), len(raw.passages()) > 1
    assert returned or summary_row(ldbench.read_run(raw.file))["t_return"] is None
    truths = {
        "first left flange contact [s]": (table.first_touch(raw, "LF"), 1e-5), "largest Y [mm]": (MM*raw.extreme("Y", 1), 2e-3),
        "highest, to the left [mm]": (MM*raw.c["Z"][left].max(), 1e-5),
        "impulse of the first left flange contact [kN·s]": (KN*impulse_of(raw), 1e-5),
        "largest force of a left flange [kN]": (KN*raw.c["N_LF"].max() or None, 1e-5),
        "largest impulse of a left flange [kN·s]": (KN*np.diff(blows["LF"]).max() or None, 1e-5),
        "first right flange contact [s]": (table.first_touch(raw, "RF"), 1e-5),
        "return to the centre [s]": (raw.t[-1] if returned else None, 1e-5),
        "energy lost [J]": (raw.c["E_lost"][-1] if "E_lost" in raw.c else 0.0, 1e-5)}
    for words, (truth, slack) in truths.items():
        cell = cells(text, words)[column]
        assert agree(cell, None if truth is None or np.isinf(truth) else truth, slack), (words, cell, truth)
    if not changes:
        assert int(cells(text, "lift-offs of both wheels")[0]) == raw.lift_offs("L") + raw.lift_offs("R")


# Page, film, pressure, comparison ----------------------------------------------------------

def test_page_facts(world: World):
    """What the page of a run says of its events, peaks, clearance and pressures."""
    for shown, name in zip(facts(world.outputs/"ldbench_results.html")["runs"], NAMES, strict=True):
        raw = raw_of(world, name)
        assert shown["name"] == name and shown["clearance"] == pytest.approx(10.18e-3, abs=1e-5)
        assert shown["firstFlange"] == pytest.approx(raw.start("LF"), abs=1e-8)
        peaks = {event["what"]: event for event in shown["events"] if event.get("peak")}
        for contact, words in WORDS.items():
            if raw.peak(contact)[0]:
                event = peaks.pop(f"largest normal force, {words}")
                assert (event["peak"], event["t"]) == pytest.approx(raw.peak(contact), rel=1e-8)
        assert not peaks
        for entry in shown["pressure"]:
            k = int(np.abs(raw.t - entry["t"]).argmin())
            for patch in entry["patches"]:
                share = raw.c[f"N_{patch['c']}"][k]/(patch["pmax"]*patch["area"])
                assert share == pytest.approx(FULLNESS[0], abs=0.06), patch["c"]


def test_film(world: World):
    """The clock, the pose, and below each close-up the forces of the wheel that it shows; test_film.py has the arrows."""
    raw = world.thrown
    picture = Picture([world.run("ex2_aw")], 0.0, raw.t[-1], 1e-3, None)
    for name, ax in picture.charts.items():
        line = next(line for line in ax.get_lines() if line.get_label().endswith(WORDS.get(name[2:], "Y")))
        scale = MM if name == "Y" else KN
        assert ("mm" if name == "Y" else "kN") in ax.get_ylabel() + ax.get_title(loc="left")
        np.testing.assert_allclose(line.get_ydata(), scale*raw.c[name], rtol=1e-12)
        np.testing.assert_allclose(line.get_xdata(), 1e3*raw.t, rtol=1e-12)
    for contact in "LF", "RF":
        k = raw.first_peak(contact)
        text = "\n".join(words for _, words, *_ in picture.words(raw.t[k])) + "\n" + words_of(picture.figure)
        lines = [Line(r"^ *(\S+) ms   1:1,000$", "time [ms], at the speed asked for", lambda w, k=k: 1e3*raw.t[k]),
                 Line(r"^Y (\S+) mm,  Z (\S+) mm,  Φ (\S+) mrad", "pose [mm, mm, mrad]",
                      lambda w, k=k: [1e3*raw.c[name][k] for name in ("Y", "Z", "roll")]),
                 Line(r"flange (\S+) kN at (\S+)°", "force [kN], angle [deg]",
                      lambda w, k=k, c=contact: (KN*raw.c[f"N_{c}"][k], DEG*raw.c[f"angle_{c}"][k]))]
        assert differing(text, lines, world, [r"^Exercise \d", r"^\d+ (?:mm|kN)$"]) == []        # test_film.py has the scales
        below = {}
        for (x, _), text, *_ in list(picture.words(raw.t[k]))[2:]:
            scene = next(scene for scene in picture.scenes[1:] if scene.ax.get_position().x0 < x < scene.ax.get_position().x1)
            below["left" if min(scene.ax.get_xlim()) > 0 else "right"] = text
        side, other = ("left", "right") if contact == "LF" else ("right", "left")
        assert "flange" in below[side] and "flange" not in below[other]


@pytest.mark.parametrize("contact", ["LF", "RF"])
def test_pressure(contact: str, world: World, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Every number that the command prints of a patch; its place is that of the contact, in the frame of the track."""
    raw, k = world.thrown, world.thrown.first_peak(contact)
    assert main(["pressure", str(raw.file), "--at", f"{raw.t[k]:.9g}", "--contact", contact, "-o", str(tmp_path/"p.pdf")]) == 0
    said = capsys.readouterr().out.replace(str(tmp_path), "")
    force, area = raw.c[f"N_{contact}"][k], float(re.search(r"area (\S+) mm", said)[1])
    length = float(re.search(r", (\S+) mm along", said)[1])
    lines = [
        Line(r"t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
        Line(r"flange: (\S+) kN at a contact angle of (\S+)°", "force [kN], angle [deg]",
             lambda w: (KN*force, DEG*abs(raw.c[f"angle_{contact}"][k]))),
        Line(r"largest pressure (\S+) MPa", "largest pressure [MPa]", lambda w: force/area/FULLNESS[0], 0.05),
        Line(r"mean (\S+) MPa", "mean pressure [MPa]", lambda w: force/area, 0.04),
        Line(r"curved patch (\S+) kN", "integral of the pressure [kN]", lambda w: KN*force, 0.04),
        Line(r"area (\S+) mm², (\S+) mm along the rail, (\S+) mm across", "area [mm2], length, width [mm]: nearly an ellipse",
             lambda w: (area, length, 4*area/np.pi/length), 0.25),
        Line(r"overlap (\S+) mm", "approach [mm]", lambda w: MM*raw.overlap(contact, k), 4e-3),
        Line(r"track at y (\S+) mm", "centre y in the track [mm]", lambda w: MM*raw.c[f"y_{contact}"][k], 3e-3),
        Line(r", z (\S+) mm", "centre z in the track [mm]", lambda w: MM*raw.c[f"z_{contact}"][k], 0.15)]
    assert differing(said, lines, world, [r"^ex2_aw", r"  Hertz's ellipse .*"]) == []
    length, width, largest = map(float, re.search(r"integral: (\S+) mm x (\S+) mm, (\S+) MPa", said).groups())
    integral = float(re.search(r"patch (\S+) kN", said)[1])
    assert largest*np.pi*length*width/6 == pytest.approx(1e3*integral, rel=5e-3)
    with ldbench_style():
        text = words_of(pressure_page(run := world.run("ex2_aw"), k, run_patches(run, k, [contact])))
    lines = [*table.words_of_a_page(raw, text)[0],
             Line(r"pressure at t = (\S+) s", "moment [s]", lambda w: raw.t[k]),
             Line(r"^(\S+) kN at (\S+)°, ∫p dA (\S+) kN on (\S+) mm²$", "force [kN], angle [deg], integral [kN], area [mm2]",
                  lambda w: (KN*force, DEG*abs(raw.c[f"angle_{contact}"][k]), integral, area), 1e-4),
             Line(r"^largest (\S+) MPa, mean (\S+) MPa, Hertz (\S+) MPa on (\S+) mm²", "pressures [MPa], area [mm2]",
                  lambda w: (force/area/FULLNESS[0], force/area, largest, np.pi*length*width/4), 0.05)]
    assert differing(text, lines, world, table.PAGE_LABELS) == []


# Every place -------------------------------------------------------------------------------

def test_every_command_and_place_has_its_lines():
    """A command that shows numbers is in the table, here or with the test that compares its numbers."""
    assert set(table.PLACES) >= set(COMMANDS)
    root = Path(__file__).parents[1]
    for place, tests in table.PLACES.items():
        for name in tests:
            file, _, test = name.partition("::")
            assert f"def {test}(" in (root/file).read_text(), (place, name)
