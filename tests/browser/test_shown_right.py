"""What the page shows is right: colours, lines, axes, times, events, many runs; in a real browser."""
from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from browser import Browser, facts, go
from invented import altered
from ldbench.results.run_data import read_data
from ldbench.viewer.page import make_page
from running import CASES, Run

# What a chart draws on its canvas: words with their boxes.
RECORD = """window.words = []; const before = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
    const place = this.getTransform(), k = place.a || 1, width = this.measureText(text).width;
    const left = x - {left: 0, center: width/2, right: width}[this.textAlign];
    if (place.b === 0) window.words.push({text, x, y, left, right: left + width, canvas: this.canvas.parentElement.className});
    before.call(this, text, x, y);
  }"""


def made_run(shipped: dict[str, Run], rows: int, **columns: np.ndarray):
    """A run of so many rows with columns of one's own."""
    import pandas as pd

    run = read_data(shipped["ex2_aw"].file)
    data = pd.DataFrame({"time": np.arange(rows)*1e-4, **columns})
    data.attrs["units"] = {}
    return altered(run, data=data)


def channels(colour: str) -> list[int]:
    return [int(colour[k:k + 2], 16) for k in (1, 3, 5)]


def test_left_is_blue_and_right_is_orange(browser: Browser, one: Path):
    """In every chart of one run, in light and dark, the elastic energies too."""
    try:
        for dark in (False, True):
            browser.size(1366, 860, dark=dark)
            browser.open(one)
            looks = browser.run("return ldbench.charts.flatMap(chart => chart.lines().map(l => [l.column.name, l.colour]))")
            sides = [(name, channels(colour)) for name, colour in looks if name[-2:] in ("LT", "LF", "RT", "RF", "_L", "_R")]
            assert {"PE_elastic_L", "PE_elastic_R", "N_LF", "N_RT"} <= {name for name, _ in sides}
            for name, (red, _, blue) in sides:
                left = name.split("_")[-1].startswith("L")
                assert (blue > red + 60) if left else (red > blue + 60), name
            others = [channels(colour) for name, colour in looks if name in ("Y", "KE_lat", "E_drift")]
            assert all(abs(red - blue) < 60 for red, _, blue in others)
    finally:
        browser.size(1366, 860)


def luminance(rgb: list[int]) -> float:
    linear = [c/12.92 if c <= 0.04045 else ((c + 0.055)/1.055)**2.4 for c in np.array(rgb)/255]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_contrast_of_lines_and_words(browser: Browser, one: Path, dark: bool):
    """At least 4.5:1 to the paper."""
    try:
        browser.size(1366, 860, dark=dark)
        browser.open(one)
        names = ["ink", "muted", "accent", "second", "LT", "LF", "RT", "RF", *(f"series{k}" for k in range(8))]
        found = browser.run("return arguments[0].map(name => ldbench.colour.of(name))", ["paper", *names])
        paper, *colours = (luminance(channels(colour)) for colour in found)
        for name, colour in zip(names, colours, strict=True):
            assert (max(paper, colour) + 0.05)/(min(paper, colour) + 0.05) >= 4.5, name
    finally:
        browser.size(1366, 860)


def test_lines_of_many_rows_hold_together(browser: Browser, shipped: dict[str, Run], tmp_path: Path):
    """Steps between bins of rows, and rows of a long run at steps: no column of pixels lies apart from its neighbour."""
    rows = 20_000
    step = np.where(np.arange(rows) % 2000 < 1000, 1.0, -1.0) + 1e-3*np.sin(np.arange(rows))
    for cells in (10**6, 3000):         # all rows, or bands
        page = make_page([made_run(shipped, rows, step=step)], cells={"ex2_aw": cells}).write(tmp_path/"steps.html")
        browser.open(page)
        spans = browser.run("""const [chart] = ldbench.charts, {canvas, box} = chart, c = chart.lines()[0].colour;
          const g = canvas.getContext('2d'), found = [], [red, green, blue] = [1, 3, 5].map(k => parseInt(c.slice(k, k + 2), 16));
          for (let x = Math.ceil(box.left) + 2; x < box.right - 2; x++) {
            const pixels = g.getImageData(x, box.top, 1, box.bottom - box.top - 1).data;
            let low = -1, high = -1;
            for (let y = 0; y < pixels.length/4; y++) {
              const near = (k, v) => Math.abs(pixels[4*y + k] - v) < 140;
              if (pixels[4*y + 3] > 100 && near(0, red) && near(1, green) && near(2, blue)) { if (low < 0) low = y; high = y; }
            }
            found.push([low, high]);
          }
          return found""")
        assert len(spans) > 400 and all(low >= 0 for low, _ in spans)
        for (low, high), (other_low, other_high) in pairwise(spans):
            assert other_low <= high + 2 and low <= other_high + 2
        tops, bottoms = zip(*spans, strict=True)
        assert min(tops) < 10 and max(bottoms) > 110


def test_axes_have_two_numbers_or_more_that_stand_apart(browser: Browser, one: Path):
    browser.open(one)
    browser.run(RECORD)
    for start, length in ((0, 0.5), (0, 0.011), (0.1, 1e-3), (0.1049, 1e-5), (0.2, 3.7e-7), (0.3, 0.199)):
        words = browser.run("window.words = []; ldbench.setWindow(arguments[0], arguments[1]); return window.words", start, length)
        charts = browser.run("return ldbench.charts.length")
        ends = [word for word in words if word["text"].endswith(" s")]
        assert len(ends) == charts                                      # every chart tells the unit of time once
        bottom = ends[0]["y"]
        below = sorted((word for word in words if word["y"] == bottom), key=lambda word: word["left"])
        assert len(below) >= 2*charts
        groups: dict[str, int] = {}
        for word in below:
            groups[word["text"]] = groups.get(word["text"], 0) + 1
        assert set(groups.values()) == {charts}                         # no number stands twice in a chart
        starts = sorted({word["left"]: word["right"] for word in below}.items())
        assert all(right < left for (_, right), (left, _) in pairwise(starts))
        beside = [word for word in words if word["y"] != bottom]
        assert len(beside) >= 2*charts
        for at in sorted({word["canvas"] for word in beside}):
            assert at == "chart"


def test_values_of_a_long_run_are_those_of_the_clock(browser: Browser, ex5: Path, shipped: dict[str, Run]):
    """Where no row is kept, the table says what is known about the row of that time, and never shows another row."""
    run = shipped["ex5_aw"]
    times = run.columns["time"]
    browser.open(ex5)
    kept = np.array(browser.run("return [...ldbench.runs[0].t]"))
    dropped = times[~np.isin(times, kept)]
    sizes = {name: np.ptp(x[~np.isnan(x)]) for name, x in run.columns.items() if not np.isnan(x).all()}
    browser.run("document.querySelector('#digits').checked || document.querySelector('#digits').click()")
    for t in dropped[np.linspace(0, len(dropped) - 1, 12).astype(int)]:
        go(browser, t)
        assert float(browser.text("#values tbody tr td").strip("≈ ")) == pytest.approx(t, abs=1e-6)
        assert not browser.run("return document.querySelector('#between').hidden")
        row = np.searchsorted(times, t)
        cells = browser.run("return [...document.querySelectorAll('#values td[data-run]')]"
                            ".map(cell => [cell.dataset.column, cell.textContent])")
        for name, text in cells:
            x = run.columns[name][row]
            if text.startswith("≈"):
                assert float(text[1:]) == pytest.approx(x, rel=6e-4, abs=1e-4*sizes[name]), name
            elif "…" in text:
                low, high = (float(word) for word in text.split("…"))
                aside = 1e-3*max(abs(low), abs(high))
                assert low - aside <= x <= high + aside, name
            else:
                assert text == "NaN" and (np.isnan(x) or 0 < run.columns[f"N_{name[-2:]}"][row] < 10), f"{name}: {text}"
    go(browser, kept[5000])
    assert browser.run("return document.querySelector('#between').hidden")


def test_a_peak_opens_the_row_that_has_it(browser: Browser, page_of: Callable[[str], Path]):
    for case in ("ex3_aw", "ex5_aw"):
        page = page_of(case)
        browser.open(page)
        peaks = [event for event in facts(page)["runs"][0]["events"] if event.get("peak")]
        assert len(peaks) >= 3
        names = {"left tread": "N_LT", "left flange": "N_LF", "right tread": "N_RT", "right flange": "N_RF"}
        for event in peaks:
            column = names[event["what"].rpartition(", ")[2]]
            browser.run("""const list = document.querySelector('#events'), [what] = arguments;
              list.value = [...list.options].find(o => o.textContent.includes(what)).value; list.onchange()""", event["what"])
            browser.wait(lambda event=event: abs(browser.run("return ldbench.t") - event["t"]) < 1e-8)
            shown = browser.text(f"#values td[data-column={column}]")
            assert float(shown) == pytest.approx(1e-3*event["peak"], rel=5e-7), event["what"]


def test_events_that_the_file_does_not_list_are_told_and_reached(browser: Browser, ex5: Path, shipped: dict[str, Run]):
    run = read_data(shipped["ex5_aw"].file)
    browser.open(ex5)
    listed = {kind: sum(event.kind == kind for event in run.events) for kind in ("left flange contact", "right wheel landing")}
    options = browser.texts("#events option[disabled]")
    for kind, count in listed.items():
        assert any(option.startswith(f"{run.count(kind) - count} more of “{kind}”") for option in options)
    found = browser.run("return ldbench.events.all.map(event => [event.t, event.what])")
    for kind in listed:
        times = [t for t, what in found if what == kind]
        assert 0.98*run.count(kind) <= len(times) <= 1.001*run.count(kind), kind
        assert np.isin(np.round(times, 9), np.round(run.time, 9)).mean() > 0.99
    go(browser, 5.0)
    at = [5.0]
    for _ in range(4):
        browser.press("e")
        at.append(browser.run("return ldbench.t"))
    assert all(0 < after - before < 0.05 for before, after in pairwise(at))


def test_six_runs_and_more(browser: Browser, all_runs: Path):
    """The names of the quantities can be read, chips and charts show the looks of a run alike, and no two runs look the same."""
    browser.open(all_runs)
    browser.run("document.querySelectorAll('#runs input').forEach(box => box.checked || box.click())")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == len(CASES))
    browser.wait(lambda: len(browser.texts("#charts section:first-child .legend li")) == len(CASES))
    assert browser.run("return document.querySelector('#values tbody th[scope=row]').getBoundingClientRect().width") > 140
    look = ("[...document.querySelectorAll(arguments[0])].map(path => ['stroke', 'stroke-dasharray']"
            ".map(name => path.getAttribute(name)))")
    chips = browser.run("return " + look, "#runs .swatch path")
    assert chips == browser.run("return " + look, "#charts section:first-child .swatch path")
    assert len({tuple(chip) for chip in chips}) == len(CASES) == 10
    looks = browser.run("return Array.from({length: 32}, (_, number) => "
                        "[ldbench.colour.run({number}), ldbench.colour.dash({number}).join()].join())")
    assert len(set(looks)) == 32


def test_two_clicks_within_a_frame_start_one_loop(browser: Browser, one: Path):
    browser.open(one)
    moves = browser.run("""const waiting = []; let now = performance.now(), moves = 0;
      window.requestAnimationFrame = frame => waiting.push(frame);
      const go = ldbench.go.bind(ldbench); ldbench.go = (...all) => { moves++; go(...all); };
      const play = document.querySelector('#play'); play.click(); play.click(); play.click();
      const found = [];
      for (let k = 0; k < 5; k++) {
        moves = 0; now += 10;
        waiting.splice(0).forEach(frame => frame(now));
        found.push(moves);
      }
      return found""")
    assert moves == [1]*5
