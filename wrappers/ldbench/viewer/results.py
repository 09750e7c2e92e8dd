"""The ten results as one page: a summary whose numbers open their moments, and every run one click away."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..geometry.pressures import FLANGES, full_row
from ..results.header import read_header
from ..results.quantities import OUTCOME
from ..results.run_data import RunData, read_data
from ..results.summary import CHAOTIC_NOTE, SUMMARY, Chaotic, shown
from .page import Page, make_page, number

TITLE = "LD benchmark: single wheelset without friction, all results"


def find_variants(files: Sequence[Path]) -> list[Path]:
    """Column files of other models and formulations: beside a case's file with its name and one more word, such as
    ex2_aw_hertz.txt, and those with another contact law that `study contact-law` left."""
    found = []
    for file in files:
        study = file.parent/"study"/f"{file.stem}_law.txt"
        beside = sorted(file.parent.glob(f"{file.stem}_*.txt"))
        found += [other for other in (*beside, study) if other.is_file() and other not in files and read_header(other).settings]
    return found


def results_page(runs: Sequence[RunData], variants: Sequence[Path] = (), chaotic: Chaotic | None = None) -> Page:
    """All runs, the first one shown; `variants` can be laid over the case that they are named after.
    `chaotic` results are in italics."""
    others = [read_data(file).named(file.stem) for file in variants]
    rows = {run: full_row(run) for run in runs}
    summary = [{"words": OUTCOME[key].label, "cells": [number_cell(run, row, key, chaotic or {}) for run, row in rows.items()]}
               for key in SUMMARY]
    if others:
        summary.append({"words": "side by side with", "cells": [cell_beside(run, others) for run in runs]})
    return make_page([*runs, *others], TITLE, shown=1, summary=summary, note=CHAOTIC_NOTE if chaotic else "", beside=others,
                     patches=FLANGES)


def cell(run: RunData, text: str, time: float | None, others: Sequence[str] = (), leaning: bool = False) -> dict[str, object]:
    """A cell of the summary table, which opens its run at the moment at which its number holds, with other runs."""
    return {"text": text, "run": run.name, "t": number(time), "with": others, "leaning": leaning}


def number_cell(run: RunData, row: dict[str, Any], key: str, chaotic: Chaotic) -> dict[str, object]:
    """The cell of a result."""
    text, leaning = shown(row, key, chaotic)
    return cell(run, text, None if text == "–" else moment(run, row, key), leaning=leaning)


def cell_beside(run: RunData, others: Sequence[RunData]) -> dict[str, object]:
    """The cell that lays other runs of a case over it."""
    mine = [other for other in others if other.name.startswith(f"{run.name}_")]
    words = ", ".join(str(other.setting("contact", "model") or other.name) for other in mine)
    return cell(run, words or "–", run.time[0] if mine else None, [other.name for other in mine])


def moment(run: RunData, row: dict[str, Any], key: str) -> float | None:
    """Time [s] of the number of the summary that is called `key`; None for a number of no moment."""
    what, _, end = key.rpartition("_")
    if key.startswith("t_"):
        return row[key]
    if key == "F_derailment":
        return row["t_derailment"]
    if what.endswith("peak_N"):
        return row[f"t_{what.removesuffix('_N')}_{end}"]
    if what in ("pmax", "patch"):
        return row[f"t_pmax_{end}"]
    if key == "drift":
        return run.time[np.nanargmax(np.abs(run.values("E_drift")))]
    if end in ("min", "max") and what in ("Y", "Z", "roll"):
        x = run.values(what)
        return run.time[np.nanargmin(x) if end == "min" else np.nanargmax(x)]
    return None
