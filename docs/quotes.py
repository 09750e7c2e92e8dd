"""Tables of measured results on the pages. No sentence has a result, so that none ages unseen.

docs/measured.json has the results of this program, which docs/measure.py measures. docs/stated.json has numbers that this
program cannot measure here, each group with its source.
"""
from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from ldbench.constants import CONTACT_NAMES
from ldbench.number_text import number_text, percent_text, scientific
from ldbench.results.quantities import Quantity
from ldbench.results.summary import ranged
from ldbench.results.twins import Spread

FILE = Path(__file__).resolve().parent/"measured.json"
STATED = FILE.with_name("stated.json")
PAIRS = "aw", "sw"
CASES = [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4) for pair in PAIRS]
LAWS = "strip", "hertz"
ENDS = "median", "least", "largest"       # of what the twins of a run do not share
INFLUENCES = "local", "flat", "apart"
PLACES = "tread", "flange", "both", "going over"
SHAPES = {"aw": "actual", "sw": "simplified", "S1002 on 60E1": "S1002 on 60E1",
          "hollow wheel, actual rail": "actual, worn hollow by 1.5 mm",
          "thin flange, actual rail": "actual, worn to a thin flange",
          "conforming wheel, actual rail": "wheel of the shape of the actual rail"}
UNKNOWN = {"APTA 140M": "APTA 140M", "APTA 240": "APTA 240", "throat radii x 0.75 to 1.25": "throat radii × 0.75 to 1.25",
           "gauge corner 9.5 to 15.9 mm": "gauge corner 9.5 to 15.9 mm"}
# The shipped bodies of a pair by what is behind their bases.
BODIES = {"infinite": "profiles/{}.bodies", "clamped": "profiles/{}_clamped.bodies"}
# What may differ between two codes on the same profiles: words, and the variables that say it here.
CAUSES: dict[str, tuple[str, dict[str, str | float]]] = {
    "hertz": ("`model = 'hertz'`, tread and flange apart", {"model": "hertz"}),
    "strip": ("`model = 'strip'`, tread and flange apart", {"model": "strip"}),
    "flat": ("`influence = 'flat'`", {"influence": "flat"}),
    "apart": ("`influence = 'apart'`", {"influence": "apart"}),
    "E": ("Young's modulus 1 % smaller", {"youngs_modulus": 0.99*2.1e11}),
    "vY": ("lateral velocity 1 % smaller", {"vY": 0.99}),
    "mass": ("mass and roll inertia 1 % smaller", {"mass": 0.99*1568.0, "roll_inertia": 0.99*656.0}),
    "load": ("vertical load 1 % smaller", {"vertical_load": 0.99*164618.0}),
    "level": ("no roll rate at the start", {"roll_rate": 0.0}),
    "rows": ("the peak read from rows every 1 ms", {"interval": 1e-3, "rows": "interval"})}


#: Other programs on our force: how they call it, their integrator, and its tolerance or step.
CLIENTS = {"ctypes, SciPy": ("ctypes", "DOP853", "tolerance 1e-11, steps to 1e-4 s"),
           "FMU, FMPy": ("FMU, FMPy", "CVODE, model exchange", "tolerance 1e-11"),
           "FMU, FMPy, co-simulation": ("", "ours", "rows at 1e-5 s"),
           "C": ("", "ours", "rows at 1e-5 s"),
           "ctypes, Exudyn": ("ctypes", "Runge-Kutta of order 4", "steps of 1e-5 s")}


def measured() -> dict[str, float]:
    """Every measured result by its name."""
    return {name: value for group in json.loads(FILE.read_text()).values() for name, value in group["values"].items()}


def stated(group: str) -> dict[str, Any]:
    """A group of numbers from elsewhere: its source and its values by name."""
    return json.loads(STATED.read_text())[group]


# Tables -----------------------------------------------------------------------------------

def table(heading: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(heading), *map(list, rows)]
    lines.insert(1, ["---"]*len(lines[0]))
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def told(name: str, unit: str, digits: int = 1) -> str:
    """A result with its unit; of a chaotic one the median and, in brackets, the range."""
    v = measured()
    if f"{name} [{unit}]" in v:
        return f"{v[f'{name} [{unit}]']:.{digits}f} {unit}"
    spread = Spread(*(v[f"{name}.{end} [{unit}]"] for end in ENDS), int(v[f"{name}.having"]), int(v["twins"]) + 1)
    return f"{ranged(Quantity('', unit, 1.0), spread, digits).line} {unit}"


def law_table() -> str:
    """Deviation of the two simpler laws from half-spaces."""
    v = measured()

    kinds = {"tread alone": "tread alone", "flange alone": "flange alone", "tread and flange": "tread and flange",
             "all": "all of these", "overturning": "rolling over the rail, exercise 5"}
    return table(("contact", *(f"`{law}`, {pair}" for law in LAWS for pair in PAIRS)), (
        (words, *(f"{percent_text(v[f'law.{pair}.{kind}.{law}.rms [%]']/100)} "
                  f"({percent_text(v[f'law.{pair}.{kind}.{law}.largest [%]']/100)})"
                  for law in LAWS for pair in PAIRS)) for kind, words in kinds.items()))


def error_table() -> str:
    """Errors that runs with half-spaces state."""
    v = measured()

    def cell(name: str, place: str) -> str:
        rms, largest = (v.get(f"table.halfspace.{name}.{place}.{kind} [%]") for kind in ("rms", "largest"))
        return "" if rms is None or largest is None else f"{percent_text(rms/100, 3)} ({percent_text(largest/100, 3)})"

    return table(("profiles", "tread", "flange", "both at once", "rolling over the rail"), (
        (words, *(cell(name, place) for place in PLACES)) for name, words in SHAPES.items()))


def cause_table() -> str:
    """What changes the first contact of the left flange on the same profiles."""
    v = measured()
    columns = {**{f"peak, exercise {k}": f"peak.ex{k}" for k in (1, 2, 3, 4)}, "duration, exercise 2": "duration.ex2",
               "impulse, exercise 2": "impulse.ex2"}

    def change(x: float) -> str:
        return f"{number_text(x, 1, sign=True)} %"

    shipped = (*(f"{v[f'first.ex{k}_aw.peak [kN]']:.1f} kN" for k in (1, 2, 3, 4)), f"{v['first.ex2_aw.duration [ms]']:.2f} ms",
               f"{v['first.ex2_aw.impulse [N s]']:.0f} N s")
    return table(("change", *columns), [("as shipped", *shipped)] + [
        (words, *(change(v[f"cause.{name}.{what} [%]"]) for what in columns.values())) for name, (words, _) in CAUSES.items()] + [
        ("`accuracy` of the table, finer and coarser: range", *(f"{v[f'accuracies.ex{k}.spread [%]']:.2f} %" for k in (1, 2, 3, 4)),
         "", "")])


def unknown_table() -> str:
    """How far the answers move with wheels and arcs that the call allows."""
    v = measured()
    rows = []
    for name, words, exercises in (("contact", "time of the first left flange contact, exercises 1 to 4", (1, 2, 3, 4)),
                                   *(("peak", f"peak of the left flange, exercise {k}", (k,)) for k in (1, 2, 3, 4)),
                                   ("force", "lateral force at derailment, exercise 5", (5,))):
        row = [words]
        for group in UNKNOWN:
            least, largest = (number_text(pick(v[f"unknown.ex{k}.{name}.{group}.{end} [%]"] for k in exercises), 1, sign=True)
                              for pick, end in ((min, "least"), (max, "largest")))
            row.append(least if least == largest else f"{least} to {largest}")
        rows.append(row)
    return table(("answer", *UNKNOWN.values()), rows)


def force_table() -> str:
    """The limit of equilibrium in exercise 5, and the derailment of a run."""
    v = measured()
    rows = {"**limit**: largest force with an equilibrium, elastic contact [kN]": ("F_limit.{}.elastic [kN]", 2),
            "the same with rigid contact, $W b_c/h_c$ [kN]": ("F_limit.{}.rigid [kN]", 2),
            "contact angle there [°]": ("angle_limit.{}.elastic [deg]", 1),
            "$b_c$, lateral distance from the centre of gravity [mm]": ("b_c.{} [mm]", 1),
            "$h_c$, vertical distance [mm]": ("h_c.{} [mm]", 1)}
    twins = f"event `derailment`: median and range of the shipped run and its {v['twins']:.0f} twins"
    return table(("quantity", *PAIRS), [
        *((words, *(f"{v[name.format(pair)]:.{digits}f}" for pair in PAIRS)) for words, (name, digits) in rows.items()),
        (twins, *(told(f"F_derailment.{pair}", "kN") for pair in PAIRS))])


def run_table() -> str:
    """The first contact of the left flange in the ten shipped runs, and how they end."""
    values = measured()
    starts = "0.1 m/s to the left", "0.5 m/s", "1 m/s", "2 m/s", "at rest; a lateral force grows by 5 kN/s"
    rows = []
    for k, start in enumerate(starts, 1):
        for pair in PAIRS:
            case = f"ex{k}_{pair}"
            first = [values[f"first.{case}.{name}"] for name in ("t [ms]", "peak [kN]", "duration [ms]", "impulse [N s]")]
            end = told(f"t_return.{case}", "ms") if k < 5 else told(f"F_derailment.{pair}", "kN")
            rows.append((f"`{case}`", start, *(f"{x:.{digits}f}" for x, digits in zip(first, (2, 1, 2, 0), strict=True)), end))
    heads = "input", "start", "flange touches [ms]", "peak [kN]", "lasts [ms]", "impulse [N s]", "return, or derailment"
    return table(heads, rows)


def short_table() -> str:
    """The results in short, with the section of docs/accuracy.md that has more of each."""
    v = measured()
    peaks = {influence: [v[f"influence.{case}.{influence}.first LF [kN]"] for case in CASES] for influence in INFLUENCES}
    moved = [100*(x/own - 1) for influence in INFLUENCES for x, own in zip(peaks[influence], peaks["local"], strict=True)]
    laws = [v[f"law.{pair}.all.halfspace.rms [%]"] for pair in PAIRS]
    returns = ", ".join(f"{v[f't_return.ex2_aw.{law} [ms]']:.0f} ms" for law in ("halfspace", *LAWS))
    spread = max(v[f"accuracies.ex{k}.spread [%]"] for k in (1, 2, 3, 4))
    limits = ", ".join(f"{v[f'F_limit.{pair}.elastic [kN]']:.1f} kN ({pair})" for pair in PAIRS)
    derailed = ", ".join(f"{told(f'F_derailment.{pair}', 'kN')} for {pair}" for pair in PAIRS)
    _, contact, pressure = max(pressures(), key=lambda one: one[2])
    return table(("answer", "value", "section"), (
        ("energy drift, exercises 1 to 4, at most",
         f"{scientific(v['drift.free [J]'])} J, or {scientific(v['drift_relative.free'])} of the initial kinetic energy", "2"),
        ("energy drift, exercise 5", f"{scientific(v['drift_relative.ramp'])} of the work of the lateral force", "2"),
        ("Y for the given forces, against another integrator", f"within {scientific(v['integration.free.largest [m]'])} m; within "
         f"{scientific(v['integration.ex3_sw.largest [m]'])} m in the chaotic `ex3_sw`", "3"),
        ("force of the default table against half-spaces, rms", ", ".join(
            f"{x:.2f} % ({pair})" for x, pair in zip(laws, PAIRS, strict=True)), "4"),
        ("first peak of the left flange, `ex2_aw`", f"{v['first.ex2_aw.peak [kN]']:.1f} kN", "6"),
        ("other accuracies of the table move first peaks (aw) by", f"at most {spread:.1f} %", "6"),
        ("`influence` moves first peaks (aw, sw) by",
         f"{number_text(min(moved), 1, sign=True)} to {number_text(max(moved), 1, sign=True)} %", "6"),
        ("other profiles that fit the call move first peaks (aw) by",
         f"{number_text(-v['unknown.peak.fall [%]'], 0, sign=True)} to {number_text(v['unknown.peak.rise [%]'], 0, sign=True)} %",
         "6"),
        ("the bodies' own elasticity moves first peaks (aw, sw) by", f"{number_text(v['bodies.peak.least [%]'], 0, sign=True)} to "
         f"{number_text(v['bodies.peak.largest [%]'], 0, sign=True)} %", "8"),
        ("largest pressure of exercises 1 to 4", f"{pressure:.1f} GPa, {CONTACT_NAMES[contact]}", "8"),
        ("return of `ex2_aw` with `halfspace`, `strip`, `hertz`", returns, "6"),
        ("static limit of exercise 5", f"{limits}; rigid contact agrees within {v['F_limit.difference [%]']:.3f} %", "7"),
        ("derailment of the shipped run, chaotic: median and range of the run and its twins", derailed, "7"),
        ("checks of `make validate`, all passed", f"{v['checks.all']:.0f}", "10")))


def drift_table() -> str:
    """The energy drift of exercise 2 by law."""
    v = measured()
    rows = {"`halfspace`": "halfspace", "`strip`": "strip", "`hertz`": "hertz",
            "`strip`, a coarse table (`accuracy = 0.06`)": "coarse strip"}
    return table(("exercise 2, actual profiles", "largest drift [J]"),
                 ((words, scientific(v[f"drift.ex2_aw.{name} [J]"])) for words, name in rows.items()))


def closed_form_table() -> str:
    """What the program gives where a closed form is known."""
    v = measured()
    frequency = "frequency.{}.lateral.{} [Hz]"
    rows = [(f"lateral frequency at rest, {pair}: Hertz's law on cones",
             *(f"{v[frequency.format(pair, kind)]:.5f} Hz" for kind in ("halfspace", "closed form"))) for pair in PAIRS]
    return table(("answer", "ldbench", "closed form"), [
        *rows, ("Hertzian ellipses of axis ratios 1:20 to 20:1", f"within {v['halfspace.ellipses [%]']:.2f} %", ""),
        ("cone on a plane", f"within {v['halfspace.cone [%]']:.2f} %", "")])


def pressures() -> list[tuple[str, str, float]]:
    """Case, contact and largest pressure [GPa] of the runs of exercises 1 to 4."""
    found = [(name.removesuffix(" [GPa]").split(".")[1:], value) for name, value in measured().items() if name.startswith("pmax.")]
    return [(case, contact, value) for (case, contact), value in found if case in CASES]


def pressure_table() -> str:
    """The largest pressure of every run, with contact and time."""
    v = measured()
    return table(("case", "largest pressure [GPa]", "contact", "time [ms]"), (
        (f"`{case}`", f"{value:.1f}", CONTACT_NAMES[contact], f"{v[f't_pmax.{case} [ms]']:.1f}")
        for case, contact, value in pressures()))


def body_table() -> str:
    """How the bodies' own elasticity changes the first contact of the left flange."""
    v = measured()

    def row(case: str, words: str, peak: str, supports: Iterable[str]) -> list[str]:
        return [words, peak, *(" to ".join(dict.fromkeys(
            f"{number_text(v[f'bodies.{case}.{support}.{what} [%]'], 1, sign=True)} %" for support in supports))
            for what in ("peak", "duration", "impulse"))]

    return table(("case", "peak with half-spaces", "peak", "duration", "impulse"), [
        *(row(case, f"`{case}`", f"{v[f'first.{case}.peak [kN]']:.1f} kN", BODIES) for case in CASES),
        *(row("ex2_aw", f"`ex2_aw`, {only} alone", "", [f"{only} alone"]) for only in ("wheel", "rail"))])


def formulation_table() -> str:
    """How results depend on the formulation."""
    v = measured()
    impulse = [v[f"formulation.first_impulse.{end} [%]"] for end in ("least", "largest")]
    force = [v[f"formulation.F_derailment.{end} [kN]"] for end in ("least", "largest")]
    pulls = " and ".join(f"{v[f'F_pulls.{pair} [kN]']:.0f} kN ({pair})" for pair in PAIRS)
    return table(("result", "depends on the formulation?"), (
        ("time of the first flange contact", f"no, within {v['formulation.t_first_LF.largest [%]']:.1f} %"),
        ("impulse of that contact", f"by {impulse[0]:.1f} to {impulse[1]:.1f} %"),
        ("all later motion in exercises 1 to 3", "yes"),
        ("exercise 4, actual profiles", "yes: it derails in `bilateral` alone, where rolling over the left flange takes "
         f"{v['climb.aw [J]']:.0f} J of {v['drift_reference.ex4_aw [J]']:.0f} J"),
        ("force at which exercise 5 overturns", f"{force[0]:.0f} to {force[1]:.0f} kN in `elastic` and `unilateral`; `bilateral` "
         f"cannot overturn: from {pulls} on its right rail pulls the wheel down")))


COSTS = {"./bootstrap": ", with all that reports, tests and documents import", "make": "", "make test": "", "make report": ""}


def need_table() -> str:
    """Time and disk space."""
    v = measured()
    return table(("what", "needs"), (
        ("system", "Linux; the executable alone on Windows. Otherwise a container or WSL"),
        ("what exercise 5 solves for its contact table, which is kept", f"{v['time.table [s]']:.1f} s of processor time"),
        ("the ten runs besides", f"{v['time.runs [s]']:.0f} s of processor time"),
        *((f"`{command}`{words}", f"{v[f'setup.{command}.time [min]']:.0f} min of processor time, "
           f"{v[f'setup.{command}.left [MB]']:.0f} MB; {v[f'setup.{command}.largest [MB]']:.0f} MB while it runs")
          for command, words in COSTS.items()),
        ("column files of exercise 5, of a report", f"{v['size.ex5 [MB]']:.0f} MB"),
        ("a page of `ex5_aw`", f"{v['page.ex5_aw [MB]']:.1f} MB; its column file has {v['size.ex5_aw [MB]']:.0f} MB")))


def build_table() -> str:
    """What was built and run where, and how far its results lie from those of the first build."""
    rows = []
    for words, (made, run, found) in stated("builds")["values"].items():
        deviations = [f"{y:g}, {force:g}" for y, force in zip(found[::2], found[1::2], strict=True)]
        rows.append((words, made, run, *(deviations or ("", ""))))
    return table(("system, compiler", "made by", "run", "exercises 1 to 4: Y [m], N [N]", "exercise 5"), rows)


def client_table() -> str:
    """The clients, and the processor time of one force."""
    v = measured()
    rows = [(client, *words, f"{v[f'plug.per force.{way} [us]']:.1f}" if way else "") for client, (way, *words) in CLIENTS.items()]
    return table(("client", "integrator", "tolerance or step", "one force takes [us]"), [
        ("this program", "ours", "as shipped", f"{v['plug.per force.our program [us]']:.1f}"), *rows])


def answer_table(answer: str, unit: str, form: Callable[[float], str]) -> Callable[[], str]:
    """What makes a table of an answer: ours in every case, and how far each client's is from it."""
    def make() -> str:
        v = measured()
        free = CASES[:8]
        own = ("this program", *(form(v[f"plug.{case}.{answer}{unit}"]) for case in free))
        others = ((client, *(f"{v[f'plug.{case}.{client}.{answer}{unit}']:.0e}" for case in free)) for client in CLIENTS)
        return table(("client", *(f"`{case}`" for case in free)), [own, *others])
    return make


def mistake_table() -> str:
    """What the check finds in files of a stranger to it."""
    v = stated("check")["values"]
    return table(("files", "how many", "outcome"), ((words, str(n), outcome) for words, (n, outcome) in v.items()))


def unit_table() -> str:
    """How large an FMU is."""
    return table(("unit", "size [MB]"), [("`wheelset.fmu` of `ex2_aw`, for Linux alone", f"{measured()['plug.size [MB]']:.1f}")])


PLUG_TABLES = {
    "units": unit_table,
    "clients": client_table, "passages": answer_table("passage", " [s]", "{:.6f}".format),
    "first peaks": answer_table("peak", " [kN]", "{:.3f}".format), "drifts of clients": answer_table("drift", "", "{:.0e}".format)}
TABLES = {
    "results in short": short_table, "drifts": drift_table, "closed forms": closed_form_table, "largest pressures": pressure_table,
    "bodies": body_table, "laws": law_table, "causes": cause_table,
    "errors of half-space tables": error_table, "unknown profiles": unknown_table, "forces of exercise 5": force_table,
}
