"""The command line and the files as another program reads them."""
import os
import re
import select
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from running import HANG, LDBENCH, REPO, columns, run_case, short_case

CONTACT_COLUMNS = [f"{quantity}_{contact}" for contact in ("LT", "LF", "RT", "RF")
                   for quantity in ("angle", "N", "Fy", "Fz", "y", "z", "radius")]
COLUMN_NAMES = [
    *"time X Y Z roll pitch vX vY vZ roll_rate pitch_rate aY aZ roll_acc".split(), *CONTACT_COLUMNS,
    *"F_ext M_gyro KE_long KE_lat KE_vert KE_roll KE_pitch PE_grav PE_load PE_elastic_L PE_elastic_R".split(),
    *"W_ext E_total E_drift".split()]


def ldbench(*arguments: str | Path, cwd: Path = REPO, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run([LDBENCH, *arguments], cwd=cwd, capture_output=True, text=True, timeout=HANG, **options)


@pytest.mark.parametrize(("option", "words"), [("--help", r"(?s).*usage: ldbench < input\.nml.*&wheelset.*"),
                                               ("-h", r"(?s).*&wheelset.*"), ("--version", r"ldbench \d+\.\d+\.\d+\n")])
def test_help_and_version(option, words, tmp_path):
    done = ldbench(option, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and re.fullmatch(words, done.stdout)
    assert max(len(line) for line in done.stdout.splitlines()) < 132 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("arguments", "words"), [
    (["-x"], "unknown option -x"), (["--help=all"], "unknown option --help=all"), (["a.nml", "--force"], "at most one argument")])
def test_wrong_arguments(arguments, words, tmp_path):
    done = ldbench(*arguments, cwd=tmp_path)
    assert done.returncode == 1 and done.stdout == ""
    assert re.fullmatch(rf"ldbench: error: .*{words}.*see ldbench --help\n", done.stderr)


def test_file_name_and_standard_input_give_the_same_bytes(tmp_path):
    text = short_case(tmp_path) + "! " + 3*2**16*"long " + "\n"
    (tmp_path/"case.nml").write_text(text)
    outcomes = []
    for arguments, given in ([tmp_path/"case.nml"], None), ([], text), (["-"], text), ([""], text), (["/dev/stdin"], text):
        done = ldbench(*arguments, input=given)
        assert done.returncode == 0 and done.stderr == ""
        written = {name: (tmp_path/name).read_bytes() for name in ("columns.txt",)}
        for name in written:
            (tmp_path/name).unlink()
        outcomes.append((re.sub(r"processor time.*|contact table: .* found", "", done.stdout), written))
    assert all(outcome == outcomes[0] for outcome in outcomes)
    assert [path.name for path in tmp_path.iterdir()] == ["case.nml"]


def test_progress_line_on_a_terminal_only(tmp_path):
    """Into a pipe nothing goes. The run would take hours: a wheelset that rests on its rails."""
    (tmp_path/"case.nml").write_text(short_case(
        tmp_path, integrator={"t_end": 1e5, "dt": 1e-5}, initial={"vY": 0.0, "roll_rate": 0.0},
        output={"interval": 0.1}))
    pty = pytest.importorskip("pty", reason="this system has no terminals")
    ours, theirs = pty.openpty()
    command, text = [LDBENCH, tmp_path/"case.nml"], b""
    shown = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs)
    hidden = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        while b"%" not in text:
            assert select.select([ours], [], [], HANG)[0], f"hangs after {text!r}"
            text += os.read(ours, 1000)
    finally:
        for run in shown, hidden:
            run.terminate()
        os.close(theirs)
    os.close(ours)
    assert re.match(rb"\rldbench: (table|integration) +\d+ %", text)
    assert hidden.communicate(timeout=HANG) == (b"", b"") and shown.communicate(timeout=HANG)[0] == b""
    assert [run.returncode for run in (shown, hidden)] == 2*[-signal.SIGTERM]


def test_layout_of_a_column_file(tmp_path):
    """Names, header, units, numbers of a run into the left flange, where contacts close and open; cells of 16 characters. numpy
    reads the file as it is."""
    text = short_case(tmp_path, initial={"vY": 1.0, "roll_rate": 0.0333}, integrator={"t_end": 0.02})
    assert run_case(text, tmp_path).returncode == 0
    file = tmp_path/"columns.txt"
    lines = file.read_text().splitlines()
    numbers = [line for line in lines[1:] if not line.startswith("#")]
    first = lines.index(numbers[0])
    units, before, after = lines[first - 1], lines[1:first], lines[first + 201:]
    assert len(numbers) == 201 and all(line.startswith("#") for line in before + after)
    assert before[0].startswith("# ldbench ") and after[0] == "# &results" and after[-1] == "# /"
    assert units[1:].split()[:13] == "s m m m rad rad m/s m/s m/s rad/s rad/s m/s2 m/s2".split()
    for line in lines[0], units:
        cells = [line[i:i + 16] for i in range(0, len(line), 16)]
        assert len(cells) == len(COLUMN_NAMES) and all(re.fullmatch(r"#? *\S+", cell) and len(cell) == 16 for cell in cells)
    for line in numbers:
        assert re.fullmatch(r"( +(-?\d\.\d{8}E[-+]\d\d|NaN)){56}", line) and len(line) == 56*16
    table = np.genfromtxt(file, names=True)
    assert list(table.dtype.names) == COLUMN_NAMES
    for name, values in columns(file).items():
        np.testing.assert_array_equal(table[name], values)
