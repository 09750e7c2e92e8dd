"""The sub-commands of `python -m ldbench`: their options, statuses and files, and every example that help gives."""
from __future__ import annotations

import argparse
import itertools
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
import shapes
from ldbench import Case, ContactTable
from ldbench.__main__ import EXAMPLES, PROGRAM, SHELLS, main, make_parser
from ldbench.bodies.influence import WAVES
from ldbench.case import variables
from ldbench.commands import COMMANDS, module_of
from ldbench.commands.options import settings
from ldbench.conicity import FINE_PITCH
from ldbench.plots.document import case_figures
from ldbench.report.compare import comparison_figures
from ldbench_round.fingerprint import hertz_table
from running import HANG, REPO, bare_environment, once

PARSERS: dict[str, argparse.ArgumentParser] = {command: make_parser([command]).commands[command] for command in COMMANDS}
NO_ROOM = "ldbench: error: standard output: No space left on device\n"


def test_help_of_every_command(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Purpose, options and examples that are of this command."""
    monkeypatch.setenv("COLUMNS", "132")
    for command in COMMANDS:
        with pytest.raises(SystemExit) as end:
            main([command, "--help"])
        said, told = capsys.readouterr()
        assert end.value.code == 0 and told == ""
        assert said.startswith(f"usage: {PROGRAM} {command} ") and "\nexamples:\n" in said
        assert max(map(len, said.splitlines())) <= 132
        assert all(string in said for action in PARSERS[command]._actions for string in action.option_strings)
        examples = said.partition("\nexamples:\n")[2].strip().splitlines()
        assert examples and all(line.strip().startswith(f"{PROGRAM} {command}") for line in examples)


def small_case(exercise: int, pair: str) -> Case:
    """To just after the flange's first contact where there is one; 300 rows. One case has half-spaces, which have pressures; the
    tables of the others take less time."""
    t_end = {1: 0.2, 2: 0.045, 3: 0.03, 4: 0.03, 5: 0.03}[exercise]
    model = "halfspace" if (exercise, pair) == (2, "aw") else "hertz"
    return Case.exercise(exercise, pair).replace(model=model, t_end=t_end, stop_at="t_end", interval=t_end/300, rows="interval",
                                                 dt=t_end/900)


@pytest.fixture(scope="module")
def made(common: Path) -> Path:
    """Namelists exN_PAIR.nml of runs that take some milliseconds, their column files in outputs/, profiles in other formats, a
    file of another code: what the examples name."""
    with once(common/"small") as first, pytest.MonkeyPatch.context() as place:
        if first:
            place.chdir(common/"small")
            make_place()
    return common/"small"


def make_place() -> None:
    for folder in "inputs", "outputs", "one":
        Path(folder).mkdir()
    Path("profiles").symlink_to(REPO/"profiles")
    for exercise, pair in itertools.product(range(1, 6), ("aw", "sw")):
        case = small_case(exercise, pair)
        case.to_namelist(f"inputs/{case.case_name}.nml")
        if case.case_name in ("ex1_aw", "ex2_aw"):
            ldbench.run(case).write(case.output_file)
    small_case(3, "aw").replace(formulation="unilateral", t_end=1e-3, output_file="one.txt").to_namelist("one/ex3_aw.nml")
    for name, step in ("a", 1e-5), ("b", 2e-5), ("c", 5e-5):
        ldbench.run(small_case(2, "aw").replace(dt=step, interval=1e-4)).write(f"{name}.txt")
    ldbench.ensemble(small_case(3, "sw"), {"mass": [1500.0]}, store="sweep.zarr")
    shutil.rmtree("sweep.zarr")     # hundreds of files, which the command store does not read: it reads what is kept beside them
    ContactTable(small_case(1, "aw")).write_geometry("outputs/geometry_aw.txt")
    wheel, rail = shapes.with_faces(shapes.shape("awprof")), shapes.shape("arprof")
    for name in "wheel.whl", "left.whl":
        Path(name).write_text(shapes.miniprof(wheel, "wheel"))
    Path("right.whl").write_text(shapes.miniprof(shapes.with_faces(shapes.thin_flange(shapes.shape("awprof"))), "wheel"))
    Path("rail.ban").write_text(shapes.miniprof(rail, "rail"))
    data = ldbench.read_run("outputs/ex2_aw.txt").data
    Path("other_code.csv").write_text("t [s],ylat [mm],NLF [kN]\n" + "".join(
        f"{t:.9g},{-1e3*y:.9g},{1e-3*n:.9g}\n" for t, y, n in zip(data.time, data.Y, data.N_LF, strict=True)))
    for code in "one", "two":
        (Path("codes")/code).mkdir(parents=True)
        shutil.copy("other_code.csv", f"codes/{code}/ex2_aw.csv")
    shutil.copy("a.txt", "codes/two/ex2_aw.txt")
    Path("other_code.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\nN_LF = "NLF"\n')


@pytest.fixture
def place(made: Path, undrawn: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, which is the working folder, and where the shipped cases are looked for."""
    folder = tmp_path/"place"
    shutil.copytree(made, folder, symlinks=True)
    monkeypatch.chdir(folder)
    monkeypatch.setattr("ldbench.case.data_folder", lambda: folder)
    # Tables and runs of these cases are not those of the shipped ones, which other tests ask for.
    monkeypatch.setattr("ldbench_round.own_runs._OWN", {})
    monkeypatch.setattr("ldbench_round.fingerprint.hertz_table", hertz_table.__wrapped__)
    # Numbers and pages have tests of their own.
    monkeypatch.setattr("ldbench.geometry.pair.FINE_PITCH", 20*FINE_PITCH)
    monkeypatch.setattr("ldbench.bodies.influence.WAVES", WAVES[::6])
    monkeypatch.setattr("ldbench.plots.document.case_figures", lambda *given: itertools.islice(case_figures(*given), 1))
    monkeypatch.setattr("ldbench.report.compare.comparison_figures", lambda *given: itertools.islice(comparison_figures(*given), 1))
    return folder


def examples() -> Iterator[str]:
    """The commands that help gives, without the name of the program."""
    for text in EXAMPLES, *(module_of(command).__doc__ or "" for command in COMMANDS):
        yield from (line.strip().removeprefix(f"{PROGRAM} ") for line in text.splitlines() if line.startswith(f"  {PROGRAM}"))


# Examples that are only parsed here, by a part of their words, and where such a call is run.
ELSEWHERE = {
    **dict.fromkeys(("run inputs/ex1_aw.nml inputs/ex2_aw.nml", "table inputs/ex1_aw.nml"), "other tests of this file"),
    **dict.fromkeys(("profile profiles/awprof.yz", "outputs/pressure.pdf", "collate codes", "study contact-law", "formulations",
                     "report", "fingerprint outputs", "ex1_aw.pdf", "store sweep.zarr"), "test_full_standard_output"),
    **dict.fromkeys(("--smoothing 0.02", "--rail-inclination", "bodies inputs/ex2_aw.nml"), "docs/profiles.md"),
    **dict.fromkeys(("outputs/ex2_aw.txt other", "plot other_code.csv"), "docs/compare.md"),
    "--at 0.0217 --contact LF": "docs/output.md", "--radii": "test_profile_table.py", "--save-map": "test_check.py",
    "trust": "test_trust.py", "submit": "test_submit.py", "fmu": "test_fmu.py", "--scheduler tcp://": "test_ensemble.py"}
# What is run with other words, by the time that it would take.
SMALLER = {"--speed 1e-3": "--speed 2e-2", "-n 50": "-n 2", "gauge=1.43:1.44": "vY=1:2", "1200:2000:9": "1200:2000:2",
           "--over vY=0.5,1,2 ": "", "ensemble inputs": "ensemble one", "0.5:1:6": "0.5:1:2"}
RUN_AS_THEY_STAND = {"table inputs/ex1_aw.nml -o outputs/geometry_aw.txt", "store sweep.zarr --remove all"}


def is_run(text: str) -> bool:
    return text in RUN_AS_THEY_STAND or not any(known in text for known in ELSEWHERE)


@pytest.mark.parametrize("text", [text for text in dict.fromkeys(examples()) if is_run(text) and "--help" not in text])
def test_example(text: str, place: Path, capsys: pytest.CaptureFixture[str]):
    """It does its work in silence, or the lines that it prints, and writes what it says."""
    for known, smaller in SMALLER.items():
        text = text.replace(known, smaller)
    words = [name for word in shlex.split(text) for name in (sorted(map(str, Path().glob(word))) if "*" in word else [word])]
    # The runs here end long before the wheelset returns, which is what a check is for.
    assert main(words) == int(words[0] == "check")
    said, told = capsys.readouterr()
    assert "ldbench: error" not in told and "Traceback" not in told
    if "-o" in words:
        assert Path(words[words.index("-o") + 1]).exists(), said


def test_other_examples_are_commands():
    others = [text.split() for text in examples() if not is_run(text)]
    assert len(others) > 20 and all(PARSERS[command].parse_args(words) for command, *words in others)
    assert all(any(known in text for text in examples()) for known in (*ELSEWHERE, *SMALLER, *RUN_AS_THEY_STAND))


# The least work of each command after which it prints.
LEAST = {
    "run": "one/ex3_aw.nml -o made.txt", "table": "one/ex3_aw.nml -o made.txt", "profile": "profiles/awprof.yz -o made.pdf",
    "bodies": "inputs/ex2_sw.nml --only rail -o made.bodies", "trust": "one/ex3_aw.nml --json made.json",
    "pressure": "outputs/ex2_aw.txt --at 0.0217 -o made.pdf", "plot": "a.txt -o made.pdf", "compare": "a.txt b.txt -o made.pdf",
    "check": "a.txt", "submit": "outputs --template", "score": "outputs/ex2_aw.txt --reference outputs",
    "fingerprint": "outputs/ex2_aw.txt", "collate": "codes -o made", "study": "contact-law",
    "formulations": "-o made", "report": "--inputs one -o made",
    "view": "a.txt -o made.html", "ensemble": "inputs/ex3_sw.nml --over mass=1500 -o made.zarr",
    "fmu": "inputs/ex1_sw.nml --set t_end=1e-3 -o made.fmu", "store": "sweep.zarr", "variables": "vY"}


@contextmanager
def full_output() -> Iterator[None]:
    """Standard output has a buffer and no room behind it, as after > /dev/full."""
    before, full = os.dup(1), os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, 1)
    stream = open(1, "w", closefd=False)        # noqa: SIM115
    try:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(sys, "stdout", stream)
            yield
    finally:
        with suppress(OSError):     # of a program that has not looked at what it left in the buffer
            stream.close()
        os.dup2(before, 1)
        os.close(before)
        os.close(full)


needs_full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")


@needs_full
@pytest.mark.parametrize("command", COMMANDS)
def test_full_standard_output(command: str, place: Path, capsys: pytest.CaptureFixture[str]):
    """Status 1 and one line, once the work is done: its files are whole. The help cannot be printed either."""
    if command in ("study", "formulations"):        # which run every case of inputs/
        for file in set(Path("inputs").glob("*.nml")) - {Path("inputs/ex3_aw.nml")}:
            file.unlink()
    words = [command, *LEAST[command].split()]
    with full_output():
        assert main(words) == 1
    assert re.findall(r"ldbench: error: [^\n]*\n", told := capsys.readouterr().err) == [NO_ROOM], told
    made = next((Path(word) for word in words if word.startswith("made")), None)
    assert (not made or made.exists()) and not list(place.rglob("*.ldbench-part*"))
    with full_output():
        assert main([command, "--help"]) == 1
    assert capsys.readouterr().err == NO_ROOM


@needs_full
def test_full_standard_output_of_the_program(capsys: pytest.CaptureFixture[str]):
    for words in ["--version"], ["--help"], *(["--completion", shell] for shell in SHELLS):
        with full_output():
            assert main(words) == 1, words
        assert capsys.readouterr().err == NO_ROOM


@needs_full
@pytest.mark.parametrize("words", ["run one.nml --json", "variables"])
def test_full_and_closed_standard_output_of_a_process(words: str, tmp_path: Path):
    """Python has nothing to add when the process ends. A reader that goes away is no error: status 141, as a program has that
    SIGPIPE ends, and silence."""
    (tmp_path/"one.nml").write_text("&contact formulation = 'unilateral' / &integrator t_end = 1e-3 / &output file = 'one.txt' /\n")
    start = {"args": [sys.executable, "-m", "ldbench", *words.split()], "cwd": tmp_path, "env": bare_environment(), "text": True}
    with open("/dev/full", "w") as full:
        done = subprocess.run(**start, stdout=full, stderr=subprocess.PIPE, timeout=HANG)
    assert (done.returncode, done.stderr) == (1, NO_ROOM)
    if words == "variables":
        with subprocess.Popen(**start, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            process.stdout.close()
            assert (process.stderr.read(), process.wait(HANG)) == ("", 141)


def refused(words: list[str], status: int, capsys: pytest.CaptureFixture[str]) -> str:
    """What a command says that ends with this status: one line."""
    capsys.readouterr()
    assert main(words) == status
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(r"ldbench: error: [^\n]+\n", said.err), said
    return said.err


def test_run_takes_several_namelists(place: Path, capsys: pytest.CaptureFixture[str]):
    """Each writes its file, the executable's byte by byte; the summaries stand one after the other."""
    files = [Path(f"outputs/ex{k}_aw.txt") for k in (1, 2)]
    before = [file.read_bytes() for file in files]
    for file in files:
        file.unlink()
    assert main(["run", "inputs/ex1_aw.nml", "inputs/ex2_aw.nml"]) == 0
    assert [file.read_bytes() for file in files] == before
    said = capsys.readouterr().out
    titles = [f"{case.case_name}: {case.title}\n" for case in (small_case(1, "aw"), small_case(2, "aw"))]
    assert said.startswith(titles[0]) and f"\n\n{titles[1]}" in said and said.count("ended at t = ") == 2
    for file in files:
        file.unlink()
    # Whatever is wrong with one of them is found before the first is run.
    assert "none.nml" in refused(["run", "inputs/ex1_aw.nml", "none.nml"], 1, capsys)
    assert not any(file.exists() for file in files)
    assert "a file of its own" in refused(["run", "inputs/ex1_aw.nml", "./inputs/ex1_aw.nml"], 1, capsys)


def test_cases_side_by_side_are_those_one_after_the_other(place: Path, capsys: pytest.CaptureFixture[str]):
    """A line of JSON for each case, in the order of the namelists, with the result that its file has."""
    names = [f"inputs/ex{k}_{pair}.nml" for pair in ("sw", "aw") for k in (3, 1)]
    for name in names:
        Case.from_namelist(name).replace(formulation="unilateral").to_namelist(name)
    found = []
    for jobs in "1", "3":
        assert main(["run", *names, "-j", jobs, "--json"]) == 0
        found.append([json.loads(line) | {"seconds": 0} for line in capsys.readouterr().out.splitlines()])
    assert found[0] == found[1] and [line["case"] for line in found[0]] == ["ex3_sw", "ex1_sw", "ex3_aw", "ex1_aw"]
    for line in found[0]:
        assert line["farthest_left"] == ldbench.read_run(line["file"]).results["farthest_left"] > 0


def test_what_is_told_besides_the_result(place: Path, capsys: pytest.CaptureFixture[str]):
    """With -q nothing but errors and JSON, with -v the files that are written; a warning without them."""
    rigid = ["--set", "formulation=unilateral"]
    assert main(["run", "one/ex3_aw.nml", "-q"]) == 0 and main(["compare", "a.txt", "b.txt", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["table", "inputs/ex1_aw.nml", *rigid, "--json", "-q"]) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    # With rigid contacts two of three frequencies are not known.
    assert told["case"] == "ex1_aw" and len(told["frequencies"]) == 3 and None in told["frequencies"] and said.err == ""
    assert "none.nml" in refused(["run", "none.nml", "-q"], 1, capsys)
    assert main(["run", "inputs/ex3_sw.nml", "--set", "vY=0.7", "-o", "made.txt", "--json"]) == 0
    assert capsys.readouterr().err.startswith("ldbench: warning: &initial roll_rate: expected about ")
    assert main(["plot", "a.txt", "-v"]) == 0
    assert capsys.readouterr().err == "ldbench: written: outputs/ldbench_plots.pdf\n"
    assert main(["run", "one/ex3_aw.nml", "-v"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1] == "ldbench: written: one.txt" and any("ContactTable(" in line for line in lines)
    assert "not allowed with" in refused(["plot", "a.txt", "-v", "-q"], 2, capsys)


def test_a_file_without_our_names_is_refused_with_the_way_to_a_map(place: Path, capsys: pytest.CaptureFixture[str]):
    for words in ["plot", "other_code.csv"], ["compare", "other_code.csv", "other_code.csv"], ["view", "other_code.csv"]:
        told = refused(words, 1, capsys)
        assert "other_code.csv: expected a column time, --map TOML that names our columns, or --simulation NAME" in told


@pytest.mark.parametrize(("words", "reader"), [
    ("compare a.txt other_code.csv", "report.compare.compare"), ("view ex2_aw.csv", "viewer.page.run_entry"),
    ("plot other_code.csv --simulation ex2_aw", "plots.document.summary_row")], ids=lambda word: word.partition(" ")[0])
def test_a_map_is_guessed(words: str, reader: str, place: Path, capsys: pytest.CaptureFixture[str],
                          monkeypatch: pytest.MonkeyPatch):
    """The simulation is the one that is given, that of the file's name, or that of our own file beside it; the columns are those of
    the written map."""
    shutil.copy("other_code.csv", "ex2_aw.csv")
    seen: list[ldbench.Run] = []
    module, _, name = reader.rpartition(".")
    home = import_module(f"ldbench.{module}")
    real = getattr(home, name)

    def spy(runs: Any, *given: Any, **more: Any) -> Any:
        seen.extend(runs if isinstance(runs, list) else [runs])
        return real(runs, *given, **more)

    monkeypatch.setattr(home, name, spy)
    assert main([*words.split(), "-o", f"made.{'html' if 'view' in words else 'pdf'}"]) == 0
    assert capsys.readouterr().err.count("the map of its columns is guessed: time, Y, N_LF.") == 1
    expected = ldbench.read_run("other_code.csv", map="other_code.toml")
    for column in "time", "Y", "N_LF":
        np.testing.assert_allclose(seen[-1].data[column], expected[column], rtol=1e-12)


def test_a_terminal_is_told_what_comes_next(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    words = ["table", str(REPO/"inputs/ex1_sw.nml"), "--set", "formulation=unilateral"]
    for terminal, options, told in (True, [], True), (False, [], False), (True, ["--json"], False), (True, ["-q"], False):
        monkeypatch.setattr(sys.stdout, "isatty", lambda terminal=terminal: terminal)
        assert main([*words, *options]) == 0
        assert ("next: " in capsys.readouterr().out) is told


def test_a_page_opens_before_a_person_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    page = tmp_path/"page.html"

    def opens(*options: str, terminal: bool = True, **variables: str) -> list[str]:
        opened.clear()
        with monkeypatch.context() as changed:
            for name in "CI", "PYTEST_CURRENT_TEST", "DISPLAY", "WAYLAND_DISPLAY":
                changed.delenv(name, raising=False)
            for name, value in variables.items():
                changed.setenv(name, value)
            changed.setattr(sys, "platform", "linux")
            changed.setattr(sys.stdout, "isatty", lambda: terminal)
            assert main(["view", str(REPO/"outputs/reference/ex1_aw.txt"), "-o", str(page), *options]) == 0
        return opened.copy()

    assert opens(DISPLAY=":0") == opens(WAYLAND_DISPLAY="wayland-0") == [page.resolve().as_uri()]
    assert opens() == opens("--no-browser", DISPLAY=":0") == opens("-q", DISPLAY=":0") == []
    assert opens(DISPLAY=":0", CI="true") == opens(DISPLAY=":0", PYTEST_CURRENT_TEST="this") == []
    assert opens(DISPLAY=":0", terminal=False) == []


def test_completion_knows_every_command_and_option(capsys: pytest.CaptureFixture[str]):
    for shell in "bash", "zsh":
        with pytest.raises(SystemExit):
            main(["--completion", shell])
        said = capsys.readouterr().out
        assert all(command in said for command in COMMANDS) and "simulation" in said and "python -m" not in said


def test_values_and_variables_by_name(capsys: pytest.CaptureFixture[str]):
    """The last value of --set counts, a text with its quotes or without; of the variables those are listed that are asked for."""
    assert settings(["vY=1", "model='strip'", "initial_vY=2e-1"]) == {"vY": 0.2, "model": "strip"}
    assert main(["variables", "integrator", "&table", "vY"]) == 0
    listed = re.findall(r"^(?:&|  )(\w+)", capsys.readouterr().out, re.MULTILINE)
    known = {group: [variable.name for variable in variables() if variable.group == group] for group in ("integrator", "table")}
    assert listed == ["initial", "vY", "table", *known["table"], "integrator", *known["integrator"]] or listed == [
        "initial", "vY", "integrator", *known["integrator"], "table", *known["table"]]


def test_pressure_is_that_of_the_nearest_row(place: Path, capsys: pytest.CaptureFixture[str]):
    time = ldbench.read_run("a.txt").time
    for t in 0.02171, 0.02178:
        assert main(["pressure", "a.txt", "--at", str(t), "--contact", "LF", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["time"] == time[np.abs(time - t).argmin()] and Path(told["picture"]).is_file()
