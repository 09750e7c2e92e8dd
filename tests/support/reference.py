"""Stored answers: outputs of the ten shipped inputs, and motions of the rigid formulations.

`make reference` runs all cases, says what moved, and replaces the references; tests say it too, and replace nothing.

outputs/reference has two files per shipped input, which read like any column file: <case>.txt, rows of the run with its events
and peaks of the summary; <case>_tolerance.txt, how far each of these numbers may move, inf where it is not compared.

Tolerances. Another compiler rounds differently; impacts amplify that. How much is measured: the run is repeated with its
initial lateral velocity changed by 1e-10 of itself to either side (exercise 5, which starts at rest: by up to 4e-12 m/s), and
the largest deviation up to a row's time is the amplification there. Fused multiply-add instructions in the whole program move
exercises 1 to 4 by less than a tenth of that, exercise 5 by up to twice that. A number may move by

    a written digit  +  1e-7 of the column's range (all energies have one)  +  10 times that deviation

and is compared while the last term is less than 1e-3 of the range. Exercise 5 is chaotic from its first bounces on the flange:
its rows end there, and the range is that of these rows. Events and peaks of the whole run have tolerances of the same kind,
event times that of a step in addition; where they are chaotic they are compared as a statistic, mean of nine runs +- their
99.9 % prediction interval, if that says anything.

formulations.csv has the rigid formulations: instants of every motion, in exercise 5 of the first second, and how exercise 5
ends. With restitution below 1 the wheelset comes to rest on the flange long before, and the end does not depend on how; with
restitution 1 it rattles on, and the end may move by some kN; bilateral, it never ends: when a rail begins to pull, and the
least Y of the last second. A number may move by 1e-9 and ten times that deviation; instants are compared up to 1e-4.
"""
from __future__ import annotations

import functools
import re
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

import ldbench
from ldbench import Case
from ldbench._core.files import complete
from ldbench.report import formulations
from running import CASES, REPO, Columns, Run, columns, for_all_cases, header, on_grid, read_interval, run_shipped

FOLDER = REPO / "outputs/reference"
ROWS = 100
RELATIVE = 1e-7        # of a column's range
WRITTEN = 1e-8         # of a number, the last digit of a column file
AMPLIFICATION = 10     # times the deviation of the perturbed runs
LIMIT = 1e-3           # of a column's range or a fact's value; a looser tolerance is none
STATISTIC = 9          # runs that make one
PREDICTION = 5.3       # its interval in standard deviations: Student's t for 99.9 %, 5.04, times sqrt(1 + 1/9)
LOOSEST = 0.5          # of a statistic's mean
DIGIT = {"[s]": 1e-6, "[mm]": 1e-3, "[kN]": 1e-3, "[m]": 1e-10}   # of facts; [m]: the axle height, in full


@dataclass
class Reference:
    columns: Columns                               # rows of the run
    tolerances: Columns                            # of the same rows
    units: dict[str, str]
    facts: dict[str, tuple[float, float]]          # events, peaks, ...: value, tolerance
    ending: str                                    # why the run ended


@dataclass
class Move:
    """The largest difference of a column or fact from its reference, in units of its tolerance."""
    what: str
    by: float
    tolerance: float
    where: str = ""

    @property
    def share(self) -> float:
        return 0.0 if self.by == 0 else np.inf if self.tolerance == 0 else self.by / self.tolerance

    def __str__(self) -> str:
        return f"{self.what}{self.where} moved by {self.by:.2g}, tolerance {self.tolerance:.2g}"


def read_facts(text: str) -> dict[str, float]:
    """Results in a summary and a column file's header; the k-th event of a kind is `kind k`."""
    found = {
        "clearance [mm]": float(re.search(r"rigid-axle clearance \[mm\]: left (\S+), right", text)[1]),
        "axle height [m]": float(re.search(r"axle_height = (\S+)", text)[1]),
        "end [s]": float(re.search(r"ended at t = (\S+) s", text)[1]),
    }
    seen: dict[str, int] = {}
    events = re.findall(r"^  t = (\S+) s  ([^,\n]+?)(?: at \S+ degrees)?(?:, lateral force (\S+) kN)?$", text, flags=re.M)
    for time, kind, force in events:
        seen[kind] = seen.get(kind, 0) + 1
        found[f"{kind} {seen[kind]} [s]"] = float(time)
        if kind == "derailment" and force:
            found["lateral force at derailment [kN]"] = float(force)
    for name, number in re.findall(r"^ *n_(\w+) = (\d+)$", text, flags=re.M):
        kind = name.replace("_", " ").replace("lift off", "lift-off")
        found[f"{kind}, number"] = float(number)
    for contact in ("LT", "LF", "RT", "RF"):
        force, time = (float(re.search(rf"^ *{name}_{contact} = (\S+)", text, flags=re.M)[1]) for name in ("peak_N", "t_peak"))
        found[f"peak N_{contact} [kN]"] = round(1e-3*force, 3)
        if force:
            found[f"time of peak N_{contact} [s]"] = round(time, 6)
    return found


def read_ending(text: str) -> str:
    return re.search(r"ended at t = \S+ s: (.*)", text)[1]


def perturbations(case: str) -> list[Callable[[str], str]]:
    """Changes of a case's text: its initial lateral velocity a little larger and smaller."""
    def change(factor: float, summand: float) -> Callable[[str], str]:
        return lambda text: re.sub(
            r"(\bvY\s*=\s*)(\S+)", lambda match: match[1] + repr(float(match[2]) * factor + summand), text)

    if case.startswith("ex5"):
        return [change(1, 1e-12 * k) for k in (1, -1, 2, -2, 3, -3, 4, -4)]
    return [change(1 + 1e-10, 0), change(1 - 1e-10, 0)]


def growth(run: Columns, others: list[Columns], name: str) -> np.ndarray:
    """Largest deviation of a column up to each row's time; inf from where a contact is open in one run only."""
    rows = len(run["time"])
    found = np.full((len(others) + 1, rows), 0.0)
    for deviation, other in zip(found[1:], others, strict=True):
        n = min(rows, len(other["time"]))
        a, b = run[name][:n], other[name][:n]
        deviation[n:] = np.inf
        deviation[:n] = np.nan_to_num(np.where(np.isnan(a) & np.isnan(b), 0, np.abs(a - b)), nan=np.inf)
    return np.maximum.accumulate(found.max(axis=0))


def column_tolerance(run: Columns, others: list[Columns], units: dict[str, str], name: str, rows: slice) -> np.ndarray:
    """The tolerance of every row; inf where the column is not compared. A column's range is what it sweeps in these rows, the most
    of all energies for an energy; its size if it is constant."""
    group = [other for other in run if units[other] == "J"] if units[name] == "J" else [name]
    swept = [x[~np.isnan(x)] for x in (run[other][rows] for other in group)]
    scale = max((np.ptp(x) or np.abs(x).max() for x in swept if len(x)), default=0.0)
    amplified = AMPLIFICATION * growth(run, others, name)
    tolerance = WRITTEN * np.nanmax(np.abs(run[name]), initial=0) + RELATIVE * scale + amplified
    return np.where(amplified <= LIMIT * scale, tolerance, np.inf)[rows]


def reproducible_rows(run: Columns, others: list[Columns], units: dict[str, str]) -> slice:
    """The rows in which the lateral displacement can be compared."""
    rows = slice(None)
    for _ in range(2):   # the range of the whole run counts the derailment
        rows = slice(np.count_nonzero(np.isfinite(column_tolerance(run, others, units, "Y", rows))))
    return rows


def fact_tolerance(value: float, others: list[float | None], resolution: float) -> tuple[float, float]:
    """The value to compare with, and by how much it may differ."""
    if None in others:
        return value, np.inf
    deviation = max(abs(other - value) for other in others)
    if AMPLIFICATION * deviation <= LIMIT * abs(value):
        return value, resolution + AMPLIFICATION * deviation
    sample = [value, *others]
    mean, tolerance = round(float(np.mean(sample)), 6), resolution + PREDICTION * float(np.std(sample, ddof=1))
    return (mean, tolerance) if len(sample) == STATISTIC and tolerance < LOOSEST * abs(mean) else (value, np.inf)


def resolution(what: str, run: Run) -> float:
    """The resolution of a fact: the digits that it is written with; an event may move by a step, the end by a row."""
    digit = next((digit for unit, digit in DIGIT.items() if what.endswith(unit)), 0.0)
    if not what.endswith("[s]"):
        return digit
    step = float(re.search(r"steps: \d+ of at most (\S+) s", run.summary)[1])
    return digit + (read_interval(run.header) if what == "end [s]" else step)


def make(run: Run, others: list[Run]) -> Reference:
    """A run, and what became of it with the initial conditions perturbed."""
    run, *others = (on_grid(done) for done in (run, *others))
    found = [other.columns for other in others]
    unit_line = next(words for line in run.header.splitlines() if (words := line.split())[:2] == ["s", "m"])
    units = dict(zip(run.columns, unit_line, strict=True))
    rows = reproducible_rows(run.columns, found, units)
    kept = np.unique(np.linspace(0, len(run.columns["time"][rows]) - 1, ROWS).astype(int))
    other_facts = [read_facts(other.summary + other.header) for other in others]
    return Reference(
        {name: values[kept] for name, values in run.columns.items()},
        {name: column_tolerance(run.columns, found, units, name, rows)[kept] for name in run.columns},
        units,
        {what: fact_tolerance(value, [facts.get(what) for facts in other_facts], resolution(what, run))
         for what, value in read_facts(run.summary + run.header).items()},
        read_ending(run.summary))


def write(case: str, reference: Reference, folder: Path = FOLDER) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    names = "".join(f"{name:>16}" for name in reference.columns) + "\n"
    units = "#" + "".join(f"{unit:>16}" for unit in reference.units.values())[1:] + "\n"
    facts = "".join(f"# {what} = {value!r} +- {tolerance:.2g}\n"
                    for what, (value, tolerance) in reference.facts.items())
    with complete(folder / f"{case}.txt") as scratch, open(scratch, "w") as file:
        file.write(f"{names}# {case}: reference rows, see tests/reference.py\n")
        file.write(f"{facts}# ended: {reference.ending}\n{units}")
        np.savetxt(file, np.transpose(list(reference.columns.values())), "%16.8E", delimiter="")
    with complete(folder / f"{case}_tolerance.txt") as scratch, open(scratch, "w") as file:
        file.write(f"{names}# {case}: tolerances of the reference rows; inf: not compared\n{units}")
        np.savetxt(file, np.transpose(list(reference.tolerances.values())), "%.1E")


def read(case: str, folder: Path = FOLDER) -> Reference:
    file = folder / f"{case}.txt"
    text, rows = header(file), columns(file)
    facts = {what: (float(value), float(tolerance))
             for what, value, tolerance in re.findall(r"^(.*) = (\S+) \+- (\S+)$", text, flags=re.M)}
    return Reference(rows, columns(folder / f"{case}_tolerance.txt"),
                     dict(zip(rows, text.splitlines()[-1].split(), strict=True)),
                     facts, re.search(r"^ended: (.*)$", text, flags=re.M)[1])


def compare(reference: Reference, run: Run) -> list[Move]:
    """The largest move, by its tolerance, of every column and fact that is compared."""
    run = on_grid(run)
    interval = read_interval(run.header)
    times = reference.columns["time"]
    rows = np.rint(times / interval).astype(int)
    there = (rows < len(run.columns["time"]))
    there[there] = np.abs(run.columns["time"][rows[there]] - times[there]) < 1e-6 * interval
    moves = [Move("rows without a counterpart", float(np.count_nonzero(~there)), 0.0,
                  f", the first at t = {times[~there][0]:.6g} s")] if not np.all(there) else []
    if list(run.columns) != list(reference.columns):
        return [*moves, Move("columns", float(len(set(run.columns) ^ set(reference.columns))), 0.0)]
    found = {n: x[rows[there]] for n, x in run.columns.items()}
    moves += [compare_column(name, reference, found, there) for name in reference.columns]
    facts = read_facts(run.summary + run.header)
    for what, (value, tolerance) in reference.facts.items():
        if np.isfinite(tolerance):
            by = abs(facts[what] - value) if what in facts else np.inf
            moves.append(Move(what, by, tolerance, f" = {facts.get(what, 'none')}, was {value:.9g},"))
    if read_ending(run.summary) != reference.ending:
        moves.append(Move("the end", np.inf, 0.0, f" ({read_ending(run.summary)}, was {reference.ending})"))
    return moves


def compare_column(name: str, reference: Reference, found: Columns, there: np.ndarray) -> Move:
    expected, tolerance = reference.columns[name][there], reference.tolerances[name][there]
    by = np.abs(found[name] - expected)
    if np.isnan(by).any():
        by[np.isnan(found[name]) & np.isnan(expected)] = 0
        # A contact that is open in one of the two only: no matter if its force is within the tolerance.
        force = f"N_{name[-2:]}"
        light = np.maximum(found[force], reference.columns[force][there]) <= reference.tolerances[force][there]
        by[np.isnan(by)] = np.where(light[np.isnan(by)], 0, np.inf)
    share = np.divide(by, tolerance, out=np.where(by > 0, np.inf, 0.0), where=tolerance > 0)
    share[np.isinf(tolerance)] = 0
    k = int(np.argmax(share))
    unit, time = reference.units[name], found["time"][k]
    return Move(name, float(by[k]), float(tolerance[k]), f" [{unit}] at t = {time:.6g} s")


RIGID_FILE = FOLDER / "formulations.csv"
RIGID = {name: changes for name, changes in formulations.FORMULATIONS.items() if changes}
RIGID_COLUMNS = "Y", "Z", "roll", "vY", "P_LF"
INSTANTS = 12
RIGID_DIGIT, RIGID_LIMIT = 1e-9, 1e-4
# Largest energy drift of exercise 5 up to its end, of the work.
DRIFTS = {"bilateral": 1e-10, "unilateral, e = 1": 1e-12, "unilateral, e = 0.5": 1e-9, "unilateral, e = 0": 1e-9}
RIGID_CASES = [(case, name, "motion") for case in CASES for name in RIGID] + [
    (case, name, "end") for case in CASES if case.startswith("ex5") for name in RIGID]


@functools.cache
def rigid_run(case: str, formulation: str, part: str, aside: float = 0.0) -> ldbench.Run:
    """A motion with rigid contacts, begun with another lateral velocity [m/s]; part: 'motion', 'end' of exercise 5."""
    made = Case.exercise(int(case[2]), case[-2:]).replace(**RIGID[formulation], rows="interval")
    if part == "end":
        made = made.replace(interval=5e-3)
    elif case.startswith("ex5"):
        made = made.replace(t_end=1.0, interval=1e-3)
    return ldbench.run(made.replace(vY=made.vY + aside))


def instants(done: ldbench.Run, times: Sequence[float]) -> dict[str, float]:
    c = done.data
    rows = np.searchsorted(c.time, np.array(times) - 1e-9)
    return {f"{name} at {t:.10g} s": float(c[name].iloc[k]) for t, k in zip(times, rows, strict=True) if k < len(c)
            for name in RIGID_COLUMNS}


def end_of(done: ldbench.Run) -> dict[str, float]:
    """First events and the last one, with the lateral force then; what impacts have cost."""
    found: dict[str, float] = {}
    for event in done.events:
        if event.kind in ("left flange contact", "right wheel lift-off", "rail pulls", "derailment"):
            found.setdefault(f"{event.kind} [s]", event.t)
            found.setdefault(f"{event.kind}, lateral force [N]", event.force)
    c = done.data
    if done.case.restitution < 1:
        found["energy lost [J]"] = float(c.E_lost.iloc[-1])
    if done.case.formulation == "bilateral":
        found["least Y of the last second [m]"] = float(c.Y[c.time > c.time.iloc[-1] - 1].min())
    return found


def rigid_reference(case: str, formulation: str, part: str) -> list[tuple[str, str, str, str, float, float]]:
    """Numbers of a rigid motion, and how far each may move; inf: not compared."""
    done = rigid_run(case, formulation, part)
    change = 1e-12 if case.startswith("ex5") else 1e-10*done.case.vY
    runs = [done, *(rigid_run(case, formulation, part, aside) for aside in (change, -change))]
    if part == "end":
        own, *others = map(end_of, runs)
    else:
        times = done.data.time.iloc[np.linspace(0, len(done.data) - 1, INSTANTS + 1).astype(int)[1:]].tolist()
        own, *others = (instants(run, times) for run in runs)
    scale, moved, found = {}, {}, []
    for what, x in own.items():
        of = what.partition(" at ")[0]
        scale[of] = max(scale.get(of, 0.0), abs(x))
    for what, x in own.items():
        of = what.partition(" at ")[0]
        moved[of] = max(moved.get(of, 0.0), *(abs(other.get(what, np.inf) - x) for other in others))
        known = part == "end" or AMPLIFICATION*moved[of] < RIGID_LIMIT*max(scale[of], 1e-3)
        found.append((case, formulation, part, what, x,
                      RIGID_DIGIT*max(scale[of], 1) + AMPLIFICATION*moved[of] if known else np.inf))
    return found


@functools.cache
def rigid_stored() -> pd.DataFrame:
    return pd.read_csv(RIGID_FILE)


def rigid_moves(case: str, formulation: str, part: str) -> list[str]:
    """What is out of tolerance in a rigid motion, in words."""
    stored = rigid_stored()
    own = stored[(stored.case == case) & (stored.formulation == formulation) & (stored.part == part)]
    done = rigid_run(case, formulation, part)
    now = end_of(done) if part == "end" else instants(done, sorted({float(what.split()[-2]) for what in own.quantity}))
    assert len(own) and set(now) <= set(own.quantity), f"{case}, {formulation}: not in {RIGID_FILE.name}"
    return [f"{case}, {formulation}: {row.quantity}: expected {row.value:.12g} within {row['may move']:.1g}, "
            f"found {now.get(row.quantity, np.nan):.12g}" for _, row in own.iterrows()
            if np.isfinite(row["may move"]) and not abs(now.get(row.quantity, np.nan) - row.value) <= row["may move"]]


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def read_now(case: str, *change: Callable[[str], str]) -> Run:
            """A run in memory: the next one of the case replaces its file."""
            run = run_shipped(case, folder, *change)
            assert run.header and run.columns
            return run

        def run_all(case: str) -> tuple[Run, list[Run]]:
            return read_now(case), [read_now(case, change) for change in perturbations(case)]

        for case, (run, others) in for_all_cases(run_all).items():
            if (FOLDER / f"{case}.txt").exists():
                moves = compare(read(case), run)
                beyond = sorted((move for move in moves if move.share > 1), key=lambda move: -move.share)
                print(*(f"{case}: {move}" for move in beyond), sep="\n", end="\n" if beyond else "")
                print(f"{case}: {len(moves) - len(beyond)} columns, events and peaks within tolerance")
            write(case, make(run, others))
    with ThreadPoolExecutor(2) as pool:
        if RIGID_FILE.exists():
            for lines in pool.map(rigid_moves, *zip(*RIGID_CASES, strict=True)):
                print(*lines, sep="\n", end="\n" if lines else "")
        rows = [row for found in pool.map(rigid_reference, *zip(*RIGID_CASES, strict=True)) for row in found]
    with complete(RIGID_FILE) as scratch:
        pd.DataFrame(rows, columns=["case", "formulation", "part", "quantity", "value", "may move"]).to_csv(
            scratch, index=False, float_format="%.12g")
    print(f"stored in {FOLDER}")


if __name__ == "__main__":
    main()
