"""Profile files as people have them: what is read, how it is placed and mended, and what is refused, with line and advice."""
import functools
import random
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import shapes
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


def gensys(points: np.ndarray, kind: str) -> str:
    return "# y z\n" + rows((points - [70 if kind == "wheel" else 0, 0])*[-1, -1], "   ")


FORMATS: dict[str, tuple[str, Callable[[np.ndarray, str], str | bytes], tuple[str, str], str]] = {
    # format told, writer, endings of wheel and rail, a note
    "blanks": ("plain", lambda p, _: rows(p), (".yz", ".yz"), ""),
    "comma": ("plain", lambda p, _: rows(p, ", "), (".csv", ".csv"), ""),
    "semicolon": ("plain", lambda p, _: "y;z\n" + rows(p, ";"), (".csv", ".csv"), ""),
    "tab": ("plain", lambda p, _: rows(p, "\t"), (".txt", ".txt"), ""),
    "decimal comma": ("plain", lambda p, _: rows(p, ";").replace(".", ","), (".csv", ".csv"), "decimal commas"),
    "decimal comma, blanks": ("plain", lambda p, _: rows(p).replace(".", ","), (".txt", ".txt"), "decimal commas"),
    "quoted": ("plain", lambda p, _: '"X","Y"\n' + "".join(f'"{y:.5f}","{z:.5f}"\n' for y, z in p), (".csv", ".csv"), ""),
    "quoted, decimal comma": ("plain", lambda p, _: "".join(f'"{y:.5f}","{z:.5f}"\n' for y, z in p).replace(".", ","),
                              (".csv", ".csv"), "decimal commas"),
    "UTF-8 mark": ("plain", lambda p, _: "\ufeff" + rows(p), (".txt", ".txt"), ""),
    "UTF-16": ("plain", lambda p, _: rows(p).encode("utf-16"), (".txt", ".txt"), ""),
    "CRLF": ("plain", lambda p, _: rows(p).replace("\n", "\r\n"), (".txt", ".txt"), ""),
    "header lines": ("plain", lambda p, _: "Profile 7\n\ny [mm]; z [mm]\n" + rows(p, ";"), (".txt", ".txt"), ""),
    "columns swapped": ("plain", lambda p, _: "z, y\n" + rows(p[:, ::-1], ","), (".csv", ".csv"), "columns 2 and 1"),
    "named in a comment": ("plain", lambda p, _: "# s y z\n" + "".join(f"{k/8} {y:.5f} {z:.5f}\n" for k, (y, z) in enumerate(p)),
                           (".txt", ".txt"), "columns 2 and 3"),
    "index named": ("plain", lambda p, _: "n\ty\tz\n" + "".join(f"{k}\t{y:.5f}\t{z:.5f}\n" for k, (y, z) in enumerate(p, 1)),
                    (".txt", ".txt"), "columns 2 and 3"),
    "index": ("plain", lambda p, _: "".join(f"{k} {y:.5f} {z:.5f}\n" for k, (y, z) in enumerate(p, 1)), (".txt", ".txt"),
              "first column, a count, skipped"),
    "Fortran exponents": ("plain", lambda p, _: "".join(f"{y:.8E} {z:.8E}\n".replace("E", "D") for y, z in p),
                          (".txt", ".txt"), ""),
    "MiniProf": ("MiniProf", miniprof, (".whl", ".ban"), ""),
    "old MiniProf": ("MiniProf", old_miniprof, (".txt", ".txt"), ""),
    "MiniProf .mpt": ("MiniProf", mpt, (".mpt", ".mpt"), ""),
    "SIMPACK": ("SIMPACK", simpack, (".prw", ".prr"), "1 outside the bounds"),
    "SIMPACK in m": ("SIMPACK", lambda p, kind: simpack(p, kind, 1.0, digits=8), (".prw", ".prr"), "1 outside the bounds"),
    "VAMPIRE": ("VAMPIRE", vampire, (".whe", ".rai"), "left side"),
    "GENSYS": ("GENSYS", gensys, (".wheel", ".rail"), ""),
}
ORIGINS = {"SIMPACK": "tape circle at y = 0, 70 mm from the back (SIMPACK)",
           "GENSYS": "tape circle at y = 0, 70 mm from the back (GENSYS)",
           "VAMPIRE": "back of the wheel at y = 680 mm of the file (VAMPIRE)"}


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("specimen", FORMATS)
def test_every_format_gives_the_points(specimen, kind, tmp_path):
    told, write, endings, note = FORMATS[specimen]
    raw, found = placed(tmp_path, "specimen" + endings[kind == "rail"], write(BOTH[kind], kind))
    points = found.points - ([680, 0] if told == "VAMPIRE" and kind == "rail" else 0)
    assert points == pytest.approx(BOTH[kind], abs=2e-5)
    assert raw.format == told and found.kind == kind
    assert raw.kind in ("", kind) and (raw.kind or told in ("plain", "MiniProf"))
    assert (raw.back is not None) == (kind == "wheel" and told in ORIGINS)
    assert raw.quantum == pytest.approx(1e-5*(1e-3 if "in m" in specimen else 1), rel=1e-9)
    assert note in "; ".join(raw.notes) and len(raw.notes) == bool(note)
    assert found.origin == ("as the file has it" if kind == "rail" else ORIGINS.get(told, "back of the wheel at y = 0"))
    assert np.all(np.diff(found.lines) == found.lines[1] - found.lines[0])
    mended = mend(found.points, found.lines, "specimen")
    assert mended.notes == [] and mended.group == 1 and np.array_equal(mended.points, found.points)
    check(mended.points, mended.lines, "specimen")


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(("unit", "note"), [(1e3, "in m"), (25.4, "in inches"), (10.0, "in cm")])
def test_units_are_told_by_the_size(kind, unit, note, tmp_path):
    _, found = placed(tmp_path, "file.txt", rows(BOTH[kind]/unit, digits=9))
    assert found.points == pytest.approx(BOTH[kind], abs=1e-5) and found.notes == [note]
    raw, found = placed(tmp_path, "file.txt", f"y [{note[3:5]}] z [{note[3:5]}]\n" + rows(BOTH[kind]/unit, digits=9))
    assert raw.unit == unit and found.notes == []
    if unit == 10.0:        # who says that a wheel 13.5 mm wide is in mm has a model
        _, found = placed(tmp_path, "file.txt", rows(BOTH[kind]/unit, digits=9), unit="mm")
        assert found.scale == 10 and found.notes == ["scale 1:10, by the size"]
        return
    assert "unit" in refused(tmp_path, "file.txt", rows(BOTH[kind]/unit, digits=9), unit="mm")


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(("signs", "note"), [
    ((1, -1), "z turned over"), ((-1, 1), "y turned over"), ((-1, -1), "y and z turned over")])
def test_axes_are_told_by_the_shape(kind, signs, note):
    for order in 1, -1:
        found = place(of_array((BOTH[kind]*signs)[::order]), "array")
        assert found.points == pytest.approx(BOTH[kind]) and found.notes == [note] and found.kind == kind
        with pytest.raises(Error, match=f"found the {kind} upside down with flip=(none|z); "):
            place(of_array(BOTH[kind]*signs), "array", flip="none" if signs[1] < 0 else "z")
    assert place(of_array(RAIL*[-1, 1]), "array", flip="none").points == pytest.approx((RAIL*[-1, 1])[::-1])


def test_slices_of_contact_are_asked_by_number(tmp_path):
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


def test_sides_and_sections_are_asked_by_number(tmp_path):
    right = shapes.bump(WHEEL, 70, 20, 1.0)
    for number, points in (1, WHEEL), (2, right):
        raw, found = placed(tmp_path, "worn.whe", vampire(WHEEL, "wheel", right), number)
        assert found.points == pytest.approx(points, abs=2e-5) and raw.notes == [["left side"], ["right side"]][number - 1]
    assert "slice=1, the right with slice=2" in refused(tmp_path, "worn.whe", vampire(WHEEL, "wheel", right))
    two = mpt(RAIL, "rail") + "[Other]\nDate=1\n" + rows(RAIL + [0, 3], ",")
    assert placed(tmp_path, "two.mpt", two, 2)[1].points == pytest.approx(RAIL + [0, 3], abs=2e-5)
    assert "found 2 sections with points; ask for one" in refused(tmp_path, "two.mpt", two)
    assert "leave slice out" in refused(tmp_path, "one.prw", simpack(WHEEL, "wheel"), 2)


def test_back_is_told_by_its_face_only():
    faced = shapes.with_faces(WHEEL)
    for shift, noise in (-70.0, 0.0), (-69.95, 0.01):
        found = place(of_array(shapes.noisy(faced, noise, 3) + [shift, 0]), "array")
        assert found.origin == "tape circle at y = 0, 70 mm from the back"
        assert thickness(found.points) == pytest.approx(102.5 + shift, abs=0.001 + 4*noise)
    for shift in 33.0, -66.5, 400.0:
        for noise in 0.0, 0.01:
            found = place(of_array(shapes.noisy(faced, noise, 3) + [shift, 0]), "array")
            assert thickness(found.points) == pytest.approx(32.5, abs=0.01 + 4*noise)
            told = re.fullmatch(r"back of the wheel at y = (\S+) mm of the file", found.origin)
            assert told and float(told[1]) == pytest.approx(shift, abs=0.001 + 4*noise)
            assert found.notes == ["faces beyond the running surface left out"]
    bare = WHEEL[WHEEL[:, 0] > 6] + [33, 0]
    with pytest.raises(Error, match=r"expected y = 0 on the tread.*; give wheel_back=.*\(the flange ends at 39\.\d+ mm\)"):
        place(of_array(bare), "array")
    assert thickness(place(of_array(bare), "array", wheel_back=33.0).points) == pytest.approx(32.5, abs=0.005)
    assert thickness(place(of_array(-bare), "array", wheel_back=-33.0).points) == pytest.approx(32.5, abs=0.005)
    for wrong in 300.0, -33.0, 43.0:
        with pytest.raises(Error, match="correct wheel_back"):
            place(of_array(bare), "array", wheel_back=wrong)


def with_line(k: int, line: str) -> str:
    lines = rows(WHEEL).splitlines()
    return "\n".join([*lines[:k], line, *lines[k:]]) + "\n"


REFUSED: dict[str, tuple[str, str | bytes, str]] = {
    "empty": ("a.yz", b"", "expected at least 10 points, found 0"),
    "comments": ("a.yz", "# 1 2\n", "the file begins with \"# 1 2\""),
    "words": ("a.yz", "y z\nmm mm\n", "expected at least 10 points, found 0"),
    "nine points": ("a.yz", rows(WHEEL[::72]), "expected at least 10 points, found 9"),
    "a word": ("a.yz", with_line(300, "12.5 high"), "line 301: expected two numbers, y and z, found \"12.5 high\""),
    "one number first": ("a.yz", with_line(0, "12.5"), "line 1: expected two numbers"),
    "NaN": ("a.yz", with_line(7, "NaN 1"), "line 8: expected two numbers"),
    "infinity": ("a.yz", with_line(7, "1e999 1"), "line 8: expected two numbers"),
    "an empty field": ("a.csv", rows(WHEEL, ",") + ",1.0\n", "line 616: expected two numbers"),
    "kilometres": ("a.yz", with_line(615, "12.5 1e7"), "line 616: expected millimetres"),
    "binary": ("a.yz", random.Random(1).randbytes(20000), "expected two numbers"),
    "NUL": ("a.yz", rows(WHEEL).encode() + bytes(512), "line 616: expected two numbers"),
    "one long line": ("a.yz", b"["*20000, "line 1: expected two numbers"),
    "commas for both": ("a.csv", rows(WHEEL, ",").replace(".", ","), "write semicolons between numbers"),
    "hardly a flange": ("a.yz", rows(np.column_stack([np.linspace(0, 135, 21), 0.01*np.sin(np.arange(21))])),
                        "the shape of neither"),
    "a wide flange": ("a.yz", rows(WHEEL*[1, 6.4]), "expected a flange 15 to 45 mm high, found 12"),
    "a low flange": ("a.yz", rows(WHEEL*[1, 0.5]), "expected a flange 15 to 45 mm high, found 1"),
    "a narrow wheel": ("a.yz", rows(WHEEL[WHEEL[:, 0] < 76]), "found a width of 7"),
    "a wide rail": ("a.ban", rows(RAIL*[1.7, 1]), "over 50 to 110 mm of a rail's head, found a width of 1"),
    "one point": ("a.yz", "1 1\n"*12, "expected y in millimetres over 80 to 200 mm"),
    "vertical": ("a.yz", rows(WHEEL*[0, 1]), "expected y in millimetres over 80 to 200 mm"),
    "half a SIMPACK": ("a.prw", simpack(WHEEL, "wheel").split("  point.end")[0], "expected point.end, found the end of the file"),
    "points without a spline": ("a.prw", "point.begin\n1 2\npoint.end\n", "line 1: expected the sections header, spline"),
    "turned SIMPACK": ("a.prw", simpack(WHEEL, "wheel").replace("rotate = 0.0", "rotate = 0.1"),
                       "line 10: expected rotate = 0, found"),
    "no unit": ("a.prw", simpack(WHEEL, "wheel").replace("len.f = 1000", "len.f = 0"), "expected units.len.f above 0"),
    "type": ("a.prw", simpack(WHEEL, "wheel").replace("type = 1", "type = 0, 9"), "found \"0, 9\""),
    "columns of MiniProf": ("a.whl", miniprof(WHEEL, "wheel").replace("X,Y,A,C", "A,C"), "line 6: expected columns X and Y"),
    "offset of MiniProf": ("a.whl", miniprof(WHEEL, "wheel").replace("XOffset=1.5", "XOffset=x"),
                           "line 4: expected a number after xoffset="),
    "VAMPIRE without datum": ("a.whe", vampire(WHEEL, "wheel").replace("TREADDATUM EUROPEAN\n", ""), "expected WHEELPROFILE or"),
    "another .rai": ("a.rai", rows(RAIL), "rename a file that is not of VAMPIRE"),
}


@pytest.mark.parametrize("broken", REFUSED)
def test_broken_file_is_refused(broken, tmp_path):
    name, text, words = REFUSED[broken]
    assert words in refused(tmp_path, name, text)


def test_mending_says_what_it_did():
    points = np.repeat(WHEEL, 1 + (np.arange(615) % 40 == 5), axis=0)
    twice = len(points) - 615
    points[[300, 301]] = points[[301, 300]]
    points[400] += [0.4, 1.0]
    lines = np.arange(1, len(points) + 1)
    found = mend(points, lines, "file")
    assert found.notes[0] == f"{twice} repeated dropped" and found.group == 1
    assert re.fullmatch(r"1 off the curve by up to (0\.[6-9]|1\.0)\d* mm dropped, line 401", found.notes[1])
    assert found.notes[2] == "2 that doubled back moved by up to 0.25 mm" and len(found.notes) == 3
    assert len(found.points) == len(found.lines) == 614 and np.isin(found.points, WHEEL).all()
    check(found.points, found.lines, "file")
