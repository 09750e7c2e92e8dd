"""Pictures and frames of films: what they show of one run and of several, at which scale, and where they look."""
from __future__ import annotations

import numpy as np
import pytest
from matplotlib.text import Text

import ldbench
from invented import altered
from ldbench import Case
from ldbench.plots.style import SERIES, ldbench_style
from ldbench.results.run_data import RunData
from ldbench.viewer.film import Picture


def case(pair: str = "aw", **changes: float) -> Case:
    """A wheelset that goes to the left flange within 12 ms, with the contact table that is built in the least time."""
    return Case.exercise(3, pair).replace(**{
        "model": "hertz", "n_lateral": 40, "n_roll": 9, "n_depth": 9, "table_file": "", "dt": 2e-5, "t_end": 0.012,
        "energy_tolerance": 0.0} | changes)


@pytest.fixture(scope="module")
def pair() -> tuple[RunData, RunData]:
    """Runs with both pairs of profiles."""
    return ldbench.run(case()), ldbench.run(case("sw"))


def drawn(*runs: RunData) -> Picture:
    with ldbench_style():
        return Picture(runs, 0.0, 0.012, 1e-3, None)


@pytest.fixture(scope="module")
def both(pair: tuple[RunData, RunData]) -> Picture:
    """A picture of both runs, which tests move to times of their own."""
    return drawn(*pair)


@pytest.fixture(scope="module")
def single(pair: tuple[RunData, RunData]) -> Picture:
    """A picture of the first run, which tests move to times of their own."""
    return drawn(pair[0])


def words(picture: Picture, t: float) -> list[str]:
    """The texts of a picture at time t."""
    still = [text.get_text() for text in picture.figure.findobj(Text) if text.get_text()]
    return still + [words for _, words, _, _ in picture.words(t)]


def test_both_runs_have_name_values_and_rail(pair: tuple[RunData, RunData], both: Picture):
    k = int(np.argmax(pair[0].values("N_LF")))
    t = float(pair[0].time[k])
    said = words(both, t)
    for run in pair:
        y = 1e3*np.interp(t, run.time, run.values("Y"))
        assert any(run.name in text and run.heading in text for text in said)
        assert any(f"Y {y:.2f} mm" in text for text in said)
    assert any(f"flange {1e-3*pair[0].values('N_LF')[k]:.0f} kN at" in text for text in said)
    assert [[line.color for line in scene.rails] for scene in both.scenes] == [[line.color for line in SERIES[:2]]]*3
    assert "N_RF" not in both.charts and not any(run.values("N_RF").any() for run in pair)      # no empty panel
    for column in "Y", "N_LF", "N_LT", "N_RT":
        chart = both.charts[column]
        assert [line.get_color() for line in chart.get_lines()[:2]] == [line.color for line in SERIES[:2]]


@pytest.fixture(scope="module")
def ended(pair: tuple[RunData, RunData]) -> tuple[RunData, Picture]:
    """A run that is the first one's first rows, and a picture of both."""
    short = altered(pair[0], data=pair[0].data.iloc[:50], name="short")
    return short, drawn(pair[0], short)


def test_a_run_that_has_ended_says_so(ended: tuple[RunData, Picture]):
    short, picture = ended
    assert not any("ended" in text for text in words(picture, 0.001))
    assert any("short" in text and f"ended at {1e3*short.time[-1]:.1f} ms" in text for text in words(picture, 0.011))


def test_arrows_of_a_run_have_the_scale_that_is_drawn(pair: tuple[RunData, RunData], single: Picture):
    """In every scene, of every closed contact; open contacts have none."""
    run = pair[0]
    for t in 0.005, 0.0105, float(run.peak("LF")[1]):
        single.frame(t)
        for scene in single.scenes:
            unit = np.ptp(scene.scale_arrow.get_xy()[:, 0])/scene.scale_force
            for (_, contact), shape in scene.arrows.items():
                force = np.hypot(*(np.interp(t, run.time, run.values(f"{name}_{contact}")) for name in ("Fy", "Fz")))
                assert shape.get_visible() == (force > 0)
                if force > 0:
                    corners = shape.get_xy()
                    tip = corners[0]
                    tail = (corners[3] + corners[4])/2
                    assert np.hypot(*(tip - tail)) == pytest.approx(unit*force, rel=1e-9)
            assert f"{1e-3*scene.scale_force:g} kN" in words(single, t)
            assert f"{1e3*scene.scale_length:g} mm" in words(single, t)


@pytest.mark.parametrize("gauge", [1.0, 1.668])
def test_close_ups_are_where_the_rails_are(gauge: float):
    """Both profiles of a side are in the middle of the picture of this side, whatever the gauge."""
    run = ldbench.run(case(gauge=gauge, back_to_back=1.35214 + gauge - 1.4351, t_end=1e-3))
    picture = drawn(run)
    outlines = picture.actors[0].outlines
    for scene in picture.scenes[1:]:
        left, right = sorted(scene.ax.get_xlim())
        bottom, top = scene.ax.get_ylim()
        rail = outlines.left.rail*[scene.side, 1]
        wheel = outlines.left.wheel*[scene.side, 1] + [0, outlines.axle]
        assert left < rail[:, 0].min() - 0.02 and rail[:, 0].max() + 0.02 < right and bottom < 0 < top
        assert left < wheel[:, 0].min() and wheel[:, 0].max() < right and bottom < wheel[:, 1].min() < top
        assert np.abs((left + right)/2 - scene.side*outlines.left.rail[:, 0].mean()) < 0.02
    whole = picture.scenes[0].ax
    assert np.abs(whole.get_xlim()).min() > outlines.left.wheel[:, 0].max() + 0.05
    assert whole.get_ylim()[1] > outlines.axle - outlines.left.wheel[:, 1].min()


def test_a_rail_that_pulls_is_drawn(pair: tuple[RunData, RunData]):
    """Contacts of bilateral constraints have negative forces, which point away from the wheel."""
    data = pair[0].data.copy()
    for column in "N_LT", "Fy_LT", "Fz_LT":
        data[column] = -data[column].abs()
    picture = drawn(altered(pair[0], data=data))
    [*picture.scenes[1].move(0.005)]
    corners = picture.scenes[1].arrows[0, "LT"].get_xy()
    assert picture.scenes[1].arrows[0, "LT"].get_visible() and corners[0, 1] < corners[3, 1]
    assert any(text.startswith("tread −") for text in words(picture, 0.005))


def test_the_longest_arrow_is_the_largest_force_of_the_film(pair: tuple[RunData, RunData], single: Picture):
    """Forces before and after the film do not count."""
    with ldbench_style():
        before = Picture([pair[0]], 0.0, 0.009, 1e-3, None)
    assert before.scenes[1].scale_force < 1e5 < single.scenes[1].scale_force
