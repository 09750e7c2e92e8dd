"""What the walk does not state of pages: how curves are thinned and bands are made, words in the place of panels, and files."""
from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from PIL import Image
from pypdf import PdfReader

import ldbench
from commands import RAIL, WHEEL, told_pair
from invented import altered
from ldbench import Error, Profile
from ldbench.__main__ import main
from ldbench.plots.call_sheets import SHEETS, run_sheet
from ldbench.plots.energies import portrait_page
from ldbench.plots.geometry import contact_lines
from ldbench.plots.profile_page import wheel_dimensions
from ldbench.plots.sheets import DPI, MOST, save_sheets
from ldbench.plots.stretches import split, thin
from ldbench.plots.style import ldbench_style
from ldbench.report.compare import impact_pages
from ldbench.report.differences import compare
from raw import Raw
from reading import words_of
from running import REPO
from specimen import World
from table import SHEETS as ROWS, WORDS

SVG = "{http://www.w3.org/2000/svg}"


# Curves ------------------------------------------------------------------------------------

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
    run, t = world.run("ex2_aw"), 1e-4*np.arange(20_000)
    data = pd.DataFrame(0.0, range(len(t)), run.data.columns).assign(
        time=t, Z=2e-3*np.sin(2*np.pi*200*t) + 5e-5*np.sin(2*np.pi*80*t))
    with ldbench_style():
        ax, = (ax for ax in portrait_page(altered(run, data=data)).axes if ax.get_ylabel() == "amplitude of Z [mm]")
    f, amplitude = ax.get_lines()[0].get_data()
    for frequency, height in ((200, 2.0), (80, 0.05)):
        assert amplitude[np.abs(f - frequency) < 2].max() == pytest.approx(height, rel=0.02)


def test_bands_stand_where_a_line_would_be_black():
    """A slow wave is a line, a fast one a band between its smallest and largest values; so is a contact that opens and closes."""
    t = np.linspace(0, 1, 20_001)
    slow, fast = np.sin(40*t), np.sin(1000*t)
    assert split(t, slow, 100)[2] is None and split(t, 0.01*fast + slow, 100)[2] is None
    line_t, line_x, band = split(t, np.where(t < 0.4, slow, fast), 100)
    there = np.isfinite(band.mean)
    assert 0.38 < band.middle[there].min() < 0.42 < 0.98 < band.middle[there].max()
    assert band.high[there][1:] == pytest.approx(1, abs=1e-3) and band.low[there][1:] == pytest.approx(-1, abs=1e-3)
    drawn = line_t[np.isfinite(line_x)]
    assert np.isin(drawn, t).all() and (drawn < 0.38).sum() > 200 and not np.any((drawn > 0.45) & (drawn < 0.95))
    rattling = np.where(np.sin(1000*t) > 0, slow, np.nan)
    assert np.isfinite(split(t, rattling, 100)[2].mean).sum() > 90


# Words -------------------------------------------------------------------------------------

def test_every_page_of_the_report_is_named(world: World):
    """The curves of abstract and extras are named as well."""
    assert [file.name for file in world.folder.glob("*.unnamed")] == []
    assert len(list((world.folder/"sheets").iterdir())) > 20


def test_a_flange_that_is_not_touched_is_told(world: World):
    """In words, in the place of its panels."""
    run = world.run("ex2_aw")
    with ldbench_style():
        figure = run_sheet(altered(run, results={"t_first_RF": np.nan}, data=run.data.assign(N_RF=0.0)), SHEETS[0])
    assert figure and len(figure.axes) == 2*len(ROWS[SHEETS[0].title])
    said = next(text for text in figure.texts if text.get_text() == "The right flange is not touched")
    assert said.get_position()[0] > 0.8


def test_impacts_of_few_rows_are_counted(world: World, tmp_path: Path):
    """In a file with every third row of the thrown wheelset; contacts that are closed in the first or last row are no impacts."""
    names, *lines = world.thrown.text.splitlines()
    rows = [k for k, line in enumerate(lines) if line[0] != "#"]
    left_out = set(rows) - set(rows[::3])
    file = tmp_path/"thin.txt"
    file.write_text("\n".join([names, *(line for k, line in enumerate(lines) if k not in left_out)]) + "\n")
    thin = Raw(file)
    closed = [episode.stop - episode.start - 2 for contact in WORDS for episode in thin.episodes(contact)
              if episode.start > 0 and episode.stop < len(thin.t)]
    few = sum(n < 6 for n in closed)
    assert 0 < few < len(closed) and {5, 6} <= set(closed), closed
    with ldbench_style():
        _, figure = next(impact_pages(compare([world.run("ex2_aw"), ldbench.read_run(file)])))
    assert f"\nex2_aw thin.txt: {few} impacts have fewer than 6 rows, so their numbers are rough" in words_of(figure)


# Profiles ----------------------------------------------------------------------------------

def test_measures_of_other_profiles():
    """S1002 and 60E1 as their standards have them; a dimension line is as long as its measure, Sd begins at the back, Sh at the
    tip."""
    wheel, rail = Profile(REPO/"profiles/s1002.yz"), Profile(REPO/"profiles/60e1.yz")
    assert [1e3*wheel.measures[name] for name in ("Sh", "Sd", "qR")] == pytest.approx([28, 32.5, 10.79], abs=0.005)
    assert wheel.measures["flange_angle"] == pytest.approx(np.radians(70), abs=2e-3) and rail.kind == "rail"
    assert [1e3*rail.measures[f"{arc}_radius"] for arc in ("crown", "shoulder", "corner")] == pytest.approx([300, 80, 13], rel=1e-3)
    assert rail.measures["inclination"] == pytest.approx(np.arctan(1/40), rel=1e-2)
    assert rail.measures["gauge_point_y"] == pytest.approx(0, abs=1e-6)
    lines = wheel_dimensions(wheel)
    assert set(lines) == {"Sh", "Sd", "qR"}
    for measure, (first, last) in lines.items():
        along = np.abs(np.subtract(last, first))
        assert along.max() == pytest.approx(1e3*wheel.measures[measure], abs=1e-9) and along.min() < 1e-9
    assert lines["Sd"][0][0] == 0 and lines["Sh"][0][1] == pytest.approx(1e3*wheel.smooth.z.min())


@pytest.mark.parametrize("side", [1, -1])
def test_contact_lines_join_points_of_wheel_and_rail(side: int):
    """For whole millimetres of displacement, on the curves of this side, at the place that the geometry functions tell."""
    found = told_pair().pair
    own = found.outlines.left if side > 0 else found.outlines.right
    lines, geometry = contact_lines(found, side), found.rolled.geometry
    assert {round(1e3*line.y) for line in lines} >= set(range(-8, 9))
    for y, on_wheel, on_rail in lines:
        assert 1e3*y == pytest.approx(round(1e3*y), abs=1e-9)
        assert np.interp(y, geometry["Y"], side*geometry["y_L" if side > 0 else "y_R"]) == pytest.approx(on_rail[0], abs=1e-9)
        for point, curve in (on_wheel, own.wheel), (on_rail, own.rail):
            assert np.hypot(*(curve - point).T).min() < 2e-4


def test_equal_clearances_are_told_for_both_sides():
    found = told_pair().pair
    equal = replace(found, outlines=replace(found.outlines, clearance=(0.01018, 0.01018)))
    assert equal.lines()[0] == "rigid-axle clearance left 10.180, right 10.180 mm"


# Files -------------------------------------------------------------------------------------

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


def test_pages_stand_one_below_the_other(tmp_path: Path):
    """Nothing of a page refers to another one, and the same pages give the same bytes."""
    figures = [Figure(figsize=(4, 2)) for _ in range(3)]
    for k, figure in enumerate(figures):
        figure.add_subplot().plot([0, 1, k])
        figure.text(0.1, 0.9, f"page {k}")
    made = {}
    for ending in "pdf", "svg", "png":
        made[ending] = target = tmp_path/f"sheets.{ending}"
        save_sheets(figures, target)
        before = target.read_bytes()
        save_sheets(figures, target)
        assert target.read_bytes() == before
    assert len(PdfReader(made["pdf"]).pages) == 3
    with Image.open(made["png"]) as picture:
        assert picture.size == (4*DPI, 3*2*DPI)
    whole = ElementTree.parse(made["svg"]).getroot()
    assert (whole.get("width"), whole.get("height")) == ("288pt", "432pt")
    inner = whole.findall(f"{SVG}svg")
    assert [float(one.get("y", "nan")) for one in inner] == [0, 144, 288]
    names = [one.get("id") for one in whole.iter() if one.get("id")]
    assert len(set(names)) == len(names)
    for one in inner:
        text = ElementTree.tostring(one, encoding="unicode")
        referred = {a or b for a, b in re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', text)}
        assert referred and referred <= set(re.findall(r'\bid="([^"]+)"', text))
    with pytest.raises(Error, match=f"expected at most {MOST} pages for a picture, found {MOST + 1}; a document .pdf holds more"):
        save_sheets(figures[:1]*(MOST + 1), tmp_path/"long.png")
    assert not (tmp_path/"long.png").exists()


@pytest.mark.parametrize("command", ["plot", "compare", "profile"])
def test_commands_write_the_pages_of_the_document(command: str, world: World, tmp_path: Path, undrawn: None,
                                                  monkeypatch: pytest.MonkeyPatch):
    """As many in a picture as in the document; the one of a plot or a comparison begins with its contents."""
    monkeypatch.setattr("ldbench.commands.profile.pair", lambda *case: told_pair().pair)
    words = {"plot": [world.thrown.file], "compare": [world.thrown.file]*2, "profile": [RAIL, WHEEL]}[command]
    counts = {}
    for ending in "pdf", "svg":
        target = tmp_path/f"{command}.{ending}"
        assert main([command, *map(str, words), "-o", str(target)]) == 0
        counts[ending] = (len(ElementTree.parse(target).getroot().findall(f"{SVG}svg")) if ending == "svg"
                          else len(PdfReader(target).pages))
    assert counts["pdf"] == counts["svg"] and (counts["pdf"] == 2 if command == "profile" else counts["pdf"] > 2)
