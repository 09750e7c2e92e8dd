"""What the page looks like on paper."""
from __future__ import annotations

from pathlib import Path

import pytest

from browser import Browser
from invented import altered
from ldbench.results.run_data import read_data
from ldbench.results.summary import summary_row
from ldbench.results.twins import Spread
from ldbench.viewer.results import results_page
from running import CASES, once
from specimen import World

MM = 96/25.4                                # pixels of CSS
PAPERS = {"a4": 210, "letter": 215.9}       # widths [mm]
MARGIN = 10                                 # [mm]


@pytest.fixture(scope="module")
def ten(world: World, common: Path) -> Path:
    """The page of ten runs with a summary that gives ranges wherever it can."""
    folder = common/"page_ten"
    with once(folder) as first:
        if first:
            runs = [altered(read_data(world.faster.file), name=name) for name in CASES]
            row = summary_row(runs[0])
            spreads = {key: Spread(x, 0.98*x, 1.03*x, 8, 9) for key, x in row.items() if isinstance(x, float) and x > 0}
            results_page(runs, (), dict.fromkeys(CASES, spreads)).write(folder/"page.html")
    return folder/"page.html"


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("pages", ["ten", "report"])
def test_nothing_is_cut_off_or_stretched(browser: Browser, request: pytest.FixtureRequest, pages: str, paper: str):
    """Every table ends at the edge of the paper, no cell's words leave it, and drawings keep their shape."""
    browser.open(request.getfixturevalue(pages), f"#run={','.join(CASES)}" if pages == "ten" else "")
    width = int((PAPERS[paper] - 2*MARGIN)*MM)
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
    try:
        ends = browser.run("""return [...document.querySelectorAll('table, canvas, td, th')].filter(e => e.offsetWidth)
          .map(e => [e.tagName, e.textContent, e.getBoundingClientRect().right, e.scrollWidth - e.clientWidth])""")
        assert len(ends) > 100
        assert [one for one in ends if one[2] > width + 1 or (one[0] in ("TD", "TH") and one[3] > 1)] == []
        shapes = browser.run("""return ldbench.charts.map(chart => chart.canvas).map(e => [e.width/e.height,
          e.getBoundingClientRect().width/e.getBoundingClientRect().height])""")
        assert all(drawn == pytest.approx(seen, rel=0.02) for drawn, seen in shapes) and shapes
    finally:
        browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
