"""Wheels on rails as they move: bodies, contact points and forces of runs, in one picture with scales."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrow, Polygon

from ..case import Case
from ..constants import CONTACT_NAMES, CONTACTS, DEG, KN, MM, SIDES
from ..geometry.outlines import Outlines, run_outlines, turned
from ..number_text import force_text, number_text
from ..plots.named import shows
from ..plots.stretches import rows_between
from ..plots.style import BLACK, CONTACT_LINES, GREY, Line
from ..results.contact_intervals import is_closed
from ..results.run_data import RunData
from .page import checked

ARROW = 0.045                       # length of the largest force in the close-up of a contact [m]
HALF_WIDTH, BELOW, ABOVE = 0.098, 0.05, 0.064   # of a close-up, from the middle of the rail's top [m]
WHEEL = {"facecolor": "#EEF0F3", "edgecolor": BLACK, "linewidth": 1.0}
RAIL = {"facecolor": "#CFD4DA", "edgecolor": BLACK, "linewidth": 0.8}
LETTERS = 0.22                      # height of the words at a scale with what is free round them [in]
SCALE_GREY = "#404040"


class Actor:
    """A run in the picture."""

    def __init__(self, run: RunData, line: Line, assumed: RunData | Case) -> None:
        self.time, columns = checked(run)
        self.columns = {"time": self.time, **columns}
        self.run, self.line = run, line
        self.outlines = run_outlines(run, assumed)[0]

    def part(self, column: str, start: float, end: float) -> np.ndarray:
        """The rows of a column from `start` to `end` [s], and one more at either side; zeros for what the file lacks."""
        return self.columns.get(column, np.zeros(len(self.time)))[rows_between(self.time, start, end)]

    def at(self, column: str, t: float) -> float:
        """Linear between rows; 0 for what the file lacks."""
        return float(np.interp(t, self.time, self.columns[column])) if column in self.columns else 0.0

    def pose_words(self, t: float) -> str:
        """Displacements at time t [s]; where the run has ended before, when."""
        y, z, roll = (number_text(scale*self.at(column, t), 2) for column, scale in (("Y", MM), ("Z", MM), ("roll", 1e3)))
        found = f"Y {y} mm,  Z {z} mm,  Φ {roll} mrad"
        return f"{found}  (ended at {1e3*self.time[-1]:.1f} ms)" if t > self.time[-1] else found

    def force_words(self, side: str, t: float) -> str:
        """Normal forces and contact angles of the closed contacts of a side, 'left' or 'right', at time t [s]."""
        found = []
        for contact in SIDES[side]:
            force, angle = self.at(f"N_{contact}", t), self.at(f"angle_{contact}", t)
            if np.isfinite(force) and is_closed(force):
                at = f" at {number_text(DEG*angle, 1)}°" if f"angle_{contact}" in self.columns and np.isfinite(angle) else ""
                found.append(f"{CONTACT_NAMES[contact].split()[1]} {force_text(force)}{at}")
        return ",  ".join(found) or "no contact"


class Scene:
    """Wheels and rails of all actors within the limits of some axes; left is left.  side: 1 left, -1 right, 0 both.

    start, end: times of the film [s], whose largest force has the longest arrow.
    """

    def __init__(self, ax: Axes, actors: Sequence[Actor], side: int, start: float, end: float) -> None:
        self.ax, self.side = ax, side
        self.drawn = [(actor, actor.outlines) for actor in actors if actor.outlines]
        self.rails: list[Line] = []             # the look of each rail that is drawn
        self.arrows: dict[tuple[int, str], FancyArrow] = {}
        self.points: dict[tuple[int, str], Line2D] = {}
        self.bodies: list[list[tuple[np.ndarray, Polygon]]] = []
        ax.set_axis_off()
        ax.set_aspect("equal")
        if not self.drawn:
            ax.text(0.5, 0.5, "no outlines", transform=ax.transAxes, ha="center", color=GREY)
            return
        largest = max(np.nanmax(np.abs(actor.part(f"N_{c}", start, end)), initial=0.0) for actor in actors for c in CONTACTS) or 1.0
        self.look_at(start, end)
        self.unit = ARROW*(1 if side else 6)/largest      # length of a force [m/N]
        self.shaft = 0.011*np.ptp(ax.get_xlim())
        self.add_rails()
        for k, (actor, outlines) in enumerate(self.drawn):
            self.add_wheelset(k, actor, outlines)
        self.add_scales(largest)

    def look_at(self, start: float, end: float) -> None:
        """Set the limits: a close-up shows the rail of its side, the whole picture both wheels from `start` to `end` [s]."""
        if self.side:
            first = self.drawn[0][1]
            rail = (first.left if self.side > 0 else first.right).rail
            middle, top = self.side*(rail[:, 0].min() + rail[:, 0].max())/2, rail[:, 1].max()
            self.ax.set(xlim=(middle + HALF_WIDTH, middle - HALF_WIDTH), ylim=(top - BELOW, top + ABOVE))
            return
        ends = []
        for actor, outlines in self.drawn:
            y, z, roll = (actor.part(name, start, end) for name in ("Y", "Z", "roll"))
            # A point is a complex number: its place to the left and its height.
            corners = np.array([complex(s*u, v) for one, s in outlines.sides for u in one.wheel[[0, -1], 0]
                                for v in (one.wheel[:, 1].min(), -one.wheel[:, 1].min())])
            places = corners[:, None]*np.exp(1j*(outlines.roll + roll)) + y + 1j*(z + outlines.axle)
            ends.append([np.nanmax(places.real), -np.nanmin(places.real), np.nanmax(places.imag)])
        left, right, height = np.max(ends, axis=0)
        self.ax.set(xlim=(left + 0.06, -right - 0.06), ylim=(-0.17*height, 1.04*height))

    def add_rails(self) -> None:
        """Draw the rails of the first run filled, and the outlines of those of further runs that differ from all before."""
        drawn: list[list[list[float]]] = []
        for actor, outlines in self.drawn:
            rails = [one.rail*[s, 1] for one, s in outlines.sides]
            if (points := [rail.tolist() for rail in rails]) in drawn:
                continue
            for rail in rails:
                foot = [[rail[-1, 0], -0.2], [rail[0, 0], -0.2]]
                shape, = self.ax.fill(*np.vstack([rail, foot]).T, **(outline_look(actor.line) if drawn else RAIL))
                shows(shape, f"rail {'left' if rail[0, 0] > 0 else 'right'}", how="body", of=actor.run.name)
            drawn.append(points)
            self.rails.append(actor.line)

    def add_wheelset(self, k: int, actor: Actor, outlines: Outlines) -> None:
        """Draw the wheels and the axle of a run with contact points and forces; all of them move."""
        shown = {f"wheel {'left' if s > 0 else 'right'}": np.vstack([one.wheel, one.wheel[::-1]*[1, -1]])*[s, 1]
                 for one, s in outlines.sides if self.side in (0, s)}
        if not self.side:
            a, b = (s*one.wheel[:, 0].min() for one, s in outlines.sides)       # ends of the axle, between the wheels
            shown = {"axle": np.array([[b, -0.08], [a, -0.08], [a, 0.08], [b, 0.08]])} | shown
        looks = outline_look(actor.line) if k else WHEEL
        self.bodies.append([(body, shows(self.ax.fill(*body.T, animated=True, **looks)[0], name, how="body", of=actor.run.name))
                            for name, body in shown.items()])
        for contact in CONTACTS:
            if {"L": 1, "R": -1}[contact[0]] == -self.side or not all(
                    f"{q}_{contact}" in actor.columns for q in ("N", "Fy", "Fz", "y", "z")):
                continue
            color = CONTACT_LINES[contact].color if len(self.drawn) == 1 else actor.line.color
            self.arrows[k, contact] = self.add_arrow(facecolor=color, animated=True)
            self.points[k, contact] = self.ax.plot([0], [0], "o", markersize=4, color=color, markeredgecolor="white",
                                                   markeredgewidth=0.6, animated=True)[0]
            shows(self.arrows[k, contact], f"Fz_{contact}", f"Fy_{contact}", "force", actor.run.name)
            shows(self.points[k, contact], f"z_{contact} [m]", f"y_{contact} [m]", "place", actor.run.name)

    def add_scales(self, largest: float) -> None:
        """Draw a bar of a round length and above it an arrow of a round force, outside the rail or between the wheels."""
        ax, far, start = self.ax, self.side or 1, 0.14
        if self.side:
            ax.set_title("left wheel" if far > 0 else "right wheel", fontsize=9, pad=4)
            start = ax.get_xlim()[0 if far > 0 else 1] - far*0.02*np.ptp(ax.get_xlim())
        low, high = ax.get_ylim()
        tall = ax.get_position().height*ax.figure.get_size_inches()[1]          # [in]
        step = max(0.13 if self.side else 0.11, LETTERS/tall)*(high - low)
        bar, force = low + 0.35*step, low + 1.35*step
        self.scale_force, self.scale_length = round_number(largest), 0.02 if self.side else 0.2
        length = self.unit*self.scale_force
        rule, = ax.plot([start, start - far*self.scale_length], [bar, bar], "|-", color=SCALE_GREY, linewidth=1.0, markersize=6)
        self.scale_arrow = self.add_arrow(facecolor=SCALE_GREY)
        shows(rule, "length", how="scale")
        shows(self.scale_arrow, "force", how="scale")
        self.aim(self.scale_arrow, np.array([start, force]), np.array([-far*length, 0.0]))
        for y, size, words in ((bar, self.scale_length, f"{MM*self.scale_length:g} mm"),
                               (force, length, f"{KN*self.scale_force:g} kN")):
            at, way = (start, "left" if far > 0 else "right") if self.side else (start - size/2, "center")
            ax.text(at, y + 0.25*step, words, ha=way, va="bottom", fontsize=8, color=SCALE_GREY)

    def add_arrow(self, **look: object) -> FancyArrow:
        """Add an arrow, to be set by `aim`."""
        shape = FancyArrow(0.0, 0.0, 1.0, 0.0, length_includes_head=True, linewidth=0, **look)
        self.ax.add_patch(shape)
        return shape

    def aim(self, shape: FancyArrow, tail: np.ndarray, along: np.ndarray) -> None:
        """Set an arrow to a vector `along` that begins at `tail`. An arrow shorter than its head is a smaller head alone."""
        head = 4*self.shaft
        size = min(1.0, float(np.hypot(*along))/head)
        shape.set_data(x=tail[0], y=tail[1], dx=along[0], dy=along[1], width=size*self.shaft, head_width=0.8*size*head,
                       head_length=size*head)

    def move(self, t: float) -> Iterable[Artist]:
        """Set everything to time t [s]; gives what is to be drawn, in order."""
        for (actor, outlines), bodies in zip(self.drawn, self.bodies, strict=True):
            y, z, roll = actor.at("Y", t), outlines.axle + actor.at("Z", t), outlines.roll + actor.at("roll", t)
            for body, polygon in bodies:
                polygon.set_xy(turned(body, y, z, roll))
                yield polygon
        for (k, contact), shape in self.arrows.items():
            actor = self.drawn[k][0]
            point, force = (np.array([actor.at(f"{q}_{contact}", t) for q in names]) for names in (("y", "z"), ("Fy", "Fz")))
            closed = is_closed(actor.at(f"N_{contact}", t)) and np.isfinite([*point, *force]).all() and np.hypot(*force) > 0
            shape.set_visible(bool(closed))
            if closed:
                self.aim(shape, point, self.unit*force)
                self.points[k, contact].set_data(point[:1], point[1:])
                yield shape
                yield self.points[k, contact]


def outline_look(line: Line) -> dict[str, Any]:
    """The look of a body that is not filled, for `Axes.fill`."""
    return {"fill": False, "edgecolor": line.color, "linewidth": 1.2, "linestyle": line.dashes}


def round_number(x: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is at most x."""
    power = 10.0**np.floor(np.log10(x)*(1 + 1e-15))
    return float(max(m*power for m in (1, 2, 5) if m*power <= x*(1 + 1e-12)))
