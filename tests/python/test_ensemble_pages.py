"""What an ensemble draws: every result at every value of every variable."""
from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

import ldbench
from ldbench.__main__ import main
from ldbench.plots.ensemble_pages import DRAWN, ensemble_figures
from ldbench.results.quantities import OUTCOME
from named_artists import artists, shown
from running import kept_tables
from table import RESULTS
from walk import walk

CASE = ldbench.Case.exercise(3).replace(model="hertz", dt=1e-5, t_end=0.015, roll_link="rails", stop_at="t_end")


def sweep(over: dict[str, list[float]], n: int | None = None) -> xr.Dataset:
    return ldbench.ensemble(CASE.replace(table_folder=kept_tables()), over, n)


def compare_members(found: xr.Dataset, ax: Axes, line: Line2D) -> None:
    """A result in the unit of its panel over a variable, of all members or of those with a value of the other variable."""
    name, truth = shown(line).y.partition(" [")[0], RESULTS[shown(line).y.partition(" [")[0]]
    assert ax.get_title(loc="left") == truth.words
    other, _, value = shown(line).of.partition(" = ")
    own = found.sel({other: float(value)}) if other else found
    x, y = (one.values.ravel() for one in xr.broadcast(own[shown(line).x.partition(" [")[0]], own[name]))
    np.testing.assert_array_equal(line.get_xdata(), x)
    np.testing.assert_allclose(line.get_ydata(), truth.scale*y, rtol=1e-12)


def drawn(figure: Figure, found: xr.Dataset) -> dict[str, list[tuple[str, np.ndarray, np.ndarray]]]:
    """Labels and points of the curves of a page, by the title of the panel; each says what it shows, and shows that."""
    variable, = {shown(one).x for _, one in artists(figure)}
    assert {ax.get_xlabel() for ax in figure.axes} - {""} == {variable} <= {"vY [m/s]", "mass [kg]"}
    assert walk(figure, {"members": compare_members}, found, says=lambda label, names, _: label == names.of) >= len(figure.axes)
    return {ax.get_title(loc="left"): [(line.get_label(), *map(np.asarray, line.get_data())) for line in ax.get_lines()]
            for ax in figure.axes}


def test_one_variable():
    """A curve in each panel, in the units of the summary; a result that no run has is not drawn."""
    found = sweep({"vY": [0.9, 1.0, 1.1]})
    figure, = ensemble_figures(found)
    curves = drawn(figure, found)
    assert set(curves) == {OUTCOME[name].label for name in DRAWN if name in found and np.isfinite(found[name]).any()}
    assert OUTCOME["first_peak_N_LF"].label in curves and OUTCOME["F_derailment"].label not in curves
    assert [ax.get_xlabel() for ax in figure.axes if ax.get_xlabel()] == ["vY [m/s]"]*3


def test_two_variables_have_a_page_each():
    """With a curve for each value of the other one, which its label tells."""
    found = sweep({"vY": [0.9, 1.0], "mass": [1500.0, 1568.0, 1600.0]})
    label = OUTCOME["first_peak_N_LF"].label
    for figure, other in zip(ensemble_figures(found), ("mass", "vY"), strict=True):
        curves = drawn(figure, found)[label]
        assert [float(words.removeprefix(f"{other} = ")) for words, *_ in curves] == found[other].values.tolist()


def test_draws_and_failures():
    """Draws are points; a run that failed is counted in the caption and has none."""
    points = sweep({"vY": [0.9, 1.1], "mass": [1500.0, 1600.0]}, 4)
    for figure in ensemble_figures(points):
        assert len(drawn(figure, points)[OUTCOME["first_peak_N_LF"].label]) == 1
    some = sweep({"mass": [1568.0, -1.0]})
    figure, = ensemble_figures(some)
    assert any("1 run failed and is not drawn" in text.get_text() for text in figure.texts)
    (_, _, y), = drawn(figure, some)[OUTCOME["t"].label]
    assert np.isfinite(y).tolist() == [True, False]


@pytest.mark.parametrize(("words", "files"), [("-o s.pdf", ["s.pdf"]), ("-o s.zarr --picture s.svg", ["s.svg", "s.zarr"])])
def test_command(words: str, files: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                 capsys: pytest.CaptureFixture[str], undrawn: None):
    monkeypatch.chdir(tmp_path)
    CASE.replace(table_folder=kept_tables()).to_namelist("case.nml")
    assert main(["ensemble", "case.nml", "--over", "vY=0.9,1.1", *words.split()]) == 0
    said = capsys.readouterr().out
    assert all(f"\n{file}: " in said and Path(file).exists() for file in files)
    assert main(["ensemble", "case.nml", "--over", "vY=0.9", "-o", "a.pdf", "--picture", "b.pdf"]) == 2
