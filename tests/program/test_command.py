"""The command line and the files as another program reads them."""
import re
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

from running import (
    HANG,
    LDBENCH,
    REPO,
    columns,
    contents,
    read_until,
    run_case,
    short_case,
    wait_for,
)

CONTACT_COLUMNS = [f"{quantity}_{contact}" for contact in ("LT", "LF", "RT", "RF")
                   for quantity in ("angle", "N", "Fy", "Fz", "y", "z", "radius")]
COLUMN_NAMES = [
    *"time X Y Z roll pitch vX vY vZ roll_rate pitch_rate aY aZ roll_acc".split(), *CONTACT_COLUMNS,
    *"F_ext M_gyro KE_long KE_lat KE_vert KE_roll KE_pitch PE_grav PE_load PE_elastic_L PE_elastic_R".split(),
    *"W_ext E_total E_drift".split()]


def ldbench(*arguments: str | Path, cwd: Path = REPO, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run([LDBENCH, *arguments], cwd=cwd, capture_output=True, text=True, timeout=HANG, **options)


@pytest.mark.parametrize(("option", "words"), [
    ("--help", r"(?s).*usage: ldbench < input\.nml.*&wheelset.*"), ("-h", r"(?s).*&wheelset.*"),
    ("--version", r"ldbench \d+\.\d+\.\d+\n")])
def test_help_and_version(option, words, tmp_path):
    done = ldbench(option, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "") and re.fullmatch(words, done.stdout)
    assert max(len(line) for line in done.stdout.splitlines()) < 132 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("arguments", "words"), [
    (["--verbose"], "unknown option --verbose"),
    (["-x"], "unknown option -x"),
    (["--help=all"], "unknown option --help=all"),
    (["--Version"], "unknown option --Version"),
    (["a.nml", "b.nml"], "at most one argument"),
    (["a.nml", "--force"], "at most one argument"),
])
def test_wrong_arguments(arguments, words, tmp_path):
    done = ldbench(*arguments, cwd=tmp_path)
    assert done.returncode == 1 and done.stdout == ""
    assert re.fullmatch(rf"ldbench: error: .*{words}.*see ldbench --help\n", done.stderr)


# Hours of integration, on whatever machine: a wheelset that rests on its rails.
ENDLESS = {"integrator": {"t_end": 1e5, "dt": 1e-5, "scheme": "energy"}, "initial": {"vY": 0.0, "roll_rate": 0.0},
           "output": {"interval": 0.1}}


def test_file_name_and_standard_input_give_the_same_bytes(tmp_path):
    text = short_case(tmp_path, output={"geometry_file": tmp_path / "geometry.txt"}) + "! " + 3*2**16*"long " + "\n"
    (tmp_path / "case.nml").write_text(text)
    outcomes = []
    for arguments, given in ([tmp_path / "case.nml"], None), ([], text), (["-"], text), ([""], text), (["/dev/stdin"], text):
        done = ldbench(*arguments, input=given)
        assert done.returncode == 0 and done.stderr == ""
        written = {name: (tmp_path / name).read_bytes() for name in ("columns.txt", "geometry.txt")}
        for name in written:
            (tmp_path / name).unlink()
        outcomes.append((re.sub(r"processor time.*", "", done.stdout), written))
    assert all(outcome == outcomes[0] for outcome in outcomes)
    assert [path.name for path in tmp_path.iterdir()] == ["case.nml"]


def test_earlier_result_is_replaced_when_the_new_one_is_complete(tmp_path):
    """A run that is stopped half-way leaves the earlier file alone."""
    table = tmp_path / "pair.table"
    (tmp_path / "case.nml").write_text(short_case(tmp_path, **ENDLESS, table={"file": table}))
    (tmp_path / "columns.txt").write_text("earlier\n")
    before = contents(tmp_path)
    run = subprocess.Popen([LDBENCH, tmp_path / "case.nml"], stdout=subprocess.DEVNULL)
    wait_for(table, run)      # after it comes the integration
    run.terminate()
    assert run.wait(HANG) == -signal.SIGTERM
    table.unlink()
    assert {path: found for path, found in contents(tmp_path).items() if "ldbench-part" not in path.name} == before
    (tmp_path / "case.nml").write_text(short_case(tmp_path))
    assert ldbench(tmp_path / "case.nml").returncode == 0
    assert (tmp_path / "columns.txt").read_text().lstrip().startswith("time ")


def test_progress_line_on_a_terminal_only(tmp_path, terminal):
    """Into a pipe nothing goes."""
    (tmp_path / "case.nml").write_text(short_case(tmp_path, **ENDLESS))
    ours, theirs = terminal
    command = [LDBENCH, tmp_path / "case.nml"]
    shown = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs)
    hidden = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    try:
        text = read_until(ours, b"%")
    finally:
        for run in shown, hidden:
            run.terminate()
    assert re.match(rb"\rldbench: (table|integration) +\d+ %", text)
    assert hidden.communicate(timeout=HANG) == (b"", b"") and shown.communicate(timeout=HANG)[0] == b""
    assert [run.returncode for run in (shown, hidden)] == 2*[-signal.SIGTERM]


@pytest.fixture(scope="module")
def column_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run into the left flange: contacts close and open, so there are NaN."""
    folder = tmp_path_factory.mktemp("columns")
    text = short_case(folder, initial={"vY": 1.0, "roll_rate": 0.0333}, integrator={"t_end": 0.02})
    assert run_case(text, folder).returncode == 0
    return folder / "columns.txt"


def test_layout(column_file):
    """Names, header, units, numbers; names, units and numbers in cells of 16 characters."""
    lines = column_file.read_text().splitlines()
    head = [line for line in lines if line.startswith("#")]
    numbers = [line for line in lines[1:] if not line.startswith("#")]
    assert len(numbers) == 201
    first = lines.index(numbers[0])
    units = lines[first - 1]
    before, after = lines[1:first], lines[first + len(numbers):]
    assert before + after == head
    assert before[0].startswith("# ldbench ") and after[0] == "# &results" and after[-1] == "# /"
    assert units[1:].split()[:13] == "s m m m rad rad m/s m/s m/s rad/s rad/s m/s2 m/s2".split()
    assert len(units.split()) == len(COLUMN_NAMES) + 1
    for line in [lines[0], units, *numbers]:
        cells = [line[i:i + 16] for i in range(0, len(line), 16)]
        assert len(cells) == len(COLUMN_NAMES)
        assert all(re.fullmatch(r"#? *\S+", cell) and len(cell) == 16 for cell in cells)
    for line in numbers:
        assert re.fullmatch(r"( +(-?\d\.\d{8}E[-+]\d\d|NaN)){56}", line)


def test_numpy_reads_the_file_as_it_is(column_file):
    table = np.genfromtxt(column_file, names=True)
    assert list(table.dtype.names) == COLUMN_NAMES
    for name, values in columns(column_file).items():
        np.testing.assert_array_equal(table[name], values)
