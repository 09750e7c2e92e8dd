"""How a sweep scales: threads of one process, and processes on a Dask cluster."""
from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import ldbench
from checks import Table
from ldbench import Case, ContactTable
from local_cluster import Cluster
from measure import Form, Section, measure, ratio

MEMBERS = {Form.SHORT: 8, Form.USUAL: 500, Form.FULL: 1000}
ROUNDS = {Form.SHORT: 2, Form.USUAL: 2, Form.FULL: 3}
WORKERS = 2

TEXT = """Exercise 3 in full, actual profiles, with as many masses between 1000 and 2000 kg as there are members. Wall
time of the sweep less that of a sweep with one member: with one and with two threads, and with one and with two worker
processes of one thread on a Dask cluster on this machine, scheduler and client on the same cores. The contact table is
there. Rounds alternate between them. A member: one run with its summary.

Cost model: n members on p workers take about table + n member/p + 10 MB per worker over the network + 1 ms per task in
the scheduler. Tasks are pieces of up to 16 members, so one scheduler feeds as many workers as a piece takes
milliseconds."""


def difference(sweep: Callable[[list[float]], object], masses: list[float]) -> float:
    """Wall time of a sweep less that of its first member [s]."""
    return wall(lambda: sweep(masses)) - wall(lambda: sweep(masses[:1]))


def wall(call: Callable[[], object]) -> float:
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def section(form: Form) -> Section:
    short = form is Form.SHORT
    out = Section("Ensembles", TEXT)
    count, rounds = MEMBERS[form], ROUNDS[form]
    masses = np.linspace(1000, 2000, count + 1).tolist()
    clusters = []
    with tempfile.TemporaryDirectory() as name:
        case = Case.exercise(3, "aw").replace(table_file=f"{name}/table")
        table = ContactTable(case)
        kinds = {f"{n} thread{'s'*(n > 1)}": lambda some, n=n: ldbench.ensemble(
            case, {"mass": some}, tables=[table], threads=n) for n in (1, 2)}
        try:
            for n in () if short else (1, WORKERS):
                folder = Path(name)/str(n)
                folder.mkdir()
                clusters.append(Cluster(folder, n))
                kinds[f"{n} process{'es'*(n > 1)}"] = lambda some, address=clusters[-1].address: ldbench.ensemble(
                    case, {"mass": some}, scheduler=address)
            for sweep in kinds.values():     # the modules are there afterwards
                sweep(masses[:2*WORKERS])
            seconds = np.array([[difference(sweep, masses) for sweep in kinds.values()] for _ in range(rounds)]).T
        finally:
            for cluster in clusters:
                cluster.stop()
    times = dict(zip(kinds, seconds, strict=True))
    out.measures += [measure(case.case_name, kind, "wall time of a member", "s", x/count) for kind, x in times.items()]
    for one, two in ("1 thread", "2 threads"), ("1 process", "2 processes"):
        if two in times:
            out.measures.append(ratio(case.case_name, two, f"times faster than {one}", times[one], times[two]))
    rows = [[m.subject, m.quantity, m.text()] for m in out.measures]
    out.tables.append(Table(f"{count} members: median (quartiles)", ["kind", "quantity", "[s] or ratio"], rows))
    return out
