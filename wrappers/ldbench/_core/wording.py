"""Numbers of things in words, and short tables that a notebook shows for a case, a run and a contact table."""
from __future__ import annotations

from collections.abc import Sequence
from html import escape


def counted(n: int, noun: str) -> str:
    """Name a number of things by a noun in the singular: '1 run', '2 runs'."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def html_table(title: str, rows: Sequence[tuple[str, ...]], head: Sequence[str] = ()) -> str:
    """Make an HTML table of texts; markup in the texts is escaped."""
    def row(cells: Sequence[str], tag: str) -> str:
        return "<tr>" + "".join(f'<{tag} style="text-align: left">{escape(str(cell))}</{tag}>' for cell in cells) + "</tr>"

    return (f'<table><caption style="text-align: left"><b>{escape(title)}</b></caption>'
            + (f"<thead>{row(head, 'th')}</thead>" if head else "")
            + "<tbody>" + "".join(row(cells, "td") for cells in rows) + "</tbody></table>")
