"""Rigid contacts on edges of profiles: the wheels of EN 15302, whose pieces meet with jumps of curvature and steps below a
micrometre, and an edge with a closed form."""
import functools
import tempfile
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import en15302
import make_profiles as arcs
from ldbench import Case, Run, run
from ldbench.constants import MM
from mirror_image import mirrored
from probes import MASS, ROLL_INERTIA, WEIGHT
from round_profiles import FLANGE, RADIUS, THROAT, Shape

WHEELS = "ABCHI"
SPEEDS = 0.3, 0.5           # [m/s]
LAWS = {"bilateral": {"formulation": "bilateral"}} | {
    f"unilateral, e = {e:g}": {"formulation": "unilateral", "restitution": e} for e in (0.0, 0.5, 1.0)}
T_END = 0.16                # [s]
PARTS = 8                   # of the way between two rows, for the quadrature
# The geometry functions know a wheel at stations 0.1 mm apart. Where its pieces meet on the flange's face there are steps of up
# to 0.09 um across the face of 70 degrees, 0.26 um upwards, which the wheelset climbs with 0.15 m/s. On the tread steps are
# a tenth of them.
STEEP, FACE_BARS, TREAD_BARS = np.radians(60), (3e-7, 2e-6), (3e-8, 2e-7)       # Z [m] and time [s]
# The edge is a spline that turns by 0.08 over 2 um: its point moves by as much, and the distance of the bodies by 0.01 um. The pose
# is unstable, so that the time's error grows.
POSE_BAR, RADIUS_BAR, EDGE_TIME_BAR = 2e-8, 2e-7, 2e-6                          # [m, rad], [m], [s]


@functools.cache
def profiles() -> dict[str, str]:
    return en15302.write(Path(tempfile.mkdtemp()))


@functools.cache
def motion(wheel: str, speed: float, law: str) -> Run:
    placed = en15302.case(wheel, profiles())
    placing = {name: getattr(placed, name) for name in (
        "wheel_profile", "rail_profile", "gauge", "gauge_depth", "back_to_back", "rolling_radius", "table_folder")}
    rows = "interval_and_events" if law == "bilateral" else "interval"
    return run(Case.exercise(1).replace(**placing, **LAWS[law], vY=speed, roll_rate=0.0, t_end=T_END, rows=rows))


EVERY = [(wheel, speed, law) for wheel in WHEELS for speed in SPEEDS for law in LAWS]
QUICK = [("A", 0.5, "bilateral"), ("B", 0.5, "unilateral, e = 0"), ("I", 0.3, "unilateral, e = 0.5")]


# On hollows of some nanometres wheel C without losses bounces a hundred thousand times.
@pytest.mark.parametrize(("wheel", "speed", "law"), [
    pytest.param(*one, marks=() if one in QUICK else pytest.mark.slow) for one in EVERY])
def test_every_wheel_runs(wheel: str, speed: float, law: str):
    """To the return, if there is energy enough for the flange, with the energy of the start but for the losses in impacts."""
    done = motion(wheel, speed, law)
    assert done.results["drift"] < 1e-9*done.results["kinetic_energy"]
    if speed == 0.5:
        assert done.ending == "return to the centre after both flanges"
    else:
        assert done.ending.startswith("return to the centre") or done.results["t"] == pytest.approx(T_END)
    lost = done.data.E_lost/done.results["kinetic_energy"]
    assert lost.min() > -1e-9
    assert lost.max() < 1e-9 if law in ("bilateral", "unilateral, e = 1") else lost.max() > 1e-9


@pytest.mark.parametrize(("wheel", "speed"), [
    pytest.param(wheel, speed, marks=() if (wheel, speed) == ("A", 0.5) else pytest.mark.slow)
    for wheel in WHEELS for speed in SPEEDS])
def test_time_is_the_quadrature_of_the_path(wheel: str, speed: float):
    """T + W Z is constant along the poses of the geometry functions, which no integrator has made."""
    done = motion(wheel, speed, "bilateral")
    c, energy = done.data, done.results["kinetic_energy"]
    out = c.iloc[:int(np.argmax(c.vY < 0))]
    out = out[energy - WEIGHT*out.Z > 0.05*energy]
    # Poses are as close to each other as the wheelset is slow.
    y = np.unique(out.Y)
    y = np.interp(np.arange(PARTS*(len(y) - 1) + 1)/PARTS, np.arange(len(y)), y)
    pose = done.table.geometry(y)
    dy, dz, turn = (np.diff(pose[name]) for name in ("Y", "Z", "roll"))
    length = np.sqrt(MASS*(dy**2 + dz**2) + ROLL_INERTIA*turn**2)
    kinetic = energy - WEIGHT*(pose.Z.to_numpy()[1:] + pose.Z.to_numpy()[:-1])/2
    t = np.concatenate([[0], np.cumsum(length/np.sqrt(2*kinetic))])
    steep = np.interp(out.Y, y, pose.angle_L) > STEEP
    assert steep.any() == (speed == 0.5)
    for ours, exact, face, tread in zip((out.Z, out.time), (pose.Z, t), FACE_BARS, TREAD_BARS, strict=True):
        assert (np.abs(ours - np.interp(out.Y, y, exact)) < np.where(steep, face, tread)).all()


def test_the_mirror_image_has_the_same_bytes():
    left, right = (motion("B", speed, "unilateral, e = 0").data for speed in (0.5, -0.5))
    image = mirrored(right)
    for name in left:
        assert np.array_equal(left[name], image[name], equal_nan=True), name


class Edge(Shape):
    """A tread of two cones that meet in an edge, on a round head: the wheelset that stands on both edges is a linkage."""

    INNER, OUTER = 0.02, 0.10           # angles of the tread on either side of the edge [rad]

    def wheel(self) -> list[arcs.Piece]:
        """Up to the edge."""
        run = MM*self.contact - arcs.WHEEL_BACK - THROAT
        flange = arcs.arc(-10, 0, FLANGE), arcs.line(FLANGE, 6/np.sin(FLANGE)), arcs.arc(18, FLANGE, self.INNER)
        low = THROAT - arcs.chain((0, 0), *flange)[-1].end[0]
        return arcs.chain((0, 0), arcs.arc(-low, -np.pi/2, 0), *flange, arcs.line(self.INNER, run/np.cos(self.INNER)))

    def case(self, folder: Path, spacing: float = arcs.STEP) -> Case:
        """With points on both sides of the edge from 2 um on."""
        made = super().case(folder, spacing)
        points, edge = np.loadtxt(made.wheel_profile), np.array(self.wheel()[-1].end)
        near, far = 2e-3*1.3**np.arange(19), 0.25*np.arange(2, 240)
        inner = edge - np.outer(near[::-1], [np.cos(self.INNER), np.sin(self.INNER)])
        outer = edge + np.outer([0, *near, *far], [np.cos(self.OUTER), np.sin(self.OUTER)])
        before = points[np.hypot(*(points - edge).T) > 1.3*near[-1]]
        np.savetxt(made.wheel_profile, np.concatenate([before, inner, outer]), fmt="%.17g")
        return made

    def pose(self, roll: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """y and z of the axle, z above the heads' centres [m]: edges at +-b are at the distance R_r from them."""
        b, s, c = self.contact, np.sin(roll), np.cos(roll)
        apart = self.head - b*c
        w = np.sqrt((self.R_r**2 - apart**2 - (b*s)**2)/(1 + (b*s/apart)**2))
        return w*b*s/apart - RADIUS*s, w + RADIUS*c


EDGE = Edge(0.06, np.inf, 0.3)


@pytest.mark.parametrize("law", ["bilateral", "unilateral, e = 0"])
def test_an_edge_rolls_on_a_round_head(law: str, tmp_path: Path):
    """The edge is fixed on the wheel and the contact angle turns from one side of the edge to the other: the pose is that of the
    linkage, and the time that of its energy."""
    speed = 0.1
    done = run(EDGE.case(tmp_path).replace(**LAWS[law], vY=speed, dt=1e-4, t_end=0.08, interval=1e-3, rows="interval"))
    c = done.data
    angle = c.angle_LT.to_numpy()
    on_edge = (angle > EDGE.INNER + 1e-3) & (c.angle_RT.to_numpy() < EDGE.OUTER - 1e-3)
    assert on_edge.sum() > 60 and np.ptp(angle[on_edge]) > 0.03
    c = c[on_edge]
    roll = np.array([brentq(lambda x, y=y: EDGE.pose(x)[0] - y, -2e-3, 2e-3, xtol=1e-17) for y in c.Y])
    z = EDGE.pose(roll)[1] - EDGE.pose(0.0)[1]
    assert c.roll.to_numpy() == pytest.approx(roll, abs=POSE_BAR) and c.Z.to_numpy() == pytest.approx(z, abs=POSE_BAR)
    assert c.radius_LT.to_numpy() == pytest.approx(RADIUS, abs=RADIUS_BAR)
    h = 1e-6

    def rate(roll: float) -> float:
        """dt/droll."""
        dy, dz = ((there - here)/(2*h) for here, there in zip(EDGE.pose(roll - h), EDGE.pose(roll + h), strict=True))
        energy = done.results["kinetic_energy"] + WEIGHT*(EDGE.pose(0.0)[1] - EDGE.pose(roll)[1])
        return np.sqrt((MASS*(dy**2 + dz**2) + ROLL_INERTIA)/(2*energy))

    t = np.array([quad(rate, 0, x, epsabs=1e-13, epsrel=1e-11)[0] for x in roll])
    assert c.time.to_numpy() == pytest.approx(t, abs=EDGE_TIME_BAR)
