"""The same force law integrated by another method: SciPy's DOP853 against the core's integrator."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import ldbench
from checks import Check, Section, Table, absolute, limit, page
from ldbench import Case, ContactTable, Run, _flat
from ldbench.style import BLACK, BLUE, GREEN, GREY, RED, SERIES, ldbench_style

PAIRS = "aw", "sw"
CASES = [(exercise, pair) for exercise in (1, 2, 3, 4, 5) for pair in PAIRS]
SHORT = [(2, "aw"), (4, "aw")]

TOLERANCES = 1e-12, 1e-13       # relative, of DOP853; the second is the reference, their difference its error
MAX_STEP = 1e-4                 # of DOP853: a longer one may pass through a contact without seeing it [s]
SAFETY = 10                     # of the bars: through impacts the estimated step error is itself uncertain
MEANINGFUL = 1e-5               # a case is compared until its bar reaches this, 0.1 % of the clearance [m, rad]
RAMP_END = 1.2                  # of exercise 5: the core's steps have parted by then [s]
SAMPLES = 1e-5                  # where the peaks of DOP853's forces are looked for [s]

COORDINATES = ("Y", "m"), ("Z", "m"), ("roll", "rad")
FLANGES = (("left", "LF"), ("right", "RF"))
CONTACTS = "LT", "LF", "RT", "RF"

TEXT = """M q'' = f(t) - dU/dq, q = (y, z, roll), is integrated once more from the shipped initial conditions, by
SciPy's DOP853 (Dormand and Prince, order 8 with step control) with relative tolerances 1e-12 and 1e-13. It has nothing
in common with the core's integrator but the force, ldbench.ContactTable.force. Bar of the deviation: ten times the
core's step error, 4/3 |q(dt) - q(dt/2)| (second order, the least it can be), and what DOP853 changes between its
tolerances. Event times: DOP853 locates contacts on its continuous solution, the core notes them at the end of a step,
so its times are late by up to one step; to this comes the deviation allowed to the motion over the speed. Peaks: the
core takes the largest of its steps, so it misses up to |N''| dt²/8.

The force law is smooth except where a contact touches (F grows as the 3/2 power of the penetration) and in the third
derivatives at the table's knots, so the integrator of fourth order need not show order 4 over impacts.

Exercise 5 loses its memory once the wheelset rattles on the flange: after 1 s the core with two steps has parted by
millimetres. It is compared until the bar reaches 10 µm. The deviation before its first flange contact, about 1 nm, does
not shrink with the step: it is round-off of the discrete gradient while the wheelset still creeps. One ulp of the axle
height, 6e-17 m, times 180 kN is 1e-11 J, which over a displacement of nanometres in a step counts as a force. The
core's Newmark scheme, which has no such quotient, was found within 1e-12 m of DOP853 there (actual profiles, 5 µs).

The tables after the first give the numbers of outputs/summary.csv and the last state error bars from three steps: the
sum of all further halvings at the observed order; for times noted at the end of a step at least the step; the spread of
the three for numbers that do not converge because the motion is chaotic; twice the spread for those that only show no
order, such as peaks, whose nearest step is a matter of chance. Steps: the shipped one, its half and quarter; exercise
5, which costs most, twice the shipped one, itself and its half."""


# DOP853 -----------------------------------------------------------------------------------

@dataclass
class Reference:
    """A motion by DOP853."""

    state: Callable[[np.ndarray], np.ndarray]   # y, z, roll and their rates at times; z from equilibrium
    touches: dict[str, float]                   # first flange contacts [s]
    passages: np.ndarray                        # of the centre [s]
    acceleration: Callable[[float], np.ndarray]


def integrate(case: Case, table: ContactTable, t_end: float, tolerance: float) -> Reference:
    """Integrate a case by DOP853 up to t_end; z is the axle's height."""
    forces, contact_forces, handle = _flat.forces, _flat.contact_forces, table._handle   # ContactTable.force, 5 times
    inertia = np.array([case.mass, case.mass, case.roll_inertia])                        # faster for single poses
    load = np.array([case.lateral_force, -table.weight, 0.0])
    ramp = np.array([case.lateral_ramp, 0.0, 0.0])

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        force, status = forces(handle, 0, x[0], x[1], x[2])
        if status[0]:
            return np.full(6, np.nan)       # the step is tried again with a shorter one
        return np.concatenate([x[3:], (force[:, 0] + load + ramp*t)/inertia])

    def closes(contact: str) -> Callable[[float, np.ndarray], float]:
        k = CONTACTS.index(contact)

        def sign(t: float, x: np.ndarray) -> float:
            return 1.0 if contact_forces(handle, x[0], x[1], x[2])[0][:, k].any() else -1.0

        sign.direction = 1.0
        return sign

    start = [case.Y, table.equilibrium + case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate]
    found = solve_ivp(rates, (0, t_end), start, "DOP853", dense_output=True, rtol=tolerance, max_step=MAX_STEP,
                      atol=tolerance*np.repeat([1e-2, 1.0], 3),     # [m, rad] and per second: the motion's size
                      events=[closes("LF"), closes("RF"), lambda t, x: x[0]])
    if not found.success:
        raise ldbench.Error(f"DOP853: {found.message}")
    left, right, passages = found.t_events
    rest = np.array([0, table.equilibrium, 0, 0, 0, 0])
    return Reference(lambda t: found.sol(t).T - rest,
                     {c: times[0] for c, times in (("LF", left), ("RF", right)) if times.size},
                     passages[passages > 0], lambda t: rates(t, found.sol(t))[3:])


def peak(reference: Reference, table: ContactTable, contact: str, t_end: float) -> tuple[float, float]:
    """Largest normal force [N] of a contact and its |second derivative| there, by a parabola through three samples."""
    y, z, roll = reference.state(np.arange(0, t_end, SAMPLES)).T[:3]
    force = table.forces_by_contact(y, table.equilibrium + z, roll)[:, CONTACTS.index(contact), :2]
    N = np.hypot(*force.T)
    k = int(np.clip(N.argmax(), 1, len(N) - 2))
    slope, bend = (N[k + 1] - N[k - 1])/2, N[k + 1] - 2*N[k] + N[k - 1]
    return (N[k] - slope**2/(2*bend), abs(bend)/SAMPLES**2) if bend < 0 else (N[k], 0.0)


# Comparison -------------------------------------------------------------------------------

@dataclass
class Trajectories:
    """A case by the core with three steps and by DOP853 with two tolerances, at the output times."""

    name: str
    dt: float                   # the shipped step [s]
    steps: np.ndarray           # of the core's motions [s]
    t: np.ndarray
    core: list[np.ndarray]      # (row, coordinate) per step
    dop: list[np.ndarray]       # per tolerance

    @property
    def shipped(self) -> int:
        return int(np.abs(self.steps/self.dt - 1).argmin())

    def step_error(self) -> np.ndarray:
        """Of the core at the shipped step, the largest so far, by order 2."""
        k = self.shipped
        return np.maximum.accumulate(4/3*np.abs(self.core[k] - self.core[k + 1]))

    def tolerance_error(self) -> np.ndarray:
        """Of DOP853, the largest so far."""
        return np.maximum.accumulate(np.abs(self.dop[0] - self.dop[1]))

    def bar(self) -> np.ndarray:
        return SAFETY*self.step_error() + self.tolerance_error()

    def deviation(self, k: int) -> np.ndarray:
        """Of the core with step k from DOP853."""
        return np.abs(self.core[k] - self.dop[1])

    @property
    def rows(self) -> int:
        """Up to which the comparison means something."""
        beyond = (self.bar() > MEANINGFUL).any(axis=1)
        return int(beyond.argmax()) if beyond.any() else len(self.t)


def trajectories(case: Case, runs: list[Run], references: list[Reference], t_end: float) -> Trajectories:
    count = min(np.searchsorted(run.columns["time"], t_end*(1 + 1e-12), "right") for run in runs)
    t = runs[0].columns["time"].to_numpy()[:count]
    return Trajectories(case.case_name, case.dt, np.array([run.case.dt for run in runs]), t,
                        [run.columns[[c for c, _ in COORDINATES]].to_numpy()[:count] for run in runs],
                        [reference.state(t)[:, :3] for reference in references])


def motion_checks(found: Trajectories) -> list[Check]:
    n, deviation, bar = found.rows, found.deviation(found.shipped), found.bar()
    source = f"DOP853, bar {SAFETY} step errors + its tolerance"
    until = f" to {found.t[n - 1]:.3f} s" if n < len(found.t) else ""
    return [limit(f"{found.name} largest deviation of {c}{until} [{unit}]", deviation[:n, i].max(), source,
                  bar[n - 1, i]) for i, (c, unit) in enumerate(COORDINATES)]


def event_checks(found: Trajectories, run: Run, references: list[Reference]) -> list[Check]:
    """First flange contacts and passages of the centre while the comparison means something."""
    last, (coarse, fine) = found.t[found.rows - 1], references
    bar_y = dict(zip(found.t, found.bar()[:, 0], strict=True))

    def motion_bar(t: float) -> float:
        """Bar of the lateral motion over its speed [s]."""
        row = found.t[min(np.searchsorted(found.t, t), len(found.t) - 1)]
        return bar_y[row]/abs(fine.state(t)[3])

    checks = []
    for side, contact in FLANGES:
        ours = [e.t for e in run.events if e.kind == f"{side} flange contact"]
        if contact in fine.touches and fine.touches[contact] < last and ours:
            t = fine.touches[contact]
            checks.append(absolute(f"{found.name} first {side} flange contact [s]", ours[0], t,
                                   "DOP853's event location, bar one step + motion's bar/speed",
                                   found.dt + motion_bar(t) + abs(t - coarse.touches[contact])))
    ours = [e.t for e in run.events if e.kind == "centre passage"]
    for k, (a, b, c) in enumerate(zip(ours, fine.passages, coarse.passages), 1):
        if b < last:
            v, curve = fine.state(b)[3], fine.acceleration(b)[0]
            checks.append(absolute(f"{found.name} centre passage {k} [s]", a, b,
                                   "DOP853's event location, bar interpolation in the step + motion's bar/speed",
                                   abs(curve/v)*found.dt**2/8 + motion_bar(b) + abs(b - c)))
    return checks


def peak_checks(found: Trajectories, runs: list[Run], references: list[Reference]) -> list[Check]:
    """Largest normal forces of the flanges."""
    checks = []
    k = found.shipped
    for side, contact in FLANGES:
        ours, finer = (run.summary[f"peak_N_{contact}"] for run in runs[k:k + 2])
        if ours > 0:
            (coarse, _), (fine, curve) = (peak(r, runs[k].table, contact, found.t[-1]) for r in references)
            bar = SAFETY*4/3*abs(ours - finer) + abs(fine - coarse) + curve*found.dt**2/8
            checks.append(Check(f"{found.name} peak normal force, {side} flange [N], relative", ours, fine,
                                f"DOP853, bar {SAFETY} step errors + |N''| dt²/8", abs(ours/fine - 1), bar/fine))
    return checks


def deviation_row(found: Trajectories) -> list[str]:
    """Largest and last deviation of each coordinate, at the shipped step."""
    n, deviation = found.rows, found.deviation(found.shipped)
    cells = [f"{x:.1e}" for i in range(3) for x in (deviation[:n, i].max(), deviation[n - 1, i])]
    return [found.name, f"{1e6*found.dt:g}", f"{found.t[n - 1]:.4f}", *cells,
            f"{found.step_error()[n - 1].max():.1e}", f"{found.tolerance_error()[n - 1].max():.1e}"]


# Error bars of the summary ----------------------------------------------------------------

NUMBERS = {                     # name: unit, factor from SI; the names of ldbench.record.summary_row
    "t_first_LF": ("ms", 1e3), "t_first_RF": ("ms", 1e3), "t_first_centre": ("ms", 1e3), "t_return": ("ms", 1e3),
    "t_derailment": ("ms", 1e3), "F_derailment": ("kN", 1e-3),
    **{f"{c}_{end}": ("mm", 1e3) for c in ("Y", "Z") for end in ("min", "max", "last")},
    **{f"roll_{end}": ("mrad", 1e3) for end in ("min", "max", "last")},
    **{f"N_max_{c}": ("kN", 1e-3) for c in CONTACTS}, **{f"t_N_max_{c}": ("ms", 1e3) for c in CONTACTS}}
AT_STEPS = "t_first_LF", "t_first_RF", "t_derailment", *(f"t_N_max_{c}" for c in CONTACTS)


def numbers(run: Run, last: float) -> dict[str, float]:
    """The run's numbers in the summary table [SI], and the state at the row of time `last`."""
    first: dict[str, float] = {}
    for event in run.events:
        first.setdefault(event.kind, event.t)
    touch = first.get("left flange contact", np.inf)
    passages = [e.t for e in run.events if e.kind == "centre passage" and e.t > touch]
    found = {"t_first_LF": touch, "t_first_RF": first.get("right flange contact"),
             "t_first_centre": passages[0] if passages else None,
             "t_return": passages[-1] if passages and run.summary["returned"] else None,
             "t_derailment": first.get("derailment")}
    if run.case.lateral_ramp and "derailment" in first:
        found["F_derailment"] = run.case.lateral_force + run.case.lateral_ramp*first["derailment"]
    row = int(np.searchsorted(run.columns["time"], last*(1 - 1e-12)))
    for c, _ in COORDINATES:
        x = run.columns[c].to_numpy()
        found |= {f"{c}_min": x.min(), f"{c}_max": x.max(), f"{c}_last": x[row]}
    for c in CONTACTS:
        if run.summary[f"peak_N_{c}"] > 0:
            found |= {f"N_max_{c}": run.summary[f"peak_N_{c}"], f"t_N_max_{c}": run.summary[f"t_peak_{c}"]}
    return {name: float(x) for name, x in found.items() if x is not None}


def error_bar(x: np.ndarray, k: int, resolution: float, rattles: bool) -> tuple[float, str]:
    """Error of x[k], of three steps h, h/2, h/4, and the observed order or why there is none.

    After thousands of impacts (`rattles`) three steps are three samples, whatever order they seem to have.
    """
    first, second = abs(x[0] - x[1]), abs(x[1] - x[2])
    spread = float(np.ptp(x))
    if spread <= 1e-9*abs(x[k]):
        return max(spread, resolution), "at the step" if resolution else "round-off"
    if resolution and spread <= 2*resolution:
        return resolution, "at the step"
    if rattles and spread > 1e-6*abs(x[k]):
        return spread, "chaotic"
    if 2*second < first < 64*second:        # order 1 to 6; what is beyond is chance
        order = np.log2(first/second)
        return max(first/(1 - 2**-order)*2.0**(-order*k), resolution), f"{order:.1f}"
    if spread > 1e-4*abs(x[k]):
        return spread, "chaotic"
    return max(2*spread, resolution), "none"


def rounded(x: float, bar: float) -> str:
    """A number with as many decimals as its error bar has with two digits."""
    decimals = int(np.clip(1 - np.floor(np.log10(bar)), 0, 9)) if bar > 0 else 9
    return f"{x:.{decimals}f}"


def summary_cells(results: list[dict[str, float]], steps: np.ndarray, shipped: int,
                  rattles: bool) -> dict[str, list[str]]:
    """Value, error bar and observed order of every number that the shipped run has."""
    cells = {}
    for name, value in results[shipped].items():
        unit, scale = NUMBERS[name]
        if any(name not in r for r in results):
            cells[name] = [f"{scale*value:.6g}", "", "chaotic"]     # it does not happen with every step
            continue
        resolution = steps[shipped] if name in AT_STEPS else 0.0
        bar, order = error_bar(np.array([r[name] for r in results]), shipped, resolution, rattles)
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
    figure = page("Deviation of the core from DOP853 over time", "Shipped steps, at the output times. step error: 4/3 "
                  "|q(dt) - q(dt/2)|, largest coordinate so far; DOP853's tolerance: what it changes between 1e-12 and "
                  "1e-13.\nExercise 5 is compared up to the dotted line.")
    columns = max(1, -(-len(found)//2))
    axes = figure.subplots(2, columns, squeeze=False, sharey=True)
    for ax in axes.flat[len(found):]:
        ax.set_axis_off()
    for k, case in enumerate(found):
        ax = axes[k % 2, k//2] if len(found) > 2 else axes.flat[k]
        for i, (colour, (name, _)) in enumerate(zip((BLUE, RED, GREEN), COORDINATES, strict=True)):
            ax.semilogy(case.t, case.deviation(case.shipped)[:, i].clip(1e-17), color=colour, linewidth=0.6, label=name)
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
                  "of the run that is compared; filled: the shipped step. Dotted, level: DOP853's own error, 1e-12 "
                  "against 1e-13. Grey: second and fourth order.")
    with_pair = [[case for case in found if case.name.endswith(pair)] for pair in PAIRS]
    for ax, pair, cases in zip(figure.subplots(1, 2, sharey=True), PAIRS, with_pair, strict=True):
        for line, case in zip(SERIES, cases, strict=False):
            error = [case.deviation(k)[:case.rows].max() for k in range(len(case.steps))]
            ax.loglog(1e6*case.steps, error, marker="o", markerfacecolor="none", **line.kwargs(), label=case.name)
            ax.loglog(1e6*case.dt, error[case.shipped], "o", color=line.color)
            own = case.tolerance_error()[case.rows - 1].max()
            ax.loglog(1e6*case.steps[[0, -1]], [own, own], ":", color=line.color, linewidth=0.8)
        h = np.array([1.0, 4.0])
        for order in (2, 4):
            ax.loglog(h, 1e-9*(h/4)**order, color=GREY, linewidth=2.5, alpha=0.4)
            ax.text(1.0, 1e-9/4.0**order, f"order {order} ", color=GREY, ha="right", va="center")
        ax.set(title={"aw": "actual profiles", "sw": "simplified profiles"}[pair], xlabel="step [µs]", xlim=(0.1, 60))
        if cases:
            ax.legend(loc="upper left")
    figure.axes[0].set_ylabel("largest deviation [m, rad]")
    return figure


# Section ----------------------------------------------------------------------------------

def ladder(exercise: int) -> tuple[float, ...]:
    """Steps over the shipped one; exercise 5, which costs most, from twice the shipped step on."""
    return (2.0, 1.0, 0.5) if exercise == 5 else (1.0, 0.5, 0.25)


def section(short: bool) -> Section:
    out = Section("Independent integration", TEXT)
    tables: dict[str, ContactTable] = {}
    found: list[Trajectories] = []
    cells: dict[int, dict[str, dict[str, list[str]]]] = {}
    for exercise, pair in SHORT if short else CASES:
        case = Case.exercise(exercise, pair)
        tables.setdefault(pair, ContactTable(case))
        table = tables[pair].for_case(case)
        runs = [ldbench.run(case.replace(dt=factor*case.dt), table=table) for factor in ladder(exercise)]
        last = min(run.summary["t"] for run in runs)
        t_end = min(last, RAMP_END) if exercise == 5 else last
        references = [integrate(case, table, t_end, tolerance) for tolerance in TOLERANCES]
        motion = trajectories(case, runs, references, t_end)
        out.checks += motion_checks(motion) + event_checks(motion, runs[motion.shipped], references)
        if motion.rows == len(motion.t):        # the run's peaks lie in the time compared
            out.checks += peak_checks(motion, runs, references)
        found.append(motion)
        results = [numbers(run, last) for run in runs]
        cells.setdefault(exercise, {})[pair] = summary_cells(results, motion.steps, motion.shipped,
                                                              exercise == 5)
    with ldbench_style():
        out.figures += [deviation_figure(found), order_figure(found)]
    head = ["case", "dt [µs]", "compared to [s]", *(f"{c}, {word} [{unit}]" for c, unit in COORDINATES
                                                    for word in ("largest", "last")), "step error", "DOP853's error"]
    out.tables += [Table("Deviation of the core from DOP853", head, [deviation_row(case) for case in found]),
                   *(summary_table(exercise, of_pair) for exercise, of_pair in cells.items())]
    return out
