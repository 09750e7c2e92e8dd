"""Scores of a run against a reference: what differs, by how much, in which grade, beside the spread of formulations."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ldbench.constants import CONTACT_NAMES, CONTACTS
from ldbench.results.quantities import quantity

from .energies import SUMS
from .tasks import MOTION, Task

GRADES = 1e-3, 1e-2, 0.1                        # limits of a relative difference
#: The quantities that are compared over time, while the same contacts are closed, by the kind of score.
OVER_TIME = {"displacement": MOTION[:3], "velocity": MOTION[3:6], "acceleration": MOTION[6:],
             **{kind: tuple(f"{base}_{contact}" for base in bases for contact in CONTACTS) for kind, bases in (
                 ("force", ("N", "Fy", "Fz")), ("angle", ("angle",)), ("place", ("y", "z")), ("radius", ("radius",)))},
             "energy": tuple(SUMS)}


#: The kinds of scores in words.
KINDS = {"displacement": "displacements", "velocity": "velocities", "acceleration": "accelerations", "force": "contact forces",
         "angle": "contact angles", "place": "contact points", "radius": "rolling radii", "energy": "energies",
         "contacts": "time with other contacts closed", "event": "times of events", "impulse": "impulses of impacts",
         "peak": "largest forces of impacts", "duration": "durations of impacts"}
#: The kinds that a round grades, and how a page calls them; `score_` and the kind is the name in the table of numbers.
GRADED = {"displacement": "displacement", "velocity": "velocity", "acceleration": "acceleration", "force": "forces",
          "angle": "angles", "place": "points", "radius": "radii", "energy": "energies", "contacts": "contacts",
          "event": "events", "impulse": "impulses"}


@dataclass(frozen=True)
class Score:
    """One quantity of a run against that of the reference."""

    kind: str                   # of KINDS
    name: str                   # 'Y', 'LF closes 1', 'centre passage 2', 'LF 1 impulse'; the same in every run
    difference: float           # relative, at least 0; NaN where it cannot be had
    # SI units. Of motion, root mean squares of the reference and of the difference; of contacts, the whole time and that in which
    # they differ.
    reference: float = np.nan
    value: float = np.nan
    share: float = 1.0          # of the reference that was compared: of its time, or 0 of an event or impact without a partner
    # Relative differences of our own runs from that with half-spaces; NaN where they are not known.
    hertz: float = np.nan       # Hertz's law
    bodies: float = np.nan      # wheel and rail as elastic bodies of their own
    rigid: float = np.nan       # rigid contacts with restitution 1
    reason: str = ""            # why the difference is NaN, where a round tells it

    @property
    def grade(self) -> float | None:
        """The smallest limit that the difference is inside: 1e-3, 1e-2 or 0.1; None beyond."""
        return next((limit for limit in GRADES if self.difference <= limit), None)

    @property
    def quantity(self) -> str:
        """What it is a score of: a column, or the contact of an event or impact."""
        return self.name.partition(" ")[0]

    @property
    def words(self) -> str:
        """The quantity in words: 'lateral force, right flange', 'right flange', 'passage of the centre'."""
        name = self.quantity
        return "passage of the centre" if name == "centre" else CONTACT_NAMES.get(name) or quantity(name).words

    @property
    def of_spread(self) -> float:
        """The difference in units of the spread of laws and formulations, the largest of `hertz`, `bodies` and `rigid`; NaN where
        none is known."""
        spread = float(np.fmax.reduce([self.hertz, self.bodies, self.rigid]))
        return self.difference/spread if spread > 0 else np.nan

    def facts(self) -> dict[str, Any]:
        """The score for other programs."""
        known = vars(self) | {"grade": self.grade, "of_spread": self.of_spread}
        return {name: x for name, x in known.items() if name != "reason"}


def unscored(kind: str, reason: str) -> Score:
    """No score, and why."""
    return Score(kind, "", np.nan, share=0.0, reason=reason)


@dataclass(frozen=True)
class Unmatched:
    """An interval of contact, or a passage of the centre, that only one of both files has."""

    where: str          # 'run' or 'reference'
    name: str           # 'LF', 'centre passage'
    time: float         # [s]
    impulse: float      # [N s]; 0 of a passage


@dataclass(frozen=True)
class Scores:
    """All scores of a run of one simulation."""

    task: Task
    horizon: float                      # time beyond which nothing is scored [s]
    end: float                          # pointwise norms end here: horizon, or the end of the shorter file [s]
    share: float                        # of the time up to `end`: the same contacts are closed; NaN without forces
    scores: tuple[Score, ...]
    unmatched: tuple[Unmatched, ...] = ()
    left_out: Mapping[str, str] = field(default_factory=dict)   # quantities that could not be scored, and why
    rigid: tuple[bool, bool] = (False, False)   # whether the file and the reference have rigid contacts

    def of_kind(self, kind: str) -> list[Score]:
        """The scores of a kind."""
        return [score for score in self.scores if score.kind == kind]

    def graded(self, kind: str) -> Score | None:
        """The score that grades a kind: that of its worst quantity; None without one.

        A column has one score. Of the events or impacts of a contact the score in the middle counts, of an even number the worse.
        """
        own: dict[str, list[Score]] = {}
        for one in sorted(self.of_kind(kind), key=lambda one: one.difference):
            if not np.isnan(one.difference):
                own.setdefault(one.quantity, []).append(one)
        return max((same[len(same)//2] for same in own.values()), key=lambda one: one.difference, default=None)

    def share_of(self, kind: str) -> float:
        """Which share of a kind could be scored: of the time of all its columns, or of all events or impacts; NaN without any."""
        own = self.of_kind(kind)
        return float(np.mean([one.share for one in own])) if own else np.nan

    def get(self, name: str) -> Score | None:
        """The score of a name; None without one."""
        return next((score for score in self.scores if score.name == name), None)

    def facts(self) -> dict[str, Any]:
        """All scores for other programs."""
        return {"simulation": self.task.name, "horizon": self.horizon, "end": self.end, "share": self.share,
                "rigid": self.rigid[0], "reference_rigid": self.rigid[1],
                "scores": [score.facts() for score in self.scores],
                "unmatched": [vars(one) for one in self.unmatched], "left_out": dict(self.left_out)}
