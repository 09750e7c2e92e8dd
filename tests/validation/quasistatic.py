"""Exercise 5 without its impacts: the equilibria of the wheelset under a lateral force F at its centre of gravity, stable or
not.

They are the points where force(q) + (F, -W, 0) = 0, a curve in (q, F), followed from rest by pseudo-arclength continuation
(Keller 1977; Seydel, Practical Bifurcation and Stability Analysis, 2010) through the limit point, where the load cannot grow
any more, and on along the unstable branch.

The wheelset runs on its treads alone up to 0.13 kN (actual profiles) and 0.30 kN (simplified). Then the left flange takes the
force. Its contact moves up the throat while the right wheel is relieved. The limit is reached when the right wheel carries
nothing: weight, lateral force and the force of the left rail then meet in the centre of gravity, so F = W b/h with b and h the
lateral and vertical distance of the left contact from it. Without friction the rail's force is normal to the surfaces, so b/h
= tan(contact angle): the wheelset stands on that point of its flange whose normal passes through its centre of gravity. (W b/h
with 750 and 457 mm, the contact being on the crown, would be 295 kN; but no lateral force of that size is carried there.) It
overturns; it does not climb, which it would if L/V, the tangent of the contact angle, exceeded tan g, g being the largest
flange angle: Nadal's limit without friction.

The shipped runs bounce on the left flange. They fall when the energy of the bouncing exceeds the barrier between the stable
and the unstable equilibrium, which shrinks to nothing at the limit; so they fall at a smaller load, and at another one for
every perturbation. Started at rest from the equilibrium at 98 % of the limit, the same ramp unloads the right wheel at the
limit itself.

Results of runs have the limit as F_limit_left and F_limit_right, which the core finds by holding the wheelset aside. They are
compared with the limit points of the continuation, also for a wheelset whose sides differ, and with the closed form where
contacts are rigid.
"""
from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, fsolve

import ldbench
import make_profiles as arcs  # the exact pieces of the shipped profiles
from checks import Check, Section, absolute, limit, relative
from ldbench import Case, ContactTable
from ldbench.constants import DEG, KN, MM
from sheets import Table

PAIRS = {"aw": "actual profiles", "sw": "simplified profiles"}
SCALE = np.array([1.0, 1.0, 1/0.75])    # q per length: roll times half the distance of the contacts [m]
LENGTH = 1e-3                           # F/W counts as so much arc length [m]
FACE = {"aw": 75.0, "sw": 70.0}         # largest flange angle [deg]
LAST_Y = 55e-3                          # the tip of a flange is over the crown of its rail at 64 and 73 mm [m]
# Rail, wheel and clearance [mm] of the shipped profiles.
SHAPES = {"aw": (arcs.arprof, arcs.awprof, arcs.CLEARANCES["aw"]), "sw": (arcs.srprof, arcs.swprof, arcs.CLEARANCES["sw"])}


@dataclass
class Curve:
    """Equilibria in the order of arc length."""

    table: ContactTable
    x: np.ndarray           # (n, 4): y, z, 0.75 m roll, LENGTH F/W [m]
    tangent: np.ndarray     # (n, 4) of the curve, unit length
    last_stable: int        # row before the limit point
    limit: np.ndarray       # x there

    @property
    def q(self) -> np.ndarray:
        return self.x[:, :3]*SCALE

    @property
    def F(self) -> np.ndarray:
        return self.x[:, 3]*self.table.weight/LENGTH

    @property
    def F_limit(self) -> float:
        return self.limit[3]*self.table.weight/LENGTH

    def potential(self) -> np.ndarray:
        """The potential of contact and weight [J]."""
        return self.table.potential(*self.q.T) + self.table.weight*self.q[:, 1]


def residual(table: ContactTable, x: np.ndarray) -> np.ndarray:
    """Unbalanced force over the weight."""
    load = np.array([x[3]*table.weight/LENGTH, -table.weight, 0.0])
    return (table.force(*(x[:3]*SCALE)) + load)*SCALE/table.weight


def stiffness(table: ContactTable, x: np.ndarray) -> np.ndarray:
    """Tangent over lengths [N/m]."""
    return table.tangent(*(x[..., :3]*SCALE).T)*np.outer(SCALE, SCALE)


def jacobian(table: ContactTable, x: np.ndarray) -> np.ndarray:
    return np.column_stack([-stiffness(table, x)/table.weight, [1/LENGTH, 0, 0]])


def direction(table: ContactTable, x: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Unit tangent of the curve, onwards."""
    t = np.linalg.svd(jacobian(table, x))[2][-1]
    return np.copysign(1.0, t @ before)*t


def advance(table: ContactTable, x: np.ndarray, t: np.ndarray, step: float) -> np.ndarray | None:
    """The equilibrium at an arc length `step` from x by Newton's method; None where it fails."""
    y = x + step*t
    for _ in range(10):
        error = np.append(residual(table, y), t @ (y - x) - step)
        move = np.linalg.solve(np.vstack([jacobian(table, y), t]), error)
        y = y - move
        if np.abs(move).max() < 1e-13:
            return y
        if np.linalg.norm(y - x) > 2*abs(step):
            return None
    return None


def follow(table: ContactTable, largest: float, way: int = 1) -> Curve:
    """The equilibria from the wheelset at rest up to LAST_Y on the left (`way` = 1), or on the right (-1).

    Steps are at most `largest` [m] up to the limit point, where contacts close and open, ten times that beyond.
    """
    x = np.append(table.rest/SCALE, 0.0)
    t = direction(table, x, np.array([way, 0.0, 0.0, 0.0]))
    xs, ts, step = [x], [t], 1e-5
    while way*x[0] < LAST_Y:
        new = advance(table, x, t, step)
        # The path turns sharply where a wheel takes or loses its load.
        if new is None or (turn := direction(table, new, t)) @ t < 0.98:
            step /= 2
            if step < 1e-9:
                raise ArithmeticError(f"no continuation beyond y = {x[0]} m, F = {x[3]*table.weight/LENGTH} N")
            continue
        x, t = new, turn
        xs.append(x)
        ts.append(t)
        step = min(largest if way*t[3] > 0 else 10*largest, 1.5*step)
    xs, ts = np.array(xs), np.array(ts)
    k = int(np.argmax(way*ts[:, 3] < 0)) - 1
    share = brentq(lambda s: direction(table, advance(table, xs[k], ts[k], s), ts[k])[3],
                   1e-3*(s := ts[k] @ (xs[k + 1] - xs[k])), s, xtol=1e-16)
    return Curve(table, xs, ts, k, advance(table, xs[k], ts[k], share))


def work(curve: Curve, rows: slice) -> float:
    """Integral of F dY [J]."""
    slope = curve.tangent[rows, 3]/curve.tangent[rows, 0]*curve.table.weight/LENGTH
    return float(CubicHermiteSpline(curve.x[rows, 0], curve.F[rows], slope).integrate(*curve.x[rows, 0][[0, -1]]))


class Overturning(NamedTuple):
    """The rigid wheelset about to overturn about its left flange."""

    F: float            # lateral force [N]
    angle: float        # of the contact [rad]
    b: float            # distances of the contact from the centre of gravity [m]
    h: float
    y: float            # lateral displacement [m]
    roll: float


@functools.cache
def pieces(pair: str) -> tuple[list[arcs.Piece], list[arcs.Piece]]:
    """Left wheel, from the axle centre, and left rail, track frame [mm]."""
    make_rail, make_wheel, clearance = SHAPES[pair]
    wheel = arcs.shift(make_wheel(arcs.solve_throat(make_wheel, make_rail(), clearance)), arcs.WHEEL_BACK, 0)
    rail = arcs.shift(make_rail(), arcs.GAUGE_POINT, 0)
    height, _, (_, z) = arcs.touch(wheel[-1:], rail, 0, 0)
    return arcs.shift(wheel, 0, height - z - arcs.ROLLING_RADIUS), rail


def overturning(pair: str, weight: float) -> Overturning:
    """From the exact arcs: left flange and right tread touch, the normal of the left contact passes the centre."""
    wheel, rail = pieces(pair)
    flange, tread = wheel[1:-1], wheel[-1:]

    def miss(state: np.ndarray) -> tuple[float, float]:
        y, roll = state
        left, angle, point = arcs.touch(flange, rail, y, roll)
        right, _, _ = arcs.touch(tread, rail, -y, -roll)
        return left - right, (point[0] - y)*np.cos(angle) - (left - point[1])*np.sin(angle)

    y, roll = fsolve(miss, (SHAPES[pair][2] + 0.3, 4e-4), xtol=1e-13)
    height, angle, point = arcs.touch(flange, rail, y, roll)
    return Overturning(weight*np.tan(angle), angle, (point[0] - y)/MM, (height - point[1])/MM, y/MM, roll)


@dataclass
class Fall:
    """How a run leaves the rails."""

    F_unloaded: float       # when the right wheel carried for the last time [N]
    F_over: float           # when Y passed that of the unstable equilibrium for good [N]
    surplus: float          # energy then, above that of the stable equilibrium [J]
    needed: float           # height of the barrier at that force [J]
    F_derailed: float       # [N]
    told: tuple[float, float]   # F_unloaded as the results of the run have it, and what its force grows by between rows [N]


def fall(case: Case, curve: Curve) -> Fall:
    run = ldbench.run(case, table=curve.table)
    c = run.data
    F = c.F_ext.to_numpy()
    y, stable, unstable = barrier(curve, np.minimum(F, curve.F_limit))
    over = int(np.flatnonzero(c.Y.to_numpy() < y)[-1]) + 1
    row = c.iloc[over]
    energy = (row[["KE_lat", "KE_vert", "KE_roll", "PE_elastic_L", "PE_elastic_R"]].sum()
              + curve.table.weight*(curve.table.equilibrium + row.Z) - row.F_ext*row.Y)
    return Fall(last_load(c), F[over], energy - stable[over], unstable[over] - stable[over], F[-1],
                (run.results["F_unloaded"], case.lateral_ramp*case.interval))


def last_load(columns: pd.DataFrame) -> float:
    """Lateral force when the right wheel carried for the last time [N]."""
    return columns.F_ext[(columns.N_RT + columns.N_RF) > 0].iloc[-1]


def barrier(curve: Curve, F: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lateral displacement of the unstable equilibrium under F, and the potential of contact, weight and lateral force of the
    stable and the unstable one [J]."""
    k, V = curve.last_stable + 1, curve.potential()
    stable = np.interp(F, curve.F[:k], (V - curve.F*curve.x[:, 0])[:k])
    order = slice(None, k - 1, -1)      # from the far end of the unstable branch up to the limit
    y = np.interp(F, curve.F[order], curve.x[order, 0])
    unstable = np.interp(F, curve.F[order], (V - curve.F*curve.x[:, 0])[order])
    return y, stable, unstable


def equilibrium(curve: Curve, F: float) -> np.ndarray:
    """q of the stable equilibrium under F."""
    k, load = curve.last_stable + 1, F/curve.table.weight*LENGTH
    x = [np.interp(F, curve.F[:k], column) for column in curve.x[:k, :3].T]
    return fsolve(lambda q: residual(curve.table, np.append(q, load)), x, xtol=1e-13,
                  fprime=lambda q: -stiffness(curve.table, q)/curve.table.weight)*SCALE


# A contact that closes or opens within a step h makes an error of C_H h^2.5 in the work: 2e-4 J of 50 J at h = 20 um.
STEP, WORK_BAR = 20e-6, 1e-5
# The left flange is pressed in by 0.15 mm, the right tread not at all: over 1.5 m this turns the contact by 1e-4 rad,
# times d ln F/d angle = 1/(sin cos) = 2.2.
CLOSED_FORM_BAR = 3e-4
# The splines of the profiles turn by less than 1e-5 rad from the arcs, which counts 2.2 times.
RIGID_BAR = 3e-5
TABLE_BAR = 1e-3           # of the direction of a force of the table
# The load grows by 0.25 kN in the 50 ms that the wheelset takes to turn by the first 10 urad beyond the limit.
LAG_BAR = 1e-3


def section(short: bool = False) -> Section:
    """short: without the runs that bounce."""
    checks, curves, falls, rigid = [], {}, {}, {}
    for pair in PAIRS:
        table = ContactTable(Case.exercise(5, pair))
        curve = curves[pair] = follow(table, STEP)
        rigid[pair] = overturning(pair, table.weight)
        checks += [*equilibrium_checks(pair, curve, rigid[pair]), *told_limits(pair, curve, rigid[pair]), quiet_check(pair, curve)]
        if not short:
            falls[pair] = [fall(table.case.replace(vY=v), curve) for v in PERTURBATIONS]
            checks += fall_checks(pair, curve, falls[pair])
    if not short:
        checks += mixed_limits()
    return Section("Quasi-static exercise 5: how the wheelset derails", __doc__, checks,
                   [limit_table(curves, rigid), fall_table(curves, falls)])


# Two sides that differ: a wheel and a rail of the other pair on the right.
MIXED = {"wheel_profile_right": "profiles/swprof.yz", "rail_profile_right": "profiles/srprof.yz", "table_folder": ""}
# Newton's tolerance of the equilibria, 1e-8 of the weight, leaves as much in the limit; the core's answer is asked for to 1e-6.
LIMIT_BAR = 1e-6


def told_limit(table: ContactTable, side: str, **changes: object) -> float:
    """The static limit to the left or to the right that the results of a run tell [N]."""
    case = table.case.replace(t_end=table.case.interval, stop_at="t_end", **changes)
    return float(ldbench.run(case, table=None if changes else table).results[f"F_limit_{side}"])


def told_limits(pair: str, curve: Curve, rigid: Overturning) -> list[Check]:
    """The static limits in the results of runs: to either side, and of rigid contacts."""
    table = curve.table
    checks = [relative(f"F_limit_{side} of the results [kN], {pair}", KN*told_limit(table, side), KN*curve.F_limit,
                       "limit point of the continuation", LIMIT_BAR) for side in ("left", "right")]
    return [*checks, relative(f"F_limit_left of the results, rigid contacts [kN], {pair}",
                              KN*told_limit(table, "left", formulation="unilateral"), KN*rigid.F,
                              "W b/h on the exact arcs; splines turn by less than 1e-5 rad from them", RIGID_BAR)]


def mixed_limits() -> list[Check]:
    """The static limits of a wheelset whose sides differ."""
    table = ContactTable(Case.exercise(5, "aw").replace(MIXED))
    return [relative(f"F_limit_{side} of the results [kN], actual profiles on the left, simplified ones on the right",
                     KN*told_limit(table, side), KN*way*follow(table, STEP, way).F_limit, "limit point of the continuation",
                     LIMIT_BAR) for side, way in (("left", 1), ("right", -1))]


PERTURBATIONS = 0.0, 1e-6, 2e-6     # lateral velocity at the start [m/s]; 0 is the shipped case


def equilibrium_checks(pair: str, curve: Curve, rigid: Overturning) -> list[Check]:
    k, table, V = curve.last_stable, curve.table, curve.potential()
    eigenvalue = np.linalg.eigvalsh(stiffness(table, curve.x))[:, 0]
    at_limit = np.linalg.eigvalsh(stiffness(table, curve.limit))[0]
    below = eigenvalue[curve.F[:k + 1].searchsorted(0.9*curve.F_limit)]
    before = slice(0, k + 1)
    return [
        limit(f"unbalanced force of all equilibria over W, {pair}",
              max(np.abs(residual(table, x)).max() for x in curve.x), "Newton's tolerance 1e-13 m times 1e9 N/m", 1e-8),
        relative(f"work of F up to the limit [J], {pair}", work(curve, before), V[k] - V[0],
                 "change of the potential of contact and weight", WORK_BAR),
        relative(f"work of F to the end of the unstable branch [J], {pair}", work(curve, slice(None)), V[-1] - V[0],
                 "change of the potential of contact and weight", WORK_BAR),
        relative(f"limit load [kN], {pair}", KN*curve.F_limit, KN*rigid.F,
                 "rigid: W b/h where the normal of the exact flange arcs passes the centre of gravity",
                 CLOSED_FORM_BAR),
        # The flange's arc has one such point; the splines of the profiles turn by less than 1e-5 rad from the arcs. The
        # table's error turns the force.
        relative(f"limit load over W, {pair}", curve.F_limit/table.weight,
                 np.tan(rigid.angle - rigid.roll + curve.limit[2]*SCALE[2]),
                 "tangent of the same flange point's angle, turned by the elastic roll; bar 3e-5 and 1e-3 for the table's error",
                 RIGID_BAR + TABLE_BAR),
        limit(f"lowest eigenvalue below the limit, its negative part [N/m], {pair}", min(eigenvalue[before].min(), 0.0),
              "stable up to the limit", 0.0),
        limit(f"lowest eigenvalue beyond the limit, its positive part [N/m], {pair}",
              max(eigenvalue[k + 1:].max(), 0.0), "unstable beyond the limit", 0.0),
        # The limit is located to 1e-12 m; the eigenvalue falls by 1e8 N/m in some 1e-5 m.
        limit(f"lowest eigenvalue at the limit over that at 90 % of the load, {pair}", at_limit/below,
              "singular at the limit point", 1e-5)]


def quiet_check(pair: str, curve: Curve) -> Check:
    """The load ramp of exercise 5 from rest at 98 % of the limit load."""
    y, z, roll = equilibrium(curve, 0.98*curve.F_limit)
    case = curve.table.case.replace(Y=y, Z=z - curve.table.equilibrium, initial_roll=roll, lateral_force=0.98*curve.F_limit)
    return relative(f"run from rest at 98 % of the limit: right wheel carries up to F [kN], {pair}",
                    KN*last_load(ldbench.run(case, table=curve.table).data), KN*curve.F_limit, "limit load; lag of the ramp",
                    LAG_BAR)


def fall_checks(pair: str, curve: Curve, falls: list[Fall]) -> list[Check]:
    return [
        *(absolute(f"exercise 5, vY = {v:g} m/s at the start: F_unloaded of the results [kN], {pair}", KN*f.told[0],
                   KN*f.F_unloaded, "last row in which the right wheel carries; bar growth between rows", KN*f.told[1])
          for v, f in zip(PERTURBATIONS, falls, strict=True)),
        limit(f"exercise 5, {len(falls)} runs: last load of the right wheel above the limit, over the limit, {pair}",
              max(max(f.F_unloaded for f in falls)/curve.F_limit - 1, 0.0), "no equilibrium beyond the limit", LAG_BAR),
        # Beyond the limit there is none. Bar: the rows are 0.5 ms apart, in which Y and the barrier change by less
        # than 1 %.
        limit(f"exercise 5, {len(falls)} runs: energy that is missing for the barrier, over the barrier, {pair}",
              max((1 - f.surplus/f.needed for f in falls if f.F_over < curve.F_limit and f.surplus < f.needed),
                  default=0.0), "the saddle is the lowest way out", 1e-2)]


def limit_table(curves: dict[str, Curve], rigid: dict[str, Overturning]) -> Table:
    rows = []
    for pair, curve in curves.items():
        y, z, roll = curve.limit[:3]*SCALE
        force = curve.table.forces_by_contact(y, z, roll)
        L, V = force[:2, :2].sum(axis=0)
        r = rigid[pair]
        rows += [(f"{pair}, elastic", f"{KN*curve.F_limit:.3f}", f"{MM*y:.3f}", f"{1e3*roll:.4f}",
                  f"{DEG*np.arctan2(-L, V):.3f}", f"{-L/V:.4f}", f"{np.tan(np.radians(FACE[pair])):.4f}",
                  f"{KN*V:.3f}", f"{force[2:, 1].sum():.4f}", "", ""),
                 (f"{pair}, rigid", f"{KN*r.F:.3f}", f"{MM*r.y:.3f}", f"{1e3*r.roll:.4f}", f"{DEG*r.angle:.3f}",
                  f"{np.tan(r.angle):.4f}", f"{np.tan(np.radians(FACE[pair])):.4f}", f"{KN*curve.table.weight:.3f}",
                  "0", f"{MM*r.b:.2f}", f"{MM*r.h:.2f}")]
    return Table("Limit of equilibrium", ("pair", "F [kN]", "Y [mm]", "roll [mrad]", "contact angle [deg]", "L/V left",
                                          "tan g", "V left [kN]", "V right [N]", "b [mm]", "h [mm]"), rows)


def fall_table(curves: dict[str, Curve], falls: dict[str, list[Fall]]) -> Table:
    return Table("Exercise 5 bouncing: when it falls", (
        "pair", "vY at the start [m/s]", "limit load [kN]", "right wheel carries up to F [kN]",
        "past the unstable equilibrium at F [kN]", "its energy then [J]", "barrier then [J]", "derailment at F [kN]"), [
        (pair, f"{v:.0e}", f"{KN*curves[pair].F_limit:.2f}", f"{KN*f.F_unloaded:.2f}", f"{KN*f.F_over:.2f}",
         f"{f.surplus:.2f}", f"{f.needed:.2f}", f"{KN*f.F_derailed:.2f}")
        for pair, runs in falls.items() for v, f in zip(PERTURBATIONS, runs, strict=True)])
