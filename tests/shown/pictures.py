"""The rows of the walk over pictures: every page and film that is drawn, and what its artists are held against."""
from __future__ import annotations

import json
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text
from scipy.integrate import cumulative_trapezoid

import ldbench
from commands import RAIL, WHEEL, comparison, study, told_pair
from invented import invented_run
from ldbench import Profile
from ldbench.geometry.pressures import run_patches
from ldbench.plots.document import case_figures, extra_figures
from ldbench.plots.figures import contact_figure, derailment_figure, impact_figure, motion_figure, overview_figures
from ldbench.plots.geometry import geometry_page, pair_page
from ldbench.plots.named import Shown
from ldbench.plots.pressure_page import pressure_page
from ldbench.plots.profile_page import profile_page
from ldbench.plots.style import SIZE
from ldbench.report.formulations import Outcome, exercises_page, values_page, verdict_page
from ldbench.report.submission import first_and_hardest
from named_artists import artists, shown
from of_geometry import OF_PROFILES, compare_contact_line, compare_functions, compare_raised, compare_reach, of_side
from of_pressure import check_pressure
from of_runs import COMPARED, compared_with, whole_range
from of_several import OF_RUNS, compare_level, compare_rms, compare_shade, of_pair_or_speed
from probes import profile
from raw import Raw
from specimen import World
from table import CLEARANCE, COLUMNS, KN, MM, SHEETS, WORDS
from texts import CHANGES, NAMES, formulations
from walk import Compare, Says, look

PAIR_PAGE = {"left": "aw", "right": "sw"}       # the wheels of the page of a pair


class Picture(NamedTuple):
    """Pages, and what their artists are held against."""

    what: str
    figures: Callable[[World], Iterable[tuple[str, Figure]]]                # by titles
    compared: Callable[[World], Mapping[str, Compare]]                      # by how artists show what they do
    source: Callable[[World, str], Any] = lambda world, title: None         # of a page, of artists whose name is none of `others`
    others: Callable[[World], Mapping[str, Any]] = lambda world: {}         # sources by the names of what artists are of
    says: Says | None = None
    count: int = 1                                                          # of artists on a page, at least
    check: Callable[[World, str, Figure], None] = lambda world, title, figure: None
    cut: Sequence[str] = ()                                                 # what does not show all points, as `walk` has it


# Pages of a run ----------------------------------------------------------------------------

class Hardest(Raw):
    """A file whose contact with the largest force stands for the first one."""

    def first(self, contact: str) -> slice | None:
        return max(self.episodes(contact), key=lambda rows: self.c[f"N_{contact}"][rows].max())


def check_sheet(world: World, title: str, figure: Figure) -> None:
    """Rows in the order of the call; three columns with their windows; letters that can be read."""
    name, title = title.split(": ")
    raw = world.raw(name)
    rows: dict[float, list[Axes]] = {}
    for ax in figure.axes:
        rows.setdefault(round(ax.get_position().y0, 6), []).append(ax)
    ordered = [sorted(row, key=lambda ax: ax.get_position().x0) for _, row in sorted(rows.items(), reverse=True)]
    assert [" ".join(row[0].get_ylabel().split()) for row in ordered] == list(SHEETS[title])
    for words, axes in zip(SHEETS[title], ordered, strict=True):
        assert len(axes) == 3
        for ax in axes:
            curves = {one.get_label() for one in ax.lines if shown(one).how == "rows"}
            assert curves == {label for label in SHEETS[title][words] if label[:4] != "work" or name == "ex5_aw"}
    top, bottom = ordered[0], ordered[-1]
    heads = [" ".join(" ".join(text.get_text() for text in ax.texts).split()) for ax in top]
    clocks = [{shown(one).x for one in ax.lines} for ax in bottom]
    last = "time since RF [ms]" if name == "ex2_aw" else "time [s]"
    assert "whole run" in heads[0] and "first contact of the left flange" in heads[1]
    assert clocks == [{"time [s]"}, {"time since LF [ms]"}, {last}]
    assert [ax.get_xlabel() for ax in bottom] == [re.sub(r"since \w\w", "since the touch", *clock) for clock in clocks]
    if name == "ex2_aw":
        assert "first contact of the right flange" in heads[2]
    else:
        assert "last second of the run: the right flange is not touched" in heads[2]
        assert bottom[2].get_xlim() == pytest.approx((raw.t[-1] - 1, raw.t[-1]))
        assert bottom[0].get_xlim() == (0, bottom[2].get_xlim()[0])
    for ax, contact in zip(bottom[1:], ("LF", "RF") if name == "ex2_aw" else ("LF",), strict=False):
        left, right = ax.get_xlim()
        millimetres = 297*ax.get_position().width*1e3*raw.impact(contact)["duration"]/(right - left)
        assert millimetres > 25, "the contact is wide enough to be read"
    words = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert min(text.get_fontsize() for text in words) >= SIZE >= 8
    whole_range(raw, figure)


def sheets(world: World) -> Iterator[tuple[str, Figure]]:
    for name in NAMES:
        for title, figure in case_figures(world.run(name)):
            yield f"{name}: {title}", figure


@cache
def again(world: World) -> dict[str, tuple[Any, Raw]]:
    """The first and the hardest contact of the ramp, computed again with more rows."""
    fine, found = first_and_hardest(world.run("ex5_aw")), {}
    with tempfile.TemporaryDirectory() as folder:
        for title, part in zip(("first contact of the left flange", "hardest contact of the left flange"), fine, strict=True):
            part.run.write(Path(folder)/"part.txt")
            found[title] = part, Hardest(Path(folder)/"part.txt")
    return found


def extras(world: World) -> Iterator[tuple[str, Figure]]:
    """Pages of a run that the call does not ask for; rows of the run in a part that was computed again are
    compared by themselves."""
    for name in NAMES:
        fine = tuple(part for part, _ in again(world).values()) if name == "ex5_aw" else None
        pages = dict(extra_figures(world.run(name), fine))
        assert len(pages) == (2 if name == "ex2_aw" else 4)
        for title, figure in pages.items():
            for ax, one in artists(figure) if title in again(world) else ():
                if look(one)[:2] == ((0, 0, 0, 1), "(0, None)") and one.get_marker() == ".":
                    compare_dots(world.pushed, again(world)[title][1], one)
                    ax.lines[ax.lines.index(one)].remove()
            yield f"{name}: {title}", figure


def compare_dots(raw: Raw, part: Raw, dots: Line2D) -> None:
    """Force and time are those of the whole run."""
    assert shown(dots).y == "N_LF [kN]"
    offset = np.interp(part.c["F_ext"][0], raw.c["F_ext"], raw.t)
    for t, force in zip(*dots.get_data(), strict=True):
        k = int(np.argmin(np.abs(raw.t - offset - part.start("LF") - 1e-3*t)))
        assert KN*raw.c["N_LF"][k] == pytest.approx(force, abs=1e-6)


def source_of_extras(world: World, title: str) -> Raw:
    name, _, title = title.partition(": ")
    return again(world)[title][1] if title in again(world) else world.raw(name)


# Pages of several runs ---------------------------------------------------------------------

@cache
def several(world: World) -> dict[str, Any]:
    """Exercises 2 and 3 with one pair and exercise 2 with another one, all of which differ."""
    faster = world.run("ex3_aw")
    told = {group: settings for group, settings in faster._comments.settings.items() if group != "profiles"}
    return {"ex2_aw": world.run("ex2_aw"), "ex3_aw": faster, "ex2_sw": invented_run(
        faster.data, faster.file, "ex2_sw", replace(faster._comments, settings=told), faster.case)}


def raws_of_several(world: World) -> dict[str, Raw]:
    return {"ex2_aw": world.thrown, "ex3_aw": world.faster, "ex2_sw": world.faster, "ex5_aw": world.pushed}


def of_abstract(world: World) -> Iterator[tuple[str, Figure]]:
    runs = [*several(world).values()]
    for figure, count in (motion_figure(runs), 3), (impact_figure(runs), 6), (contact_figure(runs), 11):
        assert len(artists(figure)) >= count
        yield "", figure
    ramp = derailment_figure([world.run("ex5_aw")])
    assert len(artists(ramp)) == 6 and ramp.axes[0].get_ylabel() == "vertical force [kN]"
    yield "", ramp


def check_beside(world: World, title: str, figure: Figure) -> None:
    """Y, forces of both flanges, first contact and kinetic energy of each run, each on its row."""
    if "side by side" not in title:
        return
    for row, name in zip(np.reshape(figure.axes, (2, 4)), ("ex2_aw", "ex3_aw"), strict=True):
        names = [{shown(line).y for line in ax.lines} for ax in row]
        assert names == [{"Y [mm]"}, {"N_LF [kN]", "-N_RF [kN]"}, {"N_LF [kN]"}, {"KE_lat+KE_vert+KE_roll [J]"}]
        assert [ax.get_ylabel() for ax in row] == [f"Exercise {name[2]}: Y [mm]", "N of flanges [kN]", "N, first contact [kN]",
                                                   "kinetic energy [J]"]
        assert {shown(line).of[:3] for ax in row for line in ax.lines} == {name[:3]}
    whole_range(world.thrown, figure, raws_of_several(world))


def check_titles(world: World, title: str, figure: Figure) -> None:
    """Panels on the left lie under the words of their column, those on the right under a difference."""
    for ax in figure.axes:
        for line in ax.lines:
            words = ax.get_title(loc="left").partition(" [")[0]
            if shown(line).how == "between rows":
                assert COLUMNS[words][0] == shown(line).y.partition(" [")[0]
            elif shown(line).how == "difference":
                assert words == "difference from the reference"
            else:
                contact, number = shown(line).x.split()[2:4]
                assert ax.get_title(loc="left").startswith(f"{WORDS[contact]} {number}: ") and shown(line).y == f"N_{contact} [kN]"


# Formulations ------------------------------------------------------------------------------

KEPT = 2500         # rows of a run, at most


@cache
def raws_of_formulations(world: World) -> dict[str, Raw]:
    """The rows that the pages keep of each run, with the impulse on the left flange of forces and impacts."""
    found = {}
    for words, raw in formulations(world).items():
        rows = np.unique(np.linspace(0, len(raw.t) - 1, KEPT).astype(int)) if words[:2] == "ex" else slice(None)
        impulse = cumulative_trapezoid(raw.c["N_LF"], raw.t, initial=0) + raw.c.get("P_LF", 0.0)
        found[words] = kept = copy(raw)
        kept.c = {name: x[rows] for name, x in (raw.c | {"impulse_LF": impulse}).items()}
        kept.t = kept.c["time"]
    return {**found, **world.raws}


def outcomes(world: World) -> Iterator[tuple[str, Figure]]:
    """The pages of the outcomes that the report has kept."""
    kept = json.loads((world.outputs/".ldbench/formulations.json").read_text(encoding="utf-8"))
    found = [Outcome(**one) for one in kept]
    for exercise in 2, 5:
        yield f"exercise {exercise}", exercises_page(found, [exercise], f"Exercise {exercise}")
    yield "verdicts", verdict_page(found, Path("inputs"))
    yield "values", values_page(found)


def check_outcomes(world: World, title: str, figure: Figure) -> None:
    """Four panels of five formulations; the work that lifts the wheelset, and the energies of the exercises beside it."""
    if title.startswith("exercise"):
        for ax in figure.axes:
            rows = [shown(line).of for line in ax.lines if shown(line).how == "rows"]
            assert sorted(rows) == sorted(f"ex{title[-1]}_aw {words}" for words in ("elastic", *CHANGES))
        whole_range(world.thrown, figure, raws_of_formulations(world))
    elif title == "verdicts":
        assert [shown(line).how for line in figure.axes[-1].lines] == ["rows", "level"]


# Profiles ----------------------------------------------------------------------------------

def pages_of_profiles(world: World) -> Iterator[tuple[str, Figure]]:
    """Wheel and rail, the wheel through its points and smoothed; then the pair."""
    for wheel in Profile(WHEEL), Profile(WHEEL, smoothing=0.02):
        yield "profiles", profile_page([wheel, Profile(RAIL)], told_pair().pair, "note")


def check_profiles(world: World, title: str, figure: Figure) -> None:
    titles = {words: {shown(one).of for one in ax.lines} - {""} for ax in figure.axes if (words := ax.get_title(loc="left"))}
    assert titles == {"wheel": {"wheel"}, "rail": {"rail"}}


def functions_of_pair(world: World) -> dict[str, Any]:
    level, rolled = told_pair().pair.level, told_pair().pair.rolled
    return {"level": {**level.geometry, "amplitude": level.amplitude, "conicity": level.conicity},
            "with roll": {**rolled.geometry, "amplitude": rolled.amplitude, "conicity": rolled.conicity,
                          "linearised": rolled.linearised}}


@cache
def geometry(world: World) -> tuple[dict[str, np.ndarray], Figure]:
    """The columns of the file of geometry functions, and their page."""
    run = world.run("ex2_aw")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder)/"geometry.txt"
        ldbench.ContactTable(run.case).write_geometry(file)
        names, *lines = file.read_text().splitlines()
        columns = dict(zip(names.split(), np.array([line.split() for line in lines if line[0] != "#"], float).T, strict=True))
        np.testing.assert_allclose(columns["delta_r"], columns["radius_L"] - columns["radius_R"], atol=1e-8)
        return columns, geometry_page(run, ldbench.read_columns(file))


def pressures(world: World) -> Iterator[tuple[str, Figure]]:
    run = world.run("ex2_aw")
    for contact in "LF", "RF":
        k = int(world.thrown.first_peak(contact))
        yield contact, pressure_page(run, k, run_patches(run, k, [contact]))


def of_file(label: str, names: Shown, source: Any) -> bool:
    return label == names.of


STUDIED = {"law": "law: one Hertz spring per zone", "step": "step: average acceleration, step 0.1 ms"}
PARTS = ("elements", "contours", "ellipse", "cut", "Hertz", "outline", "crest", "pressed", "legend")

PICTURES = [
    Picture("sheets", sheets, lambda world: COMPARED, lambda world, title: world.raw(title[:6]), count=15, check=check_sheet),
    # A wheel is drawn as far as its rail.
    Picture("extras", extras, lambda world: COMPARED, source_of_extras, check=lambda world, title, figure: whole_range(
        source_of_extras(world, title), figure), cut=["outlines"]),
    # The logarithmic axis of the forces begins at 10 kN.
    Picture("abstract", of_abstract, lambda world: OF_RUNS, lambda world, title: raws_of_several(world), raws_of_several,
            of_pair_or_speed, cut=["N of the left flange [kN]"]),
    Picture("several runs", lambda world: overview_figures([*several(world).values()]), lambda world: OF_RUNS,
            lambda world, title: raws_of_several(world), raws_of_several, of_pair_or_speed, 15, check_beside),
    Picture("compare", lambda world: comparison(world).items(), lambda world: compared_with(world.thrown, world.faster),
            lambda world, title: world.thrown, lambda world: {"ex2_aw": world.thrown, "ex3_aw": world.faster}, of_file, 0,
            check_titles),
    Picture("study", lambda world: zip(("summary", "curves"), study(world)[1], strict=True),
            lambda world: {**compared_with(*study(world)[0]), "bar": compare_rms},
            lambda world, title: world if title == "summary" else study(world)[0][0],
            lambda world: dict(zip(("half-spaces, cut steps", *(words.partition(": ")[2] for words in STUDIED.values())),
                                   study(world)[0], strict=True)),
            lambda label, names, source: label == STUDIED.get(names.of[7:], names.of), 9,
            lambda world, title, figure: check_titles(world, title, figure) if title == "curves" else None),
    # The fall of a derailment leaves the axes at 25 mm and 300 J, above which the bilateral run comes as well.
    Picture("formulations", outcomes, lambda world: {**COMPARED, "level": compare_level, "shade": compare_shade},
            lambda world, title: None, raws_of_formulations, lambda label, names, source: names.of.partition(" ")[2] == label, 2,
            check_outcomes, cut=["lateral Y [mm]", "vertical Z [mm]", "kinetic energy [J]"]),
    Picture("profiles", pages_of_profiles, lambda world: OF_PROFILES, others=lambda world: {
        "wheel": profile("awprof"), "rail": profile("arprof")}, says=lambda label, names, source: label in (
            names.how, names.how.removeprefix("part ")), count=21, check=check_profiles),
    Picture("pair", lambda world: [("pair", pair_page(told_pair().pair, "note", None))], lambda world: {
        "functions": compare_functions, "mark": compare_reach(told_pair().pair.clearance),
        "contact line": compare_contact_line(PAIR_PAGE, told_pair().pair.outlines.axle),
        "raised outline": compare_raised(PAIR_PAGE, told_pair().pair.outlines.axle)},
        lambda world, title: told_pair().pair.rolled.geometry, functions_of_pair, of_side, 101),
    Picture("geometry", lambda world: [("geometry", geometry(world)[1])], lambda world: {
        "functions": compare_functions, "mark": compare_reach((CLEARANCE[0]/MM - 5e-6, CLEARANCE[1]/MM + 5e-6))},
        lambda world, title: geometry(world)[0], says=of_side, count=28),
    Picture("pressure", pressures, lambda world: dict.fromkeys(PARTS, lambda *_: None), count=11, check=check_pressure,
            cut=["outlines", "legends"]),
]
