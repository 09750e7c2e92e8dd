"""The wheelset that is kept level against the tables of EN 15302:2021, and contact parameters against closed forms."""

import numpy as np
import pytest

import en15302
from ldbench import Case, Error
from ldbench.conicity import FINE_PITCH, level_rows, rolled_rows
from ldbench.geometry.en15302 import AMPLITUDES, TABLES, window
from ldbench.geometry.pair import pair, rigid_geometry
from round_profiles import Shape

PITCH = 5*FINE_PITCH
CONE, HOLLOW = Shape(np.arctan(1/20), np.inf, 0.08), Shape(np.arctan(1/40), 0.36, 0.3)


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


def test_windows_are_the_narrower_of_both_that_the_standard_has():
    """Half of the conicity, and 0.05 at most."""
    values = []
    for name in TABLES:
        w = window(name)
        values += w.value.tolist()
        assert w.high - w.value == pytest.approx(np.where(w.value < 0.1, 0.5*w.value, 0.05))
        assert w.value - w.low == pytest.approx(w.high - w.value)
    assert min(values) < 0.1 < max(values)


@pytest.mark.usefixtures("coarse")
def test_conicities_of_wheels_of_two_diameters(tmp_path):
    """The window of the standard at 3 mm holds the level wheelset; its roll makes the conicity larger."""
    found = pair(en15302.case("A-918", en15302.write(tmp_path)), en15302.radii("A-918"))
    w, at = window("A-918"), int(np.argmin(np.abs(AMPLITUDES - 3e-3)))
    level, rolled = found.level.conicity_at(3e-3), found.rolled.conicity_at(3e-3)
    assert w.low[at] <= level <= w.high[at] and rolled == pytest.approx(0.278, abs=5e-4) and rolled > level + 0.01


def test_radii_need_a_tape_circle(monkeypatch):
    monkeypatch.setattr("ldbench.geometry.pair.TAPE_CIRCLE", 0.2)
    with pytest.raises(Error, match=r"tape circle, 200 mm from its back, found one from 0\.0 to 135\.0 mm"):
        pair(Case.exercise(1, "aw"), (0.457, 0.456))
