"""The PDF files of the validation and of the benchmark: texts, tables, and figures at the end."""
from __future__ import annotations

import json
import re
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from matplotlib.figure import Figure

from ldbench._core.files import complete
from ldbench._core.optional import needed

PAGES = """
#let data = json("data.json")
#set document(title: data.title, date: none)
#set page("a4", flipped: true, margin: 14mm, footer: align(right, context [#data.title, page #counter(page).display()]))
#set text(8pt)
#set table(stroke: (x: none, y: 0.3pt + gray), inset: (x: 3pt, y: 2pt))
#show table.cell.where(y: 0): strong
#let cell(words) = if words == "OUTSIDE" { text(red, strong(words)) } else { words }
#for (k, chapter) in data.chapters.enumerate() {
  if k > 0 { pagebreak() }
  heading(chapter.title)
  for words in chapter.text { par(words) }
  for one in chapter.tables {
    heading(level: 2, one.title)
    table(columns: one.head.len(), table.header(..one.head), ..one.rows.flatten().map(cell))
  }
}
#for file in data.figures { image(file) }
"""


@dataclass
class Table:
    """A table; cells are text."""

    title: str
    head: Sequence[str]
    rows: list[Sequence[str]]


class Chapter(Protocol):
    """What a page needs of a section."""

    title: str
    text: str
    tables: list[Table]


def write_pdf(path: Path, title: str, chapters: Iterable[Chapter], figures: Iterable[Figure] = ()) -> None:
    """Typeset the document; it appears under its name when it is complete."""
    typst = needed("typst", "report")
    with tempfile.TemporaryDirectory() as temporary:
        folder, files = Path(temporary), []
        for figure in figures:
            files.append(f"{len(files)}.svg")
            figure.savefig(folder/files[-1])
        (folder/"data.json").write_text(json.dumps({"title": title, "figures": files, "chapters": [
            {"title": chapter.title, "text": re.split(r"\n\s*\n", chapter.text.strip()),
             "tables": [vars(table) for table in chapter.tables]} for chapter in chapters]}))
        (folder/"pages.typ").write_text(PAGES)
        typst.compile(folder/"pages.typ", output=folder/"pages.pdf", root=folder)
        with complete(path) as scratch:
            shutil.copy(folder/"pages.pdf", scratch)
