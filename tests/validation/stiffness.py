"""Elastic contact of ever stiffer wheels and rails against rigid contact with restitution 1.

Exercises 1 to 3 with the elastic modulus of the steel multiplied by up to 1e4, against rigid contacts that only push, with
restitution 1. All start on the rails, with the roll rate that rigid contact links to the lateral velocity. The step is 2.5 us
or, with more than ten times the modulus, shorter as an impact is, by the power −0.4; steps that change the energy by more than
1 nJ are cut.

When the left flange lets go for the first time, the velocities (Y, Z, roll) are compared with those of the rigid wheelset
after its first impact and as long a flight, in the kinetic metric, over the velocity before; above some 100 % the contact
lasts longer than the flight, which the treads end. An elastic impact lasts a time that falls with the power −0.4 of the
modulus (Hertz), in which the wheelset turns and the treads, which carry load when the flange touches, push on: so the distance
should fall with that power as well. The check is the power over the last two decades.

Found: the first contact tends to Moreau's impact with restitution 1, which gives all of the impulse to the flange though the
treads touch as well; slowly, as the power says. With steel as it is, treads and flange share the blow. What follows does not
converge everywhere: where treads and flange hit in turn every millisecond (exercise 1), velocities some impacts later still
change their sign.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from checks import Check, Section, absolute
from ldbench import Case, ContactTable, Run, run
from sheets import Table

PAIRS = "aw", "sw"
EXERCISES = 1, 2, 3
SCALES = 1.0, 1e1, 1e2, 1e3, 1e4                # of the elastic modulus
FALL = -0.4                                     # power of the modulus by which a Hertz impact gets shorter
BAR = 0.15                                      # of that power, observed over the last two decades
AFTER = 12e-3                                   # shown of the motion after the flange has touched [s]
LATE = 6e-3                                     # when several impacts have followed on the first [s]
ROWS = 2.5e-6                                   # output interval [s]
VELOCITY = ["vY", "vZ", "roll_rate"]

@dataclass(frozen=True)
class Impact:
    """The first contact of the left flange, and what follows."""

    begin: float            # [s]
    length: float           # [s]; rigid: 0
    impulse: float          # of the flange [N s]
    after: np.ndarray       # velocities when the flange lets go
    late: np.ndarray        # and `LATE` after it touched


def case_of(exercise: int, pair: str, **changes: object) -> Case:
    return Case.exercise(exercise, pair).replace(table_folder="", stop_at="t_end", rows="interval", interval=ROWS, dt=ROWS,
                                                 **changes)


def first_impact(done: Run) -> Impact:
    c = done.data
    t, force, v = c.time.to_numpy(), c.N_LF.to_numpy(), c[VELOCITY].to_numpy()
    begin = next(e.t for e in done.events if e.kind == "left flange contact")
    if done.case.formulation == "elastic":
        k = int(np.flatnonzero(force > 0)[0])
        end = k + int(np.flatnonzero(force[k:] == 0)[0])
        impulse = float(np.sum(force[k:end])*ROWS)
    else:
        end = int(np.searchsorted(t, begin)) + 1
        impulse = next(e.impulses["LF"] for e in done.events if e.kind == "impact" and "LF" in e.impulses)
    late = np.array([np.interp(begin + LATE, t, x) for x in v.T])
    return Impact(begin, t[end] - begin, impulse, v[end], late)


@dataclass(frozen=True)
class Approach:
    """An exercise with all moduli."""

    name: str
    rigid: Impact
    elastic: dict[float, Impact]
    inertia: np.ndarray
    weight: float
    speed: float            # before the impact, in the kinetic metric [J^1/2]

    def distance(self, scale: float) -> float:
        """The distance of the velocities after the first contact, over the velocity before."""
        e, r = self.elastic[scale], self.rigid
        fall = np.array([0, -self.weight/self.inertia[0]*(e.length - r.length), 0])
        return float(np.sqrt(self.inertia @ (e.after - r.after - fall)**2))/self.speed

    @property
    def power(self) -> float:
        """The power of the modulus with which the distance goes, over the last two decades."""
        b = max(self.elastic)
        return float(np.log(self.distance(b)/self.distance(b/100))/np.log(100))


def approaches() -> list[Approach]:
    """The exercises with both formulations."""
    found = []
    for pair in PAIRS:
        rigid: dict[int, Run] = {}
        ends: dict[int, float] = {}
        for exercise in EXERCISES:
            case = case_of(exercise, pair, formulation="unilateral")
            events = run(case.replace(t_end=0.25, interval=1e-4)).events
            touch = next(e.t for e in events if e.kind == "left flange contact")
            ends[exercise] = ROWS*round((touch + AFTER)/ROWS)
            rigid[exercise] = run(case.replace(t_end=ends[exercise]))
        elastic: dict[int, dict[float, Impact]] = {exercise: {} for exercise in EXERCISES}
        for scale in SCALES:
            stiff = {"stiffness_scale": scale, "depth": 2.2e-3*scale**FALL, "drop": 3e-3, "table_roll": 0.05}
            table = ContactTable(case_of(EXERCISES[-1], pair, **stiff))
            for exercise in EXERCISES:
                case = case_of(exercise, pair, **stiff, t_end=ends[exercise],
                               roll_rate=float(rigid[exercise].data.roll_rate.iloc[0]))
                case = case.replace(dt=min(ROWS, 1e-5*(scale/10)**FALL))
                elastic[exercise][scale] = first_impact(run(case, table=table))
        for exercise, done in rigid.items():
            case = done.case
            inertia = np.array([case.mass, case.mass, case.roll_inertia])
            found.append(Approach(f"ex{exercise}_{pair}", first_impact(done), elastic[exercise], inertia,
                                  case.mass*9.81 + case.vertical_load, float(np.sqrt(2*done.results["kinetic_energy"]))))
    return found


def impact_table(found: list[Approach]) -> Table:
    head = ["", *(f"modulus x {s:g}" for s in SCALES), "rigid, e = 1"]
    rows = []
    for a in found:
        of = [*(a.elastic[s] for s in SCALES), a.rigid]
        rows += [[f"{a.name}: first contact of the flange lasts [ms]", *(f"{1e3*x.length:.3f}" for x in of[:-1]), "0"],
                 [f"{a.name}: impulse of the flange in it [N s]", *(f"{x.impulse:.0f}" for x in of)],
                 [f"{a.name}: vY after it [m/s]", *(f"{x.after[0]:.4f}" for x in of)],
                 [f"{a.name}: distance from rigid contact after it [%]", *(f"{100*a.distance(s):.2f}" for s in SCALES), ""],
                 [f"{a.name}: vY {1e3*LATE:g} ms after the flange touched [m/s]", *(f"{x.late[0]:.4f}" for x in of)],
                 [f"{a.name}: vZ then [m/s]", *(f"{x.late[1]:.4f}" for x in of)]]
    return Table("The first contact of the left flange", head, rows)


def section() -> Section:
    found = approaches()
    checks: list[Check] = [absolute(f"{a.name}: power of the modulus with which velocities after the flange's first contact "
                                    "approach rigid ones [1]", a.power, FALL, "Hertz: duration of an impact", BAR)
                           for a in found]
    return Section("Elastic contact towards rigid contact", __doc__, checks, [impact_table(found)])
