"""What the page shows is right: colours, times, peaks, events; in a real browser."""
from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from browser import Browser, facts, go
from ldbench.results.run_data import read_data
from running import Run


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
