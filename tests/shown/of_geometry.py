"""What pages of a pair of profiles show over the lateral displacement, held against the functions and the profile files."""
from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from ldbench.plots.named import Shown
from named_artists import shown
from probes import gaps, left_rail, left_wheel
from table import COLOURS, DEG, MM
from walk import Compare

FACTORS = {"": 1.0, "mm": MM, "°": DEG, "mrad": 1e3}
LABELS = {      # of axes: what they show
    "contact angle [°]": ("angle_L", "angle_R"), "rolling radius [mm]": ("radius_L", "radius_R"),
    "Δr = left − right [mm]": ("delta_r",), "equivalent conicity": ("conicity", "linearised"),
    "contact position, outward |y| [mm]": ("y_L", "-y_R"), "contact position z [mm]": ("z_L", "z_R"), "roll Φ [mrad]": ("roll",),
    "height Z [mm]": ("Z",), "contact angle γ [°]": ("angle_L", "angle_R"), "½(tan γL − tan γR)": ("tan",),
    "contact, outward |y| [mm]": ("out_L", "out_R"), "lateral displacement Y [mm]": ("Y",), "amplitude [mm]": ("amplitude",)}
KEPT = {"": "#000000", "with roll": "#000000", "level": COLOURS["left"]}     # colour by how the wheelset is kept
RAISED = 16.0       # of the wheel above its rail [mm]
Functions = Mapping[str, np.ndarray]


def value_of(functions: Functions, name: str) -> np.ndarray:
    """A function by its name, in the unit that it tells."""
    words, _, unit = name.removesuffix("]").partition(" [")
    derived = {"tan": lambda: (np.tan(functions["angle_L"]) - np.tan(functions["angle_R"]))/2,
               "out_L": lambda: functions["y_L"], "out_R": lambda: -functions["y_R"]}
    found = derived[words]() if words in derived else functions[words.removeprefix("-")]*(-1 if words[0] == "-" else 1)
    return FACTORS[unit]*np.asarray(found)


def compare_functions(functions: Functions, ax: Axes, line: Line2D) -> None:
    """At every displacement, but for gaps where a contact jumps, in its colour."""
    names = shown(line)
    for words, name in ((ax.get_ylabel(), names.y), (ax.get_xlabel(), names.x)):
        assert name.partition(" [")[0] in LABELS[words], (words, names)
    x, y = (np.asarray(data, float) for data in line.get_data())
    np.testing.assert_allclose(x, value_of(functions, names.x), rtol=1e-9, atol=1e-12)
    known, truth = np.isfinite(y), value_of(functions, names.y)
    assert known.sum() > 0.9*np.isfinite(truth).sum() > 0
    np.testing.assert_allclose(y[known], truth[known], rtol=1e-9, atol=1e-9*np.nanmax(np.abs(truth)), err_msg=str(names))
    side = re.search(r"_([LR])\b", names.y)
    if names.y != "linearised":
        assert line.get_color() == (COLOURS[{"L": "left", "R": "right"}[side[1]]] if side else KEPT[names.of]), names


def compare_reach(clearance: tuple[float, float]) -> Compare:
    """Dotted lines where the rigid-axle clearance ends; over amplitudes at both of them."""
    def compare(source: Any, ax: Axes, line: Line2D) -> None:
        left, right = (MM*reach for reach in clearance)
        at = line.get_xdata()[0]
        expected = (left, right) if ax.get_xlabel() == "amplitude [mm]" else (left, -right)
        assert any(at == pytest.approx(one, abs=1e-3) for one in expected)
        marks = sorted(one.get_xdata()[0] for one in ax.lines if shown(one).how == "mark")
        assert marks == pytest.approx(sorted(set(expected)), abs=1e-3)
    return compare


def compare_raised(wheels: Mapping[str, str], axle: float) -> Compare:
    """Outlines go through the points of the files, the wheel so far above its rail. wheels: 'aw' or 'sw' by the side."""
    def compare(source: Any, ax: Axes, drawn: Line2D | Polygon) -> None:
        body, side = shown(drawn).y.split()[:2]
        curve = (drawn.get_xydata() if isinstance(drawn, Line2D) else drawn.get_xy())/MM
        points = left_wheel(wheels[side]) if body == "wheel" else left_rail("aw")
        if body == "wheel":
            lift = curve[:, 1].min() - points[:, 1].min()
            assert lift == pytest.approx(axle + RAISED/MM, abs=1e-3)
            points = points + [0, lift]
        inside = points[(points[:, 0] > curve[:, 0].min() + 1e-3) & (points[:, 0] < curve[:, 0].max() - 1e-3)][::5]
        if body == "rail":
            inside = inside[inside[:, 1] > curve[:, 1].min() + 1e-3]
        assert len(inside) > 10 and np.abs(gaps(inside, curve)).max() < 2e-4, shown(drawn)
        assert ax.get_title(loc="left").startswith(f"{side} wheel")
    return compare


def compare_contact_line(wheels: Mapping[str, str], axle: float) -> Compare:
    """From the raised wheel to the point of the rail, outward, that the functions have at a displacement."""
    def compare(functions: Functions, ax: Axes, line: Line2D) -> None:
        y, side = re.match(r"contact at Y = (\S+) mm, (\w+)", shown(line).y).groups()
        letter, sign = {"left": ("L", 1), "right": ("R", -1)}[side]
        above, below = line.get_xydata()/MM
        truth = [np.interp(float(y)/MM, functions["Y"], factor*functions[f"{name}_{letter}"])
                 for name, factor in (("y", sign), ("z", 1))]
        turned = sign*np.interp(float(y)/MM, functions["Y"], functions["roll"]*functions[f"radius_{letter}"])
        assert below == pytest.approx(truth, abs=2e-5), shown(line)
        assert above[0] == pytest.approx(below[0] - sign*float(y)/MM - turned, abs=5e-5), shown(line)
        raised = left_wheel(wheels[side]) + [0, axle + RAISED/MM]
        assert np.abs(gaps(above[None], raised)) < 1e-3 and line.get_color() == COLOURS[side]
    return compare


def says(label: str, names: Shown, source: Any) -> bool:
    """The side, or how the wheelset is kept."""
    sided = {"left": r"_L\b", "right": r"_R\b"}
    if label in sided:
        return bool(re.search(sided[label], names.y))
    kept, _, how = label.partition(", ")
    return names.of == kept and (not how or names.y == {"EN 15302": "conicity", "harmonic": "linearised"}[how])
