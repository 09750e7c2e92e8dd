"""Contact parameters of EN 15302:2021: the ten reference combinations, level and with roll."""
from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import en15302
from checks import Check, Section, absolute, limit
from ldbench.geometry.en15302 import AMPLITUDES, MISPRINTS, TABLES, window
from ldbench.geometry.pair import Pair, pair
from sheets import Table

# The tables are rounded to 1 um. The spline rounds what is left of joints of zones, where the contact may stand.
DELTA_R_BAR, MEDIAN_BAR = 2.0, 0.5      # [um]

TEXT = """EN 15302:2021 gives wheels A, B, C, H and I and rail A as formulas (annex I), the rolling radius difference of ten
combinations (annex J), and the equivalent conicity with tolerance windows (annex K). Two wheels are alike in five of them, have
diameters of 920 mm and 918 mm in four, and are A and B in one. The standard keeps the wheelset level: each wheel touches its own
rail. The program stands the wheelset on both rails, with roll, and computes both.

Level, the radius differences agree with the tables to 2 µm, with these exceptions. Misprints, which break the smooth run of
their own table: {misprints}. Wheel A at 6.2 mm: two zones of its formulas meet there with a step of 0.056 µm, and an arc of
14 mm nearly conforms to one of 13 mm, so the step moves the contact by 0.1 mm and the radius difference by 32 µm; on a wheel
without the step the tables are met. Where the contact jumps exactly at a displacement of the table, either end of the jump counts.

With roll the contacts move on the heads, and the conicity is larger: it is not what the windows are for. The definitions follow
O. Polach, D. Nicklisch, Wear 366-367 (2016) 200-208, and K. Knothe, S. Stichel, Rail Vehicle Dynamics (2017).
"""


def misprint_words() -> str:
    """All misprints in words."""
    words = []
    for (name, y), meant in en15302.MISPRINTS.items():
        at, values = en15302.table(name)
        words.append(f"radius difference of {name} at {y:g} mm {values[np.argmin(np.abs(at - y))]:.3f} for {meant:.3f} mm")
    for (name, amplitude), meant in MISPRINTS.items():
        printed = TABLES[name][0, int(np.argmin(np.abs(AMPLITUDES - 1e-3*amplitude)))]/1e3
        words.append(f"conicity of {name} at {amplitude:g} mm {printed:.3f} for {meant:.3f}")
    return "; ".join(words)


def combination_checks(name: str, paths: dict[str, str], found: Pair) -> tuple[list[Check], list[str]]:
    """Checks of a combination and its row of the table of results."""
    y, off = en15302.deviations(name, paths)
    step = np.array([(name, at) in en15302.AT_A_STEP for at in y.tolist()])
    checks = [
        limit(f"{name}: radius difference level, largest deviation [um]", off[~step].max(), "EN 15302, annex J", DELTA_R_BAR),
        limit(f"{name}: radius difference level, median deviation [um]", np.median(off), "EN 15302, annex J", MEDIAN_BAR)]
    if step.any():
        closed = en15302.deviations(name, paths | {"A": paths["A closed"]})[1][step]
        checks.append(limit(f"{name}: radius difference at 6.2 mm, wheel A without its step [um]", closed.max(),
                            "EN 15302, annex J", DELTA_R_BAR))
    w = window(name)
    hits = []
    for geometry in found.level, found.rolled:
        conicity = np.array([geometry.conicity_at(amplitude) for amplitude in AMPLITUDES])
        hits.append((int(np.sum((w.low <= conicity) & (conicity <= w.high))),
                     int(np.sum((w.extended_low <= conicity) & (conicity <= w.extended_high)))))
    checks.append(absolute(f"{name}: conicities level inside their windows", hits[0][0], AMPLITUDES.size, "EN 15302, annex K", 0))
    row = [name, str(y.size), f"{np.median(off):.2f}", f"{off[~step].max():.2f}", *(str(n) for pair_ in hits for n in pair_),
           *(f"{geometry.conicity_at(3e-3):.3f}" for geometry in (found.level, found.rolled)),
           f"{w.value[np.argmin(np.abs(AMPLITUDES - 3e-3))]:.3f}"]
    return checks, row


def section() -> Section:
    checks: list[Check] = []
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        paths = en15302.write(Path(folder))
        for name in TABLES:
            found = pair(en15302.case(name, paths), en15302.radii(name))
            more, row = combination_checks(name, paths, found)
            checks += more
            rows.append(row)
    return Section("Contact parameters of EN 15302", TEXT.format(misprints=misprint_words()), checks, [
        Table(f"Radius differences, and conicities inside windows, of {AMPLITUDES.size}", (
            "wheels on rail A", "radius differences", "median deviation [um]", "largest [um]", "level: inside window", "extended",
            "with roll: inside window", "extended", "conicity at 3 mm: level", "with roll", "EN 15302"), rows)])
