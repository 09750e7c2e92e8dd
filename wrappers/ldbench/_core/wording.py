"""Numbers of things in words, lines that fit on a terminal."""
from __future__ import annotations

import textwrap

WIDTH = 100         # longest line on the terminal [characters], as in fortran/program/run_results.f90


def counted(n: int, noun: str) -> str:
    """Name a number of things by a noun in the singular: '1 run', '2 runs'."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def wrapped(line: str) -> str:
    """Break a line that is too long for the terminal at blanks; what follows is indented."""
    return "\n".join(textwrap.wrap(line, WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False))
