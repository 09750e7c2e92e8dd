"""What a run costs, against others and against the floor: `make bench`.

usage: PYTHONPATH=tests/support:profiles python tests/bench [--full] [--only SECTION ...] [--out FOLDER]

Writes bench.csv, one line per figure with median and quartiles, and ldbench_bench.pdf, whose first page has the five
figures that a reader needs. Nothing here fails because a machine is slow.
"""
from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.backends.backend_pdf import PdfPages

from command import arguments, run_sections, write_csv
from ldbench._core.files import complete
from ldbench.plots.style import ldbench_style
from measure import Section
from sheets import text_pages
from summary import summary

SECTIONS = "precision", "evaluation", "cases", "ensemble"
HEAD = "section", "case", "subject", "quantity", "unit", "median", "lower quartile", "upper quartile", "rounds", "note"


def write_pdf(path: Path, sections: dict[str, Section]) -> None:
    title = {"Title": "ldbench: benchmark of speed"}
    with ldbench_style(), complete(path) as scratch, PdfPages(scratch, metadata=title) as pdf:
        for section in (summary(sections), *sections.values()):
            for figure in (*text_pages(section), *section.figures):
                pdf.savefig(figure)


def main() -> int:
    args = arguments("make bench", __doc__, SECTIONS, {"scipy": "scipy"},
                     full="all cases, methods, models and members: 15 minutes instead of 6")
    sections = run_sections(args, args.full, lambda section: (m.line() for m in section.measures if m.headline))
    print(*(f"{what}: {value}" for what, value, _ in summary(sections).tables[0].rows), sep="\n")
    write_csv(args.out/"bench.csv", HEAD, (
        [name, m.case, m.subject, m.quantity, m.unit, *(f"{x:.6g}" for x in (m.median, *m.quartiles)), len(m.values),
         m.note] for name, section in sections.items() for m in section.measures))
    write_pdf(args.out/"ldbench_bench.pdf", sections)
    print(f"{args.out/'ldbench_bench.pdf'}, {args.out/'bench.csv'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
