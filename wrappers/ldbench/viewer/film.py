"""Films of runs for slides: wheels on rails and the motion beside them, frame by frame with matplotlib."""
from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from tqdm import tqdm

from .._core.errors import Error
from .._core.files import check_ending, complete
from .._core.optional import needed
from ..case import Case
from ..plots.style import BLACK, CONTACT_LINES, GREY, SERIES, Line, ldbench_style, plain
from ..profiles.outlines import Outlines, run_outlines, turned
from ..results.quantities import CONTACT_NAMES, CONTACTS, quantity
from ..results.run_data import RunData
from .page import assumed_profiles, checked

INCHES, DPI = (12.8, 7.2), 100
RATES = {".mp4": 30, ".gif": 20}    # frames per second
FILMS = tuple(RATES)
PICTURE = ".png"                    # one moment
SECONDS = 20                        # of a film of which nobody says the speed
FRAMES = 20_000                     # at most
ARROW = 0.045                       # of the largest force, in the pictures of a contact [m]
WHEEL_GREY, RAIL_GREY = "#EEF0F3", "#CFD4DA"

Frame = np.ndarray


def check_film(target: Path) -> None:
    """Check before the work that the film can be written."""
    check_ending(target, "a film .mp4 or .gif, or a picture .png", *RATES, PICTURE)
    if target.suffix.lower() == ".mp4":
        encoder()


def make_film(runs: Sequence[RunData], target: Path, start: float | None = None, end: float | None = None,
              speed: float | None = None, case: Case | None = None) -> int:
    """Write the film of some runs from `start` to `end` [s], `speed` seconds of them per second; its frames.

    A picture is that of the moment `start`.
    """
    check_film(target)
    first, last = min(float(r.time[0]) for r in runs), max(float(r.time[-1]) for r in runs)
    start, end = first if start is None else start, last if end is None else end
    if not first <= start < end <= last:
        raise Error(f"{target}: expected times from {first:g} to {last:g} s in ascending order, "
                    f"found {start:g} to {end:g} s")
    if target.suffix.lower() == PICTURE:
        with ldbench_style(), complete(target) as scratch:
            write_picture(scratch, Picture(runs, first, last, None, case).frame(start))
        return 1
    rate = RATES[target.suffix.lower()]
    speed = speed or (end - start)/SECONDS
    count = int(np.ceil((end - start)/speed*rate)) + 1
    if count > FRAMES:
        raise Error(f"{target}: expected at most {FRAMES} frames, found {count}; a higher --speed or a shorter time "
                    "takes fewer")
    times = np.linspace(start, end, count)
    write = gif_writer if target.suffix.lower() == ".gif" else mp4_writer
    with ldbench_style(), complete(target) as scratch, write(scratch, rate) as add:
        picture = Picture(runs, start, end, speed, case)
        for t in tqdm(times, desc="film", unit="frame", disable=None, leave=False):
            add(picture.frame(float(t)))
    return count


def encoder() -> ModuleType:
    """Find the encoder of H.264."""
    return needed("imageio_ffmpeg", "view", "imageio-ffmpeg")


@contextmanager
def mp4_writer(path: Path, rate: int) -> Iterator[Callable[[Frame], object]]:
    """Open a writer of H.264 that every player accepts."""
    size = tuple(int(DPI*x) for x in INCHES)
    writer = encoder().write_frames(str(path), size, fps=rate, codec="libx264", pix_fmt_out="yuv420p", quality=7,
                                         macro_block_size=2, output_params=["-f", "mp4", "-threads", "1"])
    writer.send(None)
    try:
        yield lambda frame: writer.send(np.ascontiguousarray(frame))
    finally:
        writer.close()


@contextmanager
def gif_writer(path: Path, rate: int) -> Iterator[Callable[[Frame], object]]:
    """Open a writer of a repeating GIF, with the colours of the first frame and of lines and arrows."""
    from PIL import Image

    frames: list[Image.Image] = []
    palettes: list[Image.Image] = []

    def add(frame: Frame) -> None:
        image = Image.fromarray(frame)
        small = image.resize((image.width*5//8, image.height*5//8), Image.Resampling.LANCZOS)
        if not palettes:
            sample = small.copy()
            for k, line in enumerate((*CONTACT_LINES.values(), *SERIES)):
                sample.paste(line.color, (40*k, 0, 40*k + 40, 40))
            palettes.append(sample.quantize(96, dither=Image.Dither.NONE))
        frames.append(small.quantize(dither=Image.Dither.NONE, palette=palettes[0]))

    yield add
    frames[0].save(path, format="GIF", save_all=True, append_images=frames[1:], duration=1000//rate, loop=0)


def write_picture(path: Path, frame: Frame) -> None:
    """Write a frame as a PNG file."""
    from PIL import Image

    Image.fromarray(frame).save(path, format="PNG", optimize=True)


class Picture:
    """A figure whose moving parts are set to a time: wheelset, both contacts, displacement and flange forces."""

    def __init__(self, runs: Sequence[RunData], start: float, end: float, speed: float | None,
                 case: Case | None) -> None:
        assumed = assumed_profiles(runs, case)
        self.actors = [Actor(run, line, assumed) for run, line in zip(runs, SERIES, strict=False)]
        self.largest = max(actor.largest for actor in self.actors)
        self.figure = Figure(figsize=INCHES, dpi=DPI)
        self.canvas = FigureCanvasAgg(self.figure)
        grid = self.figure.add_gridspec(3, 3, width_ratios=(1, 1, 1.15), left=0.025, right=0.985, top=0.9, bottom=0.075,
                                        wspace=0.22, hspace=0.38)
        whole = self.figure.add_subplot(grid[0:2, 0:2])
        details = self.figure.add_subplot(grid[2, 0]), self.figure.add_subplot(grid[2, 1])
        title = ", ".join(actor.run.heading for actor in self.actors)
        self.figure.text(0.025, 0.965, plain(title), fontsize=13, weight="bold", va="top")
        self.clock = self.figure.text(0.985, 0.965, "", fontsize=13, va="top", ha="right", family="DejaVu Sans Mono")
        self.speed = "" if speed is None else f"1:{1/speed:,.0f}" if speed < 0.7 else f"{speed:g}×"
        self.movers: list[Callable[[float], Iterable[tuple[Axes, Artist]]]] = []
        self.draw_scene(whole, 0.0, (1.1, -1.1), (-0.16, 1.02), 6*ARROW)
        self.draw_scene(details[0], 1, (0.85, 0.655), (-0.045, 0.06), ARROW)
        self.draw_scene(details[1], -1, (-0.655, -0.85), (-0.045, 0.06), ARROW)
        self.cursors = [self.draw_chart(self.figure.add_subplot(grid[i, 2]), columns, start, end)
                        for i, columns in enumerate((("Y",), ("N_LF", "N_RF"), ("N_LT", "N_RT")))]
        self.cursors[-1].axes.set_xlabel("time [s]")
        for artist in (self.clock, *self.cursors):
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)   # what does not move is drawn once

    def draw_scene(self, ax: Axes, side: float, across: tuple[float, float], up: tuple[float, float],
                   arrow: float) -> None:
        """Wheels and rails within limits [m]; left is left.  side: 1 left, -1 right, 0 both."""
        ax.set(xlim=across, ylim=up)
        ax.set_aspect("equal")
        ax.set_axis_off()
        outlines = self.actors[0].outlines
        if outlines is None:
            ax.text(0.5, 0.5, "no outlines", transform=ax.transAxes, ha="center", color=GREY)
            return
        for one, s in outlines.sides:
            rail = one.rail
            foot = [[rail[-1, 0], -0.2], [rail[0, 0], -0.2]]
            ax.fill(*(np.vstack([rail, foot])*[s, 1]).T, facecolor=RAIL_GREY, edgecolor=BLACK, linewidth=0.8)
        for actor in reversed(self.actors):
            if actor.outlines:
                self.movers.append(actor.draw(actor.outlines, ax, side, filled=actor is self.actors[0], arrow=arrow/self.largest))

    def draw_chart(self, ax: Axes, columns: Sequence[str], start: float, end: float) -> Line2D:
        """Columns over the time of the film; returns the cursor."""
        several = len(self.actors) > 1
        for actor in self.actors:
            for k, column in enumerate(c for c in columns if c in actor.columns):
                known = quantity(column)
                contact = column.rpartition("_")[2]
                line = actor.line if several else CONTACT_LINES.get(contact, SERIES[k])
                t = actor.time
                rows = slice(max(np.searchsorted(t, start) - 1, 0), np.searchsorted(t, end, "right") + 1)
                words = f"{known.words}, {actor.run.name}" if several else known.words
                ax.plot(t[rows], known.scale*actor.columns[column][rows], label=plain(words),
                        **line.kwargs() | ({"linestyle": ":"} if several and k else {}))
        shown = [quantity(c) for c in columns if any(c in actor.columns for actor in self.actors)]
        ax.set_xlim(start, end)
        if shown:
            ax.set_ylabel(plain(f"[{shown[0].unit}]"))
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1, fontsize=7)
        else:
            ax.set_axis_off()
        return ax.axvline(start, color=SERIES[1].color, linewidth=1.2)

    def frame(self, t: float) -> Frame:
        """The picture at time t [s], (height, width, 3) bytes."""
        self.canvas.restore_region(self.still)
        for move in self.movers:
            for ax, artist in move(t):
                ax.draw_artist(artist)
        for cursor in self.cursors:
            cursor.set_xdata([t, t])
            cursor.axes.draw_artist(cursor)
        self.clock.set_text(f"{1e3*t:10.3f} ms   {self.speed}".rstrip())
        self.figure.draw_artist(self.clock)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()


class Actor:
    """A run in the picture."""

    def __init__(self, run: RunData, line: Line, assumed: RunData | Case) -> None:
        self.time, self.columns = checked(run)
        self.run, self.line = run, line
        self.outlines: Outlines | None = run_outlines(run, assumed)[0]
        forces = [np.nanmax(self.columns[f"N_{c}"], initial=0.0) for c in CONTACTS if f"N_{c}" in self.columns]
        self.largest = max([*forces, 1.0])

    def at(self, column: str, t: float) -> float:
        """Linear between rows; 0 for what the file lacks."""
        return float(np.interp(t, self.time, self.columns[column])) if column in self.columns else 0.0

    def draw(self, outlines: Outlines, ax: Axes, side: float, filled: bool,
             arrow: float) -> Callable[[float], Iterable[tuple[Axes, Artist]]]:
        """The wheelset in `ax`; the function moves it and gives what is to draw.  arrow: length of a force [m/N]."""
        left, right = (np.vstack([side.wheel, side.wheel[::-1]*[1, -1]]) for side in (outlines.left, outlines.right))
        ends = [-right[:, 0].min(), left[:, 0].min()]       # of the axle, between the wheels
        bodies = [np.array([[ends[k], z] for k, z in ((0, -0.08), (1, -0.08), (1, 0.08), (0, 0.08))]), left, right*[-1, 1]]
        looks = ({"facecolor": WHEEL_GREY, "edgecolor": BLACK, "linewidth": 1.0} if filled else
                 {"fill": False, "edgecolor": self.line.color, "linewidth": 1.2, "linestyle": self.line.dashes})
        polygons = [ax.fill(*body.T, **looks)[0] for body in bodies]
        contacts = [c for c in CONTACTS if (side >= 0 or c[0] == "R") and (side <= 0 or c[0] == "L")
                    and all(f"{q}_{c}" in self.columns for q in ("N", "Fy", "Fz", "y", "z"))]
        arrows = {c: ax.annotate("", (0, 0), (0, 0), arrowprops={
            "arrowstyle": "-|>", "linewidth": 2, "shrinkA": 0, "shrinkB": 0,
            "color": CONTACT_LINES[c].color if filled else self.line.color}) for c in contacts}
        height = -0.04 if side else 0.8         # below a contact, between the wheels
        words = ax.text(0.5, height, "", transform=ax.transAxes, va="top", ha="center", fontsize=9) if filled else None

        moving = [*polygons, *arrows.values(), *([words] if words else [])]
        for artist in moving:
            artist.set_animated(True)

        def move(t: float) -> Iterable[tuple[Axes, Artist]]:
            y, z, roll = self.at("Y", t), outlines.axle + self.at("Z", t), self.at("roll", t)
            for polygon, body in zip(polygons, bodies, strict=True):
                polygon.set_xy(turned(body, y, z, outlines.roll + roll))
            text = [] if side else [f"Y {1e3*y:.2f} mm, Z {1e3*self.at('Z', t):.2f} mm, Φ {1e3*roll:.2f} mrad"]
            for contact, drawn in arrows.items():
                point = np.array([self.at(f"y_{contact}", t), self.at(f"z_{contact}", t)])
                force = np.array([self.at(f"Fy_{contact}", t), self.at(f"Fz_{contact}", t)])
                closed = self.at(f"N_{contact}", t) > 0 and np.isfinite(point).all()
                drawn.set_visible(bool(closed))
                if closed:
                    drawn.set_position(point)
                    drawn.xy = tuple(point + arrow*force)
                    text.append(f"{CONTACT_NAMES[contact]} {1e-3*np.hypot(*force):.0f} kN")
            if words:
                words.set_text("\n".join(text))
            return [(ax, artist) for artist in moving]

        return move
