"""What the page of a run shows in the browser: each cell of the table of values and each tooltip, from the rows."""
from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
import pytest

from browser import Browser, go, started
from reading import Line, differing
from specimen import World
from table import CRC, PRESSED, RESULTS, fits_contact

# Words and units of the page, and the columns and factors that they stand for.
CONTACTS = {"left tread": "LT", "left flange": "LF", "right tread": "RT", "right flange": "RF"}
PER_CONTACT = {"normal force": ("N", "kN", 1e-3), "vertical force": ("Fz", "kN", 1e-3), "lateral force": ("Fy", "kN", 1e-3),
               "contact angle": ("angle", "°", 180/np.pi), "lateral position": ("y", "mm", 1e3),
               "vertical position": ("z", "mm", 1e3), "rolling radius": ("radius", "mm", 1e3)}
COLUMNS = {
    "distance X": ("X", "m", 1), "lateral displacement Y": ("Y", "mm", 1e3), "vertical displacement Z": ("Z", "mm", 1e3),
    "roll Φ": ("roll", "mrad", 1e3), "pitch Ω": ("pitch", "rad", 1), "forward velocity": ("vX", "m/s", 1),
    "lateral velocity": ("vY", "m/s", 1), "vertical velocity": ("vZ", "m/s", 1), "roll velocity": ("roll_rate", "mrad/s", 1e3),
    "pitch velocity": ("pitch_rate", "rad/s", 1), "lateral acceleration": ("aY", "m/s²", 1),
    "vertical acceleration": ("aZ", "m/s²", 1), "roll acceleration": ("roll_acc", "rad/s²", 1),
    "external lateral force": ("F_ext", "kN", 1e-3), "gyroscopic moment": ("M_gyro", "N·m", 1),
    "kinetic energy, forward": ("KE_long", "J", 1), "kinetic energy, lateral": ("KE_lat", "J", 1),
    "kinetic energy, vertical": ("KE_vert", "J", 1), "kinetic energy, roll": ("KE_roll", "J", 1),
    "kinetic energy, pitch": ("KE_pitch", "J", 1), "potential energy, gravity": ("PE_grav", "J", 1),
    "potential energy, vertical load": ("PE_load", "J", 1), "elastic energy, left wheel": ("PE_elastic_L", "J", 1),
    "elastic energy, right wheel": ("PE_elastic_R", "J", 1), "work of the lateral force": ("W_ext", "J", 1),
    "total energy": ("E_total", "J", 1), "energy drift": ("E_drift", "J", 1),
    **{f"{what}, {where}": (f"{column}_{contact}", unit, scale) for what, (column, unit, scale) in PER_CONTACT.items()
       for where, contact in CONTACTS.items()}}

SMALL = {"nJ": 1e9, "µJ": 1e6}      # units of charts whose energies are small


@pytest.fixture(scope="module")
def page(world: World, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    """The page of the report, in a tall window."""
    with started(tmp_path_factory.mktemp("chromium")) as browser:
        browser.size(1366, 2400)
        browser.open(world.outputs/"ldbench_results.html")
        yield browser


def number(text: str) -> float:
    return float(text.replace("−", "-"))


def test_rows_of_the_page(page: Browser, world: World):
    """Each cell at the peaks of both flanges, with its words and its unit."""
    raw = world.thrown
    for contact in "LF", "RF":
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


def test_patches_of_the_page(page: Browser, world: World):
    """Largest pressure and area beside the picture of a pressed patch, at the peaks of both flanges."""
    raw = world.thrown
    for contact in "LF", "RF":
        k = raw.first_peak(contact)
        go(page, raw.t[k])
        label = page.wait(lambda: page.run("const canvas = document.querySelector('#patches canvas') || "
                                           "document.querySelector('canvas#patches'); return canvas.getAttribute('aria-label')"))
        pressure, area = re.search(rf"{contact} (\S+) MPa, (\S+) mm²", label).groups()
        fits_contact(raw, contact, k, 1e6*float(pressure), 1e-6*float(area))


def test_tooltip_of_every_curve(page: Browser, world: World):
    """The time of a row, and for each curve of the legend its value and unit then."""
    raw = world.thrown
    share = 0.1335
    for k in range(page.run("return ldbench.charts.length")):
        left, right, middle = page.run("""const {canvas, box} = ldbench.charts[arguments[0]];
          canvas.scrollIntoView({block: 'center'}); const place = canvas.getBoundingClientRect();
          return [place.x + box.left, place.x + box.right, place.y + (box.top + box.bottom)/2]""", k)
        page.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
            "type": "mouseMoved", "x": left + share*(right - left), "y": middle, "button": "none", "buttons": 0})
        time, *values = page.wait(lambda k=k: page.run(
            "const tip = ldbench.charts[arguments[0]].hover.box; return !tip.hidden && tip.innerText", k)).splitlines()
        t = float(time.split()[0])
        row = int(np.abs(raw.t - t).argmin())
        assert raw.t[row] == pytest.approx(t, abs=6e-7) and abs(t/raw.t[-1] - share) < 0.01
        legend = page.run("""const section = document.querySelectorAll('#charts > section')[arguments[0]];
          return [...section.querySelectorAll('.legend li')].map(item => item.textContent)""", k)
        assert len(legend) == len(values)
        for words, text in zip(legend, values, strict=True):
            name = max((name for name in COLUMNS if words.startswith(name)), key=len)
            column, expected, scale = COLUMNS[name]
            shown, unit = text.split(" ")
            assert unit == expected or (expected == "J" and unit in SMALL), words
            assert number(shown) == pytest.approx(SMALL.get(unit, scale)*raw.c[column][row], rel=1e-5, abs=1e-12), (words, text)


def test_every_number_of_the_page(page: Browser, world: World):
    """All that stands on the page at the peak of the left flange, except choices of scale and speed."""
    raw = world.thrown
    k = raw.first_peak("LF")
    page.open(world.outputs/"ldbench_results.html")     # without a tooltip of another test
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
        *(Line(rf"^(\S+) s,? largest normal force, {words}, (\S+) {unit}$", "largest force and when",
               lambda w, m, c=contact, f=factor: (raw.peak(c)[1], f*raw.peak(c)[0]), often=True)
          for words, contact in CONTACTS.items()
          for unit, factor in ([("MN", 1e-6)] if raw.peak(contact)[0] > 1e6 else [("kN", 1e-3)]))]
    rows = [result.words for result in RESULTS.values()] + [words for both in PRESSED.values() for words in both]
    labels = [CRC, *(rf"^{re.escape(words)} .*$" for words in (*rows, *COLUMNS)),      # the tests of both tables
              r"moved by 1 µm|than 0\.1 %", r"^(?:displacement|roll|gap) ×(?:\n\d+)+$", r"^speed(?:\n1:\d+)+$", r"^Exercise \d"]
    assert differing(text, lines, world, labels) == []
