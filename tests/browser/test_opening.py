"""How a page opens: its title, the stretch of time and the moment that it shows, and where the largest pressure is."""
from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import ldbench
from browser import Browser, facts
from ldbench.viewer.page import title_of
from running import once
from specimen import World


@pytest.fixture(scope="module")
def three(world: World, common: Path) -> Path:
    """The page of two short runs and one that lasts more than ten times as long as the shorter of them."""
    folder = common/"page_three"
    with once(folder) as first:
        if first:
            ldbench.view(world.thrown.file, world.faster.file, world.pushed.file).write(folder/"page.html")
    return folder/"page.html"


def test_a_long_run_does_not_squeeze_the_others(browser: Browser, three: Path, world: World):
    """The time axes show the runs that end soon; words say which run goes on, and a button shows all of it and goes back."""
    ends = {raw.file.stem: raw.t[-1] for raw in (world.thrown, world.faster, world.pushed)}
    soon = max(ends["ex2_aw"], ends["ex3_aw"])
    assert ends["ex5_aw"] > 10*min(ends.values())
    browser.open(three)
    browser.is_quiet(three)
    for chart in range(browser.run("return ldbench.charts.length")):
        low, high = browser.run("return ldbench.charts[arguments[0]].ends", chart)
        assert (low, high) == (0, soon)
    # The slider gives them room too, and its thumb is where the time is.
    slider = "return Number(document.querySelector('#scrub').value)"
    browser.run("ldbench.go(arguments[0])", soon)
    assert 0.5 < browser.run(slider) < 0.9
    browser.run("const s = document.querySelector('#scrub'); s.value = 0.5*Number(s.value); s.oninput()")
    assert browser.run("return ldbench.t") == pytest.approx(0.5*soon, abs=2e-4)
    words = browser.text("#beyond")
    assert "ex5_aw" in words and "ex2_aw" not in words and f"{ends['ex5_aw']:.2f} s" in words and f"{soon:.3f} s" in words
    for expected in (ends["ex5_aw"], soon):
        browser.click("#time-whole")
        assert browser.run("return ldbench.window") == [0, expected]
    browser.click("#beyond button")
    assert browser.run("return ldbench.window") == [0, ends["ex5_aw"]]
    # Without the long run nothing is said, and all of the others is shown.
    browser.click("#runs label:nth-child(3) input")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == 2)
    assert browser.run("return document.querySelector('#beyond').hidden") and browser.run("return ldbench.window") == [0, soon]


def test_opens_at_the_first_flange_contact(browser: Browser, report: Path, three: Path, world: World):
    """At the row of its largest force, of the run that is shown first; a link and a moment that was chosen stay."""
    for page, fragment, raw in ((report, "", world.thrown), (report, "#run=ex5_aw", world.pushed), (three, "", world.thrown)):
        browser.open(page, fragment)
        at = raw.t[raw.first_peak("LF")]
        assert browser.run("return ldbench.t") == pytest.approx(at, abs=1e-8)
        assert browser.text("#clock") == f"{at:.6f} s" and raw.c["N_LF"][raw.first_peak("LF")] > 1e4
    browser.open(report, "#t=0")
    assert browser.run("return ldbench.t") == 0
    # The name of a run in the table opens it there; so does another choice of runs until a moment is chosen.
    browser.run("document.querySelectorAll('#summary thead a')[1].click()")
    at = world.pushed.t[world.pushed.first_peak("LF")]
    browser.wait(lambda: browser.run("return ldbench.t") == pytest.approx(at, abs=1e-8))
    browser.open(three)
    browser.click("#runs label:nth-child(1) input")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == 2)
    assert browser.run("return ldbench.t") == pytest.approx(world.faster.t[world.faster.first_peak("LF")], abs=1e-8)
    browser.run("ldbench.go(0.01)")
    browser.click("#runs label:nth-child(2) input")
    browser.wait(lambda: browser.run("return ldbench.runs.length") == 1)
    assert browser.run("return ldbench.t") == 0.01


def test_the_largest_pressure_is_one_click_away(browser: Browser, report: Path, world: World):
    """Words say which contact has it, where and when; a click goes to its row, at which its patch is shown."""
    raw = world.thrown
    pressure, time, y, z = (raw.result(name) for name in ("pmax", "t_pmax", "pmax_y", "pmax_z"))
    contact = re.search(r"pmax_contact = '(\w+)'", raw.text)[1]
    browser.open(report, "#t=0")
    words = browser.text("#hardest")
    assert {"LF": "left flange", "RF": "right flange"}[contact] in words
    found = [float(x.replace("−", "-")) for x in re.findall(r"[−\d.]+(?= (?:MPa|mm|s)\b)", words)]
    assert found == pytest.approx([1e-6*pressure, time, 1e3*y, 1e3*z], rel=2e-4)
    browser.click("#hardest button")
    row = raw.t[np.abs(raw.t - time).argmin()]
    browser.wait(lambda: abs(browser.run("return ldbench.t") - row) < 1e-8)
    label = browser.run("return document.querySelector('#pressure').getAttribute('aria-label')")
    shown = float(re.search(rf"{contact} (\S+) MPa", label)[1])
    assert shown == pytest.approx(1e-6*pressure, rel=0.01) and not browser.run("return document.querySelector('#patches').hidden")
    # So does the list of events.
    option = next(text for text in browser.texts("#events option") if "largest pressure" in text)
    assert option.startswith(f"{time:.6f} s") and f"{1e-6*pressure:.0f} MPa" in option


def test_title_of_many_runs(world: World):
    ours = [world.run(name) for name in ("ex2_aw", "ex3_aw", "ex5_aw")]
    assert title_of(ours[:1]) == ours[0].heading
    assert title_of(ours[:2]) == f"{ours[0].heading}; {ours[1].heading}"
    assert title_of([run.named(name) for run, name in zip(ours, "abc", strict=True)]) == "3 runs: a, b, c"
    assert title_of([ours[0].named(name) for name in "abcdef"]) == "6 runs: a, b, c, d and 2 more"


@pytest.mark.parametrize(("tasks", "expected"), [
    ([(k, pair) for k in range(1, 6) for pair in ("aw", "sw")], "10 runs: exercises 1 to 5, actual and simplified profiles"),
    ([(1, "aw"), (3, "aw"), (4, "aw")], "3 runs: exercises 1, 3 and 4, actual profiles"),
    ([(2, "sw"), (2, "sw"), (2, "sw")], "3 runs: exercise 2, simplified profiles")])
def test_title_of_exercises(tasks: list[tuple[int, str]], expected: str):
    runs = [ldbench.run(ldbench.Case.exercise(*task).replace(formulation="unilateral", t_end=5e-4, interval=2.5e-4,
                                                             stop_at="t_end", table_folder="")) for task in tasks]
    assert title_of(runs) == expected


def test_facts_know_the_moments(world: World):
    entry, _ = facts(world.outputs/"ldbench_results.html")["runs"]
    assert entry["opens"] == pytest.approx(world.thrown.t[world.thrown.first_peak("LF")], abs=1e-6)
    assert [moment["t"] for moment in entry["pressure"]] == sorted(moment["t"] for moment in entry["pressure"])
