"""No drawn thing without a named quantity: every artist with data of the pages says what it shows, and shows that.

The names, labels and legends are held against table.py, the data against the rows of the file.
"""
from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from invented import altered
from ldbench.plots.call_sheets import SHEETS, run_sheet
from ldbench.plots.document import case_figures, extra_figures
from ldbench.plots.figures import overview_figures
from ldbench.plots.style import SIZE, ldbench_style
from ldbench.report.submission import first_and_hardest
from named_artists import artists, shown
from of_runs import compare
from raw import Raw
from specimen import World
from table import ACROSS, KN, PANELS, PORTRAITS, SHEETS as ROWS
from walk import check_labels, look

EXTRAS = "impacts of flanges", "phase portraits and spectra", "over the lateral force", "first contact", "hardest contact"


@pytest.fixture(autouse=True)
def styled() -> Iterator[None]:
    with ldbench_style():
        yield


class Hardest(Raw):
    """A file whose contact with the largest force stands for the first one."""

    def first(self, contact: str) -> slice | None:
        return max(self.episodes(contact), key=lambda rows: self.c[f"N_{contact}"][rows].max())


def rows_of_sheet(figure: Figure) -> list[tuple[str, list[Axes]]]:
    """The rows of a sheet: label, and axes from left to right."""
    rows: dict[float, list[Axes]] = {}
    for ax in figure.axes:
        rows.setdefault(round(ax.get_position().y0, 6), []).append(ax)
    ordered = [sorted(row, key=lambda ax: ax.get_position().x0) for _, row in sorted(rows.items(), reverse=True)]
    return [(" ".join(row[0].get_ylabel().split()), row) for row in ordered]


def head(ax: Axes) -> str:
    """The words above a panel."""
    return " ".join(" ".join(text.get_text() for text in ax.texts).split())


# The pages ---------------------------------------------------------------------------------

@cache
def sheets(world: World, name: str) -> dict[str, Figure]:
    with ldbench_style():
        return dict(case_figures(world.run(name)))


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


def test_every_page_of_the_report_is_named(world: World):
    """The curves of abstract and extras are named as well."""
    assert [file.name for file in world.folder.glob("*.unnamed")] == []
    assert len(list((world.folder/"sheets").iterdir())) > 20


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
    for row, name in zip(np.reshape(beside.axes, (2, 4)), raws, strict=True):
        names = [{shown(line).y for line in ax.lines} for ax in row]
        assert names == [{"Y [mm]"}, {"N_LF [kN]", "-N_RF [kN]"}, {"N_LF [kN]"}, {"KE_lat+KE_vert+KE_roll [J]"}]
        assert [ax.get_ylabel() for ax in row] == [f"Exercise {name[2]}: Y [mm]", "N of flanges [kN]", "N, first contact [kN]",
                                                   "kinetic energy [J]"]
        assert {shown(line).of for ax in row for line in ax.lines} == {name}
    compare(world.thrown, beside, raws)
