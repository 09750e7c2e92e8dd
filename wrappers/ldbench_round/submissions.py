"""The folder of a round: a folder for each code, with its files and what `submission.toml` tells of it.

Nothing that a code sends stops the others: whatever cannot be used becomes one line among the remarks of that code.
"""
from __future__ import annotations

import difflib
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from ldbench import Error
from ldbench.constants import DESCRIPTION
from ldbench.results.columns import read_toml

from .tasks import ENDINGS, TASKS, Task, task_of

LONGEST_DESCRIPTION = 1_000_000     # of a description or a map [bytes]
LONGEST_NAME = 40                   # of a code [characters]
LONGEST_FACT = 200                  # [characters]
MOST_REMARKS = 10                   # about the keys of a description
FORMULATIONS = "elastic", "constraint", "rigid", "unilateral", "bilateral"     # of which a description says one

FORCE = "contact_force"
CONTACT_FORCES = "own", "given"     # of which a description says one

#: The keys of a description, all optional, and what they are in words.
FACTS = {"code": "code", "version": "version", "authors": "authors", "formulation": "formulation of contact",
         "restitution": "restitution of rigid contacts", "law": "law of the normal force", "step": "time step [s]",
         FORCE: "contact force", "machine": "machine", "processor_time": "processor time [s]"}
MAP = "map"
#: Keys that `submit` reads and tables of codes do not show.
SENT = "organisation", "email", "plots", "abstract"
TASK_NAMES = {task.name for task in TASKS}


@dataclass(frozen=True)
class Submission:
    """What one code submitted."""

    name: str                                   # the name of the folder, as it is printed
    facts: Mapping[str, str] = field(default_factory=dict)          # of FACTS, in words
    seconds: Mapping[str, float] = field(default_factory=dict)      # processor time [s], by the name of the simulation
    map: Mapping[str, Any] | None = None        # of its columns; None: it is guessed
    restitution: float | None = None            # of a code with rigid contacts, if the description tells it
    files: Mapping[Task, Path] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()               # a line each: what could not be used, and why


def printable(words: object, longest: int = LONGEST_FACT) -> str:
    """Words of anybody as one line that every terminal and page can show."""
    line = " ".join("".join(c if c.isprintable() else " " if c.isspace() else "?" for c in str(words)[:4*longest]).split())
    return line if len(line) <= longest else f"{line[:longest - 1]}…"


def find_submissions(folder: Path, leave_out: Path | None = None) -> tuple[list[Submission], list[str]]:
    """The codes of a folder in the order of their names, and remarks about what is no code. Hidden folders and `leave_out`, where
    the results go, are no codes. Error where the folder cannot be read."""
    try:
        paths = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    except OSError as error:
        raise Error(file=folder, expected="a folder that holds a folder for each code",
                    found=f"none: {error.strerror}") from None
    codes: list[Submission] = []
    remarks = []
    for path in paths:
        try:
            if leave_out is not None and path.exists() and leave_out.exists() and path.samefile(leave_out):
                continue
            if path.is_dir():
                codes.append(read_submission(path, unused_name(path, codes)))
            elif not is_file(path):
                remarks.append(f"{printable(path.name)}: expected the folder of a code, found a link that leads nowhere, or a "
                               "device")
        except OSError as error:
            remarks.append(f"{printable(path.name)}: expected the folder of a code, found one that cannot be read: {reason(error)}")
    return codes, remarks


@contextmanager
def quiet() -> Iterator[None]:
    """No warnings of the arithmetic: a stranger's numbers overflow or are missing, and what comes of them is judged."""
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def complaint(error: Exception, file: Path) -> str:
    """What is wrong with a stranger's file, in one line: whatever it holds, it stops no other file."""
    if isinstance(error, Error):
        return printable(str(error).replace(str(file), file.name), 400)
    if isinstance(error, MemoryError):
        return f"{printable(file.name)}: expected a file that fits into memory, found a larger one"
    return printable(f"{file.name}: cannot be used: {type(error).__name__}: {error}", 400)


def reason(error: BaseException) -> str:
    """What an error says, in one line."""
    return printable(str(getattr(error, "strerror", None) or error) or type(error).__name__)


def unused_name(folder: Path, others: list[Submission]) -> str:
    """The name of a folder as it is printed, made different from those of the others."""
    plain = printable(folder.name, LONGEST_NAME)
    names = [plain, *(f"{plain} ({k})" for k in range(2, len(others) + 2))]
    return next(name for name in names if name not in {other.name for other in others})


def read_submission(folder: Path, name: str) -> Submission:
    """What a folder holds. Everything that cannot be used is among the remarks."""
    remarks: list[str] = []
    known: dict[str, Any] = {}
    try:
        told = read_small_toml(folder/DESCRIPTION) if (folder/DESCRIPTION).exists() or (folder/DESCRIPTION).is_symlink() else {}
        known["facts"], known["seconds"] = dict(told_facts(told, remarks)), dict(told_seconds(told, remarks))
        known["map"], given = told_map(told, folder, remarks), told.get("restitution")
        known["restitution"] = float(given) if is_size(given) and given <= 1 else None
    except (Error, ValueError) as error:        # ValueError: a whole number of thousands of digits
        remarks.append(without(f"{DESCRIPTION}: cannot be read: {error}" if isinstance(error, ValueError) else str(error), folder))
    told_before = len(remarks)
    try:
        known["files"] = find_files(folder, remarks)
    except OSError as error:
        remarks.append(f"expected a folder that can be read, found {reason(error)}")
    if not known.get("files") and len(remarks) == told_before:
        remarks.append("expected files such as ex1_aw.csv, found none")
    return Submission(name, remarks=tuple(remarks), **known)


def without(message: str, folder: Path) -> str:
    """A message without the path of the folder, which the name of the code stands for."""
    return printable(message.replace(f"{folder}/", ""), 400)


def read_small_toml(path: Path) -> dict[str, Any]:
    """A TOML file of a size that a person writes; Error otherwise."""
    if not is_file(path) or path.stat().st_size > LONGEST_DESCRIPTION:
        raise Error(file=path, expected=f"a file of at most {LONGEST_DESCRIPTION} bytes",
                    found=f"one of {path.stat().st_size}" if is_file(path) else "none that can be read")
    return read_toml(path)


def told_facts(told: Mapping[str, Any], remarks: list[str]) -> Iterator[tuple[str, str]]:
    """The facts of a description in words; remarks about what cannot be, and about keys that nobody knows, with the nearest one."""
    known = [*FACTS, *SENT, MAP]
    unknown = [key for key in told if key not in known]
    for key in unknown[:MOST_REMARKS]:
        near = difflib.get_close_matches(key[:LONGEST_NAME].lower(), known, 1)
        remarks.append(f"{DESCRIPTION}: expected keys among {', '.join(known)}, found {printable(key, 40)}"
                       + (f"; {near[0]} is the nearest" if near else ""))
    if len(unknown) > MOST_REMARKS:
        remarks.append(f"{DESCRIPTION}: and {len(unknown) - MOST_REMARKS} more keys that are unknown")
    for key, value in ((key, told[key]) for key in FACTS if key in told):
        parts = value if isinstance(value, list) and key not in ("formulation", "restitution", FORCE) else [value]
        fine, expected = EXPECTED.get(key, (lambda x: isinstance(x, str) or is_number(x), "words, a number or a list of them"))
        if key == "processor_time" and isinstance(value, Mapping):
            yield key, f"{sum(x for x in value.values() if is_size(x)):.4g}"
        elif parts and all(map(fine, parts)):
            yield key, printable(", ".join(f"{one:.6g}" if isinstance(one, float) else str(one) for one in parts))
        else:
            remarks.append(f"{DESCRIPTION}: {key}: expected {expected}, found {printable(value, 40)}")


def is_number(x: object) -> TypeGuard[float]:
    """Whether a value is a number of a size that can be."""
    return isinstance(x, int | float) and not isinstance(x, bool) and abs(x) < 1e12


def is_size(x: object) -> TypeGuard[float]:
    """Whether a value is a number from 0 on that can be."""
    return is_number(x) and x >= 0


#: What the values of keys have to be, where it is more than words or a number, also in words.
EXPECTED: dict[str, tuple[Callable[[Any], bool], str]] = {
    "formulation": (lambda x: isinstance(x, str) and any(word in x[:LONGEST_FACT].lower() for word in FORMULATIONS),
                    "elastic or constraints"),
    FORCE: (lambda x: x in CONTACT_FORCES, " or ".join(CONTACT_FORCES)),
    "restitution": (lambda x: is_size(x) and x <= 1, "a number from 0 to 1"),
    "step": (lambda x: isinstance(x, str) or (is_size(x) and x > 0), "a time in seconds"),
    "processor_time": (lambda x: isinstance(x, str) or is_size(x), "a time in seconds")}


def told_seconds(told: Mapping[str, Any], remarks: list[str]) -> Iterator[tuple[str, float]]:
    """Processor times by simulation, where the description has a table of them."""
    given = told.get("processor_time")
    pairs = given.items() if isinstance(given, Mapping) else ()
    yield from ((key, float(x)) for key, x in pairs if key in TASK_NAMES and is_size(x))
    wrong = [(key, x) for key, x in pairs if key not in TASK_NAMES or not is_size(x)]
    remarks += [f"{DESCRIPTION}: processor_time: expected simulations as ex2_aw = 1.5 [s], "
                f"found {printable(key, 40)} = {printable(x, 40)}" for key, x in wrong[:MOST_REMARKS]]


def told_map(told: Mapping[str, Any], folder: Path, remarks: list[str]) -> Mapping[str, Any] | None:
    """The map of columns: a table of the description, or a file of the code's folder that it names."""
    given = told.get(MAP)
    if given is None or isinstance(given, Mapping):
        return given
    try:
        if not isinstance(given, str):
            raise Error(file=f"{DESCRIPTION}: map", expected="a table or the name of a file",
                        found=printable(given, 40))
        if not (folder/given).resolve().is_relative_to(folder.resolve()):
            raise Error(file=f"{DESCRIPTION}: map", expected="a file of the code's folder", found=printable(given, 80))
        return read_small_toml(folder/given)
    except (Error, OSError, ValueError, RuntimeError) as error:
        remarks.append(f"{without(str(error), folder)}; the map is guessed")
        return None


def find_files(folder: Path, remarks: list[str], strict: bool = False) -> dict[Task, Path]:
    """The file of each simulation; of two that of the shipped input's name is taken, or the first by name. strict: Error where
    nothing tells which of two is meant."""
    files: dict[Task, Path] = {}
    for path in sorted(folder.iterdir(), key=lambda path: (path.stem not in TASK_NAMES, path.name)):
        if path.suffix.lower() not in ENDINGS or path.name.startswith("."):
            continue
        task, shown = task_of(path), printable(path.name, 80)
        if task is None:
            remarks.append(f"{shown}: expected a name that says which of the ten simulations it is")
        elif not is_file(path):
            remarks.append(f"{shown}: expected a file, found "
                           + ("a folder" if path.is_dir() else "a link that leads nowhere, or a device"))
        elif task in files:
            if strict and (files[task].stem in TASK_NAMES) == (path.stem in TASK_NAMES):
                raise Error(file=path, expected=f"one file for {task.words}", found=f"{files[task].name}, too")
            remarks.append(f"{shown}: expected one file for {task.words}, found {printable(files[task].name, 80)}, too, which is "
                           "taken")
        else:
            files[task] = path
    return {task: files[task] for task in TASKS if task in files}


def is_file(path: Path) -> bool:
    """Whether there is a file to read; a link to itself is none."""
    try:
        return path.is_file()
    except (OSError, RuntimeError):
        return False


def is_device(path: Path) -> bool:
    """Whether reading a path might never end: that of a device or a pipe, or of a link to one."""
    try:
        return path.exists() and not path.is_file() and not path.is_dir()
    except (OSError, RuntimeError):
        return False
