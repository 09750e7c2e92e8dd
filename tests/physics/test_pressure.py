"""Pressures of a pose: against Hertz's theory, the force of the table, the mirror image, and what the columns of a run say."""
from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ldbench import ContactTable, Error
from ldbench.constants import CONTACTS
from ldbench.geometry.outlines import case_outlines, pose
from ldbench.geometry.pressures import run_patches, told
from ldbench.pressure import press, shared
from ldbench.results.run_data import RunData, read_data
from ldbench.results.summary import summary_row
from ldbench.table import rigid_geometry
from round_profiles import RADIUS, Shape, hertz
from running import Run

E_STAR = 210e9/(2*(1 - 0.3**2))         # of the default case [Pa]
TAPER = 0.025


@pytest.mark.parametrize(("radius", "ratio"), [(0.05, 0.24), (0.457, 1.0), (3.0, 3.5)], ids=["long", "round", "wide"])
def test_cone_on_a_round_head_is_hertz(radius: float, ratio: float, tmp_path: Path):
    """Semi-axes, area, largest pressure and force for a cone on a rail of constant radius, whose gap is A x² + B s² but for
    terms of higher order. A patch has 24 elements along x and 48 along s; its ends are known to a sixth of an element."""
    case = Shape(TAPER, np.inf, radius).case(tmp_path, 0.05).replace(poisson=0.3)
    handle = rigid_geometry(case)
    height = case_outlines(case).axle
    approach = 20e-6
    a, b, largest, force = hertz(np.cos(TAPER)/(2*RADIUS), 1/(2*radius), approach, E_STAR)
    assert b/a == pytest.approx(ratio, rel=0.1)
    patch, = press(handle, case, (0.0, height - approach/np.cos(TAPER), 0.0), ["LT"])
    assert patch.approach == pytest.approx(approach, rel=1e-4)
    assert patch.half_x == pytest.approx(a, rel=1/12/6) and patch.half_s == pytest.approx(b, rel=1/24/6)
    assert patch.area == pytest.approx(np.pi*a*b, rel=5e-3) and patch.mean == pytest.approx(2/3*largest, rel=5e-3)
    assert patch.largest == pytest.approx(largest, rel=1e-3) and patch.force == pytest.approx(force, rel=1e-3)
    assert patch.hertz
    assert np.array([patch.hertz.half_x/a, patch.hertz.half_s/b, patch.hertz.largest/largest]) == pytest.approx(1, abs=1e-3)
    # As it is drawn: Hertz's pressure on a close grid up to the edge, and nothing beyond it.
    x, s, p = patch.sections
    depth = 1 - (x[:, None]/a)**2 - ((s - patch.s_deepest)/b)**2
    inside = depth > 0.05
    assert np.isnan(p[depth < -0.05]).all() and np.isfinite(p[inside]).all()
    assert np.abs(p[inside] - largest*np.sqrt(depth[inside])).max() < 0.05*largest      # beside an edge without elements of its own


def test_a_patch_that_tread_and_flange_share(run: RunData):
    """It has both names where its load acts on both parts of the wheel and the columns have both closed."""
    k = run.first_interval("LF").top
    patch, = run_patches(run, k, ["LF"])
    assert (patch.contacts, patch.also) == (("LF",), "")
    assert run_patches(run, k, ["LT"]) == []
    middle = patch.angle
    for closed, steep, expected in ((["LT", "LF"], middle, "LT"), (["LF"], middle, ""), (["LT", "LF"], 0.2, "")):
        found, = shared([patch], closed, steep)
        assert found.also == expected and found.contacts == ("LF", "LT")[:1 + bool(expected)]
    tread = replace(patch, contact="LT")
    assert [one.also for one in shared([patch, tread], ["LT", "LF"], middle)] == ["", ""]       # each has its own


def test_what_is_told_of_several_patches(run: RunData):
    """The largest pressure and approach, and the area of all."""
    flange, = run_patches(run, run.first_interval("LF").top, ["LF"])
    tread, = run_patches(run, 0, ["LT"])
    assert flange.largest > tread.largest
    for both in ([flange, tread], [tread, flange]):
        assert told(both) == (flange.largest, flange.area + tread.area, max(flange.approach, tread.approach))


@pytest.fixture(scope="module")
def run(shipped: dict[str, Run]) -> RunData:
    """Exercise 2 with the actual profiles."""
    return read_data(shipped["ex2_aw"].file)


@pytest.fixture(scope="module")
def table(run: RunData) -> ContactTable:
    return ContactTable(run.case)


@pytest.fixture(scope="module")
def rows(run: RunData) -> list[int]:
    """The peaks of first contacts, and the start."""
    return [0, *(one.top for contact in CONTACTS if (one := run.first_interval(contact)))]


def test_force_is_that_of_the_table(run: RunData, table: ContactTable, rows: list[int]):
    """The pressure on the turned elements of the patches sums up to the contact's force, but for the table's error and the
    grid's 0.8/48². The integral of the pressure is larger, for the normals turn over a patch."""
    error = 5e-3     # of the table's force
    seen = set()
    for k in rows:
        forces = table.forces_by_contact(*pose(run, k))
        patches = table.pressure(*pose(run, k))
        for number, contact in enumerate(CONTACTS):
            mine = [patch for patch in patches if patch.contact == contact]
            force = float(np.hypot(*forces[number, :2]))
            assert bool(mine) == (force > 0), (k, contact)
            if mine:
                seen.add(contact)
                assert np.hypot(*np.sum([patch.resultant for patch in mine], axis=0)) == pytest.approx(force, rel=error + 2e-3)
                assert sum(patch.integral for patch in mine) > (1 - error - 2e-3)*force
                assert {patch.force for patch in mine} == {force}
                assert force == pytest.approx(run.values(f"N_{contact}")[k], rel=1e-5)         # nine digits
    assert seen == set(CONTACTS)


def test_a_patch_is_consistent(run: RunData, rows: list[int]):
    """Pressure, area, mean and place belong together."""
    for k in rows:
        for patch in run_patches(run, k):
            dx, ds = patch.x[1] - patch.x[0], patch.s[1] - patch.s[0]
            assert patch.p.shape == (len(patch.x), len(patch.s)) and (patch.p >= 0).all()
            assert patch.p == pytest.approx(patch.p[::-1]) and patch.x == pytest.approx(-patch.x[::-1])
            assert patch.integral == pytest.approx(patch.p.sum()*dx*ds)
            assert patch.mean*patch.area == pytest.approx(patch.integral)
            # The pressed elements, of which those at the edge count in part.
            assert patch.area == pytest.approx((patch.p > 0).sum()*dx*ds, rel=0.08)
            assert patch.p.max() <= patch.largest < 1.01*patch.p.max()
            assert patch.s_ends[0] < patch.s_centre < patch.s_ends[1] and patch.s_ends[0] < patch.s_deepest < patch.s_ends[1]
            # The wheel's points in both frames, and the place and angle of the contact in the columns.
            y, _, roll = pose(run, k)
            turned = patch.wheel[:, 0]*np.cos(roll) - patch.wheel[:, 1]*np.sin(roll) + y
            assert turned == pytest.approx(patch.track[:, 0])
            lengths = np.hypot(*np.diff(patch.wheel, axis=0).T)
            assert lengths == pytest.approx(ds, rel=1e-3)
            place = np.array([run.values(f"{axis}_{patch.contact}")[k] for axis in "yz"])
            assert np.hypot(*(place - patch.centre)) < patch.half_s/4
            assert (patch.force, patch.angle) == tuple(run.values(f"{what}_{patch.contact}")[k] for what in ("N", "angle"))
            # Without columns, those of the pressure.
            own, = press(rigid_geometry(run.case), run.case, pose(run, k), [patch.contact])
            assert (own.force, own.angle) == pytest.approx((patch.force, patch.angle), rel=6e-3)


def test_left_and_right_are_mirror_images(run: RunData, table: ContactTable, rows: list[int]):
    y, z, roll = pose(run, rows[2])
    ours, theirs = table.pressure(y, z, roll), table.pressure(-y, z, -roll)
    other = {"LT": "RT", "LF": "RF", "RT": "LT", "RF": "LF"}
    image = {other[patch.contact]: patch for patch in theirs}
    assert ours and len(ours) == len(theirs)
    for patch in ours:
        mirror = image[patch.contact]
        assert np.array_equal(patch.p, mirror.p) and np.array_equal(patch.s, mirror.s)
        assert patch.track == pytest.approx(mirror.track*[-1, 1]) and patch.wheel == pytest.approx(mirror.wheel*[-1, 1])
        assert patch.angle == mirror.angle and patch.force == mirror.force


def test_a_long_patch_of_the_tread_leaves_the_flange_open(shipped: dict[str, Run]):
    """Exercise 3: the overlap of the right tread reaches over the root of the flange. The wheel is one elastic system, so that
    the root carries nothing: one patch, without the edge of a cut, and no force on the flange in the columns."""
    run = read_data(shipped["ex3_aw"].file)
    before = run.time < run.time[np.flatnonzero(run.values("N_RF") > 0)[0]]
    k = int(np.where(before, run.values("N_RT"), 0).argmax())
    patch, = run_patches(run, k, ["RT", "RF"])
    assert patch.contact == "RT" and patch.integral == pytest.approx(run.values("N_RT")[k], rel=5e-3)
    assert patch.force > 1e6 and patch.largest < 2*patch.mean
    assert run.results["pmax_RF"] > 5e9 and run.results["pmax_LF"] > 4e9


@pytest.mark.parametrize("case", ["ex3_aw", "ex4_sw"])
def test_the_largest_pressure_is_at_its_place(case: str, shipped: dict[str, Run]):
    """In the row at that time, and no row at a peak of a force or of Hertz's pressure has a larger one."""
    run = read_data(shipped[case].file)
    s, contact = run.results, run.results["pmax_contact"]
    patch = max(run_patches(run, int(np.abs(run.time - s["t_pmax"]).argmin()), [contact]), key=lambda one: one.largest)
    assert patch.largest == pytest.approx(s["pmax"], rel=1e-5)
    peak = patch.track[patch.p.max(axis=0).argmax()]
    assert np.hypot(*(peak - [s["pmax_y"], s["pmax_z"]])) < 1.5*(patch.s[1] - patch.s[0])
    for one in CONTACTS:
        force = run.values(f"N_{one}")
        # Hertz's pressure grows with N^(1/3) and with the curvature of the place: rows that differ in it, by the contact angle.
        angle = np.nan_to_num(run.values(f"angle_{one}"))
        classes = np.digitize(angle, np.radians([5, 20, 40, 55, 65]))
        for k in {int(np.where(classes == c, force, 0).argmax()) for c in np.unique(classes[force > 0])}:
            for found in run_patches(run, k, [one], 24):
                assert found.largest < 1.03*s["pmax"], (one, k)


def test_a_finer_grid_changes_little(run: RunData):
    k = run.first_interval("LF").top
    assert k is not None
    coarse, fine = (run_patches(run, k, ["LF"], elements)[0] for elements in (32, 64))
    for name in "integral", "largest", "area", "half_x", "half_s":
        assert getattr(coarse, name) == pytest.approx(getattr(fine, name), rel=0.04), name
    with pytest.raises(ValueError, match="multiple of 4"):
        run_patches(run, k, ["LF"], 30)


def test_what_has_no_pressure(run: RunData, table: ContactTable, tmp_path: Path):
    with pytest.raises(Error, match="expected poses within &table"):
        table.pressure(1.0, table.equilibrium, 0.0)
    assert table.pressure(0.0, table.rigid_height + 1e-3, 0.0) == []
    rigid = ContactTable(run.case.replace(formulation="unilateral"))
    with pytest.raises(Error, match="formulation: expected 'elastic', which has pressures"):
        rigid.pressure(0.0, 0.457, 0.0)
    # Another code's file has an empty place in the summary.
    other = tmp_path/"other.txt"
    other.write_text("time Y\n0 0\n1 0\n")
    assert {summary_row(read_data(other))[name] for name in ("pmax", "pmax_LF", "patch_LF", "approach_LF")} == {None}
    changed = tmp_path/"changed.txt"
    changed.write_text(run.file.read_text().replace("CRC-32 ", "CRC-32 0"))
    with pytest.raises(Error, match="found one that has changed"):
        run_patches(read_data(changed), 0)
