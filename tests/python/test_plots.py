"""The plots: every artist shows the numbers it was given, in the unit that its axis names."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.quiver import Quiver
from matplotlib.text import Text
from pypdf import PdfReader

from invented import altered, invented_run
from ldbench import Error, Event, read_columns
from ldbench.__main__ import main
from ldbench.commands import plot
from ldbench.geometry.outlines import Outlines, case_outlines, flange_angle, run_outlines, turned
from ldbench.plots import document
from ldbench.plots.contents import arranged, contents_page, entries
from ldbench.plots.document import Part, bind, case_figures, even_shares, make_plots, save_pages
from ldbench.plots.frame import label_x, label_y
from ldbench.plots.geometry import geometry_page
from ldbench.plots.impact import HEADS, Recomputed, draw_impacts, hardest_page, impact_page, table_rows
from ldbench.plots.overview import first_contacts, overview_figures, side_by_side
from ldbench.plots.phase import energy_page
from ldbench.plots.ramp import is_ramp, ramp_page
from ldbench.plots.sections import close_up, instants, placed_outlines
from ldbench.plots.series import ENERGY, LAST, PAGES, RATIO, Page
from ldbench.plots.stretches import band, first_impact, last_second, thin
from ldbench.plots.style import ldbench_style
from ldbench.plots.summary import summary_page
from ldbench.plots.ticks import settle
from ldbench.plots.times import key_events, time_page
from ldbench.results.header import Header
from ldbench.results.quantities import CONTACT_NAMES, CONTACTS
from ldbench.results.run_data import RunData, read_data
from ldbench.results.summary import summary_row
from running import REPO, namelist, run_case

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
    curves = [curve for page in (*PAGES, ENERGY) for panel in page.panels for curve in panel.curves]
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


def test_impact_page_enlarges_the_first_contact():
    """The left flange touches from 10 to 12 ms: what is shown of that, in milliseconds, is the columns."""
    run = invented()
    figure = impact_page(run)
    force = next(ax for ax in figure.axes if ax.get_ylabel() == "N [kN]")
    for c in CONTACTS:
        line = curves_of(force)[CONTACT_NAMES[c]]
        t = line.get_xdata()
        rows = np.searchsorted(run.time, t/1e3 - 1e-9)
        np.testing.assert_allclose(line.get_ydata(), 1e-3*run.values(f"N_{c}")[rows], rtol=1e-12)
        assert t[0] < 10 and t[-1] > 12 and t[-1] - t[0] < 8
    assert [ax for ax in figure.axes if ax.get_xlabel() == "time [ms]"]


def test_ratio_is_the_outward_force_over_the_load():
    run = invented()
    left = -(run.values("Fy_LT") + run.values("Fy_LF"))/(run.values("Fz_LT") + run.values("Fz_LF"))
    right = (run.values("Fy_RT") + run.values("Fy_RF"))/(run.values("Fz_RT") + run.values("Fz_RF"))
    for curve, expected in zip(RATIO.curves, (left, right), strict=True):
        np.testing.assert_allclose(curve.values(run), expected, rtol=1e-12)
    # A wheel that is all but off its rail has none.
    run.data.loc[100:110, ["Fz_LT", "Fz_LF"]] = 0.0
    assert np.isnan(RATIO.curves[0].values(run)[100:111]).all() and np.isfinite(RATIO.curves[0].values(run)[:100]).all()


def test_contacts_keep_their_colours(drawn_pages: dict[str, Figure]):
    seen = {}
    for figure in (*(drawn_pages[page.title] for page in PAGES), impact_page(invented())):
        for ax in figure.axes:
            for line in ax.get_lines():
                for c in CONTACTS:
                    if line.get_label() == CONTACT_NAMES[c]:
                        seen.setdefault(c, set()).add((line.get_color(), line.is_dashed()))
    assert {c: len(found) for c, found in seen.items()} == dict.fromkeys(CONTACTS, 1)
    assert len({next(iter(found))[0] for found in seen.values()}) == 4
    assert all(next(iter(seen[c]))[1] == c.endswith("F") for c in CONTACTS)


def test_open_contact_is_named_not_left_empty():
    run = invented()
    for quantity in PER_CONTACT[3:]:
        run.data[f"{quantity}_LF"] = np.nan
    page = next(page for page in PAGES if page.title == "contact points")
    for ax in columns_of(time_page(run, page), page)[1][1:]:
        assert [t.get_text() for t in ax.texts if t.get_text() == "no contact"]


def test_events_are_marked_where_they_happen(drawn_pages: dict[str, Figure]):
    figure = drawn_pages[PAGES[0].title]
    for ax in figure.axes:
        assert [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == ":"] == [0.00999, 0.02]
    assert {"left flange", "centre"} <= {t.get_text() for t in figure.axes[0].texts}


def text_box(text: Text) -> object:
    return text.get_bbox_patch()


def test_band_holds_every_extreme():
    rng = np.random.default_rng(3)
    t, x = np.arange(10_000.0), rng.normal(size=10_000)
    x[2_000:3_000] = np.nan
    centre, low, high, mean = band(t, x, bins=100)
    assert len(centre) == 100 and np.all(np.diff(centre) > 0)
    for k, part in enumerate(np.split(x, 100)):
        if 20 <= k < 30:
            assert np.isnan([low[k], high[k], mean[k]]).all()
        else:
            assert (low[k], high[k]) == (part.min(), part.max())
            assert mean[k] == pytest.approx(part.mean(), abs=1e-12)


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


def test_thinned_curve_is_the_same_picture():
    """Drawn at 100 dots to the inch with every row and thinned: but for the shade of a dot in a thousand at the edges of
    the noise."""
    rng = np.random.default_rng(2)
    t = np.linspace(0, 1, 40_000)
    x = np.sin(9*t) + 0.05*rng.normal(size=len(t))
    x[20_000] = 3.0
    pictures = []
    for curve in (t, x), thin(t, x):
        figure = Figure(figsize=(10, 2), dpi=100)
        figure.add_axes((0, 0, 1, 1)).plot(*curve, color="black", linewidth=0.9)
        pictures.append(pixels(figure))
    assert len(thin(t, x)[0]) < 9_000
    assert (np.abs(pictures[0] - pictures[1]) > 64).mean() < 1e-3


def pixels(figure: Figure) -> np.ndarray:
    """What a figure looks like, (height, width), 0 black to 255."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].astype(int).mean(2)


def long_run() -> RunData:
    run = invented(rows=30_000, dt=1e-3, name="ex5_aw")
    run.data["F_ext"] = 5e3*run.time
    run.data.loc[12_345, "Y"] = 0.5           # one impact, in mm below
    return run


def test_long_run_is_a_band_and_its_last_second():
    run = long_run()
    overview = time_page(run, PAGES[0]).axes[0]
    bands = [c for c in overview.collections if isinstance(c, PolyCollection)]
    heights = np.concatenate([path.vertices[:, 1] for path in bands[0].get_paths()])
    before = run.time <= run.time[-1] - 1
    assert heights.max() == pytest.approx(500) and heights.min() == pytest.approx(1e3*run.values("Y")[before].min())
    last = time_page(run, LAST, last_second(run)).axes[0]
    t = last.get_lines()[0].get_xdata()
    assert t[-1] == run.time[-1] and t[-1] - t[0] == pytest.approx(1.0, abs=2e-3)
    np.testing.assert_allclose(last.get_lines()[0].get_ydata(), 1e3*run.values("Y")[-len(t):])
    assert first_impact(run).start < 0.01 < first_impact(run).end


def test_growing_force_is_the_axis_of_its_own_page(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(document, "PAGES", PAGES[:1])       # one page against time stands for all of them
    run = long_run()
    assert is_ramp(run) and not is_ramp(invented())
    assert [title for title, _ in case_figures(run)] == [
        PAGES[0].title, "energy and lateral force", LAST.title, "impacts of flanges"]
    figure = ramp_page(run)
    axes = {ax.get_ylabel(): ax for ax in figure.axes}
    line = axes["lateral Y [mm]"].get_lines()[0]
    before = run.time <= run.time[-1] - 1
    force = 5.0*run.time[before]
    assert force[0] <= line.get_xdata()[0] < line.get_xdata()[-1] <= force[-1] + 0.01
    np.testing.assert_allclose(line.get_ydata()[100], 1e3*run.values("Y")[before][np.searchsorted(force, line.get_xdata()[100])],
                               rtol=0.05)
    assert axes["L/V, left wheel"].get_xlim() == axes["L/V, right wheel"].get_xlim()


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


def test_window_that_ends_before_the_run_names_no_end_of_its_own():
    """The portrait of a long run shows its last second: it has no start, and its end is that of the run."""
    run = long_run()
    run.data["F_ext"] = 0.0
    axes = {ax.get_xlabel(): ax for ax in energy_page(run).axes}
    labels = curves_of(axes["Y [mm]"])
    assert "start" not in labels and labels["end of the run"].get_xdata()[0] == 1e3*run.values("Y")[-1]


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


# A real run: geometry of the pictures ------------------------------------------------------

@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunData, Path]:
    """The wheelset thrown at the left flange at 1 m/s, and its geometry file."""
    folder = tmp_path_factory.mktemp("thrown")
    text = namelist(
        case={"name": "ex3_aw", "title": "thrown"}, initial={"vY": 1.0, "roll_rate": 0.0333},
        profiles={"wheel_profile": REPO/"profiles/awprof.yz", "rail_profile": REPO/"profiles/arprof.yz"},
        contact={"model": "hertz"}, table={"n_lateral": 60, "n_roll": 9, "n_depth": 9}, integrator={"dt": 1e-5, "t_end": 0.02},
        output={"file": folder/"ex3_aw.txt", "geometry_file": folder/"geometry_aw.txt"})
    done = run_case(text, folder)
    assert done.returncode == 0, done.stderr
    return read_data(folder/"ex3_aw.txt"), folder/"geometry_aw.txt"


@pytest.fixture(scope="module")
def impact(thrown: tuple[RunData, Path]) -> Figure:
    """The page of the first impact."""
    with ldbench_style():
        return impact_page(thrown[0])


def test_header_is_understood(thrown: tuple[RunData, Path]):
    run, _ = thrown
    assert run.result("clearance_left") == pytest.approx(10.18e-3, abs=1e-6)
    assert run.heading == "Exercise 3, actual profiles" and run.header.reconstruction
    assert run.setting("initial", "vY") == 1.0 and run.setting("contact", "model") == "hertz"
    contact = run.first("left flange contact")
    assert contact and contact.t == run.first_contact("LF")
    # There is a row at the event; its force is next to none.
    row = np.flatnonzero(run.values("N_LF") > 0)[0]
    assert min(abs(run.time[[row - 1, row]] - contact.t)) < 1e-6 and run.values("N_LF")[row] < 5e3
    N, t = run.peak("LF")
    assert N == pytest.approx(run.values("N_LF").max(), rel=0.01) and t == pytest.approx(0.0115, abs=5e-4)


@pytest.mark.parametrize(("line", "damaged", "found"), [
    ("clearance_left = 0.01018", "clearance_left = 0.O1018", "clearance_left"),
    ("  order = 2", "  order = x2", "order"), ("event(1)%t = ", "event(1)%t = nan ! ", "t"),
])
def test_damaged_numbers_of_a_header_are_told(line: str, damaged: str, found: str, thrown: tuple[RunData, Path], tmp_path: Path):
    text = thrown[0].file.read_text()
    assert line in text
    (tmp_path/"columns.txt").write_text(text.replace(line, damaged, 1))
    with pytest.raises(Error) as error:
        read_data(tmp_path/"columns.txt")
    assert (error.value.file, error.value.expected) == (str(tmp_path/"columns.txt"), f"a number for {found}")


def test_a_number_that_the_header_lacks_is_told(thrown: tuple[RunData, Path], tmp_path: Path):
    lines = thrown[0].file.read_text().splitlines(keepends=True)
    (tmp_path/"columns.txt").write_text("".join(line for line in lines if "  order = " not in line))
    with pytest.raises(Error) as error:
        energy_page(read_data(tmp_path/"columns.txt"))
    assert (error.value.file, error.value.found) == (str(tmp_path/"columns.txt"), "none")
    assert error.value.expected == "a number for &integrator order in the header"


def test_rail_is_placed_by_the_gauge(thrown: tuple[RunData, Path]):
    rail = outlines(thrown[0]).left.rail
    assert abs(rail[:, 1].max()) < 1e-15       # rounding, where the core puts the top of rail
    side = rail[(rail[:, 0] < 0.73) & (rail[:, 1] > -0.02) & (rail[:, 1] < -0.01)]
    order = np.argsort(side[:, 1])
    assert np.interp(-0.014, side[order, 1], side[order, 0]) == pytest.approx(1.4351/2, abs=1e-6)


def test_wheel_stands_on_the_rail(thrown: tuple[RunData, Path]):
    """At rest the sections overlap by the Hertzian approach, 0.1005 mm, at the rolling radius, on both sides."""
    run, _ = thrown
    height = run.result("axle_height")
    for side, sign in outlines(run).sides:
        wheel, rail = turned(side.wheel*[sign, 1], 0, height, 0), side.rail*[sign, 1]
        y = sign*np.linspace(0.735, 0.775, 4001)
        gap = height_at(wheel, y) - height_at(rail, y)
        assert gap.min() == pytest.approx(-0.10052e-3, rel=0.01)
        k = int(gap.argmin())
        assert height - height_at(wheel, y)[k] == pytest.approx(0.457, abs=2e-5)
        assert abs(y[k]) == pytest.approx(abs(run.values("y_LT")[0]), abs=1e-3)


def outlines(run: RunData) -> Outlines:
    found, remark = run_outlines(run)
    assert found and remark == ""
    return found


def height_at(points: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The upper side of a section at y."""
    order = np.argsort(points[:, 0])
    points = points[order]
    top = points[points[:, 1] > -0.01] if points[:, 1].max() < 0.1 else points
    return np.interp(y, top[:, 0], top[:, 1])


def test_roll_lifts_the_left_wheel(thrown: tuple[RunData, Path]):
    left, right = (side.wheel*[sign, 1] for side, sign in outlines(thrown[0]).sides)
    assert np.all(turned(left, 0.002, 0.457, 0.01)[:, 1] > turned(left, 0, 0.457, 0)[:, 1])
    assert np.all(turned(right, 0, 0.457, 0.01)[:, 1] < turned(right, 0, 0.457, 0)[:, 1])


def test_close_ups_follow_the_gauge(thrown: tuple[RunData, Path], tmp_path: Path):
    """The rail's head is in the middle for a gauge of 1 m, too, on both sides."""
    narrow = 1.0 - 1.4351
    case = thrown[0].case.replace(gauge=1.0, back_to_back=thrown[0].number("wheelset", "back_to_back") + narrow)
    for right, (side, sign) in enumerate(case_outlines(case).sides):
        (left, other), _ = close_up(side, sign)
        gauge_corner = 1e3*sign*side.rail[:, 0].min()
        assert left > other and other + 40 < gauge_corner < left - 40, right
        assert abs((left + other)/2) == pytest.approx(537, abs=3)


def test_arrows_are_the_forces_at_the_contacts(thrown: tuple[RunData, Path], impact: Figure):
    run, _ = thrown
    (label, k), *_ = instants(run)
    assert "left flange" in label and run.values("N_LF")[k] == run.values("N_LF").max()
    arrows = {(c.get_offsets()[0][0], c.get_offsets()[0][1]): (c.U[0], c.V[0])
              for c in impact.axes[0].collections if isinstance(c, Quiver)}
    closed = [c for c in ("LT", "LF") if run.values(f"N_{c}")[k] > 0]
    assert len(arrows) == len(closed) and "LF" in closed
    for c in closed:
        foot = 1e3*run.values(f"y_{c}")[k], 1e3*run.values(f"z_{c}")[k]
        nearest = min(arrows, key=lambda at: np.hypot(at[0] - foot[0], at[1] - foot[1]))
        assert nearest == pytest.approx(foot)
        longest = max(run.values(f"N_{b}")[k] for b in CONTACTS)
        force = np.array([run.values(f"Fy_{c}")[k], run.values(f"Fz_{c}")[k]])
        assert arrows[nearest] == pytest.approx(40*force/longest)
    # Left is left, and the force of the flange pushes the wheelset to the right.
    left, right = impact.axes[0].get_xlim()
    assert left > right and run.values("Fy_LF")[k] < 0
    # The contact points lie on the wheel that is drawn.
    wheel = impact.axes[0].get_lines()[0].get_xydata()
    for c in closed:
        point = 1e3*np.array([run.values(f"y_{c}")[k], run.values(f"z_{c}")[k]])
        assert np.hypot(*(wheel - point).T).min() < 0.2          # [mm], points every 0.25 mm


def test_pictures_have_no_words_on_them(thrown: tuple[RunData, Path], impact: Figure):
    """Forces and angles stand in the title, clear of the wheel."""
    run, _ = thrown
    left = impact.axes[0]
    assert not list(left.texts) and f"{1e-3*run.values('N_LF').max():.1f} kN" in left.get_title(loc="left")


def test_missing_profile_leaves_the_picture_out(thrown: tuple[RunData, Path]):
    run, _ = thrown
    settings = run.header.settings
    profiles = {**settings["profiles"], "wheel_profile": "nowhere.yz", "rail_profile": "nowhere.yz"}
    lost = altered(run, {"settings": {**settings, "profiles": profiles}})
    assert placed_outlines(lost) is None
    assert not [c for ax in impact_page(lost).axes for c in ax.collections if isinstance(c, Quiver)]


def test_steepest_angle_of_the_flange(thrown: tuple[RunData, Path]):
    """The reconstruction of the actual wheel has a face of 75 degrees."""
    assert np.degrees(flange_angle(outlines(thrown[0]).left)) == pytest.approx(75, abs=0.2)


def test_table_of_impacts_says_what_the_run_says(thrown: tuple[RunData, Path], impact: Figure):
    run, _ = thrown
    first, = run.impacts(("LF",))
    row, = table_rows(run, [first])
    assert len(row) == len(HEADS) and row[0] == "left flange"
    assert row[3] == f"{1e-3*run.values('N_LF').max():.1f} kN"
    t, N = run.time, run.values("N_LF")
    impulse = float(np.sum(np.diff(t)*(N[1:] + N[:-1])/2))
    assert float(row[5].split()[0]) == pytest.approx(1e-3*impulse, rel=2e-3)
    before = run.values("KE_lat")[np.flatnonzero(N > 0)[0] - 1]
    assert float(row[7].split()[0]) == pytest.approx(before, abs=0.06)
    assert set(row) <= set(texts(impact))


def test_impacts_of_the_root_of_a_flange_are_told(thrown: tuple[RunData, Path]):
    """By a contact angle below 25 degrees; an unknown angle tells nothing."""
    run, _ = thrown
    first, = run.impacts(("LF",))
    angles = {24.9: "left flange, root", -24.9: "left flange, root", 25.1: "left flange", np.nan: "left flange"}
    rows = table_rows(run, [first._replace(angle=np.radians(angle)) for angle in angles])
    assert [row[0] for row in rows] == list(angles.values())
    rooted = altered(run, data=run.data.assign(angle_LF=np.radians(10.0)))
    for one, expected in (run, False), (rooted, True):
        figure = figure_of(one)
        assert any("root: contact angle below 25°" in words for words in texts(figure)) == expected
        assert ("left flange, root" in texts(figure)) == expected


def figure_of(run: RunData) -> Figure:
    """A page with the table of impacts alone."""
    figure = Figure()
    draw_impacts(figure, run, 0.9)
    return figure


# Axes that are drawn with one tick -----------------------------------------------------------

def drawn(figure: Figure, settled: bool) -> np.ndarray:
    """The picture of a figure."""
    if settled:
        settle(figure)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).astype(int)


@pytest.mark.parametrize("kind", ["linear", "log", "power", "inner"])
def test_settled_axes_look_as_matplotlib_draws_them(kind: str):
    """Marks, grid, numbers, labels, and the power of ten of an axis."""
    def make() -> Figure:
        figure = Figure(figsize=(6, 4))
        axes = figure.subplots(2, 1, sharex=True)
        for ax in axes:
            ax.plot(np.linspace(0.013, 97.7, 50), np.geomspace(0.02, 370, 50)*(1e-8 if kind == "power" else 1))
            label_y(ax, "force [kN]")
        if kind == "log":
            axes[0].set(yscale="log", xscale="log")
        if kind == "inner":
            axes[0].set_xlim(100, 0)
            axes[0].tick_params(labelsize=5)
            axes[1].set_axis_off()
        label_x(axes[-1], "time [s]")
        return figure

    with ldbench_style():
        plain, settled = drawn(make(), False), drawn(make(), True)
    assert (plain < 128).any()
    assert np.abs(plain - settled).max() <= 1


def test_axes_with_labels_that_are_not_placed_stay_matplotlibs():
    figure = Figure()
    ax = figure.subplots()
    ax.set_xlabel("anywhere")
    settle(figure)
    assert ax.xaxis.get_visible() and not ax.yaxis.get_visible()


def test_stretch_of_full_resolution_lies_on_the_rows_of_the_run(thrown: tuple[RunData, Path]):
    """A stretch has the time of the run, and dots where the run has rows."""
    run, _ = thrown
    k = len(run.time)//3
    later = altered(run, data=run.data.iloc[k:].reset_index(drop=True))
    later.data["time"] -= run.time[k]
    coarse = altered(run, data=run.data.iloc[::7].reset_index(drop=True))
    ax = hardest_page(coarse, Recomputed(later, float(run.time[k]))).axes[0]
    curve, dots = curves_of(ax)["left flange"], ax.get_lines()[-1]
    assert ax.get_xlim()[0] == pytest.approx(1e3*run.time[k]) and dots.get_linestyle() == "None"
    known = np.interp(dots.get_xdata(), curve.get_xdata(), curve.get_ydata())
    np.testing.assert_allclose(dots.get_ydata(), known, atol=1e-9)
    assert len(dots.get_xdata()) > 10


def test_geometry_page_draws_the_file(thrown: tuple[RunData, Path]):
    table = read_columns(thrown[1])
    figure = geometry_page(thrown[1])
    angle, radius, delta, conicity, *_ = figure.axes
    for ax, column, factor in ((angle, "angle_L", 180/np.pi), (radius, "radius_L", 1e3), (delta, "delta_r", 1e3),
                               (conicity, "conicity", 1)):
        np.testing.assert_allclose(ax.get_lines()[0].get_ydata(), factor*table[column])
        np.testing.assert_allclose(ax.get_lines()[0].get_xdata(), 1e3*table["Y"])
    np.testing.assert_allclose(angle.get_lines()[1].get_ydata(), 180/np.pi*table["angle_R"])
    clearance = {round(line.get_xdata()[0], 3) for line in angle.get_lines()[2:]}
    assert clearance == {-10.18, 10.18}


@pytest.fixture(scope="module")
def laid_out(thrown: tuple[RunData, Path]) -> tuple[RunData, dict[str, Figure]]:
    """A run with events that are close to each other, and its pages by their titles: all is put in its place on them, no pixel
    is painted."""
    times = {"left flange contact": 0.0100, "right flange contact": 0.0104, "centre passage": 0.0108, "derailment": 0.0196}
    crowded = altered(thrown[0], {"events": tuple(Event(t, kind) for kind, t in times.items())})
    with ldbench_style():
        figures = dict([*case_figures(crowded), (ENERGY.title, time_page(crowded, ENERGY))])
        for figure in figures.values():
            figure.draw_without_rendering()
    return crowded, figures


def test_words_of_events_lie_above_the_axes_and_clear_of_all_other_words(laid_out: tuple[RunData, dict[str, Figure]]):
    """On no curve, no tick label, no title, no legend and not on each other, however close the events are."""
    crowded, figures = laid_out
    assert len(key_events(crowded)) == 4
    for page in (*PAGES, ENERGY):
        figure = figures[page.title]
        renderer = FigureCanvasAgg(figure).get_renderer()
        words = [text for ax in figure.axes for text in ax.texts if text.get_text() in {label for _, label in key_events(crowded)}]
        assert len(words) == 4*len(page.columns)
        boxes = [text.get_window_extent(renderer) for text in words]
        others = [t.get_window_extent(renderer) for t in figure.findobj(Text)
                  if t.get_text() and t not in words and t.get_visible()]
        for k, box in enumerate(boxes):
            assert text_box(words[k]) is None
            assert not any(box.overlaps(ax.get_window_extent(renderer)) for ax in figure.axes if ax.get_visible())
            assert not any(box.overlaps(other) for other in (*others, *boxes[:k])), (page.title, words[k].get_text())


def test_labels_of_axes_lie_clear_of_their_numbers(thrown: tuple[RunData, Path], laid_out: tuple[RunData, dict[str, Figure]],
                                                   monkeypatch: pytest.MonkeyPatch):
    """On every kind of page, as it is drawn, no label of an axis lies on a tick label or on a title."""
    run, geometry = thrown
    figures = [geometry_page(geometry), *(figure for _, figure in overview_figures([run]))]
    # One page against time of a long run stands for all that are drawn like it.
    monkeypatch.setattr(document, "PAGES", PAGES[:1])
    figures += [figure for _, figure in case_figures(long_run())]
    for figure in figures:
        figure.draw_without_rendering()
    for figure in (*laid_out[1].values(), *figures):
        renderer = FigureCanvasAgg(figure).get_renderer()
        shown = [ax for ax in figure.axes if ax.get_visible() and ax.axison]
        titles = [title.get_window_extent(renderer) for ax in shown for title in (ax.title, ax._left_title) if title.get_text()]
        for ax in shown:
            for axis in ax.xaxis, ax.yaxis:
                if not axis.label.get_text():
                    continue
                label = axis.label.get_window_extent(renderer)
                ticks = [tick.get_window_extent(renderer) for tick in axis.get_ticklabels() if tick.get_text()]
                assert ticks or axis is ax.yaxis
                for other in (*ticks, *titles):
                    assert not label.overlaps(other), (figure.texts[0].get_text(), axis.label.get_text())


# Titles and runs side by side ---------------------------------------------------------------

@pytest.mark.parametrize(("wheel", "rail", "words"), [
    ("profiles/awprof.yz", "profiles/arprof.yz", "actual profiles"), ("a/swprof.yz", "b/srprof.yz", "simplified profiles"),
    ("profiles/s1002.yz", "profiles/60e1.yz", "s1002.yz on 60e1.yz"), ("awprof.yz", "srprof.yz", "awprof.yz on srprof.yz")])
def test_titles_name_the_profiles_of_the_run(wheel: str, rail: str, words: str):
    """Whatever the name of the case says."""
    run = altered(invented(), {"settings": {"profiles": {"wheel_profile": wheel, "rail_profile": rail}}})
    assert run.heading == f"Exercise 2, {words}" and run.pair == words
    assert summary_row(run)["profiles"] == words


def test_sides_with_other_profiles_are_named_both():
    profiles = {"wheel_profile": "awprof.yz", "rail_profile": "arprof.yz", "wheel_profile_right": "worn.yz"}
    assert altered(invented(), {"settings": {"profiles": profiles}}).pair == "actual profiles (left), worn.yz on arprof.yz (right)"


def test_runs_side_by_side_are_the_runs(thrown: tuple[RunData, Path]):
    run, _ = thrown
    other = altered(run, name="ex3_sw", data=run.data.assign(Y=0.5*run.values("Y")))
    axes = side_by_side([run, other]).axes
    for line, one in zip(axes[0].get_lines(), (run, other), strict=True):
        np.testing.assert_allclose(line.get_ydata(), 1e3*one.values("Y"))
    assert axes[2].get_lines()[0].get_ydata().max() == pytest.approx(1e-3*run.values("N_LF").max())
    bars = [patch.get_width() for patch in first_contacts([run, other]).axes[0].patches]
    assert sum(bars) == pytest.approx(2*100)
    assert overview_figures([long_run()]) == []


# Summary and document ----------------------------------------------------------------------

def test_contents_page_leads_to_every_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The number at each line, its link and the bookmark lead to the page with that title, which has the number at its foot."""
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
    words = [page.extract_text() for page in found.pages]
    assert all(f"{k + 1} / 7" in text for k, text in enumerate(words))
    lines = entries([(part.title, part.pages) for part in parts], 2)
    assert [(line.words, line.page) for line in lines] == [
        ("part 0", 2), ("part 1", 3), ("sheet 0", 3), ("sheet 1", 4), ("sheet 2", 5), ("part 2", 6), ("sheet 0", 6), ("sheet 1", 7)]
    numbers = {page.indirect_reference.idnum: k for k, page in enumerate(found.pages)}
    links = [link.get_object() for link in found.pages[0]["/Annots"]]
    assert [numbers[link["/Dest"][0].idnum] + 1 for link in links] == [line.page for line in lines]
    columns = arranged(lines)
    assert [line for column in columns for line in column] == lines
    assert [column[0].chapter for column in columns] == [True]*len(columns)
    figure, targets = contents_page("contents", lines)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for line, target, link in zip(lines, targets, links, strict=True):
        assert [float(x) for x in link["/Rect"]] == pytest.approx(target.rectangle, abs=0.01)
        left, low, right, high = target.rectangle
        boxes = [t.get_window_extent(renderer) for t in figure.texts if t.get_text() == line.words]
        assert [box for box in boxes if left - 1 <= box.x0 <= box.x1 <= right + 1 and low - 1 <= box.y0 <= box.y1 <= high + 1]
    assert [part.title for part in found.outline if not isinstance(part, list)] == ["Contents", "part 0", "part 1", "part 2"]


@pytest.mark.parametrize("number", [1, 2, 4, 12])
@pytest.mark.parametrize("count", [0, 1, 5, 30])
def test_shares_are_even(count: int, number: int):
    """Each index is in one share, and no share costs more than the mean and the dearest one together."""
    costs = np.random.default_rng(count).uniform(0.1, 10, count).tolist()
    shares = even_shares(costs, number)
    assert sorted(k for share in shares for k in share) == list(range(len(costs)))
    assert len(shares) <= number and all(share == sorted(share) for share in shares)
    for share in shares:
        assert sum(costs[k] for k in share) <= sum(costs)/number + max(costs)*(1 + 1e-9)


def test_summary_page_prints_what_it_is_given():
    """Chaotic results are in italics, with the digits that hold."""
    row = summary_row(invented())
    derailed = row | {"case": "ex5_sw", "t_derailment": 54.2030001, "F_derailment": 271015.0}
    [ax] = summary_page([row, derailed], "", {"ex5_sw": {"peak_N_LF": 900.0, "n_left_flange_contact": np.inf}}).axes
    found = {text.get_text(): text.get_style() for text in ax.texts}
    assert {"ex2_aw", "ex5_sw", "54.203", "271.0", "0.009990", "123.46", "2.0e-09", "–"} <= set(found)
    assert (found["123"], found["123.46"]) == ("italic", "normal")


def test_summary_row_measures_drift_by_the_initial_energy():
    run = invented()
    for column, joule in (("KE_lat", 3.0), ("KE_vert", 0.5), ("KE_roll", 0.5)):
        run.data[column] = joule
    assert summary_row(run)["drift_relative"] == pytest.approx(2e-9/4)
    for column in ("KE_lat", "KE_vert", "KE_roll"):
        run.data[column] = 0.0
    run.data["W_ext"] = np.linspace(0, 8, len(run.time))
    assert summary_row(run)["drift_relative"] == pytest.approx(2e-9/8)


def test_document_is_the_same_for_any_number_of_processes(thrown: tuple[RunData, Path], tmp_path: Path,
                                                          monkeypatch: pytest.MonkeyPatch):
    """Two runs, which go to processes of their own; one page against time stands for all of them."""
    monkeypatch.setattr(document, "PAGES", PAGES[:1])
    monkeypatch.setattr(document, "overview_figures", lambda runs: [])
    monkeypatch.setattr(document, "TOGETHER", 1)
    run, geometry = thrown
    documents = [tmp_path/f"{jobs}.pdf" for jobs in (1, 3)]
    pages = [make_plots([run.file]*2, target, [geometry], jobs) for target, jobs in zip(documents, (1, 3), strict=True)]
    assert pages == [3 + 2*3]*2         # contents, summary, geometry, the pages of the runs
    assert documents[0].read_bytes() == documents[1].read_bytes()


def test_plot_command_passes_on_what_it_is_told(thrown: tuple[RunData, Path], tmp_path: Path,
                                               monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    asked = {}
    monkeypatch.setattr(plot, "make_plots", lambda *words: asked.update(words=(*words[:4], words[5])) or 7)
    run, geometry = thrown
    target = tmp_path/"plots.pdf"
    words = ["plot", str(run.file), "-o", str(target), "--geometry", str(geometry), "--geometry", "other.txt", "-j", "1",
             "--map", "map.toml"]
    assert main(words) == 0
    assert asked["words"] == ([run.file], target, [geometry, Path("other.txt")], 1, Path("map.toml"))
    assert capsys.readouterr().out == f"{target}: 7 pages\n"
