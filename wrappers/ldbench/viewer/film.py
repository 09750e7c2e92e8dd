"""Films and pictures of runs for slides: wheelset, both contacts and charts, frame by frame with matplotlib."""
from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

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
from ..plots.named import name, shows
from ..plots.sheets import save_pages, svg
from ..plots.style import CONTACT_LINES, GREY, SERIES, ldbench_style, plain
from ..results.quantities import quantity
from ..results.run_data import RunData
from .layout import SCREEN, SMALL_TITLE, TITLE, layout
from .page import assumed_profiles
from .scene import Actor, Scene

RATES = {".mp4": 30, ".gif": 20}    # frames per second
FILMS = tuple(RATES)
PICTURES = ".png", ".svg", ".pdf"   # one moment
SECONDS = 20                        # of a film of which nobody says the speed
FRAMES = 20_000                     # at most
DPI = 100

Frame = np.ndarray


def check_film(target: Path) -> None:
    """Check before the work that the film can be written."""
    check_ending(target, "a film .mp4 or .gif, or a picture .png, .svg or .pdf", *RATES, *PICTURES)
    if target.suffix.lower() == ".mp4":
        encoder()


class Width(NamedTuple):
    """The width of a picture file."""

    inches: float
    dpi: float          # of a PNG file


def make_film(runs: Sequence[RunData], target: Path, start: float | None = None, end: float | None = None,
              speed: float | None = None, case: Case | None = None, width: Width | None = None) -> None:
    """Write the film of some runs from `start` to `end` [s], `speed` seconds of them per second, or the picture of `start` in a
    width."""
    first, last = min(float(r.time[0]) for r in runs), max(float(r.time[-1]) for r in runs)
    start, end = first if start is None else start, last if end is None else end
    kind = target.suffix.lower()
    if not (first <= start <= end <= last and (start < end or (kind in PICTURES and first < last))):
        raise Error(file=target, expected=f"times from {first:g} to {last:g} s in ascending order",
                    found=f"{start:g} to {end:g} s")
    if kind in PICTURES:
        with ldbench_style(), complete(target) as scratch:
            picture = Picture(runs, first, last, None, case, width.inches if width else None)
            if kind == ".png" and width:
                picture.still_figure(start).savefig(scratch, format="png", dpi=width.dpi, metadata={"Software": None})
            elif kind == ".png":
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
    size = tuple(int(DPI*x) for x in SCREEN)
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
                 case: Case | None, width: float | None = None) -> None:
        if len(runs) > len(SERIES):
            raise Error(file=runs[len(SERIES)].file, expected=f"at most {len(SERIES)} runs", found=len(runs),
                        advice="a page holds more")
        assumed = assumed_profiles(runs, case)
        self.actors = [Actor(run, line, assumed) for run, line in zip(runs, SERIES, strict=False)]
        self.several = len(self.actors) > 1
        self.start, self.end = start, end
        panels = self.panels()
        self.layout = layout(len(self.actors), max(len(panels), 1 if width else 3), self.actors[0].run.heading, width)
        self.figure = Figure(figsize=self.layout.size, dpi=DPI)
        self.canvas = FigureCanvasAgg(self.figure)
        self.scale, self.unit = (1e3, "ms") if end - start < 1 else (1.0, "s")      # of time in the charts
        self.speed = "" if speed is None else f"1:{1/speed:,.0f}" if speed < 0.7 else f"{speed:g}×"
        self.draw_title()
        n = len(self.actors)
        self.scenes = [Scene(self.figure.add_axes(place), self.actors, side, start, end)
                       for place, side in zip(self.layout.scenes, (0, 1, -1), strict=True)]
        self.clock_font = font("DejaVu Sans Mono", 13)
        self.value_font = font("DejaVu Sans", 9 if n == 1 else 8 if n < 5 else 7)
        self.charts: dict[str, Axes] = {}
        self.draw_charts(panels)
        self.cursors = [shows(ax.axvline(color=GREY, linewidth=1.0, animated=True), "", name("time", self.unit), "moment")
                        for ax in dict.fromkeys(self.charts.values())]
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)   # what does not move is drawn once

    def draw_title(self) -> None:
        """Write the heading of one run, or name and look of each of several."""
        if not self.several:
            self.figure.text(self.layout.edge, 1 - 0.18/self.layout.size[1], plain(self.layout.heading),
                             fontsize=SMALL_TITLE if self.layout.narrow else TITLE, weight="bold", va="top")
            return
        few = len(self.actors) < 3
        columns = 1 if self.layout.narrow else 2 if few or self.layout.clock_below else 3
        samples = [Line2D([], [], **actor.line.kwargs()) for actor in self.actors]
        labels = [run.name if run.heading == run.name else f"{run.name}: {run.heading}" for run in (a.run for a in self.actors)]
        self.figure.legend(samples, [plain(clipped(words, 42)) for words in labels], loc="upper left",
                           bbox_to_anchor=(0.012, 0.99), ncols=columns,
                           fontsize=11 if few and not self.layout.clock_below else 8, handlelength=2.6, borderaxespad=0.0)

    def panels(self) -> list[tuple[str, ...]]:
        """The columns of each chart: one run has a chart for the flanges and one for the treads, several runs have a chart for each
        contact that closes."""
        panels: list[tuple[str, ...]] = ([("Y",), ("N_LF",), ("N_RF",), ("N_LT",), ("N_RT",)] if self.several else
                                         [("Y",), ("N_LF", "N_RF"), ("N_LT", "N_RT")])
        return [columns for columns in panels if any(actor.part(c, self.start, self.end).any()
                                                     for c in columns for actor in self.actors)]

    def draw_charts(self, panels: Sequence[tuple[str, ...]]) -> None:
        """Draw displacement and normal forces over the time of the film."""
        (left, bottom, width, whole), gap = self.layout.charts, self.layout.gap
        height = (whole + gap)/max(len(panels), 1 if self.layout.clock_below else 3) - gap
        for k, columns in enumerate(panels):
            ax = self.figure.add_axes((left, bottom + whole - height - k*(height + gap), width, height))
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
                t, x = (actor.part(one, self.start, self.end) for one in ("time", column))
                curve, = ax.plot(self.scale*t, known.scale*x, label=plain(known.words), **line.kwargs())
                shows(curve, name(column, known.unit), name("time", self.unit), of=actor.run.name)
        if len(columns) > 1:
            ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=1 if self.layout.narrow else 2, borderaxespad=0.1,
                      fontsize=8)
            ax.set_ylabel(plain(quantity(columns[0])._replace(words=known.words.partition(",")[0]).label))
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
        place = self.layout
        wide, anchor = ("", "la") if place.clock_below else (10, "ra")
        yield place.clock, f"{1e3*t:{wide}.3f} ms   {self.speed}".rstrip(), self.clock_font, anchor
        for k, actor in enumerate(self.actors):
            head = f"{clipped(actor.run.name, 20)}:  " if self.several else ""
            yield (place.edge, place.values - k*place.row), head + actor.pose_words(t), self.value_font, "la"
            below = place.forces - k*place.row
            for side, (left, _, width, _) in zip(("left", "right"), place.scenes[1:], strict=True):
                yield (left + width/2, below), head + actor.force_words(side, t), self.value_font, "ma"


def clipped(words: str, length: int) -> str:
    """Words of at most so many characters."""
    return words if len(words) <= length else words[:length - 1] + "…"


def font(family: str, points: float) -> ImageFont.FreeTypeFont:
    """A font that comes with matplotlib, of a size in points."""
    return ImageFont.truetype(findfont(FontProperties(family=family)), points*DPI/72)
