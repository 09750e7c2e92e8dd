"""Figures as the pages of a PDF file, with every text laid out once in a file.

Matplotlib starts each page without what it knew of texts. The numbers of axes and the words of labels come again on page
after page, and laying them out takes a third of the time of drawing.
"""
from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Lock
from typing import Any

from fontTools.subset import Options
from matplotlib.backend_bases import GraphicsContextBase
from matplotlib.backends.backend_pdf import Op, PdfFile, RendererPdf
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.text import Text

DOTS = 72           # to the inch: points, the unit of the format
# Tables of a font by which a program that sets text chooses and places its glyphs. A page names and places each glyph itself.
LAYOUT = ["GDEF", "GPOS", "GSUB", "kern"]
DROPPED = "_drop_tables_default"        # of fontTools: what a cut font is without
CUTTING = Lock()                        # the list is that of all threads


class PagesFile(PdfFile):       # type: ignore[misc]      # matplotlib has no types
    """A PDF file; its pages are compressed as a whole and not operator by operator."""

    def __init__(self, path: Path, **facts: Any) -> None:
        """facts: the arguments of matplotlib's class."""
        self.pieces: list[bytes] = []
        super().__init__(path, **facts)

    def write(self, data: bytes) -> None:
        """Keep data that a stream will compress until its end; write other data to the file."""
        if self.currentstream is not None and self.currentstream.compressobj is not None:
            self.pieces.append(data)
        else:
            super().write(data)

    def endStream(self) -> None:            # matplotlib's name
        """Write what was kept, and end the stream."""
        if self.pieces:
            self.currentstream.write(b"".join(self.pieces))
            self.pieces = []
        super().endStream()


class TextRenderer(RendererPdf):      # type: ignore[misc]
    """The renderer of all pages of one size. Matplotlib remembers the extents of texts as long as a renderer lives; this one
    remembers the operators of a text too. They depend on its place only by the matrix at their beginning."""

    def __init__(self, file: PagesFile, width: float, height: float) -> None:
        """The size of pages is in inches."""
        super().__init__(file, DOTS, height, width)
        self.words: dict[tuple[str, FontProperties, float], tuple[bytes, bytes]] = {}

    def begin(self) -> None:
        """Begin a page: no state of the pen is left of another one."""
        self.gc = self.new_gc()

    def draw_text(self, gc: GraphicsContextBase, x: float, y: float, s: str, prop: FontProperties, angle: float,
                  ismath: bool | str = False, mtext: Text | None = None) -> None:
        """Draw a text, again from its operators where it was drawn before."""
        if ismath or gc.get_url():
            super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)
            return
        self.check_gc(gc, gc._rgb)
        known = self.words.get((s, prop, angle))
        if known is None:
            start = len(self.file.pieces)
            super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)
            pieces = self.file.pieces[start:]
            matrices = [k for k, piece in enumerate(pieces) if piece.endswith(b" " + Op.concat_matrix.pdfRepr())]
            if len(matrices) == 1:
                # The end of the matrix's line is a piece too.
                self.words[s, prop.copy(), angle] = b"".join(pieces[:matrices[0]]), b"".join(pieces[matrices[0] + 2:])
            return
        before, after = known
        cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        self.file.write(before)
        self.file.output(cos, sin, -sin, cos, x, y, Op.concat_matrix)
        self.file.write(after)


@contextmanager
def without_layout() -> Iterator[None]:
    """Fonts that are cut in this block have no tables of layout, whose cutting takes three quarters of the time."""
    with CUTTING:
        before = list(getattr(Options, DROPPED, ()))
        setattr(Options, DROPPED, before + LAYOUT)
        try:
            yield
        finally:
            setattr(Options, DROPPED, before)


class Pages:
    """A PDF that figures are added to; it is complete after `close`."""

    def __init__(self, path: Path) -> None:
        self.file = PagesFile(path, metadata={"CreationDate": None})
        self.renderers: dict[tuple[float, float], TextRenderer] = {}

    def add(self, figure: Figure) -> None:
        """Draw a figure as the next page."""
        size = tuple(figure.get_size_inches())
        if size not in self.renderers:
            self.renderers[size] = TextRenderer(self.file, *size)
        renderer = self.renderers[size]
        self.file.newPage(*size)
        renderer.begin()
        figure.draw(renderer)
        renderer.finalize()
        self.file.endStream()

    def close(self) -> None:
        """Write fonts and indices, and close the file, also one that a page has failed in."""
        try:
            with without_layout():
                self.file.finalize()
            self.file.close()
        finally:
            self.file.fh.close()
