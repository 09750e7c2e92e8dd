"""Films of runs for slides: wheels on rails and the motion beside them, frame by frame with matplotlib."""
from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import numpy as np
from PIL import Image
from tqdm import tqdm

from .._core.errors import Error
from .._core.files import check_ending, complete
from .._core.optional import needed
from ..case import Case
from ..plots.style import CONTACT_LINES, SERIES, ldbench_style
from ..results.run_data import RunData
from .picture import DPI, INCHES, Frame, Picture, check_number

RATES = {".mp4": 30, ".gif": 20}    # frames per second
FILMS = tuple(RATES)
PICTURE = ".png"                    # one moment
SECONDS = 20                        # of a film of which nobody says the speed
FRAMES = 20_000                     # at most


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
    check_number(runs)
    first, last = min(float(r.time[0]) for r in runs), max(float(r.time[-1]) for r in runs)
    start, end = first if start is None else start, last if end is None else end
    still = target.suffix.lower() == PICTURE
    if not (first <= start <= end <= last and (start < end or (still and first < last))):
        raise Error(f"{target}: expected times from {first:g} to {last:g} s in ascending order, found {start:g} to {end:g} s")
    if still:
        with ldbench_style(), complete(target) as scratch:
            Image.fromarray(Picture(runs, first, last, None, case).frame(start)).save(scratch, format="PNG", optimize=True)
        return 1
    rate = RATES[target.suffix.lower()]
    speed = speed or (end - start)/SECONDS
    count = int(np.ceil((end - start)/speed*rate)) + 1
    if count > FRAMES:
        raise Error(f"{target}: expected at most {FRAMES} frames, found {count}; a higher --speed or a shorter time takes fewer")
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
