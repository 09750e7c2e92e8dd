"""Namelist files: what is accepted, and how everything else is refused."""
import re
import subprocess
import zlib
from pathlib import Path
from typing import NamedTuple

import pytest

from golden import steeper
from running import CASES, LDBENCH, REPO, namelist, rows, run_case, short_case


class Variable(NamedTuple):
    """What `ldbench --help` says of a namelist variable."""
    group: str
    name: str
    default: str           # as it stands in a namelist
    is_number: bool


def help_variables() -> list[Variable]:
    text = subprocess.run([LDBENCH, "--help"], capture_output=True, text=True, check=True).stdout
    found, group = [], ""
    for line in text[text.index("\n&"):].splitlines()[1:]:
        if line.startswith("&"):
            group = line[1:]
        elif line.startswith("      "):           # the meaning
            assert len(line) < 132
        else:
            name, default, admits = re.fullmatch(r"  (\w+) = (.*?)   (.*)", line).groups()
            found.append(Variable(group, name, default, re.match(r"a (whole )?number from \S+ to ", admits) is not None))
    return found


VARIABLES = help_variables()
BY_NAME = {(v.group, v.name): v for v in VARIABLES}


def parse(text: str) -> dict[tuple[str, str], str]:
    """(group, variable): value as written, of a plainly written namelist file."""
    values, group = {}, ""
    for line in text.splitlines():
        line = line.split("!")[0].strip()
        if line.startswith("&"):
            group = line[1:]
        elif "=" in line:
            name, value = (part.strip() for part in line.split("="))
            values[group, name] = value
    return values


def test_one_language_many_hands(tmp_path):
    """Order of groups, letter case, lines, commas, quotes, exponents and comments are free."""
    plain = short_case(tmp_path)
    groups = re.findall(r"&\w+\n(?: .*\n)*/\n", plain)
    variants = {
        "plain": plain, "other order": "".join(groups[::-1]),
        "capitals": re.sub(r"^(&?\s*\w+)", lambda m: m[1].upper(), plain, flags=re.M),
        "one line": plain.replace("\n  ", " ").replace("\n/", " /"), "all on one line": plain.replace("\n", " "),
        "commas": re.sub(r"(= \S+)$", r"\1,", plain, flags=re.M), "double quotes": plain.replace("'", '"'),
        "Fortran exponents": plain.replace("1e-05", "1.0D-05").replace("0.5", "+5.d-1"),
        "no blanks": plain.replace(" = ", "=").replace("  ", ""), "tabs and CRLF": plain.replace("  ", "\t").replace("\n", "\r\n"),
        "doubled quotes": plain.replace("&initial", "&case title = 'it''s' /\n&initial"),
        "carriage returns": "! a case\r" + plain.replace("\n", "\r"),
        "comments": "! a case\n\n" + re.sub(r"$", "  ! it's so: &track / = ,", plain, flags=re.M),
        "no newline at the end": plain.removesuffix("\n"),
        "mark of the order of bytes": "\ufeff" + plain}
    assert len(set(variants.values())) == len(variants)
    expected = None
    for name, text in variants.items():
        done = run_case(text, tmp_path)
        assert done.returncode == 0, f"{name}: {done.stderr}"
        found = (tmp_path / "columns.txt").read_bytes()
        (tmp_path / "columns.txt").unlink()
        found = found.replace(b"'it''s'", b"''").replace(b": it's", b": initial lateral velocity 0.5 m/s, actual profiles")
        expected = expected or found
        assert found == expected, name


def test_omitted_variables_take_their_defaults(tmp_path):
    """A file with nothing but names of files runs like one that spells out every default of --help, and finds the table of it."""
    short = {"table": {"folder": tmp_path/"tables"}, "integrator": {"t_end": 2e-3},
             "output": {"file": tmp_path/"columns.txt"}}
    spelt = {group: {v.name: v.default.strip("'") for v in VARIABLES if v.group == group} for group in {v.group for v in VARIABLES}}
    found = []
    for groups in {group: values | short.get(group, {}) for group, values in spelt.items()}, short:
        text = re.sub(r"= '([^']*)'", lambda m: f"= {m[1]}" if re.fullmatch(r"[-+.\dE]+", m[1]) else m[0], namelist(**groups))
        done = run_case(text, tmp_path)
        assert done.returncode == 0, done.stderr
        found.append(((tmp_path/"columns.txt").read_bytes(), " 0 solutions," in done.stdout))
    assert found == [(found[0][0], False), (found[0][0], True)]


def run_with_table(folder: Path, **changes: dict[str, object]) -> tuple[bool, bytes]:
    """Whether a run of the short case found its contact table, and its rows."""
    done = run_case(short_case(folder, **changes), folder)
    assert done.returncode == 0, done.stderr
    return ", 0 found" not in done.stdout, rows(folder/"columns.txt")


def test_a_table_serves_what_it_does_not_depend_on(tmp_path):
    """It is found again, and gives the rows of a run that keeps nothing."""
    filed = {"table": {"folder": tmp_path/"tables"}}
    changes = {"wheelset": {"mass": 1600.0}, "initial": {"vY": 0.3}, "loading": {"lateral_ramp": 5e3},
               "integrator": {"order": 2, "beta": 0.25}}
    assert run_with_table(tmp_path, **filed)[0] is False
    without = run_with_table(tmp_path, **changes, table={"folder": ""})
    assert not without[0] and run_with_table(tmp_path, **filed | changes) == (True, without[1])
    assert len(list((tmp_path/"tables").iterdir())) == 1


def test_a_table_of_something_else_is_not_used(tmp_path):
    """The file tells all that the table depends on, so that a table of one other value is built anew."""
    odd = {"wheelset": {"back_to_back": 1.3522, "rolling_radius": 0.458}, "track": {"gauge": 1.4352, "gauge_depth": 0.0141},
           "material": {"youngs_modulus": 2.1e11, "poisson": 0.29},
           "contact": {"model": "strip", "influence": "flat", "stiffness_scale": 1.01},
           "table": {"accuracy": 3e-3, "lateral": 0.061, "lift": 0.041, "drop": 0.011,
                     "roll": 0.34, "depth": 0.0023}}
    odd["table"]["folder"] = tmp_path/"tables"
    assert run_with_table(tmp_path, **odd)[0] is False
    table, = (tmp_path/"tables").iterdir()
    words = table.read_bytes()[:1000].decode(errors="replace").split()
    told = {float(word) for word in words if re.fullmatch(r"[\d.]+(E[-+]\d+)?", word)}
    expected = [value for values in odd.values() for name, value in values.items() if name != "folder"]
    assert told >= {value for value in expected if not isinstance(value, str)} and {"strip", "flat"} <= set(words)
    assert {f"{zlib.crc32((REPO/f'profiles/{name}prof.yz').read_bytes()):08X}" for name in ("aw", "ar")} <= set(words)
    assert run_with_table(tmp_path, **odd | {"material": {"youngs_modulus": 2.1e11, "poisson": 0.291}})[0] is False
    assert len(list((tmp_path/"tables").iterdir())) == 2


GIVEN_WHOLE = "case", "wheelset", "track", "material", "profiles", "initial", "loading", "contact"
NAMED = {(v.group, v.name) for v in VARIABLES if v.group in GIVEN_WHOLE} | {
    ("table", "folder"), ("integrator", "order"), ("integrator", "dt"),
    ("integrator", "t_end"), ("integrator", "stop_at"), ("output", "file"), ("output", "interval")}

# The call's data, SI; exercises 1 to 5.
CALL = {
    ("wheelset", "mass"): 1568, ("wheelset", "roll_inertia"): 656, ("wheelset", "pitch_inertia"): 168,
    ("wheelset", "rolling_radius"): 0.457, ("wheelset", "back_to_back"): 1.35214,
    ("wheelset", "vertical_load"): 164.618e3, ("track", "gauge"): 1.4351, ("track", "gauge_depth"): 0.014,
    ("track", "friction"): 0, ("material", "youngs_modulus"): 210000e6, ("material", "poisson"): 0.28,
    ("material", "shear_modulus"): 82000e6, ("initial", "Y"): 0, ("initial", "Z"): 0, ("initial", "roll"): 0,
    ("initial", "pitch"): 0, ("initial", "vX"): 1, ("initial", "vZ"): 0, ("initial", "pitch_rate"): 2.19,
    ("loading", "lateral_force"): 0, ("contact", "stiffness_scale"): 1}
VY = 0.1, 0.5, 1, 2, 0
ROLL_RATE = 3.33e-3, 16.67e-3, 33.3e-3, 66.7e-3, 0


@pytest.mark.parametrize("case", CASES)
def test_shipped_input_says_what_the_call_says(case):
    given = parse((REPO / "inputs" / f"{case}.nml").read_text())
    assert NAMED <= set(given)
    exercise, pair = int(case[2]), case[4:]
    expected = CALL | {("initial", "vY"): VY[exercise - 1], ("initial", "roll_rate"): ROLL_RATE[exercise - 1],
                       ("loading", "lateral_ramp"): 5e3 if exercise == 5 else 0}
    for key, value in expected.items():
        assert float(given[key]) == value, key
    stop_at = "derailment" if exercise == 5 else "return_to_centre"
    words = {("case", "name"): case, ("profiles", "wheel_profile"): f"profiles/{pair}prof.yz",
             ("profiles", "rail_profile"): f"profiles/{pair.replace('w', 'r')}prof.yz",
             ("contact", "model"): "halfspace", ("integrator", "stop_at"): stop_at, ("initial", "roll_link"): "none",
             ("output", "file"): f"outputs/{case}.txt"}
    for key, word in words.items():
        assert given[key] == f"'{word}'", key


@pytest.mark.parametrize("case", CASES)
def test_header_holds_the_values_in_force(case, shipped):
    """Every variable stands in the column file's header, as given, or with its default; inclinations that are 0 do not."""
    text = (REPO / "inputs" / f"{case}.nml").read_text()
    given = parse(steeper(text) if case.startswith("ex5") else text)
    head = shipped[case].header
    in_force = parse(head[head.index("&case"):head.index("&results")])
    if_set = {("track", "rail_inclination"), ("track", "rail_inclination_right")}
    assert set(in_force) == set(BY_NAME) - if_set
    for key, variable in BY_NAME.items():
        if key in if_set | {("table", "folder"), ("output", "file")}:
            continue   # moved by the test
        value = given.get(key, variable.default)
        same = float(in_force[key]) == float(value) if variable.is_number else in_force[key] == value
        assert same, f"{key}: {in_force[key]}, expected {value}"
