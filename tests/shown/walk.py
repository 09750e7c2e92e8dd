"""The walk over all artists of a figure: each says what it shows and shows that, and looks like its entry in the legend."""
from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from ldbench.plots.named import Shown
from named_artists import artists, shown
from table import AXES, COLOURS, CURVES, WORDS

Compare = Callable[[Any, Axes, Any], None]      # of a source of numbers, the axes and an artist
Says = Callable[[str, Shown, Any], bool]        # whether a label fits what an artist shows of a source
# What has no unit, or that of the other axis.
UNITLESS = "decoration", "legend", "arrow", "outline", "point", "mark", "shade", "body", "force", "place", "scale"


def label_of(artist: Artist) -> str:
    """The words of an artist in a legend, of a bar those of its row of bars; '' of none."""
    own = next((row for row in artist.axes.containers if artist in row.get_children()), artist).get_label()
    return "" if str(own or "_").startswith("_") else str(own)


def walk(figure: Figure, compared: Mapping[str, Compare], source: Any, others: Mapping[str, Any] | None = None,
         says: Says | None = None, label: Callable[[Artist], str] = label_of, cut: Sequence[str] = ()) -> int:
    """Compare all artists of a page; how many there are. others: sources by the names of what artists are of. label: the words of
    an artist in legends. cut: labels of axes whose curves may have points that nobody sees; "outlines"; "legends" that are no list
    of looks."""
    found = artists(figure)
    for ax, one in found:
        assert "shown" in vars(one), f"nobody says what {one} shows"
        names = shown(one)
        if names.how != "decoration":
            compared[names.how](own := (others or {}).get(names.of, source), ax, one)
            words = label(one)
            assert says is None or not words or says(words, names, own), (words, names)
    if "legends" not in cut:
        check_legends(figure, label)
        check_units(figure)
    check_axes(figure)
    check_inside(figure, cut)
    return len(found)


def points_of(artist: Artist) -> np.ndarray:
    """The points of a curve, the corners of a band or of a bar."""
    if isinstance(artist, Line2D):
        return np.asarray(artist.get_xydata(), float)
    if isinstance(artist, Rectangle):
        return np.array([artist.get_xy(), np.add(artist.get_xy(), [artist.get_width(), artist.get_height()])])
    return np.vstack([path.vertices for path in artist.get_paths()] or [np.zeros((0, 2))])


def check_inside(figure: Figure, cut: Sequence[str]) -> None:
    """Every finite point of a curve, a band or a bar lies inside its axes, of a curve over time between the ends of its window;
    the base of a bar is on no logarithmic axis."""
    for ax, one in artists(figure):
        names, words = shown(one), " ".join(ax.get_ylabel().split())
        drawn = isinstance(one, PolyCollection | Rectangle) or (isinstance(one, Line2D) and one.get_transform() == ax.transData)
        if not drawn or not ax.axison or words in cut or (names.how == "outline" and "outlines" in cut):
            continue
        points = points_of(one)
        points = points[np.isfinite(points).all(axis=1)]
        for k, (ends, scale) in enumerate(((ax.get_xlim(), ax.get_xscale()), (ax.get_ylim(), ax.get_yscale()))):
            low, high = sorted(ends)
            inside = (points[:, k] >= low - 1e-6*(high - low)) & (points[:, k] <= high + 1e-6*(high - low))
            window = k == 0 and names.x.startswith("time")
            base = isinstance(one, Rectangle) and scale == "log"
            seen = inside | (base & (points[:, k] == 0))
            assert window or seen.all(), f"{names}: points beyond {low:g} to {high:g} of {words!r}"
            points = points[inside]


def check_axes(figure: Figure) -> None:
    """The words of axes say what they show, and so do those of a curve in a legend of its own axes."""
    for ax, one in artists(figure):
        names = shown(one)
        if names.how in UNITLESS:
            continue
        for words, name in ((ax.get_ylabel(), names.y), (ax.get_xlabel(), names.x)):
            words = " ".join(words.split())
            if name and words in AXES:
                assert name.startswith(AXES[words]), (words, names)
                expected = CURVES.get(words, {})
                assert label_of(one) not in expected or names.how != "rows" or expected[label_of(one)] == name, (words, names)


def check_units(figure: Figure) -> None:
    """The words of axes, or of the first axes in their row or column, or of the page, name the unit of what they show."""
    page = " ".join(text.get_text() for text in figure.texts)
    for ax, one in artists(figure):
        names, place = shown(one), ax.get_position()
        if names.how in UNITLESS:
            continue
        beside = [other for other in figure.axes if abs(other.get_position().y0 - place.y0) < 1e-6]
        below = [other for other in figure.axes if abs(other.get_position().x0 - place.x0) < 1e-6]
        for name, words in ((names.y, [ax.get_ylabel(), ax.get_title(loc="left"), *(other.get_ylabel() for other in beside), page]),
                            (names.x, [ax.get_xlabel(), *(other.get_xlabel() for other in below), page])):
            told = re.findall(r"\[(.*?)\]", next((some for k, some in enumerate(words) if "[" in some or (some and not k)), "[]"))
            unit = name.partition(" [")[2].removesuffix("]")
            assert not name or unit in (told or [""]), (names, words)


def look(artist: Artist) -> tuple[Any, ...]:
    """Colour, dashes and marker."""
    if isinstance(artist, Line2D):
        return to_rgba(artist.get_color()), str(artist._unscaled_dash_pattern), (
            (artist.get_marker(), to_rgba(artist.get_markerfacecolor())) if artist.get_ls() == "None" else "")
    return to_rgba(artist.get_facecolor()[0] if isinstance(artist, Collection) else artist.get_facecolor()), "", ""


def check_legends(figure: Figure, label: Callable[[Artist], str] = label_of) -> None:
    """Each entry looks like the curves that have its words; two entries differ; bands have the colours of their curves."""
    curves = [one for _, one in artists(figure) if label(one) and shown(one).how != "range"]
    for legend in (*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())):
        own = [one for one in curves if legend.axes is None or one.axes is legend.axes]
        entries = {text.get_text(): look(handle) for handle, text in zip(legend.legend_handles, legend.texts, strict=True)}
        assert len(set(entries.values())) == len(entries), "two entries look alike"
        for words, seen in entries.items():
            assert not words.startswith("_"), "an entry without words"
            looks = {look(one) for one in own if label(one) == words}
            assert looks == {seen}, (words, looks, seen)
    for ax, one in artists(figure):
        if shown(one).how in ("rows", "range", "mean", "arrow", "point", "solved"):
            own = set(re.findall(r"_([LR][TF])\b", shown(one).y))
            side = next((c for c in COLOURS if re.search(rf"L/V {c}|elastic_{c[0].upper()}\b", shown(one).y)), "")
            colour = one.get_color() if isinstance(one, Line2D) else one.get_facecolor()[0]
            sided = not shown(one).of or one.get_label() in WORDS.values() or shown(one).how in ("arrow", "point")
            if sided and (own or side) and to_rgba(colour)[:3] != (0, 0, 0) and "+PE" not in shown(one).y:
                expected = COLOURS[own.pop() if len(own) == 1 else side or {"L": "left", "R": "right"}[own.pop()[0]]]
                assert to_rgba(colour)[:3] == to_rgba(expected)[:3], shown(one)
        if shown(one).how in ("range", "mean"):
            curve = next(line for line in ax.lines if shown(line).how == "rows" and
                         (shown(line).y, shown(line).of) == (shown(one).y, shown(one).of))
            colour = one.get_color() if isinstance(one, Line2D) else one.get_facecolor()[0]
            assert to_rgba(colour)[:3] == to_rgba(curve.get_color())[:3], shown(one)
