"""Events of a run: contacts that begin and end, passages of the centre, derailment, impacts."""
from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from .._core.calls import descriptions

FLANGE_ANGLE = np.radians(25)       # least contact angle of a flange contact inside the clearance; as in the core


class Event(NamedTuple):
    """An event of a run."""

    t: float                            # [s]
    kind: str                           # 'left flange contact', 'derailment', ...
    force: float = np.nan               # lateral force on the wheelset then [N]; NaN in a run without one
    angle: float = np.nan               # contact angle of a flange contact [rad]; NaN of other events
    impulses: Mapping[str, float] = {}  # of an impact, by contact [N s]
    loss: float = 0.0                   # energy that an impact takes away [J]
    cause: str = ""                     # of a flange contact: 'closes', or 'moves' from the tread; '' where it is not told


def event_kinds() -> list[str]:
    """All kinds of events, in the order of the core."""
    return descriptions()[2:-1]


def count_name(kind: str) -> str:
    """The name of the number of events of a kind among the results: 'n_left_flange_contact'."""
    return "n_" + re.sub("[ -]", "_", kind)
