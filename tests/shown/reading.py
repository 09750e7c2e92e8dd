"""Numbers in texts that a user reads: each is accounted for by a line of the table, or is one of the labels that are declared."""
from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Text

NUMBER = re.compile(r"(?<![\w.\-/])[-−]?\d[\d\u2009]*(?:\.\d+)?(?:[eE][-+]?\d+)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?(?![\w/])")
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
Truth = Callable[[Any], object]


class Line(NamedTuple):
    """A shown number or some in a row, and what they must be."""

    pattern: str            # a group for each number
    what: str               # the numbers in words, with unit, side and moment
    truth: Truth            # what they are in that unit, from the specimen's raw rows; None for a dash
    slack: float = 0.0      # how far they may be off beside their rounding, as a share
    often: bool = False     # whether the pattern may match many times, with the match for a second argument of `truth`


def value(text: str) -> tuple[float, float]:
    """A number as it is written, and half a unit of its last digit."""
    plain = text.replace("\u2009", "").replace(" ", "").replace("·10", "e").translate(RAISED)
    if "e" not in plain and "·" not in text and plain.startswith("10") and len(text) > 2 and text[2] in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹":
        plain = f"1e{plain[2:]}"
    mantissa, _, power = plain.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(plain), 0.5*10.0**(int(power or 0) - decimals)


def agree(text: str, truth: float | None, slack: float = 0.0, chaotic: bool = False) -> bool:
    """Whether a text is that number. Chaotic results have zeros for the digits that do not hold."""
    if truth is None or np.isnan(truth):
        return text == "–"
    if text == "–":
        return False
    number, half = value(text)
    if chaotic:
        digits = text.rstrip("0") if "." not in text else text
        half = max(half, 0.5*10.0**(len(text) - len(digits)))
    return abs(number - truth) <= 1.001*half + slack*abs(truth)


def differing(text: str, lines: Iterable[Line], world: Any, labels: Iterable[str]) -> list[str]:
    """What is wrong in a text: numbers that differ from what they must be, lines of the table that the text lacks, numbers
    that no line and no label accounts for."""
    wrong, known = [], np.zeros(len(text), bool)
    for line in lines:
        found = list(re.finditer(line.pattern, text, re.MULTILINE))
        if not found or (len(found) > 1 and not line.often):
            wrong.append(f"{line.what}: {len(found)} times {line.pattern}")
        for match in found:
            truth = line.truth(world, match) if line.often else line.truth(world)
            for group, one in enumerate(np.atleast_1d(np.array(truth, object)), 1):
                if not agree(match[group], one, line.slack):
                    wrong.append(f"{line.what}: {match[group]}, expected {one}")
            known[match.start():match.end()] = True
    for label in labels:
        for match in re.finditer(label, text, re.MULTILINE):
            known[match.start():match.end()] = True
    return wrong + [f"nobody accounts for {match[0]} in {text[max(match.start() - 40, 0):match.end() + 20]!r}"
                    for match in NUMBER.finditer(text) if not known[match.start():match.end()].all()]


def words_of(figure: Figure) -> str:
    """The words of a figure: a line for each text and for each row of a table, but not the numbers at ticks."""
    axes = [axis for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]
    ticks = {axis.offsetText for axis in axes}
    ticks |= {label for axis in axes for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
              for label in (tick.label1, tick.label2)}
    rows: dict[tuple[object, ...], list[Text]] = {}
    for text in figure.findobj(Text):
        if text.get_text() and text.get_visible() and text not in ticks:
            rows.setdefault((text.axes, round(text.get_position()[1], 6)) if text.axes else (text,), []).append(text)
    return "\n".join(" ".join(text.get_text() for text in sorted(row, key=lambda text: text.get_position()[0]))
                     for row in rows.values())


def numbers_in(told: Any, path: str = "") -> dict[str, float | None]:
    """Numbers and nulls of JSON by their places, as `events.0.t`; words and truth values have none."""
    if isinstance(told, dict | list):
        parts = told.items() if isinstance(told, dict) else enumerate(told)
        return {place: x for name, part in parts for place, x in numbers_in(part, f"{path}.{name}" if path else str(name)).items()}
    return {path: told} if told is None or (isinstance(told, int | float) and not isinstance(told, bool)) else {}


def numbers_that_differ(told: Any, truths: Mapping[str, Any]) -> list[str]:
    """What is wrong in JSON: numbers that differ from what they must be, and numbers that nobody accounts for.

    truths: by patterns of places, the first that fits counts: a number, or one with a share and an absolute error that it may have,
    or None for null, or a function of the match that gives any of these.
    """
    wrong = []
    for place, x in numbers_in(told).items():
        found = next(((match, truth) for pattern, truth in truths.items() if (match := re.fullmatch(pattern, place))), None)
        if not found:
            wrong.append(f"nobody accounts for {place} = {x}")
            continue
        truth = found[1](found[0]) if callable(found[1]) else found[1]
        given = truth if isinstance(truth, tuple) else (truth,)
        value, share, slack = *given, *(1e-8, 0.0)[len(given) - 1:]
        if (x is None) != (value is None) or (x is not None and abs(x - value) > share*abs(value) + slack):
            wrong.append(f"{place}: {x}, expected {value}")
    return wrong
