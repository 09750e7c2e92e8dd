"""The executable for another processor, emulated: `make test-arm64`."""
import os
import re
import subprocess
from pathlib import Path

import pytest

from conftest import LDBENCH, PAIRS, REPO, Run

HERE = REPO/"ldbench"

pytestmark = pytest.mark.skipif("arm64" not in str(LDBENCH), reason="only by make test-arm64")


@pytest.mark.parametrize("pair", PAIRS)
def test_tables_have_the_same_points(pair: str, shipped: dict[str, Run], tmp_path: Path):
    """What decides about the points of a table does not depend on last digits; its stated errors are the same numbers."""
    (tmp_path/"inputs").mkdir()
    (tmp_path/"outputs").mkdir()
    os.symlink(REPO/"profiles", tmp_path/"profiles")
    here = subprocess.run([HERE], input=(REPO/f"inputs/ex1_{pair}.nml").read_text(), cwd=tmp_path, capture_output=True, text=True,
                          check=True).stdout
    for line in r"^contact table: .*$", r"^its error, .*$":
        assert re.findall(line, shipped[f"ex1_{pair}"].summary, re.M) == re.findall(line, here, re.M) != []
