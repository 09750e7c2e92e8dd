"""Measured results of the program, in one file: docs/measured.json. The pages of the documentation quote from it.

    python docs/measure.py report       from the files that `make report` has left in outputs/
    python docs/measure.py validate     from the files that `make validate` has left in outputs/
    python docs/measure.py variants     runs other laws and accuracies, and writes a page; some minutes
    python docs/measure.py bodies       runs exercises 1 to 4 with the shipped bodies of wheel and rail; a minute
    python docs/measure.py times        solves what exercise 5 needs, runs the ten cases: processor times
    python docs/measure.py disk         what ./bootstrap and make have left on the disk
    python docs/measure.py              does all of these

A result is stored under a name that ends with the unit of its value. On a page a number is followed by a comment with the
name of the result, and tables are made from the results:

    The largest energy error is 2.4e-8<!-- drift.free [J] --> J.

`python docs/make_tables.py` writes the numbers of docs/measured.json into the pages, with as many digits as the pages
show. A test checks that the pages have them, and that the results of `make report` are those of the program.
"""
from __future__ import annotations

import csv
import json
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import ldbench
from ldbench import Case, ContactInterval, ContactTable, bodies, view
from ldbench._core.files import complete
from ldbench._core.kept import kept_in
from ldbench.report import formulations
from ldbench.results.run_data import RunData, read_data
from ldbench.results.summary import summary_row
from ldbench.results.twins import TWINS, spreads
from quotes import BODIES, CAUSES, ENDS

ROOT = Path(__file__).resolve().parents[1]
OUTPUTS = ROOT/"outputs"
FILE = ROOT/"docs/measured.json"
PAIRS = "aw", "sw"
PLACES = "tread", "flange", "both", "going over"
CASES = [f"ex{exercise}_{pair}" for exercise in (1, 2, 3, 4, 5) for pair in PAIRS]
ACCURACIES = 1e-3, 2e-3, 3e-3, 4e-3, 8e-3       # of contact tables, whose effect on results is measured
DIGITS = 6                                      # of the stored values

Values = dict[str, float]
COMMANDS = {"report": "make report", "validate": "make validate", "variants": "python docs/measure.py variants",
            "bodies": "python docs/measure.py bodies", "times": "python docs/measure.py times", "disk": "./bootstrap, make"}


def megabytes(files: Iterable[Path]) -> float:
    """The size of files [MB]."""
    return sum(file.stat().st_size for file in files)/1e6


# make report ------------------------------------------------------------------------------

def of_report() -> Values:
    """Results of the ten runs and of the formulations, and the sizes of files."""
    runs = [read_data(OUTPUTS/f"{case}.txt") for case in CASES]
    values = of_runs(runs, {run.name: json.loads((kept_in(OUTPUTS)/f"{run.name}_twins.json").read_text()) for run in runs})
    kept = json.loads(formulations.kept_file(OUTPUTS).read_text())
    values |= of_formulations([formulations.Outcome(**outcome) for outcome in kept])

    products = "ldbench_plots.pdf", "ldbench_extras.pdf", "ldbench_abstract.pdf", "ldbench_results.html", "summary.csv"
    values["size.report [MB]"] = megabytes([
        *(OUTPUTS/f"{case}.txt" for case in CASES), *(OUTPUTS/"tables").iterdir(), *(OUTPUTS/name for name in products),
        *(file for file in formulations.kept_file(OUTPUTS).parent.iterdir() if file.suffix != ".stamp")])
    values["size.ex5 [MB]"] = megabytes(OUTPUTS.glob("ex5_?w.txt"))
    values["size.ex5_aw [MB]"] = megabytes([OUTPUTS/"ex5_aw.txt"])
    return values


def of_runs(runs: Iterable[RunData], twins: Mapping[str, Sequence[Mapping[str, Any]]]) -> Values:
    """Results of the ten runs; of what the twins of a run do not share median, least, largest and how many have it."""
    values: Values = {}
    rows = {run.name: summary_row(run) for run in runs}
    for name, row in rows.items():
        for key, unit in ("drift", "J"), ("drift_reference", "J"):
            values[f"{key}.{name} [{unit}]"] = row[key]
        values[f"drift_relative.{name}"] = row["drift_relative"]
    free = [row for row in rows.values() if row["exercise"] < 5]
    values["drift.free [J]"] = max(row["drift"] for row in free)
    values["drift_relative.free"] = max(row["drift_relative"] for row in free)
    values["drift_relative.ramp"] = max(row["drift_relative"] for row in rows.values() if row["exercise"] == 5)
    for run in runs:
        name, row, pair = run.name, rows[run.name], run.name[-2:]
        values |= {f"first.{name}.{what}": scale*row[f"{key}_LF"] for what, key, scale in (
            ("t [ms]", "t_first", 1e3), ("peak [kN]", "first_peak_N", 1e-3), ("duration [ms]", "first_duration", 1e3),
            ("impulse [N s]", "first_impulse", 1.0))}
        key, unit, of, scale = ("t_return", "ms", name, 1e3) if run.exercise < 5 else ("F_derailment", "kN", pair, 1e-3)
        parted = spreads(row, twins.get(name, ())).get(key)
        if parted:
            values |= {f"{key}.{of}.{end} [{unit}]": scale*getattr(parted, end) for end in ENDS}
            values[f"{key}.{of}.having"] = parted.having
        else:
            values[f"{key}.{of} [{unit}]"] = scale*row[key]
        if run.exercise < 5:
            values |= {f"pmax.{name}.{row['pmax_contact']} [GPa]": 1e-9*row["pmax"], f"t_pmax.{name} [ms]": 1e3*row["t_pmax"]}
    return values | {"twins": len(TWINS)}


def of_formulations(found: list[formulations.Outcome]) -> Values:
    """How the results depend on the formulation."""
    values: Values = {}

    def spreads(key: str) -> list[float]:
        cases = dict.fromkeys(outcome.case for outcome in found)
        some = [formulations.spread({o.formulation: o.results[key] for o in found if o.case == case}) for case in cases]
        return [100*x for x in some if np.isfinite(x)]

    values["formulation.t_first_LF.largest [%]"] = max(spreads("t_first_LF"))
    values["formulation.first_impulse.least [%]"] = min(spreads("turn_impulse_LF"))
    values["formulation.first_impulse.largest [%]"] = max(spreads("turn_impulse_LF"))
    forces = []
    for outcome in found:
        if outcome.exercise == 5 and outcome.formulation == "bilateral":
            values[f"F_pulls.{outcome.pair} [kN]"] = 1e-3*outcome.results["F_pulls"]
        elif outcome.exercise == 5:
            forces.append(1e-3*outcome.results["F_derailment"])
    values["formulation.F_derailment.least [kN]"], values["formulation.F_derailment.largest [kN]"] = min(forces), max(forces)
    return values


# make validate ----------------------------------------------------------------------------

def of_validation() -> Values:
    """Results of the validation."""
    values: Values = {}
    sections = json.loads((OUTPUTS/"validation.json").read_text())
    with (OUTPUTS/"validation.csv").open(newline="") as file:
        checks = list(csv.DictReader(file))

    def rows(section: str, title: str) -> list[dict[str, str]]:
        """The rows of a table by the names of its columns; a name that returns belongs to the column before it."""
        head, *found = next(table for name, table in sections[section].items() if name.startswith(title))
        names = [head[k - 1].replace("rms", name) if head.count(name) > 1 else name for k, name in enumerate(head)]
        return [dict(zip(names, row, strict=True)) for row in found]

    for row in rows("models", "Deviation of a wheel's force"):
        name = f"law.{row['profiles']}.{row['contact'].partition(' (')[0]}.{row['model']}"
        values |= {f"{name}.rms [%]": float(row["rms"]), f"{name}.largest [%]": float(row["largest"])}
    for row in rows("models", "Errors that runs state"):
        for place in PLACES:
            for kind in ("rms", "largest") if row[f"{place}: rms"] else ():
                values[f"table.{row['model']}.{row['profiles']}.{place}.{kind} [%]"] = 100*float(row[f"{place}: {kind}"])
    for row in rows("models", "What the model of influence changes"):
        name = f"influence.{row['case']}.{row['influence']}"
        values[f"{name}.first LF [kN]"] = float(row["first peak LF [kN]"])
    for row in rows("linear", "Frequencies [Hz]"):
        values[f"frequency.{row['pair']}.{row['mode']}.closed form [Hz]"] = float(row["closed form, Hertz"])
    for row in rows("quasistatic", "Limit of equilibrium"):
        pair, kind = row["pair"].split(", ")
        values[f"F_limit.{pair}.{kind} [kN]"] = float(row["F [kN]"])
        values[f"angle_limit.{pair}.{kind} [deg]"] = float(row["contact angle [deg]"])
        if kind == "rigid":
            values |= {f"b_c.{pair} [mm]": float(row["b [mm]"]), f"h_c.{pair} [mm]": float(row["h [mm]"])}
    values |= of_unknown_profiles(rows("unknown", "How far the numbers move"))
    values["F_limit.difference [%]"] = max(
        100*abs(values[f"F_limit.{pair}.elastic [kN]"]/values[f"F_limit.{pair}.rigid [kN]"] - 1) for pair in PAIRS)
    deviations = {row["case"]: float(row["Y, largest [m]"]) for row in rows("integration", "Deviation of the core")}
    values["integration.ex3_sw.largest [m]"] = deviations["ex3_sw"]
    values["integration.free.largest [m]"] = max(deviations[case] for case in CASES[:8] if case != "ex3_sw")
    for check in checks:
        quantity, deviation = check["quantity"], float(check["deviation"])
        if check["section"] == "linear" and quantity.endswith("halfspace"):
            values[f"frequency.{quantity.split()[-2].strip(',')}.{quantity.split()[0]}.halfspace [Hz]"] = float(check["value"])
        elif check["section"] == "halfspace" and quantity.split(":")[0] in ("cone", "r^4"):
            name = f"halfspace.{quantity.split(':')[0]} [%]"
            values[name] = max(values.get(name, 0), 100*deviation)
    values["halfspace.ellipses [%]"] = max(abs(float(cell)) for row in rows("halfspace", "Deviation from Hertz")
                                           for name, cell in row.items() if "semi-axes" not in name)
    values["checks.all"] = len(checks)
    return values


def of_unknown_profiles(rows: Iterable[dict[str, str]]) -> Values:
    """How far other wheels and other arcs move the answers [%], least and largest change of each group."""
    values: Values = {}
    for row in rows:
        exercise, _, answer = row["actual profiles"].partition(": ")
        name = {"first": "contact", "peak": "peak", "lateral": "force"}.get(answer.split()[0])
        for group, cell in (list(row.items())[2:] if name else ()):
            span, _, note = cell.partition(" (")
            least, _, largest = span.partition(" to ")
            if "without contact" in note:
                values[f"unknown.{exercise}.{name}.{group}.without contact"] = float(note.split()[0])
            values[f"unknown.{exercise}.{name}.{group}.least [%]"] = float(least)
            values[f"unknown.{exercise}.{name}.{group}.largest [%]"] = float(largest or least)

    peaks = [x for key, x in values.items() if key.split(".")[2] == "peak" and "ex5" not in key and "[%]" in key]
    return values | {"unknown.peak.fall [%]": -min(peaks), "unknown.peak.rise [%]": max(peaks)}


# Runs of this program ---------------------------------------------------------------------

def of_variants() -> Values:
    """Results with other laws and accuracies, and the size of a page."""
    values: Values = {}
    second = Case.exercise(2, "aw").replace(table_folder="")
    for model in "halfspace", "strip", "hertz":
        row = summary_row(ldbench.run(second.replace(model=model)))
        values[f"t_return.ex2_aw.{model} [ms]"] = 1e3*row["t_return"]
        values[f"drift.ex2_aw.{model} [J]"] = row["drift"]
    values["drift.ex2_aw.coarse strip [J]"] = ldbench.run(second.replace(model="strip", accuracy=0.06)).results["drift"]
    values |= of_causes((1, 2, 3, 4))
    for exercise, peaks in of_accuracies((1, 2, 3, 4)).items():
        values[f"accuracies.ex{exercise}.spread [%]"] = 100*(max(peaks)/min(peaks) - 1)
    climb = formulations.climb(Case.exercise(4, "aw")).data
    values["climb.aw [J]"] = float((climb.PE_grav + climb.PE_load).max())
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder)/"ex5_aw.html"
        view(OUTPUTS/"ex5_aw.txt").write(page)
        values["page.ex5_aw [MB]"] = page.stat().st_size/1e6
    return values


def of_accuracies(exercises: Iterable[int]) -> dict[int, list[float]]:
    """First peaks of the left flange force [N] with tables of several accuracies."""
    peaks: dict[int, list[float]] = {exercise: [] for exercise in exercises}
    for accuracy in ACCURACIES:
        table = ContactTable(Case.exercise(1, "aw").replace(table_folder="", accuracy=accuracy))
        for exercise, found in peaks.items():
            case = Case.exercise(exercise, "aw").replace(table_folder="", accuracy=accuracy)
            found.append(first_contact(case, table.for_case(case)).peak)
    return peaks


def of_causes(exercises: Iterable[int]) -> Values:
    """How causes of differences between codes change the first contact of the left flange (aw)."""
    shipped = {exercise: Case.exercise(exercise, "aw").replace(table_folder="") for exercise in exercises}
    table = ContactTable(shipped[1].replace(table_folder=str(OUTPUTS/"tables")))
    first = {exercise: first_contact(case, table.for_case(case)) for exercise, case in shipped.items()}
    values: Values = {}
    for name, (_, changes) in CAUSES.items():
        other = table
        if not {"model", "influence", "youngs_modulus"}.isdisjoint(changes):   # a table depends on the law and the material alone
            other = ContactTable(shipped[1].replace(changes))
        for exercise, case in shipped.items():
            changed = case.replace({key: value*case.vY if key == "vY" else value for key, value in changes.items()})
            contact = first_contact(changed, other.for_case(changed))
            for what in "peak", "duration", "impulse":
                values[f"cause.{name}.{what}.ex{exercise} [%]"] = 100*(getattr(contact, what)/getattr(first[exercise], what) - 1)
    return values


def of_bodies() -> Values:
    """How the bodies' own elasticity changes the first contact of the left flange; what wheel and rail do alone in one case."""
    values: Values = {}
    for pair in PAIRS:
        cases = [Case.exercise(exercise, pair).replace(table_folder="") for exercise in (1, 2, 3, 4)]
        table = ContactTable(cases[0])
        first = [first_contact(case, table.for_case(case)) for case in cases]
        for support, file in BODIES.items():
            changed = [case.replace(influence="bodies", bodies=ROOT/file.format(pair)) for case in cases]
            table = ContactTable(changed[0])
            for exercise, case in enumerate(changed, 1):
                values |= of_changed(f"bodies.ex{exercise}_{pair}.{support}", first[exercise - 1],
                                     first_contact(case, table.for_case(case)))
        if pair == "aw":
            for only in "wheel", "rail":
                with tempfile.TemporaryDirectory() as folder:
                    bodies.write(Path(folder)/"one.bodies", bodies.find(cases[1], kinds=(only,)))
                    case = cases[1].replace(influence="bodies", bodies=Path(folder)/"one.bodies")
                    values |= of_changed(f"bodies.ex2_aw.{only} alone", first[1], first_contact(case, ContactTable(case)))
    peaks = [x for name, x in values.items() if name.endswith("peak [%]") and "alone" not in name]
    return values | {"bodies.peak.least [%]": min(peaks), "bodies.peak.largest [%]": max(peaks)}


def of_changed(name: str, own: ContactInterval, other: ContactInterval) -> Values:
    """Changes of a first contact [%]."""
    return {f"{name}.{what} [%]": 100*(getattr(other, what)/getattr(own, what) - 1) for what in ("peak", "duration", "impulse")}


def first_contact(case: Case, table: ContactTable) -> ContactInterval:
    """The first contact of the left flange, by the rows."""
    return ldbench.run(case, table=table).first_interval("LF")


def of_times() -> Values:
    """Processor times [s] of what exercise 5 solves for its table, and of the ten runs with all that solved, without files."""
    tables = {pair: ContactTable(Case.exercise(1, pair).replace(table_folder="")) for pair in PAIRS}
    cases = [Case.exercise(int(name[2]), name[-2:]).replace(table_folder="") for name in CASES]
    for _ in range(2):                  # the first time they solve what they need
        seconds = sum(ldbench.run(case, table=tables[case.case_name[-2:]].for_case(case)).seconds for case in cases)
    nothing = Case.exercise(5, "aw").replace(table_folder="")
    once, again = ldbench.run(nothing), ldbench.run(nothing, table=tables["aw"].for_case(nothing))
    return {"time.table [s]": once.seconds - again.seconds, "time.runs [s]": seconds}


def of_disk() -> Values:
    """What the virtual environment and the build take."""
    def inside(folder: str, but: str = "") -> float:
        return megabytes(file for file in (ROOT/folder).rglob("*") if file.is_file() and not file.is_symlink()
                         and not (but and file.is_relative_to(ROOT/but)))

    return {"size.venv [MB]": inside(".venv"),
            "size.build [MB]": inside("build/release", "build/release/tests") + inside("build/wrapper")}


GROUPS: dict[str, Callable[[], Values]] = {
    "report": of_report, "validate": of_validation, "variants": of_variants, "bodies": of_bodies, "times": of_times,
    "disk": of_disk}


# The file ---------------------------------------------------------------------------------

def measured() -> dict[str, Any]:
    """The file of measured results: by group the command and the values."""
    return json.loads(FILE.read_text()) if FILE.exists() else {}


def main(groups: list[str]) -> int:
    if unknown := set(groups) - GROUPS.keys():
        print(f"docs: expected groups of {', '.join(GROUPS)}, found {', '.join(sorted(unknown))}", file=sys.stderr)
        return 1
    known = measured()
    for group in groups or GROUPS:
        values = GROUPS[group]()
        values = {name: float(f"{value:.{DIGITS}g}") for name, value in values.items()}
        known[group] = {"command": COMMANDS[group], "values": dict(sorted(values.items()))}
        print(f"{group}: {len(values)} results")
    with complete(FILE) as scratch:
        scratch.write_text(json.dumps({group: known[group] for group in GROUPS if group in known}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
