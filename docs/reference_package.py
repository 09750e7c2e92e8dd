"""The reference package: a zip of our solutions of the simulations, as exact as rounding lets them be, and what belongs to them.

    python docs/reference_package.py [ZIP]      outputs/ldbench_reference.zip without a name, in about two minutes

The same program makes the same bytes each time: files stand in one order, with the first date that a zip can hold.
"""
from __future__ import annotations

import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ldbench import Case, ContactTable, Error, __version__
from ldbench.constants import CONTACTS
from ldbench.runs import Run, compute
from ldbench.tools import check_ending, complete, digest
from ldbench_round.metrics import scored
from ldbench_round.own_runs import DISPLACEMENTS, FILE, ending, exact, horizon, yardsticks
from ldbench_round.scores import GRADES
from ldbench_round.tasks import TASKS, Task

INTERVAL = 2.5e-5           # between rows [s]
RAMP_INTERVAL = 1e-4        # in exercise 5 [s]
RAMP_DENSE = 1.5            # times the horizon, up to which exercise 5 has all these rows
RAMP_SPARSE = 1e-3          # between rows after that [s]
DATE = 1980, 1, 1, 0, 0, 0
AGREED = 1e-9               # of displacements, as a share of their largest values
LICENCES = "LICENSE", "CITATION.cff"
ROOT = Path(__file__).resolve().parents[1]
README = ROOT/"docs/reference_readme.txt"


@dataclass(frozen=True)
class Solution:
    """A simulation, solved, and with half the step and half the interval between rows for its error."""

    task: Task
    run: Run
    finer: Run

    @property
    def until(self) -> float:
        """Errors and impacts are told up to here: the horizon or the end of the run [s]."""
        return min(horizon(self.task), float(self.run.time[-1]))


def write_package(target: Path, cases: Iterable[tuple[Task, Case]] | None = None,
                  told: Callable[[str], object] = lambda line: None) -> None:
    """Solve the simulations and write the package, a zip. cases: those that stand for simulations, by default the ten shipped ones.
    told: gets a line of text after each simulation. Error if the package cannot be written."""
    check_ending(target, "an archive .zip", ".zip")
    cases = [(task, Case.exercise(task.exercise, task.profiles)) for task in TASKS] if cases is None else list(cases)
    tables: dict[str, ContactTable] = {}
    exactness: list[dict[str, Any]] = []
    events: list[dict[str, Any]] = []
    impulses: list[dict[str, Any]] = []
    files: dict[str, str] = {}
    for task, case in cases:
        found = solve(task, case, tables)
        with tempfile.TemporaryDirectory() as folder:
            found.run.write(columns := Path(folder)/f"{task.name}.txt")
            files[f"columns/{task.name}.txt"] = "".join(kept_lines(columns, found))
        files[f"namelists/{task.name}.nml"] = found.run.case.replace(table_folder="").to_namelist()
        exactness.append(error_row(found))
        # The column file lists five events of each kind.
        events += [{"simulation": task.name, "time [s]": event.t, "event": event.kind,
                    "contact angle [rad]": "" if np.isnan(event.angle) else event.angle,
                    "lateral force [N]": "" if np.isnan(event.force) else event.force,
                    "before the horizon": int(event.t <= found.until)} for event in found.run.events]
        impulses += impulse_rows(found)
        told(f"{task.name}: {' '.join(f'{name} {x}' for name, x in exactness[-1].items() if name != 'simulation')}")
    horizons = [{"simulation": task.name, "horizon [s]": own.horizon, "reached": int(own.reached),
                 "horizon by DOP853 [s]": "" if own.independent is None else own.independent,
                 "both integrators apart by": own.integrators, "growth": own.growth,
                 **{f"grade {k}": limit for k, limit in enumerate(GRADES, 1)}} for task, _ in cases
                for own in [yardsticks()[task.name]]]
    files |= {"exactness.csv": table(exactness), "events.csv": table(events), "impulses.csv": table(impulses),
              "horizons.csv": table(horizons), "README.md": readme(exactness)}
    names = {Path(name).name for _, case in cases for name in case.profile_files().values()}
    copied = {f"profiles/{name}": ROOT/"profiles"/name for name in (*names, "README.md")} | {name: ROOT/name for name in LICENCES}
    files |= {name: file.read_text(encoding="utf-8") for name, file in (copied | {"yardsticks.json": FILE}).items()}
    files["SHA256SUMS"] = "".join(f"{digest(files[name].encode())}  {name}\n" for name in sorted(files))
    with complete(target) as scratch, zipfile.ZipFile(scratch, "w") as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, DATE)
            entry.compress_type, entry.external_attr, entry.create_system = zipfile.ZIP_DEFLATED, 0o644 << 16, 3
            archive.writestr(entry, files[name].encode(), compresslevel=9)


# Solutions --------------------------------------------------------------------------------

def solve(task: Task, case: Case, tables: dict[str, ContactTable]) -> Solution:
    """Run a case with exact steps and with half of these; `tables` keeps the contact table of each pair of profiles."""
    interval = RAMP_INTERVAL if case.lateral_ramp else INTERVAL
    own = exact(case).replace(interval=interval, rows="interval_and_events", output_file=f"{task.name}.txt")
    # Behind the horizon, half the step tells nothing. Half the interval tells what sums over rows miss of impulses.
    half = exact(ending(case, horizon(task)), 0.5).replace(interval=interval/2, rows="interval_and_events")
    first = compute(own, table=tables[task.profiles].for_case(own) if task.profiles in tables else None)
    tables[task.profiles] = first.table
    return Solution(task, first, compute(half, table=first.table.for_case(half)))


def kept_lines(file: Path, found: Solution) -> Iterator[str]:
    """The lines of a column file; of exercise 5, some time behind the horizon, those of the rows RAMP_SPARSE apart and the last."""
    dense = RAMP_DENSE*horizon(found.task) if found.run.case.lateral_ramp else np.inf
    end = float(found.run.time[-1]) - 1e-9      # times of rows are rounded
    with file.open(encoding="utf-8") as lines:
        for k, line in enumerate(lines):
            t = 0.0 if k == 0 or line.startswith("#") else float(line.split(maxsplit=1)[0])
            if not dense < t < end or is_multiple(t, RAMP_SPARSE):
                yield line


def is_multiple(t: Any, interval: float) -> Any:
    """Whether a time, or each of several, is a whole number of intervals, but for rounding."""
    return np.abs(t/interval - np.round(t/interval)) < 1e-7


def common(found: Solution) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times of rows that both runs have at equal intervals, up to the horizon [s]; the places of these rows in both."""
    interval, runs = found.run.case.interval, (found.run, found.finer)
    rows = [np.flatnonzero((one.time <= found.until) & is_multiple(one.time, interval)) for one in runs]
    numbers = [np.round(one.time[own]/interval) for one, own in zip(runs, rows, strict=True)]
    both, mine, finer = np.intersect1d(numbers[0], numbers[1], return_indices=True)
    return both*interval, rows[0][mine], rows[1][finer]


def error_row(found: Solution) -> dict[str, Any]:
    """How exact a solution is: its drift of energy, and what half the step and twice the rows change up to the horizon."""
    t, mine, finer = common(found)
    apart = np.zeros(len(t))
    for column in DISPLACEMENTS:
        x, y = found.run.values(column)[mine], found.finer.values(column)[finer]
        apart = np.maximum(apart, np.abs(x - y)/np.abs(x).max())
    beyond = np.flatnonzero(apart > AGREED)
    drift = found.run.results["drift"]
    scores = scored(found.finer, found.run, found.task, found.until)
    largest = {kind: [one.difference for one in scores.of_kind(kind) if not np.isnan(one.difference)]
               for kind in ("event", "impulse", "peak", "duration")}
    return {"simulation": found.task.name, "step [s]": found.run.case.dt, "drift [J]": short(drift),
            "drift, relative": short(found.run.results["drift_relative"]), "until [s]": found.until,
            "displacements": short(apart.max()),
            "displacements within 1e-9 until [s]": float(t[beyond[0]]) if beyond.size else found.until,
            **{name: short(max(largest[kind])) if largest[kind] else "" for kind, name in (
                ("event", "times of events"), ("impulse", "impulses"), ("peak", "peaks"), ("duration", "durations"))},
            "without a partner": len(scores.unmatched)}


def short(x: float) -> float:
    """Two digits of an error."""
    return float(f"{x:.1e}")


# Tables -----------------------------------------------------------------------------------

def impulse_rows(found: Solution) -> list[dict[str, Any]]:
    """The impacts of every contact up to the horizon, in order of time."""
    rows = []
    for contact in CONTACTS:
        whole = [one for one in found.run.intervals(contact, 1.1*found.until) or [] if one.whole and one.end <= found.until]
        rows += [{"simulation": found.task.name, "contact": contact, "number": k, "closes [s]": one.start, "opens [s]": one.end,
                  "impulse [N s]": one.impulse, "largest force [N]": one.peak} for k, one in enumerate(whole, 1)]
    return sorted(rows, key=lambda row: (row["closes [s]"], row["contact"]))


def table(rows: Iterable[dict[str, Any]]) -> str:
    """Rows as CSV, numbers to the last bit."""
    return pd.DataFrame(list(rows)).to_csv(index=False, lineterminator="\n")


def rounded_up(x: float) -> str:
    """A number that is no smaller, with one digit."""
    shown = f"{x:.0e}"
    mantissa, exponent = shown.split("e")
    return shown if float(shown) >= x else f"{float(f'{int(mantissa) + 1}e{exponent}'):.0e}"


def readme(exactness: Sequence[dict[str, Any]]) -> str:
    """What the package holds, and how exact it is, in words."""
    free = [row for row in exactness if not row["simulation"].startswith("ex5")]
    ramp = [row for row in exactness if row["simulation"].startswith("ex5")]

    def largest(rows: Sequence[dict[str, Any]], name: str) -> str:
        known = [row[name] for row in rows if row[name] != ""]
        return rounded_up(max(known)) if known else "nothing"

    said = []
    if free:
        said.append(f"In exercises 1 to 4, half the step and twice the rows change no displacement by more than\n"
                    f"{largest(free, 'displacements')} of its largest value, no time of an event by more than "
                    f"{largest(free, 'times of events')} of it, no impulse by\nmore than {largest(free, 'impulses')}, and "
                    f"no largest force by more than {largest(free, 'peaks')}.")
    if ramp:
        until = ", ".join(f"{row['simulation']} up to {row['displacements within 1e-9 until [s]']:.3f} s" for row in ramp)
        said.append(f"In exercise 5, displacements are known to 1e-9 for a while ({until}). Up to the horizon,\nthey have changed "
                    f"by {largest(ramp, 'displacements')}. What comes after the horizon is one sample of a chaotic motion.")
    return README.read_text(encoding="utf-8").format(
        exactness="\n".join(said), version=__version__, drift=largest(exactness, "drift, relative"), interval=INTERVAL,
        ramp=RAMP_INTERVAL, dense=RAMP_DENSE, sparse=RAMP_SPARSE, count=len(exactness))


def main(words: list[str]) -> int:
    target = Path(words[0]) if words else Path("outputs/ldbench_reference.zip")
    try:
        write_package(target, told=print)
    except Error as error:
        print(f"docs: {error}", file=sys.stderr)
        return 1
    print(f"{target}: {target.stat().st_size/1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
