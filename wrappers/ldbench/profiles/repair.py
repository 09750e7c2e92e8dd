"""Repair of points as they are measured: repeated points, points off the curve, points that double back.

Each repair is said in a note. Points that cannot be repaired are refused with their line.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .._core.errors import Error
from ..number_text import number_text

LARGEST_TURN = np.radians(120)  # at a point: a larger one means that two points are exchanged
LARGEST_MOVE = 0.3              # a point that doubles back farther is no measuring error [mm]
LEAST_MISS = 0.15               # a point that is nearer to the curve stays [mm]
LEAST_END_MISS = 1.0            # and a first or last point [mm]
LEAST_SHARE = 0.9               # of the points must be on the curve
LEAST_POINTS = 10
ENOUGH_POINTS = 200             # points are put together only where there are more
LARGEST_BACKWARD = 0.03         # share of points that turn back: above, the noise exceeds the spacing
NEARBY = 20                     # points to either side that tell the usual distance from the curve
LOOP = 4                        # segments of a small loop, at most
SWEEPS = 60


@dataclass(frozen=True)
class Mended:
    """Points after repair."""
    points: np.ndarray      # (n, 2) [mm]
    lines: np.ndarray       # (n,) line of each point in the file
    group: int              # points put together to one, 1 for none
    notes: list[str]        # what was repaired, one line each


def mend(points: np.ndarray, lines: np.ndarray, where: str) -> Mended:
    """Repair points of shape (n, 2) [mm] along a curve; `lines`, of shape (n,), are theirs in the file `where`.

    Points that equal the one before to the last digit are dropped, then points off the curve. Where the noise exceeds the spacing,
    pairs are put together; points that double back by less than 0.3 mm are exchanged or united. Raises Error where more than
    a tenth of the points is off the curve, or fewer than 10 are left.
    """
    notes = []
    new = np.r_[True, (points[1:] != points[:-1]).any(axis=1)][:len(points)]
    if not new.all():
        notes.append(f"{(~new).sum()} repeated dropped")
    points, lines = points[new], lines[new]
    on, farthest = on_curve(points)
    if not on.all():
        count, first = int((~on).sum()), lines[on.argmin()]
        if len(points) - count < LEAST_SHARE*len(points):
            raise Error(file=where, line=first, expected="points along a curve",
                        found=f"{count} of {len(points)} off it, this one the first",
                        advice="look whether the points are in order and of one profile")
        notes.append(f"{count} off the curve by up to {_length(farthest)} dropped" + (f", line {first}" if count == 1 else ""))
    points, lines = points[on], lines[on]
    if len(points) < LEAST_POINTS:
        raise Error(file=where, expected=f"at least {LEAST_POINTS} points", found=len(points),
                    advice="give more points")
    group = 1
    while len(points) > ENOUGH_POINTS and (turns_of(points) > LARGEST_TURN).mean() > LARGEST_BACKWARD:
        n = len(points)//2
        points, lines, group = points[:2*n].reshape(n, 2, 2).mean(axis=1), lines[:2*n:2], 2*group
    if group > 1:
        notes.append(f"each {group} put together to one")
    points, lines, moved, way = _straighten(points, lines)
    if moved:
        notes.append(f"{moved} that doubled back moved by up to {_length(way)}")
    return Mended(points, lines, group, notes)


def check(points: np.ndarray, lines: np.ndarray, where: str) -> None:
    """Raise Error, with the line in the file `where`, for a curve through points of shape (n, 2) [mm] that crosses itself or
    turns by more than 120 degrees at a point."""
    low, high = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
    order = np.argsort(low[:, 0], kind="stable")
    # Segments, in order of their least y: those that begin before one ends are the only ones that can cross it.
    count = np.searchsorted(low[order, 0], high[order, 0], "right") - np.arange(len(order)) - 1
    first = np.repeat(np.arange(len(order)), count)
    second = first + 1 + np.arange(len(first)) - np.repeat(np.cumsum(count) - count, count)
    i, j = np.sort([order[first], order[second]], axis=0)
    near = (j > i + 1) & (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
    i, j = i[near], j[near]
    if (bad := _cross(points, i, j)).any():
        k = np.flatnonzero(bad)[np.lexsort((j[bad], i[bad]))[0]]
        ends = sorted((lines[i[k]], lines[j[k] + 1]))
        raise Error(file=where, line=ends[0], expected="a curve that does not cross itself",
                    found=f"that it crosses itself between lines {ends[0]} and {ends[1]}",
                    advice="look whether the points are in order")
    turns = turns_of(points)
    if (turns > LARGEST_TURN).any():
        k = int((turns > LARGEST_TURN).argmax())
        raise Error(file=where, line=lines[k + 1], expected="a curve that turns by at most 120 degrees at a point",
                    found=f"{np.degrees(turns[k]):.0f}", advice="look whether the points are in order")


def on_curve(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Tell which points of shape (n, 2) are on their curve, (n,), and how far off the farthest other one is [mm].

    A point is off the curve when the chord of its neighbours, and the lines through the two points before and through the two
    points after, all miss it by much more than they miss other points nearby; a first or last point, when it turns by more than
    30 degrees over a way that is long for the spacing.
    """
    kept, farthest = np.arange(len(points)), 0.0
    for _ in range(4):
        p = points[kept]
        if len(p) < 10:
            break
        before, middle, after = p[1:-3], p[2:-2], p[3:-1]
        miss = np.zeros(len(p))
        miss[2:-2] = np.min([_distance(middle, before, after), _distance(middle, p[:-4], before), _distance(middle, p[4:], after)],
                            axis=0)
        ends = np.hypot(*(p[[1, -2]] - p[[0, -1]]).T)
        miss[[0, -1]] = _distance(p[[0, -1]], p[[1, -2]], p[[2, -3]])
        if not (miss > LEAST_MISS).any():
            break
        padded = np.pad(miss[2:-2], min(NEARBY, len(p) - 5), "reflect")
        usual = np.median(np.lib.stride_tricks.sliding_window_view(padded, len(padded) - len(p) + 5), axis=1)
        spacing = np.hypot(*(after - before).T)/2
        bad = np.zeros(len(p), bool)
        bad[2:-2] = (miss[2:-2] > np.max([np.full(len(usual), LEAST_MISS), 8*usual, 0.35*spacing], axis=0)) \
            & (miss[2:-2] >= np.maximum(miss[1:-3], miss[3:-1]))
        bad[[0, -1]] = miss[[0, -1]] > np.max([[LEAST_END_MISS]*2, ends/2, 4*spacing[[0, -1]]], axis=0)
        if not bad.any():
            break
        farthest = max(farthest, float(miss[bad].max()))
        kept = kept[~bad]
    on = np.zeros(len(points), bool)
    on[kept] = True
    return on, farthest


def _length(x: float) -> str:
    return f"{number_text(max(x, 0.001), 3, trim=True)} mm"


def _distance(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Distances of points from the lines through points a and b, all of shape (n, 2)."""
    t = b - a
    return np.abs(t[:, 0]*(p - a)[:, 1] - t[:, 1]*(p - a)[:, 0])/np.maximum(np.hypot(*t.T), 1e-300)


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Angle between the segments a to b and b to c, of shape (..., 2) [rad]."""
    u, v = b - a, c - b
    return np.abs(np.arctan2(u[..., 0]*v[..., 1] - u[..., 1]*v[..., 0], u[..., 0]*v[..., 0] + u[..., 1]*v[..., 1]))


def turns_of(points: np.ndarray) -> np.ndarray:
    """Turns at the inner points of (n, 2), (n - 2,) [rad]."""
    return _turn(points[:-2], points[1:-1], points[2:])


def _cross(points: np.ndarray, i: np.ndarray, j: np.ndarray) -> np.ndarray:
    """Whether the segments from points i and j to the next points cross or touch."""
    a, b, c, d = points[i], points[i + 1], points[j], points[j + 1]
    boxes = (np.maximum(np.minimum(a, b), np.minimum(c, d)) <= np.minimum(np.maximum(a, b), np.maximum(c, d))).all(axis=1)
    return boxes & (_side(a, b, c)*_side(a, b, d) <= 0) & (_side(c, d, a)*_side(c, d, b) <= 0)


def _side(a: np.ndarray, b: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Positive where points p are on the left of the lines from a to b [mm2]."""
    return (b - a)[:, 0]*(p - a)[:, 1] - (b - a)[:, 1]*(p - a)[:, 0]


def _straighten(points: np.ndarray, lines: np.ndarray) -> tuple[np.ndarray, np.ndarray, int, float]:
    """Where points turn back over a short way, or make a small loop, exchange two neighbours or put one point in the place of two,
    until none turns back. Also returned: how many were moved, and how far at most [mm]."""
    points, lines, way, moved, farthest = points.copy(), lines.copy(), np.zeros(len(points)), 0, 0.0
    for _ in range(SWEEPS):
        n = len(points)
        back = np.zeros(n, bool)
        back[1:-1] = turns_of(points) > LARGEST_TURN
        for m in range(2, LOOP + 2):        # neighbouring segments always touch
            i = np.arange(n - 1 - m)
            back[i + 1] |= _cross(points, i, i + m)
        keep, done = np.ones(n, bool), 0
        for k in np.flatnonzero(back):
            if k < done:
                continue
            for a in (k, k - 1):
                move = np.hypot(*(points[a + 1] - points[a]))
                if a < done or a + 1 >= n or move/2 + max(way[a], way[a + 1]) >= LARGEST_MOVE:
                    continue
                if a == k and k + 2 < n and max(_turn(points[k - 1], points[k + 1], points[k]),
                                                _turn(points[k + 1], points[k], points[k + 2])) < LARGEST_TURN/2:
                    for swapped in points, lines, way:
                        swapped[[k, k + 1]] = swapped[[k + 1, k]]
                    way[a:a + 2] += move
                else:
                    way[a] = move/2 + max(way[a], way[a + 1])
                    points[a] = (points[a] + points[a + 1])/2
                    keep[a + 1] = False
                moved, farthest, done = moved + 2, max(farthest, float(way[a])), int(a) + 3
                break
        if not done:
            break
        points, lines, way = points[keep], lines[keep], way[keep]
    return points, lines, moved, farthest
