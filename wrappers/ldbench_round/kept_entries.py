"""What a collation keeps of one file: numbers, verdict, and curves as they are drawn, computed once.

The file of a code holds the entries of its simulations under a key that changes with the bytes of the file, the map, the
processor time that the submission tells, the reference that the file is scored against, and the program. So a late submission
costs its own column alone.
"""
from __future__ import annotations

import gzip
import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ldbench import Case, Error
from ldbench.plots.stretches import thin
from ldbench.results.run_data import RunData
from ldbench.tools import complete, digest, program_digest

from .check import findings_of, read_submitted
from .findings import DOUBTFUL, FAILED
from .inertia_checks import has
from .jumps import is_rigid
from .physics_checks import energy_balance
from .round_grades import Reference, digest_of, graded, read_reference
from .round_numbers import Number, first_impact, names_of, numbers_of, verdict_counts
from .scores import Score
from .submissions import complaint, printable, quiet
from .tasks import Task

COLUMNS = 300                   # of a curve over the whole run: of each the smallest and the largest value are kept
CLOSE = -1e-3, 14e-3            # around the first contact of a flange, in which every row is kept [s]
CLOSE_COLUMNS = 600
OVERALL = "Y", "roll", "energy"
IMPACTS = "N_LF", "N_RF"
SCORED_AS_ELASTIC = ("scored against elastic contacts, but the file has rigid ones: restitution = e in submission.toml has it "
                     "scored against our own run with rigid contacts and that restitution")
SHOWN_FINDINGS = 12             # of a file

Curve = tuple[np.ndarray, np.ndarray]       # time and values, SI, in single precision


@dataclass(frozen=True)
class Entry:
    """What is known of one simulation of one code."""

    key: str
    numbers: Mapping[str, Number] = field(default_factory=dict)
    verdict: Mapping[str, int] = field(default_factory=dict)        # how many checks passed, ...
    findings: tuple[str, ...] = ()                                  # what failed or is doubtful, a line each
    curves: Mapping[str, Curve] = field(default_factory=dict)       # of OVERALL over time, of IMPACTS from the first contact on
    rows: int = 0
    error: str = ""                                                 # why there is none of this
    grades: Mapping[str, Score] = field(default_factory=dict)      # differences from the reference, by the kinds of GRADED
    unscored: str = ""                                              # why there is a reference, but no grades


@dataclass(frozen=True)
class Work:
    """One file."""

    code: str
    task: Task
    file: Path
    map: Mapping[str, Any] | None
    seconds: float
    reference: Reference | None = None
    key: str = ""           # see `key_of`; '' where the file cannot be read

    @property
    def size(self) -> int:
        """Size of the file [bytes]; 0 where it cannot be told."""
        try:
            return self.file.stat().st_size
        except OSError:
            return 0


def failed_entry(task: Task, key: str, error: str) -> Entry:
    """The entry of a file that cannot be used."""
    return Entry(key, {name: Number(np.nan, error) for name in names_of(task)}, error=error)


def program() -> str:
    """The digest of this program, on which all entries depend."""
    return program_digest(Path(__file__).parent.resolve())


def key_of(one: Work) -> str:
    """The key of a file's entry. Error where the file cannot be read."""
    known = digest_of(one.file), one.task.name, one.map, one.seconds, one.reference and one.reference.key, program()
    return digest(repr(known).encode())


def make_entry(one: Work) -> Entry:
    """Read a file and compute what is kept of it, scores against a reference included; whatever is wrong with it becomes one
    line."""
    file, task, reference = one.file, one.task, one.reference
    try:
        if not one.key:
            key_of(one)         # says why the file cannot be read
        with quiet():
            read = read_submitted(file, task, one.map)
            run = read.run
            check_rows(run)
            findings = findings_of(read)
            numbers = numbers_of(run, task, findings, one.seconds)
            lines = [printable(f"{finding.verdict}: {finding.what}" + (f": {finding.hint}" if finding.hint else ""))
                     for verdict in (FAILED, DOUBTFUL) for finding in findings if finding.verdict == verdict]
            grades, unscored = graded(run, task, read_reference(reference)) if reference else ({}, "")
            if reference and is_rigid(run, task) and not is_rigid(read_reference(reference), task):
                lines.insert(0, SCORED_AS_ELASTIC)
            return Entry(one.key, numbers, verdict_counts(findings), tuple(lines[:SHOWN_FINDINGS]), curves_of(run, task),
                         len(run.time), grades=grades, unscored=unscored and f"{printable(file.name, 80)}: {unscored}")
    except Exception as error:
        return failed_entry(task, one.key, complaint(error, file))


def check_rows(run: RunData) -> None:
    """Refuse a file whose rows say nothing."""
    if "time" not in run.data:
        raise Error(f"{run.file}: expected a column that is the time, found none")
    if len(run.time) < 3:
        raise Error(f"{run.file}: expected three or more rows, found {len(run.time)}")
    motion = [name for name in ("Y", "vY", "roll") if name in run.data]
    if not motion or not any(np.isfinite(run.values(name)).any() for name in motion):
        raise Error(f"{run.file}: expected numbers of the lateral or roll motion, found none")


def curves_of(run: RunData, task: Task) -> dict[str, Curve]:
    """The curves of a run as they are drawn: over the whole run, and the forces of the flanges from their first contacts on."""
    t = run.time
    found: dict[str, Curve] = {}
    energy = energy_balance(run, Case.exercise(task.exercise, task.profiles))
    known = {name: run.values(name) for name in OVERALL if has(run, name)}
    if energy is not None:
        known["energy"] = energy - energy[0]
    for name, x in known.items():
        found[name] = single(*thin(t, x, COLUMNS))
    for name in IMPACTS:
        impact = first_impact(run, name[2])
        if not isinstance(impact, str) and has(run, name):
            rows = slice(max(int(np.searchsorted(t, impact.start + CLOSE[0])) - 1, 0),
                         int(np.searchsorted(t, impact.start + CLOSE[1], "right")) + 1)
            if rows.stop - rows.start > 1:
                found[name] = single(*thin(t[rows] - impact.start, run.values(name)[rows], CLOSE_COLUMNS))
    return found


def single(t: np.ndarray, x: np.ndarray) -> Curve:
    """A curve in single precision; what it cannot hold is a gap."""
    narrow = x.astype(np.float32)
    narrow[~np.isfinite(narrow)] = np.nan
    return t.astype(np.float32), narrow


# ---- what is kept --------------------------------------------------------------------
def kept_file(store: Path, name: str) -> Path:
    """The file that keeps the entries of a code; any name of a folder gives one."""
    return store/f"{re.sub('[^A-Za-z0-9]+', '_', name)[:40]}-{digest(name.encode(errors='replace'))[:12]}.json.gz"


def keep(store: Path, name: str, entries: Mapping[Task, Entry]) -> None:
    """Write the entries of a code; equal entries give equal bytes."""
    facts = {task.name: asdict(entry) | {"curves": {word: np.stack(curve).tolist() for word, curve in entry.curves.items()}}
             for task, entry in entries.items()}
    with complete(kept_file(store, name)) as scratch:
        scratch.write_bytes(gzip.compress(json.dumps(facts).encode(), mtime=0))


def kept(store: Path, name: str, tasks: Mapping[Task, Path]) -> dict[Task, Entry]:
    """The entries that are kept of a code; none where the file is missing or damaged."""
    try:
        facts = json.loads(gzip.decompress(kept_file(store, name).read_bytes()))
        return {task: Entry(**facts[task.name] | {
            "numbers": {word: Number(*x) for word, x in facts[task.name]["numbers"].items()},
            "grades": {word: Score(**x) for word, x in facts[task.name]["grades"].items()},
            "curves": {word: tuple(np.array(x, np.float32)) for word, x in facts[task.name]["curves"].items()},
            "findings": tuple(facts[task.name]["findings"])}) for task in tasks if task.name in facts}
    except (OSError, EOFError, ValueError, KeyError, TypeError, AttributeError, zlib.error):
        return {}
