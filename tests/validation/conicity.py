"""Rolling radii and equivalent conicity of the rigid wheelset, against exact circles and EN 15302's definition.

Test profiles have closed forms at any amplitude (round_profiles): cones of 1:40, 1:20 and 1:10 on round rail heads, and hollow
wheels on round heads, where the wheelset is a four-bar linkage. For the shipped profiles the reference is the rigid contact of
their exact arcs and lines, found without splines or tables. A 1:40 cone does not have a conicity of 0.025: the wheelset rolls
as it shifts, which moves the contacts on the round heads, so tan(gamma_e) = e/(2R - d) = 0.0256. Wickens' formula says the
same.

The core linearises harmonically: tan(gamma_e) = 1/(pi a) int_0^2pi (delta_r(a sin t)/2) sin t dt (Mauer; Knothe and Stichel,
Rail Vehicle Dynamics, 2017). EN 15302 (Annex B) takes the cone of the same wavelength as the kinematic motion y'' =
-delta_r(y)/(2 b r_0), 2 b being the distance of the contacts. Both agree to the first order in the non-linearity of delta_r:
to six digits up to the flange contact. Beyond it they differ by 20 to 45 %, for of a jump of delta_r near the turning point
the wavelength sees less than the first harmonic; the core's rule, 200 phases and cells of 0.1 mm, is good to 1 % from a few
tenths of a millimetre beyond the contact on, and wrong by up to 20 % nearer to it.

On the actual profiles the rigid wheelset has two ways to stand from about 10.2 mm on, and only the steeper one beyond 10.42
mm.
"""
from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy.optimize import brentq

import make_profiles as arcs
from checks import Check, Section, limit, relative
from ldbench import Case, ContactTable
from ldbench.constants import MM
from quasistatic import PAIRS, pieces
from round_profiles import Shape
from sheets import Table

DeltaR = Callable[[np.ndarray], np.ndarray]     # lateral displacements [m] to radius differences [m]

SHAPES = {f"cone 1:{n} on heads of {MM*R_r:.0f} mm": Shape(np.arctan(1/n), np.inf, R_r)
          for n, R_r in ((40, 0.254), (40, 0.08), (20, 0.08), (10, 0.08))} | {
         f"arc of {MM*R_w:.0f} mm on heads of {MM*R_r:.0f} mm": Shape(np.arctan(1/40), R_w, R_r)
         for R_w, R_r in ((0.5, 0.3), (0.4, 0.3), (0.36, 0.3))}
AMPLITUDES = np.arange(1, 10)*1e-3      # [m]
HOLLOW_AMPLITUDES = np.array([0.5, 1, 1.5, 2, 2.5, 3])*1e-3     # the contact stays on the arcs [m]

# A cone is linear: no error but rounding. On arcs the core sees a spline through points 0.25 mm apart; an error of 1 um
# in a radius of curvature changes 1/(R_w - R_r) by 2e-5 for 60 mm; some um are allowed for.
CONE_BAR, ARC_BAR, FINE_BAR = 1e-7, 1e-4, 1e-5
# Points rounded to 1e-9 mm, 0.25 mm apart, turn the tangent by 4e-9 rad; on a head of 254 mm the contact moves by 1 nm,
# the radius by 25 pm on each wheel: 7e-7 of delta_r at 1 mm.
SHIPPED_BAR = 1e-6
# Where an arc of 10 mm ends, the spline through points 0.05 mm apart is beside it by h^2/(80 R) = 3 nm. On the flange
# delta_r grows with the displacement, by up to 20 mm per mm below 60 degrees and 27 on its straight face: by 60 and 80 nm
# at either of the two ends and of the rail.
FACE, DELTA_R_BAR, FACE_BAR = np.radians(60), 2e-7, 4e-7
# Beyond the flange contact delta_r jumps by J = 20 mm. The core's rule sees the jump to half a cell of 0.1 mm and
# half a step of 2 pi/200 of the phase, 0.115 mm together: 2/(pi a) J (c/a) 0.115 mm/(a cos t) = 5 % at 1.1 c.
FLANGE_BAR = 6e-2


def harmonic(delta_r: DeltaR, amplitude: float) -> float:
    """Harmonic linearisation, by the midpoint rule."""
    t = (np.arange(2000) + 0.5)*np.pi/2/2000
    return float(np.mean(delta_r(amplitude*np.sin(t))*np.sin(t))/amplitude)


def by_wavelength(delta_r: DeltaR, amplitude: float) -> float:
    """EN 15302: from the wavelength of the kinematic motion, as an integral over its first quarter.

    With y = a sin t the integrand of the quarter of the wavelength, dy/sqrt(2 (G(a) - G(y))), is smooth.
    """
    n = 4000
    edges = amplitude*np.sin(np.linspace(0, np.pi/2, n + 1))
    middle = amplitude*np.sin((np.arange(n) + 0.5)*np.pi/2/n)
    f0, fm, f1 = delta_r(edges[:-1]), delta_r(middle), delta_r(edges[1:])
    G = np.concatenate([[0], np.cumsum(np.diff(edges)*(f0 + f1)/2)])
    G_middle = G[:-1] + (middle - edges[:-1])*(f0 + fm)/2
    quarter = np.pi/2*np.mean(np.sqrt(amplitude**2 - middle**2)/np.sqrt(2*(G[-1] - G_middle)))
    return (np.pi/2/quarter)**2/2


def touching(pair: str, y: float) -> float:
    """Radius difference [m] of the rigid wheelset from the exact arcs of a shipped pair, y >= 0 in m.

    Beyond the flange contact it may stand in up to three ways; the one with the least roll is what it comes to from
    the centre.
    """
    wheel, rail = pieces(pair)

    def radii(roll: float) -> tuple[float, float, float]:
        found = []
        for side in (1, -1):
            height, _, point = arcs.touch(wheel, rail, side*MM*y, side*roll)
            offset = point - np.array([side*MM*y, height])
            found.append((height, offset[0]*np.sin(side*roll) - offset[1]*np.cos(roll)))
        (left, r_left), (right, r_right) = found
        return left - right, r_left, r_right

    # The lower two solutions are below 2.5 mrad and approach each other.
    steps = np.concatenate([np.arange(0, 2.5e-3, 1e-4), np.arange(2.5e-3, 20e-3, 5e-4)])
    beyond = next(k for k, phi in enumerate(steps) if k > 0 and radii(phi)[0] <= 0)
    roll = brentq(lambda phi: radii(phi)[0], *steps[beyond - 1:beyond + 1], xtol=1e-15)
    _, r_left, r_right = radii(roll)
    return (r_left - r_right)/MM


def tabulated(pair: str, last: float, spacing: float) -> DeltaR:
    """The rolling radius difference of the exact arcs, interpolated between points, odd in y."""
    grid = np.arange(0, last + spacing, spacing)
    values = np.array([touching(pair, y) for y in grid])
    return lambda y: np.copysign(np.interp(np.abs(y), grid, values), y)


def section() -> Section:
    checks, curves = [], {}
    for name, shape in SHAPES.items():
        found = shape.geometry(amplitudes_of(shape))
        checks += shape_checks(name, shape, found)
    for pair in PAIRS:
        table = ContactTable(Case.exercise(1, pair))
        reference = tabulated(pair, 1.2*table.clearance, 2e-5)
        geometry = table.geometry(np.linspace(0, 1.2*table.clearance, 241)[1:])
        curves[pair] = geometry, reference, table.clearance
        checks += shipped_checks(pair, table, geometry, reference)
    return Section("Contact geometry and equivalent conicity", __doc__, checks, [
        Table("Equivalent conicity of the shipped profiles", (
            "pair", "amplitude [mm]", "core", "exact arcs, harmonic", "exact arcs, EN 15302 by wavelength"),
            [(pair, f"{MM*a:.2f}", f"{conicity_at(geometry, a):.6f}", f"{harmonic(reference, a):.6f}",
              f"{by_wavelength(reference, a):.6f}")
             for pair, (geometry, reference, clearance) in curves.items()
             for a in (1e-3, 5e-3, 9e-3, 1.05*clearance, 1.1*clearance, 1.15*clearance)])])


def conicity_at(geometry: pd.DataFrame, amplitude: float) -> float:
    return float(np.interp(amplitude, geometry.Y, geometry.conicity))


def amplitudes_of(shape: Shape) -> np.ndarray:
    return AMPLITUDES if np.isinf(shape.R_w) else HOLLOW_AMPLITUDES


def shape_checks(name: str, shape: Shape, geometry: pd.DataFrame) -> list[Check]:
    straight, amplitudes = np.isinf(shape.R_w), amplitudes_of(shape)
    bar = CONE_BAR if straight else ARC_BAR
    expected = shape.delta_r(amplitudes)
    last = amplitudes[-1]
    wavelength = by_wavelength(shape.delta_r, last)
    checks = [
        limit(f"delta_r from {MM*amplitudes[0]:g} to {MM*last:g} mm, largest relative deviation, {name}",
              np.abs(geometry.delta_r/expected - 1).max(), "closed form", bar),
        relative(f"conicity at {MM*last:g} mm, {name}", geometry.conicity.iloc[-1], harmonic(shape.delta_r, last),
                 "harmonic linearisation of the closed form", bar),
        # Second order in the non-linearity, below 1e-3 of delta_r here.
        relative(f"conicity at {MM*last:g} mm, {name}", geometry.conicity.iloc[-1], wavelength,
                 "EN 15302: wavelength of the closed form", max(bar, 1e-6)),
        # The closed form is of first order in (amplitude/(R_w - R_r))^2.
        relative(f"conicity at {MM*amplitudes[0]:g} mm, {name}", geometry.conicity.iloc[0], shape.small,
                 "small amplitudes, Wickens", max(bar, 1e-6))]
    if not straight:
        fine = shape.geometry(amplitudes, arcs.STEP/2)
        checks.append(limit(f"delta_r with points half as far apart, largest relative deviation, {name}",
                            np.abs(fine.delta_r/expected - 1).max(), "closed form", FINE_BAR))
    return checks


def shipped_checks(pair: str, table: ContactTable, geometry: pd.DataFrame, reference: DeltaR) -> list[Check]:
    clearance = table.clearance
    # At the clearance itself either contact is right.
    geometry = geometry[np.abs(geometry.Y - clearance) > 1e-6]
    error = 1e6*np.abs(geometry.delta_r - np.array([touching(pair, y) for y in geometry.Y]))
    on_face = geometry.angle_L > FACE
    missing = table.geometry(np.linspace(1, 1.05, 501)*clearance).delta_r.isna()
    checks = [limit(f"displacements of {len(missing)} from the clearance to 1.05 times it without a contact, {pair}",
                    missing.sum(), "the rigid wheelset stands on both rails", 0.0),
              limit(f"delta_r up to 1.2 times the clearance, contact angle below 60°, largest deviation [um], {pair}",
                    error[~on_face].max(), "rigid contact of the exact arcs", 1e6*DELTA_R_BAR)]
    if on_face.any():
        checks.append(limit(f"delta_r on the face of the flange, above 60°, largest deviation [um], {pair}",
                            error[on_face].max(), "rigid contact of the exact arcs", 1e6*FACE_BAR))
    for a in (3e-3, 6e-3, 9e-3):
        found = conicity_at(geometry, a)
        checks += [relative(f"conicity at {MM*a:.0f} mm, {pair}", found, harmonic(reference, a),
                            "exact arcs, harmonic linearisation", SHIPPED_BAR),
                   relative(f"conicity at {MM*a:.0f} mm, {pair}", found, by_wavelength(reference, a),
                            "exact arcs, EN 15302 by wavelength", SHIPPED_BAR)]
    return [*checks, relative(f"conicity at 1.1 times the clearance, {pair}", conicity_at(geometry, 1.1*clearance),
                              harmonic(reference, 1.1*clearance), "exact arcs, harmonic linearisation", FLANGE_BAR)]
