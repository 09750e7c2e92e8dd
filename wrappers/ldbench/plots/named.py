"""The names of what figures show: each artist with data says which columns it shows, in which units.

A name is a sum of columns with their signs, or a quantity that follows from them, and the unit in brackets: `N_LF [kN]`,
`-y_RT [mm]`, `KE_lat+KE_vert+KE_roll [J]`, `L/V left`. The tests read every name and compare the artist with the rows of the file.
"""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

from matplotlib.artist import Artist

Named = TypeVar("Named", bound=Artist)


@dataclass(frozen=True)
class Shown:
    """What an artist shows."""
    y: str              # along the vertical axis
    x: str              # along the horizontal axis
    how: str            # 'rows', 'mean' and 'range' of rows, 'mark' of a time or a level, 'legend', 'decoration', or others
    of: str             # the run, where a figure shows several


def shows(artist: Named, y: str, x: str = "", how: str = "rows", of: str = "") -> Named:
    """Say what an artist shows; returns the artist."""
    vars(artist)["shown"] = Shown(y, x, how, of)
    return artist


def named_bars(bars: Iterable[Artist], of: Sequence[str], y: str = "", x: str = "") -> None:
    """Say what bars show, upright along y or lying along x: each the value of another thing."""
    for bar, thing in zip(bars, of, strict=True):
        shows(bar, y, x, "bar", thing)


def name(words: str, unit: str) -> str:
    """A name with its unit."""
    return f"{words} [{unit}]" if unit else words


def decoration(artist: Named) -> Named:
    """Say that an artist shows nothing; returns the artist."""
    return shows(artist, "", how="decoration")
