"""Curves, bars and arrows of the sheets: each artist has the rows of the file, in the unit and under the name that it has."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.quiver import Quiver
from pypdf import PdfReader

import ldbench
from invented import altered
from ldbench.plots.energies import energy_page, ramp_page
from ldbench.plots.figures import overview_figures
from ldbench.plots.geometry import geometry_page
from ldbench.plots.impact import impact_page
from ldbench.plots.series import ENERGY, PAGES, time_page
from ldbench.plots.stretches import thin
from ldbench.plots.style import ldbench_style
from raw import flange_slope
from reading import Line, differing, words_of
from specimen import World
from table import CRC, DEG, KN, MM, PANELS, fits_contact


@pytest.fixture(autouse=True)
def styled():
    with ldbench_style():
        yield


def by_label(figure: Figure) -> dict[str, Axes]:
    return {ax.get_ylabel(): ax for ax in figure.axes}


def curve(ax: Axes, k: int = 0) -> np.ndarray:
    return np.asarray(ax.get_lines()[k].get_ydata(), float)


# Over time ---------------------------------------------------------------------------------

@pytest.mark.parametrize("page", [*PAGES, ENERGY], ids=lambda page: page.title)
def test_pages_over_time(page: object, world: World):
    """Each panel and curve that the call asks for; events are marked where they happen."""
    raw, figure = world.thrown, time_page(world.run("ex2_aw"), page)
    axes = by_label(figure)
    assert set(PANELS[page.title]) == set(axes)
    marks = [next(t for t, kind, _ in raw.events if kind == first) for first in (
        "left flange contact", "centre passage", "right flange contact")]
    for words, curves in PANELS[page.title].items():
        lines = axes[words].get_lines()
        drawn = {line.get_label(): line for line in lines if not line.get_label().startswith("_")}
        for label, (column, factor) in curves.items():
            x = factor*sum(raw.c[name] for name in column.split("+"))
            np.testing.assert_allclose(drawn[label].get_ydata(), x, rtol=1e-12, err_msg=f"{words} {label}")
            np.testing.assert_array_equal(drawn[label].get_xdata(), raw.t)
        assert len(drawn) == len(curves)
        assert sorted(line.get_xdata()[0] for line in lines if line.get_linestyle() == ":") == marks
    assert {ax.get_xlabel() for ax in figure.axes} == {"", "time [s]"}


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


def test_portraits_spectra_and_ratio(world: World):
    """Velocity over displacement; sines have peaks as high as they are, beside the eigenfrequencies; L/V of both wheels."""
    raw, run = world.thrown, world.run("ex2_aw")
    figure = energy_page(run)
    axes = {ax.get_xlabel(): ax for ax in figure.axes}
    for label, q, v, factor, v_factor in (("Y [mm]", "Y", "vY", MM, 1), ("Z [mm]", "Z", "vZ", MM, 1),
                                          ("Φ [mrad]", "roll", "roll_rate", 1e3, 1e3)):
        drawn = axes[label].get_lines()
        np.testing.assert_allclose(drawn[0].get_xdata(), factor*raw.c[q])
        np.testing.assert_allclose(drawn[0].get_ydata(), v_factor*raw.c[v])
        ends = {line.get_label(): line.get_xdata()[0] for line in drawn[1:]}
        assert (ends["start"], ends["end of the run"]) == pytest.approx(factor*raw.c[q][[0, -1]])
    for k, side in enumerate("LR"):
        np.testing.assert_allclose(curve(by_label(figure)["L/V"], k), raw.ratio(side), rtol=1e-12)
    t = 1e-4*np.arange(20_000)
    data = pd.DataFrame(0.0, range(len(t)), run.data.columns).assign(
        time=t, Z=2e-3*np.sin(2*np.pi*200*t) + 5e-5*np.sin(2*np.pi*80*t))
    ax = by_label(energy_page(altered(run, data=data)))["amplitude of Z [mm]"]
    f, amplitude = ax.get_lines()[0].get_data()
    for frequency, height in ((200, 2.0), (80, 0.05)):
        assert amplitude[np.abs(f - frequency) < 2].max() == pytest.approx(height, rel=0.02)
    marks = [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == ":"]
    assert marks == pytest.approx(raw.settings("eigenfrequencies"), rel=1e-5)


def test_ramp_page(world: World):
    """L/V of both wheels over the lateral force, loads, forces and displacements; Nadal's limits; the work of the force."""
    raw, axes = world.pushed, by_label(ramp_page(world.run("ex5_aw")))
    force = KN*raw.c["F_ext"]
    for label, *drawn in (("L/V", raw.ratio("L"), raw.ratio("R")), ("vertical load [kN]", KN*raw.loads("L"), KN*raw.loads("R")),
                          ("normal N [kN]", *(KN*raw.c[f"N_{contact}"] for contact in ("LT", "LF", "RT"))),
                          ("lateral Y [mm]", MM*raw.c["Y"]), ("roll Φ [mrad]", 1e3*raw.c["roll"])):
        lines = [one for one in axes[label].get_lines() if len(one.get_xdata()) > 10]
        for line, x in zip(lines, drawn, strict=True):
            f, y = line.get_data()
            np.testing.assert_allclose(y, x[np.searchsorted(force, f)], rtol=1e-9)
            assert np.nanmax(y) == np.nanmax(x) and np.nanmin(y) == np.nanmin(x)
    work = next(line for line in axes["sums [J]"].get_lines() if line.get_label() == "work of lateral force")
    np.testing.assert_allclose(work.get_ydata(), raw.c["W_ext"][np.searchsorted(raw.t, work.get_xdata())], rtol=1e-12)
    assert abs(np.nanmax(raw.ratio("L")) - np.nanmax(raw.ratio("R"))) > 0.5, "an exchange would show"
    assert not any(isinstance(one, PolyCollection) for ax in axes.values() for one in ax.collections), "bands are of long runs"
    slope = np.tan(flange_slope())
    levels = [line.get_ydata()[0] for line in axes["L/V"].get_lines() if len(line.get_xdata()) == 2]
    np.testing.assert_allclose(sorted(levels), sorted((slope - mu)/(1 + mu*slope) for mu in (0.0, 0.3)), rtol=1e-5)


# At an instant -----------------------------------------------------------------------------

def test_impact_page(world: World):
    """Pressure and area over the time of the first contact; arrows are the forces at the contacts on the wheel that is drawn."""
    raw, figure = world.thrown, impact_page(world.run("ex2_aw"))
    axes, k = by_label(figure), world.thrown.first_peak("LF")
    t, pressure = axes["pressure [GPa]"].get_lines()[0].get_data()
    again, area = axes["patch area [mm²]"].get_lines()[0].get_data()
    at = int(np.argmin(np.abs(t - 1e3*raw.t[k])))
    assert t[at] == again[at] == pytest.approx(1e3*raw.t[k], abs=1e-9) and raw.start("LF") < 1e-3*t[0] < 1e-3*t[-1]
    fits_contact(raw, "LF", k, 1e9*pressure[at], 1e-6*area[at])
    wheel = figure.axes[0].get_lines()[0].get_xydata()
    arrows = [one for one in figure.axes[0].collections if isinstance(one, Quiver)]
    closed = [c for c in ("LT", "LF") if raw.c[f"N_{c}"][k] > 0]
    longest = max(raw.c[f"N_{c}"][k] for c in ("LT", "LF", "RT", "RF"))
    for c, arrow in zip(closed, arrows, strict=True):
        foot = MM*np.array([raw.c[f"y_{c}"][k], raw.c[f"z_{c}"][k]])
        assert arrow.get_offsets()[0] == pytest.approx(foot) and np.hypot(*(wheel - foot).T).min() < 0.2     # points every 0.25 mm
        assert (arrow.U[0], arrow.V[0]) == pytest.approx([40*raw.c[f"{name}_{c}"][k]/longest for name in ("Fy", "Fz")])
    left, right = figure.axes[0].get_xlim()
    assert left > right and raw.c["Fy_LF"][k] < 0


def test_geometry_page(world: World, tmp_path: Path):
    """Clearances in words and as lines, and every curve from the columns of the file, left and right."""
    run, file = world.run("ex2_aw"), tmp_path/"geometry.txt"
    ldbench.ContactTable(run.case).write_geometry(file)
    names, *lines = file.read_text().splitlines()
    column = dict(zip(names.split(), np.array([line.split() for line in lines if line[0] != "#"], float).T, strict=True))
    figure = geometry_page(run, ldbench.read_columns(file))
    clearance = Line(r"left (\S+), right (\S+) mm", "clearances [mm]", lambda w: (10.18, 16.945), 1e-3)
    assert differing(words_of(figure), [clearance], world, [CRC]) == []
    axes = by_label(figure)
    for label, scale, *drawn in (
            ("contact angle [°]", DEG, "angle_L", "angle_R"), ("rolling radius [mm]", MM, "radius_L", "radius_R"),
            ("contact position, outward |y| [mm]", MM, "y_L", "-y_R"), ("contact position z [mm]", MM, "z_L", "z_R"),
            ("Δr = left − right [mm]", MM, "delta_r"), ("equivalent conicity", 1, "conicity"), ("roll Φ [mrad]", 1e3, "roll"),
            ("height Z [mm]", MM, "Z")):
        for k, name in enumerate(drawn):
            x = scale*column[name.lstrip("-")]*(-1 if name[0] == "-" else 1)
            np.testing.assert_allclose(curve(axes[label], k), x, rtol=1e-12, err_msg=label)
        if len(drawn) == 2:
            assert [line.get_label() for line in axes[label].get_lines()[:2]] == ["left", "right"]
        ends = [line.get_xdata()[0] for line in axes[label].get_lines()[-2:]]
        assert ends == pytest.approx([-16.945, 10.175], abs=1e-3)
    np.testing.assert_allclose(column["delta_r"], column["radius_L"] - column["radius_R"], atol=1e-8)


def test_side_by_side(world: World):
    """Y, forces of both flanges, first contact and kinetic energy of each run; shares, peak, duration, impulse of the contact."""
    raws = [world.thrown, world.faster]
    (_, beside), (_, contacts) = overview_figures([world.run("ex2_aw"), world.run("ex3_aw")])
    assert differing(words_of(beside), [], world, [r"^Exercises? \d(?: to \d)?"]) == []
    for row, raw in zip(np.reshape(beside.axes, (2, 4)), raws, strict=True):
        kinetic = sum(raw.c[f"KE_{part}"] for part in ("lat", "vert", "roll"))
        for drawn, x in ((curve(row[0]), MM*raw.c["Y"]), (curve(row[1]), KN*raw.c["N_LF"]), (curve(row[1], 1), -KN*raw.c["N_RF"]),
                         (curve(row[3]), kinetic), (curve(row[2]), KN*raw.c["N_LF"][raw.first("LF")])):
            assert (drawn.max(), drawn.min()) == pytest.approx((x.max(), x.min()), rel=1e-7)
        t = row[2].get_lines()[0].get_xdata()
        assert t[curve(row[2]).argmax()] == pytest.approx(1e3*(raw.t[raw.first_peak("LF")] - raw.start("LF")), abs=1e-6)
    ones = [raw.impact("LF") for raw in raws]
    shares = [100*one[f"{part}_after"]/sum(one[f"{other}_before"] for other in ("lat", "vert", "roll"))
              for one in ones for part in ("lat", "vert", "roll")]
    assert [x > 6 for x in shares] == [True, True, False, True, True, True], "the lines differ in length"
    lines = [Line(r"(?<!%) (\d+) % (\d+) %$", "shares of lateral and vertical motion, exercise 2 [%]", lambda w: shares[:2]),
             Line(r"^(\d+) % (\d+) % (\d+) %$", "shares of all three motions, exercise 3 [%]", lambda w: shares[3:])]
    assert differing(words_of(contacts), lines, world, [r"exercises 1 to 4", r"powers 6/5, -1/5 and 1 of"]) == []
    axes = by_label(contacts)
    for label, key, scale in (
            ("peak N [kN]", "peak", KN), ("duration [ms]", "duration", 1e3), ("impulse ∫N dt [kN·s]", "impulse", KN)):
        assert curve(axes[label]) == pytest.approx([scale*one[key] for one in ones], rel=1e-6), label
    before, after = ([raw.c["vY"][k] for raw, k in zip(raws, rows, strict=True)] for rows in (
        (0, 0), [raw.first("LF").stop - 1 for raw in raws]))
    assert curve(axes["lateral velocity after / before, reversed"]) == pytest.approx(-np.divide(after, before), rel=1e-6)


# The document ------------------------------------------------------------------------------

def test_contents_and_bookmarks_lead_to_every_page(world: World):
    """Each bookmark leads to the page with that title, and so does each line of the contents, whose link is at its number."""
    document = PdfReader(world.outputs/"ldbench_plots.pdf")
    found = [part for one in document.outline for part in (one if isinstance(one, list) else [one])]
    chapters = [part.title for part in document.outline if not isinstance(part, list)]
    exercises = [f"Exercise {k}, actual profiles (left), simplified profiles (right)" for k in (2, 5)]
    assert chapters == ["Contents", "Summary", "Contact geometry, actual profiles (left), simplified profiles (right)", *exercises,
                        "Elastic contact or constraint equations", "How far to trust an answer"]
    titles, pages = [part.title for part in found], [document.get_destination_page_number(part) for part in found]
    for heading in exercises:
        first = titles.index(heading) + 1
        for k in range(first, first + len(world.sheets(f"{heading}: "))):
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
