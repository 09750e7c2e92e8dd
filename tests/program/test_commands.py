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
from ldbench.geometry.pair import pair
from ldbench.geometry.pressures import run_patches
from ldbench_round.fingerprint import hertz_table
from running import HANG, LDBENCH, REPO, Run, contents, once

TINY = {"model": "hertz", "n_lateral": 40, "n_roll": 9, "n_depth": 9}


# ---- options -------------------------------------------------------------------------
def parser_of(command: str) -> argparse.ArgumentParser:
    return make_parser([command]).commands[command]


PARSERS = {command: parser_of(command) for command in COMMANDS}
OPTIONS = {command: {string: action for action in parser._actions for string in action.option_strings}
           for command, parser in PARSERS.items()}
# The options that several commands have, and which ones.
SHARED = {
    ("-o", "--output"): {"run", "table", "profile", "pressure", "plot", "compare", "study", "formulations", "report", "view",
                         "ensemble", "collate"},
    ("-q", "--quiet"): set(COMMANDS),
    ("-v", "--verbose"): set(COMMANDS),
    ("-j", "--jobs"): {"run", "plot", "study", "formulations", "report", "ensemble", "collate"},
    ("--map",): {"plot", "compare", "check", "score", "fingerprint", "view"},
    ("--json",): {"run", "table", "profile", "pressure", "check", "score", "fingerprint"},
    ("--simulation",): {"check", "score", "fingerprint"},
    ("--reference",): {"score", "collate"},
    ("--set",): {"run", "table", "profile", "ensemble"},
    ("--scheduler",): {"study", "ensemble"},
}
OWN = {
    "run": set(), "table": set(), "pressure": {"--at", "--contact"}, "plot": {"--geometry"},
    "profile": {"--smoothing", "--unit", "--flip", "--wheel-back", "--slice", "--radii", "--en15302"},
    "compare": {"--align"}, "check": {"--save-map", "--show-map", "--all"}, "score": {"--all"}, "fingerprint": set(),
    "collate": set(), "study": set(),
    "formulations": set(), "report": {"--inputs", "--force"}, "view": {"--case", "--title", "--from", "--to", "--speed"},
    "ensemble": {"--over", "-n", "--draw", "--seed", "--columns", "--rows"}, "variables": set(),
}
REPEATED = {"--set", "--over", "--geometry"}        # as often as given, one value each
TOLD_BY_COMMAND = {"--output": {"help", "metavar", "default"}, "--jobs": {"help"}, "--scheduler": {"help"},
                   "--reference": {"required"}}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_has_these_options(command: str):
    shared = {string for strings, commands in SHARED.items() if command in commands for string in strings}
    assert set(OPTIONS[command]) == {"-h", "--help"} | shared | OWN[command]


@pytest.mark.parametrize("strings", SHARED, ids=lambda strings: strings[-1])
def test_an_option_has_one_meaning(strings: tuple[str, ...]):
    """An option takes one kind of value in one way, with the same words of help, but for what a command writes or does."""
    actions = [OPTIONS[command][strings[-1]] for command in sorted(SHARED[strings])]
    assert all(tuple(action.option_strings) == strings for action in actions)
    free = TOLD_BY_COMMAND.get(strings[-1], set())
    for name in {"dest", "nargs", "type", "choices", "metavar", "default", "help", "required"} - free:
        assert len({str(getattr(action, name)) for action in actions}) == 1, name
    assert len({type(action) for action in actions}) == 1


def test_help_tells_where_things_go_and_what_is_done_otherwise():
    for command in SHARED["-o", "--output"]:
        output = OPTIONS[command]["--output"]
        assert output.metavar in ("FILE", "DIR") and output.type in (Path, None)
        if output.default:
            assert str(output.default).startswith("outputs")
            assert str(output.default) in output.help or "%(default)s" in output.help
    for command in SHARED["-j", "--jobs"]:
        assert OPTIONS[command]["--jobs"].help.endswith("(all cores)")
    for strings in OPTIONS.values():
        for string, action in strings.items():
            assert action.help and (string in ("-h", "--help") or re.match("[a-z]|Zarr", action.help)), string


@pytest.mark.parametrize("command", COMMANDS)
def test_no_option_swallows_a_file(command: str):
    """An option takes one value or none; only a command's last words are as many as wanted."""
    for string, action in OPTIONS[command].items():
        assert action.nargs in (None, 0), string
        assert isinstance(action, argparse._AppendAction) == (string in REPEATED), string
    words = [action for action in PARSERS[command]._actions if not action.option_strings]
    assert all(action.nargs is None for action in words[:-1])


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


def test_help_lists_the_commands(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert end.value.code == 0 and all(f"{command} {purpose}" in said for command, purpose in COMMANDS.items())


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


def test_examples_are_found():
    """Every command has an example, and every block of the README is one; no block is of a kind that nobody looks at."""
    places = {example.where for example in ALL_EXAMPLES}
    assert places == {"help", "README", *(f"help of {command}" for command in COMMANDS)}
    assert {language for language, _ in FENCED} <= {"python", "sh", "bash", "console", "", "toml", "text"}
    assert PYTHON_BLOCKS and SHELL_BLOCKS and all("$ " in session for session in SESSIONS)
    for words in (*ONLY_PARSED, *SMALLER, *EVERY_CASE):
        assert any(words in example.text for example in ALL_EXAMPLES), f"no example has {words}"


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


def test_namelists_of_the_readme(place: Path):
    """They are understood, and run for a short time."""
    for source in NAMELIST_BLOCKS:
        case = Case.from_namelist(source)
        assert ldbench.run(case.replace(**TINY, t_end=100*case.dt, stop_at="t_end", interval=10*case.dt)).results["end"] == "t_end"


def test_the_readme_shows_what_the_executable_prints(shipped: dict[str, Run]):
    """Line by line, in this order, but for the lines that it leaves out and names of folders."""
    for session in SESSIONS:
        if found := re.match(r"\$ \./ldbench < inputs/(\w+)\.nml\n", session):
            printed = iter(re.sub(r"\S*/(?=\w+\.txt)", "", shipped[found[1]].summary).splitlines())
            for line in session.splitlines()[1:]:
                assert line == "..." or re.sub(r"\S*/(?=\w+\.txt)", "", line) in printed, line


def test_python_of_the_readme(place: Path, capsys: pytest.CaptureFixture[str]):
    """All blocks in one interpreter, in their order, with the small cases for the shipped ones."""
    import matplotlib

    matplotlib.use("Agg")
    names: dict[str, object] = {}
    for block in PYTHON_BLOCKS:
        exec(compile(block, "README.md", "exec"), names)
        for file in re.findall(r"savefig\(\"(.*?)\"\)|store=\"(.*?)\"", block):
            assert Path("".join(file)).exists()


# ---- statuses ------------------------------------------------------------------------
def refused(words: list[str], status: int, capsys: pytest.CaptureFixture[str]) -> str:
    """What a command says that ends with this status: one line."""
    capsys.readouterr()
    assert main(words) == status
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(r"ldbench: error: [^\n]+\n", said.err), said
    return said.err


@pytest.mark.parametrize(("words", "told"), [
    ([], "the following arguments are required: COMMAND"),
    (["rnu"], "invalid choice: 'rnu'"),
    (["run"], "required: NAMELIST"),
    (["run", "a.nml", "--unknown"], "--unknown"),
    (["run", "inputs/ex1_aw.nml", "inputs/ex2_aw.nml", "-o", "x.txt"], "-o: expected one namelist, found 2"),
    (["run", "inputs/ex1_aw.nml", "--set", "vY"], "expected name=value after --set, found vY"),
    (["run", "inputs/ex1_aw.nml", "--set"], "argument --set: expected one argument"),
    (["plot", "a.txt", "-j", "0"], "expected a number from 1, found 0"),
    (["compare", "a.txt", "--align", "peak"], "invalid choice: 'peak'"),
    (["study", "weather"], "invalid choice: 'weather'"),
    (["run", "a.nml", "--sett", "dt=1"], "unrecognized arguments: --sett"),
    (["view", "a.txt", "--from", "1"], "--from: expected with a film"),
    (["view", "a.txt", "-o", "a.mp4", "--speed", "0"], "expected a number above 0"),
    (["pressure", "a.txt"], "required: --at"),
    (["pressure", "a.txt", "--at", "0.01", "--contact", "XF"], "invalid choice: 'XF'"),
    (["check", "a.txt", "--simulation"], "expected one argument"),
    (["score", "a.txt"], "required: --reference"),
    (["fingerprint", "a.txt", "--simulation"], "expected one argument"),
    (["profile", "a", "b", "c"], "expected a wheel or a rail, or one of each, found 3 files"),
    (["ensemble", "inputs/ex1_aw.nml"], "required: --over"),
    (["ensemble", "inputs/ex1_aw.nml", "--over", "mass=1:2"], "expected name=1,2,4 or name=1:4:7 after --over"),
    (["ensemble", "inputs/ex1_aw.nml", "--over", "mass=1,2", "-n", "3"], "expected a range name=1:4 after --over with -n"),
], ids=lambda value: " ".join(value) if isinstance(value, list) else "")
def test_wrong_usage_has_status_2(words: list[str], told: str, capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                  monkeypatch: pytest.MonkeyPatch):
    """One line, and nothing is made; what argparse says tells how to learn more."""
    monkeypatch.chdir(tmp_path)
    assert told in refused(words, 2, capsys)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [
    ["run", "none.nml"], ["run", "inputs/ex1_aw.nml", "--set", "vY=fast"], ["run", "inputs/ex1_aw.nml", "--set", "dt=1e-5"],
    ["table", "none.nml"], ["table", "inputs/ex1_aw.nml", "-o", "missing/geometry.txt"], ["profile", "none.yz"],
    ["profile", "profiles/awprof.yz", "-o", "page.txt"], ["plot", "none.txt"], ["plot", "none.txt", "-o", "page.png"],
    ["pressure", "none.txt", "--at", "0"], ["pressure", "none.txt", "--at", "0", "-o", "page.txt"],
    ["check", "none.txt"], ["check", "ex1_aw.txt"], ["score", "ex1_aw.txt", "--reference", "none.txt"],
    ["fingerprint", "none.txt"], ["fingerprint", "ex1_aw.txt"],
    ["compare", "none.txt", "none.txt"], ["compare", "none.txt"],
    ["report", "--inputs", "none"], ["collate", "none"], ["collate", "."], ["collate", ".", "--reference", "none"],
    ["view", "none.txt"], ["view", "none.txt", "-o", "film.avi"], ["ensemble", "none.nml", "--over", "mass=1,2"],
    ["ensemble", "inputs/ex1_aw.nml", "--over", "masss=1,2"], ["variables", "masss"],
], ids=" ".join)
def test_a_failure_has_status_1_and_makes_nothing(words: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                                  monkeypatch: pytest.MonkeyPatch):
    """Above all no folder outputs/."""
    monkeypatch.chdir(tmp_path)
    refused(words, 1, capsys)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [["variables"], ["run", "--help"], ["--version"]], ids=" ".join)
def test_a_closed_pipe_is_no_error(words: list[str]):
    """Status 141, as a program has that SIGPIPE ends, and silence."""
    process = subprocess.Popen([sys.executable, "-m", "ldbench", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout and process.stderr
    process.stdout.close()
    said = process.stderr.read()
    assert (process.wait(HANG), said) == (141, b"")


@pytest.mark.parametrize(("words", "meant"), [
    (["run", "inputs/ex1_aw.nml", "--set", "masss=1"], "found masss; mass is the nearest"),
    (["run", "inputs/ex1_aw.nml", "--set", "wheel_profil=x"], "found wheel_profil; wheel_profile is the nearest"),
    (["table", "inputs/ex1_aw.nml", "--set", "n_lateralx=1"], "found n_lateralx; n_lateral is the nearest"),
    (["profile", "profiles/awprof.yz", "--set", "guage=1.4"], "found guage; gauge is the nearest"),
    (["ensemble", "inputs/ex1_aw.nml", "--over", "masss=1,2"], "found masss; mass is the nearest"),
    (["variables", "vertical_laod"], "found vertical_laod; vertical_load is the nearest"),
    (["run", "inputs/ex1_aw.nml", "--set", "file=x"], "found file, which is ambiguous"),
    (["run", "inputs/ex1_aw.nml", "--set", "entirely_different=1"], "found entirely_different"),
    (["ensemble", "inputs/ex1_aw.nml", "--over", "mass=1,2", "--over", "wheelset_mass=3,4"], "wheelset_mass, which are one"),
], ids=lambda value: " ".join(value) if isinstance(value, list) else "")
def test_the_nearest_name_is_told(words: list[str], meant: str, capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                  monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    assert f"{meant}\n" in refused(words, 1, capsys)


# ---- files ---------------------------------------------------------------------------
def new_files(folder: Path, before: dict[Path, tuple[bytes, int]]) -> set[str]:
    """The files made or changed since `before`."""
    return {str(path.relative_to(folder)) for path, found in contents(folder).items()
            if path.is_file() and found != before.get(path)}


@pytest.mark.parametrize(("words", "files"), [
    (["plot", "a.txt"], {"ldbench_plots.pdf"}),
    (["profile", "profiles/awprof.yz"], {"ldbench_profile.pdf"}),
    (["pressure", "a.txt", "--at", "0.0217"], {"ldbench_pressure.pdf"}),
    (["view", "a.txt"], {"a.html"}),
    (["run", "case.nml"], {"case.txt"}),
], ids=lambda value: value[0] if isinstance(value, list) else "")
def test_outputs_is_the_folder_of_what_gets_no_name(words: list[str], files: set[str], place: Path,
                                                    capsys: pytest.CaptureFixture[str]):
    """That of the working folder, which is made where it is missing; a command that is given another place makes none."""
    shutil.rmtree("outputs")
    small_case(2, "aw").replace(output_file="", name="case", table_file="", model="hertz").to_namelist("case.nml")
    before = contents(place)
    assert main(words) == 0
    assert new_files(place, before) == {f"outputs/{name}" for name in files}
    shutil.rmtree("outputs")
    ending = next(Path(name).suffix for name in sorted(files, reverse=True))
    assert main([*words, "-o", f"mine{ending}"]) == 0
    assert Path(f"mine{ending}").is_file() and not Path("outputs").exists()


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


@pytest.mark.parametrize(("words", "told"), [
    (["a.txt", "--at", "9"], "a.txt, --at 9: expected a time from 0 to 0.045 s, found 9"),
    (["a.txt", "--at", "0.0001", "--contact", "LF"], "a.txt, t = 0.000100 s: expected LF closed, found LT, RT"),
    (["strip.txt", "--at", "0"], "&contact model: expected 'halfspace', which has pressures, found 'strip'"),
    (["rigid.txt", "--at", "0"], "&contact formulation: expected 'elastic', which has pressures, found 'unilateral'"),
    (["other.txt", "--at", "0"], "expected the header of ldbench, which tells the case, found none"),
    (["changed.txt", "--at", "0"], "expected the profile of the run changed.txt, found one that has changed since"),
], ids=["time", "contact", "model", "formulation", "header", "profile"])
def test_pressure_says_why_there_is_none(words: list[str], told: str, place: Path, capsys: pytest.CaptureFixture[str]):
    text = Path("a.txt").read_text()
    Path("strip.txt").write_text(re.sub("model *= *'halfspace'", "model = 'strip'", text))
    Path("rigid.txt").write_text(re.sub("formulation *= *'elastic'", "formulation = 'unilateral'", text))
    Path("changed.txt").write_text(re.sub("CRC-32 [0-9A-F]{8}", "CRC-32 00000000", text))
    Path("other.txt").write_text("time Y\n0 0\n1 0\n")
    before = contents(place)
    assert told in refused(["pressure", *words], 1, capsys)
    assert not new_files(place, before)


def test_json_of_profile(place: Path, capsys: pytest.CaptureFixture[str]):
    line, = told(["profile", "profiles/awprof.yz", "profiles/arprof.yz", "-o", "page.png"], capsys)
    wheel, rail = (ldbench.Profile(f"profiles/{name}.yz") for name in ("awprof", "arprof"))
    assert line["profiles"] == as_json([wheel.facts(), rail.facts()]) and line["page"] == "page.png"
    assert line["pair"] == as_json(pair(Case(wheel_profile="profiles/awprof.yz", rail_profile="profiles/arprof.yz")).facts())
    assert line["profiles"][0]["Sh"] == wheel.measures["Sh"] and line["profiles"][1]["points"] == len(rail.points)
