"""Charts and scene of the page: zooms, axes, other columns, saving, a second cursor, alignment, fit, gaps and links."""
from __future__ import annotations

import csv
import io
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from browser import Browser, go
from specimen import World

SAVED = """window.saved = []; URL.createObjectURL = blob => { window.saved.push(blob); return 'blob:none'; };
  HTMLAnchorElement.prototype.click = function () { window.savedName = this.download; }"""


def drag(browser: Browser, start: tuple[float, float], end: tuple[float, float], modifiers: int = 0) -> None:
    browser.mouse("mousePressed", *start, modifiers=modifiers)
    browser.mouse("mouseMoved", *np.mean([start, end], axis=0), modifiers=modifiers)
    browser.mouse("mouseMoved", *end, modifiers=modifiers)
    browser.mouse("mouseReleased", *end, modifiers=modifiers)


def numbers(text: str) -> list[float]:
    return [float(word) for word in text.replace("−", "-").replace("(", " ").replace(")", " ").split()
            if word.lstrip("+-").replace(".", "").replace("e-", "").isdigit()]


def settled(browser: Browser) -> str:
    """The address once it is written."""
    browser.run("ldbench.address.written = null; ldbench.write()")
    browser.wait(lambda: browser.run("return ldbench.address.written") is not None)
    return browser.run("return location.hash")


def test_scrub_and_zoom(browser: Browser, report: Path):
    """The pointer scrubs, the wheel zooms; a box zooms with ctrl and with the button of the chart, a double click goes back."""
    browser.open(report, "#t=0")
    left, right, top, bottom = browser.box_of(1)
    end, scale = browser.run("return [ldbench.end, ldbench.charts[1].scale]")
    a, b = (left + 0.2*(right - left), top + 0.1*(bottom - top)), (left + 0.3*(right - left), top + 0.6*(bottom - top))
    drag(browser, a, b, modifiers=2)
    browser.wait(lambda: browser.run("return ldbench.window[1] - ldbench.window[0]") < 0.2*end)
    np.testing.assert_allclose(browser.run("return ldbench.window"), [0.2*end, 0.3*end], rtol=1e-6)
    span = scale["high"] - scale["low"]
    np.testing.assert_allclose(browser.run("return ldbench.charts[1].limits"),
                               [scale["low"] + 0.4*span, scale["low"] + 0.9*span], rtol=1e-6)
    assert browser.run("return ldbench.t") == 0                     # the box is no scrub
    for kind, count in (("mousePressed", 1), ("mouseReleased", 1), ("mousePressed", 2), ("mouseReleased", 2)):
        browser.mouse(kind, *a, clickCount=count)
    browser.wait(lambda: browser.run("return ldbench.charts[1].limits === null && ldbench.window[1]") == end)
    drag(browser, a, b)
    browser.wait(lambda: browser.run("return ldbench.t") == pytest.approx(0.3*end, abs=2e-4))
    browser.mouse("mouseWheel", *b, pressed=False, deltaX=0, deltaY=-120)
    browser.wait(lambda: browser.run("return ldbench.window[1] - ldbench.window[0]") < 0.8*end)
    browser.run("ldbench.charts[1].card.querySelector('[title^=zoom]').click()")
    drag(browser, b, a)
    browser.wait(lambda: browser.run("return ldbench.charts[1].limits !== null"))


def test_one_column_over_another(browser: Browser, report: Path, world: World):
    """N against Y: a point follows the time, the pointer tells the row, and a click goes there."""
    c, k = world.thrown.c, world.thrown.first_peak("LF")
    browser.open(report)
    browser.run("""const [, chart] = ldbench.charts; chart.card.querySelector('[title^=axes]').click();
      const select = chart.menu.querySelector('select[aria-label="horizontal axis"]'); select.value = 'Y'; select.onchange()""")
    go(browser, c["time"][k])
    across, up, px = browser.run("""const [, chart] = ldbench.charts, {box} = chart, [low, high] = chart.across;
      const at = chart.pointAt(chart.curves[0], ldbench.t);
      return [low + (high - low)*(at[0] - box.left)/(box.right - box.left), chart.scale.value(at[1]), at]""")
    assert (across, up) == pytest.approx((1e3*c["Y"][k], 1e-3*c["N_LF"][k]), rel=1e-6)
    left, _, top, _ = browser.box_of(1)
    box = browser.run("return ldbench.charts[1].box")
    place = left - box["left"] + px[0], top - box["top"] + px[1]
    go(browser, 0.0)
    browser.mouse("mouseMoved", *place, pressed=False)
    text = browser.wait(lambda: browser.run("const tip = ldbench.charts[1].hover.box; return !tip.hidden && tip.innerText"))
    assert numbers(text.splitlines()[1])[-1] == pytest.approx(1e-3*c["N_LF"][k], rel=0.02)
    browser.mouse("mousePressed", *place)
    browser.mouse("mouseReleased", *place)
    browser.wait(lambda: abs(browser.run("return ldbench.t") - c["time"][k]) < 1e-3)
    assert browser.log() == []


def test_derived_columns(browser: Browser, report: Path, world: World):
    """What two columns make, and a sum of all contacts: the numbers are those of the file's columns."""
    c = world.thrown.c
    browser.open(report)
    for name, x in (("N_LT+N_LF", c["N_LT"] + c["N_LF"]), ("N_LT-N_RT", c["N_LT"] - c["N_RT"]),
                    ("E_drift/KE_lat", c["E_drift"]/c["KE_lat"]), ("Y*vY", c["Y"]*c["vY"]),
                    ("Fy_sum", sum(c[f"Fy_{contact}"] for contact in ("LT", "LF", "RT", "RF")))):
        found = browser.run("ldbench.runs[0].column(arguments[0]); return [...ldbench.runs[0].exact[arguments[0]]]", name)
        np.testing.assert_allclose(np.array(found, float), x, rtol=1e-12, atol=1e-12*np.nanmax(np.abs(x)), err_msg=name)
    assert browser.run("return ['Y+N_LT', 'Y', 'Y+', '+Y', 'Y/nothing'].map(name => Boolean(ldbench.runs[0].column(name)))") == [
        False, True, False, False, False]
    # By hand: two columns and a sign in the choice of columns. Unlike units have no sum.
    make = """const {picker} = ldbench.charts[0], [a, sign, b] = picker.maker.querySelectorAll('select');
      [a.value, sign.value, b.value] = arguments; picker.maker.querySelector('button').click()"""
    browser.run("""ldbench.charts[0].card.querySelector('[title="choose columns"]').click()""")
    browser.run(make, "N_LT", "/", "N_RT")
    assert browser.run("return ldbench.charts[0].names")[0] == "N_LT/N_RT"
    assert any(words.startswith("normal force, left tread / ") for words in browser.texts("#charts section:first-child .legend li"))
    browser.run(make, "N_LT", "+", "Y")
    assert "one unit" in browser.run("return ldbench.charts[0].picker.maker.textContent") and browser.log() == []


def test_save_a_chart(browser: Browser, report: Path, world: World):
    """As SVG that can be read, as PNG, and its rows with all digits as CSV."""
    c = world.thrown.c
    browser.open(report, "#w=0.01,0.08")
    browser.run(SAVED)
    browser.run("document.querySelectorAll('#charts > section')[1].querySelector('[title^=axes]').click()")

    def saved(kind: str) -> str:
        browser.run("""window.saved = []; [...ldbench.charts[1].menu.querySelectorAll('button')]
          .find(button => button.textContent === arguments[0]).click()""", kind)
        browser.wait(lambda: browser.run("return window.saved.length"))
        browser.run("window.text = null; window.saved[0].text().then(text => { window.text = text; })")
        browser.wait(lambda: browser.run("return window.text !== null"))
        assert browser.run("return window.savedName") == f"ex2_aw_N_LF_N_RF.{kind.lower()}"
        return browser.run("return window.text")

    picture = ElementTree.fromstring(saved("SVG"))
    words = " ".join(text for text in picture.itertext() if text.strip())
    assert "normal force, left flange" in words and "kN" in words
    colour = browser.run("return ldbench.colour.of('LF')")
    paths = [path.get("d") for path in picture.iter("{http://www.w3.org/2000/svg}path") if path.get("stroke") == colour]
    assert max(map(len, paths)) > 500
    saved("PNG")
    width, height = browser.run("""window.done = null;
      createImageBitmap(window.saved[0]).then(b => { window.done = [b.width, b.height]; });
      return [ldbench.charts[1].w, ldbench.charts[1].h]""")
    done = browser.wait(lambda: browser.run("return window.done"))
    assert done[0] == 3*width and done[1] > 3*height
    head, *rows = csv.reader(io.StringIO(saved("CSV")))
    inside = (c["time"] >= 0.01) & (c["time"] <= 0.08)
    assert head == ["run", "time [s]", "N_LF [N]", "N_RF [N]"]
    np.testing.assert_array_equal([[float(word) for word in row[1:]] for row in rows],
                                  np.column_stack([c[name][inside] for name in ("time", "N_LF", "N_RF")]))
    assert browser.log() == []


def test_a_second_cursor_and_the_difference(browser: Browser, report: Path, world: World):
    c = world.thrown.c
    browser.open(report)
    a, b = (float(c["time"][k]) for k in (100, 400))
    go(browser, a)
    browser.press("m")
    go(browser, b)
    assert browser.run("return ldbench.charts.every(chart => !chart.second.hidden)")
    assert numbers(browser.text("#apart"))[0] == pytest.approx(1e3*(b - a), rel=1e-5)
    apart = 1e3*(c["Y"][400] - c["Y"][100])
    assert numbers(browser.text("#charts section:first-child .legend b")) == pytest.approx([1e3*c["Y"][400], apart], rel=1e-4)
    row = browser.run("""const row = [...document.querySelectorAll('#values tr')].find(row => row.firstChild.title === 'Y');
      return [...row.children].map(cell => cell.textContent)""")
    assert numbers(row[2])[0] == pytest.approx(apart, rel=1e-5)
    go(browser, a)
    browser.press("m")
    assert browser.run("return ldbench.mark === null && ldbench.charts.every(chart => chart.second.hidden)")


def test_cursors_stay_at_their_times_on_paper(browser: Browser, report: Path):
    """Paper is narrower than the window: it stretches a chart that is drawn already, and the cursor goes with it."""
    browser.open(report)
    share = """ldbench.go(0.3*ldbench.end);
      const [chart] = ldbench.charts, left = chart.canvas.getBoundingClientRect().left;
      return [(chart.cursor.getBoundingClientRect().left + 0.75 - left)/chart.canvas.clientWidth, chart.x(ldbench.t)/chart.w]"""
    there, drawn = browser.run(share)
    assert there == pytest.approx(drawn, abs=2e-3)
    browser.run("document.querySelector('main').style.width = '700px'")
    narrow, _ = browser.run(share.split(";", 1)[1])
    assert narrow == pytest.approx(there, abs=2e-3)


def test_runs_are_aligned_at_the_first_flange_contact(browser: Browser, two: Path, world: World):
    raws = world.thrown, world.faster
    first, other = (raw.start("LF") for raw in raws)
    browser.open(two)
    browser.press("a")
    assert browser.run("return ldbench.runs.map(run => run.shift)") == pytest.approx([0, first - other])
    go(browser, first + 1e-3)
    expected = [np.interp(t + 1e-3, raw.t, raw.c["Y"]) for t, raw in zip((first, other), raws, strict=True)]
    np.testing.assert_allclose(browser.run("return ldbench.runs.map(run => run.at('Y', ldbench.t))"), expected, rtol=1e-6)
    events = browser.run("return ldbench.events.listed.filter(e => e.what === 'left flange contact').map(e => e.t)")
    assert events[0] == pytest.approx(events[1], abs=1e-9)
    # The row that the table shows is told by the time of its file.
    times = [float(text) for text in browser.texts("#values tbody tr:first-child td")[:2]]
    assert abs(times[1] - (other + 1e-3)) < 1e-4
    browser.press("a")
    assert browser.run("return [...ldbench.runs[1].t]") == raws[1].t.tolist()


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


# The scene ---------------------------------------------------------------------------------

def test_fit_holds_an_overturned_wheelset(browser: Browser, report: Path):
    browser.open(report, "#run=ex5_aw")
    corners = """const [run] = ldbench.runs, {scene} = ldbench, shape = ldbench.shapes[run.shape];
      const pose = scene.poseOf(run, shape, ldbench.t), found = [];
      for (const [outline, side] of [[shape.left, 1], [shape.right, -1]]) {
        for (const [u, v] of outline.wheel) for (const z of [v, -v]) found.push(scene.px(...scene.placed(run, pose, [side*u, z])));
        for (const [y, z] of outline.rail) found.push(scene.px(side*y, z));
      }
      return [scene.w, scene.h, found]"""

    def filled() -> float:
        """The share of the scene that wheels and rails need in width or height; more than 1 if they are not inside."""
        w, h, points = browser.run(corners)
        points = np.array(points)/[w, h]
        return np.ptp(points, axis=0).max() if np.all((points >= 0) & (points <= 1)) else np.inf

    browser.run("ldbench.go(ldbench.end)")
    assert filled() > 1
    browser.press("4")
    assert 0.6 < filled() < 1
    browser.run("ldbench.go(0)")
    browser.press("1", "4")
    assert filled() < 1


def test_small_gaps_are_exaggerated_with_a_badge(browser: Browser, report: Path, world: World):
    """A gap of some hundredths of a millimetre is drawn so many times as large, and words say so."""
    gap = """const [run] = ldbench.runs, {scene} = ldbench, shape = ldbench.shapes[run.shape], pose = run.pose(ldbench.t);
      const found = scene.lateralGap(shape.left, run, pose, 1), drawn = scene.poseOf(run, shape, ldbench.t);
      return [found.gap, found.rail - scene.placed(run, drawn, found.point)[0]]"""
    choose = "const select = document.querySelector(arguments[0]); select.value = arguments[1]; select.onchange()"
    browser.open(report, f"#t={world.thrown.start('LF') - 1e-5}&view=left")
    true, drawn = browser.run(gap)
    assert 0 < true < 1e-4 and drawn == pytest.approx(true) and browser.run("return ldbench.scene.badge") == ""
    browser.run(choose, "#exaggerate-gap", "20")
    true, drawn = browser.run(gap)
    assert drawn == pytest.approx(20*true, rel=0.2) and browser.run("return ldbench.scene.badge") == "not to scale: small gaps × 20"
    browser.run(choose, "#exaggerate-displacement", "5")
    assert browser.run("return ldbench.scene.badge") == "not to scale: displacement × 5, small gaps × 20"
