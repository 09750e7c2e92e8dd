"""How far first peak and return of the exercises are to be trusted: pages of the report."""
from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from matplotlib.figure import Figure
from tqdm import tqdm

from .._core.files import make_results_folder
from .._core.kept import kept_in, kept_json
from ..trust import Trust, trust
from ..trust.page import TITLE, report_pages
from .jobs import find_cases, sources

__all__ = ["TITLE", "figures", "kept_file", "kept_trusts"]


def kept_file(outputs: Path) -> Path:
    """The file that keeps what is found."""
    return kept_in(outputs)/"trust.json"


def kept_trusts(inputs: Path, outputs: Path, jobs: int, force: bool = False) -> list[Trust]:
    """What is found for the exercises that end with a return, anew where what it depends on has changed."""
    cases = [case for case in find_cases(inputs) if case.stop_at == "return_to_centre"]

    def make() -> list[dict[str, object]]:
        make_results_folder(outputs)
        return [trust(case, jobs=jobs).facts() for case in tqdm(cases, desc="trust", disable=None, leave=False)]

    depends = {name: x for case in cases for name, x in sources(case).items()}
    return [Trust.of_facts(facts) for facts in kept_json(kept_file(outputs), depends, force, make)]


def figures(found: Sequence[Trust]) -> Iterator[tuple[str, Figure]]:
    """A page for each pair of profiles."""
    return report_pages(found)
