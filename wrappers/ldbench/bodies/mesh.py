"""A mesh of triangles for the cross-section of a body, fine at the surface that carries contacts."""
from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from matplotlib.path import Path
from scipy.spatial import Delaunay, cKDTree

from ..profiles.smoothing import chord_lengths

GROWTH = 0.3        # of the triangles' size with the distance from the strips: a flange is half a per cent too stiff
NEAREST = 0.6       # of a point to the outline, of the size there
ROUNDS = 6          # of smoothing


@dataclass(frozen=True)
class Mesh:
    """Triangles with six nodes: three corners, then the middles of the sides opposite to them."""

    points: np.ndarray      # (nodes, 2) [m]
    triangles: np.ndarray   # (triangles, 6)
    strips: np.ndarray      # (strips, 3): first, middle and last node of each strip
    held: np.ndarray        # nodes that do not move


def graded(line: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Points on a line of points, where the arc over the wanted size grows by equal steps."""
    length = chord_lengths(line)
    count = np.concatenate([[0], np.cumsum(np.diff(length)*(1/size[1:] + 1/size[:-1])/2)])
    at = np.interp(np.linspace(0, count[-1], max(2, round(count[-1]) + 1)), count, length)
    return np.column_stack([np.interp(at, length, x) for x in line.T])


def make_mesh(strips: np.ndarray, rest: np.ndarray, held_between: tuple[int, int], size: float) -> Mesh:
    """Mesh a section whose outline is the ends of strips, (n + 1, 2), and the rest of the outline from the last strip back to the
    first, (m, 2), counterclockwise together [m]. The rest does not move from one of its corners to another one.
    """
    near = cKDTree(strips)

    def wanted(points: np.ndarray) -> np.ndarray:
        return size + GROWTH*near.query(points)[0]

    corners = np.concatenate([strips[-1:], rest, strips[:1]])
    pieces, held = [strips[:-1]], [np.zeros(len(strips) - 1, bool)]
    for k, (a, b) in enumerate(itertools.pairwise(corners)):
        line = a + np.linspace(0, 1, 400)[:, None]*(b - a)
        pieces.append(graded(line, wanted(line))[:-1])
        held.append(np.full(len(pieces[-1]), held_between[0] < k <= held_between[1]))
        held[-1][0] |= held_between[0] < k <= held_between[1] + 1       # the corner at its end does not move either
    border, fixed = np.concatenate(pieces), np.concatenate(held)
    inner = fill(border, wanted)
    inside = Path(border)
    for _ in range(ROUNDS):
        points = np.concatenate([border, inner])
        found = Delaunay(points)
        kept = found.simplices[inside.contains_points(points[found.simplices].mean(axis=1))]
        ends = np.concatenate([kept[:, [0, 1]], kept[:, [1, 2]], kept[:, [2, 0]]])
        ends = np.unique(np.sort(np.concatenate([ends, ends[:, ::-1]]), axis=1), axis=0)
        total, count = np.zeros_like(points), np.zeros(len(points))
        for one, other in ((0, 1), (1, 0)):
            np.add.at(total, ends[:, one], points[ends[:, other]])
            np.add.at(count, ends[:, one], 1)
        inner = (total/np.maximum(count, 1)[:, None])[len(border):]
    return quadratic(points, kept, len(strips) - 1, np.flatnonzero(fixed))


def fill(border: np.ndarray, wanted: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Points inside, on triangular lattices each twice as wide as the one before."""
    inside, edges = Path(border), cKDTree(border)
    low, high = border.min(axis=0), border.max(axis=0)
    centre = border[np.argmin(wanted(border))]
    size, points = wanted(border).min(), np.empty((0, 2))
    while size < (high - low).max():
        reach = 2*size*2/GROWTH + 0.2
        a, b = np.maximum(low, centre - reach), np.minimum(high, centre + reach)
        x, y = np.meshgrid(np.arange(a[0], b[0], size), np.arange(a[1], b[1], size*np.sqrt(3)/2))
        x[1::2] += size/2
        lattice = np.column_stack([x.ravel(), y.ravel()])
        lattice = lattice[inside.contains_points(lattice)]
        if len(lattice):
            asked = wanted(lattice)
            lattice = lattice[(asked >= size) & (asked < 2*size)]
        if len(lattice):
            away, _ = edges.query(lattice)
            lattice = lattice[away > NEAREST*wanted(lattice)]
        if len(points) and len(lattice):
            lattice = lattice[cKDTree(points).query(lattice)[0] > 0.8*size]
        points = np.concatenate([points, lattice])
        size *= 2
    return points


def quadratic(points: np.ndarray, triangles: np.ndarray, n_strips: int, held: np.ndarray) -> Mesh:
    """Add the nodes in the middle of the sides."""
    used, triangles = np.unique(triangles, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    points = points[used]
    sides = np.sort(np.stack([triangles[:, [1, 2]], triangles[:, [2, 0]], triangles[:, [0, 1]]], axis=1), axis=2)
    ends, middle = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
    middle = middle.reshape(-1, 3) + len(points)
    number = {tuple(pair): k + len(points) for k, pair in enumerate(ends.tolist())}
    strips = np.array([(new[k], number[tuple(sorted((int(new[k]), int(new[k + 1]))))], new[k + 1]) for k in range(n_strips)])
    held = new[held]
    held_set = set(held.tolist())
    on_held = [number[tuple(pair)] for pair in ends.tolist() if pair[0] in held_set and pair[1] in held_set]
    return Mesh(np.concatenate([points, points[ends].mean(axis=1)]), np.concatenate([triangles, middle], axis=1), strips,
                np.concatenate([held, np.array(on_held, int)]))
