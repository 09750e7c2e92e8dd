"""What the benchmark call asks for: exercises, files, quantities."""
from __future__ import annotations

import functools
import re
from dataclasses import dataclass
from pathlib import Path

from ldbench import Case, Error
from ldbench.constants import CONTACTS
from ldbench.results.columns import read_toml
from ldbench.results.quantities import PAIRS

MOTION = "Y", "Z", "roll", "vY", "vZ", "roll_rate", "aY", "aZ", "roll_acc"
PER_CONTACT = "angle", "N", "Fz", "Fy", "y", "z", "radius"

#: Columns of a submission: motion in the track frame, then the quantities of every contact.
QUANTITIES = (*MOTION, *(f"{name}_{contact}" for name in PER_CONTACT for contact in CONTACTS))

# Endings of column files.
ENDINGS = {".txt", ".csv", ".dat", ".tsv", ".asc", ".out", ".prn", ".lis", ".lst", ".lvm", ".m", ".md", ".plt", ".res"}
EXERCISE = re.compile(r"(?:ex(?:ercise)?|case|run|e)[ _.-]*([1-5])(?!\d)", re.IGNORECASE)
CLEARANCES = "profiles/clearances.toml"     # found as profiles are: the clearance of one side by the pair of profiles [mm]
LARGEST_CLEARANCE = 100             # [mm]
PROFILES = {"aw": r"(?<![a-z])(?:aw(?:prof)?|act(?:ual)?|a)(?![a-z])",
            "sw": r"(?<![a-z])(?:sw(?:prof)?|simp(?:lified)?|s)(?![a-z])"}


@dataclass(frozen=True)
class Task:
    """One of the ten simulations."""

    exercise: int           # 1 to 5
    profiles: str           # 'aw' or 'sw'

    @property
    def name(self) -> str:
        """The name of the shipped input."""
        return f"ex{self.exercise}_{self.profiles}"

    @property
    def clearance(self) -> float:
        """The clearance of one side that the call publishes [m]."""
        return clearances()[self.profiles]

    @property
    def words(self) -> str:
        """The task in words."""
        return f"exercise {self.exercise}, {PAIRS[self.profiles]}"


TASKS = tuple(Task(exercise, profiles) for exercise in range(1, 6) for profiles in PAIRS)


@functools.cache
def clearances() -> dict[str, float]:
    """The published clearances of the round by its pairs of profiles [m]. Error where the file beside the profiles lacks one."""
    file = Path(Case.exercise(1, "aw").find(CLEARANCES))
    told = read_toml(file)
    for pair in PAIRS:
        value = told.get(pair)
        if not (isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < LARGEST_CLEARANCE):
            raise Error(file=file, place=pair, found="none" if value is None else value,
                        expected=f"the published clearance of one side, above 0 and below {LARGEST_CLEARANCE} mm")
    return {pair: told[pair]/1e3 for pair in PAIRS}


def task_of(file: Path) -> Task | None:
    """The simulation that the name of a file speaks of; None where the name does not say it."""
    name = file.stem.lower()
    number = EXERCISE.search(name) or re.search(r"(?<!\d)([1-5])(?!\d)", name)
    if number is None:
        return None
    rest = name[:number.start()] + " " + name[number.end():]
    pairs = [pair for pair, words in PROFILES.items() if re.search(words, rest.replace("_", " "))]
    return Task(int(number[1]), pairs[0]) if len(pairs) == 1 else None


def task_named(word: str) -> Task:
    """The simulation of a name as 'ex2_aw'."""
    found = next((task for task in TASKS if task.name == word), None)
    if found is None:
        raise Error(expected=f"a simulation among {', '.join(task.name for task in TASKS)}", found=word)
    return found
