"""Generated inputs: how hypothesis makes them, in the tests and in `make fuzz`.

Choices in the tests are always the same, whatever ran before. `make fuzz` makes LDBENCH_EXAMPLES times as many, from a seed of
its own.
"""
from __future__ import annotations

import os
import random
from collections.abc import Iterable, Mapping

import hypothesis
from hypothesis import strategies as st
from hypothesis.internal.conjecture import providers

from running import REPO

TIMES = int(os.environ.get("LDBENCH_EXAMPLES", "0"))

hypothesis.configuration.set_hypothesis_home_dir(REPO/"build/hypothesis")
# Hypothesis takes constants from all modules that are imported, which depends on the tests that ran before.
providers.is_local_module_file = lambda path: False     # type: ignore[assignment]
hypothesis.settings.register_profile(
    "ldbench", deadline=None, database=None, derandomize=not TIMES, print_blob=False,
    suppress_health_check=list(hypothesis.HealthCheck), phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate])
hypothesis.settings.load_profile("ldbench")


def examples(n: int) -> hypothesis.settings:
    """So many examples in the tests; `make fuzz` takes a multiple."""
    return hypothesis.settings(max_examples=n*max(TIMES, 1))


def covering(layers: Mapping[str, Iterable[str]]) -> st.SearchStrategy[list[dict[str, str]]]:
    """As many combinations of options as the largest layer has, which together have every option of every layer."""
    lists = {layer: list(options) for layer, options in layers.items()}
    length = max(map(len, lists.values()))

    def combined(seed: int) -> list[dict[str, str]]:
        chance = random.Random(seed)
        found = {layer: [option for _ in range(-(-length//len(some))) for option in chance.sample(some, len(some))]
                 for layer, some in lists.items()}
        return [{layer: options[k] for layer, options in found.items()} for k in range(length)]

    return st.integers(0, 2**32).map(combined)
