"""What artists show of runs, held against the rows of their column files."""
from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.quiver import Quiver

from commands import between_rows, difference
from named_artists import artists, shown
from probes import left_rail, left_wheel, turned
from raw import PAIR, Raw, flange_slope
from table import COLUMNS, KN, MM, WORDS, fits_contact, pictured
from walk import Compare, points_of

FACTORS = {"": 1.0, "m/s": 1.0, "m/s²": 1.0, "rad/s²": 1.0, "J": 1.0, "N·m": 1.0, "s": 1.0, "mm": MM, "mrad": 1e3,
           "mrad/s": 1e3, "kN": KN, "°": 180/np.pi, "kN·s": KN, "ms": 1e3}
UNITS = {column: unit for column, unit, _ in COLUMNS.values()} | {"impulse_LF": "kN·s"}
EVENTS = {"left flange": "left flange contact", "right flange": "right flange contact", "centre": "centre passage",
          "derailment": "derailment"}


def reading(raw: Raw, name: str) -> np.ndarray:
    """What a name says, from the rows of the file."""
    words, _, unit = name.removesuffix("]").partition(" [")
    if words.startswith("L/V "):
        return raw.ratio(words[4].upper())
    if since := re.fullmatch(r"time since (\w\w)(?: (\d+))?", words):
        begun = [raw.t[rows.start] for rows in raw.episodes(since[1]) if rows.start > 0]
        return FACTORS[unit]*(raw.t - (begun[int(since[2]) - 1] if since[2] else raw.start(since[1])))
    if words.startswith("time"):
        return FACTORS[unit]*raw.t*(raw.c["vY"][0] if words == "time × first vY" else 1.0)
    total = np.zeros(len(raw.t))
    for sign, column in re.findall(r"(-|\+|^)(\w+)", words):
        assert UNITS[column] == unit, (name, column)
        total += (-1 if sign == "-" else 1)*FACTORS[unit]*raw.c[column]
    return total


def same(a: float | np.ndarray, b: float | np.ndarray, size: float, rounding: float) -> bool:
    """Whether numbers are equal but for rounding, beside a size."""
    return bool(np.all(np.abs(np.subtract(a, b)) <= rounding*np.maximum(size, np.abs(b)) + 1e-300))


def compare_rows(raw: Raw, ax: Axes, line: Line2D) -> None:
    """Each point is a row."""
    t, x = reading(raw, shown(line).x), reading(raw, shown(line).y)
    drawn_t, drawn_x = (np.asarray(data, float) for data in line.get_data())
    drawn_t, drawn_x = drawn_t[np.isfinite(drawn_x)], drawn_x[np.isfinite(drawn_x)]
    if not shown(line).x.startswith(("time", "F_ext")):
        k = int(np.argmin(np.abs(t - drawn_t[0]) + np.abs(x - drawn_x[0])))
        rows = slice(k, k + len(drawn_t))
        assert same(drawn_t, t[rows], np.ptp(t), raw.rounding), shown(line)
        assert same(drawn_x, x[rows], np.ptp(x), raw.rounding), shown(line)
        return
    k = np.clip(np.searchsorted(t, drawn_t), 1, len(t) - 1)
    k -= np.abs(t[k - 1] - drawn_t) < np.abs(t[k] - drawn_t)
    # The file has times in nine digits, and the core knows when a flange touches better than that.
    assert np.abs(t[k] - drawn_t).max(initial=0) < 2e-8*np.ptp(t) + 1e-6*("since" in shown(line).x), shown(line)
    # Rows at an event are a few nanoseconds apart, or at the same time; an integral adds up the digits that the file lacks.
    near = np.array([x[np.clip(k + j, 0, len(x) - 1)] for j in (0, -1, 1)])
    apart = np.abs(near - drawn_x)/np.abs(x[np.isfinite(x)]).max(initial=1e-300)
    size, alone = 1e-6 if "impulse" in shown(line).y else 1e-8, np.minimum(t[k] - t[k - 1], np.append(t, np.inf)[k + 1] - t[k]) > 0
    assert not len(k) or (np.nanmin(apart, axis=0).max() < size and np.mean(apart[0][alone] < size) > 0.99), shown(line)


def columns_of(raw: Raw, names: Any, middle: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The rows in each column of a band, surely inside, and perhaps."""
    t, width = reading(raw, names.x), np.diff(np.sort(middle)).min()
    return [tuple(np.flatnonzero(np.abs(t - at) < (0.5 + spare)*width) for spare in (-1e-6, 1e-6)) for at in middle]


def compare_band(raw: Raw, ax: Axes, area: PolyCollection) -> None:
    """The edges of a band are the smallest and the largest row of each column."""
    x = reading(raw, shown(area).y)
    corners = np.vstack([path.vertices for path in area.get_paths()])
    middle = np.unique(corners[:, 0])
    for at, (inside, around) in zip(middle, columns_of(raw, shown(area), middle), strict=True):
        low, high = corners[corners[:, 0] == at, 1].min(), corners[corners[:, 0] == at, 1].max()
        size = raw.rounding*np.nanmax(np.abs(x))
        assert np.nanmin(x[around]) - size <= low <= np.nanmin(x[inside]) + size, shown(area)
        assert np.nanmax(x[inside]) - size <= high <= np.nanmax(x[around]) + size, shown(area)


def compare_mean(raw: Raw, ax: Axes, line: Line2D) -> None:
    """The mean over time of the rows of each column."""
    x, weight = reading(raw, shown(line).y), np.gradient(reading(raw, shown(line).x))
    middle, mean = (data[np.isfinite(line.get_ydata())] for data in line.get_data())
    known = np.isfinite(x)
    for at, one, places in zip(middle, mean, columns_of(raw, shown(line), middle), strict=True):
        inside, around = (rows[known[rows]] for rows in places)
        truth, other = (np.sum(x[rows]*weight[rows])/np.sum(weight[rows]) for rows in (inside, around))
        edge = abs(other - truth) if raw.rounding > 1e-9 else 0.0       # a row at an edge is in either column by its last digit
        assert abs(one - truth) <= edge + 0.02*np.ptp(x[inside]) + 1e-9*abs(truth), (shown(line), at)


def compare_mark(raw: Raw, ax: Axes, line: Line2D) -> None:
    """Times of events, of touch and opening; eigenfrequencies; Nadal's limits."""
    words, clock = shown(line).y, shown(line).x
    place = line.get_xdata()[0]
    if words == "eigenfrequency":
        assert min(abs(place/f - 1) for f in raw.settings("eigenfrequencies")) < 1e-5
    elif words.startswith("Nadal"):
        friction, slope = float(words.split()[1]), np.tan(flange_slope())
        assert line.get_ydata()[0] == pytest.approx((slope - friction)/(1 + friction*slope), rel=1e-5)
        note = next(text for text in ax.texts if text.get_text() == f"Nadal, friction {friction:g}")
        assert note.xy[1] == line.get_ydata()[0]
    elif words in ("touch", "opening"):
        contact = clock.split()[2]
        assert place == pytest.approx(0 if words == "touch" else 1e3*raw.impact(contact)["duration"], abs=1e-4)
    else:
        for word in words.split(", "):
            t = next(t for t, kind, _ in raw.events if kind == EVENTS[word])
            assert clock == "time [s]" and place == pytest.approx(t, abs=2e-7), word


def compare_moment(when: Callable[[Raw], int]) -> Callable[[Raw, Axes, Line2D], None]:
    def compare(raw: Raw, ax: Axes, line: Line2D) -> None:
        """A row of its own."""
        k = when(raw)
        x, y = line.get_data()
        assert (x[0], y[0]) == pytest.approx((reading(raw, shown(line).x)[k], reading(raw, shown(line).y)[k])), shown(line)
    return compare


def compare_spectrum(raw: Raw, ax: Axes, line: Line2D) -> None:
    """The amplitude of a column at the frequency of the largest one, by a Fourier sum over the rows; see also test_spectra."""
    column, unit = re.fullmatch(r"amplitude of (\w+) \[(.*)\]", shown(line).y).groups()
    assert UNITS[column] == unit
    f, x = line.get_data()
    even = np.linspace(raw.t[0], raw.t[-1], len(raw.t))
    values = np.interp(even, raw.t, FACTORS[unit]*raw.c[column])
    window = np.hanning(len(even))
    k = int(x.argmax())
    # Frequencies are multiples of one over the number of rows times their distance.
    wave = np.exp(-2j*np.pi*f[k]*(even - even[0]))
    assert x[k] == pytest.approx(2*np.abs(np.sum(wave*window*(values - values.mean())))/window.sum(), rel=1e-6)


def outline_of(raw: Raw, words: str, k: int) -> np.ndarray:
    """The outline of a wheel at a row, or of a rail, from the profile file [mm]."""
    body, side = words.split()[:2]
    letter, mirror = side[0].upper(), {"left": 1, "right": -1}[side]
    points = left_rail(PAIR[letter])
    if body == "wheel":
        points = turned(left_wheel(PAIR[letter]), mirror*raw.c["roll"][k]) + [
            mirror*raw.c["Y"][k], raw.setting("axle_height") + raw.c["Z"][k]]
    return MM*points*[mirror, 1]


def row_of(raw: Raw, ax: Axes) -> int:
    """The row of a cross-section, by the time in its words or in those of its neighbour."""
    figure = ax.get_figure()
    place = [one for one in figure.axes if one.get_xlabel() == "y [mm]"].index(ax)
    return pictured(raw)[place//2]


def compare_outline(raw: Raw, ax: Axes, drawn: Artist) -> None:
    """The drawn outline goes through the points of the file."""
    points = outline_of(raw, shown(drawn).y, row_of(raw, ax))
    curve = drawn.get_xy() if isinstance(drawn, Patch) else drawn.get_xydata()
    left, right = sorted(ax.get_xlim())
    seen = points[(points[:, 0] > left) & (points[:, 0] < right) & (points[:, 1] > -40) & (points[:, 1] < 40)]
    apart = [np.hypot(*(curve - point).T).min() for point in seen[::7]]
    assert len(apart) > 5 and np.median(apart) < 0.2 and max(apart) < 1.0, shown(drawn)


def compare_point(raw: Raw, ax: Axes, drawn: Line2D) -> None:
    """A contact point at the row of the picture."""
    compare_moment(lambda raw: row_of(raw, ax))(raw, ax, drawn)


def compare_arrow(raw: Raw, ax: Axes, arrow: Quiver) -> None:
    """The force of a contact at its point, the longest one of the moment 40 mm."""
    k = row_of(raw, ax)
    contact = shown(arrow).y[-2:]
    assert (shown(arrow).y, shown(arrow).x) == (f"Fz_{contact}", f"Fy_{contact}")
    longest = max(raw.c[f"N_{c}"][k] for c in WORDS)
    assert (arrow.U[0], arrow.V[0]) == pytest.approx([40*raw.c[f"{name}_{contact}"][k]/longest for name in ("Fy", "Fz")])
    assert arrow.get_offsets()[0] == pytest.approx([MM*raw.c[f"{name}_{contact}"][k] for name in "yz"])
    assert (arrow.angles, arrow.scale_units, arrow.scale) == ("xy", "xy", 1)


def compare_solved(raw: Raw, ax: Axes, line: Line2D) -> None:
    """Pressure and area go with the force and the overlap of the contact at its peak."""
    others, k = [one for _, one in artists(ax.get_figure()) if shown(one).how == "solved"], raw.first_peak("LF")
    pressure, area = sorted(others, key=lambda one: shown(one).y, reverse=True)
    assert (shown(pressure).y, shown(area).y) == ("pressure LF [GPa]", "area LF [mm²]")
    t = reading(raw, shown(line).x)
    at = int(np.argmin(np.abs(line.get_xdata() - t[k])))
    assert line.get_xdata()[at] == pytest.approx(t[k], abs=1e-6)
    fits_contact(raw, "LF", k, 1e9*pressure.get_ydata()[at], 1e-6*area.get_ydata()[at])


COMPARED: Mapping[str, Callable[[Raw, Axes, Any], None]] = {
    "rows": compare_rows, "range": compare_band, "mean": compare_mean, "mark": compare_mark, "spectrum": compare_spectrum,
    "outline": compare_outline, "point": compare_point, "arrow": compare_arrow, "solved": compare_solved,
    "start": compare_moment(lambda raw: 0), "end of the run": compare_moment(lambda raw: -1),
    **{f"{words} touches": compare_moment(lambda raw, c=c: int(np.abs(raw.t - raw.start(c)).argmin()))
       for c, words in WORDS.items()}}


def whole_range(raw: Raw, figure: Figure, others: Mapping[str, Raw] | None = None) -> None:
    """What curves and bands show of a quantity between the ends of the axis is all that the file has there."""
    for ax in figure.axes:
        for y, clock, of in {(shown(one).y, shown(one).x, shown(one).of) for one in ax.get_children()
                             if "shown" in vars(one) and shown(one).how == "rows"}:
            own = [one for one in (*ax.lines, *ax.collections) if (shown(one).y, shown(one).x, shown(one).of) == (y, clock, of)]
            if not clock.startswith("time") or all(line.get_linestyle() == "None" for line in own if isinstance(line, Line2D)):
                continue
            t, x = (reading((others or {}).get(of, raw), name) for name in (clock, y))
            there = x[(t >= ax.get_xlim()[0]) & (t <= ax.get_xlim()[1]) & np.isfinite(x)]
            drawn = np.concatenate([points_of(one)[:, 1] for one in own])
            drawn = drawn[np.isfinite(drawn)]
            if there.size:
                size = 1e-6*np.ptp(x[np.isfinite(x)])
                assert drawn.min() <= there.min() + size and drawn.max() >= there.max() - size, (y, clock, of)


def compared_with(reference: Raw, *others: Raw) -> dict[str, Compare]:
    """Curves of files that are compared as long as all have rows: overlays between rows, and differences from the reference."""
    until = min(raw.t[-1] for raw in (reference, *others))

    def compare(of: Callable[[Raw, Raw, str], np.ndarray]) -> Compare:
        def compared(raw: Raw, ax: Axes, line: Line2D) -> None:
            column, _, unit = shown(line).y.removesuffix("]").partition(" [")
            assert UNITS[column] == unit and shown(line).x == "time [s]"
            t, x = line.get_data()
            k = np.searchsorted(reference.t, t*(1 - 1e-9))
            np.testing.assert_allclose(t, reference.t[k], rtol=1e-8, atol=1e-12)
            truth = FACTORS[unit]*of(reference, raw, column)[reference.t <= until*(1 + 1e-9)]
            size = 1e-8*FACTORS[unit]*np.nanmax(np.abs(reference.c[column]), initial=1e-300)
            np.testing.assert_allclose(x, truth[k], rtol=1e-6, atol=size, err_msg=str(shown(line)))
            assert not np.isfinite(truth).any() or (np.nanmin(x), np.nanmax(x)) == pytest.approx(
                (np.nanmin(truth), np.nanmax(truth)), rel=1e-6, abs=size)
        return compared

    return {**COMPARED, "between rows": compare(between_rows), "difference": compare(difference)}
