"""Which results are sensitive: each case runs once more with the start moved by 1 µm.

A result that such a twin changes by more than a thousandth depends on more than any measurement tells: many impacts have multiplied
the difference, and it is one sample of a chaotic motion. Tables have it in italics, with the digits that hold.
"""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.calls import Progress
from .._core.kept import kept_json, stamped
from .._core.pools import in_threads
from ..results.summary import summary_row
from ..runs import compute
from .jobs import Job

ASIDE = 1e-6            # of the start of a twin [m]
SAME = 1e-3             # share of a result by which a twin may move it
# Results that say how exact a run is, not what happens in it.
EXACTNESS = "drift", "drift_relative", "drift_reference", "step", "steps"


def chaotic(row: Mapping[str, Any], twin: Mapping[str, Any]) -> dict[str, float]:
    """The results of a run that its twin does not share, and how far its twin is from them; infinite where one comes or goes."""
    found = {}
    for key in twin.keys() - set(EXACTNESS):
        one, other = row.get(key), twin.get(key)
        if isinstance(one, str) or isinstance(other, str) or one == other or (one is not None and np.isnan(one)):
            continue
        spread = np.inf if one is None or other is None or np.isnan(other) else abs(one - other)
        apart = 2*ASIDE if key.startswith("Y_") else 0.0        # by the start itself
        if spread > SAME*abs(one or 0.0) + apart:
            found[key] = float(spread)
    return {key: found[key] for key in twin if key in found}


def kept_twins(jobs: Sequence[Job], kept: Path, workers: int, force: bool = False) -> dict[str, dict[str, Any]]:
    """The results of the twins by the names of the cases, run anew where something they depend on has changed since they were
    kept in a file."""
    def work(job: Job, tell: Progress) -> dict[str, Any]:
        return summary_row(compute(job.case.replace(initial_Y=job.case.initial_Y + ASIDE), tell))

    def make() -> dict[str, dict[str, Any]]:
        found = in_threads(work, sorted(jobs, key=lambda job: -job.cost), workers)
        return {job.name: row for job, row in found}

    depends = {name: x for job in jobs for name, x in stamped(job.product, Path()).items()}
    rows: dict[str, dict[str, Any]] = kept_json(kept, depends, force, make)
    return rows
