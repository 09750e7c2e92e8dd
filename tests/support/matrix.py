"""The package with old and new numpy and pandas, under the Python that runs this program: `make test-matrix`.

usage: python tests/support/matrix.py

A wheel is built and goes into an empty environment for each pair of releases below that this Python has. There the package
runs two cases: rows in memory, in its files and in those of the command `ldbench` are the same, and plots are made.
"""
from __future__ import annotations

import subprocess
import sys
import tempfile
import venv
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
NEWEST = "numpy", "pandas"
# By Python: the oldest releases that have a wheel for it, and the newest.
PAIRS = {
    (3, 10): [("numpy==1.26.4", "pandas==2.2.0"), NEWEST],
    (3, 11): [("numpy==1.26.4", "pandas==2.2.0"), ("numpy==2.0.2", "pandas==2.3.3"), NEWEST],
    (3, 12): [("numpy==1.26.4", "pandas==2.2.0"), NEWEST],
    (3, 13): [("numpy==2.1.3", "pandas==2.2.3"), NEWEST],
    (3, 14): [("numpy==2.3.5", "pandas==2.3.3"), NEWEST],
}
TRIAL = """
import subprocess, sys
from pathlib import Path
import matplotlib, numpy, pandas, scipy, ldbench

for name in "ex2_aw", "ex3_sw":
    case = ldbench.Case.from_namelist(f"inputs/{name}.nml")
    run = ldbench.run(case)
    own, executables = Path(f"{name}.txt"), Path(f"outputs/{name}.txt")
    run.write(own)
    subprocess.run([Path(sys.executable).with_name("ldbench")], input=Path("REPO/inputs", f"{name}.nml").read_text(), text=True,
                   check=True, stdout=subprocess.DEVNULL)
    written = ldbench.read_columns(executables)
    pandas.testing.assert_frame_equal(ldbench.read_columns(own), written, check_exact=True)
    pandas.testing.assert_frame_equal(written, run.data, rtol=2e-8, atol=0)      # nine digits are written
    assert run.events and run.peak("LF")[0] > 1e5
assert ldbench.__main__.main(["plot", "outputs/ex2_aw.txt", "outputs/ex3_sw.txt", "-o", "plots.pdf"]) == 0
print(f"Python {sys.version.split()[0]}, numpy {numpy.__version__}, pandas {pandas.__version__}, scipy {scipy.__version__}, "
      f"matplotlib {matplotlib.__version__}: passed")
""".replace("REPO", str(REPO)).replace("import matplotlib", "import ldbench.__main__, matplotlib")


def try_pair(wheel: Path, pair: tuple[str, str], scratch: Path) -> bool:
    """Whether the wheel serves with these two packages; what it says is printed."""
    place = scratch/"venv"
    venv.create(place, clear=True, with_pip=True)
    python = place/"bin/python"
    work = Path(tempfile.mkdtemp(dir=scratch))
    (work/"outputs").mkdir()
    (work/"profiles").symlink_to(REPO/"profiles")
    for command in ([python, "-m", "pip", "install", "--quiet", "--only-binary=:all:", wheel, *pair], [python, "-c", TRIAL]):
        done = subprocess.run(command, cwd=work, capture_output=True, text=True)
        if done.returncode:
            print(f"Python {sys.version.split()[0]}, {', '.join(pair)}: FAILED\n{done.stdout}{done.stderr}", flush=True)
            return False
    print(done.stdout.splitlines()[-1], flush=True)
    return True


def main() -> int:
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        builder = scratch/"builder"
        venv.create(builder, with_pip=True)
        subprocess.run([builder/"bin/python", "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", scratch, REPO],
                       check=True)
        wheel = next(scratch.glob("*.whl"))
        return [try_pair(wheel, pair, scratch) for pair in PAIRS[sys.version_info[:2]]].count(False)


if __name__ == "__main__":
    sys.exit(main())
