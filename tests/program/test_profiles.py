"""The core reads lines of y and z in millimetres, and refuses all else with the command that converts it."""
import random
import zlib
from collections.abc import Callable
from pathlib import Path

import shapes
from running import REPO, header, refusal, rows, run_case, short_case

Points = list[tuple[str, str]]   # y and z [mm] as written


def points_of(name: str) -> Points:
    lines = (REPO / "profiles" / f"{name}.yz").read_text().splitlines()
    return [tuple(line.split()) for line in lines if not line.startswith("#")]


def plain(points: Points) -> str:
    return "".join(f"{y} {z}\n" for y, z in points)


WHEEL, RAIL = points_of("awprof"), points_of("arprof")


def fortran(number: str) -> str:
    """12.345678 as 1.2345678000D+01, the same number."""
    written = f"{float(number):.12E}"
    assert float(written) == float(number)
    return written.replace("E", "D")


def commented(points: Points) -> str:
    return "# a profile\n! as measured\n\n%\n" + "".join(
        f"{y} {z}\n" + f"   {'#!%'[i % 3]} 1.0 2.0\n" * (i % 50 == 0) for i, (y, z) in enumerate(points))


VARIANTS: dict[str, Callable[[Points], str]] = {
    "comments": commented,
    "tabs": lambda p: "".join(f"\t{y}\t\t{z}\t\n" for y, z in p),
    "blank lines": lambda p: "\n \n\t\n" + plain(p).replace("\n", "\n\n") + "\n  ",
    "Fortran exponents": lambda p: "".join(f"{fortran(y)} {fortran(z).lower()}\n" for y, z in p),
    "C exponents": lambda p: "".join(f"{float(y):+.12e} {float(z):+.12E}\n" for y, z in p),
    "CRLF": lambda p: "# y z\r\n" + plain(p).replace("\n", "\r\n"),
    "no newline at the end": lambda p: plain(p).rstrip("\n"),
    "mark of the order of bytes": lambda p: "\ufeff" + plain(p),
    "long comment": lambda p: "# " + 5000 * "long " + "\n" + plain(p),
    "made by Python": lambda p: "# taken: MiniProf, z turned over\n" + plain(p),
}


def told_of(folder: Path, wheel: str, rail: str) -> tuple[bytes, list[str], str]:
    """Columns, header and summary of a run with rigid contacts on two profile texts."""
    (folder/"wheel.yz").write_bytes(wheel.encode())
    (folder/"rail.yz").write_bytes(rail.encode())
    done = run_case(short_case(folder, contact={"formulation": "unilateral"}, profiles={
        "wheel_profile": folder/"wheel.yz", "rail_profile": folder/"rail.yz"}), folder)
    assert done.returncode == 0, done.stderr
    return rows(folder/"columns.txt"), header(folder/"columns.txt").splitlines(), " ".join(done.stdout.split())


def test_variants_are_the_same_profile(tmp_path):
    """The columns, the clearance and the equilibrium of a run are those of the plain text."""
    def found(write: Callable[[Points], str]) -> tuple[bytes, list[str]]:
        columns, lines, _ = told_of(tmp_path, write(WHEEL), write(RAIL))
        return columns, [line for line in lines if line.startswith(("  clearance_left", "  axle_height"))]

    expected = found(plain)
    assert len(expected[1]) == 2
    for name, write in VARIANTS.items():
        assert write(WHEEL) != plain(WHEEL) and found(write) == expected, name


def test_header_and_summary_tell_where_a_profile_is_from(tmp_path):
    """CRC-32 of the file's lines, as zlib has it; a reconstruction; the first line that tells how Python made a file. Noise of
    such a file is Python's concern."""
    noisy = shapes.rows(shapes.noisy(shapes.shape("awprof"), 0.003, 1))
    _, lines, summary = told_of(tmp_path, "# a wheel\n# taken:  MiniProf, z turned over \n# taken: no\n" + noisy,
                                (REPO/"profiles/arprof.yz").read_text())
    crc = {name: f"{zlib.crc32((tmp_path/f'{name}.yz').read_bytes()):08X}" for name in ("wheel", "rail")}
    wheel = f"wheel profile: {tmp_path}/wheel.yz, CRC-32 {crc['wheel']}, MiniProf, z turned over"
    rail = next(line for line in lines if line.startswith("rail profile: "))
    assert wheel in lines and wheel in summary and f"{tmp_path}/rail.yz, CRC-32 {crc['rail']}" in rail and "RECONSTRUCTION" in rail
    assert "rail profile" not in summary


def message_for(wheel: bytes | None, folder: Path) -> str:
    file = folder / "wheel.yz"
    if wheel is not None:
        file.write_bytes(wheel)
    message = refusal(short_case(folder, profiles={"wheel_profile": file}), folder)
    assert str(file) in message
    if file.is_file():
        assert message.endswith(f" it: python -m ldbench profile {file} -o {folder}/wheel_new.yz")
    return message


BROKEN_LINES = ["12.5 high", "12.5 -3.2S", "12.5", "NaN -3.25", "12.5 Inf", "12.5 1e999", "12.5 1e", "12-5 -3.25", "0x0C -3.25",
                "12.5 1e7", "12.5\x01 -3.25", "12.5 −3.25", "12.5 -3.25 0.0", "12.5 -3.25 # good", "12.5,-3.25", "12,5 -3,25",
                "ProgramName=MiniProf"]


def test_broken_lines_are_refused_with_their_number(tmp_path):
    """In the middle, as the first and as the last line."""
    plain_lines = ["# a wheel", "", *plain(WHEEL).splitlines()]
    for wrong, number in (*((wrong, 307) for wrong in BROKEN_LINES), ("12.5 high", 3), ("12.5", len(plain_lines) + 1)):
        lines = plain_lines.copy()
        lines.insert(number - 1, wrong)
        message = message_for("\n".join(lines).encode(), tmp_path)
        shown = wrong if wrong.isprintable() else "12.5? -3.25"
        assert f"wheel.yz, line {number}: expected two numbers, y and z in mm, found '{shown}'; convert it: " in message


def in_unit(millimetres: float) -> Points:
    return [(f"{float(y) / millimetres:.9f}", f"{float(z) / millimetres:.9f}") for y, z in WHEEL]


def moved(y: float, z: float, points: Points = WHEEL) -> Points:
    """Points with y and z times a factor."""
    return [(f"{y*float(a):.9f}", f"{z*float(b):.9f}") for a, b in points]


BROKEN_FILES: dict[str, tuple[bytes | None, str]] = {
    "nine points": (plain(WHEEL[::80]).encode(), "expected at least 10 points, found 9"),
    "empty": (b"", "expected at least 10 points, found 0"),
    "comments": (b"# y z\n# 1 2\n", "expected at least 10 points, found 0"),
    "metres": (plain(in_unit(1000)).encode(), "expected y in mm over 10.0 to 1000.0 mm, found a width of 0.135"),
    "micrometres": (plain(in_unit(0.001)).encode(), "expected two numbers, y and z in mm, found '"),
    "mirrored": (plain(moved(-1, 1)).encode(), "expected points in the order of increasing y, found the first at y = "),
    "other direction": (plain(WHEEL[::-1]).encode(), "found the first at y = 135.0 and the last at y = 0.0"),
    "z down": (plain(moved(1, -1)).encode(), "expected a wheel, with z up and y from its back"),
    "a rail": (plain(RAIL).encode(), "expected a wheel, with z up and y from its back"),
    "repeated": (plain(WHEEL[:30] + WHEEL[29:]).encode(), "line 31: expected a point at least 0.001 mm from the one before, found"),
    "missing": (None, "cannot be opened"),
    "binary": (random.Random(1).randbytes(20000), "expected two numbers"),
    "NUL at the end": (plain(WHEEL).encode() + bytes(512), f"line {len(WHEEL) + 1}: expected two numbers"),
    "one long line": (20000 * b"[", "line 1: expected two numbers"),
    "noise of 3 um": (shapes.rows(shapes.noisy(shapes.shape("awprof"), 0.003, 1)).encode(),
                      "expected a smooth curve, found points with a noise of about 3 um; smooth it: "),
    "decimals of 1 um": (plain([(f"{float(y):.3f}", f"{float(z):.3f}") for y, z in WHEEL]).encode(),
                         "found points with a noise of about 0.28 um; smooth it: "),
}


def test_broken_files_are_refused(tmp_path):
    for name, (content, words) in BROKEN_FILES.items():
        folder = tmp_path/name
        folder.mkdir()
        assert words in message_for(content, folder), name
