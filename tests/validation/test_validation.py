"""Sections of `make validate` with fewer cases and poses: every check is inside its bar."""
from __future__ import annotations

import importlib
import shutil
from pathlib import Path

import numpy as np
import pytest

from checks import TESTED
from probes import table_file
from running import PAIRS, Run


@pytest.fixture(scope="session")
def workplace(shipped: dict[str, Run], strip_tables: dict[str, Path],
              tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder whose outputs have the contact tables that the sections would build."""
    folder = tmp_path_factory.mktemp("validation")
    (folder/"outputs").mkdir()
    for pair in PAIRS:
        for file in table_file(shipped, pair), strip_tables[pair]:
            shutil.copy(file, folder/"outputs")
    return folder


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
@pytest.mark.parametrize("name", TESTED)
def test_every_check_is_inside_its_bar(name: str, workplace: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(workplace)
    section = importlib.import_module(name).section(**TESTED[name])
    assert section.checks
    assert [check for check in section.checks if not check.inside or not np.isfinite([check.value, check.reference]).all()] == []
