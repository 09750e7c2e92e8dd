"""What a section of the benchmark returns: measured figures with their spread, pictures."""
from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ldbench import Case
from sheets import Table


@dataclass(frozen=True)
class Measure:
    """A figure measured several times, side by side with what it is compared with."""

    case: str
    subject: str                # method or thing that is measured, with its setting
    quantity: str
    unit: str                   # 1 for ratios and counts
    values: tuple[float, ...]   # one per round
    note: str = ""
    headline: bool = False      # printed

    @property
    def median(self) -> float:
        return float(np.median(self.values))

    @property
    def quartiles(self) -> tuple[float, float]:
        low, high = np.quantile(self.values, (0.25, 0.75))
        return float(low), float(high)

    def text(self) -> str:
        """Median and quartiles, three digits."""
        if not np.isfinite(self.median):
            return "–"
        low, high = self.quartiles
        return f"{self.median:.3g}" if low == high else f"{self.median:.3g} ({low:.3g}–{high:.3g})"

    def line(self) -> str:
        """For the terminal."""
        unit, note = "" if self.unit == "1" else f" {self.unit}", f"; {self.note}" if self.note else ""
        return f"{self.case}, {self.subject}: {self.quantity} {self.text()}{unit}{note}"


def measure(case: str, subject: str, quantity: str, unit: str, values: float | Iterable[float],
            note: str = "", headline: bool = False) -> Measure:
    return Measure(case, subject, quantity, unit, tuple(float(x) for x in np.atleast_1d(values)), note, headline)


def ratio(case: str, subject: str, quantity: str, above: Iterable[float], below: Iterable[float],
          note: str = "", headline: bool = True) -> Measure:
    """Ratio round by round: what disturbs the machine disturbs both."""
    return measure(case, subject, quantity, "1", np.asarray(above)/np.asarray(below), note, headline)


@dataclass
class Section:
    title: str
    text: str
    measures: list[Measure] = field(default_factory=list)
    more: list[Measure] = field(default_factory=list)       # for the CSV file alone
    figures: list[Figure] = field(default_factory=list)

    @property
    def tables(self) -> list[Table]:
        return [Table("Median (quartiles)", ("case", "subject", "quantity", "value", "unit", "note"), [
            (m.case, m.subject, m.quantity, m.text(), m.unit, m.note) for m in self.measures])]


def absolute(case: Case) -> Case:
    """The case with paths that hold in any folder."""
    return case.replace(**{name: str(Path(case.find(getattr(case, name))).resolve())
                           for name in ("wheel_profile", "rail_profile", "table_folder")})
