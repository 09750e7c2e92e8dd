"""The results of an ensemble over each of its variables: a page for a variable, a panel for a result."""
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .._core.wording import counted
from ..results.quantities import OUTCOME
from .frame import legend_of_page, new_page
from .named import name as named, shows
from .style import SERIES, plain

if TYPE_CHECKING:
    import xarray as xr

#: Results that are drawn, as far as a run of the ensemble has them.
DRAWN = ("first_peak_N_LF", "first_impulse_LF", "first_duration_LF", "first_peak_N_RF", "peak_N_LF", "peak_N_RF", "t_first_LF",
         "t_return", "F_derailment", "farthest_left", "pmax", "t")
COLUMNS = 3         # of panels
MOST_LINES = len(SERIES)


def ensemble_figures(dataset: xr.Dataset) -> list[Figure]:
    """The pages of the Dataset of `ldbench.ensemble`; none where it has no results or no variable."""
    shown = [name for name in DRAWN if name in dataset and np.isfinite(dataset[name].values).any()]
    return [variable_page(dataset, name, shown) for name in variables_of(dataset)] if shown else []


def variables_of(dataset: xr.Dataset) -> list[str]:
    """The variables that members differ in, in their order."""
    return [str(name) for name, one in dataset.coords.items()
            if "long_name" in one.attrs and set(one.dims) <= set(dataset.error.dims)]


def variable_page(dataset: xr.Dataset, variable: str, shown: Sequence[str]) -> Figure:
    """The results over one variable, a panel each. A curve joins the members in which all other variables are the same, if there is
    at most one other variable and it has few values; else members are points."""
    of_variable = dataset[variable]
    others = [name for name in variables_of(dataset) if name != variable]
    joined = variable in dataset.dims and (not others or (len(others) == 1 and dataset[others[0]].size <= MOST_LINES))
    failed = int((dataset.error.values != "").sum())
    figure = new_page(f"Results over {of_variable.attrs['long_name']}", counted(dataset.error.size, "run"),
                      f"each point is a run{'; the curves join runs that differ in nothing else' if joined else ''}"
                      + (f"\n{counted(failed, 'run')} failed and {'is' if failed == 1 else 'are'} not drawn" if failed else ""))
    axes = figure.subplots(-(-len(shown)//COLUMNS), COLUMNS, squeeze=False, sharex=True).ravel()
    for ax, name in zip(axes, shown, strict=False):
        draw_result(ax, dataset, variable, name, others if joined else None)
    for unused in axes[len(shown):]:
        unused.remove()
    for ax in axes[max(len(shown) - COLUMNS, 0):len(shown)]:
        ax.set_xlabel(plain(axis_of(dataset, variable)))
        ax.tick_params(labelbottom=True)
    if joined and others:
        legend_of_page(figure, axes[0].get_lines())
    return figure


def axis_of(dataset: xr.Dataset, variable: str) -> str:
    """A variable with its unit."""
    unit = str(dataset[variable].attrs["units"])
    return named(variable, unit if unit != "1" else "")


def draw_result(ax: Axes, dataset: xr.Dataset, variable: str, name: str, others: Sequence[str] | None) -> None:
    """One result over one variable; others: the variables of whose values each has a curve, None for points alone."""
    known, across = OUTCOME[name], axis_of(dataset, variable)
    result = dataset[name]*known.scale
    ax.set_title(plain(known.label), loc="left", pad=3)
    ax.margins(0.04, 0.08)
    if others is None:
        x, y = (one.values.ravel() for one in (dataset[variable].broadcast_like(result), result))
        dots, = ax.plot(x, y, ".", color=SERIES[0].color, markersize=3)
        shows(dots, named(name, known.unit), across, "members")
        return
    values = dataset[others[0]].values.tolist() if others else []
    curves = [(f"{others[0]} = {value:g}" if isinstance(value, float) else f"{others[0]} = {value}", result.isel({others[0]: k}))
              for k, value in enumerate(values)] or [("", result)]
    for (words, curve), line in zip(curves, SERIES, strict=False):
        joined, = ax.plot(dataset[variable].values, curve.values, marker=".", markersize=3, label=plain(words), **line.kwargs())
        shows(joined, named(name, known.unit), across, "members", words)
