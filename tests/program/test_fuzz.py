"""Damaged inputs: namelists, profiles as Python and as the core read them, column files of other codes and ours, maps, tables.

A failure is a crash, a hang, another error than one of a line, a file that is made or changed, or success with nonsense.
`make fuzz N=100` damages a hundred times as many.
"""
from __future__ import annotations

import os
import random
import struct
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

import ldbench
import shapes
from generated import examples
from ldbench import Case, Error
from ldbench.plots import tables
from ldbench.plots.call_sheets import SHEETS, run_sheet
from ldbench.plots.impact import impact_page
from ldbench.plots.style import ldbench_style
from ldbench.report import differences
from ldbench.results.run_data import read_data
from ldbench.results.summary import summary_row
from ldbench.table import rigid_geometry
from ldbench.viewer.film import Picture
from ldbench.viewer.page import make_page
from running import CASES, FORTRAN_TESTS, HANG, LDBENCH, REPO, namelist, short_case

pytestmark = [pytest.mark.same_build,
              pytest.mark.skipif(not (FORTRAN_TESTS/"load_tables").exists(), reason="no load_tables: make test builds it")]
# The rigid cases use the benchmark's pair and a present-day one.
PAIRS = [{"wheel_profile": REPO/"profiles/awprof.yz", "rail_profile": REPO/"profiles/arprof.yz"},
         {"wheel_profile": REPO/"profiles/s1002.yz", "rail_profile": REPO/"profiles/60e1.yz", "gauge": 1.435, "back_to_back": 1.36}]
TOKENS = [b"", b"0", b"-0", b"1", b"-1", b"1e308", b"-1e308", b"1e-320", b"9e999", b"nan", b"inf", b"-inf", b"1d5", b"0x10",
          b"99999999999999999999", b"'", b'"', b"''", b"/", b"&", b"=", b"==", b",", b";", b"\t", b"\r", b"\n", b"\r\n", b"\0",
          b"\x7f", b"\xff", b"\xc3\xa9", b"#", b"!", b"%", b"[", b"]", b"{", b"}", b"(", b"3*1", b"1,2", b"T", b".", b"..", b"-",
          b"+", b"e", b"*", b"~", b"$", b"$x^2$", b"\xef\xbb\xbf", b"0,5", b";;", b"\\", b" "*300, b"9"*300, b"x"*3000]
CHANCES = st.randoms(use_true_random=False)


def mutate(data: bytes, rng: random.Random) -> bytes:
    """One to six changes of bytes, words and lines."""
    for _ in range(rng.choice([1, 1, 1, 2, 3, 6])):
        at, lines = rng.randrange(len(data) + 1), data.split(b"\n")
        k, j = rng.randrange(len(lines)), rng.randrange(len(lines))
        words = lines[k].split(b" ")
        words[rng.randrange(len(words))] = rng.choice([*TOKENS, *lines[j].split(b" ")])
        other_word = b"\n".join([*lines[:k], b" ".join(words), *lines[k + 1:]])
        data = rng.choice([
            data[:at] + rng.choice(TOKENS) + data[at:],
            data[:at] + bytes([rng.randrange(256)]) + data[at + 1:],
            data[:at] + data[at + rng.choice([1, 1, 2, 5, 100]):],
            data[:at],
            b"\n".join([*lines[:k], lines[j], *lines[k + 1:]]),
            b"\n".join(lines[:k] + lines[j:j + rng.choice([1, 1, 3, 20])] + lines[k:]),
            b"\n".join(lines[:k] + lines[k + rng.choice([1, 1, 2, 30]):]),
            data[:at] + bytes([(data + b"\0")[at] ^ 1 << rng.randrange(8)]) + data[at + 1:],
            other_word, other_word])
    return data


def with_checksum(data: bytes) -> bytes:
    """A table's file that is told to be whole, whatever it holds: the checksum of fortran/table/table_file.f90."""
    words, mix, all_bits = struct.unpack(f"={len(data)//8}Q", data[:len(data)//8*8]), 0, 2**64 - 1
    for word in words[:-1]:
        mix ^= word
        mix ^= mix << 13 & all_bits
        mix ^= mix >> 7
        mix ^= mix << 17 & all_bits
    return data[:len(words)*8 - 8] + struct.pack("=Q", mix)


def check_message(message: str) -> None:
    assert message.isprintable() and len(message) < 3000, f"an error of one line was expected: {message!r}"


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SimpleNamespace]:
    """What is damaged, in a folder of its own, and the program that reads tables."""
    folder = tmp_path_factory.mktemp("good")
    plain = {kind: shapes.rows(shapes.shape(name, 1.0)).encode() for kind, name in (("wheel", "awprof"), ("rail", "arprof"))}
    for kind, data in plain.items():
        (folder/kind).write_bytes(data)
    time = np.linspace(0, 0.02, 30)
    rows = [[f"{x:.6g}" for x in row] for row in np.column_stack([
        time, np.sin(time), 1e3*time**2, np.where(time > 0.01, np.nan, 1.0)])]
    columns = [f"{mark.join(names)}\n{units}".encode() + "\n".join(map(mark.join, rows)).encode() + b"\n"
               for mark, names, units in ((",", ["t [s]", "ylat [mm]", "phi", "N"], ""),
                                          (";", ["t", "ylat", "phi", "N"], "s;mm;mrad;kN\n"),
                                          (" ", ["t", "ylat", "phi", "N"], "# s mm mrad kN\n"))]
    semicolons = columns[0].replace(b",", b";").replace(b".", b",")       # as Excel writes it, also with tabs
    columns += [b"\xef\xbb\xbf" + semicolons.replace(b"\n", b"\r\n"), semicolons.replace(b";", b"\t")]
    (folder/"other.csv").write_bytes(columns[1])
    case = folder/"case.nml"
    case.write_text(short_case(folder, contact={"model": "strip"}, table={"folder": folder}))
    reader = subprocess.Popen([FORTRAN_TESTS/"load_tables", case], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                              cwd=folder)

    def load(path: Path) -> str:
        print(path, file=reader.stdin, flush=True)
        answer = reader.stdout.readline()
        assert answer.endswith("\n"), "the program that reads tables died"
        return answer[:-1]

    load(folder/"nothing")
    ours = []
    for name, changes in ("elastic.txt", {}), ("rigid.txt", {"formulation": "unilateral", "table_folder": ""}):
        run = ldbench.run(Case.from_namelist(case).replace(interval=1e-4, rows="interval", **changes))
        ours.append(Path(run.write(folder/name)).read_bytes())
    table, = folder.glob("*.table")
    yield SimpleNamespace(folder=folder, plain=plain, columns=columns, load=load, ours=ours, table=table.read_bytes())
    reader.communicate(timeout=HANG)


@contextmanager
def damaged(good: SimpleNamespace, data: bytes) -> Iterator[Path]:
    """A file with these bytes: what cannot be read is refused in one line, and no file is made."""
    before = {path.name for path in good.folder.iterdir()}
    path = good.folder/"mutant"
    path.write_bytes(data)
    try:
        yield path
    except Error as error:
        check_message(str(error))
    path.unlink()
    assert {path.name for path in good.folder.iterdir()} == before


NAMELISTS = [*((REPO/"inputs"/f"{name}.nml").read_bytes() for name in CASES),
             short_case(Path(), contact={"model": "strip"}, initial={"vY": 0.5}).encode(),
             namelist(contact={"formulation": "unilateral"}, initial={"vY": -0.2}).encode()]


def refused_alike(path: Path, message: str) -> None:
    """By the executable in the same words."""
    done = subprocess.run([LDBENCH, path], cwd=path.parent, capture_output=True, timeout=HANG)
    said = done.stderr.decode(errors="replace")
    # Python shows letters without an image, such as a byte order mark, as ?, like other control characters.
    told = str(Error(said[16:].removesuffix("\n")))
    assert (done.returncode, said[:16], told) == (1, "ldbench: error: ", message), (done.returncode, said, message)


@examples(30)
@given(CHANCES)
def test_a_namelist(good: SimpleNamespace, tmp_path: Path, rng: random.Random):
    """Accepted values are written and read again; some cases are run for ten rows, with rigid contacts."""
    executable = rng.random() < 0.1
    with damaged(good, mutate(rng.choice(NAMELISTS), rng)) as path:
        try:
            case = Case.from_namelist(path)
        except Error as error:
            if executable:
                refused_alike(path, str(error))
            raise
        assert Case.from_namelist(case.to_namelist()) == case
        if executable:
            case = case.replace(formulation="unilateral", dt=1e-4, interval=1e-4, t_end=1e-3, rows="interval", stop_at="t_end",
                                table_folder="", wheel_profile_right="", rail_profile_right="", **rng.choice(PAIRS))
            ldbench.run(case).write(tmp_path/"columns.txt")
            moved = ldbench.read_columns(tmp_path/"columns.txt")
            finite = moved[["time", "Y", "Z", "roll", "vY", "vZ", "roll_rate", "E_total"]].to_numpy()
            assert np.isfinite(finite).all() and 1 <= len(finite) <= 11


PROFILES = [form(points, kind).encode("latin-1") for form in shapes.FORMATS.values() for points, kind in (
    (shapes.with_faces(shapes.shape("awprof", 1.0), 1.0), "wheel"), (shapes.shape("arprof", 1.0), "rail"))]


@examples(30)
@given(CHANCES)
def test_a_profile(good: SimpleNamespace, rng: random.Random):
    with damaged(good, mutate(rng.choice(PROFILES), rng)) as path:
        found = ldbench.Profile(path, smoothing=rng.choice([0.0, None, 0.02]))
        for stations in found.smooth, found.rough:
            assert all(np.isfinite(x).all() for x in (stations.s, stations.y, stations.z, stations.angle, stations.curvature))


@examples(30)
@given(CHANCES)
def test_a_profile_of_the_core(good: SimpleNamespace, rng: random.Random):
    """As the core reads it, on its good rail or wheel."""
    kind = rng.choice(list(good.plain))
    with damaged(good, mutate(good.plain[kind], rng)) as path:
        files = {f"{one}_profile": str(path if one == kind else good.folder/one) for one in good.plain}
        rigid_geometry(Case.from_namelist("&case /").replace(table_folder="", **files))


@examples(30)
@given(CHANCES)
def test_columns_of_another_code(good: SimpleNamespace, rng: random.Random):
    with damaged(good, mutate(rng.choice(good.columns), rng)) as path:
        frame = ldbench.read_columns(path, rng.choice([None, {"time": 1, "Y": {"column": 2, "unit": "mm"}}]))
        assert len(frame) and len(frame.columns) and all(kind == np.dtype(float) for kind in frame.dtypes)


@examples(20)
@given(CHANCES)
def test_columns_of_ours(good: SimpleNamespace, rng: random.Random):
    """Mostly with a damaged header: compared, packed for the page; now and then drawn."""
    data = rng.choice(good.ours)
    at = data.index(b"\n", data.rindex(b"\n#") + 1) + 1 if rng.random() < 0.8 else len(data)
    with damaged(good, mutate(data[:at], rng) + data[at:]) as path:
        run, reference = read_data(path), read_data(good.folder/"elastic.txt")
        found = differences.compare([reference, run])
        differences.difference_table(found)
        differences.event_table(found.runs)
        summary_row(run)
        make_page([reference, run])
        draw = rng.choice([None]*40 + [
            lambda: next(tables.paged(run.name, run.header.title, [run.name], [[run.ending]], [1], (0,), run.heading))[1],
            lambda: run_sheet(run, SHEETS[0]), lambda: impact_page(run),
            lambda: Picture([reference, run], 0.0, 1e-3, 1e-3, None).figure])
        if draw:
            with ldbench_style():
                figure = draw()
                if figure:
                    figure.savefig(os.devnull, format="png", dpi=20)


MAP = (b'time = "t"\nY = { column = "ylat", unit = "mm" }\nroll = { column = "phi", unit = "mrad", factor = -1 }\n'
       b'Z = { column = 4, unit = "mm", offset = -0.457 }\n')


@examples(30)
@given(CHANCES)
def test_a_map_of_columns(good: SimpleNamespace, rng: random.Random):
    with damaged(good, mutate(MAP, rng)) as path:
        frame = ldbench.read_columns(good.folder/"other.csv", path)
        assert all(kind == np.dtype(float) for kind in frame.dtypes) and (len(frame) == 30 or not len(frame.columns))


@examples(30)
@given(CHANCES)
def test_a_table(good: SimpleNamespace, rng: random.Random):
    """As damage leaves it, or with a checksum that is right: then it may be used, and has to be survived."""
    honest = rng.random() < 0.5
    if rng.random() < 0.5:
        data = mutate(good.table, rng)
    else:
        words = list(struct.unpack(f"={len(good.table)//8}q", good.table))
        for _ in range(rng.choice([1, 1, 2, 5])):
            k = rng.choice([rng.randrange(len(words)), rng.randrange(min(120, len(words)))])
            words[k] = rng.choice([0, 1, -1, 4, 5, 6, 10000, 2**31, 2**62, -2**63, words[k] + 1, words[k] ^ 1 << rng.randrange(62)])
        data = struct.pack(f"={len(words)}q", *(max(-2**63, min(word, 2**63 - 1)) for word in words))
    if not honest and len(data) >= 16:
        data = with_checksum(data)
    with damaged(good, data) as path:
        answer = good.load(path)
        if honest:
            assert answer != "used" or data == good.table, "a damaged table is used"
        check_message(answer)
