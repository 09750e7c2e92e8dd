"""Solve what the contact table needs for the run of a case and keep it in the case's table folder; print what the table says of the
rigid and the resting wheelset.

examples:
  python -m ldbench table inputs/ex1_aw.nml
  python -m ldbench table inputs/ex1_aw.nml -o outputs/geometry_aw.txt
"""
from __future__ import annotations

import argparse
import textwrap
from pathlib import Path

from .._core.files import check_written
from ..case import Case
from ..runs import ComputedRun, compute
from .options import add_json, add_output, add_set, print_json, settings

WIDTH = 100         # longest line on the terminal [characters], as in fortran/program/run_results.f90


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelist", metavar="NAMELIST", help="namelist file")
    add_set(parser)
    add_output(parser, "write the geometry functions over the lateral displacement")
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    case = Case.from_namelist(args.namelist).replace(settings(args.set))
    if args.output:
        check_written([Path(args.output)], map(Path, (args.namelist, *case.files().values())))
    run = compute(case, progress=True)
    table = run.table
    if args.output:
        table.write_geometry(args.output)
    if args.json:
        print_json(facts(run), run.warnings)
        return 0
    print(f"{case.case_name}: {case.title}", *table.lines(), sep="\n")
    for place, (rms, largest) in run.header.table_errors.items():
        print(f"error of the contact force, {place}: rms {rms:.1e}, largest {largest:.1e} of max(|F|, 5 kN) in poses of the run")
    for words in run.warnings:
        print(textwrap.fill(f"warning: {words}", WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False))
    if args.output:
        print(f"geometry functions: {args.output}")
    return 0


def facts(run: ComputedRun) -> dict[str, object]:
    """Collect the properties of the table for other programs."""
    table = run.table
    solved, found, failed = table.solutions
    return {
        "case": table.case.case_name, "profiles": table.case.profile_files(), "model": table.case.model,
        "formulation": table.case.formulation, "clearance_left": table.clearance, "clearance_right": table.clearance_right,
        "axle_height": table.equilibrium, "axle_roll": table.equilibrium_roll, "sinking": table.sinking,
        "load_per_wheel": table.load_per_wheel, "frequencies": table.frequencies,
        "solutions": {"solved": solved - found, "found": found, "not_converged": failed}, "folder": table.case.kept_folder,
        "error": {place: {"rms": rms, "largest": largest} for place, (rms, largest) in run.header.table_errors.items()}}
