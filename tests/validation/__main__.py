"""Everything checked against an independent answer: `make validate`.

usage: PYTHONPATH=tests/support:profiles python tests/validation [--short] [--only SECTION ...] [--out FOLDER]

Writes ldbench_validation.pdf, validation.csv with one line per check, and validation.json with the tables of the
PDF file, from which the pages of the documentation quote. Says how many checks lie inside their bars; exit status 1
if one does not.
"""
from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterator

import ldbench
from checks import Section
from command import arguments, run_sections, write_csv
from ldbench._core.files import complete
from pages import write_pdf

SECTIONS = "halfspace", "models", "linear", "conicity", "parameters", "quasistatic", "derailment", "rigid", "integration", \
    "sensitivity", "unknown", "measured", "stiffness", "manchester"
HEAD = "section", "quantity", "value", "reference", "source", "deviation", "bar", "verdict"


def lines(section: Section) -> Iterator[str]:
    """For the terminal."""
    for c in section.checks:
        yield (f"{c.verdict:8}{c.quantity}: {c.value:.6g}, {c.source} {c.reference:.6g}, "
               f"deviation {c.deviation:.2e}, bar {c.bar:.0e}")


def main() -> int:
    args = arguments("make validate", __doc__, SECTIONS, {"scipy": "scipy"},
                     short="fewer cases and poses and smaller tables, for the test suite")
    warnings.simplefilter("ignore", ldbench.Warning)        # tables that are coarse on purpose
    sections = run_sections(args, args.short, lines)
    write_csv(args.out/"validation.csv", HEAD, (
        [name, c.quantity, repr(float(c.value)), repr(float(c.reference)), c.source, f"{c.deviation:.3e}",
         f"{c.bar:.1e}", c.verdict]
        for name, section in sections.items() for c in section.checks))
    with complete(args.out/"validation.json") as scratch:
        scratch.write_text(json.dumps({
            name: {table.title: [list(table.head), *map(list, table.rows)] for table in section.tables}
            for name, section in sections.items()}, indent=1, ensure_ascii=False))
    write_pdf(args.out/"ldbench_validation.pdf", sections)
    checks = [c for section in sections.values() for c in section.checks]
    outside = sum(not c.inside for c in checks)
    print(f"{len(checks)} checks, {len(checks) - outside} inside their bars, {outside} outside: "
          f"{args.out/'ldbench_validation.pdf'}, {args.out/'validation.csv'}")
    return int(outside > 0)


if __name__ == "__main__":
    sys.exit(main())
