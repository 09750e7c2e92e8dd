"""Pages as one file: a document .pdf, or a picture .svg or .png with the pages one below the other."""
from __future__ import annotations

import base64
import io
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib
from matplotlib.backends.backend_pdf import FigureCanvasPdf, PdfPages
from matplotlib.figure import Figure
from PIL import Image

from .._core.errors import Error
from .._core.files import check_ending, complete, failing_as
from .style import ldbench_style

PDF = ".pdf"
ENDINGS = PDF, ".svg", ".png"
DPI = 110       # of a picture
MOST = 24       # pages of a picture: programs that show pictures refuse longer ones
Chapter = tuple[str, Iterable[tuple[str, Figure]]]        # title, and pages with their titles


@dataclass(frozen=True)
class Part:
    """Pages under one bookmark."""
    title: str
    file: Path
    pages: tuple[str, ...]        # their titles
    first: int = 0                # their place in the file


class Figures(tuple[Figure, ...]):
    """Figures of matplotlib, which a notebook shows one below the other."""

    def _repr_html_(self) -> str:
        return "".join(f'<img alt="" src="data:image/png;base64,{base64.b64encode(png(figure)).decode()}">' for figure in self)


def check_sheets(target: Path) -> None:
    """Refuse the name of a file that is none of these."""
    check_ending(target, "a document .pdf, or a picture .svg or .png", *ENDINGS)


def save_sheets(figures: Sequence[Figure], target: Path) -> None:
    """Write pages, as the ending of the name says."""
    kind = target.suffix.lower()
    if kind != PDF and len(figures) > MOST:
        raise Error(file=target, expected=f"at most {MOST} pages for a picture", found=len(figures),
                    advice="a document .pdf holds more")
    with complete(target) as scratch:
        if kind == PDF:
            save_pages(scratch, (("", figure) for figure in figures))
        elif kind == ".svg":
            scratch.write_text(stacked(figures), encoding="utf-8")
        else:
            images = [Image.open(io.BytesIO(png(figure))).convert("RGB") for figure in figures]
            whole = Image.new("RGB", (images[0].width, sum(image.height for image in images)))
            for k, image in enumerate(images):
                whole.paste(image, (0, sum(above.height for above in images[:k])))
            whole.save(scratch, format="PNG")


def save_pages(path: Path, figures: Iterable[tuple[str, Figure]]) -> tuple[str, ...]:
    """Write figures as the pages of a PDF; returns their titles."""
    return save_parts(path, [("", figures)])[0].pages


def save_parts(target: Path, chapters: Iterable[Chapter]) -> list[Part]:
    """Write chapters into one file, in which they share the fonts: to cut a font takes as long as a page."""
    parts = []
    with failing_as(target, target), ldbench_style(), PdfPages(target, metadata={"CreationDate": None}) as pdf:
        for title, pages in chapters:
            first, names = pdf.get_pagecount(), []
            for name, figure in pages:
                if figure.axes and (layout := figure.get_layout_engine()):
                    layout.execute(figure)
                figure.set_layout_engine("none")        # it is done
                FigureCanvasPdf(figure).print_pdf(pdf)  # PdfPages.savefig would draw the page twice
                names.append(name)
            parts.append(Part(title, target, tuple(names), first))
    return parts


def png(figure: Figure) -> bytes:
    """A figure as a PNG file."""
    file = io.BytesIO()
    with ldbench_style():
        figure.savefig(file, format="png", dpi=DPI, metadata={"Software": None})
    return file.getvalue()


def svg(figure: Figure, name: str = "page") -> str:
    """A figure as an SVG file, whose parts have identities that begin with `name`; the same figure gives the same text."""
    file = io.StringIO()
    with ldbench_style(), matplotlib.rc_context({"svg.hashsalt": "ldbench"}):
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return re.sub(r'(\bid="|href="#|url\(#)', rf"\1{name}-", file.getvalue())


def stacked(figures: Sequence[Figure]) -> str:
    """Figures as one SVG file, one below the other."""
    parts, widest, below = [], 0.0, 0.0
    for k, figure in enumerate(figures, 1):
        whole = svg(figure, f"page{k}")
        width, height = map(float, re.findall(r'viewBox="0 0 (\S+) (\S+)"', whole)[0])
        inner = whole[whole.index("<svg"):].partition(">")[2]
        parts.append(f'<svg y="{below:g}" width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}">{inner}')
        widest, below = max(widest, width), below + height
    return (f'<?xml version="1.0" encoding="utf-8" standalone="no"?>\n<svg xmlns="http://www.w3.org/2000/svg" '
            f'xmlns:xlink="http://www.w3.org/1999/xlink" version="1.1" width="{widest:g}pt" height="{below:g}pt" '
            f'viewBox="0 0 {widest:g} {below:g}">\n{"".join(parts)}</svg>\n')
