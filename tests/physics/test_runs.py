"""The ten shipped runs: what must happen in them, their energy, and what their columns say of each other."""
import re

import numpy as np
import pytest

import ldbench
from ldbench import Case
from ldbench.constants import CONTACTS
from probes import (
    GAUGE,
    MASS,
    PITCH_INERTIA,
    ROLL_INERTIA,
    WEIGHT,
    gaps,
    left_rail,
    left_wheel,
    poses,
    rest_height,
    turned,
)
from running import PAIRS, REPO, Columns, Run, kept_tables, on_grid, read_interval

FLANGE_ANGLE = np.radians(25)
DIGITS = 1e-8      # two units in the last of the files' nine digits


CASES = "ex1_sw", "ex2_aw", "ex4_aw", "ex4_sw", "ex5_aw", "ex5_sw"      # exercise 3 is between 2 and 4


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def run(case: str, shipped: dict[str, Run]) -> Run:
    return shipped[case]


def close(a: np.ndarray, b: np.ndarray | float, rel: float = 0, within: float | np.ndarray = 0) -> bool:
    """All of a are b, to a relative or an absolute tolerance."""
    return bool((np.abs(a - b) <= np.maximum(rel*np.abs(b), within)).all())


def total(c: Columns, name: str) -> np.ndarray:
    return sum(c[f"{name}_{contact}"] for contact in CONTACTS)


def first_event(run: Run, kind: str) -> float:
    return float(re.search(rf"t = (\S+) s  {kind}", run.summary)[1])


def ending(run: Run) -> str:
    return re.search(r"ended at t = \S+ s: (.*)", run.summary)[1]


@pytest.mark.parametrize("name", ["ex1_sw", "ex2_aw", "ex3_aw", "ex3_sw"])
def test_left_right_return(name: str, shipped: dict[str, Run]):
    """Exercises 1-3: left flange, right flange, then back through the centre; no sooner, no later."""
    run = shipped[name]
    c, interval = on_grid(run).columns, read_interval(run.header)
    left, right = (c["time"][np.flatnonzero(c[f"angle_{flange}"] >= FLANGE_ANGLE)[0]] for flange in ("LF", "RF"))
    assert left < right < c["time"][-1]
    assert first_event(run, "left flange contact") == pytest.approx(left, abs=interval)
    assert first_event(run, "right flange contact") == pytest.approx(right, abs=interval)
    assert ending(run) == "return to the centre after both flanges"
    crossed = np.diff(np.signbit(c["Y"][c["time"] > right]))
    assert crossed[-1] and crossed.sum() == 1


@pytest.mark.parametrize("name", ["ex1_sw", "ex3_aw", "ex3_sw", "ex4_aw"])
def test_a_flange_contact_is_on_the_flange(name: str, shipped: dict[str, Run]):
    """The flange's contact counts once while it stays closed, if its contact angle reaches 25 degrees or the wheelset is past
    the clearance. Every event says the angle."""
    run = shipped[name]
    c = run.columns
    for flange, side, sign in ("LF", "left", 1), ("RF", "right", -1):
        clearance = float(re.search(rf"clearance_{side} = (\S+)", run.header)[1])
        closed = np.flatnonzero(c[f"N_{flange}"] > 0)
        stretches = np.split(closed, np.flatnonzero(np.diff(closed) > 1) + 1)
        reaching = [k for k in stretches if (c[f"angle_{flange}"][k] >= FLANGE_ANGLE).any()
                    or (sign*c["Y"][k] > clearance).any()]
        told = re.findall(rf"t = (\S+) s  {side} flange contact at (\S+) degrees", run.summary)
        assert len(reaching) == len(told) == int(re.search(rf"n_{side}_flange_contact = (\d+)", run.header)[1])
        for k, (t, angle) in zip(reaching, told, strict=True):
            assert c["time"][k[0]] - 1.1e-4 < float(t) <= c["time"][k[-1]]
            first = k[np.argmax(c["time"][k] > float(t))]
            assert float(angle) == pytest.approx(np.degrees(c[f"angle_{flange}"][first]), abs=1.5)
        assert len(stretches) == len(reaching)        # no contact at a smaller angle has the flange's name


def test_peaks_are_those_of_the_rows(run: Run):
    """The program writes a row at the largest force of each contact."""
    for contact in CONTACTS:
        k = int(run.columns[f"N_{contact}"].argmax())
        peak, t = (float(re.search(rf" {name}_{contact} = (\S+)", run.header)[1]) for name in ("peak_N", "t_peak"))
        assert peak == pytest.approx(run.columns[f"N_{contact}"][k], rel=1e-8)
        assert t == pytest.approx(run.columns["time"][k] if peak else 0.0, rel=1e-8)
        if contact in ("LF", "RF"):
            closed = run.columns[f"N_{contact}"] > 0
            begin = int(closed.argmax())
            first = run.columns[f"N_{contact}"][begin:begin + int((~np.append(closed[begin:], False)).argmax())].max(initial=0)
            told = re.search(rf"first_peak_N_{contact} = (\S+)", run.header)
            assert (told is None) == (first == 0)
            assert first == 0 or float(told[1]) == pytest.approx(first, rel=1e-8), "a first contact opens where a row stands"


@pytest.mark.parametrize("pair", PAIRS)
def test_exercise_4(pair: str, shipped: dict[str, Run]):
    """Exercise 4 strikes both flanges and returns; the actual pair's flange goes over the right rail's corner and comes back. What
    throws the wheelset back is the impulse of the lateral forces."""
    run = shipped[f"ex4_{pair}"]
    assert first_event(run, "left flange contact") < first_event(run, "right flange contact")
    c = run.columns
    back = int(c["vY"].argmin())
    impulse = np.trapezoid(total(c, "Fy")[:back + 1], c["time"][:back + 1])
    assert impulse == pytest.approx(MASS*(c["vY"][back] - c["vY"][0]), rel=1e-3)
    assert ending(run) == "return to the centre after both flanges"
    assert abs(run.columns["Y"][-2]) < 1e-12 or run.columns["Y"][-2]*run.columns["Y"][-1] <= 0
    assert ("right flange over rail" in re.findall(r"t = \S+ s  (.*)", run.summary)) == (pair == "aw")
    assert "derailment" not in run.summary and "n_derailment = 0" in run.header


@pytest.mark.parametrize("pair", PAIRS)
def test_exercise_5_derails(pair: str, shipped: dict[str, Run]):
    """Exercise 5 overturns about the left rail. The ramp is so steep that the force passes the one that unloads the right wheel at
    rest, W b/h, while the wheelset still turns."""
    run = shipped[f"ex5_{pair}"]
    c = run.columns
    assert ending(run) == "derailment"
    assert c["F_ext"][-1] > WEIGHT*c["y_LT"][0]/rest_height(run) > float(re.search(r"F_limit_left = (\S+)", run.header)[1])
    # Once the right wheel is unloaded, moments about the left flange's contact tell the lateral force.
    unloaded = float(re.search(r"t_unloaded = (\S+)", run.header)[1])
    alone = (c["time"] >= unloaded*(1 - DIGITS)) & (c["N_LF"] > 0) & (c["N_LT"] + c["N_RT"] + c["N_RF"] == 0)
    aside, above = c["y_LF"] - c["Y"], rest_height(run) + c["Z"] - c["z_LF"]
    force = (aside*(WEIGHT + MASS*c["aZ"]) + above*MASS*c["aY"] - ROLL_INERTIA*c["roll_acc"])/above
    assert alone.sum() > 50 and close(force[alone], c["F_ext"][alone], rel=1e-6)
    # The left flange's lowest point has just passed the highest point of its rail.
    wheel = left_wheel(pair)
    tip = wheel[wheel[:, 1].argmin()]
    rail = 1e-3*np.loadtxt(REPO/f"profiles/{pair[0]}rprof.yz")
    crown = GAUGE/2 + rail[rail[:, 1].argmax(), 0]
    tips = np.array([turned(tip[None], roll)[0] + (y, z) for y, z, roll in poses(run)[-100:]])
    over, at = tips[-10:, 0] - crown, c["time"][-10:] - first_event(run, "derailment")
    # The points tell the crown to half their distance. In the row at the event the tip is there.
    near = 1.25e-4
    assert (over[at < -1e-6] < near).all() and (over[at > 1e-6] > -near).all() and over[0] < -near
    assert abs(over[np.abs(at).argmin()]) < near
    # Before, it has passed the gauge face above the shoulder of the rail's head, 3 mm below its top. Rows are 1 ms apart there.
    past = np.minimum(tips[:, 0] - GAUGE/2, tips[:, 1] + 3e-3)
    k = int(np.flatnonzero((past[:-1] <= 0) & (past[1:] > 0))[0])
    passed = np.interp(0.0, past[k:k + 2], c["time"][-100:][k:k + 2])
    assert first_event(run, "left flange over rail") == pytest.approx(passed, abs=1e-4)


def test_energy(case: str, run: Run):
    """The parts are those of the motion, they sum to E_total, and E_drift is what the work leaves unexplained: at most 1e-8 of the
    initial kinetic energy, in exercise 5 1e-7 of the ramp's work."""
    c = run.columns
    kinetic = {"KE_long": MASS*c["vX"]**2, "KE_lat": MASS*c["vY"]**2, "KE_vert": MASS*c["vZ"]**2,
               "KE_roll": ROLL_INERTIA*c["roll_rate"]**2, "KE_pitch": PITCH_INERTIA*c["pitch_rate"]**2}
    for name, twice in kinetic.items():
        assert close(c[name], twice/2, rel=3*DIGITS, within=1e-90)
    assert close(c["PE_grav"], MASS*9.81*c["Z"], rel=3*DIGITS)
    assert close(c["PE_load"], 164618*c["Z"], rel=3*DIGITS)
    parts = [name for name in c if name.startswith(("KE_", "PE_"))]
    assert len(parts) == 9
    size = sum(np.abs(c[name]) for name in parts)
    assert close(sum(c[name] for name in parts), c["E_total"], within=DIGITS*size)
    drift = c["E_total"] - c["W_ext"] - c["E_total"][0]
    assert close(drift, c["E_drift"], within=DIGITS*(size + np.abs(c["W_ext"])))
    bar = 1e-7*c["W_ext"][-1] if case.startswith("ex5") else 1e-8*(c["KE_lat"] + c["KE_vert"] + c["KE_roll"])[0]
    largest = float(re.search(r" drift = (\S+)", run.header)[1])
    assert np.abs(c["E_drift"]).max() <= largest*(1 + 1e-6) and largest < bar


def test_work_is_force_times_way(run: Run):
    """W_ext is the integral of the ramp over the lateral way."""
    c = run.columns
    work = np.concatenate([[0], np.cumsum((c["F_ext"][1:] + c["F_ext"][:-1])/2*np.diff(c["Y"]))])
    # The trapezoidal rule over rows errs by dF dY/12 in each.
    bound = np.sum(np.abs(np.diff(c["F_ext"])*np.diff(c["Y"])))/12
    assert close(c["W_ext"], work, within=bound + DIGITS*np.abs(work).max())


def test_newton_and_euler(run: Run):
    """m a = forces, I roll_acc = moments of the contact forces about the centre, through the contact points."""
    c = run.columns
    # Half a unit of nine digits of every force and of mass times acceleration.
    size = DIGITS/2*(sum(np.abs(c[f"N_{k}"]) for k in CONTACTS) + MASS*np.hypot(c["aY"], c["aZ"]) + WEIGHT)
    assert close(MASS*c["aY"], total(c, "Fy") + c["F_ext"], within=size)
    assert close(MASS*c["aZ"], total(c, "Fz") - WEIGHT, within=size)
    moment = 0
    for k in CONTACTS:
        arm_y, arm_z = c[f"y_{k}"] - c["Y"], c[f"z_{k}"] - (rest_height(run) + c["Z"])
        moment = moment + np.nan_to_num(arm_y*c[f"Fz_{k}"] - arm_z*c[f"Fy_{k}"])
    # Levers below 1 m, of nine digits.
    assert close(ROLL_INERTIA*c["roll_acc"], moment, within=2*size)


@pytest.mark.parametrize("case", ["ex2_aw", "ex4_sw"])
def test_derivatives(case: str, shipped: dict[str, Run]):
    """Velocity and acceleration are the derivatives of position, in rows that resolve every impact."""
    c = shipped[case].columns
    h = np.diff(c["time"])
    for x, v, a in (("Y", "vY", "aY"), ("Z", "vZ", "aZ"), ("roll", "roll_rate", "roll_acc")):
        # What nine digits of times and positions leave open.
        rounded = 2*DIGITS*(np.abs(c[x]).max() + (c["time"]*np.abs(c[v]))[1:])
        # Hermite's rule: exact for polynomials of fifth order from row to row.
        way = h*(c[v][1:] + c[v][:-1])/2 - h**2*np.diff(c[a])/12
        assert close(np.diff(c[x]), way, within=0.1*h**2*np.abs(np.diff(c[a])) + h**2 + rounded), x


def test_uniform_motions(run: Run):
    """X and pitch advance uniformly; the yaw constraint carries the gyroscopic moment Ip Omega roll_rate."""
    c = run.columns
    assert close(c["X"], c["time"], rel=DIGITS) and close(c["pitch"], 2.19*c["time"], rel=DIGITS)
    assert (c["vX"] == 1).all() and (c["pitch_rate"] == 2.19).all()
    assert close(c["M_gyro"], PITCH_INERTIA*2.19*c["roll_rate"], rel=DIGITS, within=1e-90)


def test_contact_forces(run: Run):
    """N is the magnitude and the contact angle the direction of the force; open contacts have neither."""
    c = run.columns
    for side in "LR":
        assert ((c[f"N_{side}T"] + c[f"N_{side}F"] > 0) == (c[f"PE_elastic_{side}"] > 0)).all()
    for k in CONTACTS:
        side = 1 if k[0] == "L" else -1
        closed = c[f"N_{k}"] > 0
        assert close(c[f"N_{k}"], np.hypot(c[f"Fy_{k}"], c[f"Fz_{k}"]), rel=DIGITS)
        direction = np.arctan2(-side*c[f"Fy_{k}"], c[f"Fz_{k}"])
        assert close(c[f"angle_{k}"][closed], direction[closed], within=2*DIGITS)
        for name in "angle", "y", "z", "radius":
            assert (np.isnan(c[f"{name}_{k}"]) == ~closed).all()


def test_contact_points(case: str, run: Run):
    """Contact points lie on the wheel's profile and inside the rail, no deeper than the wheel penetrates."""
    c = run.columns
    wheel, rail = left_wheel(case[-2:]), left_rail(case[-2:])
    for k in CONTACTS:
        rows = np.flatnonzero(c[f"N_{k}"])
        rows = rows[::max(1, len(rows)//600)]
        if len(rows) == 0:
            continue
        side = 1 if k[0] == "L" else -1
        point = np.column_stack([side*c[f"y_{k}"], c[f"z_{k}"]])[rows]
        centre = np.column_stack([side*c["Y"], rest_height(run) + c["Z"]])[rows]
        own = turned(point - centre, -side*c["roll"][rows])
        # Chords of 0.25 mm on radii from 10 mm deviate by up to 0.8 um.
        assert np.abs(gaps(own, wheel)).max() < 1e-6
        assert close(c[f"radius_{k}"][rows], -own[:, 1], within=2e-9)
        if k[1] == "T" and not case.startswith(("ex4", "ex5")):
            assert close(c[f"radius_{k}"][rows], 0.457, within=0.6e-3)
        inside = -gaps(point, rail)
        if k[1] == "T":
            assert inside.min() > -1e-6
        else:
            # The resultant of two patches, on throat and face, passes between them.
            assert inside.min() > -0.1e-3
            assert (inside < -2e-6).sum() <= 1 + 0.01*len(rows)
        for i in range(0, len(rows), max(1, len(rows)//10)):
            placed = turned(wheel, side*c["roll"][rows[i]]) + centre[i]
            near = placed[np.hypot(*(placed - point[i]).T) < 15e-3]
            assert inside[i] < -gaps(near, rail).min() + 2e-6


def test_derailed_between_rows():
    """A wheelset that derails and then leaves the table, all before the next row, has derailed."""
    done = ldbench.run(Case.exercise(5).replace(interval=5.0, rows="interval", lateral_force=4e5, model="hertz", judged="no",
                                                table_folder=kept_tables()))
    assert done.ending == "derailment" and len(done.data) == 1
