"""The laws that the contact is built of: Hertz, curves through points, tensor splines."""
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import round_profiles
from ldbench._core import flat
from probes import E_STAR, ROLLING_RADIUS, probe, text

CROWN = 0.254                         # radius of the actual rail's head [m]


def hertz(A: float, B: float) -> np.ndarray:
    """Ratio of the semi-axes, C_H, strip modulus."""
    return probe("hertz_law", stdin=text([A, B]))[0]


def test_crown_under_wheel():
    """90 kN on a 254 mm crown under a 457 mm cylinder: the published values to their last digit."""
    ratio, c_h, _ = hertz(0.5/ROLLING_RADIUS, 0.5/CROWN)
    assert c_h == pytest.approx(8.9306e10, abs=0.5e6)
    assert ratio == pytest.approx(4.8016/7.0987, abs=1e-5)
    assert (90e3/c_h)**(2/3) == pytest.approx(0.10052e-3, abs=0.5e-8)
    a, b, p0, _ = round_profiles.hertz(0.5/ROLLING_RADIUS, 0.5/CROWN, (90e3/c_h)**(2/3), E_STAR)
    assert (a, b, p0) == pytest.approx((7.0987e-3, 4.8016e-3, 1260.7e6), rel=4e-5)


@pytest.mark.parametrize("ratio", [1.0, 1.001, 3.0, 40.0, 1e4, 1e6, 1e8])
def test_hertz_equations(ratio: float):
    """Johnson's equations (4.25-4.32) by SciPy's elliptic integrals, from a sphere, whose C_H = 4/3 E* sqrt(R) is known, to nearly
    a line contact; nothing changes when the axes are exchanged."""
    A = 0.7
    if ratio == 1:
        exact = 1.0, 4/3*E_STAR*np.sqrt(0.5/A)
    else:
        a, b, _, force = round_profiles.hertz(A, ratio*A, 1.0, E_STAR)
        exact = b/a, force
    found = hertz(A, ratio*A)
    assert found[:2] == pytest.approx(exact, rel=1e-9)
    assert hertz(ratio*A, A)[:2] == pytest.approx(found[:2], rel=1e-13)


@pytest.mark.parametrize("ratio", [0.02, 1.0, 7.0])
def test_strip_integral(ratio: float):
    """Strips of the strip modulus under a parabola of depth carry C_H delta^1.5 and store 2/5 C_H delta^2.5."""
    A, delta = 1.1, 1.3e-4
    _, c_h, modulus = hertz(A, ratio*A)
    node, weight = np.polynomial.legendre.leggauss(8)      # exact for polynomials up to degree 15
    half = np.sqrt(delta/(ratio*A))
    depth = delta*(1 - node**2)
    assert half*np.sum(weight*modulus*depth) == pytest.approx(c_h*delta**1.5, rel=1e-13)
    assert half*np.sum(weight*modulus*depth**2/2) == pytest.approx(0.4*c_h*delta**2.5, rel=1e-13)


def test_linear_systems():
    """Solutions are numpy's, also where pivots are zero or small; a system whose rows depend on each other has none."""
    random = np.random.default_rng(7)
    systems = [random.normal(size=(3, 3)) for _ in range(20)]
    systems += [random.permutation(np.eye(3)) + 1e-13*one for one in systems[:5]]
    singular = [one - np.outer(one[:, 0], [0, 0, 1]) - np.outer(one[:, 2] - one[:, 1], [0, 0, 1]) for one in systems[:5]]
    right = random.normal(size=3)
    found = probe("linear_solution", stdin="".join(f"3\n{text(one)}{text(right)}" for one in (*systems, *singular)))
    assert (found[:, 0] == [1]*len(systems) + [0]*len(singular)).all()
    for one, x in zip(systems, found[:, 1:], strict=False):
        assert x == pytest.approx(np.linalg.solve(one, right), rel=1e-9)


def test_curve_through_points():
    """Position, tangent angle and curvature of SciPy's natural spline over the length of the chords, straight beyond its ends;
    where points repeat there is no curve."""
    points = np.cumsum(np.random.default_rng(2).uniform(0.1e-3, 0.4e-3, (200, 2)), axis=0)
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    exact = CubicSpline(s, points, bc_type="natural")
    at = np.concatenate([s, np.random.default_rng(1).uniform(-0.02, s[-1] + 0.02, 300)])
    on = np.clip(at, 0, s[-1])
    (dy, dz), (ddy, ddz) = exact(on, 1).T, exact(on, 2).T*(at == on)
    length, found = flat.curve_frames(1e3*points.T, at)
    assert length == pytest.approx(s[-1], rel=1e-14)
    assert found[:2].T == pytest.approx(exact(on) + (at - on)[:, None]*exact(on, 1), abs=1e-15)
    assert found[2] == pytest.approx(np.arctan2(dz, dy), abs=1e-12)
    bend = (dy*ddz - dz*ddy)/np.hypot(dy, dz)**3
    assert found[3] == pytest.approx(bend, abs=1e-10*np.abs(bend).max())
    none = flat.curve_frames(1e3*points[[0, 0, 0, 0]].T, s)
    assert np.isnan(none[0]) and np.isnan(none[1]).all()


def noise_of(points: np.ndarray) -> float:
    return flat.point_noise(*points.T)


@pytest.mark.parametrize("noise", [1e-9, 1e-7, 1e-6, 2e-5])
def test_noise_of_points(noise: float):
    """Points on two arcs, with a corner between them and one at every hundredth point, off the arcs by the noise."""
    t = np.arange(-0.4, 0.4, 0.25e-3/0.1)
    arc = 0.1*np.column_stack([np.sin(t), np.cos(t)])
    points = np.concatenate([arc, arc[-1] - arc[0] + arc[1:]])
    points[::100, 1] += 5e-5
    assert noise_of(points) < 2e-11
    off = noise*np.random.default_rng(3).normal(size=(len(points), 1))*np.concatenate([arc, arc])[:len(points)]/0.1
    assert noise_of(points + off) == pytest.approx(noise, rel=0.2)


def test_noise_of_points_far_apart_is_not_known():
    x = np.arange(0, 100, 1.01)*1e-3
    points = np.column_stack([x, np.random.default_rng(1).normal(0, 1e-5, len(x))])
    near = points*[0.9, 1]
    assert [noise_of(few) for few in (points, points[:5], near[:13], points[[0]*20])] == [0]*4
    assert noise_of(near) == pytest.approx(1e-5, rel=0.2) and noise_of(near[:14]) > 0


AXES = ((-1.0, 2.0, 0.3, 0.25), (0.0, 1.5, 0.0, 0.0), (-0.5, 0.5, 0.0, 0.1))    # first, last, centre, scale
POINTS = 12, 17, 14
SPACE = "", "x", "y", "z", "xx", "xy", "xz", "yy", "yz", "zz"      # derivatives in the order of spline_values
PLANE = "", "x", "y", "xx", "xy", "yy"


def axis_points(n: int, first: float, last: float, centre: float, scale: float) -> np.ndarray:
    """Evenly spaced in asinh((x - centre)/scale); in x for scale 0."""
    if scale == 0:
        return np.linspace(first, last, n)
    return centre + scale*np.sinh(np.linspace(np.arcsinh((first - centre)/scale), np.arcsinh((last - centre)/scale), n))


AXIS_POINTS = [axis_points(n, *axis) for n, axis in zip(POINTS, AXES, strict=True)]


def splines(f: np.ndarray, points: np.ndarray) -> np.ndarray:
    """The spline of values at AXIS_POINTS and its derivatives, see spline_values."""
    return probe("spline_values", stdin="".join(f"{len(axis)}\n{text(axis[None])}" for axis in AXIS_POINTS)
                 + text(f.ravel(order="F")[:, None]) + text(points))


@pytest.mark.parametrize(("factors", "ends"), [
    (([0, -2, 0, 1], [1, 0, 1, -1], [0, 1, 0, 1]), 2), (([1, 2, -1], [3, -1, 1], [1, 1, 2]), 0)], ids=["cubic", "parabola"])
def test_a_spline_is_the_given_polynomial(factors: tuple[list[float], ...], ends: int):
    """With all its derivatives in space and in a plane, at random points and on both sides of every knot: any cubic but beside the
    ends of an axis, and any parabola everywhere."""
    random = np.random.default_rng(3)
    points = random.uniform(*np.transpose([(axis[ends], axis[-1 - ends]) for axis in AXIS_POINTS]), (300, 3))
    for i, axis in enumerate(AXIS_POINTS):
        knots = axis[1 + ends:len(axis) - 1 - ends]
        points[100*i:100*i + 2*len(knots), i] = np.concatenate([knots - 1e-12, knots + 1e-12])
    polynomials = [np.polynomial.Polynomial(factor) for factor in factors]
    at = [polynomial(axis) for polynomial, axis in zip(polynomials, AXIS_POINTS, strict=True)]

    def exact(derivatives: tuple[str, ...], last: np.ndarray | float) -> np.ndarray:
        x, y = (lambda word, i=i, name=name: polynomials[i].deriv(word.count(name))(points[:, i]) for i, name in enumerate("xy"))
        z = [polynomials[2].deriv(word.count("z"))(last) for word in derivatives]
        return np.column_stack([x(word)*y(word)*one for word, one in zip(derivatives, z, strict=True)])

    found = splines(np.einsum("i,j,k->ijk", *at), points)
    space, plane = exact(SPACE, points[:, 2]), exact(PLANE, AXIS_POINTS[2][0])
    for columns, values in ((slice(0, 10), space), (slice(10, 16), plane), (slice(16, 17), plane[:, :1]),
                            (slice(17, 21), space[:, :4]), (slice(21, 24), plane[:, :3])):
        assert (np.abs(found[:, columns] - values) <= 1e-10*np.abs(values).max(axis=0)).all()


def test_a_spline_changes_near_a_changed_value_alone():
    values = np.random.default_rng(4).normal(size=POINTS)
    points = np.random.default_rng(5).uniform(*np.array([axis[:2] for axis in AXES]).T, (200, 3))
    changed = values.copy()
    changed[5, 8, 6] += 1
    far = np.abs(np.searchsorted(AXIS_POINTS[0], points[:, 0]) - 5.5) > 3
    moved = np.abs(splines(changed, points) - splines(values, points))[:, 0] > 0
    assert moved.any() and not moved[far].any() and far.any()
