"""The commands, a module each, with add_arguments(parser) and main(args), which returns the exit status; the docstring is the help.

`python -m ldbench COMMAND` runs them. They read arguments, call the library and print.
"""
from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

#: The commands in the order of the help, and what they do.
COMMANDS = {
    "run": "run cases and write their column files",
    "table": "solve what the contact table of a run needs and keep it, write geometry functions",
    "profile": "look at a wheel or rail profile, or at a pair, before a run",
    "bodies": "compute how wheel and rail as bodies differ from half-spaces",
    "pressure": "show the pressure between wheel and rail at one moment of a run",
    "trust": "say how far the answers of a case are to be trusted, and what decides them",
    "plot": "plot column files",
    "compare": "overlay column files, differences as PDF and CSV",
    "check": "check submissions to the benchmark: complete and physically consistent",
    "submit": "put together what a participant sends, a folder or a zip, checked",
    "score": "score column files against a reference, in numbers that survive impacts",
    "fingerprint": "tell from column files how their codes treat contact and time",
    "collate": "collate the submissions of a round: table, document and page of all codes",
    "study": "contact law against time step",
    "formulations": "elastic contact against constraint equations, all exercises",
    "report": "run the ten cases, write columns, plots, abstract and summary",
    "view": "column files as an interactive page, a film or a picture",
    "ensemble": "run a case over many values of its variables, in threads or on a Dask cluster",
    "fmu": "write a case as an FMU for other simulators",
    "store": "list what ensembles keep beside a store, or remove it",
    "variables": "list the variables of a namelist",
}

#: What may come after a command, in terms of its arguments.
NEXT = {
    "run": "`python -m ldbench view FILE` shows the columns as a page",
    "table": "`python -m ldbench run {namelist}` runs the case",
    "profile": "`python -m ldbench run NAMELIST --set wheel_profile=FILE --set rail_profile=FILE` runs a pair",
    "bodies": "`python -m ldbench run {namelist} --set influence=bodies --set bodies={output}` runs the case with them",
    "plot": "`python -m ldbench view {files[0]}` shows the run as a page",
    "compare": "`python -m ldbench score FILE --reference {files[0]}` gives numbers that survive impacts",
    "check": "`python -m ldbench score {path} --reference outputs` scores against our solutions, which `report` makes",
    "score": "`python -m ldbench fingerprint FILE` tells how a code treats contact",
    "collate": "open {output}/collation.html",
    "study": "`python -m ldbench formulations` compares elastic contact with constraint equations",
    "report": "open {output}/ldbench_results.html; `python -m ldbench submit {output}` checks and packs the submission",
}

#: The commands of a round of the benchmark, which a package beside this one has.
ROUND = "check", "submit", "score", "fingerprint", "collate"


def guessed_map(file: Path, simulation: str) -> dict[str, Any] | None:
    """The map of another code's columns that `check` guesses for a simulation of the benchmark, the file's own where '' is given;
    None where nothing tells the simulation."""
    found: dict[str, Any] | None = import_module("ldbench_round.check").guessed_map(file, simulation)
    return found


def module_of(name: str) -> ModuleType:
    """The module of a command."""
    return import_module(f"{'ldbench_round.commands' if name in ROUND else __package__}.{name}")
