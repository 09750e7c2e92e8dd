"""Short tables that a notebook shows for a case, a run and a contact table."""
from __future__ import annotations

from collections.abc import Sequence
from html import escape


def html_table(title: str, rows: Sequence[tuple[str, ...]], head: Sequence[str] = ()) -> str:
    """Make an HTML table of texts; markup in the texts is escaped."""
    def row(cells: Sequence[str], tag: str) -> str:
        first, *rest = (escape(str(cell)) for cell in cells)
        return (f'<tr><{tag} style="text-align: left">{first}</{tag}>'
                + "".join(f'<{tag} style="text-align: left">{cell}</{tag}>' for cell in rest) + "</tr>")

    return (f"<table><caption style=\"text-align: left\"><b>{escape(title)}</b></caption>"
            + (f"<thead>{row(head, 'th')}</thead>" if head else "")
            + "<tbody>" + "".join(row(cells, "td") for cells in rows) + "</tbody></table>")
