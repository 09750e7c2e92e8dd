"""The executable for Windows under wine: `make test-windows`, which also runs the ten inputs and the refusals."""
from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from running import HANG, LDBENCH, REPO, WINDOWS, columns, rows, run_case, short_case

pytestmark = pytest.mark.skipif(not WINDOWS, reason="only by make test-windows")

EXE = REPO/"ldbench.exe"


def windows_path(path: Path) -> str:
    """wine has the root of the file system as drive Z."""
    return "Z:" + str(path).replace("/", "\\")


def test_no_library_lies_beside_the_executable():
    headers = subprocess.run(["x86_64-w64-mingw32-objdump", "-p", EXE], capture_output=True, text=True, check=True).stdout
    assert {line.split()[-1] for line in headers.splitlines() if "DLL Name:" in line} == {"KERNEL32.dll", "msvcrt.dll"}


@pytest.mark.parametrize("name", ["columns.txt", r"outputs\columns.txt", r"outputs\two words é.txt", r"{}\columns.txt",
                                  r"{}\a folder\columns.txt"])
def test_paths_of_windows(name: str, tmp_path: Path):
    """Drive letters, backslashes, blanks and UTF-8; lines of the input end with CRLF. An earlier file is replaced."""
    (tmp_path/"a folder").mkdir()
    name = name.format(windows_path(tmp_path))
    profiles = {f"{what}_profile": windows_path(REPO/f"profiles/a{what[0]}prof.yz") for what in ("wheel", "rail")}
    text = short_case(tmp_path, profiles=profiles, output={"file": name}).replace("\n", "\r\n")
    target = tmp_path/name.removeprefix(windows_path(tmp_path) + "\\").replace("\\", "/")
    for _ in range(2):
        done = run_case(text, tmp_path, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (0, "") and f"columns: {name}, 21 rows" in done.stdout
        assert len(rows(target)) > 1000 and [path.name for path in target.parent.glob("*.txt*")] == [target.name]
        assert b"\r" not in target.read_bytes()


@pytest.mark.parametrize("victim", ["CASE.NML", "{}\\case.nml", r".\case.nml"])
def test_names_in_capitals_are_the_same(victim: str, tmp_path: Path):
    victim = victim.format(windows_path(tmp_path))
    done = run_case(short_case(tmp_path, output={"file": victim}), tmp_path, cwd=tmp_path)
    assert done.returncode == 1 and f"found {victim}, which is the namelist itself" in done.stderr


def test_redirection_of_the_command_line(tmp_path: Path):
    """As in cmd: an input, the summary and the message of an error go where it says; the input is not written over."""
    def cmd(line: str) -> int:
        return subprocess.run(["wine", "cmd", "/c", line], cwd=tmp_path, timeout=HANG, stdin=subprocess.DEVNULL).returncode

    (tmp_path/"case.nml").write_text(short_case(Path(), output={"file": "columns.txt"}))
    assert cmd(f"{windows_path(EXE)} < case.nml > said.txt 2> failed.txt") == 0
    assert b"columns: columns.txt, 21 rows\n" in (tmp_path/"said.txt").read_bytes() and not (tmp_path/"failed.txt").read_bytes()
    text = short_case(Path(), output={"file": "case.nml"})
    (tmp_path/"case.nml").write_text(text)
    assert cmd(f"{windows_path(EXE)} < case.nml > said.txt 2> failed.txt") == 1
    assert (tmp_path/"failed.txt").read_text().endswith("found case.nml, which is the namelist itself\n")
    assert (tmp_path/"case.nml").read_text() == text


def test_shipped_files_are_found_beside_the_executable(tmp_path: Path):
    """From any folder: profiles by the names that inputs have, and the inputs."""
    short = "&integrator t_end = 1e-3 / &contact model = 'hertz' / &output file = 'columns.txt' /\n"
    done = subprocess.run([LDBENCH], input=short, cwd=tmp_path, capture_output=True, text=True, timeout=HANG)
    assert (done.returncode, done.stderr) == (0, "") and (tmp_path/"columns.txt").is_file()
    done = subprocess.run([LDBENCH, "inputs\\none.nml"], cwd=tmp_path, capture_output=True, text=True, timeout=HANG)
    assert done.returncode == 1 and "; looked for in the working folder, in " in done.stderr


def test_a_program_calls_the_library(tmp_path: Path):
    """The client in C with libldbench.dll beside it, which needs no other library, moves as the executable does."""
    library = REPO/"build/windows/lib/libldbench.dll"
    headers = subprocess.run(["x86_64-w64-mingw32-objdump", "-p", library], capture_output=True, text=True, check=True).stdout
    assert {line.split()[-1] for line in headers.splitlines() if "DLL Name:" in line} == {"KERNEL32.dll", "msvcrt.dll"}
    shutil.copy(library, tmp_path)
    subprocess.run(["x86_64-w64-mingw32-gcc", REPO/"docs/plug/client.c", f"-I{REPO/'fortran/library'}", library, "-o",
                    tmp_path/"client.exe"], check=True)
    profiles = {f"{what}_profile": windows_path(REPO/f"profiles/a{what[0]}prof.yz") for what in ("wheel", "rail")}
    output = {"file": "columns.txt", "interval": 1e-3, "rows": "interval"}
    (tmp_path/"case.nml").write_text(text := short_case(tmp_path, profiles=profiles, output=output))
    assert run_case(text, tmp_path, cwd=tmp_path).returncode == 0
    done = subprocess.run(["wine", "client.exe", "case.nml", "1e-3"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = np.array([line.split() for line in done.stdout.splitlines()], float)
    expected = columns(tmp_path/"columns.txt")["Y"]
    assert found[:2, 1] == pytest.approx(expected[:2], abs=1e-12) and found[1, 1] > 1e-4
