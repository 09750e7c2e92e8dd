"""Put together what a participant sends by the call, a folder or a zip: ten column files, the PDF of plots, the abstract of at
most four pages, and submission.toml.

The folder that is given has them, as `report` makes them: files whose names say the simulation, such as ex2_aw.csv, one PDF with
plot in its name and one with abstract, and submission.toml with the keys code, version, authors, organisation, email and
formulation.
Each column file is checked as `check` does it. What is missing or refused is a line each, and then nothing is written. In the
result the files are exN_PAIR.ENDING, plots.pdf, abstract.pdf, submission.toml and SHA256SUMS, the list of checksums. A folder or a
zip that is there is replaced only if this command has written it and nobody has changed it since.

examples:
  python -m ldbench submit outputs --template
  python -m ldbench submit outputs -o submission
  python -m ldbench submit outputs -o submission.zip
"""
from __future__ import annotations

import argparse
from pathlib import Path

from ldbench import Error
from ldbench.commands.options import add_json, print_json
from ldbench.constants import DESCRIPTION
from ldbench.tools import counted

from ..submit import check_own, gather, send, write_template


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="the folder with all files")
    parser.add_argument("-o", "--output", type=Path, metavar="DIR|FILE.zip", default=Path("submission.zip"),
                        help="the folder, or the zip if the name ends in .zip (%(default)s)")
    parser.add_argument("--template", action="store_true", help="write only submission.toml into FOLDER, to be filled in")
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    if args.template:
        written = write_template(args.folder)
        if args.json:
            print_json({"written": str(written), "files": [written.name], "missing": []})
        else:
            print(f"{written}: fill in its keys")
        return 0
    check_own(args.output)
    parcel = gather(args.folder)
    if parcel.missing:
        if args.json:
            print_json({"written": None, "files": [], "missing": list(parcel.missing)})
        else:
            print(*parcel.missing, sep="\n")
            template = "" if (args.folder/DESCRIPTION).exists() else (
                f"; `ldbench submit {args.folder} --template` writes {DESCRIPTION}, to be filled in")
            raise Error(file=args.folder, expected="all that a participant sends", advice=f"nothing is written{template}",
                        found=f"{counted(len(parcel.missing), 'thing')} missing or refused, each in a line above")
        return 1
    names = send(parcel, args.output)
    if args.json:
        print_json({"written": str(args.output), "files": names, "missing": []})
    else:
        print(*(f"  {name}" for name in names), f"{args.output}: {counted(len(names), 'file')}", sep="\n")
    return 0
