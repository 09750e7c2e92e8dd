"""Measures of wheels and rails straight from points, with numpy alone: nothing of the package is used here.

Points are (n, 2) [mm] in order: y to the field side, from a wheel's back; z up. Between points a profile is straight.
"""
from __future__ import annotations

import numpy as np

TAPE, BELOW, ABOVE_TIP = 70.0, 10.0, 2.0        # of EN 15313, at full size [mm]
FINE = 0.04                                     # between points of a polygon that touches another [mm]
STEEPEST_ROLL = 0.06                            # [rad]


def crossing(points: np.ndarray, level: float) -> float:
    """y where a polygon first rises through a level."""
    z = points[:, 1]
    k = int(np.flatnonzero((z[:-1] < level) & (z[1:] >= level))[0])
    share = (level - z[k])/(z[k + 1] - z[k])
    return float(points[k, 0] + share*(points[k + 1, 0] - points[k, 0]))


def wheel(points: np.ndarray, scale: float = 1.0) -> dict[str, float]:
    """Sh, Sd and qR [mm] of a wheel 1:scale."""
    tip = int(points[:, 1].argmin())
    outer = points[tip:]
    tape = float(np.interp(TAPE/scale, outer[:, 0], outer[:, 1]))
    thickness = crossing(outer, tape - BELOW/scale)
    return {"Sh": tape - float(points[tip, 1]), "Sd": thickness,
            "qR": thickness - crossing(outer, float(points[tip, 1]) + ABOVE_TIP/scale)}


def gauge_point(points: np.ndarray, depth: float) -> float:
    """y of the innermost point of a rail down to a depth below its top [mm], EN 13848-1."""
    side = points[:int(points[:, 1].argmax()) + 1]
    level = side[:, 1].max() - depth
    inside = float(side[side[:, 1] >= level, 0].min())
    below = np.flatnonzero((side[:-1, 1] < level) & (side[1:, 1] >= level))
    return min([inside, *(crossing(side[k:k + 2], level) for k in below)])


def fine(points: np.ndarray) -> np.ndarray:
    s = np.r_[0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T))]
    at = np.arange(0.0, s[-1], FINE)
    return np.column_stack([np.interp(at, s, column) for column in points.T])


def clearance(wheel_points: np.ndarray, rail_points: np.ndarray, gauge: float, back_to_back: float, radius: float, depth: float,
              flange_angle: float) -> float:
    """Lateral displacement [mm] at which the left contact of the wheelset that stands on both rails is first as steep as
    flange_angle [rad]; lengths in mm."""
    # The rail from above: its highest point over every y, from the innermost point of its gauge side on.
    top = rail_points[:, 1].max()
    innermost = int(np.argmin(np.where(rail_points[:, 1] > top - 1.5*depth, rail_points[:, 0], np.inf)))
    rail = fine(rail_points[innermost:])
    rail = rail[np.r_[True, rail[1:, 0] > np.maximum.accumulate(rail[:-1, 0])]]
    rail = rail + [gauge/2 - gauge_point(rail_points, depth), -top]
    start = fine(wheel_points)
    outer = start[:, 0] + back_to_back/2
    step = np.gradient(start, axis=0)
    angle = np.arctan2(step[:, 1], step[:, 0])
    width = max(1, round(0.5/FINE))                 # the noise of points makes directions of neighbours useless
    smooth = np.convolve(np.pad(angle, width, "edge"), np.full(2*width + 1, 1/(2*width + 1)), "valid")

    def lift(z: np.ndarray, y: float, roll: float) -> tuple[float, int]:
        """How far the wheel is inside the rail, and where."""
        across = y + outer*np.cos(roll) - z*np.sin(roll)
        up = outer*np.sin(roll) + z*np.cos(roll)
        inside = np.interp(across, rail[:, 0], rail[:, 1], left=-1e9, right=-1e9) - up
        k = int(inside.argmax())
        return float(inside[k]), k

    low = start[:, 1] - start[lift(start[:, 1], 0.0, 0.0)[1], 1] - radius       # from the axle

    def left_contact(y: float) -> int:
        a, b = -STEEPEST_ROLL, STEEPEST_ROLL
        for _ in range(22):
            middle = (a + b)/2
            if lift(low, y, middle)[0] > lift(low, -y, -middle)[0]:
                a = middle
            else:
                b = middle
        return lift(low, y, (a + b)/2)[1]

    def on_flange(y: float) -> bool:
        k = left_contact(y)
        return bool(smooth[k] >= flange_angle)

    pace = 0.2*back_to_back/1360
    y = pace
    while not on_flange(y) and y < 250*pace:
        y += pace
    a, b = y - pace, y
    for _ in range(9):
        middle = (a + b)/2
        a, b = (a, middle) if on_flange(middle) else (middle, b)
    return (a + b)/2
