"""The laws that the contact is built of: Hertz, curves through points, tensor splines."""
import numpy as np
import pytest

from ldbench._core import flat
from probes import ROLLING_RADIUS, probe, text

E_STAR = 2.1e11/(2*(1 - 0.28**2))     # [Pa]
CROWN = 0.254                         # radius of the actual rail's head [m]


def hertz(A: float, B: float, N: float) -> np.ndarray:
    """Approach, semi-axes along A and B, largest pressure, C_H, strip modulus."""
    return probe("hertz_law", stdin=text([A, B, N]))[0]


def test_crown_under_wheel():
    """90 kN on a 254 mm crown under a 457 mm cylinder: the published values to their last digit."""
    approach, a, b, p0, c_h, _ = hertz(0.5/ROLLING_RADIUS, 0.5/CROWN, 90e3)
    assert approach == pytest.approx(0.10052e-3, abs=0.5e-8)
    assert a == pytest.approx(7.0987e-3, abs=0.5e-7)
    assert b == pytest.approx(4.8016e-3, abs=0.5e-7)
    assert p0 == pytest.approx(1260.7e6, abs=0.5e5)
    assert c_h == pytest.approx(8.9306e10, abs=0.5e6)


def test_sphere():
    """Equal curvatures 1/2R: C_H = 4/3 E* sqrt(R), a circle of radius sqrt(R delta)."""
    R, N = 0.3, 5e4
    approach, a, b, p0, c_h, _ = hertz(0.5/R, 0.5/R, N)
    assert c_h == pytest.approx(4/3*E_STAR*np.sqrt(R), rel=1e-13)
    assert (a, b) == pytest.approx((np.sqrt(R*approach),)*2, rel=1e-13)
    assert p0 == pytest.approx(1.5*N/(np.pi*a*b), rel=1e-13)


@pytest.mark.parametrize("ratio", [1.001, 3.0, 40.0, 1e4])
def test_hertz_equations(ratio: float):
    """Johnson's equations (4.25-4.32) hold, their elliptic integrals found by quadrature."""
    A, N = 0.7, 2e4
    approach, a, b, p0, c_h, _ = hertz(A, ratio*A, N)
    # The trapezoidal rule converges exponentially for a periodic function.
    t = np.arange(0, np.pi, np.pi/4000)
    root = np.sqrt(1 - (1 - (b/a)**2)*np.sin(t)**2)
    K, E = np.pi/2*np.mean(1/root), np.pi/2*np.mean(root)
    e2 = 1 - (b/a)**2
    assert N == pytest.approx(2/3*np.pi*a*b*p0, rel=1e-12)
    assert A == pytest.approx(p0*b/(E_STAR*e2*a**2)*(K - E), rel=1e-9)
    assert ratio*A == pytest.approx(p0*b/(E_STAR*e2*a**2)*((a/b)**2*E - K), rel=1e-9)
    assert approach == pytest.approx(p0*b/E_STAR*K, rel=1e-11)
    assert N == pytest.approx(c_h*approach**1.5, rel=1e-12)


@pytest.mark.parametrize("ratio", [1e6, 1e8])
def test_extreme_axis_ratio(ratio: float):
    """Towards a line contact b/a solves (b/a)^2 (ln(4a/b) - 1) = A/B and C_H has the limit that follows."""
    A = 1e-3
    _, a, b, _, c_h, _ = hertz(A, ratio*A, 1e4)
    k = 1/np.sqrt(ratio)
    for _ in range(60):
        k = 1/np.sqrt(ratio*(np.log(4/k) - 1))
    K = np.log(4/k)
    # Neglected terms are of order k^2 ln k.
    assert b/a == pytest.approx(k, rel=10*k**2*K + 1e-12)
    assert c_h == pytest.approx(2*np.pi/3*E_STAR*np.sqrt((K - 1)/(A*K**3)), rel=10*k**2*K + 1e-12)
    assert hertz(ratio*A, A, 1e4)[4] == pytest.approx(c_h, rel=1e-14)


@pytest.mark.parametrize("ratio", [0.02, 1.0, 7.0])
def test_strip_integral(ratio: float):
    """Strips of the strip modulus under a parabola of depth carry C_H delta^1.5 and store 2/5 C_H delta^2.5."""
    A, delta = 1.1, 1.3e-4
    *_, c_h, modulus = hertz(A, ratio*A, 1.0)
    node, weight = np.polynomial.legendre.leggauss(8)      # exact for polynomials up to degree 15
    half = np.sqrt(delta/(ratio*A))
    depth = delta*(1 - node**2)
    assert half*np.sum(weight*modulus*depth) == pytest.approx(c_h*delta**1.5, rel=1e-13)
    assert half*np.sum(weight*modulus*depth**2/2) == pytest.approx(0.4*c_h*delta**2.5, rel=1e-13)


def curve(points: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """y, z, tangent angle and curvature at stations; all in metres."""
    return flat.curve_frames(1e3*points.T, stations)[1].T


def chord_stations(points: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def test_circle():
    """Through points of a circle, 0.25 mm apart: on it, tangent to it, with its curvature -1/R."""
    R, step = 0.05, 0.25e-3
    t = np.arange(-0.5, 0.5, step/R)
    points = R*np.column_stack([np.sin(t), np.cos(t)])
    s = chord_stations(points)
    middle = (s[25:-26] + s[26:-25])/2        # between the points, away from the free ends
    y, z, angle, curvature = curve(points, middle).T
    # An interpolating cubic errs by f'''' h^4/384 in position, h^2/24 in curvature, relative to R.
    assert np.hypot(y, z) == pytest.approx(R, rel=3*(step/R)**4/384)
    assert angle == pytest.approx(-np.arctan2(y, z), abs=(step/R)**3)
    assert curvature == pytest.approx(-1/R, rel=(step/R)**2/10)


def test_line():
    """Through points of a line, unevenly spaced: that line, also beyond its ends, and no curvature."""
    s = np.sort(np.random.default_rng(1).uniform(0, 0.1, 40))
    s = np.concatenate([[0], s, [0.1]])
    direction = np.array([np.cos(0.3), np.sin(0.3)])
    stations = np.linspace(-0.02, 0.12, 57)
    y, z, angle, curvature = curve(np.outer(s, direction), stations).T
    assert np.column_stack([y, z]) == pytest.approx(np.outer(stations, direction), abs=1e-15)
    assert angle == pytest.approx(0.3, abs=1e-11)
    assert curvature == pytest.approx(0, abs=1e-7)


def test_the_curve_goes_through_its_points():
    """The length is that of the chords; where points repeat there is no curve."""
    points = np.cumsum(np.random.default_rng(2).uniform(0.1e-3, 0.4e-3, (200, 2)), axis=0)
    s = chord_stations(points)
    assert curve(points, s)[:, :2] == pytest.approx(points, abs=1e-16)
    assert flat.curve_frames(1e3*points.T, s)[0] == pytest.approx(s[-1], rel=1e-14)
    assert np.isnan(curve(points[[0, 0, 0, 0]], s)).all() and np.isnan(flat.curve_frames(1e3*points[[0, 0, 0, 0]].T, s)[0])


def noise_of(points: np.ndarray) -> float:
    return flat.point_noise(*points.T)


@pytest.mark.parametrize("noise", [1e-9, 1e-7, 1e-6, 2e-5])
def test_noise_of_points(noise: float):
    """Points on two arcs, with a corner between them and one at every hundredth point, off the arcs by the noise."""
    t = np.arange(-0.4, 0.4, 0.25e-3/0.1)
    arc = 0.1*np.column_stack([np.sin(t), np.cos(t)])
    points = np.concatenate([arc, arc[-1] - arc[0] + arc[1:]])
    points[::100, 1] += 5e-5
    random = np.random.default_rng(3)
    assert noise_of(points) < 2e-11
    across = np.concatenate([np.column_stack([np.sin(t), np.cos(t)])]*2)[:len(points)]
    assert noise_of(points + noise*across*random.normal(size=(len(points), 1))) == pytest.approx(noise, rel=0.2)


def test_noise_of_points_far_apart_is_not_known():
    x = np.arange(0, 100, 1.01)*1e-3
    points = np.column_stack([x, np.random.default_rng(1).normal(0, 1e-5, len(x))])
    assert noise_of(points) == 0 and noise_of(points[:5]) == 0
    near = points*[0.9, 1]
    assert noise_of(near) == pytest.approx(1e-5, rel=0.2) and noise_of(near[:13]) == 0 and noise_of(near[:14]) > 0
    assert noise_of(points[[0]*20]) == 0


AXES = ((-1.0, 2.0, 0.3, 0.25), (0.0, 1.5, 0.0, 0.0), (-0.5, 0.5, 0.0, 0.1))    # first, last, centre, scale


def axis_points(n: int, first: float, last: float, centre: float, scale: float) -> np.ndarray:
    """Evenly spaced in asinh((x - centre)/scale); in x for scale 0."""
    if scale == 0:
        return np.linspace(first, last, n)
    return centre + scale*np.sinh(np.linspace(np.arcsinh((first - centre)/scale), np.arcsinh((last - centre)/scale), n))


def spline(f, n: int, points: np.ndarray) -> np.ndarray:
    """Value, gradient and Hessian of the spline of f on n points per axis, in space and in a plane."""
    x, y, z = (axis_points(n, *axis) for axis in AXES)
    values = f(x[:, None, None], y[None, :, None], z[None, None, :]).ravel(order="F")
    axes = "".join(f"{n}\n{text(axis[None])}" for axis in (x, y, z))
    return probe("spline_values", stdin=axes + text(values[:, None]) + text(points))


def random_points(n: int) -> np.ndarray:
    low, high = np.array([axis[:2] for axis in AXES]).T
    return np.random.default_rng(3).uniform(low, high, (n, 3))


def smooth(x, y, z):
    return np.sin(2*x + 1)*np.exp(-0.7*y)*np.cos(3*z - 0.5*x)


def test_spline_reproduces_cubics():
    """A product of cubics is reproduced to round-off."""
    def cubic(x, y, z):
        return (1 + x - x**3/9)*(y**3 - 2*y + 0.5)*(3 - z**2 + z**3)

    points = random_points(300)
    values = spline(cubic, 11, points)
    exact = cubic(*points.T)
    assert values[:, 0] == pytest.approx(exact, abs=1e-13*np.abs(exact).max())
    plane = cubic(points[:, 0], points[:, 1], np.float64(AXES[2][0]))
    assert values[:, 10] == pytest.approx(plane, abs=1e-13*np.abs(plane).max())
    assert values[:, 16] == pytest.approx(values[:, 10], abs=1e-14*np.abs(plane).max())
    # Without second derivatives the others are the same, summed in another order.
    scale = np.abs(values).max(axis=0)
    assert (np.abs(values[:, 17:21] - values[:, :4]) <= 1e-13*scale[:4]).all()
    assert (np.abs(values[:, 21:] - values[:, 10:13]) <= 1e-13*scale[10:13]).all()


def test_spline_convergence():
    """Values converge with order 4, gradients with 3, Hessians with 2 (rms over the domain)."""
    h = 1e-3
    points = random_points(1500)
    exact = smooth(*points.T)
    errors = []
    steps = np.eye(3)*h

    def slope(shift: np.ndarray, along: np.ndarray) -> np.ndarray:     # to order h^4
        f = [smooth(*(points + shift + k*along).T) for k in (-2, -1, 1, 2)]
        return (f[0] - 8*f[1] + 8*f[2] - f[3])/(12*h)

    gradient = np.column_stack([slope(np.zeros(3), e) for e in steps])
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    second = np.column_stack([
        (slope(-2*steps[j], steps[i]) - 8*slope(-steps[j], steps[i]) + 8*slope(steps[j], steps[i])
         - slope(2*steps[j], steps[i]))/(12*h) for i, j in pairs])
    for n in 25, 49:
        v = spline(smooth, n, points)
        errors.append([np.sqrt(np.mean(error**2)) for error in (v[:, 0] - exact, v[:, 1:4] - gradient, v[:, 4:10] - second)])
    assert np.log2(np.divide(*errors)) == pytest.approx([4, 3, 2], abs=0.3)


def test_spline_derivatives():
    """Gradient and Hessian are those of the spline itself (finite differences), in space and in the plane."""
    h = 2e-5
    # Away from the ends: the differences must stay on the axes.
    points = 0.999*random_points(200) + 0.001*np.array([0.5, 0.75, 0.0])
    v = spline(smooth, 12, points)
    second = np.array([[4, 5, 6], [5, 7, 8], [6, 8, 9]])
    for i in range(3):
        low, high = (spline(smooth, 12, points + sign*h*np.eye(3)[i]) for sign in (-1, 1))
        difference = (high - low)/(2*h)
        # Third derivatives jump at knots: the differences err by a part of h there.
        assert v[:, 1 + i] == pytest.approx(difference[:, 0], abs=1e-7)
        assert v[:, second[i]] == pytest.approx(difference[:, 1:4], abs=1e-2)
        assert np.median(np.abs(v[:, second[i]] - difference[:, 1:4])) < 1e-7
        if i < 2:
            assert v[:, 11 + i] == pytest.approx(difference[:, 10], abs=1e-7)
            assert np.median(np.abs(v[:, [[13, 14], [14, 15]][i]] - difference[:, 11:13])) < 1e-7


def test_spline_is_c2():
    """Value, gradient and Hessian are the same on both sides of every knot."""
    points = random_points(18)
    for i, axis in enumerate(AXES):
        knots = axis_points(20, *axis)[1:-1]
        points[:, i] = knots
        shift = np.zeros(3)
        shift[i] = 1e-11
        low, high = (spline(smooth, 20, points + sign*shift) for sign in (-1, 1))
        assert low == pytest.approx(high, abs=1e-7)
