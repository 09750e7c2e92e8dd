"""The half-space model: its table against direct solutions, its forces, its energy, its file."""
from pathlib import Path

import numpy as np
import pytest

from conftest import LongProgram, Run, columns, rows, run_case
from probes import MIRROR, contact_states, poses, probe, text, write_case

H = 1e-7        # step of finite differences [m, rad]


@pytest.fixture(scope="module")
def first_run(long_programs: dict[str, LongProgram]) -> LongProgram:
    """Exercise 2 with this model: case.nml, ex2_aw.txt, aw.table."""
    program = long_programs["test_halfspace"]
    status, _, errors = program.finish()
    assert status == 0, errors
    return program


@pytest.fixture(scope="module")
def case(first_run: LongProgram, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_case(tmp_path_factory.mktemp("case"), "aw", first_run.folder/"aw.table",
                      contact={"model": "halfspace"})


@pytest.fixture(scope="module")
def touching(shipped: dict[str, Run]) -> np.ndarray:
    """Poses of exercises 1 to 4 in which the left wheel is on its rail, half of them on the flange."""
    rng = np.random.default_rng(2)
    found = []
    for exercise in range(1, 5):
        run = shipped[f"ex{exercise}_aw"]
        flange = run.columns["N_LF"] > 0
        found += [rng.choice(poses(run)[touching], 15) for touching in (flange, ~flange & (run.columns["N_LT"] > 0))]
    return np.concatenate(found)


def test_table_is_found_again(first_run: LongProgram, tmp_path: Path):
    """... and gives the same rows, bit by bit."""
    assert "(built)" in first_run.finish()[1]
    first, again = first_run.folder/"ex2_aw.txt", tmp_path/"again.txt"
    done = run_case((first_run.folder/"case.nml").read_text().replace(str(first), str(again)), tmp_path)
    assert done.returncode == 0 and "(found)" in done.stdout, done.stderr
    assert rows(again) == rows(first)


def test_energy_bar(first_run: LongProgram):
    c = columns(first_run.folder/"ex2_aw.txt")
    assert c["E_drift"].size > 1000
    assert np.abs(c["E_drift"]).max() < 1e-6*(c["KE_lat"] + c["KE_vert"] + c["KE_roll"])[0]


def test_table_against_direct_solutions(case: Path, touching: np.ndarray):
    """A wheel's force is that of half-spaces pressed together within 2 % of max(|F|, 5 kN)."""
    found = probe("halfspace_direct", case, stdin=text(touching)).reshape(-1, 2, 2, 3)[..., :2].sum(axis=1)
    ours, exact = found[:, 0], found[:, 1]
    size = np.linalg.norm(exact, axis=1)
    assert (size > 1e3).sum() > 100
    assert (np.linalg.norm(ours - exact, axis=1)/np.maximum(size, 5e3)).max() < 0.02


def test_forces_are_the_gradient_and_stiffness_theirs(case: Path, touching: np.ndarray):
    state = contact_states(case, touching)
    size = np.maximum(np.abs(state.gradient).max(axis=2), 1e3)
    bend = np.abs(state.hessian).max(axis=(1, 2))
    for i in range(3):
        low, high = (contact_states(case, touching + k*H*np.eye(3)[i]) for k in (-1, 1))
        # Contacts shallower than some um change by more than the differences follow.
        deep = np.abs(high.energy - low.energy) <= 0.1*np.minimum(low.energy, high.energy)
        slope = np.abs((high.energy - low.energy)/(2*H) - state.gradient[:, :, i])/size
        assert deep.mean() > 0.9
        assert slope[deep].max() < 1e-4
        # Differences miss H^2 F''/6F, 1e-7 where the penetration is 0.1 mm.
        assert np.median(slope[deep & (state.energy > 0)]) < 1e-6
        change = np.abs((high.total - low.total)/(2*H) - state.hessian[:, :, i]).max(axis=1)/bend
        assert np.median(change[deep.all(axis=1)]) < 1e-6


def test_mirror(case: Path, touching: np.ndarray):
    """The mirrored pose exchanges left and right, bit by bit."""
    one, other = contact_states(case, touching), contact_states(case, touching*MIRROR)
    assert (one.energy == other.energy[:, [2, 3, 0, 1]]).all()
    assert (one.gradient == other.gradient[:, [2, 3, 0, 1]]*MIRROR).all()
