"""Names of contacts and sides, of a file that is sent, factors from SI units, and numbers of the call and of standards that several
modules need."""
from __future__ import annotations

from math import pi

MM, KN, DEG = 1e3, 1e-3, 180/pi         # from SI units
GRAVITY = 9.81                          # as the call has it [m/s2]
TAPE_CIRCLE = 70e-3                     # from the back of a wheel (EN 13715) [m]
DESCRIPTION = "submission.toml"         # of what a participant sends, beside the files

CONTACT_NAMES = {"LT": "left tread", "LF": "left flange", "RT": "right tread", "RF": "right flange"}
CONTACTS = tuple(CONTACT_NAMES)         # as in the names of columns, in the order of the core
SIDES = {"left": ("LT", "LF"), "right": ("RT", "RF")}
