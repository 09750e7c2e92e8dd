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
CASES = [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4) for pair in PAIRS]
LAWS = "strip", "hertz"
INFLUENCES = "local", "flat", "apart"
PLACES = "tread", "flange", "both", "going over"
SHAPES = {"aw": "actual", "sw": "simplified", "S1002 on 60E1": "S1002 on 60E1",
          "hollow wheel, actual rail": "actual, worn hollow by 1.5 mm",
          "thin flange, actual rail": "actual, worn to a thin flange",
          "conforming wheel, actual rail": "wheel of the shape of the actual rail"}
UNKNOWN = {"APTA 140M": "APTA 140M", "APTA 240": "APTA 240", "throat radii x 0.75 to 1.25": "throat radii × 0.75 to 1.25",
           "gauge corner 9.5 to 15.9 mm": "gauge corner 9.5 to 15.9 mm"}
# What may differ between two codes on the same profiles: words, and the variables that say it here.
CAUSES: dict[str, tuple[str, dict[str, str | float]]] = {
    "hertz": ("`model = 'hertz'`, no influence between tread and flange", {"model": "hertz"}),
    "strip": ("`model = 'strip'`, no influence between tread and flange", {"model": "strip"}),
    "flat": ("`influence = 'flat'`", {"influence": "flat"}),
    "apart": ("`influence = 'apart'`", {"influence": "apart"}),
    "E": ("Young's modulus 1 % smaller", {"youngs_modulus": 0.99*2.1e11}),
    "vY": ("lateral velocity 1 % smaller", {"vY": 0.99}),
    "mass": ("mass and roll inertia 1 % smaller", {"mass": 0.99*1568.0, "roll_inertia": 0.99*656.0}),
    "load": ("vertical load 1 % smaller", {"vertical_load": 0.99*164618.0}),
    "level": ("no roll rate at the start", {"roll_rate": 0.0}),
    "rows": ("the peak read from rows every 1 ms", {"interval": 1e-3, "rows": "interval"})}


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

def two(value: float) -> str:
    """Two significant digits."""
    return f"{value:#.2g}".rstrip(".")


def table(heading: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table in Markdown."""
    lines = [list(heading), *map(list, rows)]
    lines.insert(1, ["---"]*len(lines[0]))
    return "".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |\n" for line in lines)


def law_table() -> str:
    """Deviation of the two simpler laws from half-spaces."""
    v = measured()

    def percent(value: float) -> str:
        return f"{value:.0f} %" if value >= 10 else f"{value:.1f} %" if value >= 1 else f"{value:.2f} %"

    kinds = {"tread alone": "tread alone", "flange alone": "flange alone", "tread and flange": "tread and flange",
             "all": "all of these", "overturning": "going over the rail, exercise 5"}
    return table(("contact", *(f"`{law}`, {pair}" for law in LAWS for pair in PAIRS)), (
        (words, *(f"{percent(v[f'law.{pair}.{kind}.{law}.rms [%]'])} ({percent(v[f'law.{pair}.{kind}.{law}.largest [%]'])})"
                  for law in LAWS for pair in PAIRS)) for kind, words in kinds.items()))


def error_table() -> str:
    """Errors that contact tables of half-spaces state."""
    v = measured()
    return table(("profiles", "tread", "flange", "both at once", "going over the rail"), (
        (words, *(f"{two(v[f'table.halfspace.{name}.{place}.rms [%]'])} % "
                  f"({two(v[f'table.halfspace.{name}.{place}.largest [%]'])} %)" for place in PLACES))
        for name, words in SHAPES.items()))


def influence_table() -> str:
    """The first flange contact and the return of a run with the models of influence."""
    v = measured()
    results = {"first LF [kN]": "first peak", "return [ms]": "return"}
    return table(("case", *(f"{words}, `{influence}`" for words in results.values() for influence in INFLUENCES)), (
        (f"`{case}`", *(f"{v[f'influence.{case}.{influence}.{what}']:.1f}" for what in results for influence in INFLUENCES))
        for case in CASES))


def cause_table() -> str:
    """What changes the first contact of the left flange on the same profiles."""
    v = measured()
    columns = {**{f"peak, exercise {k}": f"peak.ex{k}" for k in (1, 2, 3, 4)}, "duration, exercise 2": "duration.ex2",
               "impulse, exercise 2": "impulse.ex2"}

    def change(x: float) -> str:
        return f"{x:+.1f} %".replace("-", "−") if abs(x) >= 0.05 else "0.0 %"

    shipped = (*(f"{v[f'first.ex{k}_aw.peak [kN]']:.1f} kN" for k in (1, 2, 3, 4)), f"{v['first.ex2_aw.duration [ms]']:.2f} ms",
               f"{v['first.ex2_aw.impulse [N s]']:.0f} N s")
    return table(("change", *columns), [("as shipped", *shipped)] + [
        (words, *(change(v[f"cause.{name}.{what} [%]"]) for what in columns.values())) for name, (words, _) in CAUSES.items()])


def unknown_table() -> str:
    """How far the answers move with wheels and arcs that the call allows."""
    v = measured()

    def change(x: float) -> str:
        return f"{x:+.1f}".replace("-", "−")

    rows = []
    for name, words, exercises in (("contact", "time of the first left flange contact, exercises 1 to 4", (1, 2, 3, 4)),
                                   *(("peak", f"peak of the left flange, exercise {k}", (k,)) for k in (1, 2, 3, 4)),
                                   ("force", "lateral force at derailment, exercise 5", (5,))):
        row = [words]
        for group in UNKNOWN:
            least, largest = (change(pick(v[f"unknown.ex{k}.{name}.{group}.{end} [%]"] for k in exercises))
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
            "$h_c$, vertical distance [mm]": ("h_c.{} [mm]", 1),
            "**sample**: event `derailment` of the shipped run [kN]": ("F_derailment.{} [kN]", 2)}
    return table(("quantity", *PAIRS), ((words, *(f"{v[name.format(pair)]:.{digits}f}" for pair in PAIRS))
                                        for words, (name, digits) in rows.items()))


def run_table() -> str:
    """The first contact of the left flange in the ten shipped runs, and how they end."""
    values = measured()
    starts = "0.1 m/s to the left", "0.5 m/s", "1 m/s", "2 m/s", "at rest; a lateral force grows by 5 kN/s"
    rows = []
    for k, start in enumerate(starts, 1):
        for pair in PAIRS:
            case = f"ex{k}_{pair}"
            first = [values[f"first.{case}.{name}"] for name in ("t [ms]", "peak [kN]", "duration [ms]", "impulse [N s]")]
            end = f"{values[f't_return.{case} [ms]']:.1f} ms" if k < 5 else f"{values[f'F_derailment.{pair} [kN]']:.1f} kN"
            rows.append((f"`{case}`", start, *(f"{x:.{digits}f}" for x, digits in zip(first, (2, 1, 2, 0), strict=True)), end))
    heads = "input", "start", "flange touches [ms]", "peak [kN]", "lasts [ms]", "impulse [N s]", "return, or derailment"
    return table(heads, rows)


TABLES = {
    "laws": law_table, "influence": influence_table, "causes": cause_table, "errors of half-space tables": error_table,
    "unknown profiles": unknown_table, "forces of exercise 5": force_table,
}
