"""Lines are told apart by readers with any of the three kinds of colour blindness, on paper and on light and dark pages.

Colours are simulated by the matrices of Machado, Oliveira and Fernandes (IEEE Trans. Vis. Comput. Graph. 15(6), 2009) for a
reader who lacks one kind of cone, and compared by their distance in CIELAB (CIE 1976).
"""
from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

from ldbench.plots import style
from running import REPO

SEEN_BY = {
    "all cones": np.eye(3),
    "no L cones": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    "no M cones": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "no S cones": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]])}
XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])
WHITE = np.array([0.95047, 1.0, 1.08883])
APART, FAR_APART = 15, 60       # distances in CIELAB; 2 is just noticed side by side


def lab(colour: str, seen: np.ndarray) -> np.ndarray:
    """CIELAB of a colour #rrggbb as a reader sees it."""
    s = np.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)])/255
    light = np.clip(seen @ np.where(s <= 0.04045, s/12.92, ((s + 0.055)/1.055)**2.4), 0, 1)
    x = XYZ @ light/WHITE
    f = np.where(x > 216/24389, np.cbrt(x), (24389/27*x + 16)/116)
    return np.array([116*f[1] - 16, 500*(f[0] - f[1]), 200*(f[1] - f[2])])


def distance(one: str, other: str, seen: np.ndarray) -> float:
    return float(np.linalg.norm(lab(one, seen) - lab(other, seen)))


def named(file: str, pattern: str) -> list[str]:
    return re.findall(pattern, (REPO/"wrappers"/file).read_text())


CSS = named("ldbench/viewer/static/page.css", r"--(\w+): (#[0-9a-f]{6})")
DARK = [k for k, (name, _) in enumerate(CSS) if name == "paper"][1]
PALETTES = {"print": {name: line.color for name, line in style.CONTACT_LINES.items()},
            "light": dict(CSS[:DARK]), "dark": dict(CSS[DARK:])}
CODES = named("ldbench_round/static/collation.css", r"--code\d: (#[0-9a-f]{6})")
# Colours of lines, with the dashes, or dashes and width, by which they are told apart too.
LINES = {"runs": [(line.color, line.dashes) for line in style.SERIES],
         **{f"runs, {where}": [(PALETTES[where][f"series{k}"], (k % 4, k % 3)) for k in range(8)] for where in ("light", "dark")},
         "codes": [(line.color, line.dashes) for line in style.CODE_LINES],
         "codes, light": [(colour, None) for colour in CODES[:6]], "codes, dark": [(colour, None) for colour in CODES[6:]]}


@pytest.mark.parametrize("seen", SEEN_BY)
def test_lines_are_told_apart(seen: str):
    """Left and right by colour, runs and codes by colour or dashes."""
    for where, palette in PALETTES.items():
        for left, right in itertools.product(("LT", "LF"), ("RT", "RF")):
            assert distance(palette[left], palette[right], SEEN_BY[seen]) > FAR_APART, (where, left, right)
    for group, lines in LINES.items():
        for (one, dashes), (other, others) in itertools.combinations(lines, 2):
            assert dashes != others or distance(one, other, SEEN_BY[seen]) > APART, (group, one, other)
