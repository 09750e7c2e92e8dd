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
from ldbench import Case, Error, Profile
from ldbench.__main__ import main
from ldbench._core.errors import BadValue, MissingFile, Usage
from ldbench.commands import profile
from ldbench.conicity import equivalent_conicity, linearised_conicity
from ldbench.geometry.pair import pair
from ldbench.plots.dimensions import wheel_dimensions
from ldbench.plots.pair_page import contact_lines, pair_page
from ldbench.plots.style import ldbench_style
from running import REPO, command_error


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


@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_noise_of_the_points_is_told(noise, tmp_path):
    for name in "awprof", "arprof":
        (tmp_path/name).write_text(shapes.rows(shapes.noisy(shapes.shape(name), noise, 5)))
        assert Profile(tmp_path/name).noise == pytest.approx(noise, rel=0.15)


def test_curvature_is_usable_at_the_noise_of_a_measurement(tmp_path):
    """Arcs of the actual rail and wheel at 0.03 mm, where an interpolating spline has hundreds per metre."""
    for name, arcs in ("arprof", {22: (-1/0.03175, 4.0), 40: (-1/0.254, 3.0)}), \
            ("awprof", {47: (-1/0.0381, 4.0), 90: (0.0, 3.0)}):
        (tmp_path/name).write_text(shapes.rows(shapes.noisy(shapes.shape(name), 0.03, 6)))
        found = Profile(tmp_path/name, smoothing=0.03)
        for y, (curvature, bar) in arcs.items():
            y -= 8 if y == 22 else 0
            near = np.abs(1e3*found.smooth.y - y) < 3
            assert np.sqrt(np.mean((found.smooth.curvature[near] - curvature)**2)) < bar
            rough = np.abs(1e3*found.rough.y - y) < 3
            assert np.sqrt(np.mean((found.rough.curvature[rough] - curvature)**2)) > 30*bar


def test_parts_cover_the_profile_in_their_order(tmp_path):
    (tmp_path/"wheel").write_text(shapes.rows(shapes.with_faces(shapes.hollow(shapes.shape("awprof")))*[-1, -1]))
    part = Profile(tmp_path/"wheel").smooth.part
    assert list(dict.fromkeys(part.astype(int))) == [1, 2, 3, 4, 5]
    assert list(dict.fromkeys(Profile(REPO/"profiles/arprof.yz").smooth.part.astype(int))) == [6, 7, 8]


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


def test_modern_pair():
    """Two contact points close together at the centre, one conicity from there; CONTACT's positions (validation)."""
    found = pair(Case.from_namelist("&case /").replace(
        wheel_profile=str(REPO/"profiles/s1002.yz"), rail_profile=str(REPO/"profiles/60e1.yz"), gauge=1.435,
        back_to_back=1.36, rolling_radius=0.46))
    assert found.rolled.conicity_at(3e-3) == pytest.approx(0.177, abs=0.003)
    for g in found.level.geometry, found.rolled.geometry:
        assert g["y_R"] == pytest.approx(-g["y_L"][::-1], abs=1e-12)
    g = found.rolled.geometry
    assert 1e3*np.interp(3e-3, g["Y"], g["y_L"]) == pytest.approx(739.970, abs=0.5)


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


def test_a_profile_that_ends_early_has_fewer_dimension_lines(tmp_path):
    points = shapes.shape("awprof")
    (tmp_path/"short").write_text(shapes.rows(points[points[:, 0] > 20]))
    found = Profile(tmp_path/"short", wheel_back=0.0)
    assert set(wheel_dimensions(found)) == {name for name in ("Sh", "Sd", "qR") if np.isfinite(found.measures[name])}


@pytest.fixture(scope="module")
def worn_right():
    """The actual pair with the simplified wheel on the right."""
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
    tangent = {line.get_label(): line for line in axes["(tan γ left − tan γ right)/2"].get_lines()}["with roll"]
    assert np.nanmax(np.abs(tangent.get_ydata() - (np.tan(g["angle_L"]) - np.tan(g["angle_R"]))/2)) < 1e-12


PAIR = REPO/"profiles/arprof.yz", REPO/"profiles/awprof.yz"       # the rail first


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """What the command prints of a pair with its pages in a PDF, and as JSON with its pages in a picture; in this folder."""
    folder = tmp_path_factory.mktemp("pages")
    words, numbers = io.StringIO(), io.StringIO()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(profile, "pair", cache(pair))         # both commands ask for the same geometry
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


def test_page_of_one_measured_file_says_what_was_mended(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    points = np.repeat(shapes.shape("awprof"), 2, axis=0)
    (tmp_path/"my.whl").write_text(shapes.miniprof_old(points, "wheel"))
    assert main(["profile", "my.whl", "--smoothing", "0.01"]) == 0
    said = "MiniProf, back of the wheel at y = 0", "z turned over", f"{len(points)//2} repeated dropped"
    assert "\n  ".join(said) + "\n" in capsys.readouterr().out
    assert (tmp_path/"outputs/ldbench_profile.pdf").exists()


WHEEL = str(REPO/"profiles/awprof.yz")


@pytest.mark.parametrize(("words", "kind", "fields"), [
    ([WHEEL, WHEEL], Error, {"expected": "a wheel and a rail", "found": f"two wheels: {WHEEL}, {WHEEL}"}),
    ([WHEEL]*3, Usage, {"expected": "a wheel or a rail, or one of each", "found": "3 files"}),
    ([WHEEL, "-o", "page.doc"], Error, {"file": "page.doc", "found": ".doc"}),
    (["nothing.yz"], MissingFile, {"file": "nothing.yz"}),
    ([WHEEL, "--set", "gauge=9"], BadValue, {"group": "track", "variable": "gauge", "found": "9.0"}),
])
def test_wrong_page_is_refused(words, kind, fields, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    error = command_error("profile", *words)
    assert type(error) is kind and {name: getattr(error, name) for name in fields} == fields, error
    assert not list(tmp_path.iterdir())


def test_errors_are_those_of_a_run(tmp_path):
    (tmp_path/"wheel").write_text("1 2\n3 x\n")
    with pytest.raises(Error) as error:
        Profile(tmp_path/"wheel")
    assert (error.value.file, error.value.line) == (str(tmp_path/"wheel"), 2)
    assert error.value.expected.startswith("two numbers")


def test_any_noise_spacing_and_smoothing_give_a_curve(tmp_path):
    """Points dense or sparse, some lost, smoothed too little or too much: about as long as the profile is."""
    chance = np.random.default_rng(4)
    for name in ("awprof", "srprof", "60e1") * 5:
        spacing, noise, smoothing = (chance.choice(x) for x in (
            [0.02, 0.1, 0.25, 1.0], [0.003, 0.01, 0.03, 0.06], [1e-4, 0.005, 0.01, 0.03, 0.1]))
        points = shapes.noisy(shapes.shape(name, spacing), noise, int(chance.integers(1000)))
        points = points[chance.random(len(points)) < chance.choice([0.6, 1.0])]
        (tmp_path/"file").write_text(shapes.rows(points))
        found = Profile(tmp_path/"file", smoothing=smoothing)
        length = np.hypot(*np.diff(shapes.shape(name), axis=0).T).sum()
        if smoothing >= noise:
            assert 1e3*found.smooth.s[-1] == pytest.approx(length, rel=0.03)
        assert (np.isfinite(found.smooth.curvature).all() and found.noise >= 0) or spacing == 1
