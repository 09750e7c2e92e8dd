"""Fingerprints of imaginary codes: planted laws of contact, steps and tables are found, and nothing else is."""
from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import imaginary_codes as imaginary
import imaginary_physics as physics
import ldbench
from imaginary_physics import Physics
from invented import invented_run
from ldbench import Case
from ldbench.__main__ import main
from ldbench_round import own_runs
from ldbench_round.blows import BY_DEPTH, BY_RATE, NONE
from ldbench_round.fingerprint import ELASTIC, RIGID, Fingerprint, fingerprint
from ldbench_round.tasks import TASKS, Task
from running import Run

AW, SW = Task(2, "aw"), Task(2, "sw")
pytestmark = pytest.mark.usefixtures("known_hertz")
SLOW = {"marks": pytest.mark.slow}
FIRST = 0.05            # to after the first blow of the left flange [s]


def of(frame: pd.DataFrame, task: Task = AW) -> Fingerprint:
    return fingerprint(invented_run(frame), task)


@pytest.mark.parametrize(("task", "laws"), [
    (AW, Physics(k=8e9, n=1.25)), (AW, Physics(hunt_crossley=0.1)), (AW, Physics(kelvin_voigt=3e4)),
    pytest.param(AW, Physics(), **SLOW), pytest.param(AW, Physics(k=1e9, n=1.0), **SLOW),
    pytest.param(SW, Physics(k=6e10), **SLOW), pytest.param(SW, Physics(k=8e9, n=1.25), **SLOW)], ids=str)
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
        assert found.loss.holds(0.0) and found.restitution.holds(1.0) and found.loss.uncertainty < 0.01
    assert not found.step.known and not found.pitch.known


def test_the_loss_of_damped_contact_is_that_of_the_motion():
    """For weak damping it is 4/3 χ v, v being the closing velocity."""
    loss = of(physics.simulate(AW, Physics(hunt_crossley=0.1), FIRST)).loss
    assert loss.uncertainty < 0.01
    closing = 0.367         # m/s, of exercise 2
    assert loss.value == pytest.approx(4/3*0.1*closing, rel=0.06)


def motion_uncertainty(ratio: float) -> float:
    """The uncertainty of a force over Hertz's that a blow has for the motion alone, as the table of docs/organiser.md defines it:
    2 % of it, and 2 % more for each factor of 2."""
    return 0.02*ratio*(1 + abs(np.log2(ratio)))


@pytest.mark.parametrize("scale", [0.8, pytest.param(0.5, **SLOW), pytest.param(1.2, **SLOW)])
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


@pytest.mark.parametrize("scheme", ["symplectic Euler", pytest.param("newmark", **SLOW)])
def test_the_step_of_a_code_that_writes_every_step(scheme: str):
    """Velocities that are half a step late do not look like damping."""
    found = of(physics.simulate(AW, Physics(step=1e-4, every=1, scheme=scheme), FIRST))
    assert found.step.holds(1e-4) and found.step.uncertainty < 1e-6
    assert ("Newmark" if scheme == "newmark" else "Euler") in found.step.why
    assert found.exponent.holds(1.5) and found.loss.holds(0.0) and found.damping_kind == NONE


@pytest.mark.parametrize("laws", [
    pytest.param(Physics(pitch=5e-4), id="linear", **SLOW), pytest.param(Physics(pitch=5e-4, stepwise=True), id="stepwise")])
def test_the_pitch_of_a_table_is_found(laws: Physics):
    found = of(physics.simulate(AW, laws, 0.08))
    assert found.pitch.holds(laws.pitch) and found.pitch.uncertainty < 0.02*laws.pitch, found.pitch
    assert not found.step.known


@pytest.mark.parametrize(("task", "restitution"), [
    (AW, 0.5), (SW, 0.0), pytest.param(AW, 1.0, **SLOW), pytest.param(SW, 0.8, **SLOW)],
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


@pytest.mark.parametrize("task", [
    pytest.param(task, marks=() if task.name in ("ex1_sw", "ex2_aw", "ex4_sw") else pytest.mark.slow, id=task.name)
    for task in TASKS[:-1]])
def test_our_runs_are_elastic_half_spaces_without_loss(task: Task, shipped: dict[str, Run]):
    """Elastic, 3/2 in the uncertainty or within 0.06, no loss, no damping, no step, no table, and the size of Hertz's law."""
    run = ldbench.read_run(shipped[task.name].file)
    found = fingerprint(run, task)
    assert found.kind == ELASTIC
    assert abs(found.exponent.value - 1.5) < max(found.exponent.uncertainty, 0.06) and found.exponent.uncertainty < 0.25
    # Hertz's law has a spring in each zone. In the blow of ex2_aw the root's joins that of the flange at 700 kN, within which one
    # factor is known by 0.17; the other blow tells it by 0.12.
    assert 0.95 < found.hertz.value < 1.1 and found.hertz.uncertainty < (0.15 if task.name == "ex2_aw" else 0.1)
    assert not found.loss.known or (found.loss.holds(0.0) and (task.exercise == 5 or found.loss.uncertainty < 0.01))
    assert found.damping_kind == NONE and found.damping.holds(0.0)
    assert not found.step.known and found.step.why and not found.pitch.known and found.pitch.why
    assert found.sentence.startswith("Looks elastic, ")
    assert found.sentence.endswith("step not visible, no contact table over Y visible.")


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
