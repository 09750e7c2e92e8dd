"""SciPy's DOP853 against the core's integrator.

M q'' = f(t) - dU/dq, q = (y, z, roll), is integrated once more from the shipped initial conditions, by DOP853 (Dormand and
Prince, order 8 with step control) with relative tolerances 1e-12 and 3e-14 (SciPy's least is 2e-14) and steps of at most 50
and 25 µs. It has nothing in common with the core's integrator but the force.

The core's step is explicit, of fourth order, and cut into 2, 4, ... where it changes the total energy by more than a
tolerance. That change goes with the fifth power of the step, so a setting with half the step has a 32nd of the tolerance. A
step that a contact touches in, where F begins as the 3/2 power of the penetration, makes an error of order 2.5 only: from one
setting to the next errors go down 2^2.5 = 5.7 times at least. Step error of the shipped setting s between the coarser c and
the finer f: the larger of |s - f|/(1 - 1/5.7) and |c - s|/(5.7 - 1), so that none is small by chance.

Bar of the deviation: step error and what DOP853 changes between its settings, an upper bound of its error with the second.
Event times: the motion's bar over the speed of what happens, and what the rule of the core that finds times within a step
misses on DOP853's motion: contacts touch where the penetration, from its size and rate at the end of the step, was zero,
whatever the load of the tread does in the step; passages of the centre are interpolated linearly. Peaks: the motion's bar
times the derivatives of the force, and what a parabola through three values of DOP853's force misses. In all of them with the
longest step that the core may have taken there, found by halving the step until the core does not cut it.

Exercise 5 loses its memory once the wheelset rattles on the flange. It is compared until the bar reaches 10 µm.
"""
from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

import ldbench
from checks import Check, Section, absolute, limit
from independent import SIZES, rates_of, start_of
from ldbench import Case, ContactTable, Run
from ldbench._core import flat
from ldbench.constants import CONTACTS
from ldbench_round.fingerprint import half_space_softness
from sheets import Table

PAIRS = "aw", "sw"
CASES = [(exercise, pair) for exercise in (1, 2, 3, 4, 5) for pair in PAIRS]
SHORT = [(2, "aw")]

# Settings of DOP853: relative tolerance and longest step [s]. The second is the reference, their difference its error. A longer
# step may pass through a contact, and error control does not see all kinks of the force: the steps tell what these cost.
SETTINGS = (1e-12, 5e-5), (3e-14, 2.5e-5)
LADDER = 4.0, 2.0, 1.0, 0.5     # settings of the core: steps over the shipped one
SHIPPED = LADDER.index(1.0)
LEAST = 2**2.5                  # by which errors go down from one to the next, at least
MEANINGFUL = 1e-5               # a case is compared until its bar reaches this, 0.1 % of the clearance [m, rad]
RAMP_END = 0.9                  # of exercise 5: the core's settings have parted by then [s]
FLANGE_ANGLE = np.radians(25)   # of a contact of the flange; smaller angles are those of its root
JUST_AFTER = 2e-5               # a contact has closed, its angle is told [s]
SAMPLES = 1e-5, 1e-7            # in which the peaks of DOP853's forces are looked for [s]
LARGEST_FACTOR = 1.5            # of the influence of two contacts over that of their loads: `match_energy` in zone_influence
INFLUENCE_SLOPE = 1300.0        # of its relative change over the penetration [1/m]: in the table of ex1_aw up to 3 % in 22 um
NEARBY = 1e-7                   # for differences of forces [m, rad]

COORDINATES = ("Y", "m"), ("Z", "m"), ("roll", "rad")
FLANGES = (("left", "LF"), ("right", "RF"))

@dataclass
class Reference:
    """A motion by DOP853."""

    state: Callable[[np.ndarray], np.ndarray]   # y, z, roll and their rates at times; z from equilibrium
    touches: dict[str, float]                   # first contacts of the flange, not of its root [s]
    passages: np.ndarray                        # of the centre [s]
    acceleration: Callable[[float], np.ndarray]


def integrate(case: Case, table: ContactTable, t_end: float, tolerance: float, max_step: float) -> Reference:
    """Integrate a case by DOP853 up to t_end; z is the axle's height."""
    rates, handle = rates_of(case, table), table._handle

    def force_of(contact: str, pose: Sequence[float]) -> np.ndarray:
        k = 3*CONTACTS.index(contact)
        return flat.contact_values(handle, 0, 12, *pose)[0][k:k + 3]

    def closes(contact: str) -> Callable[[float, np.ndarray], float]:
        def sign(t: float, x: np.ndarray) -> float:
            return 1.0 if force_of(contact, x[:3]).any() else -1.0

        sign.direction = 1.0
        return sign

    found = solve_ivp(rates, (0, t_end), start_of(case, table), "DOP853", dense_output=True, rtol=tolerance, max_step=max_step,
                      atol=tolerance*SIZES,
                      events=[closes("LF"), closes("RF"), lambda t, x: x[0]])
    if not found.success:
        raise ldbench.Error(f"DOP853: {found.message}")
    left, right, passages = found.t_events

    def on_flange(contact: str, t: float) -> bool:
        force = force_of(contact, found.sol(min(t + JUST_AFTER, t_end))[:3])
        side = 1 if contact == "LF" else -1
        return bool(np.arctan2(-side*force[0], force[1]) >= FLANGE_ANGLE)

    rest = np.array([0, table.equilibrium, 0, 0, 0, 0])
    return Reference(lambda t: found.sol(t).T - rest,
                     {c: found_on[0] for c, times in (("LF", left), ("RF", right))
                      if (found_on := [t for t in times if on_flange(c, t)])},
                     passages[passages > 0], lambda t: rates(t, found.sol(t))[3:])


def normal_force(table: ContactTable, contact: str, q: np.ndarray) -> np.ndarray:
    """The normal force of a contact at poses (..., 3), z from equilibrium [N]."""
    y, z, roll = np.moveaxis(q[..., :3], -1, 0)
    force = table.forces_by_contact(y, table.equilibrium + z, roll)[..., CONTACTS.index(contact), :]
    return np.hypot(force[..., 0], force[..., 1])


def peak(reference: Reference, table: ContactTable, contact: str, t_end: float) -> tuple[float, float]:
    """Time [s] and size [N] of the largest normal force of a contact."""
    begin, end = 0.0, t_end
    for spacing in SAMPLES:
        t = np.arange(begin, end, spacing)
        N = normal_force(table, contact, reference.state(t))
        t_peak = t[N.argmax()]
        begin, end = max(0.0, t_peak - spacing), min(t_end, t_peak + spacing)
    return float(t_peak), float(N.max())


STATE = {"Y": "Y", "Z": "Z", "initial_roll": "roll", "vY": "vY", "vZ": "vZ", "roll_rate": "roll_rate"}


def longest_step(run: Run, t: float) -> float:
    """That may hold t: the longest half, quarter ... of an output interval that the core does not cut [s]."""
    row = int(np.searchsorted(run.data["time"], t, "right")) - 1
    state, h = run.data.iloc[row], run.case.interval
    while True:
        case = run.case.replace(
            **{name: state[column] for name, column in STATE.items()}, stop_at="t_end", t_end=h, interval=h, dt=h,
            lateral_force=run.case.lateral_force + run.case.lateral_ramp*state["time"])
        if h <= run.case.dt*(1 + 1e-9) and not ldbench.run(case, table=run.table).results["cuts"]:
            return h
        h /= 2
        if t >= state["time"] + h:
            middle = ldbench.run(case.replace(t_end=h, interval=h, dt=h), table=run.table).data.iloc[-1].copy()
            middle["time"] += state["time"]
            state = middle


def distance(run: Run, contact: str, t: float) -> tuple[float, float]:
    """How far a flange contact that closes at t is from the place of the tread contact [m], and its rate [m/s]; NaN without one."""
    tread = run.data[run.data["time"] <= t].iloc[-1]
    rows = run.data[(run.data["time"] > t) & (run.data[f"N_{contact}"] > 0)].iloc[:2]
    r = np.hypot(*(rows[f"{axis}_{contact}"].to_numpy() - tread[f"{axis}_{contact[0]}T"] for axis in "yz"))
    return r[0], (r[1] - r[0])/np.diff(rows["time"])[0]


def touch_error(reference: Reference, run: Run, contact: str, t: float, h: float) -> float:
    """The error of the time at which a contact touched, found from p and p' up to h later, N ~ p^1.5 [s].

    The core takes the rate p' of the undeformed surface. That of the surface which the tread's load N lowers by c N is another
    one, by a share of which the error is as large. It is c N', and half of c' N: the core's force on a contact has the other
    half. The influence c goes with the inverse of their distance, and changes a little with the penetration."""
    table = run.table
    late = np.linspace(h/20, h, 20)
    motion = reference.state(t + late)
    p = normal_force(table, contact, motion)**(2/3)
    bend, rate = np.polyfit(late, p/late, 1)
    y, z, roll = motion[:, :3].T
    force = table.forces_by_contact(y, table.equilibrium + z, roll)[:, CONTACTS.index(contact)]
    closing = np.abs(np.sum(force*motion[:, 3:], axis=1))/np.hypot(force[:, 0], force[:, 1])
    load = normal_force(table, contact[0] + "T", motion)
    r, rate_of_r = distance(run, contact, t)
    influence = LARGEST_FACTOR*half_space_softness(table.case)/r
    lowering = np.nan_to_num(influence*(np.abs(np.gradient(load, late)) + load/2*(abs(rate_of_r)/r + INFLUENCE_SLOPE*closing)))
    return np.max(np.abs(bend*late**2/(rate + 2*bend*late))) + np.max(np.abs(lowering/closing)*late)


def peak_error(reference: Reference, table: ContactTable, contact: str, t: float, h: float) -> float:
    """The error of a peak at t that is taken from a parabola through three values h apart [N]."""
    middle = t + h*np.linspace(-0.5, 0.5, 21)
    before, at, after = (normal_force(table, contact, reference.state(middle + k*h)) for k in (-1, 0, 1))
    found = at - (after - before)**2/(8*(after - 2*at + before))
    return np.max(np.abs(found - normal_force(table, contact, reference.state(t))))


def refined(case: Case, factor: float) -> Case:
    """A case with steps `factor` as long, an energy tolerance that goes with them, and rows at equal intervals alone."""
    return case.replace(rows="interval", dt=factor*case.dt, interval=max(case.interval, factor*case.dt),
                        energy_tolerance=factor**5*case.energy_tolerance,
                        error_tolerance=factor**5*case.error_tolerance)


@dataclass
class Trajectories:
    """A case by the core with the settings of LADDER and by DOP853 with two settings, at common output times."""

    name: str
    dt: float                   # the shipped step [s]
    t: np.ndarray
    end: float                  # of the comparison [s]
    core: list[np.ndarray]      # (row, coordinate) per setting
    dop: list[np.ndarray]       # per setting

    def __post_init__(self) -> None:
        coarser, ours, finer = self.core[SHIPPED - 1:SHIPPED + 2]
        steps = np.maximum(np.abs(coarser - ours)/(LEAST - 1), np.abs(ours - finer)/(1 - 1/LEAST))
        self.step_error = np.maximum.accumulate(steps)          # of the core with the shipped setting, the largest so far
        self.tolerance_error = np.maximum.accumulate(np.abs(self.dop[0] - self.dop[1]))     # of DOP853
        self.bar = self.step_error + self.tolerance_error
        self.deviation = np.abs(ours - self.dop[1])
        beyond = (self.bar > MEANINGFUL).any(axis=1)
        self.rows = int(beyond.argmax()) if beyond.any() else len(self.t)       # up to which the comparison means something
        self.last = self.t[self.rows - 1] if beyond.any() else self.end         # time up to which it does [s]

    def bar_at(self, t: float) -> np.ndarray:
        return self.bar[min(np.searchsorted(self.t, t), len(self.t) - 1)]


def common_rows(runs: list[Run], end: float) -> list[pd.DataFrame]:
    """The rows that the runs have in common, up to a time."""
    coarsest = max(run.case.interval for run in runs)
    count = int(end/coarsest + 1e-6) + 1
    return [run.data.iloc[::round(coarsest/run.case.interval)].iloc[:count] for run in runs]


def motion_checks(found: Trajectories) -> list[Check]:
    n, deviation, bar = found.rows, found.deviation, found.bar
    until = f" to {found.t[n - 1]:.3f} s" if n < len(found.t) else ""
    return [limit(f"{found.name} largest deviation of {c}{until} [{unit}]", deviation[:n, i].max(),
                  "DOP853, bar step error + its settings", bar[n - 1, i]) for i, (c, unit) in enumerate(COORDINATES)]


def event_checks(found: Trajectories, run: Run, references: list[Reference]) -> list[Check]:
    """First flange contacts and passages of the centre while the comparison means something."""
    coarse, fine = references

    def motion_bar(t: float) -> float:
        """Bar of the lateral motion over its speed [s]."""
        return found.bar_at(t)[0]/abs(fine.state(t)[3])

    checks = []
    for side, contact in FLANGES:
        ours = [e.t for e in run.events if e.kind == f"{side} flange contact"]
        if contact in fine.touches and fine.touches[contact] < found.last and ours:
            t = fine.touches[contact]
            checks.append(absolute(f"{found.name} first {side} flange contact [s]", ours[0], t,
                                   "DOP853's event location, bar rule within the step + motion's bar/speed",
                                   touch_error(fine, run, contact, t, longest_step(run, t)) + motion_bar(t)
                                   + abs(t - coarse.touches[contact])))
    ours = [e.t for e in run.events if e.kind == "centre passage"]
    for k, (a, b, c) in enumerate(zip(ours, fine.passages, coarse.passages, strict=False), 1):
        if b < found.last:
            v, curve = fine.state(b)[3], fine.acceleration(b)[0]
            checks.append(absolute(f"{found.name} centre passage {k} [s]", a, b,
                                   "DOP853's event location, bar interpolation in the step + motion's bar/speed",
                                   abs(curve/v)*longest_step(run, b)**2/8 + motion_bar(b) + abs(b - c)))
    return checks


def peak_checks(found: Trajectories, run: Run, reference: Reference) -> list[Check]:
    """Largest normal forces of the flanges."""
    checks = []
    for side, contact in FLANGES:
        ours = run.results[f"peak_N_{contact}"]
        if ours > 0:
            t, fine = peak(reference, run.table, contact, found.end)
            h = longest_step(run, t)
            h = max(h, *(longest_step(run, t + k*h) for k in (-1, 1)))
            q = reference.state(t)[:3]
            N = [normal_force(run.table, contact, q + d*np.eye(3)) for d in (-NEARBY, NEARBY)]
            bar = (np.abs(N[1] - N[0])/(2*NEARBY) @ found.bar_at(t) + peak_error(reference, run.table, contact, t, h))
            checks.append(Check(f"{found.name} peak normal force, {side} flange [N], relative", ours, fine,
                                "DOP853, bar motion's bar x stiffness + parabola through three steps",
                                abs(ours/fine - 1), bar/fine))
    return checks


def deviation_row(found: Trajectories) -> list[str]:
    """Largest and last deviation of each coordinate, at the shipped step."""
    n, deviation = found.rows, found.deviation
    cells = [f"{x:.1e}" for i in range(3) for x in (deviation[:n, i].max(), deviation[n - 1, i])]
    return [found.name, f"{1e6*found.dt:g}", f"{found.t[n - 1]:.4f}", *cells,
            f"{found.step_error[n - 1].max():.1e}", f"{found.tolerance_error[n - 1].max():.1e}"]


def section(short: bool = False) -> Section:
    out = Section("Independent integration", __doc__)
    tables: dict[str, ContactTable] = {}
    found: list[Trajectories] = []
    for exercise, pair in SHORT if short else CASES:
        case = Case.exercise(exercise, pair)
        if pair not in tables:
            tables[pair] = ContactTable(case)
        table = tables[pair].for_case(case)
        runs = [ldbench.run(refined(case, factor), table=table) for factor in LADDER]
        shipped = runs[SHIPPED]
        end = min(shipped.results["t"], RAMP_END) if exercise == 5 else shipped.results["t"]
        references = [integrate(case, table, end, *setting) for setting in SETTINGS]
        rows = common_rows(runs, min(run.results["t"] for run in runs))
        t = rows[0]["time"].to_numpy()
        t = t[t <= end*(1 + 1e-12)]
        motion = Trajectories(case.case_name, case.dt, t, end, [r[[c for c, _ in COORDINATES]].to_numpy()[:len(t)] for r in rows],
                              [r.state(t)[:, :3] for r in references])
        out.checks += motion_checks(motion) + event_checks(motion, shipped, references)
        if exercise < 5:        # the run's peaks lie in the time compared
            out.checks += peak_checks(motion, shipped, references[-1])
        found.append(motion)
    head = ["case", "dt [µs]", "compared to [s]", *(f"{c}, {word} [{unit}]" for c, unit in COORDINATES
                                                    for word in ("largest", "last")), "step error", "DOP853's error"]
    out.tables.append(Table("Deviation of the core from DOP853", head, [deviation_row(case) for case in found]))
    return out
