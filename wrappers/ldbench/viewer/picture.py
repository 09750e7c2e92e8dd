"""The picture of runs at a moment: wheelset, both contacts and charts, of which frames of a film are made."""
from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.lines import Line2D
from PIL import Image, ImageDraw, ImageFont

from .._core.errors import Error
from ..case import Case
from ..plots.style import CONTACT_LINES, GREY, SERIES, plain
from ..results.quantities import quantity
from ..results.run_data import RunData
from .page import assumed_profiles
from .scene import Actor, Scene

INCHES, DPI = (12.8, 7.2), 100
LEFT, RIGHT, WIDTH = 0.02, 0.325, 0.295      # left ends of the close-ups, and their width
CHARTS = 0.675, 0.31            # left, width

Frame = np.ndarray


class Picture:
    """A figure whose moving parts are set to a time: wheelset, both contacts, displacement and forces."""

    def __init__(self, runs: Sequence[RunData], start: float, end: float, speed: float | None,
                 case: Case | None) -> None:
        check_number(runs)
        assumed = assumed_profiles(runs, case)
        self.actors = [Actor(run, line, assumed) for run, line in zip(runs, SERIES, strict=False)]
        self.several = len(self.actors) > 1
        self.start, self.end = start, end
        self.figure = Figure(figsize=INCHES, dpi=DPI)
        self.canvas = FigureCanvasAgg(self.figure)
        self.speed = "" if speed is None else f"1:{1/speed:,.0f}" if speed < 0.7 else f"{speed:g}×"
        self.draw_title()
        n = len(self.actors)
        self.pitch = 0.028 if n < 5 else 0.02       # of lines of values
        self.header = 0.06 if n < 3 else 0.025*np.ceil(n/3) + 0.02
        above, height = n*self.pitch + 0.025, 0.3 if n < 5 else 0.26
        whole = above + height + 0.04
        places = ((LEFT, whole, RIGHT + WIDTH - LEFT, 0.99 - self.header - n*self.pitch - whole), (LEFT, above, WIDTH, height),
                  (RIGHT, above, WIDTH, height))
        self.scenes = [Scene(self.figure.add_axes(place), self.actors, side, start, end)
                       for place, side in zip(places, (0, 1, -1), strict=True)]
        self.clock_font = font("DejaVu Sans Mono", 13)
        self.value_font = font("DejaVu Sans", 9 if n == 1 else 8 if n < 5 else 7)
        self.charts: dict[str, Axes] = {}
        self.cursors = self.draw_charts()
        for cursor in self.cursors:
            cursor.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)   # what does not move is drawn once

    def draw_title(self) -> None:
        """Write the heading of one run, or name and look of each of several."""
        if not self.several:
            self.figure.text(0.02, 0.975, plain(self.actors[0].run.heading), fontsize=13, weight="bold", va="top")
            return
        few = len(self.actors) < 3
        samples = [Line2D([], [], **actor.line.kwargs()) for actor in self.actors]
        labels = [plain(label(actor.run)) for actor in self.actors]
        self.figure.legend(samples, labels, loc="upper left", bbox_to_anchor=(0.012, 0.99), ncols=2 if few else 3,
                           fontsize=11 if few else 8, handlelength=2.6, borderaxespad=0.0)

    def draw_charts(self) -> list[Line2D]:
        """Displacement and normal forces over the time of the film; returns the cursors.

        One run has a panel for the flanges and one for the treads, several runs have a panel for each contact that closes.
        """
        panels: list[tuple[str, ...]] = ([("Y",), ("N_LF",), ("N_RF",), ("N_LT",), ("N_RT",)] if self.several else
                  [("Y",), ("N_LF", "N_RF"), ("N_LT", "N_RT")])
        panels = [columns for columns in panels if any(np.any(actor.columns[c][actor.rows(self.start, self.end)])
                                                       for c in columns for actor in self.actors if c in actor.columns)]
        count, gap = max(len(panels), 3), 0.05 if self.several else 0.065
        height = (0.9 - 0.075 + gap)/count - gap
        cursors = []
        for k, columns in enumerate(panels):
            ax = self.figure.add_axes((CHARTS[0], 0.9 - height - k*(height + gap), CHARTS[1], height))
            cursors.append(self.draw_chart(ax, columns))
            if k < len(panels) - 1:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel("time [ms]" if self.milliseconds else "time [s]")
        return cursors

    @property
    def milliseconds(self) -> bool:
        """Whether the charts have times in milliseconds."""
        return self.end - self.start < 1

    def draw_chart(self, ax: Axes, columns: Sequence[str]) -> Line2D:
        """Draw columns of all runs over the time of the film; returns the cursor."""
        scale = 1e3 if self.milliseconds else 1.0
        for actor in self.actors:
            for column in (c for c in columns if c in actor.columns):
                known = quantity(column)
                line = actor.line if self.several else CONTACT_LINES.get(column.rpartition("_")[2], SERIES[0])
                rows = actor.rows(self.start, self.end)
                ax.plot(scale*actor.time[rows], known.scale*actor.columns[column][rows], label=plain(known.words), **line.kwargs())
        shown = [quantity(c) for c in columns if any(c in actor.columns for actor in self.actors)]
        ax.set_xlim(scale*self.start, scale*self.end)
        if len(columns) > 1:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1, fontsize=8)
            ax.set_ylabel(plain(f"[{shown[0].unit}]"))
        else:
            ax.set_title(plain(shown[0].label), loc="left", fontsize=8, pad=2)
        self.charts |= dict.fromkeys(columns, ax)
        return ax.axvline(scale*self.start, color=GREY, linewidth=1.0)

    def frame(self, t: float) -> Frame:
        """The picture at time t [s], (height, width, 3) bytes."""
        self.canvas.restore_region(self.still)
        for scene in self.scenes:
            for artist in scene.move(t):
                scene.ax.draw_artist(artist)
        for cursor in self.cursors:
            cursor.set_xdata([1e3*t if self.milliseconds else t]*2)
            cursor.axes.draw_artist(cursor)
        size = self.canvas.get_width_height()
        image = Image.frombuffer("RGBA", size, self.canvas.buffer_rgba(), "raw", "RGBA", 0, 1).convert("RGB")
        draw = ImageDraw.Draw(image)
        for (x, y), words, own, anchor in self.words(t):
            draw.text((x*image.width, (1 - y)*image.height), words, fill="black", font=own, anchor=anchor)
        return np.array(image)

    def words(self, t: float) -> Iterator[tuple[tuple[float, float], str, ImageFont.FreeTypeFont, str]]:
        """All texts that change: place in the figure, words, font and anchor.

        They are drawn with Pillow, in a tenth of the time that matplotlib takes.
        """
        yield (0.985, 0.975), f"{1e3*t:10.3f} ms   {self.speed}".rstrip(), self.clock_font, "ra"
        for k, actor in enumerate(self.actors):
            name = f"{clipped(actor.run.name, 20)}:  " if self.several else ""
            middle = (LEFT + RIGHT + WIDTH)/2
            yield (middle, 1 - self.header - k*self.pitch), name + actor.pose_words(t), self.value_font, "ma"
            for side, left in ("left", LEFT), ("right", RIGHT):
                place = left + WIDTH/2, (len(self.actors) - k)*self.pitch + 0.015
                yield place, name + actor.force_words(side, t), self.value_font, "ma"


def clipped(words: str, length: int) -> str:
    """Words of at most so many characters."""
    return words if len(words) <= length else words[:length - 1] + "…"


def label(run: RunData) -> str:
    """Name and heading of a run, for a legend."""
    return clipped(run.name if run.heading == run.name else f"{run.name}: {run.heading}", 42)


def font(family: str, points: float) -> ImageFont.FreeTypeFont:
    """A font that comes with matplotlib, of a size in points."""
    return ImageFont.truetype(findfont(FontProperties(family=family)), points*DPI/72)


def check_number(runs: Sequence[RunData]) -> None:
    """Raise Error where there are more runs than looks."""
    if len(runs) > len(SERIES):
        raise Error(f"{runs[len(SERIES)].file}: expected at most {len(SERIES)} runs, found {len(runs)}; a page holds more")
