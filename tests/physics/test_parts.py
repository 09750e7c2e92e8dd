"""Tread and flange as parts of the wheel, on a pair whose contact moves from one to the other without a gap: S1002 on 60E1."""
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

import ldbench
from ldbench import Case, read_run, run
from ldbench.constants import CONTACTS
from probes import MODERN, ROLL_INERTIA, WEIGHT, probe, text
from running import Run as Shipped, kept_tables

USUAL = 0.4363                               # flange_angle [rad]
SPEEDS = 0.2, 0.3, 0.4                       # lateral velocities [m/s]; the first turns back below the flange
STEPS = 2e-5, 1e-4, 5e-4                     # [s]
STEEP = float(np.radians(27))


def thrown(vy: float, **changes: object) -> Case:
    """The wheelset with a lateral velocity, until it is back."""
    return Case(**MODERN).replace(**{
        "vY": vy, "roll_rate": vy/30, "dt": 1e-4, "interval": 5e-4, "t_end": 0.3, "judged": "no",
        "pressures": "no", "stop_at": "return_to_centre", "table_folder": kept_tables()} | changes)


def poses(done: ldbench.Run) -> np.ndarray:
    """y, height of the axle, roll of every row."""
    d = done.data
    return np.column_stack([d.Y, done.results["axle_height"] + d.Z, done.results["axle_roll"] + d.roll])


@pytest.fixture(scope="module")
def back() -> Callable[..., ldbench.Run]:
    """A run for each set of values, once."""
    kept: dict = {}

    def made(vy: float, **changes: object) -> ldbench.Run:
        key = (vy, *sorted(changes.items()))
        if key not in kept:
            kept[key] = run(thrown(vy, **changes))
        return kept[key]

    return made


@pytest.mark.parametrize("angle", [USUAL, 0.8])
def test_a_part_has_the_loads_of_its_elements(angle: float, back: Callable, tmp_path: Path):
    """The force of each part is within 2 % of the wheel's force of what half-spaces put on the elements on its side of the
    border, while the contact moves over it, and where the wheel presses hardest."""
    runs = [back(vy) for vy in SPEEDS]
    chosen = []
    for done in runs:
        d = done.data
        there = np.flatnonzero((d.Y > 3e-3) & (d.N_LT + d.N_LF > 2e3))
        chosen.append(poses(done)[there[::max(1, len(there)//10)]])
    done.case.replace(flange_angle=angle).to_namelist(tmp_path/"case.nml")
    found = probe("wheel_parts", tmp_path/"case.nml", stdin=text(np.concatenate(chosen)))
    assert found[:, 12].all()
    table, direct = found[:, :6].reshape(-1, 2, 3), found[:, 6:12].reshape(-1, 2, 3)
    whole = np.hypot(*direct.sum(axis=1)[:, :2].T)
    error = np.hypot(*np.moveaxis(table - direct, 2, 0)[:2])/whole[:, None]
    share = np.hypot(*direct[:, 1, :2].T)/whole
    if angle < 0.5:
        assert np.count_nonzero((share > 0.05) & (share < 0.95)) >= 3
    assert error.max() <= 0.02
    # A part that carries a quarter of the force has the angle of its loads.
    size = np.hypot(*np.moveaxis(direct, 2, 0)[:2])
    angles = [np.degrees(np.arctan2(-x[..., 0], x[..., 1])) for x in (table, direct)]
    assert np.abs(angles[0] - angles[1])[size > 0.25*whole[:, None]].max() < 2.0


def test_the_border_moves_nothing(back: Callable):
    """Motion, sums of forces and end are the same whatever the border, bit by bit where they do not depend on the parts."""
    usual, other = back(0.3), back(0.3, flange_angle=STEEP)
    assert other.results["t_return"] == usual.results["t_return"]
    rows = [d[np.rint(d.time/5e-4)*5e-4 == d.time].reset_index() for d in (usual.data, other.data)]
    assert len(rows[0]) == len(rows[1]) > 100 and not rows[0].N_LF.equals(rows[1].N_LF)
    for name in "Y", "Z", "roll", "vY", "aY", "aZ", "roll_acc", "E_total":
        assert rows[0][name].equals(rows[1][name]), name
    for side in "L", "R":
        for force in "Fy", "Fz":
            sums = [d[f"{force}_{side}T"] + d[f"{force}_{side}F"] for d in rows]
            assert np.abs(sums[0] - sums[1]).max() <= 1e-8*WEIGHT


def test_moments_of_the_parts_turn_the_wheelset(back: Callable):
    """The forces of both parts, at their points in the columns, have the moment that the accelerations tell."""
    done = back(0.3)
    d = done.data
    moment = sum(((d[f"y_{k}"] - d.Y)*d[f"Fz_{k}"] - (d[f"z_{k}"] - done.results["axle_height"] - d.Z)*d[f"Fy_{k}"]).fillna(0)
                 for k in CONTACTS)
    assert ((d.N_LT > 0) & (d.N_LF > 0)).sum() > 20
    assert np.abs(moment - ROLL_INERTIA*d.roll_acc).max() < 1e-8*WEIGHT


def test_the_flange_s_force_grows_from_zero(back: Callable):
    """At 0.3 m/s the contact moves onto the flange and back, without a jump of either force: over 10 us the shares of the
    wheel's force change by less than 1 %. What the elements beyond 25 degrees carry is 66 kN at most, not the wheel's 118 kN."""
    done = back(0.3, dt=1e-5, interval=1e-5, rows="interval", t_end=0.09, stop_at="t_end")
    d = done.data
    early = d[d.time < done.results["t_first_centre"]]
    whole = np.hypot(early.Fy_LT + early.Fy_LF, early.Fz_LT + early.Fz_LF)
    for name in "N_LT", "N_LF":
        assert np.abs(np.diff(early[name]/whole)).max() < 0.01
    # Once, from zero and to zero.
    on = early.N_LF.to_numpy() > 0
    assert np.count_nonzero(np.diff(on.astype(int)) == 1) == 1
    assert early.N_LF[on].iloc[[0, -1]].max() < 0.005*whole.max()
    assert done.results["first_peak_N_LF"] == pytest.approx(66.7e3, rel=0.02)
    assert early.N_LT.min() > 0.2*WEIGHT/2
    first = d[(d.time >= done.results["t_first_LF"]) & (d.time <= done.results["t_first_LF"] + done.results["first_duration_LF"])]
    assert np.trapezoid(first.N_LF, first.time) == pytest.approx(done.results["first_impulse_LF"], rel=1e-4)


@pytest.mark.parametrize(("vy", "angle"), [(0.4, USUAL), pytest.param(0.3, STEEP, marks=pytest.mark.slow)])
def test_times_of_events_do_not_depend_on_the_step(vy: float, angle: float, back: Callable):
    """Flange contacts, lift-offs, landings and passages until the wheelset is back, for three steps: within a nanosecond on the
    way to the left flange; afterwards the motions differ, too."""
    times = []
    for dt in STEPS:
        done = back(vy, dt=dt, flange_angle=float(angle))
        first = done.results["t_first_centre"]
        times.append([(e.kind, e.cause, e.t) for e in done.events if e.t <= first])
        assert done.events[0].cause == "moves"
    assert all([e[:2] for e in other] == [e[:2] for e in times[0]] for other in times)
    for other in times[1:]:
        assert np.abs(np.array([e[2] for e in other]) - [e[2] for e in times[0]]).max() < 1e-9


@pytest.mark.parametrize("dt", STEPS[1:])
def test_the_row_of_an_event_shows_it(dt: float, back: Callable):
    """A flange contact's row has its force and its angle; a wheel's landing has a force, its lift-off none."""
    done = back(0.4, dt=dt)
    d = done.data
    seen = 0
    for e in done.events:
        side = "LR"["right" in e.kind]
        row = d.iloc[int(np.abs(d.time - e.t).argmin())]
        assert abs(row.time - e.t) < 1e-7
        if e.kind.endswith("flange contact"):
            seen += 1
            assert row[f"N_{side}F"] > 0
            assert row[f"angle_{side}F"] == pytest.approx(e.angle, abs=np.radians(0.2))
        if e.kind.endswith("landing"):
            assert row[f"N_{side}T"] + row[f"N_{side}F"] > 0
        if e.kind.endswith("lift-off"):
            assert row[f"N_{side}T"] + row[f"N_{side}F"] == 0
    assert seen >= 3


def test_a_contact_that_closes_says_so(back: Callable, shipped: dict[str, Shipped]):
    """The shipped wheel jumps onto its flange, and S1002 lands on its own after a flight."""
    events = read_run(shipped["ex2_aw"].file).events
    assert next(e for e in events if e.kind == "left flange contact").cause == "closes"
    causes = [e.cause for e in back(0.4).events if e.kind == "left flange contact"]
    assert causes == ["moves", "closes"]


def test_the_return_follows_turns(back: Callable):
    """At 0.2 m/s no flange is touched; the run ends when the wheelset is back at the centre after both sides, and says so."""
    below = back(0.2)
    assert below.success
    assert below.ending == "return to the centre, turned back below both flanges"
    assert below.results["peak_N_LF"] == below.results["peak_N_RF"] == 0
    way = CubicHermiteSpline(*below.data[["time", "Y", "vY"]].drop_duplicates("time").to_numpy().T)
    farthest = way(way.derivative().roots(extrapolate=False))
    assert [below.results["farthest_left"], below.results["farthest_right"]] == pytest.approx(
        [farthest.max(), farthest.min()], abs=1e-10)
    crossed = np.flatnonzero(np.diff(np.signbit(below.data.Y[1:])))
    assert len(crossed) == 2
    assert below.results["t_return"] == pytest.approx(below.data.time.iloc[crossed[1] + 1], abs=5e-4)
    assert back(0.3).ending == "return to the centre after both flanges"
    # A force to the left keeps the wheelset off the right flange, or with the other sign off the left one.
    for force, flange in (4e3, "right"), (-4e3, "left"):
        pushed = run(thrown(0.3, lateral_force=force))
        assert pushed.ending == f"return to the centre, turned back below the {flange} flange"
        assert (pushed.results["peak_N_RF"] == 0) == (flange == "right")
