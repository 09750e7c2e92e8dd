"""The specimen of the tests of shown numbers: two runs whose sides, units and moments cannot be mistaken for each other."""
from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

import ldbench
from ldbench.__main__ import main
from raw import Raw

# Left and right differ, tread and flange too; mass, load and inertia are not the call's; no first moment is the wanted one.
SPECIMEN = {"n_lateral": 40, "n_roll": 9, "n_depth": 9, "wheel_profile_right": "profiles/swprof.yz",
            "rail_profile_right": "profiles/srprof.yz", "mass": 1600.0, "roll_inertia": 700.0, "vertical_load": 150e3, "Z": -2e-5,
            "table_file": "outputs/aw.table"}


class World(NamedTuple):
    """The specimen: a thrown wheelset and one that is pushed until it derails, reported, and the raw rows of both."""

    folder: Path
    thrown: Raw
    pushed: Raw

    @property
    def outputs(self) -> Path:
        return self.folder/"outputs"

    def run(self, name: str) -> ldbench.Run:
        return ldbench.read_run(self.outputs/f"{name}.txt")


def make_specimen(folder: Path) -> None:
    (folder/"inputs").mkdir()
    (folder/"outputs").mkdir()
    ldbench.Case.exercise(2, "aw").replace(**SPECIMEN, vY=0.8, t_end=0.2, interval=2e-4).to_namelist(folder/"inputs/ex2_aw.nml")
    ldbench.Case.exercise(5, "aw").replace(**SPECIMEN, dt=5e-5, lateral_ramp=1.2e5, t_end=4.0,
                                           interval=2.5e-4).to_namelist(folder/"inputs/ex5_aw.nml")
    before = Path.cwd()
    os.chdir(folder)
    try:
        assert main(["report", "--inputs", "inputs", "-j", "2"]) == 0
    finally:
        os.chdir(before)
