"""Numbers as a reader sees them, in commands, tables and documents; viewer/static/number_text.js writes the same on pages.

A number has a true minus. One of 10 million or more, and one that is smaller than 1e-4 and has no fixed decimals, is written with a
power of ten. Numbers in error messages and in files for programs are not written here.
"""
from __future__ import annotations

import math
import re

LEAST, MOST = 1e-4, 1e7     # sizes below and from which a power of ten stands
DIGITS = 4                  # of a number of which nothing else is asked
UNKNOWN = "–"               # for a number that is not known, or for what did not happen
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number_text(x: float | None, decimals: int | None = None, digits: int | None = None, *, sign: bool = False,
                trim: bool = False) -> str:
    """A number; a dash for None, NaN and infinity.

    decimals: so many behind the point. digits: so many significant digits, and all those before the point. With both, so many
    significant digits and at most so many decimals; with neither, four significant digits.
    sign: a plus stands before a number above zero. trim: no zeros stand at the end.
    """
    if x is None or not math.isfinite(x):
        return UNKNOWN
    size = abs(x)
    if size >= MOST or (decimals is None and 0 < size < LEAST):
        words = scientific(size, (digits or DIGITS) - 1)
    else:
        known = decimals_of(size, digits or DIGITS)
        words = f"{size:.{known if decimals is None else min(known, decimals) if digits else decimals}f}"
        words = trimmed(words) if trim else words
    before = "−" if x < 0 else "+" if sign else ""
    return (before if re.search("[1-9]", words) else "") + words


def two_digits(x: float | None) -> str:
    """A size or a relative difference in two significant digits, without zeros at the end."""
    return number_text(x, digits=2, trim=True)


def decimals_of(x: float, digits: int) -> int:
    """How many decimals a number has that is written in so many significant digits; at least 0."""
    return max(digits - 1 - int(f"{x:.{digits - 1}e}".partition("e")[2]), 0) if x else 0


def trimmed(words: str) -> str:
    """A number without zeros at the end."""
    return words.rstrip("0").rstrip(".") if "." in words else words


def scientific(x: float, decimals: int = 1) -> str:
    """A number with a power of ten and at most so many decimals: '1.3·10⁻¹²'."""
    if not x:
        return "0"
    mantissa, exponent = f"{abs(x):.{decimals}e}".split("e")
    mantissa, power = trimmed(mantissa), f"10{str(int(exponent)).translate(SUPERSCRIPTS)}"
    return ("−" if x < 0 else "") + (power if mantissa == "1" else f"{mantissa}·{power}")


def percent_text(share: float | None, decimals: int = 2, *, sign: bool = False) -> str:
    """A share in percent with two significant digits and at most so many decimals: '0.05 %', '1.2 %', '12 %'."""
    words = number_text(None if share is None else 100*share, decimals, 2, sign=sign)
    return words if words == UNKNOWN else f"{words if re.search('[1-9]', words) else '0'} %"


def force_text(force: float) -> str:
    """A force [N] in kN, in three digits and at most one decimal."""
    return f"{number_text(1e-3*force, 1, 3)} kN"


def slope_words(slope: float, digits: int = 4) -> str:
    """A slope, and as 1:n what is not nearly 0: '0.0250 (1:40.0)'."""
    words = number_text(slope, digits)
    return words + (f" ({'−' if slope < 0 else ''}1:{1/abs(slope):.1f})" if abs(slope) > 1e-4 else "")


def clearance_words(left: float, right: float) -> str:
    """Rigid-axle flange clearance to both sides [m] as it is written everywhere, in mm: 'left 10.180, right 10.180'."""
    return f"left {number_text(1e3*left, 3)}, right {number_text(1e3*right, 3)}"
