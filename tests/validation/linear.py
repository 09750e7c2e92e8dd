"""The three eigenfrequencies of the wheelset at rest, found in six ways: by the core; by SciPy from the tangent stiffness;
from differences of the forces; from the zero crossings of runs that start in a mode with 0.2 micrometres; from the closed
form of two lines (the treads) on two circles (the rail heads) with Hertz's force; and, for the lateral mode, from that of
the rigid wheelset, a pendulum. All with strips, which are Hertz's law there; the half-space table, whose lateral stiffness
of 12 N/mm is what is left of 1e6 N/mm, against the closed form.

The centred wheelset stands with two lines, at the angle g, on two circles of radius rho. In the wheelset's frame the
penetration of the left head, its centre being p = (p_y, p_z) from the axle centre, is delta = d0 - p_y sin(g + roll) + p_z
cos(g + roll), exactly and at any displacement. With Hertz's force N(delta) the tangent stiffness of a wheel is N' grad(delta)
grad(delta)^T + N hess(delta): the contact springs and the geometric (gravity) stiffness. For N' to infinity the lateral mode
(0.44 Hz) becomes the pendulum, omega^2 = W (4R - d)/(M (2R - d)^2 + I_x); the gap, 0.09 % with steel as it is, closes as N/N'
does, with the approach, which goes with scale^(-2/3). It takes the nine decimals of the shipped points to see that: with six
the curvature under a patch is uncertain by up to 1e-3 1/m. Bounce (208 Hz) and roll (239 Hz) are oscillations on the two
contact springs.
"""
from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eigh

import ldbench
from checks import Check, Section, absolute, limit, relative
from ldbench import Case, ContactTable
from probes import E_STAR, MASS, ROLL_INERTIA, ROLLING_RADIUS, TAPER, WEIGHT, Pendulum
from quasistatic import PAIRS
from round_profiles import hertz
from sheets import Table

MODES = "lateral", "bounce", "roll"         # in the order of their frequencies
M = np.diag([MASS, MASS, ROLL_INERTIA])
SCALES = 1, 3, 10, 30, 100, 300             # of the elastic modulus


def closed_form(pendulum: Pendulum, scale: float) -> tuple[np.ndarray, float]:
    """Tangent stiffness (y, z, roll) of the wheelset at rest, and the approach [m]."""
    s, c = np.sin(TAPER), np.cos(TAPER)
    *_, C = hertz(c/(2*ROLLING_RADIUS), 1/(2*pendulum.rho), 1.0, scale*E_STAR)      # force at an approach of 1 m
    N = WEIGHT/(2*c)
    approach = (N/C)**(2/3)
    p_y, p_z = pendulum.centre[0], -ROLLING_RADIUS - pendulum.rho*c + approach/c
    gradient = np.array([s, -c, -p_y*c - p_z*s])
    hessian = np.array([[0, 0, c], [0, 0, s], [c, s, p_y*s - p_z*c]])
    left = 1.5*N/approach*np.outer(gradient, gradient) + N*hessian
    mirror = np.diag([-1, 1, -1])
    return left + mirror @ left @ mirror, approach


def frequencies(K: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """[Hz], ascending, and the modes in columns, of unit modal mass."""
    squares, modes = eigh(K, M)
    return np.sqrt(squares)/(2*np.pi), modes


def differenced(table: ContactTable) -> np.ndarray:
    """Tangent from forces at steps of 1 and 2 um (fourth order)."""
    q = np.array([0.0, table.equilibrium, 0.0])
    columns = []
    for i, length in enumerate((1.0, 1.0, 1/0.75)):
        h = np.zeros(3)
        h[i] = 1e-6*length
        slope = [(table.force(*(q - n*h)) - table.force(*(q + n*h)))/(2*n*h[i]) for n in (1, 2)]
        columns.append((4*slope[0] - slope[1])/3)
    K = np.array(columns)
    return (K + K.T)/2


def free_oscillation(table: ContactTable, mode: np.ndarray, frequency: float, periods: int) -> float:
    """Frequency of a run that starts in a mode with an amplitude of AMPLITUDE at the contacts [Hz]."""
    q = mode*AMPLITUDE/np.abs(mode*[1, 1, 0.75]).max()
    interval = 2e-3/frequency
    case = table.case.replace(vY=0.0, roll_rate=0.0, Y=q[0], Z=q[1], initial_roll=q[2], stop_at="t_end", rows="interval",
                              dt=min(table.case.dt, interval), interval=interval, t_end=(periods + 0.5)/frequency)
    c = ldbench.run(case, table=table).data
    t, x = c["time"].to_numpy(), c[["Y", "Z", "roll"]].to_numpy() @ M @ mode
    up = np.flatnonzero((x[:-1] < 0) & (x[1:] >= 0))
    crossing = t[up] - x[up]*(t[up + 1] - t[up])/(x[up + 1] - x[up])
    return (len(crossing) - 1)/(crossing[-1] - crossing[0])


def stiff_table(case: Case, scale: float) -> ContactTable:
    """A small table about the position at rest; its depth goes with the approach."""
    return ContactTable(case.replace(stiffness_scale=scale, depth=1e-3*scale**(-2/3), lateral=0.02, table_roll=0.01,
                                     table_folder=""))


# Hardening: a Hertz spring at approach d has its frequency lowered by (A/d)^2/24 by an amplitude A: 1.7e-7 at 0.2 um.
AMPLITUDE, FREE_BAR = 0.2e-6, 1e-6      # [m]
# The lateral stiffness of 12 kN/m is what is left of 1e9 N/m, whose differences carry a rounding of 0.5 N/m.
DIFFERENCE_BARS = 1e-4, 1e-6, 1e-6
# The strips' tables are to have the lateral frequency within 0.02 %. Hertz's paraboloid against the circle: (7/254)^2/2.
SHIPPED_BARS = 2e-4, 4e-4, 4e-4
# Half-spaces: the table errs by 3e-4 of 90 kN, smoothly over some mm, of which 12 N/mm are little.
HALFSPACE_BARS = 2e-2, 4e-4, 4e-4
EXACT_BARS = 3e-5, 4e-4, 4e-4           # the table's second derivatives in roll: 1e-5
SLOPE_BARS = 0.02, 2e-3                 # 5e-7 of interpolation in a gap of 2e-5, over five powers of e


def section() -> Section:
    checks, rows = [], []
    for pair in PAIRS:
        table, pendulum = ContactTable(Case.exercise(1, pair).replace(contact_model="strip")), Pendulum.of(pair)
        K = table.tangent(0.0, table.equilibrium, 0.0)
        f, shapes = frequencies(K)
        hertz, approach = closed_form(pendulum, 1.0)
        by_difference, by_formula = frequencies(differenced(table))[0], frequencies(hertz)[0]
        checks.append(relative(f"approach at rest [mm], {pair}", 1e3*(table.rigid_height - table.equilibrium),
                               1e3*approach, "Hertz on the crown", 1e-3))
        for i, name in enumerate(MODES):
            run = free_oscillation(table, shapes[:, i], f[i], 4 if i == 0 else 50)
            rows.append((pair, name, *(f"{x:.6f}" for x in (table.frequencies[i], f[i], by_difference[i], run,
                                                           by_formula[i])),
                         f"{pendulum.omega/(2*np.pi):.6f}" if i == 0 else ""))
            checks += [
                relative(f"{name} frequency of the core [Hz], {pair}", table.frequencies[i], f[i],
                         "scipy.linalg.eigh of the tangent", 1e-9),
                relative(f"{name} frequency of the tangent [Hz], {pair}", f[i], by_difference[i],
                         "differences of the forces", DIFFERENCE_BARS[i]),
                relative(f"{name} frequency of a run [Hz], {pair}", run, f[i], "tangent", FREE_BAR),
                relative(f"{name} frequency [Hz], {pair}", f[i], by_formula[i],
                         "closed form: Hertz springs on lines and circles", SHIPPED_BARS[i])]
        checks += [relative(f"{name} frequency [Hz], {pair}, halfspace", found, by_formula[i],
                            "closed form: Hertz springs on lines and circles", HALFSPACE_BARS[i])
                   for i, (name, found) in enumerate(zip(
                       MODES, ContactTable(Case.exercise(1, pair)).frequencies, strict=True))]
        strip = Case.exercise(1, pair).replace(contact_model="strip")
        checks += sweep_checks(pair, pendulum, np.array([stiff_table(strip, scale).frequencies for scale in SCALES]))
    return Section("Small oscillations at rest", __doc__, checks, [
        Table("Frequencies [Hz]", ("pair", "mode", "core", "tangent, scipy", "differences of forces", "run",
                                   "closed form, Hertz", "rigid pendulum"), rows)])


def sweep_checks(pair: str, pendulum: Pendulum, found: np.ndarray) -> list[Check]:
    rigid = pendulum.omega/(2*np.pi)
    formula = np.array([frequencies(closed_form(pendulum, s)[0])[0] for s in SCALES])
    gap = 1 - found[:, 0]/rigid
    checks = [limit(f"{name} frequency against the closed form, stiffness times {float(min(SCALES))} to {float(max(SCALES))}, "
                    f"largest deviation, {pair}", np.abs(found[:, i]/formula[:, i] - 1).max(),
                    "Hertz springs on lines and circles", EXACT_BARS[i])
              for i, name in enumerate(MODES)]
    return [*checks,
            absolute(f"gap of the lateral frequency to the rigid pendulum: power of the stiffness, {pair}",
                     slope(SCALES, gap), -2/3, "gap goes with the approach", SLOPE_BARS[0]),
            absolute(f"bounce frequency: power of the stiffness, {pair}", slope(SCALES, found[:, 1]), 1/3,
                     "Hertz: stiffness at a given load with scale^(2/3)", SLOPE_BARS[1])]


def slope(x: Sequence[float], y: np.ndarray) -> float:
    """Power of x in y."""
    return float(np.polyfit(np.log(x), np.log(np.abs(y)), 1)[0])

