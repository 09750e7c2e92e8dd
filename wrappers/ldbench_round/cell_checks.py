"""Cells without a number: which words stand for it, and where there must be a number."""
from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ldbench.constants import CONTACTS
from ldbench.results.run_data import RunData
from ldbench.tools import counted

from .findings import DOUBTFUL, FAILED, PASSED, Finding, listed
from .tasks import MOTION, PER_CONTACT

NO_NUMBERS = "words for no number"
LARGE = 0.25            # share of the largest force in the rows before and behind from which a contact was closed between them
ACCELERATIONS = MOTION[6:]


def cell_findings(run: RunData) -> Iterator[Finding]:
    """The words that were read as no number, and the numbers that are missing: in the motion, and in the forces of closed
    contacts."""
    if words := run.data.attrs.get("words", ()):
        told = [f"'{one.word[:20]}' {counted(one.number, 'time')}, first in line {one.line}, column {one.column}" for one in words]
        yield Finding(NO_NUMBERS, PASSED, sum(one.number for one in words), hint=listed(told))
    empty = {column: ~np.isfinite(run.values(column)) for column in MOTION if column in run.data}
    yield of_holes("numbers", {column: where for column, where in empty.items() if column not in ACCELERATIONS}, FAILED)
    yield of_holes("numbers of accelerations", {column: empty[column] for column in ACCELERATIONS if column in empty}, DOUBTFUL)
    yield of_holes("numbers of forces", {column: where for contact in CONTACTS for column, where in missing_forces(run, contact)},
                   FAILED)


def missing_forces(run: RunData, contact: str) -> Iterator[tuple[str, np.ndarray]]:
    """The forces of a contact that lack numbers, and where, (rows,): in rows in which another column of the contact has a number
    that is not zero while some force presses, or between rows with large forces."""
    own = {column: run.values(column) for name in PER_CONTACT if (column := f"{name}_{contact}") in run.data}
    forces = {column: x for column, x in own.items() if column.startswith(("N_", "F"))}
    if not forces:
        return
    closed = np.any([np.nan_to_num(x) != 0 for x in forces.values()], axis=0)
    # A code may keep the last place of an open contact.
    places = [x for column, x in own.items() if column not in forces]
    placed = np.zeros(closed.size, bool)
    if places:
        moves = np.any([np.abs(np.diff(x, prepend=x[:1])) > 0 for x in places], axis=0)
        placed = moves & np.all([np.isfinite(x) for x in places], axis=0)
    for column, x in forces.items():
        known = np.flatnonzero(np.isfinite(x))
        if not known.size or known.size == x.size:
            continue
        at = np.searchsorted(known, np.arange(x.size))
        before, behind = (np.abs(x[known[np.clip(k, 0, known.size - 1)]]) for k in (at - 1, at))
        inside = np.minimum(before, behind) > LARGE*np.nanmax(np.abs(x))
        yield column, ~np.isfinite(x) & (closed | placed | inside)


def of_holes(what: str, holes: Mapping[str, np.ndarray], verdict: str) -> Finding:
    """How many numbers are missing in columns, and where the first one is."""
    found = {column: np.flatnonzero(where) for column, where in holes.items() if where.any()}
    if not found:
        return Finding(what, PASSED, 0, 0)
    return Finding(what, verdict, sum(rows.size for rows in found.values()), 0, min(int(rows[0]) + 1 for rows in found.values()),
                   f"cells without a number: {listed([f'{rows.size} of {column}' for column, rows in found.items()])}")
