"""Stored answers: outputs of the ten shipped inputs, of a case with unlike sides and of a steeper exercise 5, and motions of the
rigid formulations.

`make reference` runs all cases, says what moved, and replaces the references; tests say it too, and replace nothing.

outputs/reference has two files per case, which read like any column file: <case>.txt, rows of the run, with the results of its
header before them; <case>_tolerance.txt, how far each of these numbers may move, inf where it is not compared.

Tolerances. Another compiler rounds differently; impacts amplify that. How much is measured: the run is repeated with its
initial lateral velocity changed by 1e-10 of itself to either side (exercise 5, which starts at rest: by up to 4e-12 m/s), and
the largest deviation up to a row's time is the amplification there. Fused multiply-add instructions in the whole program move
exercises 1 to 4 by less than a tenth of that, exercise 5 by up to twice that. A number may move by

    a written digit  +  1e-7 of the column's range (all energies have one)  +  10 times that deviation

and is compared while the last term is less than 1e-3 of the range. Exercise 5 is chaotic from its first bounces on the flange:
its rows end there, and the range is that of these rows.

Results are all numbers of &setup and &results in the header, and two words; the k-th event of a kind is `kind k`. They are those of
the whole run. Their tolerances are of the same kind, with a share of the number by its quantity, SHARES, in the place of the range:
a time may move by a tenth of a step, the end by a row, counts of steps by half a percent and twice what they scatter by. Where
results are chaotic they are compared as a statistic, mean of nine runs +- their 99.9 % prediction interval, if that says anything.

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
from golden import steeper, unlike
from ldbench import Case
from ldbench._core.files import complete
from ldbench.report import formulations
from running import CASES, REPO, Columns, Run, columns, header, on_grid, read_interval, run_shipped

FOLDER = REPO / "outputs/reference"
ROWS = 100
RELATIVE = 1e-7        # of a column's range
WRITTEN = 1e-8         # of a number, the last digit of a column file
AMPLIFICATION = 10     # times the deviation of the perturbed runs
LIMIT = 1e-3           # of a column's range or a fact's value; a looser tolerance is none
STATISTIC = 9          # runs that make one
PREDICTION = 5.3       # its interval in standard deviations: Student's t for 99.9 %, 5.04, times sqrt(1 + 1/9)
LOOSEST = 0.5          # of a statistic's mean
# Shares of a result that it may move by, by its unit, or by its name where that says more.
SHARES = {"N": 1e-6, "N s": 1e-6, "Pa": 1e-5, "m2": 1e-4, "m": 1e-6, "rad": 1e-6, "Hz": 1e-6, "J": 1e-6, "": 1e-6}
FLOORS = {"m": 1e-10, "rad": 1e-9}      # of these tolerances
OWN_SHARES = {"step": 1e-6, "drift": 0.3, "drift_relative": 0.3, "t_drift": np.inf,
              **{f"table_error_{place}": 0.1 for place in ("tread", "flange", "both", "going_over")}}
STEPS = "steps", "cuts", "missed", "evaluations", "rows"
STEPS_SHARE = 5e-3     # of the steps, of evaluations and rows of themselves
STEP_SHARE = 0.1       # of a step: times
# Counts of steps, and sums of rounding errors, are no motion that impacts amplify: they scatter.
UNSTEADY = {*STEPS, *OWN_SHARES}
UNSTEADY_TIMES = 2     # the scatter of the perturbed runs
SCATTER = 3            # times the value; looser tolerances are none
WORDS = "end", "pmax_contact"       # results that are no numbers

UNLIKE = "ex3_unlike"
STEEP = {f"{case}_steep": case for case in CASES if case.startswith("ex5")}
STORED = [*CASES, UNLIKE, *STEEP]


@dataclass
class Reference:
    columns: Columns                               # rows of the run
    tolerances: Columns                            # of the same rows
    units: dict[str, str]
    facts: dict[str, tuple[float, float]]          # results: value, tolerance
    words: dict[str, str]                          # results that are words; '' where they are not compared


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
    """The numbers of &setup and &results in a column file's header, by name and unit."""
    found: dict[str, float] = {}
    seen: dict[str, int] = {}
    blocks = re.findall(r"^&(?:setup|results)\n(.*?)^/$", text, flags=re.M | re.S)
    assert len(blocks) == 2, "no &setup and &results"
    for line in "".join(blocks).splitlines():
        if "event(" in line:
            own = {name: value.strip("'") for name, value in re.findall(r"event\(\d+\)%(\w+) = ('[^']*'|[^,\s]+)", line)}
            kind = own.pop("kind")
            seen[kind] = seen.get(kind, 0) + 1
            units = {"t": "s", "angle": "rad", "force": "N"}
            found |= {f"{kind} {seen[kind]}, {name} [{units.get(name, 'N s')}]": float(value)
                      for name, value in own.items() if name != "cause"}
            continue
        name, values, unit = re.fullmatch(r" *(\w+) = ('[^']*'|[^!]*?) *(?:! ([^,]*).*)?", line).groups()
        if not values.startswith("'"):
            numbers = values.split(",")
            found |= {f"{name}{f' {k}' if len(numbers) > 1 else ''} [{unit or ''}]": float(value)
                      for k, value in enumerate(numbers, 1)}
    return found


def read_words(text: str) -> dict[str, str]:
    return {name: word for name, word in re.findall(r"^ *(\w+) = '(.*)'$", text[text.index("&results"):], flags=re.M)
            if name in WORDS}


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


def fact_tolerance(what: str, value: float, others: list[float | None], resolution: float) -> tuple[float, float]:
    """The value to compare with, and by how much it may differ."""
    if None in others:
        return value, np.inf
    deviation = max(abs(other - value) for other in others)
    if name_of(what) in UNSTEADY:
        tolerance = resolution + UNSTEADY_TIMES*deviation
        return value, tolerance if tolerance <= SCATTER*abs(value) or not deviation else np.inf
    if AMPLIFICATION*deviation <= LIMIT*abs(value):
        return value, resolution + AMPLIFICATION*deviation
    sample = [value, *others]
    mean, tolerance = float(f"{np.mean(sample):.9g}"), resolution + PREDICTION*float(np.std(sample, ddof=1))
    return (mean, tolerance) if len(sample) == STATISTIC and tolerance < LOOSEST*abs(mean) else (value, np.inf)


def name_of(what: str) -> str:
    """The name of a result that is stored with a number and a unit behind it."""
    return what.partition(" ")[0]


def resolution(what: str, value: float, facts: dict[str, float], run: Run) -> float:
    """By how much a fact may move that no impact amplifies."""
    name, unit = name_of(what), what.removesuffix("]").partition(" [")[2]
    if name in STEPS:
        return STEPS_SHARE*facts[f"{name if name in ('evaluations', 'rows') else 'steps'} []"]
    if name in OWN_SHARES:
        return OWN_SHARES[name]*abs(value)
    if unit == "s":
        return read_interval(run.header) if name == "t" else STEP_SHARE*facts["step [s]"]
    return 0.0 if name.startswith("n_") else max(SHARES[unit]*abs(value), FLOORS.get(unit, 0.0))


def make(run: Run, others: list[Run]) -> Reference:
    """A run, and what became of it with the initial conditions perturbed."""
    run, *others = (on_grid(done) for done in (run, *others))
    found = [other.columns for other in others]
    unit_line = next(words for line in run.header.splitlines() if (words := line.split())[:2] == ["s", "m"])
    units = dict(zip(run.columns, unit_line, strict=True))
    rows = reproducible_rows(run.columns, found, units)
    kept = np.unique(np.linspace(0, len(run.columns["time"][rows]) - 1, ROWS).astype(int))
    facts, *other_facts = (read_facts(done.header) for done in (run, *others))
    words, *other_words = (read_words(done.header) for done in (run, *others))
    return Reference(
        {name: values[kept] for name, values in run.columns.items()},
        {name: column_tolerance(run.columns, found, units, name, rows)[kept] for name in run.columns},
        units,
        {what: fact_tolerance(what, value, [own.get(what) for own in other_facts], resolution(what, value, facts, run))
         for what, value in facts.items()},
        {name: word if all(own.get(name) == word for own in other_words) else "" for name, word in words.items()})


def write(case: str, reference: Reference, folder: Path = FOLDER) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    names = "".join(f"{name:>16}" for name in reference.columns) + "\n"
    units = "#" + "".join(f"{unit:>16}" for unit in reference.units.values())[1:] + "\n"
    facts = "".join(f"# {what} = {value!r} +- {tolerance:.2g}\n"
                    for what, (value, tolerance) in reference.facts.items())
    with complete(folder / f"{case}.txt") as scratch, open(scratch, "w") as file:
        file.write(f"{names}# {case}: reference rows, see tests/reference.py\n")
        file.write(facts + "".join(f"# {name} = '{word}'\n" for name, word in reference.words.items()) + units)
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
                     facts, dict(re.findall(r"^(\w+) = '(.*)'$", text, flags=re.M)))


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
    facts = read_facts(run.header)
    for what, (value, tolerance) in reference.facts.items():
        if np.isfinite(tolerance):
            by = abs(facts[what] - value) if what in facts else np.inf
            moves.append(Move(what, by, tolerance, f" = {facts.get(what, 'none')}, was {value:.9g},"))
    new = [what for what in facts if what not in reference.facts]
    moves += [Move(what, np.inf, 0.0, f" = {facts[what]}, was none,") for what in new if not chaotic_count(what, reference)]
    words = read_words(run.header)
    return moves + [Move(name, np.inf, 0.0, f" = '{words.get(name)}', was '{word}',") for name, word in reference.words.items()
                    if word and words.get(name) != word]


def chaotic_count(what: str, reference: Reference) -> bool:
    """Whether a result that the reference lacks is of an event of a kind whose number is not compared exactly."""
    kind = re.sub(r" \d+, \w+ \[.*\]$", "", what)
    return reference.facts.get(f"n_{re.sub('[ -]', '_', kind)} []", (0.0, 0.0))[1] > 0


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


def stored_input(name: str) -> tuple[str, Callable[[str], str]]:
    """The shipped input of a stored case, and how its text is changed."""
    return ("ex3_aw", unlike) if name == UNLIKE else (STEEP[name], steeper) if name in STEEP else (name, lambda text: text)


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        def run_all(case: str) -> tuple[Run, list[Run]]:
            shipped, change = stored_input(case)
            folder = Path(name)/case
            folder.mkdir()

            def read_now(perturb: Callable[[str], str]) -> Run:
                """A run in memory: the next one of the case replaces its file."""
                run = run_shipped(shipped, folder, lambda text: perturb(change(text)))
                assert run.header and run.columns
                return run

            return read_now(lambda text: text), [read_now(perturb) for perturb in perturbations(case)]

        for case in STORED:
            run, others = run_all(case)
            if (FOLDER / f"{case}.txt").exists():
                moves = compare(read(case), run)
                beyond = sorted((move for move in moves if move.share > 1), key=lambda move: -move.share)
                print(*(f"{case}: {move}" for move in beyond), sep="\n", end="\n" if beyond else "")
                print(f"{case}: {len(moves) - len(beyond)} columns and results within tolerance")
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
