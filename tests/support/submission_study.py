"""Two hundred submissions of imaginary codes: how many maps are found, how many mistakes, and how many false alarms there are.

    python tests/support/submission_study.py [NUMBER [FIRST]]          FIRST: seed of the first one

A third of the codes has Hertz's law of ours with a softer steel, a third laws of its own (damped or not, stiffer or softer,
linear), a third rigid contact with restitution. Dialects, headers and mistakes come by chance; half of the files has one mistake.
"""
from __future__ import annotations

import random
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import pandas as pd

import imaginary_codes as imaginary
import imaginary_physics as physics
import ldbench
from imaginary_physics import Physics
from ldbench import Case
from ldbench_round import check
from ldbench_round.findings import DOUBTFUL, FAILED
from ldbench_round.fingerprint import ELASTIC, RIGID, fingerprint
from ldbench_round.tasks import QUANTITIES, Task

EXERCISES = tuple(Task(exercise, pair) for exercise in (2, 3) for pair in ("aw", "sw"))
LAWS = (Physics(), Physics(k=6e10), Physics(k=1.4e11), Physics(k=1e9, n=1.0), Physics(hunt_crossley=0.1), Physics(kelvin_voigt=2e4))
RESTITUTIONS = 1.0, 0.7, 0.5, 0.0
VARIANTS = {"softer steel": 1, "own law": len(LAWS), "rigid": len(RESTITUTIONS)}
KINDS = tuple(VARIANTS)


@cache
def of_kind(kind: str, task: Task, number: int) -> tuple[ldbench.Run | None, pd.DataFrame | None, bool]:
    """A run or a table of a code of a kind, and whether it loses energy."""
    if kind == "own law":
        laws = LAWS[number % len(LAWS)]
        return None, physics.simulate(task, laws), bool(laws.hunt_crossley or laws.kelvin_voigt)
    if kind == "rigid":
        restitution = RESTITUTIONS[number % len(RESTITUTIONS)]
        return physics.rigid(task, restitution), None, restitution < 1
    case = Case.exercise(task.exercise, task.profiles).replace(model="hertz", stiffness_scale=0.8, table_file="")
    return ldbench.run(case), None, False


def study(seeds: Iterable[int], folder: Path) -> Counter[str]:
    """Counts of what was found."""
    found: Counter[str] = Counter()
    for seed in seeds:
        chance = random.Random(1000 + seed)
        kind, task = KINDS[seed % 3], chance.choice(EXERCISES)
        if kind == "own law":
            task = Task(2, task.profiles)           # a simulation of these takes seconds
        run, frame, loses = of_kind(kind, task, chance.randrange(VARIANTS[kind]))
        dialect = imaginary.invent(seed)
        if run is not None:
            frame = imaginary.table_of(run, dialect.interval)
        assert frame is not None
        mistakes = [m for m in imaginary.MISTAKES if dialect.scheme is not None and (m.told_by != "units" or dialect.says_units)]
        mistake = chance.choice(mistakes) if chance.random() < 0.5 and mistakes else None
        spoilt = mistake.spoil(frame) if mistake else frame
        lies = {"Y": "m" if dialect.unit("Y", "m") != "m" else "mm"} if mistake and mistake.told_by == "units" else {}
        file = folder/f"{task.name}.csv"
        truth = imaginary.write(spoilt, file, dialect, lies)
        count(found, kind, check.check_file(file), dialect, truth, frame.attrs["units"], mistake, loses)
        if not mistake and dialect.scheme is not None:
            told = fingerprint(check.read_submitted(file).run, task).kind
            found[f"{kind}: {'right' if told == (RIGID if kind == 'rigid' else ELASTIC) else 'wrong: ' + told}"] += 1
        if seed % 20 == 19:
            print(seed + 1, dict(found), file=sys.stderr, flush=True)
    return found


def count(found: Counter[str], kind: str, checked: check.Checked, dialect: imaginary.Dialect, truth: dict[str, int],
          units: dict[str, str], mistake: imaginary.Mistake | None, loses: bool) -> None:
    """Add a file to the counts."""
    assert checked.guess is not None
    named = "named" if dialect.scheme is not None else "nameless"
    matches = checked.guess.matches
    whole = {c: m.number for c, m in matches.items()} == truth and all(
        (m.unit, m.sign) == (dialect.unit(c, units[c]), dialect.sign(c)) for c, m in matches.items() if c in QUANTITIES)
    if mistake is None:
        found[f"{named}, {kind}: columns"] += len(truth)
        found[f"{named}, {kind}: columns found"] += sum(c in truth and m.number == truth[c] for c, m in matches.items())
        found[f"{named}, {kind}: files without mistakes"] += 1
        found[f"{named}, {kind}: maps found"] += whole
        failed = [f.what for f in checked.findings if f.verdict == FAILED and not (loses and f.what == "energy closes")]
        if dialect.scheme is not None and failed:
            found[f"{kind}: files with false alarms"] += 1
            for what in failed:
                found[f"   {kind}, false alarm: {what}, dialect {dialect}"] += 1
        return
    hit = any(f.what.startswith(mistake.found_by) and f.verdict in (FAILED, DOUBTFUL) for f in checked.findings)
    found[f"{kind}: files with mistakes"] += 1
    found[f"{kind}: mistakes found"] += hit
    if not hit:
        found[f"   {kind}, not found: {mistake.what}"] += 1


def main() -> None:
    number, first = (*map(int, sys.argv[1:]), *(200, 0)[len(sys.argv) - 1:])
    with tempfile.TemporaryDirectory() as folder:
        for what, count_of_it in sorted(study(range(first, first + number), Path(folder)).items()):
            print(f"{count_of_it:5d}  {what}")


if __name__ == "__main__":
    main()
