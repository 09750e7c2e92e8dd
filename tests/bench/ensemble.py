"""How a sweep scales with the threads of one process."""
from __future__ import annotations

import tempfile
import time

import numpy as np

import ldbench
from ldbench import Case, ContactTable
from measure import Section, measure, ratio

COUNT, ROUNDS = 500, 2
THREADS = 1, 2

TEXT = """Exercise 3 in full, actual profiles, with 500 masses between 1000 and 2000 kg, with one and with two threads, which take
turns. The contact table is there. A member: one run with its summary. Wall time less that of a sweep with one member, and as it
is, with the start. Processor time does not depend on what else the machine does."""


def section() -> Section:
    out = Section("Ensembles", TEXT)
    masses = np.linspace(1000, 2000, COUNT + 1).tolist()
    with tempfile.TemporaryDirectory() as name:
        case = Case.exercise(3, "aw").replace(table_folder=name)
        table = ContactTable(case)

        def spent(threads: int, some: list[float]) -> tuple[float, float]:
            """Wall and processor time of a sweep."""
            begin = time.perf_counter(), time.process_time()
            ldbench.ensemble(case, {"mass": some}, tables=[table], threads=threads)
            return time.perf_counter() - begin[0], time.process_time() - begin[1]

        spent(1, masses[:4])        # the modules are there afterwards
        # Threads; sweep or its start; wall or processor time; round.
        seconds = np.moveaxis([[[spent(n, some) for some in (masses, masses[:1])] for n in THREADS] for _ in range(ROUNDS)], 0, -1)
    for n, (whole, start) in zip(THREADS, seconds, strict=True):
        out.measures += [measure(case.case_name, f"{n} threads", "wall time of a member", "s", (whole[0] - start[0])/COUNT),
                         measure(case.case_name, f"{n} threads", "start", "s", start[0]),
                         measure(case.case_name, f"{n} threads", "processor time of a member", "s", (whole[1] - start[1])/COUNT)]
    (one, one_start), (two, two_start) = seconds[:, :, 0]
    out.measures += [ratio(case.case_name, "2 threads", "with the start, times faster than 1 thread", one, two),
                     ratio(case.case_name, "2 threads", "times faster than 1 thread", one - one_start, two - two_start)]
    return out
