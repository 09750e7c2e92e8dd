"""Measured results on the pages: tables of docs/accuracy.md, and single numbers anywhere.

A number on a page is followed by a comment with the name of the result in docs/measured.json:

    The largest energy error is 2.4e-8<!-- drift.free [J] --> J.

`quoted` rewrites such numbers with as many digits as the page shows. docs/measure.py writes the file.
"""
from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path

FILE = Path(__file__).resolve().parent/"measured.json"
QUOTE = re.compile(r"(?P<number>\d+(?:\.\d+)?(?:e-?\d+)?)<!-- (?P<name>[^<>]+?) -->")
PAIRS = "aw", "sw"
CASES = [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4, 5) for pair in PAIRS]
LAWS = "halfspace", "strip", "hertz"
INFLUENCES = "local, no table", "local", "flat", "apart"
PLACES = "tread", "flange", "both", "going over"
SHAPES = {"aw": "actual", "sw": "simplified", "S1002 on 60E1": "S1002 on 60E1",
          "hollow wheel, actual rail": "actual, worn hollow by 1.5 mm",
          "conforming wheel, actual rail": "wheel of the shape of the actual rail"}
UNKNOWN = {"APTA 140M": "APTA 140M", "APTA 240": "APTA 240", "throat radii x 0.75 to 1.25": "throat radii × 0.75 to 1.25",
           "gauge corner 9.5 to 15.9 mm": "gauge corner 9.5 to 15.9 mm"}
FORMULATIONS = {"unilateral, e = 1": "`unilateral`, $e = 1$", "unilateral, e = 0.5": "`unilateral`, $e = 0.5$",
                "unilateral, e = 0": "`unilateral`, $e = 0$"}


def measured() -> dict[str, float]:
    """Every measured result by its name."""
    return {name: value for group in json.loads(FILE.read_text()).values() for name, value in group["values"].items()}


# Single numbers ---------------------------------------------------------------------------

def quoted(text: str, values: dict[str, float]) -> str:
    """A page with the measured values in place of the numbers that quote them."""
    def fresh(found: re.Match[str]) -> str:
        if found["name"] not in values:
            raise SystemExit(f"docs: expected a name of a result in docs/measured.json, found '{found['name']}' on a page")
        return f"{like(found['number'], values[found['name']])}<!-- {found['name']} -->"

    return QUOTE.sub(fresh, text)


def like(shown: str, value: float) -> str:
    """A value with the digits that a page shows: as many decimals; zeros at the end of a whole number are rounded digits."""
    mantissa, _, exponent = shown.partition("e")
    decimals = len(mantissa.partition(".")[2])
    if exponent:
        return short(f"{value:.{decimals}e}")
    if decimals:
        return f"{value:.{decimals}f}"
    return f"{round(value, len(shown.rstrip('0')) - len(shown)):.0f}"


def short(number: str) -> str:
    """Leave out the zero of an exponent: 1.2e-08 becomes 1.2e-8."""
    return re.sub(r"e([-+])0(\d)", lambda found: f"e{found[1].strip('+')}{found[2]}", number)


# Tables -----------------------------------------------------------------------------------

def exponent(value: float, digits: int = 1) -> str:
    return short(f"{value:.{digits}e}")


def two(value: float) -> str:
    """Two significant digits."""
    return f"{value:#.2g}".rstrip(".")


def table(heading: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(heading), *map(list, rows)]
    lines.insert(1, ["---"]*len(lines[0]))
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def drift_table() -> str:
    """Energy drift of the ten runs."""
    v = measured()
    rows = []
    for case in CASES:
        reference = v[f"drift_reference.{case} [J]"]
        shown = f"{reference:.3g}" if reference < 1e3 else f"{reference:.0f}" if reference < 1e4 else exponent(reference, 2)
        rows.append([f"`{case}`", exponent(v[f"drift.{case} [J]"]), shown, exponent(v[f"drift_relative.{case}"])])
    return table(("case", "drift [J]", "reference [J]", "relative"), rows)


def integration_table() -> str:
    """Deviation of the motion from that of another integrator."""
    v = measured()
    rows = []
    for case in CASES:
        ramp = case.startswith("ex5")
        rows.append([f"`{case}`" + (f", up to {v[f'integration.{case}.end [s]']:.2f} s" if ramp else ""),
                     *(exponent(v[f"integration.{case}.{name}"]) for name in ("Y [m]", "Z [m]", "roll [rad]")),
                     "not compared" if ramp else exponent(v[f"integration.{case}.peak"])])
    return table(("case", "Y [m]", "Z [m]", "roll [rad]", "peak of the left flange, relative"), rows)


def law_table() -> str:
    """Deviation of the three laws from half-spaces."""
    v = measured()

    def percent(value: float) -> str:
        return f"{value:.0f} %" if value >= 10 else f"{value:.1f} %" if value >= 1 else f"{value:.2f} %"

    rows = []
    for kinds in ("tread alone", "flange alone", "tread and flange", "all"), ("overturning",):
        for pair in PAIRS:
            for kind in kinds:
                bold = "**" if kind == "all" else ""
                name = "overturning in exercise 5" if kind == "overturning" else kind
                rows.append([f"{bold}{name}, {pair}{bold}", f"{v[f'law.{pair}.{kind}.halfspace.poses']:.0f}", *(
                    f"{bold}{percent(v[f'law.{pair}.{kind}.{law}.rms [%]'])} "
                    f"({percent(v[f'law.{pair}.{kind}.{law}.largest [%]'])}){bold}" for law in LAWS)])
    return table(("contact, pair", "poses", *(f"`{law}`" for law in LAWS)), rows)


def error_table(law: str) -> str:
    """Errors that contact tables state."""
    v = measured()
    return table(("profiles", "tread", "flange", "both at once", "going over the rail"), (
        (words, *(f"{two(v[f'table.{law}.{name}.{place}.rms [%]'])} % ({two(v[f'table.{law}.{name}.{place}.largest [%]'])} %)"
                  for place in PLACES)) for name, words in SHAPES.items() if law == "halfspace" or name in PAIRS))


def influence_table() -> str:
    """The first flange contact and the rest of a run by the model of influence."""
    v = measured()
    rows = []
    for case in CASES[:8]:
        for influence in INFLUENCES:
            found = [v.get(f"influence.{case}.{influence}.{what}") for what in
                     ("first LF [kN]", "impulse [N s]", "RF [kN]", "return [ms]")]
            rows.append([f"`{case}`", influence, *("" if x is None else f"{x:.1f}" for x in found)])
    return table(("case", "influence", "first peak LF [kN]", "its impulse [N s]", "largest RF [kN]", "return [ms]"), rows)


def frequency_table() -> str:
    """Eigenfrequencies at rest."""
    v = measured()
    rows = []
    for pair in PAIRS:
        found, closed = (v[f"frequency.{pair}.lateral.{kind} [Hz]"] for kind in ("halfspace", "closed form"))
        rows.append([pair, f"{found:.5f}", f"{closed:.5f}", f"{100*abs(found/closed - 1):.2g} %", *(
            f"{v[f'frequency.{pair}.{mode}.halfspace [Hz]']:.2f}" for mode in ("bounce", "roll"))])
    return table(("pair", "lateral, half-space table [Hz]", "lateral, closed form [Hz]", "deviation", "bounce [Hz]",
                  "roll [Hz]"), rows)


def accuracy_table() -> str:
    """Results with contact tables of several accuracies."""
    v = measured()
    rows = []
    for exercise, digits in (1, 2), (2, 1), (4, 0):
        least, largest = (v[f"accuracies.ex{exercise}.peak.{end} [kN]"] for end in ("least", "largest"))
        begin, end = (v[f"accuracies.ex{exercise}.t_return.{end} [ms]"] for end in ("least", "largest"))
        rows.append([str(exercise), f"{least:.{digits}f} to {largest:.{digits}f}",
                     f"{v[f'accuracies.ex{exercise}.spread [%]']:.2f} %", f"{begin:.1f} to {end:.1f}"])
    return table(("exercise (aw)", "first peak of the left flange [kN]", "spread of the peak", "return to the centre [ms]"),
                 rows)


def unknown_table() -> str:
    """How far the answers move with wheels and arcs that the call allows."""
    v = measured()

    def change(x: float) -> str:
        return f"{x:+.1f}".replace("-", "−")

    words = {"contact": "first left flange contact", "peak": "peak of the left flange", "force": "lateral force at derailment"}
    rows = []
    for name, exercises in ("contact", (1, 2, 3, 4)), ("peak", (1, 2, 3, 4)), ("force", (5,)):
        for exercise in exercises:
            row = [f"{words[name]}, exercise {exercise}"]
            for group in UNKNOWN:
                least, largest = (change(v[f"unknown.ex{exercise}.{name}.{group}.{end} [%]"]) for end in ("least", "largest"))
                without = v.get(f"unknown.ex{exercise}.{name}.{group}.without contact")
                row.append((least if least == largest else f"{least} to {largest}")
                           + (f", {without:.0f} without contact" if without else ""))
            rows.append(row)
    return table(("number", *UNKNOWN.values()), rows)


def force_table() -> str:
    """The forces of exercise 5 at which something ends."""
    v = measured()

    def both(name: str, digits: int = 2) -> tuple[str, ...]:
        return tuple(f"{v[name.format(pair=pair)]:.{digits}f}" for pair in PAIRS)

    same = "the same"
    pulls = " and ".join(f"{force} kN ({pair})" for force, pair in zip(both("F_pulls.{pair} [kN]", 0), PAIRS, strict=True))
    rows = [
        ("static limit, elastic", *both("F_limit.{pair}.elastic [kN]"), "largest force with an equilibrium on the contact table",
         "`make validate`, section `quasistatic`"),
        ("static limit, rigid, $W b_c/h_c$", *both("F_limit.{pair}.rigid [kN]"),
         "the flange normal passes through the centre of gravity, exact arcs", same),
        ("statics of the mean pose, $W b_c/h_c$", *both("F_mean_pose.{pair} [kN]", 1),
         "lever arms of the mean pose of a run, between 2 s and 1 s before its end", "abstract, text on exercise 5"),
        ("right wheel carries for the last time", *both("F_last_load.{pair} [kN]"), "one sample of a chaotic run",
         "columns `N_RT`, `F_ext`"),
        ("event `left flange over rail`", *both("F_over_rail.{pair} [kN]"), "one sample", "`&results` of the column file"),
        ("event `derailment`", *both("F_derailment.{pair} [kN]"), "one sample",
         "`summary.csv` (`F_derailment`), table of results in the abstract"),
        ("last row of the run", *both("F_last_row.{pair} [kN]"),
         "one sample: force when the run stops, up to one row interval later", "column `F_ext`"),
        *((words, *both(f"F_derailment.{{pair}}.{name} [kN]"),
           "one sample of a chaotic run" if name.endswith("= 1") else "regular: the wheelset comes to rest on the flange",
           "`python -m ldbench formulations`") for name, words in FORMULATIONS.items()),
        ("`bilateral`", "none", "none", f"cannot overturn; the right rail pulls its wheel down from {pulls} on", same)]
    return table(("quantity", "aw [kN]", "sw [kN]", "kind", "where"), rows)


TABLES = {
    "drift": drift_table, "integration": integration_table, "laws": law_table, "influence": influence_table,
    "errors of half-space tables": lambda: error_table("halfspace"), "errors of strip tables": lambda: error_table("strip"),
    "frequencies": frequency_table, "accuracies": accuracy_table, "unknown profiles": unknown_table,
    "forces of exercise 5": force_table,
}
