"""Wheel and rail as elastic bodies of their own: `&contact influence = 'bodies'` and files of `python -m ldbench bodies`."""
from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import iv

import ldbench
from ldbench import Case, ContactTable, Run, bodies
from ldbench.__main__ import main
from ldbench.bodies import influence, sections
from ldbench.bodies.elements import influences
from ldbench.bodies.mesh import make_mesh
from ldbench.bodies.sections import ARC, PARTS, WIDTH, Section
from probes import MASS, ROLL_INERTIA, probe, text
from running import PAIRS, REPO, Run as Shipped, kept_tables, refusal, rows, short_case

POISSON = 0.28
FILES = {pair: REPO/f"profiles/{pair}.bodies" for pair in PAIRS}
POSE, RATES = ["Y", "Z", "roll"], ["vY", "vZ", "roll_rate"]


def with_bodies(pair: str, file: Path | None = None, **changes: object) -> Case:
    """Exercise 2 with the bodies of a file, by default the shipped ones that are infinite."""
    return Case.exercise(2, pair).replace(influence="bodies", bodies=file or FILES[pair], table_folder=kept_tables(), **changes)


def influences_in(file: Path) -> dict[str, dict[str, np.ndarray]]:
    """The influence that a file has, (strip, strip), by the kind of body and by the words of the wave number."""
    found: dict[str, dict[str, np.ndarray]] = {}
    for body in re.split(r"^body ", file.read_text(), flags=re.M)[1:]:
        kind, _, text = body.partition("\n")
        found[kind] = {}
        for wave in re.split(r"^wave ", text, flags=re.M)[1:]:
            k, _, numbers = wave.partition("\n")
            rows = [np.array(line.split(), float) for line in numbers.splitlines() if re.match(r"-?[0-9]", line)]
            lower = np.array([np.pad(row, (0, len(rows) - len(row))) for row in rows])
            found[kind][k] = lower + np.tril(lower, -1).T
    return found


def alone(kind: str, pair: str) -> str:
    """The shipped file with the body of one kind."""
    _, *found = re.split(r"^(?=body )", FILES[pair].read_text(), flags=re.M)
    return next(one for one in found if one.startswith(f"body {kind}"))


# The elements, against closed forms


def test_a_flat_body_is_a_half_space(monkeypatch: pytest.MonkeyPatch):
    """The influence in half a disc of 1 m, whose flat side has strips over 0.1 m, against the mean of K_0(k d)/pi, for waves
    that are long beside a strip and short beside the disc."""
    monkeypatch.setattr(influence, "WAVES", influence.WAVES[(influence.WAVES > 5) & (influence.WAVES < 100)][::3])
    strips = int(0.1/WIDTH)
    y = WIDTH/PARTS*(np.arange(strips*PARTS + 1) - strips*PARTS/2)
    turn = np.linspace(0, np.pi, ARC + 1)
    arc = np.column_stack([np.cos(turn), np.sin(turn)])
    body = influence.body_of(Section("wheel", np.column_stack([y, 0*y]), arc, (0, ARC)), "flat", "infinite", POISSON)
    error = np.abs(body.whole/body.halfspace - 1)
    apart = np.abs(np.arange(strips)[:, None] - np.arange(strips))
    assert error[:, apart >= 2].max() < 7e-3 and error[:, apart < 2].max() < 1e-2


def test_a_solid_cylinder_under_waves_of_pressure():
    """Against A. E. H. Love's strain function [c1 I0(kr) + c2 kr I1(kr)] sin kx: no shear and -p cos kx along r on the cylinder. A
    polygon of so many sides errs by 0.04 % itself."""
    radius, sides = 0.05, 120
    z = np.array([0.3, 0.5, 1.0, 2.0, 3.0, 5.0])        # k a
    turn = 2*np.pi*np.arange(sides)/sides
    mesh = make_mesh(radius*np.column_stack([np.cos(turn), np.sin(turn)]), np.empty((0, 2)), (0, 0), 2*np.pi*radius/sides)
    # The last side closes the polygon.
    ends = [mesh.strips[-1, 2], mesh.strips[0, 0]]
    middle = np.linalg.norm(mesh.points - mesh.points[ends].mean(axis=0), axis=1).argmin()
    mesh = replace(mesh, strips=np.vstack([mesh.strips, [ends[0], middle, ends[1]]]))
    inward = influences(mesh, POISSON, z/radius).sum(axis=2)*2*radius*np.sin(np.pi/sides)     # for p = E = 1 Pa
    i0, i1, k = iv(0, z), iv(1, z), z/radius
    ratio = -(2*(1 - POISSON) + z*i0/i1)                # c1/c2
    c2 = -1/(k**3*(2*POISSON*i0 - ratio*(i0 - i1/z) - i0 - z*i1))
    exact = k**2*(1 + POISSON)*c2*(ratio*i1 + z*i0)
    assert np.abs(inward/exact[:, None] - 1).max() < 1e-3


@pytest.mark.parametrize(("pair", "support"), [
    ("aw", "infinite"), *(pytest.param(pair, support, marks=pytest.mark.slow) for pair, support in (
        ("aw", "clamped"), ("sw", "infinite"), ("sw", "clamped")))])
def test_shipped_bodies(pair: str, support: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What is found today is in the shipped file, for every sixth wave. The influence is symmetric, as E. Betti's theorem has it,
    and positive definite for every wave number: no load is without energy."""
    monkeypatch.setattr(influence, "WAVES", influence.WAVES[::6])
    found = bodies.find(Case.exercise(2, pair), support)
    bodies.write(tmp_path/"today", found)
    shipped = influences_in(REPO/f"profiles/{pair}{'_clamped' if support == 'clamped' else ''}.bodies")
    today = influences_in(tmp_path/"today")
    for kind, waves in today.items():
        assert len(waves) == 5
        for k, whole in waves.items():
            assert np.abs(whole - shipped[kind][k]).max() < 1e-3*np.abs(shipped[kind][k]).max()
    assert [body.kind for body in found] == ["wheel", "rail"]
    for body in found:
        largest = np.abs(body.whole).max(axis=(1, 2))
        assert (np.abs(body.whole - body.whole.transpose(0, 2, 1)).max(axis=(1, 2)) < 1e-11*largest).all()
        least = np.linalg.eigvalsh(body.whole)[:, 0]
        assert (least > 0.05*np.diagonal(body.whole, axis1=1, axis2=2).mean(axis=1)).all(), body.kind


@pytest.mark.parametrize("pair", PAIRS)
def test_a_clamped_body_gives_less(pair: str):
    """Under any load and for every wave number, as it is a part of the infinite body and is held there. Both files leave
    out the same half-spaces. The triangles below a strip differ between the meshes, which makes some thousandths."""
    free, held = influences_in(FILES[pair]), influences_in(REPO/f"profiles/{pair}_clamped.bodies")
    for kind in "wheel", "rail":
        for n, (k, whole) in enumerate(free[kind].items()):
            gain = np.linalg.eigvalsh(whole - held[kind][k])
            assert gain[0] > -5e-3 and (gain[-1] > 1 or n), (kind, k, gain[[0, -1]])


# The core


@pytest.mark.parametrize("pair", ["aw", pytest.param("sw", marks=pytest.mark.slow)])
def test_a_whole_wheel_is_stable_in_any_pose(pair: str, tmp_path: Path):
    """The influence of all elements of a wheel on each other is symmetric and positive definite, where tread or flange is
    pressed and where both are, and every solution converges."""
    case = with_bodies(pair)
    table = ContactTable(case)
    rng = np.random.default_rng(5)
    anywhere = rng.uniform([-table.clearance, 0.05e-3, -5e-3], [table.clearance + 1e-3, 0.9e-3, 5e-3], (50, 3))
    on_both = rng.uniform([table.clearance - 0.4e-3, 0.2e-3, -1e-3], [table.clearance + 0.6e-3, 0.9e-3, 1e-3], (50, 3))
    y, drop, roll = np.concatenate([anywhere, on_both]).T
    case.to_namelist(tmp_path/"case.nml")
    found = probe("whole_wheel", tmp_path/"case.nml", stdin=text(np.column_stack([y, table.equilibrium - drop, roll])))
    patches, converged, energy, pivot, skew = found[:, [0, 1, 2, 5, 6]].T
    pressed = patches > 0
    assert pressed.sum() > 12 and (patches > 1).sum() > 2
    assert (converged == 1).all() and (energy[pressed] > 0).all() and (pivot > 0.2).all() and (skew == 0).all()


def test_no_difference_is_the_half_space(tmp_path: Path):
    """A wheel alone with zeros for all differences: the rows of `influence = 'local'`, byte for byte."""
    same = re.sub(r"^-?[0-9].*$", lambda row: " ".join("0" for _ in row[0].split()), alone("wheel", "aw"), flags=re.M)
    (tmp_path/"zeros").write_text(same)
    found = []
    for changes in {"influence": "local"}, {"influence": "bodies", "bodies": tmp_path/"zeros"}:
        case = Case.exercise(2, "aw").replace(stop_at="t_end", Y=0.0099, t_end=2e-3, judged="no", table_folder="", **changes)
        found.append(rows(Path(ldbench.run(case).write(tmp_path/"columns.txt"))))
        assert float(found[-1].splitlines()[-1].split()[2]) > 0.0103      # on the flange
    assert found[0] == found[1]


@pytest.fixture(scope="module")
def run() -> Run:
    """Exercise 2 with the actual profiles, through the first flange contact."""
    return ldbench.run(with_bodies("aw", stop_at="t_end", t_end=0.045, pressures="no"))


def test_energy_is_kept(run: Run):
    """The sum of energies drifts by less than 1e-9 of the kinetic energy at the start, and the table holds where the run was."""
    case = run.case
    kinetic = MASS*case.vY**2/2 + ROLL_INERTIA*case.roll_rate**2/2
    assert np.abs(run.data.E_drift).max() < 1e-9*kinetic
    assert run.table.solutions[0] > 0 and run.table.solutions[2] == 0
    assert all(rms < 3e-3 for rms, _ in run.header.table_errors.values()), run.header.table_errors


def test_bodies_soften_the_first_impact(run: Run, shipped: dict[str, Shipped], tmp_path: Path):
    """Both bodies lower the first peak of the flange by more than the wheel's alone, and the wheel's by more than the rail's alone.
    The impulse, which turns the wheelset back, stays: a softer flange is pressed for longer, and turns more of the motion."""
    half = ldbench.read_run(shipped["ex2_aw"].file)
    peaks = [run.results["first_peak_N_LF"]]
    for kind in "wheel", "rail":
        (tmp_path/kind).write_text(alone(kind, "aw"))
        one = with_bodies("aw", tmp_path/kind, stop_at="t_end", t_end=0.03, judged="no", pressures="no")
        peaks.append(ldbench.run(one).results["first_peak_N_LF"])
    assert peaks == sorted(peaks) and peaks[-1] < half.results["first_peak_N_LF"]
    # A finer mesh and a larger body change the peak by less than 5e-3; it was found once, with the shipped file.
    assert peaks[0]/half.results["first_peak_N_LF"] == pytest.approx(0.8387, rel=5e-3)
    assert run.results["first_impulse_LF"] == pytest.approx(half.results["first_impulse_LF"], rel=0.04)


def test_the_force_is_the_gradient_of_the_potential(run: Run):
    """By central differences, and the stiffness that of the force. The loads along the normals sum up to the force but for the
    table's error and for the rail's influence, which moves with the pose."""
    data = run.data
    touching = np.flatnonzero(data.N_LF > 1e5)
    assert len(touching) > 10
    # Beside the rows, of which those at events are where a contact begins or ends and the stiffness jumps.
    q = data[POSE].to_numpy()[touching[::len(touching)//4]] + [2e-6, run.table.equilibrium - 3e-6, 0]
    table, steps = run.table, np.diag([1e-7, 1e-7, 1e-7])
    force, stiffness = table.force(*q.T), table.tangent(*q.T)
    for i, step in enumerate(steps):
        there, back = (q + sign*step for sign in (1, -1))
        slope = (table.potential(*there.T) - table.potential(*back.T))/(2*step[i])
        assert -slope == pytest.approx(force[:, i], abs=1e-5*np.abs(force).max())
        bend = (table.force(*there.T) - table.force(*back.T))/(2*step[i])
        assert -bend == pytest.approx(stiffness[:, i], abs=1e-4*np.abs(stiffness).max())
    for pose in q[::3]:
        loads = np.sum([patch.resultant for patch in table.pressure(*pose) if patch.contact[0] == "L"], axis=0)
        wheel = table.force(*pose, wheel="left")[:2]
        assert np.linalg.norm(loads - wheel) < 1.5e-2*np.linalg.norm(wheel)


@pytest.mark.slow
@pytest.mark.parametrize("finer", [{"PARTS": 2*PARTS}, {"RADIUS": 2*sections.RADIUS}], ids=["mesh", "radius"])
def test_a_finer_mesh_and_a_larger_body_change_little(finer: Mapping[str, float], run: Run, tmp_path: Path,
                                                        monkeypatch: pytest.MonkeyPatch):
    """The first peak with sides of triangles half as long, and with an infinite body that is cut twice as far away."""
    for name, value in finer.items():
        for module in sections, influence:
            monkeypatch.setattr(module, name, value, raising=False)
    bodies.write(tmp_path/"finer", bodies.find(Case.exercise(2, "aw")))
    other = ldbench.run(with_bodies("aw", tmp_path/"finer", stop_at="t_end", t_end=0.03))
    assert 0 < abs(other.results["first_peak_N_LF"]/run.results["first_peak_N_LF"] - 1) < 5e-3


# Files


def changed(pattern: str, new: str) -> str:
    """The shipped file with another text in one place."""
    found, count = re.subn(pattern, new, FILES["aw"].read_text(), count=1, flags=re.M)
    assert count == 1
    return found


FIRST_WAVE = r"^(wave 0\.0002\n)"
REFUSED = {
    "other profiles": (FILES["sw"].read_text(), "line 5: expected strips on {wheel}, found strips that are up to "
                       r"\d\.\d+ mm beside it; make a file for these profiles: python -m ldbench bodies"),
    "another Poisson's ratio": (changed("^poisson 0.28", "poisson 0.3"), "line 5: expected bodies with &material poisson = 0.28, "
                                "found 0.3; make a file for this material: python -m ldbench bodies"),
    "no wave numbers": (FILES["aw"].read_text().partition("wave")[0], "expected 'wave' with a number in 1/mm, at least twice, "
                        "found the end of the file"),
    "half a file": (FILES["aw"].read_text()[:200_000].rpartition("\n")[0] + "\n",
                    r"expected \d+ numbers, found the end of the file"),
    "half a line": (changed(rf"{FIRST_WAVE}(.*\n.*\n\S+ \S+) \S+$", r"\1\2"), r"line \d+: expected 3 numbers, found '\S+ \S+'"),
    "a word": (changed(rf"{FIRST_WAVE}(.*\n\S+) \S+$", r"\1\2 much"), r"line \d+: expected 2 numbers, found '\S+ much'"),
    "a number that is none": (changed(rf"{FIRST_WAVE}(.*\n\S+) \S+$", r"\1\2 NaN"),
                              r"line \d+: expected 2 numbers, found '\S+ NaN'"),
    "no width": (changed("^width 3$", "width 0"), "line 7: expected a width above 0 mm, found 'width 0'"),
    "a width below 0": (changed("^width 3$", "width -3"), "line 7: expected a width above 0 mm, found 'width -3'"),
    "another width": (changed("^width 3$", "width 4"), r"line 5: expected strips on {wheel}, found strips that are up to "),
    "wave numbers that fall": (changed(r"^wave 0\.00028\d*", "wave 0.0001"), r"line \d+: expected wave numbers above 0 that grow, "
                               "at most 1000 of them, found 'wave 0.0001'"),
    "a wave number of 0": (changed(r"^wave 0\.0002$", "wave 0"), r"line \d+: expected wave numbers above 0 that grow"),
    "another kind": (changed("^body rail", "body axle"), r"line \d+: expected 'body wheel' or 'body rail', found 'body axle'"),
    "too many strips": ("body wheel\npoisson 0.28\nwidth 3\n" + 20_000*"strip 1 1\n", "line 504: expected at most 500 "
                        "strips, found 'strip 1 1'"),
    "another sign": (re.sub(r"^-?[0-9].*$", lambda row: " ".join(f"{-9*float(x)}" for x in row[0].split()), FILES["aw"].read_text(),
                            flags=re.M), "line 5: expected strips that act on themselves like half-spaces, less than 10 times as "
                     r"much, found -\d\S+ to \S+ times as much; the head of"),
    "half-spaces not taken off": (re.sub(r"^-?[0-9].*$", lambda row: " ".join(f"{float(x) + 0.8}" for x in row[0].split()),
                                         FILES["aw"].read_text(), flags=re.M), "line 5: expected strips that act on themselves"),
    "nothing": ("# nothing\n", "expected bodies of a wheel or a rail, found none"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_file_is_refused(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """In one line, by the executable and by Python in the same words, with no file made or touched."""
    source, words = REFUSED[what]
    (tmp_path/"wrong.bodies").write_text(source)
    contact = {"model": "halfspace", "influence": "bodies", "bodies": tmp_path/"wrong.bodies"}
    message = refusal(short_case(tmp_path, contact=contact), tmp_path)
    wheel = re.escape(str(REPO/"profiles/awprof.yz"))
    assert re.search(rf"case\.nml, &contact bodies: \S+/wrong\.bodies(, |: ){words.replace('{wheel}', wheel)}", message), message
    assert main(["run", str(tmp_path/"case.nml")]) == 1
    assert capsys.readouterr().err == f"{message}\n"


@pytest.mark.parametrize(("contact", "output", "words"), [
    ({}, {}, "&contact bodies: expected a file made by python -m ldbench bodies, with influence = 'bodies', found none"),
    ({"bodies": FILES["aw"], "model": "strip"}, {},
     "&contact influence: expected model = 'halfspace' with influence = 'bodies', found 'strip'"),
    ({"bodies": "none.bodies"}, {}, "&contact bodies: none.bodies: cannot be opened for reading"),
    ({"bodies": "own.bodies"}, {"file": "own.bodies"},
     "&output file: expected a file of its own, found own.bodies, which is &contact bodies")])
def test_a_case_is_refused(contact: dict[str, object], output: dict[str, object], words: str, tmp_path: Path,
                             capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    (tmp_path/"own.bodies").write_bytes(FILES["aw"].read_bytes())
    contact = {"model": "halfspace", "influence": "bodies"} | contact
    assert f"case.nml, {words}" in refusal(short_case(tmp_path, contact=contact, output=output), tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(tmp_path/"case.nml")]) == 1
    assert words in capsys.readouterr().err


def outline(tmp_path: Path, points: np.ndarray) -> Path:
    file = tmp_path/"outline"
    np.savetxt(file, points)
    return file


WHEEL = np.loadtxt(REPO/"profiles/awprof.yz", comments=("#", "!"))
BASE = np.array([[135.0, 40.0], [100.0, 50.8], [40.0, 50.8], [0.0, 40.0]])      # of a rim, with a slope to the plate [mm]
RIM = np.concatenate([WHEEL, BASE, WHEEL[:1]])


@pytest.mark.parametrize(("points", "words"), [
    (RIM[:-1], r"expected an outline that ends where it begins, found ends that are \d+\.\d mm apart"),
    (RIM + [0, 1], r"expected an outline that has the profile, within 0.2 mm, found [01]\.\d+ mm between them at y = "),
    (np.concatenate([WHEEL, [[67.5, 60]], WHEEL[:1]]),
     "expected an outline with a straight base of one z, found a single point there"),
    (RIM[:3], "expected at least four lines with two numbers, y and z in mm, found 3 of 2"),
], ids=["open", "beside the profile", "with a corner on top", "too short"])
def test_an_outline_is_refused(points: np.ndarray, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = outline(tmp_path, points)
    target = tmp_path/"made.bodies"
    target.write_text("an earlier file\n")
    assert main(["bodies", str(REPO/"inputs/ex2_aw.nml"), "--only", "wheel", "--rim", str(file), "-o", str(target)]) == 1
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(rf"ldbench: error: {file}: {words}.*\n", said.err), said.err
    assert target.read_text() == "an earlier file\n"


def test_a_short_profile_is_refused():
    line = np.column_stack([np.linspace(0, 0.01, 20), np.zeros(20)])
    with pytest.raises(ldbench.Error, match=r"expected a profile of at least 12 mm, found 10\.0 mm"):
        sections.section("wheel", line, "infinite", 0.05)
