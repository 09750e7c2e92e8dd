"""What pages of profiles and of their pairs show, held against the geometry functions and the profile files."""
from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

import ldbench
from ldbench.plots.named import Shown
from named_artists import shown
from probes import gaps, left_rail, left_wheel, tangent_angles
from table import COLOURS, DEG, MM
from walk import Compare

FACTORS = {"": 1.0, "mm": MM, "°": DEG, "mrad": 1e3}
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


def of_side(label: str, names: Shown, source: Any) -> bool:
    """The side, or how the wheelset is kept."""
    sided = {"left": r"_L\b", "right": r"_R\b"}
    if label in sided:
        return bool(re.search(sided[label], names.y))
    kept, _, how = label.partition(", ")
    return names.of == kept and (not how or names.y == {"EN 15302": "conicity", "harmonic": "linearised"}[how])


def compare_points(points: np.ndarray, ax: Axes, dots: Line2D) -> None:
    """The points of the file, or how far they are from the curve that is drawn above."""
    assert dots.get_xdata() == pytest.approx(MM*points[:, 0], abs=1e-9)
    if shown(dots).y == "z [mm]":
        assert dots.get_ydata() == pytest.approx(MM*points[:, 1], abs=1e-9)
    else:
        shape, = (one for one in ax.get_figure().axes if one.get_title(loc="left") == shown(dots).of)
        lines = [line for line in shape.lines if shown(line).how.startswith("part ")]
        y, z = np.nanmax([line.get_xdata() for line in lines if len(line.get_xdata())], axis=0), lines[0].get_ydata()
        away = 1e3*gaps(MM*points, np.column_stack([y, z])[np.isfinite(y)])
        assert ax.get_ylabel() == "distance [µm]" and np.median(np.abs(np.abs(away) - np.abs(dots.get_ydata()))) < 0.2


def compare_curve(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """Angle and curvature of the curve through the points, beside those of the polyline of the file."""
    angle = np.unwrap(tangent_angles(points))
    along = np.hypot(*np.gradient(points, axis=0).T)
    words, truth = {"tangent angle [°]": ("tangent angle [°]", np.degrees(angle)),
                    "curvature [1/m]": ("curvature [1/m]", np.gradient(angle)/along)}[shown(line).y]
    assert ax.get_ylabel() == words and shown(line).x == "y [mm]"
    y, x = (np.asarray(data, float) for data in line.get_data())
    near = np.array([np.abs(x[np.argsort(np.abs(y - MM*point))[:9]] - value).min() for point, value in
                     zip(points[5:-5:9, 0], truth[5:-5:9], strict=True)])
    assert np.median(near) < 0.02*np.percentile(np.abs(truth), 90), shown(line)


def compare_part(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """On the points of the file."""
    curve = line.get_xydata()[np.isfinite(line.get_xdata())]
    assert np.abs(gaps(curve/MM, points)).max() < 1e-4, shown(line)


def compare_mark(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """70 mm from the back of the wheel."""
    assert shown(line).y == "tape circle" and set(line.get_xdata()) == {70.0}


def compare_gauge(points: np.ndarray, ax: Axes, line: Line2D) -> None:
    """On the side of the rail's head, 14 mm below its top or as deep as the case says."""
    point, = line.get_xydata()
    assert np.abs(gaps(line.get_xydata()/MM, points)).max() < 1e-4
    assert MM*points[:, 1].max() - point[1] == pytest.approx(MM*ldbench.Case().gauge_depth, abs=0.1)


class OfProfiles(dict[str, Compare]):
    """By how artists show a profile; a part of it and a curve have names of their own."""

    def __missing__(self, how: str) -> Compare:
        return compare_part if how.startswith("part ") else compare_curve


OF_PROFILES = OfProfiles({"points": compare_points, "end of a zone": compare_part, "mark": compare_mark,
                          "gauge point": compare_gauge})
