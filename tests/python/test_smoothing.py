"""Smoothing of measured points: how near the curve is to the exact shape, by noise, spacing and feature."""
import itertools
from pathlib import Path

import numpy as np
import pytest

import ldbench
import make_profiles as arcs
import shapes
from ldbench.conicity import FINE_PITCH
from ldbench.geometry.pair import pair
from ldbench.profiles.smoothing import chord_lengths, smooth


def normal_noise(points: np.ndarray, noise: float, seed: int) -> np.ndarray:
    """Points with noise normal to their curve [mm]."""
    return points + np.random.default_rng(seed).normal(0, noise, (len(points), 1))*shapes.normals(points)


def sampled(corners: np.ndarray, spacing: float) -> np.ndarray:
    """Points along a polygon [mm]."""
    s = chord_lengths(corners)
    at = np.arange(0, s[-1], spacing)
    return np.column_stack([np.interp(at, s, column) for column in corners.T])


def distances(points: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Distances of points from a polygon with short sides [mm]."""
    near = np.array([np.argmin(np.sum((exact - p)**2, 1)) for p in points]).clip(1, len(exact) - 2)
    along = exact[near + 1] - exact[near - 1]
    off = points - exact[near]
    return np.abs(along[:, 0]*off[:, 1] - along[:, 1]*off[:, 0])/np.hypot(*along.T)


# A rail's corner of 2 mm.
CORNER = arcs.sample(arcs.chain((-2.0, -30.0), arcs.line(np.pi/2, 30.0), arcs.arc(2.0, np.pi/2, np.radians(2)),
                                arcs.arc(300.0, np.radians(2), np.radians(-10))), 0.02)
WHEEL = sampled(shapes.shape("awprof", 0.05), 0.01)
FACET = np.column_stack([WHEEL[:, 0], WHEEL[:, 1] + np.interp(WHEEL[:, 0], [90, 100, 110], [0, 0.1, 0])])   # 0.6 degrees a side
FLAT = np.column_stack([WHEEL[:, 0], np.maximum(WHEEL[:, 1], -25.5)])                                       # of the tip


@pytest.mark.parametrize(("name", "spacing", "noise"), [
    pytest.param(name, spacing, noise, marks=() if (spacing == 0.5 and noise in (0.003, 0.03)) or (name, noise) == ("60e1", 0.03)
                 else pytest.mark.slow)
    for name, spacing, noise in itertools.product(("awprof", "arprof", "swprof", "srprof", "60e1"), (0.1, 0.25, 0.5),
                                                  (0.001, 0.003, 0.01, 0.03))])
def test_noise_is_found_and_the_shape_is_kept(name: str, spacing: float, noise: float):
    """On shapes of arcs and lines the curve is three times nearer to the shape than the points are, and nowhere farther than
    three times their noise; where nothing is lost no place is named."""
    exact = sampled(shapes.shape(name, 0.05), 0.01)
    points = normal_noise(sampled(exact, spacing), noise, 3)
    found = smooth(points)
    assert found.noise == pytest.approx(noise, rel=0.2)
    assert found.distance == pytest.approx(found.noise, rel=0.15)
    off = distances(found.points, exact)
    assert off.max() < 3*noise + 1e-3 and np.sqrt(np.mean(off**2)) < noise*(0.5 if spacing < 0.4 else 0.7) + 3e-4
    assert len(found.far) == 0


@pytest.mark.parametrize("noise", [0.03, *(pytest.param(noise, marks=pytest.mark.slow) for noise in (0.003, 0.01))])
@pytest.mark.parametrize("shape", [CORNER, FACET, FLAT], ids=["corner of 2 mm", "facet", "flat"])
def test_features_are_kept_to_three_times_the_noise(shape: np.ndarray, noise: float):
    """To 2 um more: the flat has kinks of 12 and 17 degrees, which splines round off."""
    for spacing in 0.2, 0.25:
        exact = sampled(shape, 0.01)
        found = smooth(normal_noise(sampled(shape, spacing), noise, 5))
        assert distances(found.points, exact).max() < 3*noise + 2e-3
        assert found.noise == pytest.approx(noise, rel=0.2)


def test_a_written_profile_is_read_as_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Also one whose back is not in the file, which could not be placed again; by the core, too, which reads no other."""
    points = normal_noise(sampled(WHEEL, 0.25), 0.003, 4)
    wheel = ldbench.Profile(points[points[:, 0] > 8], wheel_back=0.0)
    wheel.write(tmp_path/"wheel.yz")
    again = ldbench.Profile(tmp_path/"wheel.yz")
    assert again.as_it_is and again.kind == "wheel" and again.data == wheel.data and again.checksum == wheel.checksum
    assert again.curve == pytest.approx(wheel.curve, abs=1e-9)
    case = ldbench.Case(wheel_profile=again)
    assert case.wheel_profile == str(tmp_path/"wheel.yz")
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", 5*FINE_PITCH)
    monkeypatch.chdir(tmp_path)             # where the file goes that a case names for a profile of points
    assert pair(case).clearance == pair(ldbench.Case(wheel_profile=wheel)).clearance
    (tmp_path/"points.txt").write_text(shapes.rows(points[points[:, 0] > 8]))
    with pytest.raises(ldbench.Error, match="give wheel_back=, the y of the wheel's back"):
        ldbench.Profile(tmp_path/"points.txt")
