"""The scene of the page: fit, exaggerated gaps and pressed patches; in a real browser."""
from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from browser import Browser, facts, go
from ldbench.geometry.pressures import full_row
from ldbench.results.run_data import read_data
from running import Run


def test_fit_holds_an_overturned_wheelset(browser: Browser, shipped: dict[str, Run], ex5: Path):
    browser.open(ex5)
    w, h = browser.run("return [ldbench.scene.w, ldbench.scene.h]")
    corners = """const [run] = ldbench.runs, {scene} = ldbench, shape = ldbench.shapes[run.shape];
      const pose = scene.poseOf(run, shape, ldbench.t), found = [];
      for (const [outline, side] of [[shape.left, 1], [shape.right, -1]]) {
        for (const [u, v] of outline.wheel) for (const z of [v, -v]) found.push(scene.px(...scene.placed(run, pose, [side*u, z])));
        for (const [y, z] of outline.rail) found.push(scene.px(side*y, z));
      }
      return found"""

    def inside() -> bool:
        points = np.array(browser.run(corners))
        return bool(np.all((points >= 0) & (points <= [w, h])))

    go(browser, float(shipped["ex5_aw"].columns["time"][-1]))
    assert not inside()
    browser.press("4")
    assert inside()
    points = np.array(browser.run(corners))
    assert np.ptp(points[:, 0]) > 0.6*w or np.ptp(points[:, 1]) > 0.6*h
    browser.press("1")
    go(browser, 0.0)
    browser.press("4")
    assert inside()


def test_small_gaps_are_exaggerated_with_a_badge(browser: Browser, shipped: dict[str, Run],
                                                 page_of: Callable[[str], Path]):
    """A gap of some hundredths of a millimetre is drawn so many times as large, a closed one stays closed, and words say so."""
    run = shipped["ex2_aw"]
    page = page_of("ex2_aw")
    gap = """const [run] = ldbench.runs, {scene} = ldbench, shape = ldbench.shapes[run.shape], pose = run.pose(ldbench.t);
      const found = scene.gap(shape.left, run, pose, 1), drawn = scene.poseOf(run, shape, ldbench.t);
      return [found.gap, found.rail - scene.placed(run, drawn, found.point)[0]]"""
    t = read_data(run.file).first_contact("LF")
    browser.open(page, f"#t={t - 1e-4}&view=left")
    true, drawn = browser.run(gap)
    assert 0 < true < 1e-4 and drawn == pytest.approx(true)
    assert browser.run("return ldbench.scene.badge") == ""
    browser.run("const select = document.querySelector('#exaggerate-gap'); select.value = '20'; select.onchange()")
    true, drawn = browser.run(gap)
    assert drawn == pytest.approx(20*true, rel=0.2)
    assert browser.run("return ldbench.scene.badge") == "not to scale: small gaps × 20"
    browser.run("const select = document.querySelector('#exaggerate-displacement'); select.value = '5'; select.onchange()")
    assert browser.run("return ldbench.scene.badge") == "not to scale: displacement × 5, small gaps × 20"


def test_pressed_patches_at_the_peaks(browser: Browser, shipped: dict[str, Run], page_of: Callable[[str], Path]):
    """Outline, largest pressure and area; the numbers are those of the table of all runs."""
    run = read_data(shipped["ex3_aw"].file)
    page = page_of("ex3_aw")
    row, (entry,) = full_row(run), facts(page)["runs"]
    browser.open(page)
    assert browser.run("return document.querySelector('#patches').hidden")
    go(browser, row["t_pmax_LF"])
    assert not browser.run("return document.querySelector('#patches').hidden")
    words = browser.run("return document.querySelector('#pressure').getAttribute('aria-label')")
    pmax, area = (float(word) for word in words.replace("contact patches: LF ", "").replace("mm²", "").split(" MPa, "))
    assert (pmax, area) == (round(1e-6*row["pmax_LF"]), round(1e6*row["patch_LF"]))
    for moment in entry["pressure"]:
        for patch in moment["patches"]:
            assert max(patch["p"]) in (98, 99) and min(patch["p"]) >= 0 and max(patch["w"]) <= 99
            # The outline that is drawn has the area that is told.
            drawn = 2*patch["x"]*np.sum(patch["w"])/99*patch["s"]/len(patch["w"])
            assert drawn == pytest.approx(patch["area"], rel=0.03)
    painted = browser.run("""const c = document.querySelector('#pressure'), g = c.getContext('2d');
      return g.getImageData(0, 0, c.width, c.height).data.filter((v, k) => k % 4 === 3 && v > 50).length""")
    assert painted > 300
    go(browser, row["t_pmax_LF"] + 1e-4)
    assert browser.run("return document.querySelector('#patches').hidden") and browser.log() == []
