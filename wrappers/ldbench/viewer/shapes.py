"""What the scene of the page draws: outlines, the faces between which there is a gap, and pressed patches."""
from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..geometry.outlines import Outlines, Side
from ..geometry.pressures import known_patches
from ..pressure import Patch, reach
from ..results.run_data import RunData

FLANK = np.radians(20)      # steeper parts of wheel and rail may touch as a flange
LEVELS = 99                 # of a pressure and of half a width, from 0 to the largest


def outline_entry(outlines: Outlines) -> dict[str, Any]:
    """Outlines for the page; sides that are mirror images stand there once."""
    left, right = (side_entry(side) for side, _ in outlines.sides)
    return {"sides": [left] if left == right else [left, right], "axle": outlines.axle, "roll": outlines.roll}


def side_entry(side: Side) -> dict[str, list[float]]:
    """Wheel and rail, and the faces between which there is a gap, where they are steep: the flange's outer side, and the rail's
    side from below its gauge corner up to the top; each from below, Y and Z in turns [m]."""
    by_y = side.wheel[np.argsort(side.wheel[:, 0], kind="stable")]
    top = int(np.argmax(side.rail[:, 1]))
    inner = side.rail[:top + 1] if side.rail[0, 0] < side.rail[-1, 0] else side.rail[top:]
    faces = {"wheel": side.wheel, "rail": side.rail, "flank": steep(by_y[int(np.argmin(by_y[:, 1])):]),
             "gauge": steep(inner[np.argsort(inner[:, 1], kind="stable")])}
    return {name: points.ravel().round(7).tolist() for name, points in faces.items()}


def steep(points: np.ndarray) -> np.ndarray:
    """The connected stretch that begins with the first steep piece."""
    d = np.diff(points, axis=0)
    pieces = np.flatnonzero(np.arctan2(d[:, 1], np.abs(d[:, 0])) > FLANK)
    return points[pieces[0]:pieces[-1] + 2] if pieces.size else points[:0]


def pressure_entries(run: RunData, contacts: Sequence[str]) -> list[dict[str, Any]]:
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
