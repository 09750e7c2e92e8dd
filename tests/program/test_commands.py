"""The sub-commands of `python -m ldbench`: their options, statuses and files, and every example that help gives."""
from __future__ import annotations

import argparse
import itertools
import json
import math
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
import shapes
from ldbench import Case, ContactTable
from ldbench.__main__ import EXAMPLES, PROGRAM, main, make_parser
from ldbench.commands import COMMANDS, module_of
from ldbench.conicity import FINE_PITCH
from ldbench.geometry.pressures import run_patches
from ldbench.plots.document import case_figures
from ldbench.report.compare import comparison_figures
from ldbench_round.fingerprint import hertz_table
from running import HANG, REPO, once

TINY = {"model": "hertz"}


PARSERS: dict[str, argparse.ArgumentParser] = {command: make_parser([command]).commands[command] for command in COMMANDS}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command(command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """Purpose, options and examples that are of this command."""
    monkeypatch.setenv("COLUMNS", "132")
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
    """To just after the flange's first contact where there is one; 300 rows. The actual profiles have half-spaces."""
    t_end = {1: 0.2, 2: 0.045, 3: 0.03, 4: 0.03, 5: 0.03}[exercise]
    model = {"model": "halfspace"} if pair == "aw" else {}
    return Case.exercise(exercise, pair).replace(**TINY | model, t_end=t_end, stop_at="t_end", interval=t_end/300, rows="interval",
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
    for folder in "inputs", "outputs":
        Path(folder).mkdir()
    Path("profiles").symlink_to(REPO/"profiles")
    for exercise in range(1, 6):
        for pair_name in "aw", "sw":
            case = small_case(exercise, pair_name)
            case.to_namelist(f"inputs/{case.case_name}.nml")
            if case.case_name in ("ex1_aw", "ex2_aw"):
                ldbench.run(case).write(case.output_file)
    for name, step in ("a", 1e-5), ("b", 2e-5), ("c", 5e-5):
        case = small_case(2, "aw")
        ldbench.run(case.replace(dt=step, interval=1e-4)).write(f"{name}.txt")
    ldbench.ensemble(small_case(3, "sw"), {"mass": [1500.0]}, store="sweep.zarr")
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
    monkeypatch.setattr("ldbench.plots.document.case_figures", lambda *given: itertools.islice(case_figures(*given), 1))
    monkeypatch.setattr("ldbench.report.compare.comparison_figures", lambda *given: itertools.islice(comparison_figures(*given), 1))
    return folder


def examples() -> Iterator[str]:
    """The commands that help gives."""
    yield from (line.strip() for line in EXAMPLES.splitlines() if line.startswith(f"  {PROGRAM}"))
    for command in COMMANDS:
        yield from map(str.strip, (module_of(command).__doc__ or "").partition("\n\nexamples:\n")[2].splitlines())


# Only parsed, as it stands: what takes minutes, needs another machine, or is run elsewhere.
ONLY_PARSED = {"ldbench report": "test_report.py makes one",
               "ldbench trust": "test_trust.py runs it",
               "ldbench submit": "test_submit.py runs it",
               "--scheduler tcp://": "a scheduler on another machine",
               **dict.fromkeys(("compare outputs/ex2_aw.txt other", "view outputs/ex2_aw.txt other", "plot outputs/ex1_aw.txt"),
                               "docs/compare.md has it"),
               **dict.fromkeys(("--radii", "run --help"), "other tests run it"),
               **dict.fromkeys(("codes -o round_2", "formulations -o trial"), "an example beside it differs in names alone")}
# What is run with other words, by the time that it would take.
SMALLER = {"--speed 1e-3": "--speed 2e-2", "-n 50": "-n 2", "gauge=1.43:1.44": "vY=1:2"}
# What runs every case of inputs/: it gets exercise 3 alone.
EVERY_CASE = "formulations", "study contact-law"


@pytest.mark.parametrize("text", dict.fromkeys(examples()))
def test_example(text: str, place: Path, capsys: pytest.CaptureFixture[str]):
    """It does its work in silence, or the lines that it prints, and writes what it says."""
    words = shlex.split(text.removeprefix(PROGRAM))
    if any(known in text for known in ONLY_PARSED):
        assert "--help" in words or PARSERS[words[0]].parse_args(words[1:])
        return
    for known, smaller in SMALLER.items():
        text = text.replace(known, smaller)
    words = [name for word in shlex.split(text.removeprefix(PROGRAM)) for name in (
        sorted(map(str, Path().glob(word))) if "*" in word else [word])]
    if " ".join(words).startswith(EVERY_CASE):
        for file in set(Path("inputs").glob("*.nml")) - {Path("inputs/ex3_aw.nml")}:
            file.unlink()
    # The runs here end long before the wheelset returns, which is what a check is for.
    assert main(words) == int(words[0] == "check")
    said, told = capsys.readouterr()
    assert "ldbench: error" not in told and "Traceback" not in told
    if "-o" in words:
        assert Path(words[words.index("-o") + 1]).exists(), said


def refused(words: list[str], status: int, capsys: pytest.CaptureFixture[str]) -> str:
    """What a command says that ends with this status: one line."""
    capsys.readouterr()
    assert main(words) == status
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(r"ldbench: error: [^\n]+\n", said.err), said
    return said.err


@pytest.mark.parametrize("words", [["variables"], ["run", "--help"]], ids=" ".join)
def test_a_closed_pipe_is_no_error(words: list[str]):
    """Status 141, as a program has that SIGPIPE ends, and silence."""
    command = [sys.executable, "-m", "ldbench", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout and process.stderr
        process.stdout.close()
        said = process.stderr.read()
        assert (process.wait(HANG), said) == (141, b"")


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
    """The order of what is printed is that of the namelists."""
    names = [f"inputs/ex{k}_{pair}.nml" for pair in ("sw", "aw") for k in (3, 1)]
    for name in names:
        Case.from_namelist(name).replace(formulation="unilateral").to_namelist(name)
    found = []
    for jobs in "1", "3":
        assert main(["run", *names, "-j", jobs, "--json"]) == 0
        found.append([json.loads(line) | {"seconds": 0} for line in capsys.readouterr().out.splitlines()])
    assert found[0] == found[1] and [line["case"] for line in found[0]] == ["ex3_sw", "ex1_sw", "ex3_aw", "ex1_aw"]


def test_what_is_told_besides_the_result(place: Path, capsys: pytest.CaptureFixture[str]):
    """With -q nothing but errors and JSON, with -v the files that are written; a warning without them."""
    assert main(["run", "inputs/ex1_aw.nml", "-q"]) == 0 and main(["compare", "a.txt", "b.txt", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["table", "inputs/ex1_aw.nml", "--json", "-q"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["case"] == "ex1_aw" and said.err == ""
    assert "none.nml" in refused(["run", "none.nml", "-q"], 1, capsys)
    assert main(["table", "inputs/ex1_aw.nml", "--set", "accuracy=1e-6", "--json"]) == 0
    assert capsys.readouterr().err.startswith("ldbench: warning: contact force: ")
    assert main(["plot", "a.txt", "-v"]) == 0
    assert capsys.readouterr().err == "ldbench: written: outputs/ldbench_plots.pdf\n"
    assert main(["run", "inputs/ex1_aw.nml", "-v"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1] == "ldbench: written: outputs/ex1_aw.txt" and any("ContactTable(" in line for line in lines)
    assert "not allowed with" in refused(["plot", "a.txt", "-v", "-q"], 2, capsys)


def test_a_file_without_our_names_is_refused_with_the_way_to_a_map(place: Path, capsys: pytest.CaptureFixture[str]):
    for words in ["plot", "other_code.csv"], ["compare", "other_code.csv", "other_code.csv"], ["view", "other_code.csv"]:
        told = refused(words, 1, capsys)
        assert "other_code.csv: expected a column time, --map TOML that names our columns, or --simulation NAME" in told


@pytest.mark.parametrize("words", ["compare a.txt other_code.csv", "plot other_code.csv --simulation ex2_aw", "view ex2_aw.csv",
                                   "view a.txt other_code.csv"])
def test_a_map_is_guessed(words: str, place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    """The simulation is the one that is given, that of the file's name, or that of our own file beside it; the columns are those of
    the written map."""
    shutil.copy("other_code.csv", "ex2_aw.csv")
    seen: list[ldbench.Run] = []
    for command, module in (("compare", "report.compare.compare"), ("plot", "plots.document.summary_row"),
                            ("view", "viewer.page.run_entry")):
        if words.startswith(command):
            name, home = module.rpartition(".")[2], import_module(f"ldbench.{module.rpartition('.')[0]}")
            real = getattr(home, name)

            def spy(runs: Any, *given: Any, real: Any = real, **more: Any) -> Any:
                seen.extend(runs if isinstance(runs, list) else [runs])
                return real(runs, *given, **more)

            monkeypatch.setattr(home, name, spy)
    assert main([*words.split(), "-o", f"made.{'html' if 'view' in words else 'pdf'}"]) == 0
    told = capsys.readouterr().err
    assert told.count("the map of its columns is guessed: time, Y, N_LF.") == 1
    expected = ldbench.read_run("other_code.csv", map="other_code.toml")
    found = seen[-1].data
    for column in "time", "Y", "N_LF":
        np.testing.assert_allclose(found[column], expected[column], rtol=1e-12)


def test_a_terminal_is_told_what_comes_next(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch):
    words = ["table", str(REPO/"inputs/ex1_aw.nml"), "--set", "formulation=unilateral"]
    told = {}
    for terminal in False, True:
        monkeypatch.setattr(sys.stdout, "isatty", lambda terminal=terminal: terminal)
        for options in (), ("--json",), ("-q",):
            assert main([*words, *options]) == 0
            told[terminal, options] = "next: " in capsys.readouterr().out
    assert [key for key, found in told.items() if found] == [(True, ())]


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


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_completion_knows_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit):
        main(["--completion", shell])
    said = capsys.readouterr().out
    assert all(command in said for command in COMMANDS) and "simulation" in said and "python -m" not in said


def as_json(x: object) -> object:
    """A number of the Python API as JSON has it."""
    if isinstance(x, dict):
        return {name: as_json(value) for name, value in x.items()}
    if isinstance(x, list | tuple | np.ndarray):
        return [as_json(value) for value in x]
    x = x.item() if isinstance(x, np.generic) else x
    return None if isinstance(x, float) and not math.isfinite(x) else x


def told(words: list[str], capsys: pytest.CaptureFixture[str]) -> list[dict]:
    """The lines of JSON that a command prints, without NaN."""
    capsys.readouterr()
    assert main([*words, "--json"]) == 0

    def refuse(word: str) -> float:
        raise AssertionError(f"{word} is no JSON")

    return [json.loads(line, parse_constant=refuse) for line in capsys.readouterr().out.splitlines()]


def test_json_of_run(place: Path, capsys: pytest.CaptureFixture[str]):
    """A line for each case: the results, events and processor time."""
    lines = told(["run", "inputs/ex1_aw.nml", "inputs/ex2_sw.nml"], capsys)
    assert [line["case"] for line in lines] == ["ex1_aw", "ex2_sw"]
    for line in lines:
        run = ldbench.read_run(line["file"])
        assert {name: line[name] for name in run.results} == as_json(run.results)
        assert line["events"] == [as_json({**event._asdict(), "impulses": dict(event.impulses)}) for event in run.events] != []
        assert line["seconds"] > 0
    assert lines[0]["peak_N_LT"] == ldbench.run("inputs/ex1_aw.nml").results["peak_N_LT"]


def test_json_of_table(place: Path, capsys: pytest.CaptureFixture[str]):
    table = ContactTable(Case.from_namelist("inputs/ex2_aw.nml"))
    line, = told(["table", "inputs/ex2_aw.nml", "-o", "geometry.txt"], capsys)
    expected = {"clearance_left": table.clearance, "clearance_right": table.clearance_right, "axle_height": table.equilibrium,
                "axle_roll": table.equilibrium_roll, "sinking": table.sinking, "load_per_wheel": table.load_per_wheel,
                "frequencies": table.frequencies, "model": "halfspace", "formulation": "elastic", "case": "ex2_aw"}
    assert {name: line[name] for name in expected} == as_json(expected)
    run = ldbench.run("inputs/ex2_aw.nml", table=table)
    assert line["error"] == {place: {"rms": rms, "largest": most} for place, (rms, most) in run.header.table_errors.items()}
    assert line["solutions"]["found"] == table.solutions[0] and line["solutions"]["not_converged"] == 0
    assert Path("geometry.txt").is_file()
    # With rigid contacts two of three frequencies are not known.
    line, = told(["table", "inputs/ex2_aw.nml", "--set", "formulation=unilateral"], capsys)
    assert len(line["frequencies"]) == 3 and None in line["frequencies"]


def test_json_of_pressure(place: Path, capsys: pytest.CaptureFixture[str]):
    """The patches of `run_patches` at the nearest row."""
    line, = told(["pressure", "a.txt", "--at", "0.0217", "--contact", "LF", "-o", "picture.png"], capsys)
    run = ldbench.read_run("a.txt")
    k = int(np.abs(run.time - 0.0217).argmin())
    assert line == as_json({"time": run.time[k], "patches": [patch.facts() for patch in run_patches(run, k, ["LF"])],
                            "picture": "picture.png"})
    assert line["patches"][0]["largest"] > 1e9 and Path("picture.png").is_file()
