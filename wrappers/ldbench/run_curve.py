"""What the smoothing of waves, which the contact law needs so that a contact is one patch, changes of a wheelset on its rails."""
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ._core import flat
from ._core.calls import Handle
from .conicity import GEOMETRY_PITCH, equivalent_conicity, level_rows
from .constants import MM
from .profiles.profile import ProfileData

AMPLITUDE = 3e-3            # for which the conicity is told [m]


@dataclass(frozen=True)
class Rigid:
    """A level wheelset on its rails."""
    clearance: tuple[float, float]      # rigid-axle flange clearance to the left and to the right [m]
    conicity: float                     # by EN 15302 at AMPLITUDE; NaN where the wheelset is not turned back

    @classmethod
    def of(cls, handle: Handle) -> Rigid:
        """The numbers of profiles that are in their places."""
        left, right = (float(flat.rigid_numbers(handle, side)[0][0]) for side in (1, 2))
        reach = round(1.5*AMPLITUDE/GEOMETRY_PITCH)
        rows = level_rows(handle, GEOMETRY_PITCH*np.arange(-reach, reach + 1))
        if not np.isfinite(rows[7]).all():
            return cls((left, right), np.nan)
        return cls((left, right), float(equivalent_conicity(np.array([AMPLITUDE]), rows[0], rows[7])[0]))


def change_words(files: Mapping[str, str], before: Rigid, after: Rigid, unsmoothed: float | None, smoothed: float | None) -> str:
    """The change from the geometry of the points to that of a run, in a line of ASCII.

    files: those of the user whose waves are smoothed, with what a run reads of them. unsmoothed, smoothed: frequency of the
    lateral motion [Hz]; None where it is not known.
    """
    found = []
    for path, read in files.items():
        profile = ProfileData(read)
        size, y = profile.moved
        found.append(f"{profile.kind} {Path(path).name} up to {1e3*size:.2g} um from its points' curve, at y = {y:.1f} mm")
    numbers = [f"equivalent conicity at {MM*AMPLITUDE:.0f} mm {told(before.conicity, 4)} -> {told(after.conicity, 4)}"]
    alike = all(left == right for left, right in (before.clearance, after.clearance))
    sides = ("",) if alike else ("left ", "right ")
    numbers += [f"{side}clearance {MM*one:.3f} -> {MM*other:.3f} mm"
                for side, one, other in zip(sides, before.clearance, after.clearance, strict=False)]
    if smoothed is not None:
        numbers.append(f"lateral frequency {told(unsmoothed, 3)} -> {told(smoothed, 3)} Hz")
    return (f"waves are smoothed so that a contact is one patch: {'; '.join(found)}; from the points to this run: "
            f"{', '.join(numbers)}; smoothing=0 keeps the waves")


def told(x: float | None, decimals: int) -> str:
    """A number, or that there is none."""
    return "none" if x is None or not np.isfinite(x) else f"{x:.{decimals}f}"
