"""Quantities that follow from the columns: L/V of each wheel, spectra, and the energies before and after an impact."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..constants import SIDES
from .run_data import RunData

KINETIC_PARTS = {"KE_lat": "lateral", "KE_vert": "vertical", "KE_roll": "roll"}


class Exchange(NamedTuple):
    """Kinetic energies [J] when an impact begins and when it ends, and the largest elastic energy of both wheels between."""

    before: dict[str, float]        # by the columns KE_lat, KE_vert, KE_roll
    after: dict[str, float]
    elastic: float


def is_forced(run: RunData) -> bool:
    """Whether a lateral force does work on the wheelset of a run that has this column."""
    return bool(run.values("W_ext").any())


def wheel_loads(run: RunData, side: str) -> tuple[np.ndarray, np.ndarray]:
    """Lateral force outwards and vertical force downwards of a wheel, 'left' or 'right', on its rail, (rows,) each [N]."""
    sign = -1.0 if side == "left" else 1.0
    lateral = sign*sum(run.values(f"Fy_{contact}") for contact in SIDES[side])
    vertical = sum(run.values(f"Fz_{contact}") for contact in SIDES[side])
    return np.asarray(lateral), np.asarray(vertical)


def lateral_over_vertical(run: RunData, side: str) -> np.ndarray:
    """L/V of a wheel, 'left' or 'right', (rows,): lateral force outwards over vertical force; NaN where the wheel has no vertical
    force downwards. Without friction L/V lies between the tangents of the contact angles of tread and flange, however small the
    forces are. The page has the same rule in derived.js."""
    lateral, vertical = wheel_loads(run, side)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(vertical > 0, lateral/vertical, np.nan)


def nadal_limit(flange_angle: float, friction: float) -> float:
    """Nadal's limit of L/V for a flange angle [rad] and a coefficient of friction (M. J. Nadal, 1896)."""
    slope = np.tan(flange_angle)
    return float((slope - friction)/(1 + friction*slope))


def spectrum(run: RunData, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Amplitude spectrum of a column over the whole run: frequencies [Hz] and amplitudes, SI.

    The rows are interpolated to equal intervals, the mean is removed, and a Hann window is applied, scaled so that a sine
    that fits the run keeps its amplitude. Empty for fewer than 16 rows.
    """
    t = run.time
    if len(t) < 16 or t[-1] <= t[0]:
        return np.empty(0), np.empty(0)
    even = np.linspace(t[0], t[-1], len(t))
    x = np.interp(even, t, run.values(column))
    window = np.hanning(len(t))
    amplitude = 2*np.abs(np.fft.rfft((x - x.mean())*window))/window.sum()
    return np.fft.rfftfreq(len(t), even[1] - even[0]), amplitude


def exchange(run: RunData, start: float, end: float) -> Exchange | None:
    """Kinetic energies before and after an impact from `start` to `end` [s], which are equal for a rigid contact; None without the
    columns of energies."""
    if not {*KINETIC_PARTS, "PE_elastic_L", "PE_elastic_R"}.issubset(run.data):
        return None
    first = max(int(np.searchsorted(run.time, start, "right")) - 1, 0)
    last = min(int(np.searchsorted(run.time, end)), len(run.time) - 1)
    # Two rows have the time of a rigid impact, that before it and that after it. Files have it in nine digits.
    if start == end and (same := np.flatnonzero(np.isclose(run.time, start, rtol=1e-8, atol=0))).size:
        first, last = int(same[0]), int(same[-1])
    elastic = (run.values("PE_elastic_L") + run.values("PE_elastic_R"))[first:last + 1]
    before, after = ({name: float(run.values(name)[k]) for name in KINETIC_PARTS} for k in (first, last))
    return Exchange(before, after, float(elastic.max()))


def cumulative(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The integral of x over t from the first row, by the trapezoidal rule."""
    return np.concatenate([[0.0], np.cumsum(np.diff(t)*(x[1:] + x[:-1])/2)])
