"""The contact table of a case: forces, energies and stiffness of any pose."""
from __future__ import annotations

import functools
import logging
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from ._core import flat
from ._core.calls import Handle, check, path_bytes, version
from ._core.errors import BadValue, Error
from ._core.files import complete
from ._core.wording import counted, html_table
from .case import TEXT_LENGTH, Case, variables
from .conicity import GEOMETRY, GEOMETRY_PITCH, geometry_rows
from .constants import CONTACTS
from .number_text import clearance_words
from .pressure import ELEMENTS, Patch, check_model, load, press
from .profiles.profile import core_file, geometry_file
from .run_curve import Rigid, change_words

if TYPE_CHECKING:       # pandas is imported where a frame is made: it takes longer than a short run
    import pandas as pd

log = logging.getLogger(__name__)

Wheel = Literal["both", "left", "right"]
Curve = Literal["run", "geometry"]      # that of runs has no waves that break a contact into several patches
Outside = Literal["raise", "nan"]

WHEELS = "both", "left", "right"
FILES = "wheel_profile", "rail_profile", "wheel_profile_right", "rail_profile_right", "bodies"     # in the order of the core
CELL = 16           # characters of a number in a file of columns

# What a case may change and keep its contact table. Profiles are compared by their contents.
FREE_GROUPS = "case", "initial", "loading", "integrator", "output"
FREE_NAMES = ("mass", "roll_inertia", "pitch_inertia", "vertical_load", "friction", "shear_modulus",
              "wheel_profile", "rail_profile", "wheel_profile_right", "rail_profile_right", "folder", "restitution")


@functools.cache
def bound_places() -> list[int]:
    """Places of the variables, beside the profiles, that a contact table depends on."""
    return [k for k, variable in enumerate(variables()) if variable.group not in FREE_GROUPS and variable.name not in FREE_NAMES]


# By the status of a pose.
OUTSIDE = ("", "lateral = {case.lateral} m", "roll = {case.table_roll} rad", "depth = {case.depth} m",
           "as it was made, where contacts push")


class ContactTable:
    """The elastic contact of a case's wheelset with its rails, tabulated by the core.

    A pose is (y, z, roll): lateral and vertical position of the axle centre in the track frame, from the
    track centreline and the top of rail [m], and the roll angle [rad]. `table.equilibrium` is the z of the
    wheelset at rest, so a column file's Z corresponds to z = equilibrium + Z. Arguments y, z, roll broadcast
    against each other; `...` below is their common shape.

    A wheel is 'left', 'right' or 'both'. A pose that the table does not hold raises Error, or gives NaN with
    `outside="nan"`; nothing is extrapolated.
    """

    case: Case
    seconds: float      # processor time for the preparation [s]
    #: Rigid-axle flange clearance to the left [m].
    clearance: float
    #: Rigid-axle flange clearance to the right [m]; that to the left where both sides have the same profiles.
    clearance_right: float
    #: Height z of the axle centre of the wheelset at rest, held at y = 0 [m].
    equilibrium: float
    #: Roll angle of the wheelset at rest [rad], 0 where left and right are the same: a column file's roll is measured from it.
    equilibrium_roll: float
    #: The pose (y, z, roll) in which the wheelset rests by itself; off the centre where left and right differ.
    rest: tuple[float, float, float]
    #: Height z of the axle centre at which the centred wheelset just touches [m].
    rigid_height: float
    #: How much lower the axle rests than with rigid contacts [m].
    sinking: float
    #: Gravity and vertical load [N].
    weight: float
    #: Half of the weight [N].
    load_per_wheel: float
    #: The three eigenfrequencies at rest, ascending [Hz]; an unstable one is negative. With rigid contacts there is one; the others
    #: are nan.
    frequencies: tuple[float, ...]

    def __init__(self, case: Case | str | os.PathLike[str]) -> None:
        """Prepare the table of a case, or of a namelist file, with what the case's table folder keeps.

        What a pose needs is solved when it is first asked for, and kept: by this table for all its poses and runs, and in the
        folder where the case names one.
        """
        case = Case.given(case)
        address, message, length = flat.prepare_case(*case.arrays(), located(case))
        check(message, length, case.label)
        self._own(case, Handle(flat.free_prepared, address))
        self._tell_smoothing()
        log.info("%s: %r", case.label, self)

    def _own(self, case: Case, handle: Handle) -> None:
        self.case, self._handle = case, handle
        (self.clearance, self.clearance_right, self.equilibrium, self.equilibrium_roll, self.rigid_height, y, z, roll,
         self.weight, self.seconds, *frequencies) = flat.prepared_numbers(handle).tolist()
        self.rest, self.frequencies = (y, z, roll), tuple(frequencies)
        self.sinking, self.load_per_wheel = self.rigid_height - self.equilibrium, self.weight/2

    def for_case(self, case: Case) -> ContactTable:
        """This table for a case that differs in initial conditions, loading, inertia, integrator or output.

        Raises Error when the case needs another table.
        """
        for k in bound_places():
            if (ours := self.case.values[k]) != (theirs := case.values[k]):
                raise Error(file=case.label, group=variables()[k].group, variable=variables()[k].name,
                            expected=f"{ours!r}, for which the contact table was made", found=f"{theirs!r}")
        address, message, length = flat.adapt_case(self._handle, *case.arrays(), located(case))
        check(message, length, case.label)
        new = object.__new__(ContactTable)
        new._own(case, Handle(flat.free_prepared, address, self._handle))
        if any(variable.group == "wheelset" and ours != theirs
               for variable, ours, theirs in zip(variables(), self.case.values, case.values, strict=True)):
            new._tell_smoothing()
        return new

    def _tell_smoothing(self) -> None:
        """Let the run's header tell what the smoothing of waves changes, where a profile has it."""
        if words := smoothing_words(self.case, self._handle, self.frequencies[0]):
            flat.tell_setup(self._handle, words.encode("ascii", "replace"))

    def __copy__(self) -> ContactTable:
        return self             # nothing in it changes

    def __deepcopy__(self, memo: object) -> ContactTable:
        return self

    def __reduce__(self) -> tuple[Callable[..., ContactTable], tuple[object, ...]]:
        """Elsewhere the table is prepared from its case."""
        return _made_again, (self.case, self._landmarks())

    def _landmarks(self) -> tuple[float, ...]:
        """What changes with the profiles."""
        return self.clearance, self.clearance_right, self.equilibrium, self.rigid_height

    @property
    def solutions(self) -> tuple[int, int, int]:
        """Solutions in the tables of both sides, those of them that the folder kept, and those that did not converge."""
        solved, found, failed = np.sum([flat.table_solutions(self._handle, side) for side in (1, 2)], axis=0).tolist()
        return solved, found, failed

    def errors(self, y: ArrayLike, z: ArrayLike, roll: ArrayLike, wheel: Wheel = "left") -> tuple[np.ndarray, np.ndarray]:
        """Error of the force on the left or right wheel, |F_table - F|/max(|F|, 5 kN), and |F| [N], shape (...) each.

        F is a finite difference of the energy without the table, of the whole wheel, pressed anew on finer grids. The error is NaN
        where that does not converge. It takes some milliseconds a pose.
        """
        if self.case.formulation != "elastic" or wheel == "both":
            raise BadValue(f"expected elastic contacts and wheel='left' or 'right', found {self.case.formulation!r}, {wheel!r}")
        arrays = np.broadcast_arrays(*(np.asarray(x, float) for x in (y, z, roll)))
        y, z, roll = (np.ascontiguousarray(x).ravel() for x in arrays)
        errors, forces = flat.force_errors(self._handle, _number(wheel), y, z, roll)
        return errors.reshape(arrays[0].shape), forces.reshape(arrays[0].shape)

    def potential(self, y: ArrayLike, z: ArrayLike, roll: ArrayLike, wheel: Wheel = "both",
                  outside: Outside = "raise") -> np.ndarray:
        """Elastic energy, shape (...) [J]."""
        return self._evaluate((), (y, z, roll), outside, wheel)

    def force(self, y: ArrayLike, z: ArrayLike, roll: ArrayLike, wheel: Wheel = "both", outside: Outside = "raise") -> np.ndarray:
        """Force of the rails on the wheels, shape (..., 3): F_y, F_z [N], moment M_x about the axle centre [N m].

        It is minus the gradient of `potential`.
        """
        return self._evaluate((3,), (y, z, roll), outside, wheel)

    def tangent(self, y: ArrayLike, z: ArrayLike, roll: ArrayLike, wheel: Wheel = "both", outside: Outside = "raise") -> np.ndarray:
        """Tangent stiffness, shape (..., 3, 3): second derivatives of `potential` in (y, z, roll) [N/m, N, N m]."""
        hessian = self._evaluate((6,), (y, z, roll), outside, wheel)
        return hessian[..., [[0, 1, 2], [1, 3, 4], [2, 4, 5]]]

    def forces_by_contact(self, y: ArrayLike, z: ArrayLike, roll: ArrayLike, outside: Outside = "raise") -> np.ndarray:
        """`force` of each contact, shape (..., 4, 3): left tread, left flange, right tread, right flange."""
        return self._evaluate((4, 3), (y, z, roll), outside)

    def pressure(self, y: float, z: float, roll: float, elements: int = ELEMENTS) -> list[Patch]:
        """Pressed patches of all contacts in one pose, solved anew for half-spaces, not from the table: pressure on a grid,
        largest and mean pressure, area, lengths, place on wheel and rail; force and angle are those of the table. For model
        'halfspace'.

        A patch has `elements` over its length along the profile, a multiple of 4, and half as many in rolling direction.
        A wheel is pressed as a whole.
        """
        check_model(self.case)
        forces = self.forces_by_contact(y, z, roll)          # raises Error outside the table
        loads = {name: load(name, *force[:2]) for name, force in zip(CONTACTS, forces, strict=True)}
        return press(self._handle, self.case, (y, z, roll), elements=elements, loads=loads)

    def _evaluate(self, shape: tuple[int, ...], pose: tuple[ArrayLike, ...], outside: Outside, wheel: Wheel = "both") -> np.ndarray:
        """The values of this shape for each pose, which the core tells apart by their number."""
        if self.case.formulation != "elastic":
            raise Error(file=self.case.label, group="contact", variable="formulation",
                        expected="'elastic', which has a contact table", found=f"{self.case.formulation!r}")
        if outside not in ("raise", "nan"):
            raise BadValue(expected="outside='raise' or 'nan'", found=f"{outside!r}")
        arrays = np.broadcast_arrays(*(np.asarray(x, float) for x in pose))
        y, z, roll = poses = [np.ascontiguousarray(x).ravel() for x in arrays]
        if not y.size:
            return np.empty((*arrays[0].shape, *shape))
        values, status = flat.contact_values(self._handle, _number(wheel), math.prod(shape), y, z, roll)
        values = values.T               # the core has the pose last
        if status.any():
            if outside == "raise":
                self._refuse(poses, status)
            values[status != 0] = np.nan
        return values.reshape((*arrays[0].shape, *shape))

    def _refuse(self, poses: list[np.ndarray], status: np.ndarray) -> NoReturn:
        """Raise the error that tells the first pose outside the table."""
        k = int(np.flatnonzero(status)[0])
        y, z, roll = (float(x[k]) for x in poses)
        if not np.isfinite([y, z, roll]).all():
            raise Error(file=self.case.label, expected="finite numbers",
                        found=f"the pose y = {y} m, z = {z} m, roll = {roll} rad")
        # The table ends at a line that leans: a wheel that is too low leaves it as one does that is too far aside.
        limit = (f"drop = {self.case.drop} m" if status[k] == 1 and abs(y) <= self.case.lateral else
                 OUTSIDE[status[k]].format(case=self.case))
        raise Error(file=self.case.label, expected=f"poses within &table {limit}",
                    found=f"y = {y} m, z = {z} m, roll = {roll} rad outside")

    def geometry(self, y: ArrayLike | None = None) -> pd.DataFrame:
        """Geometry functions of the rigid wheelset over lateral displacements y, shape (n,) [m].

        Columns Y, roll, Z (from the centred position), contact angle, rolling radius and contact point of the
        left (L) and right (R) wheel, delta_r = radius_L - radius_R, and the equivalent conicity for the
        amplitude |Y|; units in `attrs["units"]`. Without y: every 0.1 mm to 1.2 times the clearance. A row is
        NaN where the wheelset does not stand on both rails.
        """
        import pandas as pd

        if y is None:
            reach = int(12e3 * max(self.clearance, self.clearance_right))
            y = GEOMETRY_PITCH*np.arange(-reach, reach + 1)
        y = np.atleast_1d(np.asarray(y, float)).ravel()
        rows = geometry_rows(self._handle, y) if y.size else np.empty((13, 0))
        frame = pd.DataFrame(rows.T, columns=list(GEOMETRY))
        frame["Y"] = y
        frame.attrs["units"] = dict(GEOMETRY)
        return frame

    def write_geometry(self, path: str | os.PathLike[str]) -> None:
        """Write the geometry functions over the displacements at which the wheelset stands on both rails, in the form of a column
        file."""
        frame = self.geometry()
        stands = np.isfinite(frame["roll"].to_numpy())
        middle = len(stands)//2
        last = min(int(stands[middle:].cumprod().sum()), int(stands[middle::-1].cumprod().sum())) - 1
        if last < 2:
            raise Error(file=os.fspath(path), expected="a wheelset that stands on both rails",
                        found=f"{self.case.label} without one")
        setup = {"clearance_left": self.clearance, "clearance_right": self.clearance_right, "axle_height": self.equilibrium,
                 "axle_roll": self.equilibrium_roll}
        head = [f"ldbench {version()}", f"case {self.case.case_name}: {self.case.title}", "&setup",
                *(f"  {name} = {value!r}" for name, value in setup.items()), "/",
                "conicity: equivalent, by harmonic linearisation, for the amplitude |Y| about where the mean of delta_r is 0"]
        units = [f"{unit:>{CELL}}" for unit in GEOMETRY.values()]
        rows = frame.to_numpy()[middle - last:middle + last + 1]
        with complete(Path(path)) as scratch:
            scratch.write_text("\n".join([
                "".join(f"{name:>{CELL}}" for name in GEOMETRY), *(f"# {line}" for line in head), "#" + "".join(units)[1:],
                *("".join(f"{x:{CELL}.8e}" for x in row) for row in rows)]) + "\n")

    @property
    def clearance_words(self) -> str:
        """'left 10.180, right 10.180' [mm]."""
        return clearance_words(self.clearance, self.clearance_right)

    def lines(self) -> list[str]:
        """What there is to say of the rigid and the resting wheelset and of the table, line by line."""
        case, stiffness, made = self.case, "", f"formulation {self.case.formulation}: rigid contacts, no contact table"
        if case.formulation == "elastic":
            stiffness = f", vertical stiffness {1e-6*self.tangent(0.0, self.equilibrium, 0.0)[1, 1]:.1f} kN/mm"
            kept = f"kept in {folder}" if (folder := case.kept_folder) else "not kept"
            made = f"contact table: model {case.model}, {self._made}, {kept}"
        return [f"profiles: {profile_names(case)}", f"rigid-axle clearance [mm]: {self.clearance_words}",
                f"equilibrium: axle {self.equilibrium:.6f} m above the rails, {1e3*self.sinking:.4f} mm lower than with rigid "
                f"contacts, {1e-3*self.load_per_wheel:.3f} kN per wheel{stiffness}", made]

    @property
    def _made(self) -> str:
        solved, found, _ = self.solutions
        return f"{counted(solved - found, 'solution')}, {found} found"

    def __repr__(self) -> str:
        elastic = self.case.formulation == "elastic"
        kind = f"{self.case.model}, {self._made}" if elastic else f"none, as contacts are {self.case.formulation}"
        return f"ContactTable({profile_names(self.case)}: {kind}; clearance {self.clearance_words} mm)"

    def _repr_html_(self) -> str:
        """What the table says of the rigid and the resting wheelset, for a notebook."""
        frequencies = f"eigenfrequencies at rest [Hz]: {', '.join(f'{f:.4f}' for f in self.frequencies)}"
        return html_table(f"contact table, {self.case.model}",
                          [tuple(line.split(": ", 1)) for line in (*self.lines(), frequencies)])


def _made_again(case: Case, landmarks: tuple[float, ...]) -> ContactTable:
    """The table that another process had of a case."""
    table = ContactTable(case)
    if not np.allclose(table._landmarks(), landmarks, rtol=1e-9, atol=0):
        raise Error(file=case.label, expected="the profiles that the contact table was made of",
                    found="others under their names")
    return table


def _number(wheel: Wheel) -> int:
    """The number of a wheel in the core."""
    if wheel not in WHEELS:
        raise BadValue(expected="wheel='both', 'left' or 'right'", found=f"{wheel!r}")
    return WHEELS.index(wheel)


def core_files(case: Case, curve: Curve = "run") -> dict[str, str]:
    """Paths of the files that a run reads, or of those of its geometry, by variable, as the core reads them."""
    file = core_file if curve == "run" else geometry_file
    return {name: path if name == "bodies" else file(path, name.partition("_")[0]) for name, path in case.files().items()}


def located(case: Case, curve: Curve = "run") -> bytes:
    """Paths of the case's files, as the core takes them."""
    files = core_files(case, curve)
    paths = [path_bytes(files.get(name, "")) for name in FILES]
    for path in paths:
        if len(path) > TEXT_LENGTH:
            raise Error(file=case.label, expected=f"paths of at most {TEXT_LENGTH} characters",
                        found=os.fsdecode(path))
    return b"".join(path.ljust(TEXT_LENGTH) for path in paths)


def rigid_geometry(case: Case, curve: Curve = "run") -> Handle:
    """The profiles of a case in their places, without a contact table."""
    address, message, length = flat.prepare_rigid_case(*case.arrays(), located(case, curve))
    check(message, length, case.label)
    return Handle(flat.free_prepared, address)


def placed_outlines(case: Case, curve: Curve = "run",
                    ) -> tuple[list[tuple[np.ndarray, np.ndarray]], float, float, tuple[float, float]]:
    """The outlines of a case's profiles in their places: wheel in the frame of the wheelset and rail in that of the track, (n, 2)
    [m] each, Y outward, for the left and the right side; height [m] and roll [rad] of the axle of the rigid wheelset on both rails;
    rigid-axle flange clearance to the left and to the right [m]. Error where a run would refuse the profiles."""
    handle = rigid_geometry(case, curve)
    sizes, (axle, roll) = flat.outline_sizes(handle)
    left, right = ([flat.outline_points(handle, what, side, sizes[what - 1, side - 1]).T for what in (1, 2)] for side in (1, 2))
    clearance_left, clearance_right = (float(flat.rigid_numbers(handle, side)[0][0]) for side in (1, 2))
    return [(left[0], left[1]), (right[0], right[1])], float(axle), float(roll), (clearance_left, clearance_right)


def smoothing_words(case: Case, run: Handle | None = None, frequency: float | None = None) -> str:
    """What the smoothing of waves changes, for a case that has such profiles; '' for others.

    run: the case as it is prepared for a run, with the frequency of its lateral motion [Hz]; None for its profiles alone.
    """
    files, of_points = core_files(case), core_files(case, "geometry")
    changed = {path: files[name] for name, path in case.files().items() if of_points[name] != files[name]}
    if not changed:
        return ""
    before, after = Rigid.of(rigid_geometry(case, "geometry")), Rigid.of(run or rigid_geometry(case))
    unsmoothed = None
    if frequency is not None:
        address, _, length = flat.prepare_case(*case.replace(table_folder="").arrays(), located(case, "geometry"))
        if not length:
            unsmoothed = float(flat.prepared_numbers(Handle(flat.free_prepared, address))[10])
    return change_words(changed, before, after, unsmoothed, frequency)


def profile_names(case: Case) -> str:
    """The names of the profiles of wheel and rail, and of the right side's where the case names them."""
    right = [f"right {name}" for name in (case.wheel_profile_right, case.rail_profile_right) if name]
    return ", ".join([case.wheel_profile, case.rail_profile, *right])
