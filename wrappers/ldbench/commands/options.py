"""Options that several commands have, each with one name and one meaning."""
from __future__ import annotations

import argparse
import json
import logging
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from .._core.errors import Error, UnknownName, Usage, Warning
from .._core.files import DEFAULT_FOLDER
from .._core.pools import usable_cores
from ..case import Value, find_variable, shortest_name, variables
from ..results.header import read_comments
from ..results.quantities import GROUPS, quantity
from ..results.run_data import RunData, read_data
from . import NEXT, guessed_map

LOG = logging.getLogger("ldbench")
OTHERS = GROUPS[-1]         # columns that are none of ours


def add_output(parser: argparse.ArgumentParser, what: str, metavar: str = "FILE", default: str = "") -> None:
    """Add -o, the path of the result. `default` is a name in outputs/ of the working folder, which the help states."""
    path = f"{DEFAULT_FOLDER}/{default}" if default else None
    parser.add_argument("-o", "--output", type=Path, metavar=metavar, default=path and Path(path),
                        help=f"{what} ({path})" if path else what)


def add_folder(parser: argparse.ArgumentParser, what: str) -> None:
    """Add -o, the folder of several results."""
    parser.add_argument("-o", "--output", type=Path, metavar="DIR", default=Path(DEFAULT_FOLDER), help=f"{what} (%(default)s)")


def add_set(parser: argparse.ArgumentParser) -> None:
    """Add --set, which changes values of the case."""
    parser.add_argument("--set", metavar="NAME=VALUE", action="append", default=[],
                        help="replace a value of the namelist, as often as given; group_name where a name is ambiguous")


def add_jobs(parser: argparse.ArgumentParser, what: str = "runs side by side") -> None:
    """Add -j, the number of tasks that run at the same time."""
    parser.add_argument("-j", "--jobs", type=side_by_side, default=usable_cores(), metavar="N", help=f"{what} (all cores)")


def add_map(parser: argparse.ArgumentParser) -> None:
    """Add --map, the map of another code's columns."""
    parser.add_argument("--map", type=Path, metavar="TOML",
                        help="names and units of the columns, for files without ldbench's header")


def read_files(files: Iterable[Path], map: Path | None, simulation: str | None) -> list[RunData]:
    """The runs of column files. A file of another code without names of ours, and without a map, gets the map that `check` guesses
    for its simulation: the one that is given, or that its name says, or that of our own file beside it."""
    files = list(files)
    ours = (read_comments(file).header.name for file in files)
    beside = next((name for name in ours if re.fullmatch("ex[1-5]_(aw|sw)", name)), None)
    return [read_data(file, map if map is not None else map_without_names(file, simulation, beside)) for file in files]


def map_without_names(file: Path, simulation: str | None, beside: str | None) -> Mapping[str, Any] | None:
    """The guessed map of a file; None where the file has names of ours. Error, which says how columns get our names, where nothing
    tells the simulation."""
    if read_comments(file).settings:
        return None
    names = [str(name) for name in read_data(file).data]
    if "time" in names and any(name != "time" and quantity(name).group != OTHERS for name in names):
        return None
    found = guessed_map(file, simulation or "") or (beside and guessed_map(file, beside)) or None
    if found and len(found) > 1:
        LOG.warning("%s: the map of its columns is guessed: %s. `check --save-map TOML` writes it, --map TOML gives another",
                    file, ", ".join(found))
        return found
    if "time" in names:
        return None
    raise Error(file=file, expected="a column time, --map TOML that names our columns, or --simulation NAME, such as ex2_aw, by "
                "which the map is guessed", found=", ".join(names))


def add_simulation(parser: argparse.ArgumentParser) -> None:
    """Declare --simulation: which of the ten simulations a file is."""
    parser.add_argument("--simulation", metavar="NAME",
                        help="simulation of the file, such as ex2_aw (default: as its name or ldbench's header says)")


def add_reference(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """Declare --reference: the files that others are scored against."""
    parser.add_argument("--reference", type=Path, metavar="FILE|FOLDER", required=required,
                        help="the reference: a column file of the same simulation, or a folder of them")


def add_loudness(parser: argparse.ArgumentParser) -> None:
    """Add -q and -v, which every command has."""
    both = parser.add_mutually_exclusive_group()
    both.add_argument("-q", "--quiet", action="store_true", help="print nothing but errors, and what --json asks for")
    both.add_argument("-v", "--verbose", action="store_true", help="tell what is written and why, on standard error")


@contextmanager
def spoken(args: argparse.Namespace) -> Iterator[None]:
    """Print and log as much as -q and -v ask for; a `ldbench.Warning` is a line like any other."""
    handler = logging.StreamHandler()
    handler.setFormatter(Levels())
    level = LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.ERROR if args.quiet else logging.INFO if args.verbose else logging.WARNING)
    try:
        with ExitStack() as stack:
            stack.enter_context(logged_warnings())
            if args.quiet:
                # Bars of progress are drawn on terminals alone.
                plain: Any = SimpleNamespace(write=sys.stderr.write, flush=sys.stderr.flush, isatty=lambda: False)
                stack.enter_context(redirect_stderr(plain))
                if not getattr(args, "json", False):
                    stack.enter_context(redirect_stdout(stack.enter_context(open(os.devnull, "w"))))
            yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(level)


@contextmanager
def logged_warnings() -> Iterator[None]:
    """Log every `ldbench.Warning`; those of other packages appear as they would without us."""
    with warnings.catch_warnings():
        warnings.simplefilter("always", Warning)
        show = warnings.showwarning

        def log(message: Any, category: Any, *place: Any, **printed: Any) -> None:
            if issubclass(category, Warning):
                LOG.warning("%s", message)
            else:
                show(message, category, *place, **printed)

        warnings.showwarning = log
        yield


def tell_next(args: argparse.Namespace, as_called: Callable[[str], str]) -> None:
    """Tell a person at a terminal what may come after a command; pipes and files get the results alone."""
    if args.command in NEXT and sys.stdout.isatty() and not getattr(args, "json", False):
        print(as_called(f"next: {NEXT[args.command].format_map(vars(args))}"))


class Levels(logging.Formatter):
    """A message in one line, with its level where that is a warning or worse."""

    def format(self, record: logging.LogRecord) -> str:
        """The line of a record."""
        level = f"{record.levelname.lower()}: " if record.levelno >= logging.WARNING else ""
        return f"ldbench: {level}{record.getMessage()}"


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json, which prints the numbers for other programs."""
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON, SI units, instead of text")


def side_by_side(word: str) -> int:
    """A number of threads or processes."""
    number = int(word) if word.isdecimal() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a number from 1, found {word}")
    return number


@contextmanager
def naming() -> Iterator[None]:
    """Usage, where a name on the command line stands for nothing."""
    try:
        yield
    except UnknownName as error:
        raise error.turned(Usage) from None


def parse_setting(setting: str, option: str = "--set") -> tuple[str, Value]:
    """name=value of the command line, as `Case.replace` takes it."""
    name, equals, word = setting.partition("=")
    if not equals:
        raise Usage(expected=f"name=value after {option}", found=setting)
    with naming():
        kind = variables()[find_variable(name)].kind
    if kind == "text":
        return name, word.strip("'\"")
    try:
        return name, float(word)
    except ValueError:
        return name, word


def settings(given: Iterable[str]) -> dict[str, Value]:
    """Collect the values of `--set`; the last value of a variable counts."""
    return {shortest_name(find_variable(name)): value for name, value in map(parse_setting, given)}


def print_json(facts: Mapping[str, Any], warnings: Iterable[str] = ()) -> None:
    """Print one line of JSON, and warnings to standard error; NaN, which JSON does not have, becomes null."""
    for words in warnings:
        LOG.warning("%s", words)
    print(json.dumps(_plain(facts), ensure_ascii=False, allow_nan=False))


def _plain(x: Any) -> Any:
    if isinstance(x, Mapping):
        return {str(name): _plain(value) for name, value in x.items()}
    if isinstance(x, list | tuple | np.ndarray):
        return [_plain(value) for value in x]
    if isinstance(x, float | np.floating):
        return float(x) if np.isfinite(x) else None
    return x.item() if isinstance(x, np.generic) else x
