"""No drawn thing without a named quantity: every artist with data of the pages says what it shows, and shows that.

The names, labels and legends are held against table.py, the data against the rows of the file.
"""
from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.quiver import Quiver
from matplotlib.text import Text

from invented import altered
from ldbench.plots.call_sheets import SHEETS, run_sheet
from ldbench.plots.document import case_figures, extra_figures
from ldbench.plots.figures import overview_figures
from ldbench.plots.style import SIZE, ldbench_style
from ldbench.report.submission import first_and_hardest
from named_artists import artists, shown
from probes import left_rail, left_wheel, turned
from raw import PAIR, Raw, flange_slope
from specimen import World
from table import ACROSS, COLOURS, COLUMNS, KN, MM, PANELS, PORTRAITS, SHEETS as ROWS, WORDS, fits_contact, pictured

FACTORS = {"": 1.0, "m/s": 1.0, "m/s²": 1.0, "rad/s²": 1.0, "J": 1.0, "s": 1.0, "mm": MM, "mrad": 1e3, "mrad/s": 1e3, "kN": KN,
           "°": 180/np.pi, "kN·s": KN, "ms": 1e3}
UNITS = {column: unit for column, unit, _ in COLUMNS.values()}
EVENTS = {"left flange": "left flange contact", "right flange": "right flange contact", "centre": "centre passage",
          "derailment": "derailment"}
EXTRAS = "impacts of flanges", "phase portraits and spectra", "over the lateral force", "first contact", "hardest contact"


@pytest.fixture(autouse=True)
def styled() -> Iterator[None]:
    with ldbench_style():
        yield


def reading(raw: Raw, name: str) -> np.ndarray:
    """What a name says, from the rows of the file."""
    words, _, unit = name.removesuffix("]").partition(" [")
    if words.startswith("L/V "):
        return raw.ratio(words[4].upper())
    if words.startswith("time since "):
        return FACTORS[unit]*(raw.t - raw.start(words[-2:]))
    if words == "time":
        return FACTORS[unit]*raw.t
    total = np.zeros(len(raw.t))
    for sign, column in re.findall(r"(-|\+|^)(\w+)", words):
        assert UNITS[column] == unit, (name, column)
        total += (-1 if sign == "-" else 1)*FACTORS[unit]*raw.c[column]
    return total


def same(a: float | np.ndarray, b: float | np.ndarray, size: float) -> bool:
    """Whether numbers are equal but for rounding, beside a size."""
    return bool(np.all(np.abs(np.subtract(a, b)) <= 1e-9*np.maximum(size, np.abs(b)) + 1e-300))


# What artists show -------------------------------------------------------------------------

def compare_rows(raw: Raw, ax: Axes, line: Line2D) -> None:
    """Each point is a row."""
    t, x = reading(raw, shown(line).x), reading(raw, shown(line).y)
    drawn_t, drawn_x = (np.asarray(data, float) for data in line.get_data())
    drawn_t, drawn_x = drawn_t[np.isfinite(drawn_x)], drawn_x[np.isfinite(drawn_x)]
    if not shown(line).x.startswith(("time", "F_ext")):
        k = int(np.argmin(np.abs(t - drawn_t[0]) + np.abs(x - drawn_x[0])))
        rows = slice(k, k + len(drawn_t))
        assert same(drawn_t, t[rows], np.ptp(t)) and same(drawn_x, x[rows], np.ptp(x)), shown(line)
        return
    k = np.clip(np.searchsorted(t, drawn_t), 1, len(t) - 1)
    k -= np.abs(t[k - 1] - drawn_t) < np.abs(t[k] - drawn_t)
    # The file has times in nine digits, and the core knows when a flange touches better than that.
    assert np.abs(t[k] - drawn_t).max(initial=0) < 2e-8*np.ptp(t) + 1e-6*("since" in shown(line).x), shown(line)
    # Rows at an event are a few nanoseconds apart.
    near = np.array([x[np.clip(k + j, 0, len(x) - 1)] for j in (0, -1, 1)])
    apart = np.abs(near - drawn_x)/np.abs(x[np.isfinite(x)]).max(initial=1e-300)
    assert not len(k) or (np.nanmin(apart, axis=0).max() < 1e-8 and np.mean(apart[0] < 1e-8) > 0.99), shown(line)


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
        size = 1e-9*np.nanmax(np.abs(x))
        assert np.nanmin(x[around]) - size <= low <= np.nanmin(x[inside]) + size, shown(area)
        assert np.nanmax(x[inside]) - size <= high <= np.nanmax(x[around]) + size, shown(area)


def compare_mean(raw: Raw, ax: Axes, line: Line2D) -> None:
    """The mean over time of the rows of each column."""
    x, weight = reading(raw, shown(line).y), np.gradient(reading(raw, shown(line).x))
    middle, mean = (data[np.isfinite(line.get_ydata())] for data in line.get_data())
    known = np.isfinite(x)
    for at, one, (inside, _) in zip(middle, mean, columns_of(raw, shown(line), middle), strict=True):
        rows = inside[known[inside]]
        truth = np.sum(x[rows]*weight[rows])/np.sum(weight[rows])
        assert abs(one - truth) <= 0.02*np.ptp(x[rows]) + 1e-9*abs(truth), (shown(line), at)


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


def whole_range(raw: Raw, ax: Axes, labels: set[str]) -> None:
    """What curves and bands show of a quantity between the ends of the axis is all that the file has there."""
    for names in {(shown(one).y, shown(one).x) for one in ax.get_children() if "shown" in vars(one) and shown(one).how == "rows"}:
        own = [one for one in (*ax.lines, *ax.collections) if (shown(one).y, shown(one).x) == names]
        if not names[1].startswith("time") or all(line.get_linestyle() == "None" for line in own if isinstance(line, Line2D)):
            continue
        t, x = (reading(raw, name) for name in names[::-1])
        there = x[(t >= ax.get_xlim()[0]) & (t <= ax.get_xlim()[1]) & np.isfinite(x)]
        drawn = np.concatenate([np.asarray(one.get_ydata(), float) if isinstance(one, Line2D) else
                                np.vstack([path.vertices for path in one.get_paths()])[:, 1] for one in own])
        drawn = drawn[np.isfinite(drawn)]
        if there.size:
            size = 1e-6*np.ptp(x[np.isfinite(x)])
            assert drawn.min() <= there.min() + size and drawn.max() >= there.max() - size, names


# Looks, labels, legends --------------------------------------------------------------------

def look(artist: Artist) -> tuple[Any, ...]:
    """Colour, dashes and marker."""
    if isinstance(artist, Line2D):
        return to_rgba(artist.get_color()), str(artist._unscaled_dash_pattern), artist.get_marker() if not artist.get_ls() else ""
    return to_rgba(artist.get_facecolor()[0] if isinstance(artist, Collection) else artist.get_facecolor()), "", ""


def check_legends(figure: Figure) -> None:
    """Each entry looks like the curves that have its words; two entries differ; bands have the colours of their curves."""
    curves = [one for _, one in artists(figure) if not one.get_label().startswith("_") and shown(one).how != "range"]
    for legend in (*figure.legends, *(ax.get_legend() for ax in figure.axes if ax.get_legend())):
        own = [one for one in curves if legend.axes is None or one.axes is legend.axes]
        entries = {text.get_text(): look(handle) for handle, text in zip(legend.legend_handles, legend.texts, strict=True)}
        assert len(set(entries.values())) == len(entries), "two entries look alike"
        for words, seen in entries.items():
            looks = {look(one) for one in own if one.get_label() == words}
            assert looks == {seen}, (words, looks, seen)
    for ax, one in artists(figure):
        if shown(one).how in ("rows", "range", "mean", "arrow", "point", "solved"):
            own = set(re.findall(r"_([LR][TF])\b", shown(one).y))
            side = next((c for c in COLOURS if re.search(rf"L/V {c}|elastic_{c[0].upper()}\b", shown(one).y)), "")
            colour = one.get_color() if isinstance(one, Line2D) else one.get_facecolor()[0]
            if (own or side) and to_rgba(colour)[:3] != (0, 0, 0) and "+PE" not in shown(one).y:
                expected = COLOURS[own.pop() if len(own) == 1 else side or {"L": "left", "R": "right"}[own.pop()[0]]]
                assert to_rgba(colour)[:3] == to_rgba(expected)[:3], shown(one)
        if shown(one).how in ("range", "mean"):
            curve = next(line for line in ax.lines if shown(line).how == "rows" and shown(line).y == shown(one).y)
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


def rows_of_sheet(figure: Figure) -> list[tuple[str, list[Axes]]]:
    """The rows of a sheet: label, and axes from left to right."""
    rows: dict[float, list[Axes]] = {}
    for ax in figure.axes:
        rows.setdefault(round(ax.get_position().y0, 6), []).append(ax)
    ordered = [sorted(row, key=lambda ax: ax.get_position().x0) for _, row in sorted(rows.items(), reverse=True)]
    return [(" ".join(row[0].get_ylabel().split()), row) for row in ordered]


class Hardest(Raw):
    """A file whose contact with the largest force stands for the first one."""

    def first(self, contact: str) -> slice | None:
        return max(self.episodes(contact), key=lambda rows: self.c[f"N_{contact}"][rows].max())


def head(ax: Axes) -> str:
    """The words above a panel."""
    return " ".join(" ".join(text.get_text() for text in ax.texts).split())


# The pages ---------------------------------------------------------------------------------

@cache
def sheets(world: World, name: str) -> dict[str, Figure]:
    with ldbench_style():
        return dict(case_figures(world.run(name)))


def compare(raw: Raw, figure: Figure, others: Mapping[str, Raw] | None = None) -> int:
    """Compare all artists of a page; how many there are."""
    found = artists(figure)
    for ax, one in found:
        assert "shown" in vars(one), f"nobody says what {one} shows"
        names = shown(one)
        if names.how != "decoration":
            COMPARED[names.how]((others or {}).get(names.of, raw), ax, one)
    for ax in figure.axes:
        whole_range(raw, ax, set())
    check_legends(figure)
    return len(found)


@pytest.mark.parametrize("name", ["ex2_aw", "ex5_aw"])
@pytest.mark.parametrize("title", ROWS)
def test_sheets(title: str, name: str, world: World):
    """Rows in the order of the call; three columns; each artist of each panel; letters that can be read."""
    raw, figure = world.raw(name), sheets(world, name)[title]
    assert compare(raw, figure) > 3*len(ROWS[title])
    rows = rows_of_sheet(figure)
    assert [words for words, _ in rows] == list(ROWS[title])
    for words, axes in rows:
        assert len(axes) == 3
        for ax in axes:
            check_labels(ax, ROWS[title][words], words)
            curves = {one.get_label() for one in ax.lines if shown(one).how == "rows"}
            assert curves == {label for label in ROWS[title][words] if label[:4] != "work" or name == "ex5_aw"}
    (_, top), (_, bottom) = rows[0], rows[-1]
    assert "whole run" in head(top[0]) and bottom[0].get_xlabel() == "time [s]"
    clocks = [{shown(one).x for one in ax.lines} for ax in bottom]
    assert clocks[0] == {"time [s]"} and clocks[1] == {"time since LF [ms]"}
    assert bottom[1].get_xlabel() == "time since the touch [ms]" and "first contact of the left flange" in head(top[1])
    if name == "ex2_aw":
        assert clocks[2] == {"time since RF [ms]"} and "first contact of the right flange" in head(top[2])
        assert bottom[2].get_xlabel() == "time since the touch [ms]"
    else:
        assert clocks[2] == {"time [s]"} == {bottom[2].get_xlabel()}
        assert "last second of the run: the right flange is not touched" in head(top[2])
        assert bottom[2].get_xlim() == pytest.approx((raw.t[-1] - 1, raw.t[-1]))
        assert bottom[0].get_xlim() == (0, bottom[2].get_xlim()[0])
    for ax, contact in zip(bottom[1:], ("LF", "RF") if name == "ex2_aw" else ("LF",), strict=False):
        left, right = ax.get_xlim()
        millimetres = 297*ax.get_position().width*1e3*raw.impact(contact)["duration"]/(right - left)
        assert millimetres > 25, "the contact is wide enough to be read"
    words = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert min(text.get_fontsize() for text in words) >= SIZE >= 8


def test_a_flange_that_is_not_touched_is_told(world: World):
    """In words, in the place of its panels."""
    run = world.run("ex2_aw")
    still = altered(run, results={"t_first_RF": np.nan}, data=run.data.assign(N_RF=0.0))
    figure = run_sheet(still, SHEETS[0])
    assert figure and len(figure.axes) == 2*len(ROWS[SHEETS[0].title])
    said = next(text for text in figure.texts if text.get_text() == "The right flange is not touched")
    assert said.get_position()[0] > 0.8


@pytest.mark.parametrize("name", ["ex2_aw", "ex5_aw"])
def test_extras(name: str, world: World, tmp_path: Path):
    """Pages of a run that the call does not ask for."""
    raw, run = world.raw(name), world.run(name)
    fine = first_and_hardest(run) if name == "ex5_aw" else None
    pages = dict(extra_figures(run, fine))
    again = {}
    for title, part in zip(("first contact of the left flange", "hardest contact of the left flange"), fine or (), strict=False):
        part.run.write(tmp_path/f"{title}.txt")
        again[title] = Hardest(tmp_path/f"{title}.txt")
    assert len(pages) == (2 if name == "ex2_aw" else 4)
    for title, figure in pages.items():
        assert title.startswith(EXTRAS)
        whole = again.get(title, raw)
        for ax, one in artists(figure):
            if title in again and look(one)[:2] == ((0, 0, 0, 1), "(0, None)") and one.get_marker() == ".":
                compare_dots(raw, whole, one)
                ax.lines[ax.lines.index(one)].remove()
        compare(whole, figure)
        for ax in figure.axes:
            label = ax.get_ylabel()
            if ax.get_visible() and ax.get_xlabel() != "y [mm]" and ax.axison:
                check_labels(ax, PANELS[label], label)
                across = ax.get_xlabel()
                assert PORTRAITS.get(label, across) == across
                for line in ax.lines:
                    assert not across or shown(line).x in ("", ACROSS.get(across, "time since LF [ms]")), (across, shown(line))


def compare_dots(raw: Raw, part: Raw, dots: Line2D) -> None:
    """Rows of the run that lie in a part which was computed again: force and time are those of the whole run."""
    assert shown(dots).y == "N_LF [kN]"
    offset = np.interp(part.c["F_ext"][0], raw.c["F_ext"], raw.t)
    for t, force in zip(*dots.get_data(), strict=True):
        k = int(np.argmin(np.abs(raw.t - offset - part.start("LF") - 1e-3*t)))
        assert KN*raw.c["N_LF"][k] == pytest.approx(force, abs=1e-6)


def test_side_by_side(world: World):
    """Y, forces of both flanges, first contact and kinetic energy of each run, each on its row and in its look."""
    raws = {"ex2_aw": world.thrown, "ex3_aw": world.faster}
    (_, beside), _ = overview_figures([world.run(name) for name in raws])
    for row, (name, raw) in zip(np.reshape(beside.axes, (2, 4)), raws.items(), strict=True):
        names = [{shown(line).y for line in ax.lines} for ax in row]
        assert names == [{"Y [mm]"}, {"N_LF [kN]", "-N_RF [kN]"}, {"N_LF [kN]"}, {"KE_lat+KE_vert+KE_roll [J]"}]
        assert [ax.get_ylabel() for ax in row] == [f"Exercise {name[2]}: Y [mm]", "N of flanges [kN]", "N, first contact [kN]",
                                                   "kinetic energy [J]"]
        for ax in row:
            for line in ax.lines:
                assert shown(line).of == name
                compare_rows(raw, ax, line)
        for ax in row[[0, 1, 3]]:
            whole_range(raw, ax, set())
    check_legends(beside)
