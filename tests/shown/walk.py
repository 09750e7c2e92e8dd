"""The walk over all artists of a figure: each says what it shows and shows that, and looks like its entry in the legend."""
from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.quiver import Quiver

from ldbench.plots.named import Shown
from named_artists import artists, shown
from table import COLOURS, WORDS

Compare = Callable[[Any, Axes, Any], None]      # of a source of numbers, the axes and an artist
Says = Callable[[str, Shown, Any], bool]        # whether a label fits what an artist shows of a source
# What has no unit, or that of the other axis.
UNITLESS = "decoration", "legend", "arrow", "outline", "point", "mark", "shade", "body", "force", "place", "scale"


def label_of(artist: Artist) -> str:
    """The words of an artist in a legend, of a bar those of its row of bars; '' of none."""
    own = next((row for row in artist.axes.containers if artist in row.get_children()), artist).get_label()
    return "" if str(own or "_").startswith("_") else str(own)


def walk(figure: Figure, compared: Mapping[str, Compare], source: Any, others: Mapping[str, Any] | None = None,
         says: Says | None = None, label: Callable[[Artist], str] = label_of) -> int:
    """Compare all artists of a page; how many there are. others: sources by the names of what artists are of. label: the words of
    an artist in legends."""
    found = artists(figure)
    for ax, one in found:
        assert "shown" in vars(one), f"nobody says what {one} shows"
        names = shown(one)
        if names.how != "decoration":
            compared[names.how](own := (others or {}).get(names.of, source), ax, one)
            words = label(one)
            assert says is None or not words or says(words, names, own), (words, names)
    check_legends(figure, label)
    check_units(figure)
    return len(found)


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


def check_labels(ax: Axes, expected: Mapping[str, str], words: str) -> None:
    """Each curve shows what its words say, under an axis of its unit."""
    for one in (*ax.lines, *ax.collections):
        if shown(one).how in ("rows", "range", "mean", "solved", "spectrum") and not isinstance(one, Quiver):
            label = "" if one.get_label().startswith("_") else one.get_label()
            if shown(one).how == "rows" and label and "" not in expected:
                assert expected[label] == shown(one).y, (words, label)
            assert shown(one).y in expected.values(), (words, shown(one))
