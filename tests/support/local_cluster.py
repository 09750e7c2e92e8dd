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


class Cluster:
    """A scheduler and workers of one thread as processes on the loopback."""

    def __init__(self, folder: Path, workers: int, protocol: str = "tcp", configuration: dict[str, str] | None = None) -> None:
        self.folder = folder
        self.configuration = configuration or {}
        self.processes: list[subprocess.Popen] = []
        self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--protocol", protocol)
        self.address = self._wait(0, rf"Scheduler at:\s+({protocol}://\S+)")
        for k in range(workers):
            self._start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", "--host",
                        "127.0.0.1", "--local-directory", str(folder/f"worker{k}"))
        for k in range(workers):
            self._wait(1 + k, r"(Registered to)")

    def _start(self, *arguments: str) -> None:
        environment = os.environ | self.configuration | {"PYTHONPATH": str(Path(ldbench.__file__).parents[1])}
        with open(self.folder/f"{len(self.processes)}.log", "w") as log:
            self.processes.append(subprocess.Popen([sys.executable, "-m", "dask", *arguments], stdout=log, stderr=log,
                                                   cwd=self.folder, env=environment))

    def _wait(self, process: int, pattern: str) -> str:
        give_up = time.monotonic() + HANG
        while time.monotonic() < give_up:
            if found := re.search(pattern, log := (self.folder/f"{process}.log").read_text()):
                return found[1]
            if self.processes[process].poll() is not None:
                break
            time.sleep(0.05)
        raise RuntimeError(log)

    def stop(self) -> None:
        for process in self.processes:
            process.kill()
            process.wait()
