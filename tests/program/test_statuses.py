"""One rule of exit status: 0 done, 1 refused or not all done, 2 usage; one line tells why, and --json prints JSON in any case."""
from __future__ import annotations

import json
import re
import shutil
import stat
from pathlib import Path

import pytest

import ldbench
from invented import COARSE
from ldbench.__main__ import main
from running import REPO, kept_tables


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A short case, and a column file without our header."""
    monkeypatch.chdir(tmp_path)
    case = ldbench.Case.exercise(3).replace(**COARSE | {"dt": 1e-5, "t_end": 1e-3, "table_folder": kept_tables(),
                                                        "output_file": "short.txt"})
    case.to_namelist("case.nml")
    shutil.copy(REPO/"outputs/reference/ex2_aw.txt", "a.txt")
    return tmp_path


# The words after `ldbench`, the status, and what standard error says.
CALLS = [
    ("run case.nml", 0, ""),
    ("case.nml", 0, ""),
    ("run none.nml", 1, "none.nml"),
    ("none.nml", 1, "none.nml"),
    ("rum case.nml", 2, "run is the nearest"),
    ("run case.nml --jsn", 2, "--json is the nearest"),
    ("run case.nml --set vY", 2, "expected name=value after --set, found vY"),
    ("run case.nml --set modelx=hertz", 2, "expected a namelist variable"),
    ("run case.nml --set model=hurtz", 1, "&contact model"),
    ("run case.nml case.nml -o both.txt", 2, "-o: expected one namelist, found 2"),
    ("run case.nml -j 0", 2, "expected a number from 1, found 0"),
    ("run case.nml -o case.nml", 1, "found case.nml, which is the namelist itself"),
    ("table case.nml -o none/geometry.txt", 1, "expected a folder that is there, found none"),
    ("trust case.nml --json one.png --picture one.png", 1, "expected a file of its own to write"),
    ("table case.nml --set modelx=hertz", 2, "model is the nearest"),
    ("variables modelx", 2, "model is the nearest"),
    ("ensemble case.nml --over mas=1,2", 2, "mass is the nearest"),
    ("ensemble case.nml --over mass=1500", 0, ""),
    ("ensemble case.nml --over mass=1500,-1", 1, ""),
    ("compare a.txt", 2, "expected at least two files"),
    ("profile a b c", 2, "expected a wheel or a rail, or one of each"),
    ("plot a.txt --geometry a.txt", 1, "a.txt: expected geometry functions as `python -m ldbench table NAMELIST -o FILE`"),
    ("plot", 2, "required"),
    ("plot a.txt -o a.xyz", 1, ".xyz")]


@pytest.mark.parametrize(("words", "status", "told"), CALLS, ids=[words for words, *_ in CALLS])
def test_status(words: str, status: int, told: str, folder: Path, capsys: pytest.CaptureFixture[str]):
    assert main(words.split()) == status
    said = capsys.readouterr().err
    assert told in said and "Traceback" not in said
    assert re.fullmatch(r"ldbench: error: [^\n]+\n", said) if told else "error" not in said


@pytest.mark.parametrize("words", ["run none.nml", "check none.txt", "check b.txt", "score b.txt --reference b.txt",
                                   "pressure b.txt --at 0",
                                   "fingerprint b.txt", "run case.nml --set modelx=3"])
def test_json_is_printed_of_what_is_refused(words: str, folder: Path, capsys: pytest.CaptureFixture[str]):
    """The line of the error is the value of `error`."""
    Path("b.txt").write_text("time,Y\n")
    assert main([*words.split(), "--json"]) in (1, 2)
    said = capsys.readouterr()
    assert said.err == f"ldbench: error: {json.loads(said.out.splitlines()[-1])['error']}\n"


def test_our_own_file_says_its_simulation_itself(folder: Path, capsys: pytest.CaptureFixture[str]):
    """The file has its first rows alone, too few for the laws, so the check itself fails."""
    ldbench.run(ldbench.Case.exercise(2).replace(model="hertz", t_end=1e-3, table_folder=kept_tables())).write("mine.txt")
    assert main(["check", "mine.txt", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["files"][0]["simulation"] == "ex2_aw"


def test_hints_name_the_command_as_it_was_called(folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    for program, other in ("ldbench", "python -m ldbench"), ("python -m ldbench", "`ldbench"):
        monkeypatch.setattr("ldbench.__main__.PROGRAM", program)
        for words in ["run", "--set", "modelx=3", "case.nml"], ["plot", "a.txt", "--geometry", "a.txt"]:
            assert main(words) in (1, 2)
            said = capsys.readouterr().err
            assert re.search(rf"{program} (variables|table)", said) and other not in said
        with pytest.raises(SystemExit):
            main(["run", "--help"])
        assert f"  {program} run inputs/ex1_aw.nml" in capsys.readouterr().out.splitlines()


def test_a_file_that_is_replaced_keeps_its_mode(folder: Path, undrawn: None):
    for name in "keep.nml", "keep.csv":
        Path(name).touch()
        Path(name).chmod(0o600)
    Path("link.nml").symlink_to("keep.nml")
    ldbench.Case().to_namelist("link.nml")
    assert Path("link.nml").is_symlink() and ldbench.Case.from_namelist("keep.nml") == ldbench.Case()
    assert stat.S_IMODE(Path("keep.nml").stat().st_mode) == 0o600


def test_ensemble_tells_the_first_peak(folder: Path, capsys: pytest.CaptureFixture[str]):
    case = ldbench.Case.from_namelist("case.nml").replace(t_end=0.02, roll_link="rails")
    case.to_namelist("longer.nml")
    assert main(["ensemble", "longer.nml", "--over", "vY=0.9,1.1"]) == 0
    found = {vY: ldbench.run(case.replace(vY=vY)).results["first_peak_N_LF"]*1e-3 for vY in (0.9, 1.1)}
    assert f"first_peak_N_LF [kN]: {min(found.values()):.6g} to {max(found.values()):.6g}" in capsys.readouterr().out
