"""What a validation section returns: checks against references, and tables."""
from __future__ import annotations

from dataclasses import dataclass, field

from sheets import Table

SECTIONS = "halfspace", "models", "merged", "bodies", "linear", "conicity", "parameters", "quasistatic", "derailment", "rigid", \
    "integration", "answers", "pressure", "sensitivity", "unknown", "measured", "stiffness", "manchester"
# Tests run these, with fewer cases and poses where a section takes `short`.
TESTED: dict[str, dict[str, bool]] = {
    "halfspace": {}, "quasistatic": {"short": True}, "integration": {"short": True}, "answers": {"short": True},
    "manchester": {"short": True}}


@dataclass(frozen=True)
class Check:
    """A number of ours against a reference.

    deviation is what the bar limits: relative unless the quantity says otherwise, never negative.
    """

    quantity: str           # with its unit in brackets, and the case
    value: float
    reference: float
    source: str             # of the reference
    deviation: float
    bar: float

    @property
    def inside(self) -> bool:
        return bool(self.deviation <= self.bar)     # not when it is NaN

    @property
    def verdict(self) -> str:
        return "inside" if self.inside else "OUTSIDE"


def relative(quantity: str, value: float, reference: float, source: str, bar: float) -> Check:
    """A check of the relative deviation."""
    return Check(quantity, float(value), float(reference), source, abs(float(value)/float(reference) - 1), bar)


def absolute(quantity: str, value: float, reference: float, source: str, bar: float) -> Check:
    """A check of the absolute deviation, in the quantity's unit."""
    return Check(quantity, float(value), float(reference), source, abs(float(value) - float(reference)), bar)


def limit(quantity: str, value: float, source: str, bar: float) -> Check:
    """A check of something that should vanish: an error, a drift; the deviation is its size."""
    return Check(quantity, float(value), 0.0, source, abs(float(value)), bar)


@dataclass
class Section:
    """One chapter of the validation."""

    title: str
    text: str                                               # what was done, what it shows; a few sentences
    checks: list[Check] = field(default_factory=list)
    tables: list[Table] = field(default_factory=list)
