"""The page's scripts without a browser: their syntax, what they know of numbers, and the reader of links, run by node."""
from __future__ import annotations

import base64
import json
import math
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
from ldbench.constants import CONTACTS
from ldbench.number_text import force_text, number_text, percent_text, scientific
from ldbench.viewer.pack import CELLS, CELLS_BESIDE
from ldbench.viewer.page import SCRIPTS, derived_columns, derived_values, run_entry
from raw import Raw
from reading import value
from running import HANG
from specimen import World

NODE = shutil.which("node")
FILES = {path.name: path for path in sorted(Path(ldbench.__file__).parents[1].rglob("*.js"))}         # of both packages

pytestmark = pytest.mark.skipif(NODE is None, reason="no node")


def ask(task: str, scripts: tuple[str, ...], **question: object) -> Any:
    """What in_node.js answers."""
    text = json.dumps({"task": task, "scripts": [str(FILES[name]) for name in scripts], **question})
    done = subprocess.run([NODE, Path(__file__).with_name("in_node.js")], input=text, capture_output=True, encoding="utf-8",
                          timeout=HANG)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", sorted(FILES.keys() - set(SCRIPTS)))
def test_syntax(name: str):
    """No other test here reads these scripts."""
    done = subprocess.run([NODE, "--check", FILES[name]], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


# Numbers

SIZES = (0, 1e-300, 4.4e-9, 9.9996e-5, 1e-4, 0.00125, 0.0625, 0.125, 0.375, 0.5, 0.9949, 0.9995, 1.5, 2.5, 3, 9.5, 9.9949, 9.99951,
         12.345, 99.5, 99.95, 100, 163.45, 1234.5, 65432.1, 9999999.4, 9999999.5, 1e7, 10005000, 10015000, 1.25e7, 6.02e23, 1e300)
OPTIONS = {
    "numberText": [{}, {"trim": True}, {"sign": True}, *({"decimals": n} for n in range(7)), *({"digits": n} for n in range(1, 8)),
                   {"decimals": 1, "digits": 3}, {"decimals": 2, "digits": 2, "sign": True}, {"decimals": 3, "trim": True}],
    "scientific": [{}], "percentText": [{}, {"sign": True}, {"decimals": 3}], "forceText": [{}]}
WRITERS = {"numberText": number_text, "scientific": scientific, "percentText": percent_text, "forceText": force_text}


def test_numbers_are_written_as_python_writes_them():
    """Numbers of all sizes, among them ties, which JavaScript alone would round up, and what is no number."""
    generator = np.random.default_rng(2)
    drawn = generator.choice([-1, 1], 300)*10.0**generator.uniform(-8, 9, 300)
    numbers = [*SIZES, *(-x for x in SIZES), *np.round(drawn, 3), *drawn.tolist()]
    calls = [(name, float(x), options) for name, every in OPTIONS.items() for options in every for x in numbers]
    calls += [("numberText", x, {}) for x in (None, math.nan, math.inf)] + [("percentText", x, {}) for x in (None, math.nan)]
    expected = [WRITERS[name](x, **options) for name, x, options in calls]
    asked = [(name, x if x is None else repr(x).replace("inf", "Infinity"), 1 if name == "scientific" else options)
             for name, x, options in calls]
    assert ask("write", ("number_text.js",), calls=asked) == expected
    assert len(set(expected)) > 3000


def test_words_that_lines_of_an_axis_share():
    shared = {("normal force, left tread", "normal force, right flange"): "normal force",
              ("kinetic energy, roll", "elastic energy, left wheel", "potential energy, gravity"): "energy",
              ("normal force, left tread", "roll Φ"): "", ("energy drift",): "energy drift", (): "",
              ("normal force, left tread", "normal force, left tread"): "normal force, left tread"}
    assert ask("common", ("axes.js",), lists=[list(words) for words in shared]) == list(shared.values())


def test_contacts_are_those_of_the_columns():
    assert tuple(ask("contacts", SCRIPTS)) == CONTACTS


# Readings

def packed(run: ldbench.Run, cells: int = CELLS) -> dict[str, Any]:
    """A run as the page has it, of which so many numbers are kept whole."""
    entry, body = run_entry(run, run, [], cells)
    return {"facts": entry, "body": base64.b64encode(body).decode()}


def read(*runs: dict[str, Any], names: Iterable[str], times: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """What the page knows of columns at some times, or of their difference: the least and the largest value."""
    found = ask("read", SCRIPTS, runs=runs, names=list(names), times=times.tolist())
    return {name: tuple(np.array(limits, float).T) for name, limits in found.items()}


def thinned(raw: Raw, file: Path, rows: slice) -> ldbench.Run:
    """The run of a file with some of its rows."""
    lines = raw.text.splitlines(keepends=True)
    numbers = [k for k, line in enumerate(lines) if k and not line.startswith("#")]
    left_out = set(numbers) - set(numbers[rows])
    file.write_text("".join(line for k, line in enumerate(lines) if k not in left_out))
    return ldbench.read_run(file)


def test_loads_of_wheels(world: World):
    """L/V, V and L of each wheel and their sums: the page has the numbers of the rows, none where a wheel carries nothing."""
    raw, run = world.pushed, world.run("ex5_aw")
    expected = {f"{kind}_{side}": raw.ratio(side) if kind == "LV" else raw.c[f"{kind}_{side}T"] + raw.c[f"{kind}_{side}F"]
                for side in "LR" for kind in ("LV", "Fz", "Fy")}
    assert all(np.isnan(expected[f"LV_{side}"]).sum() > 100 for side in "LR")
    expected |= {f"{kind}_sum": expected[f"{kind}_L"] + expected[f"{kind}_R"] for kind in ("Fz", "Fy")}
    values, found = derived_values(run, derived_columns(raw.c)), read(packed(run, 10**7), names=expected, times=raw.t)
    assert values.keys() == expected.keys() and not derived_columns(["Fy_LT", "Fy_LF"])[1:]
    for name, x in expected.items():
        for shown in values[name], *found[name]:
            np.testing.assert_allclose(shown, x, rtol=1e-12, atol=1e-12*np.nanmax(np.abs(x)), err_msg=name)


EXPRESSIONS = {"N_LF+N_RF": lambda c: c["N_LF"] + c["N_RF"], "aY-aZ": lambda c: c["aY"] - c["aZ"],
               "aY*vY": lambda c: c["aY"]*c["vY"], "E_total/KE_long": lambda c: c["E_total"]/c["KE_long"],
               "Y/N_LF": lambda c: c["Y"]/c["N_LF"]}


def test_every_row_of_a_long_run(world: World):
    """The page leaves most rows of this run out: a value with all digits is that of the file, any other lies between the
    limits; nothing is told only where the file has nothing, or where a divisor may be zero. Expressions and loads of wheels too."""
    raw, run = world.pushed, world.run("ex5_aw")
    entry = packed(run, CELLS_BESIDE)
    rows = np.arange(0, len(raw.t), 3)
    with np.errstate(all="ignore"):
        expected = {name: rule(raw.c) for name, rule in EXPRESSIONS.items()}
    expected |= {name: x for name, x in raw.c.items() if name != "time"}
    expected |= {"Fz_L": raw.loads("L"), "Fy_sum": sum(raw.c[f"Fy_{contact}"] for contact in ("LT", "LF", "RT", "RF"))}
    found = read(entry, names=expected, times=raw.t[rows])
    assert entry["facts"]["index"]["kept"] < len(raw.t)/4
    for name, x in expected.items():
        (low, high), x = found[name], x[rows]
        exact, there, aside = low == high, ~np.isnan(x), 1e-12*np.abs(x)
        if name in raw.c:
            np.testing.assert_array_equal(low[exact], x[exact], err_msg=name)
            assert not np.any(np.isnan(low) & there), name
        known = ~np.isnan(low) & there
        assert np.all((low - aside <= x) & (x <= high + aside) | ~known), name
        assert exact[there].sum() >= 0.05*there.sum() and known.sum() >= 0.3*there.sum(), name
    assert (found["aY"][0] < found["aY"][1]).sum() > len(rows)/2


def test_difference_of_two_long_runs(world: World, tmp_path: Path):
    """Two files are equal but for the first row. Their difference is zero with all digits, or limits hold zero, at every row."""
    raw = world.pushed
    runs = [packed(run, CELLS_BESIDE) for run in (world.run("ex5_aw"), thinned(raw, tmp_path/"shorter.txt", slice(1, None)))]
    names = [name for name in raw.c if name != "time"]
    rows = np.arange(1, len(raw.t), 3)
    found = read(*runs, names=[*names, *EXPRESSIONS], times=raw.t[rows])
    for name, (low, high) in found.items():
        assert np.all((low <= 0) & (high >= 0) | np.isnan(low)), name
        if name in names:
            np.testing.assert_array_equal(np.isnan(low), np.isnan(raw.c[name][rows]), err_msg=name)
    low, high = found["aY"]
    assert 20 < (low == high).sum() < 0.5*len(rows)


@pytest.mark.parametrize("step", [2, 5])
def test_between_rows(step: int, world: World, tmp_path: Path):
    """The rows that are taken out of a file lie where the page says that values between its rows are."""
    raw = world.thrown
    run = thinned(raw, tmp_path/"thin.txt", slice(None, None, step))
    out = (np.arange(len(raw.t)) % step > 0) & (raw.t < run.time[-1])
    names = "Y", "Z", "roll", "vY", "N_LF", "N_LT", "KE_lat"
    for name, (low, high) in read(packed(run), names=names, times=raw.t[out]).items():
        x = raw.c[name][out]
        assert np.mean((low <= x) & (x <= high)) > 0.99 and np.all(low[low == high] == x[low == high]), name
        assert name != "Y" or np.median(high - low) < 1e-3*np.ptp(x)


def test_readings_in_words():
    """With all digits only what is known to all digits; else as many as are known, the last one to one unit, or both limits
    rounded outwards."""
    generator = np.random.default_rng(1)
    middle = generator.choice([-1, 1], 2000)*10.0**generator.uniform(-6, 6, 2000)
    off = np.abs(middle)*10.0**generator.uniform(-9, 1, 2000)
    texts = ask("say", SCRIPTS, readings=[*np.column_stack([middle - off, middle + off]).tolist(), [0.1, 0.1], [0, 0]])
    assert texts[-2:] == ["0.1", "0"]
    for a, b, text in zip(middle - off, middle + off, texts, strict=False):
        if text.startswith("≈ "):
            number, half = value(text[2:])
            zeros = len(text) - len(text.rstrip("0")) if "." not in text else 0
            assert max(abs(number - a), abs(number - b)) <= 2*half*10.0**zeros*(1 + 1e-9), (a, b, text)
        else:
            low, high = (value(word)[0] for word in text.split(" … "))
            assert low <= a and b <= high and high - low <= (b - a) + 2.1e-3*max(-low, high), (a, b, text)


# Links

HOSTILE = ("a&with=b", "#t=1", "100 %", "%00", "%E0%A4%A", "a+b c", "<img src=x onerror=alert(1)>", "</script>", "\"'`${1}",
           "Größe 力 ñ \u2028", "__proto__", "constructor", "")
RUNS = [{"name": "ex2_aw", "shown": True}, {"name": "ex2_sw", "shown": True}, {"name": "other", "shown": False}]
AT_FIRST = {"shown": ["ex2_aw", "ex2_sw"]}


def followed(*fragments: str, runs: list[dict[str, object]] | None = None) -> list[dict[str, Any]]:
    """To which time and view each fragment leads from 5 ms, where it does, and the runs that it shows."""
    return ask("follow", SCRIPTS, runs=runs or RUNS, t=5e-3, fragments=fragments)


def test_links_are_followed():
    expected = {
        "#t=0.02213&view=left": AT_FIRST | {"time": 0.02213, "view": "left"},
        "#t=1e-3": AT_FIRST | {"time": 1e-3},
        "#t=0.005&view=whole": AT_FIRST | {"view": "whole"},
        "#run=other": {"shown": ["other"], "time": 7e-3},     # the first flange contact
        "#view=right&with=other&run=ex2_sw&t=-1": {"shown": ["ex2_sw", "other"], "time": -1, "view": "right"},
        "#t=0.01&t=0.02": AT_FIRST | {"time": 0.01},
        "#run=ex2%5Faw": {"shown": ["ex2_aw"], "time": 7e-3},
    }
    assert dict(zip(expected, followed(*expected), strict=True)) == expected


def test_links_lead_to_what_they_were_made_of():
    """Whatever the names of the runs, and to nine digits of the time."""
    runs = [{"name": name, "shown": False} for name in HOSTILE[:-1]]
    moments = [{"t": math.pi*10.0**-k, "names": [run["name"] for run in runs[k:k + 1 + k % 3]], "view": ("whole", "left")[k % 2]}
               for k in range(len(runs))]
    links = ask("link", SCRIPTS, moments=moments)
    for moment, link, found in zip(moments, links, followed(*links, runs=runs), strict=True):
        assert found["shown"] == moment["names"], link
        assert found.get("view", "whole") == moment["view"]
        assert found["time"] == pytest.approx(moment["t"], rel=5e-9)
