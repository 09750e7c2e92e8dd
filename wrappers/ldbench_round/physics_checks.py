"""Laws that hold for any code: kinematics, momentum, energy, contact; and what the exercises prescribe."""
from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ldbench import Case
from ldbench.constants import CONTACTS
from ldbench.results.answers import answers
from ldbench.results.derived import cumulative
from ldbench.results.run_data import RunData

from .blows import LEAST_FORCE
from .drift_checks import TIME_ERROR, by_times, drift_findings
from .energies import energy_findings, side_findings, total_findings
from .findings import DOUBTFUL, FAILED, PASSED, UNKNOWN, Finding, judged
from .jumps import SHORT, jump_intervals, jumps, leaps, typical_interval
from .row_checks import OF_MOMENT, has, inertia_findings, lateral_force, lateral_work, place_findings, roll_moment, total, weight_of
from .tasks import Task

DOUBT, FAIL = 0.02, 0.1             # relative errors of a balance
START = 1e-4, 5e-4                  # of Y at the start: doubtful, wrong [m]
START_RATE = 0.01, 0.05             # of the lateral velocity there, relative: doubtful, wrong
NEGATIVE = 1e-6, 1e-3               # of the largest force that pulls: doubtful, wrong
ANGLE = 0.01, 0.1                   # from the direction of the force: doubtful, wrong [rad]
FEW_ROWS, TOO_FEW_ROWS = 10, 4      # in an impact
RAMP_ROWS = 3                       # of more than a thousand impacts in 54 s: its begin, its peak and its end
FINE, COARSE = 0.04, 0.05           # what coarse rows leave of a balance in such intervals: ours of exercise 5 leave 0.03
STEADY = 0.2                        # relative change of a rate in an interval that the trapezoidal rule integrates well
APPROACH = 0.115e-3                 # of a wheel with half the weight on its rail, by Hertz [m]
FAR = 0.5                           # of the smaller of the farthest displacements to both sides, which only a flange turns back
CLEARANCE = 0.04, 0.1               # relative: doubtful, wrong. Radii that the call leaves open move it by 5 %
GAP, GAP_AROUND = 10, 10            # an interval is long beside the median of so many on either side
GAP_CHANGE = 0.05, 0.2              # change of a velocity in a long interval, of its largest value: doubtful, wrong
STORED = 0.1                        # share of the energy that the treads may store at a moment that counts
SCALED = 0.02, 0.3                  # a constant factor from which a rate is wrong; what it may leave of the error
NEAR_CENTRE = 1e-3                  # from the centre, where no flange is [m]
CLEARLY = 0.3                       # share of the error of one sign of an angle that the other sign leaves, where it is clear
IN_IMPACT = "rows in an impact of a flange"
IMPULSES = "velocities jump, as those of rigid contacts do: their impacts are impulses"

#: Columns, their rates, and what is said of both.
INTEGRALS = (*((x, v, f"{words} velocity is the rate of the displacement") for x, v, words in (
                 ("Y", "vY", "lateral"), ("Z", "vZ", "vertical"), ("roll", "roll_rate", "roll"))),
             *((v, a, f"{words} acceleration is the rate of the velocity") for v, a, words in (
                 ("vY", "aY", "lateral"), ("vZ", "aZ", "vertical"), ("roll_rate", "roll_acc", "roll"))))


def law_findings(run: RunData, case: Case, task: Task) -> Iterator[Finding]:
    """All findings about the numbers of a file whose columns are ours, in SI units."""
    leaping, rigid, near = jumps(run, case), leaps(run, case), typical_interval(run) <= SHORT
    jumping = jump_intervals(run, case) if rigid else None
    yield from start_findings(run, case)
    yield from order_findings(run, task, case, bool(leaping))
    yield from clearance_findings(run, task)
    yield from gap_findings(run)
    if leaping and near and not rigid and not run.data.attrs.get(TIME_ERROR):
        yield Finding("velocities do not jump", FAILED, len(leaping), 0, leaping[0].row + 1,
                      "contacts give, and velocities change without a force: rows are missing, or two runs are joined")
    yield from contact_findings(run, case)
    yield from place_findings(run, case)
    yield from inertia_findings(run, case, near and not rigid)
    closed = []
    for x, v, what in INTEGRALS:
        if has(run, x, v):
            found = balance(what, run.time, run.values(x), run.values(v), "another frame, unit or sign", jumping,
                            by_times(run, run.values(v)))
            closed += [x] if found.verdict == PASSED else []
            yield found
        else:
            yield Finding(what, UNKNOWN, hint=f"no {x if not has(run, x) else v}")
    yield from drift_findings(run, case, closed, rigid, near and not rigid)
    yield from momentum_findings(run, case, jumping)
    yield roll_finding(run, case, jumping)
    yield energy_finding(run, case, rigid)
    yield from energy_findings(run, case)
    if not rigid:
        yield from total_findings(run, case)
        yield from side_findings(run)
    yield Finding(IN_IMPACT, UNKNOWN, hint=f"{IMPULSES}, which take no time") if rigid else \
        row_finding(run, *((FEW_ROWS, TOO_FEW_ROWS) if task.exercise < 5 else (RAMP_ROWS, RAMP_ROWS)))


def start_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """The initial conditions of the exercise."""
    wanted = {"Y": (case.Y, *START), "Z": (case.Z, 2e-4, 2e-3), "roll": (case.initial_roll, 1e-4, 1e-3),
              "vY": (case.vY, START_RATE[0]*abs(case.vY) + 1e-4, START_RATE[1]*abs(case.vY) + 1e-3), "vZ": (case.vZ, 1e-3, 1e-2),
              # The call leaves it to codes with constraints to link the roll velocity to the lateral one.
              "roll_rate": (case.roll_rate, 0.05*abs(case.roll_rate) + 1e-5, 0.3*abs(case.roll_rate) + 1e-3)}
    for column, (value, doubtful, failed) in wanted.items():
        if has(run, column):
            # Results may begin at the first step.
            first = float(run.values(column)[0])
            yield judged(f"initial {column}", abs(first - value), doubtful, failed, 1, f"expected {value:g}, found {first:.6g}")


def order_findings(run: RunData, task: Task, case: Case, leaping: bool) -> Iterator[Finding]:
    """Left flange first, then the right flange and the centre; or the derailment.

    Where velocities jump, an impact may have no row with a force. Then the displacement stands for a contact that has none.
    """
    known = answers(run, case)
    left, right = known["t_first_LF"], known["t_first_RF"]
    unseen = leaping and None in (left, right) and has(run, "Y")
    y, t = run.values("Y") if has(run, "Y") else np.empty(0), run.time
    if unseen:
        early = bool(y[np.argmax(np.abs(y) > max(FAR*min(y.max(), -y.min()), NEAR_CENTRE))] > 0)
        why = "the wheelset goes to the right"
    else:
        early = left is not None and (right is None or left < right)
        why = "the left flange has no contact before the right one; are the wheels exchanged?"
    if unseen or has(run, "N_LF", "N_RF"):
        yield Finding("left flange first", PASSED if early else FAILED, hint="" if early else why)
    else:
        yield Finding("left flange first", UNKNOWN, hint="no normal forces of the flanges")
    if not y.size:
        return
    if task.exercise == 5:
        derailment = known["t_derailment"]
        yield Finding("up to derailment", FAILED if derailment is None else PASSED, np.nan if derailment is None else derailment,
                      hint="" if derailment is not None else "no flange's tip passes the highest point of its rail")
        return
    # Without forces the farthest point on the right stands for the contact.
    turn = right if has(run, "N_RF") and not unseen else float(t[y.argmin()]) if y.min() < -0.5*y.max() else None
    after = y[t > turn] if turn is not None else np.empty(0)
    # The run may end between the last row and the next, which is not written.
    back = bool(after.size and (np.nanmax(after) >= 0 or (after.size > 1 and 2*after[-1] - after[-2] >= 0)))
    derailed = not back and known["t_derailment"] is not None
    # Whether a wheelset of exercise 4 climbs off the rail is a matter of the contact law.
    yield Finding("return to the centre after both flanges", PASSED if back else DOUBTFUL if derailed else FAILED,
                  hint="" if back else "the wheelset derails" if derailed else "the file ends before")


def clearance_findings(run: RunData, task: Task) -> Iterator[Finding]:
    """The left flange closes where the published clearance is used up."""
    first = answers(run)["t_first_LF"] if has(run, "N_LF", "Y") else None
    if first is None:
        return
    y = float(np.interp(first, run.time, run.values("Y")))
    expected = task.clearance
    yield judged("first left flange contact at the published clearance", abs(y/expected - 1), *CLEARANCE,
                 hint=f"expected Y = {1e3*expected:.2f} mm, found {1e3*y:.2f} mm: other profiles, gauge or back-to-back distance")


def gap_findings(run: RunData) -> Iterator[Finding]:
    """No rows are missing in an impact: velocities hardly change in an interval that is far longer than those around it, and longer
    than nearly all of the file: rows at events may stand close together beside it."""
    columns = [column for column in ("vY", "vZ", "roll_rate") if has(run, column)]
    step = np.diff(run.time)
    if not columns or step.size < 2*GAP_AROUND:
        return
    around = np.array([np.median(part) for part in np.lib.stride_tricks.sliding_window_view(
        np.pad(step, GAP_AROUND, mode="reflect"), 2*GAP_AROUND + 1)])
    long = step > np.maximum(GAP*around, 1.5*np.quantile(step, 0.9))
    if not long.any():
        yield Finding("no rows are missing", PASSED)
        return
    change = np.max([np.abs(np.diff(run.values(column)))/max(np.nanmax(np.abs(run.values(column))), 1e-300) for column in columns],
                    axis=0)
    worst = int(np.where(long, change, -1.0).argmax())
    yield judged("no rows are missing", float(change[worst]), *GAP_CHANGE, worst + 1,
                 f"{1e3*step[worst]:.3g} ms without a row; velocities change by {100*change[worst]:.0f} % of their largest")


def contact_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """Contacts push, along the normal; the contact angles of one wheel have one sign, that of its forces or the opposite one."""
    signs: dict[str, bool] = {}
    for contact in CONTACTS:
        if not has(run, f"N_{contact}"):
            continue
        n = np.nan_to_num(run.values(f"N_{contact}"))
        largest, row = float(n.max(initial=0.0)), int(n.argmin())
        if largest <= 0 <= n[row]:
            continue
        # A contact that only pulls is measured by the weight on a wheel.
        yield judged(f"N_{contact} is not negative", max(0.0, -float(n[row]))/(largest or weight_of(case)/2), *NEGATIVE, row + 1,
                     "a contact without adhesion does not pull")
        if not has(run, f"Fy_{contact}", f"Fz_{contact}") or not largest:
            continue
        fy, fz = (np.nan_to_num(run.values(f"{name}_{contact}")) for name in ("Fy", "Fz"))
        error = np.abs(np.hypot(fy, fz) - np.abs(n))/largest
        yield judged(f"N_{contact} is the resultant of Fy and Fz", error.max(), DOUBT, FAIL, int(error.argmax()) + 1,
                     "forces in the frame of the wheelset, or of another contact")
        if not has(run, f"angle_{contact}"):
            continue
        angle, closed = run.values(f"angle_{contact}"), n > 0.01*largest
        loaded = closed & np.isfinite(angle)
        if 2*loaded.sum() < closed.sum():
            yield Finding(f"angle_{contact} is there while the contact is closed", FAILED, hint="is it that of another contact?")
        if not loaded.any():
            continue
        of_force = np.arctan2(fy if contact[0] == "R" else -fy, fz)
        # Rows that are interpolated where a contact jumps from the tread to the flange's root mix the angles of two steps.
        around = np.lib.stride_tricks.sliding_window_view(np.pad(of_force, 1, mode="edge"), 3)
        low, high = around.min(axis=1), around.max(axis=1)
        same, turned = (float(np.median(np.abs(of_force - sign*angle)[loaded])) for sign in (1, -1))
        if min(same, turned) < CLEARLY*max(same, turned):
            signs[contact] = same < turned
        # Either sign is in use.
        error = min((np.where(loaded, np.maximum(np.maximum(low - x, x - high), 0.0), 0.0) for x in (angle, -angle)), key=np.max)
        yield judged(f"angle_{contact} is that of the force", error.max(), *ANGLE, int(error.argmax()) + 1,
                     "without friction the force is normal to the profiles; [rad]")
    for side, words in ("L", "left"), ("R", "right"):
        if {f"{side}T", f"{side}F"} <= signs.keys():
            alike = signs[f"{side}T"] == signs[f"{side}F"]
            yield Finding(f"contact angles of the {words} wheel have one sign", PASSED if alike else FAILED,
                          hint="" if alike else "the angle of the tread and that of the flange have opposite signs")


def balance(what: str, t: np.ndarray, x: np.ndarray, rate: np.ndarray, hint: str, jumping: np.ndarray | None,
            vague: np.ndarray | float = 0.0) -> Finding:
    """Whether x is the integral of `rate`, by the trapezoidal rule.

    jumping: the intervals, (rows - 1,), in which velocities of rigid bodies jump; None for other codes.
    vague: what the integral may miss by what the columns mean, (rows,).
    The rule fails where rows are too far apart for an impact. Then the intervals decide in which the rate hardly changes.
    """
    if not (np.isfinite(x).all() and np.isfinite(rate).all()):
        return Finding(what, UNKNOWN, hint="empty cells")
    change, integral = x - x[0], cumulative(t, rate)
    size = max(np.ptp(change), np.ptp(integral), 1e-300)
    error = np.maximum(np.abs(change - integral) - vague, 0.0)/size
    whole = judged(what, error.max(), DOUBT, FAIL, int(error.argmax()) + 1, hint)
    if whole.verdict == PASSED:
        return whole
    steps, means = np.diff(x), np.diff(t)*(rate[1:] + rate[:-1])/2
    factor = float(np.median(steps[means != 0]/means[means != 0])) if np.any(means != 0) else 1.0
    if abs(factor - 1) > SCALED[0] and np.max(np.abs(change - factor*integral)) < SCALED[1]*np.max(np.abs(change - integral)):
        return Finding(what, FAILED, float(error.max()), DOUBT, whole.row,
                       f"{factor:.3g} times the integral: {hint}, or another time")
    # The trapezoidal rule misses h/12 times the second difference of the rate.
    bend = np.pad(np.abs(np.diff(rate, 2)), 1, mode="edge")
    missing = np.diff(t)*np.maximum(bend[1:], bend[:-1])/12
    left = np.maximum(np.abs(steps - means) - np.diff(vague*np.ones(t.size)) - missing, 0.0)
    steady = np.abs(np.diff(rate)) <= STEADY*np.maximum(np.abs(rate[1:]), np.abs(rate[:-1]))
    amount = np.sum(np.abs(steps[steady]) + np.abs(means[steady]))/2
    if steady.sum() < TOO_FEW_ROWS or amount <= 0:
        return whole
    # Two columns that have nothing to do with each other give 1 to 2.
    missed = float(np.sum(left[steady])/amount)
    if missed <= COARSE:
        # How dense the rows are is a finding of its own.
        fine = missed <= FINE and jumping is None
        return Finding(what, PASSED if fine else DOUBTFUL, missed, FINE, None if fine else whole.row,
                       "between impacts, for which the rows are too far apart")
    if jumping is not None and TOO_FEW_ROWS < np.sum(~jumping) < jumping.size:
        amount = np.sum(np.abs(steps[~jumping]) + np.abs(means[~jumping]))/2
        if np.sum(left[~jumping]) <= COARSE*max(amount, 1e-300):
            return Finding(what, DOUBTFUL, float(error.max()), DOUBT, int(jumping.argmax()) + 1,
                           f"{IMPULSES}, which no column has; between these it closes")
    return judged(what, missed, DOUBT, FAIL, whole.row, hint)


def momentum_findings(run: RunData, case: Case, jumping: np.ndarray | None) -> Iterator[Finding]:
    """Whether the forces of the contacts explain the velocities."""
    for v, name, words, load in (("vY", "Fy", "lateral", lateral_force(run, case)), ("vZ", "Fz", "vertical", -weight_of(case))):
        if has(run, v, *(f"{name}_{contact}" for contact in CONTACTS)):
            force = total(run, name) + load
            yield balance(f"{words} momentum closes", run.time, case.mass*run.values(v), force,
                          "forces of another frame, unit or sign, or a missing load", jumping, by_times(run, force))
        else:
            yield Finding(f"{words} momentum closes", UNKNOWN, hint=f"needs {v} and {name} of all contacts")


def roll_finding(run: RunData, case: Case, jumping: np.ndarray | None) -> Finding:
    """Whether the moments of the contact forces about the axle's centre explain the roll velocity.

    A contact point is that of the wheel, of the rail or between both, and so it lies within the elastic approach of the force's
    line. What that makes in a moment grows with time, and in exercise 5 it grows beyond all motion.
    """
    what, forces = "roll momentum closes", [(f"Fy_{contact}", f"Fz_{contact}") for contact in CONTACTS]
    if not has(run, "roll_rate", *OF_MOMENT):
        return Finding(what, UNKNOWN, hint="needs Y, Z, the roll velocity, and forces and positions of all contacts")
    pressed = sum(np.hypot(*(np.nan_to_num(run.values(name)) for name in pair)) for pair in forces)
    moment = roll_moment(run, case)
    return balance(what, run.time, case.roll_inertia*run.values("roll_rate"), moment,
                   "forces act elsewhere than it is said, or in another frame", jumping,
                   APPROACH*cumulative(run.time, pressed) + by_times(run, moment))


def energy_balance(run: RunData, case: Case, rigid: bool = False) -> np.ndarray | None:
    """Energy without the work of the lateral force, (rows,) [J]: kinetic, of weight and load, and elastic of the treads by
    Hertz's law; rigid contacts store nothing. It dips while a flange stores energy. None without the columns that it needs."""
    if not has(run, "vY", "vZ", "roll_rate", "Z", *(f"N_{contact}" for contact in CONTACTS)):
        return None
    kinetic = (case.mass*(run.values("vY")**2 + run.values("vZ")**2) + case.roll_inertia*run.values("roll_rate")**2)/2
    return np.asarray(kinetic + weight_of(case)*run.values("Z") + stored_by_treads(run, case, rigid) - lateral_work(run, case))


def stored_by_treads(run: RunData, case: Case, rigid: bool) -> np.ndarray:
    """Elastic energy of the treads by Hertz's law, (rows,) [J]; none of rigid contacts."""
    load = weight_of(case)/2
    return np.asarray(sum(0.4*APPROACH*load*(np.clip(np.nan_to_num(run.values(f"N_{contact}")), 0, None)/load)**(5/3)
                          for contact in ("LT", "RT")))*(not rigid)


def energy_finding(run: RunData, case: Case, rigid: bool) -> Finding:
    """Whether energy is conserved between moments at which no flange touches and the treads store little.

    Hertz's law tells roughly what the treads store: half of it may be wrong. The work of the lateral force is counted.
    """
    what = "energy closes"
    without_work = energy_balance(run, case, rigid)
    if without_work is None:
        return Finding(what, UNKNOWN, hint="needs velocities, Z and N of all contacts")
    work, stored = lateral_work(run, case), stored_by_treads(run, case, rigid)
    energy = without_work + work
    size = max(float(energy[0]) - float(np.nanmin(energy)), float(energy[0]), float(np.nanmax(work)))
    calm = np.isfinite(energy) & ~run.closed("LF") & ~run.closed("RF") & (stored < STORED*size)
    if calm.sum() < 2:
        return Finding(what, UNKNOWN, hint="no two moments at which the contacts store little energy")
    vague = np.abs(stored - stored[0])/2
    error = np.where(calm, np.maximum(np.abs(without_work - energy[0]) - vague, 0.0), 0.0)/size
    row = int(error.argmax())
    if without_work[row] > energy[0]:
        return judged(what, error.max(), DOUBT, FAIL, row + 1,
                      "the wheelset gains energy: a step too long, or forces without a potential")
    return judged(what, error.max(), DOUBT, np.inf if rigid else FAIL, row + 1,
                  "the wheelset loses energy in impacts: restitution below 1" if rigid else
                  "the wheelset loses energy: damping, restitution or a damped integrator")


def row_finding(run: RunData, few: int, too_few: int) -> Finding:
    """Whether rows are dense enough for the impacts of the flanges: the median of all impacts. few, too_few: rows of an impact
    below which the file is doubtful, and wrong."""
    rows = sorted((one.rows.stop - one.rows.start, one.rows.start + 1) for contact in ("LF", "RF") if has(run, f"N_{contact}")
                  for one in run.intervals(contact, rigid=False) or [] if one.peak > LEAST_FORCE)
    if not rows:
        return Finding(IN_IMPACT, UNKNOWN, hint="no impact")
    typical, at = rows[len(rows)//2]
    verdict = FAILED if typical < too_few else DOUBTFUL if typical < few else PASSED
    return Finding(IN_IMPACT, verdict, typical, few, at if verdict != PASSED else None,
                   "" if verdict == PASSED else "a shorter interval of output shows the peaks")
