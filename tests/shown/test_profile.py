"""`python -m ldbench profile`: the pages and the numbers of a wheel, a rail and a pair."""
from __future__ import annotations

import io
import json
from contextlib import redirect_stdout
from dataclasses import replace
from math import gamma, pi, sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image
from pypdf import PdfReader

import ldbench
from ldbench import Profile
from ldbench.__main__ import main
from ldbench.commands import profile as command
from ldbench.conicity import FINE_PITCH, equivalent_conicity, linearised_conicity
from ldbench.geometry.pair import Pair, pair
from ldbench.plots.geometry import contact_lines, pair_page
from ldbench.plots.profile_page import profile_page, wheel_dimensions
from ldbench.plots.sheets import save_sheets
from ldbench.plots.style import ldbench_style
from named_artists import artists, shown
from of_geometry import compare_contact_line, compare_functions, compare_raised, compare_reach, says
from probes import gaps, profile, tangent_angles
from reading import Line, differing
from running import REPO
from table import CRC, MM
from walk import walk

RAIL, WHEEL, RIGHT = (REPO/f"profiles/{name}.yz" for name in ("arprof", "awprof", "swprof"))


class Told(NamedTuple):
    """What the command prints of the actual pair with the simplified wheel on the right, and its pages in a folder."""

    words: str
    numbers: dict
    pair: Pair
    folder: Path


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Told:
    folder, found, said = tmp_path_factory.mktemp("profile"), [], []

    def pair_once(*case: object) -> Pair:
        if not found:
            found.append(pair(*case))
        return found[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(command, "pair", pair_once)
        patch.setattr("ldbench.geometry.pair.FINE_PITCH", 10*FINE_PITCH)    # rows of the geometry, ten times as far apart
        for more in ["page.pdf"], ["page.png", "--json"]:
            said.append(io.StringIO())
            with redirect_stdout(said[-1]):
                assert main(["profile", str(RAIL), str(WHEEL), "--set", f"wheel_profile_right={RIGHT}", "-o",
                             str(folder/more[0]), *more[1:]]) == 0
            patch.setattr(command, "save_page", lambda *page: None)         # one drawing is enough
    return Told(said[0].getvalue().replace(str(folder), ""), json.loads(said[1].getvalue()), found[0], folder)


def test_printed_numbers(told: Told):
    """From the points of the files and the radii that they were made with."""
    y, z = 1e3*profile("awprof").T
    tape = np.interp(70.0, y, z)
    face = (y > y[z.argmin()]) & (y < 60)
    below = np.interp(tape - 10, z[face], y[face])
    tip = np.interp(z.min() + 2, z[face], y[face])
    lines = [Line(pattern, pattern, lambda w, x=x: x, *slack) for pattern, x, *slack in (
        (r"^wheel awprof.yz: (\d+) points", len(y)), (r"^rail arprof.yz: (\d+) points", len(profile("arprof"))),
        (r"height Sh (\S+) mm", tape - z.min(), 1e-3), (r"thickness Sd (\S+) mm", below - y.min(), 1e-3),
        (r"qR (\S+) mm", below - tip, 5e-3), (r"flange angle (\S+) °", 75.0), (r"tread slope (\S+) \(1:(\S+)\)", (1/40, 40)),
        (r"hollow of the tread (\S+) mm", 0.0), (r"crown radius (\S+) mm", 254.0), (r"shoulder radius (\S+) mm", 31.75, 2e-3),
        (r"corner radius (\S+) mm", 14.2875), (r"gauge point at y (\S+) mm", 0.0), (r"inclination (\S+) \(1:(\S+)\)", (1/40, 40)),
        (r"clearance left (\S+), right", 10.18))]
    lines.append(Line(r"equivalent conicity at [234] mm: level (\S+),", "taper of the tread", lambda w, m: 1/40, 0.03, often=True))
    # test_en15302 has these.
    labels = [CRC, r"below \S+ mm", r"top of rail at y .*$", r"right \S+ mm$", r"\bwith roll.*$", r"nonlinearity .*$",
              r"(?:rolling radii coefficient|parameter at) .*$", r"zone of the .*$"]
    assert differing(told.words, lines, None, labels) == []
    equal = replace(told.pair, outlines=replace(told.pair.outlines, clearance=(0.01018, 0.01018)))
    assert equal.lines()[0] == "rigid-axle clearance left 10.180, right 10.180 mm"


def test_numbers_for_other_programs(told: Told):
    """The command prints the library's numbers as JSON, in SI units."""
    assert [found["kind"] for found in told.numbers["profiles"]] == ["wheel", "rail"]
    assert told.numbers["page"] == str(told.folder/"page.png")
    assert told.numbers["pair"]["clearance_left"] == pytest.approx(10.18e-3, abs=1e-6)
    for found, file in zip(told.numbers["profiles"], (WHEEL, RAIL), strict=True):
        measures = {name: x if np.isfinite(x) else None for name, x in Profile(file).measures.items()}
        assert found["path"] == str(file) and {name: found[name] for name in measures} == measures


def test_profiles_and_pair_have_a_page_each(told: Told, tmp_path: Path):
    """Two pages of a PDF; in a picture the second one stands below the first."""
    pages = PdfReader(told.folder/"page.pdf").pages
    assert len(pages) == 2 and "conicity" in pages[1].extract_text()
    save_sheets([Figure((3, 2)), Figure((3, 2))], tmp_path/"page.png")
    with Image.open(tmp_path/"page.png") as picture:
        width, height = picture.size
    assert height/width == pytest.approx(4/3)


def test_measures_of_other_profiles():
    """S1002 and 60E1 as their standards have them."""
    measures, rail = Profile(REPO/"profiles/s1002.yz").measures, Profile(REPO/"profiles/60e1.yz")
    assert [1e3*measures[name] for name in ("Sh", "Sd", "qR")] == pytest.approx([28, 32.5, 10.79], abs=0.005)
    assert measures["flange_angle"] == pytest.approx(np.radians(70), abs=2e-3) and rail.kind == "rail"
    assert [1e3*rail.measures[f"{arc}_radius"] for arc in ("crown", "shoulder", "corner")] == pytest.approx([300, 80, 13], rel=1e-3)
    assert rail.measures["inclination"] == pytest.approx(np.arctan(1/40), rel=1e-2)
    assert rail.measures["gauge_point_y"] == pytest.approx(0, abs=1e-6)


def test_conicity_of_a_cone_and_of_a_cubic():
    """delta_r = 2 c y has the conicity c; delta_r = k y^3 the wavelength 4 sqrt(2/k)/a K(1/sqrt 2)/sqrt 2 sqrt(e r)."""
    y = np.linspace(-0.01, 0.01, 2001)
    amplitude = np.array([1e-3, 3e-3, 7e-3])
    for conicity in equivalent_conicity, linearised_conicity:
        assert conicity(amplitude, y, 2*0.18*y) == pytest.approx(0.18, rel=1e-6)
    k = 2e3
    quarter = gamma(0.25)**2/(4*sqrt(2*pi))           # integral of 1/sqrt(1 - u^4) from 0 to 1
    wave = 4*np.sqrt(2/k)/amplitude*quarter
    assert equivalent_conicity(amplitude, y, k*y**3) == pytest.approx(2*pi**2/wave**2, rel=1e-4)
    assert np.isnan(equivalent_conicity(amplitude, y, -y)).all()


def test_dimension_lines_are_as_long_as_the_measures():
    """Sd begins at the back, Sh at the tip."""
    found = Profile(REPO/"profiles/s1002.yz")
    lines = wheel_dimensions(found)
    assert set(lines) == {"Sh", "Sd", "qR"}
    for measure, (first, last) in lines.items():
        along = np.abs(np.subtract(last, first))
        assert along.max() == pytest.approx(1e3*found.measures[measure], abs=1e-9) and along.min() < 1e-9
    assert lines["Sd"][0][0] == 0 and lines["Sh"][0][1] == pytest.approx(1e3*found.smooth.z.min())


def compare_points(points: np.ndarray, ax: Axes, dots: Line2D) -> None:
    """The points of the file, or how far they are from the curve that is drawn above."""
    assert dots.get_xdata() == pytest.approx(MM*points[:, 0], abs=1e-9)
    if shown(dots).y == "z [mm]":
        assert dots.get_ydata() == pytest.approx(MM*points[:, 1], abs=1e-9)
    else:
        shape, = (one for one in ax.get_figure().axes if one.get_title(loc="left") == shown(dots).of)
        lines = [line for line in shape.lines if shown(line).how.startswith("part ")]
        y, z = np.nanmax([line.get_xdata() for line in lines if len(line.get_xdata())], axis=0), lines[0].get_ydata()
        away = 1e3*gaps(MM*points, np.column_stack([y, z])[np.isfinite(y)])
        assert ax.get_ylabel() == "distance [µm]" and np.median(np.abs(np.abs(away) - np.abs(dots.get_ydata()))) < 0.2


def compare_curve(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """Angle and curvature of the curve through the points, beside those of the polyline of the file."""
    angle = np.unwrap(tangent_angles(points))
    along = np.hypot(*np.gradient(points, axis=0).T)
    words, truth = {"tangent angle [°]": ("tangent angle [°]", np.degrees(angle)),
                    "curvature [1/m]": ("curvature [1/m]", np.gradient(angle)/along)}[shown(line).y]
    assert ax.get_ylabel() == words and shown(line).x == "y [mm]"
    y, x = (np.asarray(data, float) for data in line.get_data())
    near = np.array([np.abs(x[np.argsort(np.abs(y - MM*point))[:9]] - value).min() for point, value in
                     zip(points[5:-5:9, 0], truth[5:-5:9], strict=True)])
    assert np.median(near) < 0.02*np.percentile(np.abs(truth), 90), shown(line)


def compare_part(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """On the points of the file."""
    curve = line.get_xydata()[np.isfinite(line.get_xdata())]
    assert np.abs(gaps(curve/MM, points)).max() < 1e-4, shown(line)


def compare_mark(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """70 mm from the back of the wheel."""
    assert shown(line).y == "tape circle" and set(line.get_xdata()) == {70.0}


def compare_gauge(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """On the side of the rail's head, 14 mm below its top or as deep as the case says."""
    point, = line.get_xydata()
    assert np.abs(gaps(line.get_xydata()/MM, points)).max() < 1e-4
    assert MM*points[:, 1].max() - point[1] == pytest.approx(MM*ldbench.Case().gauge_depth, abs=0.1)


SMOOTHING = 2e-5        # of one wheel [m]


@pytest.mark.parametrize("smoothing", [None, MM*SMOOTHING])
def test_the_page_of_profiles_shows_the_points_of_the_files(smoothing: float | None, told: Told):
    """Points, parts, angle and curvature of wheel and rail, dimension lines and marks."""
    wheel = Profile(WHEEL) if smoothing is None else Profile(WHEEL, smoothing=smoothing)
    with ldbench_style():
        figure = profile_page([wheel, Profile(RAIL)], told.pair, "note")
    points = {"wheel": profile("awprof"), "rail": profile("arprof")}
    curves = {"through the points", *(shown(one).how for _, one in artists(figure) if "smoothed" in shown(one).how)}
    parts = {shown(one).how for _, one in artists(figure) if shown(one).how.startswith("part ")}
    compared = {**dict.fromkeys(curves, compare_curve), **dict.fromkeys(parts, compare_part), "points": compare_points,
                "end of a zone": compare_part, "mark": compare_mark, "gauge point": compare_gauge}
    assert walk(figure, compared, None, points, lambda label, names, _: label in (names.how, names.how.removeprefix("part "))) > 20
    titles = {words: {shown(one).of for one in ax.lines} - {""} for ax in figure.axes if (words := ax.get_title(loc="left"))}
    assert titles == {"wheel": {"wheel"}, "rail": {"rail"}}
    assert len(curves) == (1 if smoothing is None else 2)


@pytest.mark.parametrize("side", [1, -1])
def test_contact_lines_join_points_of_wheel_and_rail(side: int, told: Told):
    """For whole millimetres of displacement, on the curves of this side, at the place that the geometry functions tell."""
    own = told.pair.outlines.left if side > 0 else told.pair.outlines.right
    lines = contact_lines(told.pair, side)
    assert {round(1e3*line.y) for line in lines} >= set(range(-8, 9))
    geometry = told.pair.rolled.geometry
    for y, on_wheel, on_rail in lines:
        assert 1e3*y == pytest.approx(round(1e3*y), abs=1e-9)
        assert np.interp(y, geometry["Y"], side*geometry["y_L" if side > 0 else "y_R"]) == pytest.approx(on_rail[0], abs=1e-9)
        for point, curve in (on_wheel, own.wheel), (on_rail, own.rail):
            assert np.hypot(*(curve - point).T).min() < 2e-4


def test_the_page_of_a_pair_has_the_functions_of_the_displacement(told: Told):
    """The wheels differ, so that left and right are told apart."""
    with ldbench_style():
        figure = pair_page(told.pair, "note", None)
    level, rolled = told.pair.level, told.pair.rolled
    sources = {"level": {**level.geometry, "amplitude": level.amplitude, "conicity": level.conicity},
               "with roll": {**rolled.geometry, "amplitude": rolled.amplitude, "conicity": rolled.conicity,
                             "linearised": rolled.linearised}}
    raised = {"left": "aw", "right": "sw"}, told.pair.outlines.axle
    compared = {"functions": compare_functions, "mark": compare_reach(told.pair.clearance),
                "contact line": compare_contact_line(*raised), "raised outline": compare_raised(*raised)}
    assert walk(figure, compared, rolled.geometry, sources, says) > 100
