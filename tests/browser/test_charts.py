"""Charts of the page: hover, zooms, axes, other columns, saving, a second cursor, alignment, loop and links; in a real browser."""
from __future__ import annotations

import csv
import io
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import ldbench
from browser import Browser, go
from ldbench.results.run_data import read_data
from running import Run

BOX = """const chart = ldbench.charts[arguments[0]]; chart.canvas.scrollIntoView({block: 'center'});
  const place = chart.canvas.getBoundingClientRect(), {box} = chart;
  return [place.x + box.left, place.x + box.right, place.y + box.top, place.y + box.bottom]"""
SAVED = """window.saved = []; URL.createObjectURL = blob => { window.saved.push(blob); return 'blob:none'; };
  HTMLAnchorElement.prototype.click = function () { window.savedName = this.download; }"""


def mouse(browser: Browser, kind: str, x: float, y: float, pressed: bool = True, **more: object) -> None:
    browser.driver.execute_cdp_cmd("Input.dispatchMouseEvent", {
        "type": kind, "x": x, "y": y, "button": "left" if pressed else "none", "buttons": int(pressed), "clickCount": 1, **more})


def drag(browser: Browser, start: tuple[float, float], end: tuple[float, float], modifiers: int = 0) -> None:
    mouse(browser, "mousePressed", *start, modifiers=modifiers)
    mouse(browser, "mouseMoved", (start[0] + end[0])/2, (start[1] + end[1])/2, modifiers=modifiers)
    mouse(browser, "mouseMoved", *end, modifiers=modifiers)
    mouse(browser, "mouseReleased", *end, modifiers=modifiers)


def menu(browser: Browser, chart: int) -> None:
    browser.run("document.querySelectorAll('#charts > section')[arguments[0]].querySelector('[title^=axes]').click()", chart)


def numbers(text: str) -> list[float]:
    return [float(word) for word in text.replace("−", "-").replace("(", " ").replace(")", " ").split()
            if word.lstrip("+-").replace(".", "").replace("e-", "").isdigit()]


def settled(browser: Browser) -> str:
    """The address once it is written."""
    browser.run("ldbench.address.written = null; ldbench.write()")
    browser.wait(lambda: browser.run("return ldbench.address.written") is not None)
    return browser.run("return location.hash")


def test_zoom_to_a_box(browser: Browser, one: Path):
    """With ctrl, with the button of the chart, and back by a double click."""
    browser.open(one)
    left, right, top, bottom = browser.run(BOX, 1)
    end, scale = browser.run("return [ldbench.end, ldbench.charts[1].scale]")
    a, b = (left + 0.2*(right - left), top + 0.1*(bottom - top)), (left + 0.3*(right - left), top + 0.6*(bottom - top))
    drag(browser, a, b, modifiers=2)
    browser.wait(lambda: browser.run("return ldbench.window[1] - ldbench.window[0]") < 0.2*end)
    np.testing.assert_allclose(browser.run("return ldbench.window"), [0.2*end, 0.3*end], rtol=1e-6)
    span = scale["high"] - scale["low"]
    np.testing.assert_allclose(browser.run("return ldbench.charts[1].limits"),
                               [scale["low"] + 0.4*span, scale["low"] + 0.9*span], rtol=1e-6)
    assert browser.run("return ldbench.t") == 0                     # the box is no scrub
    mouse(browser, "mousePressed", *a, clickCount=1)
    mouse(browser, "mouseReleased", *a, clickCount=1)
    mouse(browser, "mousePressed", *a, clickCount=2)
    mouse(browser, "mouseReleased", *a, clickCount=2)
    browser.wait(lambda: browser.run("return ldbench.charts[1].limits === null && ldbench.window[1]") == end)
    browser.run("ldbench.charts[1].card.querySelector('[title^=zoom]').click()")
    drag(browser, b, a)
    browser.wait(lambda: browser.run("return ldbench.charts[1].limits !== null"))


def test_one_column_over_another(browser: Browser, one: Path, shipped: dict[str, Run]):
    """N against Y: a point follows the time, the pointer tells the row, and a click goes there."""
    columns = shipped["ex1_aw"].columns
    browser.open(one)
    menu(browser, 1)
    browser.run("""const select = ldbench.charts[1].menu.querySelector('select[aria-label="horizontal axis"]');
      select.value = 'Y'; select.onchange()""")
    k = int(np.argmax(columns["N_LF"]))
    go(browser, columns["time"][k])
    low, high, px = browser.run("""const [chart] = [ldbench.charts[1]], {box} = chart, [low, high] = chart.across;
      const at = ldbench.charts[1].pointAt(chart.curves[0], ldbench.t);
      return [low + (high - low)*(at[0] - box.left)/(box.right - box.left), chart.scale.value(at[1]), at]""")
    assert low == pytest.approx(1e3*columns["Y"][k], rel=1e-6) and high == pytest.approx(1e-3*columns["N_LF"][k], rel=1e-6)
    x, y = browser.run("""const {canvas} = ldbench.charts[1]; canvas.scrollIntoView({block: 'center'});
      const box = canvas.getBoundingClientRect(); return [box.x, box.y]""")
    go(browser, 0.0)
    mouse(browser, "mouseMoved", x + px[0], y + px[1], pressed=False)
    text = browser.wait(lambda: browser.run("const tip = ldbench.charts[1].hover.box; return !tip.hidden && tip.innerText"))
    assert numbers(text.splitlines()[1])[-1] == pytest.approx(1e-3*columns["N_LF"][k], rel=0.02)
    mouse(browser, "mousePressed", x + px[0], y + px[1])
    mouse(browser, "mouseReleased", x + px[0], y + px[1])
    browser.wait(lambda: abs(browser.run("return ldbench.t") - columns["time"][k]) < 1e-3)
    assert browser.run("return ldbench.charts[1].dots.children[0].hidden") is False and browser.log() == []


def test_derived_columns(browser: Browser, one: Path, shipped: dict[str, Run]):
    """What two columns make, and a sum of all contacts: the numbers are those of the file's columns."""
    c = shipped["ex1_aw"].columns
    browser.open(one)
    with np.errstate(all="ignore"):
        expected = {"N_LT+N_LF": c["N_LT"] + c["N_LF"],
                    "N_LT-N_RT": c["N_LT"] - c["N_RT"], "E_drift/KE_lat": c["E_drift"]/c["KE_lat"], "Y*vY": c["Y"]*c["vY"],
                    "Fy_sum": sum(c[f"Fy_{contact}"] for contact in ("LT", "LF", "RT", "RF"))}
    for name, x in expected.items():
        found = browser.run("ldbench.runs[0].column(arguments[0]); return [...ldbench.runs[0].exact[arguments[0]]]", name)
        found = np.array([np.nan if v is None else v for v in found], float)
        finite = np.isfinite(x)
        np.testing.assert_allclose(found[finite], x[finite], rtol=1e-12, atol=1e-12*np.max(np.abs(x[finite])), err_msg=name)
    assert browser.run("return ['Y+N_LT', 'Y', 'Y+', '+Y', 'Y/nothing'].map(name => Boolean(ldbench.runs[0].column(name)))") == [
        False, True, False, False, False]
    # By hand: two columns and a sign in the choice of columns.
    browser.run("""const {picker} = ldbench.charts[0]; ldbench.charts[0].card.querySelector('[title="choose columns"]').click();
      const [a, sign, b] = picker.maker.querySelectorAll('select'); [a.value, sign.value, b.value] = ['N_LT', '/', 'F_ext'];
      if (!b.value) b.value = 'N_RT'; picker.maker.querySelector('button').click()""")
    assert browser.run("return ldbench.charts[0].names")[0].startswith("N_LT/")
    assert browser.texts("#charts section:first-child .legend li")[0].startswith("normal force, left tread / ")
    # Unlike units have no sum.
    browser.run("""const {picker} = ldbench.charts[0], [a, sign, b] = picker.maker.querySelectorAll('select');
      [a.value, sign.value, b.value] = ['N_LT', '+', 'Y']; picker.maker.querySelector('button').click()""")
    assert "one unit" in browser.run("return ldbench.charts[0].picker.maker.textContent")
    assert browser.log() == []


def test_derived_columns_of_a_long_run_cover_all_rows(browser: Browser, shipped: dict[str, Run], ex5: Path):
    """L/V of exercise 5: least and largest value of all rows, not of the kept ones alone."""
    browser.open(ex5)
    c, loads = shipped["ex5_aw"].columns, {}
    for side, outwards in ("L", -1), ("R", 1):
        lateral, vertical = (c[f"{force}_{side}T"] + c[f"{force}_{side}F"] for force in ("Fy", "Fz"))
        with np.errstate(all="ignore"):
            ratio = np.where(vertical > 0, outwards*lateral/vertical, np.nan)
        loads |= {f"Fy_{side}": lateral, f"Fz_{side}": vertical, f"LV_{side}": ratio}
    edges = np.arange(0, len(loads["LV_L"]), browser.run("return ldbench.runs[0].bin"))
    for name, x in loads.items():
        band = browser.run("const {low, high} = ldbench.runs[0].bands[arguments[0]]; return [[...low], [...high]]", name)
        level = np.ptp(x[np.isfinite(x)])/10_000
        for found, ends in zip(band, (np.fmin.reduceat(x, edges), np.fmax.reduceat(x, edges)), strict=True):
            np.testing.assert_allclose(np.array(found, float), ends, rtol=0, atol=level, err_msg=name)
    browser.run("const [chart] = ldbench.charts; chart.names = ['LV_L']; chart.changed()")
    low, high = browser.run("const {low, high} = ldbench.charts[0].scale; return [low, high]")
    assert low <= np.nanmin(loads["LV_L"]) and high >= np.nanmax(loads["LV_L"]) and browser.log() == []


def test_save_a_chart(browser: Browser, one: Path, shipped: dict[str, Run]):
    """As SVG that can be read, as PNG, and its rows with all digits as CSV."""
    columns = shipped["ex1_aw"].columns
    browser.open(one, "#w=0.1,0.2")
    browser.run(SAVED)
    menu(browser, 1)

    def saved(kind: str) -> str:
        browser.run("""window.saved = []; [...ldbench.charts[1].menu.querySelectorAll('button')]
          .find(button => button.textContent === arguments[0]).click()""", kind)
        browser.wait(lambda: browser.run("return window.saved.length"))
        browser.run("window.text = null; window.saved[0].text().then(text => { window.text = text; })")
        browser.wait(lambda: browser.run("return window.text !== null"))
        assert browser.run("return window.savedName") == f"ex1_aw_N_LF_N_RF.{kind.lower()}"
        return browser.run("return window.text")

    picture = ElementTree.fromstring(saved("SVG"))
    words = [text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert "normal force, left flange" in words and "kN" in words
    colour = browser.run("return ldbench.colour.of('LF')")
    paths = [path for path in picture.iter("{http://www.w3.org/2000/svg}path") if path.get("stroke") == colour]
    assert any(len(path.get("d")) > 1000 for path in paths)
    saved("PNG")
    size = browser.run("""window.done = null; createImageBitmap(window.saved[0]).then(b => { window.done = [b.width, b.height]; });
      return [ldbench.charts[1].w, ldbench.charts[1].h]""")
    done = browser.wait(lambda: browser.run("return window.done"))
    assert done[0] == 3*size[0] and done[1] > 3*size[1]
    rows = list(csv.reader(io.StringIO(saved("CSV"))))
    assert rows[0] == ["run", "time [s]", "N_LF [N]", "N_RF [N]"]
    inside = (columns["time"] >= 0.1) & (columns["time"] <= 0.2)
    found = np.array([[float(word) for word in row[1:]] for row in rows[1:]])
    np.testing.assert_array_equal(found, np.column_stack([columns[name][inside] for name in ("time", "N_LF", "N_RF")]))
    assert browser.log() == []


def test_a_second_cursor_and_the_difference(browser: Browser, one: Path, shipped: dict[str, Run]):
    c = shipped["ex1_aw"].columns
    browser.open(one)
    a, b = (float(c["time"][k]) for k in (100, 400))
    go(browser, a)
    browser.press("m")
    go(browser, b)
    assert browser.run("return ldbench.charts.every(chart => !chart.second.hidden)")
    assert numbers(browser.text("#apart"))[0] == pytest.approx(1e3*(b - a), rel=1e-5)
    value, since = numbers(browser.text("#charts section:first-child .legend b"))
    assert value == pytest.approx(1e3*c["Y"][400], rel=1e-5)
    assert since == pytest.approx(1e3*(c["Y"][400] - c["Y"][100]), rel=1e-4)
    row = browser.run("""const row = [...document.querySelectorAll('#values tr')].find(row => row.firstChild.title === 'Y');
      return [...row.children].map(cell => cell.textContent)""")
    assert numbers(row[2])[0] == pytest.approx(1e3*(c["Y"][400] - c["Y"][100]), rel=1e-5)
    go(browser, a)
    browser.press("m")
    assert browser.run("return ldbench.mark") is None and browser.run("return document.querySelector('#apart').hidden")
    assert browser.run("return ldbench.charts.every(chart => chart.second.hidden)")


def test_runs_are_aligned_at_the_first_flange_contact(browser: Browser, two: Path, shipped: dict[str, Run]):
    runs = [read_data(shipped[case].file) for case in ("ex2_aw", "ex2_sw")]
    first, other = (run.first_contact("LF") for run in runs)
    browser.open(two)
    browser.press("a")
    assert browser.run("return ldbench.runs.map(run => run.shift)") == pytest.approx([0, first - other])
    go(browser, first + 1e-3)
    pose = browser.run("return ldbench.runs.map(run => run.at('Y', ldbench.t))")
    expected = [np.interp(t + 1e-3, run.time, run.values("Y")) for t, run in zip((first, other), runs, strict=True)]
    np.testing.assert_allclose(pose, expected, rtol=1e-6)
    events = browser.run("return ldbench.events.listed.filter(e => e.what === 'left flange contact').map(e => e.t)")
    assert events[0] == pytest.approx(events[1], abs=1e-9)
    # The row that the table shows is told by the time of its file.
    times = [float(text) for text in browser.texts("#values tbody tr:first-child td")[:2]]
    assert abs(times[1] - (other + 1e-3)) < 1e-4
    browser.press("a")
    assert browser.run("return [...ldbench.runs[1].t]") == shipped["ex2_sw"].columns["time"].tolist()


def test_a_link_holds_the_whole_state(browser: Browser, two: Path):
    """What one sees is what the link opens, in another window too."""
    browser.open(two)
    browser.press("a")
    browser.run("""ldbench.charts[0].zoomValues(0.5); ldbench.charts[2].setLog(true); ldbench.removeChart(ldbench.charts[1]);
      ldbench.addChart({names: ['N_LF-N_RF', 'N_LT'], over: 'Y', acrossLimits: [2, 8]}).changed();
      ldbench.setWindow(0.01, 0.02); ldbench.setMark(0.015);
      for (const [id, value] of [['gap', 20], ['roll', 5]]) {
        const select = document.querySelector('#exaggerate-' + id); select.value = value; select.onchange(); }
      ldbench.look('left'); ldbench.zoomScene(3); ldbench.panScene(30, 10); ldbench.player.choose(0.001);
      for (const id of ['arrows', 'normals', 'loop']) document.getElementById(id).click();
      ldbench.go(0.0213)""")
    state = """const {scene, player} = ldbench, {camera, settings} = scene, six = x => Number(x.toPrecision(5));
      return JSON.stringify([ldbench.t, ldbench.window.map(six), ldbench.mark, document.querySelector('#align').checked,
        player.looping, player.speed, settings, scene.view, [camera.y, camera.z, camera.width].map(six),
        ldbench.charts.map(({names, mode, over, log, limits, acrossLimits}) =>
          [names, mode, over, log, limits && limits.map(six), acrossLimits])])"""
    before, link = browser.run(state), settled(browser)
    browser.open(two, link)
    assert browser.run(state) == before
    assert settled(browser) == link and browser.log() == []
    # A link of before, to a moment alone, changes nothing else.
    go(browser, 0.02)
    assert browser.run("return ldbench.charts.length") == 5


def test_the_namelist_of_a_run_is_in_its_page(browser: Browser, one: Path, shipped: dict[str, Run]):
    """It can be read and run again."""
    browser.open(one)
    text = browser.text("#about .namelist pre")
    assert ldbench.Case.from_namelist(text).values == read_data(shipped["ex1_aw"].file).case.values
    browser.run(SAVED)
    browser.run("document.querySelector('#about .namelist button').click()")
    assert browser.run("return window.savedName") == "ex1_aw.nml"
