"""What the commands `make validate` and `make bench` share: their options, the round of the sections, the CSV file."""
from __future__ import annotations

import argparse
import csv
import importlib
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ldbench._core.errors import Error
from ldbench._core.files import complete
from ldbench._core.optional import needed


def arguments(program: str, about: str, sections: Sequence[str], modules: Mapping[str, str], **forms: str) -> argparse.Namespace:
    """The options of a program; `forms` says what another form, `short` or `full`, leaves out or adds. `modules` are needed, by
    the packages that have them. The folder is there afterwards."""
    parser = argparse.ArgumentParser(prog=program, description=about.split("\n")[0])
    for form, text in forms.items():
        parser.add_argument(f"--{form}", action="store_true", help=text)
    parser.add_argument("--only", nargs="+", choices=sections, default=sections, help="these sections only")
    parser.add_argument("--out", type=Path, default=Path("outputs"), help="folder of the two files (outputs)")
    args = parser.parse_args()
    try:
        for package, module in modules.items():
            needed(module, "validate", package)
    except Error as error:
        parser.exit(1, f"ldbench: error: {error}\n")
    args.out.mkdir(exist_ok=True)
    return args


def run_sections(args: argparse.Namespace, form: object, lines: Callable[[Any], Iterable[str]]) -> dict[str, Any]:
    """What the sections' modules return, by name, in that form; prints title, time and `lines` of each."""
    sections = {}
    for name in args.only:
        begin = time.perf_counter()
        section = sections[name] = importlib.import_module(name).section(form)
        print(f"{name}: {section.title} ({time.perf_counter() - begin:.0f} s)")
        for line in lines(section):
            print(f"  {line}", flush=True)
    return sections


def write_csv(path: Path, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with complete(path) as scratch, scratch.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(head)
        out.writerows(rows)
