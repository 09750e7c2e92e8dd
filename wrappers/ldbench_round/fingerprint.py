"""What a file tells of the code that wrote it: rigid or elastic, the law of contact, damping, step and contact table.

Everything is fitted to columns of the call. A number has an uncertainty, or the reason why the file does not tell it.
"""
from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from ldbench import Case, ContactTable
from ldbench.constants import CONTACTS
from ldbench.number_text import number_text
from ldbench.results.run_data import RunData
from ldbench.tools import counted

from .blows import (
    BY_DEPTH,
    BY_RATE,
    GIVES,
    LEAST_FORCE,
    LEAST_ROWS,
    NONE,
    TELLING_ROWS,
    Blow,
    Law,
    blows,
    fit_law,
    lacking,
    uncertainties,
)
from .findings import Estimate, combined
from .jumps import INTERPOLATED, SHORT, Jump, centred, jumps, step_of, typical_interval
from .lattice import bends, digit_noise, find_lattice
from .row_checks import axle_height
from .submissions import quiet
from .tasks import Task

ELASTIC, RIGID, UNKNOWN = "elastic", "rigid", "rigid or elastic, which the file does not tell"
USED = 4                # blows that are fitted
COUNTED = 5             # jumps from which restitution is told
UNSURE = "damping, if it grows with the approach"       # of blows that lose energy and tell no law of it
GIVES_NOT = 0.01        # approach over that of steel, below which a contact is rigid
HALVED = 0.5            # by this much damping has to reduce the misfit
POOR = 0.03             # misfit of a law that is none, over the largest force
ROWS = 0.01             # relative uncertainty of a damping by the integrals over rows, twice that of exponent and force
# Share of the lowering by the tread's load that is uncertain: the load is no point, and the way along the profile is longer than
# the straight one.
SPREAD = 0.1
LOOP = 2e-3             # uncertainty of a loss by the ends of a blow, which lie between rows
ROUGH = 0.25            # uncertainty of a loss that tells nothing
SEEN = 0.01             # least share of the energy that a blow loses if there is damping
# Relative uncertainty of our force along the motion of a code as stiff as ours, and once more for each factor of 2 in stiffness:
# such a code touches at other points. Our Hertzian contact with 0.5, 0.8 and 1.2 times the stiffness is missed by 4, 1 and 1 %.
MOTION = 0.02
UNLIKE = "the force is not proportional to our Hertzian one along this motion"
REACH = 2e-3            # over which our wheelset is moved along the normal, to either side [m]
SHIFTS = 161            # that are tried over that reach
NEIGHBOUR = 2*REACH/(SHIFTS - 1)
NEARBY = 1e-7           # shift for the rate of our force [m]


@dataclass(frozen=True)
class Fingerprint:
    """What a file tells of its code."""

    run: str                    # name of the file
    kind: str                   # 'elastic', 'rigid', or neither
    because: str                # what that rests upon
    step: Estimate              # [s]
    pitch: Estimate             # of a contact table over Y [m]
    exponent: Estimate          # n of N = k δⁿ
    force: Estimate             # elastic force at the approach [N]
    hertz: Estimate             # that force over our Hertzian one
    restitution: Estimate       # of flange impacts
    loss: Estimate              # share of the energy of an impact that it takes
    damping: Estimate           # [s/m] or [N s/m]
    approach: float = np.nan    # that the blows reach on the average [m]
    damping_kind: str = ""

    @property
    def sentence(self) -> str:
        """The fingerprint in one sentence."""
        parts = [f"Looks {self.kind}" if self.kind != UNKNOWN else f"May be {self.kind}"]
        if self.hertz.known:
            parts.append(f"{plus_minus(self.hertz)} times Hertz with the radii of the shipped profiles")
        if self.exponent.known:
            parts.append(f"exponent {plus_minus(self.exponent)}")
        if self.restitution.known and self.kind == RIGID:
            parts.append(f"restitution {plus_minus(self.restitution)}")
        elif self.loss.known:
            gains = self.loss.value < 0 and not self.loss.none
            parts.append(f"{'gains' if gains else 'loses'} {plus_minus(self.loss, -100 if gains else 100)} % per impact")
        parts.append(f"step {plus_minus(self.step, 1e3)} ms" if self.step.known else "step not visible")
        parts.append(f"contact table with a pitch of {plus_minus(self.pitch, 1e3)} mm" if self.pitch.known else
                     "no contact table over Y visible")
        return ", ".join(parts) + "."


def plus_minus(x: Estimate, factor: float = 1.0) -> str:
    """A number and its uncertainty of one digit: '1.07 ± 0.04'."""
    value, u = factor*x.value, abs(factor)*x.uncertainty
    digits = int(np.clip(-np.floor(np.log10(u)), 0, 7)) if u > 0 else 3
    return f"{number_text(value, digits)} ± {number_text(u, digits)}"


@cache
def hertz_table(profiles: str) -> ContactTable:
    """Our contact by Hertz's law for a pair of profiles."""
    return ContactTable(Case.exercise(2, profiles).replace(model="hertz", table_folder=""))


@quiet()
def fingerprint(run: RunData, task: Task) -> Fingerprint:
    """Fit a fingerprint to a run whose columns are ours, in SI units."""
    case = Case.exercise(task.exercise, task.profiles)
    contacts = [c for c in ("LF", "RF") if not lacking(run, [c])]
    step = step_of(run)
    timed = centred(run, step)
    apart, together = (sorted((blow for c in contacts for blow in blows(timed, c, axle_height(case), LEAST_FORCE, softness)),
                              key=lambda blow: blow.interval.start) for softness in (0.0, half_space_softness(case)))
    found = jumps(run, case)
    kind, because = kind_of(run, [blow for blow in apart if blow.time.size >= TELLING_ROWS], found,
                            "" if contacts else f"needs {', '.join(lacking(run, ['LF']))}")
    law = partial(Fingerprint, run.name, kind, because, step, pitch_of(run, step))
    if kind == RIGID:
        first = sorted(found[:2*COUNTED], key=lambda jump: -jump.size)[:COUNTED]
        # Digits and the rows about the impact leave this much.
        e = combined([jump.restitution for jump in first], [jump.uncertainty for jump in first], floor=2e-3,
                     why=f"velocities before and after {len(first)} impacts" if first else "no impact")
        loss = replace(e, value=1 - e.value**2, uncertainty=2*max(abs(e.value), e.uncertainty)*e.uncertainty)
        return law(**without_law("rigid contacts have no stiffness") | {
            "restitution": e, "loss": loss, "damping": Estimate(why="rigid contacts lose energy by restitution")})
    if kind != ELASTIC:
        return law(**without_law(because))
    # Rows between steps tell nothing that the steps do not.
    interval = np.nanmax([typical_interval(run), step.value])
    used, pressed = ([blow for blow in some if blow.time.size >= LEAST_ROWS and blow.interval.duration/interval >= LEAST_ROWS
                      and blow.approach_share > GIVES][:USED] for some in (apart, together))
    return law(**of_blows(timed, task, used, pressed) if used else
               without_law(f"no blow of a flange has {LEAST_ROWS} rows or steps"))


def without_law(why: str) -> dict[str, Any]:
    """No numbers of a law of contact, and why."""
    return dict.fromkeys(("exponent", "force", "hertz", "restitution", "loss", "damping"), Estimate(why=why))


def half_space_softness(case: Case) -> float:
    """1/(π E*) of the steel of wheel and rail [m²/N]."""
    return 2*(1 - case.poisson**2)/(np.pi*case.youngs_modulus)


def mean_misfit(laws: Sequence[Law | None]) -> float:
    """Mean misfit of the laws that were found; infinite if none was."""
    return float(np.mean([law.misfit for law in laws if law] or [np.inf]))


def kind_of(run: RunData, resolved: Sequence[Blow], found: Sequence[Jump], missing: str) -> tuple[str, str]:
    """Whether a code is rigid or elastic, and what says so."""
    interval = typical_interval(run)
    shares = [blow.approach_share for blow in resolved]
    stiff, soft = sum(share < GIVES_NOT for share in shares), sum(share > GIVES for share in shares)
    if found and interval <= SHORT and not any(share > GIVES for share in shares[:1]):
        return RIGID, f"velocities jump {counted(len(found), 'time')} from one row to the next, {1e3*interval:.3g} ms apart"
    if soft and soft >= stiff:
        return ELASTIC, f"wheel and rail approach each other in {counted(soft, 'blow')} of a flange"
    if stiff:
        return RIGID, f"forces change in {counted(stiff, 'contact')} of a flange without an approach"
    if missing:
        return UNKNOWN, missing
    if found:
        return UNKNOWN, f"velocities jump from row to row, but rows are {1e3*interval:.3g} ms apart"
    return UNKNOWN, f"no blow of a flange has {TELLING_ROWS} rows"


def of_blows(run: RunData, task: Task, apart: Sequence[Blow], together: Sequence[Blow]) -> dict[str, Any]:
    """The law of contact from blows of the flanges.

    Some codes press tread and flange of a wheel as one body, others apart from each other. The approach with which a law fits
    better tells which, and with which no blow gives back more energy than it took.
    """
    def unlikely(found: tuple[Sequence[Blow], list[Estimate], str, list[Law | None]]) -> float:
        return mean_misfit(found[3]) + float(np.mean([max(-loss.value, 0.0) for loss in found[1] if loss.known] or [0.0]))

    used, losses, kind, laws = min((with_laws(some) for some in (apart, together) if some), key=unlikely)
    first, restitution = losses[0], Estimate(why=losses[0].why)
    if first.known:
        e = float(np.sqrt(max(1 - first.value, 0.0)))
        restitution = Estimate(e, first.uncertainty/(2*max(e, 0.1)), why="energy that comes back from the first blow")
    known = without_law(f"no law N = k δⁿ fits a blow within {100*POOR:g} % of its peak") | {
        "loss": first, "restitution": restitution}
    pairs = [(blow, law) for blow, law in zip(used, laws, strict=True) if law and law.misfit < POOR]
    if not pairs:
        return known
    approaches = [mean_approach(blow, law) for blow, law in pairs]
    middle, own = float(np.median(approaches)), [law for _, law in pairs]
    ratios = [hertz_ratio(run, blow, law, task) for blow, law in pairs]
    forces = [law.force(middle) for law in own]
    # The force at the common approach is farther from the data than that at the approach of each blow.
    u_forces = [f*np.hypot(law.u_log_k, abs(np.log(middle/d))*law.u_n) for f, law, d in zip(forces, own, approaches, strict=True)]
    what = counted(len(pairs), "blow") + " of flanges"
    damping = combined([law.damping for law in own], [law.u_damping for law in own], "N s/m" if kind == BY_RATE else "s/m", what,
                       floor=ROWS*abs(own[0].damping))
    if kind == NONE:
        unseen = [(law, hidden_damping(blow, loss)) for blow, loss in zip(used, losses, strict=True)
                  if (law := fit_law(blow, BY_DEPTH))]
        damping = combined([law.damping for law, _ in unseen], [max(law.u_damping, hidden) for law, hidden in unseen], "s/m",
                           "no law fits", hidden_damping(used[0], first))
        # Neither fit is far better; yet no number beside these words may exclude them.
        none = damping.none and (first.none or not first.known)
        kind = NONE if none else UNSURE
        if damping.known:
            damping = replace(damping, why="none seen" if none else f"{what}; a law without damping fits nearly as well")
    return known | {
        "exponent": combined([law.n for law in own], [law.u_n for law in own], why=what, floor=0.5*ROWS),
        "force": combined(forces, u_forces, "N", what, floor=0.5*ROWS*forces[0]),
        "hertz": combined([x for x, _ in ratios], [u for _, u in ratios], why=what if np.isfinite(ratios).any() else UNLIKE),
        "approach": middle, "damping": damping, "damping_kind": kind}


def hidden_damping(blow: Blow, loss: Estimate) -> float:
    """The damping χ [s/m] that the loop of a blow does not see: a weak χ loses 4/3 χ v of the energy, closing at v."""
    return float(0.75*(loss.uncertainty if loss.known else LOOP)/max(float(blow.closing.max()), 1e-3))


def with_laws(used: Sequence[Blow]) -> tuple[Sequence[Blow], list[Estimate], str, list[Law | None]]:
    """Some blows, their losses, the kind of damping that fits, and their laws with it."""
    losses = [loss_of(blow) for blow in used]
    lossy = any(loss.value - loss.uncertainty > SEEN for loss in losses)
    fits = {kind: [fit_law(blow, kind) for blow in used] for kind in (NONE, BY_DEPTH, BY_RATE)}
    misfit = {kind: mean_misfit(laws) for kind, laws in fits.items()}
    best = min((BY_DEPTH, BY_RATE), key=lambda kind: misfit[kind])
    kind = best if lossy and misfit[best] < HALVED*misfit[NONE] else NONE
    return used, losses, kind, fits[kind]


def mean_approach(blow: Blow, law: Law) -> float:
    """Mean approach of a blow [m], geometric and weighted by the force: where stiffness is known best."""
    used = blow.force > 0.1*blow.peak
    return float(np.exp(np.average(np.log(np.maximum(blow.approach[used] - law.zero, 1e-9)), weights=blow.force[used])))


def loss_of(blow: Blow) -> Estimate:
    """Share of the energy that a blow takes; what either half of the rows would give tells the uncertainty."""
    put_in, back = blow.energy
    halves = [Blow(blow.interval, *(x[half::2] for x in (blow.time, blow.force, blow.closing, blow.approach, blow.angle,
                                                         blow.lowered))).energy for half in (0, 1)]
    if min(put_in, *(energy for energy, _ in halves)) <= 0:
        return Estimate(why="no energy in the blow")
    loss = 1 - back/put_in
    rough = max(abs(1 - there/energy - loss) for energy, there in halves)
    u = float(np.hypot(np.hypot(rough, LOOP), SPREAD*np.ptp(blow.lowered)/np.ptp(blow.approach)))
    if u > ROUGH:
        return Estimate(why=f"{blow.time.size} rows are too few for the loop of the force over the approach")
    return Estimate(loss, u, why="loop of the normal force over the approach, first blow")


def hertz_ratio(run: RunData, blow: Blow, law: Law, task: Task) -> tuple[float, float]:
    """Elastic force over our Hertzian one in a blow, and its uncertainty; NaN where they are not proportional.

    Our force is that along the motion of the file, so that a contact which moves over the profiles has the same radii in both.
    Codes sink in differently at rest, and zeros of displacements differ by micrometres. So least squares find two numbers: the
    ratio, and by how much the motion is moved along the normal.
    """
    name = blow.interval.contact
    table, contact, out = hertz_table(task.profiles), CONTACTS.index(name), 1.0 if name[0] == "L" else -1.0
    rows = np.searchsorted(run.time, blow.time)
    y, z, roll = (run.values(name)[rows] for name in ("Y", "Z", "roll"))
    elastic = law.without_damping(blow)

    def ours(moved: np.ndarray) -> np.ndarray:
        moved = moved - blow.lowered
        pose = y + out*np.sin(blow.angle)*moved, z + table.equilibrium - np.cos(blow.angle)*moved, roll
        f = table.forces_by_contact(*pose, outside="nan")[..., contact, :2]
        return np.nan_to_num(np.hypot(f[..., 0], f[..., 1]))

    def left(shift: float) -> float:
        force = ours(np.array(shift))
        return float(np.sum(elastic**2) - (force @ elastic)**2/max(np.sum(force**2), 1.0))

    tried = np.linspace(-REACH, REACH, SHIFTS)
    best = float(min(tried, key=left))
    best = float(minimize_scalar(left, bounds=(best - NEIGHBOUR, best + NEIGHBOUR), method="bounded", options={"xatol": 1e-10}).x)
    force, beside = ours(np.array([[best], [best + NEARBY]]))
    if not force.any():
        return np.nan, np.nan
    ratio = float(force @ elastic/(force @ force))
    residual = elastic - ratio*force
    if ratio <= 0 or np.sqrt(np.mean(residual**2)) > POOR*elastic.max():
        return np.nan, np.nan
    fitted = float(uncertainties(np.column_stack([force, ratio*(beside - force)/NEARBY]), residual)[0])
    return ratio, float(np.hypot(fitted, MOTION*ratio*(1 + abs(np.log2(ratio)))))


def pitch_of(run: RunData, step: Estimate) -> Estimate:
    """The pitch of a contact table over Y, from steps and kinks of the contact angles."""
    if "Y" not in run.data:
        return Estimate(unit="m", why="no Y")
    if step.why == INTERPOLATED:
        return Estimate(unit="m", why="rows are interpolated between steps, whose kinks hide those of a table")
    y, groups = run.values("Y"), []
    for contact in CONTACTS:
        if f"angle_{contact}" not in run.data or f"N_{contact}" not in run.data:
            continue
        angle = run.values(f"angle_{contact}")
        closed = np.flatnonzero(run.closed(contact) & np.isfinite(angle))
        noise = digit_noise(angle)
        stretches = np.split(closed, np.flatnonzero(np.diff(closed) > 1) + 1)
        groups += [bends(y[rows], angle[rows], noise) for rows in stretches if rows.size >= LEAST_ROWS]
    return find_lattice(groups, "m", "no steps or kinks of the contact angles at equal distances of Y" if groups else
                        "no contact angles")


