"""Everything checked against an independent answer: `make validate`.

usage: python tests/validation [--short] [--only SECTION ...] [--out FOLDER]

Writes ldbench_validation.pdf and validation.csv, one line per check, and says how many lie inside
their bars; exit status 1 if one does not.
"""
from __future__ import annotations

import argparse
import csv
import importlib
import os
import sys
import time
from pathlib import Path

from checks import Section
from pages import write_pdf

SECTIONS = "halfspace", "models", "linear", "conicity", "quasistatic", "integration", "sensitivity"
HEAD = "section", "quantity", "value", "reference", "source", "deviation", "bar", "verdict"


def write_csv(path: Path, sections: dict[str, Section]) -> None:
    part = path.with_suffix(".part")
    with part.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(HEAD)
        for name, section in sections.items():
            for c in section.checks:
                out.writerow([name, c.quantity, repr(c.value), repr(c.reference), c.source,
                              f"{c.deviation:.3e}", f"{c.bar:.1e}", c.verdict])
    os.replace(part, path)


def main() -> int:
    parser = argparse.ArgumentParser(prog="make validate", description=__doc__.split("\n")[0])
    parser.add_argument("--short", action="store_true", help="fewer cases and poses, for the test suite")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS, help="these sections only")
    parser.add_argument("--out", type=Path, default=Path("outputs"), help="folder of the two files (outputs)")
    args = parser.parse_args()
    args.out.mkdir(exist_ok=True)

    sections = {}
    for name in args.only:
        begin = time.perf_counter()
        section = sections[name] = importlib.import_module(name).section(args.short)
        print(f"{name}: {section.title} ({time.perf_counter() - begin:.0f} s)")
        for c in section.checks:
            print(f"  {c.verdict:8}{c.quantity}: {c.value:.6g}, {c.source} {c.reference:.6g}, "
                  f"deviation {c.deviation:.2e}, bar {c.bar:.0e}", flush=True)
    write_csv(args.out/"validation.csv", sections)
    write_pdf(args.out/"ldbench_validation.pdf", sections)
    checks = [c for section in sections.values() for c in section.checks]
    outside = sum(not c.inside for c in checks)
    print(f"{len(checks)} checks, {len(checks) - outside} inside their bars, {outside} outside: "
          f"{args.out/'ldbench_validation.pdf'}, {args.out/'validation.csv'}")
    return int(outside > 0)


if __name__ == "__main__":
    sys.exit(main())
