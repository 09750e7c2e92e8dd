"""Profile files as people have them: what is read, how it is placed and mended, and what is refused, with line and advice.

A file is put together of layers: what stands between numbers, heads, encodings, units, directions of axes, formats. All must give
the same points; a file with one fault must be refused in a line that names its place.
"""
from __future__ import annotations

import functools
import random
import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import shapes
from generated import covering, examples
from ldbench import Error
from ldbench.profiles.formats import Raw, of_array, read_file
from ldbench.profiles.placing import Placed, place
from ldbench.profiles.repair import check, mend
from running import REPO

WHEEL, RAIL = (np.loadtxt(REPO/"profiles"/f"{name}.yz").round(5) for name in ("s1002", "60e1"))
BOTH = {"wheel": WHEEL, "rail": RAIL}
rows, miniprof = functools.partial(shapes.rows, digits=5), functools.partial(shapes.miniprof, digits=5)
old_miniprof, simpack = functools.partial(shapes.old_miniprof, digits=5), functools.partial(shapes.simpack, digits=5)


def written(folder: Path, name: str, text: str | bytes) -> Path:
    path = folder/name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def placed(folder: Path, name: str, text: str | bytes, number: int | None = None, **how: object) -> tuple[Raw, Placed]:
    raw = read_file(written(folder, name, text), number)
    return raw, place(raw, name, **how)


def refused(folder: Path, name: str, text: str | bytes, number: int | None = None, **how: object) -> str:
    with pytest.raises(Error) as caught:
        placed(folder, name, text, number, **how)
    message = str(caught.value)
    assert name in message and "\n" not in message and "; " in message
    return message


def thickness(wheel: np.ndarray) -> float:
    """Flange thickness Sd [mm]: y of the flange's face 10 mm below the tape circle."""
    tip = wheel[:, 1].argmin()
    y, z = wheel[tip:].T
    level = np.interp(70, y, z) - 10
    k = np.argmax(z > level)
    return float(np.interp(level, z[k - 1:k + 1], y[k - 1:k + 1]))


# ---- plain columns -------------------------------------------------------------------
# What stands between two numbers, and the mark of decimals; the words of a note that it causes.
BETWEEN = {"blank": (" ", "."), "comma": (",", "."), "comma and blank": (", ", "."), "semicolon": (";", "."), "tab": ("\t", "."),
           "quotes": ('","', "."), "decimal commas": (";", ","), "decimal commas and blanks": ("  ", ","),
           "decimal commas in quotes": ('","', ",")}
# Lines above the points, and what stands beside y and z: the order of columns in a row.
HEADS = {"none": ("", "yz"), "names": ("y{0}z\n", "yz"), "X and Y": ('"X"{0}"Y"\n', "yz"), "lines": ("Profile 7\n\ny; z\n", "yz"),
         "exchanged": ("z{0}y\n", "zy"), "in a comment": ("# s y z\n", "syz"), "numbered": ("n{0}y{0}z\n", "kyz"),
         "numbers": ("", "kyz")}
UNITS = {"mm": 1.0, "in m": 1e3, "in inches": 25.4, "in cm": 10.0}
STEPS = {"mm": 1e-5, "in m": 1e-8, "in inches": 1e-9, "in cm": 1e-6}        # of the numbers in a file
PLAIN = {"kind": BOTH, "between": BETWEEN, "head": HEADS, "unit": UNITS, "told": ("no", "yes"), "turned": ("", "y", "z", "yz"),
         "order": ("forwards", "backwards"), "number": ("plain", "D"), "ends": ("\n", "\r\n", "\r"),
         "encoding": ("utf-8", "utf-8-sig", "utf-16"), "ending": (".yz", ".csv", ".txt", ".dat")}


def plain_file(form: Mapping[str, str]) -> tuple[bytes, list[str]]:
    """A file, and the notes on it."""
    points = BOTH[form["kind"]]/UNITS[form["unit"]]*[-1 if "y" in form["turned"] else 1, -1 if "z" in form["turned"] else 1]
    points = points if form["order"] == "forwards" else points[::-1]
    (between, mark), (head, columns) = BETWEEN[form["between"]], HEADS[form["head"]]
    digits = 5 if form["unit"] == "mm" else 9
    plain, quote = between.strip('"') or " ", '"' if '"' in between else ""
    number = "{:.9E}" if form["number"] == "D" and not quote else f"{{:.{digits}f}}"
    body = "".join(quote + between.join({
        "k": str(k), "s": f"{k/8}", "y": number.format(y).replace("E", "D"), "z": number.format(z).replace("E", "D")}[column]
        for column in columns).replace(".", mark) + quote + "\n" for k, (y, z) in enumerate(points, 1))
    if form["told"] == "yes":
        unit = f" [{form['unit'][3:5] or 'mm'}]"
        heading = head.replace("y", f"y{unit}").replace("z", f"z{unit}") if "y" in head else f"#{unit}\n{head}"
    else:
        heading = head
    notes = ["decimal commas"]*(mark == ",")
    if head == "" and columns == "kyz":
        notes += ["first column, a count, skipped"]
    elif columns != "yz":
        notes += [f"columns {columns.index('y') + 1} and {columns.index('z') + 1}, y and z of the heading"]
    notes += [form["unit"]]*(form["unit"] != "mm" and form["told"] == "no")
    notes += [f"{' and '.join(form['turned'])} turned over"]*bool(form["turned"])
    return (heading.format(plain) + body).replace("\n", form["ends"]).encode(form["encoding"]), notes


@examples(5)
@given(covering(PLAIN))
def test_plain_columns_give_the_points(tmp_path: Path, forms: list[dict[str, str]]):
    for form in forms:
        text, notes = plain_file(form)
        raw, found = placed(tmp_path, "specimen" + form["ending"], text)
        assert found.points == pytest.approx(BOTH[form["kind"]], abs=2e-5), form
        assert (raw.format, found.kind, raw.notes + found.notes) == ("plain", form["kind"], notes), form
        assert found.origin == ("as the file has it" if found.kind == "rail" else "back of the wheel at y = 0")
        if form["number"] == "plain" or "quotes" in form["between"]:
            assert raw.quantum == pytest.approx(STEPS[form["unit"]], rel=1e-6), form
        assert np.all(np.diff(found.lines) == (1 if form["order"] == "forwards" else -1))
        mended = mend(found.points, found.lines, "specimen")
        assert mended.notes == [] and mended.group == 1 and np.array_equal(mended.points, found.points)
        check(mended.points, mended.lines, "specimen")


# ---- formats of programs -------------------------------------------------------------
def mpt(points: np.ndarray, kind: str) -> str:
    return "[FileInfo]\nProgramName=Envision\nDate=1.2.2020\n\n[Profile]\nColumnDef=X,Y\n" + rows(points, ",")


def vampire(points: np.ndarray, kind: str, right: np.ndarray | None = None) -> str:
    """Both sides; y from the centre of the track, z of a wheel down."""
    other = points if right is None else right
    head = "TREADDATUM EUROPEAN\nFLANGEBACK 1360.0" if kind == "wheel" else "GAUGEPOINT EUROPEAN\nGAUGE 1435.0"
    z = -1 if kind == "wheel" else 1
    return (f"{kind.upper()}PROFILE\n{kind} of a test\n{head}\n"
            + "".join(f"{-680 - a:.5f}, {z*b:.5f}, {680 + c:.5f}, {z*d:.5f}\n"
                      for (a, b), (c, d) in zip(points, other, strict=True)))


def gensys(points: np.ndarray, kind: str, sign: int = -1) -> str:
    return "# y z\n" + rows((points - [70 if kind == "wheel" else 0, 0])*[sign, -1], "   ")


# Format told, writer, endings of wheel and rail, a note, how the back of a wheel is told.
FORMATS: dict[str, tuple[str, Callable[[np.ndarray, str], str], tuple[str, str], str, str]] = {
    "MiniProf": ("MiniProf", miniprof, (".whl", ".ban"), "", ""),
    "old MiniProf": ("MiniProf", old_miniprof, (".txt", ".txt"), "", ""),
    "MiniProf .mpt": ("MiniProf", mpt, (".mpt", ".mpt"), "", ""),
    **{name: ("SIMPACK", write, (".prw", ".prr"), "1 outside the bounds", "tape circle at y = 0, 70 mm from the back (SIMPACK)")
       for name, write in (("SIMPACK", simpack), ("SIMPACK in m", lambda p, kind: simpack(p, kind, 1.0, digits=8)))},
    "VAMPIRE": ("VAMPIRE", vampire, (".whe", ".rai"), "left side", "back of the wheel at y = 680 mm of the file (VAMPIRE)"),
    **{name: ("GENSYS", write, (".wheel", ".rail"), "", "tape circle at y = 0, 70 mm from the back (GENSYS)") for name, write in (
        ("GENSYS", gensys), ("GENSYS, mirrored", lambda p, kind: gensys(p, kind, 1)))}}


@examples(3)
@given(covering({"format": FORMATS, "kind": BOTH, "ends": ("\n", "\r\n", "\r"), "encoding": PLAIN["encoding"]}))
def test_every_format_gives_the_points(tmp_path: Path, forms: list[dict[str, str]]):
    for form in forms:
        (told, write, endings, note, origin), kind = FORMATS[form["format"]], form["kind"]
        text = write(BOTH[kind], kind).replace("\n", form["ends"]).encode(form["encoding"])
        raw, found = placed(tmp_path, "specimen" + endings[kind == "rail"], text)
        points = found.points - ([680, 0] if told == "VAMPIRE" and kind == "rail" else 0)
        assert points == pytest.approx(BOTH[kind], abs=2e-5), form
        assert raw.format == told and found.kind == kind and raw.kind in ("", kind) and (raw.kind or told == "MiniProf"), form
        assert (raw.back is not None) == (kind == "wheel" and bool(origin))
        assert raw.quantum == pytest.approx(1e-5*(1e-3 if "in m" in form["format"] else 1), rel=1e-9)
        assert note in "; ".join(raw.notes) and len(raw.notes) == bool(note)
        assert all("turned over" in one for one in found.notes), form
        assert found.origin == ("as the file has it" if kind == "rail" else origin or "back of the wheel at y = 0")


def test_slices_of_contact_are_asked_by_number(tmp_path: Path):
    for name, points in ("a.prr", RAIL), ("b.prr", RAIL + [0, -1]):
        written(tmp_path, name, simpack(points, "rail"))
    text = ("% slices\n 0.5 1000 % S_OFFSET, S_SCALE\n 2 % NSLC\n 0 0 0 % NFEAT\n 1 % S_METHOD\n"
            " 0.0 'a.prr'\n 1.0 \"b.prr\"\n")
    raw, found = placed(tmp_path, "turnout.slcs", text, 2)
    assert found.points == pytest.approx(RAIL + [0, -1], abs=2e-5) and (raw.format, raw.kind) == ("CONTACT", "rail")
    assert raw.notes[0] == "slice 2 of 2, at 1500: b.prr, SIMPACK"
    assert "found 2 slices; ask for one with slice=1 to 2" in refused(tmp_path, "turnout.slcs", text)
    assert "slice=1 to 2" in refused(tmp_path, "turnout.slcs", text, 3)
    assert "expected a wheel, found" in refused(tmp_path, "turnout.slcw", text, 1)
    with pytest.raises(Error, match=r"turnout.slcs, line 7: .*none.prr: cannot be opened for reading"):
        read_file(written(tmp_path, "turnout.slcs", text.replace("b.prr", "none.prr")), 2)
    assert "expected offset and scale" in refused(tmp_path, "turnout.slcs", text.replace(" 2 %", " 3 %"), 1)


def test_sides_and_sections_are_asked_by_number(tmp_path: Path):
    right = shapes.bump(WHEEL, 70, 20, 1.0)
    for number, points in (1, WHEEL), (2, right):
        raw, found = placed(tmp_path, "worn.whe", vampire(WHEEL, "wheel", right), number)
        assert found.points == pytest.approx(points, abs=2e-5) and raw.notes == [["left side"], ["right side"]][number - 1]
    assert "slice=1, the right with slice=2" in refused(tmp_path, "worn.whe", vampire(WHEEL, "wheel", right))
    two = mpt(RAIL, "rail") + "[Other]\nDate=1\n" + rows(RAIL + [0, 3], ",")
    assert placed(tmp_path, "two.mpt", two, 2)[1].points == pytest.approx(RAIL + [0, 3], abs=2e-5)
    assert "found 2 sections with points; ask for one" in refused(tmp_path, "two.mpt", two)
    assert "leave slice out" in refused(tmp_path, "one.prw", simpack(WHEEL, "wheel"), 2)


# ---- places --------------------------------------------------------------------------
def test_what_is_said_of_unit_and_axes_must_fit(tmp_path: Path):
    """A wheel 13.5 mm wide is a model where its file says mm."""
    for kind, points in BOTH.items():
        _, found = placed(tmp_path, "file.txt", rows(points/10, digits=9), unit="mm")
        assert found.scale == 10 and found.notes == ["scale 1:10, by the size"]
        for unit in 25.4, 1e3:
            assert "unit" in refused(tmp_path, "file.txt", rows(points/unit, digits=9), unit="mm")
        for flip, sign in ("z", 1), ("none", -1):
            with pytest.raises(Error, match=f"found the {kind} upside down with flip={flip}; "):
                place(of_array(points*[1, sign]), "array", flip=flip)
    assert place(of_array(RAIL*[-1, 1]), "array", flip="none").points == pytest.approx((RAIL*[-1, 1])[::-1])


@examples(12)
@given(st.sampled_from([-70.0, -69.95, 33.0, -66.5, 400.0]) | st.floats(4, 300), st.sampled_from([0.0, 0.01]), st.integers(0, 99))
def test_a_back_is_told_by_its_face(shift: float, noise: float, seed: int):
    found = place(of_array(shapes.noisy(shapes.with_faces(WHEEL), noise, seed) + [shift, 0]), "array")
    if abs(shift + 70) < 0.1:
        assert found.origin == "tape circle at y = 0, 70 mm from the back"
        assert thickness(found.points) == pytest.approx(102.5 + shift, abs=0.001 + 5*noise)
        return
    assert thickness(found.points) == pytest.approx(32.5, abs=0.01 + 5*noise)
    told = re.fullmatch(r"back of the wheel at y = (\S+) mm of the file", found.origin)
    assert told and float(told[1]) == pytest.approx(shift, abs=0.001 + 5*noise)
    assert found.notes == ["faces beyond the running surface left out"]


def test_a_back_without_a_face_is_asked_for():
    bare = WHEEL[WHEEL[:, 0] > 6] + [33, 0]
    with pytest.raises(Error, match=r"expected y = 0 on the tread.*; give wheel_back=.*\(the flange ends at 39\.\d+ mm\)"):
        place(of_array(bare), "array")
    assert thickness(place(of_array(bare), "array", wheel_back=33.0).points) == pytest.approx(32.5, abs=0.005)
    assert thickness(place(of_array(-bare), "array", wheel_back=-33.0).points) == pytest.approx(32.5, abs=0.005)
    for wrong in 300.0, -33.0, 43.0:
        with pytest.raises(Error, match="correct wheel_back"):
            place(of_array(bare), "array", wheel_back=wrong)


# ---- faults --------------------------------------------------------------------------
# A line among the points, and what is expected in its place.
SPOILT = {"12.5 high": "two numbers, y and z, found \"12.5 high\"", "12.5 1e7": "millimetres", **dict.fromkeys((
    "12.5", "NaN 1", "1e999 1", ",1.0", "\0"*40, "["*20000, "12.5 0x10", "12.5 1_0", "12.5 ١", "-"), "two numbers")}


@examples(24)
@given(st.sampled_from(sorted(SPOILT)), st.integers(0, 400), st.sampled_from(sorted(BOTH)), st.sampled_from([" ", ", ", ";", "\t"]))
def test_a_spoilt_line_is_named(tmp_path: Path, line: str, k: int, kind: str, between: str):
    lines = rows(BOTH[kind], between).splitlines()
    text = "\n".join([*lines[:k], line, *lines[k:]]) + "\n"
    assert f"line {k + 1}: expected {SPOILT[line]}" in refused(tmp_path, "a.csv", text)


FLAT = np.column_stack([np.linspace(0, 135, 21), 0.01*np.sin(np.arange(21))])
REFUSED: dict[str, tuple[str, str | bytes, str]] = {
    "empty": ("a.yz", b"", "expected at least 10 points, found 0"),
    "comments": ("a.yz", "# 1 2\n", "the file begins with \"# 1 2\""),
    "words": ("a.yz", "y z\nmm mm\n", "expected at least 10 points, found 0"),
    "nine points": ("a.yz", rows(WHEEL[::72]), "expected at least 10 points, found 9"),
    "binary": ("a.yz", random.Random(1).randbytes(20000), "expected two numbers"),
    "commas for both": ("a.csv", rows(WHEEL, ",").replace(".", ","), "write semicolons between numbers"),
    "hardly a flange": ("a.yz", rows(FLAT), "the shape of neither"),
    "a wide flange": ("a.yz", rows(WHEEL*[1, 6.4]), "expected a flange 15 to 45 mm high, found 12"),
    "a low flange": ("a.yz", rows(WHEEL*[1, 0.5]), "expected a flange 15 to 45 mm high, found 1"),
    "a narrow wheel": ("a.yz", rows(WHEEL[WHEEL[:, 0] < 76]), "found a width of 7"),
    "a wide rail": ("a.ban", rows(RAIL*[1.7, 1]), "over 50 to 110 mm of a rail's head, found a width of 1"),
    "one point": ("a.yz", "1 1\n"*12, "expected y in millimetres over 80 to 200 mm"),
    "vertical": ("a.yz", rows(WHEEL*[0, 1]), "expected y in millimetres over 80 to 200 mm"),
    "half a SIMPACK": ("a.prw", simpack(WHEEL, "wheel").split("  point.end")[0], "expected point.end, found the end of the file"),
    "points without a spline": ("a.prw", "point.begin\n1 2\npoint.end\n", "line 1: expected the sections header, spline"),
    "another .rai": ("a.rai", rows(RAIL), "rename a file that is not of VAMPIRE"),
    **{name: (file, write(WHEEL, "wheel").replace(*change), words) for name, file, write, change, words in (
        ("turned SIMPACK", "a.prw", simpack, ("rotate = 0.0", "rotate = 0.1"), "line 10: expected rotate = 0, found"),
        ("no unit", "a.prw", simpack, ("len.f = 1000", "len.f = 0"), "expected units.len.f above 0"),
        ("type", "a.prw", simpack, ("type = 1", "type = 0, 9"), "found \"0, 9\""),
        ("columns of MiniProf", "a.whl", miniprof, ("X,Y,A,C", "A,C"), "line 6: expected columns X and Y"),
        ("offset of MiniProf", "a.whl", miniprof, ("XOffset=1.5", "XOffset=x"), "line 4: expected a number after xoffset="),
        ("a third of MiniProf", "a.whl", miniprof, ("XYPoints=615", "XYPoints=1845"), "expected 1845 points, found 615"),
        ("VAMPIRE without datum", "a.whe", vampire, ("TREADDATUM EUROPEAN\n", ""), "expected WHEELPROFILE or"))}}


@pytest.mark.parametrize("broken", REFUSED)
def test_broken_file_is_refused(broken: str, tmp_path: Path):
    name, text, words = REFUSED[broken]
    assert words in refused(tmp_path, name, text)


@examples(8)
@given(st.integers(10, 80), st.permutations([100, 170, 300, 340, 400, 470, 520]))
def test_mending_says_what_it_did(every: int, at: list[int]):
    """Points that stand twice, two that are exchanged, and one that is off the curve."""
    assume(all(k % every not in (4, 5, 6) for k in at[:2]))
    points = np.repeat(WHEEL, 1 + (np.arange(615) % every == 5), axis=0)
    twice = len(points) - 615
    exchanged, off = (int(np.flatnonzero((points == WHEEL[k]).all(axis=1))[-1]) for k in at[:2])
    points[[exchanged, exchanged + 1]] = points[[exchanged + 1, exchanged]]
    points[off] += shapes.normals(WHEEL)[at[1]]
    found = mend(points, np.arange(1, len(points) + 1), "file")
    assert found.notes[0] == f"{twice} repeated dropped" and found.group == 1
    assert re.fullmatch(rf"1 off the curve by up to (0\.9\d*|1(\.0\d*)?) mm dropped, line {off + 1}", found.notes[1])
    assert re.fullmatch(r"2 that doubled back moved by up to 0\.2[45]\d* mm", found.notes[2]) and len(found.notes) == 3
    assert len(found.points) == len(found.lines) == 614 and np.isin(found.points, WHEEL).all()
    check(found.points, found.lines, "file")


@examples(8)
@given(st.integers(20, 400), st.integers(30, 180), st.sampled_from(sorted(BOTH)))
def test_points_out_of_order_are_refused_with_their_line(start: int, count: int, kind: str):
    """Points that go back and forth again; more than a tenth of them off the curve, a crossing or a turn is told."""
    points = BOTH[kind].copy()
    points[start:start + count] = points[start:start + count][::-1]
    with pytest.raises(Error, match=r"points, line \d+: expected .*; look whether the points are in order") as caught:
        found = mend(points, np.arange(1, len(points) + 1), "points")
        check(found.points, found.lines, "points")
    line = int(re.search(r"line (\d+)", str(caught.value))[1])
    assert min(abs(line - start), abs(line - start - count)) < 5, str(caught.value)


@examples(8)
@given(st.integers(60, 540))
def test_a_point_that_turns_back_is_refused_with_its_line(k: int):
    points = np.insert(WHEEL, k + 1, WHEEL[k - 3] + 0.3*shapes.normals(WHEEL)[k - 3], axis=0)
    with pytest.raises(Error, match=f"points, line {k + 1}: expected a curve that turns by at most 120 degrees.*, found 1"):
        check(points, np.arange(1, len(points) + 1), "points")
