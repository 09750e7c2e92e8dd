"""The sub-commands of `python -m ldbench`: their options, statuses and files, and every example that help and README give."""
from __future__ import annotations

import argparse
import functools
import importlib
import itertools
import json
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import ldbench
import shapes
from ldbench import Case, ContactTable
from ldbench.__main__ import EXAMPLES, PROGRAM, main, make_parser
from ldbench.commands import COMMANDS, module_of
from ldbench.geometry.pressures import run_patches
from ldbench_round.fingerprint import hertz_table
from running import HANG, LDBENCH, REPO, once

TINY = {"model": "hertz", "n_lateral": 40, "n_roll": 9, "n_depth": 9}


# ---- options -------------------------------------------------------------------------
def parser_of(command: str) -> argparse.ArgumentParser:
    return make_parser([command]).commands[command]


PARSERS = {command: parser_of(command) for command in COMMANDS}
OPTIONS = {command: {string: action for action in parser._actions for string in action.option_strings}
           for command, parser in PARSERS.items()}


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
    assert all(string in said for string in OPTIONS[command])
    examples = said.partition("\nexamples:\n")[2].strip().splitlines()
    assert examples and all(line.strip().startswith(f"{PROGRAM} {command}") for line in examples)


# ---- a folder with small things of all kinds -----------------------------------------
@pytest.fixture(scope="module")
def made(common: Path) -> Path:
    """Namelists exN_PAIR.nml of runs that take some milliseconds, their column files in outputs/, profiles in other formats, a
    file of another code: what the examples name."""
    place = common/"small"
    with once(place) as first:
        if first:
            make_place(place)
    return place


def small_case(exercise: int, pair: str) -> Case:
    """To just after the flange's first contact where there is one; 300 rows. The actual profiles have half-spaces."""
    t_end = {1: 0.2, 2: 0.045, 3: 0.03, 4: 0.03, 5: 0.03}[exercise]
    model = {"model": "halfspace"} if pair == "aw" else {}
    return Case.exercise(exercise, pair).replace(**TINY | model, t_end=t_end, stop_at="t_end", interval=t_end/300, rows="interval",
                                                 dt=t_end/900, table_file=f"outputs/{pair}.table")


def make_place(place: Path) -> None:
    (place/"inputs").mkdir()
    (place/"outputs").mkdir()
    (place/"profiles").symlink_to(REPO/"profiles")
    (place/"ldbench").symlink_to(LDBENCH)
    before = Path.cwd()
    os.chdir(place)
    try:
        for exercise in range(1, 6):
            for pair_name in "aw", "sw":
                case = small_case(exercise, pair_name)
                case.to_namelist(f"inputs/{case.case_name}.nml")
                if case.case_name in ("ex1_aw", "ex2_aw"):
                    ldbench.run(case).write(case.output_file)
        for name, step in ("a", 1e-5), ("b", 2e-5), ("c", 5e-5):
            case = small_case(2, "aw")
            ldbench.run(case.replace(dt=step, interval=1e-4)).write(f"{name}.txt")
        ContactTable(small_case(1, "aw")).write_geometry("outputs/geometry_aw.txt")
        wheel, rail = shapes.with_faces(shapes.shape("awprof")), shapes.shape("arprof")
        for name in "wheel.whl", "left.whl":
            Path(name).write_text(shapes.miniprof_new(wheel, "wheel"))
        Path("right.whl").write_text(shapes.miniprof_new(shapes.with_faces(shapes.thin_flange(shapes.shape("awprof"))), "wheel"))
        Path("rail.ban").write_text(shapes.miniprof_new(rail, "rail"))
        data = ldbench.read_run("outputs/ex2_aw.txt").data
        Path("other_code.csv").write_text("t [s],ylat [mm],NLF [kN]\n" + "".join(
            f"{t:.9g},{-1e3*y:.9g},{1e-3*n:.9g}\n" for t, y, n in zip(data.time, data.Y, data.N_LF, strict=True)))
        for code in "one", "two":
            (Path("codes")/code).mkdir(parents=True)
            shutil.copy("other_code.csv", f"codes/{code}/ex2_aw.csv")
        shutil.copy("a.txt", "codes/two/ex2_aw.txt")
        Path("other_code.toml").write_text('time = "t"\nY = { column = "ylat", factor = -1 }\nN_LF = "NLF"\n')
    finally:
        os.chdir(before)


def draw_few(monkeypatch: pytest.MonkeyPatch, module: str, figures: str, pages: int) -> None:
    """Let a document have its first pages alone; all of them are drawn by the tests of plots, comparison and report."""
    drawn = getattr(importlib.import_module(module), figures)
    monkeypatch.setattr(f"{module}.{figures}", lambda *given: itertools.islice(drawn(*given), pages))


@pytest.fixture
def place(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, which is the working folder, and where the shipped cases are looked for."""
    folder = tmp_path/"place"
    shutil.copytree(made, folder, symlinks=True)
    monkeypatch.chdir(folder)
    monkeypatch.setattr("ldbench.case.data_folder", lambda: folder)
    # Tables of these cases are not those of the shipped ones, which other tests ask for.
    monkeypatch.setattr("ldbench_round.fingerprint.hertz_table", functools.cache(hertz_table.__wrapped__))
    draw_few(monkeypatch, "ldbench.plots.document", "case_figures", 1)
    draw_few(monkeypatch, "ldbench.report.compare", "comparison_figures", 4)
    return folder


# ---- examples ------------------------------------------------------------------------
class Example(NamedTuple):
    """Something to run, and where it is written."""

    where: str
    text: str


def examples_of_help() -> Iterator[Example]:
    for line in EXAMPLES.splitlines():
        if line.startswith(f"  {PROGRAM}"):
            yield Example("help", line.strip())
    for command in COMMANDS:
        told = module_of(command).__doc__ or ""
        for line in told.partition("\n\nexamples:\n")[2].splitlines():
            yield Example(f"help of {command}", line.strip())


README = (REPO/"README.md").read_text(encoding="utf-8")


def fenced(text: str) -> tuple[list[tuple[str, str]], str]:
    """Blocks between ``` with their language, and the text without them."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL), re.sub(
        r"^```\w*\n.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


def indented(text: str) -> list[str]:
    """Blocks of lines with four blanks, between empty lines."""
    return [re.sub("^    ", "", block, flags=re.MULTILINE) for block in re.findall(r"(?<=\n\n)((?:    .*\n)+)", text)]


FENCED, PROSE = fenced(README)
BLOCKS = indented(PROSE)
PYTHON_BLOCKS = [*(text for language, text in FENCED if language == "python"),
                 *(text for text in BLOCKS if text.startswith("import "))]
NAMELIST_BLOCKS = [text for text in BLOCKS if text.startswith("&")]
SHELL_BLOCKS = [text for text in BLOCKS if text not in PYTHON_BLOCKS and text not in NAMELIST_BLOCKS] + [
    text for language, text in FENCED if language in ("", "sh", "bash")]
SESSIONS = [text for language, text in FENCED if language == "console"]      # commands after $, and what they print


def examples_of_readme() -> Iterator[Example]:
    """The commands of the blocks, line by line, and those in the text that have arguments."""
    for block in (*SHELL_BLOCKS, *SESSIONS):
        for line in re.sub(r"\\\n *", " ", block).splitlines():
            if line.startswith("$ ") if block in SESSIONS else line.strip() and not line.startswith("#"):
                yield Example("README", line.removeprefix("$ ").strip())
    for span in re.findall(r"`([^`]+)`", re.sub(r"```.*?```", "", README, flags=re.DOTALL)):
        words = span.split()[len(PROGRAM.split()):]
        if span.startswith(PROGRAM) and words and not is_a_name(words):
            yield Example("README", " ".join(span.split()))


def is_a_name(words: list[str]) -> bool:
    """Whether this is no command to type in but the name of one that needs more words."""
    needs = [action for action in PARSERS[words[0]]._actions if action.required] if words[0] in PARSERS else []
    return len(words) == 1 and bool(needs)


# Each text once, where it stands first.
ALL_EXAMPLES = list({example.text: example for example in reversed([*examples_of_help(), *examples_of_readme()])}.values())[::-1]
# What takes minutes, or needs another machine: only parsed, as it stands.
ONLY_PARSED = {"report -o trial": "the report of the example before it, in another folder",
               "study derailment": "600 runs and more with tables of their own",
               "--scheduler tcp://": "a scheduler on another machine"}
# What is run with other words, by the time that it would take.
SMALLER = {"--speed 1e-3": "--speed 2e-2", "-n 50": "-n 2"}
# What runs every case of inputs/: it gets exercise 3 alone, and for the report with both pairs of profiles.
EVERY_CASE = "report", "formulations", "study contact-law"
# What is not run but has to be there.
TARGETS = {found[1] for found in re.finditer(r"^([\w-]+):", (REPO/"Makefile").read_text(), re.MULTILINE)}


def run_words(words: list[str]) -> int:
    """A command in this process; --help and --version end it by an exit."""
    try:
        return main(words)
    except SystemExit as end:
        return int(end.code or 0)


def run_example(text: str, folder: Path) -> None:
    """A line of the shell, piece by piece."""
    if text.startswith("for "):
        done = subprocess.run(["sh", "-ec", text], cwd=folder, capture_output=True, text=True, timeout=HANG)
        assert (done.returncode, done.stderr) == (0, "")
        return
    for piece in map(str.strip, re.split(r"&&|;", text.partition(" #")[0])):
        words = shlex.split(piece)
        if words[0] == "./ldbench":
            done = subprocess.run(["sh", "-ec", piece], cwd=folder, capture_output=True, text=True, timeout=HANG)
            assert (done.returncode, done.stderr) == (0, "")
        elif words[:3] == PROGRAM.split():
            arguments = [name for word in words[3:] for name in (sorted(map(str, Path().glob(word))) if "*" in word else [word])]
            # The runs here end long before the wheelset returns, which is what a check is for.
            assert run_words(arguments) == int(words[3] == "check")
        elif words[0] in ("./bootstrap", "."):
            assert (REPO/words[0]).exists()         # what it does is tested elsewhere
        elif words[0] == "make":
            assert [word for word in words[1:] if "=" not in word and word not in TARGETS] == []
        else:
            assert words[0] in ("pip", "dask", "python", "tail"), f"{piece}: nobody knows how to try this"


@pytest.mark.parametrize("example", ALL_EXAMPLES, ids=lambda example: f"{example.where}: {example.text}")
def test_example(example: Example, place: Path, capsys: pytest.CaptureFixture[str]):
    """It does its work in silence, or the lines that it prints, and writes what it says."""
    text = example.text
    if any(words in text for words in ONLY_PARSED):
        words = shlex.split(text)[3:]
        assert PARSERS[words[0]].parse_args(words[1:])
        return
    for words, smaller in SMALLER.items():
        text = text.replace(words, smaller)
    if any(text.removeprefix(f"{PROGRAM} ").startswith(words) for words in EVERY_CASE):
        kept = "ex3_*.nml" if " report" in text else "ex3_aw.nml"
        for file in set(Path("inputs").glob("*.nml")) - set(Path("inputs").glob(kept)):
            file.unlink()
    run_example(text, place)
    said, told = capsys.readouterr()
    assert "ldbench: error" not in told and "Traceback" not in told
    if found := re.search(rf"{re.escape(PROGRAM)} (\w+) .*-o (\S+)", text):
        assert Path(found[2]).exists(), said


# ---- statuses ------------------------------------------------------------------------
def refused(words: list[str], status: int, capsys: pytest.CaptureFixture[str]) -> str:
    """What a command says that ends with this status: one line."""
    capsys.readouterr()
    assert main(words) == status
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(r"ldbench: error: [^\n]+\n", said.err), said
    return said.err


@pytest.mark.parametrize("words", [["variables"], ["run", "--help"], ["--version"]], ids=" ".join)
def test_a_closed_pipe_is_no_error(words: list[str]):
    """Status 141, as a program has that SIGPIPE ends, and silence."""
    process = subprocess.Popen([sys.executable, "-m", "ldbench", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout and process.stderr
    process.stdout.close()
    said = process.stderr.read()
    assert (process.wait(HANG), said) == (141, b"")


# ---- several cases, numbers for other programs ---------------------------------------
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


def test_two_cases_do_not_write_one_file(place: Path, capsys: pytest.CaptureFixture[str]):
    assert "a file of its own" in refused(["run", "inputs/ex1_aw.nml", "./inputs/ex1_aw.nml"], 1, capsys)


def test_cases_side_by_side_are_those_one_after_the_other(place: Path, capsys: pytest.CaptureFixture[str]):
    """The order of what is printed is that of the namelists, and each contact table is built once."""
    names = [f"inputs/ex{k}_{pair}.nml" for pair in ("sw", "aw") for k in (3, 1)]
    found = []
    for jobs in "1", "4":
        for table in Path("outputs").glob("*.table"):
            table.unlink()
        assert main(["run", *names, "-j", jobs, "--json"]) == 0
        found.append([json.loads(line) | {"seconds": 0} for line in capsys.readouterr().out.splitlines()])
    assert found[0] == found[1] and [line["case"] for line in found[0]] == ["ex3_sw", "ex1_sw", "ex3_aw", "ex1_aw"]


# ---- how much is said ----------------------------------------------------------------
def test_quiet_says_nothing_but_errors_and_json(place: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["run", "inputs/ex1_aw.nml", "-q"]) == 0 and main(["compare", "a.txt", "b.txt", "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert main(["table", "inputs/ex1_aw.nml", "--json", "-q"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["case"] == "ex1_aw" and said.err == ""
    assert "none.nml" in refused(["run", "none.nml", "-q"], 1, capsys)
    assert main(["table", "inputs/ex1_aw.nml", "--json"]) == 0
    assert capsys.readouterr().err.startswith("ldbench: warning: contact table: ")


def test_verbose_tells_what_is_written(place: Path, capsys: pytest.CaptureFixture[str]):
    assert main(["plot", "a.txt", "-v"]) == 0
    assert capsys.readouterr().err == "ldbench: written: outputs/ldbench_plots.pdf\n"
    assert main(["run", "inputs/ex1_aw.nml", "-v"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1] == "ldbench: written: outputs/ex1_aw.txt" and any("ContactTable(" in line for line in lines)
    assert "not allowed with" in refused(["plot", "a.txt", "-v", "-q"], 2, capsys)


@pytest.mark.parametrize("words", [["plot", "ex2_aw.csv"], ["compare", "a.txt", "ex2_aw.csv"], ["view", "a.txt", "ex2_aw.csv"]],
                         ids=lambda words: words[0])
def test_a_file_without_our_names_is_refused_with_the_way_to_a_map(words: list[str], place: Path,
                                                                    capsys: pytest.CaptureFixture[str]):
    shutil.copy("other_code.csv", "ex2_aw.csv")
    told = refused(words, 1, capsys)
    assert "ex2_aw.csv: expected a column time, or --map TOML" in told and "--save-map" in told


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


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
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
    if isinstance(x, float | np.floating):
        return float(x) if math.isfinite(x) else None
    return x.item() if isinstance(x, np.generic) else x


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
    table = ContactTable(Case.from_namelist("inputs/ex2_aw.nml").replace(model="strip", table_file="strip.table"))
    line, = told(["table", "inputs/ex2_aw.nml", "-o", "geometry.txt", "--set", "model=strip", "--set", "table_file=strip.table"],
                 capsys)
    expected = {"clearance_left": table.clearance, "clearance_right": table.clearance_right, "axle_height": table.equilibrium,
                "axle_roll": table.equilibrium_roll, "approach": table.approach, "load_per_wheel": table.load_per_wheel,
                "frequencies": table.frequencies, "found": True, "model": "strip", "formulation": "elastic", "case": "ex2_aw"}
    assert {name: line[name] for name in expected} == as_json(expected)
    assert line["error"]["left"] == {place: {"poses": error.poses, "rms": error.rms, "largest": error.largest}
                                     for place, error in table.accuracy.items()}
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
