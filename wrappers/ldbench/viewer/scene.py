"""Wheels on rails as they move: bodies, contact points and forces of runs, in one picture with scales."""
from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon

from ..case import Case
from ..geometry.outlines import Outlines, run_outlines, turned
from ..plots.stretches import rows_between
from ..plots.style import BLACK, CONTACT_LINES, GREY, Line
from ..results.contact_intervals import is_closed
from ..results.derived import SIDES
from ..results.quantities import CONTACT_NAMES, CONTACTS, DEG, KN, MM
from ..results.run_data import RunData
from .page import checked

ARROW = 0.045                       # length of the largest force in the close-up of a contact [m]
HALF_WIDTH, BELOW, ABOVE = 0.098, 0.05, 0.064   # of a close-up, from the middle of the rail's top [m]
WHEEL_GREY, RAIL_GREY = "#EEF0F3", "#CFD4DA"


class Actor:
    """A run in the picture."""

    def __init__(self, run: RunData, line: Line, assumed: RunData | Case) -> None:
        self.time, self.columns = checked(run)
        self.run, self.line = run, line
        self.outlines: Outlines | None = run_outlines(run, assumed)[0]

    def rows(self, start: float, end: float) -> slice:
        """The rows from `start` to `end` [s], and one more at either side."""
        return rows_between(self.time, start, end)

    def largest(self, start: float, end: float) -> float:
        """The largest normal force from `start` to `end`, pushing or pulling [N]."""
        forces = [np.abs(self.columns[f"N_{c}"][self.rows(start, end)]) for c in CONTACTS if f"N_{c}" in self.columns]
        return float(max((np.nanmax(force, initial=0.0) for force in forces), default=0.0))

    def reach(self, start: float, end: float) -> tuple[float, float, float]:
        """How far the wheels come out to either side, and up, from `start` to `end` [m]."""
        assert self.outlines
        rows = self.rows(start, end)
        y, z, roll = (self.columns[name][rows] if name in self.columns else np.zeros(len(self.time[rows]))
                      for name in ("Y", "Z", "roll"))
        wide, high = [], []
        for one, s in self.outlines.sides:
            radius = -one.wheel[:, 1].min()
            for across, up in itertools.product(s*one.wheel[[0, -1], 0], (-radius, radius)):
                c, sine = np.cos(self.outlines.roll + roll), np.sin(self.outlines.roll + roll)
                wide.append(across*c - up*sine + y)
                high.append(across*sine + up*c + z + self.outlines.axle)
        return float(np.nanmax(wide)), float(-np.nanmin(wide)), float(np.nanmax(high))

    def at(self, column: str, t: float) -> float:
        """Linear between rows; 0 for what the file lacks."""
        return float(np.interp(t, self.time, self.columns[column])) if column in self.columns else 0.0

    def pose_words(self, t: float) -> str:
        """Displacements at time t [s]; where the run has ended before, when."""
        found = f"Y {MM*self.at('Y', t):.2f} mm,  Z {MM*self.at('Z', t):.2f} mm,  Φ {1e3*self.at('roll', t):.2f} mrad"
        found = found.replace("-", "−")
        return f"{found}  (ended at {1e3*self.time[-1]:.1f} ms)" if t > self.time[-1] else found

    def force_words(self, side: str, t: float) -> str:
        """Normal forces and contact angles of the closed contacts of a side, 'left' or 'right', at time t [s]."""
        found = []
        for contact in SIDES[side]:
            force, angle = self.at(f"N_{contact}", t), self.at(f"angle_{contact}", t)
            if np.isfinite(force) and is_closed(force):
                digits = 0 if abs(force) >= 1e5 else 1
                at = f" at {DEG*angle:.1f}°" if f"angle_{contact}" in self.columns and np.isfinite(angle) else ""
                found.append(f"{CONTACT_NAMES[contact].split()[1]} {KN*force:.{digits}f} kN{at}")
        return ",  ".join(found).replace("-", "−") or "no contact"


class Scene:
    """Wheels and rails of all actors within the limits of some axes; left is left.  side: 1 left, -1 right, 0 both.

    start, end: times of the film [s], whose largest force has the longest arrow.
    """

    def __init__(self, ax: Axes, actors: Sequence[Actor], side: int, start: float, end: float) -> None:
        self.ax, self.side, self.actors = ax, side, [actor for actor in actors if actor.outlines]
        self.rails: list[Line] = []             # the look of each rail that is drawn
        self.arrows: dict[tuple[int, str], Polygon] = {}
        self.points: dict[tuple[int, str], Line2D] = {}
        self.bodies: list[list[tuple[np.ndarray, Polygon]]] = []
        ax.set_axis_off()
        ax.set_aspect("equal")
        if not self.actors:
            ax.text(0.5, 0.5, "no outlines", transform=ax.transAxes, ha="center", color=GREY)
            return
        largest = max(actor.largest(start, end) for actor in actors) or 1.0
        self.look_at(start, end)
        self.unit = ARROW*(1 if side else 6)/largest      # length of a force [m/N]
        self.shaft = abs(ax.get_xlim()[1] - ax.get_xlim()[0])*0.011
        for actor in self.actors:
            self.add_rail(actor)
        for k, actor in enumerate(self.actors):
            self.add_wheelset(k, actor)
        self.add_scales(largest)

    def look_at(self, start: float, end: float) -> None:
        """Set the limits: a close-up shows the rail of its side, the whole picture both wheels from `start` to `end` [s]."""
        outlines = self.actors[0].outlines
        assert outlines
        if self.side:
            rail = (outlines.left if self.side > 0 else outlines.right).rail
            middle = self.side*(rail[:, 0].min() + rail[:, 0].max())/2
            top = rail[:, 1].max()
            self.ax.set(xlim=(middle + HALF_WIDTH, middle - HALF_WIDTH), ylim=(top - BELOW, top + ABOVE))
            return
        left, right, height = (max(ends) for ends in zip(*(actor.reach(start, end) for actor in self.actors), strict=True))
        self.ax.set(xlim=(left + 0.06, -right - 0.06), ylim=(-0.17*height, 1.04*height))

    def add_rail(self, actor: Actor) -> None:
        """Draw the rails of a run, unless they are drawn already; the first ones are filled."""
        assert actor.outlines
        earlier = [a.outlines for a in self.actors[:self.actors.index(actor)] if a.outlines]
        if any(all(np.array_equal(one.rail, other.rail) for (one, _), (other, _) in
                   zip(actor.outlines.sides, o.sides, strict=True)) for o in earlier):
            return
        self.rails.append(actor.line)
        looks = {"facecolor": RAIL_GREY, "edgecolor": BLACK, "linewidth": 0.8} if not earlier else outline_look(actor.line)
        for one, s in actor.outlines.sides:
            foot = [[one.rail[-1, 0], -0.2], [one.rail[0, 0], -0.2]]
            self.ax.fill(*(np.vstack([one.rail, foot])*[s, 1]).T, **looks)

    def add_wheelset(self, k: int, actor: Actor) -> None:
        """Draw the wheels and the axle of a run with contact points and forces; all of them move."""
        assert actor.outlines
        left, right = (np.vstack([one.wheel, one.wheel[::-1]*[1, -1]]) for one, _ in actor.outlines.sides)
        ends = -right[:, 0].min(), left[:, 0].min()         # of the axle, between the wheels
        axle = np.array([[ends[j], z] for j, z in ((0, -0.08), (1, -0.08), (1, 0.08), (0, 0.08))])
        shown = {1: [left], -1: [right*[-1, 1]], 0: [axle, left, right*[-1, 1]]}[self.side]
        looks = {"facecolor": WHEEL_GREY, "edgecolor": BLACK, "linewidth": 1.0} if k == 0 else outline_look(actor.line)
        self.bodies.append([(body, self.ax.fill(*body.T, animated=True, **looks)[0]) for body in shown])
        for contact in CONTACTS:
            if {"L": 1, "R": -1}[contact[0]] == -self.side or not all(
                    f"{q}_{contact}" in actor.columns for q in ("N", "Fy", "Fz", "y", "z")):
                continue
            color = CONTACT_LINES[contact].color if len(self.actors) == 1 else actor.line.color
            self.arrows[k, contact] = Polygon(np.zeros((7, 2)), facecolor=color, linewidth=0, animated=True)
            self.ax.add_patch(self.arrows[k, contact])
            self.points[k, contact] = self.ax.plot([0], [0], "o", markersize=4, color=color, markeredgecolor="white",
                                                   markeredgewidth=0.6, animated=True)[0]

    def add_scales(self, largest: float) -> None:
        """Draw an arrow of a round force and a bar of a round length, outside the rail or between the wheels."""
        ax, far = self.ax, self.side or 1
        if self.side:
            ax.set_title("left wheel" if far > 0 else "right wheel", fontsize=9, pad=4)
        low, high = ax.get_ylim()
        step = (0.13 if self.side else 0.11)*(high - low)
        self.scale_force, self.scale_length = round_number(largest), 0.02 if self.side else 0.2
        outer = ax.get_xlim()[0 if far > 0 else 1]
        start = outer - far*0.02*abs(np.diff(ax.get_xlim())[0]) if self.side else 0.14
        for k, (length, words) in enumerate((
                (self.scale_length, f"{MM*self.scale_length:g} mm"), (self.unit*self.scale_force, f"{KN*self.scale_force:g} kN"))):
            y, end = low + (0.35 + k)*step, start - far*length
            if k:
                self.scale_arrow = Polygon(arrow(np.array([start, y]), np.array([end - start, 0.0]), self.shaft, 4*self.shaft),
                                           facecolor="#404040", linewidth=0)
                ax.add_patch(self.scale_arrow)
            else:
                ax.plot([start, end], [y, y], "|-", color="#404040", linewidth=1.0, markersize=6)
            ax.text((start + end)/2, y + 0.25*step, words, ha="center", va="bottom", fontsize=8, color="#404040")

    def move(self, t: float) -> Iterable[Artist]:
        """Set everything to time t [s]; gives what is to be drawn, in order."""
        for actor, bodies in zip(self.actors, self.bodies, strict=True):
            assert actor.outlines
            y, z, roll = actor.at("Y", t), actor.outlines.axle + actor.at("Z", t), actor.outlines.roll + actor.at("roll", t)
            for body, polygon in bodies:
                polygon.set_xy(turned(body, y, z, roll))
                yield polygon
        for (k, contact), shape in self.arrows.items():
            actor = self.actors[k]
            point, force = (np.array([actor.at(f"{q}_{contact}", t) for q in names]) for names in (("y", "z"), ("Fy", "Fz")))
            closed = is_closed(actor.at(f"N_{contact}", t)) and np.isfinite([*point, *force]).all() and np.hypot(*force) > 0
            shape.set_visible(bool(closed))
            if closed:
                shape.set_xy(arrow(point, self.unit*force, self.shaft, 4*self.shaft))
                self.points[k, contact].set_data(point[:1], point[1:])
                yield shape
                yield self.points[k, contact]


def outline_look(line: Line) -> dict[str, object]:
    """The look of a body that is not filled, for `Axes.fill`."""
    return {"fill": False, "edgecolor": line.color, "linewidth": 1.2, "linestyle": line.dashes}


def arrow(tail: np.ndarray, along: np.ndarray, width: float, head: float) -> np.ndarray:
    """The corners of an arrow from `tail` on, (7, 2), the tip in their middle: as long as the vector `along`.

    width: of the shaft; head: length of the head. An arrow that is shorter than its head is a smaller head alone.
    """
    length = float(np.hypot(*along))
    ahead = along/length
    aside = np.array([-ahead[1], ahead[0]])
    point = min(head, length)                       # length of the head that is drawn
    half = width/2*min(1.0, length/head)
    neck = tail + (length - point)*ahead
    return np.array([tail + half*aside, neck + half*aside, neck + 0.4*point*aside, tail + along, neck - 0.4*point*aside,
                     neck - half*aside, tail - half*aside])


def round_number(x: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most x."""
    power = 10.0**np.floor(np.log10(x)*(1 + 1e-15))
    return float(max(m*power for m in (1, 2, 5) if m*power <= x*(1 + 1e-12)))
