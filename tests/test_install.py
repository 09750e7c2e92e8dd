"""What an installation holds and asks for: optional packages, data files, the version."""
from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from ldbench.__main__ import main
from ldbench._core import needed
from ldbench import Case, Error, abstract
from ldbench.columns import _read_toml

from conftest import HANG, LDBENCH, REPO

PROJECT = _read_toml(REPO/"pyproject.toml")["project"]


# ---- optional packages ---------------------------------------------------------------
@pytest.mark.parametrize(("module", "extra", "command"), [
    ("typst", "report", ["report", "--outputs", "made"]),
    ("xarray", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500"]),
    ("zarr", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500", "--store", "made"]),
    ("distributed", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500", "--scheduler", "tcp://127.0.0.1:9"]),
    ("imageio_ffmpeg", "view", ["view", str(REPO/"outputs/reference/ex1_aw.txt"), "--film", "made.mp4"]),
])
def test_missing_package_is_one_line_with_the_command(module, extra, command, tmp_path, monkeypatch, capsys):
    """Before any work: nothing is made."""
    monkeypatch.chdir(tmp_path)
    Path("case.nml").write_text("&table file = '' /\n")
    monkeypatch.setitem(sys.modules, module, None)
    assert main(command) == 1
    said = capsys.readouterr()
    assert re.fullmatch(rf"ldbench: error: needs \S+, which is not installed: pip install 'ldbench\[{extra}\]'\n", said.err)
    assert said.out == "" and [path.name for path in tmp_path.iterdir()] == ["case.nml"]
    package = re.search(r"needs ([\w-]+)", said.err)[1]
    assert any(package in requirement for requirement in PROJECT["optional-dependencies"][extra])


@pytest.mark.parametrize(("program", "module"), [("validation", "scipy"), ("bench", "scipy"), ("bench", "sksundae")])
def test_checks_say_what_they_lack(program, module, tmp_path):
    script = f"import runpy, sys; sys.modules[{module!r}] = None; runpy.run_path({str(REPO/'tests'/program)!r}, run_name='__main__')"
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=HANG)
    assert done.returncode == 1 and done.stdout == "" and not list(tmp_path.iterdir())
    assert re.fullmatch(r"ldbench: error: needs \S+, which is not installed: pip install 'ldbench\[validate\]'\n", done.stderr)


def test_fault_inside_a_package_is_not_taken_for_its_absence(tmp_path, monkeypatch):
    (tmp_path/"faulty_package.py").write_text("import no_such_module_at_all\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="no_such_module_at_all"):
        needed("faulty_package", "view")
    with pytest.raises(Error, match="needs no-such-package, which"):
        needed("no_such_package", "view", "no-such-package")


# ---- version and data ----------------------------------------------------------------
def test_version_is_that_of_the_executable(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0
    assert capsys.readouterr().out == subprocess.run([LDBENCH, "--version"], capture_output=True, text=True).stdout


def test_data_files_of_the_report_are_installed():
    """Inputs, profiles and the abstract's text; the license."""
    build = (REPO/"meson.build").read_text()
    for folder in ("inputs", "profiles", abstract.TEMPLATE.parent.relative_to(REPO)):
        assert f"install_subdir('{folder}', install_dir: data)" in build
    assert PROJECT["license-files"] == ["LICENSE"] and (REPO/"LICENSE").is_file()


def test_shipped_inputs_are_found_from_any_folder(tmp_path, monkeypatch):
    """Unless the folder has one of its own."""
    monkeypatch.chdir(tmp_path)
    assert Case.from_namelist("inputs/ex4_sw.nml") == Case.exercise(4, "sw")
    Path("inputs").mkdir()
    Path("inputs/ex4_sw.nml").write_text("&initial vY = 0.25 /\n")
    assert Case.from_namelist("inputs/ex4_sw.nml").vY == 0.25
    with pytest.raises(Error, match="inputs/ex6_sw.nml"):
        Case.from_namelist("inputs/ex6_sw.nml")
