"""The specimen of the tests of shown numbers: runs whose sides, units and moments cannot be mistaken for each other."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

import ldbench
from ldbench.__main__ import main
from ldbench.plots import document
from ldbench.runs import compute
from named_artists import all_named
from raw import Raw
from reading import words_of
from running import kept_tables

# Left and right differ, tread and flange too; mass, load and inertia are not the call's; no first moment is the wanted one. Ten
# variations of trust need a table of their own, so tables are coarse.
SPECIMEN = {"wheel_profile_right": "profiles/swprof.yz",
            "rail_profile_right": "profiles/srprof.yz", "mass": 1600.0, "roll_inertia": 700.0, "vertical_load": 150e3, "Z": -2e-5,
            "table_folder": kept_tables(), "accuracy": 2e-2}
# What is shown is what was made, so little is made. Bodies with so few waves and sides of triangles take a tenth of the time. Each
# accuracy, influence and length of the track would be one more table.
LITTLE = {"bodies.influence.WAVES": np.geomspace(0.2, 800, 4), "bodies.influence.PARTS": 2, "bodies.sections.PARTS": 2,
          "trust.variations.FACTORS": (2.0,), "trust.variations.INFLUENCES": ("local", "flat"),
          "trust.variations.INPUT_GROUPS": ("wheelset", "material", "initial", "loading")}


class World(NamedTuple):
    """A thrown wheelset and one that is pushed until it derails, both reported, and one that is thrown faster."""

    folder: Path
    thrown: Raw         # ex2_aw
    pushed: Raw         # ex5_aw
    faster: Raw         # ex3_aw, not in the report: it rises higher after the right flange than before

    @property
    def outputs(self) -> Path:
        return self.folder/"outputs"

    @property
    def raws(self) -> dict[str, Raw]:
        return {"ex2_aw": self.thrown, "ex3_aw": self.faster, "ex5_aw": self.pushed}

    def raw(self, name: str) -> Raw:
        return self.raws[name]

    def run(self, name: str) -> ldbench.Run:
        return read(self.raw(name).file)

    def sheets(self, heading: str) -> dict[str, str]:
        """The words of the pages whose heading begins so, by the rest of the heading."""
        return {file.name.removeprefix(heading): file.read_text(encoding="utf-8")
                for file in sorted((self.folder/"sheets").glob(f"{heading}*"))}


read = cache(ldbench.read_run)


def noting(save: Callable[..., object], folder: Path) -> Callable[..., object]:
    """`document.save_parts`, which also notes the words of each figure that it draws, under chapter and title, and the figures with
    an artist that nobody named, in files with the ending .unnamed."""
    def noted(chapter: str, pages: Iterable[tuple[str, Figure]]) -> Iterator[tuple[str, Figure]]:
        for title, figure in pages:
            (folder/f"{chapter}: {title}").write_text(words_of(figure), encoding="utf-8")
            if not all_named(figure):
                (folder.parent/f"{chapter}: {title}.unnamed").touch()
            yield title, figure

    def save_noted(target: Path, chapters: Sequence[tuple[str, Iterable[tuple[str, Figure]]]]) -> object:
        # Pictures of the abstract, which are no chapter, are read in its PDF file; of sheets only what is outside of axes is read.
        with pytest.MonkeyPatch.context() as patch, matplotlib.rc_context({"pdf.use14corefonts": chapters[0][0] != ""}):
            if chapters[0][0]:
                patch.setattr(Axes, "draw", lambda *_: None)
            return save(target, [(chapter, noted(chapter, pages)) for chapter, pages in chapters])

    return save_noted


def make_specimen(folder: Path) -> None:
    """Fill an empty folder: inputs, what the report makes of them in outputs, the words of its sheets, and the faster run."""
    for name in "inputs", "outputs", "sheets", "faster":
        (folder/name).mkdir()
    thrown = ldbench.Case.exercise(2, "aw").replace(**SPECIMEN, vY=0.8, t_end=0.2, interval=2e-4)
    thrown.to_namelist(folder/"inputs/ex2_aw.nml")
    ldbench.Case.exercise(5, "aw").replace(**SPECIMEN, dt=5e-5, lateral_ramp=1.2e5, t_end=3.0,
                                           interval=2.5e-4).to_namelist(folder/"inputs/ex5_aw.nml")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name, little in LITTLE.items():
            module, _, variable = name.rpartition(".")
            patch.setattr(import_module(f"ldbench.{module}"), variable, little)
        patch.setattr(document, "save_parts", noting(document.save_parts, folder/"sheets"))
        # The arrangement of panels takes a third of the time, and no number depends on it.
        patch.setattr(ConstrainedLayoutEngine, "execute", lambda engine, figure: None)
        assert main(["report", "--inputs", "inputs", "-j", "2"]) == 0
        compute(thrown.replace(vY=1.2, name="ex3_aw")).write(folder/"faster/ex3_aw.txt")
