"""The page of a collation: matrix, curves and numbers of all codes in one HTML file that asks the network for nothing."""
from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ldbench import __version__
from ldbench.constants import CONTACT_NAMES, KN
from ldbench.plots.stretches import thin
from ldbench.viewer.page import FOLDER as VIEWER, Page, fill

from .collation import Collation
from .collation_pdf import opening, shown_until
from .kept_entries import IMPACTS, Entry
from .round_numbers import NUMBERS, main_number, names_of
from .submissions import FACTS
from .tasks import Task

STATIC = Path(__file__).resolve().parent/"static"
SCRIPTS = VIEWER/"decode.js", VIEWER/"number_text.js", STATIC/"collation.js"
POINTS = 200            # columns of a curve, of each the smallest and the largest value
CHARTS = {"Y": ("lateral displacement Y", "mm", 1e3), "roll": ("roll Φ", "mrad", 1e3), "energy": ("energy − start", "J", 1.0),
          **{name: (f"normal force, {CONTACT_NAMES[name[2:]]}, first contact", "kN", KN) for name in IMPACTS}}


def make_page(found: Collation, title: str = "Collation of codes") -> Page:
    """The page of a collation."""
    facts: dict[str, Any] = {
        "title": title, "version": __version__, "lines": found.lines(), "keys": FACTS,
        "tasks": [{"name": task.name, "words": task.words, "main": main_number(task), "numbers": names_of(task)}
                  for task in found.tasks],
        "numbers": {name: one._asdict() for name, one in NUMBERS.items()},
        "charts": [{"name": name, "words": words, "unit": unit, "scale": scale, "impact": name in IMPACTS}
                   for name, (words, unit, scale) in CHARTS.items()],
        "codes": [{"name": code.name, "facts": dict(code.facts), "entries": [entry_facts(found.entry(code, task), task)
                                                                            for task in found.tasks]} for code in found.codes]}
    return Page(fill(title, facts, [], STATIC/"collation.html", SCRIPTS))


def entry_facts(entry: Entry | None, task: Task) -> dict[str, Any] | None:
    """What the page holds of one simulation of one code."""
    if entry is None:
        return None
    known = {name: entry.numbers[name] for name in names_of(task) if name in entry.numbers}
    return {"shade": entry.shade, "error": entry.error, "findings": list(entry.findings), "verdict": dict(entry.verdict),
            "until": rounded(shown_until(entry)),
            "numbers": {name: rounded(x.value) for name, x in known.items()},
            "reasons": {name: x.reason for name, x in known.items() if x.reason},
            "opening": {name: rounded(opening(*entry.curves[name])) for name in IMPACTS if name in entry.curves},
            "curves": {name: [[rounded(x, 5) for x in numbers] for numbers in thin(*curve, POINTS)]
                       for name, curve in entry.curves.items() if len(curve[0]) > 1}}


def rounded(x: float, digits: int = 7) -> float | None:
    """A number with some digits; None for what is none."""
    return float(f"{x:.{digits}g}") if np.isfinite(x) else None
