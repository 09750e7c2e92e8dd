"""Answers of a case with their causes: statistics of the variations, in words, as data and as JSON."""
from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.errors import Error
from .._core.files import complete
from .._core.wording import counted, html_table
from ..number_text import two_digits
from ..results.quantities import OUTCOME, Quantity, si_unit
from ..results.twins import is_chaotic, spreads
from .variations import PROGRAM

if TYPE_CHECKING:       # pandas and matplotlib are imported where they are needed: it takes longer than a short run
    import pandas as pd

    from ..plots.sheets import Figures

#: Answers that are shown where not all are asked for.
SHORT = ("t_first_LF", "first_peak_N_LF", "first_duration_LF", "first_impulse_LF", "t_first_RF", "first_peak_N_RF", "t_return",
         "farthest_left", "pmax", "F_limit_left", "F_derailment")
OTHERS = 0.01       # share of the largest change below which causes are summed up
#: Causes that no variation shows.
NOT_AMONG = "friction", "damping", "wheelset and track that bend"
WIDTH = 100         # longest line on the terminal [characters]
HELD = "\u00a0"     # blank at which no line ends


@dataclass(frozen=True)
class Answer:
    """An answer of a case and what moves it, SI units; NaN for what does not happen."""

    name: str
    value: float                    # of the case itself
    median: float                   # of the case and its variations that leave the data as they are
    low: float                      # the least of these
    high: float                     # the largest of these
    low_inputs: float               # the least of all variations; inputs count to either side of an answer that is not chaotic
    high_inputs: float              # the largest of all variations
    chaotic: bool                   # whether the twins do not share it
    twins: tuple[float, ...]        # its values in the twins
    #: Change by each cause, the largest first; of the twins the largest change. Infinite: the cause makes the answer come or go.
    causes: Mapping[str, float]

    @property
    def quantity(self) -> Quantity:
        """Words, unit and digits."""
        return OUTCOME.get(self.name) or Quantity(self.name, "s", 1, digits=6)      # a time, by the name of what it is of

    def main_causes(self) -> dict[str, float]:
        """The causes that are at least a hundredth of the largest; the sum of the others' sizes as 'others'."""
        finite = [abs(change) for change in self.causes.values() if np.isfinite(change)]
        least = OTHERS*max(finite, default=0.0)
        found = {name: change for name, change in self.causes.items() if abs(change) >= least}
        others = sum(abs(change) for name, change in self.causes.items() if name not in found)
        return found | ({"others": others} if others else {})

    def change_text(self, cause: str, change: float) -> str:
        """A change in % of the value; with its unit where that is zero."""
        if not np.isfinite(change):
            return f"{cause}: makes it {'go' if np.isfinite(self.value) else 'come'}"
        sign = "up to " if cause == "others" else "+" if change > 0 else "−"
        known = self.quantity
        size, unit = (100*abs(change/self.value), "%") if self.value else (known.scale*abs(change), known.unit)
        return f"{cause}: {sign}{two_digits(size)} {unit}"

    def span_text(self, low: float, high: float) -> str:
        """A range, and what it is of the value in %."""
        text = f"{self.quantity.text(low)} to {self.quantity.text(high)}"
        if not (self.value and np.isfinite([self.value, low, high]).all()):
            return text
        below, above = (100*(x - self.value)/abs(self.value) for x in (low, high))
        return f"{text} (−{two_digits(abs(below))} to +{two_digits(abs(above))} %)"

    def lines(self) -> Iterator[str]:
        """What there is to say, line by line."""
        known = self.quantity
        note = ", chaotic: one sample" if self.chaotic else ""
        yield f"{known.words}: {known.text(self.value)} {known.unit}".rstrip() + note
        yield f"    the program leaves open: median {known.text(self.median)}, {self.span_text(self.low, self.high)}"
        for spread in spreads({self.name: self.value}, [{self.name: x} for x in self.twins]).values():
            least, largest = known.text(spread.least), known.text(spread.largest)
            yield (f"    run and twins: median {known.text(spread.median)}, {least} to {largest}; "
                   f"{spread.having} of {spread.of} have it")
        yield f"    with inputs: {self.span_text(self.low_inputs, self.high_inputs)}"
        causes = [self.change_text(*one) for one in self.main_causes().items()] or ["none of them moves it"]
        whole = [cause.replace(" ", HELD) for cause in causes]
        for line in textwrap.wrap(f"causes: {'; '.join(whole)}", WIDTH, initial_indent="    ", subsequent_indent="        ",
                                  break_on_hyphens=False):
            yield line.replace(HELD, " ")


@dataclass(frozen=True)
class Trust:
    """How far the answers of a case are to be trusted."""

    case: str                                       # its name
    title: str
    variations: tuple[tuple[str, str], ...]         # kind and cause of each
    values: Mapping[str, tuple[float, ...]]         # of each answer: of the case, then of the variations, SI; NaN: does not happen
    failed: Mapping[str, str]                       # variations that could not run, and why
    without_effect: tuple[str, ...]                 # inputs that change no answer
    notes: tuple[str, ...]                          # causes that could not be varied, and why

    @cached_property
    def answers(self) -> dict[str, Answer]:
        """All answers by their names."""
        return {name: self._answer(name, np.array(own)) for name, own in self.values.items()}

    def _answer(self, name: str, own: np.ndarray) -> Answer:
        value, rest = float(own[0]), own[1:]
        kinds = np.array([kind for kind, _ in self.variations])
        twins = rest[kinds == "twin"]
        chaotic = is_chaotic(name, value, twins.tolist())
        causes: dict[str, float] = {}
        for (_, cause), x in zip(self.variations, rest, strict=True):
            change = 0.0 if np.isnan([x, value]).all() else float(x - value) if np.isfinite([x, value]).all() else np.inf
            if abs(change) > abs(causes.get(cause, 0.0)):
                causes[cause] = change
        program = finite([value, *rest[np.isin(kinds, PROGRAM)]])
        whole = finite([value, *rest])
        if not chaotic:
            whole = finite([*whole, *(2*value - rest[kinds == "input"])])
        return Answer(name, value, float(np.median(program)) if program else np.nan,
                      min(program, default=np.nan), max(program, default=np.nan),
                      min(whole, default=np.nan), max(whole, default=np.nan), chaotic, tuple(twins.tolist()),
                      dict(sorted(causes.items(), key=lambda item: -abs(item[1]))))

    def range_of(self, kind: str, name: str) -> tuple[float, float] | None:
        """The least and the largest value of an answer, SI, in the variations of a kind; None where it does not happen in any."""
        own = finite([x for (of, _), x in zip(self.variations, self.values[name][1:], strict=True) if of == kind]
                     if name in self.values else [])
        return (min(own), max(own)) if own else None

    def shown(self, everything: bool = False) -> list[Answer]:
        """The answers of the short list that happen in the case or in a twin; or all."""
        if everything:
            return [one for one in self.answers.values() if one.value or one.causes]
        return [one for name in SHORT if (one := self.answers.get(name)) and np.isfinite([one.value, *one.twins]).any()]

    def lines(self, everything: bool = False) -> list[str]:
        """What there is to say, line by line."""
        kinds = [kind for kind, _ in self.variations]
        found = [f"{self.case}: {self.title}" if self.title else self.case,
                 f"{counted(len(kinds) + 1, 'run')}: the case, {counted(kinds.count('twin'), 'twin')} and "
                 f"{counted(len(kinds) - kinds.count('twin'), 'other variation')}, one cause at a time",
                 "the program leaves open: case, twins, table accuracy, influence, bodies",
                 "with inputs: all variations; inputs are changed to one side, and count to either side of an answer",
                 "that is not chaotic, as if changes were in proportion"]
        for one in self.shown(everything):
            found += ["", *one.lines()]
        found.append("")
        if self.without_effect:
            found += textwrap.wrap(f"without effect: {', '.join(self.without_effect)}", WIDTH, subsequent_indent="    ")
        found += [f"failed: {cause}: {reason}" for cause, reason in self.failed.items()]
        found += self.notes
        return [*found, *textwrap.wrap(f"not among the causes: {', '.join(NOT_AMONG)}", WIDTH, subsequent_indent="    ")]

    def facts(self) -> dict[str, Any]:
        """All numbers, SI units, with None for what does not happen and for changes by which an answer comes or goes."""
        return plain({
            "case": self.case, "title": self.title,
            "variations": [{"kind": kind, "cause": cause} for kind, cause in self.variations],
            "answers": {name: {
                "unit": si_unit(name), **{key: getattr(one, key) for key in (
                    "value", "median", "low", "high", "low_inputs", "high_inputs", "chaotic", "causes")},
                "values": self.values[name][1:]} for name, one in self.answers.items()},
            "failed": self.failed, "without_effect": self.without_effect, "notes": self.notes, "not_among": NOT_AMONG})

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> Trust:
        """What `facts` tells, or JSON of it; Error where it is something else."""
        try:
            values = {name: tuple(np.nan if x is None else float(x) for x in (told["value"], *told["values"]))
                      for name, told in facts["answers"].items()}
            return cls(facts["case"], facts["title"], tuple((one["kind"], one["cause"]) for one in facts["variations"]), values,
                       dict(facts["failed"]), tuple(facts["without_effect"]), tuple(facts["notes"]))
        except (KeyError, TypeError, AttributeError, ValueError):
            raise Error(place="trust", expected="the JSON that `python -m ldbench trust --json` writes",
                        found="something else") from None

    def json(self, path: str | Path = "") -> str:
        """All numbers as JSON, SI units, also written to `path` if given; null for what does not happen."""
        text = json.dumps(self.facts(), ensure_ascii=False, allow_nan=False)
        if path:
            with complete(Path(path)) as scratch:
                scratch.write_text(text + "\n", encoding="utf-8")
        return text

    def to_frame(self, everything: bool = False) -> pd.DataFrame:
        """A row for each answer: value, median, ranges, whether it is chaotic, and the change by each cause, SI units."""
        import pandas as pd

        shown = self.shown(everything)
        names = ("value", "median", "low", "high", "low_inputs", "high_inputs", "chaotic")
        causes = dict.fromkeys(cause for _, cause in self.variations)
        return pd.DataFrame([{"unit": si_unit(one.name), **{name: getattr(one, name) for name in names},
                              **{cause: one.causes.get(cause, 0.0) for cause in causes}} for one in shown],
                            pd.Index([one.name for one in shown], name="answer"))

    def plot(self, everything: bool = False) -> Figures:
        """The causes of each answer as bars: figures of matplotlib, which a notebook shows."""
        from ..plots.sheets import Figures
        from ..plots.style import ldbench_style
        from .page import causes_pages

        with ldbench_style():
            return Figures(causes_pages(self, everything))

    def _repr_html_(self) -> str:
        """The short list as a table, for a notebook."""
        rows = []
        for one in self.shown():
            main = [one.change_text(*cause) for cause in list(one.main_causes().items())[:4]]
            rows.append((one.quantity.label, one.quantity.text(one.value) + (", chaotic" if one.chaotic else ""),
                         one.span_text(one.low, one.high), one.span_text(one.low_inputs, one.high_inputs), "; ".join(main)))
        return html_table(f"{self.case}: {self.title}" if self.title else self.case, rows,
                          ("answer", "value", "the program leaves open", "with inputs", "largest causes"))

    def __repr__(self) -> str:
        return f"Trust({self.case!r}, {counted(len(self.variations) + 1, 'run')}, {counted(len(self.answers), 'answer')})"


def finite(values: list[float]) -> list[float]:
    """The values that are there."""
    return [float(x) for x in values if np.isfinite(x)]


def plain(x: Any) -> Any:
    """Numbers, texts, lists and mappings as JSON has them; None for numbers that it has not."""
    if isinstance(x, Mapping):
        return {name: plain(value) for name, value in x.items()}
    if isinstance(x, list | tuple):
        return [plain(value) for value in x]
    return None if isinstance(x, float) and not np.isfinite(x) else x
