"""The executable and the Fortran test programs as child processes."""
from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

REPO = Path(__file__).resolve().parents[2]
LDBENCH = Path(os.environ.get("LDBENCH", REPO/"ldbench")).resolve()
FORTRAN_TESTS = Path(os.environ.get("LDBENCH_TESTS", REPO/"build/release/tests")).resolve()


def run_program(*command: object, stdin: str = "") -> subprocess.CompletedProcess[str]:
    """Run to the end; a failure is an error with what the program said."""
    words = [str(word) for word in command]
    done = subprocess.run(words, input=stdin, cwd=REPO, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)}: exit status {done.returncode}, {done.stderr.strip()}")
    return done


def fortran_test(name: str, *arguments: object, stdin: str = "") -> str:
    """Output of a program of tests/fortran."""
    return run_program(FORTRAN_TESTS/name, *arguments, stdin=stdin).stdout


def resources(command: list[str], cwd: Path) -> tuple[float, float, float]:
    """Wall time [s], processor time [s] and peak memory [MB] of a child process."""
    begin = time.perf_counter()
    child = subprocess.Popen(command, cwd=cwd, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise RuntimeError(f"{' '.join(command)}: exit status {child.returncode}, {message.decode().strip()}")
    return time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss/1024
