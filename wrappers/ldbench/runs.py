"""Runs: the class Run, and the functions that compute a run or read it from a file."""
from __future__ import annotations

import functools
import logging
import os
import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._core import flat
from ._core.calls import Handle, Progress, Shared, check, descriptions, path_bytes, text, watched
from ._core.errors import Error, warn
from ._core.files import DEFAULT_FOLDER, check_written, complete
from ._core.wording import counted, html_table
from .case import Case, variables
from .constants import CONTACT_NAMES
from .results.answers import answers
from .results.header import parse_comments
from .results.run_data import RunData, checked
from .table import ContactTable

if TYPE_CHECKING:       # what draws and makes frames is imported where it is needed: it takes longer than a short run
    import pandas as pd

    from .plots.sheets import Figures
    from .viewer.page import Page

log = logging.getLogger(__name__)


class Run(RunData):
    """A run, from memory (`ldbench.run`) or from a column file (`ldbench.read_run`).

    `run["Y"]` is a column; `case` has what went in, `results` and `events` what came out; `ending` says why the run ended, and
    `success` whether as `stop_at` asks; `plot`, `view`, `to_xarray` and `write` hand it on. It can be copied, pickled and sent to
    other processes.
    """

    #: Processor time of the integration [s]; NaN of a run from a file, which does not tell it.
    seconds: float = np.nan

    @functools.cached_property
    def _in_core(self) -> ComputedRun:
        """The run in the core's memory; a run from a file is computed again."""
        return compute(self.case)

    @property
    def table(self) -> ContactTable:
        """The contact table, which serves further runs: run(case.replace(vY=0.2), table=run.table). It is prepared
        when it is first asked for, where the run comes from a file, from another process, or is a copy."""
        return self._in_core.table

    @property
    def text(self) -> str:
        """The summary that the executable prints; of a run from a file, the case is run again for it."""
        return self._in_core.text

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful about the profiles, the contact table and the run, in a line each."""
        told = [line.removeprefix("warning: ") for line in self._in_core.comments.splitlines() if line.startswith("warning: ")]
        return tuple(dict.fromkeys(told))

    def write(self, path: str | os.PathLike[str] | None = None) -> str:
        """Write the column file, by default where the case says, but not over that of the unchanged case; returns its path. Of a
        run from a file it is a copy."""
        if path is None:
            raise Error(file=self.file, expected="the path of another file, to which the run is copied", found="none")
        check_written([Path(path)], [self.file])
        with complete(Path(path)) as scratch:
            shutil.copyfile(self.file, scratch)
        return os.fspath(path)

    def plot(self) -> Figures:
        """Draw every quantity of the benchmark's list: the figures of matplotlib, a page each, which a notebook shows.

        `run.plot()[0].savefig("motion.png")` writes one of them, `save_plots` all of them.
        """
        from .plots.document import drawn

        return drawn(self)

    def save_plots(self, path: str | os.PathLike[str] = "") -> Path:
        """Write these figures as the pages of a PDF, by default NAME.pdf here, or below each other as a picture .svg
        or .png; returns its path."""
        from .plots.document import plot_runs

        target = Path(path or f"{self.name}.pdf")
        plot_runs([self], target)
        return target

    def view(self) -> Page:
        """The run as an interactive page, which a notebook shows; `.write(path)` writes it."""
        from .viewer.page import view

        return view(self)

    def _repr_html_(self) -> str:
        """The outcome in a table, for a notebook."""
        rows: list[tuple[str, ...]] = [("rows", str(len(self.data)), "")]
        known = answers(self)
        if self.ending:
            found = self.results
            rows = [("ended", f"{found['t']:.6f} s", self.ending),
                    ("rows", str(found["rows"]), f"of {found['steps']} steps of at most {found['step']:g} s"),
                    ("energy drift, largest", f"{found['drift']:.1e} J", f"of {found['kinetic_energy']:.6g} J")]
        for contact, words in CONTACT_NAMES.items():
            if peak := known[f"peak_N_{contact}"]:
                rows.append((f"largest normal force, {words}", f"{1e-3*peak:.3f} kN", f"at {known[f't_peak_{contact}']:.6f} s"))
        rows += [(event.kind, f"{event.t:.6f} s", "") for event in self.events[:12]]
        rows += [("...", f"{len(self.events) - 12} more in .events", "")] if len(self.events) > 12 else []
        return html_table(": ".join(words for words in (self.name, self.header.title) if words), rows)

    def __repr__(self) -> str:
        if not self.ending:
            return f"Run({self.name!r}, {counted(len(self.data), 'row')} of {self.file})"
        return f"Run({self.name!r}, {self.results['rows']:.0f} rows to t = {self.results['t']:g} s: {self.ending})"


class ComputedRun(Run):
    """A run in the core's memory. In another process table and run are made again from the case where they are asked for."""

    def __init__(self, table: ContactTable, handle: Handle) -> None:
        """handle: the run, which the core integrated with that table."""
        vars(self).update(table=table, handle=handle)
        listing, length, self.seconds = flat.run_comments(table._handle, handle)
        self.comments = text(listing, length)
        before, _, after = self.comments.partition("\x1c\n")
        super().__init__(Path(output_path(table.case)), comments=parse_comments(before.splitlines(), after.splitlines()),
                         case=table.case)

    def __getstate__(self) -> dict[str, Any]:
        return super().__getstate__() | {"text": self.text, "comments": self.comments, "seconds": self.seconds}

    @property
    def _in_core(self) -> ComputedRun:
        return self

    @functools.cached_property
    def text(self) -> str:
        """The summary that the executable prints."""
        return text(*flat.run_summary(self.table._handle, self.handle))

    @property
    def unkept(self) -> str:
        """A warning where the contact tables could not be kept; '' where they were."""
        return text(*flat.run_unkept(self.handle)).partition("\x1c")[0]

    @functools.cached_property
    def table(self) -> ContactTable:
        """The contact table, prepared where it is not at hand."""
        return ContactTable(self.case)

    @functools.cached_property
    def handle(self) -> Handle:
        """Handle of the run. A run from another process is computed again, once, to write its file."""
        again = compute(self.case, table=self.table)
        if again.comments != self.comments:
            raise Error(file=self.case.label, expected="the profiles and the program that made the run",
                        found="others")
        return again.handle

    @functools.cached_property
    def data(self) -> pd.DataFrame:
        """Copy the columns from the core."""
        import pandas as pd

        values = flat.run_columns(self.handle, *flat.run_size(self.handle))
        names, units = (line.split()[:len(values)] for line in descriptions()[:2])
        frame = pd.DataFrame(values.T, columns=names, copy=False)
        frame.attrs["units"] = dict(zip(names, units, strict=True))
        return frame

    def write(self, path: str | os.PathLike[str] | None = None) -> str:
        """Write the column file, by default where the case says, but not over that of the unchanged case; returns its path. An
        earlier file of another case is kept as NAME.1.txt, NAME.2.txt, ..."""
        if path is None:
            check_own_file(self.case, "a path, or another output_file in `replace`")
        path = os.fspath(path or self.file)
        kept, kept_length, message, length = flat.write_run(self.table._handle, self.handle, path_bytes(path))
        check(message, length, self.case.label)
        if kept_length:
            log.info("kept: %s, the earlier columns, of another case", os.fsdecode(kept[:kept_length]))
        return path


def run(case: Case | str | os.PathLike[str], progress: Progress | bool | None = None, table: ContactTable | None = None) -> Run:
    """Run a case, or a namelist file; nothing is written but contact tables, where the case names a folder for them: `write()` of
    the run writes the column file that the case names. For a mapping of values make a case: `run(Case(values))`.

    progress: True draws a bar on a terminal, a function is called as `progress(stage, share)` from this thread,
    with stage 'integration' and the share done, 0 to 1. table: that of an earlier run, which saves
    what it has solved; Error when it does not fit the case. Ctrl-C stops the run and raises KeyboardInterrupt;
    so does any exception in `progress`. Other Python threads go on meanwhile. Every line of `run.warnings` is a
    `ldbench.Warning`.
    """
    case = Case.given(case)
    done = compute(case, progress, table)
    if case.output_file:
        log.info("not written: %s, which the case names; write() of the run writes it", case.output_file)
    for words in filter(None, (*done.warnings, done.unkept)):
        warn(words)
    return done


def compute(case: Case, progress: Progress | bool | None = None, table: ContactTable | None = None) -> ComputedRun:
    """`run` without a `ldbench.Warning`, for commands and workers."""
    fitting = table.for_case(case) if table else ContactTable(case)

    def work(shared: Shared) -> ComputedRun:
        address, message, length = flat.simulate_case(fitting._handle, *shared)
        check(message, length, case.label)
        return ComputedRun(fitting, Handle(flat.free_run, address))

    done = watched(work, progress)
    log.info("%r, %.2f s of processor time", done, done.seconds)
    return done


def read_run(path: str | os.PathLike[str], map: Any = None) -> Run:
    """Read a run from a column file, ldbench's or another code's.

    map: how another code names the columns, a mapping or a TOML file (see `read_columns`). It is not used for a file with
    ldbench's header. Raises FileNotFoundError where there is no file, Error where it cannot be understood.
    """
    return checked(Run(Path(path), map))


def check_own_file(case: Case, wanted: str) -> None:
    """Refuse to replace the column file of the unchanged case by that of a case that differs in more than &output; `wanted`
    says how to name another file."""
    pairs = zip(variables(), case.values, case.unchanged, strict=True)
    if (any(variable.group != "output" and value != before for variable, value, before in pairs)
            and output_path(case) == output_path(Case.of_values(case.unchanged, case.label))):
        raise Error(file=case.label, expected=wanted,
                    found=f"none: {output_path(case)} is the file of the unchanged case")


def output_path(case: Case) -> str:
    """The path of the column file that a case names, or the default one."""
    return case.output_file or f"{DEFAULT_FOLDER}/{case.name}.txt"
