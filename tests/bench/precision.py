"""Work and precision: error of the trajectory at the end of a run over processor time, ours and others'."""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from checks import Table, page
from ldbench import Case, ContactTable, _flat
from ldbench.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, ldbench_style
from measure import Form, Measure, Section, measure, ratio
from problem import ROWS, Problem, Reference, Solution, by_cvode, by_ldbench, by_scipy, problem, python_alone, reference

CASES = [(exercise, pair) for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
SHORT = [(2, "aw")]
THIN = {"linewidth": 1, "markersize": 2.5}
USUAL = 1, 2, 3                 # exercises, unless all are asked for
SHORT_METHODS = "energy 4", "explicit 2", "explicit 4", "cut 4", "LSODA", "CVODE Adams", "Python alone"
FULL_METHODS = "newmark 2", "newmark 4", "energy 2", "Radau", "CVODE BDF", "Python alone"     # slower ones
HEADLINE = 1, 2, 3              # exercises compared at TARGET

TARGET = 1e-7                   # error of Y at the end at which times are compared [m]
MARGIN = 10                     # of the target over what the reference is uncertain by, else the target is larger
ENOUGH = 3e-9                   # error from which on a method is not refined any more [m]
NEARBY = 1.0, 0.93, 0.86        # settings over the nominal one: a single one may be right by chance
LONG = 1.0                      # a solution that takes longer is not repeated [s]
ROUND = 0.05                    # a shorter one is repeated in every round until it takes so long [s]
TOO_LONG = {Form.SHORT: np.inf, Form.USUAL: 0.5, Form.FULL: 2.0}     # a method that does is not refined any more [s]
FAMILIES = "SciPy", "CVODE"       # that ours is compared with

STEPS = 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6          # [s]
TOLERANCES = tuple(10.0**-k for k in range(6, 13))
UNCUT = 4e-4, 1e-6              # step of the cut member [s] at a tolerance [J]; both change together, as dt^5
ENERGIES = tuple(10.0**-k for k in range(2, 10))                # its tolerances [J]

TEXT = """The exercises up to the end of their runs, once by the core's integrator and once by others on the same
compiled force law. Error: of Y at a common end time, against DOP853 with relative tolerance 1e-13 or the core's
fourth order with 0.5 µs, whichever changes less from the setting before; their distance is in the table. Where
contacts touch the law is not smooth, so a step may be right by chance: errors are the root mean square of three
settings a few percent apart. Processor time: of the integration alone, in every round the mean of as many as take
50 ms; the core's includes events, energies and 100 rows of columns that the others do not have.

Ours: newmark (beta = 1/4), energy (average acceleration with discrete gradient), explicit (beta = 0); 2 and 4 are
orders. cut 4: explicit 4 with steps that are cut where they change the energy by more than a tolerance, as shipped;
its setting is the tolerance in joules, and the step 0.4 ms at 1e-6 J goes with its fifth root. SciPy: DOP853, LSODA,
Radau with the compiled tangent as Jacobian. CVODE of SUNDIALS (through scikit-sundae): BDF and Adams, with the same
Jacobian; z is measured from equilibrium, tolerances are relative to 1 cm, 1 m/s.

The others call the force through Python, which costs several times the force itself. Therefore every ratio is given
twice: with the time as measured, and with evaluations (force and Jacobian) times the time of an evaluation in a
compiled loop over the same trajectory. The second is what a compiled program could reach at best: the integrator's
own arithmetic is left out. Times at equal error are interpolated between settings, logarithmically, where the error
falls below the target for good. The usual form leaves out exercise 4 and methods that are slower: newmark, energy 2,
Radau, BDF, Python alone. Python alone: what a user would write with numpy, one Hertz spring per wheel along
the contact angle, integrated by LSODA; its errors are from its own strictest solution. The target is 1e-7 m; where the
two references are further apart than a tenth of it, the next power of ten (exercise 3 with simplified profiles is
chaotic)."""


@dataclass(frozen=True)
class Method:
    name: str
    family: str                 # 'ldbench', 'SciPy', 'CVODE'
    settings: tuple[float, ...]
    solve: Callable[[Problem, float], Solution]
    line: dict[str, object]
    own: Callable[[Problem], Problem] | None = None     # another force law, which is its own reference


def _ours(name: str, scheme: str, order: int, beta: float, color: str) -> Method:
    style = {"color": color, "linestyle": "-" if order == 4 else "--", "marker": "o" if order == 4 else "s"}
    return Method(name, "ldbench", STEPS, lambda p, dt: by_ldbench(p, scheme, order, beta, dt), style)


def _cut(p: Problem, tolerance: float) -> Solution:
    step, energy = UNCUT
    return by_ldbench(p, "newmark", 4, 0.0, min(step*(tolerance/energy)**0.2, p.t_end/ROWS), tolerance)


def _scipy(name: str, color: str) -> Method:
    return Method(name, "SciPy", TOLERANCES, lambda p, tolerance: by_scipy(p, name, tolerance),
                  {"color": color, "linestyle": ":", "marker": "^"})


def _cvode(name: str, color: str) -> Method:
    return Method(f"CVODE {name}", "CVODE", TOLERANCES, lambda p, tolerance: by_cvode(p, name, tolerance),
                  {"color": color, "linestyle": "-.", "marker": "D"})


METHODS = (
    _ours("energy 2", "energy", 2, 0.25, BLUE), _ours("energy 4", "energy", 4, 0.25, BLUE),
    _ours("newmark 2", "newmark", 2, 0.25, SKY), _ours("newmark 4", "newmark", 4, 0.25, SKY),
    _ours("explicit 2", "newmark", 2, 0.0, BLACK), _ours("explicit 4", "newmark", 4, 0.0, BLACK),
    Method("cut 4", "ldbench", ENERGIES, _cut, {"color": BLACK, "linestyle": "-", "marker": "*", "linewidth": 1.8,
                                             "markersize": 5}),
    _scipy("DOP853", RED), _scipy("LSODA", ORANGE), _scipy("Radau", PURPLE),
    _cvode("BDF", GREEN), _cvode("Adams", GREY),
    Method("Python alone", "Python", TOLERANCES[:6], lambda p, tolerance: by_scipy(p, "LSODA", tolerance),
           {"color": ORANGE, "linestyle": "-", "marker": "x"}, python_alone))


# Measuring --------------------------------------------------------------------------------

@dataclass
class Point:
    """A method with one setting."""

    setting: float
    error: float                # of Y, root mean square of nearby settings [m]
    calls: int                  # of force and Jacobian together
    evaluations: int
    first: float                # time, out of cold caches [s]
    seconds: list[float] = field(default_factory=list)      # per round


@dataclass
class Comparison:
    name: str
    problem: Problem
    reference: Reference
    curves: dict[str, list[Point]] = field(default_factory=dict)
    call: list[float] = field(default_factory=list)         # time of a compiled evaluation, per round [s]

    @property
    def target(self) -> float:
        """TARGET, or the next power of ten at which the reference is certain enough: a chaotic run."""
        doubt = max(self.reference.error, self.reference.apart)
        return max(TARGET, 10.0**np.ceil(np.log10(MARGIN*max(doubt, 1e-16))))

    def measured(self, method: Method, point: Point) -> np.ndarray:
        """Processor time per round [s]."""
        return np.array(point.seconds)

    def compiled(self, method: Method, point: Point) -> np.ndarray:
        """The same in a compiled program, at least [s]."""
        return np.array(point.seconds if method.family == "ldbench" else [point.calls*x for x in self.call])


def compiled_call(p: Problem) -> float:
    """Time of one evaluation in a compiled loop over the trajectory [s]."""
    rows = p.trajectory
    begin = time.process_time()
    count = max(1, 100_000//len(rows[0]))
    for _ in range(count):
        _flat.forces(p.table._handle, 0, *rows)
    return (time.process_time() - begin)/(count*len(rows[0]))


def compare(p: Problem, methods: tuple[Method, ...], rounds: int, form: Form) -> Comparison:
    """All methods, one after the other, in every round."""
    found = Comparison(p.case.case_name, p, reference(p, form is Form.SHORT))
    for k in range(rounds):
        found.call.append(compiled_call(p))
        for method in methods:
            posed = method.own(p) if method.own else p
            if k == 0:
                exact = own_reference(posed) if method.own else found.reference
                found.curves[method.name] = refine(posed, method, exact, TOO_LONG[form])
            for point in found.curves[method.name]:
                point.seconds.append(repeated(posed, method, point))
    return found


def own_reference(p: Problem) -> Reference:
    """Of another force law: LSODA's solution."""
    coarse, fine = (by_scipy(p, "LSODA", tolerance).pose for tolerance in (1e-11, 1e-12))
    return Reference(fine, float(abs(coarse[0] - fine[0])), "LSODA, 1e-12", np.nan)


def repeated(p: Problem, method: Method, point: Point) -> float:
    """Mean processor time of a round [s]."""
    if point.first > LONG:
        return point.first
    count = max(1, round(ROUND/max(point.first, ROUND/50)))
    return float(np.mean([method.solve(p, point.setting).seconds for _ in range(count)]))


def refine(p: Problem, method: Method, exact: Reference, too_long: float) -> list[Point]:
    """One setting after the other until the error is small enough or a solution takes `too_long` [s]."""
    points = []
    for setting in method.settings:
        solutions = [method.solve(p, setting*factor) for factor in NEARBY]
        first = solutions[0]
        error = np.sqrt(np.mean([(s.pose[0] - exact.pose[0])**2 for s in solutions]))
        if np.isnan(error):
            continue
        points.append(Point(setting, float(error), first.evaluations + first.jacobians, first.evaluations,
                            first.seconds))
        if error < ENOUGH or first.seconds > too_long:
            break
    return points


# At equal error ---------------------------------------------------------------------------

def at_target(points: list[Point], costs: list[np.ndarray], target: float) -> tuple[np.ndarray, float]:
    """Cost per round and setting at which the error falls below the target for good; NaN if it does not."""
    above = [k for k, point in enumerate(points) if not point.error <= target]
    k = above[-1] if above else -1
    if k == len(points) - 1:
        return np.full_like(costs[0], np.nan) if costs else np.array([np.nan]), np.nan
    if k < 0:
        return costs[0], points[0].setting      # at most
    coarse, fine = points[k], points[k + 1]
    share = np.log(coarse.error/target)/np.log(coarse.error/max(fine.error, 1e-16))
    return costs[k]**(1 - share)*costs[k + 1]**share, coarse.setting**(1 - share)*fine.setting**share


def best(found: Comparison, family: str, cost: Callable[[Method, Point], np.ndarray],
         methods: tuple[Method, ...]) -> tuple[str, float, np.ndarray]:
    """The member of a family that is the fastest at the target: name, setting, cost per round."""
    rows = []
    for method in (m for m in methods if m.family == family):
        points = found.curves[method.name]
        costs, setting = at_target(points, [cost(method, point) for point in points], found.target)
        if np.isfinite(costs).all():
            rows.append((np.median(costs), method.name, setting, costs))
    if not rows:
        return "none", np.nan, np.full(len(found.call), np.nan)
    _, name, setting, costs = min(rows, key=lambda row: row[0])
    return name, setting, costs


def setting_text(name: str, setting: float) -> str:
    """Of a member of ours."""
    return f"{setting:.2g} J" if name == "cut 4" else f"{1e6*setting:.3g} µs"


def headline(found: Comparison, methods: tuple[Method, ...]) -> list[Measure]:
    """Times of the others over ours, at equal error, both ways."""
    out = []
    name, setting, ours = best(found, "ldbench", found.measured, methods)
    out.append(measure(found.name, name, f"time at {found.target:g} m", "s", ours,
                       f"our fastest, {setting_text(name, setting)}", True))
    for family in FAMILIES:
        for way, cost in (("measured", found.measured), ("compiled", found.compiled)):
            other, tolerance, seconds = best(found, family, cost, methods)
            out.append(ratio(found.name, other, f"time of the best of {family} over ours at {found.target:g} m, {way}",
                             seconds, ours, f"tolerance {tolerance:.1g} against {name}"))
    other, tolerance, seconds = best(found, "Python", found.measured, methods)
    if np.isfinite(seconds).all():          # its law has kinks
        out.append(ratio(found.name, other, f"time over ours at {found.target:g} m, of a law of its own", seconds, ours,
                         f"tolerance {tolerance:.1g} against {name}"))
    return out


# Output -----------------------------------------------------------------------------------

def point_measures(found: Comparison, methods: tuple[Method, ...]) -> list[Measure]:
    out = [measure(found.name, "compiled loop", "time of an evaluation", "s", found.call),
           measure(found.name, found.reference.source, "estimated error of the reference", "m", found.reference.error),
           measure(found.name, found.reference.source, "distance of the other reference", "m", found.reference.apart)]
    for method in methods:
        for point in found.curves[method.name]:
            subject = f"{method.name}, {point.setting:g}"
            out.append(measure(found.name, subject, "error of Y", "m", point.error))
            out.append(measure(found.name, subject, "processor time", "s", found.measured(method, point)))
            out.append(measure(found.name, subject, "force evaluations", "1", point.evaluations))
            out.append(measure(found.name, subject, "Jacobians", "1", point.calls - point.evaluations))
            if method.family in FAMILIES:
                out.append(measure(found.name, subject, "evaluations x compiled evaluation", "s",
                                   found.compiled(method, point)))
    return out


def headline_table(found: list[Comparison], methods: tuple[Method, ...]) -> Table:
    head = ["case", "end [s]", "at [m]", "our fastest", "setting", "time [ms]",
            *(f"best of {family} / ours, {way}" for family in FAMILIES for way in ("measured", "compiled")),
            "Python alone / ours"]
    rows = []
    for case in found:
        ours, *ratios = headline(case, methods)
        setting = best(case, "ldbench", case.measured, methods)[1]
        rows.append([case.name, f"{case.problem.t_end:.4f}", f"{case.target:g}", ours.subject,
                     setting_text(ours.subject, setting), f"{1e3*ours.median:.3g}",
                     *(f"{r.text()} {r.subject}" for r in ratios),
                     *["–"]*(2*len(FAMILIES) + 1 - len(ratios))])
    return Table("Processor time at equal error of Y: the others over ours, median (quartiles)", head, rows)


def member_table(found: list[Comparison], methods: tuple[Method, ...]) -> Table:
    """Time of every method at the target."""
    head = ["case", *(m.name for m in methods)]
    rows = []
    for case in found:
        cells = []
        for method in methods:
            points = case.curves[method.name]
            costs = [at_target(points, [way(method, x) for x in points], case.target)[0]
                     for way in (case.measured, case.compiled)]
            words = [f"{1e3*np.median(x):.3g}" for x in costs[:2 if method.family in FAMILIES else 1]]
            cells.append(" / ".join(words) if np.isfinite(costs[0]).all() else "–")
        rows.append([case.name, *cells])
    return Table("Processor time at that error [ms]; others: measured / evaluations x compiled evaluation", head, rows)


def reference_table(found: list[Comparison]) -> Table:
    """What errors are measured from, and the unit of the compiled costs."""
    head = "case", "reference", "estimated error [m]", "distance of the other [m]", "compiled evaluation [µs]"
    return Table("References", head, [[c.name, c.reference.source, f"{c.reference.error:.0e}",
                                       f"{c.reference.apart:.0e}", f"{1e6*np.median(c.call):.2f}"] for c in found])


def precision_figure(found: list[Comparison], methods: tuple[Method, ...], way: str) -> Figure:
    titles = {"measured": "Error of Y at the end over processor time, as measured",
              "compiled": "Error of Y at the end over processor time; of the others: evaluations x compiled evaluation"}
    figure = page(titles[way], "Every mark is a step (200 µs to 1 µs), a tolerance (1e-6 to 1e-12) or, of cut 4, an "
                  "energy (1e-2 J to 1e-9 J); bars: quartiles. Dotted: where times are compared; shaded: below the "
                  "estimated error of the reference.")
    figure.get_layout_engine().set(rect=(0.03, 0.07, 0.94, 0.82))       # the legend stands above
    columns = max(1, -(-len(found)//2))
    axes = figure.subplots(min(2, len(found)), columns, squeeze=False, sharex=True, sharey=True)
    for k, case in enumerate(found):
        ax = axes[k % 2, k//2]
        for method in methods:
            points = case.curves[method.name]
            if not points or (way == "compiled" and method.own):
                continue
            cost = case.measured if way == "measured" else case.compiled
            times = np.array([cost(method, x) for x in points])
            low, middle, high = np.quantile(times, (0.25, 0.5, 0.75), axis=1)
            ax.errorbar(middle, [max(x.error, 1e-13) for x in points], xerr=(middle - low, high - middle),
                        **THIN | method.line, elinewidth=0.6)
        ax.axhline(case.target, color=BLACK, linestyle=":", linewidth=0.7)
        ax.axhspan(1e-13, max(case.reference.error, 1.01e-13), color=GREY, alpha=0.15, linewidth=0)
        ax.set(title=case.name, xscale="log", yscale="log", ylim=(1e-12, 1e-2))
        ax.margins(x=0.05)
    for ax in axes[-1]:
        ax.set_xlabel("processor time [s]")
    for ax in axes[:, 0]:
        ax.set_ylabel("error of Y at the end [m]")
    handles = [Line2D([], [], **THIN | m.line) for m in methods]
    figure.legend(handles, [m.name for m in methods], loc="center right", bbox_to_anchor=(0.97, 0.915), ncols=11,
                  fontsize=6.5)
    return figure


def section(form: Form) -> Section:
    short = form is Form.SHORT
    out = Section("Work and precision", TEXT)
    tables = {pair: ContactTable(Case.exercise(1, pair)) for pair in (("aw",) if short else ("aw", "sw"))}
    methods = tuple(replace(m, settings=m.settings[1:6:2]) for m in METHODS if m.name in SHORT_METHODS) if short \
        else tuple(m for m in METHODS if form is Form.FULL or m.name not in FULL_METHODS)
    cases = SHORT if short else [case for case in CASES if form is Form.FULL or case[0] in USUAL]
    found = [compare(problem(Case.exercise(*case), tables[case[1]]), methods, 5 if form is Form.FULL else 3, form)
             for case in cases]
    for case in found:
        if int(case.name[2]) in HEADLINE:
            out.measures += headline(case, methods)
    out.measures += [m for case in found for m in point_measures(case, methods)]
    out.tables += [headline_table(found, methods), member_table(found, methods), reference_table(found)]
    with ldbench_style():
        out.figures += [precision_figure(found, methods, way) for way in ("measured", "compiled")]
    return out
