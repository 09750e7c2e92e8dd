"""How the ten answers move with what the benchmark call leaves open, and how fast neighbouring motions part.

Each variant changes one thing of the shipped cases: the crown radius of the rail (actual 8, 10, 14 in; simplified 250, 300,
350 mm) and the throat radii of the flange (10 % either way), in both cases with the throat moved so that the published
clearance is kept; smoothing of the profile points; Z = 0 where the unloaded instead of the loaded wheelset stands; the contact
model; the step and the integrator; and, as a measure of chance, a start 1 nm aside. Finer step: half the step and a 32nd of
the energy tolerance. Newmark: average acceleration (beta = 1/4), order 2; energy: the same with a discrete gradient. Both have
steps of 2 µs, in exercise 5 50 µs, that are not cut. A change that is no larger than what 1 nm at the start does says nothing
about the model.

Divergence: the distance of two motions is the root of the sum of squares of their differences in Y, Z and roll times the
radius of gyration, and of the rates of these over the vertical eigenfrequency. Rate and factor are of the geometric mean of
four twins, started 1 nm aside (Y) and 1 nrad turned (roll), either way.

Twins on either side must part alike while the motion is linear in the distance: the sum of their two differences from the
motion between them, over the smaller one, has two bars. The force goes with the 3/2 power of the penetration p, so a distance
d makes a second-order part of d/(4 p) in each impact, and in each period of the vertical oscillation, since the frequency
depends on the amplitude; d is the largest distance so far and p the approach at rest. Rounding and cuts of steps part motions
as well: four probes that start 1e-15 m or rad apart show how far. The sum has six times the variance of one motion's error,
the distance of a probe twice; four times the largest of the four covers that. Twins are compared until one is a thousandth of
the approach away.
"""
from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from math import asin, radians, sin
from pathlib import Path

import numpy as np

import ldbench
import make_profiles as mp
from checks import Check, Section, absolute, limit, relative
from integration import refined
from ldbench import Case, ContactTable
from ldbench.case import Value, data_folder
from ldbench_round.tasks import clearances
from sheets import Table

PAIRS = clearances()
MODELS = "halfspace", "strip", "hertz"     # the first is that of the shipped cases
RAMP_ROWS = 1e-2            # output interval of exercise 5 [s]
STEP, RAMP_STEP = 2e-6, 5e-5    # of the schemes of order 2, for exercises 1 to 4 and for 5 [s]
ASIDE = 1e-9                # of a start that shows chance [m]
TWIN = 1e-9                 # distance at which twins start [m, rad]
PROBE = 1e-15               # distance at which probes start: rounding and cuts of steps soon part them farther [m, rad]
LINEAR = 1e-3               # twins are compared up to this distance, of the wheelset's approach at rest
TWIN_RAMP_END = 0.6         # of exercise 5 for the twins; they have parted soon after [s]
TWIN_FACTORS = 0.5, 0.125   # of the step for twins, exercises 1 to 4 and 5: the growth is that of a finer motion

def smoothed(folder: Path, pair: str) -> dict[str, Value]:
    """Write rail and wheel smoothed by 0.02 mm; the case's changes."""
    paths = {"wheel_profile": folder/f"{pair}_wheel.yz", "rail_profile": folder/f"{pair}_rail.yz"}
    for (kind, path), name in zip(paths.items(), (f"{pair}prof", f"{pair[0]}rprof"), strict=True):
        ldbench.Profile(data_folder()/"profiles"/f"{name}.yz", kind.partition("_")[0], smoothing=0.02).write(path)
    return {kind: str(path) for kind, path in paths.items()} | {"table_folder": ""}


def write_profiles(folder: Path, pair: str, crown: float | None = None, throat: float = 1.0,
                   corner: float = 14.2875) -> dict[str, Value]:
    """Write rail and wheel with another crown radius [mm] and throat radii times a factor; the case's changes.

    corner: radius of the actual rail's gauge corner [mm].

    The chains of make_profiles.py; the throat is solved for the published clearance as there."""
    if pair == "aw":
        a1, a2, a3 = asin(16.5/(crown or 254)), radians(30), np.pi/2 - mp.CANT
        R = crown or 254
        head = [(corner, a3, a2), (31.75, a2, a1), (R, a1, -a1), (31.75, -a1, -a2), (corner, -a2, -a3)]
        rail = mp.rail([mp.arc(R, g0 + mp.CANT, g1 + mp.CANT) for R, g0, g1 in head])

        def wheel(y: float) -> list:
            a, b = radians(75), radians(25)
            return mp.wheel(y, 78, mp.arc(-10, 0, a), mp.line(a, 3.1/sin(a)), mp.arc(17.4625*throat, a, b),
                            mp.arc(38.1*throat, b, mp.TAPER))
    else:
        R = crown or 300
        a = asin(24/R)
        rail = mp.rail([mp.arc(12, np.pi/2, a + mp.CANT), mp.arc(R, a + mp.CANT, -a + mp.CANT),
                        mp.arc(12, -a + mp.CANT, -np.pi/2)])

        def wheel(y: float) -> list:
            a = radians(70)
            return mp.wheel(y, 76, mp.arc(-10, 0, a), mp.line(a, 6/sin(a)), mp.arc(18*throat, a, mp.TAPER))
    stem = f"{pair}_{R:g}_{throat:g}_{corner:g}"
    files = folder/f"{stem}_wheel.yz", folder/f"{stem}_rail.yz"
    mp.write(files[0], wheel(mp.solve_throat(wheel, rail, 1e3*PAIRS[pair])), "wheel", [])
    mp.write(files[1], rail, "rail", [])
    return {"wheel_profile": str(files[0]), "rail_profile": str(files[1]), "table_folder": ""}


@dataclass(frozen=True)
class Variant:
    """One thing changed."""

    name: str
    group: str
    table: dict[str, Value]                             # what the contact table depends on
    rest: Callable[[Case, ContactTable], dict[str, Value]] = lambda case, table: {}


CROWNS = {"aw": (203.2, 355.6), "sw": (250.0, 350.0)}   # [mm]
SETTING = "dt", "energy_tolerance"
EXERCISES = 1, 2, 3, 4, 5


def variants(pair: str, folder: Path) -> list[Variant]:
    """All variants of a pair, the base first; profiles go to `folder`."""
    low, high = CROWNS[pair]
    found = [       # name, group, changes that need a table of their own, other changes
        ("base", "", dict, None),
        ("rail crown smaller", "crown", lambda: write_profiles(folder, pair, crown=low), None),
        ("rail crown larger", "crown", lambda: write_profiles(folder, pair, crown=high), None),
        ("throat radii −10 %", "throat", lambda: write_profiles(folder, pair, throat=0.9), None),
        ("throat radii +10 %", "throat", lambda: write_profiles(folder, pair, throat=1.1), None),
        ("smoothing 0.02 mm", "smoothing", lambda: smoothed(folder, pair), None),
        ("unloaded start", "Z = 0", dict, lambda case, table: {"Z": table.rigid_height - table.equilibrium}),
        *((f"model {m}", "model", lambda m=m: {"contact_model": m}, None)
          for m in MODELS[1:]),
        ("finer step", "numerics", dict, lambda case, table: {n: getattr(refined(case, 0.5), n) for n in SETTING}),
        ("Newmark, order 2", "numerics", dict, lambda case, table: {
            "beta": 0.25, "order": 2, "energy_tolerance": 0.0, "error_tolerance": 0.0,
            "dt": RAMP_STEP if case.lateral_ramp else STEP}),
        *((f"start {sign}1 nm", "chance", dict, lambda case, table, Y=Y: {"Y": Y})
          for sign, Y in (("+", ASIDE), ("−", -ASIDE)))]
    return [Variant(name, group, change(), *([rest] if rest else [])) for name, group, change, rest in found]


def base_case(exercise: int, pair: str) -> Case:
    case = Case.exercise(exercise, pair).replace(rows="interval")
    return case.replace(interval=RAMP_ROWS) if exercise == 5 else case


TIMES = "t_LF", "t_RF", "t_end"
FORCES = "N_LF", "N_RF"
LONG = {"t_LF": "first left flange contact", "t_RF": "first right flange contact", "t_end": "return or derailment",
        "N_LF": "peak normal force, left flange", "N_RF": "peak normal force, right flange"}


@dataclass(frozen=True)
class Answers:
    """What a run answers; times in s, forces in N, nan for what did not happen. F is the lateral force at derailment."""

    numbers: dict[str, float]
    ending: str             # 'returns' or 'derails'
    drift: float            # of the energy, largest, over the kinetic energy at the start


def answers(case: Case, table: ContactTable) -> Answers:
    """Run a case."""
    s = ldbench.run(case, table=table).results
    end = s["t_derailment"] if s["derailed"] else s["t_return"]
    return Answers({"t_LF": s["t_first_LF"], "t_RF": s["t_first_RF"], "t_end": end, "F": s["F_derailment"],
                    **{name: s[f"peak_{name}"] or np.nan for name in FORCES}},
                   "derails" if s["derailed"] else "returns",
                   s["drift"]/s["kinetic_energy"] if s["kinetic_energy"] else np.nan)


Study = dict[tuple[int, str], dict[str, Answers]]       # by exercise and pair, by variant


def run_variants(pair: str, found: list[Variant]) -> tuple[Study, dict[str, ContactTable]]:
    """All exercises with all variants; and the tables by variant."""
    study: Study = {(exercise, pair): {} for exercise in EXERCISES}
    tables: dict[str, ContactTable] = {}
    for variant in found:
        first = base_case(EXERCISES[0], pair).replace(**variant.table)
        table = tables[variant.name] = ContactTable(first) if variant.table or not tables else tables["base"]
        for exercise in EXERCISES:
            case = base_case(exercise, pair).replace(**variant.table)
            case = case.replace(**variant.rest(case, table))
            study[exercise, pair][variant.name] = answers(case, table)
    return study, tables


@dataclass
class Divergence:
    """Distances of twins from a motion."""

    name: str
    t: np.ndarray
    growth: np.ndarray      # (row, twin) over the distance at the start
    impacts: int            # flange contacts and landings of wheels
    compared: float         # time up to which twins on either side are compared [s]
    uneven: float           # sum of the differences of twins on either side, over the smaller one, at that time
    bar: float

    def row(self) -> list[str]:
        mean = np.exp(np.log(self.growth).mean(axis=1))
        G, rate = mean[-1], np.polyfit(self.t, np.log(mean), 1)[0]          # the exponential rate by least squares [1/s]
        return [self.name, f"{self.t[-1]:.3f}", str(self.impacts), f"{G:.3g}",
                f"{self.growth[-1].min():.3g} to {self.growth[-1].max():.3g}", f"{rate:.1f}",
                f"{G**(1/self.impacts):.2f}", f"{np.log(G)/self.t[-1]:.1f}"]


TWINS = ("Y", TWIN), ("Y", -TWIN), ("initial_roll", TWIN), ("initial_roll", -TWIN)
STATE = "Y", "Z", "roll", "vY", "vZ", "roll_rate"


def divergence(exercise: int, pair: str, table: ContactTable) -> Divergence:
    case = refined(Case.exercise(exercise, pair), TWIN_FACTORS[exercise == 5])
    if exercise == 5:
        case = case.replace(stop_at="t_end", t_end=TWIN_RAMP_END, interval=1e-3)
    starts = *TWINS, *((name, x/TWIN*PROBE) for name, x in TWINS)
    base, *others = (ldbench.run(case.replace(**{name: x}), table=table) for name, x in (("Y", 0.0), *starts))
    rows = min(len(run.data) for run in (base, *others))
    states = [run.data[list(STATE)].to_numpy()[:rows] for run in (base, *others)]
    gyration = np.sqrt(case.roll_inertia/case.mass)                     # [m]
    omega = 2*np.pi*table.frequencies[1]                                # vertical, at rest [1/s]
    scale = np.array([1, 1, gyration, 1/omega, 1/omega, gyration/omega])
    apart = np.array([(x - states[0])*scale for x in states[1:]])       # (start, row, coordinate)
    distance = np.linalg.norm(apart, axis=2).T
    twins, probes = distance[:, :len(TWINS)], distance[:, len(TWINS):]
    impacts = sum(base.results[f"n_{side}_{what}"] for side in ("left", "right")
                  for what in ("flange_contact", "wheel_landing"))
    approach = table.rigid_height - table.equilibrium                   # [m]
    row = int(np.searchsorted(np.maximum.accumulate(twins.max(axis=1)), LINEAR*approach)) - 1
    least = twins[row].reshape(2, 2).min(axis=1)
    sums = np.linalg.norm(apart[:len(TWINS), row].reshape(2, 2, -1).sum(axis=1), axis=1)
    t = base.data["time"].to_numpy()[:rows]
    second_order = (impacts + t[row]*table.frequencies[1])/4*twins[:row + 1].max()/approach
    bars = second_order + 4*probes[:row + 1].max()/least
    worst = int((sums/least/bars).argmax())
    return Divergence(case.case_name, t, twins/twins[0], impacts, t[row], sums[worst]/least[worst], bars[worst])


def change_cell(name: str, value: Answers, base: Answers) -> str:
    """Times in ms, forces in kN, and both in %."""
    if name == "t_end" and value.ending != base.ending:
        return value.ending or "neither"
    old = base.numbers[name]
    change = value.numbers[name] - old
    if np.isnan(change):
        return "" if np.isnan(old) and np.isnan(value.numbers[name]) else "only one"
    scale = 1e3 if name in TIMES else 1e-3
    return f"{scale*change:+.3f} ({100*change/old:+.2g} %)"


def change_table(exercise: int, pair: str, of: dict[str, Answers]) -> Table:
    base = of["base"]
    names = [n for n in (*TIMES, *FORCES) if any(np.isfinite(a.numbers[n]) for a in of.values())]
    head = ["variant", *(f"{LONG[n]} [{'ms' if n in TIMES else 'kN'}]" for n in names)]
    rows = [["base", *("" if np.isnan(x := base.numbers[n]) else f"{1e3*x:.3f}" if n in TIMES else f"{1e-3*x:.2f}"
                       for n in names)]]
    rows += [[name, *(change_cell(n, a, base) for n in names)] for name, a in of.items() if name != "base"]
    return Table(f"Exercise {exercise}, {pair}: change of the answers ({base.ending})", head, rows)


def profile_checks(pair: str, folder: Path) -> list[Check]:
    """The radii of this module, unchanged, give the shipped profiles."""
    files = write_profiles(folder, pair)
    checks = []
    for kind, shipped in (("wheel", f"{pair}prof"), ("rail", f"{pair[0]}rprof")):
        ours, theirs = (np.loadtxt(f, comments="#") for f in (files[f"{kind}_profile"],
                                                             data_folder()/"profiles"/f"{shipped}.yz"))
        miss = np.abs(ours - theirs).max() if ours.shape == theirs.shape else np.nan
        checks.append(limit(f"{pair} {kind} written with unchanged radii, largest difference [mm]", miss,
                            f"profiles/{shipped}.yz, bar its last digit", 1.1e-9))
    return checks


def clearance_bar(table: ContactTable) -> float:
    """By how much a clearance may differ from that of exact arcs [m].

    Where an arc of 10 mm ends, the spline through points h = 0.05 mm apart is beside it by h^2/(80 R) = 3 nm, on the wheel and on
    the rail; the throat is solved for to 0.5 nm. This is all where the contact jumps to the flange. Where the contact angle
    passes that of a flange smoothly, it counts how the spline is turned against the arc, by some h/(80 R) = 0.06 mrad at the ends
    of the arcs, over which the contact moves by 0.3 µm: the wheel's throat is 5 mm flatter than the gauge corner.
    """
    angle = float(table.geometry([table.clearance + 1e-7]).angle_L.iloc[0])
    return 7e-9 if angle > table.case.flange_angle + 0.01 else 3e-7


def energy_checks(study: Study, found: list[Variant]) -> list[Check]:
    """Largest drift of total energy over the kinetic energy at the start, exercises 1 to 4."""
    names = {MODELS[0]: "base"} | {m: f"model {m}" for m in MODELS[1:]}
    checks = []
    for pair in dict.fromkeys(p for _, p in study):
        for model, name in names.items():
            drifts = [of[name].drift for (e, p), of in study.items() if p == pair and e < 5 and name in of]
            if drifts:
                checks.append(limit(f"{pair} {model}, exercises 1 to 4: energy drift over kinetic energy [1]",
                                    max(drifts), "conservation of energy; the bar asked of a benchmark code", 1e-6))
    return checks


def first_contact_checks(study: Study) -> list[Check]:
    """The models differ in the tread's force by 0.1 % (design), so the way to the flange takes the same time."""
    return [relative(f"ex{exercise}_{pair} {name}: first left flange contact [s]", of[name].numbers["t_LF"],
                     of["base"].numbers["t_LF"], f"model {MODELS[0]}; bar: tread forces equal within 0.1 %", 1e-3)
            for (exercise, pair), of in study.items() if exercise < 3 for name in (f"model {m}" for m in MODELS[1:])
            if name in of]


def release_checks(pair: str, tables: dict[str, ContactTable]) -> list[Check]:
    """Let go where it just touches, a Hertz spring (force ~ depth^3/2) peaks at 5/2 times the weight."""
    checks = []
    for model, name in zip(MODELS, ("base", *(f"model {m}" for m in MODELS[1:])), strict=True):
        table = tables[name]
        case = table.case.replace(Z=table.rigid_height - table.equilibrium, vY=0, roll_rate=0, dt=1e-5, t_end=5e-3,
                                  stop_at="t_end")
        rest = np.linalg.norm(table.forces_by_contact(0.0, table.equilibrium, 0.0)[0, :2])
        peak = ldbench.run(case, table=table).results["peak_N_LT"]
        checks.append(relative(f"{pair} {model}: peak over static tread force, let go where it touches [1]", peak/rest,
                               2.5, "Hertz: 2/5 C δ^5/2 = W δ; bar: table and law on the tread 0.1 %", 1e-3))
    return checks


def section() -> Section:
    out = Section("What the call leaves open", __doc__)
    study: Study = {}
    parting: list[Divergence] = []
    tables: dict[str, dict[str, ContactTable]] = {}
    with tempfile.TemporaryDirectory() as scratch:
        for pair, clearance in PAIRS.items():
            found = variants(pair, Path(scratch))
            of_pair, tables[pair] = run_variants(pair, found)
            study |= of_pair
            parting += [divergence(exercise, pair, tables[pair]["base"]) for exercise in EXERCISES]
            out.checks += profile_checks(pair, Path(scratch)) + [
                absolute(f"{pair} clearance, {v.name} [m]", tables[pair][v.name].clearance, clearance,
                         "benchmark call; bar the spline through the points, and the throat's last digit",
                         clearance_bar(tables[pair][v.name])) for v in found if v.group in ("crown", "throat")]
            out.checks += release_checks(pair, tables[pair])
    study = dict(sorted(study.items()))
    parting.sort(key=lambda d: d.name)
    out.checks += energy_checks(study, found) + first_contact_checks(study) + [
        limit(f"{d.name} twins on either side, to {d.compared:.3f} s: sum of their differences, over the smaller [1]",
              d.uneven, "linear divergence; bar (impacts + periods)/4 largest distance/approach + 4 probes/distance", d.bar)
        for d in parting]
    out.tables = [Table("Divergence of motions that start 1 nm or 1 nrad apart", (
        "case", "to [s]", "impacts", "growth, mean of twins", "growth, range", "fitted rate [1/s]", "factor per impact",
        "ln growth / time [1/s]"), [d.row() for d in parting]),
        *(change_table(exercise, pair, of) for (exercise, pair), of in study.items())]
    return out
