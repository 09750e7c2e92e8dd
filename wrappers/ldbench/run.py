"""Run a case: integrate the wheelset's motion, write the column file, print the summary.

The column file is the executable's, byte by byte. A case that --set changes, other than in &output, needs a file of its
own: by --output, or by another name where the namelist names no file.

examples:
  python -m ldbench run inputs/ex1_aw.nml
  python -m ldbench run inputs/ex1_aw.nml --set dt=1e-5 --set order=2 --output coarse.txt
  python -m ldbench run inputs/ex3_sw.nml --set contact_model=hertz --output outputs/ex3_sw_hertz.txt
"""
from __future__ import annotations

import argparse
import functools
import os
import re
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from . import _flat
from ._core import (
    DEFAULT_FOLDER,
    Error,
    Handle,
    Progress,
    Shared,
    check,
    descriptions,
    path_bytes,
    text,
    watched,
)
from .case import Case, Value, find_variable, variables
from .notebook import html_table
from .table import CONTACT_NAMES, CONTACTS, ContactTable

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd

    from .view.page import Page


class Event(NamedTuple):
    """Something that happened in a run."""

    t: float            # [s]
    kind: str           # 'left flange contact', 'derailment', ...
    force: float        # lateral force at the centre of gravity then [N]
    impulses: dict[str, float]   # of an impact, by contact [N s]
    loss: float         # energy lost in it [J]


def event_kinds() -> list[str]:
    return descriptions()[4:-1]


def count_name(kind: str) -> str:
    """The name of the number of events of a kind in a summary."""
    return "n_" + re.sub("[ -]", "_", kind)


class Run:
    """A finished run."""

    def __init__(self, table: ContactTable, handle: Handle) -> None:
        self.case: Case = table.case
        vars(self).update(table=table, _handle=handle)

    def __getstate__(self) -> dict[str, Any]:
        """The results; the rest is made again from the case where it is asked for."""
        return {name: getattr(self, name) for name in ("case", "_results", "summary", "text")}

    @functools.cached_property
    def table(self) -> ContactTable:
        """The contact table, which serves further runs: run(case.replace(vY=0.2), table=run.table). A run that came from
        another process, or is a copy, loads or builds it when it is first used."""
        return ContactTable(self.case)

    @functools.cached_property
    def _handle(self) -> Handle:
        """The run in the core. One that came from another process is done again, once, to write its file."""
        again = run(self.case, table=self.table)
        if not np.array_equal(again._results[0], self._results[0], equal_nan=True):
            raise Error(f"{self.case.label}: expected the profiles and the program that made the run, found others")
        return again._handle

    @functools.cached_property
    def _results(self) -> tuple[np.ndarray, list[Event]]:
        """Rows of the columns, shape (columns, rows), and events."""
        kinds = event_kinds()
        rows, t, kind, force, impulses, loss = _flat.run_results(self._handle, *_flat.run_size(self._handle))
        struck = [{c: float(x) for c, x in zip(CONTACTS, blow, strict=True) if x} for blow in impulses.T]
        return rows, [Event(float(a), kinds[b - 1], float(c), d, float(e))
                      for a, b, c, d, e in zip(t, kind, force, struck, loss, strict=True)]

    @functools.cached_property
    def columns(self) -> pd.DataFrame:
        """The columns of the column file, a row per output interval, or fewer in flight; units in `attrs["units"]`."""
        import pandas as pd

        names, units = (line.split()[:len(self._results[0])] for line in descriptions()[:2])
        frame = pd.DataFrame(self._results[0].T, columns=names, copy=False)
        frame.attrs["units"] = dict(zip(names, units, strict=True))
        return frame

    @property
    def events(self) -> list[Event]:
        """What happened, in order of time; the first five of each kind, a hundred impacts. All are counted in `summary`."""
        return self._results[1]

    @functools.cached_property
    def summary(self) -> dict[str, Any]:
        """The outcome in numbers, SI units.

        clearance, clearance_right (to either side), equilibrium (height of the axle, held at the centre), equilibrium_roll,
        rest_Y, rest_Z, rest_roll (where it rests by itself, as the columns have it), approach (elastic, at rest),
        load_per_wheel, frequency_1 to frequency_3 (eigenfrequencies at rest, nan where rigid contacts leave fewer); per
        contact peak_N_LT ... and its time t_peak_LT ..., largest impulse peak_P_LT ... (rigid contacts) and t_peak_P_LT
        ...; kinetic_energy (initial, of lateral, vertical and roll motion), drift (largest |energy error| over all steps),
        steps, step, evaluations, cuts, rows, t (at the end), end (why there), returned, derailed, n_left_flange_contact ...
        (events of each kind); processor time table_seconds, seconds (integration), table_found (in a file).
        """
        (step, steps, evaluations, cuts, drift, kinetic_energy, seconds, returned, derailed, _,
         *rest) = _flat.run_numbers(self._handle).tolist()
        peaks, peak_times, counts, blows, blow_times = rest[:4], rest[4:8], rest[8:-8], rest[-8:-4], rest[-4:]
        time = self._results[0][0]
        table = self.table
        return {
            "clearance": table.clearance, "clearance_right": table.clearance_right, "equilibrium": table.equilibrium,
            "equilibrium_roll": table.equilibrium_roll, "rest_Y": table.rest[0],
            "rest_Z": table.rest[1] - table.equilibrium, "rest_roll": table.rest[2] - table.equilibrium_roll,
            "approach": table.rigid_height - table.equilibrium, "load_per_wheel": table.weight / 2,
            **{f"frequency_{k}": frequency for k, frequency in enumerate(table.frequencies, 1)},
            **{f"peak_N_{c}": peak for c, peak in zip(CONTACTS, peaks, strict=True)},
            **{f"t_peak_{c}": t for c, t in zip(CONTACTS, peak_times, strict=True)},
            **{f"peak_P_{c}": blow for c, blow in zip(CONTACTS, blows, strict=True)},
            **{f"t_peak_P_{c}": t for c, t in zip(CONTACTS, blow_times, strict=True)},
            "kinetic_energy": kinetic_energy, "drift": drift,
            "steps": int(steps), "step": step, "evaluations": int(evaluations), "cuts": int(cuts),
            "rows": time.size, "t": float(time[-1]), "end": self._end(),
            "returned": bool(returned), "derailed": bool(derailed),
            **{count_name(kind): int(n) for kind, n in zip(event_kinds(), counts, strict=True)},
            "table_seconds": table._seconds, "seconds": seconds, "table_found": bool(table._found),
        }

    @functools.cached_property
    def text(self) -> str:
        """The summary that the executable prints."""
        return text(*_flat.run_summary(self.table._handle, self._handle))

    def _end(self) -> str:
        found = re.search(r"^ended at t = \S+ s: (.*)$", self.text, re.MULTILINE)
        return found[1] if found else ""

    def write(self, path: str | os.PathLike[str] | None = None, geometry: str | os.PathLike[str] = "") -> str:
        """Write the column file, by default where the case says; returns its path.

        geometry: a file for the geometry functions. No earlier file is replaced before both new ones are complete.
        """
        path = os.fspath(path or output_path(self.case))
        message, length = _flat.write_run(self.table._handle, self._handle, path_bytes(path), path_bytes(geometry))
        check(message, length, self.case.label)
        return path

    def view(self) -> Page:
        """The run as an interactive page, which a notebook shows; `.write(path)` writes it."""
        from .view import view

        return view(self)

    def _repr_html_(self) -> str:
        """The outcome in a table, for a notebook."""
        summary = self.summary
        peaks = [(f"largest normal force, {words}", f"{1e-3*summary[f'peak_N_{c}']:.3f} kN",
                  f"at {summary[f't_peak_{c}']:.6f} s") for c, words in CONTACT_NAMES.items() if summary[f"peak_N_{c}"]]
        events = [(event.kind, f"{event.t:.6f} s", "") for event in self.events[:12]]
        more = [("...", f"{len(self.events) - 12} more in .events", "")] if len(self.events) > 12 else []
        return html_table(f"{self.case.case_name}: {self.case.title}", [
            ("ended", f"{summary['t']:.6f} s", summary["end"]),
            ("rows", str(summary["rows"]), f"of {summary['steps']} steps of at most {summary['step']:g} s"),
            ("energy drift, largest", f"{summary['drift']:.1e} J", f"of {summary['kinetic_energy']:.6g} J"),
            *peaks, *events, *more])

    def __repr__(self) -> str:
        summary = self.summary
        return f"Run({self.case.case_name!r}, {summary['rows']} rows to t = {summary['t']:g} s: {summary['end']})"


def run(case: Case, progress: Progress | bool | None = None, table: ContactTable | None = None) -> Run:
    """Run a case; nothing is written but the contact table's file, if the case has one.

    progress: True draws a bar on a terminal, a function is called as `progress(stage, share)` from this thread,
    with stage 'table' or 'integration' and the share done, 0 to 1. table: that of an earlier run, which saves
    building or loading it; Error when it does not fit the case. Ctrl-C stops the run and raises KeyboardInterrupt;
    so does any exception in `progress`. Other Python threads go on meanwhile.
    """
    fitting = table.for_case(case) if table else ContactTable(case, progress)

    def work(shared: Shared) -> Run:
        address, message, length = _flat.simulate_case(fitting._handle, *shared)
        check(message, length, case.label)
        return Run(fitting, Handle(_flat.free_run, address))

    return watched(work, progress)


def output_path(case: Case) -> str:
    """Where the case's columns go."""
    return case.output_file or f"{DEFAULT_FOLDER}/{case.case_name}.txt"


def parse_setting(setting: str) -> tuple[str, Value]:
    """name=value of the command line, as `Case.replace` takes it."""
    name, equals, word = setting.partition("=")
    if not equals:
        raise Error(f"expected name=value after --set, found {setting}")
    if variables()[find_variable(name)].kind == "text":
        return name, word.strip("'\"")
    try:
        return name, float(word)
    except ValueError:
        return name, word


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", help="namelist file")
    parser.add_argument("--set", metavar="NAME=VALUE", nargs="+", action="extend", default=[],
                        help="replace values of the namelist; group_name where a name is ambiguous")
    parser.add_argument("--output", metavar="FILE", help="the column file (default: as the namelist says, which a case that "
                        "--set changes may not replace)")


def main(args: argparse.Namespace) -> int:
    unchanged = Case.from_namelist(args.namelist)
    settings = dict(map(parse_setting, args.set))
    case = unchanged.replace(**settings)
    if args.output:
        case = case.replace(output_file=args.output)
    elif (any(variables()[find_variable(name)].group != "output" for name in settings)
          and output_path(case) == output_path(unchanged)):
        raise Error(f"{case.label}: expected --output FILE with --set, found none: {output_path(case)} is the file of the "
                    "unchanged case")
    for name, path in ("file", output_path(case)), ("geometry_file", case.geometry_file):
        if path:
            case.check_writable(f"&output {name}", path)
    result = run(case, progress=True)
    result.write(geometry=case.geometry_file)
    print(result.text, end="")
    return 0
