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
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from invented import altered, invented_run
from ldbench import Error, Event, read_columns
from ldbench.__main__ import main
from ldbench.commands import plot
from ldbench.plots.document import case_figures, make_plots
from ldbench.plots.geometry import geometry_page
from ldbench.plots.phase import phase_page
from ldbench.plots.sections import instants, section_page
from ldbench.plots.series import PAGES, Page
from ldbench.plots.stretches import band, first_episode, thin
from ldbench.plots.style import ldbench_style
from ldbench.plots.summary import summary_page
from ldbench.plots.times import time_page
from ldbench.profiles.outlines import Outlines, run_outlines, turned
from ldbench.results.header import Header
from ldbench.results.quantities import CONTACT_NAMES, CONTACTS
from ldbench.results.run_data import RunData, read_data
from ldbench.results.summary import summary_row
from running import REPO, namelist, run_case

# What the call asks for, as columns.
KINEMATICS = ["Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc"]
PER_CONTACT = ["angle", "N", "Fz", "Fy", "y", "z", "radius"]
ENERGIES = ["KE_lat", "KE_vert", "KE_roll", "PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R", "W_ext", "E_drift"]
FACTORS = {"mm": 1e3, "mrad": 1e3, "mrad/s": 1e3, "kN": 1e-3, "°": 180/np.pi,
           "m/s": 1, "m/s²": 1, "rad/s²": 1, "J": 1}


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


def unit(ax: Axes) -> str:
    return ax.get_ylabel().rpartition("[")[2].rstrip("]")


def texts(figure: Figure) -> list[str]:
    cells = [cell for ax in figure.axes for table in ax.tables for cell in table.get_celld().values()]
    return [t.get_text() for t in figure.findobj(Text)] + [cell.get_text().get_text() for cell in cells]


def grid(figure: Figure, rows: int) -> list[list[Axes]]:
    n = len(figure.axes)//rows
    return [figure.axes[i*n:(i + 1)*n] for i in range(rows)]


def test_everything_the_call_lists_has_a_panel():
    curves = [curve for page in PAGES for panel in page.panels for curve in panel.curves]
    drawn = [column for curve in curves for column in curve.columns]
    wanted = KINEMATICS + [f"{q}_{c}" for q in PER_CONTACT for c in CONTACTS] + ENERGIES
    assert not set(wanted) - set(drawn)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.title)
def test_page_draws_the_columns(page: Page):
    run = invented()
    figure = time_page(run, page)
    assert f"Exercise 2, actual profiles: {page.title}" in texts(figure)
    for panel, (overview, zoom) in zip(page.panels, grid(figure, len(page.panels)), strict=True):
        factor = FACTORS[unit(overview)]
        lines = {line.get_label(): line for line in overview.get_lines()}
        for curve in panel.curves:
            expected = factor*sum(run.values(column) for column in curve.columns)
            np.testing.assert_allclose(lines[curve.label].get_ydata(), expected, rtol=1e-12)
            np.testing.assert_array_equal(lines[curve.label].get_xdata(), run.time)
        # The zoom shows the same numbers around 10 to 12 ms, in milliseconds.
        for curve, line in zip(panel.curves, zoom.get_lines(), strict=True):
            t = line.get_xdata()
            rows = np.searchsorted(run.time, t/1e3 - 1e-9)
            expected = factor*sum(run.values(column) for column in curve.columns)[rows]
            np.testing.assert_allclose(line.get_ydata(), expected, rtol=1e-12)
            assert t[0] < 10 and t[-1] > 12 and t[-1] - t[0] < 8
    assert overview.get_xlabel() == "time [s]" and zoom.get_xlabel() == "time [ms]"


def test_contacts_keep_their_colours():
    run = invented()
    seen = {}
    for page in PAGES:
        for ax in time_page(run, page).axes:
            for line in ax.get_lines():
                for c in CONTACTS:
                    if line.get_label() == CONTACT_NAMES[c]:
                        seen.setdefault(c, set()).add((line.get_color(), line.is_dashed()))
    assert {c: len(found) for c, found in seen.items()} == dict.fromkeys(CONTACTS, 1)
    assert len({next(iter(found))[0] for found in seen.values()}) == 4
    assert all(next(iter(seen[c]))[1] == c.endswith("F") for c in CONTACTS)


def test_open_contact_is_named_not_left_empty():
    page = next(page for page in PAGES if page.title == "contact positions, lateral")
    overview, zoom = grid(time_page(invented(), page), 4)[3]
    assert [t.get_text() for t in overview.texts if t.get_text() == "no contact"]
    assert [t.get_text() for t in zoom.texts if t.get_text() == "no contact"]


def test_events_are_marked_where_they_happen():
    figure = time_page(invented(), PAGES[0])
    marks = [line.get_xdata()[0] for line in figure.axes[0].get_lines() if line.get_linestyle() == ":"]
    assert marks == [0.00999, 0.02]
    assert {"left flange", "centre"} <= {t.get_text() for t in figure.axes[0].texts}


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


def test_long_run_is_a_band_and_its_last_second():
    run = invented(rows=30_000, dt=1e-3, name="ex5_aw")
    run.data.loc[12_345, "Y"] = 0.5           # one impact, in mm below
    overview, zoom, last = grid(time_page(run, PAGES[0]), 3)[0]
    bands = [c for c in overview.collections if isinstance(c, PolyCollection)]
    heights = np.concatenate([path.vertices[:, 1] for path in bands[0].get_paths()])
    before = run.time <= run.time[-1] - 1
    assert heights.max() == pytest.approx(500) and heights.min() == pytest.approx(1e3*run.values("Y")[before].min())
    t = last.get_lines()[0].get_xdata()
    assert t[-1] == run.time[-1] and t[-1] - t[0] == pytest.approx(1.0, abs=2e-3)
    np.testing.assert_allclose(last.get_lines()[0].get_ydata(), 1e3*run.values("Y")[-len(t):])
    assert zoom.get_xlim()[0] < 10 < zoom.get_xlim()[1]


def test_phase_portrait_is_velocity_over_displacement():
    run = invented()
    axes = phase_page(run).axes
    for ax, (q, v, x_scale, v_scale) in zip(axes, (("Y", "vY", 1e3, 1), ("Z", "vZ", 1e3, 1),
                                                   ("roll", "roll_rate", 1e3, 1e3)), strict=True):
        curve = ax.get_lines()[0]
        np.testing.assert_allclose(curve.get_xdata(), x_scale*run.values(q))
        np.testing.assert_allclose(curve.get_ydata(), v_scale*run.values(v))
        start = next(line for line in ax.get_lines() if line.get_label() == "start")
        assert start.get_xdata()[0] == x_scale*run.values(q)[0]


def test_first_episode_is_the_first_only():
    run = invented()
    run.data.loc[300:320, "N_LF"] = 5.0
    assert first_episode(run, "LF") == pytest.approx((0.01, 0.012))
    assert first_episode(run, "RF") is None


# A real run: geometry of the pictures ------------------------------------------------------

@pytest.fixture(scope="module")
def thrown(tmp_path_factory: pytest.TempPathFactory) -> tuple[RunData, Path]:
    """The wheelset thrown at the left flange at 1 m/s, and its geometry file."""
    folder = tmp_path_factory.mktemp("thrown")
    text = namelist(
        case={"name": "ex3_aw", "title": "thrown"}, initial={"vY": 1.0, "roll_rate": 0.0333},
        profiles={"wheel_profile": REPO/"profiles/awprof.yz", "rail_profile": REPO/"profiles/arprof.yz"},
        contact={"model": "strip"}, table={"n_lateral": 60, "n_roll": 9, "n_depth": 9}, integrator={"dt": 1e-5, "t_end": 0.02},
        output={"file": folder/"ex3_aw.txt", "geometry_file": folder/"geometry_aw.txt"})
    done = run_case(text, folder)
    assert done.returncode == 0, done.stderr
    return read_data(folder/"ex3_aw.txt"), folder/"geometry_aw.txt"


def test_header_is_understood(thrown: tuple[RunData, Path]):
    run, _ = thrown
    assert run.result("clearance_left") == pytest.approx(10.18e-3, abs=1e-6)
    assert run.heading == "Exercise 3, actual profiles" and run.header.reconstruction
    assert run.setting("initial", "vY") == 1.0 and run.setting("contact", "model") == "strip"
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
        phase_page(read_data(tmp_path/"columns.txt"))
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


def test_arrows_are_the_forces_at_the_contacts(thrown: tuple[RunData, Path]):
    run, _ = thrown
    (label, k), *_ = instants(run)
    assert "left flange" in label and run.values("N_LF")[k] == run.values("N_LF").max()
    figure = section_page(run)
    arrows = {(c.get_offsets()[0][0], c.get_offsets()[0][1]): (c.U[0], c.V[0])
              for c in figure.axes[0].collections if isinstance(c, Quiver)}
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
    left, right = figure.axes[0].get_xlim()
    assert left > right and run.values("Fy_LF")[k] < 0
    # The contact points lie on the wheel that is drawn.
    wheel = figure.axes[0].get_lines()[0].get_xydata()
    for c in closed:
        point = 1e3*np.array([run.values(f"y_{c}")[k], run.values(f"z_{c}")[k]])
        assert np.hypot(*(wheel - point).T).min() < 0.2          # [mm], points every 0.25 mm


def test_missing_profile_leaves_the_picture_out(thrown: tuple[RunData, Path]):
    run, _ = thrown
    settings = run.header.settings
    profiles = {**settings["profiles"], "wheel_profile": "nowhere.yz", "rail_profile": "nowhere.yz"}
    assert section_page(altered(run, {"settings": {**settings, "profiles": profiles}})) is None


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


def test_labels_of_axes_lie_clear_of_their_numbers(thrown: tuple[RunData, Path]):
    """On every kind of page, as it is drawn, no label of an axis lies on a tick label or on a title."""
    run, geometry = thrown
    figures = [*(figure for _, figure in case_figures(run)), geometry_page(geometry),
               time_page(invented(rows=30_000, dt=1e-3, name="ex5_aw"), PAGES[0])]
    for figure in figures:
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw(renderer)
        shown = [ax for ax in figure.axes if ax.get_visible() and ax.axison]
        titles = [title.get_window_extent(renderer) for ax in shown for title in (ax.title, ax._left_title)
                  if title.get_text()]
        for ax in shown:
            for axis in ax.xaxis, ax.yaxis:
                if not axis.label.get_text():
                    continue
                label = axis.label.get_window_extent(renderer)
                ticks = [tick.get_window_extent(renderer) for tick in axis.get_ticklabels() if tick.get_text()]
                assert ticks or axis is ax.yaxis
                for other in (*ticks, *titles):
                    assert not label.overlaps(other), (figure.texts[0].get_text(), axis.label.get_text())


# Summary and document ----------------------------------------------------------------------

def test_summary_page_prints_what_it_is_given():
    row = summary_row(invented())
    figure = summary_page([row, row | {"case": "ex5_sw", "t_derailment": 54.2030001, "F_derailment": 271015.0}])
    found = texts(figure)
    assert {"ex2_aw", "ex5_sw", "54.203000", "271.015", "0.009990", "123.46", "2.0e-09"} <= set(found)
    assert found.count("–") > 2


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
    """Two pages against time stand for all of them."""
    monkeypatch.setattr("ldbench.plots.document.PAGES", PAGES[:2])
    run, geometry = thrown
    documents = [tmp_path/f"{jobs}.pdf" for jobs in (1, 3)]
    pages = [make_plots([run.file], document, [geometry], jobs)
             for document, jobs in zip(documents, (1, 3), strict=True)]
    assert pages == [2 + 4]*2
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
