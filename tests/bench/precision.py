"""Work and precision: error of Y at the end of a run over processor time, ours and others' on the same force."""
from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import ldbench
from independent import SIZES, start_of
from ldbench import Case, ContactTable
from ldbench._core import flat
from ldbench.plots.style import GREY, PAGE, ldbench_style
from ldbench.runs import compute
from measure import Measure, Section, absolute, measure, ratio
from running import FORTRAN_TESTS

EXERCISES = 1, 2, 3
PEERS = FORTRAN_TESTS/"peers"   # tests/bench/peers.f90, built where SUNDIALS is
TARGETS = 1e-7, 1e-9            # errors of Y at the end at which times are compared [m]
CHAOTIC = {"ex3_sw": 100}       # there so many times as much
MARGIN = 10                     # of the target over what the reference is uncertain by, else the target is larger
ENOUGH = 3                      # a method is not refined any more when its error is so many times below the last target
NEARBY = 1.0, 0.93, 0.86        # settings over the nominal one: a single one may be right by chance
TOO_LONG = 0.2                  # a method that does is not refined any more [s]
ROUND = 0.05                    # a solution that takes less time is repeated until it took so long [s]
ROWS = 100                      # of our output
FAR_OFF = 1e15                  # rates of a trial pose outside the table: shortens the step (LSODA would keep a NaN)
FINE = 5e-6, 1e-11              # our step [s] and tolerance [J] as reference
STEPS = 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6          # [s]
TOLERANCES = tuple(10.0**-k for k in range(6, 14))
LONGEST = 1e-3              # step that is cut [s]
ERROR = 0.01                # tolerance of the error over that of the energy, a tenth of that of the shipped cases: less work [m/J]
ENERGIES = tuple(10.0**-k for k in range(2, 12))                # tolerances of cut steps [J]

TEXT = """The exercises up to the end of their runs, by the core's integrator and by others on the same force. Error: of Y at
the common end, against the core's cut steps of 5 µs with 1e-11 J; the distance of DOP853 with 1e-13 from it is in the
CSV file. Where contacts touch the law is not smooth, so a step may be right by chance: errors are the root mean
square of three settings a few percent apart. Times at equal error are interpolated between settings, logarithmically,
where the error falls below the target for good. The targets are 1e-7 m and 1e-9 m, for exercise 3 with simplified
profiles, which is chaotic, a hundred times as much; where the references are further apart than a tenth of that, the
next power of ten.

Ours: explicit 2, explicit 4 (beta = 0), newmark 2 (beta = 1/4). cut 4: explicit, with steps of 1 ms that are cut where
they change the energy, or err, by more than a tolerance. SUNDIALS, compiled and called from Fortran
(tests/bench/peers.f90): CVODE's Adams methods with fixed-point iteration, ARKODE's explicit methods by their orders (5:
Dormand and Prince, 6: Verner, 8: Fehlberg, whose error estimate is blind in free flight). DOP853, LSODA: SciPy's,
compiled too, but no package lets a compiled program call them: they call the force through Python, which costs several
times the force itself.

Processor time: of SUNDIALS and SciPy that of the integration alone, with nothing but the state at the end; ours
includes events, energies and 100 rows, but no direct solutions that judge the forces or show pressures. Each is
repeated until it took 50 ms. Exercise 4 is left out."""
NO_PEERS = "SUNDIALS with its Fortran modules is not here, so nothing compiled is compared with: ./bootstrap --sundials"


@dataclass
class Problem:
    """A case up to the last row of the shipped run before it ends: by then no step size has ended it."""

    case: Case
    table: ContactTable
    t_end: float
    program: subprocess.Popen | None = None     # that solves it in compiled form, if it is there


@contextmanager
def problem(case: Case, table: ContactTable) -> Iterator[Problem]:
    table = table.for_case(case)
    p = Problem(case, table, float(ldbench.run(case, table=table).data["time"].iloc[-2]))
    if not PEERS.exists():
        yield p
        return
    with tempfile.TemporaryDirectory() as folder:
        absolute(case).to_namelist(Path(folder)/"case.nml")
        with subprocess.Popen([PEERS, Path(folder)/"case.nml"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True, bufsize=1) as p.program:
            yield p
            p.program.stdin.close()


Answer = tuple[float, float, int]           # Y at the end [m], NaN if it failed; processor time [s]; evaluations of the force


def by_ours(p: Problem, dt: float, energy_tolerance: float = 0.0, error_tolerance: float = 0.0, **scheme: object) -> Answer:
    case = p.case.replace(dt=min(dt, p.t_end/ROWS), energy_tolerance=energy_tolerance, error_tolerance=error_tolerance,
                          stop_at="t_end", t_end=p.t_end, rows="interval", interval=p.t_end/ROWS, judged="no", pressures="no",
                          **scheme)
    try:
        run = compute(case, table=p.table)
    except ldbench.Error:
        return np.nan, np.nan, 0
    return float(run.data["Y"].iloc[-1]), run.seconds, run.results["evaluations"]


def by_peer(p: Problem, tolerance: float, method: str) -> Answer:
    p.program.stdin.write(f"&job method='{method}' tolerance={tolerance!r} t_end={p.t_end!r} /\n")
    words = p.program.stdout.readline().split()
    if not words:
        raise RuntimeError(f"{PEERS} ended at {method} with {tolerance}")
    return float(words[0]), float(words[1]), int(words[2])


def by_scipy(p: Problem, tolerance: float, method: str, max_step: float = np.inf) -> Answer:
    # The cheapest way from Python: the core's procedure on numbers, no arrays of several motions.
    case, weight, handle = p.case, p.table.weight, p.table._handle

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        force, status = flat.contact_values(handle, 0, 3, *x[:3])
        if status[0]:
            return np.full(6, FAR_OFF)
        fy, fz, moment = force.ravel().tolist()
        return np.array([*x[3:], (fy + case.lateral_force + case.lateral_ramp*t)/case.mass, (fz - weight)/case.mass,
                         moment/case.roll_inertia])

    begin = time.process_time()
    found = solve_ivp(rates, (0, p.t_end), start_of(p.case, p.table), method, t_eval=[p.t_end], rtol=tolerance,
                      atol=tolerance*SIZES, max_step=max_step)
    return float(found.y[0, -1]) if found.success else np.nan, time.process_time() - begin, found.nfev


@dataclass(frozen=True)
class Method:
    name: str
    family: str                 # 'ldbench', 'SUNDIALS', 'SciPy'
    settings: tuple[float, ...]
    solve: Callable[[Problem, float], Answer]


METHODS = (
    *(Method(name, "ldbench", STEPS, lambda p, dt, options=options: by_ours(p, dt, **options)) for name, options in (
        ("newmark 2", {"order": 2, "beta": 0.25}), ("explicit 2", {"order": 2, "beta": 0.0}),
        ("explicit 4", {"order": 4, "beta": 0.0}))),
    Method("cut 4", "ldbench", ENERGIES, lambda p, energy: by_ours(
        p, LONGEST, energy, error_tolerance=ERROR*energy, order=4, beta=0.0)),
    *(Method(name, "SUNDIALS", TOLERANCES, lambda p, tolerance, method=method: by_peer(p, tolerance, method))
      for name, method in (("CVODE Adams", "adams"), *((f"ARKODE {order}", f"erk {order}") for order in (4, 5, 6, 8)))),
    *(Method(name, "SciPy", TOLERANCES, lambda p, tolerance, name=name: by_scipy(p, tolerance, name))
      for name in ("DOP853", "LSODA")))


@dataclass
class Point:
    """A method with one setting."""

    setting: float
    error: float                # of Y, root mean square of nearby settings [m]
    evaluations: int            # of the force
    times: np.ndarray           # of the nearby settings [s]


def refine(p: Problem, method: Method, exact: float, enough: float) -> list[Point]:
    """One setting after the other until the error is small enough or a solution takes too long."""
    def lasting(setting: float) -> Answer:
        """The mean time of solutions that are repeated until they took ROUND."""
        y, seconds, evaluations = method.solve(p, setting)
        count = int(min(ROUND/max(seconds, 1e-5), 50)) if seconds < ROUND else 0
        return y, float(np.mean([seconds, *(method.solve(p, setting)[1] for _ in range(count))])), evaluations

    points = []
    for setting in method.settings:
        found = [lasting(setting*factor) for factor in NEARBY]
        error = float(np.sqrt(np.mean([(y - exact)**2 for y, *_ in found])))
        if np.isnan(error):
            continue
        points.append(Point(setting, error, found[0][2], np.array([seconds for _, seconds, _ in found])))
        if error < enough or np.median(points[-1].times) > TOO_LONG:
            break
    return points


def times_at(points: list[Point], target: float) -> np.ndarray:
    """Times between the settings about a target, where the error falls below it for good; NaN where it does not."""
    above = [k for k, point in enumerate(points) if not point.error <= target]
    k = above[-1] if above else -1
    if k == len(points) - 1:
        return np.array([np.nan])
    if k < 0:
        return points[0].times        # at most
    coarse, fine = points[k], points[k + 1]
    share = np.log(coarse.error/target)/np.log(coarse.error/max(fine.error, 1e-16))
    return coarse.times**(1 - share)*fine.times**share


def headline(name: str, methods: tuple[Method, ...], curves: dict[str, list[Point]], target: float) -> Iterator[Measure]:
    """Time of our fastest, and of the fastest of others over it, at equal error."""
    best = {family: min(((np.median(times), method.name, times) for method in methods if method.family == family
                         and np.isfinite(times := times_at(curves[method.name], target)).all()), default=None)
            for family in ("ldbench", "SUNDIALS", "SciPy")}
    if not (ours := best.pop("ldbench")):
        return
    yield measure(name, ours[1], f"time at {target:g} m", "s", ours[2], "our fastest")
    for family, theirs in best.items():
        if theirs:
            yield ratio(name, theirs[1], f"time of the best of {family} over ours at {target:g} m", theirs[2], ours[2],
                        f"against {ours[1]}")


def precision_figure(found: dict[str, dict[str, list[Point]]]) -> Figure:
    figure = Figure(figsize=PAGE, layout="constrained")
    axes = figure.subplots(2, -(-len(found)//2), squeeze=False, sharex=True, sharey=True)
    for ax, (name, curves) in zip(axes.T.flat, found.items(), strict=False):
        for k, (method, points) in enumerate(curves.items()):
            ax.plot([np.median(x.times) for x in points], [max(x.error, 1e-13) for x in points], marker="osD^v*"[k % 6],
                    markersize=2.5, linewidth=1, linestyle="-" if k < 6 else ":", label=method)
        for target in TARGETS:
            ax.axhline(target, color=GREY, linestyle=":", linewidth=0.7)
        ax.set(title=name, xscale="log", yscale="log", ylim=(1e-12, 1e-2), xlabel="processor time [s]",
               ylabel="error of Y at the end [m]")
    axes[0, 0].legend(fontsize=6)
    return figure


def section() -> Section:
    out = Section("Work and precision", TEXT)
    methods = tuple(m for m in METHODS if PEERS.exists() or m.family != "SUNDIALS")
    if not PEERS.exists():
        print(NO_PEERS)
        out.text += f"\n\n{NO_PEERS}."
    tables = {pair: ContactTable(Case.exercise(1, pair)) for pair in ("aw", "sw")}
    found: dict[str, dict[str, list[Point]]] = {}
    for exercise in EXERCISES:
        for pair, table in tables.items():
            with problem(Case.exercise(exercise, pair), table) as p:
                name = p.case.case_name
                exact = by_ours(p, *FINE, order=4, beta=0.0)[0]
                apart = abs(by_scipy(p, 1e-13, "DOP853", 1e-4)[0] - exact)      # a longer step may pass through a contact
                least = 10.0**np.ceil(np.log10(MARGIN*max(apart, 1e-16)))
                targets = sorted({float(f"{max(target*CHAOTIC.get(name, 1), least):.0e}") for target in TARGETS}, reverse=True)
                found[name] = {m.name: refine(p, m, exact, targets[0 if m.family == "SciPy" else -1]/ENOUGH)
                               for m in methods}
            for target in targets:
                out.measures += headline(name, methods, found[name], target)
            out.more.append(measure(name, "DOP853, 1e-13", "distance from the reference", "m", apart))
            for method, points in found[name].items():
                for point in points:
                    out.more += [measure(name, f"{method}, {point.setting:g}", quantity, unit, value) for quantity, unit, value in (
                        ("error of Y", "m", point.error), ("processor time", "s", point.times),
                        ("force evaluations", "1", point.evaluations))]
    with ldbench_style():
        out.figures.append(precision_figure(found))
    return out
