"""A case as an initial value problem for any integrator, on the compiled force law; its reference solution."""
from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import sksundae
from scipy.integrate import solve_ivp

import ldbench
from ldbench import Case, ContactTable, _flat

SIZE = np.array([1e-2, 1e-2, 1e-2, 1.0, 1.0, 1.0])  # of the motion [m, rad] and per second: scales absolute tolerances
MAX_STEP = 1e-4                 # of the reference: a longer one may pass through a contact without seeing it [s]
STRICT, FINE = (1e-12, 1e-13), (1e-6, 5e-7)                 # tolerances and steps [s] of the references
SHORT_STRICT, SHORT_FINE = (1e-10, 1e-11), (2e-6, 1e-6)
ROWS = 100                      # of our output: the others give the end only
FAR_OFF = 1e15                  # rates of a trial pose outside the table: shortens the step (LSODA would keep a NaN)


@dataclass
class Problem:
    """x = (y, z, roll) and their rates; z from equilibrium."""

    case: Case
    table: ContactTable
    t_end: float
    trajectory: tuple[np.ndarray, np.ndarray, np.ndarray]   # y, z (above the rails), roll, of the shipped run
    start: np.ndarray
    rates: Callable[[float, np.ndarray], np.ndarray]
    jacobian: Callable[[float, np.ndarray], np.ndarray]


def problem(case: Case, table: ContactTable) -> Problem:
    """The case up to the last row of the shipped run before it ends: by then no step size has ended it."""
    table = table.for_case(case)
    columns = ldbench.run(case, table=table).columns.iloc[:-1]
    # The cheapest way from Python: the core's procedure on arrays that are there, no checks in between.
    forces, tangents, handle = _flat.forces, _flat.tangents, table._handle
    y, z, roll = np.empty(1), np.empty(1), np.empty(1)
    height, mass, inertia = table.equilibrium, case.mass, case.roll_inertia
    lateral, ramp, weight = case.lateral_force, case.lateral_ramp, table.weight

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        y[0], z[0], roll[0], vy, vz, roll_rate = x.tolist()
        z[0] += height
        force, status = forces(handle, 0, y, z, roll)
        if status[0]:
            return np.full(6, FAR_OFF)
        fy, fz, moment = force.ravel().tolist()
        return np.array([vy, vz, roll_rate, (fy + lateral + ramp*t)/mass, (fz - weight)/mass, moment/inertia])

    def jacobian(t: float, x: np.ndarray) -> np.ndarray:
        y[0], z[0], roll[0] = x[0], height + x[1], x[2]
        yy, yz, yr, zz, zr, rr = tangents(handle, 0, y, z, roll)[0].ravel().tolist()
        full = np.zeros((6, 6))
        full[0, 3] = full[1, 4] = full[2, 5] = 1
        full[3:, :3] = ((-yy/mass, -yz/mass, -yr/mass), (-yz/mass, -zz/mass, -zr/mass),
                        (-yr/inertia, -zr/inertia, -rr/inertia))
        return full

    start = np.array([case.Y, case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate])
    trajectory = tuple(np.ascontiguousarray(columns[c] + h) for c, h in (("Y", 0), ("Z", height), ("roll", 0)))
    return Problem(case, table, float(columns["time"].iloc[-1]), trajectory, start, rates, jacobian)


def numpy_law(table: ContactTable) -> Callable[[float, float, float], np.ndarray]:
    """Force on the wheelset by one Hertz spring per wheel, from the geometry functions."""
    g = table.geometry().dropna()
    Y, Z, roll = (g[c].to_numpy() for c in ("Y", "Z", "roll"))
    sides = [(g[f"angle_{s}"].to_numpy(), g[f"y_{s}"].to_numpy(), sign) for s, sign in (("L", 1), ("R", -1))]
    approach = table.rigid_height - table.equilibrium
    stiffness = table.weight/2/approach**1.5        # Hertz, from the approach at rest [N/m^1.5]

    def force(y: float, z: float, phi: float) -> np.ndarray:
        total = np.zeros(3)
        down = np.interp(y, Y, Z) + table.rigid_height - z
        tilt = np.interp(y, Y, roll) - phi
        for angle, lateral, sign in sides:
            gamma, arm = np.interp(y, Y, angle), np.interp(y, Y, lateral) - y
            depth = (down + tilt*arm)*np.cos(gamma)
            if depth > 0:
                N = stiffness*depth**1.5
                Fy, Fz = -sign*N*np.sin(gamma), N*np.cos(gamma)
                total += Fy, Fz, arm*Fz + z*Fy
        return total

    return force


def python_alone(p: Problem) -> Problem:
    """The same wheelset on that law, in Python from end to end."""
    law, height = numpy_law(p.table), p.table.equilibrium
    mass = np.array([p.case.mass, p.case.mass, p.case.roll_inertia])
    lateral, ramp, weight = p.case.lateral_force, p.case.lateral_ramp, p.table.weight

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        force = law(x[0], x[1] + height, x[2]) + (lateral + ramp*t, -weight, 0.0)
        return np.concatenate([x[3:], force/mass])

    return replace(p, rates=rates)


# One solution -----------------------------------------------------------------------------

@dataclass
class Solution:
    """The pose at the end and what it cost."""

    pose: np.ndarray            # Y, Z [m], roll [rad]; NaN if it failed
    seconds: float              # of the processor
    evaluations: int            # of the force law
    jacobians: int              # of its tangent


FAILED = np.full(3, np.nan)


def by_ldbench(p: Problem, scheme: str, order: int, beta: float, dt: float, energy_tolerance: float = 0.0) -> Solution:
    """By the core; its time includes events and energies that the others do not have."""
    case = p.case.replace(scheme=scheme, order=order, beta=beta, dt=dt, energy_tolerance=energy_tolerance,
                          t_end=p.t_end, stop_at="t_end", interval=p.t_end/ROWS)
    try:
        run = ldbench.run(case, table=p.table)
    except ldbench.Error:
        return Solution(FAILED, np.nan, 0, 0)
    last = run.columns[["time", "Y", "Z", "roll"]].to_numpy()[-1]
    reached = abs(last[0] - p.t_end) < 1e-9
    return Solution(last[1:] if reached else FAILED, run.summary["seconds"], run.summary["evaluations"], 0)


def by_scipy(p: Problem, method: str, tolerance: float, max_step: float = np.inf) -> Solution:
    options = {"jac": p.jacobian} if method == "Radau" else {}
    begin = time.process_time()
    found = solve_ivp(p.rates, (0, p.t_end), p.start, method, t_eval=[p.t_end], rtol=tolerance, atol=tolerance*SIZE,
                      max_step=max_step, **options)
    seconds = time.process_time() - begin
    return Solution(found.y[:3, -1] if found.success else FAILED, seconds, found.nfev, found.njev)


def by_cvode(p: Problem, method: str, tolerance: float) -> Solution:
    """By SUNDIALS; three output times, for with two it gives every step."""
    def rates(t: float, x: np.ndarray, out: np.ndarray) -> None:
        out[:] = p.rates(t, x)

    def jacobian(t: float, x: np.ndarray, _: np.ndarray, out: np.ndarray) -> None:
        out[:] = p.jacobian(t, x)

    solver = sksundae.cvode.CVODE(rates, jacfn=jacobian, method=method, rtol=tolerance, atol=tolerance*SIZE,
                                  max_num_steps=10**7)
    begin = time.process_time()
    found = solver.solve(np.array([0, p.t_end/2, p.t_end]), p.start)
    seconds = time.process_time() - begin
    return Solution(found.y[-1, :3] if found.success else FAILED, seconds, found.nfev, found.njev)


# Reference --------------------------------------------------------------------------------

@dataclass
class Reference:
    pose: np.ndarray
    error: float                # of Y, estimated [m]
    source: str
    apart: float                # the other candidate's Y from it [m]


def reference(p: Problem, short: bool = False) -> Reference:
    """DOP853 or our order 4 with a small step: the one that changes less from the setting before.

    The two have nothing in common but the force law, so their distance bounds the errors of both.
    """
    tolerances, steps = (SHORT_STRICT, SHORT_FINE) if short else (STRICT, FINE)
    candidates = []
    for source, solutions in (
            (f"DOP853, {tolerances[1]:g}", [by_scipy(p, "DOP853", x, MAX_STEP) for x in tolerances]),
            (f"newmark 4, {steps[1]:g} s", [by_ldbench(p, "newmark", 4, 0.25, x) for x in steps])):
        coarse, fine = (s.pose for s in solutions)
        candidates.append((abs(coarse[0] - fine[0]), source, fine))
    (error, source, pose), (_, _, other) = sorted(candidates, key=lambda c: c[0])
    return Reference(pose, float(error), source, float(abs(pose[0] - other[0])))
