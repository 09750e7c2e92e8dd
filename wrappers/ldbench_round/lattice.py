"""Marks that a code leaves at equal distances: kinks at the points of a contact table, or at steps between interpolated rows."""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .findings import Estimate

PROMINENT = 20.0        # times the median change of slope, from which a row is a kink
LEAST_CELLS = 8         # of a lattice that have a kink of their own
IN_STEP = 0.85          # least length of the mean of all kinks on the circle of the lattice
SHARE = 0.9             # of all changes of slope that has to lie at the points of the lattice
LEAST_ROWS = 3          # from one point of a lattice to the next
NOISE = 30.0            # times the noise of digits that a change of slope exceeds


@dataclass(frozen=True)
class Bends:
    """Changes of slope of a column over a variable, at the rows between the first and the last."""

    at: np.ndarray          # where [unit of the variable]
    size: np.ndarray        # of the change of slope, in units of the noise or of what is usual, whichever is larger
    spacing: float          # of the rows, median


def bends(x: np.ndarray, y: np.ndarray, noise: float) -> Bends:
    """Changes of slope of y over x for successive rows; where x hardly changes, there is none.

    noise: of y, from its digits.
    """
    dx = np.diff(x)
    usual = float(np.median(np.abs(dx))) if dx.size else 0.0
    if usual <= 0 or dx.size < 2:
        return Bends(np.empty(0), np.empty(0), usual)
    fast = np.abs(dx) > 0.2*usual
    slope = np.divide(np.diff(y), dx, out=np.zeros_like(dx), where=fast)
    both = fast[1:] & fast[:-1] & (dx[1:]*dx[:-1] > 0)
    change = np.abs(np.diff(slope))*usual
    change[change < NOISE*noise] = 0.0
    return Bends(x[1:-1][both], change[both], usual)


def digit_noise(x: np.ndarray) -> float:
    """Rounding of a column [its unit]: the digits that a code prints, or what is usual of 8 digits, whichever is larger."""
    known = x[np.isfinite(x) & (x != 0)]
    if known.size < 3:
        return 0.0
    steps = np.diff(np.unique(known))
    size = float(np.median(np.abs(known)))
    least = float(np.quantile(steps, 0.02)) if steps.size else 0.0
    if least < 1e-7*size:
        return 1e-8*size
    # Where digits are few, all differences are multiples of the last one.
    multiples = steps/least
    return least if float(np.mean(np.abs(multiples - np.round(multiples)) < 0.01)) > 0.9 else 1e-8*size


def find_lattice(groups: Sequence[Bends], unit: str, nothing: str) -> Estimate:
    """The distance of equally spaced kinks; `nothing` says what it means that there are none.

    Kinks count by turns: each is a point on a circle whose circumference is the distance that is tried. Points on a lattice
    meet; points elsewhere spread. The largest distance at which they meet is taken, because they meet at its fractions, too.
    """
    spacing = float(np.median([one.spacing for one in groups])) if groups else 0.0
    groups = [one for one in groups if one.size.any()]
    prominent = [(one.size > PROMINENT*np.median(one.size)) & (one.size > 1e-3*one.size.max()) for one in groups]
    at = np.concatenate([[], *(one.at[rows] for one, rows in zip(groups, prominent, strict=True))])
    size = np.concatenate([[], *(one.size[rows]/one.size.max() for one, rows in zip(groups, prominent, strict=True))])
    reach = float(np.ptp(at)) if at.size else 0.0
    if at.size < LEAST_CELLS or spacing <= 0 or reach <= 0:
        return Estimate(unit=unit, why=nothing)
    frequencies = np.arange(LEAST_CELLS/2/reach, 1/(2.5*spacing), 1/(10*reach))
    weight = np.minimum(size, np.median(size))
    meeting = np.abs(turned(frequencies, at, weight))/weight.sum() if frequencies.size else np.zeros(1)
    high = np.flatnonzero(meeting > max(IN_STEP, 0.9*meeting.max()))
    if not high.size:
        return Estimate(unit=unit, why=nothing)
    # The top of the first hill.
    first = high[0]
    while first + 1 < meeting.size and meeting[first + 1] > meeting[first]:
        first += 1
    pitch = refined(groups, at, weight, 1/float(frequencies[first]), spacing, unit)
    return pitch or Estimate(unit=unit, why=nothing)


def turned(frequencies: np.ndarray, at: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The sum of weights that are turned by their places times a frequency, for frequencies at equal distances, (frequencies,).

    A turn by a sum of two frequencies is the product of two turns, so far fewer exponentials are needed than there are turns.
    """
    fine = int(np.ceil(np.sqrt(frequencies.size)))
    first, rest = (np.exp(2j*np.pi*np.outer(some, at)) for some in (frequencies[::fine], frequencies[:fine] - frequencies[0]))
    return ((first*weight) @ rest.T).ravel()[:frequencies.size]


def refined(groups: Sequence[Bends], at: np.ndarray, weight: np.ndarray, pitch: float, spacing: float,
            unit: str) -> Estimate | None:
    """The distance by a line through the kinks over their numbers; None unless nearly all kinks are near the lattice, and few rows
    are."""
    phase = float(np.angle(np.exp(2j*np.pi*at/pitch) @ weight))/(2*np.pi)*pitch
    for _ in range(3):
        number = np.round((at - phase)/pitch)
        mean = float(weight @ number)/weight.sum()
        square = float(weight @ (number - mean)**2)
        if square <= 0:
            return None
        pitch = float(weight @ ((number - mean)*at))/square
        phase = float(weight @ at)/weight.sum() - mean*pitch
    cells = np.unique(number).size
    near = total = 0.0
    for one in groups:
        distance = np.abs(one.at - phase - pitch*np.round((one.at - phase)/pitch))
        share = one.size/one.size.max()
        near, total = near + float(share[distance < 1.2*one.spacing].sum()), total + float(share.sum())
    # Closer points would be near any row.
    if cells < LEAST_CELLS or near < SHARE*total or pitch < LEAST_ROWS*spacing:
        return None
    # No kink is placed better than by the rows about it, and all may be off to one side at either end.
    return Estimate(pitch, spacing/float(np.ptp(number)), unit, f"kinks in {cells} cells")
