"""Measure the horizons and spreads of the ten simulations, by which scores are judged: wrappers/ldbench_round/yardsticks.json.

    python docs/yardsticks.py [SIMULATION ...]      as ex2_aw; all ten without a name, in some minutes

Every horizon is measured twice: by twins of our integrator, and by twins of SciPy's DOP853 against our integrator.
"""
from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from independent import displacements
from ldbench._core.files import complete
from ldbench.table import ContactTable
from ldbench_round.horizon import FILE
from ldbench_round.spread import measured_yardstick, rounded
from ldbench_round.tasks import TASKS, task_named


def main(names: list[str]) -> int:
    known: dict[str, Any] = json.loads(FILE.read_text()) if FILE.exists() else {}
    tables: dict[str, dict[str, ContactTable]] = {"aw": {}, "sw": {}}
    for task in [task_named(name) for name in names] or TASKS:
        facts = rounded(measured_yardstick(task, tables[task.profiles], another=displacements))
        known[task.name] = facts
        least = "" if facts["reached"] else " at least"
        end = "later" if facts["end"] is None else f"at {facts['end']:g} s"
        seen = "later" if facts["independent"] is None else f"{facts['independent']:g} s"
        print(f"{task.name}: horizon {facts['horizon']:g} s{least}, by DOP853 {seen}, both from one start apart by "
              f"{facts['integrators']:.1e}, run ends {end}, growth until then {facts['growth']:g}, "
              f"spreads of {len(facts['hertz'])} and {len(facts['rigid'])} numbers", flush=True)
    with complete(Path(FILE)) as scratch:
        scratch.write_text(json.dumps({task.name: known[task.name] for task in TASKS if task.name in known}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
