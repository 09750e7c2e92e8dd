"""Score column files against a reference, in numbers that survive impacts.

Columns are compared pointwise only while both files have the same contacts closed, events are matched in order, and nothing
is scored beyond the horizon of the simulation. A grade is the smallest of 1e-3, 1e-2 and 0.1 that is not below the relative
difference; each kind of quantity has the grade of its worst one. Beside it stand the share that was scored, and the difference
over that of our own runs: with Hertz's law, and the largest one that Hertz's law, wheel and rail as elastic bodies and rigid
contacts make. So forces, which depend on the bodies, weigh less than impulses and times. Without a map the command guesses the
columns of other codes, as `check` does. docs/organiser.md defines every number.

examples:
  python -m ldbench score outputs/ex2_aw.txt --reference outputs
  python -m ldbench score other_code.csv --reference outputs/ex2_aw.txt --simulation ex2_aw --all
"""
from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ldbench import Case, Error
from ldbench.commands.options import add_json, add_map, add_reference, add_simulation, print_json
from ldbench.number_text import UNKNOWN
from ldbench.results.quantities import quantity
from ldbench.results.run_data import RunData

from ..check import read_submitted
from ..findings import FAILED, apart_text, times_text
from ..metrics import score
from ..own_runs import yardsticks
from ..physics_checks import start_findings
from ..scores import GRADES, KINDS, OVER_TIME, Score, Scores
from ..submissions import complaint, find_files
from ..tasks import TASKS, Task, task_named, task_of

SHOWN = 5       # impacts without a partner
WIDTH = 54      # of a quantity in words


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("path", type=Path, metavar="FILE|FOLDER", help="a column file, or a folder of them")
    add_reference(parser, required=True)
    add_simulation(parser)
    parser.add_argument("--all", action="store_true", help="print every score and every impact without a partner")
    add_map(parser)
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    found: list[tuple[Path, Scores, list[str]]] = []
    failures: list[str] = []
    left_out: list[str] = []
    for task, file, reference in files(args.path, args.reference, args.simulation, left_out):
        try:
            runs = read_submitted(file, task, args.map).run, read_submitted(reference, task).run
            strange = [line for run in runs for line in doubts(run, task)]
            found.append((file, score(*runs, task), strange))
        except Exception as error:
            if not args.path.is_dir():
                raise
            failures.append(complaint(error, file))
    if args.json:
        print_json({"files": [{"file": str(file), **scores.facts(), "doubts": strange} for file, scores, strange in found],
                    "failures": failures, "left_out": left_out})
    else:
        for file, scores, strange in found:
            print("\n".join([f"{file}: {heading(scores)}", *(f"  doubtful: {line}" for line in strange), *lines(scores, args.all)]))
        for line in failures:
            print(f"not scored: {line}")
        for line in left_out:
            print(f"left out: {line}")
    return int(bool(failures))


def files(path: Path, reference: Path, name: str | None, left_out: list[str]) -> Iterator[tuple[Task, Path, Path]]:
    """Simulations, files and references that belong together; Error where there are none. What a folder holds besides is
    added to `left_out`."""
    known = find_files(reference, [], strict=True) if reference.is_dir() else None
    if path.is_dir():
        if known is None or name:
            raise Error(file=path, expected="a file, for --reference FILE and for --simulation", found="a folder")
        own = find_files(path, left_out)
        if not own.keys() & known.keys():
            raise Error(file=path, expected=f"files of the simulations in {reference}", found="none")
        yield from ((task, file, known[task]) for task, file in own.items() if task in known)
        return
    task = task_named(name) if name else task_of(path) or (task_of(reference) if known is None else None)
    if task is None:
        raise Error(file=path, expected="a name that says the simulation, as ex2_aw, or --simulation", found="neither")
    if known is not None and task not in known:
        raise Error(file=reference, expected=f"a file of {task.words}", found="none")
    yield task, path, known[task] if known is not None else reference


def doubts(run: RunData, task: Task) -> list[str]:
    """What speaks for another simulation: the name of the file, or the start of the motion. Error where ldbench's header does."""
    told = next((other for other in TASKS if other.name == run.header.name), task)
    if told != task:
        raise Error(file=run.file, expected=f"a file of {task.words}", found=f"the header of {told.words}")
    named = task_of(run.file) or task
    return [f"{run.file}: expected a file of {task.words}, found {what}" for what in (
        *([f"a name that says {named.words}"] if named != task else []),
        *(f"{one.what} {one.hint.rpartition(' ')[2]} instead of {one.hint.split()[1].strip(',')}" for one in
          start_findings(run, Case.exercise(task.exercise, task.profiles)) if one.verdict == FAILED))]


def heading(scores: Scores) -> str:
    """How far a file was scored."""
    yardstick = yardsticks()[scores.task.name]
    share = "" if scores.share != scores.share else (
        f"; the same contacts are closed for {percent(scores.share, 4)} % of it")
    kinds = [f"the {where} has rigid contacts" for where, rigid in zip(("file", "reference"), scores.rigid, strict=True) if rigid]
    unlike = f"; {kinds[0]} and the other elastic ones, which differ after the first impact" if len(kinds) == 1 else ""
    return (f"{scores.task.words}; scored up to {scores.end:.4g} s (horizon {'' if yardstick.reached else 'beyond '}"
            f"{scores.horizon:.4g} s), where a difference of the start has grown {yardstick.growth:,.0f} times{share}{unlike}")


def lines(scores: Scores, everything: bool) -> Iterator[str]:
    """The table of a file: a line for each kind, with the quantity that grades it; or all scores."""
    yield f"  {'quantity':{WIDTH}} {'difference':>10} {'grade':>6} {'scored':>7} {'of Hertz':>9} {'of spread':>9}"
    for kind, words in KINDS.items():
        if everything:
            yield from (row(quantity(one.name).words if kind in OVER_TIME else one.name, one, one.share)
                        for one in scores.of_kind(kind))
        elif worst := scores.graded(kind):
            named = words if kind == "contacts" else f"{words}, worst: {worst.words}"
            yield row(named, worst, scores.share_of(kind))
    listed = scores.unmatched if everything else sorted(scores.unmatched, key=lambda one: -one.impulse)[:SHOWN]
    for one in listed:
        yield f"  only in the {one.where}: {one.name} at {one.time:.6f} s" + (f", {one.impulse:.4g} N s" if one.impulse else "")
    if len(scores.unmatched) > len(listed):
        yield f"  and {len(scores.unmatched) - len(listed)} more in one file only"
    yield from (f"  not scored: {name}: {why}" for name, why in scores.left_out.items())


def percent(share: float, digits: int = 3) -> str:
    """A share in percent; 100 and 0 stand for the whole and for nothing alone."""
    return apart_text(100*share, [0.0, float(np.nextafter(100.0, 0.0))], digits)


def row(words: str, one: Score, share: float) -> str:
    """A line of the table."""
    by_hertz = one.difference/one.hertz if one.hertz > 0 else float("nan")
    grade = UNKNOWN if one.grade is None else f"{one.grade:g}"
    return (f"  {words:{WIDTH}} {apart_text(one.difference, GRADES, 2):>10} {grade:>6} "
            f"{percent(share):>5} % {times_text(by_hertz):>9} {times_text(one.of_spread):>9}")
