"""The package with old and new numpy and pandas, under the Python that runs this program: `make test-matrix`.

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
# By Python: the oldest releases that have a wheel for it; the newest ones are tried, too.
OLD = {(3, 10): "numpy==1.26.4 pandas==2.2.0", (3, 11): "numpy==1.26.4 pandas==2.2.0", (3, 12): "numpy==1.26.4 pandas==2.2.0",
       (3, 13): "numpy==2.1.3 pandas==2.2.3", (3, 14): "numpy==2.3.5 pandas==2.3.3"}
TRIAL = f"""
import subprocess, sys
from pathlib import Path
import ldbench.__main__, matplotlib, numpy, pandas, scipy

for name in "ex2_aw", "ex3_sw":
    run = ldbench.run(ldbench.Case.from_namelist(f"inputs/{{name}}.nml"))
    own, executables = Path(f"{{name}}.txt"), Path(f"outputs/{{name}}.txt")
    run.write(own)
    program = [Path(sys.executable).with_name("ldbench")]
    subprocess.run(program, input=Path("{REPO}/inputs", name + ".nml").read_bytes(), check=True, stdout=subprocess.DEVNULL)
    written = ldbench.read_columns(executables)
    pandas.testing.assert_frame_equal(ldbench.read_columns(own), written, check_exact=True)
    pandas.testing.assert_frame_equal(written, run.data, rtol=2e-8, atol=0)      # nine digits are written
    assert run.events and run.results["peak_N_LF"] > 1e5
assert ldbench.__main__.main(["plot", "outputs/ex2_aw.txt", "outputs/ex3_sw.txt", "-o", "plots.pdf"]) == 0
print(f"Python {{sys.version.split()[0]}}", *(f"{{x.__name__}} {{x.__version__}}" for x in (numpy, pandas, scipy, matplotlib)))
"""


def try_pair(wheel: Path, pair: str, scratch: Path) -> bool:
    """Whether the wheel serves with these two packages; what it says is printed."""
    venv.create(scratch/"venv", clear=True, with_pip=True)
    python, work = scratch/"venv/bin/python", Path(tempfile.mkdtemp(dir=scratch))
    (work/"outputs").mkdir()
    install = [python, "-m", "pip", "install", "--quiet", "--only-binary=:all:", wheel, *pair.split()]
    for command in install, [python, "-c", TRIAL]:
        done = subprocess.run(command, cwd=work, capture_output=True, text=True)
        if done.returncode:
            print(f"Python {sys.version.split()[0]}, {pair}: FAILED\n{done.stdout}{done.stderr}", flush=True)
            return False
    print(done.stdout.splitlines()[-1], "passed", flush=True)
    return True


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        venv.create(f"{folder}/builder", with_pip=True)
        subprocess.run([f"{folder}/builder/bin/python", "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, REPO],
                       check=True)
        built = next(Path(folder).glob("*.whl"))
        sys.exit([try_pair(built, pair, Path(folder)) for pair in (OLD[sys.version_info[:2]], "numpy pandas")].count(False))
