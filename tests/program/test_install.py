"""What an installation holds and asks for: optional packages, data files, the version."""
from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from ldbench import Case, Error
from ldbench.__main__ import main
from ldbench.report import abstract
from ldbench.results.columns import read_toml
from ldbench.viewer import page
from ldbench_round import own_runs
from running import CASES, LDBENCH, REPO, short_case

PROJECT = read_toml(REPO/"pyproject.toml")["project"]


@pytest.mark.parametrize(("module", "extra", "command"), [
    ("typst", "report", ["report", "-o", "made"]),
    ("xarray", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500"]),
    ("zarr", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500", "-o", "made"]),
    ("distributed", "ensemble", ["ensemble", "case.nml", "--over", "mass=1400,1500", "--scheduler", "tcp://127.0.0.1:9"]),
    ("shtab", "completion", ["--completion", "bash"]),
    ("imageio_ffmpeg", "view", ["view", str(REPO/"outputs/reference/ex1_aw.txt"), "-o", "made.mp4"]),
])
def test_missing_package_is_one_line_with_the_command(module, extra, command, tmp_path, monkeypatch, capsys):
    """Before any work: nothing is made."""
    monkeypatch.chdir(tmp_path)
    Path("case.nml").write_text("&table folder = '' /\n")
    monkeypatch.setitem(sys.modules, module, None)
    assert main(command) == 1
    said = capsys.readouterr()
    assert re.fullmatch(rf"ldbench: error: needs \S+, which is not installed: pip install 'ldbench\[{extra}\]'\n", said.err)
    assert said.out == "" and [path.name for path in tmp_path.iterdir()] == ["case.nml"]
    package = re.search(r"needs ([\w-]+)", said.err)[1]
    assert any(package in requirement for requirement in PROJECT["optional-dependencies"][extra])


EVERYWHERE = "wrappers", "tests", "docs", "profiles"
# Imported for types alone, by names that mypy brings.
TYPES = {"-typeshed", "typing-extensions"}
# Run as commands or as plug-ins of pytest, and imported by nobody.
COMMANDS = {"meson", "meson-python", "ninja", "pytest-randomly", "pytest-xdist", "ruff", "mypy", "codespell"}


def package_name(text: str) -> str:
    """The package of a requirement or of a module."""
    return {"PIL": "pillow", "skfem": "scikit-fem"}.get(text, re.match(r"[\w.-]+", text)[0].lower().replace("_", "-"))


def imported(*folders: str) -> set[str]:
    """Packages of others that the programs of some folders import, also by `needed`."""
    sources = [file.read_text(encoding="utf-8") for folder in folders for file in (REPO/folder).rglob("*.py")]
    found = set()
    for node in (node for source in sources for node in ast.walk(ast.parse(source))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found.add(node.module)
        elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "needed":
            found.add(node.args[0].value)
    own = {file.stem for folder in EVERYWHERE for file in (REPO/folder).rglob("*.py")} | {"ldbench", "ldbench_round"}
    return {package_name(name) for name in {name.partition(".")[0] for name in found} - own - sys.stdlib_module_names} - TYPES


def test_what_is_imported_is_declared_and_the_reverse():
    """pyproject.toml names what the packages import; requirements.txt besides what tests and docs import, and commands."""
    extras = [requirement for some in PROJECT["optional-dependencies"].values() for requirement in some]
    declared = {package_name(name) for requirement in PROJECT["dependencies"] + extras
                for name in re.findall(r"[\w-]+", re.split("[>;]", requirement)[0])}
    assert imported("wrappers") == declared
    installed = set(map(package_name, (REPO/"requirements.txt").read_text().splitlines()[1:]))
    sphinx = {"sphinx"}         # of the tools, which have an environment of their own
    assert imported(*EVERYWHERE) - sphinx == installed - COMMANDS and installed >= COMMANDS


def test_version_has_one_place(capsys):
    """The core says it, the package repeats it and Meson reads it there; copies in files that cannot read agree."""
    said = subprocess.run([LDBENCH, "--version"], capture_output=True, text=True).stdout
    with pytest.raises(SystemExit) as end:
        main(["--version"])
    assert end.value.code == 0 and capsys.readouterr().out == said
    version = said.split()[1]
    built = json.loads((REPO/"build/wrapper/meson-info/intro-projectinfo.json").read_text())
    assert built["version"] == version and PROJECT["dynamic"] == ["version"]
    for file, place in (("CITATION.cff", rf"^version: {version}$"), ("CHANGELOG.md", rf"\A# Changelog\n\n## {version}\b"),
                        ("fortran/support/windows/ldbench.manifest", rf'name="ldbench" version="{version}\.0"'),
                        (".ci/recipe/meta.yaml", rf'set version = "{version}"')):
        assert re.search(place, (REPO/file).read_text(), re.MULTILINE), file


def test_data_files_are_installed():
    """Inputs and profiles; every file of both packages, the page's scripts and the abstract's words among them; the license."""
    build = (REPO/"meson.build").read_text()
    for folder in "inputs", "profiles":
        assert f"install_subdir('{folder}', install_dir: data)" in build
    found = re.search(r"run_command\('sh', '-c', '''(.*?)'''", build, re.DOTALL)
    listed = subprocess.run(["sh", "-c", found[1]], cwd=REPO, capture_output=True, text=True, check=True).stdout.split()
    packages = REPO/"wrappers"
    there = {str(path.relative_to(packages)) for path in packages.rglob("*") if path.is_file() and "__pycache__" not in path.parts
             and path.suffix not in (".so", ".f90") and not path.name.startswith(".")}
    assert {str(Path(name)) for name in listed} == there
    assert {str(file.relative_to(packages)) for file in (abstract.TEMPLATE, page.FOLDER/"page.html", own_runs.FILE,
                                                         packages/"ldbench/py.typed")} <= there
    assert PROJECT["license-files"] == ["LICENSE"] and (REPO/"LICENSE").is_file()


@pytest.mark.same_build
def test_install_below_a_folder_of_packages(tmp_path):
    """make install puts what will run from PREFIX below DESTDIR; the installed executable runs an installed case there."""
    root = tmp_path/"two words"
    subprocess.run(["make", "install", f"DESTDIR={root}", "PREFIX=/usr"], cwd=REPO, check=True, stdout=subprocess.DEVNULL)
    share = root/"usr/share/ldbench"
    assert sorted(path.stem for path in (share/"inputs").iterdir()) == sorted(CASES)
    case = short_case(Path("outputs"), profiles={"wheel_profile": "profiles/awprof.yz", "rail_profile": "profiles/arprof.yz"})
    done = subprocess.run([root/"usr/bin/ldbench"], input=case, cwd=share, capture_output=True, text=True)
    assert done.returncode == 0 and (share/"outputs/columns.txt").is_file(), done.stderr


def test_shipped_inputs_are_found_from_any_folder(tmp_path, monkeypatch):
    """Unless the folder has one of its own."""
    monkeypatch.chdir(tmp_path)
    assert Case.from_namelist("inputs/ex4_sw.nml") == Case.exercise(4, "sw")
    Path("inputs").mkdir()
    Path("inputs/ex4_sw.nml").write_text("&initial vY = 0.25 /\n")
    assert Case.from_namelist("inputs/ex4_sw.nml").vY == 0.25
    with pytest.raises(Error, match=r"inputs/ex6_sw\.nml"):
        Case.from_namelist("inputs/ex6_sw.nml")
