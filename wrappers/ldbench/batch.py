"""Run cases with the executable: in parallel, and only those that are not up to date.

Beside each product lies a stamp, PRODUCT.stamp, with the hashes of everything the
product depends on and of the product itself.
"""
from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import f90nml

from ._core import Error, digest

PROJECT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Job:
    """One run of the executable in the folder `root`."""
    name: str
    text: str                     # of the namelist
    product: Path                 # the file that it is run for
    root: Path
    litter: Path | None = None    # a file that the run writes as well and nobody wants

    @cached_property
    def namelist(self) -> f90nml.Namelist:
        return f90nml.reads(self.text)

    def value(self, group: str, name: str, default: object = None) -> object:
        return self.namelist.get(group, {}).get(name, default)

    @property
    def table(self) -> Path | None:
        file = self.value("table", "file")
        return self.root/str(file) if file else None

    @property
    def cost(self) -> float:
        """About how often it may evaluate the contacts."""
        stages = 6 if self.value("integrator", "order", 2) == 4 else 1
        return stages*float(self.value("integrator", "t_end", 1.0))/float(self.value("integrator", "dt", 2e-6))

    def sources(self, executable: Path) -> dict[str, str]:
        """Hashes of what the product depends on."""
        profiles = [self.root/str(self.value("profiles", which, default)) for which, default in
                    (("wheel_profile", "profiles/awprof.yz"), ("rail_profile", "profiles/arprof.yz"))]
        profiles += [self.root/str(name) for which in ("wheel_profile_right", "rail_profile_right")
                     if (name := self.value("profiles", which))]
        return {"namelist": digest(self.text.encode())} | hashes([executable, *profiles], self.root)


def with_values(text: str, values: Mapping[str, Mapping[str, object]]) -> str:
    """A namelist with some values replaced or added."""
    namelist = f90nml.reads(text)
    for group, variables in values.items():
        namelist.setdefault(group, f90nml.Namelist()).update(variables)
    return f"{namelist}\n"


def case_job(namelist: Path, folder: Path, root: Path) -> Job:
    """The job of a namelist file that puts its columns into `folder`.  The text stays as it is
    where that is what it says."""
    text = namelist.read_text()
    output = folder/f"{namelist.stem}.txt"
    if (root/str(f90nml.reads(text).get("output", {}).get("file", ""))).resolve() != output.resolve():
        text = with_values(text, {"output": {"file": inside(output, root)}})
    return Job(namelist.stem, text, output, root)


def inside(path: Path, root: Path) -> str:
    """A path as a namelist in `root` would say it."""
    try:
        return str(path.resolve().relative_to(root.resolve()))
    except ValueError:
        return str(path.resolve())


def project_root() -> Path:
    """Where `inputs` are: the repository that the package is in, or the current folder."""
    return PROJECT if (PROJECT/"inputs").is_dir() else Path.cwd()


def find_executable(root: Path) -> Path:
    """$LDBENCH, ROOT/ldbench or one on the search path."""
    named = os.environ.get("LDBENCH")
    for candidate in (named, root/"ldbench", shutil.which("ldbench")):
        if candidate and Path(candidate).is_file():
            return Path(candidate).resolve()
    raise Error(f"{named or root/'ldbench'}: expected the executable, found none; `make` builds it")


def find_namelists(inputs: Path) -> list[Path]:
    """The exercises' namelist files of a folder."""
    namelists = sorted(inputs.glob("ex*.nml"))
    if not namelists:
        raise Error(f"{inputs}: expected namelists ex*.nml, found none")
    return namelists


def hashes(files: Sequence[Path], root: Path) -> dict[str, str]:
    """Hash of each file, '' of one that is missing."""
    return {inside(file, root): digest(file.read_bytes()) if file.is_file() else "" for file in files}


def stamp_of(product: Path) -> Path:
    return product.with_name(product.name + ".stamp")


def is_up_to_date(product: Path, sources: Mapping[str, str]) -> bool:
    """Whether a product is there, untouched, and made from just these sources."""
    try:
        stamp = json.loads(stamp_of(product).read_text())
        return stamp == {"sources": dict(sources), "product": digest(product.read_bytes())}
    except (OSError, ValueError):
        return False


def write_stamp(product: Path, sources: Mapping[str, str]) -> None:
    stamp = {"sources": dict(sources), "product": digest(product.read_bytes())}
    stamp_of(product).write_text(json.dumps(stamp, indent=1) + "\n")


def run_job(job: Job, executable: Path) -> None:
    """Run one job; an Error with the core's text if it fails."""
    sources = job.sources(executable)
    try:
        done = subprocess.run([executable], input=job.text, cwd=job.root, capture_output=True, text=True,
                              errors="replace")
    except OSError as error:
        raise Error(f"{executable}: cannot be run: {error.strerror}") from None
    if job.litter:
        job.litter.unlink(missing_ok=True)
    if done.returncode:
        words = done.stderr.strip().splitlines()[-1:] or [f"exit status {done.returncode}"]
        raise Error(f"{job.name}: " + words[0].removeprefix("ldbench: error: standard input").lstrip(":, "))
    write_stamp(job.product, sources)


def run_jobs(jobs: Sequence[Job], executable: Path, workers: int,
             done: Callable[[Job], object] = lambda job: None) -> None:
    """Run jobs side by side, the longest first; `done` is called after each.  When one fails, those
    that run are waited for, the others are not begun."""
    with ThreadPoolExecutor(workers) as pool:
        tasks = {pool.submit(run_job, job, executable): job for job in sorted(jobs, key=lambda job: -job.cost)}
        try:
            for task in as_completed(tasks):
                task.result()
                done(tasks[task])
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def run_stale(jobs: Sequence[Job], executable: Path, workers: int, force: bool = False,
              done: Callable[[Job, bool], object] = lambda job, ran: None) -> list[Job]:
    """Run the jobs that are not up to date; these are returned.  `done(job, ran)` is called for all.

    Jobs that share a contact table would each build it: first one of them runs for every table
    that is missing, then the rest."""
    stale = [job for job in jobs if force or not is_up_to_date(job.product, job.sources(executable))]
    for job in jobs:
        if job not in stale:
            done(job, False)
    first: dict[Path, Job] = {}
    for job in sorted(stale, key=lambda job: job.cost):
        if job.table and not job.table.is_file():
            first.setdefault(job.table, job)
    rest = [job for job in stale if job not in first.values()]
    for batch in (list(first.values()), rest):
        run_jobs(batch, executable, workers, lambda job: done(job, True))
    return stale
