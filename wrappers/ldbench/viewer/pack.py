"""Columns as few bytes: every number of a row that is kept comes out with all nine digits.

A short run is kept whole. Of a long one some rows are kept exactly, those round events and extremes, the peaks of
the contact forces, and rows at even distances; beside them go bands, the least and the largest value of every
column in bins of a few rows, and the columns that the scene moves by, one value for every row.

Exact numbers are decimals, m 10^e with |m| < 10^9. A number is predicted from the ones before it, and the
difference in units of its last digit is what is written; `decode.js` predicts in the same order of operations, and so
to the last bit. Bytes of equal weight lie together, and deflate does the rest.
"""
from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

EVERY_ROW = "Y", "Z", "roll", "N_LT", "N_LF", "N_RT", "N_RF"       # of these columns a long run keeps every row
PEAKS = "N_LT", "N_LF", "N_RT", "N_RF"                             # and the rows of the largest values of these
CELLS = 600_000             # numbers of a run that is kept whole,
CELLS_BESIDE = 100_000      # and of one that is there for comparison
BINS = 8192                 # of a band
LEVELS = 2**14 - 2          # of a band, from the least to the largest value of a column
ASIDE = 1e-3                # of a level: a band reaches so far beyond its values, as the page rounds when it makes values of levels
FINE_LEVELS = 2**16 - 2     # of a column that is kept for every row
DIGITS = 9
EMPTY, ZERO = 127, 126      # instead of an exponent
POWERS = np.array([float(f"1e{k}") for k in range(129)])
EXPONENTS = -118, 118       # of the last digit; smaller numbers are zero, larger ones are left out


def pack(time: np.ndarray, columns: Mapping[str, np.ndarray], moments: Sequence[float], cells: int,
         derived: Mapping[str, np.ndarray]) -> tuple[dict[str, Any], bytes]:
    """Columns, each of shape (rows,), over `time`, for the page: an index of what is in the body, and the deflated body.

    moments: times [s] round which a long run keeps rows exactly. cells: how many numbers are kept whole. derived: columns that
    the page computes of others at the rows that it has; a long run gets bands of them.
    """
    n = len(time)
    room = max(cells//max(len(columns), 1), 200)
    whole = n <= room
    rows = np.arange(n) if whole else keep_rows(time, columns, moments, room)
    t, data = pack_exact(time[rows])
    parts = [data, *(pack_exact(x[rows], t)[1] for x in columns.values())]
    index: dict[str, Any] = {"rows": n, "kept": len(t), "exact": list(columns), "bands": []}
    if not whole:
        index["bin"] = -(-n//BINS)
        edges = np.arange(0, n, index["bin"])        # bins have equal numbers of rows
        parts.append(pack_exact(time)[1])
        for name, x in {**columns, **derived}.items():
            band, data = pack_track(x) if name in EVERY_ROW else pack_band(x, edges)
            index["bands"].append({"name": name, **band})
            parts.append(data)
    return index, zlib.compress(b"".join(parts), 6)


def keep_rows(time: np.ndarray, columns: Mapping[str, np.ndarray], moments: Sequence[float], room: int) -> np.ndarray:
    """At most `room` rows: ends, extremes, events with their surroundings, peaks, and rows at equal distances."""
    n = len(time)
    kept = np.zeros(n, bool)
    kept[[0, 1, -2, -1]] = True
    for x in columns.values():
        if not np.isnan(x).all():
            kept[[np.nanargmin(x), np.nanargmax(x)]] = True
    around = max(min(room//4//max(len(moments), 1)//2, 200), 2)
    for t in moments:
        k = int(np.searchsorted(time, t))
        kept[max(k - around, 0):k + around + 1] = True
    edges = np.linspace(0, n, max(room//6//len(PEAKS), 1) + 1).astype(int)
    for x in (columns[name] for name in PEAKS if name in columns):
        for a, b in pairwise(edges):
            if np.nanmax(x[a:b], initial=0.0) > 0:
                kept[a + np.nanargmax(x[a:b])] = True
    left = room - int(kept.sum())
    if left > 0:
        kept[np.linspace(0, n - 1, left).round().astype(int)] = True
    return np.flatnonzero(kept)


def decimals(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nine digits m and the exponent e of the last one; e is EMPTY or ZERO where there are none."""
    none, zero = ~np.isfinite(x), x == 0
    x = np.where(none, 0, x)
    e = np.floor(np.log10(np.abs(np.where(none | zero, 1, x)))).astype(int) - (DIGITS - 1)
    m = np.abs(np.rint(scaled(x, e)))
    # The logarithm may be off by one beside a power of ten, and rounding may carry.
    e = e + (m >= 10**DIGITS) - ((m < 10**(DIGITS - 1)) & ~zero & ~none)
    m = np.rint(scaled(x, e))
    zero |= e < EXPONENTS[0]
    none |= e > EXPONENTS[1]
    m[zero | none] = 0
    return m, np.where(none, EMPTY, np.where(zero, ZERO, e))


def scaled(x: np.ndarray, e: np.ndarray) -> np.ndarray:
    """x / 10^e, with powers of ten as they are written."""
    power = POWERS[np.minimum(np.abs(e), 128)]
    return np.where(e < 0, x*power, x/power)


def value_of(m: np.ndarray, e: np.ndarray) -> np.ndarray:
    """m 10^e as the page computes it: powers of ten up to 22 are exact, numbers with larger ones are read as text."""
    values = np.where(e == EMPTY, np.nan, scaled(m, -np.where(e >= ZERO, 0, e)))
    for k in np.flatnonzero((np.abs(e) > 22) & (e < ZERO)):
        values[k] = float(f"{int(m[k])}e{int(e[k])}")
    return values


def predicted(x: np.ndarray, t: np.ndarray | None) -> np.ndarray:
    """Every number from the three before it, by the parabola through them; the first three are taken for 0. Without t, rows are
    at equal distances."""
    t = np.arange(len(x), dtype=float) if t is None else t
    found = np.zeros(len(x))
    (x3, x2, x1), (t3, t2, t1) = ((v[:-3], v[1:-2], v[2:-1]) for v in (x, t))
    with np.errstate(all="ignore"):
        d1 = (x1 - x2)/(t1 - t2)
        d2 = (x2 - x3)/(t2 - t3)
        found[3:] = x1 + d1*(t[3:] - t1) + (d1 - d2)/(t1 - t3)*(t[3:] - t1)*(t[3:] - t2)
    return found


def pack_exact(x: np.ndarray, t: np.ndarray | None = None) -> tuple[np.ndarray, bytes]:
    """The numbers as the page will have them, and their bytes: exponents, then the four bytes of the differences from what is
    predicted."""
    m, e = decimals(x)
    values = value_of(m, e)
    with np.errstate(all="ignore"):
        units = np.floor(scaled(predicted(values, t), e) + 0.5)
    units = np.where(np.abs(units) <= 1e9, units, 0.0)      # NaN too
    difference = np.where(e >= ZERO, 0, m - units).astype(np.int64)
    return values, e.astype(np.int8).tobytes() + planes(signless(difference), 4)


def planes(code: np.ndarray, count: int) -> bytes:
    """Whole numbers as bytes, those of equal weight together, the lowest first."""
    return b"".join(((code >> 8*k) & 255).astype(np.uint8).tobytes() for k in range(count))


def quantised(x: np.ndarray, count: int) -> tuple[dict[str, Any], np.ndarray]:
    """The least value and the size of a level, of which there are so many up to the largest value; and the values in levels."""
    known = x[np.isfinite(x)]
    low, step = (float(known.min()), float(np.ptp(known)/count)) if known.size else (0.0, 0.0)
    return {"low": low, "step": step}, (np.where(np.isfinite(x), x, np.nan) - low)/(step or 1.0)


def numbered(levels: np.ndarray) -> np.ndarray:
    """Whole numbers of levels: from 1, and 0 where there is no value."""
    return np.where(np.isnan(levels), 0, 1 + levels).astype(np.int64)


def pack_band(x: np.ndarray, edges: np.ndarray) -> tuple[dict[str, Any], bytes]:
    """Least and largest value in the bins from every edge to the next; levels are rounded outwards, so that the band
    holds every value, and only a bin that has the column's least value alone has a band without width."""
    facts, levels = quantised(x, LEVELS)
    low, high = np.fmin.reduceat(levels, edges), np.fmax.reduceat(levels, edges)
    a = numbered(np.maximum(np.floor(low - ASIDE), 0))
    b = numbered(np.where(high > 0, np.ceil(high + ASIDE), high))
    return facts, planes(signless(np.diff(a, prepend=0)), 2) + planes(b - a, 2)


def pack_track(x: np.ndarray) -> tuple[dict[str, Any], bytes]:
    """The nearest level for every row, by its first or second differences, whichever are smaller. Only the least value has
    the lowest level, so that the page tells an open contact from a small force."""
    facts, levels = quantised(x, FINE_LEVELS)
    plain = np.diff(numbered(np.where(levels > 0, np.maximum(np.rint(levels), 1), levels)), prepend=0)
    codes = [signless(plain), signless(np.diff(plain, prepend=0))]
    order = int(np.argmin([np.log2(code + 1.0).sum() for code in codes]))
    return facts | {"order": 1 + order}, planes(codes[order], 3)


def signless(d: np.ndarray) -> np.ndarray:
    """Whole numbers as non-negative ones: 0, -1, 1, -2 ... become 0, 1, 2, 3 ..."""
    return np.where(d >= 0, 2*d, -2*d - 1)
