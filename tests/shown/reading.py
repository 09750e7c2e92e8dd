"""Numbers in what a user reads: each is accounted for by a line of the table, or is one of the labels that are declared.

JSON and tables of CSV are read as texts, too, with a line `place = number` for each of their numbers.
"""
from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Text

NUMBER = re.compile(r"(?<![\w.\-/])[-−]?\d[\d\u2009]*(?:\.\d+)?(?:[eE][-+]?\d+)?(?:·10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?(?![\w/])")
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
NOTHING = "–"           # of a number that does not exist
Truth = Callable[[Any], object]


class Known(NamedTuple):
    """A number, None of what does not exist, and how far a shown one may be off beside its rounding, as a share and in its unit."""

    value: float | None
    slack: float = 1e-8
    spare: float = 0.0
    chaotic: bool = False       # whether it is written with zeros for the digits that do not hold

    def of(self, scale: float) -> Known:
        """The number in another unit."""
        return self._replace(value=None if self.value is None else scale*self.value, spare=abs(scale)*self.spare)


class Line(NamedTuple):
    """A shown number or some in a row, and what they must be."""

    pattern: str            # a group for each number
    what: str               # the numbers in words, with unit, side and moment
    truth: Truth            # what they are in that unit, from the specimen's raw rows; None for a dash
    slack: float = 0.0      # how far they may be off beside their rounding, as a share
    often: bool = False     # whether the pattern may match many times, with the match for a second argument of `truth`

    def wrong(self, world: Any, match: re.Match[str]) -> list[str]:
        """The numbers of a match that are not what they must be."""
        truth = self.truth(world, match) if self.often else self.truth(world)
        several = isinstance(truth, list | tuple | np.ndarray) and not isinstance(truth, Known)
        return [f"{self.what}: {match[group]}, expected {one}" for group, one in enumerate(truth if several else [truth], 1)
                if not agree(match[group], one, self.slack)]


def value(text: str) -> tuple[float, float]:
    """A number as it is written, and half a unit of its last digit."""
    plain = text.replace("\u2009", "").replace(" ", "").replace("·10", "e").translate(RAISED)
    if "e" not in plain and "·" not in text and plain.startswith("10") and len(text) > 2 and text[2] in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹":
        plain = f"1e{plain[2:]}"
    mantissa, _, power = plain.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return float(plain), 0.5*10.0**(int(power or 0) - decimals)


def agree(text: str, truth: Known | float | None, slack: float = 0.0) -> bool:
    """Whether a text is that number."""
    known = truth if isinstance(truth, Known) else Known(truth, slack)
    if known.value is None or np.isnan(known.value):
        return text == NOTHING
    if text == NOTHING:
        return False
    number, half = value(text)
    if known.chaotic and "." not in text:
        half = max(half, 0.5*10.0**(len(text) - len(text.rstrip("0"))))
    return abs(number - known.value) <= 1.001*half + known.slack*abs(known.value) + known.spare


def differing(text: str, lines: Iterable[Line], world: Any, labels: Iterable[str]) -> list[str]:
    """What is wrong in a text: numbers that differ from what they must be, lines of the table that the text lacks, numbers
    that no line and no label accounts for, numbers that may be any."""
    wrong, known = [], np.zeros(len(text), bool)
    for line in lines:
        found = list(re.finditer(line.pattern, text, re.MULTILINE))
        if not found or (len(found) > 1 and not line.often):
            wrong.append(f"{line.what}: {len(found)} times {line.pattern}")
        for match in found:
            wrong += line.wrong(world, match) or idle(text, line, world, match)
            known[match.start():match.end()] = True
    for label in labels:
        for match in re.finditer(label, text, re.MULTILINE):
            known[match.start():match.end()] = True
    return wrong + [f"nobody accounts for {match[0]} in {text[max(match.start() - 40, 0):match.end() + 20]!r}"
                    for match in NUMBER.finditer(text) if not known[match.start():match.end()].all()]


def idle(text: str, line: Line, world: Any, match: re.Match[str]) -> Iterator[str]:
    """The numbers of a match that may be any: the line agrees with others in their place."""
    for group in range(1, match.re.groups + 1):
        first, last = match.span(group)
        others = [match.re.match(text[:first] + other + text[last:], match.start()) for other in changed(match[group])]
        if all(other and not noticed(line, world, other) for other in others):
            yield f"{line.what}: {match[group]} may be any number, as {changed(match[group])[0]}"


def noticed(line: Line, world: Any, match: re.Match[str]) -> bool:
    """Whether a line disagrees with a match, or knows nothing of its numbers."""
    try:
        return bool(line.wrong(world, match))
    except (StopIteration, LookupError, ValueError):
        return True


def changed(number: str) -> list[str]:
    """A number whose first digit that counts is another one, so that it is less than half as large or more than half as large
    again, and one that is far from zero; of one that does not exist, a number."""
    if number == NOTHING:
        return ["7"]
    if re.match("10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]", number):
        return [f"9·{number}"]
    sign, plain = re.match(r"([-+−]?)(.*)", number).groups()
    place = next((k for k, digit in enumerate(plain) if digit in "123456789"), None)
    if place is None:
        return [sign + plain.replace("0", "9", 1)]
    return [sign + plain[:place] + str((int(plain[place]) + 3) % 9 + 1) + plain[place + 1:], f"{sign}9{re.split('e|·', plain)[0]}"]


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


def told_text(told: Any, path: str = "") -> str:
    """The numbers and nulls of JSON as lines `place = number`, with places such as `events.0.t`; words have none."""
    if isinstance(told, dict | list):
        parts = told.items() if isinstance(told, dict) else enumerate(told)
        return "".join(told_text(one, f"{path}.{name}" if path else str(name)) for name, one in parts)
    known = told is None or (isinstance(told, int | float) and not isinstance(told, bool))
    return f"{path} = {NOTHING if told is None else repr(told)}\n" if known else ""


def csv_text(file: Path, *keys: str) -> str:
    """The numbers of a table as lines `keys of the row.column = number`, and empty cells; words have none."""
    with file.open(newline="", encoding="utf-8") as opened:
        return "".join(f"{'.'.join(row[key] for key in keys)}.{column} = {cell or NOTHING}\n" for row in csv.DictReader(opened)
                       for column, cell in row.items() if column not in keys and (not cell or NUMBER.fullmatch(cell)))


def places(text: str, truths: Mapping[str, Any]) -> list[Line]:
    """A line of the table for each number of JSON or CSV. truths: by patterns of places, of which the first that fits counts, what
    the number is, or a function of the match that says this."""
    found = []
    for place in re.findall("^(.*) = ", text, re.MULTILINE):
        matches = ((re.fullmatch(pattern, place), truth) for pattern, truth in truths.items())
        match, truth = next((both for both in matches if both[0]), (None, None))
        if match:
            one = truth(match) if callable(truth) else truth
            one = one if isinstance(one, Known) else Known(one)
            found.append(Line(rf"^{re.escape(place)} = (\S+)$", place, lambda w, one=one: one))
    return found
