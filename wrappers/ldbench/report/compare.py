"""Column files laid over each other: the document and the tables of a comparison."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from .._core.files import check_ending, check_written, write_frame
from ..plots.document import save_document
from ..results.run_data import RunData
from .compare_pages import comparison_figures
from .differences import compare, difference_table, event_table, impact_table


def make_comparison(runs: Sequence[RunData], target: Path, align: str = "time") -> list[Path]:
    """Write the PDF of a comparison, and differences, events, peaks and impacts as CSV, SI units."""
    read = [run.file for run in runs]
    check_written([target], read)
    tables = target.with_suffix(".csv")
    check_written([target, tables], read)
    check_ending(target, "a document .pdf, beside which the tables go as .csv", ".pdf")
    found = compare(runs, align)
    save_document([("Comparison", comparison_figures(found))], target, "ldbench: comparison")
    write_frame(pd.concat([difference_table(found), event_table(found.runs), impact_table(found.runs)]), tables)
    return [target, tables]
