"""The page of a collation in Chromium: matrix, switches, charts, themes, a phone."""
from __future__ import annotations

from pathlib import Path

import pytest

import imaginary_round
from browser import Browser
from imaginary_round import CODES, Runs
from ldbench_round import own_runs
from ldbench_round.collation import Collation, collate
from ldbench_round.collation_html import make_page
from ldbench_round.collation_pdf import signed_percent, text
from ldbench_round.tasks import Task

FAST, OTHER = Task(4, "aw"), Task(3, "aw")
INK = """const c = document.querySelectorAll("canvas")[arguments[0]];
const p = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
let n = 0; for (let i = 3; i < p.length; i += 4) n += p[i] > 0; return n"""


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Collation:
    """Three codes, one of them with a strange name, and a file that cannot be used."""
    folder = tmp_path_factory.mktemp("codes")
    runs = Runs(n_lateral=60, n_roll=13, n_depth=11)
    imaginary_round.write_round(folder, [FAST, OTHER], CODES[1:3], runs)
    (folder/"Contura").rename(folder/"<b>x")
    (folder/"empty").mkdir()
    (folder/"empty/ex1_aw.csv").write_text("")
    before = dict(own_runs._OWN)
    own_runs._OWN.update({task: runs.of(CODES[1], task) for task in (FAST, OTHER)} | {Task(1, "aw"): runs.of(CODES[1], OTHER)})
    store = tmp_path_factory.mktemp("kept")
    try:
        return collate(folder, store, 1)
    finally:
        own_runs._OWN.clear()
        own_runs._OWN.update(before)


@pytest.fixture(scope="module")
def page(found: Collation, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_page(found).write(tmp_path_factory.mktemp("page")/"collation.html")


def test_the_page_shows_the_matrix_and_asks_nobody(browser: Browser, page: Path, found: Collation):
    browser.size(1366, 860)
    browser.open(page)
    assert browser.log() == [] and {url.partition(":")[0] for url in browser.requests()} <= {"file", "data"}
    assert [code.name for code in found.codes] == ["<b>x", "Bora", "empty"]
    assert [name.strip() for name in browser.texts("#matrix tbody th")] == [code.name for code in found.codes]
    cells = browser.texts("#matrix tbody td")
    assert len(cells) == 3*10 and sum(cell == "–" for cell in cells) == 3*10 - 5 and "cannot be used" in cells
    k = found.tasks.index(FAST)
    assert cells[10 + k].startswith(text("peak", found.value(found.codes[1], FAST, "peak")))
    browser.run("const s = document.getElementById('as'); s.value = 'median'; s.dispatchEvent(new Event('change'))")
    value, middle = found.value(found.codes[1], FAST, "peak"), found.median(FAST, "peak")
    assert browser.texts("#matrix tbody td")[10 + k].startswith(signed_percent((value - middle)/middle))
    assert browser.text("#lines summary") == "What could not be used: 1"


def test_a_cell_chooses_its_simulation_and_a_switch_takes_a_code_away(browser: Browser, page: Path, found: Collation):
    browser.open(page)
    k = found.tasks.index(FAST)
    browser.run("document.querySelectorAll('#matrix tbody tr')[1].children[arguments[0] + 1].firstChild.click()", k)
    assert browser.run("return document.getElementById('task').value") == str(k)
    assert "exercise 4, actual profiles" in browser.text("#numbers-title")
    assert len(browser.texts("#numbers tbody tr")) == 1 + 2
    assert browser.log() == []
    charts = range(len(browser.texts("canvas")))
    both = [browser.run(INK, chart) for chart in charts]
    browser.click("#codes label:nth-child(1) input")
    one = [browser.run(INK, chart) for chart in charts]
    assert len(both) == 5 and all(a > b > 0 for a, b in zip(both, one, strict=True))
    browser.click("#none")
    none = [browser.run(INK, chart) for chart in charts]
    assert all(a > b for a, b in zip(one, none, strict=True))
    browser.click("#all")
    assert [browser.run(INK, chart) for chart in charts] == both
    assert not any("SEVERE" in line for line in browser.log())


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_nothing_is_wider_than_a_phone(dark: bool, browser: Browser, page: Path):
    browser.size(390, 844, mobile=True, dark=dark)
    browser.open(page)
    assert browser.run("return document.documentElement.scrollWidth") <= 390
    assert browser.run("return document.documentElement.dataset.theme") == ("dark" if dark else "light")
    small = browser.run("return [...document.querySelectorAll('button, select')].filter(e => e.offsetHeight < 28).map(e => e.id)")
    assert small == []
    browser.size(1366, 860)
