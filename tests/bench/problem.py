"""A case as an initial value problem for any integrator, on the compiled force law; its reference solution."""
from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import ldbench
from ldbench import Case, ContactTable
from ldbench._core import flat
from running import FORTRAN_TESTS

SIZE = np.array([1e-2, 1e-2, 1e-2, 1.0, 1.0, 1.0])  # of the motion [m, rad] and per second: scales absolute tolerances
MAX_STEP = 1e-4                 # of DOP853 as reference: a longer one may pass through a contact without seeing it [s]
STRICT = 1e-12, 1e-13           # its tolerances
PEER_STRICT = 1e-13, 3e-14      # those of CVODE as reference
FINE = (1e-5, 1e-10), (5e-6, 1e-11)     # our steps [s] and tolerances [J] as reference
ROWS = 100                      # of our output from Python
FAR_OFF = 1e15                  # rates of a trial pose outside the table: shortens the step (LSODA would keep a NaN)
PEERS = FORTRAN_TESTS/"peers"   # tests/bench/peers.f90, built where SUNDIALS is


@dataclass
class Problem:
    """x = (y, z, roll) and their rates; z from equilibrium."""

    case: Case
    table: ContactTable
    t_end: float
    start: np.ndarray
    rates: Callable[[float, np.ndarray], np.ndarray]
    jacobian: Callable[[float, np.ndarray], np.ndarray]
    program: subprocess.Popen | None            # that solves it in compiled form, if it is there


@contextmanager
def problem(case: Case, table: ContactTable) -> Iterator[Problem]:
    """The case up to the last row of the shipped run before it ends: by then no step size has ended it."""
    table = table.for_case(case)
    t_end = float(ldbench.run(case, table=table).data["time"].iloc[-2])
    # The cheapest way from Python: the core's procedure on arrays that are there, no checks in between.
    values, handle = flat.contact_values, table._handle
    y, z, roll = np.empty(1), np.empty(1), np.empty(1)
    height, mass, inertia = table.equilibrium, case.mass, case.roll_inertia
    lateral, ramp, weight = case.lateral_force, case.lateral_ramp, table.weight

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        y[0], z[0], roll[0], vy, vz, roll_rate = x.tolist()
        z[0] += height
        force, status = values(handle, 0, 3, y, z, roll)
        if status[0]:
            return np.full(6, FAR_OFF)
        fy, fz, moment = force.ravel().tolist()
        return np.array([vy, vz, roll_rate, (fy + lateral + ramp*t)/mass, (fz - weight)/mass, moment/inertia])

    def jacobian(t: float, x: np.ndarray) -> np.ndarray:
        y[0], z[0], roll[0] = x[0], height + x[1], x[2]
        yy, yz, yr, zz, zr, rr = values(handle, 0, 6, y, z, roll)[0].ravel().tolist()
        full = np.zeros((6, 6))
        full[0, 3] = full[1, 4] = full[2, 5] = 1
        full[3:, :3] = ((-yy/mass, -yz/mass, -yr/mass), (-yz/mass, -zz/mass, -zr/mass), (-yr/inertia, -zr/inertia, -rr/inertia))
        return full

    start = np.array([case.Y, case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate])
    p = Problem(case, table, t_end, start, rates, jacobian, None)
    if not PEERS.exists():
        yield p
        return
    with tempfile.TemporaryDirectory() as folder:
        absolute(case).to_namelist(Path(folder)/"case.nml")
        with subprocess.Popen([PEERS, Path(folder)/"case.nml"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              text=True, bufsize=1) as program:
            yield replace(p, program=program)
            program.stdin.close()


def absolute(case: Case) -> Case:
    """The case with paths that hold in any folder."""
    return case.replace(**{name: str(Path(case.find(getattr(case, name))).resolve())
                           for name in ("wheel_profile", "rail_profile", "table_file")})


@dataclass
class Solution:
    """The pose at the end and what it cost."""

    pose: np.ndarray            # Y, Z [m], roll [rad]; NaN if it failed
    seconds: float              # of the processor
    evaluations: int            # of the force law
    jacobians: int              # of its tangent


FAILED = np.full(3, np.nan)


def compiled(p: Problem, least: float, **job: str | float) -> Solution:
    """By the program, repeated until it took `least` [s]."""
    job |= {"t_end": p.t_end, "seconds": least}
    words = (f"{name}={value!r}" for name, value in job.items())
    p.program.stdin.write(f"&job {' '.join(words)} /\n")
    words = p.program.stdout.readline().split()
    if not words:
        raise RuntimeError(f"{PEERS} ended at {job}")
    return Solution(np.array(words[:3], float), float(words[3]), int(words[4]), int(words[5]))


def by_ours(p: Problem, least: float, scheme: str, order: int, beta: float, dt: float,
            energy_tolerance: float = 0.0) -> Solution:
    """By the core; without the program its time includes events, energies and the columns of some rows."""
    if p.program:
        return compiled(p, least, method=scheme, order=order, beta=beta, dt=dt, energy_tolerance=energy_tolerance)
    case = p.case.replace(scheme=scheme, order=order, beta=beta, dt=min(dt, p.t_end/ROWS), stop_at="t_end",
                          energy_tolerance=energy_tolerance, t_end=p.t_end, interval=p.t_end/ROWS)

    def once() -> Solution:
        try:
            run = ldbench.run(case, table=p.table)
        except ldbench.Error:
            return Solution(FAILED, np.nan, 0, 0)
        last = run.data[["time", "Y", "Z", "roll"]].to_numpy()[-1]
        reached = abs(last[0] - p.t_end) < 1e-9
        return Solution(last[1:] if reached else FAILED, run.seconds, run.results["evaluations"], 0)

    return lasting(once, least)


def by_peer(p: Problem, least: float, method: str, tolerance: float) -> Solution:
    """By SUNDIALS."""
    return compiled(p, least, method=method, tolerance=tolerance)


def by_scipy(p: Problem, least: float, method: str, tolerance: float, max_step: float = np.inf) -> Solution:
    options = {"jac": p.jacobian} if method == "Radau" else {}

    def once() -> Solution:
        begin = time.process_time()
        found = solve_ivp(p.rates, (0, p.t_end), p.start, method, t_eval=[p.t_end], rtol=tolerance,
                          atol=tolerance*SIZE, max_step=max_step, **options)
        seconds = time.process_time() - begin
        return Solution(found.y[:3, -1] if found.success else FAILED, seconds, found.nfev, found.njev)

    return lasting(once, least)


def lasting(once: Callable[[], Solution], least: float) -> Solution:
    """Repeated until it took `least` [s]; the mean time."""
    done = [once()]
    while sum(s.seconds for s in done) < least:
        done.append(once())
    return replace(done[0], seconds=float(np.mean([s.seconds for s in done])))


@dataclass
class Reference:
    pose: np.ndarray
    error: float                # of Y, estimated [m]
    source: str
    apart: float                # the other candidate's Y from it [m]


def reference(p: Problem) -> Reference:
    """Our cut steps or another's, small: the one that changes less from the setting before.

    The two have nothing in common but the force law, so their distance bounds the errors of both.
    """
    ours = [by_ours(p, 0, "newmark", 4, 0.0, *settings) for settings in FINE]
    if p.program:
        other, theirs = f"CVODE Adams, {PEER_STRICT[1]:g}", [by_peer(p, 0, "adams", x) for x in PEER_STRICT]
    else:
        other, theirs = f"DOP853, {STRICT[1]:g}", [by_scipy(p, 0, "DOP853", x, MAX_STEP) for x in STRICT]
    candidates = [(abs(coarse.pose[0] - fine.pose[0]), source, fine.pose) for source, (coarse, fine) in (
        (other, theirs), (f"cut 4, {FINE[1][1]:g} J", ours))]
    (error, source, pose), (_, _, other) = sorted(candidates, key=lambda c: c[0])
    return Reference(pose, float(error), source, float(abs(pose[0] - other[0])))
