"""Namelist files: what is accepted, in any hand, and how everything else is refused."""
from __future__ import annotations

import re
import subprocess
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import given, strategies as st

from generated import covering, examples
from golden import steeper
from ldbench import Case, Error
from running import CASES, LDBENCH, REPO, Run, namelist, refusal, rows, run_case, short_case


class Variable(NamedTuple):
    """What `ldbench --help` says of a namelist variable."""
    group: str
    name: str
    default: str           # as it stands in a namelist
    admits: str

    @property
    def bounds(self) -> tuple[float, float] | None:
        found = re.match(r"a (?:whole )?number from (\S+) to (\S+?),?(?: |$)", self.admits)
        return (float(found[1]), float(found[2])) if found else None

    @property
    def whole(self) -> bool:
        return self.admits.startswith("a whole")


def help_variables() -> list[Variable]:
    text = subprocess.run([LDBENCH, "--help"], capture_output=True, text=True, check=True).stdout
    found, group = [], ""
    for line in text[text.index("\n&"):].splitlines()[1:]:
        if line.startswith("&"):
            group = line[1:]
        elif line.startswith("      "):           # the meaning
            assert len(line) < 132
        else:
            found.append(Variable(group, *re.fullmatch(r"  (\w+) = (.*?)   (.*)", line).groups()))
    return found


VARIABLES = help_variables()
BY_NAME = {(v.group, v.name): v for v in VARIABLES}
NUMBERS = [v for v in VARIABLES if v.bounds and "'" not in v.default]


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


# ---- hands ---------------------------------------------------------------------------
# Changes of a plain text, layer by layer; those of lines come last.
HANDS: dict[str, dict[str, Callable[[str], str]]] = {
    "order": {"given": str, "backwards": lambda text: "".join(re.findall(r"&\w+\n(?: .*\n)*/\n", text)[::-1])},
    "letters": {"small": str, "capitals": lambda text: re.sub(r"^(&?\s*\w+)", lambda m: m[1].upper(), text, flags=re.M)},
    "commas": {"none": str, "behind values": lambda text: re.sub(r"(= \S+)$", r"\1,", text, flags=re.M)},
    "quotes": {"single": str, "double": lambda text: text.replace("'", '"')},
    "numbers": {"plain": str, "Fortran": lambda text: text.replace("1e-05", "1.0D-05").replace("0.5", "+5.d-1")},
    "blanks": {"plain": str, "none": lambda text: text.replace(" = ", "=").replace("  ", ""),
               "tabs": lambda text: text.replace("  ", "\t")},
    "comments": {"none": str, "above": lambda text: "! a case\n\n" + text,
                 "behind": lambda text: re.sub(r"$", "  ! it's so: &track / = ,", text, flags=re.M)},
    "lines": {"many": str, "one for a group": lambda text: re.sub(r"\n[ \t]*(?=[^&\n])", " ", text) if "!" not in text else text,
              "one": lambda text: text.replace("\n", " ") if "!" not in text else text},
    "ends": {"LF": str, "CRLF": lambda text: text.replace("\n", "\r\n"), "CR": lambda text: text.replace("\n", "\r")},
    "last": {"a line end": str, "none": lambda text: text.rstrip("\r\n")},
    "mark": {"none": str, "of the order of bytes": lambda text: "\ufeff" + text}}


@examples(2)
@given(covering(HANDS))
def test_one_language_many_hands(tmp_path: Path, hands: list[dict[str, str]]):
    """Order of groups, letter case, lines, commas, quotes, exponents and comments are free."""
    plain = short_case(tmp_path)
    assert run_case(plain, tmp_path).returncode == 0
    expected = (tmp_path/"columns.txt").read_bytes()
    for hand in hands:
        text = plain
        for layer, option in hand.items():
            text = HANDS[layer][option](text)
        (tmp_path/"columns.txt").unlink()
        (tmp_path/"case.nml").write_bytes(text.encode())
        done = subprocess.run([LDBENCH, tmp_path/"case.nml"], cwd=REPO, capture_output=True, text=True)
        assert done.returncode == 0, (hand, done.stderr)
        assert (tmp_path/"columns.txt").read_bytes() == expected, hand


def test_a_doubled_quote_stands_for_one(tmp_path: Path):
    done = run_case(short_case(tmp_path).replace("&initial", "&case title = 'it''s' /\n&initial"), tmp_path)
    assert done.returncode == 0 and b": it's" in (tmp_path/"columns.txt").read_bytes()


# ---- values --------------------------------------------------------------------------
# Variables that have conditions with others, which test_refusals.py states.
TIED = {"order", "beta", "gamma", "dt", "t_end", "interval", "restitution", "stiffness_scale"}


def written(values: Mapping[Variable, str]) -> str:
    """A namelist, plainly written, a group after the other."""
    return "".join(f"&{group}\n" + "".join(f"  {v.name} = {x}\n" for v, x in values.items() if v.group == group) + "/\n"
                   for group in dict.fromkeys(v.group for v in values))


def numbers_of(variable: Variable, inside: bool) -> st.SearchStrategy[float | int]:
    least, largest = variable.bounds
    if variable.whole:
        within = st.integers(int(least), int(largest))
        return within if inside else st.integers(-10**6, int(least) - 1) | st.integers(int(largest) + 1, 10**6)
    within = st.floats(least, largest)
    return within if inside else st.floats(-1e30, least, exclude_max=True) | st.floats(largest, 1e30, exclude_min=True)


@examples(40)
@given(st.data())
def test_a_value_within_its_range_is_taken(data: st.DataObject):
    """It stands in the case as it was written, and in a namelist that the case writes."""
    free = [v for v in NUMBERS if v.name not in TIED]
    chosen = data.draw(st.lists(st.sampled_from(free), min_size=1, max_size=4, unique=True))
    values = {v: data.draw(st.sampled_from(v.bounds) | numbers_of(v, inside=True)) for v in chosen}
    text = written({v: repr(int(x) if v.whole else x) for v, x in values.items()})
    case = Case.from_namelist(text)
    assert [getattr(case, f"{v.group}_{v.name}") for v in chosen] == [values[v] for v in chosen]
    assert Case.from_namelist(case.to_namelist()) == case


MALFORMED = "NaN", "-inf", "1e999", "'1.0'", ".true.", "0x10", "1.0m", "2*1.0", "1e+", "1+2", "", "1.5.2", "--1", "1_0"


def refused(text: str, folder: Path, executable: bool) -> str:
    """The message of Python, and of the executable."""
    (folder/"case.nml").write_text(text)
    with pytest.raises(Error) as caught:
        Case.from_namelist(folder/"case.nml")
    message = str(caught.value)
    assert "\n" not in message and len(message) < 800
    if executable:
        assert refusal(text, folder) == f"ldbench: error: {message}"
    return message


@examples(60)
@given(st.data(), st.sampled_from(NUMBERS), st.integers(0, 3), st.integers(0, 1))
def test_a_value_outside_its_range_is_refused(tmp_path: Path, data: st.DataObject, variable: Variable, above: int, often: int):
    """With its line, its variable, what is admitted and what was found; by the executable and by Python in the same words."""
    outside = numbers_of(variable, inside=False).map(repr)
    wrong = outside | st.sampled_from([*MALFORMED, *(["1.5"] if variable.whole else [])])
    if variable.name == "rail_inclination":
        wrong = outside | st.sampled_from(["1:5", "'steep'", "'1:0'", "1:-40x", "1:", "-1:"])
    value = data.draw(wrong)
    message = refused("\n"*above + f"&{variable.group}\n  {variable.name} = {value}\n/\n", tmp_path, executable=often == 0)
    place = f"case.nml, line {above + (2 if value else 3)}, &{variable.group} {variable.name}: expected {variable.admits}, found "
    assert place + (value.split("*")[0] if value else "/") in message, (message, place)


@examples(12)
@given(st.sampled_from([v for v in VARIABLES if v.admits.startswith("one of")]),
       st.sampled_from(["''", "'x'", "'yes no'", "yes", "1.0"]))
def test_a_word_that_is_none_is_refused(tmp_path: Path, variable: Variable, value: str):
    message = refused(f"&{variable.group} {variable.name} = {value} /\n", tmp_path, executable=False)
    assert f"line 1, &{variable.group} {variable.name}: expected {variable.admits}, found {value}" in message


# ---- the language --------------------------------------------------------------------
# What becomes of the line of a variable, or of the whole text; what is told of it. {k} is the number of the line, {n} of the last.
Edit = Callable[[str, str, str], str]       # of the text, a line and its group
AMONG, ONE_OF = "line {k}, &{group}: expected one of {first}", "expected one of &case &wheelset &track"
MISTAKES: dict[str, tuple[Edit, str]] = {
    "unknown variable": (lambda text, line, group: text.replace(line, f"  x{line.strip()}"), AMONG),
    "a unit": (lambda text, line, group: text.replace(line, f"{line} kg"), AMONG),
    "a long name": (lambda text, line, group: text.replace(line, f"{'g'*3000} = 1\n{line}"), AMONG),
    "twice": (lambda text, line, group: text.replace(line, f"{line}\n{line.upper()}"),
              "line {k1}, &{group} {name}: expected once, found a second time"),
    "no value": (lambda text, line, group: text.replace(line, line.split("=")[0] + "= /\n!"),
                 "line {k}, &{group} {name}: expected"),
    "no sign": (lambda text, line, group: text.replace(line, line.replace(" =", "")), "line {k}, &{group} {name}: expected ="),
    "an escape": (lambda text, line, group: text.replace("= ", "= \x1b[31m", 1), "line 2, &{first_group} {first_name}: expected "),
    "open quote": (lambda text, line, group: text.replace(line, line.split("=")[0] + "= 'strip"),
                   "line {k}, &{group}: expected a closing quote, found 'strip"),
    "open group": (lambda text, line, group: text.rstrip("/\n"), "&{last}: expected / at the end of the group, found the end of"),
    "no mark": (lambda text, line, group: text.replace(f"&{group}\n", f"{group}\n"), "line {g}: expected a group such as &"),
    "a blank": (lambda text, line, group: text.replace(f"&{group}\n", f"& {group}\n"), f"line {{g}}: {ONE_OF}"),
    "a control character": (lambda text, line, group: text.replace(f"&{group}\n", f"&{group}\x01\n"), f"line {{g}}: {ONE_OF}"),
    "second group": (lambda text, line, group: f"{text}&{group.capitalize()} /\n", "line {n1}: expected each group once, found a "),
    "unknown group": (lambda text, line, group: f"{text}&brakes\n/\n", f"line {{n1}}: {ONE_OF}"),
    "a word behind": (lambda text, line, group: f"{text}end\n", "line {n1}: expected a group such as &wheelset, found end"),
    "only comments": (lambda text, line, group: "! " + text.replace("\n", "\n! "), "expected namelist groups such as &case")}


@examples(2)
@given(st.data())
def test_a_mistake_in_the_language_is_refused_at_its_line(tmp_path: Path, data: st.DataObject):
    """By the executable and by Python in the same words."""
    for change, words in MISTAKES.values():
        groups = data.draw(st.permutations(["wheelset", "track", "material", "initial"]))[:3]
        text = written({v: v.default for group in groups for v in NUMBERS if v.group == group})
        variable = data.draw(st.sampled_from([v for v in NUMBERS if v.group in groups and v.name != "roll"]))
        lines, line = text.splitlines(), f"  {variable.name} = {variable.default}"
        k = lines.index(line) + 1
        told = words.format(k=k, k1=k + 1, n1=len(lines) + 1, g=lines.index(f"&{variable.group}") + 1, last=groups[-1],
                            group=variable.group, name=variable.name, first_group=groups[0], first_name=lines[1].split()[0],
                            first=next(v.name for v in VARIABLES if v.group == variable.group))
        place, what = map(re.escape, told.split(": ", 1)) if ": " in told else ("", re.escape(told))
        message = refused(change(text, line, variable.group), tmp_path, executable=True)
        assert re.search(rf"{place}(, &\S*)?(: )?{what}", message, re.IGNORECASE), (message, told)


# ---- defaults, tables, the call -------------------------------------------------------
def test_omitted_variables_take_their_defaults(tmp_path: Path):
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


def test_a_table_serves_what_it_does_not_depend_on(tmp_path: Path):
    """It is found again, and gives the rows of a run that keeps nothing."""
    filed = {"table": {"folder": tmp_path/"tables"}}
    changes = {"wheelset": {"mass": 1600.0}, "initial": {"vY": 0.3}, "loading": {"lateral_ramp": 5e3},
               "integrator": {"order": 2, "beta": 0.25}}
    assert run_with_table(tmp_path, **filed)[0] is False
    without = run_with_table(tmp_path, **changes, table={"folder": ""})
    assert not without[0] and run_with_table(tmp_path, **filed | changes) == (True, without[1])
    assert len(list((tmp_path/"tables").iterdir())) == 1


def test_a_table_of_something_else_is_not_used(tmp_path: Path):
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
def test_shipped_input_says_what_the_call_says(case: str):
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
def test_header_holds_the_values_in_force(case: str, shipped: dict[str, Run]):
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
        same = float(in_force[key]) == float(value) if variable.bounds else in_force[key] == value
        assert same, f"{key}: {in_force[key]}, expected {value}"
