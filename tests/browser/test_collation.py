"""The page of a collation: counts and shades of the checks, numbers, and the curves that are drawn, from the files of the codes."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from browser import Browser
from ldbench.__main__ import main
from raw import Raw
from reading import value
from running import once
from specimen import World
from table import MM

CHART = "lateral displacement Y of all codes"
RECORD = """window.drawn = []; let path = [];
  const own = CanvasRenderingContext2D.prototype, {moveTo, lineTo, stroke, beginPath, fillText} = own;
  own.beginPath = function () { path = []; beginPath.call(this); };
  own.moveTo = function (x, y) { path.push([x, y]); moveTo.call(this, x, y); };
  own.lineTo = function (x, y) { path.push([x, y]); lineTo.call(this, x, y); };
  own.stroke = function () { window.drawn.push({chart: this.canvas.getAttribute('aria-label'), colour: this.strokeStyle, path});
    stroke.call(this); };
  own.fillText = function (text, x, y) {
    window.drawn.push({chart: this.canvas.getAttribute('aria-label'), text, x, y, align: this.textAlign});
    fillText.call(this, text, x, y); };
  [...document.querySelectorAll('button')].find(button => button.textContent === 'all').click()"""


@pytest.fixture(scope="module")
def collated(world: World, common: Path) -> Path:
    """Four codes: two sound ones, one whose vertical velocity is twice as large, and one whose file cannot be read."""
    folder = common/"page_collated"
    with once(folder) as first:
        if first:
            for name, raw in ("Alpha", world.thrown), ("Beta", world.faster):
                (folder/"codes"/name).mkdir(parents=True)
                (folder/"codes"/name/"ex2_aw.txt").write_text(plain_rows(raw, 1.0))
            for name, text in ("Delta", plain_rows(world.thrown, 2.0)), ("Gamma", "nothing\n"):
                (folder/"codes"/name).mkdir()
                (folder/"codes"/name/"ex2_aw.txt").write_text(text)
            assert main(["collate", str(folder/"codes"), "-o", str(folder/"out")]) == 0
    return folder


def plain_rows(raw: Raw, factor: float) -> str:
    """The columns under our names, without a header of ours; the vertical velocity by a factor."""
    columns = {name: factor*x if name == "vZ" else x for name, x in raw.c.items()}
    rows = np.column_stack(list(columns.values()))
    return " ".join(columns) + "\n" + "\n".join(" ".join(f"{x:.9e}" for x in row) for row in rows) + "\n"


def test_counts_and_shades_are_those_of_the_checks(browser: Browser, collated: Path, capsys: pytest.CaptureFixture[str]):
    """Each cell has the counts of `check`, in the order of the words above them, and the shade that the legend names so."""
    browser.driver.get((collated/"out/collation.html").as_uri())
    legend = browser.run("""return Object.fromEntries([...document.querySelectorAll('.key')]
      .map(one => [one.textContent, getComputedStyle(one).backgroundColor]))""")
    rows = browser.run("""return [...document.querySelectorAll('#matrix tbody tr')].map(row => [row.firstChild.textContent.trim(),
      row.children[3].textContent, getComputedStyle(row.children[3]).backgroundColor])""")
    assert [name for name, *_ in rows] == ["Alpha", "Beta", "Delta", "Gamma"]
    seen = set()
    for name, text, colour in rows:
        if name == "Gamma":
            assert "cannot be used" in text and colour == legend["file cannot be used"]
            continue
        main(["check", str(collated/f"codes/{name}/ex2_aw.txt"), "--json"])
        told = capsys.readouterr().out
        counts = [told.count(f'"verdict": "{verdict}"') for verdict in ("passed", "doubtful", "failed")]
        assert text.endswith(" / ".join(map(str, counts))), (name, text, counts)
        words = "some failed" if counts[2] else "some doubtful" if counts[1] else "all checks passed"
        assert colour == legend[words], (name, words)
        seen.add(words)
    assert "some failed" in seen


def test_curves_are_those_of_the_files(browser: Browser, collated: Path, world: World):
    """The lateral displacement of each code, by the numbers at the axes, in the colour that stands beside its name."""
    browser.driver.get((collated/"out/collation.html").as_uri())
    browser.run(RECORD)
    drawn = [one for one in browser.wait(lambda: browser.run("return window.drawn")) if one["chart"] == CHART]
    ticks = {align: np.array([[one[at], value(one["text"])[0]] for one in drawn if one.get("align") == align])
             for align, at in (("center", "x"), ("right", "y"))}
    ticks["right"][:, 0] -= 4       # letters stand so much below the line of their number
    across, up = (np.polyfit(*ticks[align].T, 1) for align in ("center", "right"))
    looks = browser.run("""return Object.fromEntries([...document.querySelectorAll('#codes label')].map(label =>
      [label.textContent, getComputedStyle(label.querySelector('path')).stroke]))""")
    assert len(set(looks.values())) == 4
    for name, raw in ("Alpha", world.thrown), ("Beta", world.faster):
        colour = "#{:02x}{:02x}{:02x}".format(*(int(x) for x in looks[name].removeprefix("rgb(").removesuffix(")").split(",")))
        path = np.array(next(one["path"] for one in drawn if "path" in one and one["colour"] == colour))
        t, y = np.polyval(across, path[:, 0]), np.polyval(up, path[:, 1])
        inside = (t > raw.t[0]) & (t < raw.t[-1])
        np.testing.assert_allclose(y[inside], MM*np.interp(t[inside], raw.t, raw.c["Y"]), atol=0.02*np.ptp(MM*raw.c["Y"]))
        assert np.ptp(y) == pytest.approx(np.ptp(MM*raw.c["Y"]), rel=0.02)


def test_numbers_stand_below_their_names(browser: Browser, collated: Path, world: World):
    browser.driver.get((collated/"out/collation.html").as_uri())
    head = browser.run("return [...document.querySelectorAll('#numbers thead th')].map(cell => cell.textContent)")
    rows = browser.run("""return Object.fromEntries([...document.querySelectorAll('#numbers tbody tr')].map(row =>
      [row.firstChild.textContent.trim(), [...row.children].map(cell => cell.firstChild?.textContent ?? '')]))""")
    for name, raw in ("Alpha", world.thrown), ("Beta", world.faster):
        told = dict(zip(head, rows[name], strict=True))
        first = raw.impact("LF")
        for words, expected in (("left flange [ms]", 1e3*first["start"]), ("right flange [ms]", 1e3*raw.impact("RF")["start"]),
                                ("peak [kN]", 1e-3*first["peak"]), ("impulse [kN·s]", 1e-3*first["impulse"])):
            assert float(told[words]) == pytest.approx(expected, rel=0.02), (name, words)
    # The counts are those of the matrix above, which the checks tell, below the words in the same order.
    matrix = browser.run("""return Object.fromEntries([...document.querySelectorAll('#matrix tbody tr')].map(row =>
      [row.firstChild.textContent.trim(), row.children[3].textContent]))""")
    counts = {name: dict(zip(head, row, strict=True))["passed / doubtful / failed"] for name, row in rows.items() if name in matrix}
    assert counts and all(matrix[name].endswith(told) or "cannot" in told for name, told in counts.items())
    assert any(len(set(told.split(" / ")[1:])) == 2 for told in counts.values())
