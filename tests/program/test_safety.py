"""A folder of anybody's is looked at, and nothing in it is run."""
from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from running import HANG, bare_environment

# Modules that the command imports, early and late: of Python's library, numpy, those of other packages, and our second package.
IMPORTED = "argparse", "logging", "difflib", "hashlib", "numpy", "pandas", "ldbench_round"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A submission with modules, each of which leaves a file `run`."""
    for name in IMPORTED:
        (tmp_path/f"{name}.py").write_text("import os\nopen('run', 'w').close()\nraise SystemExit(77)\n")
    (tmp_path/"ex2_aw.csv").write_text("time,Y\n0,0\n1,0\n")
    return tmp_path


def test_modules_of_the_working_folder_are_not_imported(folder: Path):
    """By the command that imports most of them: what the package imports at its start, numpy, pandas, and our second package."""
    done = subprocess.run([sys.executable, "-m", "ldbench", "check", "."], cwd=folder, capture_output=True, text=True, timeout=HANG,
                          env=bare_environment())
    assert not (folder/"run").exists(), done.stderr
    assert done.returncode == 1 and "Traceback" not in done.stderr and "ex2_aw" in done.stdout + done.stderr


def test_a_path_that_the_user_gives_stays(folder: Path):
    """PYTHONPATH is the user's own word, and a script has its folder."""
    code = "import sys; first = sys.path[0]; import ldbench; print('/own' in sys.path, sys.path[0] == first)"
    done = subprocess.run([sys.executable, "-c", code], cwd=folder.parent, capture_output=True, text=True, timeout=HANG,
                          env={"PYTHONPATH": "/own", "PATH": ""})
    assert done.stdout == "True True\n", done.stderr
