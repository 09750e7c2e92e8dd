"""Collate the submissions of a round: one table, one document and one page of all codes.

The folder has a folder for each code: files whose names say the simulation, such as ex2_aw.csv, and a description
submission.toml: code, version, authors, formulation, restitution, law, step, contact_force, machine, processor_time, map (all
optional).
Without a map the command guesses the columns, as `check` does. With --reference every file is scored and graded, as `score`
does; a code that states its restitution is scored against our own run with rigid contacts if the reference is elastic.
Results: collation.csv (code, simulation, number, value), collation.pdf and collation.html; with codes whose contact_force is
"given", contact_forces.csv: medians and spreads of these codes and of the others. DIR/.ldbench keeps what was read, so
that a late submission costs its own files alone. A line is printed for each file that could not be used.

examples:
  python -m ldbench collate codes
  python -m ldbench collate codes -o round_2
  python -m ldbench collate codes -o graded --reference outputs
"""
from __future__ import annotations

import argparse
from pathlib import Path

from ldbench import Error
from ldbench.commands.options import add_folder, add_jobs, add_reference
from ldbench.tools import counted, kept_in, make_results_folder

from ..collation import collate, write_csv
from ..collation_html import make_page
from ..collation_pdf import make_document
from ..contact_groups import FILE, write_groups
from ..kept_entries import find_references


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="a folder that holds a folder for each code")
    add_folder(parser, "where the results go")
    add_reference(parser)
    add_jobs(parser, "files read side by side")


def main(args: argparse.Namespace) -> int:
    if not args.folder.is_dir():
        raise Error(file=args.folder, expected="a folder that holds a folder for each code", found="none")
    if not any(path.is_dir() and not path.name.startswith(".") for path in args.folder.iterdir()):
        raise Error(file=args.folder, expected="a folder for each code", found="none")
    references = find_references(args.reference) if args.reference else None
    store = kept_in(args.output)
    make_results_folder(args.output)
    store.mkdir(exist_ok=True)
    found = collate(args.folder, store, args.jobs, args.output, references=references)
    for line in found.lines():
        print(line)
    if not found.used:
        raise Error(file=args.folder, expected="a file that can be used", found="none")
    files = [args.output/f"collation{ending}" for ending in (".csv", ".pdf", ".html")]
    write_csv(found, files[0])
    make_document(found, files[1])
    make_page(found).write(files[2])
    if write_groups(found, args.output/FILE):
        files.append(args.output/FILE)
    print(f"{counted(len(found.codes), 'code')}, {found.used} of {len(found.entries)} files used, {len(found.computed)} read")
    print("\n".join(str(file) for file in files))
    return 0
