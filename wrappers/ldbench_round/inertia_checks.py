"""Whether mass, weight and roll inertia of a file are those of the call.

Newton's law holds in every row, so that accelerations and forces tell the inertia: forces over accelerations have its slope. In
rows in which hardly anything accelerates, the forces tell the weight. An error of some percent hides in the momentum of a
whole run, whose impacts are hundreds of times as large.
"""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ldbench import Case
from ldbench.results.derived import cumulative
from ldbench.results.quantities import CONTACTS, GRAVITY
from ldbench.results.run_data import RunData

from .findings import FAILED, UNKNOWN, Finding, judged
from .place_checks import axle_height

LINEAR = 0.04           # residual over the forces, at most, of rows that obey one law
QUIET = 0.3             # share of the rows, those with the least acceleration, that tell the weight
LEAST_ROWS = 20
INERTIA = 0.005, 0.015  # relative errors: doubtful, wrong. Rows in which the law does not hold are not judged
ROLL_INERTIA = 0.03, 0.06   # points of contact may be anywhere within the elastic approach


def inertia_findings(run: RunData, case: Case, dense: bool = False) -> Iterator[Finding]:
    """Mass, weight and roll inertia. dense: rows are so near, and contacts so soft, that accelerations are those of the forces."""
    forces = {name: [f"{name}_{contact}" for contact in CONTACTS] for name in ("Fy", "Fz", "y", "z")}
    weight = weight_of(case)
    if has(run, "aZ", *forces["Fz"]):
        force, a = total(run, "Fz"), run.values("aZ")
        quiet = np.abs(a) <= np.nanquantile(np.abs(a), QUIET)
        found = float(np.nanmedian((force - case.mass*a)[quiet]))
        yield slope_finding("mass by the vertical forces", a, force - found, case.mass, INERTIA, "kg", dense)
        yield judged("weight and vertical load", abs(found/weight - 1), *INERTIA,
                     hint=f"expected {1e-3*weight:.1f} kN, found {1e-3*found:.1f} kN where hardly anything accelerates")
    if has(run, "aY", *forces["Fy"]):
        yield slope_finding("mass by the lateral forces", run.values("aY"), total(run, "Fy") + lateral_force(run, case), case.mass,
                            INERTIA, "kg", dense)
    if has(run, "Y", "Z", "roll_acc", *(column for columns in forces.values() for column in columns)):
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
