"""List what ensembles keep beside a store, or remove it.

Every result of `ensemble -o DIR` is kept in the database .ldbench/DIR.sqlite, whichever sweep made it. A sweep that runs again
computes only what is missing there. Nothing is removed but by this command, which leaves the Zarr directory itself as it is.

examples:
  python -m ldbench store sweep.zarr
  python -m ldbench store sweep.zarr --remove all
"""
from __future__ import annotations

import argparse
from pathlib import Path

from .._core.errors import unknown
from .._core.wording import counted
from ..ensembles.records import Sweep, open_records, read_records, records_file, remove_file
from .options import add_json, print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("store", type=Path, metavar="DIR", help="the Zarr directory of `ensemble -o`")
    parser.add_argument("--remove", metavar="SWEEP", action="append", default=[],
                        help="remove a sweep and the results that no other one has, as often as given; all removes the database, "
                             "of an earlier version, too")
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    file = records_file(args.store)
    if "all" in args.remove:
        remove_file(args.store)
        if args.json:
            print_json({"file": str(file), "removed": "all", "sweeps": []})
        else:
            print(f"{file}: removed")
        return 0
    with read_records(args.store) as records:
        sweeps = records.sweeps()
    removed = 0
    if args.remove:
        names = [sweep.sweep for sweep in sweeps]
        for name in args.remove:
            if name not in names:
                raise unknown(f"a sweep among {', '.join(names)}", name, names, file=file)
        with open_records(args.store, waits=False) as records:
            removed = records.remove(args.remove)
            sweeps = records.sweeps()
    if args.json:
        print_json({"file": str(file), "removed": removed, "sweeps": [sweep._asdict() for sweep in sweeps]})
        return 0
    if args.remove:
        print(f"{counted(removed, 'result')} removed")
    print(f"{file}: {counted(len(sweeps), 'sweep')}", *map(line, sweeps), sep="\n")
    return 0


def line(sweep: Sweep) -> str:
    """A sweep in words."""
    dims = " x ".join(f"{size} {name}" for name, size in sweep.about["dims"].items())
    return (f"  {sweep.sweep}  {sweep.made}  {sweep.about['case']}: {counted(sweep.members, 'member')} ({dims}), "
            f"{sweep.done} done, {sweep.failed} failed")
