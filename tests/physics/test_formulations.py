"""Rigid contact, bilateral and unilateral, against exact answers."""
import functools
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.interpolate import CubicHermiteSpline

import reference
from ldbench import Case, Error, Run, run
from ldbench.report import formulations
from probes import MASS, MODERN, ROLL_INERTIA, WEIGHT, gaps, left_rail, left_wheel, turned
from reference import RIGID_CASES
from round_profiles import Shape
from running import REPO

INERTIA = np.array([MASS, MASS, ROLL_INERTIA])


@functools.cache
def exercise(name: str, formulation: str, restitution: float = 1.0, **changes: object) -> Run:
    case = Case.exercise(int(name[2]), name[-2:])
    return run(case.replace(formulation=formulation, restitution=restitution, **{"rows": "interval"} | changes))


def velocities(c) -> np.ndarray:
    return np.column_stack([c.vY, c.vZ, c.roll_rate])


ON_60E1 = Case.exercise(3).replace(**MODERN)


def test_path_passes_over_hollows():
    """S1002 on 60E1: contact jumps along the tread long before the flange touches. The path goes on at the other point,
    with an impulse there that keeps the energy, and is that of the geometry functions, another algorithm, on both sides."""
    done = run(ON_60E1.replace(formulation="bilateral", vY=0.7, interval=2e-4))
    jump = next(e for e in done.events if e.kind == "impact")
    touch = next(e for e in done.events if e.kind == "left flange contact")
    assert jump.t < 0.1*touch.t and set(jump.impulses) == {"LT", "RT"}
    assert done.results["drift"] < 1e-11*done.results["kinetic_energy"]
    simple = exercise("ex3_sw", "bilateral", interval=2e-4)
    for found, aside, high in (done, 7.5e-3, 1.0), (simple, 18.2e-3, 1e-3):
        c = found.data[(found.data.Y.abs() < aside) & (found.data.Z.abs() < high)]
        geometry = found.table.geometry(c.Y.to_numpy())
        assert len(c) > 100 and c.Y.max() > 1.05*found.table.clearance
        assert np.abs(geometry[["Z", "roll"]].to_numpy() - c[["Z", "roll"]].to_numpy()).max() < 2e-9
    closed = c.N_LT.to_numpy() != 0
    for column in "radius", "angle":
        assert c[f"{column}_LT"].to_numpy()[closed] == pytest.approx(geometry[f"{column}_L"].to_numpy()[closed], abs=2e-6)


def test_energy_of_a_modern_pair():
    """With two contacts on one tread at once, and points of a wheel at jumps of its curvature and at ends of its zones, which come
    and go within a step. In random runs the nearest point of the conforming flange root jumps by a millimetre, and points that were
    not known come up inside the rail. No energy is made or lost but in impacts."""
    for changes, restitution in ({}, 1.0), ({"vY": 0.5}, 0.5), ({"vY": 0.5, "gauge": 1.4351, "back_to_back": 1.35214}, 0.0):
        done = run(ON_60E1.replace(formulation="unilateral", restitution=restitution, **changes))
        assert done.ending == "return to the centre after both flanges"
        assert done.results["drift"] < 1e-9*done.results["kinetic_energy"]
    rng = np.random.default_rng(0)
    for _ in range(3):
        done = run(ON_60E1.replace(
            formulation="unilateral", restitution=float(rng.choice([0.0, 0.5, 1.0])), vY=float(rng.uniform(0.05, 1)), roll_rate=0.0,
            lateral_force=float(rng.choice([0, 30e3, 60e3])), stop_at="t_end", t_end=0.3, rows="interval"))
        assert done.results["drift"] < 1e-6*done.results["kinetic_energy"], done.case


def test_energies_beside_the_climb_are_those_of_the_inputs(tmp_path: Path):
    """Exercise 2 begins with 0.8 m/s, exercise 4 with half the mass; there is no exercise 1 or 3."""
    for k, changes in (2, {"vY": 0.8}), (4, {"mass": MASS/2}), (5, {}):
        Case.exercise(k, "aw").replace(**changes).to_namelist(tmp_path/f"ex{k}_aw.nml")
    figure = Figure()
    formulations.draw_climb(figure.add_gridspec(1, 1)[0], tmp_path)
    [ax] = figure.axes
    known = {"exercise 2": 0.5*MASS*0.8**2, "exercise 4": 0.5*MASS/2*2.0**2}
    assert {text.get_text(): text.get_position()[1] for text in ax.texts} == pytest.approx(known)
    assert [line.get_ydata()[0] for line in ax.lines[1:]] == pytest.approx([*known.values()])
    assert known["exercise 2"] == pytest.approx(502, abs=1)


def test_a_wheelset_rests_in_a_corner():
    """Between tread and flange, with a lateral force that is too small for the flange and too large for the tread. The
    corner is where the paths on both sides of it, straight over nanometres, meet."""
    case = Case.exercise(1).replace(formulation="bilateral", vY=0.0, roll_rate=0.0, lateral_force=2e4, t_end=5e-3,
                                    stop_at="t_end")
    near = run(case).table.clearance
    y = near + np.array([-2e-9, -1e-9, 1e-9, 2e-9])
    z = np.array([run(case.replace(Y=at, t_end=1e-4)).data.Z.iloc[0] for at in y])
    slopes = (z[1] - z[0])/1e-9, (z[3] - z[2])/1e-9
    corner = y[1] + (z[2] - z[1] - slopes[1]*2e-9)/(slopes[0] - slopes[1])
    still = run(case.replace(Y=corner)).data
    assert slopes[0] < 2e4/WEIGHT < slopes[1]
    assert (still.Y == still.Y.iloc[0]).all() and (still.vY == 0).all()
    # The three contacts push, and carry the weight and the force.
    assert (still[["N_LT", "N_LF", "N_RT"]] > 1e3).all(axis=None)
    for axis, force in ("y", -2e4), ("z", WEIGHT):
        assert still[[f"F{axis}_{k}" for k in ("LT", "LF", "RT")]].sum(axis=1).to_numpy() == pytest.approx(force, rel=1e-9)
    assert still[["aY", "aZ", "roll_acc"]].abs().max(axis=None) < 1e-9
    # A micrometre beside it, it comes back to where it was.
    moved = run(case.replace(Y=corner - 1e-6)).data
    assert moved.Y.max() > corner and (moved.Y - corner).abs().max() < 1.001e-6


@pytest.mark.parametrize("right", ["", "s1002"])
def test_rest_and_frequency_are_those_of_the_geometry_functions(right: str):
    """At rest the height is least. W Z'' = omega^2 (m + m Z'^2 + I roll'^2) over Y, by differences."""
    profile = str(REPO / f"profiles/{right}.yz") if right else ""
    case = Case.exercise(1).replace(formulation="bilateral", wheel_profile_right=profile, table_folder="", t_end=1e-3)
    done = run(case)
    y, z, roll = done.table.rest
    step = 2e-5
    near = done.table.geometry(y + step*np.arange(-1, 2))
    heights, rolls = near["Z"].to_numpy(), near["roll"].to_numpy()
    assert heights[1] == pytest.approx(z - done.table.equilibrium, abs=1e-12) and rolls[1] == pytest.approx(roll, abs=1e-12)
    slope, bend = (heights[2] - heights[0])/(2*step), (heights[2] - 2*heights[1] + heights[0])/step**2
    turn = (rolls[2] - rolls[0])/(2*step)
    omega = np.sqrt(WEIGHT*bend/(MASS*(1 + slope**2) + ROLL_INERTIA*turn**2))
    assert abs(slope) < 1e-6 and (y == 0) == (right == "")
    assert done.table.frequencies[0] == pytest.approx(omega/(2*np.pi), rel=3e-5)


CONES = Shape(np.arctan(1/40), np.inf, 0.3)


def cone_case(folder: Path, amplitude: float) -> Case:
    """Exact cones on round heads: points with all digits."""
    return CONES.case(folder, 0.05).replace(
        formulation="bilateral", Y=amplitude, dt=1e-4, interval=1e-3, rows="interval", t_end=3.0)


def test_period_on_cones(tmp_path: Path):
    """The rigid wheelset on two round heads is a pendulum, known at any amplitude: design, 'exact checks'."""
    amplitude = 5e-3
    R, d = CONES.R, CONES.d
    largest = float(CONES.roll(amplitude))

    def rate(tau: float) -> float:
        """dt/dtau for roll = largest cos(tau)."""
        roll, short = largest*np.cos(tau), 2*largest*np.sin(tau/2)**2        # short: of the largest
        dy, dz = 2*R*np.cos(2*roll) - d*np.cos(roll), 2*R*np.sin(2*roll) - d*np.sin(roll)
        mass = MASS*(dy**2 + dz**2) + ROLL_INERTIA
        # z(largest) - z(roll) of z = -R cos(2 roll) + d cos(roll), without cancellation.
        rise = 2*R*np.sin(largest + roll)*np.sin(short) - 2*d*np.sin((largest + roll)/2)*np.sin(short/2)
        return largest*np.sin(tau)*np.sqrt(mass/(2*WEIGHT*rise))

    period = 4*quad(rate, 0, np.pi/2, epsabs=1e-13, epsrel=1e-12, limit=200)[0]
    c = run(cone_case(tmp_path, amplitude)).data
    passages = CubicHermiteSpline(c.time, c.Y, c.vY).roots(extrapolate=False)
    assert len(passages) >= 2
    assert 2*(passages[1] - passages[0]) == pytest.approx(period, rel=1e-8)


def test_a_row_on_the_flange_starts_there():
    """Where the path passes one Y at several heights, a run starts at the height that it is given."""
    climbing = exercise("ex4_aw", "bilateral").data
    rows = climbing[(climbing.Z > 1e-3) & (climbing.Y < 0.05)]
    for row in rows.iloc[::len(rows)//8].itertuples():
        start = run(Case.exercise(4).replace(formulation="bilateral", Y=row.Y, Z=row.Z, vY=row.vY, t_end=1e-3)).data.iloc[0]
        assert start[["Z", "roll", "vZ"]].to_numpy() == pytest.approx([row.Z, row.roll, row.vZ], rel=1e-5)


def test_bilateral_motion_is_reversible():
    """From where it is after the flange, with the velocity reversed, the wheelset comes back."""
    there = exercise("ex2_aw", "bilateral", t_end=0.045, stop_at="t_end").data.iloc[-1]
    assert there.vY < 0
    back = run(Case.exercise(2).replace(
        formulation="bilateral", Y=there.Y, vY=-there.vY, t_end=0.045, stop_at="t_end")).data.iloc[-1]
    assert back.Y == pytest.approx(0, abs=1e-8) and back.vY == pytest.approx(-0.5, abs=1e-8)


def test_multipliers_are_the_forces_of_statics_and_of_newton():
    """At rest both wheels carry half; on the way forces and accelerations balance, each contact in its direction."""
    still = run(Case.exercise(1).replace(formulation="bilateral", vY=0.0, roll_rate=0.0, t_end=1e-3)).data.iloc[0]
    assert still.N_LT == pytest.approx(WEIGHT/2/np.cos(still.angle_LT), rel=1e-9)
    c = exercise("ex2_aw", "bilateral").data
    forces = {axis: sum(c[f"F{axis}_{k}"] for k in ("LT", "LF", "RT", "RF")) for axis in "yz"}
    assert np.abs(forces["y"] - MASS*c.aY).max() < 1e-3
    assert np.abs(forces["z"] - WEIGHT - MASS*c.aZ).max() < 1e-3
    # q'' as a difference of the velocities, where nothing jumps.
    smooth = (c.time > 1e-3) & (c.time < 0.02)
    assert np.abs(np.gradient(c.vY, c.time) - c.aY)[smooth].max() < 1e-4
    pulled = c.N_RT < 0
    assert pulled.any() and (c.Fz_RT[pulled] < 0).all() and (c.angle_RT[pulled].abs() < 0.1).all()


def order(errors: list[float]) -> float:
    """Observed, of errors at steps that are halved: the slope from the first to the last."""
    return np.log2(errors[0]/errors[-1])/(len(errors) - 1)


def test_bilateral_order(tmp_path: Path):
    """On the way: a light wheelset that swings fast on cones, whose path bends evenly. Errors fall with the fourth
    power of the step."""
    case = cone_case(tmp_path, 3e-4).replace(
        mass=20.0, roll_inertia=8.0, interval=0.01, t_end=1.0, stop_at="t_end", energy_tolerance=0.0, error_tolerance=0.0)
    y = [run(case.replace(dt=dt)).data.Y.to_numpy() for dt in (0.01, 0.005, 0.0025, 2e-4)]
    errors = [np.abs(coarse - y[-1]).max() for coarse in y[:-1]]
    assert errors[0] > 1e-10 and 3.5 < order(errors) < 4.5


@pytest.mark.parametrize(("name", "restitution"), [("ex3_aw", 0.5), ("ex3_sw", 1.0)])
def test_unilateral_order(name: str, restitution: float):
    """At an instant after contacts of both flanges, with dozens of impacts, openings and closings on the way: errors fall
    at least with the fourth power of the step, for none of the events costs an order."""
    t_end = 8e-4*int(exercise(name, "unilateral", restitution).results["t"]/8e-4)
    fixed = {"t_end": t_end, "stop_at": "t_end", "interval": 8e-4, "energy_tolerance": 0.0, "error_tolerance": 0.0}
    y = [exercise(name, "unilateral", restitution, dt=dt, **fixed).data.Y.iloc[-1] for dt in (8e-4, 4e-4, 2e-4, 2.5e-5)]
    errors = [abs(coarse - y[-1]) for coarse in y[:-1]]
    # Where no contact lasts only rounding is left, some 1e-11 m.
    assert max(errors) < 1e-10 or order(errors) > 3.5


def test_free_flight_is_the_parabola():
    """With the loads and speeds of the case, not of the call."""
    mass, load = 1700.0, 1.2e5
    case = Case.exercise(1).replace(formulation="unilateral", Z=0.03, vY=0.3, vZ=0.1, roll_rate=0.05, t_end=0.02, stop_at="t_end",
                                    lateral_force=1e4, lateral_ramp=1e6, mass=mass, vertical_load=load, vX=7.0, pitch=0.4,
                                    pitch_rate=3.0)
    c = run(case).data
    t, a = c.time, 9.81 + load/mass
    assert (c.N_LT == 0).all() and (c.P_LT == 0).all()
    assert np.abs(c.Y - (0.3*t + (1e4*t**2/2 + 1e6*t**3/6)/mass)).max() < 1e-15
    assert np.abs(c.Z - (0.03 + 0.1*t - a*t**2/2)).max() < 1e-15
    assert np.abs(c.roll - 0.05*t).max() < 1e-15
    assert np.abs(c.X - 7*t).max() < 1e-15 and np.abs(c.pitch - 0.4 - 3*t).max() < 1e-15
    assert np.abs(c.PE_load/(load*c.Z) - 1).max() < 1e-12 and np.abs(c.PE_grav/(mass*9.81*c.Z) - 1).max() < 1e-12
    assert np.abs(c.E_drift).max() < 1e-9


@pytest.mark.parametrize(("pair", "restitution"), [("aw", 1.0), ("sw", 0.4), ("aw", 0.0)])
def test_a_single_impact_has_the_closed_form(pair: str, restitution: float):
    """P = -(1 + e) u/(n.M^-1 n), at the point where the bodies touch and along their common normal: a wheelset in the air hits the
    left rail with its flange."""
    done = run(Case.exercise(3, pair).replace(
        formulation="unilateral", restitution=restitution, Y={"aw": 5e-3, "sw": 14e-3}[pair], Z=4e-3, vZ=0.3, vY=1.0,
        roll_rate=0.0, t_end=0.015, interval=1e-4, rows="interval", stop_at="t_end"))
    hit = next(event for event in done.events if event.kind == "impact")
    assert list(hit.impulses) == ["LF"]
    c = done.data
    k = int(np.searchsorted(c.time, hit.t))
    assert (c.P_LF[:k] == 0).all() and c.P_LF[k] == pytest.approx(hit.impulses["LF"], rel=1e-12)
    assert next((event.t for event in done.events if event.kind == "impact" and event.t > hit.t), 1) > c.time[k]
    # Pose and velocities on both sides of the impact, by the parabola from the nearest rows.
    gravity, fall = np.array([0, -WEIGHT/MASS, 0]), hit.t - c.time[k - 1]
    pose = np.array([c.Y[k - 1], done.table.equilibrium + c.Z[k - 1], c.roll[k - 1]])
    before, pose = velocities(c)[k - 1] + gravity*fall, pose + velocities(c)[k - 1]*fall + gravity*fall**2/2
    # The normal and its lever from the profiles' points, 0.25 mm apart.
    wheel = turned(left_wheel(pair), pose[2]) + pose[:2]
    apart = gaps(wheel, left_rail(pair))
    nearest = int(apart.argmin())
    assert abs(apart[nearest]) < 2e-6
    tangent, lever = wheel[nearest + 1] - wheel[nearest - 1], wheel[nearest] - pose[:2]
    normal = np.array([-tangent[1], tangent[0]])/np.hypot(*tangent)
    n = np.array([*normal, lever[0]*normal[1] - lever[1]*normal[0]])
    assert n @ before < -0.1
    assert hit.impulses["LF"] == pytest.approx(-(1 + restitution)*(n @ before)/(n @ (n/INERTIA)), rel=0.01)
    if c.N_LF[k]:
        return
    # Exactly: the direction is that of the change of momentum.
    after = velocities(c)[k] - gravity*(c.time[k] - hit.t)
    change = INERTIA*(after - before)
    exact = change/np.hypot(*change[:2])
    mass, u = 1/(exact @ (exact/INERTIA)), exact @ before
    assert exact == pytest.approx(n, abs=0.02)
    assert hit.impulses["LF"] == pytest.approx(-(1 + restitution)*u*mass, rel=1e-8)
    assert hit.impulses["LF"] == pytest.approx(np.hypot(*change[:2]), rel=1e-8)
    assert exact @ after == pytest.approx(-restitution*u, abs=1e-8)
    assert hit.loss == pytest.approx(0.5*(before @ (INERTIA*before) - after @ (INERTIA*after)), abs=1e-6)
    if restitution == 0:        # the projection in the kinetic metric is left; the loss is what is projected out
        assert after == pytest.approx(before - u*mass*exact/INERTIA, abs=1e-8)
        assert hit.loss == pytest.approx(0.5*u**2*mass, rel=1e-6)


def test_zeno_ends_in_contact():
    """A wheelset that drops on both treads with e = 0.5 comes to rest after 3 v/a: impacts in number, then forces."""
    done = run(Case.exercise(1).replace(formulation="unilateral", restitution=0.5, Z=1e-3, vY=0.0, roll_rate=0.0, t_end=0.05,
                                        stop_at="t_end", interval=1e-4))
    a = WEIGHT/MASS
    v = np.sqrt(2*a*1e-3)
    c = done.data
    rest = v/a + 2*0.5*v/a/(1 - 0.5)
    assert (c.N_LT[c.time > rest + 1e-4] > 0).all() and (c.N_LT[c.time < rest - 1e-4] == 0).all()
    assert c.E_lost.iloc[-1] == pytest.approx(0.5*MASS*v**2, rel=1e-6)
    assert done.results["n_impact"] < 60
    assert np.abs(c.roll).max() < 1e-12 and c.N_LT.iloc[-1] == pytest.approx(WEIGHT/2/np.cos(0.025), rel=1e-3)


# A sixth of the motions; `make reference` compares all.
STORED = [(case, formulation) for case, formulation, part in RIGID_CASES if part == "motion"][::6]


@pytest.mark.parametrize(("name", "formulation"), STORED)
def test_motions_are_the_stored_ones(name: str, formulation: str):
    """And keep their energy: bilateral to 1e-11 of the kinetic energy, for the speed is corrected by what a step errs, unilateral
    to 1e-10 over hundreds of impacts, which lose nothing with restitution 1."""
    moved = reference.rigid_moves(name, formulation, "motion")
    assert not moved, "\n".join(moved)
    if name.startswith("ex5") or formulation not in ("bilateral", "unilateral, e = 1"):
        return
    done = reference.rigid_run(name, formulation, "motion")
    energy = done.results["kinetic_energy"]
    assert done.results["drift"] < (1e-11 if formulation == "bilateral" else 1e-10)*energy
    if formulation != "bilateral":
        assert done.results["n_impact"] >= 5 and abs(done.data.E_lost.iloc[-1]) < 1e-10*energy


def test_end_of_the_path_is_told():
    """On a gauge 60 mm wider, to where the other wheel, on the end of its tread, has no rail."""
    case = Case.exercise(4).replace(formulation="bilateral")
    with pytest.raises(Error) as told:
        run(case.replace(gauge=case.gauge + 0.06))
    where = re.search(r"expected a path on which both wheels stay on their rails, found its end at t = \S+ s, "
                      r"Y = (\S+) m", str(told.value))
    assert where, told.value
    # The end of the right tread has come down the gauge corner, which begins 14.3 mm from the gauge face.
    assert 0 < case.back_to_back/2 + 0.135 - float(where[1]) - (case.gauge + 0.06)/2 < 14.3e-3
    assert "\n" not in str(told.value)
