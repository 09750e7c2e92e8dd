"""Tell from column files of other codes how these codes treat contact and time.

The command finds whether contact is rigid or elastic, which power of the approach the normal force follows, how stiff it is
against Hertz's law, which energy an impact loses, the step of the integrator, and the pitch of a table of contact over Y, each
with its uncertainty, or the reason why the file does not tell it. It uses the file alone, and the benchmark's profiles for
Hertz's law. Files of other codes need no map of their columns: the command guesses it, as `check` does.

examples:
  python -m ldbench fingerprint outputs/ex2_aw.txt
  python -m ldbench fingerprint other_code.csv --simulation ex2_aw --map other_code.toml --json
"""
from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path

from ldbench.commands.options import add_json, add_map, add_simulation, print_json

from ..check import read_submitted
from ..findings import Estimate
from ..fingerprint import Fingerprint, fingerprint, plus_minus
from ..submissions import complaint
from ..tasks import task_named


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="column files of one simulation of the benchmark each")
    add_simulation(parser)
    add_map(parser)
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    task = task_named(args.simulation) if args.simulation else None
    found: list[tuple[Path, Fingerprint]] = []
    failures: list[str] = []
    for file in args.files:
        try:
            submitted = read_submitted(file, task, args.map)
            found.append((file, fingerprint(submitted.run, submitted.task)))
        except Exception as error:
            if len(args.files) == 1:
                raise
            failures.append(complaint(error, file))
    if args.json:
        print_json({"files": [{"file": str(file), "sentence": one.sentence, **asdict(one)} for file, one in found],
                    "failures": failures})
        return int(bool(failures))
    for file, one in found:
        print(f"{file}: {one.sentence}")
        for words, number in lines_of(one):
            print(f"  {words}: {number}")
    for line in failures:
        print(f"no fingerprint: {line}")
    return int(bool(failures))


def lines_of(one: Fingerprint) -> list[tuple[str, str]]:
    """The numbers in words, each with its uncertainty and what it rests upon, or why there is none."""
    told: list[tuple[str, Estimate, float, str]] = [
            ("exponent of the approach", one.exponent, 1.0, ""),
            (f"force at an approach of {1e3*one.approach:.3g} mm" if one.force.known else "force", one.force, 1e-3, "kN"),
            ("force over that of Hertz", one.hertz, 1.0, ""), ("restitution of the energy", one.restitution, 1.0, ""),
            ("energy lost per impact", one.loss, 100.0, "%"), (one.damping_kind or "damping", one.damping, 1.0, one.damping.unit),
            ("time step", one.step, 1e3, "ms"), ("pitch of a contact table", one.pitch, 1e3, "mm")]
    return [("contact", f"{one.kind}; {one.because}"), *(
        (what, f"{' '.join([plus_minus(x, factor), *([unit] if unit else [])])} ({x.why})" if x.known else f"not told: {x.why}")
        for what, x, factor, unit in told)]
