"""Wheel and rail as elastic bodies of their own: `&contact influence = 'bodies'`.

Influence. The elements on sections are held against two solutions that share nothing with them: an elastic quarter-space by
Hetenyi's alternation, up to its edge, and the rim of the actual wheel in three dimensions, by scikit-fem's tetrahedra on the same
mesh of the section. Half-space, cylinder, symmetry and positive definiteness are among the tests of `make test`.

Contact. The first flange contact is integrated with the wheel pressed as one elastic system in every pose, without a table. What
the bodies change in it, and the stiffness of a flange, stand in tables.

How far the surface's normals explain it: the influence between the wheel's tread and its flange over that of places on a
half-space as far apart. With local normals that is the cosine of the angle between them; so it is in three of the four conformal
corrections of CONTACT (its public source), and (-nu + (2 - nu) cos)/(2 (1 - nu)) in the fourth. The flange bends besides.

The rail's influence moves with the pose, so the loads along the normals are not all of the gradient; the last table has the rest.
"""
from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

import ldbench
import quarter_space
import solid_wheel
from checks import Check, Section, limit
from ldbench import Case, ContactTable, bodies
from ldbench.bodies.elements import influences
from ldbench.bodies.influence import WAVES, Body, body_of, mean_k0
from ldbench.bodies.mesh import make_mesh
from ldbench.bodies.sections import ARC, PARTS, WIDTH, Section as Outline
from models import AFTER, compare, direct, tabulated
from probes import probe, text
from running import REPO
from sheets import Table

POISSON = 0.28
EDGE = 0.12                             # of the quarter-space that carries strips, from its edge on [m]
EDGE_BAR = 1e-2                         # measured 3.7e-3, between neighbours at the edge and the shortest waves
# Between two strips, measured 4.9e-3; on one strip, where the load is as narrow as a tetrahedron, 1.5e-2.
APART_BAR, SAME_BAR = 5e-3, 2e-2
TOLD = 0.03                             # smallest influence that is compared, of the largest
FILES = {"infinite": "profiles/{}.bodies", "clamped": "profiles/{}_clamped.bodies"}
DIRECT = [(2, "aw", "infinite"), (2, "aw", "clamped"), (2, "sw", "infinite"), (4, "aw", "infinite")]
ANGLES = [(5, 65), (20, 65), (45, 65), (60, 45), (60, 20), (60, 5)]        # between whose places influence is told [degrees]
STEP = 2e-6                             # of the energy's central difference [m]
FORCES = 30e3, 100e3, 300e3, 1e6, 3e6   # on a flange whose stiffness is told [N]


def with_bodies(exercise: int, pair: str, support: str) -> Case:
    return Case.exercise(exercise, pair).replace(influence="bodies", bodies=REPO/FILES[support].format(pair))


def quarter() -> list[Check]:
    """A quarter of a disc of 1 m, whose outer arc is held, for waves that are short beside it."""
    strips = round(EDGE/WIDTH)
    y = np.linspace(-EDGE, 0, strips*PARTS + 1)
    turn = np.linspace(0, np.pi/2, ARC + 1)
    arc = np.column_stack([-np.sin(turn), np.cos(turn)])
    body = body_of(Outline("wheel", np.column_stack([y, 0*y]), arc, (0, ARC)), "quarter", "infinite", POISSON)
    checks = []
    for k in WAVES[(WAVES > 5) & (WAVES < 150)][::2]:
        at = list(WAVES).index(k)
        exact = body.halfspace[at] + quarter_space.influence(k, strips, WIDTH, POISSON)[::-1, ::-1]
        seen = exact > TOLD*exact.max()
        error = np.abs(body.whole[at]/exact - 1)[seen].max()
        checks.append(limit(f"influence at the edge of a quarter-space, k = {k:.3g}/m, relative", error, "Hetenyi's alternation",
                            EDGE_BAR))
    return checks


def solid() -> list[Check]:
    """The rim of the actual wheel, clamped, on a coarse mesh, the same in both."""
    body, = bodies.find(Case.exercise(2, "aw"), "clamped", kinds=["wheel"])
    outline = body.section
    ends = outline.ends[::PARTS]
    mesh = make_mesh(ends, outline.rest, outline.held, WIDTH)
    whole = influences(mesh, POISSON, WAVES)/(2*(1 - POISSON**2))
    ours = over_a_length(whole, solid_wheel.LOADED)
    theirs = solid_wheel.influence(mesh, outline.rest[0, 1], POISSON)
    seen, same = np.abs(theirs) > TOLD*theirs.max(), np.eye(len(ours), dtype=bool)
    error = np.abs(ours/theirs - 1)
    source = "tetrahedra of scikit-fem"
    apart = seen & ~same
    return [limit(f"influence between places of the wheel, {apart.sum()} pairs, relative", error[apart].max(), source, APART_BAR),
            limit(f"influence of places of the wheel on themselves, {same.sum()}, relative", error[same].max(), source, SAME_BAR)]


def over_a_length(whole: np.ndarray, length: float) -> np.ndarray:
    """Mean displacement over |x| < length of strips by loads over the same, from the influence of waves. Beyond the last wave
    number it is that of half-spaces, which is seen on neighbours alone."""
    strips = np.arange(whole.shape[1])
    apart = WIDTH*np.abs(strips[:, None] - strips)
    inner, outer = np.geomspace(WAVES[0], WAVES[-1], 20_001), np.geomspace(WAVES[-1], 10*WAVES[-1], 2001)
    near = apart < 4*WIDTH
    tail = np.zeros((len(outer), *near.shape))
    tail[:, near] = [mean_k0(k, apart[0, :4])[np.rint(apart[near]/WIDTH).astype(int)]/np.pi for k in outer]
    found = 2*length/np.pi*WAVES[0]*whole[0]
    for k, values in (inner, CubicSpline(np.log(WAVES), whole)(np.log(inner))), (outer, tail):
        share = 2*length/np.pi*np.sinc(k*length/np.pi)**2
        found = found + np.trapezoid(share[:, None, None]*values, k, axis=0)
    return found


def without_table() -> list[Check]:
    """The first flange contacts of runs against the wheel pressed in every pose."""
    checks = []
    for exercise, pair, support in DIRECT:
        name = f"ex{exercise}_{pair}, {support} bodies"
        run, ours = tabulated(with_bodies(exercise, pair, support), name)
        checks += compare(name, ours, direct(run.case, float(ours.t[0]) - AFTER, float(ours.t[-1]) + AFTER))
    return checks


def by_angle() -> Table:
    """The influence between places of wheels over that of a half-space."""
    rows = []
    for pair in "aw", "sw":
        for support in FILES:
            body, = bodies.find(Case.exercise(2, pair), support, kinds=["wheel"])
            rows.append([pair, support, *(f"{between(body, *angles):.2f}" for angles in ANGLES)])
    turned = np.cos(np.radians([one - other for one, other in ANGLES]))
    rows.append(["", "cosine", *(f"{x:.2f}" for x in turned)])
    rows.append(["", "CONTACT's fourth", *(f"{(-POISSON + (2 - POISSON)*x)/(2*(1 - POISSON)):.2f}" for x in turned)])
    return Table("Influence between the wheel's places at two angles, over that of a half-space with one normal",
                 ["profiles", "body", *(f"{one} and {other} degrees" for one, other in ANGLES)], rows)


def between(body: Body, one: float, other: float) -> float:
    return body.over_halfspace(*np.radians([one, other]))*np.cos(np.radians(one - other))


def stiffnesses() -> Table:
    """How stiff the left flange is against its rail, laterally, with the wheelset's height and roll fixed."""
    rows = []
    for pair in "aw", "sw":
        laws = {"half-spaces": Case.exercise(2, pair), **{f"{support} bodies": with_bodies(2, pair, support) for support in FILES}}
        for law, case in laws.items():
            table = ContactTable(case)
            y = table.clearance + np.linspace(-0.1e-3, 4e-3, 1000)
            geometry = table.geometry([table.clearance])
            pose = y, np.full_like(y, table.rigid_height + geometry.Z[0]), np.full_like(y, geometry.roll[0])
            force = np.hypot(*table.force(*pose, "left", outside="nan")[:, :2].T)
            at = [int(np.argmax(force > size)) for size in FORCES]
            tangent = table.tangent(*(x[at] for x in pose), "left")[:, 0, 0]
            rows.append([pair, law, *(f"{1e-6*x:.0f}" for x in tangent)])
    return Table("Lateral stiffness of a flange by its force [kN/mm]",
                 ["profiles", "law", *(f"{1e-3*size:g} kN" for size in FORCES)], rows)


def moving_influence() -> Table:
    """What loads along the normals miss of the energy's gradient, in the first flange contact of exercise 2."""
    rows = []
    for pair in "aw", "sw":
        case = with_bodies(2, pair, "infinite")
        run = ldbench.run(case)
        data = run.data[run.data.N_LF > run.first_interval("LF").peak/5].iloc[:40:4]
        poses = data[["Y", "Z", "roll"]].to_numpy() + [0, run.results["axle_height"], 0]
        energy = [[pressed(case, poses + way*axis)[:, 2] for way in (STEP, -STEP)] for axis in np.eye(3)[:2]]
        gradient = np.array([there - back for there, back in energy]).T/(-2*STEP)
        missed = np.linalg.norm(gradient - pressed(case, poses)[:, 3:5], axis=1)/np.linalg.norm(gradient, axis=1)
        rows.append([pair, f"{len(poses)}", f"{np.median(missed):.1e}", f"{missed.max():.1e}"])
    return Table("Loads along the normals against the gradient of the energy of a whole wheel, of the force",
                 ["profiles", "poses", "median", "largest"], rows)


def pressed(case: Case, poses: np.ndarray) -> np.ndarray:
    """The answers of tests/fortran/whole_wheel.f90."""
    with tempfile.TemporaryDirectory() as folder:
        case.to_namelist(Path(folder)/"case.nml")
        return probe("whole_wheel", Path(folder)/"case.nml", stdin=text(poses))


def section() -> Section:
    checks = [*quarter(), *solid(), *without_table()]
    return Section("Wheel and rail as bodies of their own", __doc__ or "", checks, [by_angle(), stiffnesses(), moving_influence()])
