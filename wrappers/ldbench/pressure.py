"""Pressed patches of wheels and rails in one pose, by the model 'halfspace'."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ._core import flat
from ._core.calls import Handle
from ._core.errors import BadValue, Error
from .case import Case
from .constants import CONTACTS, SIDES

CLOSE = 241                             # points of the close grid on which a patch is drawn, in each direction
SHARE = 0.02                            # of a patch's load that the other part of the wheel has at least where both share the patch
ELEMENTS = 48                           # over the length of a patch along the profile, wherever pressures are shown


@dataclass(frozen=True)
class Ellipse:
    """The ellipse of Hertz's theory with a patch's integral of the pressure and the curvatures where the approach of the
    undeformed bodies is largest."""

    half_x: float       # semi-axis in rolling direction [m]
    half_s: float       # semi-axis along the profile [m]
    largest: float      # pressure [Pa]

    @property
    def area(self) -> float:
        """Area [m²]."""
        return float(np.pi*self.half_x*self.half_s)


@dataclass(frozen=True)
class Patch:
    """A pressed patch on the surface developed into the plane (x rolling direction, s along the wheel's profile, from the
    first point of the profile on the flange's back, towards the field side)."""

    contact: str                    # 'LT', 'LF', 'RT' or 'RF'
    x: np.ndarray                   # centres of elements (n_x,) [m], 0 at the axle
    s: np.ndarray                   # centres of elements (n_s,) [m]
    p: np.ndarray                   # pressure on the elements (n_x, n_s) [Pa]
    width: np.ndarray               # half of the pressed length in rolling direction at s (n_s,) [m]
    wheel: np.ndarray               # the wheel's points at s, from the axle centre, in the frame of the wheelset (n_s, 2) [m]
    track: np.ndarray               # the wheel's points at s in the frame of the track (n_s, 2) [m]
    half_x: float                   # half of the length of the patch in rolling direction [m]
    s_ends: tuple[float, float]     # ends of the patch along the profile [m]
    approach: float                 # largest interpenetration of the undeformed surfaces along their normal, Hertz's delta [m]
    s_deepest: float                # where that is [m]
    force: float                    # normal force of the contact, of all its patches, as in the columns [N]
    angle: float                    # contact angle of this force, positive on flanges of both sides, as in the columns [rad]
    integral: float                 # of the pressure over the patch [N]; above the force, as the normals turn over a patch
    largest: float                  # largest pressure [Pa]
    area: float                     # under pressure [m²]
    energy: float                   # elastic energy of all patches of the wheel [J]
    hertz: Ellipse | None           # None where the bodies conform
    also: str = ""                  # the wheel's other contact, where tread and flange share this patch

    @property
    def contacts(self) -> tuple[str, ...]:
        """The contacts whose patch this is: one, or tread and flange of a wheel."""
        return (self.contact, self.also) if self.also else (self.contact,)

    @property
    def half_s(self) -> float:
        """Half of the length of the patch along the profile [m]."""
        return (self.s_ends[1] - self.s_ends[0])/2

    @cached_property
    def s_centre(self) -> float:
        """Mean of s, weighted by the pressure [m]."""
        return float((self.p.sum(axis=0)*self.s).sum()/self.p.sum())

    @cached_property
    def centre(self) -> tuple[float, float]:
        """The centre of pressure on the wheel's profile in the frame of the track, y and z [m]."""
        return self._at(self.track, self.s_centre)

    @cached_property
    def centre_wheel(self) -> tuple[float, float]:
        """The centre of pressure on the wheel's profile, from the axle centre, in the frame of the wheelset, y and z [m]."""
        return self._at(self.wheel, self.s_centre)

    def _at(self, points: np.ndarray, s: float) -> tuple[float, float]:
        y, z = (float(np.interp(s, self.s, column)) for column in points.T)
        return y, z

    @property
    def mean(self) -> float:
        """Mean pressure [Pa]."""
        return self.integral/self.area

    @cached_property
    def sections(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The patch on a close grid: x (n,), s (m,) and pressure (n, m), NaN beside the patch. The square of a pressure is nearly a
        parabola up to the edge of a patch, also beside it in Hertz's theory, so squares are interpolated up to the edges."""
        x, s = np.linspace(-self.half_x, self.half_x, CLOSE), np.linspace(*self.s_ends, CLOSE)
        edge = np.minimum(self.width, self.half_x)
        rows = np.zeros((CLOSE, len(self.s)))
        for j, end in enumerate(edge):
            inside = np.abs(self.x) < end
            rows[:, j] = np.interp(x, [-end, *self.x[inside], end], [0, *self.p[inside, j]**2, 0], 0, 0)
        beside = np.concatenate([[self.s_ends[0]], self.s, [self.s_ends[1]]])
        order = np.argsort(beside, kind="stable")
        p = np.array([np.interp(s, beside[order], np.concatenate([[0], row, [0]])[order]) for row in rows])
        within = np.abs(x)[:, None] <= np.interp(s, self.s, edge)
        return x, s, np.where(within, np.sqrt(p), np.nan)

    @cached_property
    def resultant(self) -> tuple[float, float]:
        """Sum of the pressure along the normals of the elements, y and z in the frame of the track [N]."""
        along = np.gradient(self.track, self.s, axis=0)
        share = self.p.sum(axis=0)*(self.integral/self.p.sum())/np.hypot(*along.T)
        y, z = float(-share @ along[:, 1]), float(share @ along[:, 0])
        return (y, z) if z > 0 else (-y, -z)

    def facts(self) -> dict[str, object]:
        """The numbers, SI units."""
        names = ("contact", "also", "force", "integral", "energy", "largest", "mean", "area", "half_x", "half_s", "approach",
                 "angle", "centre", "centre_wheel", "s_centre", "s_ends")
        hertz = self.hertz and {name: getattr(self.hertz, name) for name in ("half_x", "half_s", "area", "largest")}
        return {name: getattr(self, name) for name in names} | {"hertz": hertz}


def shared(patches: Sequence[Patch], closed: Sequence[str], steep: float) -> list[Patch]:
    """The patches, of which those are tread and flange at once that press on both parts of a wheel while the columns have both
    contacts closed and only one has a patch. steep: contact angle from which the wheel is a flange [rad]."""
    own = {patch.contact for patch in patches}

    def other(patch: Patch) -> str:
        name = patch.contact[0] + ("T" if patch.contact[1] == "F" else "F")
        y, z = np.abs(np.gradient(patch.track, axis=0)).T
        load = patch.p.sum(axis=0)
        part = (np.arctan2(z, y) >= steep) == (name[1] == "F")
        return name if name in closed and name not in own and load[part].sum() > SHARE*load.sum() else ""

    return [replace(patch, also=other(patch)) for patch in patches]


def load(contact: str, y: float, z: float) -> tuple[float, float]:
    """Normal force [N] and contact angle [rad] of the force of a contact, as the columns have them."""
    return float(np.hypot(y, z)), float(np.arctan2(-y if contact[0] == "L" else y, z))


def check_model(case: Case) -> None:
    """Error where a case has no pressures."""
    for name, value, wanted in (("formulation", case.formulation, "elastic"), ("model", case.model, "halfspace")):
        if value != wanted:
            raise Error(file=case.label, group="contact", variable=name, expected=f"'{wanted}', which has pressures",
                        found=f"'{value}'")


def press(handle: Handle, case: Case, pose: Sequence[float], contacts: Sequence[str] = CONTACTS,
          elements: int = ELEMENTS, loads: Mapping[str, tuple[float, float]] | None = None) -> list[Patch]:
    """The patches of some contacts in a pose: axle centre y, z [m], roll angle [rad], track frame.

    loads: normal force [N] and contact angle [rad] of the contacts, as the columns have them; by default those of the pressures.
    `handle` holds the geometry of `case`. A patch has `elements` over its length along the profile and half as many in rolling
    direction. A wheel is pressed as a whole. A patch is the flange's if most of its load acts on points of
    the wheel that are as steep as `&contact flange_angle`, or on the flange's tip.
    """
    check_model(case)
    if elements < 8 or elements % 4:
        raise BadValue(expected="a multiple of 4 elements, at least 8", found=elements)
    found = []
    for side, names in SIDES.items():
        if any(name in contacts for name in names):
            found += [patch for patch in _press_wheel(handle, case, pose, side, names, elements) if patch.contact in contacts]
    if loads is None:
        sums = {name: np.sum([patch.resultant for patch in found if patch.contact == name], axis=0) for name in contacts}
        loads = {name: load(name, *force) for name, force in sums.items() if np.any(force)}
    return [replace(patch, force=loads[patch.contact][0], angle=loads[patch.contact][1]) for patch in found]


def _press_wheel(handle: Handle, case: Case, pose: Sequence[float], side: str, names: Sequence[str],
                 elements: int) -> list[Patch]:
    """The patches of a wheel; `names` of its tread and flange."""
    y, z, roll = (float(number) for number in pose)
    turn = np.array([[np.cos(roll), np.sin(roll)], [-np.sin(roll), np.cos(roll)]])
    sign = 1 if side == "left" else -1
    n, ok, p, point, width, facts, total = flat.pressures(handle, 1 if side == "left" else 2, np.array([y, z, roll]), elements//4,
                                                           elements)
    if not ok:
        raise Error(file=case.label, expected=f"pressures in the pose y = {y} m, z = {z} m, roll = {roll} rad",
                    found="a half-space solution that does not converge")
    found = []
    for k in range(n):
        flange, dx, ds, low, half_x, *ends, approach, deepest, integral, largest, _, area = facts[:13, k].tolist()
        ellipse = Ellipse(*facts[13:, k].tolist())
        half = (np.arange(elements//4) + 0.5)*dx
        wheel = point[:, :, k].T*[sign, 1]
        found.append(Patch(
            names[int(flange)], np.concatenate([-half[::-1], half]), low + (np.arange(elements) + 0.5)*ds,
            np.concatenate([p[::-1, :, k], p[:, :, k]]), width[:, k], wheel, wheel @ turn + [y, z], half_x, (ends[0], ends[1]),
            approach, deepest, np.nan, np.nan, integral, largest, area, float(total[3]), ellipse if ellipse.largest > 0 else None))
    return found
