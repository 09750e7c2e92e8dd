"""Column files on common instants, and what differs between them, in numbers."""
from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from .._core.errors import Error
from ..case import Case
from ..constants import CONTACT_NAMES, CONTACTS
from ..results.answers import all_events, answers, first_flange
from ..results.columns import time_mean
from ..results.contact_intervals import ContactInterval
from ..results.derived import is_forced
from ..results.quantities import OUTCOME, SI, Quantity, quantity
from ..results.run_data import RunData
from ..table import placed_outlines
from ..viewer.page import distinct

GIVEN = {"time", "X", "vX", "pitch", "pitch_rate", "F_ext", "KE_long", "KE_pitch"}   # not outcomes
TIMES = "t_first_LF", "t_first_RF", "t_return", "t_unloaded", "t_derailment"
IMPACTS = 100           # of a contact, in tables
MEASURES = {"start": ("start", "s"), "duration": ("duration", "s"), "peak": ("largest normal force", "N"),
            "impulse": ("impulse", "N.s"), "angle": ("contact angle at the largest force", "rad")}


@dataclass(frozen=True)
class Comparison:
    """Runs on common instants: `time` of the reference, counted from its alignment, and the columns of each run there."""
    time: np.ndarray                     # [s]
    runs: tuple[RunData, ...]          # the first is the reference
    shifts: tuple[float, ...]            # instants of each file that are taken as the same [s]
    columns: tuple[str, ...]             # that all files have
    values: tuple[dict[str, np.ndarray], ...]

    def unit(self, column: str) -> str:
        """The SI unit of a column, '' where nobody tells it."""
        for run in self.runs:
            if unit := run.data.attrs.get("units", {}).get(column):
                return str(unit)
        known = quantity(column)
        return SI.get(known.unit, known.unit) if known.group != "other columns" else ""

    def shown(self, column: str) -> Quantity:
        """A column in words, with the unit in which it is shown."""
        found = quantity(column, self.unit(column))
        return found._replace(unit="SI") if not self.unit(column) else found

    def difference(self, k: int, column: str) -> np.ndarray:
        """File k less the reference; nan where either contact is open."""
        return self.values[k][column] - self.values[0][column]


def compare(runs: Sequence[RunData], align: str = "time") -> Comparison:
    """Bring runs onto common instants.  align: 'time', or 'first-flange' for the first flange contact of each."""
    if len(runs) < 2:
        raise Error(place="compare", expected="at least two column files", found=len(runs))
    runs = distinct(runs)
    firsts = [0.0 if align == "time" else first_flange(answers(run)) for run in runs]
    if None in firsts:
        raise Error(file=runs[firsts.index(None)].file, expected="a flange contact to align by", found="none")
    shifts = tuple(first for first in firsts if first is not None)
    starts, ends = zip(*((run.time[0] - shift, run.time[-1] - shift) for run, shift in zip(runs, shifts, strict=True)), strict=True)
    time = runs[0].time - shifts[0]
    room = 1e-9*max(abs(t) for t in starts + ends)
    time = time[(time >= max(starts) - room) & (time <= min(ends) + room)]
    if time.size < 2:
        raise Error(file=runs[0].file, expected="files that overlap in time", found="no common rows")
    columns = tuple(column for column in runs[0].data if column not in GIVEN and all(column in run.data for run in runs)
                    and (column != "W_ext" or any(map(is_forced, runs))))
    if not columns:
        raise Error(file=runs[0].file, expected="a column besides time that all files have", found="none",
                    advice="--map TOML says how other codes name ours")
    values = tuple({column: np.interp(time, run.time - shift, run.values(column)) for column in columns}
                   for run, shift in zip(runs, shifts, strict=True))
    return Comparison(time, tuple(runs), shifts, columns, values)


def difference_table(found: Comparison) -> pd.DataFrame:
    """Root mean square and largest difference of every quantity of every file, SI."""
    rows = []
    for k in range(1, len(found.runs)):
        for column in found.columns:
            d = found.difference(k, column)
            known = ~np.isnan(d)
            worst = int(np.nanargmax(np.abs(d))) if known.any() else None
            rows.append({
                "file": found.runs[k].name, "what": "difference", "quantity": column, "words": found.shown(column).words,
                "unit": found.unit(column), "rms": np.sqrt(time_mean(found.time, d**2)),
                "largest": d[worst] if worst is not None else np.nan,
                "at [s]": found.time[worst] if worst is not None else np.nan,
                "share compared": float(known.mean())})
    return pd.DataFrame(rows)


def event_times(run: RunData, case: Case | None = None) -> dict[str, float]:
    """Instants [s] worth comparing, in their order: the first of each kind of event, the answers among times, the end. case: as of
    `answers`."""
    known = answers(run, case)
    found = {f"first {event.kind}": event.t for event in reversed(all_events(run, case)) if event.kind != "derailment"}
    found |= {OUTCOME[name].short: known[name] for name in TIMES if known[name] is not None}
    return dict(sorted(found.items(), key=lambda one: one[1])) | {"end": float(run.time[-1])}


def placeable_case(run: RunData) -> Case | None:
    """The case of a run; None where the file does not tell it, or where its profiles are not there."""
    with suppress(Error):
        placed_outlines(run.case)
        return run.case
    return None


def event_table(runs: Sequence[RunData]) -> pd.DataFrame:
    """Times of events and peaks of forces in every file against the reference, SI. Files that do not tell their case have that of
    the first file that does."""
    case = next(filter(None, map(placeable_case, runs)), None)
    times, peaks = ([told(run, case) for run in runs] for told in (event_times, answers))
    rows = []
    for k, other in enumerate(runs[1:], 1):
        rows += [pair_row(other, "event", name, name, "s", times[0].get(name), times[k].get(name)) for name in times[0] | times[k]]
        for c in CONTACTS:
            both = [peaks[one][f"peak_N_{c}"] for one in (0, k)]
            if any(both):
                rows.append(pair_row(other, "peak", f"N_{c}", f"largest {quantity(f'N_{c}').words}", "N", *both))
    return pd.DataFrame(rows)


def pair_row(other: RunData, what: str, name: str, words: str, unit: str, reference: float | None,
             value: float | None) -> dict[str, Any]:
    """A row of the table of events, peaks and impacts, SI."""
    return {"file": other.name, "what": what, "quantity": name, "words": words, "unit": unit, "reference": reference,
            "value": value, "difference": np.nan if reference is None or value is None else value - reference}


class Pairing(NamedTuple):
    """An impact of the reference and those of the other files with the same contact and number; None where there is none."""
    contact: str
    name: str               # 'LF 2'
    words: str              # 'left flange 2'
    impacts: tuple[ContactInterval | None, ...]     # by file


def paired_impacts(runs: Sequence[RunData]) -> tuple[list[Pairing], int]:
    """The first IMPACTS of each contact by number, in order of time; how many more impacts the lists would have."""
    found: list[Pairing] = []
    left_out = 0
    for contact in CONTACTS:
        lists = [run.impacts([contact]) for run in runs]
        count = max(map(len, lists))
        left_out += max(count - IMPACTS, 0)
        found += [Pairing(contact, f"{contact} {k + 1}", f"{CONTACT_NAMES[contact]} {k + 1}",
                          tuple(own[k] if k < len(own) else None for own in lists)) for k in range(min(count, IMPACTS))]
    return sorted(found, key=lambda one: next(impact.start for impact in one.impacts if impact)), left_out


def impact_table(runs: Sequence[RunData]) -> pd.DataFrame:
    """Start, duration, peak, impulse and contact angle of every impact of every file against the reference, SI."""
    rows = []
    for one in paired_impacts(runs)[0]:
        for k, other in enumerate(runs[1:], 1):
            mine, reference = one.impacts[k], one.impacts[0]
            if mine or reference:
                rows += [pair_row(other, "impact", f"{one.name} {name}", f"{one.words}, {words}", unit,
                                  getattr(reference, name, None), getattr(mine, name, None))
                         for name, (words, unit) in MEASURES.items()]
    return pd.DataFrame(rows, columns=["file", "what", "quantity", "words", "unit", "reference", "value", "difference"])
