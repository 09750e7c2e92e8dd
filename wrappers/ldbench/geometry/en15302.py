"""Reference conicities of EN 15302:2021, annex K, and the tolerance windows about them.

The combinations are named by their wheels on rail A: 'A' to 'I' with two wheels alike; 'A-918' and so on with diameters of
920 mm and 918 mm on the tape circle; 'A-B' with wheel A on the side to which displacements count.
"""
from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

AMPLITUDES = 1e-3*(1 + 0.2*np.arange(33))       # [m]
WIDEST, SHARE = 0.05, 0.5                       # half width of a window: the smaller one of this, and this share of the value

FILE = Path(__file__).with_name("en15302.csv")
# By combination, thousandths at the amplitudes, (3, 33): reference values, lower and upper ends of the extended windows.
TABLES = dict(zip(FILE.read_text().partition("\n")[0].split(",")[1::3],
                  np.loadtxt(FILE, delimiter=",", skiprows=1)[:, 1:].T.reshape(-1, 3, len(AMPLITUDES)), strict=True))
# Values that break the smooth run of their table and would be this instead, by combination and amplitude [mm].
MISPRINTS = {("C", 4.2): 0.214}


@dataclass(frozen=True)
class Window:
    """Reference values of a combination and their windows at AMPLITUDES, each (33,)."""
    value: np.ndarray           # misprints put right
    low: np.ndarray             # of the window for software
    high: np.ndarray
    extended_low: np.ndarray    # of the window for measurement and software together
    extended_high: np.ndarray


def window(combination: str) -> Window:
    """The windows of a combination; those of a misprint lie about what it would be."""
    value, low, high = TABLES[combination]/1e3
    for (name, amplitude), meant in MISPRINTS.items():
        if name == combination:
            at = int(np.argmin(np.abs(AMPLITUDES - 1e-3*amplitude)))
            low[at], high[at], value[at] = low[at] + meant - value[at], high[at] + meant - value[at], meant
    half = np.minimum(WIDEST, SHARE*value)
    return Window(value, value - half, value + half, low, high)
