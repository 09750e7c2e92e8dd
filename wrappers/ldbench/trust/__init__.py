"""How far the answers of a run are to be trusted: `Case.trust`."""
from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from .._core.calls import Progress
from .._core.errors import BadValue, Error
from .._core.pools import usable_cores
from ..case import Case
from ..ensembles.members import Record, Wanted, groups_of
from ..ensembles.pools import run_here
from ..results.quantities import OUTCOME, si_unit
from ..results.twins import EXACTNESS
from .answers import SHORT, Answer, Trust
from .variations import variations

__all__ = ["SHORT", "Answer", "Trust", "trust"]

FORCES = "N", "N.s", "Pa", "J"      # units of what is proportional to the forces


def trust(case: Case | str | os.PathLike[str], *, laws: bool = False, jobs: int | None = None,
          progress: Progress | bool | None = None) -> Trust:
    """Say how far the answers of a case are to be trusted: run it, and variations of it, one cause at a time.

    Causes: twins (starts within 3 µm), the table's accuracy, the influence of half-spaces' places on each other, the bodies' own
    elasticity in place of half-spaces (two supports), the smoothing of measured profiles, and every input that is not zero, raised
    by 1 % (gauge, back_to_back and gauge_depth by 0.1 mm); with `laws` the other contact laws. An input whose change leaves every
    answer as it is, to the last bit, is no cause. Inputs are changed to one side; ranges count them to either side, as small
    changes are in proportion.

    jobs: threads, all cores by default. A progress function is called as `progress("trust", share)`; True draws a bar on a
    terminal. Ctrl-C stops the runs. Contact tables and bodies of all variations are kept in the case's table folder, so that a
    second call takes a few seconds. Error where the case itself cannot run; `failed` has the variations that could not.
    """
    from tqdm import tqdm

    if jobs is not None and jobs < 1:
        raise BadValue(place="trust", expected="at least one thread", found=jobs)
    case = Case.given(case)
    with tempfile.TemporaryDirectory() as folder:
        varied, notes = variations(case, laws, Path(folder))
        members = [case, *(one.case for one in varied)]
        records: list[Record] = [{}]*len(members)
        groups = groups_of(members, range(len(members)))
        with (closing(run_here(members, groups, {}, Wanted(), jobs or usable_cores())) as going,
              tqdm(desc="trust", total=len(members), unit="run", delay=1, leave=False,
                   disable=None if progress is True else True) as bar):
            for done, (number, record) in enumerate(going, 1):
                if number == 0 and record["error"]:
                    raise Error(record["error"])
                records[number] = record
                bar.update()
                if callable(progress):
                    progress("trust", done/len(members))
    ran = [k for k, one in enumerate(varied, 1) if not records[k]["error"]]
    values = {name: [value(name, records[0], 1.0), *(value(name, records[k], varied[k - 1].factor) for k in ran)]
              for name in answers_of([records[0], *(records[k] for k in ran)])}
    idle = [k for k in ran if varied[k - 1].kind == "input" and all(
        own[1 + ran.index(k)] == own[0] or np.isnan([own[1 + ran.index(k)], own[0]]).all() for own in values.values())]
    kept = [0, *(1 + place for place, k in enumerate(ran) if k not in idle)]
    return Trust(
        case.case_name, case.title, tuple((varied[k - 1].kind, varied[k - 1].name) for k in ran if k not in idle),
        {name: tuple(own[place] for place in kept) for name, own in values.items()},
        {one.name: records[k]["error"].replace(f"{folder}/", "") for k, one in enumerate(varied, 1) if records[k]["error"]},
        tuple(varied[k - 1].name for k in idle), tuple(notes))


def answers_of(records: Sequence[Record]) -> list[str]:
    """The names of the answers that are numbers, in the order of the table of quantities."""
    numbers = {name for record in records for name, x in record.items() if isinstance(x, float) and np.isfinite(x)} - {*EXACTNESS}
    known = [name for name in OUTCOME if name in numbers]
    return known + sorted(name for name in numbers.difference(known) if name.startswith("t_"))


def value(name: str, record: Record, factor: float) -> float:
    """An answer of a record, SI; NaN where it did not happen. factor: on the forces of the run."""
    found = float(record.get(name, np.nan))
    return factor*found if si_unit(name) in FORCES else found


Case.trust = trust
