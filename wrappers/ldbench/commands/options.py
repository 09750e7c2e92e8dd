"""Options that several commands have, each with one name and one meaning."""
from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .._core.errors import Usage
from .._core.files import DEFAULT_FOLDER
from .._core.pools import usable_cores
from .._core.wording import tell
from ..case import Value, find_variable, shortest_name, variables


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
                        help="how files without ldbench's header name our columns; files with it need no map")


def add_simulation(parser: argparse.ArgumentParser) -> None:
    """Declare --simulation: which of the ten simulations a file is."""
    parser.add_argument("--simulation", metavar="NAME", help="which simulation a file is, as ex2_aw (the name of the file says it)")


def add_reference(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """Declare --reference: the files that others are scored against."""
    parser.add_argument("--reference", type=Path, metavar="FILE|FOLDER", required=required,
                        help="what is right: a column file of the same simulation, or a folder of them")


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add --json, which prints the numbers for other programs."""
    parser.add_argument("--json", action="store_true", help="print the numbers as JSON, SI units, instead of text")


def side_by_side(word: str) -> int:
    """A number of threads or processes."""
    number = int(word) if word.isdecimal() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"expected a number from 1, found {word}")
    return number


def parse_setting(setting: str, option: str = "--set") -> tuple[str, Value]:
    """name=value of the command line, as `Case.replace` takes it."""
    name, equals, word = setting.partition("=")
    if not equals:
        raise Usage(f"expected name=value after {option}, found {setting}")
    if variables()[find_variable(name)].kind == "text":
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
        tell(f"ldbench: warning: {words}")
    print(json.dumps(_plain(facts), ensure_ascii=False, allow_nan=False))


def _plain(x: Any) -> Any:
    if isinstance(x, Mapping):
        return {str(name): _plain(value) for name, value in x.items()}
    if isinstance(x, list | tuple | np.ndarray):
        return [_plain(value) for value in x]
    if isinstance(x, float | np.floating):
        return float(x) if np.isfinite(x) else None
    return x.item() if isinstance(x, np.generic) else x
