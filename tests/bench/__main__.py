"""What a run costs, against others and against the floor: `make bench`.

usage: PYTHONPATH=tests/support:profiles python tests/bench [--only SECTION ...]

Writes outputs/bench.csv, one line per figure with median and quartiles, and ldbench_bench.pdf, whose first page has the five
figures that a reader needs. Nothing here fails because a machine is slow.
"""
from __future__ import annotations

import sys
from collections.abc import Callable, Mapping

from command import OUTPUTS, arguments, run_sections, write_csv
from measure import Measure, Section
from sheets import write_pdf

SECTIONS = "precision", "evaluation", "cases", "ensemble"
HEAD = "section", "case", "subject", "quantity", "unit", "median", "lower quartile", "upper quartile", "rounds", "note"


def summary(sections: Mapping[str, Section]) -> Section:
    """The first page: the five figures that a reader needs, of the sections that were run."""
    def found(name: str, wanted: Callable[[Measure], bool]) -> list[Measure]:
        return [m for m in sections[name].measures if wanted(m)] if name in sections else []

    peers = found("precision", lambda m: "SUNDIALS over ours" in m.quantity)
    nearest = [min((m for m in peers if m.case == case), key=lambda m: m.median) for case in sorted({m.case for m in peers})]
    memory = found("cases", lambda m: m.quantity == "peak memory")
    return Section("What ldbench costs", """Median (quartiles) of the rounds: the cases by the executable, one after the other;
the largest peak memory of one of them; an evaluation of all contact forces; the best of the other integrators over ours at equal
error, compiled, least and largest of the cases; a sweep by two threads over one. A ratio above 1 is in favour of
ldbench. Every figure is on the pages that follow, with what it was measured by. What was not measured this time is left out.""", [
        *found("cases", lambda m: m.case == "all cases"), *sorted(memory, key=lambda m: -m.median)[:1],
        *found("evaluation", lambda m: (m.subject, m.quantity) == ("force", "time of an evaluation"))[-1:],
        *sorted(nearest, key=lambda m: m.median)[::max(len(nearest) - 1, 1)],
        *found("ensemble", lambda m: m.quantity.startswith("times faster"))[-1:]])


def main() -> int:
    args = arguments("make bench", __doc__, SECTIONS)
    sections = run_sections(args.only, lambda module: module.section(), lambda section: (
        m.line() for m in section.measures if m.headline))
    first = summary(sections)
    print(*(m.line() for m in first.measures), sep="\n")
    document, table = OUTPUTS/"ldbench_bench.pdf", OUTPUTS/"bench.csv"
    write_csv(table, HEAD, (
        [name, m.case, m.subject, m.quantity, m.unit, *(f"{x:.6g}" for x in (m.median, *m.quartiles)), len(m.values),
         m.note] for name, section in sections.items() for m in (*section.measures, *section.more)))
    write_pdf(document, "ldbench: benchmark of speed", [first, *sections.values()],
              [figure for section in sections.values() for figure in section.figures])
    print(f"{document}, {table}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
