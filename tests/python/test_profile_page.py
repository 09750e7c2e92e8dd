"""`python -m ldbench profile`: the page and its numbers."""
import io
import json
from contextlib import redirect_stdout
from functools import cache
from math import gamma, pi, sqrt

import numpy as np
import pytest
from PIL import Image
from pypdf import PdfReader

import shapes
from ldbench import Case, Profile
from ldbench.__main__ import main
from ldbench.commands import profile
from ldbench.conicity import FINE_PITCH, equivalent_conicity, linearised_conicity
from ldbench.geometry.pair import pair
from ldbench.plots.geometry import contact_lines, pair_page
from ldbench.plots.profile_page import wheel_dimensions
from ldbench.plots.style import ldbench_style
from running import REPO


def test_measures_of_a_wheel():
    """S1002 as its standard has it; the tip's radius and the tread's slope of the benchmark's wheel."""
    measures = Profile(REPO/"profiles/s1002.yz").measures
    assert [1e3*measures[name] for name in ("Sh", "Sd", "qR")] == pytest.approx([28, 32.5, 10.79], abs=0.005)
    assert measures["flange_angle"] == pytest.approx(np.radians(70), abs=2e-3)
    assert Profile(REPO/"profiles/awprof.yz").measures["tread_slope"] == pytest.approx(1/40, abs=1e-6)
    worn = shapes.hollow(shapes.shape("awprof"))
    assert np.ptp(worn[:, 1]) > 20


def test_measures_of_a_rail():
    found = Profile(REPO/"profiles/60e1.yz")
    assert found.kind == "rail"
    assert [1e3*found.measures[f"{arc}_radius"] for arc in ("crown", "shoulder", "corner")] == \
        pytest.approx([300, 80, 13], rel=1e-3)
    assert found.measures["inclination"] == pytest.approx(np.arctan(1/40), rel=1e-2)
    assert found.measures["gauge_point_y"] == pytest.approx(0, abs=1e-6)


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


@pytest.mark.parametrize("name", ["s1002", "awprof", "swprof"])
def test_dimension_lines_are_as_long_as_the_measures(name):
    """Each ends at points of the profile, at the tape circle, at the tip or at the back."""
    found = Profile(REPO/f"profiles/{name}.yz")
    lines = wheel_dimensions(found)
    assert set(lines) == {"Sh", "Sd", "qR"}
    curve = 1e3*np.column_stack([found.smooth.y, found.smooth.z])
    for measure, (first, last) in lines.items():
        along = np.abs(np.subtract(last, first))
        assert along.max() == pytest.approx(1e3*found.measures[measure], abs=1e-9) and along.min() < 1e-9
    near = {what: np.hypot(*(curve - point).T).min() for what, point in (
        ("Sd", lines["Sd"][1]), ("qR, outside", [lines["qR"][1][0], lines["Sd"][0][1]]),
        ("qR, inside", [lines["qR"][0][0], 1e3*found.smooth.z.min() + 2]))}
    assert max(near.values()) < 0.06, near
    assert lines["Sd"][0][0] == 0 and lines["Sh"][0][1] == pytest.approx(curve[:, 1].min())


@pytest.fixture(scope="module")
def worn_right():
    """The actual pair with the simplified wheel on the right."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("ldbench.geometry.pair.FINE_PITCH", 5*FINE_PITCH)
        return pair(Case.exercise(1).replace(wheel_profile_right=str(REPO/"profiles/swprof.yz"),
                                             wheel_profile=str(REPO/"profiles/awprof.yz")))


@pytest.mark.parametrize("side", [1, -1])
def test_contact_lines_join_points_of_wheel_and_rail(side, worn_right):
    """For whole millimetres of displacement, on the curves of this side, at the place that the geometry functions tell."""
    own = worn_right.outlines.left if side > 0 else worn_right.outlines.right
    lines = contact_lines(worn_right, side)
    assert {round(1e3*line.y) for line in lines} >= set(range(-8, 9))
    geometry = worn_right.rolled.geometry
    for y, on_wheel, on_rail in lines:
        assert 1e3*y == pytest.approx(round(1e3*y), abs=1e-9)
        assert np.interp(y, geometry["Y"], side*geometry["y_L" if side > 0 else "y_R"]) == pytest.approx(on_rail[0], abs=1e-9)
        for point, curve in (on_wheel, own.wheel), (on_rail, own.rail):
            assert np.hypot(*(curve - point).T).min() < 2e-4


def test_the_page_of_a_pair_has_the_functions_of_the_displacement(worn_right):
    """The wheels differ, so that left and right are told apart."""
    with ldbench_style():
        figure = pair_page(worn_right, "note", None)
    assert len(figure.axes) >= 8
    axes = {ax.get_ylabel(): ax for ax in figure.axes}
    g = worn_right.rolled.geometry
    drawn = {line.get_label(): line for line in axes["Δr = left − right [mm]"].get_lines()}
    assert drawn["with roll"].get_ydata() == pytest.approx(1e3*g["delta_r"])
    angles = {line.get_label(): line for line in axes["contact angle γ [°]"].get_lines()}
    assert np.nanmax(np.abs(angles["left"].get_ydata() - np.degrees(g["angle_L"]))) < 1e-9
    tangent = {line.get_label(): line for line in axes["½(tan γL − tan γR)"].get_lines()}["with roll"]
    assert np.nanmax(np.abs(tangent.get_ydata() - (np.tan(g["angle_L"]) - np.tan(g["angle_R"]))/2)) < 1e-12


PAIR = REPO/"profiles/arprof.yz", REPO/"profiles/awprof.yz"       # the rail first


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """What the command prints of a pair with its pages in a PDF, and as JSON with its pages in a picture; in this folder."""
    folder = tmp_path_factory.mktemp("pages")
    words, numbers = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(profile, "pair", cache(pair))         # both commands ask for the same geometry
        patch.setattr("ldbench.geometry.pair.FINE_PITCH", 5*FINE_PITCH)
        with redirect_stdout(words):
            assert main(["profile", *map(str, PAIR), "-o", str(folder/"page.pdf")]) == 0
        with redirect_stdout(numbers):
            assert main(["profile", *map(str, PAIR), "-o", str(folder/"page.png"), "--json"]) == 0
    return folder, words.getvalue(), json.loads(numbers.getvalue())


def test_profiles_and_pair_have_a_page_each(pages, tmp_path):
    """Two pages of a PDF; in a picture the second one stands below the first."""
    folder, *_ = pages
    for suffix in "pdf", "png":
        assert main(["profile", str(PAIR[1]), "-o", str(tmp_path/f"page.{suffix}")]) == 0
    assert [len(PdfReader(where/"page.pdf").pages) for where in (tmp_path, folder)] == [1, 2]
    (width, height), (same, both) = (Image.open(where/"page.png").size for where in (tmp_path, folder))
    assert (same, both) == (width, 2*height)
    assert "conicity" in PdfReader(folder/"page.pdf").pages[1].extract_text()


def test_numbers_of_a_pair_in_words(pages):
    """The wheel comes first, whatever the order of the files."""
    folder, out, _ = pages
    assert (folder/"page.pdf").read_bytes().startswith(b"%PDF") and (folder/"page.png").read_bytes().startswith(b"\x89PNG")
    for words in "flange height Sh 25.75 mm", "qR ", "crown radius 254.0 mm", "clearance 2 x 10.180 mm", \
            "equivalent conicity at 3 mm: level 0.025, with roll 0.026 (EN 15302)", "zone of the flange":
        assert words in out
    assert out.startswith("wheel awprof.yz")


def test_numbers_of_a_pair_for_other_programs(pages):
    """The command prints the library's numbers as JSON, in SI units."""
    folder, _, told = pages
    rail, wheel = PAIR
    assert [found["kind"] for found in told["profiles"]] == ["wheel", "rail"]
    assert told["page"] == str(folder/"page.png") and told["pair"]["clearance_left"] == pytest.approx(10.18e-3, abs=1e-6)
    for found, file in zip(told["profiles"], (wheel, rail), strict=True):
        measures = {name: x if np.isfinite(x) else None for name, x in Profile(file).measures.items()}
        assert found["path"] == str(file) and {name: found[name] for name in measures} == measures
