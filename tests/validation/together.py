"""The first contact of the flange: runs with the table against a motion whose forces are solved directly in every pose, and
what the model of influence changes."""
from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import ldbench
from checks import Check, absolute, relative
from ldbench._core import flat
from ldbench.geometry.outlines import case_outlines
from ldbench.pressure import MOST_PATCHES, press
from ldbench.table import rigid_geometry
from probes import MIRROR
from sheets import Table
from unknown import variants

SHIPPED = "aw", "sw"
EXERCISES = 1, 2, 3, 4
# Wheels that lie against the gauge corner in exercise 3, among those of the section on unknown profiles.
CONFORMING = "APTA 240", "throat radii x 1.25"
INFLUENCES = "local", "flat", "apart"
# Elements of a patch along x > 0 and along s. 12 x 48 elements change the first peaks of ex1_aw and ex4_sw by at most 0.08 %.
ELEMENTS = 8, 32
STEP = 1e-5                 # of the runs with the table, and between their rows [s]
AFTER = 5e-4                # the direct motion has short steps so long before and after the contact with the table [s]
STEP_FREE, STEP_IN_FLANGE = 2e-4, 2e-5      # longest steps before the contact, and in it, so that rows show its peak [s]
# A step may err by 0.1 nm in y and z, and by as much at a rail for roll. A run takes some hundred steps, so positions are known to
# 10 nm. Velocities belong to vibrations of some 1000 rad/s.
TOLERANCE = np.outer([1.0, 1e3], [1e-10, 1e-10, 1e-10/0.75]).ravel()
DEEPEST = 1e-3              # by which the wheels sink in at rest, at most [m]
SOURCE = "half-spaces pressed together at every step, no table"
# The tables with actual profiles state a largest error of 1.0 % for a force in service, which exceeds the error of the grids.
BAR = 1e-2
# Share of the contact's duration T by which the time of the peak may differ. Near its peak a force is about
# N cos(pi t/T), which lies BAR below N at t = T sqrt(2 BAR)/pi.
PEAK_BAR = np.sqrt(2*BAR)/np.pi


@dataclass(frozen=True)
class Contact:
    """The first contact of the left flange."""

    t: np.ndarray           # of its rows, and of one row before and one after [s]
    force: np.ndarray       # [N]

    @property
    def peak(self) -> float:
        return float(self.force.max())

    @property
    def peak_time(self) -> float:
        return float(self.t[self.force.argmax()])

    @property
    def impulse(self) -> float:
        return float(np.trapezoid(self.force, self.t))


def first_contact(t: np.ndarray, force: np.ndarray, name: str) -> Contact:
    closed = force > 0
    begin = int(closed.argmax())
    end = begin + int(closed[begin:].argmin())
    if not closed[begin] or closed[end]:
        raise RuntimeError(f"{name}: expected a contact of the left flange that opens before t = {t[-1]:.4g} s")
    return Contact(t[max(begin - 1, 0):end + 1], force[max(begin - 1, 0):end + 1])


def kept_table(pair: str, influence: str) -> str:
    return f"outputs/{pair}_halfspace.table" if influence == "local" else f"outputs/{pair}_halfspace_{influence}.table"


def tabulated(case: ldbench.Case, name: str) -> tuple[ldbench.Run, Contact]:
    """A run of a case with the table, and its first flange contact."""
    run = ldbench.run(case.replace(dt=STEP, interval=STEP))
    return run, first_contact(run.data.time.to_numpy(), run.data.N_LF.to_numpy(), name)


def shipped(exercise: int, pair: str, influence: str) -> ldbench.Case:
    """The case of an exercise with a model of influence."""
    return ldbench.Case.exercise(exercise, pair).replace(influence=influence, table_file=kept_table(pair, influence))


def direct(case: ldbench.Case, begin: float, t_end: float) -> Contact:
    """The first flange contact of a case, which closes after `begin`, without a table: by steps of Dormand and Prince, in each of
    which the half-spaces of both wheels are pressed together."""
    handle, nx, ns = rigid_geometry(case), *ELEMENTS
    inertia = np.array([case.mass, case.mass, case.roll_inertia])
    weight = case.mass*9.81 + case.vertical_load

    def total(q: np.ndarray) -> np.ndarray:
        sides = [flat.pressures(handle, side, q, nx, ns, MOST_PATCHES) for side in (1, 2)]
        if not all(ok for _, ok, *_ in sides):
            raise RuntimeError(f"{case.name}, direct: a half-space solution did not converge")
        return sides[0][-1][:3] + MIRROR*sides[1][-1][:3]

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[3:], (total(x[:3]) - [0, weight, 0])/inertia])

    centred = case_outlines(case).axle
    height = brentq(lambda z: total(np.array([0.0, z, 0.0]))[1] - weight, centred - DEEPEST, centred, xtol=1e-13)
    x = np.array([case.Y, height + case.Z, case.initial_roll, case.vY, case.vZ, case.roll_rate])
    for span, longest in ((0.0, begin), STEP_FREE), ((begin, t_end), STEP_IN_FLANGE):
        found = solve_ivp(rates, span, x, "RK45", rtol=2.3e-14, atol=TOLERANCE, max_step=longest)
        x = found.y[:, -1]

    def flange_force(q: np.ndarray) -> float:
        """The wheel's force, of normals that turn within an element, without what its tread carries."""
        patches = press(handle, case, q, ["LT", "LF"], ns)
        treads = [patch.resultant for patch in patches if patch.contact == "LT"]
        whole = flat.pressures(handle, 1, q, nx, ns, MOST_PATCHES)[-1][:2]
        return float(np.hypot(*(whole - np.sum(treads or [[0, 0]], axis=0)))) if len(patches) > len(treads) else 0.0

    force = [flange_force(q) for q in found.y[:3].T]
    return first_contact(found.t, np.array(force), f"{case.name}, direct")


def compare(name: str, ours: Contact, exact: Contact) -> list[Check]:
    duration = exact.t[-1] - exact.t[0]
    return [relative(f"{name}: first peak of the left flange [N]", ours.peak, exact.peak, SOURCE, BAR),
            relative(f"{name}: impulse of the first contact of the left flange [N s]", ours.impulse, exact.impulse, SOURCE, BAR),
            absolute(f"{name}: time of the first peak of the left flange [s]", ours.peak_time, exact.peak_time, SOURCE,
                     PEAK_BAR*duration)]


def told(contact: Contact, run: ldbench.Run | None = None) -> list[str]:
    """Numbers of a first contact, and of the run behind it: largest force of the right flange and return."""
    cells = [f"{1e-3*contact.peak:.1f}", f"{contact.impulse:.1f}"]
    if run is None:
        return [*cells, "", ""]
    passages = [event.t for event in run.events if event.kind == "centre passage"]
    return [*cells, f"{1e-3*run.results['peak_N_RF']:.1f}", f"{1e3*passages[-1]:.1f}" if passages else ""]


def one_system() -> tuple[list[Check], Table]:
    """Checks of the first flange contact, and what the model of influence changes."""
    checks: list[Check] = []
    rows = []
    for pair in SHIPPED:
        for exercise in EXERCISES:
            name = f"ex{exercise}_{pair}"
            run, ours = tabulated(shipped(exercise, pair, INFLUENCES[0]), name)
            exact = direct(run.case, float(ours.t[0]) - AFTER, float(ours.t[-1]) + AFTER)
            checks += compare(name, ours, exact)
            rows += [[name, "local, no table", *told(exact)], [name, INFLUENCES[0], *told(ours, run)]]
            for influence in INFLUENCES[1:]:
                other, contact = tabulated(shipped(exercise, pair, influence), f"{name}, {influence}")
                rows.append([name, influence, *told(contact, other)])
    with tempfile.TemporaryDirectory() as folder:
        for wheel, changes in variants(Path(folder), CONFORMING).items():
            name = f"ex3_aw with {wheel}"
            run, ours = tabulated(ldbench.Case.exercise(3, "aw").replace(changes), name)
            checks += compare(name, ours, direct(run.case, float(ours.t[0]) - AFTER, float(ours.t[-1]) + AFTER))
    return checks, Table("What the model of influence changes", [
        "case", "influence", "first peak LF [kN]", "its impulse [N s]", "largest RF [kN]", "last passage of the centre [ms]"], rows)
