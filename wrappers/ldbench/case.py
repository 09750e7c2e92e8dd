"""A case: the values of all namelist variables."""
from __future__ import annotations

import copy
import functools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, NoReturn

import numpy as np

from ._core import flat
from ._core.calls import check, kept_folder, path_bytes, text, text_bytes
from ._core.errors import BadType, BadValue, Error, MissingFile, UnknownName, unknown
from ._core.files import complete
from ._core.wording import html_table

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd
    from typing_extensions import Unpack

    from ._core.case_types import Values, Variables
else:
    Variables = object

Value = float | int | str
Changes = Mapping[str, "Value | os.PathLike[str]"]

EXERCISES, PAIRS = range(1, 6), ("aw", "sw")       # of the shipped inputs
TEXT_LENGTH = 256       # of a text variable in the core
LARGEST = 2**31 - 1     # whole number of the core


class Variable(NamedTuple):
    """A namelist variable as the core lists it."""

    group: str
    name: str
    kind: str           # 'real', 'integer' or 'text'
    default: str
    range: str          # in words
    unit: str
    meaning: str
    header: str         # 'always', or 'if set' where headers have it only if it is not the default

    @property
    def is_slope(self) -> bool:
        """Whether the value is an angle that may be given as 1:n."""
        return "1:n" in self.range


@functools.cache
def variables() -> tuple[Variable, ...]:
    """All namelist variables, in the order of the core's list."""
    return tuple(Variable(*line.split("\t")) for line in text(*flat.describe_variables()).splitlines())


@functools.cache
def data_folder() -> Path:
    """The folder of the shipped inputs/ and profiles/: that of the installed package, or the repository."""
    package = Path(__file__).resolve().parent
    return next((folder for folder in (package / "data", package.parents[1]) if (folder / "inputs").is_dir()), package)


def places(folder: Path | None) -> bytes:
    """Where files are looked for after the working folder, as the core takes it: beside a namelist in `folder`, and among the
    shipped ones."""
    return b"\x1c".join(os.fsencode(place) for place in (folder or "", data_folder()))


def find_file(name: str | os.PathLike[str], folder: Path | None = None) -> str:
    """Path of the file that is called `name`: from the working folder, beside the namelist in `folder` or in the folder above it,
    or among the shipped ones. MissingFile, which names these places, where there is none."""
    path, size, message, length = flat.find_file(path_bytes(name), places(folder))
    check(message, length)
    return os.fsdecode(bytes(path)[:size])


@functools.cache
def _indices() -> dict[str, tuple[int, ...]]:
    """Place in the list of every name and group_name, in lower case; several where a name is ambiguous."""
    found: dict[str, tuple[int, ...]] = {}
    for k, variable in enumerate(variables()):
        found[f"{variable.group}_{variable.name}".lower()] = (k,)
    for k, variable in enumerate(variables()):
        name = variable.name.lower()
        found[name] = found.get(name, ()) + (k,)
    return found


def find_variable(name: str) -> int:
    """Place in the list of the variable called `name`, or `group_name`, in any case of letters."""
    found = _indices().get(name.lower(), ())
    if len(found) == 1:
        return found[0]
    if found:
        choices = " or ".join(f"{variables()[k].group}_{variables()[k].name}" for k in found)
        raise UnknownName(expected=f"{choices}", found=f"{name}, which is ambiguous")
    nearest = {known: shortest_name(places[0]) for known, places in _indices().items()}
    raise unknown("a namelist variable (python -m ldbench variables lists them)", name, nearest)


def find_variables(names: Iterable[str]) -> list[int]:
    """Places in the list of variables, each of which may be named once: vY, VY and initial_vY are one variable."""
    found: dict[int, str] = {}
    for name in names:
        if (k := find_variable(name)) in found:
            raise BadType(expected="every variable once", found=f"{found[k]} and {name}, which are one")
        found[k] = name
    return list(found)


class Case(Variables):
    """All namelist variables of a run; immutable.

        case = ldbench.Case(vY=0.3, dt=5e-6)            # the other variables have the defaults of a namelist

    Variables are attributes, by their namelist names in any case of letters: `case.dt`, `case.vY`. Where two
    groups share a name, for files and folders, and anywhere else if you like, the group goes before it:
    `case.table_roll`, `case.output_file`, `case.table_folder`. Values are in SI units, angles in rad; `case.describe()` lists them.

    Files with relative names are looked for in the working folder, then beside the namelist file and in the folder above it,
    then among the shipped ones, as by the executable. Columns and contact tables go to the working folder; tables go to the
    user's cache where their folder may not be written.
    """

    values: tuple[Value, ...]       # in the order of `variables()`
    unchanged: tuple[Value, ...]    # the values before `replace`
    label: str                      # the namelist file, for messages
    folder: Path | None             # the namelist file's folder

    #: `ldbench.trust` sets it: a case knows no runs.
    trust: ClassVar[Callable[..., Any]]

    def __init__(self, values: Changes | None = None, /, **changes: Unpack[Values]) -> None:
        """A case of the benchmark with other values, by their names or in a mapping: `Case(vY=0.3, output_file="fast.txt")`,
        `Case({"vY": 0.3})`. Error where the core refuses a value."""
        vars(self).update(values=defaults(), label="case", folder=None)
        vars(self)["unchanged"] = vars(self)["values"] = self._with(together(values, changes)).values
        self._refuse()

    @classmethod
    def of_values(cls, values: Sequence[Value], label: str = "case", folder: Path | None = None) -> Case:
        """A case of the values of all variables, in the order of `variables()`."""
        case = cls.__new__(cls)
        vars(case).update(label=label, folder=folder)
        vars(case)["unchanged"] = vars(case)["values"] = tuple(
            case._coerced(variable, value) for variable, value in zip(variables(), values, strict=True))
        case._check()
        return case

    @classmethod
    def of_groups(cls, groups: Mapping[str, Mapping[str, Value]], label: str = "case", folder: Path | None = None) -> Case:
        """A case of the groups of a namelist that give every variable, as the header of a column file does."""
        for variable in variables():
            if variable.header == "always" and variable.name not in groups.get(variable.group, {}):
                raise Error(file=label, group=variable.group, variable=variable.name, expected=variable.range,
                            found="none")
        return cls.of_values([groups[variable.group].get(variable.name, default)
                              for variable, default in zip(variables(), defaults(), strict=True)], label, folder)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a Case does not change; case.replace({name}=...) gives another one")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError("a Case does not change")

    @classmethod
    def from_namelist(cls, source: str | os.PathLike[str] | Mapping[str, Mapping[str, Value]]) -> Case:
        """A case from a namelist file, from namelist text, or from groups as `namelist` gives them.

        A string that begins with & or has several lines is text. A file that is not in the working folder may be a shipped one,
        `inputs/ex1_aw.nml`. Variables that are not mentioned have the benchmark's values. Raises Error with the core's message.
        """
        if isinstance(source, Mapping):
            return cls._read("namelist", _namelist_text(source))
        if isinstance(source, str) and (not source.strip() or source.lstrip().startswith(("&", "\ufeff")) or "\n" in source):
            return cls._read("namelist", source)
        return cls._read(find_file(source), None)

    @classmethod
    def given(cls, case: Case | str | os.PathLike[str]) -> Case:
        """The case itself, or that of a namelist file."""
        if isinstance(case, Case):
            return case
        if not isinstance(case, str | os.PathLike):
            raise BadType(expected="a Case, or the path or the text of a namelist",
                          found=f"{type(case).__name__}: Case(values) makes a case of a mapping of values")
        return cls.from_namelist(case)

    @classmethod
    def exercise(cls, number: int, profiles: str = "aw") -> Case:
        """One of the ten shipped inputs: exercise 1 to 5 with the actual ('aw') or simplified ('sw') profiles."""
        if number not in EXERCISES or profiles not in PAIRS:
            raise BadValue(expected=f"exercise {EXERCISES[0]} to {EXERCISES[-1]} with the profiles {' or '.join(map(repr, PAIRS))}",
                           found=f"{number!r} with {profiles!r}")
        return cls.from_namelist(data_folder() / "inputs" / f"ex{number}_{profiles}.nml")

    @classmethod
    def _read(cls, label: str, source: str | None) -> Case:
        folder = Path(label).resolve().parent if source is None else None
        numbers, words, message, length = flat.read_namelist(
            path_bytes(label), int(source is not None), _words(source or ""), places(folder), len(variables()))
        check(message, length)
        return cls.of_values(_unpack(numbers, bytes(words)), label, folder)

    def replace(self, values: Changes | None = None, /, **changes: Unpack[Values]) -> Case:
        """A case with other values: `case.replace(vY=0.3, dt=5e-6)`, or `case.replace({"vY": 0.3, "dt": 5e-6})`."""
        changed = self._with(together(values, changes))
        changed._refuse()
        return changed

    def _check(self) -> None:
        """Raise the core's Error where a value is out of range or does not fit the others."""
        check(*flat.check_values(path_bytes(self.label), *self.arrays()))

    def _refuse(self) -> None:
        """As `_check`, of values that are arguments: the Error is a ValueError too."""
        try:
            self._check()
        except MissingFile:
            raise
        except Error as error:
            raise error.turned(BadValue) from None

    def check_writable(self, path: str | os.PathLike[str]) -> None:
        """Check before a run that its column file can be written."""
        check(*flat.check_writable(path_bytes(self.label), path_bytes(path)))

    def _with(self, changes: Changes) -> Case:
        """A case with other values, before the core has checked them."""
        values = list(self.values)
        for k, value in zip(find_variables(changes), changes.values(), strict=True):
            values[k] = self._coerced(variables()[k], value)
        changed = copy.copy(self)
        vars(changed)["values"] = tuple(values)
        return changed

    def _coerced(self, variable: Variable, value: Value | os.PathLike[str]) -> Value:
        """A value of the variable's kind; its range is left to the core."""
        refusal: type[Error] = BadType
        if variable.kind == "text":
            if isinstance(value, os.PathLike):
                value = os.fspath(value)
            if variable.is_slope and isinstance(value, Real) and not isinstance(value, (bool, np.bool_)):
                value = repr(float(value))
            refusal = BadValue if isinstance(value, str) else BadType
            if isinstance(value, str) and len(_words(value)) <= TEXT_LENGTH:
                return value.rstrip(" ")
        elif isinstance(value, str) and variable.is_slope:
            refusal = BadValue
            with suppress(Error):
                return slope_angle(variable, value)
        elif isinstance(value, Real) and not isinstance(value, (bool, np.bool_)):
            refusal = BadValue
            with suppress(OverflowError):       # where no real number is so large
                if variable.kind == "real":
                    return float(value)
                if (isinstance(value, Integral) or float(value).is_integer()) and abs(value) <= LARGEST:
                    return int(value)
        raise refusal(file=self.label, group=variable.group, variable=variable.name, expected=variable.range, found=f"{value!r}")

    def arrays(self) -> tuple[np.ndarray, bytes]:
        """The values as the core takes them: numbers, shape (variables,), and texts of 256 characters each, with the places where
        files are looked for."""
        numbers = np.array([0.0 if isinstance(value, str) else float(value) for value in self.values])
        words = b"".join((_words(value) if isinstance(value, str) else b"").ljust(TEXT_LENGTH) for value in self.values)
        return numbers, words + places(self.folder)

    def namelist(self) -> dict[str, dict[str, Value]]:
        """All values by group and variable: `case.namelist()["initial"]["vY"]`."""
        groups: dict[str, dict[str, Value]] = {}
        for variable, value in zip(variables(), self.values, strict=True):
            groups.setdefault(variable.group, {})[variable.name] = value
        return groups

    def to_namelist(self, path: str | os.PathLike[str] | None = None) -> str:
        """All values as namelist text, also written to `path` if given.

        `Case.from_namelist(case.to_namelist()) == case`, to the last bit.
        """
        source = _namelist_text(self.namelist())
        if path is not None:
            with complete(Path(path)) as scratch:
                scratch.write_bytes(os.fsencode(source))
        return source

    def find(self, name: str) -> str:
        """Path of the file that the case calls `name`; `name` itself when there is none."""
        with suppress(MissingFile):
            return find_file(name, self.folder)
        return name

    @property
    def kept_folder(self) -> str:
        """The folder that keeps contact tables: `table_folder`, or the user's cache where that may not be written; '' for none."""
        return kept_folder(self.table_folder)

    def profile_files(self) -> dict[str, str]:
        """Paths of the profiles by variable, those of the right side where they are named."""
        names = "wheel_profile", "rail_profile", "wheel_profile_right", "rail_profile_right"
        return {name: self.find(str(getattr(self, name))) for name in names if getattr(self, name)}

    def files(self) -> dict[str, str]:
        """Paths of all files that a run reads, by variable."""
        return self.profile_files() | ({"bodies": self.find(self.bodies)} if self.influence == "bodies" else {})

    def describe(self) -> pd.DataFrame:
        """All variables as a table: value, default, unit, range and meaning by group and name."""
        import pandas as pd

        rows = [(v.group, v.name, value, default, v.unit, v.range, v.meaning) for v, value, default in
                zip(variables(), self.values, defaults(), strict=True)]
        return pd.DataFrame(rows, columns=["group", "name", "value", "default", "unit", "range", "meaning"],
                            ).set_index(["group", "name"])

    if not TYPE_CHECKING:       # `Variables` tells all names to type checkers
        def __getattr__(self, name: str) -> Any:
            """A variable by its name in other letters, or by group_name."""
            if name.startswith("_") or name in ("values", "unchanged", "label", "folder"):
                raise AttributeError(name)
            try:
                return getattr(self, shortest_name(find_variable(name)))
            except Error as error:
                raise AttributeError(str(error)) from None

    def __eq__(self, other: object) -> bool:
        """Whether all values are equal and the names of files lead to the same ones."""
        if not isinstance(other, Case):
            return NotImplemented
        return self.values == other.values and self._places() == other._places()

    def __hash__(self) -> int:
        return hash((self.values, *self._places()))

    def _places(self) -> list[str]:
        """The paths of the files that are read, links resolved."""
        return [os.path.realpath(file) for file in self.files().values()]

    def _repr_html_(self) -> str:
        """Show the values that differ from the defaults, with units and meanings, in a notebook."""
        rows = [(f"&{v.group} {v.name}", f"{value!r}", v.unit, v.meaning) for v, value, default in
                zip(variables(), self.values, defaults(), strict=True) if value != default]
        return html_table(f"{self.case_name}: {self.title}", rows or [("all", "the benchmark's values", "", "")],
                     ("variable", "value", "unit", "meaning"))

    def __repr__(self) -> str:
        """Write the values that differ from the defaults as Python; `eval(repr(case))` gives an equal case."""
        changed = (f"{shortest_name(k)}={value!r}" for k, (value, default) in
                   enumerate(zip(self.values, defaults(), strict=True)) if value != default)
        return f"Case({', '.join(changed)})"


def slope_angle(variable: Variable, words: str) -> float:
    """The angle of words such as '1:40', as the core reads them of a variable [rad]."""
    return float(Case.from_namelist({variable.group: {variable.name: words}}).values[variables().index(variable)])


def together(values: Changes | None, changes: Mapping[str, object]) -> Changes:
    """Values from a mapping and from keywords, where no name stands in both."""
    values = {} if values is None else values
    if not isinstance(values, Mapping):
        raise BadType(expected="a mapping of values by their names", found=type(values).__name__)
    if both := values.keys() & changes.keys():
        raise BadType(expected="every variable once",
                      found=f"{' and '.join(sorted(both))} in the mapping and as a keyword")
    return {**values, **changes}        # type: ignore[dict-item]      # the values of a TypedDict are objects to mypy


def shortest_name(k: int) -> str:
    """The name of the k-th variable; with its group where the name alone is ambiguous or does not tell what is in the file."""
    variable = variables()[k]
    alone = len(_indices()[variable.name.lower()]) == 1 and variable.name not in ("file", "folder")
    return variable.name if alone else f"{variable.group}_{variable.name}"


def _property(k: int, variable: Variable) -> property:
    """The k-th variable as an attribute of a case, with what help() says of it."""
    def value(case: Case) -> Value:
        return case.values[k]

    def title(case: Case) -> Value:
        return case.values[k] or text(*flat.describe_case(*case.arrays()))

    unit = f" [{variable.unit}]" if variable.unit not in ("", "1") else ""
    words = f"{variable.name}{unit}: {variable.meaning}. Expected is {variable.range}; the default is {variable.default.strip()} "
    return property(title if variable.name == "title" else value, doc=f"{words}(&{variable.group}).")


for _k, _variable in enumerate(variables()):
    setattr(Case, shortest_name(_k), _property(_k, _variable))


@functools.cache
def defaults() -> tuple[Value, ...]:
    """The benchmark's value of every variable."""
    numbers, words, message, length = flat.read_namelist(b"case", 1, b"&case /", places(None), len(variables()))
    check(message, length)
    return tuple(_unpack(numbers, bytes(words)))


def _namelist_text(groups: Mapping[str, Mapping[str, Value]]) -> str:
    """Groups as the text of a namelist."""
    def word(value: object) -> str:
        return "'" + str(value).replace("'", "''") + "'" if isinstance(value, (str, os.PathLike)) else str(value)

    lines: list[str] = []
    for group, values in groups.items():
        lines += [f"&{group}", *(f"    {name} = {word(value)}" for name, value in values.items()), "/"]
    return "\n".join(lines) + "\n"


def _words(text: str) -> bytes:
    """A text for the core, with another control character for NUL, where f2py would end it; the core refuses either."""
    return text_bytes(text.replace("\0", "\x7f"))


def _unpack(numbers: np.ndarray, words: bytes) -> list[Value]:
    def value(k: int, kind: str) -> Value:
        if kind == "text":
            return os.fsdecode(words[TEXT_LENGTH * k:TEXT_LENGTH * (k + 1)]).rstrip(" ")
        return int(numbers[k]) if kind == "integer" else float(numbers[k])

    return [value(k, variable.kind) for k, variable in enumerate(variables())]
