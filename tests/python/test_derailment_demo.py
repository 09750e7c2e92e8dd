"""The page of the demonstration of ensembles, drawn from invented results."""
from __future__ import annotations

import numpy as np
import pytest

from ldbench.plots.style import ldbench_style
from ldbench.report import derailment_demo as demo

xr = pytest.importorskip("xarray")
MASSES, GAUGES, ANGLES = np.linspace(1000, 3000, 5), (1.430, 1.435, 1.440), (45.0, 75.0)


def invented() -> tuple[xr.Dataset, xr.Dataset]:
    """Forces that grow with the mass, and derailment at the weight."""
    force = 1e3*MASSES*np.ones((3, 1))*np.array([[1.0], [1.1], [1.2]])
    impact = xr.Dataset({"peak_N_LF": (("gauge", "mass"), force), "peak_N_RF": (("gauge", "mass"), force/2)},
                        {"gauge": list(GAUGES), "mass": MASSES})
    mass, angle = np.tile(MASSES, 2), np.repeat(ANGLES, 5)
    weight = 9.81*mass + demo.Case.exercise(5).vertical_load
    place = {name: (("member", "row"), np.full((10, 2), x)) for name, x in (
        ("Y", 0.01), ("Z", 0.0), ("y_LF", 0.73), ("z_LF", -0.01))}
    ramp = xr.Dataset({"mass": ("member", mass), "flange_angle": ("member", angle), "limit_load": ("member", 0.99*weight),
                       "axle_height": ("member", np.full(10, 0.457)),
                       "event_force": (("member", "kind", "occurrence"), weight[:, None, None]), **place},
                      {"kind": ["derailment"], "occurrence": [1]})
    return impact, ramp


def test_the_page_has_units_scales_and_lines_of_all_gauges():
    with ldbench_style():
        figure = demo.plot(*invented())
    left, right, colours = figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("mass of the wheelset [kg]", "peak normal force [kN]")
    assert right.get_xlabel() == "steepest angle γ of the flange [°]" and colours.get_ylabel() == "mass of the wheelset [kg]"
    drawn = {line.get_label(): line for line in left.get_lines()}
    for k, gauge in enumerate(GAUGES):
        np.testing.assert_allclose(drawn[f"gauge {1e3*gauge:.1f} mm"].get_ydata(), (1 + 0.1*k)*MASSES)
    np.testing.assert_allclose(right.collections[0].get_offsets()[:, 1], 1.0)
    assert "rigid: climbs, or overturns at b/h = 1.542" in [text.get_text() for text in right.get_legend().get_texts()]
    assert "exercise 3" in figure.texts[2].get_text() and figure.get_size_inches() == pytest.approx((11.69, 8.27))
