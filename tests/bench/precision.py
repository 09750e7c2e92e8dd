"""Work and precision: error of the trajectory at the end of a run over processor time, ours and others'."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ldbench import Case, ContactTable
from ldbench.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PAGE, PURPLE, RED, SKY, ldbench_style
from measure import Measure, Section, measure, ratio
from problem import PEERS, Problem, Reference, Solution, by_ours, by_peer, by_scipy, problem, reference

CASES = [(exercise, pair) for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
THIN = {"linewidth": 1, "markersize": 2.5}
USUAL = 1, 2, 3                 # exercises, unless all are asked for; those whose ratios are printed
FULL_METHODS = "newmark 2", "newmark 4", "energy 2", "ARKODE 6", "ARKODE 8", "DOP853", "Radau"      # slower

TARGETS = 1e-7, 1e-9            # errors of Y at the end at which times are compared [m]
CHAOTIC = {"ex3_sw": 100}       # there so many times as much
MARGIN = 10                     # of the target over what the reference is uncertain by, else the target is larger
ENOUGH = 3                      # a method is not refined any more when its error is so many times below the last target
NEARBY = 1.0, 0.93, 0.86        # settings over the nominal one: a single one may be right by chance
LONG = 1.0                      # a solution that takes longer is not repeated [s]
ROUND = 0.05                    # a shorter one is repeated in every round until it takes so long [s]
TOO_LONG, FULL_TOO_LONG = 0.2, 2.0      # a method that does is not refined any more [s]
ROUNDS, FULL_ROUNDS = 5, 7
CLOSE = 1.4                     # a method that takes so many times as long as its family's fastest is not timed in rounds

STEPS = 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6          # [s]
TOLERANCES = tuple(10.0**-k for k in range(6, 14))
# Steps of the cut members [s] at a tolerance [J]; both change together, as dt^(order + 1).
UNCUT = {4: (4e-4, 1e-6), 6: (8e-4, 1e-6)}
ENERGIES = tuple(10.0**-k for k in range(2, 12))                # its tolerances [J]

TEXT = """The exercises up to the end of their runs, by the core's integrator and by others on the same compiled force.
Error: of Y at a common end time, against the core's cut steps of 5 µs with 1e-11 J or CVODE's Adams method with 3e-14,
whichever changes less from the setting before; their distance is in the CSV file. Where contacts touch the law is not
smooth, so a step may be right by chance: errors are the root mean square of three settings a few percent apart. Times
and evaluations at equal error are interpolated between settings, logarithmically, where the error falls below the
target for good. The targets are 1e-7 m and 1e-9 m, for exercise 3 with simplified profiles, which is chaotic, a hundred
times as much; where the references are further apart than a tenth of that, the next power of ten.

Ours: newmark (beta = 1/4), energy (average acceleration with discrete gradient), explicit (beta = 0); 2 and 4 are
orders. cut 4, cut 6: explicit, with steps that are cut where they change the energy by more than a tolerance; the
setting is the tolerance in joules, and the step, 0.4 ms and 0.8 ms at 1e-6 J, goes with its fifth and seventh root;
shipped is cut 4 with 0.1 ms and 1e-9 J. SUNDIALS, compiled and
called from Fortran: CVODE's Adams methods with fixed-point iteration and with Newton's, BDF with Newton's, on the exact
tangent; ARKODE's explicit methods by their orders (5: Dormand and Prince, 6: Verner, 8: Fehlberg, whose error estimate
is blind in free flight). SPRKStep, symplectic, comes with SUNDIALS 6.6. z is measured from equilibrium; tolerances are
relative to 1 cm, 1 m/s. LSODA, DOP853, Radau: SciPy's, compiled too, but no package lets a compiled program call them:
they call the force through Python, which costs several times the force itself. They are compared at the first target.

Processor time: of the integration alone, by one program (tests/bench/peers.f90) with the same force, compiled alike; in
every round the mean of as many solutions as take 50 ms, all methods in turn. Only the state at the end is kept: events,
energies and rows cost extra. Without SUNDIALS ours is called from Python, where it includes events and 100 rows.

In the picture of errors over times every mark is a step (200 µs to 1 µs), a tolerance (1e-6 to 1e-13) or, of cut steps, an
energy (1e-2 J to 1e-11 J); bars are quartiles of what was timed in rounds. Times are compared at the dotted lines; the shade is
below the estimated error of the reference.

The usual form leaves out exercise 4 and methods that are slower: newmark, energy 2, ARKODE 6 and 8, DOP853, Radau."""
NO_PEERS = "SUNDIALS with its Fortran modules is not here, so nothing compiled is compared with: ./bootstrap --sundials"


@dataclass(frozen=True)
class Method:
    name: str
    family: str                 # 'ldbench', 'SUNDIALS', 'SciPy'
    settings: tuple[float, ...]
    solve: Callable[[Problem, float, float], Solution]      # seconds at least, setting
    line: dict[str, object]

    @property
    def compiled(self) -> bool:
        return self.family != "SciPy"


def _ours(name: str, scheme: str, order: int, beta: float, color: str) -> Method:
    style = {"color": color, "linestyle": "-" if order == 4 else "--", "marker": "o" if order == 4 else "s"}
    return Method(name, "ldbench", STEPS, lambda p, least, dt: by_ours(p, least, scheme, order, beta, dt),
                  style)


def _cut(order: int, line: dict[str, object]) -> Method:
    step, energy = UNCUT[order]
    return Method(f"cut {order}", "ldbench", ENERGIES, lambda p, least, tolerance: by_ours(
        p, least, "newmark", order, 0.0, step*(tolerance/energy)**(1/(order + 1)), tolerance), line)


def _scipy(name: str, color: str) -> Method:
    return Method(name, "SciPy", TOLERANCES, lambda p, least, tolerance: by_scipy(p, least, name, tolerance),
                  {"color": color, "linestyle": ":", "marker": "^"})


def _peer(name: str, method: str, color: str, line: str) -> Method:
    return Method(name, "SUNDIALS", TOLERANCES, lambda p, least, tolerance: by_peer(p, least, method, tolerance),
                  {"color": color, "linestyle": line, "marker": "D"})


METHODS = (
    _ours("energy 2", "energy", 2, 0.25, BLUE), _ours("energy 4", "energy", 4, 0.25, BLUE),
    _ours("newmark 2", "newmark", 2, 0.25, SKY), _ours("newmark 4", "newmark", 4, 0.25, SKY),
    _ours("explicit 2", "newmark", 2, 0.0, BLACK), _ours("explicit 4", "newmark", 4, 0.0, BLACK),
    *(_cut(order, {"color": BLACK, "linestyle": line, "marker": "*", "linewidth": 1.8, "markersize": 5})
      for order, line in ((4, "-"), (6, "--"))),
    _peer("CVODE Adams", "adams", GREY, "-."), _peer("CVODE Adams-Newton", "adams newton", GREY, "-"),
    _peer("CVODE BDF", "bdf", GREEN, "-."),
    *(_peer(f"ARKODE {order}", f"erk {order}", color, line)
      for order, color, line in ((4, PURPLE, "-."), (5, PURPLE, "-"), (6, SKY, "-."), (8, SKY, ":"))),
    _scipy("DOP853", RED), _scipy("LSODA", ORANGE), _scipy("Radau", PURPLE))


@dataclass
class Point:
    """A method with one setting."""

    setting: float
    error: float                # of Y, root mean square of nearby settings [m]
    evaluations: int            # of the force
    jacobians: int
    first: float                # time of the first solutions [s]
    seconds: list[float] = field(default_factory=list)      # per round, if it was timed

    @property
    def times(self) -> np.ndarray:
        return np.array(self.seconds or [self.first])


Values = Callable[[Point], np.ndarray | float]


@dataclass
class Comparison:
    name: str
    problem: Problem
    reference: Reference
    methods: tuple[Method, ...]
    targets: list[float] = field(default_factory=list)
    curves: dict[str, list[Point]] = field(default_factory=dict)     # by method

    def best(self, family: str, target: float) -> tuple[str, np.ndarray]:
        """The member of a family that is the fastest at a target; its times."""
        rows = [(np.median(times), name, times) for name, times in self.times(family, target).items()]
        return min(rows, key=lambda row: row[0])[1:] if rows else ("none", np.array([np.nan]))

    def times(self, family: str, target: float) -> dict[str, np.ndarray]:
        """The times of the family's members that reach the target."""
        found = {m.name: self.at(m.name, target, lambda point: point.times) for m in self.methods if m.family == family}
        return {name: times for name, times in found.items() if np.isfinite(times).all()}

    def at(self, name: str, target: float, values: Values) -> np.ndarray:
        """Interpolated between the settings about the target."""
        points = self.curves.get(name, [])
        bracket = around(points, target)
        if bracket is None:
            return np.array([np.nan])
        coarse, fine, share = bracket
        return np.atleast_1d(values(points[coarse])**(1 - share)*values(points[fine])**share)

    def close(self, method: Method) -> bool:
        """Whether it may be the fastest of its family at a target."""
        return any(np.median(times[method.name]) <= CLOSE*min(map(np.median, times.values()))
                   for times in (self.times(method.family, target) for target in self.targets) if method.name in times)


def around(points: list[Point], target: float) -> tuple[int, int, float] | None:
    """The settings between which the error falls below the target for good, the way from one to the other."""
    above = [k for k, point in enumerate(points) if not point.error <= target]
    k = above[-1] if above else -1
    if k == len(points) - 1:
        return None
    if k < 0:
        return 0, 0, 0.0        # at most
    return k, k + 1, float(np.log(points[k].error/target)/np.log(points[k].error/max(points[k + 1].error, 1e-16)))


def targets(name: str, exact: Reference) -> list[float]:
    """From large to small, each a power of ten at which the reference is certain enough."""
    doubt = max(exact.error, exact.apart, 1e-16)
    least = 10.0**np.ceil(np.log10(MARGIN*doubt))
    return sorted({float(f"{max(target*CHAOTIC.get(name, 1), least):.0e}") for target in TARGETS}, reverse=True)


def compare(p: Problem, methods: tuple[Method, ...], full: bool) -> Comparison:
    """Every method once with every setting, then in rounds those about the targets that may be the fastest."""
    exact = reference(p)
    found = Comparison(p.case.case_name, p, exact, methods, targets(p.case.case_name, exact))
    for method in methods:
        found.curves[method.name] = refine(found, method, FULL_TOO_LONG if full else TOO_LONG)
    chosen = []
    for method in filter(found.close, methods):
        points = found.curves[method.name]
        brackets = [x for x in (around(points, target) for target in found.targets) if x]
        chosen += [(method, points[k]) for k in sorted({k for x in brackets for k in x[:2]})]
    for _ in range(FULL_ROUNDS if full else ROUNDS):
        for method, point in chosen:
            least = 0 if point.first > LONG else ROUND
            point.seconds.append(method.solve(p, least, point.setting).seconds)
    return found


def refine(found: Comparison, method: Method, too_long: float) -> list[Point]:
    """One setting after the other until the error is small enough or a solution takes too long [s]."""
    enough = found.targets[-1 if method.compiled else 0]/ENOUGH
    points = []
    for setting in method.settings:
        solutions = [method.solve(found.problem, 0, setting*factor) for factor in NEARBY]
        error = np.sqrt(np.mean([(s.pose[0] - found.reference.pose[0])**2 for s in solutions]))
        if np.isnan(error):
            continue
        seconds = float(np.median([s.seconds for s in solutions]))
        points.append(Point(setting, float(error), solutions[0].evaluations, solutions[0].jacobians, seconds))
        if error < enough or seconds > too_long:
            break
    return points


def setting_text(name: str, setting: float) -> str:
    """The text of a setting of one of our integrators."""
    return f"{setting:.2g} J" if name.startswith("cut") else f"{1e6*setting:.3g} µs"


def headline(found: Comparison, target: float) -> list[Measure]:
    """Time and evaluations of ours, the others' times over ours, at equal error."""
    ours, times = found.best("ldbench", target)
    if not np.isfinite(times).all():
        return []
    at = f"at {target:g} m"
    setting = setting_text(ours, float(found.at(ours, target, lambda point: point.setting)[0]))
    out = [measure(found.name, ours, f"time {at}", "s", times, f"our fastest, {setting}"), evaluations(found, ours, target)]
    for family in "SUNDIALS", "SciPy":
        name, theirs = found.best(family, target)
        if not np.isfinite(theirs).all():
            continue
        tolerance = float(found.at(name, target, lambda point: point.setting)[0])
        out += [ratio(found.name, name, f"time of the best of {family} over ours {at}", theirs, times,
                      f"tolerance {tolerance:.1g} against {ours}"), evaluations(found, name, target)]
    return out


def evaluations(found: Comparison, name: str, target: float) -> Measure:
    count = found.at(name, target, lambda point: point.evaluations)
    return measure(found.name, name, f"evaluations at {target:g} m", "1", np.round(count))


def point_measures(found: Comparison) -> list[Measure]:
    source = found.reference.source
    out = [measure(found.name, source, "estimated error of the reference", "m", found.reference.error),
           measure(found.name, source, "distance of the other reference", "m", found.reference.apart)]
    for name, points in found.curves.items():
        for point in points:
            subject = f"{name}, {point.setting:g}"
            out += [measure(found.name, subject, "error of Y", "m", point.error),
                    measure(found.name, subject, "processor time", "s", point.times),
                    measure(found.name, subject, "force evaluations", "1", point.evaluations),
                    measure(found.name, subject, "Jacobians", "1", point.jacobians)]
    return out


def precision_figure(found: list[Comparison]) -> Figure:
    figure = Figure(figsize=PAGE, layout="constrained")
    figure.get_layout_engine().set(rect=(0, 0, 1, 0.93))       # the legend stands above
    columns = max(1, -(-len(found)//2))
    axes = figure.subplots(min(2, len(found)), columns, squeeze=False, sharex=True, sharey=True)
    drawn = [m for m in found[0].methods if any(case.curves[m.name] for case in found)]
    for k, case in enumerate(found):
        ax = axes[k % 2, k//2]
        for method in drawn:
            points = case.curves[method.name]
            if not points:
                continue
            low, middle, high = np.array([np.quantile(x.times, (0.25, 0.5, 0.75)) for x in points]).T
            ax.errorbar(middle, [max(x.error, 1e-13) for x in points], xerr=(middle - low, high - middle),
                        **THIN | method.line, elinewidth=0.6)
        for target in case.targets:
            ax.axhline(target, color=BLACK, linestyle=":", linewidth=0.7)
        ax.axhspan(1e-13, max(case.reference.error, 1.01e-13), color=GREY, alpha=0.15, linewidth=0)
        ax.set(title=case.name, xscale="log", yscale="log", ylim=(1e-12, 1e-2))
        ax.margins(x=0.05)
    for ax in axes[-1]:
        ax.set_xlabel("processor time [s]")
    for ax in axes[:, 0]:
        ax.set_ylabel("error of Y at the end [m]")
    handles = [Line2D([], [], **THIN | m.line) for m in drawn]
    figure.legend(handles, [m.name for m in drawn], loc="center right", bbox_to_anchor=(0.97, 0.965), ncols=11, fontsize=6.5)
    return figure


def section(full: bool) -> Section:
    out = Section("Work and precision", TEXT)
    peers = PEERS.exists()
    if not peers:
        print(NO_PEERS)
        out.text += f"\n\n{NO_PEERS}."
    tables = {pair: ContactTable(Case.exercise(1, pair)) for pair in ("aw", "sw")}
    methods = tuple(m for m in METHODS if (full or m.name not in FULL_METHODS) and (peers or m.family != "SUNDIALS"))
    found = []
    for exercise, pair in CASES:
        if full or exercise in USUAL:
            with problem(Case.exercise(exercise, pair), tables[pair]) as p:
                found.append(compare(p, methods, full))
    for case in found:
        for target in case.targets:
            out.measures += [replace(m, headline=m.headline and int(case.name[2]) in USUAL) for m in headline(case, target)]
    out.more = [m for case in found for m in point_measures(case)]
    with ldbench_style():
        out.figures.append(precision_figure(found))
    return out
