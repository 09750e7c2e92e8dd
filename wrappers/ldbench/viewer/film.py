"""Films and pictures of runs for slides: wheelset, both contacts and charts, frame by frame with matplotlib."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from types import ModuleType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.lines import Line2D
from PIL import Image, ImageDraw, ImageFont
from tqdm import tqdm

from .._core.errors import Error
from .._core.files import check_ending, complete
from .._core.optional import needed
from ..case import Case
from ..plots.sheets import save_pages, svg
from ..plots.style import CONTACT_LINES, GREY, SERIES, ldbench_style, plain
from ..results.quantities import quantity
from ..results.run_data import RunData
from .page import assumed_profiles
from .scene import Actor, Scene

RATES = {".mp4": 30, ".gif": 20}    # frames per second
FILMS = tuple(RATES)
PICTURES = ".png", ".svg", ".pdf"   # one moment
SECONDS = 20                        # of a film of which nobody says the speed
FRAMES = 20_000                     # at most
INCHES, DPI = (12.8, 7.2), 100
LEFT, RIGHT, WIDTH = 0.02, 0.325, 0.295      # left ends of the close-ups, and their width
CHARTS = 0.675, 0.31            # left, width

Frame = np.ndarray


def check_film(target: Path) -> None:
    """Check before the work that the film can be written."""
    check_ending(target, "a film .mp4 or .gif, or a picture .png, .svg or .pdf", *RATES, *PICTURES)
    if target.suffix.lower() == ".mp4":
        encoder()


def make_film(runs: Sequence[RunData], target: Path, start: float | None = None, end: float | None = None,
              speed: float | None = None, case: Case | None = None) -> None:
    """Write the film of some runs from `start` to `end` [s], `speed` seconds of them per second, or the picture of `start`."""
    first, last = min(float(r.time[0]) for r in runs), max(float(r.time[-1]) for r in runs)
    start, end = first if start is None else start, last if end is None else end
    kind = target.suffix.lower()
    if not (first <= start <= end <= last and (start < end or (kind in PICTURES and first < last))):
        raise Error(file=target, expected=f"times from {first:g} to {last:g} s in ascending order",
                    found=f"{start:g} to {end:g} s")
    if kind in PICTURES:
        with ldbench_style(), complete(target) as scratch:
            picture = Picture(runs, first, last, None, case)
            if kind == ".png":
                Image.fromarray(picture.frame(start)).save(scratch, format="PNG", optimize=True)
            elif kind == ".svg":
                scratch.write_text(svg(picture.still_figure(start)), encoding="utf-8")
            else:
                save_pages(scratch, [("", picture.still_figure(start))])
        return
    rate, speed = RATES[kind], speed or (end - start)/SECONDS
    count = int(np.ceil((end - start)/speed*rate)) + 1
    if count > FRAMES:
        raise Error(file=target, expected=f"at most {FRAMES} frames", found=count,
                    advice="a higher --speed or a shorter time takes fewer")
    times = tqdm(np.linspace(start, end, count), desc="film", unit="frame", disable=None, leave=False)
    with ldbench_style(), complete(target) as scratch:
        picture = Picture(runs, start, end, speed, case)
        (write_gif if kind == ".gif" else write_mp4)(scratch, rate, (picture.frame(float(t)) for t in times))


def encoder() -> ModuleType:
    """Find the encoder of H.264."""
    return needed("imageio_ffmpeg", "view", "imageio-ffmpeg")


def write_mp4(path: Path, rate: int, frames: Iterable[Frame]) -> None:
    """Write H.264 that every player accepts, tuned for lines that stand still or move slowly: others leave traces of themselves."""
    size = tuple(int(DPI*x) for x in INCHES)
    writer = encoder().write_frames(str(path), size, fps=rate, codec="libx264", pix_fmt_out="yuv420p", quality=7,
                                    macro_block_size=2, output_params=["-f", "mp4", "-threads", "1", "-tune", "stillimage"])
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
    finally:
        writer.close()


def write_gif(path: Path, rate: int, frames: Iterable[Frame]) -> None:
    """Write a repeating GIF with the colours of the first frame, whose charts have the colours of all arrows."""
    images = (image.resize((image.width*5//8, image.height*5//8), Image.Resampling.LANCZOS)
              for image in map(Image.fromarray, frames))
    first = next(images)
    palette = first.quantize(96, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    first, *others = (image.quantize(dither=Image.Dither.NONE, palette=palette) for image in chain([first], images))
    first.save(path, format="GIF", save_all=True, append_images=others, duration=1000//rate, loop=0)


class Picture:
    """A figure whose moving parts are set to a time: wheelset, both contacts, displacement and forces."""

    def __init__(self, runs: Sequence[RunData], start: float, end: float, speed: float | None,
                 case: Case | None) -> None:
        if len(runs) > len(SERIES):
            raise Error(file=runs[len(SERIES)].file, expected=f"at most {len(SERIES)} runs", found=len(runs),
                        advice="a page holds more")
        assumed = assumed_profiles(runs, case)
        self.actors = [Actor(run, line, assumed) for run, line in zip(runs, SERIES, strict=False)]
        self.several = len(self.actors) > 1
        self.start, self.end = start, end
        self.figure = Figure(figsize=INCHES, dpi=DPI)
        self.canvas = FigureCanvasAgg(self.figure)
        self.scale, self.unit = (1e3, "ms") if end - start < 1 else (1.0, "s")      # of time in the charts
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
        self.draw_charts()
        self.cursors = [ax.axvline(color=GREY, linewidth=1.0, animated=True) for ax in dict.fromkeys(self.charts.values())]
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)   # what does not move is drawn once

    def draw_title(self) -> None:
        """Write the heading of one run, or name and look of each of several."""
        if not self.several:
            self.figure.text(LEFT, 0.975, plain(self.actors[0].run.heading), fontsize=13, weight="bold", va="top")
            return
        few = len(self.actors) < 3
        samples = [Line2D([], [], **actor.line.kwargs()) for actor in self.actors]
        labels = [run.name if run.heading == run.name else f"{run.name}: {run.heading}" for run in (a.run for a in self.actors)]
        self.figure.legend(samples, [plain(clipped(words, 42)) for words in labels], loc="upper left",
                           bbox_to_anchor=(0.012, 0.99), ncols=2 if few else 3, fontsize=11 if few else 8, handlelength=2.6,
                           borderaxespad=0.0)

    def draw_charts(self) -> None:
        """Draw displacement and normal forces over the time of the film.

        One run has a panel for the flanges and one for the treads, several runs have a panel for each contact that closes.
        """
        panels: list[tuple[str, ...]] = ([("Y",), ("N_LF",), ("N_RF",), ("N_LT",), ("N_RT",)] if self.several else
                                         [("Y",), ("N_LF", "N_RF"), ("N_LT", "N_RT")])
        panels = [columns for columns in panels if any(actor.part(c, self.start, self.end).any()
                                                       for c in columns for actor in self.actors)]
        count, gap = max(len(panels), 3), 0.05 if self.several else 0.065
        height = (0.9 - 0.075 + gap)/count - gap
        for k, columns in enumerate(panels):
            ax = self.figure.add_axes((CHARTS[0], 0.9 - height - k*(height + gap), CHARTS[1], height))
            ax.set_xlim(self.scale*self.start, self.scale*self.end)
            self.draw_chart(ax, columns)
            if k < len(panels) - 1:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel(f"time [{self.unit}]")

    def draw_chart(self, ax: Axes, columns: Sequence[str]) -> None:
        """Draw columns of all runs."""
        for actor in self.actors:
            for column in (c for c in columns if c in actor.columns):
                known = quantity(column)
                line = actor.line if self.several else CONTACT_LINES.get(column.rpartition("_")[2], SERIES[0])
                t, x = (actor.part(name, self.start, self.end) for name in ("time", column))
                ax.plot(self.scale*t, known.scale*x, label=plain(known.words), **line.kwargs())
        if len(columns) > 1:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1, fontsize=8)
            ax.set_ylabel(plain(f"[{known.unit}]"))
        else:
            ax.set_title(plain(known.label), loc="left", fontsize=8, pad=2)
        self.charts |= dict.fromkeys(columns, ax)

    def frame(self, t: float) -> Frame:
        """The picture at time t [s], (height, width, 3) bytes."""
        self.canvas.restore_region(self.still)
        for scene in self.scenes:
            for artist in scene.move(t):
                scene.ax.draw_artist(artist)
        for cursor in self.cursors:
            cursor.set_xdata([self.scale*t]*2)
            cursor.axes.draw_artist(cursor)
        size = self.canvas.get_width_height()
        image = Image.frombuffer("RGBA", size, self.canvas.buffer_rgba(), "raw", "RGBA", 0, 1).convert("RGB")
        draw = ImageDraw.Draw(image)
        for (x, y), words, own, anchor in self.words(t):
            draw.text((x*image.width, (1 - y)*image.height), words, fill="black", font=own, anchor=anchor)
        return np.array(image)

    def still_figure(self, t: float) -> Figure:
        """The figure at time t [s], for files that are drawn in lines and letters: nothing moves any more."""
        for scene in self.scenes:
            shown = list(scene.move(t))
            for point in scene.points.values():         # those of open contacts have no place
                point.set_visible(point in shown)
            for artist in shown:
                artist.set_animated(False)
        for cursor in self.cursors:
            cursor.set(xdata=[self.scale*t]*2, animated=False)
        for (x, y), words, own, anchor in self.words(t):
            self.figure.text(x, y, plain(words), family=own.getname()[0], fontsize=72*own.size/DPI, va="top",
                             ha={"l": "left", "m": "center", "r": "right"}[anchor[0]])
        return self.figure

    def words(self, t: float) -> Iterator[tuple[tuple[float, float], str, ImageFont.FreeTypeFont, str]]:
        """All texts that change: place in the figure, words, font and anchor. Pillow draws them in a tenth of the time that
        matplotlib takes."""
        yield (0.985, 0.975), f"{1e3*t:10.3f} ms   {self.speed}".rstrip(), self.clock_font, "ra"
        for k, actor in enumerate(self.actors):
            name = f"{clipped(actor.run.name, 20)}:  " if self.several else ""
            yield (LEFT, 1 - self.header - k*self.pitch), name + actor.pose_words(t), self.value_font, "la"
            for side, left in ("left", LEFT), ("right", RIGHT):
                place = left + WIDTH/2, (len(self.actors) - k)*self.pitch + 0.015
                yield place, name + actor.force_words(side, t), self.value_font, "ma"


def clipped(words: str, length: int) -> str:
    """Words of at most so many characters."""
    return words if len(words) <= length else words[:length - 1] + "…"


def font(family: str, points: float) -> ImageFont.FreeTypeFont:
    """A font that comes with matplotlib, of a size in points."""
    return ImageFont.truetype(findfont(FontProperties(family=family)), points*DPI/72)
