"""The folders of the core: each uses itself and those before it alone."""
import re
import subprocess
from pathlib import Path

import pytest

from conftest import LDBENCH, REPO

FOLDERS = re.search(r"^FOLDERS = (.*)$", (REPO/"Makefile").read_text(), re.MULTILINE)[1].split()
SOURCES = {path.stem: path for path in (REPO/"fortran").rglob("*.f90")}


def used(module: str) -> list[str]:
    return re.findall(r"^ *use +(\w+)", SOURCES[module].read_text(), re.MULTILINE)


def folder(module: str) -> int:
    return FOLDERS.index(SOURCES[module].relative_to(REPO/"fortran").parts[0])


def test_arrows_go_one_way():
    assert {SOURCES[module].relative_to(REPO/"fortran").parts[0] for module in SOURCES} == set(FOLDERS)
    wrong = [(module, other) for module in SOURCES for other in used(module) if other in SOURCES and folder(other) > folder(module)]
    assert wrong == []
    assert sum(folder(other) < folder(module) for module in SOURCES for other in used(module) if other in SOURCES) > 100


def test_modules_and_procedures_are_of_a_size_to_hold_in_the_head():
    """No module above 500 lines, no procedure above 120, those within it included."""
    start = re.compile(r"^ *(?!end)(?:\w+(?:\([^)]*\))? +)*(?:subroutine|function) +(\w+)")
    for path in SOURCES.values():
        lines = path.read_text().splitlines()
        assert len(lines) <= 500, path
        stack = []
        for k, line in enumerate(lines):
            if found := start.match(line):
                stack.append((found[1], k))
            elif re.match(r"^ *end (?:subroutine|function)", line):
                name, first = stack.pop()
                assert k - first < 120, (path, name)


@pytest.mark.skipif(LDBENCH != REPO/"ldbench", reason="links objects of the release build")
def test_elastic_contact_needs_no_rigid_contact(tmp_path: Path):
    """A program is linked with all of support, profile, contact, table and dynamics, and nothing of rigid or program."""
    build = REPO/"build/release"
    (tmp_path/"alone.f90").write_text("""program alone
  use newmark, only: drift_4, kick_4
  implicit none

  print '(2f12.8)', sum(kick_4), sum(drift_4)
end program alone
""")
    objects = [str(build/f"{path.stem}.o") for module, path in SOURCES.items() if folder(module) < FOLDERS.index("rigid")
               and module not in ("memory", "terminal")]
    done = subprocess.run(["gfortran", "-fopenmp", "-flto=auto", "-I", build, "-o", "alone", "alone.f90", *objects, "-llapack",
                           "-lblas"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([tmp_path/"alone"], capture_output=True, text=True)
    assert ran.returncode == 0 and [float(x) for x in ran.stdout.split()] == [1.0, 1.0]
