"""Pressed patches for the page: outline, pressure along the profile, largest pressure and area at some moments of a run."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..geometry.pressures import known_patches
from ..pressure import CONTACTS, Patch, reach
from ..results.run_data import RunData

LEVELS = 99         # of a pressure and of half a width, from 0 to the largest


def pressure_entries(run: RunData, contacts: Sequence[str] = CONTACTS) -> list[dict[str, Any]]:
    """The patches that are known at the largest normal force of each of some contacts and at the peak of the first contact of
    each flange."""
    return [{"t": float(run.time[k]), "patches": list(map(patch_entry, patches))} for k in moments(run, contacts)
            if (patches := known_patches(run, k))]


def moments(run: RunData, contacts: Sequence[str]) -> list[int]:
    """Rows at which patches are shown, in order of time."""
    rows = {one.top for contact in ("LF", "RF") if (one := run.first_interval(contact))}
    rows |= {int(np.abs(run.time - peak[1]).argmin()) for contact in contacts if (peak := run.peak(contact))}
    return sorted(rows)


def patch_entry(patch: Patch) -> dict[str, Any]:
    """A patch for the page; lengths x in rolling direction (half) and s along the profile [m]."""
    half = patch.p[len(patch.x)//2:]                        # from the middle of the patch in rolling direction
    widths = np.minimum([reach(column)/len(half) for column in half.T], 1)
    dx, ds = patch.x[1] - patch.x[0], patch.s[1] - patch.s[0]
    middle = half[0]/max(patch.largest, half.max())
    return {"c": patch.contact, "pmax": float(f"{patch.largest:.5g}"), "area": float(f"{patch.area:.5g}"),
            "x": float(f"{len(half)*dx:.4g}"), "s": float(f"{len(patch.s)*ds:.4g}"),
            "p": np.rint(LEVELS*middle).astype(int).tolist(), "w": np.rint(LEVELS*widths).astype(int).tolist()}
