"""What test_named.py does not compare: bands and thinned curves, spectra, geometry, first contacts, and the documents."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from pypdf import PdfReader

import ldbench
from invented import altered
from ldbench.plots.energies import portrait_page
from ldbench.plots.figures import overview_figures
from ldbench.plots.geometry import geometry_page
from ldbench.plots.stretches import split, thin
from ldbench.plots.style import ldbench_style
from of_geometry import compare_functions, compare_reach, says
from reading import Line, differing, words_of
from specimen import World
from table import CRC
from walk import walk


@pytest.fixture(autouse=True)
def styled():
    with ldbench_style():
        yield


def by_label(figure: Figure) -> dict[str, Axes]:
    return {ax.get_ylabel(): ax for ax in figure.axes}


def curve(ax: Axes, k: int = 0) -> np.ndarray:
    return np.asarray(ax.get_lines()[k].get_ydata(), float)


# Over time ---------------------------------------------------------------------------------

def test_thinned_curve_keeps_what_its_columns_show():
    """First, last, smallest and largest value of every column of equal width, whatever the rows' distances; gaps stay."""
    rng = np.random.default_rng(1)
    t, x = np.cumsum(rng.exponential(size=50_000)), rng.normal(size=50_000).round(1)
    x[700:900] = x[2_000:3_000:2] = np.nan
    x[40_000:45_000] = 0.25
    thin_t, thin_x = thin(t, x, 500)
    assert len(thin_t) < 4*500 + 2*1_000 + 10 and np.all(np.diff(thin_t) > 0)
    np.testing.assert_array_equal(thin_x, x[np.searchsorted(t, thin_t)])
    edges = np.linspace(t[0], t[-1], 501)
    rows, kept = (np.clip(np.searchsorted(edges, s, "right") - 1, 0, 499) for s in (t, thin_t))
    for k in range(500):
        a, b = x[rows == k], thin_x[kept == k]
        np.testing.assert_array_equal([a[0], a[-1], np.fmin.reduce(a), np.fmax.reduce(a)],
                                      [b[0], b[-1], np.fmin.reduce(b), np.fmax.reduce(b)])
    ends = np.flatnonzero(np.diff(np.isnan(x)))
    assert np.isin(t[ends], thin_t).all() and np.isin(t[ends + 1], thin_t).all()


def test_spectra(world: World):
    """Sines have peaks as high as they are, beside the eigenfrequencies."""
    run = world.run("ex2_aw")
    t = 1e-4*np.arange(20_000)
    data = pd.DataFrame(0.0, range(len(t)), run.data.columns).assign(
        time=t, Z=2e-3*np.sin(2*np.pi*200*t) + 5e-5*np.sin(2*np.pi*80*t))
    f, amplitude = by_label(portrait_page(altered(run, data=data)))["amplitude of Z [mm]"].get_lines()[0].get_data()
    for frequency, height in ((200, 2.0), (80, 0.05)):
        assert amplitude[np.abs(f - frequency) < 2].max() == pytest.approx(height, rel=0.02)


def test_bands_stand_where_a_line_would_be_black():
    """A slow wave is a line, a fast one a band between its smallest and largest values; so is a contact that opens and closes."""
    t = np.linspace(0, 1, 20_001)
    slow, fast = np.sin(40*t), np.sin(1000*t)
    assert split(t, slow, 100)[2] is None and split(t, 0.01*fast + slow, 100)[2] is None
    mixed = np.where(t < 0.4, slow, fast)
    line_t, line_x, band = split(t, mixed, 100)
    there = np.isfinite(band.mean)
    assert 0.38 < band.middle[there].min() < 0.42 < 0.98 < band.middle[there].max()
    assert band.high[there][1:] == pytest.approx(1, abs=1e-3) and band.low[there][1:] == pytest.approx(-1, abs=1e-3)
    drawn = line_t[np.isfinite(line_x)]
    assert np.isin(drawn, t).all() and (drawn < 0.38).sum() > 200 and not np.any((drawn > 0.45) & (drawn < 0.95))
    rattling = np.where(np.sin(1000*t) > 0, slow, np.nan)
    assert np.isfinite(split(t, rattling, 100)[2].mean).sum() > 90


def test_geometry_page(world: World, tmp_path: Path):
    """Clearances in words and as lines, and every curve from the columns of the file, left and right."""
    run, file = world.run("ex2_aw"), tmp_path/"geometry.txt"
    ldbench.ContactTable(run.case).write_geometry(file)
    names, *lines = file.read_text().splitlines()
    column = dict(zip(names.split(), np.array([line.split() for line in lines if line[0] != "#"], float).T, strict=True))
    figure = geometry_page(run, ldbench.read_columns(file))
    clearance = Line(r"left (\S+), right (\S+) mm", "clearances [mm]", lambda w: (10.18, 16.945), 1e-3)
    assert differing(words_of(figure), [clearance], world, [CRC]) == []
    compared = {"functions": compare_functions, "mark": compare_reach((10.175e-3, 16.945e-3))}
    assert walk(figure, compared, column, says=says) == 12 + 16
    np.testing.assert_allclose(column["delta_r"], column["radius_L"] - column["radius_R"], atol=1e-8)


def test_first_contacts(world: World):
    """Shares of kinetic energies in words; test_named_figures.py compares what is drawn."""
    raws = [world.thrown, world.faster]
    (_, beside), (_, contacts) = overview_figures([world.run("ex2_aw"), world.run("ex3_aw")])
    assert differing(words_of(beside), [], world, [r"^Exercises? \d(?: to \d)?"]) == []
    ones = [raw.impact("LF") for raw in raws]
    shares = [100*one[f"{part}_after"]/sum(one[f"{other}_before"] for other in ("lat", "vert", "roll"))
              for one in ones for part in ("lat", "vert", "roll")]
    assert [x > 6 for x in shares] == [True, True, False, True, True, True], "the lines differ in length"
    lines = [Line(r"(?<!%) (\d+) % (\d+) %$", "shares of lateral and vertical motion, exercise 2 [%]", lambda w: shares[:2]),
             Line(r"^(\d+) % (\d+) % (\d+) %$", "shares of all three motions, exercise 3 [%]", lambda w: shares[3:])]
    assert differing(words_of(contacts), lines, world, [r"exercises 1 to 4", r"powers 6/5, -1/5 and 1 of"]) == []


# The document ------------------------------------------------------------------------------

def test_contents_and_bookmarks_lead_to_every_page(world: World):
    """Each bookmark leads to the page with that title, and so does each line of the contents, whose link is at its number."""
    document = PdfReader(world.outputs/"ldbench_plots.pdf")
    found = [part for one in document.outline for part in (one if isinstance(one, list) else [one])]
    chapters = [part.title for part in document.outline if not isinstance(part, list)]
    exercises = [f"Exercise {k}, actual profiles (left), simplified profiles (right)" for k in (2, 5)]
    assert chapters == ["Contents", "Table of results", *exercises] and len(document.pages) == 2 + 4*len(exercises)
    first = document.pages[0].extract_text()
    assert all(words in first for words in ("ldbench 1.", "2 runs", "ldbench_extras.pdf"))
    more = [part.title for part in PdfReader(world.outputs/"ldbench_extras.pdf").outline if not isinstance(part, list)]
    assert more == ["Contents", "Contact geometry, actual profiles (left), simplified profiles (right)",
                    *(f"{words}: more pages" for words in exercises), "Elastic contact or constraint equations",
                    "How far to trust an answer"]
    titles, pages = [part.title for part in found], [document.get_destination_page_number(part) for part in found]
    for heading in exercises:
        first = titles.index(heading) + 1
        for k in range(first, first + 4):
            text = document.pages[pages[k]].extract_text()
            assert f"{heading}: {titles[k]}" in text and f"{pages[k] + 1} / {len(document.pages)}" in text
    places: list[tuple[str, float, float]] = []
    document.pages[0].extract_text(visitor_text=lambda text, matrix, *_: places.append((text.strip(), *matrix[4:])))
    links = [link.get_object() for link in document.pages[0]["/Annots"]]
    numbers = {page.indirect_reference.idnum: k for k, page in enumerate(document.pages)}
    assert [numbers[link["/Dest"][0].idnum] for link in links] == pages[1:]
    for link, page in zip(links, pages[1:], strict=True):
        left, low, right, high = map(float, link["/Rect"])
        assert [text for text, x, y in places if left < x < right and low < y < high and text.isdigit()] == [str(page + 1)]
