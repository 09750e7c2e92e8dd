"""Our own runs with rigid contacts, which codes with rigid contacts are scored against where the reference is elastic.

From the first impact on, rigid contacts move otherwise than elastic ones, and grades against an elastic reference would tell the
formulation alone.
"""
from __future__ import annotations

from pathlib import Path

from ldbench import Case
from ldbench.results.quantities import CONTACTS
from ldbench.results.run_data import RunData
from ldbench.runs import compute
from ldbench.tools import complete

from .exact_runs import exact
from .horizon import ending, horizon
from .jumps import SHORT, jumps, typical_interval
from .submissions import quiet
from .tasks import Task

IMPULSES = tuple(f"P_{contact}" for contact in CONTACTS)


@quiet()
def is_rigid(found: RunData, task: Task) -> bool:
    """Whether a file has rigid contacts: columns of their impulses, or velocities that jump from one row to the next."""
    return tells_impulses(found) or (typical_interval(found) <= SHORT
                                     and bool(jumps(found, Case.exercise(task.exercise, task.profiles))))


def tells_impulses(found: RunData) -> bool:
    """Whether a file has the impulses of rigid impacts."""
    return any(name in found.data for name in IMPULSES)


def write_rigid_run(folder: Path, task: Task, restitution: float, program: str) -> Path:
    """The column file of our run of a simulation with rigid contacts, made where it is not there; `program` stands for ours."""
    target = folder/f"{task.name}_restitution_{restitution:g}-{program[:12]}.txt"
    if not target.exists():
        folder.mkdir(parents=True, exist_ok=True)
        case = exact(Case.exercise(task.exercise, task.profiles)).replace(formulation="unilateral", restitution=restitution,
                                                                          table_file="", output_file="")
        made = compute(ending(case, horizon(task)))
        with complete(target) as scratch:
            made.write(scratch)
    return target
