"""The figures of the abstract and the pages of several runs: every artist says what it shows, and shows that."""
from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from invented import invented_run
from ldbench.plots.figures import contact_figure, derailment_figure, impact_figure, motion_figure, overview_figures
from ldbench.plots.named import Shown
from ldbench.plots.style import ldbench_style
from named_artists import shown
from of_runs import COMPARED, FACTORS, compare, reading
from raw import Raw
from specimen import World
from table import CONTACTS, ELASTIC, KINETIC
from walk import walk

PAIRS = {"aw": "actual profiles (left), simplified profiles (right)", "sw": "simplified profiles"}
SHARES = {"lateral": "KE_lat", "vertical": "KE_vert", "roll": "KE_roll", "elastic and potential": "the rest"}
POWERS = {"first peak": 6/5, "first duration": -1/5, "first impulse": 1}
STEPS = 130         # of the lateral force
LABELS = {          # of axes, and what they show
    "Y [mm]": "Y", "initial velocity × time [mm]": "time × first vY", "N of the left flange [kN]": "N_LF",
    "time since the flange touched [ms]": "time since LF", "lateral velocity [m/s]": "first vY",
    "first peak [kN]": "first peak of N_LF",
    "lateral force [kN]": "F_ext", "vertical force [kN]": "Fz_", "initial lateral velocity [m/s]": "first vY",
    "peak N [kN]": "first peak of N_LF", "duration [ms]": "first duration of N_LF", "impulse ∫N dt [kN·s]": "first impulse of N_LF",
    "lateral velocity after / before, reversed": "rebound of N_LF", "time since the touch [ms]": "time since LF",
    "share of the kinetic energy before the contact [%]": "share of ", "y [mm]": ""}


@pytest.fixture(autouse=True)
def styled() -> Iterator[None]:
    with ldbench_style():
        yield


@pytest.fixture(scope="module")
def runs(world: World) -> dict[str, Any]:
    """Exercises 2 and 3 with one pair and exercise 2 with another one, all of which differ."""
    faster = world.run("ex3_aw")
    told = {group: settings for group, settings in faster._comments.settings.items() if group != "profiles"}
    return {"ex2_aw": world.run("ex2_aw"), "ex3_aw": faster, "ex2_sw": invented_run(
        faster.data, faster.file, "ex2_sw", replace(faster._comments, settings=told), faster.case)}


@pytest.fixture(scope="module")
def raws(world: World) -> dict[str, Raw]:
    return {"ex2_aw": world.thrown, "ex3_aw": world.faster, "ex2_sw": world.faster, "ex5_aw": world.pushed}


def of_pair(raws: Mapping[str, Raw], pair: str) -> list[Raw]:
    """The runs of exercises 1 to 4 of a pair, by its letters or words."""
    return [raw for name, raw in raws.items() if pair in (name[-2:], PAIRS[name[-2:]]) and name[2] != "5"]


def rebound(raw: Raw) -> float:
    return -raw.c["vY"][raw.first("LF").stop - 1]/raw.c["vY"][0]


def of_each(raws: Mapping[str, Raw], name: str, pair: str) -> np.ndarray:
    """A number of each run of a pair."""
    words, _, unit = name.removesuffix("]").partition(" [")
    if words == "first vY":
        return np.array([raw.c["vY"][0] for raw in of_pair(raws, pair)])
    key = words.removeprefix("first ").removesuffix(" of N_LF")
    return FACTORS[unit]*np.array([rebound(raw) if key == "rebound" else raw.impact("LF")[key] for raw in of_pair(raws, pair)])


def compare_runs(raws: Mapping[str, Raw], ax: Axes, dots: Line2D) -> None:
    """A dot for each run of a pair."""
    names = shown(dots)
    for drawn, name in zip(dots.get_data(), (names.x, names.y), strict=True):
        assert drawn == pytest.approx(of_each(raws, name, names.of), rel=1e-6), names


def compare_power(raws: Mapping[str, Raw], ax: Axes, slope: Line2D) -> None:
    """Through the first run of the pair, with the power of Hertz's impact, from the slowest to the fastest run."""
    names = shown(slope)
    x, y = slope.get_data()
    speeds, values = (of_each(raws, name, names.of) for name in (names.x, names.y))
    assert (x.min(), x.max()) == pytest.approx((speeds.min(), speeds.max()))
    assert y == pytest.approx(values[0]*(x/speeds[0])**POWERS[names.y.partition(" of ")[0]], rel=1e-6)


def steps_of(raw: Raw, names: Shown) -> Iterator[tuple[float, np.ndarray]]:
    """Mean of the force and the values in each interval of it, until the last second."""
    rows = raw.t < raw.t[-1] - 1
    force, x = reading(raw, names.x)[rows], reading(raw, names.y)[rows]
    edges = np.linspace(force[0], force[-1], STEPS + 1)
    for k in range(STEPS):
        own = (force >= edges[k]) & (force < edges[k + 1]) | ((k == STEPS - 1) & (force >= edges[k]))
        if own.any():
            yield force[own].mean(), x[own]


def compare_steps(raw: Raw, ax: Axes, drawn: Line2D | PolyCollection) -> None:
    """The mean of each interval, or its fifth and 95th of hundred parts."""
    told = [(at, x.mean(), *np.percentile(x, (5, 95))) for at, x in steps_of(raw, shown(drawn))]
    if isinstance(drawn, Line2D):
        assert np.array(drawn.get_data()).T == pytest.approx(np.array([one[:2] for one in told]), rel=1e-9, abs=1e-9)
        return
    corners = np.vstack([path.vertices for path in drawn.get_paths()])
    for at, _, low, high in told:
        own = corners[np.abs(corners[:, 0] - at) < 1e-9, 1]
        assert (own.min(), own.max()) == pytest.approx((low, high), rel=1e-9, abs=1e-9)


def compare_bar(raw: Raw, ax: Axes, bar: Rectangle) -> None:
    """Beside the name of its run, from the end of the bar before it; as long as its share."""
    words, parts = shown(bar).x.removeprefix("share of ").removesuffix(" [%]"), list(SHARES.values())
    one = raw.impact("LF")
    whole = sum(one[f"{part}_before"] for part in ("lat", "vert", "roll"))
    ends = np.cumsum([0, *(100*one[f"{part}_after"]/whole for part in ("lat", "vert", "roll"))]).tolist() + [100.0]
    k = parts.index(words)
    assert (bar.get_x(), bar.get_x() + bar.get_width()) == pytest.approx(tuple(ends[k:k + 2]))
    labels = {label.get_text(): at for at, label in zip(ax.get_yticks(), ax.get_yticklabels(), strict=True)}
    assert bar.get_y() + bar.get_height()/2 == pytest.approx(labels[shown(bar).of])


OF_RUNS = {**COMPARED, "runs": compare_runs, "power": compare_power, "percentiles": compare_steps,
           "mean of steps": compare_steps, "bar": compare_bar}


def says(label: str, names: Shown, raw: Any) -> bool:
    """Whether a curve is what the legend says: a speed, a contact, an energy, a pair."""
    if speed := re.fullmatch(r"(\S+) m/s", label):
        return bool(abs(float(speed[1]) - raw.c["vY"][0]) < 1e-9)
    if label in CONTACTS:
        return names.y.startswith(f"Fz_{CONTACTS[label]} ")
    if names.how == "bar":
        return names.x == f"share of {SHARES[label]} [%]"
    if names.how == "power":
        return label in ("slope 6/5", "Hertz")
    return (KINETIC | ELASTIC).get(label) == names.y or label in (names.of, PAIRS.get(names.of))


def check_axes(figure: Figure) -> None:
    """Each axis says what it shows."""
    for ax in figure.axes:
        for artist in (*ax.lines, *ax.patches):
            names = shown(artist)
            for words, name in ((ax.get_xlabel(), names.x), (ax.get_ylabel(), names.y)):
                assert not words or name.startswith(LABELS[words]), (words, names)


def check(figure: Figure, raws: Mapping[str, Raw]) -> int:
    check_axes(figure)
    return walk(figure, OF_RUNS, raws, raws, says)


def test_figures_of_the_abstract(world: World, runs: dict[str, Any], raws: dict[str, Raw]):
    """Motions, impacts, the ramp, the contact with its energies: a panel or a look for each pair."""
    counts = [check(figure(list(runs.values())), raws) for figure in (motion_figure, impact_figure, contact_figure)]
    ramp = derailment_figure([world.run("ex5_aw")])
    assert check(ramp, raws) == 6 and ramp.axes[0].get_ylabel() == "vertical force [kN]"
    assert counts[0] == 3 and counts[1] == 6 and counts[2] > 10


def test_pages_of_several_runs(world: World, runs: dict[str, Any], raws: dict[str, Raw]):
    (_, beside), (_, contacts) = overview_figures(list(runs.values()))
    assert compare(world.thrown, beside, raws) == 15
    assert check(contacts, raws) == 3*4 + 2*4 + 3
