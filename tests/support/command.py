"""What the commands `make validate` and `make bench` share: their options, the round of the sections, the CSV file."""
from __future__ import annotations

import argparse
import csv
import importlib
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from ldbench._core.files import complete

OUTPUTS = Path("outputs")


def arguments(program: str, about: str, sections: Sequence[str]) -> argparse.Namespace:
    """The options of a program. OUTPUTS is there afterwards."""
    parser = argparse.ArgumentParser(prog=program, description=about.split("\n")[0])
    parser.add_argument("--only", nargs="+", choices=sections, default=sections, help="these sections only")
    OUTPUTS.mkdir(exist_ok=True)
    return parser.parse_args()


def run_sections(names: Iterable[str], made: Callable[[Any], Any], lines: Callable[[Any], Iterable[str]]) -> dict[str, Any]:
    """What is made of the sections' modules, by name; prints title, time and `lines` of each."""
    sections = {}
    for name in names:
        begin = time.perf_counter()
        section = sections[name] = made(importlib.import_module(name))
        print(f"{name}: {section.title} ({time.perf_counter() - begin:.0f} s)")
        for line in lines(section):
            print(f"  {line}", flush=True)
    return sections


def write_csv(path: Path, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    with complete(path) as scratch, scratch.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(head)
        out.writerows(rows)
