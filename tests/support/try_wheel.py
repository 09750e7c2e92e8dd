"""A wheel serves on a machine that has nothing but Python: `make wheel`.

usage: python tests/support/try_wheel.py WHEEL

Into an empty environment goes the wheel, with what it needs of the package index; then no program can be found and no
variable is set. It makes the report: the ten column files are those of the executable in the wheel, byte by byte, and the
stored references within their tolerances. Of the libraries of Fortran only the wheel's are in use, and none of LAPACK.
"""
from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

from running import CASES, REPO

ITS_OWN = "gfortran", "gomp", "quadmath"
SCRIPT = """
import re, ldbench
print(*sorted(set(re.findall(r"/\\S+", open("/proc/self/maps").read()))), sep="\\n")
"""


def check(wheel: Path, scratch: Path) -> None:
    here, there, place = scratch/"here", scratch/"there", scratch/"venv"
    here.mkdir()
    (there/"outputs").mkdir(parents=True)
    venv.create(place, with_pip=True)
    subprocess.run([place/"bin/python", "-m", "pip", "install", "--quiet", f"{wheel.resolve()}[report]"], check=True)

    def installed(*command: str) -> str:
        return subprocess.run([place/"bin/python", *command], cwd=here, env={"PATH": "/nowhere", "HOME": str(scratch)},
                              check=True, stdout=subprocess.PIPE, text=True).stdout

    libraries = [Path(line) for line in installed("-c", SCRIPT).splitlines()]
    for name in ITS_OWN:
        found = [file for file in libraries if file.name.startswith(f"lib{name}")]
        assert found and all(place in file.parents for file in found), f"{name}: {found}"
    assert not [file for file in libraries if file.name.startswith("liblapack")]
    ldbench = place/"bin/ldbench"
    print(installed(str(ldbench), "--version").strip(), "from", wheel.name)
    installed("-m", "ldbench", "run", "inputs/ex1_aw.nml")
    (here/"outputs/ex1_aw.txt").rename(here/"ex1_aw.txt")
    installed("-m", "ldbench", "report")
    for case in CASES:
        subprocess.run([ldbench, REPO/"inputs"/f"{case}.nml"], cwd=there, check=True, stdout=subprocess.DEVNULL)
        assert (here/f"outputs/{case}.txt").read_bytes() == (there/f"outputs/{case}.txt").read_bytes(), case
    assert (here/"ex1_aw.txt").read_bytes() == (here/"outputs/ex1_aw.txt").read_bytes()
    for name in ("ldbench_plots.pdf", "ldbench_extras.pdf", "ldbench_abstract.pdf", "summary.csv", "ldbench_results.html"):
        print(f"outputs/{name}  {(here/'outputs'/name).stat().st_size/1e6:.2f} MB")
    print("ten column files: the bytes of the executable's")
    subprocess.run([sys.executable, "-m", "pytest", "-q", REPO/"tests/program/test_reference.py::test_run_is_the_stored_one"],
                   env=os.environ | {"LDBENCH": str(ldbench)}, cwd=REPO, check=True)


if __name__ == "__main__":
    os.environ.pop("PYTHONPATH", None)
    with tempfile.TemporaryDirectory() as folder:
        check(Path(sys.argv[1]), Path(folder))
