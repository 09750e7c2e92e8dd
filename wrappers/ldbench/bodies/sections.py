"""Cross-sections of the rim of a wheel and the head of a rail, and what holds them."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .._core.errors import Error
from ..profiles.smoothing import chord_lengths

Kind = Literal["wheel", "rail"]
Support = Literal["infinite", "clamped"]

WIDTH = 3e-3            # of a strip [m]
PARTS = 3               # sides of triangles on a strip
SIDE = 20e-3            # below its top, to which a rail is touched [m]
RADIUS = 2.0            # of the body that an infinite one is cut to [m]; 1 to 3 m change a first peak by 0.3 %
ARC = 40                # sides of its border
NEAR = 0.2e-3           # of an outline to the profile [m]

# Generic sections go on from the profile straight to their base.
RIM_THICKNESS = 50.8e-3     # from the tread at the tape circle: 2 in, two-wear wheels (AAR M-107/M-208)
HEAD_DEPTH = 49.2e-3        # from the top: 1 15/16 in, 136RE (AREMA, Manual for Railway Engineering, ch. 4)


@dataclass(frozen=True)
class Section:
    """The section of a body, counterclockwise from the first strip on [m]."""

    kind: Kind
    ends: np.ndarray            # of the strips and their parts, (PARTS*strips + 1, 2)
    rest: np.ndarray            # the other corners, (m, 2)
    held: tuple[int, int]       # corners of the rest between which it does not move


def section(kind: Kind, profile: np.ndarray, support: Support, depth: float, outline: np.ndarray | None = None,
            file: str = "") -> Section:
    """The section below a profile, (n, 2) y and z up from first to last point [m].

    The base is what lies highest of a wheel's section, lowest of a rail's. It is the one of an outline from a file, a closed
    polygon [m], or lies `depth` above a wheel's z = 0, below a rail's top [m]. An 'infinite' body goes on behind the base as a
    half-plane does; a 'clamped' one is held there.
    """
    ends = divided(profile if kind == "wheel" else profile[profile[:, 1] > profile[:, 1].max() - SIDE])
    up = 1 if kind == "wheel" else -1
    if kind == "rail":
        ends = ends[::-1]
    if outline is None:
        base = depth if kind == "wheel" else profile[:, 1].max() - depth
        rest = np.array([[ends[-1, 0], base], [ends[0, 0], base]])
        if (up*(base - ends[:, 1])).min() <= 0:
            raise Error(expected=f"a {'rim' if kind == 'wheel' else 'head'} that reaches beyond the profile",
                        found=f"one of {1e3*depth:g} mm")
    else:
        rest = beyond(outline, ends, file)
    height = up*rest[:, 1]
    first, last = np.flatnonzero(height > height.max() - 1e-6)[[0, -1]]
    if first == last:
        raise Error(file=file, expected="an outline with a straight base of one z", found="a single point there")
    if support == "clamped":
        return Section(kind, ends, rest, (int(first), int(last)))
    centre = (rest[first] + rest[last])/2
    turn = np.linspace(0, np.pi, ARC + 1)
    arc = centre + RADIUS*up*np.column_stack([np.cos(turn), np.sin(turn)])
    arc[[0, -1], 1] = centre[1]
    return Section(kind, ends, np.concatenate([rest[:first + 1], arc, rest[last:]]), (int(first) + 1, int(first) + 1 + ARC))


def divided(line: np.ndarray) -> np.ndarray:
    """Ends of strips and of their parts on a line of points, in its middle."""
    along = chord_lengths(line)
    strips = int(along[-1]/WIDTH)
    if strips < PARTS + 1:
        raise Error(expected=f"a profile of at least {1e3*(PARTS + 1)*WIDTH:g} mm", found=f"{1e3*along[-1]:.1f} mm")
    at = (along[-1] - strips*WIDTH)/2 + np.linspace(0, strips*WIDTH, strips*PARTS + 1)
    return np.column_stack([np.interp(at, along, x) for x in line.T])


def beyond(outline: np.ndarray, ends: np.ndarray, file: str) -> np.ndarray:
    """The corners of an outline from the last strip's end on to the first one's, counterclockwise."""
    if np.linalg.norm(outline[0] - outline[-1]) > NEAR:
        raise Error(file=file, expected="an outline that ends where it begins",
                    found=f"ends that are {1e3*np.linalg.norm(outline[0] - outline[-1]):.1f} mm apart")
    ring = outline[:-1]
    turned = np.roll(ring, -1, axis=0)
    if np.sum(ring[:, 0]*turned[:, 1] - turned[:, 0]*ring[:, 1]) < 0:
        ring = ring[::-1]
    away, side = distances(ends, ring)
    if away.max() > NEAR:
        y, z = 1e3*ends[np.argmax(away)]
        raise Error(file=file, expected=f"an outline that has the profile, within {1e3*NEAR:g} mm",
                    found=f"{1e3*away.max():.2f} mm between them at y = {y:.1f}, z = {z:.1f} mm")
    first, last = side[-1] + 1, side[0]           # corner after the last strip's end; corner before the first one's
    count = (last - first) % len(ring) + 1
    return ring[(first + np.arange(count)) % len(ring)]


def distances(points: np.ndarray, ring: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance of points from a polygon, and which of its sides is nearest."""
    way = np.roll(ring, -1, axis=0) - ring
    reach = points[:, None] - ring
    share = np.clip(np.sum(reach*way, axis=2)/np.maximum(np.sum(way**2, axis=1), 1e-30), 0, 1)
    away = np.linalg.norm(reach - share[..., None]*way, axis=2)
    return away.min(axis=1), away.argmin(axis=1)
