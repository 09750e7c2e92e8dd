"""The largest pressure of a run against the pressures of all rows.

The core presses few moments of a run: those that Hertz's theory ranks first, those of the largest forces, and the first peaks of
the flanges. Here both wheels are pressed in every row of exercises 1 to 4, on 16 x 32 elements, and then on 24 x 48 in the rows
whose pressure comes within 10 % of the largest. No row may have a larger pressure than the answer of the run, but by its bar.

The answer itself, and the pressures at the first peaks of the flanges, are pressed anew on 48 x 96 elements at the time and in the
pose of the nearest row.
"""
from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

import ldbench
from checks import Check, Section, absolute, limit, relative
from ldbench import Case, ContactTable, Run
from ldbench._core.calls import Handle
from ldbench.constants import CONTACTS
from ldbench.pressure import ELEMENTS, Patch, press
from ldbench.table import rigid_geometry
from sheets import Table

PAIRS = "aw", "sw"
EXERCISES = 1, 2, 3, 4
FLANGES = "LF", "RF"
COARSE, FINE = 32, 2*ELEMENTS   # elements over the length of a patch along the profile
NEAR = 0.9                      # share of the largest pressure on coarse elements from which on rows are pressed again
EXCESS_BAR = 5e-3               # by which a row may have a larger pressure than the answer
GRID_BAR = 1e-2                 # by which twice as many elements may change a pressure or an approach
# The edge of a patch is known to a quarter of an element on either side: (1 + 2/4/48)^2 - 1.
AREA_BAR = 2.1e-2


@dataclass(frozen=True)
class Hardest:
    """The largest pressure of a row."""

    row: int
    patch: Patch


class Poses:
    """The rows of a run, to be pressed."""

    def __init__(self, run: Run) -> None:
        self.run = run
        self.handle: Handle = rigid_geometry(run.case)
        self.q = run.data[["Y", "Z", "roll"]].to_numpy() + [0, run.results["axle_height"], run.results["axle_roll"]]

    def pressed(self, rows: np.ndarray, elements: int) -> list[Hardest]:
        """The largest pressure of each row that has one."""
        def one(k: int) -> Hardest | None:
            patches = press(self.handle, self.run.case, self.q[k], elements=elements)
            return Hardest(k, max(patches, key=lambda patch: patch.largest)) if patches else None

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return [found for found in pool.map(one, rows.tolist()) if found]

    def hardest(self) -> Hardest:
        """The row with the largest pressure."""
        force = self.run.data[[f"N_{contact}" for contact in CONTACTS]].to_numpy()
        coarse = self.pressed(np.flatnonzero((force > 0).any(axis=1)), COARSE)
        most = max(found.patch.largest for found in coarse)
        again = np.array([found.row for found in coarse if found.patch.largest > NEAR*most])
        return max(self.pressed(again, ELEMENTS), key=lambda found: found.patch.largest)

    def at(self, time: float, contact: str) -> tuple[int, list[Patch]]:
        """The nearest row, and the patches of a contact there on fine elements."""
        k = int(np.abs(self.run.data.time.to_numpy() - time).argmin())
        return k, press(self.handle, self.run.case, self.q[k], [contact], FINE)


def answer_checks(poses: Poses, found: Hardest) -> list[Check]:
    s, name = poses.run.results, poses.run.name
    contact = s["pmax_contact"]
    k, patches = poses.at(s["t_pmax"], contact)
    patch = max(patches, key=lambda one: one.largest)
    peak = patch.track[np.unravel_index(int(patch.p.argmax()), patch.p.shape)[1]]
    span = patch.s_ends[1] - patch.s_ends[0]
    checks = [
        limit(f"{name}: excess of the largest pressure of all rows over pmax [1]", max(found.patch.largest/s["pmax"] - 1, 0.0),
              f"every row pressed: {1e-9*found.patch.largest:.3f} GPa, {found.patch.contact}", EXCESS_BAR),
        absolute(f"{name}: t_pmax [s]", s["t_pmax"], poses.run.data.time.iloc[k], "the nearest row; bar rounding", 1e-9),
        relative(f"{name}: pmax [GPa]", 1e-9*s["pmax"], 1e-9*patch.largest, "twice as many elements", GRID_BAR),
        # The largest of the elements is up to an element of either grid from the top.
        limit(f"{name}: place of pmax from that of the largest element [mm]",
              1e3*float(np.hypot(*(peak - [s["pmax_y"], s["pmax_z"]]))), "twice as many elements; bar two coarse elements",
              1e3*2*span/ELEMENTS)]
    for flange in FLANGES:
        if np.isnan(s[f"pmax_{flange}"]):
            continue
        k, patches = poses.at(s[f"t_first_peak_{flange}"], flange)
        for quantity, scale, unit, value, bar in (("pmax", 1e-9, "GPa", max(one.largest for one in patches), GRID_BAR),
                                                  ("patch", 1e6, "mm²", sum(one.area for one in patches), AREA_BAR),
                                                  ("approach", 1e3, "mm", max(one.approach for one in patches), GRID_BAR)):
            checks.append(relative(f"{name}: {quantity}_{flange} [{unit}]", scale*s[f"{quantity}_{flange}"], scale*value,
                                   "twice as many elements", bar))
        checks.append(limit(f"{name}: excess of pmax_{flange} over pmax [1]", max(s[f"pmax_{flange}"]/s["pmax"] - 1, 0.0),
                            "the largest of the run", 0.0))
    return checks


def section() -> Section:
    checks: list[Check] = []
    rows = []
    for pair in PAIRS:
        table = ContactTable(Case.exercise(1, pair))
        for exercise in EXERCISES:
            run = ldbench.run(Case.exercise(exercise, pair), table=table)
            poses, s = Poses(run), run.results
            found = poses.hardest()
            checks += answer_checks(poses, found)
            rows.append([run.name, f"{1e-9*s['pmax']:.3f}", s["pmax_contact"], f"{1e3*s['t_pmax']:.4f}",
                         f"{1e-9*found.patch.largest:.3f}", found.patch.contact, f"{1e3*run.data.time.iloc[found.row]:.4f}"])
    return Section("Largest pressures against those of all rows", __doc__, checks, [Table(
        "Largest pressure of a run: the answer, and that of all rows",
        ["case", "pmax [GPa]", "contact", "at [ms]", "all rows [GPa]", "its contact", "its time [ms]"], rows)])
