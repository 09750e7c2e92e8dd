"""Imaginary codes with laws of their own: a small simulator of the exercises whose stiffness, damping, step and table are planted.

It shares the placed outlines of the profiles and the weight with ldbench and nothing else: contact is N = k δⁿ of the depth of
the wheel in the rail, with damping if wanted, and time goes in equal steps of a simple scheme. Rigid codes are runs of ours
without their columns of impulses.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pandas as pd
from scipy import ndimage
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

import ldbench
from ldbench import Case
from ldbench.geometry.outlines import case_outlines
from ldbench_round.physics_checks import weight_of
from ldbench_round.tasks import QUANTITIES, Task

SIDE = np.array([1.0, 1.0, -1.0, -1.0])     # right wheels are left ones in a mirror
SPLIT = np.radians(10)                      # tangent angle between tread and flange
SPACING = 0.4e-3, 0.2e-3                    # of the points of tread and flange [m]
COARSE = 5                                  # points from one that is looked at first to the next
GRID = 1.25e-4                              # of points whose distance from the rail is known [m]
SHIFT = 2e-6*np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])      # for the slope of the distance [m]
UNITS = {**dict.fromkeys(("Y", "Z", "y", "z", "radius"), "m"), "time": "s", "roll": "rad", "angle": "rad", "vY": "m/s", "vZ": "m/s",
         "roll_rate": "rad/s", "aY": "m/s2", "aZ": "m/s2", "roll_acc": "rad/s2", **dict.fromkeys(("N", "Fy", "Fz"), "N")}


@dataclass(frozen=True)
class Physics:
    """The laws of a code."""

    k: float = 9e10                         # N = k δⁿ [N/mⁿ]
    n: float = 1.5
    hunt_crossley: float = 0.0              # factor χ of N = k δⁿ (1 + χ dδ/dt) [s/m]
    kelvin_voigt: float = 0.0               # c of N = k δⁿ + c dδ/dt, not below 0 [N s/m]
    scheme: Literal["newmark", "symplectic Euler"] = "newmark"      # Newmark with β = 0, γ = 1/2
    step: float = 5e-5                      # [s]
    every: int = 2                          # steps from row to row
    pitch: float = 0.0                      # of a contact table over Y [m]; 0: no table
    stepwise: bool = False                  # whether angles are taken from the nearest point of the table


class Exact:
    """Deepest points of treads and flanges in the rails, from the outlines."""

    def __init__(self, profiles: str) -> None:
        case = Case.exercise(2, profiles)
        outlines = case_outlines(case)
        self.height = outlines.axle
        wheel, rail = (resampled(points) for points in (outlines.left.wheel, outlines.left.rail))
        at, line = fine(rail, 1e-5)
        slope = np.gradient(line, at, axis=0)
        normal = np.column_stack([-slope[:, 1], slope[:, 0]])/np.hypot(*slope.T)[:, None]
        y, z = np.arange(0.714, 0.785, GRID), np.arange(-0.022, 0.006, GRID)
        points = np.stack(np.meshgrid(y, z, indexing="ij"), axis=-1)
        near = nearest(line, points)
        distance = np.einsum("ijk,ijk->ij", points - line[near], normal[near])
        self.corner = np.array([y[0], z[0]])
        self.spline = ndimage.spline_filter(distance, order=3, mode="nearest")
        s, w = fine(wheel, 1e-4)
        angle = np.arctan2(*np.gradient(w, s, axis=0).T[::-1])
        tip = int(w[:, 1].argmin())
        crown = (np.arange(len(s)) > tip) & (angle > -0.02) & (angle < np.radians(80))
        tread = crown & (angle < SPLIT) & (w[:, 0] < 0.785)
        flange = crown & (angle >= SPLIT)
        arcs = [np.arange(s[part].min(), s[part].max(), spacing) for part, spacing in zip((tread, flange), SPACING, strict=True)]
        size = max(map(len, arcs))
        self.last = np.array([len(arc) - 1 for arc in arcs]*2)
        shape = CubicSpline(s, w)
        # The shorter of both is repeated at its end.
        r = [shape(np.concatenate([arc, np.full(size - len(arc), arc[-1])])) for arc in arcs]
        self.r = np.stack([r[0], r[1], r[0], r[1]])

    def outside(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (..., 2) from the rail, by a cubic spline."""
        at = (points - self.corner)/GRID
        return ndimage.map_coordinates(self.spline, np.moveaxis(at, -1, 0), order=3, mode="nearest", prefilter=False)

    def contacts(self, q: np.ndarray) -> tuple[np.ndarray, ...]:
        """Depth (4,), normal (4, 2), arm (4, 2) and rolling radius (4,) of the contacts in a pose, as on the left."""
        y, z, roll = SIDE*q[0], q[1], SIDE*q[2]
        c, s = np.cos(roll)[:, None], np.sin(roll)[:, None]
        arm = np.stack([c*self.r[..., 0] - s*self.r[..., 1], s*self.r[..., 0] + c*self.r[..., 1]], axis=-1)
        # Every fifth point, then all points about the deepest of these.
        centre = np.column_stack([y, np.full(4, z)])
        depth = -self.outside(arm[:, ::COARSE] + centre[:, None])
        i = np.arange(4)
        around = np.clip(COARSE*depth.argmax(axis=1), COARSE, arm.shape[1] - COARSE - 1)[:, None] + np.arange(-COARSE, COARSE + 1)
        depth = -self.outside(arm[i[:, None], around] + centre[:, None])
        top = around[i, depth.argmax(axis=1)]
        m = np.clip(depth.argmax(axis=1), 1, 2*COARSE - 1)
        k = around[i, m]
        below, here, above = depth[i, m - 1], depth[i, m], depth[i, m + 1]
        bend = below - 2*here + above
        x = np.clip(np.where(bend < 0, (below - above)/np.where(bend < 0, 2*bend, 1.0), 0.0), -1, 1)[:, None]
        weights = [(x*x - x)/2, 1 - x*x, (x*x + x)/2]
        deepest = sum(w*arm[i, k + j] for j, w in zip((-1, 0, 1), weights, strict=True))
        own = sum(w*self.r[i, k + j] for j, w in zip((-1, 0, 1), weights, strict=True))
        distance, right, left, above, below = self.outside(deepest + centre + np.concatenate([[[0, 0]], SHIFT])[:, None])
        normal = np.column_stack([right - left, above - below])
        normal /= np.maximum(np.hypot(*normal.T), np.finfo(float).tiny)[:, None]
        # A zone that is deepest at its border is touched beyond it.
        inside = (top > 0) & (top < self.last)
        return np.where(inside, -distance, -1.0), normal, deepest, -own[:, 1]


class Tabulated:
    """Touching height, angle and arm of every contact over Y, level, with a pitch; roll is taken into account linearly."""

    def __init__(self, exact: Exact, pitch: float, stepwise: bool) -> None:
        self.height, self.stepwise = exact.height, stepwise
        reach = int(np.ceil(0.014/pitch))
        self.y = pitch*np.arange(-reach, reach + 1)
        left = np.array([[self.touching(exact, y, contact) for contact in (0, 1)] for y in self.y])
        self.rows = np.concatenate([left, left[::-1]], axis=1)

    @staticmethod
    def touching(exact: Exact, y: float, contact: int) -> list[float]:
        """Height of the axle at which a contact of the level wheelset touches, angle, arm and radius."""
        z = exact.height + max(0.0, abs(y) - 0.009)
        for _ in range(25):
            depth, normal, arm, radius = (x[contact] for x in exact.contacts(np.array([y, z, 0.0])))
            if abs(depth) < 1e-9:
                break
            z += np.clip(depth/max(normal[1], 0.2), -1e-3, 1e-3)
        # A contact that cannot be closed at this Y never is; that of a tread on the gauge face is the flange's.
        apart = abs(depth) > 1e-7 or (contact == 0 and normal[1] < 0.9)
        return [exact.height - 0.02 if apart else z, np.arctan2(-normal[0], max(normal[1], 0.2)), *arm, radius]

    def contacts(self, q: np.ndarray) -> tuple[np.ndarray, ...]:
        """As those of `Exact`."""
        x = np.clip((q[0] - self.y[0])/(self.y[1] - self.y[0]), 0, len(self.y) - 1.001)
        k, share = int(x), x - int(x)
        height, angle, a_y, a_z, radius = ((1 - share)*self.rows[k] + share*self.rows[k + 1]).T
        if self.stepwise:
            angle = self.rows[round(x), :, 1]
        roll = SIDE*q[2]
        depth = (height - q[1] - (a_y + a_z*np.tan(angle))*roll)*np.cos(angle)
        normal = np.column_stack([-np.sin(angle), np.cos(angle)])
        return depth, normal, np.column_stack([a_y - roll*a_z, a_z + roll*a_y]), radius


def resampled(points: np.ndarray) -> np.ndarray:
    """Points in ascending order of Y as the core gives them, or turned round."""
    return points if points[-1, 0] > points[0, 0] else points[::-1]


def fine(points: np.ndarray, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Arc lengths at equal intervals, and points of a spline there."""
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.arange(0, arc[-1], spacing)
    return at, CubicSpline(arc, points)(at)


def nearest(line: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Numbers of the points of a smooth line that are nearest to points (..., 2): among every 20th, then about this one."""
    near = 20*cKDTree(line[::20]).query(points)[1]
    for step in (5, 1):
        others = np.clip(near[..., None] + step*np.arange(-4, 5), 0, len(line) - 1)
        best = np.sum((line[others] - points[..., None, :])**2, axis=-1).argmin(axis=-1)
        near = np.take_along_axis(others, best[..., None], axis=-1)[..., 0]
    return near


@functools.cache
def exact(profiles: str) -> Exact:
    """The geometry of a pair of profiles."""
    return Exact(profiles)


@functools.cache
def tabulated(profiles: str, pitch: float, stepwise: bool) -> Tabulated:
    """A table of the geometry of a pair of profiles."""
    return Tabulated(exact(profiles), pitch, stepwise)


def geometry_of(task: Task, physics: Physics) -> Exact | Tabulated:
    """The geometry that a code works with."""
    return tabulated(task.profiles, physics.pitch, physics.stepwise) if physics.pitch else exact(task.profiles)


@functools.cache
def simulate(task: Task, physics: Physics, t_end: float = np.inf) -> pd.DataFrame:
    """The quantities of the call in SI units, as `imaginary_codes.table_of`, up to the return to the centre or to `t_end` [s]."""
    case, shape = Case.exercise(task.exercise, task.profiles), geometry_of(task, physics)
    inertia, weight = np.array([case.mass, case.mass, case.roll_inertia]), weight_of(case)

    def forces(t: float, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
        depth, normal, arm, radius = shape.contacts(q)
        rate = SIDE*v[2]
        closing = -((SIDE*v[0] - rate*arm[:, 1])*normal[:, 0] + (v[1] + rate*arm[:, 0])*normal[:, 1])
        elastic = physics.k*np.maximum(depth, 0.0)**physics.n
        n = np.where(depth > 0, np.maximum(elastic*(1 + physics.hunt_crossley*closing) + physics.kelvin_voigt*closing, 0.0), 0.0)
        fy, fz = n*normal[:, 0], n*normal[:, 1]
        total = np.array([SIDE @ fy + case.lateral_force + case.lateral_ramp*t, fz.sum() - weight,
                          SIDE @ (arm[:, 0]*fz - arm[:, 1]*fy)])
        return total/inertia, (n, normal, arm, radius)

    z = shape.height
    for _ in range(60):         # rest: the treads carry the weight
        short = inertia[1]*forces(0.0, np.array([0.0, z, 0.0]), np.zeros(3))[0][1]
        z += 0.3*short/(physics.k*physics.n*2e-2*1e-4**(physics.n - 1)*50)
    q, v, t = np.array([0.0, z, 0.0]), np.array([case.vY, case.vZ, case.roll_rate]), 0.0
    rows, hit, h, step = [], False, physics.step, 0
    t_end = min(t_end, case.t_end)
    a, contact = forces(t, q, v)
    while t <= t_end + h/2:
        hit |= contact[0][3] > 0
        if step % physics.every == 0:
            rows.append(row_of(t, q - [0, z, 0], v, a, q, contact))
            if hit and q[0] > 0 and v[0] > 0:
                break
        if physics.scheme == "symplectic Euler":
            v = v + h*a
            q = q + h*v
        else:
            v = v + h/2*a
            q = q + h*v
        step += 1
        t = step*h
        a, contact = forces(t, q, v)
        if physics.scheme == "newmark":
            v = v + h/2*a
    frame = pd.DataFrame(rows, columns=["time", *QUANTITIES])
    frame.attrs["units"] = {name: UNITS[name if name in UNITS else name.partition("_")[0]] for name in frame}
    return frame


def row_of(t: float, moved: np.ndarray, v: np.ndarray, a: np.ndarray, q: np.ndarray,
           contact: tuple[np.ndarray, ...]) -> list[float]:
    """A row of the file: motion, then angle, N, Fz, Fy, y, z, radius of the contacts; open contacts have no place."""
    n, normal, arm, radius = contact
    open_ = np.where(n > 0, 1.0, np.nan)
    angle = np.arctan2(-normal[:, 0], normal[:, 1])
    return [t, *moved, *v, *a, *(angle*open_), *n, *(n*normal[:, 1]), *(SIDE*n*normal[:, 0]), *((q[0] + SIDE*arm[:, 0])*open_),
            *((q[1] + arm[:, 1])*open_), *(radius*open_)]


def rigid(task: Task, restitution: float) -> ldbench.Run:
    """A run of ours with rigid contacts, to be written without its impulses."""
    case = Case.exercise(task.exercise, task.profiles)
    return ldbench.run(case.replace(formulation="unilateral", restitution=restitution, output_file=""))
