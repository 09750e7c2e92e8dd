"""Files that nobody can use, or that hold nonsense, made of a good one: what an organiser may be sent."""
from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

Spoil = Callable[[Path, Path], object]      # of the file to be written and the good one


def with_rows(change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """A file whose numbers are changed."""
    def spoil(file: Path, good: Path) -> None:
        names, *rows = good.read_text().splitlines()
        numbers = change(np.array([[float(x) for x in row.split(",")] for row in rows]))
        file.write_text("\n".join([names, *(",".join(f"{x:.8g}" for x in row) for row in numbers)]) + "\n")
    return spoil


def with_times(change: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    return with_rows(lambda x: np.column_stack([change(x[:, 0]), x[:, 1:]]))


def sprinkled(value: float, share: float = 1.0) -> Spoil:
    """A file with a value here and there, or everywhere but for the times."""
    chance = np.random.default_rng(4)
    return with_rows(lambda x: np.column_stack([x[:, 0], np.where(chance.random(x[:, 1:].shape) < share, value, x[:, 1:])]))


def with_column(number: int, cell: Callable[[str], str]) -> Spoil:
    """A file with a column, by its number from 0, whose cells are of another type."""
    def spoil(file: Path, good: Path) -> None:
        names, *rows = (row.split(",") for row in good.read_text().splitlines())
        changed = [[cell(x) if k == number else x for k, x in enumerate(row)] for row in rows]
        file.write_text("\n".join(",".join(row) for row in [names, *changed]) + "\n")
    return spoil


def bytes_of(change: Callable[[bytes], bytes]) -> Spoil:
    return lambda file, good: file.write_bytes(change(good.read_bytes()))


def unreadable(file: Path, good: Path) -> None:
    file.write_text("")
    file.chmod(0)
    if os.access(file, os.R_OK):        # root reads everything
        file.unlink()
        file.mkdir()


HOSTILE: dict[str, Spoil] = {
    "empty": bytes_of(lambda x: b""), "binary": bytes_of(lambda x: bytes(range(256))*400), "zeros": bytes_of(lambda x: b"\0"*10000),
    "cut in a row": bytes_of(lambda x: x[:len(x)//2]), "names alone": bytes_of(lambda x: x.split(b"\n")[0]),
    "one row": with_rows(lambda x: x[:1]), "two rows": with_rows(lambda x: x[:2]),
    "names twice": bytes_of(lambda x: b",".join([b"t"]*x.split(b"\n")[0].count(b",") + [b"t"]) + x[x.index(b"\n"):]),
    "no permission": unreadable, "a loop": lambda file, good: file.symlink_to(file.name),
    "a link to nothing": lambda file, good: file.symlink_to("nothing"), "a device": lambda file, good: file.symlink_to("/dev/zero"),
    "a pipe": lambda file, good: os.mkfifo(file), "huge names": bytes_of(lambda x: b"x"*3_000_000 + b"\n" + x),
    "huge row": bytes_of(lambda x: x + b"1,"*1_000_000),
    "a page": bytes_of(lambda x: b"<html><script>alert(1)</script></html>\n"*50),
    "half a header": bytes_of(lambda x: b"# ldbench 1.0.0\n# case ex4_aw: x\n# &results\n" + x[:2000]),
    "a header that ends in a word": bytes_of(lambda x: b"# ldbench 1.0.0\n# case ex4_aw: x\n# &case\n#  title = \".0\n# /\n" + x),
    "descending": with_rows(lambda x: x[::-1]), "times out of order": with_rows(np.random.default_rng(1).permutation),
    "one time": with_times(lambda t: 0*t), "times empty": with_times(lambda t: np.nan*t),
    "a time that jumps": with_times(lambda t: t + 1e6*(np.arange(len(t)) > len(t)/2)),
    "a time that stops": with_times(lambda t: np.minimum(t, t[len(t)//3])),
    "one column": with_rows(lambda x: x[:, :1]), "a column is missing": with_rows(lambda x: x[:, :-1]),
    "thousands of columns": bytes_of(lambda x: b"\n".join(row + b",0"*3000 for row in x.split(b"\n")[:400])),
    "NaN everywhere": sprinkled(np.nan), "zero everywhere": sprinkled(0.0), "1e308 everywhere": sprinkled(1e308),
    "infinite everywhere": sprinkled(np.inf), "NaN here and there": sprinkled(np.nan, 0.1),
    "huge numbers here and there": sprinkled(1e300, 0.01), "infinite here and there": sprinkled(np.inf, 0.01),
    "letters that are not UTF-8": bytes_of(lambda x: b"d\xe9placement \xff\n" + x),
    "a cell too many": bytes_of(lambda x: x.replace(b"\n", b"\n1,", 3)),
    "commas for points": bytes_of(lambda x: x.replace(b".", b",")),
    "milliseconds that are called seconds": with_column(0, lambda x: f"{1e3*float(x):.8g}"),
    "words as numbers": bytes_of(lambda x: x.replace(b"0.0", b"zero")), "quotes about numbers": with_column(1, lambda x: f'"{x}"'),
    "a word in a column of numbers": with_column(1, lambda x: "contact" if float(x) > 0.01 else x),
    "complex times": with_column(0, lambda x: f"({x}+0j)"), "imaginary numbers": with_column(1, lambda x: f"{x}i"),
    "booleans": with_column(1, lambda x: str(float(x) > 0)), "hexadecimal": with_column(1, lambda x: float(x).hex()),
    "dates for times": with_column(0, lambda x: "2006-05-31T10:22:05"),
}

# A line above the names is a remark, whatever its length and letters. The unit of the time follows from the length of the
# file, whatever it states.
HARMLESS = {"huge names", "letters that are not UTF-8", "milliseconds that are called seconds", "quotes about numbers"}
