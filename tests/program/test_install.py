"""What an installation holds and asks for: optional packages, data files, the version."""
from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

import ldbench
from imports import imported
from ldbench import Case, Error
from ldbench.__main__ import main
from ldbench.report import abstract
from ldbench.results.columns import read_toml
from ldbench.viewer import page
from ldbench_round import own_runs
from running import CASES, HANG, LDBENCH, REPO, header

PROJECT = read_toml(REPO/"pyproject.toml")["project"]
NOBODY = 65534       # user and group without rights


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
COMMANDS = {"meson", "ninja", "pytest-randomly", "pytest-xdist", "ruff", "mypy", "codespell"}


def package_name(text: str) -> str:
    """The package of a requirement or of a module."""
    usual = re.match(r"[\w.-]+", text)[0].lower().replace("_", "-")
    return {"PIL": "pillow", "skfem": "scikit-fem", "mesonpy": "meson-python"}.get(text, usual)


def packages_of(*folders: str) -> set[str]:
    """Packages of others that the programs of some folders import, also by `needed`."""
    files = [file for folder in folders for file in (REPO/folder).rglob("*.py")]
    found = {module for file in files for module, _ in imported(file)}
    found |= {name for file in files for name in re.findall(r"\bneeded\(\"(\w+)\"", file.read_text(encoding="utf-8"))}
    own = {file.stem for folder in EVERYWHERE for file in (REPO/folder).rglob("*.py")} | {"ldbench", "ldbench_round"}
    return {package_name(name) for name in {name.partition(".")[0] for name in found} - own - sys.stdlib_module_names} - TYPES


def test_what_is_imported_is_declared_and_the_reverse():
    """pyproject.toml names what the packages import; requirements.txt besides what tests and docs import, and commands."""
    extras = [requirement for some in PROJECT["optional-dependencies"].values() for requirement in some]
    declared = {package_name(name) for requirement in PROJECT["dependencies"] + extras
                for name in re.findall(r"[\w-]+", re.split("[>;]", requirement)[0])}
    assert packages_of("wrappers") == declared | {"meson-python"}       # which pip installs to build
    installed = set(map(package_name, (REPO/"requirements.txt").read_text().splitlines()[1:]))
    elsewhere = {"sphinx", "exudyn"}        # of environments of their own
    assert packages_of(*EVERYWHERE) - elsewhere == installed - COMMANDS and installed >= COMMANDS


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
    there = {str(path.relative_to(packages)) for path in packages.glob("*/**/*") if path.is_file()
             and not {"__pycache__", "fmu"} & set(path.parts) and path.suffix not in (".so", ".f90")
             and not path.name.startswith(".")}
    assert {str(Path(name)) for name in listed} == there
    assert {str(file.relative_to(packages)) for file in (abstract.TEMPLATE, page.FOLDER/"page.html", own_runs.FILE,
                                                         packages/"ldbench/py.typed")} <= there
    assert PROJECT["license-files"] == ["LICENSE"] and (REPO/"LICENSE").is_file()


def contents(folder: Path) -> dict[str, tuple[int, int, bytes]]:
    """All that lies below a folder: mode, time, bytes."""
    return {str(path): (path.stat().st_mode, path.stat().st_mtime_ns, path.read_bytes() if path.is_file() else b"")
            for path in (folder, *folder.rglob("*"))}


@dataclass
class Installed:
    """What `make install` and Meson have put below a prefix, and the home of a user who may write nothing there."""

    root: Path
    home: Path

    @property
    def share(self) -> Path:
        return self.root/"usr/share/ldbench"

    def run(self, *command: object, cwd: Path | None = None, home: Path | None = None, **streams: object,
            ) -> subprocess.CompletedProcess[str]:
        """Run an installed program as the user: 'ldbench' by its name, 'python' with the installed package. Python itself, and what
        the package imports, may be where root alone reads."""
        rights = []
        if os.geteuid() == 0:
            reading = ["--inh-caps=+dac_read_search", "--ambient-caps=+dac_read_search"] if command[0] == "python" else []
            rights = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups", *reading]
        packages = next(self.root.rglob("ldbench/__init__.py")).parents[1]
        environment = {"PATH": f"{self.root}/usr/bin:{os.environ['PATH']}", "HOME": str(home or self.home), "OMP_NUM_THREADS": "1",
                       "PYTHONPATH": str(packages)}
        return subprocess.run([*rights, *([sys.executable] if command[0] == "python" else command[:1]), *command[1:]],
                              cwd=cwd or self.home, env=environment, capture_output=True, text=True, timeout=HANG, **streams)

    def new_folder(self, name: str) -> Path:
        """A folder of the user's."""
        folder = self.home/name
        folder.mkdir()
        if os.geteuid() == 0:
            os.chown(folder, NOBODY, NOBODY)
        return folder


@pytest.fixture(scope="module")
def prefix() -> Iterator[Installed]:
    """An installation that cannot be written, and is not at the end of the tests. Names of folders have blanks."""
    if os.geteuid() == 0 and not shutil.which("setpriv"):
        pytest.skip("no setpriv, by which root becomes a user without rights")
    # Other users may not enter the folder of pytest.
    with tempfile.TemporaryDirectory(prefix="ldbench ", dir="/tmp") as name:
        Path(name).chmod(0o755)
        installed = Installed(Path(name)/"the root", Path(name)/"the home")
        installed.home.mkdir()
        if os.geteuid() == 0:
            os.chown(installed.home, NOBODY, NOBODY)
        meson = Path(sys.executable).with_name("meson"), "install", "-C", "build/wrapper", "--no-rebuild", "--quiet"
        for command in ("make", "install", f"DESTDIR={installed.root}", "PREFIX=/usr"), (*meson, "--destdir", installed.root):
            subprocess.run(command, cwd=REPO, check=True, stdout=subprocess.DEVNULL)
        for path in (installed.root, *installed.root.rglob("*")):
            path.chmod(path.stat().st_mode & ~0o222)
        before = contents(installed.root)
        yield installed
        after = contents(installed.root)
        for path in filter(Path.is_dir, (installed.root, *installed.root.rglob("*"))):
            path.chmod(0o755)
        assert after == before


def ways(installed: Installed, file: Path) -> dict[str, Callable[[Path], subprocess.CompletedProcess[str]]]:
    """How a case is run in a folder."""
    api = "import sys, ldbench; print(ldbench.run(sys.argv[1]).write())"
    return {"standard input": lambda folder: installed.run("ldbench", cwd=folder, input=file.read_text()),
            "executable": lambda folder: installed.run("ldbench", file, cwd=folder),
            "command": lambda folder: installed.run("python", "-m", "ldbench", "run", file, cwd=folder),
            "Python": lambda folder: installed.run("python", "-c", api, file, cwd=folder)}


@pytest.mark.same_build
@pytest.mark.parametrize("case", [pytest.param(case, marks=[] if case == "ex3_sw" else pytest.mark.slow) for case in CASES])
def test_installed_cases_run_for_a_user_without_rights(case: str, prefix: Installed):
    """From standard input, by its path, by the command and in Python: the results and tables are in the user's folder, and all of
    these have the same bytes."""
    assert sorted(path.stem for path in (prefix.share/"inputs").iterdir()) == sorted(CASES)
    folder = prefix.new_folder(f"my {case}")
    columns = folder/"outputs"/f"{case}.txt"
    found = set()
    for way, start in ways(prefix, prefix.share/"inputs"/f"{case}.nml").items():
        done = start(folder)
        assert (done.returncode, done.stderr) == (0, ""), way
        found.add(columns.read_bytes())
        columns.unlink()
    assert len(found) == 1
    assert [path.suffix for path in (folder/"outputs").rglob("*")] == ["", ".table"] and not (prefix.home/".cache").exists()


@pytest.mark.slow
@pytest.mark.same_build
def test_installed_commands_for_a_user_without_rights(prefix: Installed):
    """The report of the ten cases, the page of two of them and an ensemble are made in the user's folder."""
    folder = prefix.new_folder("my round")
    for command, made in (
            (["report"], ["ldbench_plots.pdf", "ldbench_abstract.pdf", "ldbench_results.html", "summary.csv"]),
            (["view", "outputs/ex1_aw.txt", "outputs/ex2_aw.txt", "-o", "page.html"], ["../page.html"]),
            (["ensemble", "inputs/ex2_aw.nml", "--set", "roll_link=rails", "--over", "vY=0.4,0.5", "-o", "sweep.zarr", "--picture",
              "sweep.pdf"], ["../sweep.zarr", "../sweep.pdf"])):
        done = prefix.run("python", "-m", "ldbench", *command, cwd=folder)
        assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
        assert all((folder/"outputs"/name).exists() for name in made)
    assert sorted(path.stem for path in (folder/"outputs").glob("ex*.txt")) == sorted(CASES)


SHORT = "&integrator t_end = 1e-3 / &contact model = 'hertz' / &output file = 'outputs/columns.txt' /\n"
UNKEPT = r"ldbench: warning: &table folder: outputs/tables/hertz_\w+\.table: cannot be written; .*\n"
LEAST = "--set", "t_end=1e-3", "--set", "model=hertz", "-o"
PROFILES = """
import ldbench
wheel = ldbench.Profile("profiles/awprof.yz")
print(wheel.path)
print(ldbench.run(ldbench.Case(t_end=1e-3, model="hertz", wheel_profile=wheel)).case.wheel_profile == wheel.path)
"""
# A run whose table goes to the cache, or is not kept; and one with a smoothed wheel, which cannot do without a file.
READ_ONLY = """
import ldbench
case = ldbench.Case.from_namelist("inputs/ex1_aw.nml").replace(model="hertz", t_end=1e-3)
print(ldbench.run(case).table.lines()[-1])
wheel = ldbench.Profile("profiles/awprof.yz", smoothing=0.01)
print(ldbench.run(case.replace(wheel_profile=wheel, table_folder="")).case.wheel_profile)
"""


@pytest.mark.same_build
def test_shipped_names_serve_anywhere(prefix: Installed):
    """An installed input and an installed profile have short names in any folder, also where a link leads to the executable."""
    folder = prefix.new_folder("short names")
    (prefix.new_folder("bin")/"linked").symlink_to(prefix.root/"usr/bin/ldbench")
    short = SHORT.replace("outputs/", "")
    for start in "ldbench", "../bin/linked", str(prefix.home/"bin/linked"):
        done = prefix.run(start, cwd=folder, input=short)
        assert (done.returncode, done.stderr) == (0, ""), start
    assert prefix.run("ldbench", "inputs/none.nml", cwd=folder).stderr == (
        "ldbench: error: inputs/none.nml: cannot be opened for reading; looked for in the working folder, "
        f"in {prefix.share}\n")
    told = prefix.run("python", "-c", PROFILES, cwd=folder)
    assert told.stdout.split("\n")[:2] == [str(next(prefix.root.rglob("data/profiles/awprof.yz"))), "True"], told.stderr
    done = prefix.run("python", "-m", "ldbench", "run", "inputs/ex1_aw.nml", *LEAST, "mine.txt", cwd=folder)
    assert done.returncode == 0 and (folder/"mine.txt").is_file(), done.stderr


@pytest.mark.same_build
def test_a_read_only_folder_is_not_written(prefix: Installed):
    """Results cannot go there: one line says what to do. What saves time goes to the user's cache, or one line says that it is not
    kept; runs have the same results."""
    share, folder, none = prefix.share, prefix.new_folder("read-only"), Path("/none")
    for start in ("ldbench", "inputs/ex1_aw.nml"), ("python", "-m", "ldbench", "run", "inputs/ex1_aw.nml"):
        done = prefix.run(*start, cwd=share)
        assert done.returncode == 1 and done.stderr.count("\n") == 1
        assert done.stderr.endswith("&output file: expected a path that can be written, found outputs/ex1_aw.txt; go to a folder "
                                    "where you may write, or name a file in one\n")
    text = f"&table folder = 'outputs/tables' / {SHORT}".replace("outputs/columns", f"{folder}/columns")
    rows = []
    for home, work in (folder, "[1-9][0-9]* solutions, 0 found"), (folder, "0 solutions, [1-9][0-9]* found"), (none, ""):
        done = prefix.run("ldbench", cwd=share, input=text, home=home)
        assert done.returncode == 0
        if work:
            told = done.stdout.replace("\n  ", " ")
            assert re.search(rf"^contact table: {work}; kept in {folder}/.cache/ldbench$", told, re.MULTILINE), told
            assert done.stderr == "" and len(list(folder.rglob("*.table"))) == 1
        else:
            assert re.fullmatch(UNKEPT, done.stderr)
        rows.append((folder/"columns.txt").read_bytes())
    assert rows[0] == rows[1] == rows[2]
    done = prefix.run("python", "-c", READ_ONLY, cwd=share, home=folder)
    kept, made, _ = done.stdout.split("\n")
    assert kept.endswith(f"found, kept in {folder}/.cache/ldbench") and not done.stderr, done.stderr
    assert re.fullmatch(rf"{folder}/\.cache/ldbench/awprof-\w+\.yz", made)
    done = prefix.run("python", "-c", READ_ONLY, cwd=share, home=none)
    assert done.stdout.endswith(", 0 found, not kept\n")
    assert done.stderr.count("Warning: &table folder: outputs/tables/hertz_") == 1
    assert done.stderr.endswith(
        "Error: outputs/profiles: cannot be made: Permission denied; go to a folder where you may write, or name another one\n")
    done = prefix.run("python", "-m", "ldbench", "run", "inputs/ex1_aw.nml", *LEAST, folder/"made.txt", cwd=share, home=none)
    assert re.fullmatch(UNKEPT, done.stderr) and (folder/"made.txt").is_file()


def checksums(text: str) -> list[str]:
    """The checksums of the profiles that a run was made with, by its header."""
    return re.findall(r"profile: .* ([0-9A-F]{8})", text)


@pytest.mark.same_build
def test_one_rule_where_files_are_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """In the working folder, beside the namelist, in the folder above, among the shipped: the executable and Python find the same
    one of these, each of which has another checksum, and a message names them all."""
    here, inputs = tmp_path/"here", tmp_path/"my study/inputs"
    places = [here, inputs, inputs.parent]
    for number, place in enumerate(places):
        (place/"profiles").mkdir(parents=True)
        for name in "mine.yz", "awprof.yz":
            (place/"profiles"/name).write_text(f"# {number}\n{(REPO/'profiles/awprof.yz').read_text()}")
    monkeypatch.chdir(here)
    for name in "awprof.yz", "mine.yz":
        (inputs/f"{name}.nml").write_text(
            f"&profiles wheel_profile = 'profiles/{name}' / &contact formulation = 'unilateral' / "
            "&integrator t_end = 1e-3 / &output file = 'columns.txt' rows = 'interval' /")
    seen = []
    for place in (*places, REPO):
        done = subprocess.run([LDBENCH, inputs/"awprof.yz.nml"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        by_program = header(here/"columns.txt")
        ldbench.run(inputs/"awprof.yz.nml").write("python.txt")
        assert checksums(by_program) == checksums(header(here/"python.txt"))
        assert Case.from_namelist(inputs/"awprof.yz.nml").find("profiles/awprof.yz") == str(
            "profiles/awprof.yz" if place == here else place/"profiles/awprof.yz")
        seen.append(checksums(by_program)[0])
        if place != REPO:
            shutil.rmtree(place/"profiles")
    assert len(set(seen)) == 4
    message = (f"{inputs}/mine.yz.nml, &profiles wheel_profile: profiles/mine.yz: cannot be opened for reading; looked for in the "
               f"working folder, in {inputs}, in {inputs.parent}, in {REPO}")
    done = subprocess.run([LDBENCH, inputs/"mine.yz.nml"], capture_output=True, text=True)
    assert done.stderr == f"ldbench: error: {message}\n"
    with pytest.raises(Error) as told:
        ldbench.run(inputs/"mine.yz.nml")
    assert str(told.value) == message and isinstance(told.value, FileNotFoundError)
    with pytest.raises(FileNotFoundError, match=r"none\.yz: cannot be opened for reading; looked for in the working folder, in "):
        ldbench.Profile("none.yz")


def test_a_profile_beside_the_namelist_is_not_written_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """A profile that is found there, by a name that leads nowhere from the working folder."""
    wheel = tmp_path/"wheel.yz"
    shutil.copy(REPO/"profiles/awprof.yz", wheel)
    (tmp_path/"case.nml").write_text(f"&profiles wheel_profile = 'wheel.yz' / &output file = '{wheel}' /")
    (tmp_path/"here").mkdir()
    monkeypatch.chdir(tmp_path/"here")
    done = subprocess.run([LDBENCH, "../case.nml"], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1) and "which is &profiles wheel_profile" in done.stderr
    with pytest.raises(Error, match="which is &profiles wheel_profile"):
        Case.from_namelist("../case.nml")
    assert wheel.read_bytes() == (REPO/"profiles/awprof.yz").read_bytes()


def test_shipped_inputs_are_found_from_any_folder(tmp_path, monkeypatch):
    """Unless the folder has one of its own."""
    monkeypatch.chdir(tmp_path)
    assert Case.from_namelist("inputs/ex4_sw.nml") == Case.exercise(4, "sw")
    Path("inputs").mkdir()
    Path("inputs/ex4_sw.nml").write_text("&initial vY = 0.25 /\n")
    assert Case.from_namelist("inputs/ex4_sw.nml").vY == 0.25
    with pytest.raises(Error, match=r"inputs/ex6_sw\.nml"):
        Case.from_namelist("inputs/ex6_sw.nml")
