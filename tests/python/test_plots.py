"""The plots: every artist shows the numbers it was given, in the unit that its axis names."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.quiver import Quiver
from matplotlib.text import Text
from pypdf import PdfReader

from invented import altered, invented_run
from ldbench import Event
from ldbench.plots import document
from ldbench.plots.document import Part, bind, contents_page, entries, save_pages
from ldbench.plots.energies import energy_page
from ldbench.plots.impact import impact_page, instants
from ldbench.plots.series import ENERGY, PAGES, RATIO, Page, time_page
from ldbench.plots.stretches import thin
from ldbench.plots.style import ldbench_style
from ldbench.results.header import Header
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData
from specimen import World

# What the call asks for, as columns.
KINEMATICS = ["Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc"]
PER_CONTACT = ["angle", "N", "Fz", "Fy", "y", "z", "radius"]
ENERGIES = ["KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R", "W_ext", "E_drift"]
FACTORS = {"": 1, "mm": 1e3, "mrad": 1e3, "mrad/s": 1e3, "kN": 1e-3, "°": 180/np.pi, "m/s": 1, "m/s²": 1, "rad/s²": 1, "J": 1}


@pytest.fixture(autouse=True)
def styled():
    with ldbench_style():
        yield


def invented(rows: int = 400, dt: float = 1e-4, name: str = "ex2_aw") -> RunData:
    """A run of invented numbers, all columns different; the left flange touches from 10 to 12 ms."""
    t = dt*np.arange(rows)
    columns = {"time": t}
    for k, column in enumerate(KINEMATICS + ENERGIES + ["KE_long", "KE_pitch", "F_ext"]):
        columns[column] = (k + 1)*1e-3*np.sin((k + 1)*t/t[-1])
    for k, c in enumerate(CONTACTS):
        closed = (t >= 0.01 - 1e-9) & (t < 0.012 - 1e-9) if c == "LF" else np.full(rows, c != "RF")
        for i, quantity in enumerate(PER_CONTACT):
            x = (k + 1 + 0.1*i)*(1 + t)
            columns[f"{quantity}_{c}"] = np.where(closed, x, 0.0 if quantity in ("N", "Fy", "Fz") else np.nan)
    numbers = {**{f"peak_N_{c}": 0.0 for c in CONTACTS}, "peak_N_LF": 123456.0, "t_peak_LF": 0.011, "drift": 2e-9,
               "end": "t_end", "step": 1e-6}
    events = Event(0.00999, "left flange contact"), Event(0.02, "centre passage")
    return invented_run(pd.DataFrame(columns), name=name, header=Header(title="invented", results=numbers, events=events))


@pytest.fixture(scope="module")
def drawn_pages() -> dict[str, Figure]:
    """The pages against time of the run of invented numbers, by their titles."""
    with ldbench_style():
        return {page.title: time_page(invented(), page) for page in (*PAGES, ENERGY)}


def unit(ax: Axes) -> str:
    return ax.get_ylabel().rpartition("[")[2].rstrip("]")


def curves_of(ax: Axes) -> dict[str, Line2D]:
    """The curves of axes by their labels; marks of events are none."""
    return {line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")}


def texts(figure: Figure) -> list[str]:
    cells = [cell for ax in figure.axes for table in ax.tables for cell in table.get_celld().values()]
    return [t.get_text() for t in figure.findobj(Text)] + [cell.get_text().get_text() for cell in cells]


def columns_of(figure: Figure, page: Page) -> list[list[Axes]]:
    """The axes of a page, column by column, those without a panel left out."""
    width = len(page.columns)
    return [[figure.axes[i*width + j] for i in range(len(column))] for j, column in enumerate(page.columns)]


def panels_of(figure: Figure, page: Page) -> list[tuple[Axes, object]]:
    return [(ax, panel) for axes, column in zip(columns_of(figure, page), page.columns, strict=True)
            for ax, panel in zip(axes, column, strict=True)]


def test_everything_the_call_lists_has_a_panel():
    curves = [curve for page in (*PAGES, ENERGY) for column in page.columns for panel in column for curve in panel.curves]
    drawn = [column for curve in curves for column in curve.columns]
    wanted = KINEMATICS + [f"{q}_{c}" for q in PER_CONTACT for c in CONTACTS] + ENERGIES
    assert not set(wanted) - set(drawn)


@pytest.mark.parametrize("page", [*PAGES, ENERGY], ids=lambda page: page.title)
def test_page_draws_the_columns(page: Page, drawn_pages: dict[str, Figure]):
    run, figure = invented(), drawn_pages[page.title]
    assert f"Exercise 2, actual profiles: {page.title}" in texts(figure)
    for ax, panel in panels_of(figure, page):
        factor, lines = FACTORS[unit(ax)], curves_of(ax)
        for curve in panel.curves:
            expected = factor*sum(run.values(column) for column in curve.columns)
            # On the right, outwards is to the right.
            sign = -1 if "outward" in panel.label and curve.columns[0].endswith(("RT", "RF")) else 1
            np.testing.assert_allclose(lines[curve.label].get_ydata(), sign*expected, rtol=1e-12)
            np.testing.assert_array_equal(lines[curve.label].get_xdata(), run.time)
    assert {axes[-1].get_xlabel() for axes in columns_of(figure, page)} == {"time [s]"}


def test_ratio_is_the_outward_force_over_the_load():
    run = invented()
    for curve, side, outwards in zip(RATIO.curves, "LR", (-1, 1), strict=True):
        lateral, vertical = (run.values(f"{force}_{side}T") + run.values(f"{force}_{side}F") for force in ("Fy", "Fz"))
        np.testing.assert_allclose(curve.values(run), outwards*lateral/vertical, rtol=1e-12)


def test_events_are_marked_where_they_happen(drawn_pages: dict[str, Figure]):
    figure = drawn_pages[PAGES[0].title]
    for ax in figure.axes:
        assert [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == ":"] == [0.00999, 0.02]
    assert {"left flange", "centre"} <= {t.get_text() for t in figure.axes[0].texts}


def test_thinned_curve_keeps_what_its_columns_show():
    """First, last, smallest and largest value of every column of equal width, whatever the rows' distances; gaps stay."""
    rng = np.random.default_rng(1)
    t, x = np.cumsum(rng.exponential(size=50_000)), rng.normal(size=50_000).round(1)
    x[700:900] = np.nan
    x[2_000:3_000:2] = np.nan
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
    # No gap is bridged and none is opened.
    ends = np.flatnonzero(np.diff(np.isnan(x)))
    assert np.isin(t[ends], thin_t).all() and np.isin(t[ends + 1], thin_t).all()
    assert thin(t[:2_000], x[:2_000], 500)[0] is not None and len(thin(t[:2_000], x[:2_000], 500)[0]) == 2_000


def test_phase_portrait_is_velocity_over_displacement():
    run = invented()
    axes = {ax.get_xlabel(): ax for ax in energy_page(run).axes}
    for label, q, v, x_scale, v_scale in (("Y [mm]", "Y", "vY", 1e3, 1), ("Z [mm]", "Z", "vZ", 1e3, 1),
                                          ("Φ [mrad]", "roll", "roll_rate", 1e3, 1e3)):
        curve = axes[label].get_lines()[0]
        np.testing.assert_allclose(curve.get_xdata(), x_scale*run.values(q))
        np.testing.assert_allclose(curve.get_ydata(), v_scale*run.values(v))
        start, end = (curves_of(axes[label])[name] for name in ("start", "end of the run"))
        assert start.get_xdata()[0] == x_scale*run.values(q)[0] and end.get_xdata()[0] == x_scale*run.values(q)[-1]


def test_spectrum_shows_the_sines_with_their_amplitudes_and_the_eigenfrequencies():
    run = invented(rows=20_000, dt=1e-4)
    run.data["Z"] = 2e-3*np.sin(2*np.pi*200*run.time) + 5e-5*np.sin(2*np.pi*80*run.time)
    run = altered(run, results={"frequency_1": 0.4, "frequency_2": 210.0, "frequency_3": 240.0})
    ax = next(ax for ax in energy_page(run).axes if "amplitude of Z" in ax.get_ylabel())
    f, amplitude = ax.get_lines()[0].get_data()
    for frequency, height in ((200, 2.0), (80, 0.05)):
        near = np.abs(f - frequency) < 2
        assert amplitude[near].max() == pytest.approx(height, rel=0.02)
    assert [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == ":"] == [0.4, 210.0, 240.0]


def test_arrows_are_the_forces_at_the_contacts(world: World):
    """On the wheel that is drawn: left is left, and the force of the flange pushes the wheelset to the right."""
    run = world.run("ex2_aw")
    (label, k), *_ = instants(run)
    assert "left flange" in label
    ax = impact_page(run).axes[0]
    arrows = [(c.get_offsets()[0], (c.U[0], c.V[0])) for c in ax.collections if isinstance(c, Quiver)]
    closed = [c for c in ("LT", "LF") if run.values(f"N_{c}")[k] > 0]
    assert len(arrows) == len(closed) and "LF" in closed
    longest = max(run.values(f"N_{c}")[k] for c in CONTACTS)
    wheel = ax.get_lines()[0].get_xydata()
    for c in closed:
        foot = 1e3*np.array([run.values(f"{name}_{c}")[k] for name in ("y", "z")])
        at, arrow = min(arrows, key=lambda one, foot=foot: np.hypot(*(one[0] - foot)))
        assert at == pytest.approx(foot)
        assert arrow == pytest.approx([40*run.values(f"{name}_{c}")[k]/longest for name in ("Fy", "Fz")])
        assert np.hypot(*(wheel - foot).T).min() < 0.2          # [mm], points every 0.25 mm
    left, right = ax.get_xlim()
    assert left > right and run.values("Fy_LF")[k] < 0


def test_contents_page_leads_to_every_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The number at each line and its link lead to the page with that title; the link's rectangle holds the words."""
    monkeypatch.setattr(document, "LISTED", 6)
    parts = []
    for k, count in enumerate((1, 3, 2)):
        figures = []
        for i in range(count):
            figure = Figure(figsize=(11.69, 8.27))
            figure.text(0.1, 0.5, f"part {k} sheet {i}")
            figures.append((f"sheet {i}", figure))
        parts.append(Part(f"part {k}", tmp_path/f"{k}.pdf", save_pages(tmp_path/f"{k}.pdf", figures)))
    assert bind(parts, tmp_path/"all.pdf") == 7
    found = PdfReader(tmp_path/"all.pdf")
    lines = entries([(part.title, part.pages) for part in parts], 2)
    assert [(line.words, line.page) for line in lines] == [
        ("part 0", 2), ("part 1", 3), ("sheet 0", 3), ("sheet 1", 4), ("sheet 2", 5), ("part 2", 6), ("sheet 0", 6), ("sheet 1", 7)]
    numbers = {page.indirect_reference.idnum: k for k, page in enumerate(found.pages)}
    links = [link.get_object() for link in found.pages[0]["/Annots"]]
    assert [numbers[link["/Dest"][0].idnum] + 1 for link in links] == [line.page for line in lines]
    figure, targets = contents_page("contents", lines)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for line, ((left, low, right, high), page), link in zip(lines, targets, links, strict=True):
        assert [float(x) for x in link["/Rect"]] == pytest.approx([left, low, right, high], abs=0.01) and page == line.page
        boxes = [t.get_window_extent(renderer) for t in figure.texts if t.get_text() == line.words]
        assert [box for box in boxes if left - 1 <= box.x0 <= box.x1 <= right + 1 and low - 1 <= box.y0 <= box.y1 <= high + 1]
