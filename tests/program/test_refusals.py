"""What is refused: an input, words of its message and the exit status. Each is told in one line, and no file is made or touched."""
from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from ldbench import Case, run
from ldbench.__main__ import main
from running import REPO, contents, refusal, short_case

# Namelists beside those of test_inputs.py: a text, or what differs from a short case by group. `{here}` in a value is the folder.
OWN = {"profiles": {"wheel_profile": "./wheel.yz", "rail_profile": "rail.yz"}}
NAMELISTS: list[tuple[str | dict[str, dict[str, object]], tuple[str, ...]]] = [
    ("&track rail_inclination = '1:-40' /", ("line 1, &track rail_inclination: expected a number from -0.12 to 0.12 rad, or 1:n",)),
    ("&track rail_inclination_right = '1:5' /", ("&track rail_inclination_right: expected a number from -0.12 to 0.12 rad, 1:n",)),
    ({"case": {"name": "a/b"}}, ("&case name", "expected a word that can name a file", "a/b")),
    # Values that do not fit each other or the profiles.
    ({"track": {"gauge": 1.2}}, ("&track gauge = 1.2 m", "back_to_back = 1.35214 m", "awprof.yz", "arprof.yz")),
    ({"wheelset": {"back_to_back": 1.6}}, ("&track gauge = 1.4351 m", "back_to_back = 1.6 m")),
    ({"track": {"gauge_depth": 0.05}}, ("&track gauge_depth", "0.05", "arprof.yz")),
    ({"profiles": {"wheel_profile": REPO/"profiles/arprof.yz", "rail_profile": REPO/"profiles/awprof.yz"}},
     ("&profiles wheel_profile", "arprof.yz: expected a wheel, with z up and y from its back")),
    ({"profiles": {"rail_profile": REPO/"profiles/awprof.yz"}}, ("awprof.yz: the rail has no gauge face 0.014 m below its top",)),
    ({"profiles": {"rail_profile": "missing.yz"}}, ("&profiles rail_profile: missing.yz: cannot be opened for reading",)),
    ({"integrator": {"dt": 1e-3}, "output": {"interval": 1e-4}}, ("&output interval", "dt = 0.001 s, found 1.0E-4")),
    ({"integrator": {"t_end": 1e3, "dt": 1e-9}, "output": {"interval": 1e1}}, ("1e9 steps between rows", "found 1.0E+10")),
    ({"integrator": {"t_end": 1e5, "dt": 1e-9}, "output": {"interval": 1e-3}}, ("&output interval", "1e7 rows", "found 1.0E+8")),
    ({"integrator": {"order": 3}}, ("&integrator order: expected 2 or 4, found 3",)),
    ({"output": {"interval": 3e-3}}, ("&output interval: expected at most &integrator t_end = 0.002 s, found 0.003",)),
    ({"integrator": {"order": 4, "beta": 0.25}}, ("&integrator beta: expected 0 with order = 4, found 0.25",)),
    ({"integrator": {"order": 4, "beta": 0.0, "gamma": 0.6}}, ("&integrator gamma: expected 0.5 with order = 4, found 0.6",)),
    # Rigid contacts.
    *(({"contact": {"formulation": "unilateral", "restitution": wrong}}, ("&contact restitution: expected a number from 0.0 to",))
      for wrong in (1.1, -0.1)),
    *(({"contact": contact | {"restitution": 0.5}}, ("&contact restitution: expected 1",)) for contact in (
        {}, {"formulation": "bilateral"})),
    ({"contact": {"formulation": "bilateral", "stiffness_scale": 2.0}}, ("&contact stiffness_scale: expected 1",)),
    ({"contact": {"formulation": "bilateral"}, "initial": {"Y": 0.05}, "table": {"lateral": 0.04}},
     ("&initial Y = 0.05 m: expected a wheelset that can stand on both rails",)),
    # Poses off the contact table.
    ({"initial": {"vY": 20.0}, "integrator": {"t_end": 0.1}}, ("&table ", "expected", "found", "at t = ", "Y = ")),
    ({"initial": {"vZ": -20.0}, "integrator": {"t_end": 0.1}}, ("&table depth", "expected", "found", "at t = ")),
    ({"initial": {"Z": -0.01}}, ("&table depth = 0.0022 m", "expected", "found", "Z = -0.01")),
    ({"table": {"depth": 1e-6}}, ("&wheelset vertical_load = 164618.0 N", "&table depth = 1.0E-6 m", "expected", "found")),
    ({"integrator": {"order": 2, "beta": 0.25, "dt": 2e-3, "t_end": 0.1, "max_iterations": 1, "max_halvings": 0},
      "output": {"interval": 2e-3}}, ("&integrator dt = 0.002 s", "expected Newton's method to", "found that it does not")),
    # Files.
    ({"output": {"file": "{here}/missing/columns"}}, ("{here}/missing/columns", "&output file: expected", "found")),
    ({"output": {"file": "{here}/folder"}}, ("{here}/folder", "&output file: expected", "found")),
    *((OWN | {"output": {"file": "columns.txt"}} | {group: {name: victim}},
       (f"&{group} {name}: expected a file of its own, found {victim}, which is ",))
      for group, name, victim in (("output", "file", "./rail.yz"), ("output", "file", "case.nml"),
                                  ("output", "file", "loop/wheel.yz")))]


def filled(value: object, here: Path) -> object:
    return value.replace("{here}", str(here)) if isinstance(value, str) else value


@pytest.mark.parametrize(("source", "words"), NAMELISTS, ids=range(len(NAMELISTS)))
def test_a_namelist_is_refused(source: str | dict[str, dict[str, object]], words: tuple[str, ...], tmp_path: Path,
                                 capsys: pytest.CaptureFixture[str]):
    """By the executable; by Python in the same words, blank for blank."""
    (tmp_path/"folder").mkdir()
    (tmp_path/"loop").symlink_to(".")
    shutil.copy(REPO/"profiles/awprof.yz", tmp_path/"wheel.yz")
    shutil.copy(REPO/"profiles/arprof.yz", tmp_path/"rail.yz")
    text = source if isinstance(source, str) else short_case(tmp_path, **{
        group: {name: filled(value, tmp_path) for name, value in values.items()} for group, values in source.items()})
    message = refusal(text, tmp_path)
    for word in ("case.nml", *words):
        assert str(filled(word, tmp_path)) in message
    if isinstance(source, str):
        assert main(["run", str(tmp_path/"case.nml")]) == 1
        assert capsys.readouterr().err == f"{message}\n"


# Commands in a folder with the files of `things`: words, exit status, message.
COMMANDS: list[tuple[str, int, str]] = [
    ("", 2, "the following arguments are required: COMMAND"), ("rnu", 2, "invalid choice: 'rnu'"),
    ("run", 2, "required: NAMELIST"), ("run a.nml --unknown", 2, "--unknown"), ("run none.nml", 1, "none.nml"),
    ("run case.nml other.nml -o x.txt", 2, "-o: expected one namelist, found 2"),
    ("run case.nml --set vY", 2, "expected name=value after --set, found vY"),
    ("run case.nml --set vY=fast", 1, "case.nml, &initial vY: expected a number"),
    ("run case.nml --set masss=1", 2, "found masss; mass is the nearest"),
    ("run case.nml --set vY=0.9", 1, "columns.txt is the file of the unchanged case"),
    ("run case.nml -o missing/x.txt", 1, "case.nml, &output file: expected a path that can be written, found missing/x.txt"),
    ("table case.nml -o missing/x.txt", 1, "missing/x.txt: expected a folder that is there, found none"),
    ("table case.nml -o case.nml", 1, "case.nml: expected a file of its own to write"),
    ("variables masss", 2, "found masss; mass is the nearest"),
    ("profile none.yz", 1, "none.yz"), ("profile a b c", 2, "expected a wheel or a rail, or one of each, found 3 files"),
    ("profile wheel.yz -o page.txt", 1, "page.txt"),
    ("profile wheel.yz --en15302 A", 2, "expected a wheel and a rail for --en15302, found one profile"),
    ("profile wheel.yz --radii 0.46,0.459", 2, "expected a wheel and a rail for --radii, found one profile"),
    ("plot foreign.csv", 1, "foreign.csv"),
    ("compare back.csv", 2, "expected at least two files"),
    ("compare back.csv back.csv --align peak", 2, "invalid choice: 'peak'"),
    ("pressure ours.txt", 2, "required: --at"), ("pressure ours.txt --at 9", 1, "ours.txt, --at 9: expected a time from 0 to "),
    ("pressure ours.txt --at 0", 1, "&contact model: expected 'halfspace', which has pressures, found 'hertz'"),
    ("pressure plain.csv --at 0", 1, "expected the header of ldbench, which tells the case, found none"),
    ("check ours.txt --simulation", 2, "expected one argument"),
    ("score ours.txt", 2, "required: --reference"), ("fingerprint none.txt", 1, "none.txt"),
    ("report --inputs none", 1, "none"), ("report --inputs wrong", 1, "ex6_aw.nml, &case name: expected"),
    ("ensemble case.nml", 2, "required: --over"),
    ("ensemble case.nml --over mass=1:2", 2, "expected name=1,2,4 or name=1:4:7 after --over"),
    ("ensemble case.nml --over mass=1,2 -n 3", 2, "expected a range name=1:4 after --over with -n"),
    ("ensemble case.nml --over mass=1:2 -n 2 --seed -1", 1, "a seed from 0"),
    ("ensemble case.nml --over mass=1,2 --over wheelset_mass=3,4", 1, "wheelset_mass, which are one"),
    ("view none.txt", 1, "cannot be opened for reading"), ("view ours.txt --from 0", 2, "--from: expected with a film"),
    ("view ours.txt -o ours.txt", 1, "expected a"), ("view ours.txt -o film.avi", 1, "found .avi"),
    ("view ours.txt -o film.gif --from 7", 1, "expected times from 0 to "),
    ("view ours.txt -o film.gif --speed 1e-12", 1, "expected at most 20000 frames"),
    ("view unnamed.csv", 1, "expected a column time, --map TOML that names our columns, or --simulation NAME"),
    ("view back.csv", 1, "expected rows with ascending times")]


@pytest.fixture(scope="module")
def things(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("things")
    case = Case.exercise(3, "aw").replace(model="hertz", table_folder="", t_end=2e-3,
                                          output_file="columns.txt", wheel_profile=REPO/"profiles/awprof.yz",
                                          rail_profile=REPO/"profiles/arprof.yz")
    for name in "case", "other":
        case.to_namelist(folder/f"{name}.nml")
    run(case).write(folder/"ours.txt")
    (folder/"unnamed.csv").write_text("t,Y\n0,0\n1,1\n")
    (folder/"foreign.csv").write_text("a,b\n1,2\n3,4\n")
    (folder/"plain.csv").write_text("time,Y\n0,0\n1,1\n")
    (folder/"wrong").mkdir()
    (folder/"wrong/ex6_aw.nml").write_text("&case name = 'ex6_aw' /\n")
    (folder/"back.csv").write_text("time,Y\n0,0\n1,1\n0.5,2\n")
    shutil.copy(REPO/"profiles/awprof.yz", folder/"wheel.yz")
    return folder


@pytest.mark.parametrize(("words", "status", "told"), COMMANDS, ids=[words or "nothing" for words, *_ in COMMANDS])
def test_a_command_is_refused(words: str, status: int, told: str, things: Path, capsys: pytest.CaptureFixture[str],
                              monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(things)
    before = contents(things)
    assert main(words.split()) == status
    said = capsys.readouterr()
    assert said.out == "" and re.fullmatch(r"ldbench: error: [^\n]+\n", said.err) and told in said.err, said
    assert contents(things) == before
