"""One run: its columns, its results, its events and its case, from a column file or from memory."""
from __future__ import annotations

import copy
import functools
import re
from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .._core.errors import Error, unknown
from .._core.optional import needed
from ..case import Case
from ..constants import CONTACTS
from .columns import read_columns
from .contact_intervals import LARGEST, ContactInterval, find_intervals, is_closed
from .events import Event, event_kinds
from .header import Comments, Header, read_comments
from .quantities import PAIR_FILES, PAIRS

# Why a run ended that ended as its `stop_at` asks, in the core's words; another ending has other words, as 't_end, derailment not
# reached'.
RETURNED = "return to the centre after both flanges"
BACK = "return to the centre"       # begins all endings there; one that goes on otherwise tells where the flange was not reached
AS_ASKED = "t_end", "derailment"
# What a Dataset has of events: its name, the field, and the unit.
EVENT_FIELDS: tuple[tuple[str, str, dict[str, str]], ...] = (
    ("time", "t", {"units": "s"}), ("kind", "kind", {}), ("force", "force", {"units": "N"}),
    ("angle", "angle", {"units": "rad"}), ("loss", "loss", {"units": "J"}))

AnyRun = TypeVar("AnyRun", bound="RunData")

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd
    import xarray as xr


class Results(dict[str, Any]):
    """The outcome of a run by name; UnknownName, with the nearest name, where the run has no result of that name."""

    def __init__(self, file: Path, found: Mapping[str, Any]) -> None:
        super().__init__(found)
        self.file = file

    def __missing__(self, name: str) -> Any:
        raise unknown(f"{self.file}: expected a result {name}", name, list(self), "none")


class RunData:
    """A run that ldbench computed, or the contents of another code's file.

    A file without ldbench's header has `data` alone: `results` and `events` are empty, `ending` is '', and `case` raises Error.
    """

    def __init__(self, file: Path, map: Any = None, name: str = "", *, comments: Comments | None = None,
                 data: pd.DataFrame | None = None, case: Case | None = None) -> None:
        """A run from a column file, or that has what is given in its place. `map` tells how another code names our columns, see
        `read_columns`."""
        #: Path of the column file that exists or that the case names.
        self.file: Path = file
        self._map = map
        vars(self).update({key: part for key, part in (("_comments", comments), ("data", data), ("case", case))
                           if part is not None})
        #: The name of the case, or of the file.
        self.name: str = name or self.header.name or file.stem

    def __getstate__(self) -> dict[str, Any]:
        _ = self.data
        return {key: part for key, part in vars(self).items() if key in ("file", "_map", "name", "_comments", "data", "case")}

    def named(self, name: str) -> RunData:
        """The run by another name."""
        other = copy.copy(self)
        other.name = name
        return other

    def with_data(self, data: pd.DataFrame) -> RunData:
        """The run with other columns or rows."""
        return RunData(self.file, name=self.name, comments=self._comments, data=data)

    # What is known of the run ---------------------------------------------------------------

    @functools.cached_property
    def data(self) -> pd.DataFrame:
        """The columns of the column file in SI units, a row per output interval and event; units in `attrs["units"]`."""
        found = read_columns(self.file, None if self.is_ours else self._map)
        if self.is_ours and not self.ending and "time" in found:
            raise Error(file=self.file, expected="the group &results after the last row",
                        found="none: the run is not finished, or the file is cut")
        return found

    @functools.cached_property
    def case(self) -> Case:
        """The case that was run, with all that went in: `run.case.vY`; Error where the file does not tell it."""
        if not self.is_ours:
            raise Error(file=self.file, expected="the header of ldbench, which tells the case", found="none")
        return Case.of_groups(self._comments.settings, f"{self.file}, header", self.file.resolve().parent)

    @functools.cached_property
    def _comments(self) -> Comments:
        return read_comments(self.file)

    @property
    def header(self) -> Header:
        """Version of ldbench, name and title of the case, profiles, points and errors of the contact table."""
        return self._comments.header

    @property
    def is_ours(self) -> bool:
        """Whether ldbench wrote the file, which then tells the case."""
        return bool(self._comments.settings)

    @property
    def results(self) -> Results:
        """What came out, SI units, by the names in the groups &setup and &results of the column file: `run.results["drift"]`.

        The section Results of the page on output lists them. What did not happen is NaN, such a text is ''. KeyError, with the
        nearest name, for a name that no result has.
        """
        return Results(self.file, self._comments.results)

    @property
    def events(self) -> list[Event]:
        """Events in order of time: the first five of each kind and a hundred impacts. `results` has the numbers of all events."""
        return list(self._comments.events)

    # Questions -----------------------------------------------------------------------------

    @functools.cached_property
    def time(self) -> np.ndarray:
        """The times of the rows, (rows,) [s]; Error where they do not ascend."""
        time = self.values("time")
        if not (np.isfinite(time).all() and np.all(np.diff(time) >= 0)):
            raise Error(file=self.file, expected="rows with ascending times", found="others")
        return time

    def values(self, column: str) -> np.ndarray:
        """A column, (rows,), SI; Error where the run has none of that name."""
        if column not in self.data:
            raise unknown(f"a column {column}", column, map(str, self.data), "none", file=self.file)
        return self.data[column].to_numpy()

    def __getitem__(self, column: str) -> np.ndarray:
        """A column, (rows,), SI: `run["Y"]`."""
        return self.values(column)

    def __contains__(self, column: object) -> bool:
        return column in self.data

    def __iter__(self) -> Iterator[str]:
        return map(str, self.data)

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.data)

    def __bool__(self) -> bool:
        return True

    @property
    def ending(self) -> str:
        """Why the run ended; '' where the file does not say."""
        return self._comments.ending

    @property
    def success(self) -> bool:
        """Whether the run ended as its `stop_at` asks: at the return to the centre, at the derailment, or at `t_end`. False where
        the time was over before, where the wheelset derailed unasked, and where the file does not say."""
        return self.ending in AS_ASKED or self.ending.startswith(BACK)

    @property
    def exercise(self) -> int | None:
        """The number of the exercise, by the name of the case."""
        found = re.match(r"ex(\d)_", self.name)
        return int(found[1]) if found else None

    @property
    def formulation(self) -> str:
        """How contact is treated: 'elastic', 'bilateral' or 'unilateral'; '' in another code's file."""
        return self._text("contact", "formulation") or ("elastic" if self.is_ours else "")

    @property
    def law(self) -> str:
        """The law of elastic contact, 'halfspace', 'strip' or 'hertz'; of rigid contacts the formulation; '' in another code's
        file."""
        return self._text("contact", "model") if self.formulation == "elastic" else self.formulation

    @property
    def pair(self) -> str:
        """The profiles in words, by the names of their files: 'actual profiles', or 's1002.yz on 60e1.yz'. A file without
        ldbench's header has the pair that its name tells; '' where nothing does."""
        wheel, rail, right_wheel, right_rail = (
            Path(self._text("profiles", which)).name for which in (
                "wheel_profile", "rail_profile", "wheel_profile_right", "rail_profile_right"))
        if not (wheel and rail):
            return PAIRS.get(self.name.partition("_")[2], "")
        left = PAIR_FILES.get((wheel, rail), f"{wheel} on {rail}")
        right = PAIR_FILES.get(files := (right_wheel or wheel, right_rail or rail), " on ".join(files))
        return left if left == right else f"{left} (left), {right} (right)"

    @property
    def heading(self) -> str:
        """'Exercise 1, actual profiles', or the name of the case."""
        return f"Exercise {self.exercise}, {self.pair}" if self.exercise and self.pair else self.name

    def _text(self, group: str, name: str) -> str:
        """A text of the namelist, also of one that is no case of this version; '' where the file does not say."""
        return str(self._comments.settings.get(group, {}).get(name, ""))

    def first(self, kind: str) -> Event | None:
        """The first event of a kind; None where there was none."""
        check_kind(kind)
        return next((event for event in self._comments.events if event.kind == kind), None)

    def first_interval(self, contact: str) -> ContactInterval | None:
        """The first interval of the rows in which a contact is closed, of a flange not at its root, for what is drawn; None without
        one. In a file with results it is that of the first touch, in files of other codes the contact angle tells the root."""
        check_contact(contact)
        begin = self.results.get(f"t_first_{contact}", np.nan) - 1e-9        # the times of rows are rounded
        return next((one for one in self.intervals(contact, rigid=False) or []
                     if (self.time[one.rows.stop - 1] >= begin if np.isfinite(begin) else not one.at_root)), None)

    def intervals(self, contact: str, until: float = np.inf, rigid: bool = True) -> list[ContactInterval] | None:
        """The intervals in which a contact is closed, in the rows up to a time [s]; None where the file has no force of it.

        With `rigid`, jumps of the column P of rigid impacts count too.
        """
        force = self.normal_force(contact)
        jumps = self.values(f"P_{contact}") if rigid and f"P_{contact}" in self.data else None
        if force is None and jumps is None:
            return None
        rows = int(np.searchsorted(self.time, until, "right"))
        blows = np.zeros(rows)
        if jumps is not None and rows:
            blows[1:] = np.diff(np.clip(np.nan_to_num(jumps[:rows]), -LARGEST, LARGEST))
        angle = self.values(f"angle_{contact}") if f"angle_{contact}" in self.data else np.full(rows, np.nan)
        return find_intervals(contact, self.time[:rows], np.zeros(rows) if force is None else force[:rows], blows, angle,
                              self._text("output", "rows") in ("interval_and_events", "contacts"))

    def impacts(self, contacts: str | Sequence[str] = CONTACTS) -> list[ContactInterval]:
        """All impacts of a contact, or of some, in order of time: start, end, largest force, impulse and contact angle of each.

        An impact is a set of successive closed rows between two open rows. A contact that is closed in the first or last row of
        the file is left out there, because its length is unknown, and so is a contact that also pulls. A run with rigid contacts
        adds the impacts among its events, of which the file lists a hundred.
        """
        contacts = [contacts] if isinstance(contacts, str) else contacts
        found = [one for contact in contacts for one in self.intervals(contact, rigid=False) or [] if one.is_impact]
        found += [ContactInterval(contact, event.t, event.t, np.nan, event.t, impulse, np.nan) for event in self.events
                  for contact, impulse in event.impulses.items() if contact in contacts]
        return sorted(found, key=lambda one: (one.start, CONTACTS.index(one.contact)))

    def normal_force(self, contact: str) -> np.ndarray | None:
        """The normal force of a contact, (rows,) [N], 0 in empty cells; of a file without it, that of its components; None
        without these."""
        check_contact(contact)
        parts = [self.values(name).astype(float) for n in ("N", "Fy", "Fz") if (name := f"{n}_{contact}") in self.data]
        if not parts:
            return None
        with np.errstate(over="ignore"):
            force = parts[0] if f"N_{contact}" in self.data else np.hypot(parts[0], parts[1] if len(parts) == 2 else 0.0)
        return np.clip(np.nan_to_num(force, nan=0.0, posinf=0.0, neginf=0.0), -LARGEST, LARGEST)

    def closed(self, contact: str) -> np.ndarray:
        """Whether a contact is closed, (rows,): its normal force, of either sign, is above 1 N. None is without a column."""
        force = self.normal_force(contact)
        return np.zeros(len(self.data), bool) if force is None else np.asarray(is_closed(force))

    # Elsewhere -----------------------------------------------------------------------------

    def to_xarray(self) -> xr.Dataset:
        """The columns as an xarray Dataset over `time`, with units, so that `.sel(time=slice(0.1, 0.2))` finds rows.

        A file without times is one over `row`. An impact of rigid contacts has two rows at one time.

        The events have the dimension `event`, with `event_time`, `event_kind`, `event_force`, `event_angle`, `event_loss` and,
        over `contact`, `event_impulse`. `results`, the ending and the name of the case are attributes.
        """
        xarray = needed("xarray", "ensemble")
        units, rows = self.data.attrs.get("units", {}), "time" if "time" in self.data else "row"
        data: dict[str, Any] = {name: (rows, self.values(name), {"units": units.get(name) or "1"}) for name in self}
        if self.events:
            data |= {f"event_{name}": ("event", np.array([getattr(event, field) for event in self.events]), attributes)
                     for name, field, attributes in EVENT_FIELDS}
            data["event_impulse"] = (("event", "contact"), np.array(
                [[event.impulses.get(contact, 0.0) for contact in CONTACTS] for event in self.events]), {"units": "N.s"})
        told = {name: int(value) if isinstance(value, bool) else value for name, value in self.results.items()
                if not (isinstance(value, float) and np.isnan(value))}
        coordinates = {"contact": list(CONTACTS)} if self.events else {}
        return xarray.Dataset(data, coordinates, {"case": self.name, "title": self.header.title, "end": self.ending, **told})


def check_contact(contact: str) -> None:
    """Refuse what is not the name of a contact."""
    if contact not in CONTACTS:
        raise unknown(f"a contact {', '.join(CONTACTS)}", contact, CONTACTS)


def check_kind(kind: str) -> None:
    """Refuse what is not a kind of events."""
    if kind not in event_kinds():
        raise unknown("a kind of events", kind, event_kinds())


def read_data(path: str | PathLike[str], map: Any = None) -> RunData:
    """Read a column file. map: how another code names our columns; it is for a file without ldbench's header."""
    return checked(RunData(Path(path), map))


def checked(run: AnyRun) -> AnyRun:
    """The run; Error at once where its file cannot be read."""
    _ = run.data
    return run
