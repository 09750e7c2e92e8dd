"""The wheelset that is kept level against the tables of EN 15302:2021, and contact parameters against closed forms."""
from pathlib import Path

import numpy as np
import pytest

import en15302
import en15302_tables
import ldbench
from ldbench import Case, Error
from ldbench.__main__ import main
from ldbench._core.errors import Usage
from ldbench.conicity import FINE_PITCH, equivalent_conicity, level_rows, rolled_rows
from ldbench.geometry.contact_geometry import ContactGeometry
from ldbench.geometry.en15302 import AMPLITUDES, MISPRINTS, TABLES, window
from ldbench.geometry.pair import pair, rigid_geometry
from round_profiles import Shape
from running import REPO, command_error

SOME = "A", "B", "I-918", "A-B"     # `make validate` takes all of them
PITCH = 5*FINE_PITCH
CONE, HOLLOW = Shape(np.arctan(1/20), np.inf, 0.08), Shape(np.arctan(1/40), 0.36, 0.3)


@pytest.fixture(scope="module")
def paths(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return en15302.write(tmp_path_factory.mktemp("en15302"))


# ---- the reference cases -------------------------------------------------------------
@pytest.mark.parametrize("combination", SOME)
def test_radius_difference_of_the_level_wheelset(combination, paths):
    y, off = en15302.deviations(combination, paths)
    at_step = [(combination, at) in en15302_tables.AT_A_STEP for at in y.tolist()]
    assert off[np.logical_not(at_step)].max() < 2
    assert np.median(off) < 0.3


def test_tables_are_met_without_the_step_of_wheel_a(paths):
    closed = paths | {"A": paths["A closed"]}
    for combination, y in en15302_tables.AT_A_STEP:
        _, (off,) = en15302.deviations(combination, closed, y)
        assert off < 2


@pytest.mark.parametrize("combination", SOME)
def test_conicity_of_the_level_wheelset_is_in_its_window(combination, paths):
    y = np.arange(-250, 251)*2*FINE_PITCH
    rows = en15302.level(combination, paths, 1e3*y)
    found, w = equivalent_conicity(AMPLITUDES, rows[0], rows[7]), window(combination)
    assert ((w.low <= found) & (found <= w.high)).all()


def test_misprints_break_the_smooth_run_of_their_tables():
    for (combination, y), meant in en15302_tables.MISPRINTS.items():
        at, values = en15302_tables.table(combination)
        k = int(np.argmin(np.abs(at - y)))
        smooth = en15302_tables.smooth(values, k)
        assert abs(meant - smooth) < 2e-3 < 40e-3 < abs(values[k] - smooth)
    for (combination, amplitude), meant in MISPRINTS.items():
        values = np.array(TABLES[combination][0].split(), float)/1e3
        k = int(np.argmin(np.abs(AMPLITUDES - 1e-3*amplitude)))
        smooth = en15302_tables.smooth(values, k)
        assert abs(meant - smooth) < 1e-3 < 30e-3 < abs(values[k] - smooth)


# ---- closed forms --------------------------------------------------------------------
@pytest.mark.parametrize("shape", [CONE, HOLLOW])
def test_level_wheelset_has_its_closed_form(shape, tmp_path):
    y = np.linspace(-2e-3, 2e-3, 21)
    rows = level_rows(rigid_geometry(shape.case(tmp_path)), y)
    assert rows[7] == pytest.approx(shape.level_delta_r(y), rel=1e-4, abs=1e-9)


@pytest.fixture
def coarse(monkeypatch):
    """Geometry functions of a pair in rows five times as far apart, which serve where no radius difference jumps."""
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", PITCH)


@pytest.mark.usefixtures("coarse")
def test_parameters_of_a_cone(tmp_path):
    """Level: the contact angles stay, the wheelset would roll by the cone's slope. With roll: the angles turn with it."""
    found = pair(CONE.case(tmp_path))
    slope, e = np.tan(CONE.taper), found.level.distance/2
    assert found.level.parameter("angle") == pytest.approx(0, abs=1e-6)
    assert found.level.parameter("roll") == pytest.approx(slope, rel=1e-4)
    assert found.rolled.parameter("roll") == pytest.approx(found.rolled.conicity_at(3e-3)*e/CONE.head, rel=1e-4)
    assert found.rolled.parameter("angle") == pytest.approx(found.rolled.parameter("roll")*(1 + slope**2), rel=1e-4)
    for geometry in found.level, found.rolled:
        assert geometry.nonlinearity == pytest.approx(0, abs=1e-3)
        assert geometry.rolling_radii_coefficient(600) == pytest.approx(2*geometry.rolling_radii_coefficient(300))
        assert geometry.rolling_radii_coefficient(300) == pytest.approx(300*geometry.steering/(geometry.distance*0.457), rel=1e-9)
    last = PITCH*np.floor(found.clearance[0]/PITCH)
    assert found.rolled.steering == pytest.approx(CONE.delta_r(np.array([last]))[0], rel=1e-6)


@pytest.mark.usefixtures("coarse")
def test_contact_angle_parameter_of_a_hollow_wheel(tmp_path):
    found = pair(HOLLOW.case(tmp_path)).level
    growth = 1/(HOLLOW.R_w - HOLLOW.R_r)/np.cos(HOLLOW.taper)**3
    assert found.parameter("angle", 1e-3) == pytest.approx(found.distance/2*growth, rel=1e-3)


def test_wheels_of_other_radii(tmp_path):
    """Two wheels that are smaller by as much are a smaller rolling radius; one that is smaller adds to the difference."""
    case, y = CONE.case(tmp_path), np.linspace(-4e-3, 4e-3, 9)
    handle, d = rigid_geometry(case), 1e-3
    smaller = rigid_geometry(case.replace(rolling_radius=case.rolling_radius - d))
    assert rolled_rows(handle, y, (d, d)) == pytest.approx(rolled_rows(smaller, y), abs=1e-9)
    assert level_rows(handle, y, (0.0, d))[7] == pytest.approx(level_rows(handle, y)[7] + d, abs=1e-12)
    # With roll the smaller wheel stands lower, and both contacts move on the heads.
    one, none = rolled_rows(handle, y, (0.0, d)), rolled_rows(handle, y)
    assert one[1] - none[1] == pytest.approx(d/(none[8] - none[10]), rel=0.05)


def test_no_difference_of_radii_does_not_steer():
    y = np.linspace(-0.01, 0.01, 201)
    assert equivalent_conicity(np.array([1e-3, 5e-3]), y, 0*y) == pytest.approx(0, abs=0)


def test_a_gap_ends_the_functions():
    rows = np.tile(np.arange(-50, 51)*1e-4, (12, 1))
    rows[:, 80] = np.nan
    found = ContactGeometry.of("level", ["Y"], rows, (0.0, 0.0))
    assert found.geometry["Y"][-1] == pytest.approx(29e-4) and found.amplitude[-1] == pytest.approx(29e-4)
    assert np.isnan(found.conicity_at(4e-3))


# ---- the command ---------------------------------------------------------------------
@pytest.mark.usefixtures("coarse")
def test_reference_on_the_page(paths, tmp_path, capsys):
    made, target = en15302.case("A-918", paths), tmp_path/"page.png"
    settings = [word for name in ("gauge", "back_to_back", "rolling_radius") for word in ("--set", f"{name}={getattr(made, name)}")]
    assert main(["profile", paths["A"], paths["rail"], *settings, "--radii", "0.46,0.459", "--en15302", "A-918",
                 "-o", str(target)]) == 0
    assert target.stat().st_size and "equivalent conicity at 3 mm: level 0.261, with roll 0.278" in capsys.readouterr().out


WHEEL, RAIL = str(REPO/"profiles/awprof.yz"), str(REPO/"profiles/arprof.yz")


@pytest.mark.parametrize(("words", "kind", "words_of_error"), [
    ([WHEEL, "--en15302", "A"], Usage, "expected a wheel and a rail for --en15302, found one profile"),
    ([WHEEL, "--radii", "0.46,0.459"], Usage, "expected a wheel and a rail for --radii, found one profile"),
    ([WHEEL, RAIL, "--radii", "0.46,459"], Error, "rolling_radius"),
])
def test_wrong_reference_is_refused(words, kind, words_of_error, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    error = command_error("profile", *words)
    assert type(error) is kind and words_of_error in str(error), error
    assert not list(tmp_path.iterdir())


def test_radii_need_a_tape_circle(monkeypatch):
    monkeypatch.setattr("ldbench.geometry.pair.TAPE_CIRCLE", 0.2)
    with pytest.raises(Error, match=r"tape circle, 200 mm from its back, found one from 0\.0 to 135\.0 mm"):
        pair(Case.exercise(1, "aw"), (0.457, 0.456))


@pytest.mark.parametrize("wheel", "AHI")
def test_clearance_does_not_depend_on_the_points_of_a_file(wheel: str, paths: dict[str, str], tmp_path: Path):
    """The clearance of 1,000 points with five decimals of a millimetre is that of the formulas. No flange touches in exercise 1, in
    which the wheelset swings within the clearance."""
    lines = Path(paths[wheel]).read_text().splitlines()
    numbers = [line for line in lines if line.lstrip()[:1] in "-0123456789"]
    points = np.array([line.split()[:2] for line in numbers], float)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    few = np.column_stack([np.interp(np.linspace(0, arc[-1], 1000), arc, points[:, k]) for k in range(2)])
    file = tmp_path/"few.yz"
    file.write_text("\n".join([line for line in lines if line not in numbers] + [f"{y:.5f} {z:.5f}" for y, z in few]) + "\n")
    runs = [ldbench.run(en15302.case(wheel, {**paths, wheel: str(path)}).replace(
        model="hertz", n_lateral=80, n_roll=17, n_depth=15, vY=0.1, t_end=1.0)) for path in (paths[wheel], file)]
    clearances = [run.table.clearance for run in runs]
    assert clearances[1] == pytest.approx(clearances[0], abs=1e-5) and clearances[0] > 6e-3
    for run in runs:
        assert not run.count("left flange contact") and not run.data[["N_LF", "N_RF"]].to_numpy().any()
        assert run.data.Y.abs().max() < run.table.clearance
