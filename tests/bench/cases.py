"""What the ten cases cost as a user runs them: wall time, table, files, memory."""
from __future__ import annotations

import shutil
import tempfile
import time
from pathlib import Path

import numpy as np

import ldbench
from evaluation import absolute
from ldbench import Case, ContactTable
from measure import Section, measure, ratio
from programs import resources
from running import CASES, LDBENCH, REPO
from sheets import Table

MODELS = "strip", "hertz", "halfspace"      # the first is what the others' tables are compared with
THREADS = 1, 2

TEXT = """Every shipped input by the executable, as a child process, its contact table there in a file: wall and
processor time from start to exit with all files written, and peak resident memory. Table: built by the
executable for each model of normal contact, with one thread and with two, in a run that ends at once. Python: the same
from a namelist to a file, modules loaded. Writing: the column file of a run that is there, apart from its integration."""


def child(case: str, folder: Path) -> tuple[float, float, float]:
    """Run a shipped input with its files in `folder`."""
    namelist = folder/f"{case}.nml"
    text = (REPO/"inputs"/namelist.name).read_text()
    namelist.write_text(text.replace("'outputs/", f"'{folder}/").replace("'profiles/", f"'{REPO}/profiles/"))
    return resources([str(LDBENCH), str(namelist)], folder)


def case_measures(out: Section, names: list[str], rounds: int) -> None:
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for pair in sorted({case[-2:] for case in names}):
            table = Path(ContactTable(Case.exercise(1, pair)).case.table_path())
            shutil.copy(table, folder)
        found = np.array([[child(case, folder) for case in names] for _ in range(rounds)])
    for case, samples in zip(names, found.transpose(1, 2, 0), strict=True):
        measures = [measure(case, "executable", quantity, unit, values) for (quantity, unit), values in zip(
            (("wall time", "s"), ("processor time", "s"), ("peak memory", "MB")), samples, strict=True)]
        out.measures += measures
        rows.append([case, *(m.text() for m in measures)])
    totals = found.sum(axis=1)
    total = measure("all cases", "executable", "wall time", "s", totals[:, 0], f"{len(names)} cases, one after the other", True)
    out.measures.append(total)
    rows.append(["together", total.text(), measure("", "", "", "s", totals[:, 1]).text(), ""])
    out.tables.append(Table("The cases by the executable: median (quartiles)",
                            ["case", "wall time [s]", "processor time [s]", "peak memory [MB]"], rows))


def table_measures(out: Section, pairs: tuple[str, ...], models: tuple[str, ...], rounds: int) -> None:
    """A run of one step whose table is not in a file; threads and models take turns."""
    kinds = [(model, threads) for model in models for threads in THREADS]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for pair in pairs:
            case = absolute(Case.exercise(1, pair)).replace(
                table_file="", dt=1e-4, interval=1e-4, t_end=1e-4, stop_at="t_end", output_file=f"{folder}/columns.txt")
            found = np.array([[built(case.replace(contact_model=model), threads, Path(folder))
                               for model, threads in kinds] for _ in range(rounds)])
            for (model, threads), seconds in zip(kinds, found.transpose(1, 2, 0), strict=True):
                subject = f"table, {model}, {threads} thread{'s'*(threads > 1)}"
                measures = [measure(pair, subject, f"{what} time of building", "s", x, headline=True)
                            for what, x in zip(("wall", "processor"), seconds, strict=True)]
                over = ratio(pair, subject, "wall time over the strip table's", seconds[0],
                             found[:, THREADS.index(threads), 0], headline=False)
                out.measures += [*measures, over]
                rows.append([pair, model, str(threads), *(m.text() for m in (*measures, over))])
    out.tables.append(Table("Building a contact table: median (quartiles)", [
        "profiles", "model", "threads", "wall time [s]", "processor time [s]", "wall time over the strip model's"], rows))


def built(case: Case, threads: int, folder: Path) -> tuple[float, float]:
    """Wall and processor time [s] of a run whose table has to be built."""
    case.to_namelist(folder/"case.nml")
    return resources(["env", f"OMP_NUM_THREADS={threads}", str(LDBENCH), str(folder/"case.nml")], folder)[:2]


def writing_measures(out: Section, case: Case, rounds: int) -> None:
    """Column file and its recording, against the integration."""
    run = ldbench.run(case)
    write, integrate = [], []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder)/"columns.txt"
        for _ in range(rounds):
            begin = time.process_time()
            run.write(path)
            write.append(time.process_time() - begin)
            integrate.append(ldbench.run(case, table=run.table).seconds)
        size = path.stat().st_size
    rows = run.results["rows"]
    out.measures += [
        measure(case.case_name, "column file", "processor time of writing", "s", write,
                f"{rows} rows, {size/1e6:.1f} MB"),
        ratio(case.case_name, "column file", "writing over integrating", write, integrate, f"{rows} rows")]
    out.tables.append(Table(f"Writing the column file of {case.case_name}, {rows} rows, {size/1e6:.1f} MB",
                            ["processor time [s]", "over the integration"],
                            [[m.text() for m in out.measures[-2:]]]))


def python_measures(out: Section, case: Case, rounds: int) -> None:
    """The run from Python, its column file written, against the executable."""
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copy(ContactTable(case).case.table_path(), folder)
        for _ in range(rounds):
            theirs.append(child(case.case_name, folder)[0])
            begin = time.perf_counter()
            ldbench.run(Case.from_namelist(folder/f"{case.case_name}.nml")).write()
            ours.append(time.perf_counter() - begin)
    out.measures += [measure(case.case_name, "Python", "wall time", "s", ours),
                     ratio(case.case_name, "Python", "wall time over the executable's", ours, theirs)]


def section(full: bool) -> Section:
    out = Section("The cases as they are run", TEXT)
    rounds = 3
    case_measures(out, CASES, rounds)
    table_measures(out, ("aw", "sw"), MODELS if full else MODELS[::2], rounds if full else 2)
    python_measures(out, Case.exercise(5, "aw"), rounds)
    writing_measures(out, Case.exercise(1, "aw"), rounds)
    return out
