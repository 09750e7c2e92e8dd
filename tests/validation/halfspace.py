"""The half-space solver against closed forms of contact mechanics.

Frictionless contact of elastic half-spaces on rectangular elements (Boussinesq-Love influence coefficients, no tension and no
interpenetration to 1e-9 of the depth). K. L. Johnson, Contact Mechanics (1985): Hertz's ellipse (4.25-4.32) over axis ratios
0.05 to 20, flat punch (3.34-3.37); bodies of the form r^n (I. N. Sneddon, Int. J. Eng. Sci. 3 (1965) 47-57; n = 1 is the cone,
5.3); two patches that act on each other. Semi-axes are those of the pressure's second moments.
"""
from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, gamma

from checks import Check, Section, limit, relative
from probes import probe, text
from sheets import Table

E_STAR = 1.0       # the solver is linear in it
RATIOS = 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0       # semi-axis rolling to transverse
SOURCE = "Hertz (Johnson 4.25-4.32)"


@dataclass
class Pressed:
    """Solution on elements centred at x > 0 (rows) and s (columns)."""

    x: np.ndarray
    s: np.ndarray
    depth: np.ndarray
    p: np.ndarray
    area: float             # of an element

    @property
    def force(self) -> float:
        return 2*self.p.sum()*self.area

    @property
    def energy(self) -> float:
        return (self.p*self.depth).sum()*self.area

    def semi_axis(self, at: np.ndarray) -> float:
        """The semi-axis of an ellipsoid of pressure, along x or s, from the second moment N a^2/5."""
        return float(np.sqrt(5*(self.p*at**2).sum()/self.p.sum()))

    def peak(self) -> float:
        """Largest pressure of an ellipsoid of pressure, from force and area of the moments."""
        a, b = self.semi_axis(self.x[:, None]), self.semi_axis(self.s[None])
        return 1.5*self.force/(np.pi*a*b)


def press(n: int, width: float, length: float, depth: Callable[[np.ndarray, np.ndarray], np.ndarray],
          ns: int | None = None) -> Pressed:
    """Press a body on n (x, of which half are solved) by ns (default n) elements over |x| < width, |s| < length."""
    ns = ns or n
    dx, ds = 2*width/n, 2*length/ns
    x, s = (np.arange(n//2) + 0.5)*dx, (np.arange(ns) + 0.5)*ds - length
    g = depth(x[:, None], s[None])
    ok, *pressures = probe("halfspace_pressure", stdin=f"{n//2} {ns} {dx!r} {ds!r} {E_STAR!r}\n" + text(g.T.ravel()[:, None]))[:, 0]
    if not ok:
        raise RuntimeError("the half-space solver did not reach its tolerance")
    return Pressed(x, s, g, np.reshape(pressures, (ns, n//2)).T, dx*ds)


class Hertz:
    """Hertz's ellipse with largest pressure E*/1000 and semi-axes `ratio` along x, 1 along s."""

    def __init__(self, ratio: float) -> None:
        self.p0 = 1e-3*E_STAR
        self.a, self.b = ratio, 1.0
        long, short = max(self.a, self.b), min(self.a, self.b)
        m = 1 - (short/long)**2
        if m > 0:
            share = self.p0*short/(E_STAR*m*long**2)
            curvatures = share*(ellipk(m) - ellipe(m)), share*((long/short)**2*ellipe(m) - ellipk(m))
        else:
            curvatures = 2*(np.pi*self.p0/(4*long*E_STAR),)
        self.A, self.B = curvatures if self.a >= self.b else curvatures[::-1]
        self.delta = self.p0*short*ellipk(m)/E_STAR
        self.force = 2/3*np.pi*long*short*self.p0
        self.energy = 0.4*self.force*self.delta

    def press(self, n: int, approach: float = 1.0) -> Pressed:
        """Solve on 1.1 times the semi-axes, at a multiple of the approach."""
        return press(n, 1.1*self.a, 1.1*self.b, lambda x, s: approach*self.delta - self.A*x**2 - self.B*s**2)


QUANTITIES = "force", "semi-axis along x", "semi-axis along s", "largest pressure", "energy"


def hertz_errors(ratio: float, n: int) -> np.ndarray:
    """Relative deviations of QUANTITIES from Hertz's ellipse on n x n elements."""
    exact, found = Hertz(ratio), Hertz(ratio).press(n)
    values = found.force, found.semi_axis(found.x[:, None]), found.semi_axis(found.s[None]), found.peak(), found.energy
    return np.array(values)/[exact.force, exact.a, exact.b, exact.p0, exact.energy] - 1


def two_patches(n: int, distance: float = 8.0) -> tuple[float, float]:
    """Force of each of two Hertz circles of radius about 1 that act on each other, and the far-field answer.

    Far away a load N displaces the surface by N/(pi E* d) (Boussinesq); the next term is of the order (a/d)^2/10 of
    that.
    """
    circle = Hertz(1.0)
    found = press(n, 1.1, distance/2 + 1.1, ns=int(n*(distance/2 + 1.1)/1.1), depth=lambda x, s: (
        circle.delta - circle.A*x**2 - circle.B*(np.abs(s) - distance/2)**2))
    stiffness = circle.force/circle.delta**1.5
    return found.force/2, brentq(lambda N: N - stiffness*(circle.delta - N/(np.pi*E_STAR*distance))**1.5, 0, circle.force)


def section() -> Section:
    stated = 40
    checks: list[Check] = []
    rows = []
    for ratio in RATIOS:
        errors = hertz_errors(ratio, stated)
        rows.append([f"{ratio:g}", *(f"{100*e:+.4f}" for e in errors)])
        worst = int(np.argmax(np.abs(errors[:4])))
        # 0.5 % is the bar for each of N, a, b, p0.
        checks.append(limit(f"Hertz, semi-axes {ratio:g}:1, largest of N, a, b, p0 ({QUANTITIES[worst]}) off by [1]",
                            errors[worst], f"{SOURCE}, {stated} x {stated} elements", 5e-3))
    grids = 8, 12, 16, 24, 32, 48, 64
    order = -np.polyfit(np.log(grids), np.log(np.abs([hertz_errors(1.0, n)[4] for n in grids])), 1)[0]
    # Pressure falls like a square root at the edge: the area errs by a part of an element, its share of
    # the energy by the power 2 or more.
    checks.append(Check("order of convergence of the energy, circle [1]", order, 2.0, "error ~ (element)^2",
                        max(0.0, 2 - order), 0.3))
    delta = 1e-3
    for power, name in (1, "cone"), (4, "r^4"):
        # The contact has radius 1 with this c.
        c = delta/(0.5*np.sqrt(np.pi)*power*gamma(power/2)/gamma(power/2 + 0.5))
        found = press(stated, 1.1, 1.1, lambda x, s, c=c, power=power: delta - c*np.hypot(x, s)**power)
        force = 2*E_STAR*delta*power/(power + 1)
        for what, unit, ours, exact in (("force", "E* a^2/1000", 1e3*found.force, 1e3*force),
                                        ("energy", "E* a^3/10^6", 1e6*found.energy, 1e6*force*delta*power/(2*power + 1))):
            checks.append(relative(f"{name}: {what} [{unit}]", ours, exact, "Sneddon (1965)", 5e-3))
    # A flat circular punch: N = 2 E* a delta, infinite pressure at its rim, which is uncertain by a part of an element, 2/stated.
    punch = press(stated, 1.0, 1.0, lambda x, s: np.where(np.hypot(x, s) <= 1, 1e-3, -1.0))
    checks.append(relative("flat punch: force [E* a^2/1000]", 1e3*punch.force, 2.0, "Johnson 3.36", 2/stated))
    ours, far = two_patches(20)
    # Far field: next term (a/d)^2/10 of the displacement, itself a part 2a/(3d) ... of delta: 1e-4; elements: 1e-3.
    checks.append(relative("two circles 8 a apart: force of each [E* a^2/1000]", 1e3*ours, 1e3*far,
                           "Hertz with Boussinesq's far field", 3e-3))
    for ratio in 0.2, 1.0, 5.0:
        # The force is the exact derivative of the discrete energy: h^2 = 1e-6 remains of the central difference.
        h, exact = 1e-3, Hertz(ratio)
        low, middle, high = (exact.press(stated, approach) for approach in (1 - h, 1.0, 1 + h))
        checks.append(relative(f"Hertz, {ratio:g}:1: force [E* a^2/1000], from dU/d(approach)",
                               1e3*(high.energy - low.energy)/(2*h*exact.delta), 1e3*middle.force, "force of the same solution",
                               1e-5))
    return Section("Half-space solver against closed forms", __doc__, checks, [Table(
        f"Deviation from Hertz in percent, {stated} x {stated} elements over 1.1 times the semi-axes",
        ["semi-axes, rolling : transverse", *QUANTITIES], rows)])
