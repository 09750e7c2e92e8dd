"""Films of runs for slides: wheels on rails and the motion beside them, frame by frame with matplotlib."""
from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path
from types import ModuleType

import numpy as np
from PIL import Image
from tqdm import tqdm

from .._core.errors import Error
from .._core.files import check_ending, complete
from .._core.optional import needed
from ..case import Case
from ..plots.style import ldbench_style
from ..results.run_data import RunData
from .picture import DPI, INCHES, Frame, Picture

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
              speed: float | None = None, case: Case | None = None) -> None:
    """Write the film of some runs from `start` to `end` [s], `speed` seconds of them per second, or the picture of `start`."""
    first, last = min(float(r.time[0]) for r in runs), max(float(r.time[-1]) for r in runs)
    start, end = first if start is None else start, last if end is None else end
    kind = target.suffix.lower()
    if not (first <= start <= end <= last and (start < end or (kind == PICTURE and first < last))):
        raise Error(f"{target}: expected times from {first:g} to {last:g} s in ascending order, found {start:g} to {end:g} s")
    if kind == PICTURE:
        with ldbench_style(), complete(target) as scratch:
            Image.fromarray(Picture(runs, first, last, None, case).frame(start)).save(scratch, format="PNG", optimize=True)
        return
    rate, speed = RATES[kind], speed or (end - start)/SECONDS
    count = int(np.ceil((end - start)/speed*rate)) + 1
    if count > FRAMES:
        raise Error(f"{target}: expected at most {FRAMES} frames, found {count}; a higher --speed or a shorter time takes fewer")
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
