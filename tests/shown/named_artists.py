"""What the artists of a figure say that they show."""
from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.text import Text

from ldbench.plots.named import Shown


def shown(artist: Artist) -> Shown:
    """What an artist says that it shows."""
    return vars(artist)["shown"]


def all_named(figure: Figure) -> bool:
    """Whether each artist with data says what it shows."""
    return all("shown" in vars(one) for _, one in artists(figure))


def artists(figure: Figure) -> list[tuple[Axes, Artist]]:
    """All artists with data, each with its axes; words have tests of their own."""
    found = []
    for ax in figure.axes:
        frame = {ax.patch, ax.xaxis, ax.yaxis, ax.get_legend(), *ax.spines.values()}
        found += [(ax, one) for one in ax.get_children() if ax.get_visible() and one not in frame and not isinstance(one, Text)
                  and not (isinstance(one, LineCollection) and not one.get_segments())]      # dividers of a colour bar
    others = set(figure.get_children()) - {figure.patch, *figure.axes, *figure.legends, *figure.texts}
    assert not others, "artists beside the panels"
    return found


def check_pictures_of_pressure(figure: Figure, contact: str, hertz: tuple[float, float, float], largest: float) -> None:
    """Hertz's ellipse lies along the rail as long as it is printed [mm, mm, MPa]; cuts and colours have the largest pressure."""
    assert all_named(figure)
    found: dict[str, list[Any]] = {}
    for _, one in artists(figure):
        found.setdefault(shown(one).how, []).append(one)
    ellipse, = found["ellipse"]
    assert (ellipse.width, ellipse.height, ellipse.angle) == (*(pytest.approx(size, abs=0.006) for size in hertz[:2]), 0)
    assert (ellipse.axes.get_xlabel(), ellipse.axes.get_ylabel()) == ("x along the rail [mm]", "s [mm]")
    for name, label, size in ("x [mm]", "along the rail", hertz[0]), ("s [mm]", "along the profile", hertz[1]):
        cut, = (one for one in found["cut"] if shown(one).x == name)
        smooth, = (one for one in found["Hertz"] if shown(one).x == name)
        assert cut.get_label() == label and cut.get_color() == smooth.get_color()
        assert cut.get_ydata().max() == pytest.approx(largest, rel=0.05)
        assert smooth.get_ydata().max() == pytest.approx(hertz[2], rel=1e-3)
        assert np.ptp(smooth.get_xdata()) == pytest.approx(size, abs=0.006)
        assert np.ptp(cut.get_xdata()[cut.get_ydata() > 0]) == pytest.approx(size, rel=0.5)
    assert found["elements"][0].get_array().max() == pytest.approx(found["cut"][0].get_ydata().max())
    assert {shown(one).y for how in ("ellipse", "cut", "Hertz", "elements") for one in found[how]} == {
        f"pressure {contact} [MPa]", f"Hertz's ellipse {contact} [mm]"}
