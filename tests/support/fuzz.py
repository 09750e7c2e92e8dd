"""Mutated inputs, each from a seed of its own: namelists, profiles, column files of other codes and ours, maps of columns,
tables.

A failure is a crash, a hang, a traceback, an error of more than one line, a file that is made or changed, or success with
nonsense. Children do many inputs each and say which one they begin; of one that dies or is silent, that was the last.

usage: PYTHONPATH=profiles python tests/support/fuzz.py [N] [--seed FIRST] [--jobs PROCESSES]      (make fuzz N=100000)
"""
from __future__ import annotations

import argparse
import os
import random
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import shapes
from running import CASES, FORTRAN_TESTS, LDBENCH, REPO, environment, namelist, short_case

BATCH = 400                 # inputs of a child
HANG = 1800                 # a child that takes so long hangs [s]
# The rigid cases use the benchmark's pair and a present-day one.
PAIRS = [{"wheel_profile": "profiles/awprof.yz", "rail_profile": "profiles/arprof.yz"},
         {"wheel_profile": "profiles/s1002.yz", "rail_profile": "profiles/60e1.yz", "gauge": 1.435, "back_to_back": 1.36}]
TOKENS = [b"", b"0", b"-0", b"1", b"-1", b"1e308", b"-1e308", b"1e-320", b"9e999", b"nan", b"inf", b"-inf", b"1d5", b"0x10",
          b"99999999999999999999", b"'", b'"', b"''", b"/", b"&", b"=", b"==", b",", b";", b"\t", b"\r", b"\n", b"\r\n", b"\0",
          b"\x7f", b"\xff", b"\xc3\xa9", b"#", b"!", b"%", b"[", b"]", b"{", b"}", b"(", b"3*1", b"1,2", b"T", b".", b"..", b"-",
          b"+", b"e", b"*", b"~", b"$", b"$x^2$", b"\xef\xbb\xbf", b"0,5", b";;", b"\\", b" "*300, b"9"*300, b"x"*3000]


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


class Child:
    """What a process needs to do many inputs."""

    def __init__(self, folder: Path) -> None:
        import ldbench  # not where the parent only counts

        self.ldbench = ldbench
        self.folder = folder
        inputs = [(REPO/"inputs"/f"{name}.nml").read_bytes() for name in CASES]
        made = short_case(Path(), contact={"model": "strip"}, initial={"vY": 0.5}).encode()
        self.namelists = [*inputs, made, namelist(contact={"formulation": "unilateral"}, initial={"vY": -0.2}).encode()]
        self.profiles = [form(points, kind).encode("latin-1") for form in shapes.FORMATS.values() for points, kind in (
            (shapes.with_faces(shapes.shape("awprof", 1.0), 1.0), "wheel"), (shapes.shape("arprof", 1.0), "rail"))]
        self.plain = {kind: shapes.rows(shapes.shape(name, 1.0)).encode()
                      for kind, name in (("wheel", "awprof"), ("rail", "arprof"))}
        for kind, data in self.plain.items():
            (folder/kind).write_bytes(data)
        time = np.linspace(0, 0.02, 30)
        values = np.column_stack([time, np.sin(time), 1e3*time**2, np.where(time > 0.01, np.nan, 1.0)])
        rows = [[f"{x:.6g}" for x in row] for row in values]
        self.columns = [
            *(f"{mark.join(names)}\n{units}".encode() + "\n".join(map(mark.join, rows)).encode() + b"\n"
              for mark, names, units in ((",", ["t [s]", "ylat [mm]", "phi", "N"], ""),
                                         (";", ["t", "ylat", "phi", "N"], "s;mm;mrad;kN\n"),
                                         (" ", ["t", "ylat", "phi", "N"], "# s mm mrad kN\n")))]
        semicolons = self.columns[0].replace(b",", b";").replace(b".", b",")       # as Excel writes it, also with tabs
        self.columns += [b"\xef\xbb\xbf" + semicolons.replace(b"\n", b"\r\n"), semicolons.replace(b";", b"\t")]
        self.map = (b'time = "t"\nY = { column = "ylat", unit = "mm" }\nroll = { column = "phi", unit = "mrad", factor = -1 }\n'
                    b'Z = { column = 4, unit = "mm", offset = -0.457 }\n')
        (folder/"other.csv").write_bytes(self.columns[1])
        case = folder/"case.nml"
        case.write_text(short_case(folder, contact={"model": "strip"}, table={"folder": folder}))
        self.tables = subprocess.Popen([FORTRAN_TESTS/"load_tables", case], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                       text=True, cwd=folder)
        self._load(folder/"nothing")
        self.ours = []
        for name, changes in ("elastic.txt", {}), ("rigid.txt", {"formulation": "unilateral", "table_folder": ""}):
            run = ldbench.run(ldbench.Case.from_namelist(case).replace(interval=1e-4, rows="interval", **changes))
            self.ours.append(Path(run.write(folder/name)).read_bytes())
        table, = folder.glob("*.table")
        self.table = table.read_bytes()
        self.known = self._listing()

    def _listing(self) -> set[str]:
        return {path.name for path in self.folder.iterdir()}

    def _load(self, path: Path) -> str:
        print(path, file=self.tables.stdin, flush=True)
        answer = self.tables.stdout.readline()
        assert answer.endswith("\n"), "the program that reads tables died"
        return answer[:-1]

    def run(self, seed: int) -> None:
        rng = random.Random(seed)
        name = KINDS[seed % len(KINDS)]
        try:
            KIND[name](self, rng)
        except self.ldbench.Error as error:
            check_message(str(error))
        for left in ("mutant", "columns.txt"):
            (self.folder/left).unlink(missing_ok=True)
        assert self._listing() == self.known, f"files made: {self._listing()}"

    def mutant(self, data: bytes) -> Path:
        path = self.folder/"mutant"
        path.write_bytes(data)
        return path

    def namelist(self, rng: random.Random) -> None:
        """Accepted values are written and read again; some cases are run for ten rows, with rigid contacts."""
        path = self.mutant(mutate(rng.choice(self.namelists), rng))
        executable = rng.random() < 0.1
        try:
            case = self.ldbench.Case.from_namelist(path)
        except self.ldbench.Error as error:
            if executable:
                self.refused_alike(path, str(error))
            raise
        assert self.ldbench.Case.from_namelist(case.to_namelist()) == case
        if rng.random() < 0.1:
            case = case.replace(formulation="unilateral", dt=1e-4, interval=1e-4, t_end=1e-3, rows="interval", stop_at="t_end",
                                table_folder="", wheel_profile_right="", rail_profile_right="", **rng.choice(PAIRS))
            run = self.ldbench.run(case)
            run.write(self.folder/"columns.txt")
            moved = self.ldbench.read_columns(self.folder/"columns.txt")
            finite = moved[["time", "Y", "Z", "roll", "vY", "vZ", "roll_rate", "E_total"]].to_numpy()
            assert np.isfinite(finite).all() and 1 <= len(finite) <= 11

    def refused_alike(self, path: Path, message: str) -> None:
        done = subprocess.run([LDBENCH, path], cwd=self.folder, capture_output=True, timeout=HANG)
        said = done.stderr.decode(errors="replace")
        # Python shows letters without an image, such as a byte order mark, as ?, like other control characters.
        head, told = said[:16], str(self.ldbench.Error(said[16:].removesuffix("\n")))
        assert (done.returncode, head, told) == (1, "ldbench: error: ", message), (done.returncode, said, message)

    def profile(self, rng: random.Random) -> None:
        path = self.mutant(mutate(rng.choice(self.profiles), rng))
        found = self.ldbench.Profile(path, smoothing=rng.choice([0.0, None, 0.02]))
        for stations in found.smooth, found.rough:
            assert all(np.isfinite(x).all() for x in (stations.s, stations.y, stations.z, stations.angle, stations.curvature))

    def core_profile(self, rng: random.Random) -> None:
        """As the core reads it, on its good rail or wheel."""
        from ldbench.table import rigid_geometry

        kind = rng.choice(list(self.plain))
        files = {f"{one}_profile": str(self.folder/one) for one in self.plain}
        files[f"{kind}_profile"] = str(self.mutant(mutate(self.plain[kind], rng)))
        rigid_geometry(self.ldbench.Case.from_namelist("&case /").replace(table_folder="", **files))

    def column_file(self, rng: random.Random) -> None:
        path = self.mutant(mutate(rng.choice(self.columns), rng))
        mapped = rng.choice([None, {"time": 1, "Y": {"column": 2, "unit": "mm"}}])
        frame = self.ldbench.read_columns(path, mapped)
        assert len(frame) and len(frame.columns) and all(kind == np.dtype(float) for kind in frame.dtypes)

    def our_file(self, rng: random.Random) -> None:
        """One of ours, mostly with a damaged header: compared, packed for the page; now and then drawn."""
        from ldbench.plots import tables
        from ldbench.plots.call_sheets import SHEETS, run_sheet
        from ldbench.plots.impact import impact_page
        from ldbench.plots.style import ldbench_style
        from ldbench.report import differences
        from ldbench.results.run_data import read_data
        from ldbench.results.summary import summary_row
        from ldbench.viewer.film import Picture
        from ldbench.viewer.page import make_page

        data = rng.choice(self.ours)
        at = data.index(b"\n", data.rindex(b"\n#") + 1) + 1 if rng.random() < 0.8 else len(data)
        run = read_data(self.mutant(mutate(data[:at], rng) + data[at:]))
        reference = read_data(self.folder/"elastic.txt")
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

    def column_map(self, rng: random.Random) -> None:
        frame = self.ldbench.read_columns(self.folder/"other.csv", self.mutant(mutate(self.map, rng)))
        assert all(kind == np.dtype(float) for kind in frame.dtypes) and (len(frame) == 30 or not len(frame.columns))

    def table_file(self, rng: random.Random) -> None:
        """As damage leaves it, or with a checksum that is right: then it may be used, and has to be survived."""
        honest = rng.random() < 0.5
        if rng.random() < 0.5:
            data = mutate(self.table, rng)
        else:
            words = list(struct.unpack(f"={len(self.table)//8}q", self.table))
            for _ in range(rng.choice([1, 1, 2, 5])):
                k = rng.choice([rng.randrange(len(words)), rng.randrange(min(120, len(words)))])
                words[k] = rng.choice([0, 1, -1, 4, 5, 6, 10000, 2**31, 2**62, -2**63, words[k] + 1,
                                       words[k] ^ 1 << rng.randrange(62)])
            data = struct.pack(f"={len(words)}q", *(max(-2**63, min(word, 2**63 - 1)) for word in words))
        if not honest and len(data) >= 16:
            data = with_checksum(data)
        answer = self._load(self.mutant(data))
        if honest:
            assert answer != "used" or data == self.table, "a damaged table is used"
        check_message(answer)


KIND: dict[str, Callable[[Child, random.Random], None]] = {
    "namelist": Child.namelist, "profile": Child.profile, "core profile": Child.core_profile,
    "columns": Child.column_file, "ours": Child.our_file, "map": Child.column_map, "table": Child.table_file}
KINDS = list(KIND)


def be_child(seeds: range) -> None:
    """Say each seed before its input is done; the failure of one is told in a line and the next one is begun."""
    with tempfile.TemporaryDirectory() as folder:
        child = Child(Path(folder))
        os.chdir(folder)
        for seed in seeds:
            print(f"seed {seed}", flush=True)
            try:
                child.run(seed)
            except Exception as error:
                print(f"failed {seed} {type(error).__name__}: {' '.join(str(error).split())[:500]}", flush=True)
    print("end", flush=True)


def failure(seed: str | int, text: str) -> str:
    return f"{seed} {KINDS[int(seed) % len(KINDS)]}: {text}"


def fuzz(seeds: range) -> list[str]:
    """Failures of some inputs, done by children; the next child goes on after the input that one died of."""
    failures: list[str] = []
    while seeds:
        words = [sys.executable, __file__, "--child", str(seeds.start), str(seeds.stop)]
        try:
            done = subprocess.run(words, capture_output=True, timeout=HANG, env=environment(OMP_NUM_THREADS="1"))
            said, end = done.stdout, f"died with {done.returncode}: {done.stderr.decode(errors='replace')[-300:]}"
        except subprocess.TimeoutExpired as hang:
            said, end = hang.stdout or b"", "hangs"
        lines = [line.partition(" ") for line in said.decode(errors="replace").splitlines()]
        failures += [failure(*text.split(" ", 1)) for word, _, text in lines if word == "failed"]
        if lines and lines[-1][0] == "end":
            break
        begun = [int(text) for word, _, text in lines if word == "seed"]
        if not begun:
            raise RuntimeError(end)
        failures.append(failure(begun[-1], end))
        seeds = range(begun[-1] + 1, seeds.stop)
    return failures


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("n", type=int, nargs="?", default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    args = parser.parse_args()
    pieces = [range(k, min(k + BATCH, args.seed + args.n)) for k in range(args.seed, args.seed + args.n, BATCH)]
    count = 0
    with ThreadPoolExecutor(args.jobs) as pool:
        for piece, found in zip(pieces, pool.map(fuzz, pieces), strict=True):
            count += len(found)
            print("".join(f"\n{failure}" for failure in found) + "\n"*bool(found), end=f"\r{piece.stop - args.seed} inputs",
                  flush=True)
    print(f", {count} failures")
    return bool(count)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        be_child(range(int(sys.argv[2]), int(sys.argv[3])))
        sys.exit()
    sys.exit(main())
