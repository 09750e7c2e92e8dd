"""What the pages of a collation share: the look of a code's lines, and words that fit their places."""
from __future__ import annotations

from ldbench.plots.style import CODE_LINES, Line

CODES_ON_PAGE = 14


def line_of(k: int) -> Line:
    """The look of a code's lines."""
    return CODE_LINES[k % len(CODE_LINES)]


def capital(words: str) -> str:
    """Words that begin with a capital letter."""
    return words[0].upper() + words[1:]


def cut(words: str, longest: int) -> str:
    """Words that fit a place."""
    return words if len(words) <= longest else f"{words[:longest - 1]}…"
