"""Fingerprints of imaginary codes: planted laws of contact, steps and tables are found, and nothing else is."""
from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import imaginary_codes as imaginary
import imaginary_physics as physics
import ldbench
import ldbench_round.fingerprint as fingerprints
from imaginary_physics import Physics
from ldbench import Case
from ldbench.__main__ import main
from ldbench.results.contact_intervals import ContactInterval
from ldbench.results.events import FLANGE_ANGLE
from ldbench.results.header import Header
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData
from ldbench_round import own_runs
from ldbench_round.blows import Blow
from ldbench_round.estimate import Estimate, combined, untold
from ldbench_round.fingerprint import ELASTIC, RIGID, UNKNOWN, Fingerprint, fingerprint, plus_minus
from ldbench_round.lattice import Bends, bends, digit_noise, find_lattice
from ldbench_round.physics_checks import LEAST_FORCE
from ldbench_round.stiffness import BY_DEPTH, BY_RATE, NONE, fit_law
from ldbench_round.tasks import TASKS, Task
from running import Run

AW, SW = Task(2, "aw"), Task(2, "sw")
pytestmark = pytest.mark.usefixtures("known_hertz")
FIRST = 0.05            # to after the first blow of the left flange [s]


class Frame:
    """Columns in memory as the source of a run."""

    file, header = Path("other_code.csv"), Header()

    def __init__(self, frame: pd.DataFrame) -> None:
        self.frame = frame

    def columns(self) -> pd.DataFrame:
        return self.frame


def of(frame: pd.DataFrame, task: Task = AW) -> Fingerprint:
    return fingerprint(RunData(Frame(frame)), task)


def rounded(frame: pd.DataFrame, digits: int) -> pd.DataFrame:
    """The table as a code prints it that gives few digits, but for the time."""
    found = frame.map(lambda x: float(f"{x:.{digits}g}")).assign(time=frame["time"])
    found.attrs = frame.attrs
    return found


# ---- planted laws of contact ---------------------------------------------------------
@pytest.mark.parametrize(("task", "laws"), [
    (AW, Physics()), (SW, Physics(k=6e10)), (AW, Physics(k=1e9, n=1.0)), (SW, Physics(k=8e9, n=1.25)),
    (AW, Physics(hunt_crossley=0.1)), (AW, Physics(kelvin_voigt=3e4))], ids=str)
def test_the_law_of_contact_is_found(task: Task, laws: Physics):
    """Exponent, force and damping are those planted, within uncertainties of some percent."""
    found = of(physics.simulate(task, laws, FIRST), task)
    assert found.kind == ELASTIC
    assert found.exponent.holds(laws.n) and found.exponent.uncertainty < 0.02, found.exponent
    assert found.force.holds(laws.k*found.approach**laws.n) and found.force.uncertainty < 0.03*found.force.value, found.force
    if laws.hunt_crossley:
        assert found.damping_kind == BY_DEPTH
        assert found.damping.holds(laws.hunt_crossley) and found.damping.uncertainty < 0.05*laws.hunt_crossley
    elif laws.kelvin_voigt:
        assert found.damping_kind == BY_RATE
        assert found.damping.holds(laws.kelvin_voigt) and found.damping.uncertainty < 0.05*laws.kelvin_voigt
    else:
        assert found.damping_kind == NONE and found.damping.holds(0.0)
        assert found.closing.holds(laws.n) and found.opening.holds(laws.n)
        assert found.loss.holds(0.0) and found.restitution.holds(1.0) and found.loss.uncertainty < 0.01
    assert not found.step.known and not found.pitch.known


def test_the_loss_of_damped_contact_is_that_of_the_motion():
    """The loop of the rows is that of rows four times as dense; for weak damping it is 4/3 χ v, v being the closing velocity."""
    laws = Physics(hunt_crossley=0.1)
    frame = physics.simulate(AW, laws, FIRST)
    dense = physics.simulate(AW, Physics(hunt_crossley=0.1, step=2.5e-5, every=1), FIRST)
    loss = of(frame).loss
    assert loss.holds(physics.loss_of(dense)) and loss.uncertainty < 0.01
    closing = 0.367         # m/s, of exercise 2
    assert loss.value == pytest.approx(4/3*0.1*closing, rel=0.06)


def motion_uncertainty(ratio: float) -> float:
    """The uncertainty of a force over Hertz's that a blow has for the motion alone, as the table of docs/benchmark.md defines it:
    2 % of it, and 2 % more for each factor of 2."""
    return 0.02*ratio*(1 + abs(np.log2(ratio)))


@pytest.mark.parametrize("scale", [0.5, 0.8, 1.2])
def test_softer_and_stiffer_steel_has_less_and_more_of_the_force_of_hertz(scale: float):
    """Hertz's law of ours with another modulus has that share of the force, in rows every 0.1 ms.

    Limit of the uncertainty: the forces are proportional, so the fit adds nothing to the uncertainty u of a blow by its motion.
    Where every blow keeps what it says, n blows lie within u of the truth, their standard deviation about their mean is u at
    most, and sqrt(n/(n - 1)) of it, 1.41 for two blows, is added in squares: sqrt(1 + 2) u.
    """
    case = Case.exercise(2, "sw").replace(model="hertz", stiffness_scale=scale, table_file="", n_lateral=120, n_roll=15, n_depth=15,
                                          t_end=0.06, stop_at="t_end")
    found = of(imaginary.table_of(ldbench.run(case), 1e-4), SW).hertz
    assert found.holds(scale)
    assert 0.99*motion_uncertainty(found.value) < found.uncertainty < np.sqrt(3)*motion_uncertainty(found.value)


def test_a_stiffer_contact_has_more_of_the_force_of_hertz():
    """The ratio to Hertz's law grows as the planted stiffness does. A stiffer blow is elsewhere on the flange, where Hertz's law,
    unlike the planted one, has another stiffness: this is most of the uncertainty.

    Limit of the uncertainty: least squares for a ratio and a shift leave no more than those for a ratio alone in the same poses,
    a share m of the peak. A blow gives one independent residual at least. Then the ratio has a standard deviation of m of it over
    sqrt(<a²>(1 - c²)), where a is Hertz's force over the peak and c is the cosine between a and its rate with the shift. Two of
    these deviations, and what the motion adds, are the limit.
    """
    found = []
    for k in (9e10, 1.35e11):
        frame = physics.simulate(AW, Physics(k=k), FIRST)
        run = RunData(Frame(frame))
        one = of(frame).hertz
        (ratio, misfit, a, rate), *more = ratios_to_hertz(run, AW)
        assert not more
        cosine = (a @ rate)/np.sqrt((a @ a)*(rate @ rate))
        fitted = 2*misfit*ratio/np.sqrt(np.mean(a**2)*(1 - cosine**2))
        assert motion_uncertainty(one.value) < one.uncertainty < np.hypot(fitted, motion_uncertainty(one.value))
        assert abs(one.value - ratio) < np.hypot(one.uncertainty, fitted)
        found.append(one)
    soft, stiff = found
    quotient = stiff.value/soft.value
    assert abs(quotient - 1.5) < quotient*np.hypot(soft.uncertainty/soft.value, stiff.uncertainty/stiff.value)


def ratios_to_hertz(run: RunData, task: Task) -> Iterator[tuple[float, float, np.ndarray, np.ndarray]]:
    """Four facts of each blow: the force over that of our table of Hertz's law in the same poses, what this leaves as a share of
    the peak, and Hertz's force over its part of the peak with the rate of that with a shift along the normal [1/m]. No approach,
    shift or law is fitted. In our own runs the tread's load lowers the surface of the flange, so that Hertz's force is that of
    poses which are less deep by it."""
    table = fingerprints.hertz_table(task.profiles)
    steel = 2.1e11/(2*(1 - 0.3**2))

    def lowered(rows: np.ndarray, contact: str) -> np.ndarray:
        tread = contact[0] + "T"
        if not run.header.settings:          # of another code, which presses them apart
            return np.zeros(rows.sum())
        y, z, angle = (run.values(f"{name}_{contact}")[rows] - run.values(f"{name}_{tread}")[rows] for name in ("y", "z", "angle"))
        return np.nan_to_num(run.values(f"N_{tread}")[rows]*np.cos(angle)/(np.pi*steel*np.hypot(y, z)))

    def hertz_force(rows: np.ndarray, contact: str, moved: float) -> np.ndarray:
        """Hertz's force in the poses of some rows that are moved along the normal."""
        angle, outward = run.values(f"angle_{contact}")[rows], 1 if contact[0] == "L" else -1
        moved = moved - lowered(rows, contact)
        pose = (run.values("Y")[rows] + moved*outward*np.sin(angle),
                run.values("Z")[rows] + table.equilibrium - moved*np.cos(angle), run.values("roll")[rows])
        return np.hypot(*table.forces_by_contact(*pose)[:, CONTACTS.index(contact), :2].T)

    for one in run.impacts(("LF", "RF")):
        rows = (run.time > one.start) & (run.time < one.end)
        force = run.values(f"N_{one.contact}")[rows]
        if rows.sum() < 8 or force.max() < LEAST_FORCE or abs(one.angle) < FLANGE_ANGLE:
            continue
        hertz, more, less = (hertz_force(rows, one.contact, moved) for moved in (0.0, 1e-7, -1e-7))
        ratio = float((force @ hertz)/(hertz @ hertz))
        yield (ratio, float(np.sqrt(np.mean((force - ratio*hertz)**2))/force.max()), ratio*hertz/force.max(),
               ratio*(more - less)/2e-7/force.max())


def force_over_hertz(run: RunData, task: Task) -> float:
    """The median of those ratios, of the first blows in which one force is a multiple of the other within 3 % of the peak."""
    return float(np.median(list(islice((ratio for ratio, misfit, *_ in ratios_to_hertz(run, task) if misfit < 0.03), 4))))


# ---- planted steps and tables --------------------------------------------------------
@pytest.mark.parametrize("scheme", ["newmark", "symplectic Euler"])
def test_the_step_of_a_code_that_writes_every_step(scheme: str):
    """Velocities that are half a step late do not look like damping."""
    found = of(physics.simulate(AW, Physics(step=1e-4, every=1, scheme=scheme), FIRST))
    assert found.step.holds(1e-4) and found.step.uncertainty < 1e-6
    assert ("Newmark" if scheme == "newmark" else "Euler") in found.step.why
    assert found.exponent.holds(1.5) and found.loss.holds(0.0) and found.damping_kind == NONE


@pytest.mark.parametrize("step", [5e-4, 1e-3])
def test_the_step_of_a_code_whose_rows_are_interpolated(step: float):
    """Steps of 1 ms in rows of 0.1 ms: the rows between steps tell nothing of the contact law."""
    run = RunData(Frame(physics.simulate(AW, Physics(step=step, every=1), 0.12)))
    found = of(imaginary.table_of(run, 1e-4))
    assert found.step.holds(step) and found.step.uncertainty < 0.01*step and "interpolated" in found.step.why
    assert not found.exponent.known and not found.pitch.known and not found.loss.known


@pytest.mark.parametrize("laws", [Physics(pitch=5e-4), Physics(pitch=5e-4, stepwise=True)], ids=["linear", "stepwise"])
def test_the_pitch_of_a_table_is_found(laws: Physics):
    found = of(physics.simulate(AW, laws, 0.08))
    assert found.pitch.holds(laws.pitch) and found.pitch.uncertainty < 0.02*laws.pitch, found.pitch
    assert not found.step.known


def test_rows_that_are_too_far_apart_are_said_to_be():
    found = of(physics.simulate(AW, Physics(every=20), FIRST))
    for number in (found.exponent, found.force, found.hertz, found.loss, found.damping):
        assert not number.known and "no blow" in number.why


# ---- rigid codes ---------------------------------------------------------------------
@pytest.mark.parametrize(("task", "restitution"), [(AW, 1.0), (AW, 0.5), (SW, 0.8), (SW, 0.0)],
                         ids=lambda value: str(getattr(value, "name", value)))
def test_rigid_codes_and_their_restitution_are_found(task: Task, restitution: float):
    """With rows at impacts restitution is that of the case; in rows of 0.1 ms it is uncertain by when the impact was."""
    run = physics.rigid(task, restitution)
    own = fingerprint(run, task)
    assert own.kind == RIGID and own.restitution.holds(restitution) and own.restitution.uncertainty < 0.01
    even = of(imaginary.table_of(run, 1e-4), task)
    assert even.kind == RIGID and even.restitution.holds(restitution) and even.restitution.uncertainty < 0.15, even.restitution
    assert not even.exponent.known and "rigid" in even.exponent.why
    assert not even.pitch.known and not even.step.known


# ---- nothing that is not there -------------------------------------------------------
@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_our_runs_are_elastic_half_spaces_without_loss(task: Task, shipped: dict[str, Run]):
    """Elastic, 3/2 in the uncertainty or within 0.06, no loss, no damping, no step, no table, and the size of Hertz's law."""
    run = ldbench.read_run(shipped[task.name].file)
    found = fingerprint(run, task)
    assert found.kind == ELASTIC
    assert abs(found.exponent.value - 1.5) < max(found.exponent.uncertainty, 0.06) and found.exponent.uncertainty < 0.25
    assert found.hertz.holds(force_over_hertz(run, task)) and found.hertz.uncertainty < 0.1
    assert 0.95 < found.hertz.value < 1.1
    assert not found.loss.known or (found.loss.holds(0.0) and (task.exercise == 5 or found.loss.uncertainty < 0.01))
    assert found.damping_kind == NONE and found.damping.holds(0.0)
    assert not found.step.known and found.step.why and not found.pitch.known and found.pitch.why
    assert found.sentence.startswith("Looks elastic, ")
    assert found.sentence.endswith("step not visible, no contact table over Y visible.")


def test_few_digits_widen_uncertainties_and_make_no_findings():
    """Three digits of everything but the time."""
    frame = physics.simulate(AW, Physics(), FIRST)
    fine, coarse = of(frame), of(rounded(frame, 3))
    assert coarse.exponent.holds(1.5) and coarse.exponent.uncertainty > fine.exponent.uncertainty
    assert coarse.loss.holds(0.0) and coarse.damping_kind == NONE
    assert not coarse.step.known and not coarse.pitch.known


def test_a_file_without_contact_columns_says_what_it_needs():
    frame = physics.simulate(AW, Physics(), FIRST)
    found = of(frame.drop(columns=[name for name in frame if name[:2] in ("y_", "z_")]))
    assert found.kind == UNKNOWN and "y_LF" in found.because and found.exponent.why == found.because
    assert not np.isfinite(found.exponent.value) and "May be" in found.sentence


# ---- parts ---------------------------------------------------------------------------
@pytest.mark.parametrize(("kind", "damping"), [(NONE, 0.0), (BY_DEPTH, 0.2), (BY_RATE, 4e4)])
def test_a_law_is_fitted_to_the_digits_of_its_numbers(kind: str, damping: float):
    """A sine of an approach that begins at 5 micrometres, with a force by the law."""
    t = np.linspace(0.02, 0.98, 60)*3e-3
    x, v = 3e-4*np.sin(np.pi*t/3e-3), 3e-4*np.pi/3e-3*np.cos(np.pi*t/3e-3)
    elastic = 8e10*x**1.4
    force = {NONE: elastic, BY_DEPTH: elastic*(1 + damping*v), BY_RATE: elastic + damping*v}[kind]
    closed = force > 0
    whole = ContactInterval("LF", 0.0, 3e-3, force.max(), 1.5e-3, np.nan, 0.9)
    blow = Blow(whole, *(part[closed] for part in (t, force, v, x + 5e-6, np.full(60, 0.9), 0*t)))
    law = fit_law(blow, kind)
    assert law is not None
    assert (law.n, law.k, law.zero) == pytest.approx((1.4, 8e10, 5e-6), rel=3e-3)
    assert law.damping == pytest.approx(damping, rel=3e-3) and law.misfit < 1e-3


def test_kinks_at_equal_distances_are_a_lattice_and_others_are_none():
    x = np.linspace(0.0, 0.02, 400)
    kinked = np.interp(x, 7e-4*np.arange(40) - 1e-3, np.random.default_rng(1).normal(size=40))
    assert find_lattice([bends(x, kinked, 1e-9)], "m", "none").holds(7e-4)
    irregular = np.sort(np.random.default_rng(2).uniform(-1e-3, 0.021, 40))
    other = np.interp(x, irregular, np.random.default_rng(3).normal(size=40))
    assert find_lattice([bends(x, other, 1e-9)], "m", "none") == untold("none", "m")
    assert find_lattice([bends(x, np.sin(300*x), 1e-9)], "m", "none") == untold("none", "m")
    assert find_lattice([Bends(np.empty(0), np.empty(0), 0.0)], "m", "none") == untold("none", "m")


def test_the_noise_of_digits_is_the_last_digit():
    x = np.sin(np.linspace(0, 3, 1000))
    assert digit_noise(np.round(x, 3)) == pytest.approx(1e-3)
    assert digit_noise(x) < 1e-7


def test_estimates_are_combined_by_their_uncertainties_and_their_spread():
    assert combined([1.0, 1.0], [0.1, 0.2]).uncertainty == pytest.approx(0.1)
    apart = combined([1.0, 2.0], [0.01, 0.01])
    assert apart.value == pytest.approx(1.5) and apart.holds(1.0) and apart.holds(2.0)
    assert not combined([], []).known and not combined([np.nan], [1.0]).known
    assert plus_minus(Estimate(1.0714, 0.043)) == "1.07 ± 0.04"
    assert plus_minus(Estimate(0.0301, 0.002), 100) == "3.0 ± 0.2"


# ---- the command ---------------------------------------------------------------------
def test_the_command_tells_a_file_of_another_code(tmp_path: Path, shipped: dict[str, Run], capsys: pytest.CaptureFixture[str],
                                                  monkeypatch: pytest.MonkeyPatch):
    """The map is guessed, as for check; units, signs and names are those of another code."""
    monkeypatch.setitem(own_runs._OWN, AW, ldbench.read_run(shipped["ex2_aw"].file))
    file = tmp_path/"ex2_aw.csv"
    dialect = imaginary.Dialect(lateral=-1, vertical=-1, length="mm", angle="mrad", force="kN", scheme=2)
    imaginary.write(physics.simulate(AW, Physics(hunt_crossley=0.1), FIRST), file, dialect)
    assert main(["fingerprint", str(file)]) == 0
    told = capsys.readouterr().out
    assert f"{file}: Looks elastic, " in told and "loses 4.9" in told and "not told: " in told
    assert main(["fingerprint", str(file), "--simulation", "ex2_aw", "--json"]) == 0
    facts, = json.loads(capsys.readouterr().out)["files"]
    assert facts["kind"] == ELASTIC and facts["exponent"]["value"] == pytest.approx(1.5, abs=0.02)
    assert facts["step"]["value"] is None and facts["step"]["why"]
