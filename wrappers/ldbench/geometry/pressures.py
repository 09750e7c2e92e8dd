"""Patches of a run, at a row and through the first contact of a flange."""
from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np

from .._core.calls import Handle
from .._core.errors import Error
from ..constants import CONTACTS
from ..pressure import ELEMENTS, Patch, press, shared
from ..results.contact_intervals import ContactInterval
from ..results.run_data import RunData
from ..table import rigid_geometry
from .outlines import fits, pose

FLANGES = "LF", "RF"

_placed: WeakKeyDictionary[RunData, Handle] = WeakKeyDictionary()      # profiles are placed once for all poses of a run


def run_patches(run: RunData, k: int, contacts: Sequence[str] = CONTACTS, elements: int = ELEMENTS) -> list[Patch]:
    """The patches of some contacts at row k. Error where the run has no pressures: of another law of contact, of a file without
    ldbench's header, with profiles that are not there or have changed."""
    case = run.case
    changed = [file for name, file in case.profile_files().items() if Path(file).is_file()
               and not fits(case, run, name)]
    if changed:
        raise Error(file=changed[0], expected=f"the profile of the run {run.file}", found="one that has changed since")
    if run not in _placed:
        _placed[run] = rigid_geometry(case)
    wheels = [contact for contact in CONTACTS if contact[0] in {name[0] for name in contacts}]
    loads = {contact: (float(run.values(f"N_{contact}")[k]), float(run.values(f"angle_{contact}")[k])) for contact in wheels}
    closed = [contact for contact in wheels if run.closed(contact)[k]]
    found = shared(press(_placed[run], case, pose(run, k), wheels, elements, loads), closed, case.flange_angle)
    return [patch for patch in found if set(patch.contacts) & set(contacts)]


def known_patches(run: RunData, k: int, contacts: Sequence[str] = CONTACTS) -> list[Patch]:
    """The patches of some contacts at row k; none where no pressure is known: of another law of contact, of another code, or with
    profiles that are not there or not those of the run."""
    if run.law != "halfspace":
        return []
    try:
        return run_patches(run, k, contacts)
    except Error:
        return []


def told(patches: Sequence[Patch]) -> tuple[float, float, float]:
    """Largest pressure [Pa], area of all patches [m²] and largest approach [m]."""
    return hardest(patches).largest, sum(patch.area for patch in patches), max(patch.approach for patch in patches)


def hardest(patches: Sequence[Patch]) -> Patch:
    """The patch with the largest pressure."""
    return max(patches, key=lambda patch: patch.largest)


def patch_history(run: RunData, one: ContactInterval, number: int) -> np.ndarray:
    """Time [s], largest pressure [Pa], area of all patches [m²] and largest approach [m], (4, n), at rows of an interval in which
    a contact is closed, at about equal intervals; empty where no pressure is known."""
    ends = run.time[max(one.rows.start - 1, 0)], run.time[min(one.rows.stop, len(run.time) - 1)]
    rows = np.unique([*np.searchsorted(run.time, np.linspace(*ends, number + 2)[1:-1]), one.top])
    found = [(run.time[k], *told(patches)) for k in rows if (patches := known_patches(run, int(k), [one.contact]))]
    return np.array(found).reshape(-1, 4).T
