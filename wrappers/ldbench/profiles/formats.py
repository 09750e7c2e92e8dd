"""Files of wheel and rail profiles as points: what the file says, in the file's unit and coordinates.

The contents tell the format, then the ending of the name. Sources of the formats:

- MiniProf: Greenwood Engineering, "MiniProf for Windows, Technical Reference", 2008 (keys, `ColumnDef`, offsets); GENSYS,
  "Users Manual for Program CONV_MINIPROF2KPF_WHEEL" (the old style: the first empty line ends the heading).
- SIMPACK `.prw`, `.prr`, CONTACT `.slcs`, `.slcw`, VAMPIRE `.whe`, `.rai`: E. Vollebregt, "User guide for CONTACT", section on
  profile files, and the published readers of CONTACT (read_simpack, read_slices, read_vampire; Vtech CMCC, 2008 to 2023).
- GENSYS `.wheel`, `.rail`: "Users Manual for Program KPF", sections on wheel and rail profile input data.
"""
from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from .._core.errors import Error
from .._core.files import read_text
from ..constants import MM, TAPE_CIRCLE

LEAST_SHARE = 0.9       # of the points that a file announces
LARGEST = 1e4           # coordinate, in any unit
ENDINGS = {".whl": "wheel", ".prw": "wheel", ".slcw": "wheel", ".whe": "wheel", ".wheel": "wheel",
           ".ban": "rail", ".prr": "rail", ".slcs": "rail", ".rai": "rail", ".rail": "rail"}
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4, "inches": 25.4}      # [mm]
SIMPACK = {"shift.y", "shift.z", "mirror.y", "mirror.z", "bound.y.min", "bound.z.min", "bound.y.max", "bound.z.max", "rotate",
           "units.len.f", "type"}
# Lines that the program writes into its own files.
HIDDEN, SCALE, REMARK = "# gauge side behind the first point, down to [mm]:", "# scale 1:", "# remark on "
MOST = 0.9              # share of numbers that tell the step to which all are rounded
NUMBER = re.compile(r"[+-]?(?:\d+\.?(\d*)|\.(\d+))(?:[eEdD]([+-]?\d+))?", re.ASCII)
COMMA_NUMBER = re.compile(r"[+-]?\d*(?:,\d+)?(?:[eEdD][+-]?\d+)?", re.ASCII)
NAMED = re.compile(r"(x|y|z|lateral|vertical|height)(?:[ _-]?(?:mm|cm|m|in|inch))?")
WORDS = re.compile(r"(?!nan|inf)[a-z\"'(]|\[[^\[\]]+\]\s*$", re.IGNORECASE | re.ASCII)
MINIPROF = re.compile(r"miniprof|#mini(wheel|rail)prof|\[fileinfo\]")
BRACKETS = re.compile(r"[\[(]\s*(mm|cm|m|in|inch|inches)\s*[\])]", re.IGNORECASE)

Line = tuple[int, str, str]             # number, text without comments, text
Row = tuple[int, list[str], str]        # number, fields, text


@dataclass(frozen=True)
class Raw:
    """What a profile file says."""
    points: np.ndarray      # (n, 2): y, z in the file's unit, in the order of the file, the format's own shifts applied
    lines: np.ndarray       # (n,) line of each point in the file, from 1
    format: str             # 'plain', 'MiniProf', 'SIMPACK', 'CONTACT', 'VAMPIRE', 'GENSYS', 'array'
    kind: str = ""          # 'wheel', 'rail', or '' where neither contents nor ending of the name say it
    unit: float = 0.0       # millimetres per unit of the file; 0 where the file does not say it
    back: float | None = None   # y of the wheel's back in the file's coordinates and unit, where the format's convention tells it
    quantum: float = 0.0    # step to which coordinates are rounded in the file, file's unit; 0 unknown
    notes: list[str] = field(default_factory=list)
    hidden: float = 0.0     # of a rail that the program wrote: depth below the top to which it goes on behind its first point [mm]
    scale: float = 0.0      # of a file that the program wrote, 5 for 1:5; 0 where the file does not say it
    remarks: dict[str, str] = field(default_factory=dict)   # of a file that the program wrote, by measure
    taken: str = ""         # the text after '# taken: ' of a file that the program itself wrote


def read_file(path: str | os.PathLike[str], slice: int | None = None) -> Raw:
    """Read the points of a file.

    `slice`, from 1, asks for one profile of a file that has several: a slice of CONTACT's, a section of MiniProf's, the left (1)
    or right (2) side of VAMPIRE's. Raises Error, with file and line, for what is not the format.
    """
    name, suffix = os.fspath(path), Path(path).suffix.lower()
    lines = read_text(Path(name)).split("\n")
    first = [line.strip().lower().split(" ")[0] for line in lines]
    vampire = next((word for word in first if word), "") in ("wheelprofile", "railprofile")
    if suffix in (".slcs", ".slcw"):
        raw = _slices(name, lines, slice, suffix)
    elif {"header.begin", "spline.begin", "point.begin"} & set(first):
        raw = _simpack(name, lines)
    elif vampire or suffix in (".whe", ".rai"):
        raw = _vampire(name, lines, slice)
    else:
        raw = _Columns(name, lines, slice, suffix).read()
    if slice not in (None, 1) and not raw.format.startswith(("CONTACT", "VAMPIRE", "MiniProf")):
        raise Error(file=name, expected=f"several profiles, of which one is number {slice}", found="one",
                    advice="leave slice out")
    if not len(raw.points):
        shown = " / ".join(_clip(line) for line in lines[:3] if line.strip()) or "nothing"
        raise Error(file=name, expected="at least 10 points", found="0",
                    advice=f"rows of y and z are looked for, the file begins with {shown}")
    taken = next((line[9:].strip() for line in lines if line.startswith("# taken: ")), "")
    kind = raw.kind or ENDINGS.get(suffix, "")
    if taken and not kind:          # the program begins its files with the kind
        kind = next((word for word in ("wheel", "rail") if lines[0].startswith(f"# {word} ")), "")
    raw = replace(raw, kind=kind, back=None if kind == "rail" else raw.back, taken=taken)
    if not taken:
        return raw
    return replace(raw, hidden=_after(lines, HIDDEN, 0.0), scale=_after(lines, SCALE, 1.0), remarks=remarks_of(lines))


def _after(lines: list[str], mark: str, default: float) -> float:
    """The number behind a mark that the program writes."""
    return next((_value(line[len(mark):].strip()) for line in lines if line.startswith(mark)), default)


def remarks_of(lines: Iterable[str]) -> dict[str, str]:
    """Remarks on measures that the program wrote into a file, by measure."""
    pairs = (line[len(REMARK):].strip().partition(": ") for line in lines if line.startswith(REMARK))
    return {name: words for name, _, words in pairs}


def told_by(path: str | os.PathLike[str]) -> tuple[float, dict[str, str]]:
    """The scale of a profile, 5 for 1:5, and the remarks on its measures, as a file of the program tells them."""
    lines = [line for line in read_text(Path(path)).split("\n") if line.startswith("#")]
    return _after(lines, SCALE, 1.0), remarks_of(lines)


def of_array(points: object) -> Raw:
    """Take points in millimetres, of shape (n, 2) or (2, n), y and z. Raises Error for other shapes and for numbers that are not
    finite."""
    try:
        array = np.array(points, dtype=float)
    except (TypeError, ValueError) as error:
        raise Error(place="points", expected="numbers of shape (n, 2), y and z in mm", found=error) from None
    array = array.T if array.ndim == 2 and array.shape[1] != 2 else array
    if array.ndim != 2 or array.shape[1] != 2:
        raise Error(place="points", expected="numbers of shape (n, 2), y and z in mm", found=array.shape)
    bad = ~(np.abs(array) <= LARGEST).all(axis=1)
    if bad.any():
        raise Error(place=f"points, line {bad.argmax() + 1}", expected="millimetres", found=array[bad.argmax()])
    return Raw(array, np.arange(1, len(array) + 1), "array", unit=1.0)


# ---- lines and numbers ---------------------------------------------------------------
def _clip(text: str) -> str:
    """A text in quotes, cut to 60 characters."""
    text = text.strip()
    return f'"{text if len(text) <= 60 else text[:57] + "..."}"'


def _refuse(name: str, line: int, expected: str, found: str, advice: str = "correct or delete the line") -> Error:
    return Error(file=name, line=line, expected=expected, found=_clip(found), advice=advice)


def _value(word: str) -> float:
    """A number as Fortran or C writes it; NaN where the word is none."""
    return float(word.replace("d", "e").replace("D", "e")) if NUMBER.fullmatch(word) else np.nan


def _fields(row: str) -> list[str]:
    """Fields between blanks, commas or semicolons; '?' stands for an empty one."""
    if "," in row or ";" in row:
        row = re.sub(r"(^|[,;])\s*(?=[,;])", r"\1 ? ", row).replace(",", " ").replace(";", " ")
    return row.split()


def _quantum(words: list[str]) -> float:
    """Step to which most numbers are rounded: that of the largest where they have exponents, else that of nearly all by their
    length, or the largest step of which nearly all are multiples; 0 where it is beyond double precision."""
    places, powers = [], []
    for word in words:
        if found := NUMBER.fullmatch(word):
            digits = len(found[1] or found[2] or "")
            if found[3] is None:
                places.append(digits)
            elif _value(word) != 0:
                powers.append(digits - int(found[3]))
    decimals = min(powers) if powers else sorted(places)[int(MOST*(len(places) - 1))] if places else 99
    values = np.array([_value(word) for word in words])
    if not 0 <= decimals <= 12 or np.abs(values).max(initial=0)*10.0**decimals > 2**53:
        return 0.0
    near = np.rint(values*10.0**decimals)
    whole = near[np.abs(values*10.0**decimals - near) < 1e-3].astype(np.int64)      # without those of more decimals
    # Few numbers with more digits than the others do not tell the step; halves and quarters of an inch are steps, too.
    while (multiples := whole % 10 == 0).mean() >= MOST and whole[multiples].any():
        whole, decimals = whole[multiples]//10, decimals - 1
    return float(f"{int(np.gcd.reduce(whole))}e{-decimals}")


def _take(name: str, rows: list[Row], columns: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Points, their lines and their words from rows of fields. Raises Error at the first row that has no two numbers there."""
    points, words = np.empty((len(rows), 2)), []
    for i, (line, fields, text) in enumerate(rows):
        pair = [fields[k] if k < len(fields) else "" for k in columns]
        points[i] = [_value(word) for word in pair]
        if not np.isfinite(points[i]).all():
            raise _refuse(name, line, "two numbers, y and z", text)
        words += pair
    if (large := (np.abs(points) > LARGEST).any(axis=1)).any():
        line, _, text = rows[large.argmax()]
        raise _refuse(name, line, "millimetres", text, "no coordinate may exceed 10000")
    return points, np.array([line for line, _, _ in rows], int), words


# ---- plain columns and MiniProf ------------------------------------------------------
class _Columns:
    """Rows of numbers below a heading: plain, MiniProf, GENSYS.

    A wheel of GENSYS has y = 0 on the running circle, 70 mm from the wheel's inside, y towards the centre of the track and z
    down, in mm (manual of KPF). A wheel of MiniProf has the origin that its alignment gave it.
    """

    def __init__(self, name: str, lines: list[str], number: int | None, suffix: str) -> None:
        self.name, self.lines, self.number, self.suffix = name, lines, number, suffix
        self.format = "GENSYS" if suffix in (".wheel", ".rail") else "MiniProf" if suffix == ".mpt" else "plain"
        self.kind = ""
        self.columns: tuple[int, int] | None = None
        self.offset = [0.0, 0.0]
        self.announced = -1
        self.names: list[list[str]] = []        # candidates for names of columns
        self.units: set[float] = set()
        self.notes: list[str] = []

    def read(self) -> Raw:
        sections = self._sections(self._heading())
        if not 0 < (self.number or len(sections) < 2) <= max(1, len(sections)):
            raise Error(file=self.name, expected="one profile", found=f"{len(sections)} sections with points",
                        advice=f"ask for one with slice=1 to {len(sections)}")
        if not sections:
            return Raw(np.empty((0, 2)), np.empty(0, int), self.format)
        rows = [(line, _fields(row), text) for line, row, text in self._decimal_commas(sections[(self.number or 1) - 1])]
        points, lines, words = _take(self.name, rows, self.columns or self._named(rows) or self._after_index(rows))
        if len(points) > 10 and points[-1, 0] == points[-1, 1] in range(len(points) - 1, len(points) + 2):
            self.notes.append(f"line {lines[-1]}, {points[-1, 0]:g} {points[-1, 1]:g}, is a count of points: dropped")
            points, lines, words = points[:-1], lines[:-1], words[:-2]
        if len(points) < LEAST_SHARE*self.announced:
            raise Error(file=self.name, expected=f"{self.announced} points", found=len(points),
                        advice="the file is incomplete")
        if self.announced >= 0 and self.announced != len(points):
            self.notes.append(f"{len(points)} points of the {self.announced} announced")
        gensys = self.format == "GENSYS"
        unit = self.units.pop() if len(self.units) == 1 else 1.0 if gensys else 0.0
        return Raw(points + self.offset, lines, self.format, self.kind, unit,
                   MM*TAPE_CIRCLE/unit if gensys and self.suffix == ".wheel" else None, _quantum(words), self.notes)

    def _heading(self) -> int:
        """Take what the heading says; returns the number of its lines. An old heading of MiniProf may hold numbers, and ends with
        a blank line."""
        start = 0
        for i, line in enumerate(self.lines):
            word = line.strip().lower()
            if found := MINIPROF.match(word):
                self.format, self.kind = "MiniProf", found[1] or self.kind
                start = max(start, self._blank(i))
            elif i == 0 and self.suffix in (".whl", ".ban") and WORDS.match(word) and self._blank(i):
                self.format, start = "MiniProf", self._blank(i)
            key, equals, value = line.partition("=")
            if equals and self._key(i + 1, key.strip().lower(), value.strip()):
                self.format = "MiniProf"
            if i < start or not word:
                continue
            row = re.split("[#!%]", line, maxsplit=1)[0].strip()
            if (row and not WORDS.match(row)) or (row[:1] == '"' and re.match(r'["\s]*[+\-.,\d]+"', row)):
                return i
            self._name(row or word.lstrip("#!% "), bool(row))
        return len(self.lines)

    def _blank(self, i: int) -> int:
        """Number of the first blank line after line i that numbers follow; 0 where there is none."""
        return next((k for k in range(i + 1, len(self.lines) - 1)
                     if not self.lines[k].strip() and re.match(r"\s*[+\-.\d]", self.lines[k + 1])), 0)

    def _key(self, line: int, key: str, value: str) -> bool:
        """Take the value of a key of MiniProf; False for other keys."""
        if key == "columndef":
            names = [name.strip().upper() for name in value.split(",")]
            if not {"X", "Y"} <= set(names):
                raise _refuse(self.name, line, "columns X and Y", value, "ColumnDef names the columns, as in ColumnDef=X,Y,A,C")
            self.columns = names.index("X"), names.index("Y")
        elif key in ("xoffset", "yoffset", "xypoints"):
            number = _value(value.replace(",", "."))
            if value and not (abs(number) < LARGEST and (key != "xypoints" or number > 0)):
                raise _refuse(self.name, line, f"a number after {key}=", value)
            if value and key == "xypoints":
                self.announced = round(number)
            elif value:
                self.offset[key == "yoffset"] = number
        return key in ("columndef", "xoffset", "yoffset", "xypoints") or (key == "programname" and "MiniProf" in value)

    def _name(self, row: str, heading: bool) -> None:
        """Take a line of heading, or a comment above the points, for the names and units of the columns."""
        self.units |= {UNITS[unit.lower()] for unit in BRACKETS.findall(row)}
        bare = BRACKETS.sub(" ", row).replace('"', " ").lower()
        names = [name.strip() for name in (re.split("[,;\t]", bare) if re.search("[,;\t]", bare) else bare.split())]
        self.names.append(names if heading or all(len(name) < 9 for name in names) else [])

    def _sections(self, start: int) -> list[list[Line]]:
        """Rows without comments, section by section of those that have rows."""
        sections: list[list[Line]] = [[]]
        inside = self.format == "MiniProf" and start > 0 and any(re.match(r"\s*\[.+\]\s*$", line) for line in self.lines[:start])
        for i, line in enumerate(self.lines[start:], start + 1):
            row = re.split("[#!%]", line, maxsplit=1)[0]
            if inside and re.match(r"\s*\[[^\[\]]+\]\s*$", row):
                sections.append([])
            elif row.strip() and not (inside and "=" in row) and not (self.format == "MiniProf" and row.lstrip()[0] == '"'):
                if row.count('"') % 2 == 0:
                    row = row.replace('","', ";").replace('";"', ";").replace('"', " ")
                sections[-1].append((i, row, line))
        return [rows for rows in sections if rows]

    def _decimal_commas(self, rows: list[Line]) -> list[Line]:
        """Rows with points in place of decimal commas, where all rows have two numbers with such commas and none has a point."""
        if not any("," in row for _, row, _ in rows) or any("." in row for _, row, _ in rows):
            return rows
        words = [re.split(r"[;\s]+", row.strip(" \t;")) for _, row, _ in rows]
        if all(len(row) > 1 and all(word and COMMA_NUMBER.fullmatch(word) for word in row[:2]) for row in words):
            self.notes.append("decimal commas")
            return [(line, row.replace(",", "."), text) for line, row, text in rows]
        if all(row.count(",") > 2 and ";" not in row for _, row, _ in rows):
            raise _refuse(self.name, rows[0][0], "one comma between two numbers", rows[0][2],
                          "commas stand both for decimals and between numbers; write semicolons between numbers")
        return rows

    def _named(self, rows: list[Row]) -> tuple[int, int] | None:
        """Columns that the heading names: y and z, else x and y, else x and z."""
        for names in reversed(self.names):
            found = {{"lateral": "y", "vertical": "z", "height": "z"}.get(match[1], match[1]): k
                     for k, name in enumerate(names) if (match := NAMED.fullmatch(name))}
            pair = next((pair for pair in ("yz", "xy", "xz") if set(pair) <= set(found)), "")
            if pair and max(found[pair[0]], found[pair[1]]) < len(rows[0][1]):
                columns = found[pair[0]], found[pair[1]]
                if columns != (0, 1):
                    self.notes.append(f"columns {columns[0] + 1} and {columns[1] + 1}, {pair[0]} and {pair[1]} of the heading")
                return columns
        return None

    def _after_index(self, rows: list[Row]) -> tuple[int, int]:
        """Columns 1 and 2, or 2 and 3 where the first counts the rows. y itself counts millimetres in some files: it then has
        fewer than 200 rows and stands beside a z that goes up and down."""
        if len(rows) > 2 and all(len(fields) > 2 and re.fullmatch(r"\d{1,9}", fields[0], re.ASCII) and "." in fields[1]
                                 for _, fields, _ in rows):
            steps = np.diff([int(fields[0]) for _, fields, _ in rows])
            ways = np.sign(np.diff([_value(fields[1]) for _, fields, _ in rows]))
            if (steps == 1).all() and (len(rows) > 200 or abs(ways.sum()) >= 0.8*np.abs(ways).sum() > 0):
                self.notes.append("first column, a count, skipped")
                return 1, 2
        return 0, 1


# ---- SIMPACK, VAMPIRE, slices --------------------------------------------------------
def _simpack(name: str, lines: list[str]) -> Raw:
    """Read SIMPACK's sections header, spline and in it point, with rows of y, z and a weight.

    Shifts are added, then points outside the bounds dropped, then mirrors applied. A wheel has y = 0 on the tape circle, 70 mm
    from its back. `rotate` is refused: its unit varies. A file without units.len.f is in m where it is narrower than 1, else mm.
    """
    section, rows, values = "", [], dict.fromkeys((f"{what}.{axis}" for what in ("shift", "mirror") for axis in "yz"), 0.0)
    for i, line in enumerate(lines, 1):
        row = re.split("[!#%]", line, maxsplit=1)[0].strip()
        word = row.lower().split()[0] if row else ""
        if word.endswith(".begin"):
            if section != ("spline" if word == "point.begin" else ""):
                raise _refuse(name, i, "the sections header, spline and in it point, one after the other", word)
            section = word[:-6]
        elif word.endswith(".end"):
            if word != f"{section}.end":
                raise _refuse(name, i, "the end of the section that is open", word)
            section = "spline" if word == "point.end" else ""
            if word == "spline.end":
                break
        elif row and section == "point":
            rows.append((i, _fields(row), line))
        elif section and "=" in row:
            key, _, text = row.partition("=")
            key = key.strip().lower()
            if key in SIMPACK and (key == "type") == (section == "header"):
                values[key] = _simpack_value(name, i, key, text.strip())
    if section == "point":
        raise Error(file=name, expected="point.end", found="the end of the file", advice="the file is incomplete")
    points, numbers, words = _take(name, rows, (0, 1))
    points += [values["shift.y"], values["shift.z"]]
    keep = np.array([not len(fields) > 2 or not _value(fields[2]) <= 0 for _, fields, _ in rows], bool)
    for k, axis in enumerate("yz"):
        low, high = values.get(f"bound.{axis}.min", 1), values.get(f"bound.{axis}.max", 0)
        keep &= (low >= high) | ((points[:, k] >= low) & (points[:, k] <= high))
    notes = [f"{n} outside the bounds or without weight dropped"] if (n := int((~keep).sum())) else []
    points = points[keep]*[-1 if values[f"mirror.{axis}"] > 0 else 1 for axis in "yz"]
    unit = 1e3/values["units.len.f"] if "units.len.f" in values else 0.0
    if not unit and len(points):
        unit = 1e3 if np.ptp(points[:, 0]) < 1 else 1.0
        notes.append(f"without units.len.f, in {'m' if unit > 1 else 'mm'} by the width")
    return Raw(points, numbers[keep], "SIMPACK", {0: "rail", 1: "wheel"}.get(int(values.get("type", 2)), ""), unit,
               -MM*TAPE_CIRCLE/unit if unit else None, _quantum(words), notes)


def _simpack_value(name: str, line: int, key: str, text: str) -> float:
    """The value of a key of SIMPACK. Raises Error for what is no number or has no meaning here."""
    number = _value(text)
    if not abs(number) < 1e9:
        raise _refuse(name, line, f"a number for {key}", text)
    if key == "rotate" and number != 0:
        raise _refuse(name, line, "rotate = 0", text, "export the profile unturned")
    if key == "units.len.f" and number <= 0:
        raise _refuse(name, line, "units.len.f above 0", text, "1000 stands for mm")
    if key == "type" and number not in (0, 1):
        raise _refuse(name, line, "type 0, a rail, or 1, a wheel", text)
    return number


def _vampire(name: str, lines: list[str], side: int | None) -> Raw:
    """Read `WHEELPROFILE` or `RAILPROFILE` of VAMPIRE: a title, the datum, `FLANGEBACK` (distance between the backs) or `GAUGE`
    [mm], then rows of y, z of the left and y, z of the right side. y counts from the centre of the track; the left side is
    mirrored, so that y grows to the field side. Backs are half of FLANGEBACK from the centre."""
    given = [(i, line) for i, line in enumerate(lines, 1) if line.strip()]
    kind = {"wheelprofile": "wheel", "railprofile": "rail"}.get(given[0][1].strip().lower() if given else "", "")
    wanted = [("TREADDATUM", "FLANGEBACK"), ("GAUGEPOINT", "GAUGE")][kind == "rail"]
    heads = [line.strip().upper().split() for _, line in given[2:4]]
    if not kind or [head[0] for head in heads] != list(wanted) or len(heads[1]) < 2 or not _value(heads[1][1]) > 0:
        shown = " / ".join(_clip(line) for _, line in given[:4]) or "nothing"
        raise Error(file=name,
                    expected=f"WHEELPROFILE or RAILPROFILE, a title, {' '.join(wanted)} and a number, each on its line",
                    found=shown, advice="correct the heading, or rename a file that is not of VAMPIRE")
    rows = [(i, _fields(re.split('["!%]', line, maxsplit=1)[0]), line) for i, line in given[4:]]
    rows = [row for row in rows if row[1]]
    points, numbers, words = _take(name, rows, (0, 1))
    both = bool(rows) and len(rows[0][1]) > 3
    points *= [-1 if both or points[:, 0].mean() < 0 else 1, 1]
    if side not in (None, 1, 2) or (side == 2 and not both):
        raise Error(file=name, expected=f"slice=1, left{', or 2, right' if both else ''}", found=f"slice={side}")
    if both:
        right, _, right_words = _take(name, rows, (2, 3))
        if side is None and (apart := np.abs(points - right).max()) >= 1e-6:
            raise Error(file=name, expected="two sides alike", found=f"sides up to {apart:.3g} mm apart",
                        advice="ask for the left with slice=1, the right with slice=2")
        points, words = (right, right_words) if side == 2 else (points, words)
    notes = [f"{'right' if side == 2 else 'left'} side"] if both else []
    return Raw(points, numbers, "VAMPIRE", kind, 1.0, _value(heads[1][1])/2 if kind == "wheel" else None, _quantum(words), notes)


def _slices(name: str, lines: list[str], number: int | None, suffix: str) -> Raw:
    """Read one slice of CONTACT's `.slcs` (rails) or `.slcw` (wheels): offset and scale of the positions, the number of slices,
    features and interpolation, then a position and a quoted file name per slice. Comments begin with %."""
    rows = [(i, row) for i, line in enumerate(lines, 1) if (row := line.split("%")[0].strip())]
    named = [(i, found) for i, row in rows if (found := re.match(r"([-+.\deE]+)[\s,]+(['\"])(.+?)\2", row))]
    scale = [_value(word) for word in _fields(rows[0][1])[:2]] if rows else []
    count = _value(_fields(rows[1][1])[0]) if len(rows) > 1 else np.nan
    if len(scale) < 2 or not np.isfinite([*scale, count]).all() or count != len(named) or not named:
        shown = " / ".join(_clip(row) for _, row in rows[:5]) or "nothing"
        raise Error(file=name,
                    expected="offset and scale, the number of slices, and as many lines of a position and a quoted file name",
                    found=f"{len(named)} names and {shown}", advice="see CONTACT's user guide")
    if (number is None and len(named) > 1) or (number is not None and not 0 < number <= len(named)):
        raise Error(file=name, expected="one profile", found=f"{len(named)} slices",
                    advice=f"ask for one with slice=1 to {len(named)}")
    line, found = named[(number or 1) - 1]
    file = Path(name).parent/found[3]
    if file.suffix.lower() in (".slcs", ".slcw"):
        raise _refuse(name, line, "the file of a profile", found[3])
    try:
        raw = read_file(file)
    except Error as error:
        raise error.within(f"{name}, line {line}") from None
    kind = ENDINGS[suffix]
    if raw.kind not in ("", kind):
        raise _refuse(name, line, f"a {kind}", f"{found[3]}, a {raw.kind}")
    place = scale[1]*(_value(found[1]) + scale[0])
    return replace(raw, format="CONTACT", kind=kind,
                   notes=[f"slice {number or 1} of {len(named)}, at {place:g}: {found[3]}, {raw.format}", *raw.notes])
