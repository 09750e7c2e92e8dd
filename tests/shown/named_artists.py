"""What the artists of a figure say that they show."""
from __future__ import annotations

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
