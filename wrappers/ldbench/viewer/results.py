"""The ten results as one page: a summary whose numbers open their moments, and every run one click away."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..geometry.pressures import FLANGES
from ..results.answers import answers
from ..results.header import read_comments
from ..results.quantities import OUTCOME
from ..results.run_data import RunData, read_data
from ..results.summary import CHAOTIC_NOTE, SUMMARY, shown, summary_row
from ..results.twins import Chaotic
from .page import Page, make_page, number

FIRST_PEAK = "first_peak_N_LF"
TITLE = "LD benchmark: single wheelset without friction, all results"


def find_variants(files: Sequence[Path]) -> list[Path]:
    """Column files of other models and formulations: beside a case's file with its name and one more word, such as
    ex2_aw_hertz.txt, and those with another contact law that `study contact-law` left."""
    found = []
    for file in files:
        study = file.parent/"study"/f"{file.stem}_law.txt"
        beside = sorted(file.parent.glob(f"{file.stem}_*.txt"))
        found += [other for other in (*beside, study) if other.is_file() and other not in files and read_comments(other).settings]
    return found


def results_page(runs: Sequence[RunData], variants: Sequence[Path] = (), chaotic: Chaotic | None = None,
                 bodies: Mapping[str, tuple[float, float]] | None = None) -> Page:
    """All runs, the first one shown; `variants` can be laid over the case that they are named after.
    `chaotic` results have ranges. bodies: range of the first peak [N] with the bodies' own elasticity, by the name of the run."""
    others = [read_data(file).named(file.stem) for file in variants]
    rows = {run: summary_row(run) for run in runs}
    summary = [{"words": OUTCOME[key].label, "cells": [number_cell(run, row, key, chaotic or {}) for run, row in rows.items()]}
               for key in SUMMARY]
    if bodies:
        summary.insert(SUMMARY.index(FIRST_PEAK) + 1, {
            "words": f"{OUTCOME[FIRST_PEAK].label}, wheel and rail as bodies",
            "cells": [cell(run, of_bodies(run, bodies), None) for run in runs]})        # no moment of these runs
    if others:
        summary.append({"words": "side by side with", "cells": [cell_beside(run, others) for run in runs]})
    return make_page([*runs, *others], TITLE, shown=1, summary=summary, note=CHAOTIC_NOTE if chaotic else "", beside=others,
                     patches=FLANGES)


def cell(run: RunData, text: str, time: float | None, others: Sequence[str] = ()) -> dict[str, object]:
    """A cell of the summary table, which opens its run at the moment at which its number holds, with other runs."""
    return {"text": text, "run": run.name, "t": number(time), "with": others}


def number_cell(run: RunData, row: dict[str, Any], key: str, chaotic: Chaotic) -> dict[str, object]:
    """The cell of a result."""
    text = shown(row, key, chaotic).line
    return cell(run, text, None if text == "–" else moment(run, key))


def of_bodies(run: RunData, bodies: Mapping[str, tuple[float, float]]) -> str:
    """The range of a run's first peak with the bodies' own elasticity."""
    return " to ".join(OUTCOME[FIRST_PEAK].text(peak) for peak in bodies[run.name]) if run.name in bodies else "–"


def cell_beside(run: RunData, others: Sequence[RunData]) -> dict[str, object]:
    """The cell that lays other runs of a case over it."""
    mine = [other for other in others if other.name.startswith(f"{run.name}_")]
    words = ", ".join(other.law or other.name for other in mine)
    return cell(run, words or "–", run.time[0] if mine else None, [other.name for other in mine])


def moment(run: RunData, key: str) -> float | None:
    """Time [s] of the number of the summary that is called `key`; None for a number of no moment."""
    known = answers(run)
    what, _, contact = key.rpartition("_")
    if contact in FLANGES and what in ("pmax", "patch", "approach"):
        return known[f"t_first_peak_{contact}"]
    if what in ("first_duration", "first_impulse"):
        return known[f"t_first_{contact}"]
    times = key if key.startswith("t_") else "", f"t_{key}", f"t_{key.replace('_N_', '_')}", f"t_{key.removeprefix('F_')}"
    return next((known[name] for name in times if name in known), None)
