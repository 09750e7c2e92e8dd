"""Runs as a page in the browser."""
from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from typing import TYPE_CHECKING

from .._core.errors import BadType
from ..case import Case
from ..results.run_data import RunData, read_data

if TYPE_CHECKING:       # what draws is imported where it is needed: it takes longer than a short run
    from .page import Page


def view(*runs: RunData | str | PathLike[str], title: str = "", case: Case | None = None) -> Page:
    """Runs, or column files, as a page: `ldbench.view(run, "other.txt").write("both.html")`; a notebook shows it.

    The first one is the reference of the differences. case: whose profiles are drawn for files that name none.
    """
    from .page import make_page

    strange = [run for run in runs if not isinstance(run, RunData | str | PathLike)]
    if strange or not runs:
        raise BadType("view: expected runs or column files, each an argument, found "
                      + (type(strange[0]).__name__ if strange else "none"))
    return make_page(distinct([run if isinstance(run, RunData) else read_data(run) for run in runs]), title, case)


def distinct(runs: Sequence[RunData]) -> list[RunData]:
    """Give runs of the same name different names: by contact law or formulation, by file, or by number."""
    def apart(names: list[str]) -> bool:
        return len(set(names)) == len(names)

    names = [run.name for run in runs]
    if apart(names):
        return list(runs)
    laws = [f"{run.name} {law(run) or run.file.name}" for run in runs]
    files = [f"{run.name} {run.file.name}" for run in runs]
    paths = [str(run.file) for run in runs]
    numbered = [f"{name} ({k})" for k, name in enumerate(names, 1)]
    chosen = next(words for words in (laws, files, paths, numbered) if apart(words))
    return [run.named(name) for run, name in zip(runs, chosen, strict=True)]


def law(run: RunData) -> str:
    """The contact law of elastic contact, or how rigid contact is treated."""
    return str(run.setting("contact", "model") or "") if run.formulation == "elastic" else run.formulation
