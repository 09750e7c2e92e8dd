"""Run cases: integrate the wheelset's motion, write the column files, print the summaries.

Several cases run side by side. A column file has the same bytes as the executable's. A case that --set changes outside
&output needs its own file: give -o, or set another name if the namelist names no file.

examples:
  python -m ldbench run inputs/ex1_aw.nml
  python -m ldbench run inputs/ex1_aw.nml inputs/ex2_aw.nml --json
  python -m ldbench run inputs/ex1_aw.nml --set dt=1e-5 --set order=2 -o coarse.txt
  python -m ldbench run inputs/ex3_sw.nml --set contact_model=hertz -o outputs/ex3_sw_hertz.txt
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.calls import Progress
from .._core.errors import Usage
from .._core.files import check_written
from .._core.pools import in_threads, one_of_each
from ..case import Case, Value
from ..ensembles.members import table_keys
from ..runs import Run, check_own_file, compute, output_path
from .options import LOG, add_jobs, add_json, add_output, add_set, print_json, settings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("namelists", nargs="+", metavar="NAMELIST", help="namelist files")
    add_set(parser)
    add_output(parser, "the column file of one case (default: as the namelist says, unless --set changes the case)")
    add_json(parser)
    add_jobs(parser)


def main(args: argparse.Namespace) -> int:
    if args.output and len(args.namelists) > 1:
        raise Usage(place="-o", expected="one namelist", found=len(args.namelists))
    cases = [chosen(namelist, settings(args.set), args.output) for namelist in args.namelists]
    for case in cases:
        case.check_writable(output_path(case))
    check_written([Path(output_path(case)) for case in cases], map(Path, args.namelists))
    if len(cases) == 1:
        show(written(cases[0], True), 0, args.json)
        return 0

    def work(number: int, stopping: Progress) -> Run:
        return written(cases[number], stopping)

    waiting: dict[int, Run] = {}
    told = 0
    table = table_keys()
    for batch in one_of_each(range(len(cases)), lambda number: cases[number].table_folder and table(cases[number])):
        for number, result in in_threads(work, batch, args.jobs):
            waiting[number] = result
            while told in waiting:          # a result is printed when those before it are
                show(waiting.pop(told), told, args.json)
                told += 1
    return 0


def written(case: Case, progress: Progress | bool) -> Run:
    """Run a case and write its files."""
    result = compute(case, progress)
    LOG.info("written: %s", result.write(output_path(case)))
    if words := result.unkept:
        LOG.warning("%s", words)
    return result


def show(result: Run, number: int, as_json: bool) -> None:
    """Print the summary of a run, or its results for other programs."""
    if as_json:
        print_json(facts(result), result.warnings)
    else:
        print("\n"*(number > 0) + result.text, end="")


def chosen(namelist: str, changes: dict[str, Value], output: str | None) -> Case:
    """Make the case that the arguments describe; a changed case needs a column file of its own."""
    case = Case.from_namelist(namelist).replace(changes)
    if output:
        return case.replace(output_file=output)
    check_own_file(case, "-o FILE with --set")
    return case


def facts(result: Run) -> dict[str, object]:
    """Collect the results of a run for other programs."""
    return {"case": result.name, "file": str(result.file), "end": result.ending, **result.results, "seconds": result.seconds,
            "events": [event._asdict() for event in result.events]}
