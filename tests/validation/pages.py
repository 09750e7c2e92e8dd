"""The PDF of the validation: an overview of all checks, then text, tables and figures of each section."""
from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from pypdf import PdfReader, PdfWriter

import ldbench
from checks import Check, Section, number
from ldbench._core.files import complete
from ldbench.plots.style import GREY, ldbench_style
from sheets import HEIGHT, RIGHT, WIDTH, Sheets, Table, text_pages

OVERVIEW = "section", "quantity", "value", "reference", "source of the reference", "deviation", "bar", "verdict"


def write_pdf(path: Path, sections: dict[str, Section]) -> None:
    """Write the document; same sections, same bytes. It appears under its name when it is complete."""
    writer, pages = PdfWriter(), io.BytesIO()
    with ldbench_style(), PdfPages(pages, metadata={"CreationDate": None, "ModDate": None}) as pdf:
        chapters = [("Overview", "overview", overview(sections)),
                    *((s.title, name, (*text_pages(s), *s.figures)) for name, s in sections.items())]
        for _, name, figures in chapters:
            for figure in figures:
                save(pdf, figure, name)
    writer.append(PdfReader(pages), import_outline=False)
    k = 0
    for title, _, figures in chapters:
        chapter = writer.add_outline_item(title=title, page_number=k)
        for figure in figures:
            writer.add_outline_item(title=figure.texts[0].get_text(), page_number=k, parent=chapter)
            k += 1
    writer.add_metadata({"/Title": f"ldbench {ldbench.__version__}: validation"})
    with complete(path) as scratch:
        writer.write(scratch)


def save(pdf: PdfPages, figure: Figure, name: str) -> None:
    """Write a page with a footer."""
    footer = figure.text(RIGHT/WIDTH, 7/HEIGHT, f"ldbench {ldbench.__version__}, validation: {name}, "
                         f"page {pdf.get_pagecount() + 1}", fontsize=6.5, ha="right", va="bottom", color=GREY)
    pdf.savefig(figure)
    footer.remove()


def overview(sections: dict[str, Section]) -> list[Figure]:
    """What was checked, how many checks hold, and all of them."""
    checks = [c for s in sections.values() for c in s.checks]
    outside = sum(not c.inside for c in checks)
    sheets = Sheets("ldbench validation")
    sheets.paragraph(
        f"ldbench {ldbench.__version__}. Every number here is compared with an answer that was found without the code "
        "that is checked: a closed form, another numerical method, or a solution refined until it no longer changes. "
        "The bar is the largest deviation that the stated error estimate allows; it was fixed beforehand. "
        f"{len(checks)} checks: {len(checks) - outside} inside their bars, {outside} outside.")
    sheets.table(Table("Sections", ("section", "", "checks", "inside", "largest deviation over its bar"), [
        (name, s.title, str(len(s.checks)), str(sum(c.inside for c in s.checks)), nearest(s.checks))
        for name, s in sections.items()]))
    sheets.table(Table("All checks", OVERVIEW, [
        (name, c.quantity, number(c.value), number(c.reference), c.source, f"{c.deviation:.1e}", f"{c.bar:.0e}",
         c.verdict) for name, s in sections.items() for c in s.checks]))
    return sheets.figures


def nearest(checks: Sequence[Check]) -> str:
    """The check that comes nearest to its bar, or exceeds it most."""
    shares = [(c.deviation/c.bar, c.quantity) for c in checks if c.bar > 0]
    return "" if not shares else "{:.2g}: {}".format(*max(shares))
