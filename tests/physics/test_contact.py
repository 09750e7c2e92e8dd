"""Placement, rigid geometry and the contact potential, against exact answers."""

import numpy as np
import pytest

from ldbench import Case, ContactTable, run
from ldbench._core import flat
from ldbench.table import rigid_geometry
from ldbench_round.tasks import clearances
from probes import (
    E_STAR,
    MIRROR,
    MODERN,
    ROLLING_RADIUS,
    TAPER,
    WEIGHT,
    Pendulum,
    States,
    gaps,
    left_rail,
    left_wheel,
    poses,
    tangent_angles,
    turned,
)
from round_profiles import hertz
from running import PAIRS, Run, kept_tables


@pytest.fixture(scope="module", params=PAIRS)
def pair(request: pytest.FixtureRequest) -> str:
    return request.param


# The pairs of what takes seconds for each.
HEAVY = ["aw", pytest.param("sw", marks=pytest.mark.slow)]


@pytest.fixture(scope="module")
def table(pair: str) -> ContactTable:
    """The table of the shipped inputs."""
    return ContactTable(Case.exercise(2, pair).replace(table_folder=kept_tables()))


@pytest.mark.parametrize("shapes", [*PAIRS, "s1002"])
def test_zones_tile_the_wheel(shapes: str):
    """Between 2 and 6 zones from the rim face to behind the flange's tip, each longer than 1 mm, the flange's last."""
    case = Case.exercise(2, shapes) if shapes in PAIRS else Case.exercise(2).replace(**MODERN)
    (_, n), zones = flat.rigid_numbers(rigid_geometry(case), 1)
    first, last, flange, _ = zones[:, :int(n)]
    wheel = np.loadtxt(case.find(case.wheel_profile), comments=("#", "!"))
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(wheel, axis=0).T))])       # [mm]
    assert 1e3*last[0] == pytest.approx(wheel[-1, 0], abs=1e-6) and (first[:-1] == last[1:]).all()
    assert (np.interp(1e3*last, wheel[:, 0], along) - np.interp(1e3*first, wheel[:, 0], along) > 1).all()
    assert 2 <= n <= 6 and not flange[0] and flange[-1] and (np.diff(flange) >= 0).all()


def tread_stiffness(pair: str) -> float:
    """C_H of the centred tread: a cone on a constant crown [N/m^1.5]."""
    return hertz(np.cos(TAPER)/(2*ROLLING_RADIUS), 0.5/Pendulum.of(pair).rho, 1.0, E_STAR)[3]      # the force at an approach of 1 m


def test_static_equilibrium(table: ContactTable):
    """At rest each rail carries 90.000 kN, all forces and moments balance to 1e-9; high above there is neither energy nor force."""
    rest, above = (States(table, np.array([[0, table.equilibrium + up, 0]])) for up in (0, 0.02))
    assert -rest.gradient[0, [0, 2], 1] == pytest.approx(90e3, abs=0.5) and (rest.force[0, [1, 3]] == 0).all()
    assert -rest.total[0] == pytest.approx([0, WEIGHT, 0], abs=1e-9*WEIGHT)
    assert (above.energy == 0).all() and (above.gradient == 0).all()


def test_approach(pair: str, table: ContactTable):
    """The axle rests lower than the rigid one by Hertz's approach of a cone on the crown."""
    # The files' six decimals leave the crown's curvature uncertain by 3e-4.
    approach = (90e3/np.cos(TAPER)/tread_stiffness(pair))**(2/3)/np.cos(TAPER)
    assert table.rigid_height - table.equilibrium == pytest.approx(approach, rel=2e-4)


def test_clearance(pair: str, table: ContactTable):
    """Rigid-axle clearance 10.18 and 16.94 mm to 1 um; there the profiles' points touch at tread and flange."""
    assert table.clearance == pytest.approx(clearances()[pair], abs=1e-6)
    (y, z, roll), = Pendulum.of(pair).poses(np.array([clearances()[pair]]))
    wheel = left_wheel(pair)
    gap = gaps(turned(wheel, roll) + [y, z], left_rail(pair))
    flange = tangent_angles(wheel) > np.radians(10)
    # Points 0.25 mm apart: chord and arc of the rail's and the wheel's radii differ by up to 1 um.
    assert gap[flange].min() == pytest.approx(0, abs=1.5e-6)
    assert gap[~flange].min() == pytest.approx(0, abs=1e-7)


def test_geometry_functions(pair: str):
    """Roll and height of the rigid wheelset are those of the exact pendulum, cone on round heads."""
    g = ContactTable(Case.exercise(2, pair).replace(formulation="unilateral", table_folder="")).geometry()
    rail = Pendulum.of(pair)
    on_tread = np.abs(g["Y"]) < 0.95*clearances()[pair]
    g = {name: column.to_numpy()[on_tread] for name, column in g.items()}
    exact = rail.poses(g["Y"])
    # Points of six decimals, rounded by up to 0.5 nm; a wheel's lever is 0.75 m. Rounded points tilt the normal by up to 4e-6,
    # which shifts the contact on a crown of 0.3 m by 1 um.
    left, right = rail.radius(exact), rail.radius(exact*MIRROR)
    for name, values, within in (("roll", exact[:, 2], 2e-9), ("Z", exact[:, 1] - rail.poses(np.zeros(1))[0, 1], 2e-9),
                                 ("radius_L", left, 1e-7), ("radius_R", right, 1e-7), ("delta_r", left - right, 2e-7),
                                 ("angle_L", TAPER + exact[:, 2], 2e-5)):
        assert g[name] == pytest.approx(values, abs=within), name
    wide = np.abs(g["Y"]) > 2e-3
    assert g["conicity"][wide] == pytest.approx((left - right)[wide]/(2*g["Y"][wide]), rel=2e-4)
    if pair == "aw":      # the published values
        near = np.abs(np.abs(g["Y"]) - 5e-3) < 1e-6
        assert g["roll"][near]/g["Y"][near] == pytest.approx(0.033663, abs=1e-6)
        assert 2*g["Z"][near]/g["Y"][near]**2 == pytest.approx(0.068153, rel=2e-3)


@pytest.mark.parametrize("formulation", ["elastic", "bilateral"])
def test_a_roll_rate_on_rails_is_the_slope_of_the_roll(formulation: str):
    """d(roll)/dY of the geometry functions, off the centre too, where treads roll on their crowns."""
    y, step = 6e-3, 1e-5
    case = Case.exercise(1, "aw").replace(formulation=formulation, roll_link="rails", Y=y, t_end=1e-4, interval=1e-4, model="hertz",
                                          table_folder=kept_tables(), stop_at="t_end", judged="no")
    done = run(case)
    roll = done.table.geometry([y - step, y + step]).roll.to_numpy()
    assert done.data.roll_rate.iloc[0] == pytest.approx(case.vY*np.diff(roll)[0]/(2*step), rel=1e-6)


@pytest.fixture(scope="module")
def random_poses(pair: str, table: ContactTable, shipped: dict[str, Run]) -> np.ndarray:
    """Poses over the whole table, 10 um to 1 mm below where a wheel first touches, and flange contacts."""
    rng = np.random.default_rng(4)
    n = 80
    # Half of them anywhere, half of them about the running position.
    scale = np.repeat([1, 0.2], n//2)
    y, roll = rng.uniform(-0.05, 0.05, n)*scale, rng.uniform(-0.3, 0.3, n)*scale**2
    low, high = np.full(n, 0.3), np.full(n, 1.0)        # the height of first contact lies between
    for _ in range(24):
        middle = (low + high)/2
        energy = States(table, np.column_stack([y, middle, roll])).energy
        touching = (np.isnan(energy) | (energy > 0)).any(axis=1)
        low, high = np.where(touching, middle, low), np.where(touching, high, middle)
    found = [np.column_stack([y, high - 10**rng.uniform(-5, -3, n), roll])]
    # Flange contacts of the runs, on the gauge face and on top of the rail, moved a little.
    run = shipped[f"ex5_{pair}"]
    flange, high = run.columns["N_LF"] > 0, run.columns["Z"] > 20e-3
    for rows in flange & ~high, flange & high:
        near = rng.choice(poses(run)[rows], 40) + rng.normal(0, [5e-5, 3e-5, 3e-5], (40, 3))
        found += [near[:20], near[20:]*MIRROR]
    found = np.concatenate(found)
    state = States(table, found)
    return found[np.isfinite(state.energy).all(axis=1) & (state.energy > 0).any(axis=1)]


H = 1e-7      # step of finite differences [m, rad]


def shifted(table: ContactTable, poses: np.ndarray, i: int, h: float = H) -> list[States]:
    """States at -2h, -3h/2, ..., 2h along coordinate i."""
    return [States(table, poses + k*h/2*np.eye(3)[i]) for k in range(-4, 5)]


def misses(values: list[np.ndarray], exact: np.ndarray, h: float = H) -> np.ndarray:
    """By what `exact` misses the derivative of values at -2h, -3h/2, ..., 2h: the least of the differences of fourth order about it
    and to either side, because third derivatives jump at the knots of a table, and a knot lies on one side at most."""
    def onward(f: list[np.ndarray]) -> np.ndarray:
        return (-25*f[0] + 48*f[1] - 36*f[2] + 16*f[3] - 3*f[4])/(6*h)

    a, b, c, d = (values[k] for k in (0, 2, 6, 8))
    found = (a - 8*b + 8*c - d)/(12*h), onward(values[4:]), -onward(values[4::-1])
    return np.min(np.abs(np.array(found) - exact), axis=0)


def resolved(around: list[States]) -> np.ndarray:
    """Contacts deep enough for the differences (about 5 um), or open; (pose, contact)."""
    low, high = around[0].force, around[-1].force
    return np.abs(high - low) <= 0.12*np.minimum(low, high)


@pytest.mark.parametrize("pair", HEAVY, indirect=True)
def test_forces_and_stiffness_are_derivatives(table: ContactTable, random_poses: np.ndarray):
    """Force and moment of every wheel are minus the gradient of its energy, the tangent stiffness is the derivative of the
    gradient, at random poses."""
    state = States(table, random_poses)
    on_flange = (state.force[:, [1, 3]] > 0).any(axis=1)
    assert ((state.force > 0).sum(axis=0) > 20).all()        # all four contacts are there,
    assert (np.abs(random_poses[:, 2]) > 0.1).sum() > 12     # large roll,
    assert (random_poses[on_flange, 1] > table.rigid_height + 20e-3).sum() > 12     # flanges on top of the rail
    gradient = state.gradient[:, ::2] + state.gradient[:, 1::2]     # of a wheel: tread and flange have one potential
    size = np.maximum(np.abs(gradient).max(axis=2), 1e3), np.abs(state.hessian).max(axis=(1, 2))
    for i in range(3):
        around = shifted(table, random_poses, i)
        # Knots of two contacts' tables may lie on both sides; nearer to the pose there is one at most.
        near = shifted(table, random_poses, i, H/3)
        force = misses([s.energy for s in around], gradient[:, :, i])/size[0]
        stiffness = np.minimum(misses([s.total for s in around], state.hessian[:, :, i]),
                               misses([s.total for s in near], state.hessian[:, :, i], H/3)).max(axis=1)/size[1]
        clear = resolved(around)
        wheels, all_four = clear[:, ::2] & clear[:, 1::2], clear.all(axis=1)
        assert wheels.mean() > 0.9 and force[wheels].max() < 1e-7 and np.median(force[wheels & (state.energy > 0)]) < 1e-9
        assert all_four.mean() > 0.9 and stiffness[all_four].max() < 1e-7 and np.median(stiffness[all_four]) < 1e-9
