"""An earlier column file is replaced by that of the same case alone, and a changed case is told what does not fit."""
import logging
import stat
from pathlib import Path

import pytest

import ldbench
from ldbench import Case, run
from running import WINDOWS, run_case, short_case

NAME = "columns.txt"


def made(folder: Path, **initial: float) -> tuple[str, bytes]:
    """Run a short case by the executable: what it prints, and its column file."""
    text = short_case(folder, initial=initial)
    (folder/"case.nml").write_text(text)
    done = run_case(text, folder)
    assert done.returncode == 0, done.stderr
    return done.stdout, (folder/NAME).read_bytes()


def test_the_file_of_another_case_is_kept(tmp_path: Path):
    """In its bytes, beside the new one, each under the first free name; the same case replaces its file."""
    first = made(tmp_path, vY=0.1)
    again = made(tmp_path, vY=0.1)
    assert again[1] == first[1] and "kept" not in first[0] + again[0]
    for number, vY in (1, 0.2), (2, 0.3):
        earlier = (tmp_path/NAME).read_bytes()
        told, columns = made(tmp_path, vY=vY)
        aside = tmp_path/f"columns.{number}.txt"
        assert columns != earlier == aside.read_bytes()
        assert told.splitlines()[-1] == f"kept: {aside}, the earlier columns, of another case"
    assert {file.name for file in tmp_path.glob("columns*")} == {NAME, "columns.1.txt", "columns.2.txt"}


@pytest.mark.parametrize(("text", "kept"), [("time Y\n0.0 1.0\n", True), ("notes of mine", True), ("", False)])
def test_anybody_s_file_is_kept(text: str, kept: bool, tmp_path: Path):
    (tmp_path/NAME).write_text(text)
    made(tmp_path, vY=0.1)
    aside = tmp_path/"columns.1.txt"
    assert aside.read_text() == text if kept else not aside.exists()


def test_python_keeps_it_too(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    (tmp_path/"case.nml").write_text(short_case(tmp_path, initial={"vY": 0.1, "roll_link": "rails"}))
    case = Case.from_namelist(tmp_path/"case.nml")
    file = run(case).write()
    earlier = (tmp_path/NAME).read_bytes()
    with caplog.at_level(logging.INFO, "ldbench"):
        run(case).write(file)
        assert "kept" not in caplog.text
        run(case.replace(vY=0.2)).write(file)
    assert f"kept: {tmp_path/'columns.1.txt'}" in caplog.text and (tmp_path/"columns.1.txt").read_bytes() == earlier


def test_python_tells_of_a_file_that_it_does_not_write(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    """`run` writes no file that the case names; the log says so, and what writes it."""
    case = Case.exercise(1).replace(model="hertz", t_end=1e-3, table_folder="", output_file=tmp_path/NAME)
    with caplog.at_level(logging.INFO, "ldbench"):
        made_here = run(case)
    assert f"not written: {tmp_path/NAME}, which the case names; write()" in caplog.text and not (tmp_path/NAME).exists()
    assert made_here.write() == str(tmp_path/NAME) and (tmp_path/NAME).is_file()
    caplog.clear()
    with caplog.at_level(logging.INFO, "ldbench"):
        run(case.replace(output_file=""))
    assert "not written" not in caplog.text


def test_a_roll_rate_that_does_not_fit_vy_is_one_warning(tmp_path: Path):
    """The change of vY alone is told on the terminal, in the column file and in Python; no case that fits is."""
    told, columns = made(tmp_path, vY=0.7, roll_rate=0.01667)
    assert told.replace("\n  ", " ").count("warning: &initial roll_rate: expected about 0.02356 rad/s") == 1
    assert columns.count(b"warning: &initial roll_rate") == 1
    case = Case.from_namelist(tmp_path/"case.nml")
    with pytest.warns(ldbench.Warning, match=r"&initial roll_rate: expected .* vY = 0.7 m/s, found 0.01667; roll_link") as found:
        run(case)
    assert len(found) == 1
    for fitting in case.replace(roll_link="rails"), case.replace(vY=0.5), case.replace(vY=0.0, roll_rate=0.0), case.replace(
            formulation="unilateral"), case.replace(vY=-0.5, roll_rate=-0.01667):
        assert not any("roll_rate" in words for words in run(fitting).warnings)


@pytest.mark.skipif(WINDOWS, reason="Windows has neither these modes nor these links")
@pytest.mark.parametrize("mode", [0o600, 0o664])
def test_a_file_that_is_replaced_keeps_its_mode_and_its_link(mode: int, tmp_path: Path):
    """The link leads to it through another link; of another case the file is kept where it lies, with its mode."""
    (tmp_path/"far").mkdir()
    file, between, name = tmp_path/"far/real.txt", tmp_path/"far/between", tmp_path/NAME
    between.symlink_to("real.txt")
    name.symlink_to("far/between")
    made(tmp_path, vY=0.1)
    assert name.is_symlink() and between.is_symlink() and file.is_file()
    file.chmod(mode)
    first = made(tmp_path, vY=0.1)[1]
    assert stat.S_IMODE(file.stat().st_mode) == mode
    told, columns = made(tmp_path, vY=0.2)
    aside = tmp_path/"far/real.1.txt"
    assert told.splitlines()[-1] == f"kept: {aside}, the earlier columns, of another case"
    assert (aside.read_bytes(), file.read_bytes()) == (first, columns) and name.is_symlink()
    assert [stat.S_IMODE(one.stat().st_mode) for one in (file, aside)] == [mode, mode]
    assert {one.name for one in file.parent.iterdir()} == {"between", "real.txt", "real.1.txt"}


@pytest.mark.skipif(WINDOWS, reason="Windows has no such links")
def test_a_link_to_the_input_is_no_output(tmp_path: Path):
    text = short_case(tmp_path)
    (tmp_path/NAME).symlink_to("case.nml")
    done = run_case(text, tmp_path)
    assert done.returncode == 1 and done.stderr.startswith("ldbench: error: ") and (tmp_path/"case.nml").read_text() == text
