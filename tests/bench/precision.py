"""Work and precision: error of the trajectory at the end of a run over processor time, ours and others'."""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ldbench import Case, ContactTable
from ldbench.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, RED, SKY, ldbench_style
from measure import END, OUTPUTS, Form, Measure, Section, measure, ratio
from problem import PEERS, Problem, Reference, Solution, by_ours, by_peer, by_scipy, problem, python_alone, reference
from sheets import Table, page

CASES = [(exercise, pair) for exercise in (1, 2, 3, 4) for pair in ("aw", "sw")]
SHORT = [(2, "aw")]
THIN = {"linewidth": 1, "markersize": 2.5}
USUAL = 1, 2, 3                 # exercises, unless all are asked for; those whose ratios are printed
SHORT_METHODS = ("energy 4", "explicit 2", "explicit 4", "cut 4", "cut 6", "CVODE Adams", "CVODE BDF", "ARKODE 5", "LSODA",
                 "Python alone")
FULL_METHODS = "newmark 2", "newmark 4", "energy 2", "ARKODE 6", "ARKODE 8", "DOP853", "Radau", "Python alone"  # slower

TARGETS = 1e-7, 1e-9            # errors of Y at the end at which times are compared [m]
CHAOTIC = {"ex3_sw": 100}       # there so many times as much
MARGIN = 10                     # of the target over what the reference is uncertain by, else the target is larger
ENOUGH = 3                      # a method is not refined any more when its error is so many times below the last target
NEARBY = 1.0, 0.93, 0.86        # settings over the nominal one: a single one may be right by chance
LONG = 1.0                      # a solution that takes longer is not repeated [s]
ROUND = 0.05                    # a shorter one is repeated in every round until it takes so long [s]
TOO_LONG = {Form.SHORT: np.inf, Form.USUAL: 0.2, Form.FULL: 2.0}     # a method that does is not refined any more [s]
ROUNDS = {Form.SHORT: 1, Form.USUAL: 5, Form.FULL: 7}
OWN_STRICT = {Form.SHORT: (1e-9, 1e-10), Form.USUAL: (1e-11, 1e-12), Form.FULL: (1e-11, 1e-12)}      # of Python alone
CLOSE, CLOSER = 3.0, 1.4        # to its family's fastest a method has to be to be tried with other outputs, to be timed

STEPS = 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6          # [s]
TOLERANCES = tuple(10.0**-k for k in range(6, 14))
# Steps of the cut members [s] at a tolerance [J]; both change together, as dt^(order + 1).
UNCUT = {4: (4e-4, 1e-6), 6: (8e-4, 1e-6)}
ENERGIES = tuple(10.0**-k for k in range(2, 12))                # its tolerances [J]

TEXT = """The exercises up to the end of their runs, by the core's integrator and by others on the same compiled force.
Error: of Y at a common end time, against the core's cut steps of 5 µs with 1e-11 J or CVODE's Adams method with 3e-14,
whichever changes less from the setting before; their distance is in the table. Where contacts touch the law is not
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
every round the mean of as many solutions as take 50 ms, all methods in turn. Output: the end alone; events, and states at
the case's output interval; events and all 56 columns then, neither formatted nor kept. Others find events as roots of the
penetrations and interpolate the states, and evaluate the contacts once more for a row. Our steps are at most as long as
the output interval, so rows need no interpolation; where longer steps would do, they cost more than others' steps.
Without SUNDIALS ours is called from Python, where it includes events and 100 rows.

The usual form leaves out exercise 4 and methods that are slower: newmark, energy 2, ARKODE 6 and 8, DOP853, Radau, Python
alone: what a user would write with numpy, one Hertz spring per wheel along the contact angle, integrated by LSODA; its
errors are from its own strictest solution."""
NO_PEERS = "SUNDIALS with its Fortran modules is not here, so nothing compiled is compared with: ./bootstrap --sundials"


@dataclass(frozen=True)
class Method:
    name: str
    family: str                 # 'ldbench', 'SUNDIALS', 'SciPy', 'Python'
    settings: tuple[float, ...]
    solve: Callable[[Problem, str, float, float], Solution]     # output, seconds at least, setting
    line: dict[str, object]
    own: Callable[[Problem], Problem] | None = None     # another force law, which is its own reference

    @property
    def compiled(self) -> bool:
        return self.family in ("ldbench", "SUNDIALS")


def _ours(name: str, scheme: str, order: int, beta: float, color: str) -> Method:
    style = {"color": color, "linestyle": "-" if order == 4 else "--", "marker": "o" if order == 4 else "s"}
    return Method(name, "ldbench", STEPS, lambda p, output, least, dt: by_ours(p, output, least, scheme, order, beta, dt),
                  style)


def _cut(order: int, line: dict[str, object]) -> Method:
    step, energy = UNCUT[order]
    return Method(f"cut {order}", "ldbench", ENERGIES, lambda p, output, least, tolerance: by_ours(
        p, output, least, "newmark", order, 0.0, step*(tolerance/energy)**(1/(order + 1)), tolerance), line)


def _scipy(name: str, color: str) -> Method:
    return Method(name, "SciPy", TOLERANCES, lambda p, _, least, tolerance: by_scipy(p, least, name, tolerance),
                  {"color": color, "linestyle": ":", "marker": "^"})


def _peer(name: str, method: str, color: str, line: str) -> Method:
    return Method(name, "SUNDIALS", TOLERANCES,
                  lambda p, output, least, tolerance: by_peer(p, output, least, method, tolerance),
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
    _scipy("DOP853", RED), _scipy("LSODA", ORANGE), _scipy("Radau", PURPLE),
    Method("Python alone", "Python", TOLERANCES[:6], lambda p, _, least, tolerance: by_scipy(p, least, "LSODA", tolerance),
           {"color": ORANGE, "linestyle": "-", "marker": "x"}, python_alone))


# Measuring --------------------------------------------------------------------------------

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
    curves: dict[tuple[str, str], list[Point]] = field(default_factory=dict)    # by method and output

    def best(self, family: str, output: str, target: float) -> tuple[str, np.ndarray]:
        """The member of a family that is the fastest at a target; its times."""
        rows = [(np.median(times), name, times) for name, times in self.times(family, output, target).items()]
        return min(rows, key=lambda row: row[0])[1:] if rows else ("none", np.array([np.nan]))

    def times(self, family: str, output: str, target: float) -> dict[str, np.ndarray]:
        """The times of the family's members that reach the target."""
        found = {m.name: self.at(m.name, output, target, lambda point: point.times) for m in self.methods if m.family == family}
        return {name: times for name, times in found.items() if np.isfinite(times).all()}

    def at(self, name: str, output: str, target: float, values: Values) -> np.ndarray:
        """Interpolated between the settings about the target."""
        points = self.curves.get((name, output), [])
        bracket = around(points, target)
        if bracket is None:
            return np.array([np.nan])
        coarse, fine, share = bracket
        return np.atleast_1d(values(points[coarse])**(1 - share)*values(points[fine])**share)

    def close(self, method: Method, output: str, factor: float) -> bool:
        """Whether it may be the fastest of its family at a target."""
        return any(np.median(times[method.name]) <= factor*min(map(np.median, times.values()))
                   for times in (self.times(method.family, output, target) for target in self.targets)
                   if method.name in times)


def around(points: list[Point], target: float) -> tuple[int, int, float] | None:
    """The settings between which the error falls below the target for good, the way from one to the other."""
    above = [k for k, point in enumerate(points) if not point.error <= target]
    k = above[-1] if above else -1
    if k == len(points) - 1:
        return None
    if k < 0:
        return 0, 0, 0.0        # at most
    return k, k + 1, float(np.log(points[k].error/target)/np.log(points[k].error/max(points[k + 1].error, 1e-16)))


def targets(name: str, exact: Reference, form: Form) -> list[float]:
    """From large to small, each a power of ten at which the reference is certain enough."""
    doubt = max(exact.error, exact.apart, 1e-16)
    least = 10.0**np.ceil(np.log10(MARGIN*doubt))
    wanted = TARGETS[:1] if form is Form.SHORT else TARGETS
    return sorted({float(f"{max(target*CHAOTIC.get(name, 1), least):.0e}") for target in wanted}, reverse=True)


def compare(p: Problem, methods: tuple[Method, ...], form: Form) -> Comparison:
    """Every method once with every setting, then in rounds those about the targets that may be the fastest."""
    exact = reference(p, form is Form.SHORT)
    found = Comparison(p.case.case_name, p, exact, methods, targets(p.case.case_name, exact, form))
    chosen = []
    for output in OUTPUTS if p.program else (END,):
        for method in methods:
            if output == END or (method.compiled and found.close(method, END, CLOSE)):
                found.curves[method.name, output] = refine(found, method, output, form)
        for method in methods:
            if not found.close(method, output, CLOSER):
                continue
            points = found.curves[method.name, output]
            brackets = [x for x in (around(points, target) for target in found.targets) if x]
            chosen += [(method, output, points[k]) for k in sorted({k for x in brackets for k in x[:2]})]
    for _ in range(ROUNDS[form]):
        for method, output, point in chosen:
            least = 0 if point.first > LONG else ROUND
            point.seconds.append(method.solve(posed(p, method), output, least, point.setting).seconds)
    return found


def posed(p: Problem, method: Method) -> Problem:
    return method.own(p) if method.own else p


def own_reference(p: Problem, form: Form) -> Reference:
    """The reference of another force law: LSODA's solution."""
    strict = OWN_STRICT[form]
    coarse, fine = (by_scipy(p, 0, "LSODA", tolerance).pose for tolerance in strict)
    return Reference(fine, float(abs(coarse[0] - fine[0])), f"LSODA, {strict[1]:g}", np.nan)


def refine(found: Comparison, method: Method, output: str, form: Form) -> list[Point]:
    """One setting after the other until the error is small enough or a solution takes too long."""
    p = posed(found.problem, method)
    exact = own_reference(p, form) if method.own else found.reference
    enough = found.targets[-1 if method.compiled else 0]/ENOUGH
    points = []
    for setting in method.settings:
        solutions = [method.solve(p, output, 0, setting*factor) for factor in NEARBY]
        error = np.sqrt(np.mean([(s.pose[0] - exact.pose[0])**2 for s in solutions]))
        if np.isnan(error):
            continue
        seconds = float(np.median([s.seconds for s in solutions]))
        points.append(Point(setting, float(error), solutions[0].evaluations, solutions[0].jacobians, seconds))
        if error < enough or seconds > TOO_LONG[form]:
            break
    return points


# At equal error ---------------------------------------------------------------------------

def setting_text(name: str, setting: float) -> str:
    """The text of a setting of one of our integrators."""
    return f"{setting:.2g} J" if name.startswith("cut") else f"{1e6*setting:.3g} µs"


def headline(found: Comparison, output: str, target: float) -> list[Measure]:
    """Time and evaluations of ours, the others' times over ours, at equal error."""
    ours, times = found.best("ldbench", output, target)
    if not np.isfinite(times).all():
        return []
    at = f"at {target:g} m, {output}"
    setting = setting_text(ours, float(found.at(ours, output, target, lambda point: point.setting)[0]))
    out = [measure(found.name, ours, f"time {at}", "s", times, f"our fastest, {setting}")]
    out += [evaluations(found, ours, output, target)]
    for family in "SUNDIALS", "SciPy", "Python":
        name, theirs = found.best(family, output, target)
        if not np.isfinite(theirs).all():
            continue
        tolerance = float(found.at(name, output, target, lambda point: point.setting)[0])
        what = "ours" if family != "Python" else "ours, of a law of its own"
        out += [ratio(found.name, name, f"time of the best of {family} over {what} {at}", theirs, times,
                      f"tolerance {tolerance:.1g} against {ours}"), evaluations(found, name, output, target)]
    return out


def evaluations(found: Comparison, name: str, output: str, target: float) -> Measure:
    count = found.at(name, output, target, lambda point: point.evaluations)
    return measure(found.name, name, f"evaluations at {target:g} m, {output}", "1", np.round(count))


# Output -----------------------------------------------------------------------------------

def point_measures(found: Comparison) -> list[Measure]:
    source = found.reference.source
    out = [measure(found.name, source, "estimated error of the reference", "m", found.reference.error),
           measure(found.name, source, "distance of the other reference", "m", found.reference.apart)]
    for (name, output), points in found.curves.items():
        for point in points:
            subject = f"{name}, {point.setting:g}, {output}"
            out += [measure(found.name, subject, "error of Y", "m", point.error),
                    measure(found.name, subject, "processor time", "s", point.times),
                    measure(found.name, subject, "force evaluations", "1", point.evaluations),
                    measure(found.name, subject, "Jacobians", "1", point.jacobians)]
    return out


def headline_table(found: list[Comparison], output: str) -> Table:
    head = ["case", "end [s]", "at [m]", "ours", "time [ms]", "evaluations", "best of SUNDIALS", "evaluations",
            "its time / ours", *["best of SciPy / ours"]*(output == END)]
    rows = []
    for case in found:
        for target in case.targets:
            done = headline(case, output, target)
            if not done:
                continue
            ours, count, *others = done
            by_family = {m.quantity.split(" over ")[0].split()[-1]: (m, n) for m, n in zip(others[::2], others[1::2], strict=False)}
            cells = ["–"]*3
            if "SUNDIALS" in by_family:
                m, n = by_family["SUNDIALS"]
                cells = [m.subject, f"{n.median:.0f}", m.text()]
            rows.append([case.name, f"{case.problem.t_end:.4f}", f"{target:g}", f"{ours.subject}, {ours.note[13:]}",
                         f"{1e3*ours.median:.3g}", f"{count.median:.0f}", *cells])
            if output == END:
                scipy, _ = by_family.get("SciPy", (None, None))
                rows[-1].append(f"{scipy.text()} {scipy.subject}" if scipy else "–")
    return Table(f"Processor time at equal error of Y: {output}; median (quartiles)", head, rows)


def member_table(found: list[Comparison], output: str) -> Table:
    """Every method at the targets."""
    methods = [m for m in found[0].methods if any((m.name, output) in case.curves for case in found)]
    rows = []
    for case in found:
        for target in case.targets:
            times = {m.name: case.times(m.family, output, target).get(m.name) for m in methods}
            rows.append([f"{case.name}, {target:g} m", *(
                "–" if x is None else
                f"{1e3*np.median(x):.3g} / {case.at(name, output, target, lambda point: point.evaluations)[0]:.0f}"
                for name, x in times.items())])
    return Table(f"Processor time [ms] / evaluations at that error: {output}", ["case", *(m.name for m in methods)], rows)


def reference_table(found: list[Comparison]) -> Table:
    """What errors are measured from."""
    return Table("References", ("case", "reference", "estimated error [m]", "distance of the other [m]"), [
        [c.name, c.reference.source, f"{c.reference.error:.0e}", f"{c.reference.apart:.0e}"] for c in found])


def precision_figure(found: list[Comparison], output: str) -> Figure:
    figure = page(f"Error of Y at the end over processor time: {output}",
                  "Every mark is a step (200 µs to 1 µs), a tolerance (1e-6 to 1e-13) or, of cut steps, an energy (1e-2 J to "
                  "1e-11 J); bars: quartiles, of what was timed in rounds. Dotted: where times are compared; shaded: below "
                  "the estimated error of the reference.")
    figure.get_layout_engine().set(rect=(0.03, 0.07, 0.94, 0.82))       # the legend stands above
    columns = max(1, -(-len(found)//2))
    axes = figure.subplots(min(2, len(found)), columns, squeeze=False, sharex=True, sharey=True)
    drawn = [m for m in found[0].methods if any(case.curves.get((m.name, output)) for case in found)]
    for k, case in enumerate(found):
        ax = axes[k % 2, k//2]
        for method in drawn:
            points = case.curves.get((method.name, output))
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
    figure.legend(handles, [m.name for m in drawn], loc="center right", bbox_to_anchor=(0.97, 0.915), ncols=11, fontsize=6.5)
    return figure


def section(form: Form) -> Section:
    short = form is Form.SHORT
    out = Section("Work and precision", TEXT)
    peers = PEERS.exists()
    if not peers:
        print(NO_PEERS)
        out.text += f"\n\n{NO_PEERS}."
    tables = {pair: ContactTable(Case.exercise(1, pair)) for pair in (("aw",) if short else ("aw", "sw"))}
    methods = tuple(replace(m, settings=m.settings[1:6:2]) for m in METHODS if m.name in SHORT_METHODS) if short \
        else tuple(m for m in METHODS if form is Form.FULL or m.name not in FULL_METHODS)
    methods = tuple(m for m in methods if peers or m.family != "SUNDIALS")
    found = []
    for exercise, pair in SHORT if short else CASES:
        if form is Form.FULL or exercise in USUAL:
            with problem(Case.exercise(exercise, pair), tables[pair]) as p:
                found.append(compare(p, methods, form))
    outputs = OUTPUTS if peers else (END,)
    for case in found:
        for measures in (headline(case, output, target) for output in outputs for target in case.targets):
            out.measures += [replace(m, headline=m.headline and int(case.name[2]) in USUAL) for m in measures]
    out.measures += [m for case in found for m in point_measures(case)]
    out.tables += [*(headline_table(found, output) for output in outputs), *(member_table(found, x) for x in outputs),
                   reference_table(found)]
    with ldbench_style():
        out.figures += [precision_figure(found, output) for output in outputs]
    return out
