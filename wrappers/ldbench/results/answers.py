"""The answers of a run, by the same names whoever computed it.

A file that ldbench wrote has the answers of the core, which knows what happens between the rows. In the file of another code the
rows tell them by the definitions of the core. `quantities.OUTCOME` has their words and units.
"""
from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import dropwhile
from typing import Any

import numpy as np

from ..case import Case
from ..constants import CONTACT_NAMES, CONTACTS, SIDES
from ..table import placed_outlines
from .contact_intervals import ContactInterval
from .derived import KINETIC_PARTS, cumulative
from .events import Event, count_name, event_kinds
from .header import ABSENT, ALWAYS, SETUP
from .run_data import RunData

FLANGES = {"LF": 1, "RF": -1}       # the sign of Y on the side of each
EXTREMES = {"farthest_left": ("Y", 1), "farthest_right": ("Y", -1), "farthest_up": ("Z", 1), "farthest_down": ("Z", -1),
            "largest_roll": ("roll", 1), "smallest_roll": ("roll", -1)}
# Not each of these happens in every run, and rows do not tell them all.
NAMES = (*SETUP, *ABSENT, *ALWAYS, "end", "cuts", "missed", "evaluations", "t_drift", "derailed",
         *(f"{kind}{name}" for name in EXTREMES for kind in ("", "t_")),
         *(f"{kind}_{contact}" for contact in CONTACTS for kind in ("peak_N", "t_peak")), *map(count_name, event_kinds()))

CROSSED = 1e-4          # share of the largest |Y| beyond which the wheelset is on one side
SWING = 0.5             # share of the way to the left that the wheelset goes to the right at least, where it reaches that flange
SUDDEN = 0.2            # least relative change of the lateral velocity from row to row that is an impact without duration
CLOSE_ROWS = 0.5e-3     # rows that are farther apart do not tell such an impact from one with a duration [s]
LEAST_SPEED = 0.02      # towards a flange, from which there are such impacts [m/s]
EXPLAINED = 5           # times the impulse of its force that the momentum of the wheelset changes by in such an impact, at least


def answers(run: RunData, case: Case | None = None) -> dict[str, Any]:
    """All answers of a run by their names, SI; None for what did not happen and for what the file does not tell.

    case: whose profiles and lateral force another code's file has; without it the file tells no derailment. Error where the times
    of the rows do not ascend, or where the profiles of the case cannot be placed.
    """
    found = told(run.results) | {"end": run.ending} if run.ending else of_rows(run, case)
    return dict.fromkeys(NAMES) | {name: value for name, value in found.items() if value == value and value != ""}


def all_events(run: RunData, case: Case | None = None) -> list[Event]:
    """Events in order of time: those that a file of ours lists, or all that the rows of another code's file tell. case: as of
    `answers`."""
    return run.events if run.ending else row_events(run, case, closed_intervals(run))


def first_flange(found: Mapping[str, Any]) -> float | None:
    """Time [s] at which a flange first touches, by the answers of a run; None where none does."""
    return min((t for contact in FLANGES if (t := found[f"t_first_{contact}"]) is not None), default=None)


def told(results: Mapping[str, Any]) -> dict[str, Any]:
    """The answers of the core. A contact without a peak has never closed."""
    never = {f"{time}{contact}" for contact in CONTACTS for peak, time in (("peak_N_", "t_peak_"), ("peak_P_", "t_peak_P_"))
             if not results.get(f"{peak}{contact}")}
    return {name: value for name, value in results.items() if name not in never and (value or not name.startswith("peak_"))}


def of_rows(run: RunData, case: Case | None) -> dict[str, Any]:
    """The answers that rows tell."""
    closed = closed_intervals(run)
    events = row_events(run, case, closed)
    found: dict[str, Any] = {"t": float(run.time[-1]), "rows": len(run.time)}
    for contact in CONTACTS:
        if first := first_touch(run, contact, closed[contact]):
            found |= contact_answers(run, first)
        if f"N_{contact}" in run and run.closed(contact).any():
            k = int(np.nanargmax(force := run.values(f"N_{contact}")))
            found |= {f"peak_N_{contact}": float(force[k]), f"t_peak_{contact}": float(run.time[k])} if force[k] > 0 else {}
        if f"P_{contact}" in run and (blows := np.diff(run.values(f"P_{contact}"), prepend=0.0)).any():
            found |= {f"peak_P_{contact}": float(blows.max()), f"t_peak_P_{contact}": float(run.time[blows.argmax()])}
    for name, (column, sign) in EXTREMES.items():
        if column in run and np.isfinite(x := sign*run.values(column)).any():
            k = int(np.nanargmax(x))
            found |= {name: float(sign*x[k]), f"t_{name}": float(run.time[k])}
    return found | passage_answers(run, found) | energy_answers(run) | event_answers(run, case, events)


def closed_intervals(run: RunData) -> dict[str, list[ContactInterval]]:
    """The intervals in which each contact is closed, of a flange from its first contact on that is not one of its root; what has a
    small contact angle later is a contact of the flange's tip."""
    return {contact: list(dropwhile(lambda one: one.at_root, run.intervals(contact) or [])) for contact in CONTACTS}


# Contacts --------------------------------------------------------------------------------

def first_touch(run: RunData, contact: str, closed: Sequence[ContactInterval]) -> ContactInterval | None:
    """The first interval in which a contact is closed or, where the lateral velocity turns from one row to the next without a force
    that explains it, an impact without duration, as codes with constraints have it."""
    lasting = closed[0] if closed else None
    sudden = sudden_impact(run, contact) if contact in FLANGES and f"P_{contact}" not in run else None
    return sudden if sudden and not (lasting and lasting.start + CLOSE_ROWS < sudden.start) else lasting


def sudden_impact(run: RunData, contact: str) -> ContactInterval | None:
    """The first impact of a flange that takes no time: the lateral velocity towards it drops from one row to the next."""
    if len(run.time) < 2 or not all(column in run for column in ("vY", "Y", f"N_{contact}")):
        return None
    t, v, y = run.time, FLANGES[contact]*run.values("vY"), FLANGES[contact]*run.values("Y")
    force = np.abs(np.nan_to_num(run.values(f"N_{contact}")))
    drop, spacing = v[:-1] - v[1:], np.diff(t)
    explained = spacing*np.maximum(force[1:], force[:-1])
    with np.errstate(invalid="ignore"):
        found = (drop > SUDDEN*v[:-1]) & (v[:-1] > LEAST_SPEED) & (y[:-1] > 0.5*np.nanmax(y))
        found &= (Case().mass*drop > EXPLAINED*explained) & (spacing < CLOSE_ROWS)
    if not found.any():
        return None
    k = int(found.argmax()) + 1
    return ContactInterval(contact, float(t[k]), float(t[k]), np.nan, float(t[k]), np.nan, np.nan, top=k)


def contact_answers(run: RunData, first: ContactInterval) -> dict[str, Any]:
    """Touch, peak, duration and impulse of the first contact. Impacts of rigid contacts take no time, so their forces have no
    peak."""
    contact = first.contact
    found: dict[str, Any] = {f"t_first_{contact}": first.start}
    if np.isfinite(first.peak) and f"P_{contact}" not in run:
        found |= {f"first_peak_N_{contact}": first.peak, f"t_first_peak_{contact}": first.t_peak}
    if first.ends:
        found[f"first_duration_{contact}"] = first.duration
        if np.isfinite(first.impulse):
            found[f"first_impulse_{contact}"] = first.impulse
    if contact in FLANGES and np.isfinite(first.impulse) and (turn := turn_impulse(run, first)) is not None:
        found[f"turn_impulse_{contact}"] = turn
    return found


def turn_impulse(run: RunData, first: ContactInterval) -> float | None:
    """Impulse of a flange from its first touch until the lateral velocity first turns away from it [N s]; None where it does not,
    or without that velocity."""
    force = run.normal_force(first.contact)
    if force is None or "vY" not in run:
        return None
    t, v = run.time, FLANGES[first.contact]*run.values("vY")
    back = np.flatnonzero((t >= first.end if first.end == first.start else t > first.start) & (v <= 0))
    if not back.size:
        return None
    k = max(int(back[0]), 1)
    blows = run.values(f"P_{first.contact}") if f"P_{first.contact}" in run else np.zeros(len(t))
    push = cumulative(t, force)
    turned = t[k - 1] + (t[k] - t[k - 1])*min(max(v[k - 1], 0.0)/max(v[k - 1] - v[k], 1e-300), 1.0)
    before = np.interp(first.start, t, push)
    return float(np.interp(turned, t, push) - before + blows[k] - blows[max(int(np.searchsorted(t, first.start)) - 1, 0)])


# The centre -------------------------------------------------------------------------------

def passages(run: RunData, until: float = np.inf) -> list[float]:
    """Times [s] at which the wheelset passes the centre, between rows on either side; none without the column Y.

    A row is on a side if |Y| is above a ten thousandth of the largest |Y|, so that rounding makes no passage. A run that ends at
    the centre has its last passage there.
    """
    if "Y" not in run.data:
        return []
    good = np.isfinite(run.values("Y")) & (run.time <= until)
    t, y = run.time[good], run.values("Y")[good]
    size = np.abs(y).max(initial=0.0)
    sided = np.flatnonzero(np.abs(y) > CROSSED*size)
    if not sided.size:
        return []
    found = []
    for change in np.flatnonzero(np.diff(np.sign(y[sided]))):
        before, after = sided[change], sided[change + 1]
        k = before + int(np.argmax(y[before + 1:after + 1]*np.sign(y[after]) >= 0))
        found.append(float(t[k] + (t[k + 1] - t[k])*y[k]/(y[k] - y[k + 1])))
    if sided[-1] < len(y) - 1:
        found.append(float(t[sided[-1] + 1 + int(np.abs(y[sided[-1] + 1:]).argmin())]))
    return found


def passage_answers(run: RunData, found: Mapping[str, Any]) -> dict[str, Any]:
    """First passages of the centre after one flange and after both. Where the file does not tell when a flange touched, the
    farthest point on its side stands for it, of a wheelset that swings to both sides."""
    touched = [found.get(f"t_first_{contact}") for contact in FLANGES]
    if None in touched and "farthest_left" in found and -found["farthest_right"] > SWING*found["farthest_left"]:
        touched = [found[f"t_{name}"] if t is None else t
                   for t, name in zip(touched, ("farthest_left", "farthest_right"), strict=True)]
    known, passed = [t for t in touched if t is not None], passages(run)
    return {name: next((t for t in passed if t > after), None) for name, after in (
        ("t_first_centre", min(known, default=np.inf)), ("t_return", max(known) if len(known) == 2 else np.inf))}


# Energies ---------------------------------------------------------------------------------

def energy_answers(run: RunData) -> dict[str, Any]:
    """Kinetic energy at the start, largest drift of the energy, energy lost in impacts."""
    found: dict[str, Any] = {}
    if all(part in run for part in KINETIC_PARTS):
        found["kinetic_energy"] = float(sum(run.values(part)[0] for part in KINETIC_PARTS))
        found["drift_reference"] = found["kinetic_energy"] or (
            float(np.abs(run.values("W_ext")).max()) or None if "W_ext" in run else None)
    if "E_lost" in run:
        found["lost"] = float(run.values("E_lost")[-1])
    if "E_drift" in run and np.isfinite(drift := np.abs(run.values("E_drift"))).any():
        k = int(np.nanargmax(drift))
        found |= {"drift": float(drift[k]), "t_drift": float(run.time[k])}
        if found.get("drift_reference"):
            found["drift_relative"] = found["drift"]/found["drift_reference"]
    return found


# Events -----------------------------------------------------------------------------------

def row_events(run: RunData, case: Case | None, closed: Mapping[str, Sequence[ContactInterval]]) -> list[Event]:
    """The events that rows tell, in order of time: contacts of flanges, wheels that lift off and land, passages of the centre, and
    the derailment of a run whose case is known."""
    found = [Event(one.start, f"{CONTACT_NAMES[contact]} contact", angle=abs(one.angle))
             for contact in FLANGES for one in closed[contact] if one.begins]
    for side, contacts in SIDES.items():
        for first, last in wheel_intervals([one for contact in contacts for one in closed[contact]]):
            found += [Event(first.start, f"{side} wheel landing")] if first.begins else []
            found += [Event(last.end, f"{side} wheel lift-off")] if last.ends else []
    found += [Event(t, "centre passage") for t in passages(run)]
    if case and "Y" in run and (derailed := derailment(run, case)):
        found.append(derailed)
    return sorted(found, key=lambda event: event.t)


def wheel_intervals(found: Sequence[ContactInterval]) -> Iterator[tuple[ContactInterval, ContactInterval]]:
    """The times in which a wheel is on its rail: the intervals of its contacts with which each begins and ends."""
    first = last = None
    for one in sorted(found, key=lambda one: one.rows.start):
        if last is None or one.rows.start > last.rows.stop:
            if first and last:
                yield first, last
            first = last = one
        elif one.rows.stop > last.rows.stop:
            last = one
    if first and last:
        yield first, last


def derailment(run: RunData, case: Case) -> Event | None:
    """The derailment by the rows of a file with the column Y, by the criterion of the core; None without one.

    The tip of a flange passes the highest point of its rail outwards, and the lateral force does not draw it inwards: from there
    is no way back (`fortran/dynamics/events.f90`). case: whose profiles and lateral force the file has.
    """
    t, y = run.time, run.values("Y")
    roll = run.values("roll") if "roll" in run.data else np.zeros(len(t))
    force = case.lateral_force + case.lateral_ramp*t
    found: list[float] = []
    for (wheel, rail), sign in zip(placed_outlines(case)[0], (1, -1), strict=True):
        tip, crown = wheel[wheel[:, 1].argmin()], rail[rail[:, 1].argmax(), 0]
        past = sign*(y - tip[1]*np.sin(roll)) + tip[0]*np.cos(roll) - crown
        out = np.flatnonzero((past[1:] > 0) & (past[1:] > past[:-1]) & (sign*force[1:] >= 0))
        found += [float(np.interp(0.0, past[k:k + 2], t[k:k + 2])) for k in out[:1]]
    return Event(min(found), "derailment", float(case.lateral_force + case.lateral_ramp*min(found))) if found else None


def event_answers(run: RunData, case: Case | None, events: Sequence[Event]) -> dict[str, Any]:
    """Numbers of the events that rows tell; the derailment, and when the wheel that lifts for good carried its last force."""
    known = {kind for contact, kind in ((contact, f"{CONTACT_NAMES[contact]} contact") for contact in FLANGES)
             if run.normal_force(contact) is not None}
    known |= {f"{side} wheel {what}" for side, contacts in SIDES.items() for what in ("lift-off", "landing")
              if all(run.normal_force(contact) is not None for contact in contacts)}
    known |= ({"centre passage"} if "Y" in run else set()) | ({"derailment"} if case and "Y" in run else set())
    counts = Counter(event.kind for event in events)
    found: dict[str, Any] = {count_name(kind): counts[kind] for kind in known}
    if case is None or "derailment" not in known:
        return found
    event = next((event for event in events if event.kind == "derailment"), None)
    found["derailed"] = event is not None
    if event:
        other = "right" if np.interp(event.t, run.time, run.values("Y")) > 0 else "left"
        wheel = [one for one in events if one.kind.startswith(f"{other} wheel ") and one.t <= event.t]
        lifted = wheel[-1].t if wheel and wheel[-1].kind.endswith("lift-off") else None
        found |= {"t_derailment": event.t, "t_unloaded": lifted}
        if case.lateral_force or case.lateral_ramp:
            found |= {"F_derailment": event.force,
                      "F_unloaded": None if lifted is None else case.lateral_force + case.lateral_ramp*lifted}
    return found
