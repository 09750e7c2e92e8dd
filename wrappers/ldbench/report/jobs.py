"""Run cases side by side, and only those that are not up to date.

Column files have the bytes that the executable writes. Relative names are in the working directory.
"""
from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from .._core.calls import Progress
from .._core.errors import Error
from .._core.files import digest
from .._core.kept import hashes, inside, is_up_to_date, write_stamp
from .._core.pools import in_threads, one_of_each
from ..case import Case, data_folder
from ..ensembles.members import table_keys
from ..runs import compute, output_path


@dataclass(frozen=True)
class Job:
    """A run, and the column file that it is done for."""
    case: Case
    product: Path

    @property
    def name(self) -> str:
        """The name of the run, for messages."""
        return self.product.stem

    @property
    def cost(self) -> float:
        """About how often it may evaluate the contacts."""
        stages = {4: 6, 6: 11}.get(self.case.order, 1)
        return stages*self.case.t_end/self.case.dt


def sources(case: Case) -> dict[str, str]:
    """Digests of what a run depends on besides the program."""
    files = [Path(file) for file in case.files().values()]
    return {f"case {case.case_name}": digest(os.fsencode(case.to_namelist()))} | hashes(files, Path())


def case_job(case: Case, folder: Path) -> Job:
    """The job of a case that puts its columns into `folder`. The case stays as it is where that is what it says."""
    product = folder/f"{case.case_name}.txt"
    if Path(output_path(case)).resolve() != product.resolve():
        case = case.replace(output_file=inside(product, Path()))
    return Job(case, product)


def shipped_inputs() -> Path:
    """The folder of the ten namelists: that of the working directory, or the installed one."""
    return here if (here := Path("inputs")).is_dir() else data_folder()/"inputs"


def find_cases(inputs: Path) -> list[Case]:
    """The cases of the exercises' namelist files in a folder."""
    files = sorted(inputs.glob("ex*.nml"))
    if not files:
        raise Error(file=inputs, expected="namelists ex*.nml", found="none")
    cases = [Case.from_namelist(file) for file in files]
    for file, case in zip(files, cases, strict=True):
        if case.case_name != file.stem or not re.fullmatch("ex[1-5]_(aw|sw)", file.stem):
            raise Error(file=file, group="case", variable="name",
                        expected="an exercise and a pair of profiles, 'ex1_aw' to 'ex5_sw', as in the name of the file",
                        found=f"'{case.case_name}'", advice="the commands run, plot, compare and view take any name")
    return cases


def run_job(job: Job, tell: Progress) -> None:
    """Run one job. An exception in `tell` ends it early."""
    case, before = job.case, sources(job.case)
    case.check_writable(output_path(case))
    compute(case, tell).write(output_path(case))
    write_stamp(job.product, before)


def run_stale(jobs: Sequence[Job], workers: int, force: bool = False,
              done: Callable[[Job, bool], object] = lambda job, ran: None) -> None:
    """Run the jobs that are not up to date side by side, the longest first; `done(job, ran)` is called for all.

    Jobs that share a contact table would each solve it: first the shortest of them runs for every table, then the rest."""
    stale = [job for job in jobs if force or not is_up_to_date(job.product, sources(job.case))]
    for job in jobs:
        if job not in stale:
            done(job, False)

    table = table_keys()
    for batch in one_of_each(sorted(stale, key=lambda job: job.cost), lambda job: job.case.table_folder and table(job.case)):
        for job, _ in in_threads(run_job, sorted(batch, key=lambda job: -job.cost), workers):
            done(job, True)
