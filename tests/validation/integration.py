"""Another integrator on the core's force: SciPy's DOP853 against the core's integrator."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import ldbench
from checks import Check, Section, absolute, limit
from independent import SIZES, rates_of, start_of
from ldbench import Case, ContactTable, Run
from ldbench._core import _flat
from ldbench.plots.style import BLACK, BLUE, GREEN, GREY, RED, SERIES, ldbench_style
from ldbench_round.fingerprint import half_space_softness
from sheets import Table, page

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
NEARBY = 1e-7                   # for differences of forces [m, rad]

COORDINATES = ("Y", "m"), ("Z", "m"), ("roll", "rad")
FLANGES = (("left", "LF"), ("right", "RF"))
CONTACTS = "LT", "LF", "RT", "RF"

TEXT = """M q'' = f(t) - dU/dq, q = (y, z, roll), is integrated once more from the shipped initial conditions, by
SciPy's DOP853 (Dormand and Prince, order 8 with step control) with relative tolerances 1e-12 and 3e-14 (SciPy's least
is 2e-14) and steps of at most 50 and 25 µs. It has nothing in common with the core's integrator but the force,
ldbench.ContactTable.force.

The core's step is explicit, of fourth order, and cut into 2, 4, ... where it changes the total energy by more than a
tolerance. That change goes with the fifth power of the step, so a setting with half the step has a 32nd of the
tolerance. A step that a contact touches in, where F begins as the 3/2 power of the penetration, makes an error of order
2.5 only, and so much smaller as the tolerance where that cuts it. From one setting to the next errors e go down 2^2.5 =
5.7 times at least. Step error of the shipped setting s between the coarser c and the finer f: the larger of |s - f|/(1
- 1/5.7) and |c - s|/(5.7 - 1), so that it is not small by chance in one of them.

Bar of the deviation: step error and what DOP853 changes between its settings, an upper bound of its error with the
second: kinks of the force make errors of order 2.5 of the step, so the first misses 5.7 times as much. Event
times: the motion's bar over the speed of what happens, and what the rule of the core that finds times within a step
misses on DOP853's motion: contacts touch where the penetration, from its size and rate at the end of the step, was
zero, whatever the load of the tread does in the step; passages of the centre are interpolated linearly. Peaks: the
motion's bar times the derivatives of the force, and what a parabola through three values of DOP853's force misses. In
all of them with the longest step that the core may have taken there, which is found by halving the step until the core
does not cut it.

In exercises 2 to 4 steps hardly matter: what is left of the deviation is mostly DOP853's, which shrinks with its
tolerance, and both come near to what round-off grows to by the impacts.

Exercise 5 loses its memory once the wheelset rattles on the flange. It is compared until the bar reaches 10 µm. Each
finer setting agrees for longer, by about the time in which the distance grows as many times as the error has become
smaller: another 0.1 s for a factor of ten.

The tables after the first give the numbers of outputs/summary.csv, the state at the end, their step errors as above and
the observed order, from the settings with twice and half the shipped step, at the output times that all have. 'none':
what is left is round-off, or a matter of where steps happen to begin, as in peaks; the error is then no less than the
spread of the three. 'chaotic': the number does not converge because the motion is chaotic; the error is the spread."""


# DOP853 -----------------------------------------------------------------------------------

@dataclass
class Reference:
    """A motion by DOP853."""

    state: Callable[[np.ndarray], np.ndarray]   # y, z, roll and their rates at times; z from equilibrium
    touches: dict[str, float]                   # first contacts of the flange, not of its root [s]
    passages: np.ndarray                        # of the centre [s]
    acceleration: Callable[[float], np.ndarray]


def integrate(case: Case, table: ContactTable, t_end: float, tolerance: float, max_step: float) -> Reference:
    """Integrate a case by DOP853 up to t_end; z is the axle's height."""
    rates, contact_forces, handle = rates_of(case, table), _flat.contact_forces, table._handle

    def closes(contact: str) -> Callable[[float, np.ndarray], float]:
        k = CONTACTS.index(contact)

        def sign(t: float, x: np.ndarray) -> float:
            return 1.0 if contact_forces(handle, x[0], x[1], x[2])[0][:, k].any() else -1.0

        sign.direction = 1.0
        return sign

    found = solve_ivp(rates, (0, t_end), start_of(case, table), "DOP853", dense_output=True, rtol=tolerance, max_step=max_step,
                      atol=tolerance*SIZES,
                      events=[closes("LF"), closes("RF"), lambda t, x: x[0]])
    if not found.success:
        raise ldbench.Error(f"DOP853: {found.message}")
    left, right, passages = found.t_events

    def on_flange(contact: str, t: float) -> bool:
        y, z, roll = found.sol(min(t + JUST_AFTER, t_end))[:3]
        force = contact_forces(handle, y, z, roll)[0][:, CONTACTS.index(contact)]
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


# What the core's rules miss within a step --------------------------------------------------

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
    """Of a flange's contact that closes at t from where the tread was in contact [m], and its rate [m/s]; NaN if it was not."""
    tread = run.data[run.data["time"] <= t].iloc[-1]
    rows = run.data[(run.data["time"] > t) & (run.data[f"N_{contact}"] > 0)].iloc[:2]
    r = np.hypot(*(rows[f"{axis}_{contact}"].to_numpy() - tread[f"{axis}_{contact[0]}T"] for axis in "yz"))
    return r[0], (r[1] - r[0])/np.diff(rows["time"])[0]


def touch_error(reference: Reference, run: Run, contact: str, t: float, h: float) -> float:
    """The error of the time at which a contact touched, found from p and p' up to h later, N ~ p^1.5 [s].

    The core takes the rate p' of the undeformed surface. That of the surface which the tread's load N lowers by c N is another
    one, by a share of which the error is as large. It is c N', and half of c' N: the core's force on a contact has the other
    half. The influence c goes with the inverse of their distance."""
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
    lowering = np.nan_to_num(influence*(np.abs(np.gradient(load, late)) + load/2*abs(rate_of_r)/r))
    return np.max(np.abs(bend*late**2/(rate + 2*bend*late))) + np.max(np.abs(lowering/closing)*late)


def peak_error(reference: Reference, table: ContactTable, contact: str, t: float, h: float) -> float:
    """The error of a peak at t that is taken from a parabola through three values h apart [N]."""
    middle = t + h*np.linspace(-0.5, 0.5, 21)
    before, at, after = (normal_force(table, contact, reference.state(middle + k*h)) for k in (-1, 0, 1))
    found = at - (after - before)**2/(8*(after - 2*at + before))
    return np.max(np.abs(found - normal_force(table, contact, reference.state(t))))


# Comparison -------------------------------------------------------------------------------

def refined(case: Case, factor: float) -> Case:
    """A case with steps `factor` as long, an energy tolerance that goes with them, and rows at equal intervals alone."""
    return case.replace(rows="interval", dt=factor*case.dt, interval=max(case.interval, factor*case.dt),
                        energy_tolerance=factor**5*case.energy_tolerance)


def step_error(coarser: np.ndarray, ours: np.ndarray, finer: np.ndarray) -> np.ndarray:
    """Error of ours by its distance to the settings with twice and half the step."""
    return np.maximum(np.abs(coarser - ours)/(LEAST - 1), np.abs(ours - finer)/(1 - 1/LEAST))


@dataclass
class Trajectories:
    """A case by the core with the settings of LADDER and by DOP853 with two settings, at common output times."""

    name: str
    dt: float                   # the shipped step [s]
    t: np.ndarray
    end: float                  # of the comparison [s]
    core: list[np.ndarray]      # (row, coordinate) per setting
    dop: list[np.ndarray]       # per setting

    def step_error(self) -> np.ndarray:
        """The error of the core with the shipped setting, the largest so far."""
        k = SHIPPED
        return np.maximum.accumulate(step_error(*self.core[k - 1:k + 2]))

    def tolerance_error(self) -> np.ndarray:
        """The error of DOP853, the largest so far."""
        return np.maximum.accumulate(np.abs(self.dop[0] - self.dop[1]))

    def bar(self) -> np.ndarray:
        return self.step_error() + self.tolerance_error()

    def bar_at(self, t: float) -> np.ndarray:
        return self.bar()[min(np.searchsorted(self.t, t), len(self.t) - 1)]

    def deviation(self, k: int) -> np.ndarray:
        """The deviation of the core with setting k from DOP853."""
        return np.abs(self.core[k] - self.dop[1])

    @property
    def rows(self) -> int:
        """Up to which the comparison means something."""
        beyond = (self.bar() > MEANINGFUL).any(axis=1)
        return int(beyond.argmax()) if beyond.any() else len(self.t)

    @property
    def last(self) -> float:
        """Time up to which it does [s]."""
        return self.t[self.rows - 1] if self.rows < len(self.t) else self.end


def common_rows(runs: list[Run], end: float) -> list[pd.DataFrame]:
    """The rows that the runs have in common, up to a time."""
    coarsest = max(run.case.interval for run in runs)
    count = int(end/coarsest + 1e-6) + 1
    return [run.data.iloc[::round(coarsest/run.case.interval)].iloc[:count] for run in runs]


def trajectories(case: Case, rows: list[pd.DataFrame], references: list[Reference], end: float) -> Trajectories:
    t = rows[0]["time"].to_numpy()
    t = t[t <= end*(1 + 1e-12)]
    core = [r[[c for c, _ in COORDINATES]].to_numpy()[:len(t)] for r in rows]
    return Trajectories(case.case_name, case.dt, t, end, core, [r.state(t)[:, :3] for r in references])


def motion_checks(found: Trajectories) -> list[Check]:
    n, deviation, bar = found.rows, found.deviation(SHIPPED), found.bar()
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
    n, deviation = found.rows, found.deviation(SHIPPED)
    cells = [f"{x:.1e}" for i in range(3) for x in (deviation[:n, i].max(), deviation[n - 1, i])]
    return [found.name, f"{1e6*found.dt:g}", f"{found.t[n - 1]:.4f}", *cells,
            f"{found.step_error()[n - 1].max():.1e}", f"{found.tolerance_error()[n - 1].max():.1e}"]


# Error bars of the summary ----------------------------------------------------------------

NUMBERS = {                     # name: unit, factor from SI; the names of ldbench.results.summary.summary_row
    "t_first_LF": ("ms", 1e3), "t_first_RF": ("ms", 1e3), "t_first_centre": ("ms", 1e3), "t_return": ("ms", 1e3),
    "t_derailment": ("ms", 1e3), "F_derailment": ("kN", 1e-3),
    **{f"{c}_{end}": ("mm", 1e3) for c in ("Y", "Z") for end in ("min", "max", "last")},
    **{f"roll_{end}": ("mrad", 1e3) for end in ("min", "max", "last")},
    **{f"peak_N_{c}": ("kN", 1e-3) for c in CONTACTS}, **{f"t_peak_{c}": ("ms", 1e3) for c in CONTACTS}}


def numbers(run: Run, rows: pd.DataFrame) -> dict[str, float]:
    """The run's numbers in the summary table [SI]; extremes and last state are those of `rows`."""
    first: dict[str, float] = {}
    for event in run.events:
        first.setdefault(event.kind, event.t)
    touch = first.get("left flange contact", np.inf)
    passages = [e.t for e in run.events if e.kind == "centre passage" and e.t > touch]
    found = {"t_first_LF": touch, "t_first_RF": first.get("right flange contact"),
             "t_first_centre": passages[0] if passages else None,
             "t_return": passages[-1] if passages and run.ending.startswith("return") else None,
             "t_derailment": first.get("derailment")}
    if run.case.lateral_ramp and "derailment" in first:
        found["F_derailment"] = run.case.lateral_force + run.case.lateral_ramp*first["derailment"]
    for c, _ in COORDINATES:
        x = rows[c].to_numpy()
        found |= {f"{c}_min": x.min(), f"{c}_max": x.max(), f"{c}_last": x[-1]}
    for c in CONTACTS:
        if run.results[f"peak_N_{c}"] > 0:
            found |= {f"peak_N_{c}": run.results[f"peak_N_{c}"], f"t_peak_{c}": run.results[f"t_peak_{c}"]}
    return {name: float(x) for name, x in found.items() if x is not None}


def error_bar(x: np.ndarray, rattles: bool) -> tuple[float, str]:
    """Error of the second of three settings, and the observed order or why there is none.

    After thousands of impacts (`rattles`) three settings are three samples, whatever order they seem to have.
    """
    first, second = abs(x[0] - x[1]), abs(x[1] - x[2])
    spread, size = float(np.ptp(x)), float(np.abs(x).max())
    if rattles and spread > 1e-6*size:
        return spread, "chaotic"
    if first < 2*second:
        return max(spread, float(step_error(*x))), "none"
    order = np.log2(first/second) if second > 0 else np.inf
    return float(step_error(*x)), f"{order:.1f}" if order < 6 else "none"       # what is beyond is chance


def rounded(x: float, bar: float) -> str:
    """A number with as many decimals as its error bar has with two digits."""
    decimals = int(np.clip(1 - np.floor(np.log10(bar)), 0, 9)) if bar > 0 else 9
    return f"{x:.{decimals}f}"


def summary_cells(runs: list[Run], rows: list[pd.DataFrame], rattles: bool) -> dict[str, list[str]]:
    """Value, error bar and observed order of every number that the shipped run has."""
    cells = {}
    results = [numbers(run, of_run) for run, of_run in zip(runs, rows, strict=True)][SHIPPED - 1:SHIPPED + 2]
    for name, value in numbers(runs[SHIPPED], runs[SHIPPED].data).items():
        _unit, scale = NUMBERS[name]
        if any(name not in r for r in results):
            cells[name] = [f"{scale*value:.6g}", "", "chaotic"]     # it does not happen with every setting
            continue
        bar, order = error_bar(np.array([r[name] for r in results]), rattles)
        cells[name] = [rounded(scale*value, scale*bar), f"{scale*bar:.1e}", order]
    return cells


def summary_table(exercise: int, cells: dict[str, dict[str, list[str]]]) -> Table:
    """The numbers of an exercise, both pairs side by side."""
    pairs = list(cells)
    head = ["", *(f"{pair}: {word}" for pair in pairs for word in ("value", "error bar", "observed order"))]
    rows = [[f"{name} [{unit}]", *(cell for pair in pairs for cell in cells[pair].get(name, ["", "", ""]))]
            for name, (unit, _) in NUMBERS.items() if any(name in cells[pair] for pair in pairs)]
    return Table(f"Exercise {exercise}: numbers of the summary with error bars", head, rows)


# Figures ----------------------------------------------------------------------------------

def deviation_figure(found: list[Trajectories]) -> Figure:
    figure = page("Deviation of the core from DOP853 over time",
                  "Shipped steps, at output times. step error: from twice and half the step, largest coordinate so "
                  "far; DOP853's tolerance: what it changes between 1e-12 and 3e-14.\nExercise 5 is compared up to "
                  "the dotted line.")
    columns = max(1, -(-len(found)//2))
    axes = figure.subplots(2, columns, squeeze=False, sharey=True)
    for ax in axes.flat[len(found):]:
        ax.set_axis_off()
    for k, case in enumerate(found):
        ax = axes[k % 2, k//2] if len(found) > 2 else axes.flat[k]
        for i, (colour, (name, _)) in enumerate(zip((BLUE, RED, GREEN), COORDINATES, strict=True)):
            ax.semilogy(case.t, case.deviation(SHIPPED)[:, i].clip(1e-17), color=colour, linewidth=0.6, label=name)
        ax.semilogy(case.t, case.step_error().max(axis=1).clip(1e-17), color=BLACK, linewidth=1, label="step error")
        ax.semilogy(case.t, case.tolerance_error().max(axis=1).clip(1e-17), color=GREY, linestyle="--", linewidth=1,
                    label="DOP853's tolerance")
        if case.rows < len(case.t):
            ax.axvline(case.t[case.rows - 1], color=BLACK, linestyle=":", linewidth=0.8)
        ax.set(title=case.name, xlabel="time [s]", ylim=(1e-17, 1e-2))
    for ax in axes[:, 0]:
        ax.set_ylabel("deviation [m, rad]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="center right", bbox_to_anchor=(0.97, 0.955), ncols=5)
    return figure


def order_figure(found: list[Trajectories]) -> Figure:
    figure = page("Deviation of the core from DOP853 over the step", "Largest of Y, Z [m] and roll [rad] over the part "
                  "of the run that is compared; filled: the shipped setting; the energy tolerance goes with the fifth "
                  "power of the step.\nDotted, level: DOP853's own error, 1e-12 against 3e-14. Grey: order 2.5 and 4.")
    with_pair = [[case for case in found if case.name.endswith(pair)] for pair in PAIRS]
    for ax, pair, cases in zip(figure.subplots(1, 2, sharey=True), PAIRS, with_pair, strict=True):
        for line, case in zip(SERIES, cases, strict=False):
            error = [case.deviation(k)[:case.rows].max() for k in range(len(LADDER))]
            ax.loglog(LADDER, error, marker="o", markerfacecolor="none", **line.kwargs(), label=case.name)
            ax.loglog(1.0, error[SHIPPED], "o", color=line.color)
            own = case.tolerance_error()[case.rows - 1].max()
            ax.loglog([LADDER[0], LADDER[-1]], [own, own], ":", color=line.color, linewidth=0.8)
        h = np.array([LADDER[-1], LADDER[0]])
        for order in (2.5, 4):
            ax.loglog(h, 1e-12*(h/h[0])**order, color=GREY, linewidth=2.5, alpha=0.4)
            ax.text(h[1], 1e-12*(h[1]/h[0])**order, f" order {order:g}", color=GREY, va="center")
        ax.set(title={"aw": "actual profiles", "sw": "simplified profiles"}[pair], xlabel="step over the shipped one",
               xlim=(0.4, 7), xticks=LADDER, xticklabels=[f"{x:g}" for x in LADDER])
        ax.minorticks_off()
        if cases:
            ax.legend(loc="upper left")
    figure.axes[0].set_ylabel("largest deviation [m, rad]")
    return figure


# Section ----------------------------------------------------------------------------------

def section(short: bool) -> Section:
    out = Section("Independent integration", TEXT)
    tables: dict[str, ContactTable] = {}
    found: list[Trajectories] = []
    cells: dict[int, dict[str, dict[str, list[str]]]] = {}
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
        motion = trajectories(case, rows, references, end)
        out.checks += motion_checks(motion) + event_checks(motion, shipped, references)
        if exercise < 5:        # the run's peaks lie in the time compared
            out.checks += peak_checks(motion, shipped, references[-1])
        found.append(motion)
        cells.setdefault(exercise, {})[pair] = summary_cells(runs, rows, exercise == 5)
    with ldbench_style():
        out.figures += [deviation_figure(found), order_figure(found)]
    head = ["case", "dt [µs]", "compared to [s]", *(f"{c}, {word} [{unit}]" for c, unit in COORDINATES
                                                    for word in ("largest", "last")), "step error", "DOP853's error"]
    out.tables += [Table("Deviation of the core from DOP853", head, [deviation_row(case) for case in found]),
                   *(summary_table(exercise, of_pair) for exercise, of_pair in cells.items())]
    return out
