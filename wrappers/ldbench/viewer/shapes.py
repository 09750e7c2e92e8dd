"""The faces between which the page draws the gap: a flange's outer side and the gauge side of the rail that it meets."""
from __future__ import annotations

import numpy as np

FLANK = np.radians(20)      # steeper parts of wheel and rail may touch as a flange


def facing(wheel: np.ndarray, rail: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The flange's outer side and the rail's gauge side, where they are steep, each from below: (n, 2) and (m, 2) [m]."""
    by_y = wheel[np.argsort(wheel[:, 0], kind="stable")]
    outer = by_y[int(np.argmin(by_y[:, 1])):]
    return steep(outer), steep(gauge_side(rail))


def gauge_side(rail: np.ndarray) -> np.ndarray:
    """The points of a rail from below its gauge corner up to the top."""
    top = int(np.argmax(rail[:, 1]))
    inner = rail[:top + 1] if rail[0, 0] < rail[-1, 0] else rail[top:]
    return inner[np.argsort(inner[:, 1], kind="stable")]


def steep(points: np.ndarray) -> np.ndarray:
    """The connected stretch that begins with the first steep piece."""
    d = np.diff(points, axis=0)
    pieces = np.flatnonzero(np.arctan2(d[:, 1], np.abs(d[:, 0])) > FLANK)
    return points[pieces[0]:pieces[-1] + 2] if pieces.size else points[:0]
