"""The executable and the Fortran test programs as child processes."""
from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from running import FORTRAN_TESTS, REPO


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


# A process begins with the peak memory of the one that it was forked from: this one has hardly any.
LAUNCHER = """
import os, sys, time
begin = time.perf_counter()
child = os.fork()
if child == 0:
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    try:
        os.execvp(sys.argv[1], sys.argv[1:])
    finally:
        os._exit(127)
_, status, usage = os.wait4(child, 0)
print(os.waitstatus_to_exitcode(status), time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss)
"""


def resources(command: list[str], cwd: Path) -> tuple[float, float, float]:
    """Wall time [s], processor time [s] and peak memory [MB] of a program, its own: 10 MB are the least that is told."""
    done = subprocess.run([sys.executable, "-I", "-S", "-c", LAUNCHER, *command], cwd=cwd, capture_output=True, text=True,
                          check=True)
    status, wall, processor, peak = map(float, done.stdout.split())
    if status:
        raise RuntimeError(f"{' '.join(command)}: exit status {status:.0f}, {done.stderr.strip()}")
    return wall, processor, peak/1024
