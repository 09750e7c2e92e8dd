"""What the page of a run shows: each cell of the table of values, each tooltip, patch, event and colour, from the rows."""
from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from browser import Browser, facts, go
from ldbench.__main__ import main
from ldbench.results.run_data import read_data
from ldbench.viewer.page import distinct, make_page
from reading import Line, differing, value
from running import Run
from specimen import World
from table import COLUMNS, CONTACTS, CRC, PRESSED, RESULTS, WORDS, fits_contact

SMALL = {"nJ": 1e9, "µJ": 1e6}      # units of charts whose energies are small


@pytest.fixture
def page(browser: Browser, report: Path) -> Browser:
    """The page of the report, in a tall window."""
    browser.size(1366, 2400)
    browser.open(report)
    return browser


def number(text: str) -> float:
    return value(text)[0]


def test_rows_and_patches(page: Browser, world: World):
    """Each cell at the peaks of both flanges, with its words and its unit; largest pressure and area beside the pressed patch."""
    raw = world.thrown
    (entry, _) = facts(world.outputs/"ldbench_results.html")["runs"]
    for contact in PRESSED:
        k = raw.first_peak(contact)
        go(page, raw.t[k])
        rows = [row for row in page.run("return [...document.querySelectorAll('#values tbody tr')].map(row => "
                                        "[...row.children].map(cell => cell.textContent))") if len(row) == 4]
        assert rows.pop(0)[::3] == ["time of the row", "s"]
        assert {words for words, *_ in rows} == set(COLUMNS)
        for words, text, _, unit in rows:
            column, expected, scale = COLUMNS[words]
            x = scale*raw.c[column][k]
            assert unit == expected, words
            assert text == "–" if np.isnan(x) else number(text) == pytest.approx(x, rel=1e-6, abs=1e-12), (words, text, x)
        label = page.run("return document.querySelector('#pressure').getAttribute('aria-label')")
        pressure, area = re.search(rf"{contact} (\S+) MPa, (\S+) mm²", label).groups()
        fits_contact(raw, contact, k, 1e6*float(pressure), 1e-6*float(area))
        painted = page.run("""const c = document.querySelector('#pressure'), g = c.getContext('2d');
          return g.getImageData(0, 0, c.width, c.height).data.filter((v, k) => k % 4 === 3 && v > 50).length""")
        assert painted > 300 and not page.run("return document.querySelector('#patches').hidden")
    for patch in (patch for moment in entry["pressure"] for patch in moment["patches"]):
        # The outline that is drawn has the area that is told.
        assert max(patch["p"]) in (98, 99) and min(patch["p"]) >= 0 and max(patch["w"]) <= 99
        assert 2*patch["x"]*np.sum(patch["w"])/99*patch["s"]/len(patch["w"]) == pytest.approx(patch["area"], rel=0.03)
    go(page, 0.0)
    assert page.run("return document.querySelector('#patches').hidden")


def test_tooltip_of_every_curve(page: Browser, world: World):
    """The time of a row, and for each curve of the legend its value and unit then."""
    raw = world.thrown
    share = 0.1335
    for k in range(page.run("return ldbench.charts.length")):
        left, right, top, bottom = page.box_of(k)
        page.mouse("mouseMoved", left + share*(right - left), (top + bottom)/2, pressed=False)
        time, *values = page.wait(lambda k=k: page.run(
            "const tip = ldbench.charts[arguments[0]].hover.box; return !tip.hidden && tip.innerText", k)).splitlines()
        t = float(time.split()[0])
        row = int(np.abs(raw.t - t).argmin())
        assert raw.t[row] == pytest.approx(t, abs=6e-7) and abs(t/raw.t[-1] - share) < 0.01
        legend = page.run("""const section = document.querySelectorAll('#charts > section')[arguments[0]];
          return [...section.querySelectorAll('.legend li')].map(item => item.textContent)""", k)
        for words, text in zip(legend, values, strict=True):
            column, expected, scale = COLUMNS[max((name for name in COLUMNS if words.startswith(name)), key=len)]
            shown, unit = text.split(" ")
            assert unit == expected or (expected == "J" and unit in SMALL), words
            assert number(shown) == pytest.approx(SMALL.get(unit, scale)*raw.c[column][row], rel=1e-5, abs=1e-12), (words, text)


def test_every_number_of_the_page(page: Browser, world: World):
    """All that stands on the page at the peak of the left flange, except choices of scale and speed."""
    raw = world.thrown
    k = raw.first_peak("LF")
    go(page, raw.t[k])
    text = page.run("return document.body.innerText").replace("\t", " ").replace("−", "-")

    def legend(_: object, match: re.Match[str]) -> float:
        column, _, scale = COLUMNS[match[0].partition("\n")[0]]
        return SMALL.get(match[0].rpartition(" ")[2], scale)*raw.c[column][k]

    def event(_: object, match: re.Match[str]) -> float:
        return next(t for t, kind, _ in raw.events if kind == match[0].partition(" s ")[2] and abs(t - float(match[1])) < 1e-5)

    def unlisted(_: object, match: re.Match[str]) -> int:
        kind = match[0].split("\u201c")[1].split("\u201d")[0]
        return raw.lift_offs(kind[0].upper(), kind.endswith("landing")) - sum(kind == what for _, what, _ in raw.events)

    lines = [
        Line(r"vertical displacement (\S+) m, initial lateral velocity (\S+) m/s", "initial Z [m], vY [m/s]",
             lambda w, m: (raw.c["Z"][0], raw.c["vY"][0]), often=True),
        Line(r"^Y (\S+) mm, Z (\S+) mm, Φ (\S+) mrad$", "pose", lambda w: [1e3*raw.c[name][k] for name in ("Y", "Z", "roll")]),
        Line(r"^time of the row (\S+) s$", "moment [s]", lambda w: raw.t[k]), Line(r"^(\S+) s$", "clock [s]", lambda w: raw.t[k]),
        Line(rf"^(?:{'|'.join(COLUMNS)})\n(\S+) \S+$", "legends of the charts", legend, 1e-6, often=True),
        Line(r"^(\S+) s (?!largest)[a-z -]+$", "events [s]", event, often=True),
        Line(r"^(\d+) more of .*$", "events that are not listed", unlisted, often=True),
        *(Line(rf"^(\S+) s,? largest normal force, {words}, (\S+) kN$", "largest force and when",
               lambda w, m, c=contact: (raw.peak(c)[1], 1e-3*raw.peak(c)[0]), often=True)
          for words, contact in CONTACTS.items()),
        Line(r"^largest pressure: (\S+) MPa, right flange, at (\S+) s, y (\S+) mm, z (\S+) mm", "largest pressure, when and where",
             lambda w: [scale*raw.result(name) for name, scale in (
                 ("pmax", 1e-6), ("t_pmax", 1), ("pmax_y", 1e3), ("pmax_z", 1e3))]),
        Line(r"^(\S+) s largest pressure, right flange, (\S+) MPa$", "largest pressure and when",
             lambda w: (raw.result("t_pmax"), 1e-6*raw.result("pmax")))]
    rows = [result.words for result in RESULTS.values()] + [words for both in PRESSED.values() for words in both]
    labels = [CRC, r"wheel and rail as bodies .*$",         # variations of the case, of which its rows know nothing
              *(rf"^{re.escape(words)} .*$" for words in (*rows, *COLUMNS)),      # the tests of both tables
              r"of 8 twins|up to 3 µm|than 0\.1 %",
              r"^(?:displacement|roll|gap) ×(?:\n\d+)+$", r"^speed(?:\n1:\d+)+$", r"^Exercise \d"]
    assert differing(text, lines, world, labels) == []


def test_cells_and_peaks_of_the_table_open_their_row(page: Browser, world: World, report: Path):
    """In the table of all runs and in the list of events."""
    raw = world.pushed
    force, t = raw.peak("LF")
    line = page.texts("#summary tbody th").index("peak N, left flange [kN]")
    page.run("document.querySelectorAll('#summary tbody tr')[arguments[0]].children[2].firstChild.click()", line)
    page.wait(lambda: page.text("#clock") == f"{t:.6f} s")
    assert page.run("return ldbench.runs.map(run => run.name)") == ["ex5_aw"]
    for contact, words in WORDS.items():
        force, t = raw.peak(contact)
        if force:
            page.run("""const list = document.querySelector('#events'), [what] = arguments;
              list.value = [...list.options].find(o => o.textContent.includes(what)).value; list.onchange()""",
                     f"largest normal force, {words}")
            page.wait(lambda t=t: abs(page.run("return ldbench.t") - t) < 1e-8)
            assert float(page.text(f"#values td[data-column=N_{contact}]")) == pytest.approx(1e-3*force, rel=5e-7), words
    page.click("#runs label:nth-child(1) input")        # and the other run over it
    page.wait(lambda: page.run("return ldbench.runs.map(run => run.name)") == ["ex2_aw", "ex5_aw"])
    page.is_quiet(report)


@pytest.mark.parametrize("dark", [False, True])
def test_left_is_blue_and_right_is_orange(dark: bool, browser: Browser, report: Path):
    """In every chart of one run, the elastic energies too; other curves have neither colour."""
    browser.size(1366, 860, dark)
    browser.open(report)
    looks = browser.run("return ldbench.charts.flatMap(chart => chart.lines().map(l => [l.column.name, l.colour]))")
    assert {"PE_elastic_L", "PE_elastic_R", "N_LF", "N_RT", "Y"} <= {name for name, _ in looks}
    for name, colour in looks:
        red, blue = (int(colour[k:k + 2], 16) for k in (1, 5))
        side = name.rpartition("_")[2][:1] if name[-2:] in ("LT", "LF", "RT", "RF", "_L", "_R") else ""
        assert {"L": blue > red + 60, "R": red > blue + 60, "": abs(red - blue) < 60}[side], name


# The longest run, of which not all rows are kept -----------------------------------------

@pytest.mark.slow
def test_a_long_run(browser: Browser, whole_ramps: Mapping[str, Run], ex5: Path):
    """Kept rows have all digits; between them the table says what is known about the row of that time, never another row; the
    scene has all rows, charts the smallest and largest value of some."""
    run = whole_ramps["ex5_aw"]
    times = run.columns["time"]
    assert run.file.stat().st_size > 90e6 and ex5.stat().st_size < 6e6
    browser.open(ex5)
    browser.is_quiet(ex5)
    kept = np.array(browser.run("return [...ldbench.runs[0].t]"))
    peaks = [times[np.argmax(run.columns[f"N_{c}"])] for c in ("LT", "LF", "RT")]
    assert np.isin(kept, times).all() and np.isin(peaks, kept).all()
    dropped = times[~np.isin(times, kept)]
    sizes = {name: np.ptp(x[~np.isnan(x)]) for name, x in run.columns.items() if not np.isnan(x).all()}
    browser.run("document.querySelector('#digits').checked || document.querySelector('#digits').click()")
    for t in (*peaks, *dropped[np.linspace(0, len(dropped) - 1, 6).astype(int)]):
        go(browser, t)
        assert browser.run("return document.querySelector('#between').hidden") == (t in peaks)
        row = np.searchsorted(times, t)
        for name, text in browser.run("return [...document.querySelectorAll('#values td[data-run]')]"
                                      ".map(cell => [cell.dataset.column, cell.textContent])"):
            x = run.columns[name][row]
            if t in peaks:
                assert text == "NaN" if np.isnan(x) else float(text) == x, name
            elif text.startswith("≈"):
                figures, _, exponent = text[2:].partition("E")
                unit = 10.0**(int(exponent) - len(figures.partition(".")[2]))
                assert abs(float(text[1:]) - x) <= unit*(1 + 1e-9), name
            elif "…" in text:
                low, high = (float(word) for word in text.split("…"))
                assert low <= x <= high, name
            else:       # a constant, the column's least value, or none
                assert text == "NaN" if np.isnan(x) else float(text) == x, f"{name}: {text}"
    bands = browser.run("""const run = ldbench.runs[0]; run.column('LV_L');
      return {Y: [...run.tracks.Y], N_LF: [...run.tracks.N_LF], bin: run.bin,
              ...Object.fromEntries(['aY', 'LV_L'].map(name => [name, [[...run.bands[name].low], [...run.bands[name].high]]]))}""")
    for name in "Y", "N_LF":
        np.testing.assert_allclose(bands[name], run.columns[name], atol=1e-4*sizes[name])
    c, edges = run.columns, np.arange(0, len(times), bands["bin"])
    with np.errstate(all="ignore"):
        load = c["Fz_LT"] + c["Fz_LF"]
        ratio = np.where(load > 0, -(c["Fy_LT"] + c["Fy_LF"])/load, np.nan)
    for name, x in ("aY", c["aY"]), ("LV_L", ratio):
        for found, extreme in zip(bands[name], (np.fmin, np.fmax), strict=True):
            np.testing.assert_allclose(np.array(found, float), extreme.reduceat(x, edges), atol=5e-3*np.nanmax(np.abs(x)))


def test_difference_of_two_long_runs(browser: Browser, world: World, tmp_path: Path):
    """Two files are equal but for their first rows. At rows that the page does not keep every difference in the table, in
    legends and in the chart of differences is zero or holds it, and a value with all digits is that of the file."""
    raw = world.pushed
    lines = raw.text.splitlines(keepends=True)
    first = next(k for k, line in enumerate(lines) if k and not line.startswith("#"))
    (tmp_path/"shorter.txt").write_text("".join(lines[:first] + lines[first + 1:]))
    runs = distinct([world.run("ex5_aw"), read_data(tmp_path/"shorter.txt")])
    browser.open(make_page(runs, beside=runs).write(tmp_path/"page.html"))

    def holds_zero(text: str) -> bool:
        low, *rest = (number(word) for word in text.split(" … "))
        return low <= 0 <= rest[0] if rest else low == 0

    seen = set()
    for k in np.random.default_rng(2).integers(1, len(raw.t), 25):
        go(browser, raw.t[k])
        rows = browser.run("""return [...document.querySelectorAll('#values tr')].filter(row => row.children.length === 5)
          .map(row => [...row.children].map(cell => cell.textContent))""")[2:]
        for words, *values, apart, _ in rows:
            column, _, scale = COLUMNS[words]
            x = scale*raw.c[column][k]
            for text in values:
                if text[0] != "≈" and "…" not in text:
                    assert text == "–" if np.isnan(x) else number(text) == pytest.approx(x, rel=1e-6)
            assert apart == "–" if np.isnan(x) else holds_zero(apart), (words, apart)
            seen.add("…" in apart)
        assert holds_zero(browser.text("#charts section:nth-child(2) .legend b").removesuffix(" mm"))
    assert seen == {False, True}
    drawn = browser.run("""const [a, b] = ldbench.runs, d = ldbench.difference(a, b, 'aY', 0, 10);
      return [[...d.from], [...d.low], [...d.high]]""")
    times, low, high = np.array(drawn, float)
    assert times[0] == raw.t[0] and np.all((low <= 0) & (high >= 0)) and high.max() > 0


def test_approach_is_that_of_the_pressure(browser: Browser, report: Path, world: World, tmp_path: Path,
                                          capsys: pytest.CaptureFixture[str]):
    """At the first peak of each flange, and with a gap before: the words in the scene, and those of `ldbench pressure`."""
    raw = world.thrown
    browser.open(report)
    browser.run("""window.drawn = []; const {fillText} = CanvasRenderingContext2D.prototype;
      CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        window.drawn.push(text); fillText.call(this, text, ...place); }""")

    def told(contact: str, t: float) -> list[list[str]]:
        browser.run("ldbench.look(arguments[0])", {"L": "left", "R": "right"}[contact[0]])
        go(browser, t)
        browser.run("window.drawn = []; ldbench.redrawScene()")
        words = [text.split() for text in browser.run("return window.drawn") if text.endswith(" mm")]
        return [found for found in words if found[0] in ("approach", "gap")]

    for contact in PRESSED:
        t = raw.t[raw.first_peak(contact)]
        assert main(["pressure", str(raw.file), "--at", repr(float(t)), "--contact", contact, "-o", str(tmp_path/"p.png")]) == 0
        approach = float(re.search(r"approach (\S+) mm", capsys.readouterr().out)[1])
        (word, shown, _), = told(contact, t)
        assert word == "approach" and approach > 0.1 and float(shown) == pytest.approx(approach, abs=6e-4), contact
        (word, shown, _), = told(contact, raw.t[np.searchsorted(raw.t, raw.start(contact)) - 3])
        assert word == "gap" and 0 < float(shown) < 1


def test_events_that_the_file_does_not_list_are_told_and_reached(browser: Browser, report: Path, world: World):
    raw, kind = world.pushed, "right wheel landing"
    browser.open(report, "#run=ex5_aw")
    unlisted = raw.lift_offs("R", landings=True) - sum(what == kind for _, what, _ in raw.events)
    assert any(text.startswith(f"{unlisted} more of “{kind}”") for text in browser.texts("#events option[disabled]"))
    times = [t for t, what in browser.run("return ldbench.events.all.map(event => [event.t, event.what])") if what == kind]
    assert len(times) == pytest.approx(raw.lift_offs("R", landings=True), rel=0.03)
    browser.run("ldbench.go(1.0)")
    browser.press("e", "e")
    assert 1.0 < browser.run("return ldbench.t") < 1.2
