"""Sections of `make validate` with fewer cases and poses: every check is inside its bar."""
from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

from checks import TESTED
from running import kept_tables


@pytest.fixture(scope="session")
def workplace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder whose outputs have the kept contact tables."""
    folder = tmp_path_factory.mktemp("validation")
    (folder/"outputs").mkdir()
    (folder/"outputs/tables").symlink_to(kept_tables())
    return folder


@pytest.mark.filterwarnings("ignore::ldbench.Warning")
@pytest.mark.parametrize("name", TESTED)
def test_every_check_is_inside_its_bar(name: str, workplace: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(workplace)
    section = importlib.import_module(name).section(**TESTED[name])
    assert section.checks
    assert [check for check in section.checks if not check.inside or not np.isfinite([check.value, check.reference]).all()] == []
