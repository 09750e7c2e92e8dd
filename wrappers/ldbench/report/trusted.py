"""How far the answers of the exercises are to be trusted, for the pages of the report that `trust.page.report_pages` draws."""
from __future__ import annotations

from pathlib import Path

from tqdm import tqdm

from .._core.files import make_results_folder
from .._core.kept import kept_in, kept_json
from ..trust import Trust, trust
from .jobs import find_cases, sources


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
