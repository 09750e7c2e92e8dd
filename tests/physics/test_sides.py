"""Left and right may differ: wheel_profile_right, rail_profile_right."""
import functools
import itertools
import re
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

import ldbench
import shapes
from ldbench import Case, ContactTable, run
from ldbench.conicity import equivalent_conicity, linearised_conicity
from ldbench.geometry.outlines import case_outlines, pose, run_outlines, turned
from ldbench.results.run_data import read_data
from mirror_image import OTHER, mirrored, mirrored_results
from probes import MASS, WEIGHT, gaps
from round_profiles import RADIUS, Shape
from running import REPO, alike, header, rows, run_case, short_case

# The call's roll rate fits its own profiles, and the two sides have different ones.
pytestmark = pytest.mark.filterwarnings("ignore:&initial roll_rate. expected about")

FORMULATIONS = "elastic", "bilateral", "unilateral"
LEFT = {"wheel_profile": "awprof", "rail_profile": "arprof"}
RIGHT = {"wheel_profile": "s1002", "rail_profile": "60e1"}
# Which law a table holds does not matter to what has two sides: that of Hertz is built in the least time. The wheelset stays
# between the rails, and so does the path on which rigid contact is followed.
COARSE = {"model": "hertz", "lateral": 0.02}


def profiles(left: dict[str, str], right: dict[str, str]) -> dict[str, str]:
    """Values of the shipped profiles of either side."""
    def path(name: str) -> str:
        return str(REPO / f"profiles/{name}.yz")

    return {key: path(name) for key, name in left.items()} | {f"{key}_right": path(name) for key, name in right.items()}


def two_sided(formulation: str = "elastic", left: dict[str, str] = LEFT, right: dict[str, str] = RIGHT, **changes) -> Case:
    return Case.exercise(2).replace(table_folder="", formulation=formulation, t_end=0.3, stop_at="t_end", **COARSE,
                                    **profiles(left, right)).replace(**changes)


@functools.cache
def table_of(formulation: str = "elastic", left: tuple[str, ...] = tuple(LEFT.values()),
             right: tuple[str, ...] = tuple(RIGHT.values())) -> ContactTable:
    """That of two_sided with these wheel and rail; it serves other initial conditions."""
    return ContactTable(two_sided(formulation, *(dict(zip(LEFT, names, strict=True)) for names in (left, right))))


@pytest.mark.parametrize("formulation", ["elastic", "unilateral"])
def test_the_same_file_twice_is_the_default(formulation: str, tmp_path: Path):
    """Named twice, or copied: the same bytes, but for the names; and one table."""
    shutil.copy(REPO / "profiles/arprof.yz", tmp_path / "copy.yz")
    found = []
    for right in ({}, {"wheel_profile_right": REPO / "profiles/awprof.yz", "rail_profile_right": tmp_path / "copy.yz"}):
        text = short_case(tmp_path, profiles=right, contact={"formulation": formulation}, table={"folder": tmp_path/"tables"})
        done = run_case(text, tmp_path)
        assert "rigid-axle clearance [mm]: left 10.180, right 10.180\n" in done.stdout, done.stderr
        found.append(rows(tmp_path / "columns.txt"))
        (tmp_path / "columns.txt").unlink()
    assert found[0] == found[1]
    assert not (tmp_path / "table.right").exists()


OTHERS = {"wheel and rail": RIGHT, "wheel": {"wheel_profile": "s1002"}, "rail": {"rail_profile": "srprof"}}
STARTS = {"thrown": {"vY": 0.5, "roll_rate": 0.01667}, "at the centre": {"vY": 0.0, "roll_rate": 0.0},
          "dropped": {"Z": 0.002, "vY": 0.0, "roll_rate": 0.0},
          "implicit": {"vY": 0.5, "roll_rate": 0.01667, "beta": 0.25, "order": 2}}
MIRRORED = [("elastic", "wheel and rail", "thrown"), ("elastic", "rail", "dropped"), ("elastic", "wheel", "implicit"),
            ("bilateral", "rail", "thrown"), ("bilateral", "wheel and rail", "at the centre"), ("unilateral", "wheel", "thrown"),
            ("unilateral", "rail", "dropped")]
LEANS = "1:60", "1:30"      # of the left and of the right rail
SIDE = re.compile("left|right")


@pytest.mark.parametrize(("formulation", "side", "begin"), MIRRORED)
def test_mirrored_input_gives_mirrored_output(formulation: str, side: str, begin: str):
    """Files and inclinations of left and right exchanged, initial conditions mirrored: columns, results, events and geometry
    functions are mirrored bit for bit."""
    right, start = LEFT | OTHERS[side], STARTS[begin]
    lean = dict(zip(("rail_inclination", "rail_inclination_right"), LEANS, strict=True)) if side == "rail" else {}
    case = two_sided(formulation, LEFT, right, t_end=0.1, **start, **lean)
    if formulation == "bilateral" and right == RIGHT:
        case = case.replace(t_end=0.02)         # then it stands on a corner of the s1002's flange
    opposite = case.replace(**profiles(right, LEFT), **{name: -start[name] for name in ("vY", "roll_rate")},
                            **dict(zip(lean, LEANS[::-1], strict=False)))
    here, there = run(case), run(opposite)
    found = mirrored(there.data)
    assert len(here.data) > 10
    for name in here.data:
        assert np.array_equal(here.data[name], found[name], equal_nan=True), name
    image = mirrored_results(there.results)
    rounding = {"drift", "t_drift", "drift_relative", "changes"}
    assert {name: (x, image[name]) for name, x in here.results.items()
            if name not in rounding and not alike(x, image[name], rel=1e-9)} == {}
    events, image = ([(e.t, e.kind, str(e.angle), e.cause, e.loss) for e in done.events] for done in (here, there))
    assert sorted(events) == sorted((t, SIDE.sub(lambda side: OTHER[side[0]], kind), *rest) for t, kind, *rest in image)
    assert alike(here.header.table_errors, there.header.table_errors, rel=1e-9)
    image = np.array([-1, 1, -1])*there.table.rest
    assert here.table.rest == pytest.approx(image, abs=1e-15) if lean else here.table.rest == tuple(image)
    y = 1e-3*np.arange(-9, 10)
    geometry, reflected = here.table.geometry(y), mirrored(there.table.geometry(y[::-1]))
    for name in geometry.columns:
        close = {"rtol": 1e-9, "atol": 0} if name == "conicity" else {"rtol": 0, "atol": 0}
        assert np.allclose(geometry[name], reflected[name], equal_nan=True, **close), name


def balance(row: pd.Series, table: ContactTable) -> np.ndarray:
    """Force [N] and moment about the axle centre [N m] of contacts and weight, from what the columns say of contacts."""
    total = np.array([0, -WEIGHT, 0])
    for contact in "LT", "LF", "RT", "RF":
        if row[f"N_{contact}"]:
            angle = (-1 if contact[0] == "L" else 1)*row[f"angle_{contact}"]
            force = row[f"N_{contact}"]*np.array([np.sin(angle), np.cos(angle)])
            arm = row[f"y_{contact}"] - row.Y, row[f"z_{contact}"] - row.Z - table.equilibrium
            total = total + [*force, arm[0]*force[1] - arm[1]*force[0]]
    return total


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_at_rest_forces_and_moments_balance(formulation: str):
    """Put where the header says it rests, the wheelset stays there, off the centre and rolled; there the contacts'
    normals, at their points, and the weight are in balance."""
    case = two_sided(formulation, vY=0.0, roll_rate=0.0, t_end=0.3 if formulation == "elastic" else 0.1)
    table = table_of(formulation).for_case(case)
    y, z, roll = table.rest
    assert abs(y) > 2e-3 and abs(roll) > 5e-5
    c = run(case.replace(Y=y, Z=z - table.equilibrium, initial_roll=roll - table.equilibrium_roll), table=table).data
    for k in 0, -1:
        assert (np.abs(balance(c.iloc[k], table)) < np.array([1e-6, 1e-6, 1e-5])*WEIGHT).all()
    assert (np.ptp(c[["Y", "Z", "roll"]], axis=0) < [1e-7, 1e-9, 1e-9]).all()


def test_held_at_the_centre_only_the_lateral_force_is_left():
    """Where Y = Z = roll = 0: no start-up transient but the slow way off the centre."""
    table = table_of().for_case(two_sided(vY=0.0, roll_rate=0.0))
    force = table.force(0.0, table.equilibrium, table.equilibrium_roll)
    assert force[1] == pytest.approx(WEIGHT, rel=1e-9) and abs(force[2]) < 1e-9*WEIGHT
    c = run(table.case, table=table).data
    assert force[0] == pytest.approx(MASS*c.aY[0], rel=1e-9) and force[0] != 0
    assert np.abs(c.loc[0, ["aZ", "roll_acc"]]).max() < 1e-6
    assert c.aY[0] == pytest.approx(force[0]/MASS) and np.sign(c.Y.iloc[100]) == np.sign(force[0])


def two_cones(left: Shape, right: Shape) -> tuple[float, float, float]:
    """Y, Z over the centred pose, roll of the lowest pose in which two cones lie on two round heads."""
    def distances(q: np.ndarray, y: float) -> list[float]:
        """The distances of the heads' centres from the treads, less the heads' radii."""
        z, roll = q
        found = []
        for shape, side in (left, 1), (right, -1):
            g, turn = shape.taper, side*roll
            # The tread, a line through the contact of the centred wheelset in the wheelset's frame.
            point, normal = np.array([shape.contact, -RADIUS]), np.array([-np.sin(g), np.cos(g)])
            turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            centre = np.array([shape.head, -shape.R_r])
            found.append(turned @ normal @ (np.array([side*y, z]) + turned @ point - centre) - shape.R_r)
        return found

    def pose(y: float) -> np.ndarray:
        return fsolve(distances, [RADIUS, 0.0], args=(y,), xtol=1e-12)

    def climb(y: float) -> float:
        return pose(y + 1e-5)[0] - pose(y - 1e-5)[0]

    y = brentq(climb, -0.008, 0.008, xtol=1e-12)
    return y, *pose(y) - [pose(0.0)[0], 0.0]


CONES = Shape(np.arctan(1/20), np.inf, 0.3), Shape(np.arctan(1/19.8), np.inf, 0.28)


def test_rest_on_two_cones(tmp_path: Path):
    """Off the centre by what the geometry of two lines on two circles says; an elastic wheelset tends to it."""
    def case(spacing: float) -> Case:
        files = {}
        for shape, end in zip(CONES, ("", "_right"), strict=True):
            (folder := tmp_path / f"{spacing}{end}").mkdir()
            written = shape.case(folder, spacing)
            files |= {f"wheel_profile{end}": written.wheel_profile, f"rail_profile{end}": written.rail_profile}
        return two_sided().replace(**files)

    y, z, roll = two_cones(*CONES)
    assert abs(y) > 1e-4
    exact, near = case(0.05), case(0.25)
    table = ContactTable(exact.replace(formulation="unilateral"))
    assert table.rest[0] == pytest.approx(y, abs=1e-8)
    assert table.rest[1] - table.equilibrium == pytest.approx(z, abs=1e-12)
    assert table.rest[2] == pytest.approx(roll, abs=1e-9)
    # A small table about the position at rest of steel 100 times as stiff; its depth goes with the approach.
    table = ContactTable(near.replace(stiffness_scale=100, depth=1e-3*100**(-2/3), table_roll=0.01))
    assert table.rest[0] == pytest.approx(y, rel=0.03) and table.rest[2] == pytest.approx(roll, rel=0.03)


@pytest.fixture(scope="module")
def worn_pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Files of a wheel and of the same with a flange worn by 2 mm; the tread is the same."""
    folder, new = tmp_path_factory.mktemp("worn"), shapes.shape("awprof")
    for name, points in ("new", new), ("worn", shapes.thin_flange(new)):
        (folder / f"{name}.yz").write_text(shapes.rows(points))
    return str(folder / "new.yz"), str(folder / "worn.yz")


def test_clearance_to_either_side_is_that_of_the_symmetric_wheelset(worn_pair: tuple[str, str], tmp_path: Path):
    """The geometry functions change over to the flange at the clearance of either side; header and summary tell both."""
    new, worn = worn_pair
    case = two_sided("unilateral", LEFT, LEFT, t_end=1e-3)
    table = {sides: ContactTable(case.replace(wheel_profile=sides[0], wheel_profile_right=sides[1]))
             for sides in itertools.product(worn_pair, worn_pair)}
    found = {sides: (one.clearance, one.clearance_right) for sides, one in table.items()}
    wide, narrow = found[worn, worn], found[new, new]
    assert wide[0] == wide[1] > narrow[0] + 3e-4 and narrow[0] == narrow[1]
    assert found[new, worn] == pytest.approx((narrow[0], wide[0]), abs=1e-9)
    assert found[worn, new] == pytest.approx((wide[0], narrow[0]), abs=1e-9)
    for way, angle, clearance in (1, "angle_L", narrow[0]), (-1, "angle_R", wide[0]):
        g = table[new, worn].geometry(way*(clearance + np.array([-2e-4, -1e-4, 1e-4, 2e-4])))
        assert (g[angle] >= np.radians(25)).tolist() == [False, False, True, True]
    done = run(table[new, worn].case, table=table[new, worn])
    assert f"rigid-axle clearance [mm]: left {1e3*narrow[0]:.3f}, right {1e3*wide[0]:.3f}\n" in done.text
    done.write(tmp_path / "columns.txt")
    head = header(tmp_path / "columns.txt")
    assert f"left wheel profile: {new}, CRC-32 " in head
    assert f"right wheel profile: {worn}, CRC-32 " in head and "\nrail profile: " in head
    read = read_data(tmp_path / "columns.txt")
    assert (read.results["clearance_left"], read.results["clearance_right"]) == pytest.approx((narrow[0], wide[0]), abs=1e-6)
    assert set(read.header.profiles) == {"left wheel", "right wheel", "rail"}


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_energy(formulation: str):
    """Through impacts on both flanges: 1e-8 of the initial kinetic energy. The extremes of the motion in the results are those of
    the rows, or between two of them."""
    done = run(two_sided(formulation, stop_at="t_end", t_end=0.6), table=table_of(formulation))
    assert done.results["n_left_flange_contact"] and done.results["n_right_flange_contact"]
    assert done.results["drift"] < 1e-8*done.results["kinetic_energy"]
    for column, names in ("Y", ("farthest_left", "farthest_right")), ("Z", ("farthest_up", "farthest_down")), (
            "roll", ("largest_roll", "smallest_roll")):
        for name, way in zip(names, (1, -1), strict=True):
            assert abs(way*done.results[name] - (way*done.data[column]).max()) < 5e-6, name


def test_conicity_about_the_centre_of_the_motion():
    """Linear and off the centre: that of the slope. A cubic off the centre: EN 15302 by integration of the motion."""
    y, scale = np.linspace(-0.01, 0.01, 2001), 1e4             # y'' = -scale delta_r
    for conicity in equivalent_conicity, linearised_conicity:
        assert conicity(np.array([1e-3, 4e-3]), y, 0.06*(y - 1.2345e-3)) == pytest.approx(0.03, rel=1e-9)

    def delta_r(y: np.ndarray) -> np.ndarray:
        return 0.05*(y - 2e-3) + 20*(y - 2e-3)**2 + 2e3*(y - 2e-3)**3

    def turned(t: float, x: np.ndarray) -> float:
        return x[1]

    turned.direction = 1
    way = solve_ivp(lambda t, x: [x[1], -scale*delta_r(x[0])], (0, 2), [7e-3, 0], events=turned, rtol=1e-11, atol=1e-14)
    amplitude = (7e-3 - way.y_events[0][0][0])/2
    # Half a wave: pi/sqrt(scale 2 conicity).
    expected = (np.pi/way.t_events[0][0])**2/(2*scale)
    assert equivalent_conicity(np.array([amplitude]), y, delta_r(y)) == pytest.approx(expected, rel=1e-4)
    for conicity in equivalent_conicity, linearised_conicity:
        assert np.isnan(conicity(np.array([9.9e-3]), y, delta_r(y))).all(), "leaves the functions"


def test_pictures_of_two_sides(tmp_path: Path):
    """Each wheel is drawn with its own profile, above its rail; the columns' contact points lie on it, to what is between its
    points."""
    run = read_data(ldbench.run(two_sided(t_end=0.03), table=table_of()).write(tmp_path/"columns.txt"))
    placed, remark = run_outlines(run)
    assert remark == "" and (placed.axle, placed.roll) == (run.results["axle_height"], run.results["axle_roll"])
    assert placed.left.wheel.shape != placed.right.wheel.shape
    rigid, table = case_outlines(run.case), table_of()
    sunk, rolled = rigid.axle - placed.axle, rigid.roll - placed.roll
    assert sunk == pytest.approx(table.sinking, abs=1e-10)
    assert placed.clearance == pytest.approx(rigid.clearance, abs=1e-9)
    assert rigid.clearance == (table.clearance, table.clearance_right)
    for (side, sign), contacts in zip(placed.sides, (("LT", "LF"), ("RT", "RF")), strict=True):
        rail, wheel = side.rail, turned(side.wheel, 0, placed.axle, sign*placed.roll)
        assert abs(rail[:, 1].max()) < 1e-9 and (wheel[:, 0] > 0).all()
        # Each tread enters its rail by what the wheelset sinks and rolls from its rigid place, in which treads touch.
        wheel, rail = (points[np.argsort(points[:, 0])] for points in (wheel, rail))
        y = np.linspace(0.74, 0.77, 301)
        gap = np.interp(y, *wheel.T) - np.interp(y, *rail.T)
        assert gap.min() == pytest.approx(-sunk - sign*y[gap.argmin()]*rolled, abs=2e-7)
        for contact in contacts:
            for k in np.flatnonzero(run.values(f"N_{contact}") > 0)[::10]:
                y, z, roll = pose(run, k)
                point = np.array([[sign*run.values(f"y_{contact}")[k], run.values(f"z_{contact}")[k]]])
                assert abs(gaps(point, turned(side.wheel, sign*y, z, sign*roll))[0]) < 1e-6
    for side, other in (rigid.left, placed.left), (rigid.right, placed.right):
        np.testing.assert_array_equal(side.wheel, other.wheel)
        np.testing.assert_array_equal(side.rail, other.rail)
