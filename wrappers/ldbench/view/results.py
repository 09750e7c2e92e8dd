"""The ten results as one page: a summary whose numbers open their moments, and every run one click away."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..plots import SUMMARY_LINES
from ..record import Record, read_header, read_record, summary_row
from .page import Cell, Page, make_page

TITLE = "LD benchmark: single wheelset without friction, all results"
VARIANT_CELLS = 100_000         # numbers that are kept whole of a run that is there for comparison


def find_variants(files: Sequence[Path]) -> list[Path]:
    """Column files of other models and formulations: beside a case's file with its name and one more word, such as
    ex2_aw_hertz.txt, and those with another contact law that `compare --study` left."""
    found = []
    for file in files:
        study = file.parent/"study"/f"{file.stem}_law.txt"
        beside = sorted(file.parent.glob(f"{file.stem}_*.txt"))
        found += [other for other in (*beside, study) if other.is_file() and other not in files and
                  read_header(other)["settings"]]
    return found


def results_page(records: Sequence[Record], variants: Sequence[Path] = ()) -> Page:
    """All runs, the first one shown; `variants` can be laid over the case that they are named after."""
    others = [replace(read_record(file), name=file.stem) for file in variants]
    rows = [summary_row(record) for record in records]
    summary = []
    for words, key, write in SUMMARY_LINES:
        cells = []
        for record, row in zip(records, rows, strict=True):
            x = row.get(key)
            text = "–" if x is None or (text := write(x)) == "nan" else text
            cells.append(Cell(text, record.name, None if text == "–" else moment(record, row, key)))
        summary.append((words, cells))
    if others:
        summary.append(("side by side with", [beside(record, others) for record in records]))
    return make_page([*records, *others], TITLE, shown=1, summary=summary,
                     cells={other.name: VARIANT_CELLS for other in others})


def beside(record: Record, others: Sequence[Record]) -> Cell:
    mine = [other for other in others if other.name.startswith(f"{record.name}_")]
    words = ", ".join(str(other.setting("contact", "model") or other.name) for other in mine)
    return Cell(words or "–", record.name, float(record.time[0]) if mine else None, tuple(o.name for o in mine))


def moment(record: Record, row: dict[str, Any], key: str) -> float | None:
    """Time [s] of the number of the summary that is called `key`; None for a number of no moment."""
    if key.startswith("t_"):
        return float(row[key])
    if key == "F_derailment":
        return float(row["t_derailment"])
    if key.startswith("N_max_"):
        t = row[f"t_{key}"]
        return None if t is None or not np.isfinite(t) else float(t)
    quantity, _, end = key.rpartition("_")
    if end in ("min", "max") and quantity in ("Y", "Z", "roll", "E_drift"):
        x = record.values(quantity)
        return float(record.time[int(np.nanargmin(x) if end == "min" else
                                     np.nanargmax(np.abs(x) if quantity == "E_drift" else x))])
    return None
