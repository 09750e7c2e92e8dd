"""What a collation keeps of one file: numbers, verdict, grades, and curves as they are drawn, computed once.

The key of an entry changes with all that it depends on, so that a late submission costs its own files alone.
"""
from __future__ import annotations

import gzip
import json
import re
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ldbench import Case, Error
from ldbench.plots.stretches import thin
from ldbench.results.answers import answers
from ldbench.results.run_data import RunData
from ldbench.tools import complete, digest, program_digest

from .check import findings_of, read_submitted
from .energies import ENERGIES
from .findings import DOUBTFUL, FAILED
from .jumps import IMPULSES, is_rigid
from .metrics import MATCHED_BEYOND, score
from .own_runs import horizon
from .physics_checks import energy_balance
from .round_numbers import VERDICTS, Number, names_of, numbers_of
from .row_checks import has
from .scores import GRADED, Score, unscored
from .submissions import complaint, find_files, printable, quiet, reason
from .tasks import QUANTITIES, Task, task_of

LARGEST = 300_000_000           # of a file that is read [bytes]: 2 GB of memory hold it
COLUMNS = 300                   # of a curve over the whole run: of each the smallest and the largest value are kept
CLOSE = -1e-3, 14e-3            # around the first contact of a flange, in which every row is kept [s]
CLOSE_COLUMNS = 600
OVERALL = "Y", "roll", "energy"
IMPACTS = "N_LF", "N_RF"
NEEDED = {"time", *QUANTITIES, *ENERGIES, *IMPULSES}        # of a reference, for scores
SCORED_AS_ELASTIC = ("scored against elastic contacts, but the file has rigid ones: restitution = e in submission.toml has it "
                     "scored against our own run with rigid contacts and that restitution")
SHOWN_FINDINGS = 12             # of a file

Curve = tuple[np.ndarray, np.ndarray]       # time and values, SI, in single precision


# ---- references ----------------------------------------------------------------------
@dataclass(frozen=True)
class Reference:
    """The file of a simulation that others are scored against."""

    task: Task
    file: Path
    key: str                            # changes with the bytes of the file


def find_references(path: Path) -> dict[Task, Reference]:
    """The references of a folder of column files, or of one file. Error if the folder or a file cannot be read, if no file is of a
    simulation, or two are of the same one."""
    if not path.exists():
        raise Error(file=path, expected="a folder of column files as the reference, or one such file", found="none")
    try:
        files = find_files(path, [], strict=True) if path.is_dir() else {task: path for task in [task_of(path)] if task}
    except OSError as error:
        raise Error(file=path, expected="a reference that can be read", found=reason(error)) from None
    if not files:
        raise Error(file=path, expected="names of files that say the simulation, as ex2_aw.txt, for the reference",
                    found="none")
    return {task: reference_of(task, file) for task, file in files.items()}


def reference_of(task: Task, file: Path) -> Reference:
    """The reference of a simulation. Error where its file cannot be read."""
    return Reference(task, file, digest(f"{digest_of(file, file)} {task.name}".encode()))


def digest_of(file: Path, shown: str | Path) -> str:
    """The digest of a file's bytes. Error, with the file as it is shown, where it cannot be read or is too large."""
    try:
        if (size := file.stat().st_size) > LARGEST:
            raise Error(file=shown, expected=f"at most {LARGEST/1e6:.0f} MB", found=f"{size/1e6:.0f} MB")
        return digest(file.read_bytes())
    except (OSError, ValueError) as error:
        raise Error(f"cannot be opened for reading: {reason(error)}", file=shown) from None


_READ: dict[str, RunData] = {}


def read_reference(one: Reference) -> RunData:
    """The columns and rows of a reference that scores need, read once. Error where there are none."""
    if one.key not in _READ:
        run = read_submitted(one.file, one.task).run
        data = run.data[[name for name in run.data if name in NEEDED]]
        if "time" not in data or len(data) < 2 or not np.isfinite(data.drop(columns="time")).any(axis=None):
            raise Error(file=one.file, expected="times, and numbers of the motion or of normal forces", found="none")
        # The row behind the last one that is matched: the reference is interpolated between rows.
        rows = int(np.searchsorted(run.time, MATCHED_BEYOND*horizon(one.task), "right")) + 1
        _READ[one.key] = run.with_data(data.iloc[:rows].copy())
    return _READ[one.key]


# ---- entries -------------------------------------------------------------------------
@dataclass(frozen=True)
class Entry:
    """What is known of one simulation of one code."""

    key: str
    numbers: Mapping[str, Number] = field(default_factory=dict)
    verdict: Mapping[str, int] = field(default_factory=dict)        # how many checks passed, ...
    findings: tuple[str, ...] = ()                                  # what failed or is doubtful, a line each
    curves: Mapping[str, Curve] = field(default_factory=dict)       # of OVERALL over time, of IMPACTS from the first contact on
    error: str = ""                                                 # why there is none of this
    grades: Mapping[str, Score] = field(default_factory=dict)       # differences from the reference, by the kinds of GRADED
    unscored: str = ""                                              # why there is a reference, but no grades

    @property
    def shade(self) -> str:
        """The worst verdict."""
        return "unusable" if self.error else next((one for one in ("failed", "doubtful") if self.verdict.get(one)), "passed")


@dataclass(frozen=True)
class Work:
    """One file."""

    code: str
    task: Task
    file: Path
    map: Mapping[str, Any] | None
    seconds: float
    reference: Reference | None = None
    key: str = ""           # see `key_of`

    @property
    def size(self) -> int:
        """Size of the file [bytes]."""
        return self.file.stat().st_size


def failed_entry(one: Work, error: str) -> Entry:
    """The entry of a file that cannot be used."""
    return Entry(one.key, {name: Number(np.nan, error) for name in names_of(one.task)}, error=error)


def program() -> str:
    """The digest of this program, on which all entries depend."""
    return program_digest(Path(__file__).parent.resolve())


def key_of(one: Work) -> str:
    """The key of a file's entry. Error where the file cannot be read."""
    bytes_read = digest_of(one.file, printable(one.file.name))
    known = bytes_read, one.task.name, one.task.clearance, one.map, one.seconds, one.reference and one.reference.key, program()
    return digest(repr(known).encode())


@quiet()
def make_entry(one: Work) -> Entry:
    """Read a file and compute what is kept of it, scores against a reference included; whatever is wrong with it becomes one
    line."""
    file, task = one.file, one.task
    try:
        read = read_submitted(file, task, one.map)
        run = read.run
        check_rows(run)
        findings = findings_of(read)
        lines = [printable(f"{finding.verdict}: {finding.what}" + (f": {finding.hint}" if finding.hint else ""))
                 for verdict in (FAILED, DOUBTFUL) for finding in findings if finding.verdict == verdict]
        grades: dict[str, Score] = {}
        why = ""
        if one.reference:
            reference = read_reference(one.reference)
            grades, why = graded(run, task, reference)
            if is_rigid(run, task) and not is_rigid(reference, task):
                lines.insert(0, SCORED_AS_ELASTIC)
        counts = {name: sum(finding.verdict == verdict for finding in findings) for verdict, name in VERDICTS.items()}
        return Entry(one.key, numbers_of(run, task, findings, one.seconds), counts, tuple(lines[:SHOWN_FINDINGS]),
                     curves_of(run, task), grades=grades, unscored=why and f"{printable(file.name, 80)}: {why}")
    except Exception as error:
        return failed_entry(one, complaint(error, file))


def check_rows(run: RunData) -> None:
    """Refuse a file whose rows say nothing."""
    if "time" not in run.data:
        raise Error(file=run.file, expected="a column that is the time", found="none")
    if len(run.time) < 3:
        raise Error(file=run.file, expected="three or more rows", found=len(run.time))
    if not any(np.isfinite(run.values(name)).any() for name in ("Y", "vY", "roll") if name in run.data):
        raise Error(file=run.file, expected="numbers of the lateral or roll motion", found="none")


def graded(run: RunData, task: Task, reference: RunData) -> tuple[dict[str, Score], str]:
    """The scores of a run by the kinds of GRADED, each with the share of its kind that was scored; or none, and why."""
    try:
        scores = score(run, reference, task)
    except Exception as error:
        return {}, f"not scored: {complaint(error, run.file)}"
    return {kind: replace(one, share=scores.share_of(kind)) if (one := scores.graded(kind)) else
            unscored(kind, "no number in common with the reference before the horizon") for kind in GRADED}, ""


def curves_of(run: RunData, task: Task) -> dict[str, Curve]:
    """The curves of a run as they are drawn: over the whole run, and the forces of the flanges from their first contacts on."""
    t = run.time
    known = {name: run.values(name) for name in OVERALL if has(run, name)}
    if (energy := energy_balance(run, Case.exercise(task.exercise, task.profiles))) is not None:
        known["energy"] = energy - energy[0]
    found = {name: single(*thin(t, x, COLUMNS)) for name, x in known.items()}
    starts = answers(run)
    for name in IMPACTS:
        if name in run and (start := starts[f"t_first_{name[2:]}"]) is not None:
            rows = slice(max(int(np.searchsorted(t, start + CLOSE[0])) - 1, 0),
                         int(np.searchsorted(t, start + CLOSE[1], "right")) + 1)
            found[name] = single(*thin(t[rows] - start, run.values(name)[rows], CLOSE_COLUMNS))
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
