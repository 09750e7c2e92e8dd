"""How a sweep scales: threads of one process, and processes on a Dask cluster."""
from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil

import ldbench
from ldbench import Case, ContactTable
from local_cluster import Cluster
from measure import Section, measure, ratio

WORKERS = 2

TEXT = """Exercise 3 in full, actual profiles, with as many masses between 1000 and 2000 kg as there are members: with one
and with two threads, and with one and with two worker processes of one thread on a Dask cluster on this machine,
scheduler and client on the same cores. The contact table is there. Rounds alternate between them. A member: one run with
its summary. Wall time less that of a sweep with one member, and as it is, with the start: the client connects, each worker
gets the table. Processor time is that of all processes, and does not depend on what else the machine does."""


def wall(call: Callable[[], object]) -> float:
    begin = time.perf_counter()
    call()
    return time.perf_counter() - begin


def processor_time(cluster: Cluster | None) -> float:
    """The processor time of this process and of a cluster [s]."""
    times = [psutil.Process(process.pid).cpu_times() for process in (cluster.processes if cluster else ())]
    return time.process_time() + sum(x.user + x.system for x in times)


def section(full: bool) -> Section:
    out = Section("Ensembles", TEXT)
    count, rounds = (1000, 3) if full else (500, 2)
    masses = np.linspace(1000, 2000, count + 1).tolist()
    clusters = []
    with tempfile.TemporaryDirectory() as name:
        case = Case.exercise(3, "aw").replace(table_file=f"{name}/table")
        table = ContactTable(case)
        kinds = {f"{n} thread{'s'*(n > 1)}": lambda some, n=n: ldbench.ensemble(
            case, {"mass": some}, tables=[table], threads=n) for n in (1, 2)}
        try:
            for n in (1, WORKERS):
                folder = Path(name)/str(n)
                folder.mkdir()
                clusters.append(Cluster(folder, n))
                kinds[f"{n} process{'es'*(n > 1)}"] = lambda some, address=clusters[-1].address: ldbench.ensemble(
                    case, {"mass": some}, scheduler=address)
            for sweep in kinds.values():     # the modules are there afterwards
                sweep(masses[:2*WORKERS])
            owners = [next((c for c in clusters if kind.startswith(f"{len(c.processes) - 1} process")), None) for kind in kinds]

            def spent(sweep: Callable[[list[float]], object], owner: Cluster | None) -> list[list[float]]:
                """Wall and processor time of a sweep, and of one of a member."""
                found = []
                for some in masses, masses[:1]:
                    begin = processor_time(owner)
                    found.append([wall(lambda some=some: sweep(some)), processor_time(owner) - begin])
                return found

            # Kind, sweep or its start, wall or processor time, round.
            seconds = np.moveaxis([[spent(*each) for each in zip(kinds.values(), owners, strict=True)]
                                   for _ in range(rounds)], 0, -1)
        finally:
            for cluster in clusters:
                cluster.stop()
    names = list(kinds)
    for kind, (whole, start) in zip(names, seconds, strict=True):
        out.measures += [measure(case.case_name, kind, "wall time of a member", "s", (whole[0] - start[0])/count),
                         measure(case.case_name, kind, "start", "s", start[0]),
                         measure(case.case_name, kind, "processor time of a member", "s", (whole[1] - start[1])/count)]
    for one, two in ("1 thread", "2 threads"), ("1 process", "2 processes"):
        (a, a_start), (b, b_start) = (seconds[names.index(kind)][:, 0] for kind in (one, two))
        out.measures += [ratio(case.case_name, two, f"with the start, times faster than {one}", a, b),
                         ratio(case.case_name, two, f"times faster than {one}", a - a_start, b - b_start)]
    return out
