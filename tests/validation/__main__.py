"""Everything checked against an independent answer: `make validate`.

usage: PYTHONPATH=tests/support:profiles python tests/validation [--only SECTION ...]

Writes outputs/ldbench_validation.pdf, validation.csv with one line per check, and validation.json with the tables of the PDF
file, from which the pages of the documentation quote. Says how many checks lie inside their bars; exit status 1 if one does
not.
"""
from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Iterator, Mapping

import ldbench
from checks import SECTIONS, Section
from command import OUTPUTS, arguments, run_sections, write_csv
from ldbench._core.files import complete
from sheets import Table, write_pdf

HEAD = "section", "quantity", "value", "reference", "source", "deviation", "bar", "verdict"


def lines(section: Section) -> Iterator[str]:
    """For the terminal."""
    for c in section.checks:
        yield (f"{c.verdict:8}{c.quantity}: {c.value:.6g}, {c.source} {c.reference:.6g}, "
               f"deviation {c.deviation:.2e}, bar {c.bar:.0e}")


def overview(sections: Mapping[str, Section], said: str) -> Section:
    """What was checked, how many checks hold, and all of them; of each section the check that comes nearest to its bar."""
    nearest = {name: "{:.2g}: {}".format(*max(((c.deviation/c.bar, c.quantity) for c in s.checks if c.bar > 0), default=(0, "")))
               for name, s in sections.items()}
    return Section("ldbench validation", f"""ldbench {ldbench.__version__}. Every number here is compared with an answer that was
found without the code that is checked: a closed form, another numerical method, or a solution refined until it no longer
changes. The bar is the largest deviation that the stated error estimate allows; it was fixed beforehand. {said}.""", tables=[
        Table("Sections", ("section", "", "checks", "inside", "largest deviation over its bar"), [
            (name, s.title, str(len(s.checks)), str(sum(c.inside for c in s.checks)), nearest[name])
            for name, s in sections.items()]),
        Table("All checks", HEAD, [
            (name, c.quantity, f"{c.value:.5g}", f"{c.reference:.5g}", c.source, f"{c.deviation:.1e}", f"{c.bar:.0e}", c.verdict)
            for name, s in sections.items() for c in s.checks])])


def main() -> int:
    args = arguments("make validate", __doc__, SECTIONS)
    warnings.simplefilter("ignore", ldbench.Warning)        # tables that are coarse on purpose
    sections = run_sections(args.only, lambda module: module.section(), lines)
    document, table = OUTPUTS/"ldbench_validation.pdf", OUTPUTS/"validation.csv"
    write_csv(table, HEAD, (
        [name, c.quantity, repr(float(c.value)), repr(float(c.reference)), c.source, f"{c.deviation:.3e}",
         f"{c.bar:.1e}", c.verdict]
        for name, section in sections.items() for c in section.checks))
    with complete(OUTPUTS/"validation.json") as scratch:
        scratch.write_text(json.dumps({
            name: {table.title: [list(table.head), *map(list, table.rows)] for table in section.tables}
            for name, section in sections.items()}, indent=1, ensure_ascii=False))
    checks = [c for section in sections.values() for c in section.checks]
    outside = sum(not c.inside for c in checks)
    said = f"{len(checks)} checks, {len(checks) - outside} inside their bars, {outside} outside"
    write_pdf(document, f"ldbench {ldbench.__version__}: validation", [overview(sections, said), *sections.values()])
    print(f"{said}: {document}, {table}")
    return int(outside > 0)


if __name__ == "__main__":
    sys.exit(main())
