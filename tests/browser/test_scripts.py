"""The page's scripts without a browser: their syntax, the decoder of columns and the reader of links, run by node."""
from __future__ import annotations

import base64
import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ldbench
from ldbench.plots.series import ratio_curve
from ldbench.results.derived import SIDES
from ldbench.viewer.pack import FINE_LEVELS, LEVELS, Packed, pack
from ldbench.viewer.page import SCRIPTS, wheel_columns
from ldbench_round import collation_html
from running import HANG, Run

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


def test_every_script_of_the_pages_is_found():
    assert {*SCRIPTS, *(path.name for path in collation_html.SCRIPTS)} == set(FILES)


def test_syntax():
    assert ask("syntax", (), files={name: str(path) for name, path in FILES.items()}) == {}


def decoded(packed: Packed) -> dict[str, Any]:
    """A run as decode.js has it; columns are arrays."""
    def array(found: Any) -> Any:
        if isinstance(found, str):
            return np.frombuffer(base64.b64decode(found), "<f8")
        return {name: array(value) for name, value in found.items()} if isinstance(found, dict) else found

    # The page gets the index as JSON that has no NaN.
    index = json.loads(json.dumps(packed.index, allow_nan=False))
    return array(ask("decode", ("decode.js",), index=index, body=base64.b64encode(packed.body).decode()))


def as_written(x: np.ndarray) -> np.ndarray:
    """Numbers as a column file has them: with nine digits."""
    return np.array([float(f"{value:.8E}") for value in x])


def has_nine_digits(found: np.ndarray, x: np.ndarray) -> None:
    """Every number is the one that the file has, to the last bit, and NaN where it has none or an infinite one."""
    np.testing.assert_array_equal(found, np.where(np.isfinite(x), as_written(x), np.nan))


def made_columns(t: np.ndarray) -> dict[str, np.ndarray]:
    """Columns for every way to predict a number, and numbers of all sizes."""
    chance = np.random.default_rng(4)
    n = len(t)
    smooth = np.sin(3*t) + t**2
    wide = chance.choice([-1, 1], n)*chance.uniform(1, 10, n)*10.0**chance.integers(-100, 100, n)
    wide[:12] = 1.0, -1.0, 9.99999999e-5, 9.999999999, 9.9999999949, 1e22, 1e-22, 1e23, 123456789.5, 0.1, -0.1, 1/3
    force = np.maximum(np.sin(40*t), 0)*1e5         # zero on long stretches
    holes = smooth.copy()
    holes[::7] = np.nan
    holes[20:40] = np.inf
    holes[40:50] = -np.inf
    columns = {"smooth": smooth, "multiple": -1e3*smooth, "wide": wide, "noise": chance.normal(size=n).cumsum(),
               "force": force, "holes": holes, "line": 2*t - 1, "parabola": (t - 0.3)**2, "constant": np.full(n, -0.25),
               "zero": np.zeros(n), "negative zero": np.full(n, -0.0), "nothing": np.full(n, np.nan)}
    return {name: as_written(x) for name, x in columns.items()}


@pytest.mark.parametrize("even", [True, False], ids=["even times", "uneven times"])
def test_a_short_run_keeps_every_digit(even: bool):
    t = np.arange(1000)*1e-3
    if not even:
        t = as_written(np.sort(np.random.default_rng(5).uniform(0, 1, 1000)))
    columns = made_columns(t)
    packed = pack(t, columns)
    methods = [method.get("order", "a multiple") for method in packed.index["exact"]]
    assert {0, 2, 3, "a multiple"} <= set(methods), methods
    found = decoded(packed)
    has_nine_digits(found["t"], t)
    assert list(found["exact"]) == list(columns)
    for name, x in columns.items():
        has_nine_digits(found["exact"][name], x)
    assert (found["rows"], found["tracks"], found["bands"], found["rowTimes"]) == (1000, {}, {}, None)


def test_loads_of_wheels_are_those_of_the_plots(shipped: dict[str, Run]):
    """L/V, V and L where a wheel carries little or nothing: the page has the numbers of Python, and none in the same rows."""
    run = ldbench.read_run(shipped["ex5_sw"].file)
    loads = wheel_columns(run)
    rows = np.flatnonzero(np.minimum(loads["Fz_L"], loads["Fz_R"]) < 2e3)
    found = ask("derive", ("series.js", "derived.js"), exact={name: run.values(name)[rows].tolist() for name in run.data
                                                              if name[:2] in ("Fy", "Fz")})
    assert len(rows) > 5000 and set(loads) == {f"{kind}_{side}" for kind in ("LV", "Fz", "Fy") for side in "LR"}
    for name, x in loads.items():
        np.testing.assert_array_equal(np.array(found[name], float), x[rows], err_msg=name)
    for side, wheel in zip("LR", SIDES, strict=True):
        np.testing.assert_array_equal(loads[f"LV_{side}"], ratio_curve(wheel).values(run))


def test_two_rows():
    found = decoded(pack(np.array([0.0, 1e-5]), {"a": np.array([np.nan, -1.5])}))
    has_nine_digits(found["t"], np.array([0.0, 1e-5]))
    has_nine_digits(found["exact"]["a"], np.array([np.nan, -1.5]))


@pytest.mark.parametrize("even", [True, False], ids=["even times", "uneven times"])
def test_a_long_run_has_bands_and_tracks(even: bool):
    """The kept rows have all digits; a band holds every value, as closely as its levels allow, and a track is the nearest level."""
    n = 18_000
    t = np.arange(n)*3e-4
    if not even:
        t = as_written(np.cumsum(np.random.default_rng(6).uniform(1.5e-4, 4.5e-4, n)))
    columns = {name: x for name, x in made_columns(t).items() if name != "wide"}
    columns["gap"] = np.where((t > 1) & (t < 2), np.nan, columns["noise"])
    tracks = "smooth", "force", "gap"
    packed = pack(t, columns, every_row=tracks, moments=[2.5], peaks=["force"], cells=6000)
    assert packed.index["even"] == even and packed.index["kept"] < 1000
    assert {band.get("order") for band in packed.index["bands"] if band["name"] in tracks} == {1, 2}
    found = decoded(packed)
    times = found["rowTimes"]
    if even:
        np.testing.assert_allclose(times, t, rtol=0, atol=1e-12)
    else:
        has_nine_digits(times, t)

    rows = np.abs(t[None, :] - found["t"][:, None]).argmin(axis=1)
    assert len(set(rows)) == packed.index["kept"]
    has_nine_digits(found["t"], t[rows])
    for name, x in columns.items():
        has_nine_digits(found["exact"][name], x[rows])

    assert set(found["tracks"]) == set(tracks) and set(found["bands"]) == set(columns) - set(tracks)
    for name in tracks:
        x, track = columns[name], found["tracks"][name]
        assert np.array_equal(np.isnan(track), np.isnan(x))
        assert np.nanmax(np.abs(track - x)) <= 0.5001*np.ptp(x[~np.isnan(x)])/FINE_LEVELS
    edges = np.arange(0, n, found["bin"])
    for name, band in found["bands"].items():
        x = np.where(np.isfinite(columns[name]), columns[name], np.nan)
        least, largest = np.fmin.reduceat(x, edges), np.fmax.reduceat(x, edges)
        step = np.ptp(x[~np.isnan(x)])/LEVELS if not np.isnan(x).all() else 0.0
        for side, extreme, sign in (("low", least, 1), ("high", largest, -1)):
            assert np.array_equal(np.isnan(band[side]), np.isnan(extreme)), (name, side)
            outside = sign*(extreme - band[side])
            known = outside[~np.isnan(outside)]
            assert np.all(known >= -1e-9*step) and np.all(known <= 1.001*step), (name, side)


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
        "#run=other": {"shown": ["other"]},
        "#view=right&with=other&run=ex2_sw&t=-1": {"shown": ["ex2_sw", "other"], "time": -1, "view": "right"},
        "#t=0.01&t=0.02": AT_FIRST | {"time": 0.01},
        "#run=ex2%5Faw": {"shown": ["ex2_aw"]},
    }
    assert dict(zip(expected, followed(*expected), strict=True)) == expected


def test_fragments_that_say_nothing_change_nothing():
    fragments = ("", "#", "##", "#&&", "#=", "#t", "#t=", "#t=&view=&run=&with=", "#t=NaN", "#t=Infinity", "#t=-1e999", "#t=ten",
                 "#view=middle", "#view=Left", "#run=nobody", "#with=nobody", "#T=1", "#%", "#%E0%A4%A", "#" + "&"*100_000,
                 "#run=" + "x"*100_000, "#t=javascript:alert(1)", *(f"#run={text}&with={text}" for text in HOSTILE))
    assert followed(*fragments) == [AT_FIRST]*len(fragments)


def test_a_view_that_is_a_name_of_every_object_is_none():
    assert followed("#view=constructor", "#view=toString", "#view=__proto__") == [AT_FIRST]*3


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


def test_charts_in_an_address_are_read_again():
    """Whatever the names of the columns."""
    states = [{"names": [name, "Y"], "mode": ("values", "difference")[k % 2], "over": "" if k % 2 else name, "log": k % 3 == 0,
               "limits": None if k % 4 else [-1.5e-9, 2.25], "acrossLimits": None} for k, name in enumerate(HOSTILE[:-1])]
    for state, found in zip(states, ask("charts", SCRIPTS, states=states), strict=True):
        assert found["names"] == state["names"]
        assert found.get("mode", "values") == state["mode"] and found.get("over", "") == state["over"]
        assert found.get("log", False) == state["log"] and found.get("limits") == state["limits"]
