"""A Dask cluster on this machine."""
from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import ldbench
from running import HANG

HERE = ("--host", "127.0.0.1", "--no-dashboard")


class Cluster:
    """A scheduler and workers of one thread as processes on the loopback."""

    def __init__(self, folder: Path, workers: int) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen]()
        self._start("scheduler", *HERE, "--port", "0")
        self.address = self._wait(0, r"Scheduler at:\s+(tcp://\S+)")
        for k in range(workers):
            self._start("worker", self.address, *HERE, "--nthreads", "1", "--no-nanny", "--local-directory", f"{folder}/worker{k}")
        for k in range(workers):
            self._wait(1 + k, r"(Registered to)")

    def _start(self, *arguments: str) -> None:
        environment = os.environ | {"PYTHONPATH": str(Path(ldbench.__file__).parents[1])}
        with open(self.folder/f"{len(self.processes)}.log", "w") as log:
            self.processes.append(subprocess.Popen([sys.executable, "-m", "dask", *arguments], stdout=log, stderr=log,
                                                   cwd=self.folder, env=environment))

    def _wait(self, process: int, pattern: str) -> str:
        give_up = time.monotonic() + HANG
        while not (found := re.search(pattern, log := (self.folder/f"{process}.log").read_text())):
            if time.monotonic() > give_up or self.processes[process].poll() is not None:
                raise RuntimeError(log)
            time.sleep(0.05)
        return found[1]

    def stop(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()
