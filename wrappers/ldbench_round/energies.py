"""Kinetic and potential energy of a file: what its columns say, and what the motion says that they are."""
from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from ldbench import Case
from ldbench.constants import CONTACTS, GRAVITY
from ldbench.results.derived import KINETIC_PARTS
from ldbench.results.quantities import quantity
from ldbench.results.run_data import RunData

from .findings import Finding, judged
from .row_checks import lateral_work

#: The sums that a file may give, with their parts; the elastic energy of the contacts belongs to the potential energy.
KINETIC, POTENTIAL = "KE", "PE"
ENERGY_PARTS = {KINETIC: tuple(KINETIC_PARTS), POTENTIAL: ("PE_grav", "PE_load", "PE_elastic_L", "PE_elastic_R")}
ENERGIES = (*ENERGY_PARTS, *(part for parts in ENERGY_PARTS.values() for part in parts))
SUMS = {KINETIC: "kinetic energy", POTENTIAL: "potential energy"}
WRONG = 0.02, 0.1       # of the largest change of an energy: doubtful, wrong
UNTOLD = 0.1, 0.3       # of the change of kinetic energy in a contact: doubtful, wrong
LONG, MANY = 6, 10      # rows of a contact and number of contacts that tell what contacts store, at least
AT_REST = 20.0          # elastic energy of the contacts at rest, at most [J]; zero may be there or where they are open

KINDS = {"kinetic": r"kinet\w*|cinetique|[et]?kin|ke|ec|ek", "potential": r"potent\w*|[eu]?pot|pe|ep",
         "elastic": r"e?elast\w*|[eu]?el"}
WHERE = {"lat": r"lat(?:eral)?|quer|y", "vert": r"vert(?:ical)?|vertikal|z", "roll": r"roll|roulis|wanken|al|phi",
         "grav": r"g(?:rav(?:ity)?)?|weight|pesanteur|gewicht", "load": r"load|charge|last", "elastic_L": r"left|gauche|links|l",
         "elastic_R": r"right|droite?|rechts|r"}
NO_PART = "energy", "energie", "e", "total", "wheelset", "axle", "wheel", "of", "the", "de", "di", "del", "la"


def energy_named(words: str) -> str:
    """The column of ours that a name in lower case and plain letters, as 'kinetic energy lateral', stands for; '' for none."""
    tokens = [token for token in re.findall("[a-z]+", words) if token not in NO_PART]
    kinds = {kind for token in tokens for kind, pattern in KINDS.items() if re.fullmatch(pattern, token)}
    places = {place for token in tokens for place, pattern in WHERE.items() if re.fullmatch(pattern, token)}
    if not kinds or len(places) > 1 or len(tokens) > len(kinds) + len(places):
        return ""
    whole = KINETIC if "kinetic" in kinds else POTENTIAL
    column = f"{whole}_{next(iter(places))}" if places else whole if "elastic" not in kinds else ""
    return column if column in ENERGIES else ""


def told(run: RunData, whole: str, elastic: bool = True) -> np.ndarray | None:
    """The kinetic or potential energy of a file, (rows,) [J], by its parts or its sum; None where it has neither.

    elastic: whether parts of the elastic energy count, if the file has them.
    """
    needed = [part for part in ENERGY_PARTS[whole] if not part.startswith("PE_elastic")]
    if not all(part in run.data for part in needed):
        return run.values(whole) if whole in run.data else None
    parts = [part for part in ENERGY_PARTS[whole] if part in run.data and (elastic or part in needed)]
    return np.asarray(sum(np.nan_to_num(run.values(part)) for part in parts))


def energy_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """Whether energies, where a file has them, are those of its motion. Their zeros are free, so changes are compared."""
    motion = {"vY": case.mass, "vZ": case.mass, "roll_rate": case.roll_inertia}
    if not all(name in run.data for name in (*motion, "Z")):
        return
    expected = dict(zip(ENERGY_PARTS[KINETIC], (inertia*run.values(name)**2/2 for name, inertia in motion.items()), strict=True))
    expected[KINETIC] = np.asarray(sum(expected.values()))
    expected |= {"PE_grav": case.mass*GRAVITY*run.values("Z"), "PE_load": case.vertical_load*run.values("Z")}
    expected[POTENTIAL] = expected["PE_grav"] + expected["PE_load"]
    kinetic = expected[KINETIC] - expected[KINETIC][0]
    work = lateral_work(run, case)
    for column, energy in expected.items():
        if column not in run.data:
            continue
        change, of_motion = (x - x[0] for x in (run.values(column), energy))
        over = change - of_motion
        if column == POTENTIAL:
            # The contacts may have stored what kinetic energy, weight and load have lost.
            stored = np.maximum(work - kinetic - of_motion, 0.0) + AT_REST
            over = over - np.clip(over, -AT_REST, stored)
        size = max(np.ptp(of_motion), 1e-300)
        error = np.nan_to_num(np.abs(over), nan=np.inf)/size
        ratio = float(np.sum(change*of_motion)/max(np.sum(of_motion**2), 1e-300))
        yield judged(f"{SUMS.get(column) or quantity(column).words} is that of the motion", error.max(), *WRONG,
                     int(error.argmax()) + 1, f"about {ratio:.3g} times what velocities, or weight, load and Z make")


def side_findings(run: RunData) -> Iterator[Finding]:
    """Whether the elastic energy of a wheel stays what it is while none of its contacts presses."""
    for side, words in ("L", "left"), ("R", "right"):
        column, forces = f"PE_elastic_{side}", [f"N_{side}{part}" for part in "TF"]
        if not all(name in run.data for name in (column, *forces)):
            continue
        energy, pressed = run.values(column), np.any([np.nan_to_num(run.values(name)) != 0 for name in forces], axis=0)
        # Rows beside a contact may be those of its beginning and its end.
        free = ~np.convolve(pressed, np.ones(3), "same").astype(bool) & np.isfinite(energy)
        size = float(np.ptp(energy[np.isfinite(energy)])) if np.isfinite(energy).any() else 0.0
        if free.sum() < 2 or not size:
            continue
        error = np.where(free, np.abs(energy - np.median(energy[free])), 0.0)/size
        row = int(error.argmax())
        yield judged(f"no elastic energy of the {words} wheel in the air", float(error[row]), *WRONG, row + 1,
                     f"it changes by {error[row]*size:.4g} J while no contact of this wheel presses; are the wheels exchanged?")


def total_findings(run: RunData, case: Case) -> Iterator[Finding]:
    """Whether kinetic and potential energy add up to a sum that does not dip and come back: contacts that give store energy in an
    impact, which the potential energy has to tell. A sum that falls for good is that of a code that loses energy."""
    parts = [told(run, whole) for whole in (KINETIC, POTENTIAL)]
    if parts[0] is None or parts[1] is None or "vY" not in run.data:
        return
    yield from stored_finding(run, parts[0], parts[0] + parts[1] - lateral_work(run, case))
    work = lateral_work(run, case)
    energy = np.nan_to_num(parts[0] + parts[1] - work)
    dip = np.minimum(np.maximum.accumulate(energy), np.maximum.accumulate(energy[::-1])[::-1]) - energy
    size = max(float(np.ptp(parts[0])), float(np.ptp(work)), 1e-300)
    row = int(dip.argmax())
    yield judged("total energy does not dip in an impact", float(dip[row]/size), *WRONG, row + 1,
                 f"the sum of kinetic and potential energy dips by {dip[row]:.4g} J and comes back: {what_is_stored(run)}")


def stored_finding(run: RunData, kinetic: np.ndarray, energy: np.ndarray) -> Iterator[Finding]:
    """Whether many contacts take no energy that a file does not tell. What the work of the lateral force lacks between rows goes
    one way through a contact; what a contact stores comes back, so a straight line from its begin to its end leaves it."""
    dips, places = [], []
    for one in (one for contact in CONTACTS for one in run.intervals(contact, rigid=False) or [] if one.whole):
        rows = slice(one.rows.start - 1, one.rows.stop + 1)
        if one.rows.stop - one.rows.start >= LONG and (size := np.ptp(kinetic[rows])):
            t, x = run.time[rows], energy[rows]
            line = np.interp(run.time[one.top], t[[0, -1]], x[[0, -1]])
            dips.append(float(line - energy[one.top])/size)
            places.append(one.top)
    if len(dips) >= MANY:
        dip = float(np.median(dips))
        row = places[int(np.argmin(np.abs(np.asarray(dips) - dip)))]
        yield judged("contacts give back what they have stored", abs(dip), *UNTOLD, row + 1,
                     f"at the largest forces {100*dip:.3g} % of the change of kinetic energy are untold, the median of {len(dips)} "
                     f"contacts: {what_is_stored(run)}")


def what_is_stored(run: RunData) -> str:
    """What may be wrong with the elastic energy of a file, in words."""
    stored = [run.values(part) for part in ENERGY_PARTS[POTENTIAL][2:] if part in run.data]
    if not stored:
        return "the elastic energy of the contacts is missing"
    told = any(np.any(np.nan_to_num(x) != 0) for x in stored)
    return f"the elastic energy of the contacts is {'another one' if told else 'zero'}"
