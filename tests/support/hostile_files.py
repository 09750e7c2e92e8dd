"""Files that nobody can use, or that hold nonsense, made of a good one: what an organiser may be sent."""
from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np


def with_rows(change: Callable[[np.ndarray], np.ndarray]) -> Callable[[Path, Path], None]:
    """A file whose numbers are changed."""
    def spoil(file: Path, good: Path) -> None:
        names, *rows = good.read_text().splitlines()
        numbers = change(np.array([[float(x or "nan") for x in row.split(",")] for row in rows]))
        file.write_text("\n".join([names, *(",".join(f"{x:.8g}" for x in row) for row in numbers)]) + "\n")
    return spoil


def constant(value: float) -> Callable[[Path, Path], None]:
    return with_rows(lambda x: np.column_stack([x[:, 0], np.full((len(x), x.shape[1] - 1), value)]))


def with_column(number: int, cell: Callable[[str], str]) -> Callable[[Path, Path], None]:
    """A file with a column, by its number from 0, whose cells are of another type."""
    def spoil(file: Path, good: Path) -> None:
        names, *rows = (row.split(",") for row in good.read_text().splitlines())
        changed = [[cell(x) if k == number else x for k, x in enumerate(row)] for row in rows]
        file.write_text("\n".join(",".join(row) for row in [names, *changed]) + "\n")
    return spoil


def in_milliseconds(unit: str) -> Callable[[Path, Path], None]:
    """A file with times in milliseconds under the unit that is told."""
    def spoil(file: Path, good: Path) -> None:
        with_column(0, lambda x: f"{1e3*float(x):.8g}")(file, good)
        names, _, rows = file.read_text().partition("\n")
        file.write_text(names.replace("[s]", unit, 1) + "\n" + rows)
    return spoil


def bytes_of(change: Callable[[bytes], bytes]) -> Callable[[Path, Path], None]:
    return lambda file, good: file.write_bytes(change(good.read_bytes())) and None


def loop(file: Path, good: Path) -> None:
    file.symlink_to(file.name)


def unreadable(file: Path, good: Path) -> None:
    file.write_text("")
    file.chmod(0)
    if os.access(file, os.R_OK):        # root reads everything
        file.unlink()
        file.mkdir()


HOSTILE: dict[str, Callable[[Path, Path], None]] = {
    "empty": bytes_of(lambda x: b""), "binary": bytes_of(lambda x: bytes(range(256))*400), "zeros": bytes_of(lambda x: b"\0"*10000),
    "cut in a row": bytes_of(lambda x: x[:len(x)//2]), "names alone": bytes_of(lambda x: x.split(b"\n")[0]),
    "NaN everywhere": constant(np.nan), "1e308 everywhere": constant(1e308), "one row": with_rows(lambda x: x[:1]),
    "two rows": with_rows(lambda x: x[:2]),
    "names twice": bytes_of(lambda x: b",".join([b"t"]*x.split(b"\n")[0].count(b",") + [b"t"]) + x[x.index(b"\n"):]),
    "descending": with_rows(lambda x: x[::-1]), "one time": with_rows(lambda x: np.column_stack([0*x[:, 0], x[:, 1:]])),
    "no permission": unreadable, "a folder": lambda file, good: file.mkdir(), "a loop": loop,
    "a link to nothing": lambda file, good: file.symlink_to("nothing"), "a device": lambda file, good: file.symlink_to("/dev/zero"),
    "a pipe": lambda file, good: os.mkfifo(file), "huge names": bytes_of(lambda x: b"x"*3_000_000 + b"\n" + x),
    "huge row": bytes_of(lambda x: x + b"1,"*1_000_000),
    "a page": bytes_of(lambda x: b"<html><script>alert(1)</script></html>\n"*50),
    "half a header": bytes_of(lambda x: b"# ldbench 1.0.0\n# case ex4_aw: x\n# &results\n" + x[:2000]),
    "a header that ends in a word": bytes_of(lambda x: b"# ldbench 1.0.0\n# case ex4_aw: x\n# &case\n#  title = \".0\n# /\n" + x),
    "words as numbers": bytes_of(lambda x: x.replace(b"0.0", b"zero")),
    "infinite everywhere": constant(np.inf), "no rows": bytes_of(lambda x: x.split(b"\n")[0] + b"\n"),
    "times out of order": with_rows(lambda x: x[np.random.default_rng(1).permutation(len(x))]),
    "times empty": with_rows(lambda x: np.column_stack([np.full(len(x), np.nan), x[:, 1:]])),
    "a time that jumps": with_rows(lambda x: np.column_stack([x[:, 0] + 1e6*(np.arange(len(x)) > len(x)/2), x[:, 1:]])),
    "a time that stops": with_rows(lambda x: np.column_stack([np.minimum(x[:, 0], x[len(x)//3, 0]), x[:, 1:]])),
    "one column": with_rows(lambda x: x[:, :1]), "a column is missing": with_rows(lambda x: x[:, :-1]),
    "thousands of columns": bytes_of(lambda x: b"\n".join(row + b",0"*3000 for row in x.split(b"\n")[:400])),
    "huge numbers here and there": with_rows(lambda x: np.where(np.random.default_rng(2).random(x.shape) < 0.01, 1e300, x)),
    "empty cells here and there": with_rows(lambda x: np.where(np.random.default_rng(3).random(x.shape) < 0.1, np.nan, x)),
    "infinite here and there": with_rows(
        lambda x: np.column_stack([x[:, 0], np.where(np.random.default_rng(4).random(x[:, 1:].shape) < 0.01, np.inf, x[:, 1:])])),
    "constant but for the time": constant(1.0), "zero but for the time": constant(0.0),
    "letters that are not UTF-8": bytes_of(lambda x: b"d\xe9placement \xff\n" + x),
    "a cell too many": bytes_of(lambda x: x.replace(b"\n", b"\n1,", 3)),
    "commas for points": bytes_of(lambda x: x.replace(b".", b",")),
    "cut in a letter": bytes_of(lambda x: x[:-3]),
    "milliseconds that are called seconds": in_milliseconds("[s]"), "milliseconds without a unit": in_milliseconds(""),
    "words in a column of numbers": with_column(1, lambda x: "left" if float(x) > 0 else "right"),
    "a word in a column of numbers": with_column(1, lambda x: "contact" if float(x) > 0.01 else x),
    "words for times": with_column(0, lambda x: "noon"), "complex times": with_column(0, lambda x: f"({x}+0j)"),
    "complex numbers": with_column(1, lambda x: f"({x}+1e-3j)"), "imaginary numbers": with_column(1, lambda x: f"{x}i"),
    "booleans": with_column(1, lambda x: str(float(x) > 0)), "booleans for times": with_column(0, lambda x: str(float(x) > 0.01)),
    "dates for times": with_column(0, lambda x: "2006-05-31T10:22:05"), "hexadecimal": with_column(1, lambda x: float(x).hex()),
    "quotes about numbers": with_column(1, lambda x: f'"{x}"'),
}

# A line above the names is a remark, whatever its length and letters. The unit of the time follows from the length of the
# file, whatever it states.
HARMLESS = {"huge names", "letters that are not UTF-8", "milliseconds without a unit", "milliseconds that are called seconds"}
