"""Check submissions to the benchmark: are they complete, and does physics agree with them?

A folder holds the files of one code. Their names say the simulation, such as ex2_aw.csv or exercise3_simplified.txt; other files
are named and left out. No reference is needed: kinematics, momentum and energy have to close, and the motion has to be that of
the exercise. Files of other codes need no map of their columns: the command guesses it from names and from a run of our own.
A finding is passed, doubtful or failed; one failure makes the status 1. Of many columns -v and --json name all.

examples:
  python -m ldbench check outputs
  python -m ldbench check other_code.csv --simulation ex2_aw --save-map other_code.toml
"""
from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from ldbench import Error
from ldbench.commands.options import add_json, add_map, add_simulation, print_json
from ldbench.number_text import number_text
from ldbench.tools import complete

from ..cell_checks import NO_NUMBERS
from ..check import Checked, check_file, check_folder, unlike
from ..findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding, apart_text
from ..tasks import task_named


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("path", type=Path, metavar="FILE|FOLDER", help="a column file, or a folder of them")
    add_simulation(parser)
    parser.add_argument("--save-map", type=Path, metavar="TOML", help="write the map that was guessed for a file")
    parser.add_argument("--show-map", action="store_true", help="print the guessed map, which is always printed if it is doubtful")
    parser.add_argument("--all", action="store_true", help="print what passed, too")
    add_map(parser)
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    folder: list[Finding] = []
    if args.path.is_dir():
        checked, folder = check_folder(args.path, args.map)
    else:
        checked = [check_file(args.path, task_named(args.simulation) if args.simulation else None, args.map)]
    if args.save_map:
        save_map(args.save_map, checked)
    if args.json:
        print_json({"folder": [asdict(finding) for finding in folder], "files": [
            {"file": str(one.file), "simulation": one.task.name, "map": one.guess.toml() if one.guess else None,
             "findings": [asdict(finding) for finding in one.findings]} for one in checked]})
    else:
        if folder:
            print(f"{args.path}: {counts(folder)}")
            print_findings(folder, args.all, args.verbose)
        for one in checked:
            print(f"{one.file}: {one.task.words}; {counts(one.findings)}")
            doubt = bool(one.guess and unlike(one.guess))
            if one.guess and (args.show_map or (doubt and not args.save_map)):
                print(f"  the map of its columns, guessed{' with doubt' if doubt else ''}:")
                print("".join(f"  {line}\n" for line in one.guess.toml().splitlines()), end="")
            print_findings(one.findings, args.all, args.verbose)
    return int(any(finding.verdict == FAILED for findings in (folder, *(one.findings for one in checked)) for finding in findings))


def counts(findings: Sequence[Finding]) -> str:
    """How many findings there are of each kind."""
    found = {verdict: sum(finding.verdict == verdict for finding in findings) for verdict in (PASSED, DOUBTFUL, FAILED, UNKNOWN)}
    return ", ".join(f"{number} {verdict}" for verdict, number in found.items() if number)


def print_findings(findings: Sequence[Finding], everything: bool, whole: bool) -> None:
    """Print a line per finding, with the whole lists of columns if asked for."""
    for finding in findings:
        if finding.verdict == PASSED and not everything and finding.what != NO_NUMBERS:
            continue
        number = "" if finding.number != finding.number else f" {apart_text(finding.number, [finding.limit])}"
        limit = "" if finding.limit != finding.limit else f" (limit {number_text(finding.limit, digits=3, trim=True)})"
        time = "" if finding.time != finding.time else f" at {finding.time:.6g} s"
        row = "" if finding.row is None else f", row {finding.row}{time}"
        hint = f": {told}" if (told := finding.told(whole)) else ""
        print(f"  {finding.verdict}: {finding.what}{number}{limit if number else ''}{row}{hint}")


def save_map(path: Path, checked: Sequence[Checked]) -> None:
    """Write the map of the one file that was checked."""
    maps = [one.guess.toml() for one in checked if one.guess]
    if len(maps) != 1:
        raise Error(file=path, expected="one file whose map is guessed", found=len(maps))
    with complete(path) as scratch:
        scratch.write_text(maps[0], encoding="utf-8")
