"""The equations of motion and their integration, against exact answers."""
import warnings

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import ldbench
from ldbench import Case, ContactTable
from ldbench.runs import compute
from probes import E_STAR, MASS, ROLLING_RADIUS, TAPER, Pendulum, top
from round_profiles import hertz
from running import kept_tables

# A small, quickly built table for motions near the centre.
NEAR = {"lateral": 0.02, "lift": 0.03, "drop": 2e-3, "table_roll": 0.01, "depth": 1e-3,
        "table_folder": ""}
INTEGRATORS = {"implicit": {"beta": 0.25, "order": 2}, "explicit": {"beta": 0.0, "order": 2}, "fourth": {"beta": 0.0, "order": 4}}
AT_REST = {"vY": 0.0, "roll_rate": 0.0}
POSE, RATES = ["Y", "Z", "roll"], ["vY", "vZ", "roll_rate"]


@pytest.fixture(scope="module")
def actual() -> ContactTable:
    """The contact table of the shipped inputs with the actual profiles."""
    return ContactTable(Case.exercise(2, "aw").replace(table_folder=kept_tables()))


def motion(table: ContactTable, dt: float, t_end: float, every: int = 1, **changes: object) -> pd.DataFrame:
    """Every so many steps of a motion that nothing cuts or stops."""
    steps = round(t_end/dt)
    return compute(table.case.replace(**{
        "dt": dt, "interval": every*dt, "t_end": steps*dt, "stop_at": "t_end", "rows": "interval",
        "energy_tolerance": 0.0, "error_tolerance": 0.0, "tolerance": 1e-13} | changes), table=table).data


@pytest.mark.parametrize("model", ["hertz", "strip", "halfspace"])
def test_impact(model: str):
    """A wheelset without load, falling on both treads at v, penetrates until M (v^2/2 + g d) = 2/5 C d^2.5, and leaves as fast
    after twice the integral of dx/sqrt(v^2 + 2 g x - 4/5 C/M x^2.5) up to d.

    The simplified treads are cones on constant crowns: the two wheels act in parallel along the vertical,
    C = 2 C_H cos(gamma)^2.5.
    """
    C = 2*np.cos(TAPER)**2.5*hertz(np.cos(TAPER)/(2*ROLLING_RADIUS), 0.5/Pendulum.of("sw").rho, 1.0, E_STAR)[3]
    table = ContactTable(Case.exercise(2, "sw").replace(model=model, vertical_load=0.0, **NEAR))
    fall = motion(table, 1e-6, 6e-3, order=4, beta=0.0, **AT_REST, Z=5e-5, vZ=-0.18)
    v = np.sqrt(0.18**2 + 2*9.81*(table.equilibrium + 5e-5 - table.rigid_height))
    deepest = brentq(lambda d: MASS*v**2/2 + MASS*9.81*d - 0.4*C*d**2.5, 1e-5, 1e-2)

    def rate(u: float) -> float:
        """dt/du for x = deepest (1 - u^2)."""
        x = deepest*(1 - u**2)
        return 2*deepest*u/np.sqrt(v**2 + 2*9.81*x - 0.8*C*x**2.5/MASS)

    t, depth = fall.time.to_numpy(), table.rigid_height - table.equilibrium - fall.Z.to_numpy()
    closing, opening = np.flatnonzero(np.diff(np.signbit(depth)))[:2]
    on, off = (t[i] - depth[i]*(t[i + 1] - t[i])/(depth[i + 1] - depth[i]) for i in (closing, opening))
    # The files' six decimals leave the crown's curvature, and C, uncertain by about 1e-4.
    assert top(depth) == pytest.approx(deepest, rel=1e-4)
    assert off - on == pytest.approx(2*quad(rate, 0, 1, epsabs=1e-9)[0], rel=2e-4)
    assert np.interp(off, t, fall.vZ) == pytest.approx(v, rel=1e-5)
    assert fall[["Y", "roll"]].abs().max(axis=None) < 1e-15


def orders(errors: list[float]) -> np.ndarray:
    """From errors at steps halved each time."""
    return np.log2(np.array(errors[:-1])/errors[1:])


def ends_apart(motions: list[pd.DataFrame], reference: pd.DataFrame) -> list[float]:
    """The largest difference of each last pose from that of the reference."""
    return [np.abs(m[POSE].to_numpy()[-1] - reference[POSE].to_numpy()[-1]).max() for m in motions]


@pytest.mark.parametrize("integrator", ["implicit", "explicit", "fourth"])
def test_order_in_contact(integrator: str, actual: ContactTable):
    """Bouncing and rolling on closed contacts, every integrator converges with its order; so does its energy."""
    initial, order = AT_REST | {"Z": 2e-5, "initial_roll": 1e-5}, INTEGRATORS[integrator]["order"]
    # The fourth order errs so little that the shorter steps show rounding alone.
    steps = (4e-4, 2e-4, 1e-4) if order == 4 else (2e-4, 1e-4, 5e-5)
    reference = motion(actual, 5e-6, 8e-3, 16, **INTEGRATORS["fourth"], **initial)
    found = [motion(actual, dt, 8e-3, round(steps[0]/dt), **INTEGRATORS[integrator], **initial) for dt in steps]
    assert orders(ends_apart(found, reference)) == pytest.approx([order, order], abs=0.1)
    # The third derivatives of the table's splines jump at its points, which scatters single motions: five are taken, at the
    # instants that all steps have.
    more = [[motion(actual, dt, 8e-3, round(steps[0]/dt), **INTEGRATORS[integrator], **initial | {"Z": Z}) for dt in steps]
            for Z in (1.6e-5, 1.8e-5, 2.2e-5, 2.4e-5)]
    falls = np.mean([orders([np.linalg.norm(m.E_drift) for m in motions]) for motions in (found, *more)], axis=0)
    assert np.mean(falls) == pytest.approx(order, abs=0.1)
    assert falls == pytest.approx([order, order], abs=0.3)


def cut_run(table: ContactTable, **changes: object) -> ldbench.Run:
    """Exercise 2 through both flange impacts and 25 landings."""
    case = Case.exercise(2, "aw").replace(**{"stop_at": "t_end", "t_end": 0.12} | changes)
    return ldbench.run(case, table=table)


def last_pose(run: ldbench.Run) -> np.ndarray:
    return run.data[POSE].to_numpy()[-1]


def test_the_error_of_a_step_is_seen_where_the_energy_is_kept(actual: ContactTable):
    """Ten times the shipped step with the shipped tolerance of the energy alone errs by more than 1e-8 m; the tolerance of the
    error makes that go down with it, to the shipped error for fewer forces than the shipped step takes."""
    exact = last_pose(cut_run(actual, dt=5e-6, energy_tolerance=1e-11))
    shipped = cut_run(actual)
    long = {tolerance: cut_run(actual, dt=1e-3, interval=1e-3, error_tolerance=tolerance) for tolerance in (0.0, 1e-9, 1e-12)}
    error = {tolerance: np.abs(last_pose(run) - exact).max() for tolerance, run in long.items()}
    assert error[0.0] > 1e-8 > 1e-9 > error[1e-12]
    assert error[1e-12] < error[1e-9]/10 and error[1e-9] < error[0.0]
    assert long[1e-12].results["evaluations"] < shipped.results["evaluations"]


def test_tolerance_bounds_the_drift(actual: ContactTable):
    """No step changes the energy by more than the tolerance, and steps are no shorter than that takes: one of them comes near."""
    for tolerance in 1e-5, 1e-7:
        run = cut_run(actual, dt=1e-5, interval=1e-5, rows="interval", energy_tolerance=tolerance, error_tolerance=0.0, t_end=0.03)
        change = np.abs(np.diff(run.data.E_drift)).max()
        assert 0.1*tolerance < change < 2*tolerance, change
    assert cut_run(actual, energy_tolerance=0, error_tolerance=0).results["drift"] > 1e-3


def test_below_rounding_nothing_is_cut(actual: ContactTable):
    """A tolerance that rounding of the pose exceeds is none: the wheelset on its treads makes whole steps."""
    calm = {"vY": 0.01, "roll_link": "rails", "t_end": 0.02, "stop_at": "t_end", "energy_tolerance": 1e-16, "dt": 2e-5}
    run = ldbench.run(Case.exercise(2, "aw").replace(**calm), table=actual)
    assert run.results["drift"] < 1e-8
    assert run.results["steps"] <= 1100
    falling = ldbench.run(run.case.replace(Z=0.02, vY=0.0, t_end=0.01), table=actual)      # no contact, only weight
    assert falling.data[["N_LT", "N_RT"]].to_numpy().max() == 0
    assert falling.results["steps"] <= 550


@pytest.mark.parametrize(("scheme", "limit"), [({"order": 2}, 2), ({"order": 4}, 5.027),
                                               ({"order": 2, "beta": 0.2}, 20**0.5)])
def test_steps_beyond_the_limit_of_stability_are_told(scheme: dict, limit: float, actual: ContactTable):
    """A small oscillation stays small up to the limit and grows beyond it; only then the run warns, in Python too."""
    case = Case.exercise(1, "aw").replace(**{
        "vY": 0.0, "roll_rate": 0.0, "initial_roll": 1e-9, "beta": 0.0, "energy_tolerance": 0.0, "error_tolerance": 0.0,
        "rows": "interval", "stop_at": "t_end"} | scheme)
    for share, told in (0.98, 0), (1.02, 1):
        dt = share*limit/(2*np.pi*max(actual.frequencies))
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            done = ldbench.run(case.replace(dt=dt, interval=dt, t_end=60*dt), table=actual)
        assert (done.data.roll.abs().max() > 3e-9) == bool(told)
        assert sum("limit of stability" in str(one.message) for one in found) == told and (told or not found)
        assert done.text.count("warning: &integrator dt: expected steps of at most") == told


def test_a_drift_that_makes_a_run_doubtful_is_told(actual: ContactTable):
    """1 % of the largest kinetic energy; the column file says it, too."""
    case = Case.exercise(2, "aw").replace(beta=0.25, order=2, energy_tolerance=0.0, error_tolerance=0.0, rows="interval")
    for dt, doubtful in (1e-4, False), (2e-3, True):
        done = compute(case.replace(dt=dt, interval=2e-3), table=actual)
        most = (0.5*MASS*(done.data.vY**2 + done.data.vZ**2)).max()
        assert (done.results["drift"] > 0.01*most) == doubtful
        assert [words.startswith("expected an energy drift of at most 1 %") for words in done.warnings] == [True]*doubtful


def test_work_of_the_ramp(actual: ContactTable):
    """The work counted for a growing lateral force is what the total energy grows by."""
    pushed = Case.exercise(5, "aw").replace(t_end=0.02, interval=4e-4, dt=1e-4, Z=3e-5, energy_tolerance=0, error_tolerance=0,
                                            lateral_ramp=2e6, judged="no", pressures="no")
    done = ldbench.run(pushed, table=actual)
    assert done.data.W_ext.iloc[-1] > 50 and done.results["drift"] < 1e-7


def test_peak_at_the_start(actual: ContactTable):
    """A force that only falls is largest at t = 0: the wheels of exercise 2 let go 0.05 mm deeper than they stand."""
    run = cut_run(actual, t_end=5e-4, interval=1e-4, Z=-5e-5, vY=0.0, roll_rate=0.0)
    assert run.results["peak_N_LT"] == pytest.approx(run.data.N_LT.iloc[0], rel=1e-12)
    assert run.results["t_peak_LT"] == 0 and run.results["peak_N_LT"] > 1.2e5


def backwards(case: Case, end: pd.Series) -> Case:
    """The case that begins where a motion ended, with all velocities reversed."""
    return case.replace(Y=end.Y, Z=end.Z, initial_roll=end.roll, **{name: -end[name] for name in RATES})


@pytest.mark.parametrize("integrator", [*INTEGRATORS, "cut"])
def test_time_reversal(integrator: str, actual: ContactTable):
    """Reversed after the left flange impact of exercise 2, the wheelset returns to its start; what cuts a step cuts the reversed
    one."""
    case = Case.exercise(2, "aw").replace(stop_at="t_end", t_end=0.03)
    cut = integrator == "cut"
    if not cut:
        case = case.replace(**INTEGRATORS[integrator], dt=5e-6, interval=5e-4, energy_tolerance=0.0, error_tolerance=0.0,
                            tolerance=1e-13)
    forth = ldbench.run(case, table=actual)
    start, end = forth.data.iloc[0], forth.data.iloc[-1]
    assert end.vY < -0.2                        # thrown back by the flange
    back = ldbench.run(backwards(case, end), table=actual)
    home, far = back.data.iloc[-1], 1 if cut else 0.1
    assert home[POSE].to_numpy() == pytest.approx(start[POSE].to_numpy(), abs=1e-10*far)
    assert -home[RATES].to_numpy() == pytest.approx(start[RATES].to_numpy(), abs=1e-7 if cut else 1e-9)
    assert back.results["cuts"] == pytest.approx(forth.results["cuts"], rel=0.02)
    assert (forth.results["cuts"] > 80) == cut


def test_an_error_after_a_derailment_ends_the_run_as_one():
    """A derailed wheelset lands so hard that Newton's method does not solve the step: that is no end of a run."""
    case = Case.exercise(2).replace(
        Y=0.0403, Z=0.0256, vY=1.22, roll_rate=0.0, order=2, beta=0.25, max_iterations=4, max_halvings=0, dt=1e-3, interval=1e-3,
        error_tolerance=0.0, energy_tolerance=0.0, stop_at="t_end", t_end=0.3, judged="no", pressures="no",
        table_folder=kept_tables())
    with pytest.raises(ldbench.Error, match=r"&integrator dt = .* expected Newton's method .* at t = ([0-9.]+) s") as stopped:
        ldbench.run(case)
    assert ldbench.run(case.replace(t_end=0.018)).results["n_derailment"] == 1
    assert "at t = 0.02" in str(stopped.value)
    # It has not derailed where a force draws it back.
    assert ldbench.run(case.replace(t_end=0.018, lateral_force=-100.0)).results["n_derailment"] == 0


def test_steps_that_miss_their_tolerance_for_ever_end_with_a_line(actual: ContactTable):
    case = Case.exercise(2, "aw").replace(error_tolerance=1e-40, judged="no", pressures="no")
    with pytest.raises(ldbench.Error, match=r"expected steps that keep to their tolerances in at most 100000 parts, "
                       r"found one at t = \S+ s that needs more"):
        ldbench.run(case, table=actual)


def test_the_last_interval_may_be_shorter(actual: ContactTable):
    """The run ends at t_end, in the pose that it has there with other rows."""
    case = Case.exercise(2, "aw").replace(t_end=2.35e-3, stop_at="t_end", rows="interval", energy_tolerance=0, error_tolerance=0)
    ends = [ldbench.run(case.replace(interval=interval, dt=5e-5), table=actual).data.iloc[-1] for interval in (1e-3, 5e-5)]
    assert [end.time for end in ends] == [2.35e-3]*2
    assert ends[0][POSE + RATES].to_numpy() == pytest.approx(ends[1][POSE + RATES].to_numpy(), rel=1e-6, abs=1e-12)
