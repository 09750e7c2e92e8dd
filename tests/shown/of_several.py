"""What pages of several runs show, of the abstract, of formulations and of the study, held against the rows of column files."""
from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_hex
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from commands import rms_of, study
from ldbench.plots.named import Shown
from named_artists import shown
from of_runs import COMPARED, FACTORS, reading
from raw import Raw, mean_square
from specimen import World
from table import CONTACTS, ELASTIC, KINETIC

PAIRS = {"aw": "actual profiles (left), simplified profiles (right)", "sw": "simplified profiles"}
SHARES = {"lateral": "KE_lat", "vertical": "KE_vert", "roll": "KE_roll", "elastic and potential": "the rest"}
POWERS = {"first peak": 6/5, "first duration": -1/5, "first impulse": 1}
STEPS = 130         # of the lateral force
GREEN, ORANGE, RED = "#bfe5d6", "#fce3b4", "#f6c9b0"
STUDY_WORDS = {"Y": "lateral displacement Y", "N_LF": "normal force, left flange"}


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


def of_pair_or_speed(label: str, names: Shown, raw: Any) -> bool:
    """Whether a curve is what the legend says: a speed, a contact, an energy, a pair."""
    if speed := re.fullmatch(r"(\S+) m/s", label):
        return bool(abs(float(speed[1]) - raw.c["vY"][0]) < 1e-9)
    if label in CONTACTS:
        return names.y.startswith(f"Fz_{CONTACTS[label]} ")
    if names.how == "bar":
        return names.x == f"share of {SHARES[label]} [%]"
    if names.how == "power":
        return label in ("slope 6/5", "Hertz")
    return (KINETIC | ELASTIC).get(label) == names.y or label in (names.of, PAIRS.get(names.of[-2:]))


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


def compare_rms(world: World, ax: Axes, bar: Rectangle) -> None:
    """The root mean square of a difference over that of the reference, above the name of the case."""
    (fine, *variants), _, _ = study(world)
    column, words = re.fullmatch(r"rms of (\w+), (.*)", shown(bar).y).groups()
    case, which = shown(bar).of.split()
    one = variants[["law", "step"].index(which)]
    assert ax.get_title(loc="left") == f"{STUDY_WORDS[column]}, {words}"
    until = fine.t <= one.t[-1]
    size = np.sqrt(mean_square(fine.t[until], fine.c[column][until]))
    assert bar.get_height() == pytest.approx(rms_of(fine, one, column, "first" in words)/size, rel=0.01)
    below = ax.get_figure().axes[-1].get_xticklabels()
    assert [label.get_text() for label in below if label.get_position()[0] == round(bar.get_x() + bar.get_width()/2)] == [case]
