"""Whether forces and contacts of a row agree with the call: mass, weight and roll inertia, points of contact, angles, radii.

Newton's law holds in every row, so that accelerations and forces tell the inertia: forces over accelerations have its slope. In
rows in which hardly anything accelerates, the forces tell the weight. An error of some percent hides in the momentum of a
whole run, whose impacts are hundreds of times as large. Contact points lie on the rail, where forces are normal to its profile.
"""
from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
from scipy.spatial import KDTree

from ldbench import Case
from ldbench.constants import CONTACTS, GRAVITY
from ldbench.geometry.outlines import case_outlines
from ldbench.results.derived import cumulative
from ldbench.results.run_data import RunData

from .findings import DOUBTFUL, FAILED, UNKNOWN, Finding, judged

LINEAR = 0.04           # residual over the forces, at most, of rows that obey one law
QUIET = 0.3             # share of the rows, those with the least acceleration, that tell the weight
LEAST_ROWS = 20
INERTIA = 0.005, 0.015  # relative errors: doubtful, wrong. Rows in which the law does not hold are not judged
ROLL_INERTIA = 0.03, 0.06   # points of contact may be anywhere within the elastic approach
OF_MOMENT = "Y", "Z", *(f"{name}_{contact}" for name in ("Fy", "Fz", "y", "z") for contact in CONTACTS)
LIGHT = 3e5             # force with a patch short enough for one direction of the profile [N]; heavier ones span an arc
LOADED = 0.02           # of the largest force of a contact, from which its rows count
ROWS = 3000             # at most
MOST = 0.9              # of the impulse of a contact that has to be where it is said to be
AWAY = 0.3e-3, 2e-3     # from the rail, beyond the elastic approach: doubtful, wrong [m]
TURNED = 0.05, 0.2      # from the normal of the profile: doubtful, wrong [rad]
MODULUS = 9e10          # force over approach to the power 3/2 of steel wheels on rails, roughly [N/m^1.5]
RADIUS = 0.3e-3, 1.5e-3 # from the distance of the contact from the axle, beyond the elastic approach: doubtful, wrong [m]
LIFT = 2e-4             # range of Z that tells whether a radius follows it [m]
ONE, LIKE = 0.15, 0.9   # by what the slope may differ from 1; least correlation
ARC = 1e-3              # to either side over which the direction of the profile is taken [m]: patches are longer


def inertia_findings(run: RunData, case: Case, dense: bool = False) -> Iterator[Finding]:
    """Mass, weight and roll inertia. dense: rows are so near, and contacts so soft, that accelerations are those of the forces."""
    weight = weight_of(case)
    if has(run, "aZ", *(f"Fz_{contact}" for contact in CONTACTS)):
        force, a = total(run, "Fz"), run.values("aZ")
        quiet = np.abs(a) <= np.nanquantile(np.abs(a), QUIET)
        found = float(np.nanmedian((force - case.mass*a)[quiet]))
        yield slope_finding("mass by the vertical forces", a, force - found, case.mass, INERTIA, "kg", dense)
        yield judged("weight and vertical load", abs(found/weight - 1), *INERTIA,
                     hint=f"expected {1e-3*weight:.1f} kN, found {1e-3*found:.1f} kN where hardly anything accelerates")
    if has(run, "aY", *(f"Fy_{contact}" for contact in CONTACTS)):
        yield slope_finding("mass by the lateral forces", run.values("aY"), total(run, "Fy") + lateral_force(run, case), case.mass,
                            INERTIA, "kg", dense)
    if has(run, "roll_acc", *OF_MOMENT):
        yield slope_finding("roll inertia", run.values("roll_acc"), roll_moment(run, case), case.roll_inertia, ROLL_INERTIA,
                            "kg m2")


def has(run: RunData, *columns: str) -> bool:
    """Whether a file has columns."""
    return all(column in run.data for column in columns)


def weight_of(case: Case) -> float:
    """Weight of the wheelset and vertical load [N]."""
    return float(case.mass*GRAVITY + case.vertical_load)


def lateral_force(run: RunData, case: Case) -> np.ndarray:
    """The lateral force that acts on the wheelset beside those of the contacts, (rows,) [N]."""
    return case.lateral_force + case.lateral_ramp*run.time


def lateral_work(run: RunData, case: Case) -> np.ndarray:
    """The work of that force, (rows,) [J]."""
    return cumulative(run.time, lateral_force(run, case)*run.values("vY"))


def roll_moment(run: RunData, case: Case) -> np.ndarray:
    """Moment of all contact forces about the axle's centre, (rows,) [N m]."""
    moment = np.zeros(run.time.size)
    for contact in CONTACTS:
        fy, fz, y, z = (run.values(f"{name}_{contact}") for name in ("Fy", "Fz", "y", "z"))
        moment += np.nan_to_num((y - run.values("Y"))*fz - (z - run.values("Z") - axle_height(case))*fy)
    return moment


def total(run: RunData, name: str) -> np.ndarray:
    """Sum of a force over the four contacts, (rows,) [N]."""
    return np.asarray(sum(np.nan_to_num(run.values(f"{name}_{contact}")) for contact in CONTACTS))


def slope_finding(what: str, acceleration: np.ndarray, force: np.ndarray, expected: float, limits: tuple[float, float],
                  unit: str, dense: bool = False) -> Finding:
    """Whether forces are an inertia times accelerations. dense: forces that are not proportional to them are wrong; otherwise the
    balances say whether they are."""
    fine = np.isfinite(acceleration) & np.isfinite(force)
    a, f = acceleration[fine], force[fine]
    # Rows in which the acceleration jumps would decide alone: sums of absolute values count each as it is large.
    loud = np.abs(a) > 0.01*np.max(np.abs(a), initial=0.0)
    if loud.sum() < LEAST_ROWS:
        return Finding(what, UNKNOWN, hint="no rows with an acceleration")
    slope = float(np.median(f[loud]/a[loud]))
    left = float(np.median(np.abs(f[loud] - slope*a[loud]))/np.median(np.abs(f[loud])))
    if not left <= LINEAR or slope <= 0:
        return Finding(what, FAILED if dense else UNKNOWN, left, LINEAR,
                       hint="forces and accelerations of a row are not proportional")
    return judged(what, abs(slope/expected - 1), *limits, hint=f"expected {expected:g} {unit}, found {slope:.4g} {unit}")


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
            yield from lift_finding(run, case, contact, rows)
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
    said, distance = run.values(f"radius_{contact}")[rows], distance_from_axle(run, case, contact)[rows]
    error = np.nan_to_num(np.abs(said - distance), nan=np.inf)
    beyond = np.maximum(error - 1.5*(n/MODULUS)**(2/3), 0.0)
    ratio = float(np.median(said/distance))
    cause = ("a diameter" if abs(ratio - 2) < 0.02 else "another sign" if abs(ratio + 1) < 0.02 else
             "another unit than the name says" if not 0.1 < abs(ratio) < 10 else
             "the radius of another wheel, or of a wheelset of another size")
    return judged(f"radius_{contact} is the distance from the axle", most(beyond, n), *RADIUS, int(rows[beyond.argmax()]) + 1,
                  f"[m]; expected {float(np.median(distance)):.4f} m, found {float(np.median(said)):.4f} m: {cause}")


def distance_from_axle(run: RunData, case: Case, contact: str) -> np.ndarray:
    """Distance of a contact point from the axle's axis, (rows,) [m]."""
    y, z, roll = (run.values(name) for name in (f"y_{contact}", f"z_{contact}", "roll"))
    return np.asarray((y - run.values("Y"))*np.sin(roll) - (z - run.values("Z") - axle_height(case))*np.cos(roll))


def lift_finding(run: RunData, case: Case, contact: str, rows: np.ndarray) -> Iterator[Finding]:
    """Whether a rolling radius has the vertical displacement of the axle in it, in these rows: a height is no radius."""
    error, lift = (run.values(f"radius_{contact}") - distance_from_axle(run, case, contact))[rows], run.values("Z")[rows]
    fine = np.isfinite(error) & np.isfinite(lift)
    error, lift = error[fine] - np.mean(error[fine]), lift[fine] - np.mean(lift[fine])
    if error.size < LEAST_ROWS or np.ptp(lift) < LIFT or not error.any():
        return
    slope, likeness = float(error @ lift/(lift @ lift)), float(error @ lift/np.sqrt((error @ error)*(lift @ lift)))
    if abs(abs(slope) - 1) < ONE and abs(likeness) > LIKE:
        worst = int(rows[fine][np.abs(error).argmax()]) + 1
        yield Finding(f"radius_{contact} does not follow Z", DOUBTFUL, slope, 0.0, worst,
                      f"it changes by {slope:.2f} times Z beside the distance from the axle: a height is no radius")
