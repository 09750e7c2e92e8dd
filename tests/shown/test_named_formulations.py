"""The pages of the formulations: every curve and level from the rows of runs of its own, every shade from the words in its cell."""
from __future__ import annotations

import json
import re
from collections.abc import Iterator
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from scipy.integrate import cumulative_trapezoid

import ldbench
from ldbench.plots.named import Shown
from ldbench.plots.style import ldbench_style
from ldbench.report.formulations import Outcome, exercises_page, values_page, verdict_page
from named_artists import shown
from of_runs import COMPARED, compare
from raw import Raw
from specimen import World
from walk import walk

CHANGES = {"bilateral": {"formulation": "bilateral"}, **{f"unilateral, e = {e:g}": {"formulation": "unilateral", "restitution": e}
                                                         for e in (1.0, 0.5, 0.0)}}
KEPT = 2500         # rows of a run, at most
LABELS = {"lateral Y [mm]": "Y [mm]", "vertical Z [mm]": "Z [mm]", "left flange: impulse [kN·s]": "impulse_LF [kN·s]",
          "kinetic energy [J]": "KE_lat+KE_vert+KE_roll [J]"}
GREEN, ORANGE, RED = "#bfe5d6", "#fce3b4", "#f6c9b0"


@pytest.fixture(autouse=True)
def styled() -> Iterator[None]:
    with ldbench_style():
        yield


@pytest.fixture(scope="module")
def found(world: World) -> list[Outcome]:
    """The outcomes of the report."""
    return [Outcome(**one) for one in json.loads((world.outputs/".ldbench/formulations.json").read_text(encoding="utf-8"))]


@pytest.fixture(scope="module")
def raws(world: World, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Raw]:
    """Runs of each formulation, and the ones that roll over the flange."""
    folder, made = tmp_path_factory.mktemp("formulations"), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(world.folder)
        cases = {name: ldbench.Case.from_namelist(f"inputs/{name}.nml").replace(table_folder="") for name in ("ex2_aw", "ex5_aw")}
        rare = {"ex2_aw": {}, "ex5_aw": {"interval": 5e-3, "dt": 1e-3}}
        for name, case in cases.items():
            made[f"{name} elastic"] = world.raw(name)
            for words, changes in CHANGES.items():
                made[f"{name} {words}"] = written(case.replace(**changes, **rare[name]), folder)
        made["over the flange, aw"] = written(cases["ex5_aw"].replace(
            **CHANGES["bilateral"], vY=2.5, lateral_ramp=0.0, interval=2e-5, dt=2e-5, t_end=0.1), folder)
    return {**{words: thinned(raw) for words, raw in made.items() if words[:2] == "ex"}, **world.raws,
            "over the flange, aw": made["over the flange, aw"]}


def written(case: ldbench.Case, folder: Path) -> Raw:
    found = Raw(Path(ldbench.run(case).write(folder/"run.txt")))
    found.rounding = 1e-8           # the page has the core's numbers, of which the file has nine digits
    return found


def thinned(raw: Raw) -> Raw:
    """The rows that are kept, with the impulse on the left flange of forces and impacts."""
    rows = np.unique(np.linspace(0, len(raw.t) - 1, KEPT).astype(int))
    impulse = cumulative_trapezoid(raw.c["N_LF"], raw.t, initial=0) + raw.c.get("P_LF", 0.0)
    kept = copy(raw)
    kept.c = {name: x[rows] for name, x in (raw.c | {"impulse_LF": impulse}).items()}
    kept.t = kept.c["time"]
    return kept


def says(label: str, names: Shown, raw: Any) -> bool:
    return names.of.partition(" ")[2] == label


@pytest.mark.parametrize("exercise", [2, 5])
def test_curves(exercise: int, found: list[Outcome], raws: dict[str, Raw]):
    """Four panels of five formulations."""
    figure = exercises_page(found, [exercise], f"Exercise {exercise}")
    for ax in figure.axes:
        names = {(shown(line).y, shown(line).x) for line in ax.lines}
        assert names == {(LABELS[ax.get_ylabel()], "time [s]")}
        rows = [shown(line).of for line in ax.lines if shown(line).how == "rows"]
        assert sorted(rows) == sorted(f"ex{exercise}_aw {words}" for words in ("elastic", *CHANGES))
    assert compare(raws["ex2_aw"], figure, raws, says) >= 20


def compare_level(raw: Raw, ax: Axes, line: Line2D) -> None:
    """The kinetic energy with which an exercise begins, told above it."""
    energy = line.get_ydata()[0]
    assert shown(line).y == "first KE_lat [J]" and energy == pytest.approx(raw.c["KE_lat"][0], rel=1e-8)
    assert [text.get_text() for text in ax.texts if text.get_position()[1] == energy] == [f"exercise {shown(line).of[2]}"]


def compare_shade(source: Any, ax: Axes, box: Rectangle) -> None:
    """Green below 3 %, orange below 30 %, red where it is more or no number."""
    words = shown(box).y
    share = re.fullmatch(r"(\S+) %(?: \*)?", words)
    if share:
        expected = GREEN if float(share[1]) < 3 else ORANGE if float(share[1]) < 30 else RED
    else:
        expected = GREEN if words == "the same" else RED
        assert words in ("the same", "differs") or re.fullmatch(r"\d+ (?:to|of) \d+", words), words
    assert to_hex(box.get_facecolor()) == expected, shown(box)
    middle = box.get_y() + box.get_height()/2
    inside = [text.get_text() for text in ax.texts if abs(text.get_position()[1] - middle) < 1e-6
              and box.get_x() < text.get_position()[0] < box.get_x() + box.get_width()]
    assert inside == [words]


def test_tables_and_the_work_over_the_flange(found: list[Outcome], raws: dict[str, Raw], world: World,
                                             monkeypatch: pytest.MonkeyPatch):
    """Shades, the work that lifts the wheelset, and the energies of the exercises beside it."""
    monkeypatch.chdir(world.folder)
    compared = {**COMPARED, "level": compare_level, "shade": compare_shade}
    verdicts = verdict_page(found, Path("inputs"))
    assert walk(verdicts, compared, None, raws) > 12
    *_, climb = verdicts.axes
    assert [shown(line).how for line in climb.lines] == ["rows", "level"] and climb.get_ylabel() == "work of weight and load [J]"
    assert walk(values_page(found), compared, None) >= 2
