"""What an installation holds and asks for: optional packages, data files, the version."""
from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ldbench import Case, Error
from ldbench.__main__ import main
from ldbench._core.optional import needed
from ldbench.report import abstract
from ldbench.results.columns import read_toml
from ldbench.viewer import page
from ldbench_round import horizon
from running import CASES, HANG, LDBENCH, REPO, environment, short_case

PROJECT = read_toml(REPO/"pyproject.toml")["project"]


# ---- optional packages ---------------------------------------------------------------
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
    Path("case.nml").write_text("&table file = '' /\n")
    monkeypatch.setitem(sys.modules, module, None)
    assert main(command) == 1
    said = capsys.readouterr()
    assert re.fullmatch(rf"ldbench: error: needs \S+, which is not installed: pip install 'ldbench\[{extra}\]'\n", said.err)
    assert said.out == "" and [path.name for path in tmp_path.iterdir()] == ["case.nml"]
    package = re.search(r"needs ([\w-]+)", said.err)[1]
    assert any(package in requirement for requirement in PROJECT["optional-dependencies"][extra])


@pytest.mark.parametrize(("program", "module"), [("validation", "scipy"), ("bench", "scipy")])
def test_checks_say_what_they_lack(program, module, tmp_path):
    script = (f"import runpy, sys; sys.modules[{module!r}] = None; "
              f"runpy.run_path({str(REPO/'tests'/program)!r}, run_name='__main__')")
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, env=environment(), capture_output=True, text=True,
                          timeout=HANG)
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


def test_version_has_one_place():
    """The core says it and Meson reads it there; copies in files that cannot read agree."""
    version = subprocess.run([LDBENCH, "--version"], capture_output=True, text=True).stdout.split()[1]
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
    assert {str(file.relative_to(packages)) for file in (abstract.TEMPLATE, page.FOLDER/"page.html", horizon.FILE,
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


# ---- bootstrap and make --------------------------------------------------------------
def stand_in(file: Path, script: str) -> None:
    """A program of the test's own."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"#!{shutil.which('bash')}\n{script}")
    file.chmod(0o755)


def take_from_system(folder: Path, *names: str) -> None:
    for name in names:
        (folder/name).symlink_to(shutil.which(name))


# A user without rights, whose sudo forgets the environment; the lists' lock is held once, one download breaks off.
APT = """
echo "apt-get $* http_proxy=$http_proxy no_proxy=$no_proxy" >>"$LOG"
n=$(grep -c . "$LOG")
[ "$n" -ne 1 ] || { echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 7 (apt-get)"; exit 100; }
[ "$n" -ne 2 ] || { echo "E: Failed to fetch http://mirror/x.deb  Hash Sum mismatch"; exit 100; }
case "$*" in *install*) ln -s cc "$(dirname "$0")/gfortran" ;; esac
"""
PYTHON = """
case "$1 $2" in
  "-c "*ensurepip*) echo "$0" ;;
  "-m venv") mkdir -p "$3/bin"; cp "$0" "$3/bin/python" ;;
  "-m pip") case "$3" in
    install) echo "pip $* PIP_CERT=$PIP_CERT PIP_CONFIG_FILE=$PIP_CONFIG_FILE https_proxy=$https_proxy" >>"$LOG"
      [ $(grep -c '^pip' "$LOG") -gt 1 ] || { echo "THESE PACKAGES DO NOT MATCH THE HASHES"; exit 1; } ;;
    esac ;;
esac
"""


@pytest.fixture
def bootstrap(tmp_path):
    """Run a copy of bootstrap where only these programs are; gfortran comes with apt-get. The process and a log."""
    programs = tmp_path/"bin"
    programs.mkdir()
    take_from_system(programs, "bash", "env", "mktemp", "rm", "cat", "tr", "grep", "dirname", "mkdir", "cp", "ln")
    log = tmp_path/"log"
    for name, script in (("cc", "exit 0"), ("make", ""), ("pkg-config", ""), ("apt-get", APT), ("id", "echo 1000"),
                         ("sleep", 'echo "sleep" >>"$LOG.sleep"'), ("sudo", '[ "$1" = -n ] || env -i PATH="$PATH" LOG="$LOG" "$@"'),
                         ("python3", PYTHON)):
        stand_in(programs/name, script)
    shutil.copy(REPO/"bootstrap", tmp_path)
    (tmp_path/"requirements.txt").write_text("a-package==1.0\n")

    def run(**environment: str) -> tuple[subprocess.CompletedProcess[str], list[str]]:
        done = subprocess.run([tmp_path/"bootstrap"], env={"PATH": str(programs), "LOG": str(log), **environment},
                              capture_output=True, text=True, timeout=HANG)
        return done, log.read_text().splitlines() if log.exists() else []

    return run


def test_bootstrap_waits_for_apt_retries_and_keeps_proxies_and_certificates(bootstrap, tmp_path):
    done, log = bootstrap(http_proxy="http://proxy:3128", https_proxy="http://proxy:3129", no_proxy="localhost",
                          PIP_CERT="/etc/own.pem", PIP_CONFIG_FILE="/etc/own.conf")
    assert done.returncode == 0, done.stdout + done.stderr
    apt = [line for line in log if line.startswith("apt-get")]
    assert ["update" in line for line in apt] == [True, True, True, False] and "install -y gfortran" in apt[-1]
    assert all("-o DPkg::Lock::Timeout=600" in line for line in apt)
    assert all(line.endswith("http_proxy=http://proxy:3128 no_proxy=localhost") for line in apt)
    pip = [line for line in log if line.startswith("pip")]
    assert len(pip) == 2 and pip[0] == pip[1]
    assert pip[0].endswith("PIP_CERT=/etc/own.pem PIP_CONFIG_FILE=/etc/own.conf https_proxy=http://proxy:3129")
    assert Path(f"{tmp_path}/log.sleep").read_text() == "sleep\n"       # for the lock, not for the download
    again, log_then = bootstrap()
    assert again.returncode == 0 and ".venv is up to date" in again.stdout and log_then == log


def test_bootstrap_gives_up_what_fails_twice(bootstrap, tmp_path):
    stand_in(tmp_path/"bin/apt-get", 'echo "E: no network"; echo x >>"$LOG"; exit 100')
    done, log = bootstrap()
    assert done.returncode == 1 and len(log) == 2 and "E: no network\nbootstrap: installation failed\n" == done.stderr
    assert not (tmp_path/".venv").exists()


@pytest.mark.skipif(not shutil.which("flock"), reason="two makes at once need flock")
def test_two_makes_at_once_build_everything_once(tmp_path):
    """Whichever comes first: the compiler is only at work while its make has the lock."""
    for folder in ("fortran", "tests/fortran"):
        shutil.copytree(REPO/folder, tmp_path/folder)
    shutil.copy(REPO/"Makefile", tmp_path)
    stand_in(tmp_path/"compiler", """
while [ $# -gt 0 ] && [ "$1" != -o ]; do shift; done
[ "$1" = -o ] || exit 0
flock -n build/lock true && echo "no lock" >>log
echo "$2" >>log
: >"$2"
""")
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    makes = [subprocess.Popen(["make", "FC=./compiler"], cwd=tmp_path, env=environment, stdout=subprocess.DEVNULL) for _ in "ab"]
    assert [make.wait(HANG) for make in makes] == [0, 0]
    made = (tmp_path/"log").read_text().splitlines()
    assert len(made) == len(set(made)) > 40 and "no lock" not in made
    assert (tmp_path/"ldbench").exists()
