"""Whether forces act where a file says that they act: contact points on the rail, and forces normal to its profile there."""
from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from scipy.spatial import KDTree

from ldbench import Case
from ldbench.geometry.outlines import case_outlines
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData

from .findings import Finding, judged

LIGHT = 3e5             # force with a patch short enough for one direction of the profile [N]; heavier ones span an arc
LOADED = 0.02           # of the largest force of a contact, from which its rows count
ROWS = 3000             # at most
MOST = 0.9              # of the impulse of a contact that has to be where it is said to be
AWAY = 0.3e-3, 2e-3     # from the rail, beyond the elastic approach: doubtful, wrong [m]
TURNED = 0.05, 0.2      # from the normal of the profile: doubtful, wrong [rad]
MODULUS = 9e10          # force over approach to the power 3/2 of steel wheels on rails, roughly [N/m^1.5]
RADIUS = 0.3e-3, 1.5e-3 # from the distance of the contact from the axle, beyond the elastic approach: doubtful, wrong [m]
ARC = 1e-3              # to either side over which the direction of the profile is taken [m]: patches are longer


@cache
def rail_of(exercise: Case) -> tuple[np.ndarray, np.ndarray]:
    """Points of the left rail, (n, 2) [m], and the angle of the profile there as contact angles have it, (n,) [rad]."""
    points = case_outlines(exercise).left.rail
    points = points if points[-1, 0] > points[0, 0] else points[::-1]
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.arange(0.0, arc[-1], 1e-4)
    fine = np.column_stack([np.interp(at, arc, points[:, k]) for k in range(2)])
    ahead, behind = (np.column_stack([np.interp(at + way*ARC, arc, points[:, k]) for k in range(2)]) for way in (1, -1))
    return fine, np.arctan2(*(ahead - behind).T[::-1])


@cache
def axle_height(case: Case) -> float:
    """Height of the axle of the centred wheelset above the top of rail [m]; it sinks by a tenth of a millimetre at rest."""
    return case_outlines(case).axle


def most(x: np.ndarray, weight: np.ndarray) -> float:
    """The number that MOST of the weight does not exceed."""
    return float(np.quantile(x, MOST, weights=weight/weight.max(), method="inverted_cdf"))


def place_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """Contact points lie on the rail, and contact angles are those of its profile there."""
    rail, slope = rail_of(case)
    for contact in CONTACTS:
        columns = [f"{name}_{contact}" for name in ("N", "y", "z")]
        if not all(column in run.data for column in columns):
            continue
        n, y, z = (run.values(column) for column in columns)
        n = np.nan_to_num(n)
        rows = np.flatnonzero((n > LOADED*n.max(initial=0.0)) & np.isfinite(y) & np.isfinite(z))
        if not rows.size:
            continue
        rows = rows[::max(1, rows.size // ROWS)]
        outward = 1 if contact[0] == "L" else -1
        points = np.column_stack([outward*y[rows], z[rows]])
        distance, foot = KDTree(rail).query(points)
        beyond = np.maximum(distance - 1.5*(n[rows]/MODULUS)**(2/3), 0.0)
        worst = int(rows[beyond.argmax()]) + 1
        yield judged(f"contact point of {contact} lies on the rail", most(beyond, n[rows]), *AWAY, worst,
                     "[m]; positions of another origin or of another frame, or another profile")
        if {"Y", "Z", "roll", f"radius_{contact}"} <= set(run.data):
            yield radius_finding(run, case, contact, rows, n[rows])
        if f"angle_{contact}" not in run.data:
            continue
        light = n[rows] <= LIGHT
        if not light.any():
            continue
        rows, foot = rows[light], foot[light]
        angle = run.values(f"angle_{contact}")[rows]
        # Either sign is in use.
        error = min((np.nan_to_num(np.abs(sign*angle - slope[foot])) for sign in (1, -1)), key=lambda e: float(np.median(e)))
        yield judged(f"angle_{contact} is that of the rail at the contact point", most(error, n[rows]), *TURNED,
                     int(rows[error.argmax()]) + 1, "[rad]; the force is not normal to the profile where it is said to act")


def radius_finding(run: RunData, case: Case, contact: str, rows: np.ndarray, n: np.ndarray) -> Finding:
    """Whether a rolling radius is the distance of the contact from the axle in these rows, in which the contact carries n [N]."""
    y, z, said = (run.values(f"{name}_{contact}")[rows] for name in ("y", "z", "radius"))
    roll = run.values("roll")[rows]
    distance = (y - run.values("Y")[rows])*np.sin(roll) - (z - run.values("Z")[rows] - axle_height(case))*np.cos(roll)
    error = np.nan_to_num(np.abs(said - distance), nan=np.inf)
    beyond = np.maximum(error - 1.5*(n/MODULUS)**(2/3), 0.0)
    ratio = float(np.median(said/distance))
    cause = ("a diameter" if abs(ratio - 2) < 0.02 else "another sign" if abs(ratio + 1) < 0.02 else
             "another unit than the name says" if not 0.1 < abs(ratio) < 10 else
             "the radius of another wheel, or of a wheelset of another size")
    return judged(f"radius_{contact} is the distance from the axle", most(beyond, n), *RADIUS, int(rows[beyond.argmax()]) + 1,
                  f"[m]; expected {float(np.median(distance)):.4f} m, found {float(np.median(said)):.4f} m: {cause}")
