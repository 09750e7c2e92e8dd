"""Run cases side by side, and only those that are not up to date.

Column files have the bytes that the executable writes.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import f90nml

from .._core.calls import Progress
from .._core.errors import Error
from .._core.files import DEFAULT_FOLDER, digest
from .._core.kept import hashes, inside, is_up_to_date, write_stamp
from .._core.pools import in_threads, one_of_each
from ..case import Case, data_folder
from ..runs import compute, output_path


@dataclass(frozen=True)
class Job:
    """One run, whose relative names are in the folder `root`."""
    name: str
    text: str                     # of the namelist
    product: Path                 # the file that it is run for
    root: Path
    litter: Path | None = None    # a file that the run writes as well and nobody wants

    @cached_property
    def namelist(self) -> f90nml.Namelist:
        """The namelist of the run."""
        return f90nml.reads(self.text)

    def value(self, group: str, name: str, default: object = None) -> Any:
        """A value of the namelist, or the default."""
        return self.namelist.get(group, {}).get(name, default)

    @property
    def table(self) -> Path | None:
        """The file of the contact table; None where the case keeps none."""
        file = self.value("table", "file")
        return self.root/str(file) if file else None

    @property
    def cost(self) -> float:
        """About how often it may evaluate the contacts."""
        stages = {4: 6, 6: 11}.get(self.value("integrator", "order", 2), 1)
        return stages*float(self.value("integrator", "t_end", 1.0))/float(self.value("integrator", "dt", 2e-6))

    @cached_property
    def profiles(self) -> list[str]:
        """Names of profiles."""
        names = [self.value("profiles", which, default) for which, default in (
            ("wheel_profile", "profiles/awprof.yz"), ("rail_profile", "profiles/arprof.yz"), ("wheel_profile_right", ""),
            ("rail_profile_right", ""))]
        return [str(name) for name in names if name]

    @property
    def case(self) -> Case:
        """The case of the run."""
        read = Case.from_namelist(self.text + "\n")         # text, not the name of a file
        return RootedCase.of_values(read.values, "namelist", self.root)

    def sources(self) -> dict[str, str]:
        """Hashes of what the product depends on besides the program."""
        profiles = [profile_in(self.root, name) for name in self.profiles]
        return {"namelist": digest(self.text.encode())} | hashes(profiles, self.root)


class RootedCase(Case):
    """A case whose relative names are in the folder of a job, as for the executable that runs there; but for shipped profiles."""

    def find(self, name: str) -> str:
        """The path of a profile."""
        return str(profile_in(self.folder or Path(), name))

    def table_path(self) -> str:
        """The path of the file of the contact table; '' where the case keeps none."""
        if not self.table_file:
            return ""
        path = Path(self.folder or "", self.table_file)
        if self.table_file == f"{DEFAULT_FOLDER}/{path.name}":      # as the executable makes it
            path.parent.mkdir(exist_ok=True)
        return str(path)


def profile_in(root: Path, name: str) -> Path:
    """The profile of that name in `root`, or the shipped one."""
    there, shipped = root/name, data_folder()/name
    return shipped if shipped.is_file() and not there.exists() else there


def with_values(text: str, values: Mapping[str, Mapping[str, object]]) -> str:
    """A namelist with some values replaced or added."""
    namelist = f90nml.reads(text)
    for group, variables in values.items():
        namelist.setdefault(group, f90nml.Namelist()).update(variables)
    return f"{namelist}\n"


def case_job(namelist: Path, folder: Path, root: Path) -> Job:
    """The job of a namelist file that puts its columns into `folder`.  The text stays as it is
    where that is what it says."""
    text = namelist.read_text(encoding="utf-8-sig", errors="surrogateescape")
    output = folder/f"{namelist.stem}.txt"
    if (root/str(f90nml.reads(text).get("output", {}).get("file", ""))).resolve() != output.resolve():
        text = with_values(text, {"output": {"file": inside(output, root)}})
    return Job(namelist.stem, text, output, root)


def shipped_inputs(root: Path) -> Path:
    """The folder of the ten namelists: that of `root`, or the installed one."""
    return root/"inputs" if (root/"inputs").is_dir() else data_folder()/"inputs"


def find_namelists(inputs: Path) -> list[Path]:
    """The exercises' namelist files of a folder."""
    namelists = sorted(inputs.glob("ex*.nml"))
    if not namelists:
        raise Error(f"{inputs}: expected namelists ex*.nml, found none")
    for file in namelists:
        name = Case.from_namelist(file).case_name
        if name != file.stem or not re.fullmatch("ex[1-5]_(aw|sw)", name):
            raise Error(f"{file}, &case name: expected an exercise and a pair of profiles, 'ex1_aw' to 'ex5_sw', as in the name "
                        f"of the file, found '{name}'; the commands run, plot, compare and view take any name")
    return namelists


def run_job(job: Job, tell: Progress) -> None:
    """Run one job; an Error with the core's text if it fails. An exception in `tell` ends it early."""
    sources = job.sources()
    try:
        case = job.case
        columns = job.root/output_path(case)
        geometry = job.root/case.geometry_file if case.geometry_file else ""
        for variable, path in (("&output file", columns), ("&output geometry_file", geometry),
                               ("&table file", case.table_path())):
            case.check_writable(variable, path)
        compute(case, tell).write(columns, geometry)
    except Error as error:
        raise Error(f"{job.name}: " + str(error).removeprefix("namelist").lstrip(":, ")) from None
    finally:
        if job.litter:
            job.litter.unlink(missing_ok=True)
    write_stamp(job.product, sources)


def run_jobs(jobs: Sequence[Job], workers: int, done: Callable[[Job], object] = lambda job: None) -> None:
    """Run jobs side by side, the longest first; `done` is called after each."""
    for job, _ in in_threads(run_job, sorted(jobs, key=lambda job: -job.cost), workers):
        done(job)


def find_stale(jobs: Sequence[Job], force: bool = False) -> list[Job]:
    """The jobs that are not up to date."""
    return [job for job in jobs if force or not is_up_to_date(job.product, job.sources())]


def run_stale(jobs: Sequence[Job], workers: int, force: bool = False,
              done: Callable[[Job, bool], object] = lambda job, ran: None, stale: Sequence[Job] | None = None) -> list[Job]:
    """Run the jobs that are not up to date, or `stale` where these are known; they are returned.  `done(job, ran)` is
    called for all.

    Jobs that share a contact table would each build it: first one of them runs for every table
    that is missing, then the rest."""
    stale = find_stale(jobs, force) if stale is None else list(stale)
    for job in jobs:
        if job not in stale:
            done(job, False)
    def lacking(job: Job) -> Path | None:
        return job.table if job.table and not job.table.is_file() else None

    for batch in one_of_each(sorted(stale, key=lambda job: job.cost), lacking):
        run_jobs(batch, workers, lambda job: done(job, True))
    return stale
