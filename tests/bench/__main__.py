"""What a run costs, against others and against the floor: `make bench`.

usage: python tests/bench [--short] [--only SECTION ...] [--out FOLDER]

Writes bench.csv, one line per figure with median and quartiles, and ldbench_bench.pdf. Nothing here fails
because a machine is slow.
"""
from __future__ import annotations

import argparse
import csv
import importlib
import os
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[1]/"validation"))     # pages and tables are the validation's

from matplotlib.backends.backend_pdf import PdfPages  # noqa: E402

import pages  # noqa: E402
from ldbench.style import ldbench_style  # noqa: E402
from measure import Section  # noqa: E402

SECTIONS = "precision", "steps", "evaluation", "instructions", "cases"
HEAD = "section", "case", "subject", "quantity", "unit", "median", "lower quartile", "upper quartile", "rounds", "note"


def write_csv(path: Path, sections: dict[str, Section]) -> None:
    part = path.with_suffix(".part")
    with part.open("w", newline="") as file:
        out = csv.writer(file)
        out.writerow(HEAD)
        for name, section in sections.items():
            for m in section.measures:
                out.writerow([name, m.case, m.subject, m.quantity, m.unit,
                              *(f"{x:.6g}" for x in (m.median, *m.quartiles)), len(m.values), m.note])
    os.replace(part, path)


def write_pdf(path: Path, sections: dict[str, Section]) -> None:
    part = path.with_suffix(".part")
    with ldbench_style(), PdfPages(part, metadata={"Title": "ldbench: benchmark of speed"}) as pdf:
        for section in sections.values():
            for figure in (*pages.text_pages(section), *section.figures):
                pdf.savefig(figure)
    os.replace(part, path)


def main() -> int:
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__.split("\n")[0])
    parser.add_argument("--short", action="store_true", help="one exercise, few settings, no valgrind")
    parser.add_argument("--only", nargs="+", choices=SECTIONS, default=SECTIONS, help="these sections only")
    parser.add_argument("--out", type=Path, default=Path("outputs"), help="folder of the two files (outputs)")
    args = parser.parse_args()
    args.out.mkdir(exist_ok=True)

    sections = {}
    for name in args.only:
        begin = time.perf_counter()
        section = importlib.import_module(name).section(args.short)
        print(f"{name}: {section.title} ({time.perf_counter() - begin:.0f} s)")
        for m in section.measures:
            if m.headline:
                print(f"  {m.line()}", flush=True)
        sections[name] = section
    write_csv(args.out/"bench.csv", sections)
    write_pdf(args.out/"ldbench_bench.pdf", sections)
    print(f"{args.out/'ldbench_bench.pdf'}, {args.out/'bench.csv'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
