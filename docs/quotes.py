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
          "conforming wheel, actual rail": "wheel of the shape of the actual rail"}
UNKNOWN = {"APTA 140M": "APTA 140M", "APTA 240": "APTA 240", "throat radii x 0.75 to 1.25": "throat radii × 0.75 to 1.25",
           "gauge corner 9.5 to 15.9 mm": "gauge corner 9.5 to 15.9 mm"}


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
             "all": "all of these", "overturning": "overturning in exercise 5"}
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
    """The spread of the first flange contact and of the return of a run over the models of influence."""
    v = measured()

    def spread(case: str, what: str) -> str:
        values = [v[f"influence.{case}.{influence}.{what}"] for influence in INFLUENCES]
        return f"{min(values):.1f} to {max(values):.1f}"

    return table(("case", "first peak of the left flange [kN]", "return to the centre [ms]"), (
        (f"`{case}`", spread(case, "first LF [kN]"), spread(case, "return [ms]")) for case in CASES))


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


TABLES = {
    "laws": law_table, "influence": influence_table, "errors of half-space tables": error_table,
    "unknown profiles": unknown_table, "forces of exercise 5": force_table,
}
